"""Evidence of trials is that of dense normal distributions, and the threshold is what chance alone passes so often."""

from __future__ import annotations

from dataclasses import fields, replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.stats import binom, multivariate_normal

from hexathermal.learn.diagnosis import chance
from hexathermal.learn.diagnosis.borne_out import STEP_ALONE
from hexathermal.learn.diagnosis.chance import FALSE_ALARMS, chance_threshold
from hexathermal.learn.diagnosis.channels import Channel, Levels
from hexathermal.learn.diagnosis.course import _mopped_up
from hexathermal.learn.diagnosis.deciding import OUTSIDE, SOUND, Decision, decided
from hexathermal.learn.diagnosis.evidence import LEAST, RHO, TOLERATED, Base, Scored, mean_log, relevance, screened
from hexathermal.learn.diagnosis.joining import Found
from hexathermal.learn.diagnosis.ranking import NONE, SURE_WITNESS, Ranked, Step
from hexathermal.learn.diagnosis.search import Search
from hexathermal.learn.diagnosis.spans import visible
from hexathermal.learn.diagnosis.trials import Trial
from hexathermal.poses import FloatArray
from tests.learn.diagnosis.noises import LEVELS, channel_like, dense, noisy

LARGEST = 50.0
NOTHING = Decision(None, 1.0, {}, ())


@pytest.fixture
def channel(rng: np.random.Generator) -> Channel:
    return channel_like(rng, runs=4, windows=25)


@pytest.fixture
def base(channel: Channel, rng: np.random.Generator) -> Base:
    return Base(rng.standard_normal((len(channel), 3)), np.array([1.0, 2.0, 0.5]), 2)


def density(channel: Channel, X: FloatArray, sd: FloatArray) -> float:
    return float(multivariate_normal(None, dense(channel, LEVELS) + (X * sd**2) @ X.T).logpdf(channel.y))


def test_a_term_is_scored_as_dense_distributions_score_it(
    channel: Channel, base: Base, rng: np.random.Generator
) -> None:
    """The score of one to four columns is the log of the mean over sizes of p(y | law and trial) / p(y | law)."""
    channel = noisy(channel, LEVELS, rng)
    trials = [Trial("backlash", rng.standard_normal((len(channel), k))) for k in (2, 1, 4, 2, 3)]
    for found in screened(channel, base, LEVELS, trials, LARGEST):
        trial, k = found.trial, found.trial.columns.shape[1]
        size = LEVELS.rms / np.sqrt(k) / visible(trial.columns, base.X)
        X = np.column_stack([base.X, trial.columns])
        values = np.array([density(channel, X, np.append(base.sd, rho * size)) for rho in RHO])
        wanted = mean_log(values) - density(channel, base.X, base.sd)
        assert found.value == pytest.approx(wanted, abs=1e-6)
        assert found.rho == RHO[int(np.argmax(values))]
        np.testing.assert_allclose(found.size, found.rho * size)


def test_what_is_visible_of_columns_that_go_against_each_other_is_their_sum(
    channel: Channel, base: Base, rng: np.random.Generator
) -> None:
    """Two columns that are nearly alike, with amplitudes of either sign, are as visible as what they leave together."""
    one, little = rng.standard_normal((2, len(channel)))
    columns = np.column_stack([one, one + 0.02 * little])
    channel = channel.with_y(4.0 * little)
    (found,) = screened(channel, base, LEVELS, [Trial("thermal-lag", columns)], 1e4)
    whole = base.extended(columns, found.size)
    amplitudes = channel.solved(whole.X, whole.sd, LEVELS)[1][-2:]
    law = base.X[:, : base.plain]
    assert found.visible == pytest.approx(visible((columns @ amplitudes)[:, None], law)[0], rel=1e-6)
    assert found.visible < 0.2 * np.linalg.norm(visible(columns * amplitudes, law))


