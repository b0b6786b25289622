"""The report of a measured campaign of a whole hexapod: runs, check, what can be told apart, the proof of its law."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from hexathermal.errors import ArgumentError
from hexathermal.learn.campaign import Campaign
from hexathermal.learn.check_hexapod import HexapodCheck, HexapodRunCheck, check_hexapod_campaign, hexapod_warnings
from hexathermal.learn.hexapod_data import AXES
from hexathermal.learn.hexapod_observability import Observability
from hexathermal.learn.hexapod_validation import HexapodValidation, validate_hexapod
from hexathermal.show import campaign_figures, hexapod_figures, hexapod_tables
from hexathermal.show import campaign_hexapod as tables
from hexathermal.show.diagnosis_page import paragraph
from hexathermal.show.figures import BLACK, BLUE, VERMILION
from hexathermal.show.hexapod_answers import law_origin
from hexathermal.show.html_tables import from_table
from hexathermal.show.options import machine
from hexathermal.show.report_campaign import MOST_RUNS, text_lines
from hexathermal.show.report_campaign_charts import HOUR_S, collinearity_chart, hex_colour, noise_chart, run_words
from hexathermal.show.report_chart import Bars, Chart, Curve, Panel, file_name
from hexathermal.show.report_page import Report, Section
from hexathermal.show.report_thinning import MOST_POINTS, kept_of, thinned_words

Progress = Callable[[int, int, str], None]
LOOKS = (("µm", "shift", slice(0, 3)), ("µrad", "turn", slice(3, 6)))
COLOURS = (BLUE, VERMILION, BLACK)


def hexapod_report(campaign: Campaign, law: str | None, progress: Progress) -> Report:
    """Return the report of a campaign of kind ``"hexapod"``.

    Parameters
    ----------
    campaign : Campaign
    law : str or None
        Name or path of the machine whose law is held against the runs for validation; default the campaign's own.
    progress : callable
        Called as ``progress(done, total, label)``.

    Raises
    ------
    CampaignError
        A table is at fault.
    ArgumentError, UnknownNameError
        The machine that was named has no law, or none that these data can be held against.
    """
    check = check_hexapod_campaign(campaign, progress)
    notes: list[str] = []
    proof = _validated(campaign, law, notes, progress)
    title = campaign.title or campaign.folder.name
    sections = [_measured(check), _runs(check), _quality(check), *([] if proof is None else [_proof(proof)])]
    facts = {"check": tables.hexapod_check_facts(check),
             "validation": None if proof is None else hexapod_tables.hexapod_validation_facts(proof)}  # fmt: skip
    return Report("campaign", f"Campaign: {title}", f"Measured campaign of a hexapod: {title}", _finding(check, proof),
                  _pairs(check, proof), tuple(sections), tuple(notes), facts)  # fmt: skip


def _validated(campaign: Campaign, law: str | None, notes: list[str], progress: Progress) -> HexapodValidation | None:
    """Return what a machine's law leaves of the runs for validation; without one that was asked for, say why not."""
    if not campaign.runs_of("validation"):
        notes.append("no run is for validation: how well a law predicts is not known")
        return None
    name = law if law is not None else None if campaign.hexapod is None else str(campaign.hexapod)
    if name is None:
        notes.append("the campaign names no machine: no law is held against it; --law names one")
        return None
    hexapod = machine(name)
    if hexapod.thermal is None and law is None:
        notes.append(f"machine {hexapod.name!r} of the campaign has no thermal law; --law names a machine that has one")
        return None
    progress(0, 0, "validating (the first run compiles)")
    origin, why = law_origin(name, hexapod)
    try:
        found = validate_hexapod(hexapod, campaign, origin=origin)
    except ArgumentError as error:
        if law is not None:
            raise
        notes.append(f"the machine's law could not be validated: {error}")
        return None
    notes.extend(found.notes)
    if origin is None:
        notes.append(f"whether these runs were fitted cannot be told: {why}")
    if len(found.fitted) == len(found.runs):  # else the validation says which are left out
        notes.extend(f"run {run} was fitted: the law was identified on its rows, then named {before}; it proves nothing"
                     for run, before in found.fitted.items())  # fmt: skip
    return found


def _finding(check: HexapodCheck, proof: HexapodValidation | None) -> str:
    """Return the sentence that stands first."""
    if proof is None:
        shifts = [np.linalg.norm(one.deviation[:, :3], axis=1).max() for one in check.runs if len(one.time)]
        largest = float(max(shifts, default=0.0))
        return f"The platform was measured up to {largest * 1e6:z.2f} µm off its commanded pose."
    far, turned = proof.total["translation"], proof.total["rotation"]
    return (
        f"On runs for validation the machine's law brings the platform's error from {far.before.value * 1e6:z.2f} to "
        f"{far.after.value * 1e6:z.2f} µm and from {turned.before.value * 1e6:z.2f} to {turned.after.value * 1e6:z.2f} "
        "µrad (RMS)."
    )


