"""A cause that errors of the thermometers must take back again is none: what is left of the law would be larger.

What is visible of an effect stands, with the noise and those errors, in what the law alone leaves. An effect that is
much larger is one half of a pair that cancels: a thermometer that is late by more than all of it, say, and
as large a disbelief of what it and the others read apart.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from hexathermal.learn.diagnosis.channels import Channel, Levels
from hexathermal.learn.diagnosis.evidence import Base, Scored

CANCELLED = 1.75
"""Times what the law alone leaves, RMS, from which on so large an effect is one half of what cancels: of 105 true ones
of four generators the largest has 1.07; of clocks and exchanged plugs, whose data are mended, 2.2."""


def most_visible(channel: Channel, base: Base, levels: Levels) -> float:
    """Return `CANCELLED` times what the law alone leaves of the drift, RMS [m].

    Parameters
    ----------
    channel : Channel
        The drift in windows.
    base : Base
        Of which the law, and what joined it, are the first columns.
    levels : Levels
        Noise of the drift.
    """
    first = slice(base.plain)
    _, mean = channel.solved(base.X[:, first], base.sd[first], channel.plain(levels))
    return CANCELLED * float(np.sqrt(((channel.y - base.X[:, first] @ mean) ** 2).mean()))


def cancels(scored: Scored, most: float) -> bool:
    """Return whether columns of a trial show more than `most` [m]: the drift says nothing for it then."""
    return scored.visible > most and scored.trial.base is None


def all_not_cancelled(scored: list[Scored], most: float) -> list[Scored]:
    """Return trials as the drift speaks for them, see `cancels`."""
    return [replace(item, value=min(item.value, 0.0)) if cancels(item, most) else item for item in scored]