def test_a_changed_law_is_scored_on_the_same_data(channel: Channel, base: Base, rng: np.random.Generator) -> None:
    """A swap or a clock replaces the law's columns; its score is p(y | other columns) / p(y | law)."""
    channel = noisy(channel, LEVELS, rng)
    other = rng.standard_normal((len(channel), 2))
    trial = Trial("swapped-sensors", np.zeros((len(channel), 0)), base=other, advantage=1.5)
    (found,) = screened(channel, base, LEVELS, [trial], LARGEST)
    changed = np.column_stack([other, base.X[:, 2:]])
    wanted = density(channel, changed, base.sd) - density(channel, base.X, base.sd) + 1.5
    assert found.value == pytest.approx(wanted, abs=1e-6)


def test_what_the_law_can_carry_says_nothing(channel: Channel, base: Base, rng: np.random.Generator) -> None:
    """A column that the law has already wins nothing, whatever its size in the data."""
    channel = noisy(channel, LEVELS, rng)
    channel = channel.with_y(channel.y + base.X[:, 0])
    (found,) = screened(channel, base, LEVELS, [Trial("scale-error", base.X[:, :1].copy())], LARGEST)
    assert found.value < 1.0


def test_an_effect_raises_its_own_trial(channel: Channel, base: Base, rng: np.random.Generator) -> None:
    """Of thirty shapes, the hidden one wins, and what is seen of it is what was hidden within 30 %."""
    trials = [Trial(f"shape-{k}", rng.standard_normal((len(channel), 1))) for k in range(30)]
    hidden = noisy(channel, LEVELS, rng)
    size = 1.0 * LEVELS.rms / visible(trials[7].columns, base.X)[0]
    hidden = hidden.with_y(hidden.y + size * trials[7].columns[:, 0])
    best = max(screened(hidden, base, LEVELS, trials, LARGEST), key=lambda one: one.value)
    assert best.trial is trials[7]
    assert best.visible == pytest.approx(LEVELS.rms, rel=0.3)


def test_visible_is_the_part_off_the_law(channel: Channel, rng: np.random.Generator) -> None:
    """Columns of the law have nothing visible, of others what least squares leaves; collinear columns do no harm."""
    X = rng.standard_normal((len(channel), 2))
    N = np.column_stack([X, X @ [2.0, 1.0]])
    table = np.column_stack([X @ [1.0, -2.0], rng.standard_normal(len(channel))])
    left = table[:, 1] - X @ np.linalg.lstsq(X, table[:, 1], rcond=None)[0]
    np.testing.assert_allclose(visible(table, N), [0.0, np.sqrt((left**2).mean())], atol=1e-10)


def test_mean_log_survives_large_evidence() -> None:
    """The mean of exponentials is taken without overflow; one value is its own mean."""
    assert mean_log(np.array([2000.0, 2000.0])) == pytest.approx(2000.0)
    assert mean_log(np.log([1.0, 3.0])) == pytest.approx(np.log(2.0))


def scored(trial: Trial, value: float, shown: float, noise: float) -> Scored:
    """A trial with its evidence and what is visible of it; all else does not matter."""
    known = {"trial": trial, "value": value, "visible": shown, "noise": noise, "size": np.ones(1)}
    return Scored(**{field.name: known.get(field.name, 1.0) for field in fields(Scored)})  # type: ignore[arg-type]


def test_many_rows_do_not_make_a_trifle_large() -> None:
    """However many rows tell of it, an effect says at most half the square of it over what the null tolerates."""
    trial = Trial("creep", np.zeros((1, 1)))
    assert scored(trial, 1e4, 2.0 * TOLERATED, 1.0).gated == pytest.approx(2.0)
    assert scored(trial, 1.0, 5.0, 1.0).gated == 1.0


