"""Errors that all thermometers share are no cause; where nobody can know of them, nothing changes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from hexathermal.learn.diagnosis.common_error import common_error, doubted_alike
from hexathermal.learn.diagnosis.view import View
from tests.learn.diagnosis.campaigns import first_name, nothing_shared, viewed

ERROR_K, TIME_S = 0.06, 7200.0


def drifting(view: View, seed: int) -> View:
    """A view whose logger adds one error to all thermometers, of first order, from each run's first row on."""
    rng, runs = np.random.default_rng(seed), []
    for rows in view.runs:
        time = rows.signals.time
        kept = np.exp(-np.diff(time) / TIME_S)
        error = [rng.standard_normal()]
        for a in kept:
            error.append(a * error[-1] + np.sqrt(1.0 - a * a) * rng.standard_normal())
        shared = ERROR_K * (np.array(error) - error[0])
        dT = {name: values + shared for name, values in rows.signals.dT.items()}
        runs.append(replace(rows, signals=replace(rows.signals, dT=dT)))
    return replace(view, runs=tuple(runs))


def test_what_motion_and_room_do_not_foretell_wanders_more_where_the_logger_drifts() -> None:
    """The thermometers' mean wanders by what a sound leg's does and the logger's error together."""
    sound = viewed("held_out", 2, (), 1.0)[0]
    view = drifting(sound, 2)
    before, after = common_error(sound), common_error(view)
    assert before is not None
    assert after is not None
    assert after.slow == pytest.approx(np.hypot(before.slow, ERROR_K), rel=0.25)
    assert after.slow > 1.5 * before.slow


def warmed(view: View, size: float, seed: int) -> View:
    """A view in which heat that nobody recorded warms thermometers, the first one whole, the last one not at all."""
    rng, runs = np.random.default_rng(seed), []
    for rows in view.runs:
        time = rows.signals.time
        heat = np.convolve(rng.standard_normal(len(time)), np.exp(-np.arange(0.0, 4.0, (time[1] - time[0]) / 1800.0)))
        heat = heat[: len(time)] / heat[: len(time)].std()
        part = dict(zip(view.sensors, np.linspace(1.0, 0.0, len(view.sensors)), strict=True))
        dT = {name: values + size * part[name] * (heat - heat[0]) for name, values in rows.signals.dT.items()}
        runs.append(replace(rows, signals=replace(rows.signals, dT=dT)))
    return replace(view, runs=tuple(runs))


def test_warmth_that_nobody_recorded_is_no_error_that_all_share() -> None:
    """It is not alike in all places: of 0 to 1 K of it, half a kelvin in their mean, little may be shared."""
    sound = viewed("held_out", 2, (), 1.0)[0]
    before, warm = common_error(sound), common_error(warmed(sound, 1.0, 3))
    assert before is not None
    assert warm is not None
    assert before.slow <= warm.slow < 0.05


@pytest.mark.parametrize("readings", ["stuck", "coarse"])
def test_a_thermometer_that_does_not_answer_speaks_for_none(readings: str) -> None:
    """One that is stuck, or steps by 2 K, shows no error of the logger: what all may share is as without it."""
    view = drifting(viewed("held_out", 2, (), 1.0)[0], 2)
    name, runs = view.sensors[-1], []
    for rows in view.runs:
        own = (
            np.zeros(len(rows.drift))
            if readings == "stuck"
            else 2.0 * np.round(rows.signals.dT[view.sensors[-1]] / 2.0)
        )
        runs.append(replace(rows, signals=replace(rows.signals, dT={**rows.signals.dT, name: own})))
    whole, without = (
        common_error(replace(view, runs=tuple(runs))),
        common_error(replace(view, sensors=view.sensors[:-1])),
    )
    assert whole is not None
    assert without is not None
    assert name not in whole.sensors
    assert whole.slow == pytest.approx(without.slow, rel=1e-6)
    assert whole.slow > 0.03


def test_thermometers_that_never_change_are_no_reason_to_stop() -> None:
    """All outside the law stuck: nobody can know what they share, and nothing stands in the null for it."""
    view = viewed("held_out", 2, (), 1.0)[0]
    still = {name: 0.0 for name in view.sensors if name not in view.base}
    runs = [replace(rows, signals=replace(rows.signals, dT={**rows.signals.dT, **{name: np.zeros(len(rows.drift))
                                                                                   for name in still}}))
            for rows in view.runs]  # fmt: skip
    assert common_error(replace(view, runs=tuple(runs))) is None


def test_weights_are_a_mean_of_thermometers() -> None:
    """None is below 0, their sum is 1, and more than one speaks; what each errs by is taken off what all may share."""
    found = common_error(viewed("held_out", 2, (), 1.0)[0])
    assert found is not None
    assert found.weights.min() >= 0.0
    assert found.weights.sum() == pytest.approx(1.0)
    assert found.weights.max() <= 0.5 + 1e-6
    own = found.slow / np.linalg.norm(found.weights)
    assert found.beside(0.0) == found.slow
    assert found.beside(0.6 * own) == pytest.approx(0.8 * found.slow)
    assert found.beside(2.0 * own) == 0.0


def test_errors_of_what_is_foretold_are_no_larger_than_what_wanders() -> None:
    """Directions in which what is foretold is uncertain are smaller, the one by one, than what is not foretold."""
    view = drifting(viewed("held_out", 2, (), 1.0)[0], 2)
    sizes = np.concatenate(doubted_alike(view)).std(axis=0)
    assert len(sizes) > 4
    assert 0.0 < sizes[3:].max() < sizes[0]


ALARMS = (("held_out", 1), ("modal", 2), ("held_out_axis", 1))


@pytest.mark.long
@pytest.mark.parametrize(("bench", "seed"), ALARMS)
def test_a_logger_that_drifts_is_no_cause(bench: str, seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """A sound leg or axis whose logger drifts gets no name; where the null knew no shared error, it would.

    Of twelve sound axes none gets a name, and seven did.
    """
    view = replace(drifting(viewed(bench, seed, (), 1.0)[0], seed), placed=bench.endswith("axis"))
    assert first_name(view) is None
    unknowing = replace(view)
    nothing_shared(monkeypatch)
    assert first_name(unknowing) is not None


@pytest.mark.long
@pytest.mark.parametrize("cause", ["hidden-heat", "thermal-lag"])
def test_what_goes_as_motion_or_the_room_is_still_named(cause: str) -> None:
    """The doubt of a sound logger hides no cause that follows what warms the leg."""
    view, _answer = viewed("finite_volume", 11, (cause,), 1.5)
    assert first_name(view) == cause


def test_few_thermometers_or_nothing_that_warms_say_nothing() -> None:
    """With fewer than five thermometers outside the law, or in a leg that rests, nothing is doubted alike."""
    view = viewed("quiet", 1, (), 1.0)[0]
    few = replace(view, sensors=view.sensors[:5])
    assert common_error(few) is None
    assert doubted_alike(few)[0].shape[1] == 0
    still = [replace(rows, signals=replace(rows.signals, q=np.full(len(rows.signals), 0.2))) for rows in view.runs]
    assert common_error(replace(view, runs=tuple(still))) is None
    assert common_error(view) is not None
