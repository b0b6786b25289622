"""Shapes of terms against the same physics stepped row by row; what belongs to the bench; equality and pickling."""

from __future__ import annotations

import dataclasses
import pickle

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hexathermal.errors import ArgumentError, UnknownNameError
from hexathermal.learn.air import index_sensitivity
from hexathermal.machine.leg_repairs import SensorRepair
from hexathermal.machine.leg_signals import LegSignals, Memory
from hexathermal.machine.leg_states import of_bench, sensors_of, solved_length
from hexathermal.machine.leg_term_files import COUNTS, PARAMETERS, UNITS
from hexathermal.machine.leg_terms import INDEX_PER_K, SHAPES, LegTerm, term_columns
from hexathermal.poses import FloatArray
from tests.learn.extended_laws import EXAMPLES, drawn_signals

FINE = 4000
"""Steps of a row in which a differential equation is integrated."""


def integrated(time: np.ndarray, u: np.ndarray, tau: float) -> np.ndarray:
    """Return ``tau y' = u - y``, at rest at first, by many small steps between rows where u is linear."""
    y = np.empty_like(u)
    y[0] = u[0]
    for k in range(1, len(u)):
        value, h = y[k - 1], (time[k] - time[k - 1]) / FINE
        for part in (np.arange(FINE) + 0.5) / FINE:
            middle = u[k - 1] + part * (u[k] - u[k - 1])
            value += h / tau / (1.0 + 0.5 * h / tau) * (middle - value)
        y[k] = value
    return y


@given(seed=st.integers(0, 10**6), tau=st.floats(20.0, 5000.0))
def test_a_lag_solves_its_differential_equation(seed: int, tau: float) -> None:
    """``(q0 + r q) (y - dT)`` with ``tau y' = dT - y``, in two stages of half the time where that is asked for."""
    signals = drawn_signals(seed, 8)
    dT, span = signals.dT["T01"], 0.6 + 0.4 * signals.q
    parameters = {"sensor": "T01", "ratio": 0.4, "time_constant_s": tau}
    once = term_columns("lag", signals, parameters)[:, 0]
    assert np.allclose(once, span * (integrated(signals.time, dT, tau) - dT), atol=1e-6)
    twice = term_columns("lag", signals, parameters | {"order": 2})[:, 0]
    assert abs(twice[0]) < 1e-15
    steady = LegSignals(signals.time, {"T01": np.full(8, 3.0)}, signals.q, 0.6)
    assert np.abs(term_columns("lag", steady, parameters | {"order": 2})).max() < 1e-12


def test_a_low_pass_of_many_rows_is_its_recursion_over_any_gap(rng: np.random.Generator) -> None:
    """3000 rows at uneven steps, gaps of a day among them: each row is the step of a linear piece from the last one."""
    steps = rng.uniform(1.0, 30.0, 3000)
    steps[[400, 401, 2500]] = 86400.0
    time, values, tau = np.cumsum(steps), np.cumsum(rng.standard_normal((3000, 2)), axis=0), 25.0
    wanted = np.empty_like(values)
    wanted[0] = values[0]
    for i in range(1, len(time)):
        step, slope = steps[i], (values[i] - values[i - 1]) / steps[i]
        held = wanted[i - 1] - values[i - 1] + tau * slope
        wanted[i] = values[i] - tau * slope + held * np.exp(-step / tau)
    found = Memory().low_pass("one", time, values, tau)
    np.testing.assert_allclose(found, wanted, rtol=0.0, atol=1e-10)
    memory = Memory()
    blocks = [memory.low_pass("one", time[part], values[part], tau) for part in np.split(np.arange(3000), [1, 2, 700])]
    np.testing.assert_allclose(np.concatenate(blocks), found, rtol=0.0, atol=1e-12)