def test_what_thermometers_feign_is_tolerated() -> None:
    """An effect as large as thermometers may feign says at most 1/2, ten times that 50."""
    assert relevance(0.3, 0.1, 0.3) == pytest.approx(0.5, rel=0.01)
    feigned = replace(Trial("hidden-heat", np.zeros((1, 1))), feigned=0.3)
    assert scored(feigned, 1e4, 3.0, 0.1).gated == pytest.approx(50.0, rel=0.01)


def drawn_maxima(channel: Channel, base: Base, trials: list[Trial], rng: np.random.Generator, count: int) -> FloatArray:
    """The best mean evidence of a cause in campaigns with nothing but noise and law."""
    found = []
    for _ in range(count):
        drawn = noisy(channel, LEVELS, rng)
        drawn = drawn.with_y(drawn.y + base.X @ (base.sd * rng.standard_normal(len(base.sd))))
        scored = screened(drawn, base, LEVELS, trials, LARGEST)
        causes = sorted({one.trial.cause for one in scored})
        found.append(
            max(mean_log(np.array([one.value for one in scored if one.trial.cause == name])) for name in causes)
        )
    return np.array(found)


def test_chance_passes_the_threshold_as_seldom_as_it_says(
    channel: Channel, base: Base, rng: np.random.Generator
) -> None:
    """Of 400 campaigns with nothing in them the threshold is passed by FALSE_ALARMS of them, no more and not never.

    Bounds hold for a rate between a fifth and three times FALSE_ALARMS; 3 below, chance passes far oftener.
    """
    trials = [Trial(f"cause-{k % 8}", rng.standard_normal((len(channel), 1 + k % 2))) for k in range(24)]
    threshold = chance_threshold(channel, base, LEVELS, trials, LARGEST, 1)
    maxima = drawn_maxima(channel, base, trials, rng, 400)
    above = int((maxima > threshold).sum())
    assert above <= binom.ppf(1.0 - 1e-4, 400, 3.0 * FALSE_ALARMS), above
    assert int((maxima > threshold - 3.0).sum()) > binom.ppf(1.0 - 1e-4, 400, 3.0 * FALSE_ALARMS)


def test_the_threshold_repeats(channel: Channel, base: Base, rng: np.random.Generator) -> None:
    """The same seed gives the same threshold; no trials need none."""
    trials = [Trial(f"cause-{k}", rng.standard_normal((len(channel), 1))) for k in range(8)]
    one, two = (chance_threshold(channel, base, LEVELS, trials, LARGEST, 5) for _ in range(2))
    assert one == two
    assert chance_threshold(channel, base, LEVELS, [], LARGEST, 5) == 0.0


def ranked(cause: str, value: float, seen: float = 2.0, columns: int = 1) -> Ranked:
    """A cause with an evidence, as large as may be seen."""
    trial = Trial(cause, np.zeros((1, columns)))
    return Ranked(cause, value, scored(trial, value, seen * LEVELS.rms, LEVELS.rms), LEVELS)


def step(*items: Ranked) -> Step:
    return Step(tuple(sorted(items, key=lambda one: -one.value)), LEVELS, 0.0)


def test_nothing_is_named_below_the_threshold() -> None:
    """A ranking whose best is below the threshold is 'none', and the likelier the farther below."""
    weak, weaker = (
        decided(step(ranked("creep", value), ranked("backlash", -3.0)), LEAST) for value in (LEAST - 0.5, 0.0)
    )
    assert weak.leader is None
    assert weaker.leader is None
    assert weaker.probability > weak.probability


def test_a_trifle_is_not_named_for_many_rows() -> None:
    """Evidence of 1000 for an effect of a tenth of the noise is no name."""
    assert decided(step(ranked("creep", 1000.0, seen=0.1)), LEAST).leader is None


