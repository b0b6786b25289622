"""The report of an error budget, from what ``hexathermal budget`` wrote: its JSON, or the tables of its folder."""

from __future__ import annotations

import csv
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from hexathermal.errors import FileFormatError, Problem
from hexathermal.poses import FloatArray
from hexathermal.predict.budget import AXES
from hexathermal.show.budget_tables import UNITS, standard_text
from hexathermal.show.diagnosis_page import paragraph, table
from hexathermal.show.report import read_json
from hexathermal.show.report_budget_charts import contributions_chart, places_charts
from hexathermal.show.report_chart import Chart
from hexathermal.show.report_page import Report, Section

HEADS = tuple(f"{axis} {unit}>" for axis, unit in zip(AXES, UNITS, strict=True))
COLUMNS = tuple(f"{axis}_{unit}" for axis, unit in zip(AXES, UNITS, strict=True))
PLACES = {"map": "Map over poses", "path": "Along the path", "day": "Over the day"}


@dataclass(frozen=True, eq=False)
class Source:
    """One contribution to a budget: what it is, and its standard uncertainty of each axis [um, urad]."""

    label: str
    standard: float
    unit: str
    distribution: str
    uncertainty: FloatArray
    basis: str


@dataclass(frozen=True, eq=False)
class Places:
    """A map, a path or a day: its columns, NaN where a pose is out of reach, and the worst places in words."""

    kind: str
    columns: dict[str, FloatArray]
    refused: tuple[str, ...]
    worst: tuple[str, ...] = ()

    def size(self, what: str, unit: str) -> FloatArray:
        """Return the length of a shift or turn: ``drift``, ``bias``, ``u`` or ``worst_case`` in um or urad."""
        names = [column for column in COLUMNS if column.endswith(f"_{unit}")]
        return np.asarray(np.linalg.norm([self.columns[f"{what}_{name}"] for name in names], axis=0))


@dataclass(frozen=True, eq=False)
class WrittenBudget:
    """A budget as it was written; six numbers are x, y, z [um], rx, ry, rz [urad].

    Attributes
    ----------
    title : str
    biases : dict of str to array
        Uncorrected, removed, remaining, and the causes of the last.
    uncertainty : array, shape (6,)
    expanded, worst_case : array, shape (6,), or None
        Where they were written.
    probability : float
    sources : tuple of Source
        Largest first.
    places : tuple of Places
    simulation : dict
        Of the Monte Carlo, empty where there is none.
    notes : tuple of str
    """

    title: str
    biases: dict[str, FloatArray]
    uncertainty: FloatArray
    expanded: FloatArray | None
    worst_case: FloatArray | None
    probability: float
    sources: tuple[Source, ...]
    places: tuple[Places, ...] = ()
    simulation: dict[str, Any] | None = None
    notes: tuple[str, ...] = ()


def read_budget(place: Path) -> WrittenBudget:
    """Return a budget that was written, from its JSON file or its folder.

    Raises
    ------
    FileFormatError
        It lacks what a budget has.
    """
    try:
        return _of_json(read_json(place)) if place.is_file() else _of_folder(place)
    except (KeyError, IndexError, TypeError, ValueError, csv.Error) as error:
        what = f"{error} is missing" if isinstance(error, KeyError) else str(error)
        words = f"no budget that can be read: {what}; write it anew with 'budget'"
        raise FileFormatError(str(place), (Problem(1, 1, words),)) from None


def _of_json(answer: dict[str, Any]) -> WrittenBudget:
    """Return a budget from JSON."""
    one = answer.get("budget", answer)
    biases = {"drift, uncorrected": one["bias_uncorrected"]}
    if one["corrected"]:
        biases |= {"removed by correction": one["bias_removed"], "bias that remains": one["bias_remaining"]}
    biases |= {f"of it {name}": part for name, part in one["bias_remaining_causes"].items()}
    sources = tuple(
        Source(item["label"], float(item["standard_uncertainty"]), item["unit"], item["distribution"],
               _six(item["uncertainty"]), item["basis"])
        for item in one["contributions"]
    )  # fmt: skip
    point = ", ".join(f"{value:g}" for value in one["point_from_platform_origin_mm"])
    heat = dict.fromkeys(f"{end:.4g}" for end in (min(one["temperatures_degC"]), max(one["temperatures_degC"])))
    title = (
        f"machine {one['machine'] or 'without a name'}, {one['frame']} frame, point ({point}) mm, "
        f"{' to '.join(heat)} degC, {'corrected' if one['corrected'] else 'nominal'} lengths"
    )
    places = tuple(_places(kind, answer[kind]["columns"], answer[kind]["rows"], answer[kind].get("worst", {}))
                   for kind in PLACES if kind in answer)  # fmt: skip
    notes = (str(one["region_note"]),) if one.get("region_note") else ()
    return WrittenBudget(
        title, {name: _six(values) for name, values in biases.items()}, _six(one["standard_uncertainty"]),
        _six(one["expanded_uncertainty"]), _six(one["worst_case"]), float(one["probability"]), sources, places,
        answer.get("monte_carlo"), notes,
    )  # fmt: skip