def test_what_others_foretell_is_their_sum_less_that_sum_late() -> None:
    """``(q0 + r q) (F - low_pass(F))``, F the weighted sum of the others; the sensor's own reading plays no part."""
    signals = drawn_signals(5, 8)
    both = 0.4 * signals.dT["T02"] + 0.7 * signals.dT["T03"]
    parameters = {"sensor": "T01", "weights": {"T02": 0.4, "T03": 0.7}, "ratio": 0.4, "time_constant_s": 900.0}
    lacks = term_columns("foretold", signals, parameters)[:, 0]
    assert np.allclose(lacks, (0.6 + 0.4 * signals.q) * (both - integrated(signals.time, both, 900.0)), atol=1e-6)
    term = LegTerm("thermal-lag", "foretold", parameters, [1e-6])
    assert sensors_of((term,)) == ("T01", "T02", "T03")
    assert sensors_of((term.reading({"T02": "T01", "T01": "T02"}),)) == ("T02", "T01", "T03")


def test_squares_of_several_places_are_added_by_their_weights() -> None:
    """``(q0 + r q) sum_w w (u^2 - u0^2)``, u in degC from the reference; the law reads the places that have weights."""
    signals = dataclasses.replace(drawn_signals(6, 9), zero_degC={"T01": 19.5, "T02": 23.0, "T03": 21.0})
    own = {"sensor": "T01", "weights": {"T02": 0.4, "T03": 0.6}, "ratio": 0.7, "reference_degC": 20.0}
    u = {name: signals.zero_degC[name] + signals.dT[name] - 20.0 for name in ("T02", "T03")}
    squares = 0.4 * (u["T02"] ** 2 - 3.0**2) + 0.6 * (u["T03"] ** 2 - 1.0**2)
    found = term_columns("square", signals, own)[:, 0]
    assert np.allclose(found, (0.6 + 0.7 * signals.q) * squares, rtol=1e-12, atol=0.0)
    assert sensors_of((LegTerm("nonlinear-expansion", "square", own, [1e-9]),)) == ("T02", "T03")
    # a stroke that was right at 20 degC: the same whichever place tells the zero, since u counts from there
    right = term_columns("square", signals, {**own, "calibration_degC": 20.0})[:, 0]
    assert np.allclose(right - found, 0.7 * (signals.q - signals.q[0]) * (0.4 * 3.0**2 + 0.6 * 1.0**2))


@given(seed=st.integers(0, 10**6))
def test_shapes_of_motion_are_their_recursions(seed: int) -> None:
    """Direction, relaxation and heat of motion, written as a loop over rows."""
    signals = drawn_signals(seed, 60)
    t, q = signals.time, signals.q
    last, heat = 0.0, [0.0]
    ends: list[float] = []
    before = 0.0
    for k in range(60):
        moved = q[k] - q[k - 1] if k else 0.0
        moved = moved if abs(moved) > 2e-6 else 0.0
        last = np.sign(moved) if moved else last
        if moved and moved * before > 0.0:
            ends[-1] = t[k]
        elif moved:
            ends.append(t[k])
        before = moved
        decayed = sum(np.exp(-(t[k] - end) / 300.0) for end in ends)
        if k:
            heat.append((abs(moved) / (t[k] - t[k - 1])) ** 2)
        assert term_columns("direction", signals, {})[k, 0] == 0.5 * last
        kicked = term_columns("relaxation", signals, {"time_constant_s": 300.0, "kick": "move"})[k, 0]
        assert kicked == pytest.approx(decayed, abs=1e-12)
    stored = term_columns("stored-heat", signals, {"source": "motion", "power": 2, "time_constant_s": 0.0})
    assert np.allclose(stored[:, 0], heat, atol=1e-18)


def test_heat_may_pass_through_what_is_rubbed_first() -> None:
    """With a time constant of the source it is the heat behind two low passes in turn; with 0 behind one."""
    signals = drawn_signals(5, 60)
    own = {"source": "motion", "power": 1}

    def stored(**times: float) -> FloatArray:
        return term_columns("stored-heat", signals, own | times)

    rubbed, speed = np.zeros(60), Memory().speed(signals.time, signals.q)
    for k, step in enumerate(np.diff(signals.time)):
        rubbed[k + 1] = speed[k + 1] + (rubbed[k] - speed[k + 1]) * np.exp(-step / 200.0)
    wanted = Memory().low_pass("warm", signals.time, rubbed, 900.0)
    both = stored(source_time_constant_s=200.0, time_constant_s=900.0)
    np.testing.assert_allclose(both[:, 0], wanted - wanted[0], atol=1e-18)
    assert np.abs(both).max() < np.abs(stored(time_constant_s=900.0)).max()
    np.testing.assert_array_equal(
        stored(source_time_constant_s=0.0, time_constant_s=900.0), stored(time_constant_s=900.0)
    )


