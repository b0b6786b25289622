"""The report of a measured leg or component: what was measured, what it tells, the law and what it leaves."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from hexathermal.errors import ArgumentError
from hexathermal.learn.campaign import Campaign
from hexathermal.learn.campaign_laws import identify_campaign, validate_campaign
from hexathermal.learn.check import CampaignCheck, check_campaign
from hexathermal.learn.check_words import as_data, hours, warnings_of
from hexathermal.learn.coverage import TWO_SIDED
from hexathermal.learn.identification import Identification
from hexathermal.learn.law import IdentifiedLaw
from hexathermal.learn.validation import Validation
from hexathermal.show import campaign_tables, identification_tables
from hexathermal.show import report_campaign_charts as charts
from hexathermal.show.diagnosis_page import paragraph, table
from hexathermal.show.html_tables import from_table
from hexathermal.show.report_chart import Chart
from hexathermal.show.report_page import Report, Section
from hexathermal.show.shares import bounded

MOST_RUNS = 12
"""Runs that have a figure of their own."""

NO_INTERVAL = "one landing: no interval"

Progress = Callable[[int, int, str], None]


def campaign_report(campaign: Campaign, law: IdentifiedLaw | None, progress: Progress) -> Report:
    """Return the report of a campaign of kind ``"leg"`` or ``"component"``.

    Parameters
    ----------
    campaign : Campaign
    law : IdentifiedLaw or None
        That is held against the runs for validation; without it the one that the campaign's own runs for identification
        give.
    progress : callable
        Called as ``progress(done, total, label)``.

    Raises
    ------
    CampaignError
        A table is at fault.
    ArgumentError, UnknownNameError
        The law is of another kind, zero or sensors than the campaign.
    """
    check = check_campaign(campaign, progress)
    notes: list[str] = []
    found = _identified(campaign, notes, progress)
    used = law if law is not None else None if found is None else found.law
    proof = None
    if used is not None:
        proof = _validated(used, campaign, law is not None, notes, progress)
    title = campaign.title or campaign.folder.name
    sections = [
        _measured(check), _runs(check), _quality(check),
        *([] if found is None else [_sensors(found)]),
        *([] if used is None else [_law(used, found, law is not None)]),
        *([] if proof is None or used is None else [_proof(proof, used)]),
    ]  # fmt: skip
    return Report(
        "campaign", f"Campaign: {title}", f"Measured campaign: {title}", _finding(check, proof, used),
        _pairs(check, proof), tuple(sections), tuple(notes), _facts(check, found, used, proof),
    )  # fmt: skip


def _identified(campaign: Campaign, notes: list[str], progress: Progress) -> Identification | None:
    """Return what the runs for identification give, or say why there is nothing."""
    if not campaign.runs_of("identification"):
        notes.append("no run is for identification: no law is identified, and pairs of sensors are not compared")
        return None
    try:
        return identify_campaign(campaign, progress=progress)
    except ArgumentError as error:
        notes.append(f"no law could be identified: {error}")
        return None


def _validated(
    law: IdentifiedLaw, campaign: Campaign, asked: bool, notes: list[str], progress: Progress
) -> Validation | None:
    """Return how a law predicts the runs for validation; where nobody asked for this law, say why it cannot be told."""
    if not campaign.runs_of("validation"):
        notes.append("no run is for validation: how well a law predicts is not known")
        return None
    try:
        return validate_campaign(law, campaign, progress)
    except ArgumentError as error:
        if asked:
            raise
        notes.append(f"the law could not be validated: {error}")
        return None


def _finding(check: CampaignCheck, proof: Validation | None, law: IdentifiedLaw | None) -> str:
    """Return the sentence that stands first."""
    largest = max((max(map(abs, run.drift)) for run in check.runs if run.record.used), default=0.0) * 1e6
    if proof is None or law is None:
        return f"The measured drift reaches {largest:z.2f} µm; how much of it a law foretells is not known."
    total = proof.total
    which, verdict = " + ".join(law.sensors), proof.verdict
    told = (
        f"On runs for validation, the law of {which} {verdict.value}"
        if verdict.name in ("BETTER", "WORSE")
        else f"The law of {which}, on runs for validation: {verdict.value}"
    )
    return (
        f"{told}; the drift reaches {total.drift_largest * 1e6:z.2f} µm, what is left of it at "
        f"most {total.linf.value * 1e6:z.2f} µm."
    )


def _pairs(check: CampaignCheck, proof: Validation | None) -> tuple[tuple[str, str, str], ...]:
    """Return the key figures."""
    campaign = check.campaign
    rows, used = (sum(getattr(run.record, name) for run in check.runs) for name in ("rows", "used"))
    roles = ", ".join(f"{len(campaign.runs_of(role))} for {role}" for role in ("identification", "validation"))
    pairs = [
        ("Runs", str(len(check.runs)), roles),
        ("Duration", f"{np.nansum(hours(check)):z.1f} h", f"{used} of {rows} rows usable"),
        ("Thermocouples", str(len(campaign.sensors)), "condition number "
         f"{campaign_tables.number(check.condition, 0)}"),
    ]  # fmt: skip
    if proof is not None:
        total = proof.total
        mean, less = total.mean_reduction, total.rmse
        pairs += [
            ("RMSE, for validation", f"{total.drift_rms * 1e6:z.2f} → {less.value * 1e6:z.3f} µm",
             f"95 %: {less.low * 1e6:z.3f} to {less.high * 1e6:z.3f} µm" if bounded(less) else NO_INTERVAL),
            ("Mean drift less by", f"{100.0 * mean.value:z.1f} %",
             f"95 %: {100.0 * mean.low:z.1f} to {100.0 * mean.high:z.1f} %" if bounded(mean) else NO_INTERVAL),
            ("Inside 95 % interval", f"{100.0 * proof.coverage:z.1f} %", f"of {proof.rows} rows"),
        ]  # fmt: skip
    return tuple(pairs)


def text_lines(words: str) -> str:
    """Return lines of text as paragraphs."""
    return "".join(paragraph(line.strip()) for line in words.splitlines() if line.strip())


def _measured(check: CampaignCheck) -> Section:
    """Return what was measured."""
    campaign = check.campaign
    parts = [paragraph(campaign_tables.overview(check).replace("\n", " "))]
    if campaign.leg is not None:
        low, high = (value * 1e3 for value in campaign.leg.stroke)
        parts.append(paragraph(
            f"A leg of q0 = {campaign.leg.retracted_length * 1e3:g} mm between its joints when retracted, and a stroke "
            f"from {low:g} to {high:g} mm."
        ))  # fmt: skip
    if campaign.beams is not None:
        done = "applied the index of air" if campaign.beams.index_compensated else "did not apply the index of air"
        parts.append(paragraph(
            f"Three beams at {campaign.beams.radius * 1e3:g} mm from the axis, dead path "
            f"{campaign.beams.dead_path * 1e3:g} mm; the laser's electronics {done}."
        ))  # fmt: skip
    if campaign.inputs:
        parts.append(paragraph("Inputs: " + "; ".join(
            one.name + (f", {one.description}" if one.description else "") for one in campaign.inputs
        ) + "."))  # fmt: skip
    parts.append(from_table(campaign_tables.runs_table(check, False), "Runs"))
    if campaign.thermocouples:
        parts.append(_thermocouples(campaign))
    first = next((run for run in check.runs if run.run.role == "identification"), check.runs[0])
    scenario = charts.scenario_chart(first)
    return Section("measured", "Measured", "What was measured", (*parts, *([] if scenario is None else [scenario])))


def _thermocouples(campaign: Campaign) -> str:
    """Return what is known of the thermocouples: a table, or their names alone where nothing else is said."""
    sensors = campaign.thermocouples
    columns = [("name", [item.name for item in sensors])]
    if any(item.part for item in sensors):
        columns.append(("part", [item.part or "-" for item in sensors]))
    if any(item.position is not None for item in sensors):
        places = ["-" if item.position is None else f"{item.position * 1e3:g}" for item in sensors]
        columns.append(("along the leg, mm>", places))
    heads, cells = zip(*columns, strict=True)
    if len(columns) == 1:
        return paragraph(f"Thermocouples: {', '.join(cells[0])}; the campaign does not say where they sit.")
    return table("Thermocouples", heads, list(zip(*cells, strict=True)))


def _runs(check: CampaignCheck) -> Section:
    """Return the runs against time."""
    shown = [run for run in check.runs if len(run.trace.time)]
    parts: list[str | Chart] = []
    if len(shown) > MOST_RUNS:
        parts.append(paragraph(f"The first {MOST_RUNS} of {len(shown)} runs are drawn.", "note"))
    parts += [charts.run_chart(check, run) for run in shown[:MOST_RUNS]]
    if not shown:
        parts.append(paragraph("No run has a row that may be used.", "note"))
    return Section("runs", "Runs", "Temperatures and drift, run by run", tuple(parts))


def _quality(check: CampaignCheck) -> Section:
    """Return what the check says."""
    sensors = check.campaign.sensors
    told = warnings_of(check)
    words = "".join(paragraph(f"Warning: {one}.", "note") for one in told) or paragraph("The check warns of nothing.")
    drawn = [charts.noise_chart(sensors, check.sensor_noise, check.sensor_slow),
             charts.collinearity_chart(sensors, check.correlation), charts.coverage_chart(check)]  # fmt: skip
    return Section(
        "quality", "Check", "What the data are worth",
        (words, text_lines(campaign_tables.remarks(check)),
         from_table(campaign_tables.cleaning_table(check, False), "What was left out, and why"),
         from_table(campaign_tables.sensors_table(check, False), "Noise, range and likeness of each thermocouple",
                    without=() if any(item.part for item in check.campaign.thermocouples) else (1,)),
         from_table(campaign_tables.apart_table(check, False), "What can be told apart"),
         *(one for one in drawn if one is not None)),
    )  # fmt: skip


def _sensors(found: Identification) -> Section:
    """Return the search for sensors."""
    ranked = found.ranked
    drawn: list[str | Chart] = []
    if (ranked.sizes == 2).any():
        drawn = [charts.matrices_chart(ranked), charts.front_chart(found)]
    return Section(
        "sensors", "Which sensors", "Which thermocouples foretell the drift",
        (paragraph(f"{len(ranked.names)} sets of sensors were fitted to the runs for identification, and judged on "
                   f"runs left out. Chosen: {' + '.join(found.choice.sensors)}. Why: {found.choice.reason}."),
         from_table(identification_tables.sets_table(found, False), "The best sets"), *drawn),
    )  # fmt: skip


def _law(law: IdentifiedLaw, found: Identification | None, given: bool) -> Section:
    """Return the law with its uncertainty."""
    form = f"Σ {identification_tables.law_formula(law)}".replace("dT", "ΔT")
    source = law.origin.title or "a campaign without a title"
    whose = (
        f"The law that was given, identified from {source}" if given else "The law that the runs of this campaign give"
    )
    causes = dict.fromkeys([term.cause for term in law.terms] + [one.cause for one in law.repairs])
    more = f" It is extended by {', '.join(causes)}." if causes else ""
    rows = [(name, f"{value:z.4f}", f"{u:z.4f}", f"{value - TWO_SIDED * u:z.4f} to {value + TWO_SIDED * u:z.4f}", unit)
            for name, value, u, unit in identification_tables.coefficient_rows(law)]  # fmt: skip
    parts = [
        paragraph(f"{whose}: drift = {form} over {', '.join(law.sensors)}.{more}"),
        table("Coefficients", ("coefficient", "value>", "standard uncertainty>", "95 % interval>", "unit"), rows),
    ]
    if found is not None and not given:
        parts.append(text_lines("\n".join(f"Warning: {one}" for one in found.warnings)))
        if found.check is not None:
            like = ", ".join(found.check.like) or "no common material"
            parts.append(paragraph(
                f"Effective expansion of the fixed part: {found.check.expansion * 1e6:z.2f} ± "
                f"{TWO_SIDED * found.check.expansion_uncertainty * 1e6:z.2f} um/m/K (95 %), like {like}."
            ))  # fmt: skip
    return Section("law", "The law", "The law, with its uncertainty", tuple(parts))


def _proof(proof: Validation, law: IdentifiedLaw) -> Section:
    """Return the validation."""
    fitted = [
        f"Run {name} was fitted (then named {before}): it proves nothing." for name, before in proof.fitted.items()
    ]
    parts: list[str | Chart] = [
        paragraph("Runs for validation: what the law predicts, and what was measured."),
        *(paragraph(one, "note") for one in fitted),
        from_table(identification_tables.validation_table(proof, False), "What the law leaves, with 95 % intervals"),
        *(paragraph(f"Note: {note.rstrip('.')}.", "note") for note in proof.notes),
    ]  # fmt: skip
    if len(proof.curves) > MOST_RUNS:
        parts.append(paragraph(f"The first {MOST_RUNS} of {len(proof.curves)} runs are drawn.", "note"))
    parts += [charts.validation_chart(proof, curves, law) for curves in proof.curves[:MOST_RUNS]]
    return Section("proof", "Validation", "Predicted and measured, on runs for validation", tuple(parts))


def _facts(
    check: CampaignCheck, found: Identification | None, law: IdentifiedLaw | None, proof: Validation | None
) -> dict[str, Any]:
    """Return the key figures as plain values."""
    return {
        "check": as_data(check),
        "identification": None if found is None else identification_tables.identification_facts(found),
        "law": None if law is None else {
            "sensors": list(law.sensors), "coefficients": [
                {"name": name, "value": value, "standard_uncertainty": u, "unit": unit}
                for name, value, u, unit in identification_tables.coefficient_rows(law)]},
        "validation": None if proof is None else identification_tables.validation_facts(proof),
    }  # fmt: skip
