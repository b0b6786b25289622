"""Figures of an identification and a validation, in the manner of the paper's figures 6, 7 and 8."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from hexathermal.learn.selection import RankedSets
from hexathermal.learn.validation import RunCurves, Validation
from hexathermal.show.figures import BLACK, BLUE, GREEN, GREY, save_figure
from hexathermal.show.figures import STYLE as STYLE
from hexathermal.show.identification_tables import matrix_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

ORANGE, RED, VIOLET = "#E69F00", "#C0392B", "#7B4BA8"
CRITERIA = {"rmse": "RMSE", "linf": "largest residual"}


def save_both(figure: Figure, folder: Path, name: str) -> list[Path]:
    """Write a figure as PNG and SVG; returns the paths."""
    return [save_figure(figure, folder / f"{name}{ending}") for ending in (".png", ".svg")]


def matrices_figure(ranked: RankedSets) -> Figure:
    """Return the two matrices of the criteria (paper, fig. 6): the brightest set is the best, each matrix on its own.

    Single sensors stand on the diagonal from the bottom left to the top right.
    """
    import matplotlib as mpl
    from matplotlib.figure import Figure

    with mpl.rc_context({**STYLE, "axes.grid": False}):
        figure = Figure(figsize=(10.2, 4.9), layout="constrained")
        for axes, (by, what) in zip(figure.subplots(1, 2), CRITERIA.items(), strict=True):
            sensors, matrix = matrix_of(ranked, by)
            values = np.ma.masked_invalid(matrix * 1e6)
            # the worst sets would hide the differences between good ones
            high = float(np.quantile(values.compressed(), 0.9)) if values.count() else 1.0
            shown = axes.imshow(values, origin="lower", cmap="cividis_r", vmin=float(values.min()), vmax=high)
            ticks = range(len(sensors))
            axes.set_xticks(ticks, sensors, rotation=90, fontsize=7.5)
            axes.set_yticks(ticks, sensors, fontsize=7.5)
            axes.set_title(f"{what[0].upper()}{what[1:]} of the rows fitted")
            axes.set_xlabel("pairs of sensors; single sensors on the diagonal")
            best = np.unravel_index(int(np.ma.argmin(values)), values.shape)
            for i, j in {(best[0], best[1]), (best[1], best[0])}:
                axes.plot(j, i, "o", mfc="none", mec=RED, ms=9.0, mew=1.4)
            bar = figure.colorbar(shown, ax=axes, extend="max", shrink=0.88)
            bar.set_label(f"{what} (µm); brightest is best, best circled")
            bar.ax.invert_yaxis()
    return figure


def front_figure(ranked: RankedSets, chosen: int = -1) -> Figure:
    """Return the scatter of all sets (paper, fig. 7): largest residual and RMSE, the front in black, and a zoom."""
    import matplotlib as mpl
    from matplotlib.figure import Figure

    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(10.2, 4.7), layout="constrained")
        whole, zoom = figure.subplots(1, 2)
        front = list(ranked.front())
        x, y = ranked.fit.linf * 1e6, ranked.fit.rmse * 1e6
        for axes in (whole, zoom):
            for size, colour, label in ((2, BLUE, "pairs"), (1, ORANGE, "single sensors")):
                here = ranked.sizes == size
                axes.plot(x[here], y[here], "o", color=colour, ms=4.0, alpha=0.75, mec="none", label=label)
            axes.plot(x[front], y[front], "-", color=BLACK, lw=1.2, marker="o", ms=4.0, label="Pareto front")
            if chosen >= 0 and ranked.sizes[chosen] <= 2:
                axes.plot(x[chosen], y[chosen], "s", mfc="none", mec=RED, ms=9.0, mew=1.4,
                          label=f"chosen: {' + '.join(ranked.names[chosen])}")  # fmt: skip
            axes.set_xlabel("largest residual (µm)")
        whole.set_ylabel("RMSE (µm)")
        whole.set_title("Every pair and every single sensor, fitted rows")
        whole.legend(loc="lower right")
        best = ranked.best(1, left_out=False)
        _zoom(zoom, [*front, best, *([chosen] if chosen >= 0 and ranked.sizes[chosen] <= 2 else [])], x, y)
        zoom.set_title("Zoom on the front")
        _named(zoom, ranked, front, x, y)
        if best not in front:
            zoom.annotate(
                ranked.names[best][0], (x[best], y[best]), (6, -10), textcoords="offset points", color="#8A6100"
            )
    return figure


def _zoom(axes: Axes, kept: Sequence[int], x: Any, y: Any) -> None:
    """Set limits about some points, with room on the left for names."""
    for values, limit, before in ((x[list(kept)], axes.set_xlim, 1.5), (y[list(kept)], axes.set_ylim, 1.0)):
        room = 0.25 * max(float(np.ptp(values)), 0.02 * float(values.max()), 1e-6)
        limit(float(values.min()) - before * room, float(values.max()) + 2.0 * room)


def _named(axes: Axes, ranked: RankedSets, front: Sequence[int], x: Any, y: Any) -> None:
    """Write the names of the front's sets into the left margin, where no set can be, under each other."""
    low, high = axes.get_ylim()
    height = 1.0
    for point in front:
        height = min(float((y[point] - low) / (high - low)), height - 0.045)
        axes.annotate(
            "–".join(ranked.names[point]), (x[point], y[point]), (0.01, height), textcoords="axes fraction",
            fontsize=8.0, va="center", arrowprops={"arrowstyle": "-", "color": GREY, "lw": 0.6},
        )  # fmt: skip