def test_heat_of_motion_does_not_depend_on_when_rows_are_taken() -> None:
    """Rows close together in motion and far apart at rest, or a gap from within a move on, store the same heat."""
    fine = np.arange(0.0, 3601.0)
    q = 0.1 * np.clip((fine - 600.0) / 10.0, 0.0, 1.0)
    parameters = {"source": "motion", "power": 1, "time_constant_s": 1800.0}

    def left(rows: FloatArray) -> float:
        """Heat in the last row of those that are taken."""
        signals = LegSignals(rows, {}, np.interp(rows, fine, q))
        return float(term_columns("stored-heat", signals, parameters)[-1, 0])

    every = left(fine)
    assert every == pytest.approx(0.1 / 1800.0 * np.exp(-2995.0 / 1800.0), rel=1e-3)
    dense = np.unique(np.concatenate([np.arange(0.0, 3601.0, 60.0), np.arange(600.0, 611.0)]))
    assert left(dense) == pytest.approx(every, rel=1e-6)
    gap = np.concatenate([np.arange(0.0, 606.0), np.arange(900.0, 3601.0, 20.0)])
    assert left(gap) == pytest.approx(every, rel=0.1)  # when the rod came to rest is not known


def test_heat_may_last_as_long_as_anything_moves() -> None:
    """Of power 0: strokes back and forth between rows count by their time, at whatever speed; rest does not."""
    fine = np.arange(0.0, 7201.0)
    works = ((fine > 600.0) & (fine < 1500.0)) | ((fine > 4000.0) & (fine < 4300.0))
    q = 0.1 + 0.05 * works * np.sin(2.0 * np.pi * fine / 7.3) * np.where(fine < 2000.0, 1.0, 0.3)
    rows = np.arange(0.0, 7201.0, 20.0)
    signals, heat = LegSignals(rows, {}, np.interp(rows, fine, q)), {"source": "motion", "time_constant_s": 900.0}

    wanted = Memory().low_pass("heat", fine, works.astype(np.float64), 900.0, held=True)[::20]
    told = term_columns("stored-heat", signals, heat | {"power": 0})[:, 0]
    by_way = term_columns("stored-heat", signals, heat | {"power": 1})[:, 0]
    np.testing.assert_allclose(told, wanted, atol=0.02)
    assert np.corrcoef(by_way, wanted)[0, 1] < 0.97 < 0.999 < np.corrcoef(told, wanted)[0, 1]
    rested = LegSignals(rows, {}, np.full(len(rows), 0.1))
    assert not term_columns("stored-heat", rested, heat | {"power": 0}).any()


def test_what_is_rubbed_may_expand_itself() -> None:
    """A share of the expansion is that of what is rubbed, the rest that of what it warms; with 0 or 1 all of one."""
    signals = drawn_signals(5, 60)
    both = {"source": "motion", "source_time_constant_s": 200.0, "time_constant_s": 900.0}

    def stored(**own: float) -> FloatArray:
        return term_columns("stored-heat", signals, both | own)

    rubbed = stored(source_time_constant_s=0.0, time_constant_s=200.0)
    np.testing.assert_allclose(stored(source_share=0.3), 0.7 * stored() + 0.3 * rubbed, atol=1e-18)
    np.testing.assert_array_equal(stored(source_share=0.0), stored())
    np.testing.assert_allclose(stored(source_share=1.0), rubbed, atol=1e-18)