def _pairs(check: HexapodCheck, proof: HexapodValidation | None) -> tuple[tuple[str, str, str], ...]:
    """Return the key figures."""
    campaign = check.campaign
    roles = ", ".join(f"{len(campaign.runs_of(role))} for {role}" for role in ("identification", "validation"))
    rows, used = sum(one.rows for one in check.runs), sum(len(one.time) for one in check.runs)
    hours = sum(one.clock.duration for one in check.runs) / HOUR_S
    pairs = [("Runs", str(len(check.runs)), roles), ("Duration", f"{hours:z.1f} h", f"{used} of {rows} rows usable"),
             ("Thermometers", str(len(campaign.sensors)), "on legs and plates")]  # fmt: skip
    if proof is not None:
        for name, unit in (("translation", "µm"), ("rotation", "µrad")):
            one = proof.total[name]
            which = "less" if one.reduction.value >= 0.0 else "more"
            pairs.append((f"RMS {name}", f"{one.before.value * 1e6:z.2f} → {one.after.value * 1e6:z.2f} {unit}",
                          f"{abs(100.0 * one.reduction.value):.0f} % {which}, for validation"))  # fmt: skip
    return tuple(pairs)


def _measured(check: HexapodCheck) -> Section:
    """Return what was measured."""
    parts = [paragraph(tables.overview(check).replace("\n", " ")), from_table(tables.runs_table(check, False), "Runs")]
    return Section("measured", "Measured", "What was measured", tuple(parts))


def _runs(check: HexapodCheck) -> Section:
    """Return the runs against time."""
    shown = [one for one in check.runs if len(one.time)]
    parts: list[str | Chart] = [run_chart(check, one) for one in shown[:MOST_RUNS]]
    if len(shown) > MOST_RUNS:
        parts.insert(0, paragraph(f"The first {MOST_RUNS} of {len(shown)} runs are drawn.", "note"))
    return Section("runs", "Runs", "Temperatures and deviation of the pose, run by run", tuple(parts))


def run_chart(check: HexapodCheck, run: HexapodRunCheck) -> Chart:
    """Return one run: temperatures, and shift and turn of the platform off its commanded pose."""
    drawn = [run.heat, *(run.deviation[:, part] for _unit, _what, part in LOOKS)]
    rows = kept_of(len(run.time), MOST_POINTS, *drawn)
    hours = run.time[rows] / HOUR_S
    looks = {"-": "line", "--": "dashed", "-.": "dashdot", ":": "dotted"}
    sensors = check.campaign.thermocouples
    panels = []
    if sensors:
        curves = tuple(Curve(item.name, *campaign_figures.broken(hours, values), hex_colour(colour), looks[style])
                       for item, (colour, style), values in
                       zip(sensors, campaign_figures.looks(sensors), run.heat[rows].T, strict=True))  # fmt: skip
        panels.append(Panel("Temperatures", curves, "time", "temperature", "h", "°C", height=1.4))
    words = []
    for unit, what, part in LOOKS:
        values = run.deviation[rows, part] * 1e6
        curves = tuple(Curve(axis, *campaign_figures.broken(hours, values[:, k]), COLOURS[k],
                             ("line", "dashed", "dotted")[k]) for k, axis in enumerate(AXES[part]))  # fmt: skip
        panels.append(Panel(f"{what.capitalize()} off the commanded pose", curves, "time", what, "h", unit))
        words.append(f"{what} up to {float(np.linalg.norm(run.deviation[:, part], axis=1).max()) * 1e6:z.2f} {unit}")
    name = run_words(run.run.name)
    return Chart(
        file_name(name), f"{name} ({run.run.role})",
        f"{name}: {len(run.time)} measured poses in {run.time[-1] / HOUR_S:z.1f} hours, {' and '.join(words)} off the "
        "commanded pose.",
        f"{len(run.time)} of {run.rows} rows usable.{thinned_words(len(rows), len(run.time))}", tuple(panels),
        shared=True,
    )  # fmt: skip