def _of_folder(folder: Path) -> WrittenBudget:
    """Return a budget from the tables of a folder."""
    header, rows = _table(folder / "budget.csv")
    lines = [dict(zip(header, row, strict=True)) for row in rows]
    six = {id(line): _six([line[name] for name in COLUMNS]) for line in lines}
    names = {"bias uncorrected": "drift, uncorrected", "bias removed": "removed by correction",
             "bias remaining": "bias that remains"}  # fmt: skip
    biases = {names[line["kind"]]: six[id(line)] for line in lines if line["kind"] in names}
    biases |= {f"of it {line['label']}": six[id(line)] for line in lines if line["kind"] == "bias cause"}
    sources = tuple(Source(line["label"], float(line["standard_uncertainty"]), line["unit"], line["distribution"],
                           six[id(line)], line["basis"]) for line in lines if line["kind"] == "source")  # fmt: skip
    total = next(six[id(line)] for line in lines if line["kind"] == "combined")
    places = [_places(kind, *_table(folder / f"{kind}.csv"), {}) for kind in PLACES
              if (folder / f"{kind}.csv").is_file()]  # fmt: skip
    note = (
        "the tables of a folder do not tell machine, pose, expanded uncertainty and worst case; a report of the file "
        "of 'budget --json' has them"
    )
    return WrittenBudget(f"folder {folder.resolve().name}", biases, total, None, None, 0.95, sources, tuple(places),
                         None, (note,))  # fmt: skip


def _table(file: Path) -> tuple[list[str], list[list[str]]]:
    """Return header and rows of a CSV file."""
    with file.open(newline="", encoding="utf-8-sig") as stream:
        header, *rows = list(csv.reader(stream))
    return header, rows


def _places(kind: str, columns: Sequence[str], rows: Sequence[Sequence[Any]], worst: dict[str, Any]) -> Places:
    """Return a map, a path or a day."""
    values = {name: np.array([_number(row[k]) for row in rows]) for k, name in enumerate(columns) if name != "refused"}
    at = list(columns).index("refused")
    refused = tuple(dict.fromkeys(str(row[at]) for row in rows if row[at]))
    words = tuple(
        f"Worst {name}: {one.get('worst_case_um', one.get('worst_case_urad')):z.3f} "
        f"{'um' if name == 'shift' else 'urad'} at {one['place']}: {one['reason']}."
        for name, one in worst.items()
    )
    found = Places(kind, values, refused, words)
    for what in ("drift", "bias", "u", "worst_case"):
        found.size(what, "um"), found.size(what, "urad")
    return found


def _number(cell: Any) -> float:
    """Return a cell as a number; NaN where it is empty."""
    return float("nan") if cell == "" else float(cell)


def _six(values: Sequence[Any]) -> FloatArray:
    """Return six numbers."""
    found = np.array([float(value) for value in values])
    if found.shape != (6,):
        raise ValueError(f"{len(found)} numbers where six are wanted")
    return found


def budget_report(found: WrittenBudget, place: Path) -> Report:
    """Return the report of a budget.

    Parameters
    ----------
    found : WrittenBudget
    place : Path
        Where it was read.
    """
    spread = found.uncertainty
    shift, turn = (float(np.linalg.norm(part)) for part in np.split(spread, 2))
    top = found.sources[0].label if found.sources else "none"
    drift, left = (np.linalg.norm(found.biases.get(name, np.zeros(6))[:3])
                   for name in ("drift, uncorrected", "bias that remains"))  # fmt: skip
    kept = "bias that remains" in found.biases
    finding = (
        f"The warm machine is off by {drift:z.2f} um in shift"
        + (f"; correction leaves {left:z.2f} um of it" if kept else "")
        + f", known to {shift:z.2f} um (standard uncertainty), mostly by {top}."
    )
    pairs = [
        ("Drift, uncorrected", f"{drift:z.2f} µm", "length of the shift"),
        *([("Bias that remains", f"{left:z.2f} µm", "length of the shift")] if kept else []),
        ("Standard uncertainty", f"{shift:z.2f} µm", f"{turn:z.2f} µrad in turn; roots of the sums of squares"),
        ("Largest contribution", top, f"{len(found.sources)} sources"),
    ]
    sections = [_balance(found), _contributions(found), *(_along(one) for one in found.places)]
    if found.simulation:
        sections.append(_simulation(found.simulation))
    facts = {
        "title": found.title, "drift_um": float(drift), "bias_remaining_um": float(left) if kept else None,
        "standard_uncertainty": dict(zip(COLUMNS, spread.tolist(), strict=True)), "shift_uncertainty_um": shift,
        "turn_uncertainty_urad": turn, "largest_contribution": top,
    }  # fmt: skip
    return Report("budget", f"Error budget: {place.stem}", f"Error budget: {found.title}", finding.replace("um", "µm"),
                  tuple(pairs), tuple(sections), found.notes, facts)  # fmt: skip