def test_the_air_in_a_tube_follows_that_at_the_station() -> None:
    """With a time constant the index is behind a low pass, the path as it is; with 0 it is that at the station."""
    signals = drawn_signals(4, 50)
    own = {"path_m": 0.7, "stroke_share": 1.0}
    late = Memory().low_pass("late", signals.time, signals.recorded("index"), 600.0)
    found = term_columns("air-index", signals, own | {"time_constant_s": 600.0})[:, 0]
    np.testing.assert_allclose(found, (0.7 + signals.q) * late, atol=1e-20)
    at_once = term_columns("air-index", signals, own)
    assert np.abs(found - at_once[:, 0]).max() > 0.1 * np.abs(at_once).max()
    np.testing.assert_array_equal(term_columns("air-index", signals, own | {"time_constant_s": 0.0}), at_once)


def test_a_cube_goes_with_the_sign_of_the_warming() -> None:
    """It is ``(q0 + ratio q) dT^3``: cooling by as much gives its negative."""
    signals = drawn_signals(4, 50)
    cold = dataclasses.replace(signals, dT={name: -values for name, values in signals.dT.items()})
    own = {"sensor": "T01", "ratio": 0.5}
    found = term_columns("cube", signals, own)[:, 0]
    np.testing.assert_allclose(found, signals.span(0.5) * signals.temperature("T01") ** 3, rtol=1e-12)
    np.testing.assert_array_equal(term_columns("cube", cold, own)[:, 0], -found)


def test_a_short_move_kicks_in_part() -> None:
    """With a saturation a move of length L kicks by ``1 - exp(-L / saturation)``, with its sign where it has one."""
    t = np.arange(0.0, 100.0, 10.0)
    for kick, sign in (("move", 1.0), ("direction", -1.0)):
        signals = LegSignals(t, {}, np.where(t < 5.0, 0.2, 0.193))
        settings = {"time_constant_s": 60.0, "kick": kick, "saturation_m": 0.004}
        left = term_columns("relaxation", signals, settings)[:, 0]
        assert left[1] == pytest.approx(-sign * np.expm1(-7.0 / 4.0), abs=1e-12)
        assert left[-1] == pytest.approx(left[1] * np.exp(-80.0 / 60.0), abs=1e-12)


def test_a_laser_with_a_fixed_index_reads_a_wrong_path() -> None:
    """What is read less what is true, ``(path + q) (n - n_r)`` from the zero on, is the term's column."""
    signals = drawn_signals(4, 50)
    index, q = 1.00027 + signals.recorded("index"), signals.q
    wrong = (0.7 + q) * (index - 1.000265)
    settings = {"path_m": 0.7, "stroke_share": 1.0, "reference_index": 1.000265}
    assert np.allclose(term_columns("air-index", signals, settings)[:, 0], wrong - wrong[0], atol=1e-15)
    with pytest.raises(ArgumentError, match="index of refraction of the air at the zero"):
        term_columns("air-index", dataclasses.replace(signals, zero_index=None), settings)


def test_the_pressure_alone_may_not_have_been_applied() -> None:
    """Then n is that of air as warm and humid as at the zero: ``(path + q) (n - n_0)``; without it an error says so."""
    signals = drawn_signals(4, 50)
    settings = {"path_m": 0.7, "stroke_share": 1.0, "weather": "pressure"}
    wanted = (0.7 + signals.q) * signals.recorded("pressure_index")
    assert np.array_equal(term_columns("air-index", signals, settings)[:, 0], wanted)
    with pytest.raises(ArgumentError, match="needs the air's pressure along the run"):
        term_columns("air-index", dataclasses.replace(signals, pressure_index=None), settings)


def test_the_air_s_temperature_alone_may_not_have_been_applied() -> None:
    """Then what is read goes with it at once, by Ciddor's sensitivity to 4 % between 15 and 25 degC."""
    signals = drawn_signals(4, 50)
    settings = {"path_m": 0.7, "stroke_share": 1.0, "weather": "temperature"}
    wanted = (0.7 + signals.q) * INDEX_PER_K * signals.recorded("air")
    assert np.allclose(term_columns("air-index", signals, settings)[:, 0], wanted, atol=1e-18)
    for warm in (15.0, 20.0, 25.0):
        sensitivity = index_sensitivity(633e-9, warm, 101325.0, 0.5).temperature
        assert INDEX_PER_K == pytest.approx(float(sensitivity), rel=0.04)
    with pytest.raises(ArgumentError, match="'pressure' or 'temperature' or left out"):
        term_columns("air-index", signals, settings | {"weather": "humidity"})