def _quality(check: HexapodCheck) -> Section:
    """Return what the check says."""
    told = hexapod_warnings(check)
    words = "".join(paragraph(f"Warning: {one}.", "note") for one in told) or paragraph("The check warns of nothing.")
    parts: list[str | Chart] = [words, text_lines(tables.remarks(check)),
                                from_table(tables.coordinates_table(check, False), "Measured coordinates")]  # fmt: skip
    sensors = check.campaign.sensors
    if sensors:
        parts.append(from_table(tables.thermometers_table(check, False), "Thermometers"))
        drawn = [noise_chart(sensors, check.sensor_noise, check.sensor_slow),
                 collinearity_chart(sensors, check.correlation)]  # fmt: skip
        parts += [one for one in drawn if one is not None]
    if check.observability is not None:
        parts.append(observability_chart(check.observability))
        parts.append(
            from_table(hexapod_tables.observability_table(check.observability, False), "What can be told apart")
        )
    else:
        parts.append(paragraph(f"What can be told apart is not known: {check.why_not or 'no reason told'}."))
    return Section("quality", "Check", "What the data are worth, and what they tell apart", tuple(parts))


def observability_chart(found: Observability) -> Chart:
    """Return the uncertainty of each coefficient, with all others unknown and with all others known."""
    seen = [one for one in found.coefficients if np.isfinite(one.uncertainty)]
    names = tuple(one.name for one in seen)
    bars = (
        Bars("all unknown together", names, np.array([one.uncertainty * 1e6 for one in seen]), BLUE),
        Bars("if all others were known", names, np.array([one.alone * 1e6 for one in seen]), VERMILION),
    )
    numbers = np.arange(1.0, len(found.singular_values) + 1.0)
    singular = Curve("singular value", numbers, np.maximum(found.singular_values, 1e-16), BLUE, "line")
    return Chart(
        "observability", "What poses and temperatures tell apart",
        f"Standard uncertainty of {len(seen)} coefficients, and {len(numbers)} singular values; condition number "
        f"{found.condition:.3g}.",
        "Coefficients: what the measurement's noise leaves. Singular values: a small one is a direction that the data "
        "hardly see.",
        (Panel("Coefficients", bars, "standard uncertainty", "", "µm/m/K", across=True),
         Panel("Directions", (singular,), "direction, best first", "singular value", log=True)),
        lambda: hexapod_figures.observability_figure(found),
    )  # fmt: skip


def _proof(proof: HexapodValidation) -> Section:
    """Return the validation."""
    shown = list(proof.runs)[:MOST_RUNS]
    lines = [f"Verdict on {name}: {'the law ' if one.name in ('BETTER', 'WORSE') else ''}{one.value}."
             for name, one in proof.verdict.items()]  # fmt: skip
    parts: list[str | Chart] = [
        paragraph("Errors of the platform before and after the machine's law, axis by axis. " + " ".join(lines)),
        from_table(hexapod_tables.hexapod_validation_table(proof, False), "Before and after, with 95 % intervals"),
        *(validation_chart(proof, run) for run in shown),
    ]  # fmt: skip
    if len(shown) < len(proof.runs):
        parts.append(paragraph(f"The first {len(shown)} of {len(proof.runs)} runs are drawn.", "note"))
    return Section("proof", "Validation", "Before and after, on runs for validation", tuple(parts))


def validation_chart(found: HexapodValidation, run: str) -> Chart:
    """Return one run of a validation: errors of six axes before and after."""
    here = np.flatnonzero(found.rows.run == found.rows.runs.index(run))
    hours = found.rows.time[here] / HOUR_S
    panels = []
    for k, axis in enumerate(AXES):
        unit = "µm" if k < 3 else "µrad"
        score = found.runs[run][axis]
        marks = (Curve("without correction", hours, found.before[here, k] * 1e6, VERMILION, "rings"),
                 Curve("with correction", hours, found.after[here, k] * 1e6, BLUE, "dots"))  # fmt: skip
        title = f"{axis}: RMS {score.before.value * 1e6:z.2f} → {score.after.value * 1e6:z.2f} {unit}"
        panels.append(Panel(title, marks, "time", axis, "h", unit, height=0.7))
    words = ", ".join(f"{axis} {found.runs[run][axis].before.value * 1e6:z.2f} to "
                      f"{found.runs[run][axis].after.value * 1e6:z.2f}" for axis in AXES)  # fmt: skip
    name = run_words(run)
    return Chart(
        f"validation-{file_name(run)}", f"{name}: error of the platform",
        f"{name}, {len(here)} poses: RMS error of each axis without and with correction (µm, µrad): {words}.",
        "Measured less predicted pose, base axes: without correction (rings) and with the machine's law (dots).",
        tuple(panels), lambda: hexapod_figures.validation_figure(found, run), True,
    )  # fmt: skip
