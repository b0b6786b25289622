"""What is drawn along behind the rod, or depends on how fast it came, is real and has no name."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from hexathermal.learn.diagnosis.drag import drags
from hexathermal.learn.diagnosis.pace import paces
from hexathermal.learn.diagnosis.stuck import stuck
from hexathermal.learn.diagnosis.view import View
from hexathermal.poses import FloatArray
from tests.learn.diagnosis.campaigns import first_name, viewed
from tests.learn.diagnosis.test_further_forms import with_drift

STEP_M = 1e-4
DRAWN, FAST = "follows the way since a reversal", "follows the speed of the last move"
STUCK = "follows the rests before moves"


def hose(q: FloatArray, way: float) -> FloatArray:
    """A hose that is drawn along, by tenths of millimetres: it yields the less, the more it is stretched."""
    out, pull = np.zeros(len(q)), 0.0
    for k in range(1, len(q)):
        gone = q[k] - q[k - 1]
        count = 1 + int(abs(gone) / STEP_M)
        for _ in range(count):
            pull += gone / count / way * (1.0 - pull * np.sign(gone))
        out[k] = pull
    return out


def taut(q: FloatArray, way: float) -> FloatArray:
    """A cable between two stops of a sledge: it pulls evenly until it is taut."""
    out = np.zeros(len(q))
    for k in range(1, len(q)):
        out[k] = np.clip(out[k - 1] + 2.0 * (q[k] - q[k - 1]) / way, -1.0, 1.0)
    return out


def film(time: FloatArray, q: FloatArray) -> FloatArray:
    """A film of grease as thick as the last minutes' way was fast, less than proportionally; it stays at rest."""
    out, way = np.full(len(q), np.nan), list[tuple[float, float]]()
    for k in range(1, len(q)):
        gone = abs(q[k] - q[k - 1])
        if gone > STEP_M:
            way = [one for one in way if time[k] - one[0] <= 150.0] if way and time[k] - way[-1][0] <= 150.0 else []
            way.append((time[k], gone))
            rest = way[1:] or way
            since = way[0][0] if len(way) > 1 else time[k - 1]
            out[k] = np.sqrt(sum(one[1] for one in rest) / (time[k] - since))
        else:
            out[k] = out[k - 1]
    return np.nan_to_num(out / np.nanmedian(out), nan=1.0)


@pytest.mark.long
@pytest.mark.parametrize(("bench", "drawn"), [("finite_volume", hose), ("modal", taut)])
def test_what_turns_round_over_centimetres_has_no_name(
    bench: str, drawn: Callable[[FloatArray, float], FloatArray]
) -> None:
    """Neither creep, which moves while the rod rests, nor backlash, which turns round at once."""
    view, _ = viewed(bench, 12, (), 1.0)
    assert first_name(with_drift(view, [drawn(rows.signals.q, 0.045) for rows in view.runs], 1.5)) == DRAWN


def sticking(time: FloatArray, q: FloatArray) -> FloatArray:
    """A seal that holds the more, by the logarithm of its rest, and is set free by strokes: half of it by each."""
    out, held, since = np.zeros(len(q)), 0.0, time[0]
    for k in range(1, len(q)):
        gone = q[k] - q[k - 1]
        if abs(gone) > STEP_M and abs(q[k - 1] - q[max(k - 2, 0)]) <= STEP_M:
            held = 0.5 * held + np.sign(gone) * np.log1p((time[k - 1] - since) / 60.0)
        since = time[k] if abs(gone) > STEP_M else since
        out[k] = held
    return out


@pytest.mark.long
@pytest.mark.parametrize("bench", ["modal", "rough"])
def test_what_sticks_the_more_the_longer_it_rested_has_no_name(bench: str) -> None:
    """No backlash, whose size is one; where all rests are alike nothing is asked, since they are one."""
    view, _ = viewed(bench, 12, (), 1.0)
    assert first_name(with_drift(view, [sticking(one.time, one.q) for one in view.signals], 1.5)) == STUCK
    for made in (to_and_fro, up_and_down_stairs):
        even = [replace(rows, signals=replace(rows.signals, q=made(len(rows.drift)))) for rows in view.runs]
        assert not list(stuck(replace(view, runs=tuple(even))))


def to_and_fro(count: int) -> FloatArray:
    """A rod that goes 20 mm out and back, every tenth row."""
    return np.asarray(0.02 * (np.arange(count) // 10 % 2))


def up_and_down_stairs(count: int) -> FloatArray:
    """A rod that goes up five steps of 20 mm and down again, a step every tenth row."""
    step = np.arange(count) // 10 % 10
    return np.asarray(0.02 * np.minimum(step, 10 - step))


@pytest.mark.long
def test_what_depends_on_the_speed_has_no_name() -> None:
    """Neither creep nor a step of the zero, which a few fast moves look like."""
    view, _ = viewed("modal", 12, (), 1.0)
    runs = (rows.signals for rows in view.runs)
    assert first_name(with_drift(view, [film(signals.time, signals.q) for signals in runs], 1.5)) == FAST


def test_speeds_are_asked_where_they_differ() -> None:
    """A rod that always goes as fast, by small steps with pauses, tells no speeds; one that goes twice as fast does."""
    view, _ = viewed("finite_volume", 12, (), 1.0)
    assert len(list(paces(_sawing(view, 40.0, 40.0)))) == 0
    slow, _log = paces(_sawing(view, 40.0, 80.0))
    assert np.ptp(slow) > 0.3


def _sawing(view: View, first: float, second: float) -> View:
    """The view with runs that go to and fro by a millimetre each so many seconds [s], later each so many."""
    runs = []
    for rows in view.runs:
        time = rows.signals.time - rows.signals.time[0]
        half = 0.5 * time[-1]
        count = np.floor(np.minimum(time, half) / first) + np.floor(np.maximum(time - half, 0.0) / second)
        q = 1e-3 * np.abs((count + 50.0) % 100.0 - 50.0)
        runs.append(replace(rows, signals=replace(rows.signals, q=q)))
    return replace(view, runs=tuple(runs))


def test_a_drag_has_turned_round_behind_its_way() -> None:
    """The column goes from one end to the other within a few ways of the rod, and rests with it."""
    view, _ = viewed("finite_volume", 12, (), 1.0)
    ways = {}
    for way, columns in drags(view):
        assert columns.shape[0] == len(view.q)
        ways.setdefault(way, columns)
    spans = [float(np.ptp(columns[:, 0])) for columns in ways.values()]
    assert spans == sorted(spans, reverse=True)
    assert 1.5 < spans[0] < 2.0