def _cells(values: FloatArray) -> list[str]:
    """Return six numbers; a negative zero loses its sign."""
    return [f"{value:z.3f}".replace("-0.000", "0.000") for value in values]


def _balance(found: WrittenBudget) -> Section:
    """Return bias and uncertainty."""
    rows = [(name, *_cells(values)) for name, values in found.biases.items()]
    rows.append(("standard uncertainty", *_cells(found.uncertainty)))
    percent = f"{100.0 * found.probability:g} %"
    if found.expanded is not None and found.worst_case is not None:
        rows += [(f"expanded, {percent}", *_cells(found.expanded)),
                 ("worst case: |bias| + expanded", *_cells(found.worst_case))]  # fmt: skip
    words = "Errors are reached minus wanted: shift of the point, and rotation vector of the platform, axis by axis."
    return Section("balance", "Balance", "What is off, what is removed, what is not known",
                   (paragraph(words), table("Bias and uncertainty", ("quantity", *HEADS), rows)))  # fmt: skip


def _contributions(found: WrittenBudget) -> Section:
    """Return the contributions."""
    rows = [(one.label, *_cells(one.uncertainty), standard_text(one.standard, one.unit), one.distribution)
            for one in found.sources]  # fmt: skip
    rows.append(("combined (root of the sum of squares)", *_cells(found.uncertainty), "", ""))
    basis = [(one.label, one.basis or "not stated") for one in found.sources]
    remaining = found.biases.get("bias that remains", found.biases["drift, uncorrected"])
    parts: list[str | Chart] = []
    if found.sources:
        pairs = tuple((one.label, one.uncertainty) for one in found.sources)
        parts.append(contributions_chart(pairs, found.uncertainty, remaining))
    parts.append(
        table("Contributions, largest first", ("source", *HEADS, "standard uncertainty>", "distribution"), rows)
    )
    parts.append(table("On what each source rests", ("source", "basis"), basis))
    return Section("contributions", "Contributions", "Which source weighs how much", tuple(parts))


def _along(places: Places) -> Section:
    """Return a map, a path or a day."""
    parts: list[str | Chart] = [paragraph(words) for words in places.worst]
    reached = int(np.isfinite(places.size("bias", "um")).sum())
    parts.append(paragraph(f"{reached} of {len(places.columns['x_mm'])} places can be reached."))
    parts += [paragraph(f"Out of reach: {why}", "note") for why in places.refused[:3]]
    names = {"drift": "drift, uncorrected", "bias": "bias that remains", "u": "standard uncertainty",
             "worst_case": "worst case"}  # fmt: skip
    rows = []
    for unit, what in (("um", "shift"), ("urad", "turn")):
        for key, name in names.items():
            known = places.size(key, unit)
            known = known[np.isfinite(known)]
            cells = (known.min(), np.median(known), known.max()) if known.size else (np.nan,) * 3
            rows.append((f"{name}, {what}", *(f"{value:z.3f}" for value in cells), unit))
    parts.append(table("Over all places", ("quantity", "smallest>", "median>", "largest>", "unit"), rows))
    if reached:
        parts += places_charts(places)
    return Section(places.kind, places.kind.capitalize(), PLACES[places.kind], tuple(parts))


def _simulation(told: dict[str, Any]) -> Section:
    """Return the Monte Carlo."""
    names = {"mean": "mean", "standard_uncertainty": "standard uncertainty", "low": "shortest interval, low",
             "high": "shortest interval, high", "tolerance": "tolerance"}  # fmt: skip
    rows = [(words, *_cells(_six(told[key]))) for key, words in names.items() if key in told]
    words = f"{told.get('draws', 0)} machines were drawn. Verdict: {told.get('verdict', 'not told')}."
    return Section("simulation", "Monte Carlo", "The same by simulation",
                   (paragraph(words), table("Monte Carlo", ("quantity", *HEADS), rows)))  # fmt: skip
