"""The report of a diagnosis, from the JSON that ``hexathermal diagnose`` wrote, of a leg, a component or a machine."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

from hexathermal.errors import FileFormatError, Problem
from hexathermal.learn.diagnosis.result import Experiment, Quantity, in_turn
from hexathermal.learn.diagnosis.words import two_digits
from hexathermal.learn.machine_diagnosis.result import MachineAdvice
from hexathermal.learn.validation_scores import Figure
from hexathermal.show import shares
from hexathermal.show.diagnosis_page import paragraph, table, text
from hexathermal.show.diagnosis_tables import verdict_probability
from hexathermal.show.diagnosis_words import (
    NONE_NAMED,
    UNNAMED,
    VERDICTS,
    how_apart,
    parameter,
    settings_words,
    where,
)
from hexathermal.show.experiment_words import promise_words, told_apart
from hexathermal.show.machine_limits import LIMITS_HEAD, LIMITS_ON_PAGES, limits_rows, limits_told
from hexathermal.show.report_chart import Chart
from hexathermal.show.report_diagnosis_charts import disturbances_chart, gain_chart, limits_chart, ranking_chart
from hexathermal.show.report_diagnosis_fields import wrong_fields
from hexathermal.show.report_page import Report, Section
from hexathermal.show.shares import probability

MOST_WRONG = 5
"""Wrong fields that are listed; the rest is counted."""

Facts = dict[str, Any]


def diagnosis_report(told: Facts, place: Path) -> Report:
    """Return the report of a diagnosis.

    Parameters
    ----------
    told : dict
        As `diagnose --json` writes it.
    place : Path
        Where it was read.

    Raises
    ------
    FileFormatError
        It lacks what a diagnosis has; every such field is listed.
    """
    if wrong := wrong_fields(told):
        raise _unreadable(place, wrong)
    try:
        return _report(told, place)
    except (KeyError, TypeError, ValueError, AttributeError, IndexError):
        raise _unreadable(place, ("the settings of a cause, or what it is named, are of no diagnosis",)) from None


def _unreadable(place: Path, wrong: tuple[str, ...]) -> FileFormatError:
    """Return the error about fields that are no diagnosis's."""
    more = f" (and {len(wrong) - MOST_WRONG} more)" if len(wrong) > MOST_WRONG else ""
    words = f"no diagnosis that can be read: {'; '.join(wrong[:MOST_WRONG])}{more}; write it anew with 'diagnose'"
    file = place / "diagnosis.json" if place.is_dir() else place
    return FileFormatError(str(file), (Problem(1, 1, words),))


def _report(told: Facts, place: Path) -> Report:
    """Return the report."""
    title = str(told["title"]) or "campaign without a title"
    whole = told.get("kind") == "hexapod"
    many = len(told["effects"])
    sure = verdict_probability("" if whole else told["verdict"], many, float(told["probability"]))
    said = UNNAMED if _unnamed(told) else VERDICTS[told["verdict"]]
    verdict = f"{many} causes are named" if many > 1 else said
    pairs = [("Verdict", verdict, sure),
             ("Threshold", f"{told['threshold']:.1f}", "log evidence that a name needed")]  # fmt: skip
    gain = told["gain"]
    bare = _without_frames(told)
    if gain is not None:
        best, aside = (gain, "") if bare is None else (bare, ", frame of each run out")
        for key, unit in _measures(best):
            before, after = best[f"{key}_before_{unit}"], best[f"{key}_after_{unit}"]
            shown = unit.replace("um", "µm").replace("urad", "µrad")
            same = not _joined(gain)
            value = f"{before:.3f} {shown}" if same else f"{before:.3f} → {after:.3f} {shown}"
            part = _reduction(best, key)
            sure = "" if same or part is None else f": {_worth(part)}"
            what = "nothing joined the law" if same else "before → after"
            pairs.append((f"{_measure(key)}, for validation", value, what + aside + sure))
    unlike = list(told.get("unlike") or []) if told["effects"] else []  # else the first sentence has it
    if told["effects"] and (given := (told.get("given") or {}).get("sentence")):
        unlike = [given, *unlike]
    notes = [str(note).rstrip(".") for note in (*unlike, *told["notes"])]
    folder = place if place.is_dir() else place.parent
    if (folder / "report.html").is_file():
        notes.append("pictures of what is left of each run stand in report.html beside the file that was read")
    sections = [_finding(told), _ranking(told)]
    if gain is not None and gain.get("runs"):
        sections.append(_gain(gain, bare))
    sections += [_limits(told), _next(told), _noise(told)]
    facts = {"title": title, "verdict": told["verdict"], "cause": told["cause"], "target": told["target"],
             "probability": told["probability"], "gain": gain}  # fmt: skip
    about = "whole machine" if whole else f"law of {' + '.join(told['sensors'])}"
    first = next((str(one["sentence"]) for one in told["effects"]), str(told["sentence"]))
    return Report("diagnosis", f"Diagnosis: {title}", f"Diagnosis of {title}, {about}", first,
                  tuple(pairs), tuple(sections), tuple(notes), facts)  # fmt: skip


