"""What notebooks show: machines, laws, budgets, validations and diagnoses as tables with their units.

The tables are those of the command line; here they become HTML that takes colours and letters from the page it stands
on, so that it reads on light and on dark ones. Every table has a caption, and headers for its columns and rows.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from rich.table import Table

from hexathermal.learn.coverage import TWO_SIDED
from hexathermal.learn.diagnosis.result import Diagnosis
from hexathermal.learn.hexapod_identification import HexapodIdentification
from hexathermal.learn.hexapod_validation import HexapodValidation
from hexathermal.learn.identification import Identification
from hexathermal.learn.law import IdentifiedLaw
from hexathermal.learn.machine_diagnosis.result import MachineDiagnosis
from hexathermal.learn.validation import Validation, Verdict
from hexathermal.machine.hexapod import Hexapod
from hexathermal.machine.thermal import LegLaw, ThermalModel
from hexathermal.poses import coordinates_from_pose
from hexathermal.predict.acceptance import Acceptance
from hexathermal.predict.budget import Budget
from hexathermal.show import diagnosis_page as page
from hexathermal.show import (
    diagnosis_sections,
    diagnosis_tables,
    diagnosis_words,
    machine_sections,
    machine_tables,
    machine_words,
)
from hexathermal.show.acceptance_tables import results_table, verdict_lines
from hexathermal.show.budget_tables import bias_table, contributions_table
from hexathermal.show.extension_tables import term_cells, term_facts
from hexathermal.show.hexapod_tables import hexapod_laws_table, hexapod_validation_table, kinds_table, unit_of
from hexathermal.show.html_tables import from_table
from hexathermal.show.identification_tables import (
    coefficient_rows,
    gain_table,
    law_formula,
    law_table,
    sets_table,
    validation_table,
)
from hexathermal.show.notebook_drawing import machine_drawing
from hexathermal.show.tables import law_tables, leg_facts, machine_facts, thermal_facts, thermal_tables
from hexathermal.show.tables import machine_tables as tables_of_machine

PROBABILITY = 0.95
"""Of the expanded uncertainties of a budget."""

CSS = """
.hexathermal{color:inherit;line-height:1.45}
.hexathermal .finding{font-size:1.1em;font-weight:600;margin:.3em 0}
.hexathermal p{margin:.4em 0}
.hexathermal .scroll{overflow-x:auto}
.hexathermal table{border-collapse:collapse;margin:.3em 0 .8em;color:inherit;background:none;font-size:.95em}
.hexathermal caption{caption-side:top;text-align:left;font-weight:600;padding:.3em 0;color:inherit}
.hexathermal tr,.hexathermal thead,.hexathermal tbody tr:nth-child(odd){background:none}
.hexathermal th,.hexathermal td{text-align:left;vertical-align:baseline;padding:.2em .9em .2em 0;border:0;
border-bottom:1px solid color-mix(in srgb,currentColor 25%,transparent);font-weight:400;color:inherit;max-width:40em}
.hexathermal thead th{font-weight:600;vertical-align:bottom}
.hexathermal tbody th{white-space:nowrap}
@media (max-width:40rem){.hexathermal tbody th{white-space:normal;min-width:6rem}}
.hexathermal .named th,.hexathermal .named td{font-weight:600}
.hexathermal .n{text-align:right;font-variant-numeric:tabular-nums}
.hexathermal td.n{white-space:nowrap}
.hexathermal dl.facts{display:flex;flex-wrap:wrap;gap:.4em 2em;margin:.5em 0}
.hexathermal dl.facts dd{margin:0;font-size:1.15em;font-weight:600}
.hexathermal dl.facts small{display:block;font-weight:400;font-size:.8em}
.hexathermal summary{cursor:pointer;padding:.2em 0}
.hexathermal svg{max-width:100%;height:auto;color:inherit}
"""
"""Colours are those of the page around; lines are the text's colour, thinned."""


def html_of(value: Any) -> str:
    """Return a value as HTML for a notebook.

    Parameters
    ----------
    value : Hexapod, ThermalModel, LegLaw, IdentifiedLaw, Identification, HexapodIdentification, Validation,
            HexapodValidation, Budget, Acceptance, Diagnosis or MachineDiagnosis

    Raises
    ------
    TypeError
        There is no such picture of the value.

    Examples
    --------
    >>> import hexathermal as ht
    >>> law = ht.LegLaw("T07", 1.99e-6, 1.09e-6, campaign="bench <1>")
    >>> '<td class="n">1.99</td>' in html_of(law), "bench &lt;1&gt;" in html_of(law)
    (True, True)
    """
    for kind in type(value).__mro__:
        if kind in _DRAWN:
            return f'<div class="hexathermal"><style>{CSS}</style>{"".join(_DRAWN[kind](value))}</div>'
    known = ", ".join(sorted(kind.__name__ for kind in _DRAWN))
    raise TypeError(f"a {type(value).__name__} has no tables for a notebook; these have: {known}")


