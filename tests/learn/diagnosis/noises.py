"""Channels made up for tests, and their noise as dense matrices: the oracle of the compiled filter."""

from __future__ import annotations

import numpy as np

from hexathermal.learn.diagnosis.channels import Channel, Levels
from hexathermal.poses import FloatArray

LEVELS = Levels(0.2, 0.15, 0.3, 0.39, 2400.0)


def channel_like(
    rng: np.random.Generator,
    runs: int = 3,
    windows: int = 30,
    *,
    tied_offsets: bool = True,
    walks: bool = True,
    shows: bool = False,
) -> Channel:
    """A channel of runs whose windows and landings are of random length; its values are zero.

    With `shows` windows show half to one and a half of what wanders, and have a least noise, each its own.
    """
    parts = []
    for k in range(runs):
        fresh = rng.random(windows) < 0.4
        fresh[0] = True
        step = np.concatenate([[0.0], rng.uniform(30.0, 900.0, windows - 1)])
        parts.append(
            (np.arange(windows) == 0, fresh, step, rng.integers(1, 25, windows).astype(float), np.full(windows, k))
        )
    start, fresh, step, rows, run = (np.concatenate(items) for items in zip(*parts, strict=True))
    n = len(start)
    shown = rng.uniform(0.5, 1.5, n) if shows else None
    floor = rng.uniform(0.0, 0.3, n) if shows else None
    return Channel(np.zeros(n), start, fresh, step, rows, run, True, tied_offsets, True, shown, floor, walks)


def dense(channel: Channel, levels: Levels) -> FloatArray:
    """The covariance of a channel's noise, shape (n, n), written down part by part.

    Where what wanders walks from each run's first row on, the offset goes against what the slow process is there.
    """
    run, landing = channel.run, np.cumsum(channel.fresh)
    time = np.cumsum(channel.step)
    same_run, same_landing = run[:, None] == run[None, :], landing[:, None] == landing[None, :]
    V = levels.slow**2 * np.exp(-np.abs(time[:, None] - time[None, :]) / levels.slow_time) + levels.offset**2
    if channel.walks:
        begun = np.exp(-(time - time[channel.start][run]) / levels.slow_time)
        V -= min(levels.slow, levels.offset) ** 2 * (begun[:, None] + begun[None, :])
    V = V * same_run * np.outer(channel.wander, channel.wander) + levels.landing**2 * same_landing
    least = 0.0 if channel.floor is None else channel.floor**2
    return np.asarray(V + np.diag(levels.white**2 / channel.rows + least))


def noisy(channel: Channel, levels: Levels, rng: np.random.Generator) -> Channel:
    """The channel with a draw of its noise as values."""
    return channel.with_y(np.linalg.cholesky(dense(channel, levels)) @ rng.standard_normal(len(channel)))