def _without_frames(told: Facts) -> Facts | None:
    """Return a machine's gain without the measuring frame of each run, where frames differ and would hide all else."""
    frames = told["disturbances"].get("frame_of_each_run", {}) if told.get("kind") == "hexapod" else {}
    bare: Facts | None = (told["gain"] or {}).get("without_frame_of_each_run")
    return bare if any(frames.values()) else None


def _measures(gain: Facts) -> list[tuple[str, str]]:
    """Return what a gain tells of, and its unit."""
    known = [("translation_rmse", "um"), ("rotation_rmse", "urad"), ("rmse", "um")]
    found = [(key, unit) for key, unit in known if f"{key}_before_{unit}" in gain]
    return found[:2] if len(found) > 2 else found  # of a machine "rmse" repeats the first


def _reduction(one: Facts, key: str) -> Figure | None:
    """Return by which part a measure became less, with its 95 % interval; None where that is not told."""
    name = "rmse_gain" if key == "rmse" else f"{key.removesuffix('_rmse')}_reduction"
    ends = one.get(f"{name}_95")
    if one.get(name) is None or not ends or len(ends) != 2:
        return None
    low, high = (math.nan if end is None else float(end) for end in ends)
    return Figure(float(one[name]), low, high)


def _worth(part: Figure) -> str:
    """Return by how much an error became less, and whether that is proven."""
    if not math.isfinite(part.low + part.high):
        word = "less" if part.value >= 0.0 else "more"
        return f"{shares.parts(abs(part.value))} % {word}; not proven: it has no interval"
    return f"{shares.less(part)}; {shares.proven(part)}"


def _finding(told: Facts) -> Section:
    """Return what was named."""
    whole = told.get("kind") == "hexapod"
    parts: list[str | Chart] = []
    for one, sentence in zip(told["effects"], _sentences(told), strict=True):
        rows, head = (
            _sizes(one, whole),
            ("parameter", "value>", "standard uncertainty>", "95 % interval>", "unit"),
        )
        where = f", {one['target']}" if one["target"] else ""
        alike = f" Not ruled out: {', '.join(one['equivalent'])}." if one["equivalent"] else ""
        sizes = table(f"Size of {one['cause']}", head, rows)
        parts.append(
            f'<div class="card"><h3>{text(one["cause"] + where)}</h3>{paragraph(sentence)}'
            f"{sizes if rows else ''}"
            f"{paragraph('Probability of the name: ' + probability(float(one['probability'])) + '.' + alike)}</div>"
        )
    if told["follows"]:
        parts.append(paragraph(f"What is left, and has no name, {told['follows']}.", "note"))
    if not parts:
        parts.append(paragraph(
            f"Every cause that these data could show was tried, and none {NONE_NAMED[_unnamed(told)]}. "
            "That is no proof that there is none: how small an effect can hide is told below."
        ))  # fmt: skip
    return Section("finding", "Finding", "What was found", tuple(parts))


def _unnamed(told: Facts) -> bool:
    """Whether some candidates of a leg or a part stand above chance although none is named."""
    if told.get("kind") == "hexapod" or told["verdict"] != "none":
        return False
    return any(one["evidence"] >= told["threshold"] for one in told["candidates"])


