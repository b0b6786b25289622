"""Tables of machines, days and trajectories, for the command line to print."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
from rich.box import SIMPLE_HEAD, Box
from rich.cells import cell_len
from rich.table import Table

from hexathermal.kinematics.constants import LARGEST_CONDITION
from hexathermal.kinematics.jacobian import condition_number
from hexathermal.machine.hexapod import Hexapod
from hexathermal.machine.library import models_folder
from hexathermal.machine.thermal import LegLaw, PlateLaw, ThermalModel
from hexathermal.poses import FloatArray
from hexathermal.predict.trajectory import POSE_COLUMNS, TrajectorySummary
from hexathermal.show.extension_tables import exchange_rows, extension_facts, extension_rows, term_cells, term_facts
from hexathermal.simulate.day import HOUR_S, reference_degC
from hexathermal.simulate.demonstration import Demonstration, largest

AXES = {"x": "mm", "y": "mm", "z": "mm", "rx": "deg", "ry": "deg", "rz": "deg"}


def framed(pretty: bool, *columns: str) -> Table:
    """Return an empty table: ruled for a terminal, plain for a file or a pipe.

    A name that ends in ``>`` is a column of numbers; a line end in a name is one on a terminal only.
    """
    box: Box | None = SIMPLE_HEAD if pretty else None
    table = Table(box=box, padding=(0, 1, 0, 0) if pretty else (0, 2, 0, 0), pad_edge=False, highlight=False)
    for column in columns:
        name = column.removesuffix(">")
        name = name if pretty else name.replace("\n", " ")
        table.add_column(name, justify="right" if column.endswith(">") else "left", overflow="fold")
    return table


NARROWEST, LONGEST_WORD = 12, 24
"""Columns of text are folded down to so many letters, between words up to the longest; columns of numbers never are."""


def width_of(table: Table, width: int) -> int:
    """Return how wide a table is drawn where there is room for `width` letters: numbers are never broken in two."""
    needed = 2 + len(table.columns) * 2
    for column in table.columns:
        lines = [line for cell in (column.header, *column.cells) for line in str(cell).splitlines()]
        longest = max(map(cell_len, lines), default=0)
        if column.justify == "right":
            column.min_width, column.no_wrap = longest, True
            needed += longest
        else:
            words = (cell_len(word) for line in lines for word in line.split())
            column.min_width = min(max(words, default=0), LONGEST_WORD)
            needed += max(min(longest, NARROWEST), column.min_width)
    return max(width, needed)


def _listed(array: FloatArray, digits: int = 3) -> str:
    """Return numbers as text: one where all are the same."""
    values = np.atleast_1d(array)
    texts = [f"{value:z.{digits}f}".rstrip("0").rstrip(".") for value in values.ravel()]
    return texts[0] if len(set(texts)) == 1 else ", ".join(texts)


def _span(array: FloatArray) -> str:
    """Return the extremes of numbers, or the one number that all are."""
    low, high = float(np.min(array)), float(np.max(array))
    return f"{low:z.3f}" if f"{low:z.3f}" == f"{high:z.3f}" else f"{low:z.3f} to {high:z.3f}"


def _thermal(hexapod: Hexapod) -> str:
    """Return whether a machine can be corrected, and by which thermometers."""
    if hexapod.thermal is None:
        return "not active"
    return f"active, {len(hexapod.sensor_names)} sensors"


def _mm(array: FloatArray | None) -> list[Any] | None:
    """Return metres as rounded millimetres."""
    return None if array is None else np.round(array * 1e3, 9).tolist()


def _deg(array: FloatArray | None) -> list[Any] | None:
    """Return radians as rounded degrees."""
    return None if array is None else np.round(np.degrees(array), 9).tolist()


def machines_table(machines: dict[str, Hexapod], pretty: bool) -> Table:
    """Return the table of machines by name."""
    table = framed(pretty, "machine", "grade", "stroke\nmm", "legs at home\nmm", "thermal")
    for name, hexapod in machines.items():
        stroke = "not limited" if hexapod.stroke is None else _span(np.diff(hexapod.stroke) * 1e3)
        lengths = hexapod.inverse_kinematics(hexapod.home) * 1e3
        table.add_row(name, hexapod.grade, stroke, _span(lengths), _thermal(hexapod))
    return table


def machine_file(name_or_path: str) -> Path:
    """Return the file of a machine that was loaded by name or path."""
    bundled = models_folder() / name_or_path / "hexapod.toml"
    if bundled.is_file() and Path(name_or_path).name == name_or_path:
        return bundled
    path = Path(name_or_path)
    return path / "hexapod.toml" if path.is_dir() else path


def machine_facts(hexapod: Hexapod, file: Path | None = None) -> dict[str, Any]:
    """Return all that is known of a machine, with its file where it has one, ready for JSON: mm, deg, um/m/K, degC."""
    condition = float(condition_number(hexapod, hexapod.home))
    limits = hexapod.limits
    return {
        "name": hexapod.name,
        "grade": hexapod.grade,
        "source": hexapod.source,
        "file": None if file is None else str(file.resolve()),
        "base_joints_mm": _mm(hexapod.base_joints),
        "platform_joints_mm": _mm(hexapod.platform_joints),
        "home_mm": _mm(hexapod.home[:3, 3]),
        "leg_lengths_at_home_mm": _mm(hexapod.inverse_kinematics(hexapod.home)),
        "q0_mm": _mm(hexapod.retracted_length),
        "stroke_mm": _mm(hexapod.stroke),
        "base_cone_deg": _deg(hexapod.base_cone),
        "platform_cone_deg": _deg(hexapod.platform_cone),
        "condition_number_at_home": condition if np.isfinite(condition) else None,
        "limits": None if limits is None else {"convention": limits.convention} | {
            f"{axis}_{unit}": (_mm if unit == "mm" else _deg)(np.array(getattr(limits, axis)))
            for axis, unit in AXES.items()
        },
        "thermal": None if hexapod.thermal is None else thermal_facts(hexapod.thermal),
    } | extension_facts(hexapod)  # fmt: skip


def thermal_facts(model: ThermalModel) -> dict[str, Any]:
    """Return laws, references and range of a thermal model, ready for JSON: um/m/K and degC."""

    def plate(law: PlateLaw | None) -> dict[str, Any] | None:
        if law is None:
            return None
        std = None if law.expansion_std is None else round(law.expansion_std * 1e6, 9)
        return {"expansion_um_per_m_K": round(law.expansion * 1e6, 9), "expansion_std_um_per_m_K": std,
                "sensor": law.sensor}  # fmt: skip

    return {
        "sensors": list(model.sensor_names),
        "reference_temperature_degC": np.asarray(model.reference_temperature_degC).tolist(),
        "valid_degC": list(model.valid_degC),
        "thermometers_of_leg": list(model.thermometers_of_leg),
        "legs": [leg_facts(law) for law in model.legs],
        "platform": plate(model.platform),
        "base": plate(model.base),
    }


def leg_facts(law: LegLaw) -> dict[str, Any]:
    """Return the coefficients of a leg with their standard uncertainties, ready for JSON: um/m/K."""
    std = None if law.covariance is None else np.round(np.sqrt(np.diagonal(law.covariance)) * 1e6, 9)
    count = len(law.sensors)
    return {
        "sensors": list(law.sensors),
        "A_um_per_m_K": np.round(law.A * 1e6, 9).tolist(),
        "B_um_per_m_K": np.round(law.B * 1e6, 9).tolist(),
        "A_std_um_per_m_K": None if std is None else std[:count].tolist(),
        "B_std_um_per_m_K": None if std is None else std[count:].tolist(),
        "covariance_known": law.covariance is not None,
        "campaign": law.campaign,
        "terms": term_facts(law.terms),
    }


def machine_tables(facts: dict[str, Any], pretty: bool) -> list[Table]:
    """Return the tables that show the facts of a machine."""
    return [_overview(facts, pretty), _joints(facts, pretty), *thermal_tables(facts["thermal"], pretty)]


def _overview(facts: dict[str, Any], pretty: bool) -> Table:
    """Return what concerns the whole machine."""
    table = framed(pretty, f"machine {facts['name']}", "")
    rows = [(key, facts[key]) for key in ("grade", "source", "file") if facts[key]]
    rows.append(("platform origin at home, base frame", ", ".join(f"{value:g}" for value in facts["home_mm"]) + " mm"))
    rows.append(("legs at home", _span(np.array(facts["leg_lengths_at_home_mm"])) + " mm"))
    for key, what in (("q0_mm", "retracted length q0"), ("base_cone_deg", "cone of the base joints"),
                      ("platform_cone_deg", "cone of the platform joints")):  # fmt: skip
        text = "not known" if facts[key] is None else f"{_listed(np.array(facts[key]), 6)} {key.rpartition('_')[2]}"
        rows.append((what, text))
    stroke = facts["stroke_mm"]
    if stroke is None:
        rows.append(("stroke", "not limited"))
    else:
        low, high = (_listed(np.array(stroke)[:, k], 6) for k in (0, 1))
        rows.append(("stroke q", f"from {low} to {high} mm"))
    condition = facts["condition_number_at_home"]
    singular = condition is None or condition > LARGEST_CONDITION
    text = "infinite" if condition is None else f"{condition:.3g}" if singular else f"{condition:z.3f}"
    rows.append(("condition number at home", f"{text} ({'singular' if singular else '1 is best'})"))
    if facts["limits"] is None:
        rows.append(("travel limits of the maker", "not known"))
    for axis, unit in AXES.items() if facts["limits"] else ():
        low, high = facts["limits"][f"{axis}_{unit}"]
        rows.append((f"travel limit {axis}", f"{low:g} to {high:g} {unit} ({facts['limits']['convention']})"))
    for row in (*rows, *extension_rows(facts)):
        table.add_row(*row)
    return table


def _joints(facts: dict[str, Any], pretty: bool) -> Table:
    """Return the joints of the legs."""
    table = framed(
        pretty,
        "leg",
        *(f"{part}\n{axis} mm>" for part in ("base", "platform") for axis in "xyz"),
        "length\nat home mm>",
    )
    rows = zip(facts["base_joints_mm"], facts["platform_joints_mm"], facts["leg_lengths_at_home_mm"], strict=True)
    for k, (base, platform, length) in enumerate(rows):
        table.add_row(str(k + 1), *(f"{value:z.3f}" for value in (*base, *platform, length)))
    return table


def thermal_tables(thermal: dict[str, Any] | None, pretty: bool) -> list[Table]:
    """Return the tables of a thermal model's facts; what its absence means where there is none."""
    about = framed(pretty, "thermal", "")
    if thermal is None:
        about.add_row("compensation", "not active: the machine has no thermal law")
        return [about]
    about.add_row("compensation", "active: drift of a leg = sum over its sensors of A q0 dT + B q dT")
    low, high = thermal["valid_degC"]
    about.add_row("reference temperature", _listed(np.array(thermal["reference_temperature_degC"]), 6) + " degC")
    about.add_row("valid", f"from {low:g} to {high:g} degC; outside, temperatures are refused")
    for part in ("platform", "base"):
        plate = thermal[part]
        text = "no law" if plate is None else f"expansion {plate['expansion_um_per_m_K']:g} um/m/K"
        if plate is not None and plate["expansion_std_um_per_m_K"] is not None:
            text += f", standard uncertainty {plate['expansion_std_um_per_m_K']:g}"
        if plate is not None:
            text += f", sensor {plate['sensor']}" if plate["sensor"] else ", no sensor: not compensated"
        about.add_row(f"{part} plate", text)
    for row in exchange_rows(thermal["thermometers_of_leg"]):
        about.add_row(*row)
    about.add_row("columns of a temperature file", ", ".join(f"{name}_degC" for name in thermal["sensors"]))
    return [about, *law_tables(thermal["legs"], pretty)]


