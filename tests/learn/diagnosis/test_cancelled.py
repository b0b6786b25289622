"""What is larger than what the law leaves is one half of what cancels, and says nothing."""

from __future__ import annotations

import numpy as np
import pytest

from hexathermal.learn.diagnosis.cancelled import CANCELLED, not_cancelled
from hexathermal.learn.diagnosis.evidence import Base, Scored
from hexathermal.learn.diagnosis.trials import Trial
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
    left = rng.standard_normal(90)
    left -= law @ np.linalg.lstsq(law * np.sqrt(channel.rows)[:, None], left * np.sqrt(channel.rows), rcond=None)[0]
    left /= np.sqrt((left**2).mean())
    base = Base(law, np.full(2, 100.0), 2)
    base = base.extended(left[:, None], np.ones(1)) if doubted else base
    items = [_scored(0.95 * CANCELLED, 30.0), _scored(1.05 * CANCELLED, 30.0), _scored(1.05 * CANCELLED, -2.0),
             _scored(1.05 * CANCELLED, 30.0, mends=True)]  # fmt: skip
    found = not_cancelled(channel.with_y(law @ [3.0, -2.0] + left), base, LEVELS, items)
    assert [item.value for item in found] == [30.0, 0.0, -2.0, 30.0]
