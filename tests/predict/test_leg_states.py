"""Machines whose legs carry terms: exact where a row tells all, row after row where legs remember."""

from __future__ import annotations

import dataclasses
import json
import pickle
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import hexathermal as ht
from hexathermal.cli import main
from hexathermal.errors import ArgumentError, FileFormatError, OutOfStrokeError, ThermalModelError
from hexathermal.learn.leg_law_files import write_leg_law
from hexathermal.machine.leg_repairs import SensorRepair
from hexathermal.machine.leg_signals import LegSignals
from hexathermal.machine.leg_states import STATELESS, of_bench
from hexathermal.machine.leg_terms import LegTerm
from hexathermal.predict.budget_blocks import blocks
from hexathermal.predict.budget_inputs import situation
from tests.learn.extended_laws import EXAMPLES, law_with, terms_of
from tests.machines import random_poses
from tests.predict.remembering import LAG, MACHINE, ONE_ROW, Q0, SCALE, SCREW, SLACK, STATES, motion, with_terms


@given(seed=st.integers(0, 10**6))
def test_terms_of_a_row_are_corrected_exactly(seed: int) -> None:
    """The platform stands at the wanted pose to 1e-12 m; the drift is the equations written out."""
    rng = np.random.default_rng(seed)
    poses = random_poses(MACHINE, 3, rng)
    temps = rng.uniform(15.0, 30.0, (3, 7))
    told = MACHINE.corrected_leg_lengths(poses, temps)
    assert np.abs(MACHINE.predicted_pose(told, temps) - poses).max() < 1e-12
    q, dT = told - Q0, temps[:, :6] - 20.0
    law = MACHINE.thermal.legs[0]
    added = (Q0 + 0.5 * q) * 2e-8 * dT**2 + (Q0 + 0.3 * q) * 0.4e-6 * dT + 3e-6 * q
    added = added + 0.1e-6 * np.sin(2 * np.pi * q / 0.00203) - 0.2e-6 * (np.cos(2 * np.pi * q / 0.00203) - 1.0)
    assert np.abs(MACHINE.leg_drift(told, temps) - (law.A * Q0 + law.B * q) * dT - added).max() < 1e-15
    sent = MACHINE.corrected_pose(poses, temps)
    assert np.abs(MACHINE.inverse_kinematics(sent) - told).max() < 1e-12


def test_every_way_of_calling_gives_the_same() -> None:
    """One pose or many, one set of temperatures or many, a mapping, an SE3."""
    import pinocchio as pin

    rng = np.random.default_rng(3)
    poses, temps = random_poses(MACHINE, 4, rng), rng.uniform(15.0, 30.0, (4, 7))
    each = np.array([MACHINE.corrected_leg_lengths(T, t) for T, t in zip(poses, temps, strict=True)])
    assert np.abs(MACHINE.corrected_leg_lengths(poses, temps) - each).max() < 1e-15
    grid = MACHINE.corrected_leg_lengths(poses[:, None], temps[None])
    assert grid.shape == (4, 4, 6)
    assert np.abs(grid[[0, 1, 2, 3], [0, 1, 2, 3]] - each).max() < 1e-15
    named = dict(zip(MACHINE.sensor_names, temps[0], strict=True))
    assert np.array_equal(MACHINE.corrected_leg_lengths(pin.SE3(poses[0]), named), each[0])


def test_a_command_out_of_stroke_is_refused_with_its_terms() -> None:
    """A scale error of 1e-3 makes a leg near its end ask for more than the stroke; the other legs are not blamed."""
    wild = with_terms(LegTerm("scale-error", "position", {}, [-1e-3]), legs=(2,))
    longest = wild.length_limits[1][2]
    heights = np.arange(80.0, 200.0, 0.05)
    above = ht.pose_from_coordinates(np.outer(heights, [0, 0, 1, 0, 0, 0]), hexapod=wild)
    pose = next(T for T in above if wild.inverse_kinematics(T)[2] > longest - 1e-4)
    assert (wild.inverse_kinematics(pose) < longest).all()
    with pytest.raises(OutOfStrokeError) as caught:
        wild.corrected_leg_lengths(pose, [20.0] * 7)
    assert caught.value.leg == 3


@pytest.mark.parametrize("term", STATES)
def test_states_are_refused_where_a_row_does_not_tell_them(term: LegTerm) -> None:
    """Every call of a single pose names the cause and what to call instead; without the states it works."""
    machine = with_terms(term, SCALE)
    home, temps = machine.home, [22.0] * 7
    calls = (
        lambda m: m.corrected_leg_lengths(home, np.array(temps)), lambda m: m.corrected_pose(home, temps),
        lambda m: m.predicted_pose(m.home_lengths, temps), lambda m: m.leg_drift(m.home_lengths, temps),
    )  # fmt: skip
    # of a backlash a budget counts both sides
    calls += () if term.shape == "direction" else (lambda m: m.error_budget(home, temps),)
    rest = dataclasses.replace(machine, thermal=machine.thermal.without_states())
    for call in calls:
        with pytest.raises(ThermalModelError, match=rf"{term.cause}.*leg_controllers.*without_states"):
            call(machine)
        call(rest)
    assert rest == with_terms(SCALE)


