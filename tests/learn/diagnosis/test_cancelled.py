"""What is larger than what the law leaves is one half of what cancels, and the drift says nothing for it."""

from __future__ import annotations

import numpy as np
import pytest

from hexathermal.learn.diagnosis.cancelled import CANCELLED, all_not_cancelled, most_visible
from hexathermal.learn.diagnosis.evidence import Base, Scored
from hexathermal.learn.diagnosis.stage import Stage
from hexathermal.learn.diagnosis.trials import Trial
from tests.learn.diagnosis.campaigns import viewed
from tests.learn.diagnosis.noises import LEVELS, channel_like


def _scored(visible: float, value: float, *, mends: bool = False) -> Scored:
    """A trial whose columns, or mended data, show so much."""
    trial = Trial("a cause", np.zeros((90, 0 if mends else 1)), base=np.zeros((90, 1)) if mends else None)
    return Scored(trial, value, visible, 1.0, 0.0, 1.0, np.ones(1))


@pytest.mark.parametrize("doubted", [False, True])
def test_an_effect_is_no_larger_than_what_the_law_leaves(doubted: bool, rng: np.random.Generator) -> None:
    """Of a residual of 1 um one of more than `CANCELLED` um says nothing, whatever errors of thermometers explain.

    What speaks against it stays, and what mends data is not asked: it is told beside those errors.
    """
    channel, law = channel_like(rng), rng.standard_normal((90, 2))
    left, weights = rng.standard_normal(90), np.sqrt(channel.rows)
    left -= law @ np.linalg.lstsq(law * weights[:, None], left * weights, rcond=None)[0]
    left /= np.sqrt((left**2).mean())
    base = Base(law, np.full(2, 100.0), 2)
    base = base.extended(left[:, None], np.ones(1)) if doubted else base
    most = most_visible(channel.with_y(law @ [3.0, -2.0] + left), base, LEVELS)
    assert most == pytest.approx(CANCELLED, rel=1e-3)
    items = [_scored(0.95 * most, 30.0), _scored(1.05 * most, 30.0), _scored(1.05 * most, -2.0),
             _scored(1.05 * most, 30.0, mends=True)]  # fmt: skip
    assert [item.value for item in all_not_cancelled(items, most)] == [30.0, 0.0, -2.0, 30.0]


@pytest.mark.long
def test_another_trial_of_the_cause_speaks_for_it(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where the best trial of a cause is too large another one leads; where all are, the drift says nothing for it."""
    view, _ = viewed("quiet", 3, ("backlash",), 1.5)
    search = Stage(view).search
    own = {item.cause: item for item in search.step(search.trials).ranking}["backlash"]
    again = Stage(view).search
    monkeypatch.setitem(again.__dict__, "_most_visible", 0.999 * own.best.visible)
    smaller = {item.cause: item for item in again.step(again.trials).ranking}["backlash"]
    assert smaller.best.visible < own.best.visible
    assert 0.0 < smaller.value <= own.value
    none = Stage(view).search
    monkeypatch.setitem(none.__dict__, "_most_visible", 0.0)
    assert all(item.value <= 0.0 for item in none.step(none.trials).ranking if item.cause == "backlash")
