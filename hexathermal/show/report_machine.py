"""The report of a whole machine: geometry, drawing, workspace, thermal law, a warm day, the budget."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from hexathermal.errors import ArgumentError, HexathermalError
from hexathermal.kinematics.workspace import margins, reachable_volume
from hexathermal.machine.hexapod import Hexapod
from hexathermal.predict.budget import Budget, error_budget
from hexathermal.predict.budget_plates import Plates, blind_plates
from hexathermal.show import report_machine_charts as charts
from hexathermal.show.budget_tables import bias_table, contributions_table
from hexathermal.show.diagnosis_page import paragraph, table
from hexathermal.show.html_tables import from_table
from hexathermal.show.report_budget_charts import contributions_chart
from hexathermal.show.report_chart import Chart
from hexathermal.show.report_page import Report, Section
from hexathermal.show.tables import day_table, machine_facts, machine_file, machine_tables, percent, singular_at_home
from hexathermal.simulate.demonstration import Demonstration, demonstrate, summary

SEED = 1
Progress = Callable[[int, int, str], None]


def machine_report(hexapod: Hexapod, name: str, progress: Progress) -> Report:
    """Return the report of a machine.

    Parameters
    ----------
    hexapod : Hexapod
    name : str
        By which it was loaded: a bundled machine's name, or a path.
    progress : callable
        Called as ``progress(done, total, label)``.
    """
    facts = machine_facts(hexapod, machine_file(name))
    facts["file"] = Path(facts["file"]).name  # a report may be passed on
    notes = [warning] if (warning := singular_at_home(facts).removeprefix("warning: ")) else []
    told: dict[str, Any] = {"machine": facts}
    sections = [_geometry(hexapod, facts), _workspace(hexapod, told, notes, progress)]
    finding = f"{hexapod.name or name} is a machine without a thermal law: how it drifts is not known."
    pairs = [("Grade", hexapod.grade or "not said", "A identified, B measured, C drawing or published values")]
    if "volume_cm3" in told:
        pairs.append(("Reachable volume", _volume(told["volume_cm3"]), "translations at home's orientation"))
    if hexapod.thermal is None:
        none = paragraph("None is stated: the machine can be moved, but not corrected.")
        sections.append(Section("thermal", "Thermal law", "Thermal law", (none,)))
    else:
        sections.append(_thermal(hexapod, facts))
        progress(0, 0, "simulating a day (the first run compiles)")
        day = _day(hexapod, notes)
        if day is None:
            finding = (
                f"{hexapod.name or name} carries a thermal law; no warm day of it could be simulated, as the notes say."
            )
        else:
            numbers = summary(day)
            told["day"] = numbers
            shift = numbers["largest_shift_um"]
            finding = (
                f"On a simulated working day {hexapod.name or name} drifts by up to {shift['without']:z.2f} µm; "
                f"correction leaves {shift['with']:z.2f} µm."
            )
            pairs += [
                (
                    f"Largest {what}",
                    f"{one['without']:z.2f} → {one['with']:z.2f} {unit}",
                    f"{percent(one['reduction_percent'])} % {'less' if one['reduction_percent'] >= 0.0 else 'more'}",
                )
                for what, one, unit in (("shift", shift, "µm"), ("turn", numbers["largest_turn_urad"], "µrad"))
            ]
            sections.append(_warm_day(day, numbers))
            progress(0, 0, "error budget")
            sections.append(_budget(hexapod, day, told, notes))
    title = hexapod.name or name
    return Report("machine", f"Machine {title}", f"Machine {title}: {hexapod.source or 'source not said'}", finding,
                  tuple(pairs), tuple(sections), tuple(notes), told)  # fmt: skip


def _volume(cm3: float) -> str:
    """Return a volume in words: whole numbers, of small ones three digits.

    Examples
    --------
    >>> _volume(30954.2), _volume(11.837)
    ('30954 cm³', '11.8 cm³')
    """
    return f"{cm3:.0f} cm³" if cm3 >= 1e3 else f"{cm3:.3g} cm³"


def _geometry(hexapod: Hexapod, facts: dict[str, Any]) -> Section:
    """Return the geometry, and the machine drawn."""
    overview, joints = machine_tables(facts, False)[:2]
    return Section(
        "geometry", "Geometry", "Geometry",
        (charts.drawing_chart(hexapod), from_table(overview, "The machine"),
         from_table(joints, "Joints of the legs, base frame and platform frame")),
    )  # fmt: skip


def _workspace(hexapod: Hexapod, told: dict[str, Any], notes: list[str], progress: Progress) -> Section:
    """Return numbers of the workspace."""
    parts: list[str | Chart] = []
    progress(0, 0, "workspace")
    try:
        volume = reachable_volume(hexapod)
        low, high = (value * 1e6 for value in volume.bounds)
        told["volume_cm3"], told["volume_bounds_cm3"] = float(volume.value) * 1e6, [float(low), float(high)]
        parts.append(paragraph(
            f"Without turning, the platform's origin reaches a volume of {_volume(told['volume_cm3'])} (between "
            f"{_volume(low)} and {_volume(high)}, bounds that hold), within strokes, cones and travel, on home's side "
            "of singular poses."
        ))  # fmt: skip
        found = charts.travels(hexapod)
        told["travel_from_home"] = {axis: list(ends) for axis, ends in found.items()}
        rows = [(axis, *(f"{'beyond ' * (abs(end) >= charts.farthest(hexapod, k))}{end:z.2f}" for end in ends),
                 "mm" if k < 3 else "deg") for k, (axis, ends) in enumerate(found.items())]  # fmt: skip
        parts.append(table("Travel from home, one coordinate at a time", ("coordinate", "from>", "to>", "unit"), rows))
        parts.append(charts.workspace_chart(hexapod, found))
    except HexathermalError as error:
        parts.append(paragraph(f"The workspace is not known: {error}", "note"))
        notes.append(f"the workspace is not known: {error}")
    home = margins(hexapod, hexapod.home)
    parts.append(paragraph(f"Condition number at home: {float(home.condition_number):.3g} (1 is best)."))
    return Section("workspace", "Workspace", "Workspace", tuple(parts))


def _thermal(hexapod: Hexapod, facts: dict[str, Any]) -> Section:
    """Return the thermal law with its uncertainty."""
    names = ("Thermal law", "Coefficients of the legs", "Terms that extend the laws")
    shown = [from_table(one, name) for one, name in zip(machine_tables(facts, False)[2:], names, strict=False)]
    drawn = charts.law_chart(hexapod)
    words = (
        "drift of a leg = Σ over its sensors of A q0 ΔT + B q ΔT; what a leg corrects is commanded with the other "
        "sign: corrected = nominal − drift."
    )
    parts: list[str | Chart] = [paragraph(words[0].upper() + words[1:]), *shown]
    if drawn is not None:
        parts.append(drawn)
    return Section("thermal", "Thermal law", "Thermal law, with its uncertainty", tuple(parts))


def _day(hexapod: Hexapod, notes: list[str]) -> Demonstration | None:
    """Return a simulated day; a machine that cannot live through it says why."""
    try:
        return demonstrate(hexapod, seed=SEED)
    except HexathermalError as error:
        notes.append(f"no day was simulated: {error}")
        return None


def _warm_day(day: Demonstration, numbers: dict[str, Any]) -> Section:
    """Return a warm day with and without correction."""
    words = (
        f"A simulation, not a measurement (seed {SEED}): the machine works for eight hours along "
        f"{numbers['work_poses']} poses and rests. Its legs' true coefficients differ from the law's by "
        f"{100.0 * numbers['day']['law_uncertainty']:g} %, thermometers have noise and gain errors, temperatures are "
        "generic. Each error is the largest of all poses."
    )
    return Section("day", "A warm day", "A warm day, with and without correction",
                   (paragraph(words), charts.day_chart(day),
                    from_table(day_table(day, False), "The day, hour by hour")))  # fmt: skip


def _budget(hexapod: Hexapod, day: Demonstration, told: dict[str, Any], notes: list[str]) -> Section:
    """Return the budget at home, at the warmest minute of the day."""
    at = int(np.argmax(day.truth.legs.mean(axis=1)))
    known = {f"{part}_degC": float(getattr(day.truth, part)[at]) for part in blind_plates(hexapod)}
    plates = Plates(**known)  # type: ignore[arg-type]
    try:
        budget: Budget = error_budget(hexapod, hexapod.home, day.readings[at], plates=plates,
                                      air_degC=float(day.truth.room[at]))  # fmt: skip
    except (ArgumentError, HexathermalError) as error:
        notes.append(f"no budget could be made: {error}")
        return Section("budget", "Budget", "Error budget", (paragraph(f"Not known: {error}", "note"),))
    told["budget"] = budget.as_dict()
    pairs = tuple((one.label, one.uncertainty * 1e6) for one in budget.contributions)
    hour = float(day.truth.time[at]) / 3600.0
    assumed = [one.label for one in budget.contributions if one.basis.startswith("engineering value")]
    words = (
        f"At home, {hour:z.1f} h into that day, when the legs are warmest; errors of the platform's origin, base axes."
    )
    parts: list[str | Chart] = [paragraph(words), contributions_chart(pairs, budget.uncertainty * 1e6,
                                                                      budget.remaining * 1e6)]  # fmt: skip
    parts += [from_table(bias_table(budget, 0.95, False), "Bias and uncertainty"),
              from_table(contributions_table(budget, False), "Contributions, largest first")]  # fmt: skip
    if assumed:
        parts.append(paragraph(
            f"Engineering values, to be replaced by what is known of the machine: {', '.join(assumed)}.", "note"
        ))  # fmt: skip
    return Section("budget", "Budget", "Error budget", tuple(parts))