def folded(summary: str, *parts: str) -> str:
    """Return parts that a reader opens."""
    return f"<details><summary>{page.text(summary)}</summary>{''.join(parts)}</details>"


def _finding(words: str) -> str:
    """Return the sentence that stands first."""
    return page.paragraph(words[:1].upper() + words[1:], "finding")


def _notes(notes: Sequence[str], what: str = "Note") -> list[str]:
    """Return remarks, each a paragraph."""
    return [page.paragraph(f"{what}: {note.rstrip('.')}.") for note in notes]


def _machine(hexapod: Hexapod) -> list[str]:
    """Return what a machine is."""
    overview, joints, *thermal = tables_of_machine(machine_facts(hexapod), True)
    head = f"Hexapod {hexapod.name}" if hexapod.name else "Hexapod without a name"
    return [
        _finding(head),
        machine_drawing(hexapod),
        from_table(overview, "Machine"),
        *_thermal_tables(thermal),
        folded("Joints of the six legs", from_table(joints, "Joints, each in the frame of its plate")),
    ]


def _thermal_tables(tables: Sequence[Table]) -> list[str]:
    """Return the tables of a thermal model."""
    captions = ("Thermal model", "Expansion laws of the legs: drift = sum of A q0 dT + B q dT", "Terms of the laws")
    return [from_table(table, caption) for table, caption in zip(tables, captions, strict=False)]


def _leg_law(law: LegLaw) -> list[str]:
    """Return the coefficients of a machine's leg."""
    captions = ("Leg law: drift = sum of A q0 dT + B q dT", "Terms that extend it")
    tables = zip(law_tables([leg_facts(law)], True), captions, strict=False)
    return [from_table(table, caption, without=(0,)) for table, caption in tables]


def _identified_law(law: IdentifiedLaw) -> list[str]:
    """Return a law with its uncertainty, and where it holds."""
    form = f"sum of {law_formula(law)}"
    rows = [(name, f"{value:.4f}", f"{u:.4f}", f"{value - TWO_SIDED * u:.4f} to {value + TWO_SIDED * u:.4f}", unit)
            for name, value, u, unit in coefficient_rows(law)]  # fmt: skip
    parts = [
        page.table(f"Law of a {law.kind}: drift = {form}",
                   ("coefficient", "value>", "standard uncertainty>", "95 % interval", "unit"), rows),
        page.table("Where it holds, and where it comes from", ("what", "value"), _origin_rows(law)),
    ]  # fmt: skip
    if law.terms:
        heads = ("term of the law", "amplitudes", "standard uncertainty", "unit", "shape")
        parts.insert(1, page.table("Terms that extend it", heads, [term_cells(one) for one in term_facts(law.terms)]))
    repairs = ", ".join(dict.fromkeys(one.cause for one in law.repairs))
    return parts + ([page.paragraph(f"Data are put right before the law reads them: {repairs}.")] if repairs else [])


def _origin_rows(law: IdentifiedLaw) -> list[tuple[str, str]]:
    """Return range and origin of a law."""
    rows = [(f"dT of {name}", f"{low:.2f} to {high:.2f} K")
            for name, (low, high) in zip(law.sensors, law.validity.dT, strict=True)]  # fmt: skip
    if law.validity.q is not None:
        rows.append(("displacement q", " to ".join(f"{value * 1e3:.1f}" for value in law.validity.q) + " mm"))
    if law.retracted_length is not None:
        rows.append(("retracted length q0", f"{law.retracted_length * 1e3:.6g} mm"))
    rows.append(("noise of what is left", f"{law.noise.variance**0.5 * 1e6:.3f} um"))
    rows.append(("counts from", "the first row of each run" if law.zero == "run" else "the first row of the campaign"))
    rows += [("campaign", law.origin.title)] * bool(law.origin.title)
    return [*rows, *[("runs", ", ".join(law.origin.runs))] * bool(law.origin.runs)]


def _identification(found: Identification) -> list[str]:
    """Return which law was chosen, and why."""
    choice = found.choice
    return [
        _finding(f"Law of {' + '.join(choice.sensors)}"),
        page.paragraph(f"Chosen: {choice.reason}."),
        from_table(law_table(found, True), "Coefficients"),
        folded("The best sets of sensors", from_table(sets_table(found, True), "Sets of sensors")),
        *_notes(found.warnings, "Warning"),
        *_notes(found.notes),
    ]


def _hexapod_identification(found: HexapodIdentification) -> list[str]:
    """Return the laws of six legs, and which kind of them was chosen."""
    kind = "One law for all six legs" if found.chosen == "common" else f"{found.chosen} laws".capitalize()
    return [
        _finding(kind),
        page.paragraph(f"Chosen: {found.reason}."),
        from_table(hexapod_laws_table(found, True), "Coefficients"),
        folded("Kinds of laws side by side", from_table(kinds_table(found, True), "Kinds of laws")),
        *_notes(found.notes),
    ]


