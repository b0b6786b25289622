"""Sections of a diagnosis' report: words and tables around the pictures, for a test engineer."""

from __future__ import annotations

from hexathermal.learn.diagnosis.causes import catalogue
from hexathermal.learn.diagnosis.result import Diagnosis, Effect
from hexathermal.learn.diagnosis.words import two_digits
from hexathermal.learn.validation_scores import Figure
from hexathermal.show.diagnosis_album import MOST_RUNS
from hexathermal.show.diagnosis_gain import gain_words
from hexathermal.show.diagnosis_page import facts, paragraph, section, table, text
from hexathermal.show.diagnosis_tables import joined_words, verdict_probability, visible_words
from hexathermal.show.diagnosis_words import (
    NONE_NAMED,
    changed,
    effect_rows,
    how_apart,
    noise_rows,
    placed,
    sentences,
    settings_words,
    shared_words,
    shares_windows,
    unexplained_words,
    verdict_words,
)
from hexathermal.show.experiment_words import alike_words, promise_words, told_apart
from hexathermal.show.shares import bounded, interval, less, parts, probability

OTHERWISE = "What the names do not add up to is left for something without a name and for errors of the models."
"""What is left of probabilities."""


def opening(found: Diagnosis) -> str:
    """Return what stands under the first sentence: further causes, key figures, notes."""
    many = f"{len(found.effects)} causes are named" if len(found.effects) > 1 else verdict_words(found)
    pairs = [("Verdict", many, verdict_probability(found.verdict, len(found.effects), found.probability))]
    if found.gain is not None:
        one = found.gain.total
        before = f"{one.rmse_before * 1e6:.3f}"
        if changed(found):
            change = f"{before} → {one.rmse_after.value * 1e6:.3f} µm"
            pairs.append(("RMSE on runs never fitted", change, less(one.rmse_gain)))
        else:
            pairs.append(("RMSE on runs never fitted", f"{before} µm", "nothing joined the law"))
    pairs.append(("Noise", f"{found.noise.rms * 1e6:.3f} µm", "within runs; what shifts a whole run is told below"))
    roles = [run.role for run in found.residuals]
    pairs.append(("Runs", f"{len(roles)}", f"{roles.count('identification')} fitted, {roles.count('validation')} not"))
    left = ["something is left that neighbouring windows share, see the autocorrelation under “Noise”"]
    notes = "".join(paragraph(f"Note: {note}.", "note") for note in (*found.notes, *left * shares_windows(found)))
    others = "".join(paragraph(words) for words in sentences(found)[1:])
    return others + facts(pairs) + notes


def all_sections(found: Diagnosis, drawn: dict[str, str]) -> list[tuple[str, str, str]]:
    """Return the sections: name, short title, HTML.

    Parameters
    ----------
    found : Diagnosis
    drawn : dict of str to str
        HTML of the pictures of each section.
    """
    parts = [
        ("finding", "Finding", "What was found", _finding(found)),
        (
            "predicted",
            "Predicted and measured",
            "What the law predicts, and what was measured",
            _predicted(found, drawn),
        ),
        ("gain", "Before and after", "Before and after, on runs never fitted", _gain(found, drawn)),
        ("follows", "What the residual follows", "What the residual follows", _signals(found, drawn)),
        ("ranking", "Ranking", "What was tried, the likeliest first", _ranking(found, drawn)),
        ("next", "Next experiments", "What to measure next", _next(found)),
        ("confused", "Confusions", "What these data cannot tell apart", _confused(found)),
        ("limits", "Detection limits", "How small an effect would have been named", _limits(found, drawn)),
        ("noise", "Noise", "Noise budget", _noise(found, drawn)),
    ]
    return [(f"s-{name}", short, section(f"s-{name}", title, body)) for name, short, title, body in parts]


def _finding(found: Diagnosis) -> str:
    """Return what was named, or what it means that nothing was."""
    if found.effects:
        left = (
            [paragraph(f"Besides, something without a name is left: it {found.follows}.", "note")]
            if found.follows
            else []
        )
        return "".join([*(_effect(one, found.law.kind) for one in found.effects), *left])
    if found.verdict == "none":
        return paragraph(
            f"Every cause that these data could show was tried, and none {NONE_NAMED[bool(found.unnamed)]}. "
            "That is no proof that there is none: how small an effect can hide is told below, cause by cause."
        ) + "".join(paragraph(words, "note") for words in found.unnamed)
    return paragraph(unexplained_words(found))


NAMED_FIRST = (
    "Causes that were named stand first, in the order in which they were found, each with its evidence over what those "
    "before it left; the others with what they had before anything was named. "
)

NOT_LEADING = (
    " An evidence of 0.0 tells that nothing more speaks for a cause: it is behind those that lead, for which alone the "
    "noise was fitted anew, or acts as no such cause does."
)