def test_probabilities_sum_to_one_and_equivalents_are_close() -> None:
    """Hypotheses share what is believed of them; a cause nearly as likely is stated, one far behind is not."""
    decision = decided(step(ranked("creep", 80.0), ranked("backlash", 79.0), ranked("zero-drift", 5.0)), LEAST)
    assert sum(decision.probabilities.values()) == pytest.approx(SOUND)
    assert decision.leader is not None
    assert decision.leader.cause == "creep"
    assert decision.equivalent == ("backlash",)
    assert decision.probability < 0.95


def test_what_was_recorded_is_hardly_likelier_than_a_sketch_close_behind() -> None:
    """A missing thermometer a little ahead of stored heat is likelier by little; one far ahead, or ahead of another
    cause, as likely as before. Names, and what is shared by both, stay.
    """
    heat, other = ranked("hidden-heat", 90.0), ranked("creep", 90.0)
    close, beside = (decided(step(ranked("missing-sensor", 100.0), one), LEAST) for one in (heat, other))
    assert close.leader is not None
    assert close.leader.cause == "missing-sensor"
    assert close.equivalent == ("hidden-heat",)
    assert 0.5 < close.probability < 0.6 < beside.probability
    assert sum(close.probabilities.values()) == pytest.approx(SOUND)
    far = [
        decided(step(ranked("missing-sensor", 100.0), ranked(name, 60.0)), LEAST) for name in ("hidden-heat", "creep")
    ]
    assert far[0].probability == pytest.approx(far[1].probability)


def test_a_rate_of_each_runs_own_may_be_a_drift_of_the_zero() -> None:
    """It has no name, but that is no surer than `OUTSIDE`; what is less sure goes to the name, where it was asked."""
    own, drift = ranked("follows time (a rate of each run's own)", 100.0, columns=6), ranked("zero-drift", 10.0)
    both, alone = decided(step(own, drift), LEAST), decided(step(own, ranked("creep", 10.0)), LEAST)
    assert not both.named
    assert both.probability == OUTSIDE
    assert both.probabilities["zero-drift"] > 0.3
    assert sum(both.probabilities.values()) == pytest.approx(SOUND)
    assert alone.probability > 0.9


def test_a_fault_that_the_drift_alone_speaks_for_as_well_is_stated() -> None:
    """A thermometer's fault is as good as the name where its parity seconds it, or is too uncertain to deny it."""
    fault = ranked("sensor-drift", 18.0)
    certain = decided(step(ranked("zero-drift", 40.0), fault), LEAST)
    stated = [
        decided(step(ranked("zero-drift", 40.0), replace(fault, seconded=witness, withheld=withheld)), LEAST)
        for witness, withheld in ((4.0, 22.0), (-1.0, 22.0), (4.0, 15.0))
    ]
    assert [one.equivalent for one in stated] == [("sensor-drift",), (), ()]
    unsure = [replace(fault, withheld=22.0, agreed=agreed) for agreed in (0.3, -0.7, -1.3)]
    told = [decided(step(ranked("zero-drift", 40.0), one), LEAST).equivalent for one in unsure]
    assert told == [("sensor-drift",), ("sensor-drift",), ()]
    assert stated[0].probability == pytest.approx(0.5 * certain.probability)
    assert stated[1].probability == stated[2].probability == certain.probability


def test_something_nameless_far_ahead_is_unexplained() -> None:
    """Flexible columns that lead by far leave no name; a cause close behind them keeps its name.

    One column without a name, as a kink, imitates nothing: ahead of a cause it leaves it no name.
    """
    far = decided(step(ranked("follows the displacement", 120.0, columns=6), ranked("creep", 20.0)), LEAST)
    near = decided(step(ranked("follows the displacement", 60.0, columns=6), ranked("creep", 59.0)), LEAST)
    single = decided(step(ranked("follows the temperature", 60.0), ranked("creep", 58.0)), LEAST)
    behind = decided(step(ranked("creep", 62.0), ranked("follows the temperature", 60.0)), LEAST)
    ahead = decided(step(ranked("creep", 65.0), ranked("follows the temperature", 60.0)), LEAST)
    assert far.leader is not None
    assert not far.named
    assert near.named
    assert not single.named
    assert behind.leader is not None
    assert behind.leader.cause == "follows the temperature"
    assert ahead.named


