"""Figures of the report of a budget: stacked contributions; maps, paths and days."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np

from hexathermal.poses import FloatArray
from hexathermal.predict.budget import AXES
from hexathermal.show.budget_figures import COLOURS, OTHERS, SHOWN
from hexathermal.show.figures import BLACK, BLUE, GREEN, GREY, PURPLE, VERMILION
from hexathermal.show.report_chart import Bars, Cells, Chart, Curve, Panel
from hexathermal.show.report_thinning import MOST_POINTS, kept_of, thinned_words

COORDINATES = {"x_mm": "mm", "y_mm": "mm", "z_mm": "mm", "rx_deg": "°", "ry_deg": "°", "rz_deg": "°"}
PANELS = (("Shift of the point", "um", "µm", slice(0, 3)), ("Turn of the platform", "urad", "µrad", slice(3, 6)))
FOUR = (("drift", "drift without correction", VERMILION, "dashed"), ("worst_case", "worst case", BLUE, "line"),
        ("bias", "bias that remains", GREEN, "dashdot"), ("u", "standard uncertainty", PURPLE, "dotted"))  # fmt: skip
MAPPED = (("bias", "bias that remains"), ("u", "standard uncertainty"), ("worst_case", "worst case"))


class Mapped(Protocol):
    """What is drawn of a map, a path or a day."""

    @property
    def kind(self) -> str:
        """``"map"``, ``"path"`` or ``"day"``."""

    @property
    def columns(self) -> dict[str, FloatArray]:
        """By their names."""

    def size(self, what: str, unit: str) -> FloatArray:
        """Return the length of a shift or turn."""


def contributions_chart(
    sources: Sequence[tuple[str, FloatArray]], uncertainty: FloatArray, remaining: FloatArray
) -> Chart:
    """Return stacked contributions: bars as high as the standard uncertainty, split as the variance is.

    Parameters
    ----------
    sources : sequence of (str, array, shape (6,)) [um, urad]
        Largest first.
    uncertainty, remaining : array, shape (6,) [um, urad]
    """
    with np.errstate(all="ignore"):
        parts = [np.nan_to_num(values**2 / uncertainty) for _label, values in sources]
    panels = []
    for title, _unit, shown, part in PANELS:
        bars = [Bars(label, tuple(AXES[part]), parts[k][part], COLOURS[k]) for k, (label, _values) in
                enumerate(sources[:SHOWN])]  # fmt: skip
        if len(sources) > SHOWN:
            rest = np.sum([one[part] for one in parts[SHOWN:]], axis=0)
            bars.append(Bars(f"{len(sources) - SHOWN} others", tuple(AXES[part]), rest, OTHERS))
        bars.append(Bars("|bias| that remains", tuple(AXES[part]), np.abs(remaining[part]), BLACK, mark=True))
        panels.append(Panel(title, tuple(bars), "axis", "standard uncertainty, bias", "", shown, stacked=True))
    sizes = ", ".join(f"{axis} {value:.2f} {'µm' if k < 3 else 'µrad'}" for k, (axis, value) in
                      enumerate(zip(AXES, uncertainty, strict=True)))  # fmt: skip
    return Chart(
        "contributions", "Contributions to the uncertainty",
        f"Stacked bars of {len(sources)} sources for six axes, the largest {sources[0][0]}; standard uncertainties: "
        f"{sizes}.",
        "A bar is as high as the standard uncertainty, and split as the variance is; diamonds: the bias that remains.",
        tuple(panels),
    )  # fmt: skip


def places_charts(places: Mapped) -> list[Chart]:
    """Return what a map, a path or a day shows: matrices over two coordinates, else curves."""
    moved = [name for name in COORDINATES if len(np.unique(np.round(places.columns[name], 9))) > 1]
    if places.kind == "map" and len(moved) == 2:
        count = [len(np.unique(np.round(places.columns[name], 9))) for name in moved]
        if count[0] * count[1] == len(places.columns[moved[0]]):
            return [_matrices(places, moved, *panel[:3]) for panel in PANELS]
    return [_curves(places, moved)]


def _matrices(places: Mapped, moved: list[str], title: str, unit: str, shown: str) -> Chart:
    """Return bias, uncertainty and worst case over two coordinates; the last changes fastest."""
    across, up = (np.unique(np.round(places.columns[name], 9)) for name in moved)
    panels, words = [], []
    (x, x_unit), (y, y_unit) = ((name.rpartition("_")[0], COORDINATES[name]) for name in moved)
    for what, name in MAPPED:
        values = places.size(what, unit).reshape(len(across), len(up)).T
        low, high = float(np.nanmin(values)), float(np.nanmax(values))
        worst = float(np.nanmax(places.size("worst_case", unit)))
        if high - low < 0.02 * worst:  # else rounding would look like a map
            low, high = max(0.0, low - 0.01 * worst), high + 0.01 * worst
        cells = Cells(name, across, up, values, shown, low, max(high, low + 1e-12))
        panels.append(Panel(name.capitalize(), (cells,), x, y, x_unit, y_unit, height=0.75))
        words.append(f"{name} from {np.nanmin(values):.3f} to {np.nanmax(values):.3f} {shown}")
    return Chart(
        f"map-{'shift' if unit == 'um' else 'turn'}", f"{title} over {x} and {y}",
        f"Three matrices over {len(across)} by {len(up)} poses: {'; '.join(words)}.",
        "Poses out of reach are left empty. Worst case: |bias| + expanded uncertainty.", tuple(panels),
    )  # fmt: skip


def _curves(places: Mapped, moved: list[str]) -> Chart:
    """Return four curves along time, a coordinate, or the number of the place."""
    columns = places.columns
    if "time_s" in columns:
        x, name, unit = columns["time_s"] / 3600.0, "time", "h"
    elif len(moved) == 1:
        x, name, unit = columns[moved[0]], moved[0].rpartition("_")[0], COORDINATES[moved[0]]
    else:
        x, name, unit = np.arange(1.0, len(columns["x_mm"]) + 1.0), "place", ""
    drawn = [np.stack([places.size(what, own) for what, *_look in FOUR], axis=1) for _title, own, *_unit in PANELS]
    rows = kept_of(len(x), MOST_POINTS, *drawn)
    sensors = [column for column in columns if column.endswith("_degC")]
    panels, words = [], []
    heat = [columns[column] for column in sensors]
    if heat and max(float(np.ptp(one)) for one in heat) > 0.0:
        curves = [Curve(sensor.removesuffix("_degC"), x[rows], one[rows], GREY) for sensor, one in
                  zip(sensors, heat, strict=True)]  # fmt: skip
        panels.append(Panel("Thermometers", tuple(curves), name, "temperature", unit, "°C"))
    for title, own, shown, _part in PANELS:
        four = tuple(Curve(label, x[rows], places.size(what, own)[rows], colour, look)
                     for what, label, colour, look in FOUR)  # fmt: skip
        panels.append(Panel(title, four, name, title.split()[0].lower(), unit, shown))
        words.append(f"worst case up to {np.nanmax(places.size('worst_case', own)):.2f} {shown}")
    return Chart(
        places.kind, {"map": "Over the grid", "path": "Along the path", "day": "Over the day"}[places.kind],
        f"Drift, bias, uncertainty and worst case of {len(x)} places against {name}: {'; '.join(words)}.",
        f"Worst case: |bias| + expanded uncertainty.{thinned_words(len(rows), len(x))}", tuple(panels), shared=True,
    )  # fmt: skip
