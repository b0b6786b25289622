"""What a bench as it should be leaves of a channel, and which channels are unlike it whatever is named.

A channel of a bench whose numbers lie within their tolerances differs from the simulated one by

    foretold^2 = (t R)^2 + slow^2 + row^2,    t^2 = sum of (A W^(1/2))^2 / sum of simulated^2

with A what the numbers do to the channel in the windows of the runs that were fitted and W their prior
(`hexathermal.compare.evidence`), R the RMS of what is simulated in the runs that are judged, `slow` the slow errors of
the campaign at hand, `MOST_NOISE` times the usual ones at most, since what the bench gets wrong is no noise (of the
drift, with the scatter of its landings), and `row` the noise and the resolution of single rows.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from operator import attrgetter

import numpy as np
import numpy.typing as npt

from hexathermal.compare.bench_runs import UM, RunCurves
from hexathermal.compare.measured import MeasuredRun, near_rows
from hexathermal.compare.noise import TYPICAL, Noise
from hexathermal.compare.scores import ChannelScore, ComparedRun, channel_of
from hexathermal.compare.steps import Fit
from hexathermal.learn.cleaning_channels import SMALLEST_MOVE_M
from hexathermal.poses import FloatArray

UNLIKE, UNLIKE_IN_FEW = 2.0, 3.0
"""A channel whose RMSE, before and after, is more than so many times what is foretold is explained by no number of the
bench: in all runs together, or in those that are judged."""

MOST_NOISE = 3.0
"""Slow errors of a campaign count up to so many times the usual ones."""

AGAINST = -0.7
"""Measured and simulated drift that correlate less than this go against each other."""


def tolerated(fit: Fit) -> FloatArray:
    """Return what tolerances make of each thermocouple and the drift, RMS over that of the channel, shape (s + 1,)."""
    sensors, deviation = fit.sums.sensors, fit.sums.precision() ** -0.5
    made, whole = np.zeros(sensors + 1), np.zeros(sensors + 1)
    for simulated, table, used in zip(fit.found.simulated, fit.found.tables, fit.found.used, strict=True):
        shown = np.asarray(simulated.values[0])
        squares = np.zeros(used.size)
        squares[used] = ((table[:, :-1] * deviation) ** 2).sum(axis=1)
        made += squares.reshape(shown.shape)[: sensors + 1].sum(axis=1)
        whole += np.where(used.reshape(shown.shape), shown**2, 0.0)[: sensors + 1].sum(axis=1)
    return np.asarray(np.sqrt(made / np.maximum(whole, 1e-30)))


@dataclass(frozen=True, eq=False)
class Left:
    """What some runs leave of each channel, RMS, shape (s + 1,); K, the drift m.

    Attributes
    ----------
    before, after : array
        By the bench as it is, and with what was named.
    foretold : array
        By a bench as it should be.
    """

    before: FloatArray
    after: FloatArray
    foretold: FloatArray

    def beyond(self, times: float) -> npt.NDArray[np.bool_]:
        """Return the channels that are farther than so many times what is foretold, before as after."""
        return np.asarray(np.minimum(self.before, self.after) > times * self.foretold)


def left_of(shares: FloatArray, noise: Noise, runs: Sequence[ComparedRun], measured: Sequence[MeasuredRun]) -> Left:
    """Return what runs leave of each channel, `shares` as `tolerated`; thermocouples without a value leave nothing."""
    slow, last = _slow(noise), len(shares) - 1
    found = []
    for k, share in enumerate(shares):
        true, before, after = (_course(map(of, runs), k) for of in (_MEASURED, _BEFORE, _AFTER))
        rows = [_row_error(run, k) for run in measured]
        known = np.hypot(share * _rms(after), np.hypot(slow[int(k == last)], np.sqrt(np.mean(rows))))
        found.append((_rms(before - true), _rms(after - true), float(known)))
    return Left(*np.array(found).T)


_MEASURED, _BEFORE, _AFTER = attrgetter("measured"), attrgetter("before"), attrgetter("after")


def _course(curves: Iterable[RunCurves], k: int) -> FloatArray:
    """Return the course of a channel, run after run."""
    return np.concatenate([channel_of(one, k) for one in curves])


def _rms(values: FloatArray) -> float:
    """Return the RMS of the values that are there; 0 without any."""
    good = values[np.isfinite(values)]
    return float(np.sqrt(np.mean(good**2))) if len(good) else 0.0


def _row_error(run: MeasuredRun, k: int) -> float:
    """Return the variance of single rows of a channel: from row to row where nothing moves, and by its resolution."""
    values = run.rises[:, k] if k < run.rises.shape[1] else run.drift
    step = np.diff(values)
    near = near_rows(run.time)
    if k == run.rises.shape[1]:
        near &= np.abs(np.diff(run.row_q)) < SMALLEST_MOVE_M
    step = step[near & np.isfinite(step)]
    if not len(step):
        return 0.0
    moved = np.abs(step[step != 0.0])
    resolution = float(np.median(moved)) if len(moved) else 0.0
    return float(0.5 * np.mean(step**2) + resolution**2 / 12.0)


def _slow(noise: Noise) -> tuple[float, float]:
    """Return the slow errors of a thermocouple [K], and of the drift with its landings' scatter [m]."""
    slow, common, _time, drift, _drift_time = (MOST_NOISE * value for value in TYPICAL)
    rise = np.hypot(min(noise.slow, slow), min(noise.common, common))
    return float(rise), float(np.hypot(min(noise.drift_slow, drift), noise.scatter)) / UM


def unlike(scores: Sequence[ChannelScore], names: Sequence[str], every: Left, judged: Left) -> tuple[ChannelScore, ...]:
    """Return the channels that no number of the bench explains, the most unlike first.

    Parameters
    ----------
    scores : sequence of ChannelScore
    names : sequence of str
        Of the thermocouples, in the order of `Left`.
    every, judged : Left
        Of all runs, and of those that are judged.
    """
    far = every.beyond(UNLIKE) | judged.beyond(UNLIKE_IN_FEW)
    channels = {name for name, one in zip([*names, "drift"], far.tolist(), strict=True) if one}
    found = [one for one in scores if one.channel in channels]
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
        both = [_course(map(of, runs), k) for of in (_MEASURED, _BEFORE)]
        if all(np.ptp(one) > 0.0 for one in both) and np.asarray(np.corrcoef(both))[0, 1] < AGAINST:
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
