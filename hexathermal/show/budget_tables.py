"""Tables of error budgets, for the command line to print, and as rows for CSV."""

from __future__ import annotations

from typing import Any

import numpy as np
from rich.table import Table

from hexathermal.poses import FloatArray, coordinates_from_pose
from hexathermal.predict.budget import AXES, Budget
from hexathermal.predict.budget_map import BudgetMap
from hexathermal.predict.montecarlo import Simulation
from hexathermal.show.options import in_millimetres
from hexathermal.show.tables import framed

UNITS = ("um", "um", "um", "urad", "urad", "urad")
HEADS = tuple(f"{axis}\n{unit}>" for axis, unit in zip(AXES, UNITS, strict=True))


def _cells(values: FloatArray) -> list[str]:
    """Return six numbers in um and urad."""
    return [f"{value * 1e6:z.3f}" for value in values]


def bias_table(budget: Budget, probability: float, pretty: bool) -> Table:
    """Return bias and uncertainty of a budget."""
    table = framed(pretty, f"{budget.frame} frame", *HEADS)
    table.add_row("drift, uncorrected", *_cells(budget.uncorrected))
    if budget.corrected:
        table.add_row("removed by correction", *_cells(budget.removed))
        table.add_row("bias that remains", *_cells(budget.remaining))
    for name, part in zip(budget.causes, budget.cause_parts, strict=True):
        table.add_row(f"  of it {name}", *_cells(part))
    table.add_row("standard uncertainty", *_cells(budget.uncertainty))
    table.add_row("effective degrees of freedom", *("inf" if np.isinf(nu) else f"{nu:z.1f}" for nu in budget.dof))
    table.add_row(f"expanded, {100 * probability:g} %", *_cells(budget.expanded(probability)))
    table.add_row("worst case: |bias| + expanded", *_cells(budget.worst_case(probability)))
    return table


SHOWN = {"m": (1e6, "um"), "rad": (1e6, "urad"), "1/K": (1e6, "um/m/K")}
"""Units of sources as people read them."""


def standard_text(standard: float, unit: str) -> str:
    """Return the standard uncertainty of a source with its unit, in that of people.

    Examples
    --------
    >>> standard_text(2.1e-7, "m"), standard_text(0.1, "K"), standard_text(3.4e-8, "1/K"), standard_text(0.03, "1")
    ('0.21 um', '0.1 K', '0.034 um/m/K', '0.03')
    """
    factor, shown = SHOWN.get(unit, (1.0, unit))
    return f"{standard * factor:.3g} {shown}".removesuffix(" 1")


def contributions_table(budget: Budget, pretty: bool, width: int | None = None) -> Table:
    """Return the contributions of a budget, largest first; columns sum up as squares."""
    wide = not pretty or width is None or width >= 130
    more = ("standard\nuncertainty>", "distribution", "legs", "dof>") if wide else ()
    table = framed(pretty, "source", *HEADS, *more)
    for item in budget.contributions:
        cells = [standard_text(item.standard, item.unit), item.distribution, item.correlation]
        cells.append("inf" if np.isinf(item.dof) else f"{item.dof:g}")
        table.add_row(item.label, *_cells(item.uncertainty), *(cells if wide else ()))
    table.add_row("combined (root of the sum of squares)", *_cells(budget.uncertainty), *([""] * len(more)))
    return table


def simulation_table(found: Simulation, pretty: bool) -> Table:
    """Return a Monte Carlo beside the linear budget."""
    table = framed(pretty, f"{found.draws} draws, {100 * found.probability:g} %", *HEADS)
    budget = found.budget
    table.add_row("mean", *_cells(found.mean))
    table.add_row("standard uncertainty", *_cells(found.uncertainty))
    table.add_row("shortest interval, low", *_cells(found.low))
    table.add_row("shortest interval, high", *_cells(found.high))
    expanded = budget.expanded(found.probability)
    table.add_row("linear budget, low", *_cells(budget.remaining - expanded))
    table.add_row("linear budget, high", *_cells(budget.remaining + expanded))
    table.add_row("larger difference", *_cells(found.differences.max(axis=0)))
    table.add_row("tolerance", *_cells(found.tolerance))
    table.add_row("agrees", *("yes" if good else "no" for good in found.agrees))
    return table


