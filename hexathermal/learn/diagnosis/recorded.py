"""What a campaign did record: sensors and inputs without values are not looked at, and the reader is told."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np

from hexathermal.errors import ArgumentError
from hexathermal.learn.law import IdentifiedLaw
from hexathermal.learn.signals import RunRows


def silent_sensors(runs: Iterable[RunRows]) -> tuple[str, ...]:
    """Return the thermometers that have no values at all in one run or more."""
    names = (name for rows in runs for name, values in rows.signals.dT.items() if not np.isfinite(values).all())
    return tuple(dict.fromkeys(names))


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
            raise ArgumentError(
                f"sensor {lost[0]} of the law has no values in run {rows.run.name}: choose another with --sensors, or "
                "take that run out of campaign.toml"
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
    try:
        return bool(np.isfinite(law.predict_signals(rows.signals, run=rows.run.name)).all())
    except ArgumentError:
        return False


def silence_words(runs: Sequence[RunRows]) -> list[str]:
    """Return notes on what has no values in the runs that are searched."""
    sensors, inputs = silent_sensors(runs), silent_inputs(runs)
    found = [f"not looked at, without values in a run: {', '.join(sensors)}"] if sensors else []
    return found + ([f"recorded inputs without values in a run: {', '.join(inputs)}"] if inputs else [])
