"""Sections of the report of a machine's diagnosis: words and tables around the pictures, for a test engineer."""

from __future__ import annotations

from hexathermal.learn.machine_diagnosis.causes import catalogue
from hexathermal.learn.machine_diagnosis.planning import MachineExperiment
from hexathermal.learn.machine_diagnosis.result import MachineDiagnosis, MachineEffect
from hexathermal.learn.machine_proposal import ALIKE
from hexathermal.show.diagnosis_page import facts, paragraph, section, table, text
from hexathermal.show.diagnosis_words import VERDICTS
from hexathermal.show.hexapod_tables import unit_of
from hexathermal.show.machine_limits import LIMITS_HEAD, LIMITS_ON_PAGES, limits_rows
from hexathermal.show.machine_tables import apart, ranking_rows
from hexathermal.show.machine_words import (
    UM,
    amplitude,
    changed,
    framed_out,
    gain_words,
    noise_words,
    notes_of,
    parameter_rows,
    score_cells,
    sentences,
)
from hexathermal.show.shares import less, probability


def opening(found: MachineDiagnosis) -> str:
    """Return what stands under the first sentence: further causes, key figures, notes."""
    many = f"{len(found.effects)} causes are named" if len(found.effects) > 1 else VERDICTS[found.verdict]
    pairs = [("Verdict", many, f"probability {probability(found.probability)}")]
    if found.gain is not None:
        for name, word in (("translation", "Translation"), ("rotation", "Rotation")):
            one, unit = (found.gain.unframed if framed_out(found) else found.gain.total)[name], unit_of(name)
            before, part = f"{one.before.value * UM:.2f}", one.reduction
            aside = ", frame of each run out" if framed_out(found) else ""
            value = f"{before} → {one.after.value * UM:.2f} {unit}" if changed(found) else f"{before} {unit}"
            pairs.append(
                (
                    f"{word}, runs never fitted{aside}",
                    value,
                    less(part) if changed(found) else "nothing joined the machine",
                )
            )
    noise = found.disturbances.noise * UM
    pairs.append(("Noise of a pose", f"{noise[:3].mean():.2f} um, {noise[3:].mean():.2f} urad", "each coordinate"))
    roles = [run.role for run in found.residuals]
    pairs.append(
        ("Runs", f"{len(roles)}", f"{roles.count('identification')} searched, {roles.count('validation')} not")
    )
    notes = "".join(paragraph(f"Note: {note}.", "note") for note in notes_of(found)[0])
    others = "".join(paragraph(words) for words in sentences(found)[1:])
    return others + facts(pairs) + notes


def all_sections(
    found: MachineDiagnosis, drawn: dict[str, str], plan: MachineExperiment | None
) -> list[tuple[str, str, str]]:
    """Return the sections: name, short title, HTML.

    Parameters
    ----------
    found : MachineDiagnosis
    drawn : dict of str to str
        HTML of the pictures of each section.
    plan : MachineExperiment or None
    """
    parts = [
        ("finding", "Finding", "What was found", _finding(found)),
        ("gain", "Before and after", "Before and after, on runs never fitted", _gain(found, drawn)),
        ("runs", "Runs", "What is left, run by run", _runs(found, drawn)),
        ("follows", "What the residual follows", "What the residual follows", _signals(drawn)),
        ("ranking", "Ranking", "Every cause that was tried", _ranking(found, drawn)),
        ("confused", "Confusions", "What these poses and temperatures cannot tell apart", _confused(found)),
        ("next", "Next experiment", "What to measure next", _next(found, drawn, plan)),
        ("limits", "Detection limits", "How small an effect would have been named", _limits(found, drawn)),
    ]
    return [(f"s-{name}", short, section(f"s-{name}", title, body)) for name, short, title, body in parts]


def _finding(found: MachineDiagnosis) -> str:
    """Return what was named, or what it means that nothing was."""
    if found.effects:
        left = [paragraph(f"Besides, something is left that {found.follows}.", "note")] if found.follows else []
        return "".join([*(_effect(one) for one in found.effects), *left])
    if found.verdict == "none":
        return paragraph(
            "Every cause of the catalogue was tried at every leg, plate and joint, and none explains these poses "
            "better than chance could. That is no proof that there is none: how small an effect can hide is told below."
        )
    return paragraph(
        f"What is left {found.follows} more than chance could make it, but no cause of the catalogue explains that. "
        "Look at the pictures of that signal: it is real, and it is not noise. The machine was left as it is."
    )


def _effect(one: MachineEffect) -> str:
    """Return one cause that was named."""
    known = catalogue().get(one.cause)
    where = f", {one.target}" if one.target else ""
    head = ("parameter", "value>", "standard uncertainty>", "95 % interval", "unit")
    if one.equivalent_places:
        alike = f"These data do not rule out {', '.join(one.equivalent_places)}: see the next experiment."
    else:
        alike = "No other cause or place explains these data as well."
    physics = (
        f"{known.CAUSE.physics} How it shows: {known.CAUSE.signature}"
        if known is not None
        else "A cause of a single leg, seen through the leg it sits on."
    )
    return (
        f'<div class="card"><h3>{text(one.cause + where)}</h3>{paragraph(physics)}'
        + table(f"Size of {one.cause}", head, parameter_rows(one))
        + paragraph(
            f"On the platform it makes {amplitude(one)} um and {amplitude(one, rotation=True)} urad in these poses "
            f"(RMS, 95 %); what law and measuring frame do not absorb of it is {one.strength:.2g} times the noise."
        )
        + paragraph(f"Probability of the name: {probability(one.probability)}. {alike}")
        + "</div>"
    )