def map_table(found: BudgetMap, pretty: bool) -> Table:
    """Return the spread of a map: smallest, middle and largest."""
    table = framed(pretty, "over all places", "smallest>", "median>", "largest>", "unit")
    names = {
        "uncorrected": "drift, uncorrected", "remaining": "bias that remains", "uncertainty": "standard uncertainty",
        "worst_case": "worst case",
    }  # fmt: skip
    for measure, unit in (("shift", "um"), ("turn", "urad")):
        for what, name in names.items():
            values = found.size(what, measure) * 1e6
            values = values[np.isfinite(values)]
            cells = (values.min(), np.median(values), values.max()) if values.size else (np.nan,) * 3
            table.add_row(f"{name}, {measure}", *(f"{value:z.3f}" for value in cells), unit)
    return table


def contribution_rows(budget: Budget) -> tuple[list[str], list[list[Any]]]:
    """Return header and rows of a CSV file of a budget: biases first, then sources, largest first, then the total."""
    header = ["kind", "label", "standard_uncertainty", "unit", "distribution", "correlation", "dof"]
    header += [f"{axis}_{unit}" for axis, unit in zip(AXES, UNITS, strict=True)] + ["basis"]
    rows: list[list[Any]] = []
    for kind, values in (("bias uncorrected", budget.uncorrected), ("bias removed", budget.removed),
                         ("bias remaining", budget.remaining)):  # fmt: skip
        rows.append([kind, "", "", "", "", "", "", *(values * 1e6).tolist(), ""])
    for name, part in zip(budget.causes, budget.cause_parts, strict=True):
        rows.append(["bias cause", name, "", "", "", "", "", *(part * 1e6).tolist(), ""])
    rows += [
        ["source", item.label, item.standard, item.unit, item.distribution, item.correlation, item.dof,
         *(item.uncertainty * 1e6).tolist(), item.basis]
        for item in budget.contributions
    ]  # fmt: skip
    rows.append(["combined", "", "", "", "", "", "", *(budget.uncertainty * 1e6).tolist(), ""])
    return header, rows


def map_rows(
    found: BudgetMap, coordinates: FloatArray, time_s: FloatArray | None, sensors: tuple[str, ...]
) -> tuple[list[str], list[list[Any]]]:
    """Return header and rows of a CSV file of a map or a day; cells of poses out of reach are empty."""
    header = ["time_s"] if time_s is not None else []
    header += ["x_mm", "y_mm", "z_mm", "rx_deg", "ry_deg", "rz_deg", *(f"{name}_degC" for name in sensors)]
    named = (("drift", found.uncorrected), ("bias", found.remaining), ("u", found.uncertainty),
             ("worst_case", found.worst_case))  # fmt: skip
    header += [f"{name}_{axis}_{unit}" for name, _ in named for axis, unit in zip(AXES, UNITS, strict=True)]
    header.append("refused")
    reasons = {k: in_millimetres(why) for k, why in found.refused}
    rows = []
    for k in range(len(found.poses)):
        cells: list[Any] = [] if time_s is None else [float(time_s[k])]
        cells += [*coordinates[k].tolist(), *found.temps[k].tolist()]
        for _name, values in named:
            cells += [""] * 6 if k in reasons else (values[k] * 1e6).tolist()
        rows.append([*cells, reasons.get(k, "")])
    return header, rows


def place_text(found: BudgetMap, index: int, coordinates: FloatArray, time_s: FloatArray | None) -> str:
    """Return where a place of a map is, for people."""
    six = ", ".join(f"{value:g}" for value in np.round(coordinates[index], 6))
    place = f"pose ({six}) mm, deg"
    return place if time_s is None else f"{time_s[index] / 3600.0:z.2f} h, {place}"


def coordinates_of(found: BudgetMap, convention: str, hexapod: Any) -> FloatArray:
    """Return the coordinates (N, 6) [mm, deg] of a map's poses from home."""
    return coordinates_from_pose(found.poses, convention, hexapod)