def _broken(curves: RunCurves) -> RunCurves:
    """Return curves with a gap where rows are missing, so that no line runs across."""
    step = np.diff(curves.time)
    gaps = np.flatnonzero(step > 10.0 * np.median(step)) + 1 if len(step) else np.array([], dtype=np.int64)

    def cut(values: Any) -> Any:
        return np.insert(values, gaps, np.nan, axis=0)

    q = None if curves.q is None else cut(curves.q)
    return RunCurves(curves.run, cut(curves.time), q, *(cut(getattr(curves, name)) for name in (
        "dT", "measured", "predicted", "half_width")))  # fmt: skip


def _heading(found: Validation, run: str) -> str:
    """Return a run's name and whether it was fitted."""
    if run in found.fitted:
        return f"{run}: fitted (as {found.fitted[run]}), proves nothing"
    return f"{run}: never fitted" if found.fits_known else f"{run}: run for validation"


def validation_figure(found: Validation, curves: RunCurves, sensors: Sequence[str]) -> Figure:
    """Return one run of a validation (paper, fig. 8).

    Top: the rod's extension in black, the law's sensors in violet. Bottom: measured drift as red dots, the predicted
    drift as a blue line with its 95 % interval, the residual in green.
    """
    import matplotlib as mpl
    from matplotlib.figure import Figure

    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(7.6, 6.0), layout="constrained")
        top, bottom = figure.subplots(2, 1, sharex=True, height_ratios=[1.0, 1.35])
        curves = _broken(curves)
        hours = curves.time / 3600.0
        heat = top
        if curves.q is not None:
            top.step(hours, curves.q * 1e3, where="post", color=BLACK, lw=1.0)
            top.set_ylabel("rod extension (mm)")
            heat = top.twinx()
            heat.grid(False)
            heat.spines["right"].set_visible(True)
        for k, name in enumerate(sensors):
            heat.plot(
                hours, curves.dT[:, k], color=VIOLET, ls=("-", "--", ":", "-.")[k % 4], lw=1.2, label=f"ΔT {name}"
            )
        heat.set_ylabel("ΔT (K)", color=VIOLET)
        # between title and axes: inside it would cover the rod's line
        heat.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=4, borderaxespad=0.2, borderpad=0.2)
        one = found.runs[curves.run]
        top.set_title(_heading(found, curves.run), pad=22.0)
        low, high = (curves.predicted - curves.half_width) * 1e6, (curves.predicted + curves.half_width) * 1e6
        bottom.fill_between(hours, low, high, color=BLUE, alpha=0.15, lw=0.0, label="95 % prediction interval")
        bottom.plot(hours, curves.measured * 1e6, ".", color=RED, ms=2.5, label="measured")
        bottom.plot(hours, curves.predicted * 1e6, color=BLUE, lw=1.3, label="predicted")
        residual = (curves.measured - curves.predicted) * 1e6
        bottom.plot(hours, residual, color=GREEN, lw=1.0, label="residual")
        bottom.axhline(0.0, color=GREY, lw=0.6)
        bottom.set_xlabel("time (h)")
        bottom.set_ylabel("drift (µm)")
        bottom.set_title(
            f"RMSE {one.rmse.value * 1e6:.2f} µm, largest residual {one.linf.value * 1e6:.2f} µm; mean reduction "
            f"{100.0 * one.mean_reduction.value:.0f} %, {100.0 * found.run_coverage[curves.run]:.0f} % inside"
        )
        bottom.legend(loc="upper center", bbox_to_anchor=(0.5, -0.16), ncols=4)
    return figure
