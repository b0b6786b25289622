"""What may stand off in place of a step of the zero: a few windows, a landing, or two of them."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import numpy.typing as npt

from hexathermal.learn.diagnosis.channels import Channel
from hexathermal.poses import FloatArray

BUMPS = (-3, -2, -1, 1, 2, 3)
"""So many windows before or behind a step are asked; besides them a landing there, a part of it, or the first one of
the run."""

PAIRS = 3
"""Pairs of landings after a step, one behind the other, that are asked so."""

FADES_S = (300.0, 900.0)
"""Time constants with which what was jolted may come back: a door that opened, a draught."""


def stand_offs(step: FloatArray, channel: Channel) -> tuple[list[FloatArray], list[FloatArray]]:
    """Return what may stand off in place of a step, each shape (n, 1), and pairs of landings after it, shape (n, 2).

    A few windows, a landing about its moment, or what of it comes before or behind that, where landings scatter and
    others come before and behind; or the first landing of its run, and with it, where the run counts from it, all the
    others. Two landings, the last of a run say, may stand off each by itself.
    """
    index = np.arange(len(step))[:, None]
    first = int(np.argmax(step[:, 0] > 0.0))
    landings = np.flatnonzero(np.append(channel.fresh, True))
    at = int(np.searchsorted(landings, first, "right")) - 1
    begin = int(np.flatnonzero(channel.start[: first + 1])[-1])
    spans = [(first + min(width, 0), first + max(width, 0)) for width in BUMPS]
    own, end = landings[at], landings[at + 1]
    # of a run's last landing what is left is the step itself, of its first one all but the step
    inside = channel.has_landings and begin < own and end < len(step) and not channel.start[end]
    spans += [(own, first), (first, end)] if inside else [(first, first)] * 2
    spans.append((begin, landings[landings > begin][0]))
    bumps = [((low <= index) & (index < high)).astype(float) for low, high in spans]
    if channel.zeroed_by_run:
        bumps[-1] = (channel.run == channel.run[first])[:, None] - bumps[-1]
    after = [_between(index, landings, at + k) for k in range(PAIRS + 1)]
    bumps += [_between(index, landings, max(at - 1, 0)), after[0]]
    return bumps, [np.column_stack(pair) for pair in pairwise(after)]


def fadings(step: FloatArray, channel: Channel) -> list[FloatArray]:
    """Return a step that fades in its run, by each of `FADES_S`, shape (n, 1)."""
    first = int(np.argmax(step[:, 0] > 0.0))
    since = np.cumsum(channel.step)[:, None]
    own = (channel.run == channel.run[first])[:, None] * step
    return [fading(own, since - since[first], tau) for tau in FADES_S]


def fading(step: npt.NDArray[Any], since: FloatArray, tau: float) -> FloatArray:
    """Return a step that fades with a time constant [s], from times since it began [s], each of one shape."""
    return np.asarray(step * np.exp(-np.maximum(since, 0.0) / tau))


def _between(index: npt.NDArray[np.int64], landings: npt.NDArray[np.int64], at: int) -> FloatArray:
    """Return the column of a landing, shape (n, 1); zeros where there is none."""
    if at + 1 >= len(landings):
        return np.zeros(index.shape)
    return np.asarray((landings[at] <= index) & (index < landings[at + 1]), dtype=np.float64)