def law_tables(legs: list[dict[str, Any]], pretty: bool) -> list[Table]:
    """Return the coefficients of the legs with their standard uncertainties, and their terms where they have any."""
    unsure = any(law["covariance_known"] for law in legs)
    heads = [f"{letter} um/m/K>" for letter in "AB"]
    heads = [head for letter, one in zip("AB", heads, strict=True) for head in (one, f"std of {letter}>")[: 1 + unsure]]
    laws = framed(pretty, "leg", "sensor", *heads, "coefficients from")
    shared = all(law == legs[0] for law in legs)
    terms = framed(pretty, "leg", "term of the law", "amplitudes", "std", "unit", "shape")
    for k, law in enumerate(legs[:1] if shared else legs):
        leg = "1 to 6" if shared else str(k + 1)
        for j, sensor in enumerate(law["sensors"]):
            cells = []
            for letter in "AB":
                std = law[f"{letter}_std_um_per_m_K"]
                cells += [f"{law[f'{letter}_um_per_m_K'][j]:g}", "-" if std is None else f"{std[j]:.3g}"][: 1 + unsure]
            laws.add_row(leg, sensor, *cells, law["campaign"] or "not said")
        for term in law["terms"]:
            terms.add_row(leg, *term_cells(term))
    return [laws, terms] if terms.row_count else [laws]


