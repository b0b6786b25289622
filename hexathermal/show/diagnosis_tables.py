"""Tables of a diagnosis for the command line, and the same as plain values."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from rich.table import Table

from hexathermal.learn.diagnosis.result import Candidate, Diagnosis, Effect
from hexathermal.show.diagnosis_words import (
    effect_rows,
    how_apart,
    noise_rows,
    rounded,
    settings_words,
    span,
    visible_std,
    where,
)
from hexathermal.show.experiment_words import odds, promised, told_apart
from hexathermal.show.shares import probability
from hexathermal.show.tables import framed


def ranking_table(found: Diagnosis, pretty: bool) -> Table:
    """Return every cause that was tried, best first."""
    table = framed(
        pretty, "cause", "named", "target", "visible RMS\num>", "evidence\nlog>", "probability>", "at best with"
    )
    for k, one in enumerate(found.candidates):
        named = "yes" if k < len(found.effects) else ""
        table.add_row(one.cause, named, where(one.cause, one.target), visible_words(found, k), f"{one.evidence:z.1f}",
                      probability(one.probability), settings_words(one.settings) or "-")  # fmt: skip
    return table


def visible_words(found: Diagnosis, k: int) -> str:
    """Return what stays visible of a candidate [um], with its 95 % interval; of mended data only where named."""
    from hexathermal.learn.diagnosis.words import two_digits

    one: Candidate = found.candidates[k]
    std, value = one.spread * 1e6, one.visible * 1e6
    if k < len(found.effects) and not math.isfinite(std):
        std = visible_std(found.effects[k]) * 1e6
    return f"{rounded(value, std)} ({span(value, std, positive=True)})" if math.isfinite(std) else two_digits(value)


def verdict_probability(verdict: str, effects: int, value: float) -> str:
    """Return the probability of a verdict, in words that say what it is of.

    Examples
    --------
    >>> verdict_probability("none", 0, 0.62)
    'probability 0.620 that nothing of a quarter of the noise or more is there'
    """
    if verdict == "none":
        return f"probability {probability(value)} that nothing of a quarter of the noise or more is there"
    return f"{'the first with ' if effects > 1 else ''}probability {probability(value)}"


def effects_table(found: Diagnosis, pretty: bool) -> Table:
    """Return the causes that were named, with their parameters."""
    table = framed(pretty, "named", "target", "parameter", "value>", "standard\nuncertainty>", "95 % interval", "unit",
                   "probability>", "not ruled out", "joins\nthe law")  # fmt: skip
    for one in found.effects:
        for k, row in enumerate(effect_rows(one, found.law.kind) or [("-",) * 5]):
            head = (one.cause, one.target or "-") if k == 0 else ("", "")
            tail = (probability(one.probability), ", ".join(one.equivalent) or "none other",
                    joined_words(one)) if k == 0 else ("", "", "")  # fmt: skip
            table.add_row(*head, *row, *tail)
    return table


def joined_words(one: Effect) -> str:
    """Return whether a cause joined the law; a step of the zero is no term: at most its run is freed of it."""
    if one.taken_back:
        return "taken back"
    if one.of_judged_run or (one.cause == "zero-jump" and (one.joined or one.refused)):
        return "no term"
    return "yes" if one.joined else "no"


def limits_table(found: Diagnosis, pretty: bool) -> Table:
    """Return how large each effect must be in this campaign to be named, smallest first."""
    from hexathermal.learn.diagnosis.words import two_digits

    table = framed(pretty, "would be named from", "visible RMS\num>", "whole RMS\num>")
    for one in sorted(found.limits, key=lambda item: (item.whole, item.cause)):
        table.add_row(one.cause, two_digits(one.visible * 1e6), two_digits(one.whole * 1e6))
    return table


def confusions_table(found: Diagnosis, pretty: bool) -> Table:
    """Return the pairs of causes that this campaign would confuse."""
    table = framed(pretty, "these data confuse", "with", "evidence apart\nlog>", "told apart")
    for one in found.confusions:
        table.add_row(*one.causes, f"{max(one.separation, 0.0):z.1f}", how_apart(one.separation))
    return table


def experiments_table(found: Diagnosis, pretty: bool) -> Table:
    """Return what to measure next and what it promises."""
    from hexathermal.learn.diagnosis.words import two_digits

    table = framed(pretty, "next", "experiment", "tells apart", "for an effect of\num>", "promised\nlog>", "odds")
    for k, one in enumerate(found.experiments):
        size = two_digits(one.size * 1e6) if one.size > 0.0 else "-"
        table.add_row(f"{k + 1}", one.words, told_apart(one), size, promised(one), odds(one.separation))
    return table


def noise_table(found: Diagnosis, pretty: bool) -> Table:
    """Return the noise that is left in the end."""
    table = framed(pretty, "noise", "standard deviation\num>", "what it is")
    for name, value, words in noise_rows(found):
        table.add_row(name, f"{value * 1e6:z.3f}", words)
    return table


def diagnosis_facts(found: Diagnosis) -> dict[str, Any]:
    """Return a diagnosis as plain values, ready for JSON."""
    told: dict[str, Any] = plain(found.to_json())
    return told


def plain(value: Any) -> Any:
    """Return plain values of a nested answer: numbers that are none become null, arrays lists.

    Examples
    --------
    >>> plain({"a": np.float64(np.nan), "b": (np.int64(2), "x")})
    {'a': None, 'b': [2, 'x']}
    """
    if isinstance(value, Mapping):
        return {str(name): plain(item) for name, item in value.items()}
    if isinstance(value, list | tuple | np.ndarray):
        return [plain(item) for item in value]
    if isinstance(value, np.generic):
        value = value.item()
    return None if isinstance(value, float) and not math.isfinite(value) else value
