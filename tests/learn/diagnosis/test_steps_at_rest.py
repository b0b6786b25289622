"""What lets go, closes or is switched off when nothing has moved for a while steps at once: it does not creep."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from hexathermal.learn.diagnosis.deciding import decided
from hexathermal.learn.diagnosis.evidence import LEAST
from hexathermal.learn.diagnosis.last_move import steps_at_rest
from hexathermal.learn.diagnosis.stage import Stage
from hexathermal.learn.diagnosis.tolerating import tolerant
from hexathermal.learn.diagnosis.view import View
from hexathermal.poses import FloatArray
from tests.learn.diagnosis.campaigns import first_name, viewed
from tests.learn.diagnosis.test_further_forms import with_drift

MOVED_M = 1e-5
STOPS = ("follows the rest since a move", "follows the last move")


def rested(view: View) -> list[FloatArray]:
    """The time since the rod moved last, in all rows of each run [s]; before its first move it has rested for long."""
    found = []
    for rows in view.runs:
        since, last = np.full(len(rows.signals.time), np.inf), -np.inf
        for k in range(1, len(since)):
            if abs(rows.signals.q[k] - rows.signals.q[k - 1]) > MOVED_M:
                last = rows.signals.time[k]
            since[k] = rows.signals.time[k] - last
        found.append(since)
    return found


@pytest.mark.long
@pytest.mark.parametrize(("bench", "after"), [("quiet", 120.0), ("finite_volume", 70.0)])
def test_a_brake_that_closes_at_rest_has_no_name(bench: str, after: float) -> None:
    """A step some time after each stop is real, and no creep; what no window resolves is never named sooner."""
    view, _ = viewed(bench, 12, (), 1.0)
    braked = with_drift(view, [(since >= after).astype(float) for since in rested(view)], 1.5)
    assert first_name(braked) in STOPS


@pytest.mark.long
@pytest.mark.parametrize(("bench", "tau"), [("quiet", 60.0), ("modal", 100.0)])
def test_what_relaxes_after_each_move_is_creep(bench: str, tau: float) -> None:
    """One exponential after each stop, whatever its direction, leads every step by far."""
    view, _ = viewed(bench, 12, (), 1.0)
    crept = with_drift(view, [-np.expm1(-np.minimum(since, 1e6) / tau) for since in rested(view)], 1.5)
    decision = decided(tolerant(Stage(crept), LEAST).step, LEAST)
    assert decision.leader is not None
    assert decision.leader.cause == "creep"


def test_steps_are_tried_only_where_something_rests_so_long() -> None:
    """Where all rests after moves are shorter than a step, it would be one at the first move, and is not tried."""
    view, _ = viewed("quiet", 12, (), 1.0)
    assert len(list(steps_at_rest(view))) > 10
    hasty = []
    for rows in view.runs:
        time = rows.signals.time  # ten minutes of rest, then a move every 100 s
        q = np.where(time < 600.0, 0.0, 0.02 * (1.0 + np.floor(time / 100.0) % 2.0))
        hasty.append(replace(rows, signals=replace(rows.signals, q=q)))
    found = dict(steps_at_rest(replace(view, runs=tuple(hasty))))
    assert found
    assert max(found) < 100.0
    assert len({step.tobytes() for step in found.values()}) == len(found)
    still = [replace(rows, signals=replace(rows.signals, q=np.zeros_like(rows.signals.q))) for rows in view.runs]
    assert list(steps_at_rest(replace(view, runs=tuple(still)))) == []
