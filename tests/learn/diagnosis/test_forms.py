"""Effects in the forms in which others write them are named, and by the shape that they have."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from hexathermal.learn.diagnosis.causes import air_refraction, frame_expansion, hidden_heat
from hexathermal.learn.diagnosis.causes.creep import SATURATIONS_M, _saturations
from hexathermal.learn.diagnosis.causes.nonlinear_expansion import trials as squares
from hexathermal.learn.diagnosis.deciding import CLEAR, Decision, _cool, decided
from hexathermal.learn.diagnosis.diagnosing import HIDING, _sees_little
from hexathermal.learn.diagnosis.evidence import LEAST, Scored
from hexathermal.learn.diagnosis.forms import as_joined, other_lines
from hexathermal.learn.diagnosis.limits import SOUND_CAMPAIGNS, STRONGEST, WEAKEST, sure_of_nothing
from hexathermal.learn.diagnosis.ranking import Ranked
from hexathermal.learn.diagnosis.result import Limit
from hexathermal.learn.diagnosis.rivals import SHAPE_ERROR
from hexathermal.learn.diagnosis.sensor_model import Shown
from hexathermal.learn.diagnosis.stage import Stage
from hexathermal.learn.diagnosis.trials import Delay, Trial
from hexathermal.learn.diagnosis.unexplained import flexible_trials
from hexathermal.learn.diagnosis.view import View
from hexathermal.learn.diagnosis.witnesses import WHOLE, Witnesses
from hexathermal.learn.interferometer import index_along_run
from tests.learn.diagnosis.campaigns import viewed
from tests.learn.diagnosis.noises import LEVELS


def decision_of(view: View) -> Decision:
    """What is said of a view at first."""
    return decided(Stage(view).step, LEAST)


@pytest.mark.long
@pytest.mark.parametrize(
    ("cause", "seed", "form"),
    [("nonlinear-expansion", 3, {"curve": "warming"}), ("hidden-heat", 2, {"bodies": "behind"}),
     ("creep", 10, {"directed": False})],
)  # fmt: skip
def test_each_form_is_named(cause: str, seed: int, form: dict[str, Any]) -> None:
    """A square of the warming, heat that passes through what is rubbed, a kick that knows no direction."""
    view, answer = viewed("quiet", seed, (cause,), 1.0)
    assert answer.parameters[0] == dict(answer.parameters[0]) | form
    leader = decision_of(view).leader
    assert leader is not None
    assert leader.cause == cause


def test_each_way_in_which_a_clock_may_be_off_is_weighed_to_the_end() -> None:
    """Where motion prefers a clock that gains, the best one that is off by a time stands beside it, and no others."""

    def clock(value: float, **settings: float) -> Scored:
        return Scored(
            Trial("clock-offset", np.zeros((4, 0)), None, "", settings), value, 1.0, 1.0, 0.0, 0.0, np.zeros(0)
        )

    gains, off, later = clock(247.0, gains_s_per_h=-11.0), clock(205.0, offset_s=-84.0), clock(177.0, offset_s=-59.0)
    lag = replace(off, trial=Trial("thermal-lag", np.zeros((4, 0)), None, "", {"offset_s": -84.0}))
    assert other_lines(gains, [gains, later, off, lag]) == [off]
    assert other_lines(off, [gains, later, off, lag]) == [gains]
    assert other_lines(lag, [gains, later, off, lag]) == []


@pytest.mark.parametrize(("sensors", "joins"), [(("T09", "T16"), "T09"), (("T16",), "T16")])
def test_of_thermometers_that_are_late_together_the_one_that_explains_most_joins(
    sensors: tuple[str, ...], joins: str
) -> None:
    """A law late as a whole is gated by a lag that shows, not by that of its main thermometer."""

    def term(target: str, tau: float, value: float) -> Scored:
        own = Trial("thermal-lag", np.ones((4, 1)), target, "lag", {"time_constant_s": tau, "order": 2})
        return Scored(own, value, 1.0, 1.0, 0.0, 1.0, np.ones(1))

    own, other, slower = term("T16", 240.0, 0.3), term("T09", 240.0, 106.0), term("T09", 480.0, 120.0)
    late = Trial("thermal-lag", np.zeros((4, 0)), "T16", delay=Delay(sensors, (91.0, 91.0), late=False), term=own.trial)
    whole = Scored(late, 112.0, 1.0, 1.0, 0.0, 0.0, np.zeros(0))
    assert as_joined(whole, [whole, own, slower, other]).trial.target == joins
    assert as_joined(whole, [whole, own, slower, other]).trial.parameters["time_constant_s"] == 240.0


@pytest.mark.parametrize(("rows", "tried"), [(1, False), (2, False), (4, True)])
def test_heat_as_long_as_motion_lasts_is_tried_where_that_is_not_the_number_of_moves(rows: int, tried: bool) -> None:
    """Moves that are over within a row or two are told by their number, after each of which a leg may creep."""
    speed = np.tile(np.concatenate([np.full(rows, 0.01), np.zeros(20), np.full(rows, -0.01), np.zeros(7)]), 30)
    view = cast(View, SimpleNamespace(signals=[SimpleNamespace(q=np.cumsum(speed))] * 2))
    assert hidden_heat._works(view) is tried
    at_rest = cast(View, SimpleNamespace(signals=[SimpleNamespace(q=np.zeros(100))]))
    assert not hidden_heat._works(at_rest)


def test_a_square_of_the_warming_counts_from_each_run_s_zero() -> None:
    """Without it the effect is seen as less: the square of the temperature is off by a slope in each run."""
    view, _ = viewed("quiet", 3, ("nonlinear-expansion",), 1.0)
    stage = Stage(view)
    both = stage.search.scored(stage.levels, list(squares(stage.bench)))
    best = max(both, key=lambda item: item.value)
    assert best.trial.shape == "square"
    assert "reference_degC" not in best.trial.parameters
    others = [item.value for item in both if "reference_degC" in item.trial.parameters]
    assert best.value > max(others) + 1.0


def test_where_runs_have_one_zero_warming_and_temperature_are_the_same() -> None:
    """A square or a kink of either is tried once."""
    view, _ = viewed("component", 7873671558253397, (), 1.0)
    bench = Stage(view).bench
    assert not view.zeroed_by_run
    for found in (list(squares(bench)), list(flexible_trials(bench))):
        single = [trial for trial in found if trial.shape == "square" or "beyond a kink" in trial.cause]
        columns = {np.round(trial.columns[:, 0], 12).tobytes() for trial in single}
        assert len(columns) == len(single) > 0


def test_light_may_pass_along_the_leg_and_an_index_may_be_set_once() -> None:
    """The path with the leg, and the index of the campaign's first row, are among what is tried."""
    view, _ = viewed("quiet", 2, (), 1.0)
    tried = [trial.parameters for trial in air_refraction.trials(Stage(view).bench)]
    assert {"path_m": view.dead_path + view.length, "stroke_share": 1.0} in tried
    first = view.runs[0].signals.zero_index
    assert {one["path_m"] for one in tried if one.get("reference_index") == first} == {
        view.dead_path, view.dead_path + view.length
    }  # fmt: skip


