"""What an extended law gains on runs never fitted, in words."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from hexathermal.show.diagnosis_words import changed
from hexathermal.show.shares import less, proven

if TYPE_CHECKING:
    from hexathermal.learn.diagnosis.result import Diagnosis

SHIFTED = 0.75
"""Part of the RMSE below which what a law leaves beside a constant in each run is told."""

FEWEST_JUDGED = 3
"""Fewer runs for validation hardly tell how much runs differ."""


def gain_words(found: Diagnosis) -> str:
    """Return what the extended law gains on runs for validation, in words."""
    if found.gain is None:
        return "There are no runs for validation that could be judged: what the extended law gains is not known."
    one = found.gain.total
    before, after, part = one.rmse_before * 1e6, one.rmse_after.value * 1e6, one.rmse_gain
    if not changed(found):
        said = f"On runs never fitted the law leaves an RMSE of {before:.3f} um; nothing joined it"
        said += refused_words(found) or zero_words(found)
    else:
        said = (
            f"On runs never fitted the extended law brings the RMSE from {before:.3f} to {after:.3f} um ({less(part)}"
        )
        said += f"; {proven(part)})" + refused_words(found)
    if found.reachable is not None and math.isfinite(found.reachable):
        free = f"{found.reachable * 1e6:.3f} um"
        beaten = found.reachable > found.gain.total.rmse_after.value
        said += f"; a free fit of all channels {f'does no better: {free}' if beaten else f'reaches {free}'}"
    skipped = found.gain.skipped
    judged = len(found.gain.runs)
    few = changed(found) and judged < FEWEST_JUDGED
    runs = "one run" if judged == 1 else f"{judged} runs"
    said += f". That is of {runs}; three or more tell how much runs differ" if few else ""
    said += f".{shifted_words(found)}{use_words(found)}"
    return said + (f" Not compared, rows differ: {', '.join(skipped)}." if skipped else "")


def use_words(found: Diagnosis) -> str:
    """Return whether to use an extended law, where its gain is not beyond doubt; else nothing."""
    if found.gain is None or found.gain.proven or not changed(found):
        return ""
    part = found.gain.total.rmse_gain
    if part.value <= 0.0:
        return " On these runs it is no better: do not use it before more runs for validation say otherwise."
    unsure = "hold 0 in the interval of its gain" if math.isfinite(part.low) else "give its gain no interval"
    return f" These runs, never fitted, {unsure}: measure more for validation before you rely on it."


def zero_words(found: Diagnosis) -> str:
    """Return what a law leaves beside a constant in each run, where that is much less; else nothing."""
    one = found.beside_constants
    if one is None or found.gain is None or one.rmse_before > SHIFTED * found.gain.total.rmse_before:
        return ""
    return (
        "; beside a constant in each run, which the noise of its first row shifts as a whole, means over minutes leave "
        f"{one.rmse_before * 1e6:.3f} um"
    )


def refused_words(found: Diagnosis) -> str:
    """Return by how much a law would foretell runs never fitted worse with what stays out of it; else nothing."""
    if found.refused is None:
        return ""
    lost, beside = found.refused.gain.total, found.refused.beside
    said = f"; with what stays out, too, it would leave {lost.rmse_after.value * 1e6:.3f} um ({less(lost.rmse_gain)})"
    if beside is None:
        return said
    return (
        f"{said}, {'but' if found.refused.better_beside else 'and'} beside a constant in each run, which the noise of "
        f"its first row shifts as a whole, {beside.rmse_after * 1e6:.3f} instead of {beside.rmse_before * 1e6:.3f} um: "
        + ("more runs for validation decide" if found.refused.better_beside else "it does not pay")
    )


def shifted_words(found: Diagnosis) -> str:
    """Return what the gain is beside a constant in each run, where it is not beyond doubt as it stands; else nothing.

    Each run counts from its own first row, whose noise shifts all others, so that few runs may lose by what they gain.
    """
    one = found.beside_constants
    if one is None or found.gain is None or not changed(found) or found.gain.proven:
        return ""
    return (
        " The noise of its first row shifts a run as a whole, whatever the law; beside a constant in each run the RMSE "
        f"of means over minutes goes from {one.rmse_before * 1e6:.3f} to {one.rmse_after * 1e6:.3f} um, and falls in "
        f"{one.falls} of {one.runs} runs."
    )