def day_table(result: Demonstration, pretty: bool, width: int | None = None) -> Table:
    """Return a simulated day, one row an hour; where less than `width` letters are left, only what matters most."""
    errors = [
        f"{what}\n{how}\n{unit}>" for what, unit in (("shift", "um"), ("turn", "urad")) for how in ("without", "with")
    ]
    names = ["hour>", "state", "legs\nK>", "correct\num>", *errors[:2], "less>", *errors[2:], "less>"]
    rows = _day_rows(result)
    for dropped in ((), (1, 3), (1, 2, 3), (1, 2, 3, 7, 8, 9)):
        kept = [k for k in range(len(names)) if k not in dropped]
        table = framed(pretty, *(names[k] for k in kept))
        for row in rows:
            table.add_row(*(row[k] for k in kept))
        if width is None or width_of(table, 0) <= width:
            break
    return table


def _day_rows(result: Demonstration) -> list[list[str]]:
    """Return the cells of a simulated day, one row an hour."""
    without, with_ = largest(result.errors_without), largest(result.errors_with)
    correction = (result.corrected - result.nominal).mean(axis=(1, 2)) * 1e6
    rise = result.truth.legs.mean(axis=1) - reference_degC(result.hexapod)
    hours = result.truth.time / HOUR_S
    rows = []
    for hour in np.arange(0.0, hours[-1] + 1e-9, 1.0):
        k = int(np.argmin(np.abs(hours - hour)))
        state = "works" if result.truth.working[k] else "rests"
        cells = [f"{hour:g}", state, f"{rise[k]:+z.2f}", f"{correction[k]:+z.2f}"]
        for before, after in zip(without, with_, strict=True):
            cells += [f"{before[k]:z.2f}", f"{after[k]:z.2f}", reduction(before[k], after[k])]
        rows.append(cells)
    return rows