def test_a_relaxation_does_not_ask_how_often_a_move_was_logged() -> None:
    """The same moves logged every 2 s and every 20 s leave the same, of whatever kick, one time or decades of them."""
    knots, places = [0.0, 100.0, 140.0, 600.0, 660.0, 700.0, 2000.0], [0.2, 0.2, 0.22, 0.22, 0.25, 0.24, 0.24]
    found = {}
    for step in (2.0, 20.0):
        t = np.arange(0.0, 2001.0, step)
        signals = LegSignals(t, {}, np.interp(t, knots, places))
        found[step] = [
            term_columns("relaxation", signals, {"time_constant_s": 150.0, "kick": kick, "decades": decades})[:, 0]
            for kick in ("direction", "move", "step") for decades in (0.0, 2.0)
        ]  # fmt: skip
    for fine, coarse in zip(found[2.0], found[20.0], strict=True):
        assert np.allclose(fine[::10], coarse, atol=1e-12)
        assert np.ptp(coarse) > 0.3


def test_relaxations_over_decades_go_with_the_logarithm_of_time() -> None:
    """Between the shortest and the longest time equal ratios of time take equal parts."""
    t = np.concatenate([[0.0, 1.0], np.geomspace(2.0, 1e5, 400)])
    signals = LegSignals(t, {}, np.where(t < 1.0, 0.2, 0.21))
    left = term_columns("relaxation", signals, {"time_constant_s": 10.0, "kick": "move", "decades": 3.0})[:, 0]
    lost = -np.diff(np.interp(np.log(np.geomspace(40.0, 4000.0, 6)), np.log(t[1:] - 0.999), left[1:]))
    assert np.allclose(lost, lost.mean(), rtol=0.1)
    assert left[1] == 1.0
    assert left[-1] < 1e-3


@given(seed=st.integers(0, 10**6), middle=st.floats(15.0, 28.0))
def test_a_square_counts_from_its_middle_and_a_bend_is_one_there(seed: int, middle: float) -> None:
    """``(T - T_m)^2`` less that of the zero, times the span; a wide bend is that square, a narrow one two lines."""
    signals = drawn_signals(seed, 40)
    span, T0 = 0.6 + 0.4 * signals.q, signals.zero_of("T01")
    T = T0 + signals.dT["T01"]
    own = {"sensor": "T01", "ratio": 0.4}
    square = term_columns("square", signals, own | {"reference_degC": middle})[:, 0]
    own |= {"middle_degC": middle}
    assert np.allclose(square, span * ((T - middle) ** 2 - (T0 - middle) ** 2), atol=1e-11)
    wide = term_columns("bend", signals, own | {"width_K": 1e3})[:, 0]
    assert np.allclose(wide, square, atol=1e-3 * (np.abs(square).max() + 1e-6))
    narrow = term_columns("bend", signals, own | {"width_K": 1e-4})[:, 0]
    assert np.allclose(narrow, 2e-4 * span * (np.abs(T - middle) - np.abs(T0 - middle)), atol=2e-8)