def test_windows_that_stand_off_are_no_step(channel: Channel, base: Base, rng: np.random.Generator) -> None:
    """A step that stays keeps its evidence; where one to three windows stand off, steps count next to nothing."""
    own = channel.run == 2
    at = int(np.argmax(own)) + 12
    later = [own & (np.arange(len(own)) >= at + k) for k in range(-3, 6)]
    steps = [Trial("zero-jump", rows[:, None].astype(float), "run-03") for rows in later]
    largest = {}
    for width in (1, 3, 100):
        off = own & (np.arange(len(own)) >= at) & (np.arange(len(own)) < at + width)
        data = channel.with_y(noisy(channel, LEVELS, rng).y + 8.0 * off)
        found = Search(SimpleNamespace(), data, base, LARGEST).scored(LEVELS, steps)  # type: ignore[arg-type]
        largest[width] = max(item.value for item in found)
        assert all(item.trial.most == STEP_ALONE for item in found if item.value == STEP_ALONE)
    assert largest[100] > 10.0
    assert max(largest[1], largest[3]) <= STEP_ALONE < LEAST


def test_a_landing_that_stands_off_is_no_step(channel: Channel, base: Base, rng: np.random.Generator) -> None:
    """The scatter of a run's first landing says next to nothing for a step at its end; a later step keeps its own."""
    own = np.flatnonzero(channel.run == 2)
    fresh = channel.start.copy()
    fresh[own[[12, 18, 22]]] = True  # so that no landing but the first could stand off in place of a step
    inside, index = channel.run == 2, np.arange(len(channel))
    data = replace(channel, fresh=fresh)
    said = {}
    for moment in (12, 18):
        step = (inside & (index >= own[moment])).astype(float)
        noise = noisy(channel, LEVELS, rng).y
        search = Search(SimpleNamespace(), data.with_y(noise + 8.0 * step), base, LARGEST)  # type: ignore[arg-type]
        trial = Trial("zero-jump", step[:, None], "run-03")
        said[moment] = search.scored(LEVELS, [trial])[0].value
    assert said[12] <= STEP_ALONE < LEAST
    assert said[18] > 10.0


def test_two_landings_that_stand_off_are_no_step(channel: Channel, base: Base, rng: np.random.Generator) -> None:
    """The last two landings of a run, each off by its own scatter, are no step; off by the same they may be one."""
    own = np.flatnonzero(channel.run == 2)
    fresh = channel.start.copy()
    fresh[own[[6, 12, 18, 22]]] = True
    inside, index = channel.run == 2, np.arange(len(channel))
    step = (inside & (index >= own[18])).astype(float)
    last = (inside & (index >= own[22])).astype(float)
    said = {}
    for size in (4.0, 12.0):
        noise = noisy(channel, LEVELS, rng).y
        data = replace(channel, fresh=fresh).with_y(noise + 4.0 * step + (size - 4.0) * last)
        search = Search(SimpleNamespace(), data, base, LARGEST)  # type: ignore[arg-type]
        trials = [Trial("zero-jump", own[:, None], "run-03") for own in (step, last)]
        said[size] = max(item.value for item in search.scored(LEVELS, trials))
    assert said[4.0] > LEAST
    assert said[12.0] <= STEP_ALONE < LEAST