FEIGNED = "Why none is named of those that stand above that is told under “What was found”."


def _effect(one: Effect, kind: str) -> str:
    """Return one cause that was named."""
    cause = catalogue()[one.cause].CAUSE
    rows = [
        (name if unit == "-" else f"{name}, {unit}", value, std, between.replace(" ", "\N{NO-BREAK SPACE}"))
        for name, value, std, between, unit in effect_rows(one, kind)
    ]
    head = ("parameter", "value>", "standard uncertainty>", "95 % interval>")
    alike = alike_words(one, kind)
    joined = (
        f"No law is fitted to {one.target}, a run for validation: what it is judged by there has the step in it."
        if one.of_judged_run
        else f"It is no term of the law, which is to hold in other runs. Coefficients freed of it in {one.target} "
        "would foretell runs never fitted worse, see the gain below: they are those fitted with it."
        if joined_words(one) == "no term" and one.refused
        else "It is no term of the law, which is to hold in other runs: the coefficients are freed of it in "
        f"{one.target}."
        if joined_words(one) == "no term"
        else "Cleaning took it back before a law was fitted, so that none need hold it; later runs are cleaned alike."
        if one.taken_back
        else "It was mended before a law was fitted: the other thermometers tell of it without the drift."
        if one.told_by_thermometers
        else "It joined the law, since it foretells runs left out of the fit."
        if one.joined
        else "It did not join the law: that would foretell runs never fitted worse, see the gain below. More runs for "
        "validation tell whether this name is wrong, those runs are unlike the others, or their noise speaks by chance."
        if one.refused
        else "It did not join the law: runs left out of the fit do as well without it. It may go along with the drift "
        "and move nothing."
    )
    return (
        f'<div class="card"><h3>{text(placed(one.cause, one.target))}</h3>{paragraph(cause.physics)}'
        + (table(f"Size of {one.cause}", head, rows, stacked=True) if rows else "")
        + paragraph(f"How it shows: {cause.signature} {two_digits(one.visible * 1e6)} um of it stays visible.")
        + "".join(paragraph(words) for words in shared_words(one))
        + paragraph(f"Probability of the name: {probability(one.probability)}. {OTHERWISE} {alike} {joined}")
        + "</div>"
    )


def _predicted(found: Diagnosis, drawn: dict[str, str]) -> str:
    """Return the runs."""
    held = sum(run.role == "validation" for run in found.residuals)
    count = held or len(found.residuals)
    lines = [paragraph(
        "Runs for validation: no law was fitted to them." if held else
        "There are no runs for validation: these were all fitted, and prove nothing about new ones."
    )]  # fmt: skip
    if count > MOST_RUNS:
        lines.append(paragraph(f"The first {MOST_RUNS} of {count} runs are drawn.", "note"))
    lines.append(drawn["runs"])
    if drawn["fitted"]:
        lines.append(f"<h3>Runs for identification</h3>{drawn['fitted']}")
    return "".join(lines)


def _gain(found: Diagnosis, drawn: dict[str, str]) -> str:
    """Return the gain on runs for validation."""
    lines = [paragraph(gain_words(found))]
    if found.gain is None:
        return lines[0]
    if changed(found):
        rows = [
            (name, f"{one.rmse_before * 1e6:.3f}", _with_interval(one.rmse_after),
             f"{parts(one.rmse_gain.value)} % ({interval(one.rmse_gain)})",
             f"{one.linf_before * 1e6:.2f} → {one.linf_after.value * 1e6:.2f}",
             f"{parts(one.linf_gain.value)} % ({interval(one.linf_gain)})")
            for name, one in (*found.gain.runs.items(), ("all", found.gain.total))
        ]  # fmt: skip
        head = ("run", "RMSE before, um>", "RMSE after, um (95 %)>", "RMSE less by (95 %)>", "largest, um>",
                "largest less by (95 %)>")  # fmt: skip
        lines += [drawn["gain"], table("The law and the extended law, run by run", head, rows, [len(rows) - 1])]
        lines.append(paragraph(
            "The interval of all runs tells how an RMSE may differ from run to run; of two or three runs it is wide. "
            "What both laws share cancels in the gain.", "note"
        ))  # fmt: skip
    else:
        plain = [(name, f"{one.rmse_before * 1e6:.3f}", f"{one.linf_before * 1e6:.2f}")
                 for name, one in (*found.gain.runs.items(), ("all", found.gain.total))]  # fmt: skip
        lines.append(table("The law, run by run", ("run", "RMSE, um>", "largest, um>"), plain))
    lines.append(paragraph(
        "The free fit uses all temperatures and flexible curves at once. It is no law, since it says nothing of why; "
        "it shows what these channels give without a physical form."
    ))  # fmt: skip
    return "".join(lines)