def _gain(found: MachineDiagnosis, drawn: dict[str, str]) -> str:
    """Return the gain on runs for validation."""
    lines = [paragraph(gain_words(found))]
    if found.gain is None:
        return lines[0]
    runs = [*found.gain.runs.items(), ("all", found.gain.total)]
    runs += [("all, no frame", found.gain.unframed)] if framed_out(found) else []
    if changed(found):
        rows = [(run, name, unit_of(name), *(cell.replace("->", "→") for cell in score_cells(score)))
                for run, scores in runs for name, score in scores.items()]  # fmt: skip
        head = ("run", "error", "unit", "RMSE before>", "RMSE after (95 %)>", "less by (95 %)>", "largest>")
        marked = range(len(rows) - len(found.gain.total), len(rows))
        return "".join(
            [*lines, drawn["gain"], table("Before and after, run by run and axis by axis", head, rows, marked)]
        )
    plain = [(run, name, unit_of(name), f"{score.before.value * UM:.3f}", f"{score.largest_before * UM:.2f}")
             for run, scores in runs for name, score in scores.items()]  # fmt: skip
    return lines[0] + table("The machine, run by run", ("run", "error", "unit", "RMSE>", "largest>"), plain)


def _runs(found: MachineDiagnosis, drawn: dict[str, str]) -> str:
    """Return the residuals of runs."""
    held = sum(run.role == "validation" for run in found.residuals)
    words = (
        "Runs for validation: nothing was fitted to them."
        if held
        else "There are no runs for validation: these were all searched, and prove nothing about new ones."
    )
    return (
        paragraph(f"Measured less predicted pose: x, y, z, and rx, ry, rz, the angles of the controller. {words}")
        + drawn["runs"]
        + f"<h3>All runs</h3>{drawn['all']}"
    )


def _signals(drawn: dict[str, str]) -> str:
    """Return the residual against signals."""
    return (
        paragraph(
            "Signals move together in any campaign: what works warms, and time runs on. A residual that follows one of "
            "them does not yet make that its cause; the ranking weighs all causes against each other on the same data."
        )
        + drawn["follows"]
        + f"<h3>Against the pose</h3>{drawn['pose']}<h3>Leg by leg</h3>{drawn['legs']}"
        + (f"<h3>Against temperatures of plates and air</h3>{drawn['parts']}" if drawn["parts"] else "")
    )


def _ranking(found: MachineDiagnosis, drawn: dict[str, str]) -> str:
    """Return the ranking."""
    head = ("cause", "where", "RMS, um (95 %)>", "RMS, urad (95 %)>", "visible, noise = 1>", "evidence>",
            "probability>", "at best with")  # fmt: skip
    return (
        paragraph(
            "Evidence is the logarithm of how much more probable these poses are with the cause at that place than "
            "without, its unknown size taken into account: 2.3 is 10 to 1, 7 is 1000 to 1. A name needed "
            f"{found.threshold:.1f} in this campaign. Names that begin with “follows” are no causes: they stand for "
            "something real without a name."
        )
        + drawn["ranking"]
        + table("Candidates, best first", head, ranking_rows(found), range(len(found.effects)))
    )


def _confused(found: MachineDiagnosis) -> str:
    """Return what looks alike, with reasons; and what these runs cannot show."""
    bench = notes_of(found)[1]
    if found.alike:
        rows = [(names, why) for names, _between, why in (one.partition(ALIKE) for one in found.alike)]
        said = paragraph(
            "If one of them were at work, twice as large as needed to be named, another could be named in its place."
        ) + table("Look alike in these data", ("cause and place", "why"), rows)
    else:
        said = paragraph(
            "These poses and temperatures tell all causes and places apart, at twice the size that is named."
        )
    if bench:
        rows = [(cause, words) for cause, _colon, words in (one.partition(": ") for one in bench)]
        said += table("What poses of a machine do not show, and what would", ("cause of a leg", "measure"), rows)
    return said


def _next(found: MachineDiagnosis, drawn: dict[str, str], plan: MachineExperiment | None) -> str:
    """Return the next experiment: designed poses, and what the catalogue advises."""
    said = ""
    if plan is not None:
        rows = [(one.true, one.rival, f"{one.before:.1f}", f"{one.after:.1f}", apart(one.after))
                for one in plan.promises]  # fmt: skip
        head = ("if true", "told from", "without it>", "with it>", "then")
        said += (
            paragraph(f"{plan.words}.")
            + drawn["plan"]
            + table("Promised separation, mean log evidence", head, rows)
            + paragraph(
                "The poses stand in poses-run-1.csv, temperatures and promises in experiment.json, beside this page."
            )
        )
    if found.advice:
        items = "".join(f"<li>{text(one.words)}<small>For: {text(one.purpose)}.</small></li>"
                        for one in found.advice)  # fmt: skip
        said += f'<h3>What the catalogue advises</h3><ol class="next">{items}</ol>'
    return said or paragraph("No experiment is proposed.")


def _limits(found: MachineDiagnosis, drawn: dict[str, str]) -> str:
    """Return limits of detection, and the noise that makes them."""
    rows = limits_rows(found.limits)
    if not rows:
        return paragraph("No limit could be told.")
    head = ("cause", *LIMITS_HEAD)
    return (
        paragraph(noise_words(found))
        + drawn["limits"]
        + table("Smallest effect on the platform that would be named, RMS", head, rows)
        + paragraph(LIMITS_ON_PAGES)
    )