def test_legs_that_remember_are_corrected_to_zero() -> None:
    """Commands of rows one by one; the legs, warm by the same terms along those commands, hold the pose to 1e-12 m.

    The terms' drift is summed leg by leg over the whole motion at once, by another way than the controllers'.
    """
    machine, plain = with_terms(*STATES, *ONE_ROW), with_terms()
    poses, temps, time = motion(40)
    controllers = machine.leg_controllers()
    told = np.array([controllers.corrected_leg_lengths(*row) for row in zip(poses, temps, time, strict=True)])
    drift = plain.leg_drift(told, temps)
    for leg in range(6):
        before = LegSignals(time[:1], {"T1": np.zeros(1)}, np.zeros(1), Q0)
        rows = LegSignals(time, {"T1": temps[:, leg] - 20.0}, told[:, leg] - Q0, Q0)
        for term in (*STATES, *ONE_ROW):
            here = term.drift(rows)
            if term in (SCALE, SCREW):
                both = LegSignals(
                    np.concatenate([before.time, time]), {"T1": np.concatenate([[0.0], rows.dT["T1"]])},
                    np.concatenate([[0.0], rows.q]), Q0,
                )  # fmt: skip
                here = term.drift(both)[1:]
            drift[:, leg] += here
    wanted = plain.leg_drift(plain.corrected_leg_lengths(poses, temps), temps)
    wanted = wanted + plain.corrected_leg_lengths(poses, temps)
    assert np.abs(told + drift - wanted).max() < 1e-12
    assert np.abs(told - plain.corrected_leg_lengths(poses, temps)).max() > 1e-6


@pytest.mark.long
@pytest.mark.parametrize("cuts", [[40], [1, 2, 40], [17, 18, 33, 40]])
def test_rows_one_by_one_are_rows_in_blocks(cuts: list[int]) -> None:
    """To 1e-12 m, commands and drift."""
    machine = with_terms(*STATES, *ONE_ROW)
    poses, temps, time = motion(40)
    one, other, third = (machine.leg_controllers() for _ in range(3))
    single = np.array([one.corrected_leg_lengths(*row) for row in zip(poses, temps, time, strict=True)])
    starts = [0, *cuts[:-1]]
    blocks_ = [
        other.corrected_leg_lengths(poses[a:b], temps[a:b], time[a:b]) for a, b in zip(starts, cuts, strict=True)
    ]
    assert np.abs(np.concatenate(blocks_) - single).max() < 1e-12
    drift = np.concatenate(
        [third.leg_drift(single[a:b], temps[a:b], time[a:b]) for a, b in zip(starts, cuts, strict=True)]
    )
    cold = with_terms().leg_drift(with_terms().corrected_leg_lengths(poses, temps), temps)
    wanted = with_terms().corrected_leg_lengths(poses, temps) + cold
    assert np.abs(single + drift - wanted).max() < 1e-12


def test_a_reversal_within_the_scales_noise_ends() -> None:
    """Where no length solves the equation since the backlash jumps there, the leg is off by no more than the backlash,
    and what is remembered is what was commanded.
    """
    machine = with_terms(LegTerm("backlash", "direction", {}, [30e-6]))
    home, temps = machine.home, np.full(7, 22.0)
    one, plain = machine.leg_controllers(), with_terms()
    truth = machine.leg_controllers()
    told = []
    for k in range(40):
        pose = home @ ht.pose_from_coordinates([0, 0, 0.003 * np.sin(k) + 0.01 * (k % 3), 0, 0, 0])
        told.append(one.corrected_leg_lengths(pose, temps, float(k)))
        wanted = plain.corrected_leg_lengths(pose, temps) + plain.leg_drift(
            plain.corrected_leg_lengths(pose, temps), temps
        )
        true = told[-1] + truth.leg_drift(told[-1], temps, float(k))
        assert np.abs(true - wanted).max() < 31e-6
    assert [memory.terms[0]._kept for memory in one._memories] == [memory.terms[0]._kept for memory in truth._memories]