def test_where_runs_have_one_zero_the_index_of_air_counts_from_it() -> None:
    """The weather of the days between runs is in it, as in the drift: not each run's own first row."""
    view, _ = viewed("component", 7873671558253397, (), 1.0)
    assert not view.zeroed_by_run
    first = view.runs[0].weather
    assert first is not None
    zero = index_along_run(first[:1])[0]
    for rows in view.runs:
        assert rows.weather is not None
        assert rows.signals.index is not None
        assert rows.signals.air is not None
        assert rows.signals.zero_index == zero
        assert np.allclose(rows.signals.index, index_along_run(rows.weather) - zero, atol=1e-15)
        assert np.allclose(rows.signals.air, rows.weather[:, 0] - first[0, 0], atol=1e-12)
    assert np.ptp([rows.signals.index[0] for rows in view.runs if rows.signals.index is not None]) > 1e-7


@pytest.mark.long
@pytest.mark.parametrize("weather", ["pressure", "temperature", None])
def test_a_barometer_that_nobody_reads_is_told_from_a_whole_index(weather: str | None) -> None:
    """Beams that lack the index of air by its pressure or its temperature alone, or all of it: told as that."""
    view, _ = viewed("quiet", 2, (), 1.0)
    runs = []
    for rows in view.runs:
        assert rows.weather is not None
        still = rows.weather.copy() if weather is None else np.tile(rows.weather[0], (len(rows.weather), 1))
        lacking = 0 if weather == "temperature" else 1
        still[:, lacking] = rows.weather[:, lacking]
        index = index_along_run(still)
        assert rows.signals.pressure_index is not None
        if weather == "pressure":
            assert np.allclose(rows.signals.pressure_index, index - index[0], atol=1e-12)
        runs.append(replace(rows, drift=rows.drift + 0.4 * (view.dead_path + rows.signals.q) * (index - index[0])))
    leader = Stage(replace(view, runs=tuple(runs))).step.ranking[0]
    assert leader.cause == "air-refraction"
    assert leader.best.trial.parameters.get("weather") == weather


