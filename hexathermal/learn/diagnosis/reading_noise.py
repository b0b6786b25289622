"""What noise of the law's thermometers leaves in windows of the drift, where nothing else may be as small.

A law moves by ``A q0 + B q`` for a kelvin that one reads. Smoothed over minutes, the noise of readings nearby is alike:
a drift that is measured far better than its thermometers read would look as sure as it is smooth.
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np

from hexathermal.learn.diagnosis.recorded import reading
from hexathermal.learn.diagnosis.steepest import believed
from hexathermal.learn.diagnosis.view import View


def with_reading_noise(view: View) -> View:
    """Return a view whose windows have at least the noise that the law's thermometers leave in their means [m].

    ``floor_w² = sum_s min(k mean (A_s q0 + B_s q)² noise_s², noise²) max(1, S_s / 2 t_w)``, with the part
    ``k = min(9 / (4 n), 1 / rows_w)`` that a parabola through the n rows of S_s seconds, or a longer mean, leaves of
    white noise, and `noise` what the law leaves; `t_w` since the window before: those within half a parabola err alike,
    and tell no more than one. Where rows are too far apart to be smoothed, k is 1 / rows_w, and each tells by itself.
    """
    law, channel = view.base_columns, view.channel
    sizes = channel.loose(law)
    levels = channel.fitted(law, sizes)[0]
    mean = channel.solved(law, sizes, levels)[1]
    A, B = mean.reshape(2, -1) if view.stroked else (mean, np.zeros(len(mean)))
    B = believed(view, A, B)
    total = np.zeros(len(channel))
    for name, a, b in zip(view.base, A, B, strict=True):
        _step, noise = view.once(("reading", name), partial(reading, view.runs, name), [name])
        moved = float(((a * view.length + b * view.q) ** 2).mean()) * noise**2
        left, over = view.noise_left(name), view.smoothing[name]
        since = np.where(channel.start, over, np.maximum(channel.step, 1.0))
        together = np.maximum(0.5 * over / since, 1.0) if left < 1.0 else 1.0
        total += np.minimum(moved * np.minimum(left**2, 1.0 / channel.rows), levels.rms**2) * together
    return replace(view, floor=np.sqrt(total))
