"""A cause that errors of the thermometers must take back again is none: what is left of the law would be larger.

What is visible of an effect stands, with the noise and those errors, in what the law alone leaves. An effect several
times as large as that is one half of a pair that cancels: a thermometer that is late by more than all of it, say, and
as large a disbelief of what it and the others read apart.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from hexathermal.learn.diagnosis.channels import Channel, Levels
from hexathermal.learn.diagnosis.evidence import Base, Scored

CANCELLED = 1.75
"""Times what the law alone leaves, RMS, from which on so large an effect is one half of what cancels: of 105 true ones
of four generators the largest has 1.07; of clocks and exchanged plugs, whose data are mended, 2.2."""


def not_cancelled(channel: Channel, base: Base, levels: Levels, scored: Sequence[Scored]) -> list[Scored]:
    """Return trials as the drift speaks for them: not for columns larger than `CANCELLED` times what the law leaves.

    Parameters
    ----------
    channel : Channel
        The drift in windows.
    base : Base
        Of which the law, and what joined it, are the first columns.
    levels : Levels
        Noise of the drift.
    scored : sequence of Scored
    """
    first = slice(base.plain)
    _, mean = channel.solved(base.X[:, first], base.sd[first], channel.plain(levels))
    most = CANCELLED * float(np.sqrt(((channel.y - base.X[:, first] @ mean) ** 2).mean()))
    return [replace(item, value=min(item.value, 0.0)) if item.visible > most and item.trial.base is None else item
            for item in scored]  # fmt: skip