def test_what_follows_the_air_at_once_is_its_index_where_beams_measure() -> None:
    """A frame is behind the air; without an index of it what follows at once is tried as the frame's."""
    view, _ = viewed("quiet", 2, (), 1.0)
    blind = [replace(rows, signals=replace(rows.signals, index=None)) for rows in view.runs]
    for seen, at_once in ((view, False), (replace(view, runs=tuple(blind)), True)):
        bench = Stage(seen).bench
        times = {trial.parameters["time_constant_s"] for trial in frame_expansion.trials(bench)}
        assert (0.0 in times) == at_once
        assert (
            any(trial.parameters.get("weather") == "temperature" for trial in air_refraction.trials(bench)) != at_once
        )


def test_thermometers_feign_of_the_index_only_what_the_air_s_temperature_does() -> None:
    """Their errors go as temperatures: nothing of theirs follows the pressure."""
    view, _ = viewed("quiet", 2, (), 1.0)
    for trial in air_refraction.trials(Stage(view).bench):
        assert trial.unfeigned == (trial.parameters.get("weather") != "temperature")


def test_short_moves_are_tried_where_lengths_of_moves_differ() -> None:
    """Equal moves tell no saturation; short beside long ones do; without a move nothing is asked."""
    view, _ = viewed("quiet", 2, (), 1.0)

    def moving(places: list[float]) -> View:
        rows = view.runs[0]
        q = np.repeat(places, len(rows.signals.q) // len(places) + 1)[: len(rows.signals.q)]
        return replace(view, runs=(replace(rows, signals=replace(rows.signals, q=q)),))

    assert _saturations(moving([0.0, 0.01, 0.0, 0.01])) == []
    assert _saturations(moving([0.0, 0.001, 0.05, 0.0])) == list(SATURATIONS_M)
    assert _saturations(moving([0.02])) == []


def limits(*sizes: float) -> list[Limit]:
    """Limits of detection over a noise of 1."""
    return [Limit(f"cause-{k}", size, size) for k, size in enumerate(sizes)]


def test_none_is_as_sure_as_the_campaign_can_see() -> None:
    """Where all would be seen it is certain; where nothing would, it is as likely as before; between them between."""
    with np.errstate(all="raise"):
        assert sure_of_nothing(limits(0.0, 0.1, WEAKEST), 1.0) == 1.0
    assert sure_of_nothing(limits(STRONGEST, 9.0), 1.0) == pytest.approx(SOUND_CAMPAIGNS)
    half = sure_of_nothing(limits(np.sqrt(WEAKEST * STRONGEST)), 1.0)
    assert half == pytest.approx(SOUND_CAMPAIGNS / (SOUND_CAMPAIGNS + 0.5 * (1.0 - SOUND_CAMPAIGNS)))
    assert sure_of_nothing([], 1.0) == SOUND_CAMPAIGNS


def test_a_campaign_that_sees_little_says_so() -> None:
    """Where more than a third of the causes may hide more than the noise a note says it, beside "none" alone."""
    assert HIDING < 0.5
    (note,) = _sees_little("none", limits(0.5, 1.5), 1.0)
    assert "1 of 2 causes could hide an effect larger than the noise" in note
    assert _sees_little("none", limits(0.5, 0.6, 0.7, 1.5), 1.0) == []
    assert _sees_little("effect", limits(9.0), 1.0) == []


def ranked(value: float, gated: float) -> Ranked:
    """A name whose evidence counts against nothing as far as stated."""
    trial = Trial("creep", np.zeros((1, 1)), doubt=value - gated)
    return Ranked("creep", value, Scored(trial, value, 9.0 * LEVELS.rms, LEVELS.rms, 0.0, 1.0, np.ones(1)), LEVELS)


def test_what_may_be_feigned_leads_by_as_little() -> None:
    """Evidence between names is divided by the error of a sketch, or by what of it does not count against nothing."""
    assert _cool(ranked(200.0, 200.0)) == pytest.approx(1.0 + 200.0 * SHAPE_ERROR)
    assert _cool(ranked(200.0, 10.0)) == pytest.approx(20.0)
    assert CLEAR > LEAST


@pytest.mark.parametrize("amplitude", [-0.5, 0.0, 0.6, 1.0, 3.0])
def test_a_part_of_something_is_between_none_and_all(amplitude: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """The air's share in a thermometer that came off: below 0 or above 1 it counts against the fault."""
    shown = Shown(20.0, amplitude, 0.05)
    monkeypatch.setattr(Witnesses, "_shown", lambda self, trial, sensor: shown)
    witness = Witnesses(*cast(Any, [None] * 4))
    beyond = amplitude - np.clip(amplitude, 0.0, 1.0)
    said = witness._gain(Trial("sensor-detached", np.zeros((1, 1)), "T01", partly=True), "T01")
    assert said == pytest.approx(20.0 - 0.5 * beyond**2 / (0.05**2 + WHOLE**2))
    assert witness._gain(Trial("sensor-drift", np.zeros((1, 1)), "T01"), "T01") == 20.0