def reduction(before: float, after: float) -> str:
    """Return by how much an error shrank, in percent, or grew: "55 %", "80 % more"; "none" where it stayed."""
    if after == before:
        return "none"
    if after > before:
        return f"{percent(100.0 * (after / before - 1.0))} % more" if before > 0.0 else "more"
    return f"{percent(100.0 * (1.0 - after / before))} %"


def percent(value: float) -> str:
    """Return percents without a sign: a decimal below 1 and above 99, never rounded to 0 or 100."""
    size = abs(value)
    if size > 99.0:
        return f"{math.floor(size * 10.0) / 10.0:z.1f}" if size < 100.0 else f"{size:z.0f}"
    if 0.0 < size < 0.05:
        return "below 0.1"
    return f"{size:z.1f}" if size < 0.95 else f"{size:z.0f}"


def singular_at_home(facts: dict[str, Any]) -> str:
    """Return a warning where a machine cannot be held at its home; empty where it can."""
    condition = facts["condition_number_at_home"]
    if condition is not None and condition <= LARGEST_CONDITION:
        return ""
    text = "infinite" if condition is None else f"{condition:.3g}"
    return (
        f"warning: machine {facts['name']!r} is singular at home (condition number {text}, allowed "
        f"{LARGEST_CONDITION:g}): its legs do not hold the platform there, so no pose can be corrected from home; "
        "check the joints, their order and home in the machine's file"
    )


def trajectory_table(summary: TrajectorySummary, pretty: bool) -> Table:
    """Return what a corrected trajectory was made of."""
    table = framed(pretty, "corrected trajectory", "")
    table.add_row("poses", f"{summary.rows}")
    table.add_row("temperatures", f"{summary.lowest_degC:g} to {summary.highest_degC:g} degC, {summary.pairing}")
    table.add_row("sensors", ", ".join(summary.sensors))
    where = f"leg {summary.largest_leg}, line {summary.largest_line} of the poses"
    table.add_row("largest correction", f"{summary.largest_correction_um:z.3f} um ({where})")
    for name, low, high in zip(POSE_COLUMNS, summary.lowest_pose, summary.highest_pose, strict=True):
        table.add_row(f"span of {name}", f"{low:g} to {high:g}")
    table.add_row("columns copied from the poses", ", ".join(summary.copied) or "none")
    table.add_row("columns of the temperatures not used", ", ".join(summary.unused) or "none")
    for note in summary.notes:
        table.add_row("note", note)
    table.add_row("written", str(summary.out))
    return table