def _sentences(told: Facts) -> list[str]:
    """Return a sentence for each cause; of a leg or a part later ones tell what those before them left."""
    said = [str(one["sentence"]) for one in told["effects"]]
    return said if told.get("kind") == "hexapod" else list(in_turn(said))


def _sizes(effect: Facts, whole: bool) -> list[tuple[str, ...]]:
    """Return the parameters of a cause, of a `whole` machine or a part: name, value, uncertainty, interval, unit."""
    from hexathermal.learn.machine_diagnosis.quantities import spoken

    # the JSON does not say of what kind the part is; its sentence has the unit of a part without a stroke
    kind = "component" if "um/K" in effect["sentence"] else "leg"
    rows: list[tuple[str, ...]] = []
    for name, value in effect["parameters"].items():
        number, std = (math.nan if value[key] is None else float(value[key]) for key in ("value", "std"))
        size = parameter(name, Quantity(number, std, value["unit"]), kind)
        rows.append((spoken(name) if whole else size.name, *size.cells, size.unit or "-"))
    return rows


def _ranking(told: Facts) -> Section:
    """Return every cause that was tried."""
    head = ("cause", "where", "evidence>", "probability>", "at best with")
    rows = [
        (one["cause"], where(one["cause"], one["target"]), f"{one['evidence']:z.1f}",
         probability(float(one["probability"])), settings_words(one["settings"]) or "-")
        for one in told["candidates"]
    ]  # fmt: skip
    words = (
        "Evidence is the logarithm of how much more probable these data are with the cause than without: 2.3 is 10 to "
        f"1, 7 is 1000 to 1. A name needed {told['threshold']:.1f}."
    )
    drawn = [ranking_chart(told)] if told["candidates"] else []
    listed = table("Candidates, best first", head, rows, range(len(told["effects"]))) if rows else ""
    return Section("ranking", "Ranking", "What was tried, the likeliest first", (paragraph(words), *drawn, listed))


def _gain(gain: Facts, bare: Facts | None) -> Section:
    """Return errors before and after, run by run, and `bare` of frames; where nothing joined, there is no after."""
    rows: list[tuple[str, ...]] = []
    joined = _joined(gain)
    unframed = {} if bare is None else {"all, no frame": bare}
    for name, one in (*gain["runs"].items(), ("all", gain), *unframed.items()):
        for key, unit in _measures(one):
            if not joined:
                rows.append((name, _measure(key), f"{one[f'{key}_before_{unit}']:.3f}", unit))
                continue
            rows.append((name, _measure(key), f"{one[f'{key}_before_{unit}']:.3f}",
                         f"{one[f'{key}_after_{unit}']:.3f}", _less_by(one, key, unit), unit))  # fmt: skip
    drawn = gain_chart({**gain, "runs": unframed} if unframed else gain, _measures, joined)
    if not joined:
        head: tuple[str, ...] = ("run", "measure", "RMSE>", "unit")
        words = paragraph("Nothing joined: what is left on runs never fitted is what was left before.")
        return Section("gain", "What is left", "What is left on runs never fitted",
                       (words, *drawn, table("What is left, run by run", head, rows, stacked=True)))  # fmt: skip
    head = ("run", "measure", "before>", "after>", "less by (95 %)>", "unit")
    whole = [(_measure(key), _reduction(gain if bare is None else bare, key)) for key, _unit in _measures(gain)]
    said = [f"{name} {_worth(part)}" for name, part in whole if part is not None]
    runs = "All runs never fitted together" + (
        ", each without the frame that suits it best" if bare is not None else ""
    )
    words = (
        paragraph(f"{runs}: {'. '.join([*said[:1], *(one[0].upper() + one[1:] for one in said[1:])])}.") if said else ""
    )
    return Section("gain", "Before and after", "Before and after, on runs never fitted",
                   (words, *drawn, table("Before and after the extension", head, rows)))  # fmt: skip


