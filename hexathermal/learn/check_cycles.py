"""What swings with one period in a campaign: a cycle of the room or of a cooler, or what a recorded cause makes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from hexathermal.learn.check import CampaignCheck, RunCheck
from hexathermal.learn.check_sums import Trace
from hexathermal.poses import FloatArray

CYCLE_SHARE = 0.35
"""Share of a temperature's swing, trend taken off, that one period must have to be called a cycle."""

CYCLE_NOISES = 5.0
"""A cycle's amplitude is larger than so many noises of the sensor."""

LEAST_ROWS = 64

COHERENT, CHANCE = 0.6, 0.01
"""Coherence from which a recorded cause makes a cycle, and the largest probability that chance makes as much."""


INDEPENDENT = 3
"""Of the five coefficients of a band under a Hann window about so many are independent."""


@dataclass(frozen=True)
class Cycle:
    """A temperature that swings, medians over the runs that show it.

    Attributes
    ----------
    sensor : str
    period : float [s]
    amplitude : float [K]
    runs : int
        That show it.
    input : str
        Which input, or motion of the rod, swings with it, run by run the same way; nothing where none does.
    moved : bool
        Whether the part has a rod that moves.
    """

    sensor: str
    period: float
    amplitude: float
    runs: int
    input: str = ""
    moved: bool = False

    @property
    def cause(self) -> str:
        """What makes it, in words."""
        if self.input:
            return f"{self.input} changes in that rhythm: heat of the part's own, no cycle of the room"
        return "a cycle of the room or of a cooler" + ", or of the movements" * self.moved


@dataclass(frozen=True, eq=False)
class _Spectrum:
    """Fourier coefficients of a run's trace less a cubic, under a Hann window: frequency [Hz], complex values."""

    frequency: FloatArray
    values: npt.NDArray[np.complex128]

    def power(self) -> FloatArray:
        """Return the power in the trace's unit, squared per Hz but for a constant."""
        return np.asarray(np.square(np.abs(self.values)))


def cycles(check: CampaignCheck) -> tuple[Cycle, ...]:
    """Return the sensors that swing with one period in half of the runs or more, as a room does by its conditioning.

    Each run's temperature less a cubic in time is taken apart by a periodogram; its strongest period counts where it
    makes up `CYCLE_SHARE` of the variance and fits into the run four times. A recorded cause makes a cycle that is
    coherent with it over the runs, ``|sum S I*|^2 / (sum |S|^2 sum |I|^2) > COHERENT`` with the Fourier coefficients
    ``S`` and ``I`` about that period, as chance makes it in one of a hundred campaigns only.
    """
    found = []
    for k, sensor in enumerate(check.campaign.sensors):
        tops = {j: item for j, run in enumerate(check.runs) if (item := _cycle(run, k)) is not None}
        if tops and len(tops) >= 0.5 * len(check.runs):
            period, amplitude = np.median([item[:2] for item in tops.values()], axis=0)
            if amplitude > CYCLE_NOISES * check.sensor_noise[k]:
                bands = [(check.runs[j], item[2]) for j, item in tops.items()]
                moved = any(run.q is not None and run.q[0] < run.q[1] for run in check.runs)
                driver = _driver(check, k, bands)
                found.append(Cycle(sensor, float(period), float(amplitude), len(tops), driver, moved))
    return tuple(found)


def _spectrum(time: FloatArray, value: FloatArray) -> _Spectrum | None:
    """Return the spectrum of a trace, or None of too few rows."""
    good = np.isfinite(value)
    if good.sum() < LEAST_ROWS:
        return None
    even = np.linspace(time[0], time[-1], int(good.sum()))
    value = np.interp(even, time[good], value[good])
    scaled = np.linspace(-1.0, 1.0, len(even))
    value = value - np.polynomial.Polynomial.fit(scaled, value, 3)(scaled)
    # periodic, as spectral windows are
    window = 0.5 - 0.5 * np.cos(2.0 * np.pi * np.arange(len(even)) / len(even))
    values = np.fft.rfft(window * value) * np.sqrt(2.0 / np.square(window).sum() * (even[1] - even[0]))
    return _Spectrum(np.fft.rfftfreq(len(even), even[1] - even[0]), values)


def _cycle(run: RunCheck, k: int) -> tuple[float, float, slice] | None:
    """Return period [s], amplitude [K] and the band of a sensor's cycle in a run, or None."""
    found = _spectrum(run.trace.time, run.trace.dT[:, k])
    if found is None:
        return None
    frequency, power = found.frequency, found.power()
    low = int(np.searchsorted(frequency, 4.0 / (run.trace.time[-1] - run.trace.time[0])))
    if low >= len(power) - 2 or not power.any():
        return None
    top = low + int(np.argmax(power[low:]))
    band = slice(max(top - 2, 1), top + 3)
    if top <= low or power[band].sum() < CYCLE_SHARE * power[1:].sum():
        return None
    return float(1.0 / frequency[top]), float(np.sqrt(2.0 * power[band].sum() * frequency[1])), band


def _driver(check: CampaignCheck, k: int, bands: list[tuple[RunCheck, slice]]) -> str:
    """Return the recorded cause that is most coherent with a sensor's cycle; nothing where none is."""
    best, name = 0.0, ""
    for j, cause in enumerate(_causes(check)):
        coherence, count = _coherence(k, j, bands)
        if coherence > max(best, COHERENT) and (1.0 - coherence) ** (count - 1) < CHANCE:
            best, name = coherence, cause
    return name


def _causes(check: CampaignCheck) -> tuple[str, ...]:
    """Return the names of the columns of `_recorded`."""
    moved = any(run.trace.q is not None for run in check.runs)
    return (*(one.name for one in check.campaign.inputs), *(("the rod's place", "the rod's travel") if moved else ()))


def _recorded(trace: Trace) -> FloatArray:
    """Return what is recorded of causes: inputs, and place and travel of the rod where there is one."""
    if trace.q is None:
        return trace.inputs
    return np.column_stack([trace.inputs, trace.q, np.abs(np.diff(trace.q, prepend=trace.q[0]))])


def _coherence(k: int, j: int, bands: list[tuple[RunCheck, slice]]) -> tuple[float, int]:
    """Return the coherence of a sensor's cycle with a cause over runs, and of how many independent coefficients."""
    both, own, other, count = 0.0 + 0.0j, 0.0, 0.0, 0
    for run, band in bands:
        heat, cause = run.trace.dT[:, k], _recorded(run.trace)[:, j]
        known = np.isfinite(heat) & np.isfinite(cause)
        swing = _spectrum(run.trace.time, np.where(known, heat, np.nan))
        driving = _spectrum(run.trace.time, np.where(known, cause, np.nan))
        if swing is None or driving is None or not driving.values[band].any():
            continue
        s, c = swing.values[band], driving.values[band]
        both += complex(np.vdot(c, s))
        own += float(np.square(np.abs(s)).sum())
        other += float(np.square(np.abs(c)).sum())
        count += INDEPENDENT
    return (abs(both) ** 2 / (own * other) if own * other > 0.0 else 0.0), count
