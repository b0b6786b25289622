"""What a bench as it should be leaves of a channel, and which channels are unlike it whatever is named.

A channel of a bench whose numbers lie within their tolerances differs from the simulated one by

    foretold^2 = (t R)^2 + noise^2,    t^2 = sum of (A W^(1/2))^2 / sum of simulated^2

with A what the numbers do to the channel in the windows of the runs that were fitted and W their prior
(`hexathermal.compare.evidence`), R the RMS of what is simulated in the runs that are judged, and the slow errors of the
campaign at hand, `MOST_NOISE` times the usual ones at most: what the bench gets wrong is not taken for noise.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hexathermal.compare.bench_runs import UM
from hexathermal.compare.evidence import CONTACT_SD, GAIN_SD
from hexathermal.compare.noise import TYPICAL, Noise
from hexathermal.compare.parameters import TOLERANCES
from hexathermal.compare.scores import ChannelScore, ComparedRun, channel_of
from hexathermal.compare.steps import Fit
from hexathermal.poses import FloatArray

UNLIKE = 2.0
"""A channel whose RMSE is more than so many times what is foretold is explained by no number of the bench."""

MOST_NOISE = 3.0
"""Slow errors of a campaign count up to so many times the usual ones."""

AGAINST = -0.7
"""Measured and simulated drift that correlate less than this go against each other."""


def tolerated(fit: Fit) -> FloatArray:
    """Return what tolerances make of each thermocouple and the drift, RMS over that of the channel, shape (s + 1,)."""
    sensors = fit.sums.sensors
    deviation = np.concatenate([TOLERANCES, np.full(sensors, CONTACT_SD), np.full(sensors, GAIN_SD)])
    made, whole = np.zeros(sensors + 1), np.zeros(sensors + 1)
    for simulated, table, used in zip(fit.found.simulated, fit.found.tables, fit.found.used, strict=True):
        shown = np.asarray(simulated.values[0])
        squares = np.zeros(used.size)
        squares[used] = ((table[:, :-1] * deviation) ** 2).sum(axis=1)
        made += squares.reshape(shown.shape)[: sensors + 1].sum(axis=1)
        whole += np.where(used.reshape(shown.shape), shown**2, 0.0)[: sensors + 1].sum(axis=1)
    return np.asarray(np.sqrt(made / np.maximum(whole, 1e-30)))


def foretold(fit: Fit, runs: Sequence[ComparedRun]) -> FloatArray:
    """Return the RMS that a bench as it should be leaves of each channel in runs, shape (s + 1,); K, the drift m."""
    shares, noise = tolerated(fit), _slow(fit.noise)
    found = []
    for k, share in enumerate(shares):
        shown = np.concatenate([channel_of(run.after, k) for run in runs])
        slow = noise[0] if k < len(shares) - 1 else noise[1]
        found.append(np.hypot(share * np.sqrt(np.mean(shown**2)), slow))
    return np.array(found)


def _slow(noise: Noise) -> tuple[float, float]:
    """Return the slow errors of a thermocouple [K] and of the drift [m] that count."""
    slow, common, _time, drift, _drift_time = (MOST_NOISE * value for value in TYPICAL)
    rise = np.hypot(min(noise.slow, slow), min(noise.common, common))
    return float(rise), float(np.hypot(min(noise.drift_slow, drift), noise.scatter)) / UM


def unlike(scores: Sequence[ChannelScore]) -> tuple[ChannelScore, ...]:
    """Return the channels that no number of the bench explains, the most unlike first."""
    found = [one for one in scores if one.rmse_after > UNLIKE * one.foretold]
    return tuple(sorted(found, key=lambda one: -one.rmse_after / one.foretold))


def unlike_words(channels: Sequence[ChannelScore], role: str) -> str:
    """Return channels that no number explains, in words: the first three with what they leave."""
    told = [_left(one) for one in channels[:3]]
    more = f", and {len(channels) - 3} more (see the table)" if len(channels) > 3 else ""
    return f"an RMSE of {'; '.join(told)}{more}, on the runs for {role}"


def _left(one: ChannelScore) -> str:
    """Return what a channel leaves, in words."""
    factor, unit, digits = (1e6, "um", 2) if one.channel == "drift" else (1.0, "K", 3)
    left, known = (f"{value * factor:.{digits}f} {unit}" for value in (one.rmse_after, one.foretold))
    return f"{left} in {one.channel} where {known} is foretold"


def unlike_notes(channels: Sequence[ChannelScore], runs: Sequence[ComparedRun]) -> list[str]:
    """Return what to look at where channels are unlike the bench."""
    notes = []
    if any(one.channel == "drift" for one in channels):
        k = runs[0].measured.rises.shape[1]
        both = [np.concatenate([channel_of(curves, k) for curves in part])
                for part in ([run.measured for run in runs], [run.before for run in runs])]  # fmt: skip
        if all(np.ptp(one) > 0.0 for one in both) and np.corrcoef(both)[0, 1] < AGAINST:
            notes.append("the measured drift goes against the simulated: have the beams the other sign?")
    names = [one.channel for one in channels if one.channel != "drift"]
    if names and len(names) <= max(runs[0].measured.rises.shape[1] // 2, 1):
        notes.append(
            f"{names[0]}: does it sit where the campaign says, on its own plug, and firmly?"
            if len(names) == 1
            else f"{', '.join(names)}: do they sit where the campaign says, each on its own plug, and firmly?"
        )
    if channels:
        notes.append("'hexathermal diagnose' looks for faults of thermometers, beams and clocks, which no bench has")
    return notes