def test_what_was_reached_may_differ_from_what_was_asked() -> None:
    """`remember=False` asks only; `leg_drift` tells where the legs went; time that runs back is refused."""
    machine = with_terms(*STATES)
    poses, temps, time = motion(3)
    one, other = machine.leg_controllers(), machine.leg_controllers()
    for _ in range(3):
        told = one.corrected_leg_lengths(poses[0], temps[0], time[0], remember=False)
    one.leg_drift(told, temps[0], time[0])
    other.corrected_leg_lengths(poses[0], temps[0], time[0])
    next_row = (poses[1], temps[1], time[1])
    assert np.array_equal(one.corrected_leg_lengths(*next_row), other.corrected_leg_lengths(*next_row))
    with pytest.raises(ArgumentError, match="never decrease"):
        one.corrected_leg_lengths(poses[2], temps[2], time[0])
    with pytest.raises(ArgumentError, match="no rows in the order of time"):
        one.corrected_leg_lengths(poses[None], temps[2], time)
    with pytest.raises(ArgumentError, match="one set for each of 1 rows"):
        one.corrected_leg_lengths(poses[2], temps, time[2])
    with pytest.raises(ArgumentError, match="one set for each of 1 rows"):
        one.leg_drift(told, temps, time[2])
    assert with_terms(SCALE).corrected_leg_lengths(poses[:0], temps[0]).shape == (0, 6)
    with pytest.raises(ArgumentError, match="expected 1 values"):
        one.corrected_leg_lengths(poses[2], temps[2], time)
    heat = LegTerm("hidden-heat", "stored-heat", {"source": "pump_W", "time_constant_s": 60.0}, [1e-9])
    pumped = with_terms(heat).leg_controllers()
    with pytest.raises(ArgumentError, match="recorded input 'pump_W'"):
        pumped.corrected_leg_lengths(poses[0], temps[0], 0.0)
    cold = pumped.corrected_leg_lengths(poses[0], temps[0], 0.0, inputs={"pump_W": 0.0})
    warm = pumped.corrected_leg_lengths(poses[0], temps[0], 600.0, inputs={"pump_W": 1000.0})
    assert (warm < cold).all()


def test_a_budget_holds_the_terms() -> None:
    """What correction leaves is nothing, the drift is the predicted pose's; rates are those of the true machine."""
    rng = np.random.default_rng(9)
    pose, temps = random_poses(MACHINE, 1, rng)[0], rng.uniform(16.0, 30.0, 7)
    laws = MACHINE.thermal
    model = ht.ThermalModel(laws.legs, laws.platform, None, laws.reference_temperature_degC, laws.valid_degC)
    machine = dataclasses.replace(MACHINE, thermal=model)
    budget = machine.error_budget(pose, temps)
    assert np.abs(budget.remaining).max() < 1e-12
    drifted = machine.predicted_pose(machine.inverse_kinematics(pose), temps)
    assert np.abs(budget.uncorrected[:3] - (drifted - pose)[:3, 3]).max() < 1e-12
    assert np.abs(budget.uncorrected - with_terms().error_budget(pose, temps).uncorrected).max() > 1e-7
    here = situation(machine, pose, temps, air_degC=18.0)
    rates = here.rates()
    for quantity in ("temperature", "gain", "contact", "reference temperature", "coefficients", "length", "amplitudes"):
        for k in blocks(machine, quantity)[0]:
            x = np.zeros((2, here.size))
            h = {"coefficients": 1e-9, "length": 1e-6, "amplitudes": 1e-9, "temperature": 0.05}.get(quantity, 0.01)
            x[:, k] = h, -h
            above, below = here.errors(x)
            assert np.abs((above - below) / (2 * h) - rates[:, k]).max() < 1e-6 * max(1.0, np.abs(rates[:, k]).max())


def test_a_budget_counts_the_amplitudes() -> None:
    """With their covariance where all terms state one, else with 3 % of each; common to legs of one law; by Monte Carlo
    too. A machine without terms has no such source, and cannot be given one.
    """
    known = [dataclasses.replace(term, covariance=np.diag((0.1 * term.amplitudes) ** 2)) for term in ONE_ROW]
    home, temps = MACHINE.home, [26.0] * 7
    part = {}
    for name, machine in (("guess", MACHINE), ("known", with_terms(*known)), ("some", with_terms(*known, legs=(0, 3)))):
        budget = machine.error_budget(home, temps)
        part[name] = next(one for one in budget.contributions if one.label == "terms of the law")
    assert np.allclose(part["known"].uncertainty, 10.0 / 3.0 * part["guess"].uncertainty, rtol=1e-9, atol=1e-13)
    assert part["some"].covariance[2, 2] > 0.0
    assert part["known"].basis == "covariance of the law"
    source = ht.Sources([one for one in ht.default_sources(with_terms(*known)) if one.label == "terms of the law"])
    drawn = ht.monte_carlo(with_terms(*known), home, temps, source, least_draws=20_000, most_draws=20_000, seed=4)
    assert np.allclose(np.sqrt(np.diag(drawn.covariance)), part["known"].uncertainty, rtol=0.05, atol=1e-10)
    assert all(one.label != "terms of the law" for one in ht.default_sources(with_terms()))
    with pytest.raises(ArgumentError, match="of which the machine has none"):
        with_terms().error_budget(home, temps, [ht.Source("x", "amplitudes", 1e-7)])