def _verdict(verdict: Verdict) -> str:
    """Return a verdict on a law in words."""
    return f"the law {verdict.value}" if verdict in (Verdict.BETTER, Verdict.WORSE) else verdict.value


def _validation(found: Validation) -> list[str]:
    """Return what runs never fitted say of a law."""
    return [
        _finding(f"{_verdict(found.verdict)}, on {found.rows} rows"),
        from_table(validation_table(found, True), "Runs", named=(len(found.runs),)),
        *_notes(found.notes),
    ]


def _hexapod_validation(found: HexapodValidation) -> list[str]:
    """Return what runs never fitted say of a machine."""
    said = [f"{key}: {_verdict(found.verdict[key])}, RMS {found.total[key].before.value * 1e6:.2f} to "
            f"{found.total[key].after.value * 1e6:.2f} {unit_of(key)}" for key in found.verdict]  # fmt: skip
    return [
        _finding("; ".join(said)),
        from_table(hexapod_validation_table(found, True), "Errors of the platform before and after"),
        *_notes(found.notes),
    ]


def _budget(budget: Budget) -> list[str]:
    """Return bias, uncertainty and what contributes to it."""
    place = ", ".join(f"{value * 1e3:g}" for value in budget.point)
    at = ", ".join(f"{value:.6g}" for value in coordinates_from_pose(budget.pose) + 0.0)
    heat = " to ".join(dict.fromkeys(f"{value:.2f}" for value in (budget.temps.min(), budget.temps.max())))
    return [
        _finding(f"Error budget of {budget.machine or 'a machine'}, {'' if budget.corrected else 'not '}corrected"),
        page.paragraph(
            f"Pose ({at}) mm, deg in the base frame; {heat} °C. Errors of the point ({place}) mm from the platform's "
            f"origin, in the axes of the {budget.frame} frame."
        ),
        from_table(bias_table(budget, PROBABILITY, True), "Bias and uncertainty"),
        from_table(
            contributions_table(budget, True), "Sources, the heaviest first", named=(len(budget.contributions),)
        ),
    ]


def _acceptance(found: Acceptance) -> list[str]:
    """Return the verdict and every decision."""
    first, *others = verdict_lines(found).splitlines()
    return [_finding(first), *map(page.paragraph, others), from_table(results_table(found, True), "Decisions"),
            *_notes(found.notes)]  # fmt: skip


def _diagnosis(found: Diagnosis) -> list[str]:
    """Return what a leg's law gets wrong."""
    gain = [] if found.gain is None else [from_table(gain_table(found.gain, True), "Gain on runs never fitted")]
    return [
        _finding(diagnosis_words.sentences(found)[0]),
        diagnosis_sections.opening(found),
        *_effects(found, diagnosis_tables.effects_table),
        *gain,
        *_ranking(found, diagnosis_tables.ranking_table, diagnosis_tables.limits_table),
        *[page.paragraph(f"Next: {found.experiments[0].words}") for _ in found.experiments[:1]],
    ]


def _machine_diagnosis(found: MachineDiagnosis) -> list[str]:
    """Return what a machine's model gets wrong."""
    gain = [] if found.gain is None else [from_table(machine_tables.gain_table(found, True),
                                                     "Errors before and after, on runs never fitted")]  # fmt: skip
    return [
        _finding(machine_words.sentences(found)[0]),
        machine_sections.opening(found),
        *_effects(found, machine_tables.effects_table),
        *gain,
        *_ranking(found, machine_tables.ranking_table, machine_tables.limits_table),
        *[page.paragraph(f"Next, for {one.purpose}: {one.words}") for one in found.advice[:1]],
    ]


def _effects(found: Any, effects: Callable[[Any, bool], Table]) -> list[str]:
    """Return the causes that were named, where there are any."""
    return [from_table(effects(found, True), "Causes and their parameters")] if found.effects else []


def _ranking(found: Any, ranking: Callable[[Any, bool], Table], limits: Callable[[Any, bool], Table]) -> list[str]:
    """Return every candidate and the limits of detection, folded."""
    named = range(len(found.effects))
    return [
        folded(
            "What was tried, the likeliest first",
            from_table(ranking(found, True), "Candidates, best first", named=named),
        ),
        folded("How small an effect would be named", from_table(limits(found, True), "Limits of detection")),
    ]


_DRAWN: dict[type, Callable[[Any], list[str]]] = {
    Acceptance: _acceptance,
    Budget: _budget,
    Diagnosis: _diagnosis,
    Hexapod: _machine,
    HexapodIdentification: _hexapod_identification,
    HexapodValidation: _hexapod_validation,
    IdentifiedLaw: _identified_law,
    Identification: _identification,
    LegLaw: _leg_law,
    MachineDiagnosis: _machine_diagnosis,
    ThermalModel: lambda model: _thermal_tables(thermal_tables(thermal_facts(model), True)),
    Validation: _validation,
}
"""Which values notebooks show, and how."""