def _less_by(one: Facts, key: str, unit: str) -> str:
    """Return by how much a measure became less, with its interval where that is told."""
    part = _reduction(one, key)
    if part is None or not math.isfinite(part.low + part.high):
        share = 1.0 - one[f"{key}_after_{unit}"] / max(one[f"{key}_before_{unit}"], 1e-12)
        return f"{shares.parts(share)} %"
    return f"{shares.parts(part.value)} % ({shares.parts(part.low)} to {shares.parts(part.high)})"


def _measure(key: str) -> str:
    """Return a measure's name."""
    return key.replace("_", " ").replace("rmse", "RMSE")


def _joined(gain: Facts) -> bool:
    """Return whether anything changed by what was found."""
    pairs = [(gain[f"{key}_before_{unit}"], gain[f"{key}_after_{unit}"]) for key, unit in _measures(gain)]
    return any(abs(after - before) > 1e-9 * max(abs(before), 1.0) for before, after in pairs)


def _limits(told: Facts) -> Section:
    """Return how small an effect would have been named."""
    drawn = limits_chart(told)
    if drawn is None:
        return Section("limits", "Detection limits", "How small an effect would have been named",
                       (paragraph("No limit could be told."),))  # fmt: skip
    if "detection_limits_um" in told:
        sizes = sorted(told["detection_limits_um"].items(), key=lambda item: item[1])
        rows = [(cause, two_digits(value)) for cause, value in sizes]
        listed = table("Smallest effect that would be named", ("cause", "visible RMS, um>"), rows)
    else:
        listed = table("Smallest effect on the platform that would be named, RMS", ("cause", *LIMITS_HEAD),
                       limits_rows(limits_told(told)))  # fmt: skip
        listed += paragraph(LIMITS_ON_PAGES)
    alike = _alike(told)
    return Section("limits", "Detection limits", "How small an effect would have been named", (drawn, listed, *alike))


def _alike(told: Facts) -> list[str]:
    """Return what these data cannot tell apart."""
    if told.get("confusions"):
        rows = [(*one["causes"], how_apart(one["separation"]), f"{max(one['separation'], 0.0):.1f}")
                for one in told["confusions"]]  # fmt: skip
        head = ("cause", "and", "told apart", "evidence apart>")
        return [table("Causes that look alike in these data", head, rows)]
    return [paragraph(f"Alike in these data: {one}.") for one in told.get("alike", ())]


def _next(told: Facts) -> Section:
    """Return what to measure next."""
    if "experiments" in told:
        planned = [Experiment(one["words"], tuple(one["causes"]), one["separation"], one.get("size_um", 0.0) * 1e-6)
                   for one in told["experiments"]]  # fmt: skip
        lines = [f"{one.words} Tells apart: {told_apart(one)}; {promise_words(one)}." for one in planned]
    else:
        lines = [f"{one['words']} ({_purpose(one)})" for one in told.get("advice", ())]
        plan = told.get("next_experiment")
        if isinstance(plan, dict) and plan.get("words"):
            lines.insert(0, str(plan["words"]))
    body = "".join(f"<li>{text(line)}</li>" for line in lines)
    words = f'<ol class="next">{body}</ol>' if lines else paragraph("No experiment is proposed.")
    return Section("next", "Next experiments", "What to measure next", (words,))


def _purpose(told: Facts) -> str:
    """Return what a measurement that the catalogue advises is for."""
    return MachineAdvice(told["words"], tuple(told["causes"]), tuple(told.get("places", ()))).purpose


def _noise(told: Facts) -> Section:
    """Return the noise."""
    if "noise_um" in told:
        parts = told["noise_um"]
        names = {"white": "white", "landings": "landing", "readings": "readings", "slow": "slow",
                 "zero of a run": "offset"}  # fmt: skip
        rows = [(name, f"{parts[key]:.3f}") for name, key in names.items() if key in parts]
        return Section(
            "noise", "Noise", "Noise", (table("Parts of the noise", ("noise", "standard deviation, um>"), rows),)
        )
    drawn = disturbances_chart(told["disturbances"])
    return Section("noise", "Noise", "Noise and disturbances", drawn or (paragraph("Not told."),))
