"""Which thermometer hangs in the room, where no column records the air and no part says so.

What moves warms a part, and its thermometers show it; one that hangs in the room hardly answers. Where motion and
recorded inputs, behind low passes, tell most of what the others read since each run began, and little of what one
reads, that one reads the room: ``1 - |T - x b|^2 / |T|^2`` is far below the middle one of all. A frame far from all
that warms answers as little, and follows the room slowly: of several the one that changes most within minutes is
taken.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from hexathermal.learn.campaign import Campaign
from hexathermal.learn.diagnosis.common_error import answers, outside, warming
from hexathermal.learn.diagnosis.stage import view_of
from hexathermal.learn.diagnosis.view import View
from hexathermal.learn.signals import RunRows
from hexathermal.poses import FloatArray

FEWEST = 3
"""Thermometers outside the law that are needed: one is told by what the others do."""

LEAST_WARMED, APART, LEAST_GAP = 0.4, 0.75, 0.1
"""Part of its squares that heat must tell of the middle thermometer; the most of this part that it may tell of one in
the room; and what it must tell more of all others than of those, or some are only farther from what warms."""

QUICKLY_S = 600.0
"""Time within which a room changes and a frame hardly does."""


def in_the_room(campaign: Campaign, runs: Sequence[RunRows], base: tuple[str, ...]) -> str | None:
    """Return the thermometer of a part that hangs in the room by what it reads; None where none clearly does.

    One whose part is stated sits on that. Where any run records the air, or one is said to hang there, none is sought.

    Parameters
    ----------
    campaign : Campaign
    runs : sequence of RunRows
    base : tuple of str
        The law's thermometers, which sit on the part.
    """
    told_else = campaign.air_thermometer is not None or any(rows.signals.air is not None for rows in runs)
    if campaign.kind != "component" or told_else:
        return None
    view = view_of(campaign, runs, base)
    sensors = [name for name in outside(view) if answers(view, name)]
    if len(sensors) < FEWEST:
        return None
    told = _told_by_heat(view, sensors)
    order, middle = np.argsort(told), float(np.median(told))
    gaps = np.diff(told[order]) * (told[order][:-1] < APART * middle)
    if middle < LEAST_WARMED or gaps.max() < LEAST_GAP:
        return None
    sitting = {one.name for one in campaign.thermocouples if one.part}
    apart = [sensors[k] for k in order[: int(np.argmax(gaps)) + 1]]
    free = [name for name in apart if name not in sitting]
    return max(free, key=lambda name: _quick_change(view, name), default=None)


def _told_by_heat(view: View, sensors: Sequence[str]) -> FloatArray:
    """Return the part of each thermometer's squares that motion and inputs tell, since each run's begin, shape (s,)."""
    heats = [np.column_stack(list(warming(signals, memory, airy=False)))
             for signals, memory in zip(view.signals, view.rows.memories(), strict=True)]  # fmt: skip
    X, T = (_since_begin(view, view.windows(tables)) for tables in (heats, view.tables(sensors)))
    size = np.sqrt((X**2).mean(axis=0))
    X = X[:, size > 0.0] / size[size > 0.0]
    left = T - X @ np.linalg.lstsq(X, T, rcond=1e-6)[0]
    return np.asarray(1.0 - (left**2).sum(axis=0) / np.maximum((T**2).sum(axis=0), np.finfo(float).tiny))


def _since_begin(view: View, windows: FloatArray) -> FloatArray:
    """Return values in windows less those of the first window of their run."""
    return np.asarray(windows - windows[view.channel.start][view.channel.run])


def _quick_change(view: View, sensor: str) -> float:
    """Return by how much a thermometer changes within `QUICKLY_S`, RMS [K]."""
    step = max(1, round(QUICKLY_S / view.sampling))
    changes = [np.diff(signals.dT[sensor][::step]) for signals in view.signals]
    return float(np.sqrt(np.mean(np.concatenate([*changes, np.zeros(1)]) ** 2)))


def hung(rows: RunRows, sensor: str | None) -> RunRows:
    """Return a run of which a thermometer stands for the air, if any does and has values there."""
    if sensor is None or not np.isfinite(rows.signals.dT[sensor]).all():
        return rows
    return replace(rows, signals=replace(rows.signals, air=rows.signals.dT[sensor]), air_sensor=sensor)


def room_words(sensor: str | None) -> list[str]:
    """Return what a reader must know of a thermometer that is taken for one in the room, if any is."""
    if sensor is None:
        return []
    return [
        f"{sensor} is taken for a thermometer in the room: motion and inputs warm the others, but hardly this one; if "
        'it sits on a part, say which: part = "..." of its [[thermocouples]] in campaign.toml'
    ]
