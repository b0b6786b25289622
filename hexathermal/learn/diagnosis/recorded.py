"""What a campaign did record: sensors and inputs without values are not looked at, and the reader is told."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np

from hexathermal.errors import ArgumentError, DataError
from hexathermal.learn.campaign_clocks import SLOWEST_S, long_words
from hexathermal.learn.cleaning_rules import TO_SIGMA
from hexathermal.learn.law import IdentifiedLaw
from hexathermal.learn.signals import RunRows
from hexathermal.machine.leg_signals import WORDS


def silent_sensors(runs: Iterable[RunRows]) -> tuple[str, ...]:
    """Return the thermometers that have no values at all in one run or more."""
    names = (name for rows in runs for name, values in rows.signals.dT.items() if not np.isfinite(values).all())
    return tuple(dict.fromkeys(names))


NOISY = 5.0
"""Noise of a thermometer over the middle one of all from which on it is not trusted to say what moves a part."""


MOST_STEPS = 6.0
"""A reading that bends by more steps from row to row is one whose temperature jumps."""


def row_noise(runs: Iterable[RunRows], sensor: str) -> float:
    """Return a thermometer's noise from row to row, standard deviation [K].

    By the median of second differences: beside a nut or a motor the temperature itself jumps now and then. A reading in
    coarse steps mostly stays, and is told by all its differences.
    """
    values = [rows.signals.dT[sensor] for rows in runs]
    bend = float(np.median(np.abs(np.concatenate([np.diff(one, 2) for one in values]))))
    if bend > 0.0:
        return float(TO_SIGMA * bend / np.sqrt(6.0))
    return float(np.sqrt(np.mean(np.concatenate([np.diff(one) for one in values]) ** 2) / 2.0))


def reading(runs: Sequence[RunRows], sensor: str) -> tuple[float, float]:
    """Return a thermometer's resolution, as far as its noise does not make up for it, and its noise [K].

    Noise of variance s^2 leaves ``exp(-2 pi^2 s^2 / step^2)`` of what steps hide of a mean (Widrow and Kollar,
    Quantization Noise, 2008, chapter 19). Second differences of the reading show 6 times s^2 and what steps add to it,
    step^2 / 12; where the reading mostly stays, they show less than that.
    """
    values = [rows.signals.dT[sensor] for rows in runs]
    steps = np.diff(np.unique(np.round(np.concatenate(values), 6)))
    noise = row_noise(runs, sensor)
    if not len(steps):
        return 0.0, noise
    step = float(np.quantile(steps, 0.1))
    bends = np.clip(np.concatenate([np.diff(one, 2) for one in values]) / step, -MOST_STEPS, MOST_STEPS)
    dither = max(float((bends**2).mean()) / 6.0 - 1.0 / 12.0, 0.0) if len(bends) else 0.0
    return step * float(np.exp(-2.0 * np.pi**2 * dither)), noise


def noisy_sensors(runs: Sequence[RunRows], sensors: Sequence[str]) -> dict[str, tuple[float, float]]:
    """Return the thermometers that are far noisier than the others: their noise [K], and its ratio to the middle one.

    Smoothed over a window such a reading fits much; a law that reads it row by row brings its noise into the drift.
    """
    noise = {name: row_noise(runs, name) for name in sensors}
    usual = float(np.median(list(noise.values()))) if noise else 0.0
    return {name: (value, value / usual) for name, value in noise.items() if value > NOISY * usual > 0.0}


def silent_inputs(runs: Iterable[RunRows]) -> tuple[str, ...]:
    """Return the recorded inputs that have no values at all in one run or more."""
    names = (name for rows in runs for name, values in rows.signals.inputs.items() if not np.isfinite(values).all())
    return tuple(dict.fromkeys(names))


def without_inputs(rows: RunRows, names: Sequence[str]) -> RunRows:
    """Return a run without some of its inputs."""
    if not names:
        return rows
    kept = {name: values for name, values in rows.signals.inputs.items() if name not in names}
    return replace(rows, signals=replace(rows.signals, inputs=kept))


def refuse_silent(runs: Iterable[RunRows], sensors: Sequence[str]) -> None:
    """Refuse runs in which a sensor of the law has no values."""
    for rows in runs:
        lost = [name for name in silent_sensors([rows]) if name in sensors]
        if lost:
            raise DataError(
                f"sensor {lost[0]} of the law has no values in run {rows.run.name}: choose another with --sensors, or "
                "take that run out of campaign.toml"
            )


def refuse_slow(runs: Sequence[RunRows]) -> None:
    """Refuse runs whose rows come so seldom that no cause could be told by them: their times are in another unit."""
    slowest = min((rows.record.sampling for rows in runs), default=0.0)
    if slowest > SLOWEST_S:
        raise DataError(
            f"one row every {long_words(slowest)} in every run for identification: is time_s in milliseconds? Causes "
            f"act within minutes and hours, which rows {long_words(SLOWEST_S)} apart at most can tell: mend time_s"
        )


def judged_runs(runs: Sequence[RunRows], laws: Sequence[IdentifiedLaw]) -> tuple[list[RunRows], list[str]]:
    """Return the runs in which everything that laws read has values, and the names of the others."""
    good, mute = list[RunRows](), list[str]()
    for rows in runs:
        if all(_readable(rows, law) for law in laws):
            good.append(rows)
        else:
            mute.append(rows.run.name)
    return good, mute


def _readable(rows: RunRows, law: IdentifiedLaw) -> bool:
    """Return whether a law says something of every row."""
    if law.stroked and rows.usable.q is None:
        return False
    try:
        return bool(np.isfinite(law.predict_signals(rows.signals, run=rows.run.name)).all())
    except ArgumentError:
        return False


def partly_recorded(runs: Sequence[RunRows]) -> list[str]:
    """Return what some of the runs that are searched do not record and others do, in words."""
    found: dict[str, str] = {}
    for name in ("air", "index", "tilt"):
        without = [rows.run.name for rows in runs if getattr(rows.signals, name) is None]
        if 0 < len(without) < len(runs):
            found.setdefault(", ".join(without), WORDS[name])
    return [
        f"not recorded in {names} of {len(runs)} runs, but in others: {words}; what needs it is looked for nowhere; "
        f"take {names} out of campaign.toml, or add the columns"
        for names, words in found.items()
    ]


def silence_words(runs: Sequence[RunRows]) -> list[str]:
    """Return notes on what has no values in the runs that are searched, and on what is too noisy."""
    sensors, inputs = silent_sensors(runs), silent_inputs(runs)
    found = [f"not looked at, without values in a run: {', '.join(sensors)}"] if sensors else []
    spoken = [name for name in runs[0].signals.dT if name not in sensors] if runs else []
    found += [
        f"{name} is not trusted: its noise from row to row is {noise:.2g} K, {ratio:.0f} times the usual one here; it "
        "is not tried as a missing sensor"
        for name, (noise, ratio) in noisy_sensors(runs, spoken).items()
        if name != runs[0].air_sensor  # the air is never at rest
    ]
    return found + ([f"recorded inputs without values in a run: {', '.join(inputs)}"] if inputs else [])
