"""Which trial of a cause is best is asked once more as if nothing slow were noise."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from hexathermal.learn.diagnosis import channels
from hexathermal.learn.diagnosis.evidence import Base
from hexathermal.learn.diagnosis.search import Search
from hexathermal.learn.diagnosis.trials import Trial
from tests.learn.diagnosis.noises import LEVELS, channel_like, noisy


def test_the_trial_that_explains_what_is_slow_is_found(
    rng: np.random.Generator, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of two trials one knows the slope in all runs, the other half of it, and a wave better.

    The walk that the slope seems to be alone hides it: the second says more there. Asked as if no walk were noise, the
    first is found, which explains far more in the end.
    """
    quiet = replace(LEVELS, landing=0.02, slow=0.05, offset=0.2, slow_time=900.0)
    noise = noisy(channel_like(rng, runs=9, windows=60), quiet, rng)
    hours = noise._since / 3600.0
    data = noise.with_y(noise.y + 0.5 * hours + 0.15 * np.sin(7.0 * hours))
    steep, half = 0.5 * hours + 0.15 * np.sin(7.0 * hours + 0.6), 0.25 * hours + 0.15 * np.sin(7.0 * hours)
    trials = [Trial("creep", column[:, None]) for column in (steep, half)]
    base = Base(rng.standard_normal((len(data), 1)), np.ones(1), 1)

    def search() -> Search:
        view = SimpleNamespace(kind="component", base=(), sensors=(), stroked=False)
        return Search(SimpleNamespace(view=view), data, base, 10.0)  # type: ignore[arg-type]

    null, _ = data.fitted(base.X, base.sd)
    alone = {id(item.trial): item.value for item in search().scored(null, trials)}
    assert null.slow_time == channels.WALKING_S
    assert alone[id(trials[1])] > alone[id(trials[0])] + 2.0
    found = search().step(trials).ranking[0]
    assert found.best.trial.columns is trials[0].columns
    monkeypatch.setattr(Search, "_in_quick_noise", lambda *_given: [])
    before = search().step(trials).ranking[0]
    assert before.best.trial.columns is trials[1].columns
    assert found.value > before.value + 10.0


def test_quick_noise_changes_as_much_within_minutes(rng: np.random.Generator) -> None:
    """A walk and its quick noise have the same scatter a minute apart, within a tenth; what is quick stays."""
    channel = noisy(channel_like(rng), LEVELS, rng)
    walk = replace(LEVELS, slow=2.0, offset=2.01, slow_time=channels.WALKING_S)
    quick = channel.quick(walk)
    assert quick.slow_time == channels.SLOW_TIMES[0]
    after = [one.slow**2 * -np.expm1(-60.0 / one.slow_time) for one in (walk, quick)]
    assert after[1] == pytest.approx(after[0], rel=0.1)
    assert channel.quick(quick) is quick