def test_a_machine_with_terms_is_written_and_read(tmp_path: Path) -> None:
    """To the last bit, one law for all or six; pickled too; a machine without terms is not told from before."""
    for machine in (with_terms(*ONE_ROW, *STATES), with_terms(LAG, SCREW, legs=(1, 4))):
        assert ht.load_hexapod(ht.write_hexapod(machine, tmp_path / "m")) == machine
        assert pickle.loads(pickle.dumps(machine)) == machine
        assert machine != with_terms()
    assert "terms" not in ht.write_hexapod(with_terms(), tmp_path / "plain").read_text(encoding="utf-8")


@pytest.mark.parametrize(("old", "new", "said"), [
    ('shape = "lag"', 'shape = "lagging"', "thermal.leg.terms[0].shape must be one of"),
    ("time_constant_s = 900.0", "time_constant_s = -1", "thermal.leg.terms[0].time_constant_s must be above 0"),
    ('unit = "1/K"', 'unit = "um"', "thermal.leg.terms[0].unit of shape 'lag' must be '1/K'"),
    ('sensor = "T1"\nratio', 'sensor = "T9"\nratio', "a term reads sensor 'T9', which the leg law does not name"),
    ('cause = "backlash"', 'cause = "zero-drift"', "term 'zero-drift' tells of a bench"),
])  # fmt: skip
def test_a_bad_term_of_a_machine_is_named(tmp_path: Path, old: str, new: str, said: str) -> None:
    """With line and column."""
    file = ht.write_hexapod(with_terms(LAG, SLACK), tmp_path)
    text = file.read_text(encoding="utf-8")
    assert old in text
    file.write_text(text.replace(old, new), encoding="utf-8")
    with pytest.raises(FileFormatError) as caught:
        ht.load_hexapod(file)
    assert said in str(caught.value)
    assert caught.value.problems[0].line > text[: text.index("[[thermal.leg.terms]]")].count("\n")


def test_apply_carries_what_is_of_the_leg(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """From leg.toml with a term of each shape to a machine: terms of the bench and repairs stay behind, and it is said;
    sensors that only terms read are asked for; the machine's drift is the law's.
    """
    every = tuple(term for shape in EXAMPLES for term in terms_of(shape))
    law = law_with(every, (SensorRepair("swapped-sensors", "swap", {"first": "T01", "second": "T02"}),))
    file, answer = write_leg_law(law, tmp_path / "leg.toml"), tmp_path / "a.json"
    assert (
        main(["apply", str(file), "--machine", "reference", "--out", str(tmp_path / "m"), "--json", str(answer)]) == 0
    )
    told = capsys.readouterr()
    facts = json.loads(answer.read_text(encoding="utf-8"))
    machine = ht.load_hexapod(tmp_path / "m")
    kept = [term for term in every if not of_bench(term)]
    assert [term.cause for term in machine.thermal.legs[0].terms] == [term.cause for term in kept]
    assert machine.thermal.legs[0].sensors == ("T01", "T02", "T03")
    assert facts["terms"] == list(dict.fromkeys(term.cause for term in kept))
    assert facts["states"] == ["thermal-lag", "hidden-heat", "backlash", "creep"]
    assert "frame-expansion, air-refraction, abbe-tilt, zero-drift: left out" in told.err
    assert "swapped-sensors: not applied" in told.err
    assert "give 'hexathermal correct' poses with time_s" in told.out
    assert main(["apply", str(file), "--machine", "reference", "--out", str(tmp_path / "r"), "--at-rest"]) == 0
    assert not ht.load_hexapod(tmp_path / "r").thermal.states
    assert "thermal-lag, hidden-heat, backlash, creep: left out, as --at-rest asks" in capsys.readouterr().err
    one = law_with(
        tuple(term for term in kept if term.shape in STATELESS and term.shape not in ("position", "periodic"))
    )
    q, dT = np.linspace(0.0, 0.25, 6), np.array([3.0, -1.0, 2.0])
    names = [f"T0{k + 1}" for k in range(3)]
    rows = LegSignals(np.zeros(6), {name: np.full(6, dT[k]) for k, name in enumerate(names)}, q, Q0,
                      zero_degC=dict.fromkeys(names, 20.0))  # fmt: skip
    write_leg_law(one, file)
    assert main(["apply", str(file), "--machine", "reference", "--out", str(tmp_path / "n")]) == 0
    drift = ht.load_hexapod(tmp_path / "n").leg_drift(Q0 + q, np.tile(20.0 + dT, 6))
    assert np.abs(drift - one.predict_signals(rows)).max() < 1e-15
    capsys.readouterr()
