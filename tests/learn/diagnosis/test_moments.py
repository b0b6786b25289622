"""Moments at which something may begin: none is passed over, and the parity tells the one at which contact is lost."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hexathermal.learn.diagnosis.causes.sensor_detached import _promising_moments
from hexathermal.learn.diagnosis.causes.zero_jump import _moments
from hexathermal.learn.diagnosis.course import _foresight, _share
from hexathermal.learn.diagnosis.evidence import Scored
from hexathermal.learn.diagnosis.sensor_model import SensorModel
from hexathermal.learn.diagnosis.stage import Stage
from hexathermal.learn.diagnosis.trials import Trial
from tests.learn.diagnosis.campaigns import viewed
from tests.learn.diagnosis.test_evidence import ranked


@given(st.integers(3, 300), st.integers(0, 40), st.integers(8, 120), st.integers(0, 2**32 - 1))
def test_steps_are_looked_for_in_long_rests_too(short: int, long: int, most: int, seed: int) -> None:
    """Among many short windows and one long rest, no stretch of time beyond its share of the run is passed over."""
    rng = np.random.default_rng(seed)
    gaps = np.concatenate([rng.uniform(5.0, 40.0, short), np.full(long, 300.0)])
    time = np.cumsum(gaps)
    chosen = _moments(time, 1, most)
    assert chosen.min() >= 1
    assert len(chosen) <= max(most, 1)
    assert np.all(np.diff(chosen) > 0)
    if len(time) - 1 >= most:
        share = (time[-1] - time[1]) / (most // 2 - 1)
        assert np.diff(time[chosen]).max(initial=0.0) <= share + gaps.max() + 1e-9


@pytest.mark.parametrize("bench", ["modal", "finite_volume"])
def test_the_parity_finds_the_moment_of_lost_contact(bench: str) -> None:
    """Of a thermometer of the law that comes off, the most promising moment is within ten minutes of the true one."""
    view, answer = viewed(bench, 5, ("sensor-detached",), 1.0)
    hidden = answer.parameters[0]
    run, moment = _promising_moments(SensorModel(view, str(hidden["target"])))[0]
    assert view.runs[run].run.name == hidden["run"]
    assert abs(moment - float(hidden["moment"])) < 600.0


def test_runs_left_out_deny_chance_and_confirm_what_is_there() -> None:
    """A random shape makes runs left out less likely, in the mean of twenty; the true shape more, and leaves less."""
    stage = Stage(viewed("quiet", 21, ("backlash",), 1.0)[0])
    leader = ranked("backlash", 10.0)
    rng = np.random.default_rng(1)

    def joined(columns: np.ndarray) -> Stage:
        size = np.full(columns.shape[1], 1e-6)
        return stage.with_effect(Scored(Trial("backlash", columns), 1.0, 1.0, 1.0, 1.0, 1.0, size))

    chance = [_foresight(stage, joined(rng.standard_normal((len(stage.channel), 1))), leader) for _ in range(20)]
    true = joined(stage.view.columns("direction", {}))
    assert np.mean(chance) < 0.0
    assert _foresight(stage, true, leader) > 5.0
    assert _share(stage, true, leader) > 0.0