@pytest.mark.parametrize(("shape", "own"), [
    ("square", {"reference_degC": 20.0}),
    ("square", {"reference_degC": 23.0}),
    ("bend", {"middle_degC": 22.0, "width_K": 1.5}),
])  # fmt: skip
def test_a_stroke_right_at_its_calibration_is_wrong_at_the_zero(shape: str, own: dict[str, float]) -> None:
    """A leg right at 20 degC has grown by ``(q0 + r q) (f(T) - f(20))``, which less that of the zero is the term."""
    signals = drawn_signals(7, 60)
    signals = dataclasses.replace(signals, dT={"T01": signals.dT["T01"] - signals.dT["T01"][0]})

    def grown(T: np.ndarray) -> np.ndarray:
        if shape == "square":
            return np.asarray((T - own["reference_degC"]) ** 2)
        return np.asarray(2.0 * 1.5**2 * np.log(np.cosh((T - 22.0) / 1.5)))

    T = 21.3 + signals.dT["T01"]
    length = (0.6 + 0.4 * signals.q) * (grown(T) - grown(np.array(20.0)))
    parameters = {"sensor": "T01", "ratio": 0.4, "calibration_degC": 20.0} | own
    found = term_columns(shape, signals, parameters)[:, 0]
    np.testing.assert_allclose(found, length - length[0], rtol=0.0, atol=1e-12)


def test_a_square_from_a_middle_needs_the_zero() -> None:
    """Without the temperature of the zero it is refused, by the sensor's name; counted from the zero it is not."""
    signals = LegSignals(np.zeros(2), {"T01": np.array([0.0, 2.0])}, np.zeros(2), 0.5)
    assert term_columns("square", signals, {"sensor": "T01", "ratio": 0.0})[1, 0] == 2.0
    with pytest.raises(ArgumentError, match="temperature of sensor 'T01' at the zero"):
        term_columns("square", signals, {"sensor": "T01", "ratio": 0.0, "reference_degC": 20.0})


def test_every_shape_has_an_example_a_unit_and_rules() -> None:
    """So that none is forgotten by the files and by the tests of streams; examples have as many amplitudes as told."""
    for shape, examples in EXAMPLES.items():
        for cause, parameters, amplitudes in examples:
            term = LegTerm(cause, shape, parameters, amplitudes)
            assert term.columns(drawn_signals(1)).shape == (160, COUNTS.get(shape, 1))
            named = {f"{key}m" if key.endswith("_m") else key for key in parameters}
            assert named <= set(PARAMETERS[shape])
    assert set(PARAMETERS) == set(EXAMPLES)
    assert set(UNITS) <= set(SHAPES)


def test_the_bench_is_not_the_leg() -> None:
    """Terms of the frame and of the interferometer are told from those of the leg."""
    terms = [
        LegTerm(cause, shape, own, sizes) for shape, examples in EXAMPLES.items() for cause, own, sizes in examples
    ]
    assert {term.cause for term in terms if of_bench(term)} == {
        "frame-expansion",
        "air-refraction",
        "abbe-tilt",
        "zero-drift",
    }


def test_wrong_terms_and_repairs_are_refused() -> None:
    """A shape or a repair that does not exist, a covariance of another size, a parameter too few or too many."""
    with pytest.raises(UnknownNameError, match="no shape 'sag'"):
        LegTerm("sag", "sag", {}, [1.0])
    with pytest.raises(ArgumentError, match="covariance has shape"):
        LegTerm("backlash", "direction", {}, [1.0], np.eye(2))
    with pytest.raises(UnknownNameError, match="no repair 'glue'"):
        SensorRepair("sensor-detached", "glue", {})
    with pytest.raises(ArgumentError, match="lacks rate_K_per_h"):
        SensorRepair("sensor-drift", "drift", {"sensor": "T01"})
    with pytest.raises(ArgumentError, match="does not know speed"):
        SensorRepair("clock-offset", "clock", {"offset_s": 1.0, "speed": 2.0})


def test_a_length_that_no_command_gives_is_refused() -> None:
    """A drift as large as the leg has no correction; one that jumps at the wanted length gets the nearest."""
    with pytest.raises(ArgumentError, match="no small part of the length"):
        solved_length(1.0, lambda length: -3.0 * length)
    found = solved_length(1.0, lambda length: 1e-6 if length >= 1.0 else -1e-6)
    assert abs(found - 1.0) < 3e-6


def test_terms_are_pickled() -> None:
    """And come back the same."""
    term = LegTerm("backlash", "direction", {}, [3e-7])
    back = pickle.loads(pickle.dumps(term))
    assert back == term
    assert back != LegTerm("backlash", "direction", {}, [3.1e-7])
    assert not back.amplitudes.flags.writeable