def _with_interval(one: Figure) -> str:
    """Return metres with their interval [um]."""
    ends = f" ({one.low * 1e6:.3f} to {one.high * 1e6:.3f})" if bounded(one) else ""
    return f"{one.value * 1e6:.3f}{ends}"


def _signals(found: Diagnosis, drawn: dict[str, str]) -> str:
    """Return the residual against each signal."""
    return (
        paragraph(
            "Each dot is a window of a run (of very many some are drawn, those farthest out always), large points are "
            "means of parts of equal count. Signals move together in "
            "any campaign: what works warms, and time runs on. A residual that follows one of them here does "
            "not yet make that its cause; the ranking weighs all of them against each other on the same data."
        )
        + drawn["signals"]
    )


def _ranking(found: Diagnosis, drawn: dict[str, str]) -> str:
    """Return the ranking."""
    head = ("cause", "visible RMS, um (95 %)>", "evidence>", "probability>", "at best with")
    rows = [
        (placed(one.cause, one.target), visible_words(found, k),
         f"{one.evidence:z.1f}", probability(one.probability), settings_words(one.settings) or "-")
        for k, one in enumerate(found.candidates)
    ]  # fmt: skip
    return (
        paragraph(
            "Evidence is the logarithm of how much more probable these data are with the cause than without, its "
            "unknown size and parameters taken into account: 2.3 is 10 to 1, 7 is 1000 to 1. A name needed "
            f"{found.threshold:.1f} in this campaign, which chance alone reaches at most once in a hundred. Names that "
            "begin with “follows” are no causes: they stand for something real without a name."
            + (NOT_LEADING if any(one.evidence == 0.0 for one in found.candidates) else "")
        )
        + paragraph(
            f"{NAMED_FIRST if found.effects else ''}Of several thermometers that explain the runs fitted, the one is "
            "named that foretells runs left out best."
        )
        + "".join(paragraph(FEIGNED) for _words in found.unnamed)
        + drawn["ranking"]
        + table("Candidates: those named, then the others, best first", head, rows, range(len(found.effects)))
    )


def _next(found: Diagnosis) -> str:
    """Return the next experiments."""
    if not found.experiments:
        return paragraph("No experiment is proposed.")
    items = "".join(
        f"<li>{text(one.words)}<small>Tells apart: {text(told_apart(one))}; {text(promise_words(one))}.</small></li>"
        for one in found.experiments
    )
    return (
        paragraph(
            "The promise is the log evidence that the measurement brings on average, with the noise of a landing in "
            "this campaign, for an effect as large as found here, or twice as large as the least that would be named."
        )
        + f'<ol class="next">{items}</ol>'
    )


def _confused(found: Diagnosis) -> str:
    """Return pairs that these data confuse."""
    open_ones = [
        f"{placed(one.cause, one.target)} and {', '.join(one.equivalent)}" for one in found.effects if one.equivalent
    ]
    left = f" What was named is another question: not told apart are {'; '.join(open_ones)}." if open_ones else ""
    if not found.confusions:
        return paragraph(
            "Were one cause at work alone, twice as large as needed to be named, this campaign would tell it from all "
            f"others.{left}"
        )
    rows = [(*one.causes, how_apart(one.separation), f"{max(one.separation, 0.0):.1f}") for one in found.confusions]
    return paragraph(
        "If one of these causes were at work alone, twice as large as needed to be named, the other could be named in "
        f"its place.{left}"
    ) + table("Causes that look alike in these data", ("cause", "and", "told apart", "evidence apart>"), rows)


def _limits(found: Diagnosis, drawn: dict[str, str]) -> str:
    """Return limits of detection."""
    if not found.limits:
        return paragraph("No limit could be told.")
    rows = [(one.cause, two_digits(one.visible * 1e6), two_digits(one.whole * 1e6),
             catalogue()[one.cause].CAUSE.signature)
            for one in sorted(found.limits, key=lambda item: (item.whole, item.cause))]  # fmt: skip
    head = ("cause", "visible RMS, um>", "whole RMS, um>", "how it would show")
    return drawn["limits"] + table("Smallest effect that would be named", head, rows)


def _noise(found: Diagnosis, drawn: dict[str, str]) -> str:
    """Return the noise budget."""
    rows = [(name, f"{value * 1e6:.3f}", words) for name, value, words in noise_rows(found)]
    hidden = "The slow part holds what has no name as well, and so do the limits of detection."
    held = paragraph(hidden) if found.follows is not None and found.verdict == "unexplained" else ""
    return drawn["noise"] + held + table("Parts of the noise", ("noise", "standard deviation, um>", "what it is"), rows)
