"""Whether what wanders slowly in the drift is errors of the law's thermometers, which go as the length they speak for.

A thermometer that errs by b moves a law by ``(A q0 + B q) b``: where this is most of the slow noise, as in a leg of
steel, a little of it goes as the displacement does, a little more in each run, and would be a scale that is off.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from hexathermal.learn.diagnosis.steepest import believed
from hexathermal.learn.diagnosis.view import View
from hexathermal.poses import FloatArray

LIKELIER = 1.0
"""Log evidence by which the drift must rather wander as the law's thermometers do."""

POWERS = 3
"""Powers of the displacement that stand beside the law: what goes with it in all runs alike is not what wanders."""


def with_wandering(view: View) -> View:
    """Return a view whose slow noise and offsets go as ``sqrt(sum_s (A_s q0 + B_s q)^2)`` where the drift says so.

    Parameters
    ----------
    view : View
    """
    if not view.stroked or not view.moves:
        return view
    law, channel = view.base_columns, view.channel
    columns = np.column_stack([law, powers_of_place(view)])
    sizes = channel.loose(columns)
    levels, alone = channel.fitted(columns, sizes)
    A, B = channel.solved(columns, sizes, levels)[1][: law.shape[1]].reshape(2, -1)
    other = replace(view, erring=np.concatenate([A, believed(view, A, B)]))
    _, told = other.channel.fitted(columns, sizes, levels)
    return other if told > alone + LIKELIER else view


def powers_of_place(view: View) -> FloatArray:
    """Return powers of the displacement in windows, -1 to 1 over its range, shape (n, `POWERS`)."""
    place = 2.0 * (view.q - view.q.min()) / np.ptp(view.q) - 1.0
    return np.column_stack([np.empty((len(place), 0)), *(place**power for power in range(1, POWERS + 1))])
