"""What relaxes from the beginning of each run on, and a zero that drifts at a rate of its own in each run."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from hexathermal.learn.diagnosis.causes import creep, zero_drift
from hexathermal.learn.diagnosis.causes.creep import FEWEST_BEGUN
from hexathermal.learn.diagnosis.deciding import decided
from hexathermal.learn.diagnosis.evidence import LEAST
from hexathermal.learn.diagnosis.own_rates import FEWEST_RATES, own_rates
from hexathermal.learn.diagnosis.stage import Stage
from hexathermal.learn.diagnosis.tolerating import tolerant
from hexathermal.learn.diagnosis.unexplained import flexible_trials
from hexathermal.learn.diagnosis.view import View
from tests.learn.diagnosis.campaigns import first_name, viewed


@pytest.mark.long
@pytest.mark.parametrize("seed", [7])
def test_what_was_clamped_for_a_run_creeps(seed: int) -> None:
    """By a stretched exponential or the logarithm of time, whatever moves: it is no bench that follows the room.

    An instrument may warm up so, too.
    """
    view, answer = viewed("modal", seed, ("creep",), 1.0)
    assert answer.parameters[0]["begun"]
    decision = decided(tolerant(Stage(view), LEAST).step, LEAST)
    assert decision.leader is not None
    assert decision.leader.cause == "creep"
    assert {decision.leader.cause, *decision.equivalent} == {"creep", "zero-drift"}


@pytest.mark.long
def test_rates_that_differ_are_a_drift_all_the_same() -> None:
    """Where each run drifts at a rate of its own about a common one, that is no rhythm of a long period."""
    view, answer = viewed("modal", 1, ("zero-drift",), 1.0)
    assert answer.parameters[0]["unlike"] > 0.2
    assert first_name(view) == "zero-drift"


def test_a_law_carries_the_common_rate_alone() -> None:
    """What one run has of its own stands beside it: one column for each run, of which no law knows anything."""
    view, _ = viewed("modal", 1, ("zero-drift",), 1.0)
    steady, *_warmed, own = zero_drift.trials(Stage(view).bench)
    assert own.carried == steady.carried == 1
    assert own.starts == len(view.runs)
    assert own.columns[:, 1:].sum(axis=1) == pytest.approx(steady.columns[:, 0])


@pytest.mark.long
def test_what_comes_to_rest_in_each_run_alike_may_creep_or_warm_up() -> None:
    """A clamped leg, or an instrument that warms up: nothing in these data tells them apart, and both are told."""
    view, _ = viewed("quiet", 2, (), 1.0)
    size = 4.0 * Stage(view).levels.rms
    runs = [replace(one, drift=one.drift - size * np.expm1(-one.signals.time / 2500.0)) for one in view.runs]
    decision = decided(Stage(replace(view, runs=tuple(runs))).step, LEAST)
    assert decision.leader is not None
    assert {decision.leader.cause, *decision.equivalent} >= {"creep", "zero-drift"}
    assert decision.probability < 0.8


@pytest.mark.parametrize("period", [510.0, 1026.0, 3300.0])
def test_a_rhythm_of_any_period_keeps_step(period: float) -> None:
    """Some wave that is tried keeps step with one of any period to the ends of the runs: half of it is seen or more."""
    view, _ = viewed("modal", 1, ("zero-drift",), 1.0)
    wave = np.sin(2.0 * np.pi * view.time / period + 0.7 * view.channel.run)
    waves = [trial.columns for trial in flexible_trials(Stage(view).bench) if trial.target == "t"]
    seen = []
    for columns in waves:
        weights, *_ = np.linalg.lstsq(columns, wave, rcond=None)
        seen.append(1.0 - float(((wave - columns @ weights) ** 2).mean() / (wave**2).mean()))
    assert max(seen) > 0.5


@pytest.mark.long
def test_a_floor_that_tilts_with_the_day_has_rates_of_each_runs_own() -> None:
    """Runs of some hours see a straight piece of a day each: real, of time, and no drift of the zero."""
    view, _ = viewed("quiet", 2, (), 1.0)
    size = 2.0 * Stage(view).levels.rms
    tilted = []
    for run, rows in enumerate(view.runs):
        hours = rows.signals.time / 3600.0 + 31.0 * run  # each run at another hour of the day
        day = np.sin(2.0 * np.pi * hours / 24.0)
        tilted.append(replace(rows, drift=rows.drift + 2.0 * size * (day - day[0])))
    assert first_name(replace(view, runs=tuple(tilted))) == "follows time (a rate of each run's own)"


def test_few_runs_are_not_asked() -> None:
    """A slow noise goes alike from the beginnings of three runs, and at rates of their own."""
    whole, _ = viewed("modal", 1, ("zero-drift",), 1.0)
    for count in (FEWEST_BEGUN - 1, FEWEST_BEGUN):
        view = replace(whole, runs=whole.runs[:count])
        bench = Stage(view).bench
        begun = [trial for trial in creep.trials(bench) if trial.parameters["kick"] == "begin"]
        assert bool(begun) == (count >= FEWEST_BEGUN)
        assert (len(list(zero_drift.trials(bench))) > 1) == (count >= FEWEST_RATES)
        assert (own_rates(view) is not None) == (count >= FEWEST_RATES)
        assert all(np.isfinite(trial.columns).all() for trial in begun)


def test_an_instrument_warms_up_beside_a_part_that_never_moves(rng: np.random.Generator) -> None:
    """What comes to rest alike in each run is a drift of the zero; nothing of such a part was clamped or moved."""
    leg, _ = viewed("quiet", 2, (), 1.0)
    runs = []
    for rows in leg.runs:
        signals = replace(rows.signals, q=np.zeros(len(rows.signals)), retracted_length=1.0)
        noise = 0.3e-6 * rng.standard_normal(len(signals))
        warming = -0.5e-6 * np.expm1(-(signals.time - signals.time[0]) / 2800.0)
        drift = 1e-6 * signals.temperature(leg.base[0]) + noise + warming
        runs.append(replace(rows, signals=signals, drift=drift - drift[0]))
    part = replace(leg, kind="component", runs=tuple(runs), base=leg.base[:1])
    assert not part.moves
    stage = Stage(part)
    assert not list(creep.trials(stage.bench))
    leader = stage.step.ranking[0]
    assert leader.cause == "zero-drift"
    assert leader.best.trial.parameters["time_constant_s"] == 3000.0


def with_field(size: float) -> View:
    """A quiet leg beside a magnet, whose recorded field switches on and off and is on when half of the runs begin."""
    view, _ = viewed("quiet", 2, (), 1.0)
    rng = np.random.default_rng(5)
    runs = []
    for k, one in enumerate(view.runs):
        on = (k + np.cumsum(rng.random(len(one.signals.time)) < 0.01)) % 2.0
        field = 40.0 + 8.0 * on + 0.01 * rng.standard_normal(len(on))
        signals = replace(one.signals, inputs={"field_uT": field})
        runs.append(replace(one, signals=signals, drift=one.drift + size * (field - field[0])))
    return replace(view, runs=tuple(runs))


def test_an_input_counts_from_where_the_drift_counts_from() -> None:
    """A drift goes as a recorded input: one of the columns that follow it is just that, on or off when a run begins."""
    without, view = with_field(0.0), with_field(1e-8)
    shown = view.channel.y - without.channel.y
    columns = [trial.columns for trial in flexible_trials(Stage(view).bench) if trial.target == "input"]
    left = [shown - one @ np.linalg.lstsq(one, shown, rcond=None)[0] for one in columns]
    assert min(float(np.abs(one).max()) for one in left) < 1e-6 * float(np.abs(shown).max())