@pytest.mark.parametrize("carried", [True, False])
def test_what_had_not_come_to_rest_is_no_evidence_by_itself(
    channel: Channel, base: Base, rng: np.random.Generator, carried: bool
) -> None:
    """A decay in one run, which no law carries, does not count against nothing; what a law carries does."""
    index, first = np.arange(len(channel)), channel.run == 0
    room = np.sin(index / 9.0)
    decay = np.where(first, np.exp(-index / 8.0), 0.0)
    data = channel.with_y(noisy(channel, LEVELS, rng).y + 4.0 * (room if carried else 2.0 * decay))
    search = Search(SimpleNamespace(), data, base, LARGEST)  # type: ignore[arg-type]
    trial = Trial("frame-expansion", np.column_stack([room, decay]), starts=1)
    best = search.scored(LEVELS, [trial])[0]
    doubted = search._doubted(best, [LEVELS], data.evidence(base.X, base.sd, LEVELS))
    assert best.value > LEAST
    assert (doubted.gated > LEAST) == carried


def test_a_later_name_must_beat_what_the_first_one_s_shape_left() -> None:
    """A lag over a missing sensor of evidence 300 needs 9 more: the two are confused; a backlash needs no more."""
    first = Found(ranked("missing-sensor", 300.0), NOTHING, True, np.zeros(1), np.zeros(1))
    assert _mopped_up(ranked("thermal-lag", 12.0), [first]) == pytest.approx(9.0)
    assert _mopped_up(ranked("backlash", 12.0), [first]) == 0.0
    assert _mopped_up(ranked("thermal-lag", 12.0), []) == 0.0


def test_of_names_alike_the_larger_effect_is_the_first() -> None:
    """Of causes alike in evidence, first is the one that a small misfit stands for least; far ahead stays first."""
    alike = decided(step(ranked("creep", 300.0, seen=0.3), ranked("clock-offset", 299.0)), LEAST)
    ahead = decided(step(ranked("creep", 300.0, seen=0.3), ranked("clock-offset", 250.0)), LEAST)
    assert alike.leader is not None
    assert ahead.leader is not None
    assert (alike.leader.cause, ahead.leader.cause) == ("clock-offset", "creep")


def test_what_another_thermometer_proves_is_no_misfit_of_the_drift() -> None:
    """A fault that shows little in the drift is gated, unless the sensor's own parity is beyond that of all others."""
    small = ranked("sensor-drift", 80.0, seen=0.1)
    assert small.gated < LEAST
    assert replace(small, witness=SURE_WITNESS).gated < LEAST
    assert replace(small, witness=60.0).gated == pytest.approx(small.gated + 60.0 - SURE_WITNESS)


def test_drift_and_parity_that_agree_are_no_chance() -> None:
    """A small fault of which drift and parity both speak is named: the lesser of them counts, never more than both."""
    small = ranked("sensor-drift", 20.0, seen=0.1)
    assert replace(small, witness=12.0, both=8.0).gated == pytest.approx(small.gated + 8.0)
    assert small.gated + 8.0 > LEAST
    assert replace(small, witness=12.0, both=-2.0).gated == small.gated < LEAST
    assert replace(small, witness=99.0, both=50.0).gated == small.value


def test_the_null_is_given_every_noise_that_a_leader_is_given(
    channel: Channel, base: Base, rng: np.random.Generator
) -> None:
    """Noise refitted for the leaders is open to the null: on noise alone no cause of ten gains 6 by it, in 20 draws."""
    wins = 0
    bench = SimpleNamespace(view=SimpleNamespace(base=(), sensors=(), kind="leg"), model=lambda _name: None)
    for _ in range(20):
        search = Search(bench, noisy(channel, LEVELS, rng), base, LARGEST)  # type: ignore[arg-type]
        trials = [Trial(f"cause-{k}", rng.standard_normal((len(channel), 1))) for k in range(10)]
        wins += search.step(trials).ranking[0].value > LEAST
    assert wins <= binom.ppf(1.0 - 1e-4, 20, 0.03)


def test_names_of_the_verdicts() -> None:
    """'none' is what nothing is called, and no cause."""
    assert NONE == "none"
    assert TOLERATED < 0.2
    assert 0.0 < chance.FALSE_ALARMS <= 0.02
    assert isinstance(LEVELS, Levels)
