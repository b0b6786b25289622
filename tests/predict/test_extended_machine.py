"""Extended machines are used as they are: corrected, predicted, followed along trajectories, budgeted, drawn."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import hexathermal as ht
from hexathermal.errors import ArgumentError, HexathermalError, NotConvergedError, ThermalModelError
from hexathermal.machine.compliance import Compliance
from hexathermal.machine.leg_terms import LegTerm
from hexathermal.machine.pinocchio_model import PinocchioMachine
from hexathermal.predict.budget_blocks import blocks
from hexathermal.predict.budget_inputs import situation
from hexathermal.predict.budget_load import OF_LOAD
from hexathermal.predict.budget_maps import graded_temperatures
from hexathermal.predict.measuring import machine_poses, measured_poses
from hexathermal.predict.pose_errors import pose_errors
from hexathermal.predict.trajectory import POSE_COLUMNS, correct_trajectory
from tests.extended_machines import SCREW, SLACK, extended_machine

POSE = ht.pose_from_coordinates([5.0, -10.0, 12.0, 1.0, 1.5, -2.0])


def some_rows(rng: np.random.Generator, count: int, spread: float = 5.0) -> tuple[np.ndarray, np.ndarray]:
    """Return poses about the reference machine's home and temperatures of an extended machine."""
    poses = ht.pose_from_coordinates(rng.uniform(-1, 1, (count, 6)) * [30, 30, 30, 5, 5, 5])
    return poses, 22.0 + rng.normal(size=(count, 13)) * spread / 3.0


@settings(max_examples=30)
@given(seed=st.integers(0, 10**9))
def test_a_corrected_machine_stands_where_it_should(seed: int) -> None:
    """predicted(corrected(pose)) is the pose to 1e-12 m, with every extension at once, however it is called."""
    rng = np.random.default_rng(seed)
    machine = extended_machine(rng)
    poses, temps = some_rows(rng, 3)
    lengths = machine.corrected_leg_lengths(poses, temps)
    assert np.abs(machine.predicted_pose(lengths, temps) - poses).max() < 1e-12
    one = machine.corrected_leg_lengths(poses[1].copy(), temps[1].copy())
    assert np.abs(one - lengths[1]).max() < 1e-15
    by_name = dict(zip(machine.sensor_names, temps[1], strict=True))
    assert np.array_equal(machine.corrected_leg_lengths(poses[1], by_name), one)
    assert np.abs(machine.predicted_pose(one, by_name) - poses[1]).max() < 1e-12
    grid = machine.corrected_leg_lengths(poses[:, None], temps[None, :2])
    assert np.abs(grid[1, 1] - one).max() < 1e-15
    assert np.abs(machine.predicted_pose(grid, temps[:2]) - poses[:, None]).max() < 1e-12
    sent = machine.inverse_kinematics(machine.corrected_pose(poses, temps))
    assert np.abs(sent - lengths).max() < 1e-12


@pytest.mark.parametrize("seed", range(4))
def test_legs_are_told_drift_and_sag_written_out(seed: int) -> None:
    """Where the platform stands, each leg is ``told + law + term + sag`` long to 1e-12 m, with Pinocchio's forces."""
    rng = np.random.default_rng(seed)
    machine = extended_machine(rng)
    (pose,), (temps,) = some_rows(rng, 1)
    told, model, soft = machine.inverse_kinematics(pose), machine.thermal, machine.compliance
    reached = machine.predicted_pose(told, temps)
    read = dict(zip(model.sensor_names, temps - model.reference_temperature_degC, strict=True))
    true = told.copy()
    for leg, law in enumerate(model.legs):
        dT = np.array([read[f"leg{model.thermometers_of_leg[leg]}_{name}"] for name in law.sensors])
        q0 = machine.retracted_length[leg]
        true[leg] += law.A @ dT * q0 + law.B @ dT * (told[leg] - q0)
        for term in law.terms:
            waves = 2.0 * np.pi * (told[leg] - q0) / term.parameters["pitch_m"]
            true[leg] += term.amplitudes @ [np.sin(waves), np.cos(waves) - 1.0]
    loaded = PinocchioMachine(machine, soft.payload_mass, soft.payload_centre, soft.gravity).leg_forces(reached)
    alone = PinocchioMachine(machine, gravity=soft.gravity).leg_forces(reached)
    true -= soft.leg_compliance * (loaded - alone)
    p = machine.platform_joints * (1.0 + model.platform.expansion * read["platform_T1"])
    b = machine.base_joints * (1.0 + model.base.expansion * read["base_T1"])
    spans = np.linalg.norm(p @ reached[:3, :3].T + reached[:3, 3] - b, axis=1)
    assert np.abs(spans - true).max() < 1e-12


def test_exchanged_plugs_are_exchanged_columns(reference: ht.Hexapod, rng: np.random.Generator) -> None:
    """A machine whose legs 3 and 4 are told by each other's thermometers is the drawn one with these columns exchanged:
    lengths, poses, budgets and their parts.
    """
    laws = [ht.LegLaw("T1", rng.normal(2e-6, 2e-7), 1e-6) for _leg in range(6)]
    plain = dataclasses.replace(reference, thermal=ht.ThermalModel(laws))
    order = [0, 1, 3, 2, 4, 5]
    swapped = dataclasses.replace(
        plain, thermal=dataclasses.replace(plain.thermal, thermometers_of_leg=[1, 2, 4, 3, 5, 6])
    )
    assert swapped.sensor_names == plain.sensor_names
    poses, temps = some_rows(rng, 100)[0], rng.uniform(15, 30, (100, 6))
    lengths = plain.corrected_leg_lengths(poses, temps)
    assert np.array_equal(swapped.corrected_leg_lengths(poses, temps[:, order]), lengths)
    assert np.array_equal(swapped.predicted_pose(lengths, temps[:, order]), plain.predicted_pose(lengths, temps))
    one, other = plain.error_budget(POSE, temps[0]), swapped.error_budget(POSE, temps[0, order])
    assert np.abs(one.remaining).max() < 1e-14
    assert np.allclose(one.covariance, other.covariance, rtol=1e-12, atol=0.0)
    here, there = situation(plain, POSE, temps[0]), situation(swapped, POSE, temps[0, order])
    for quantity in ("temperature", "gain", "contact"):
        rates = here.rates()[:, blocks(plain, quantity)[0]][:, order]
        assert np.allclose(there.rates()[:, blocks(swapped, quantity)[0]], rates, rtol=1e-12, atol=1e-20)
    for quantity in ("coefficients", "growth", "length"):
        rates = here.rates()[:, blocks(plain, quantity)[0]]
        assert np.allclose(there.rates()[:, blocks(swapped, quantity)[0]], rates, rtol=1e-12, atol=1e-20)
    gradients = graded_temperatures(swapped, 21.0, [1.0, 2.0, 0.5])
    assert np.array_equal(gradients[order], graded_temperatures(plain, 21.0, [1.0, 2.0, 0.5]))


def test_a_trajectory_is_that_of_the_extended_machine(tmp_path: Path, rng: np.random.Generator) -> None:
    """`correct` writes, for temperatures by their recorded names in any order, the lengths of the extended machine."""
    machine = extended_machine(rng)
    coordinates, temps = rng.uniform(-5, 5, (40, 6)), some_rows(rng, 40)[1]
    shuffled = rng.permutation(13)
    names = [f"{machine.sensor_names[k]}_degC" for k in shuffled]
    for name, header, rows in (("p", POSE_COLUMNS, coordinates), ("t", names, temps[:, shuffled])):
        np.savetxt(tmp_path / f"{name}.csv", rows, "%.17g", ",", header=",".join(header), comments="")
    correct_trajectory(machine, *(tmp_path / f"{name}.csv" for name in "pto"))
    found = np.genfromtxt(tmp_path / "o.csv", delimiter=",", names=True)
    lengths = np.stack([found[f"leg{leg}_length_mm"] for leg in range(1, 7)], axis=1)
    wanted = machine.corrected_leg_lengths(ht.pose_from_coordinates(coordinates), temps)
    assert np.abs(lengths - wanted * 1e3).max() < 1e-9


def test_a_backlash_of_one_leg_is_followed(tmp_path: Path, rng: np.random.Generator) -> None:
    """Read from hexapod.toml, one leg's backlash moves that leg's commands alone, row by row, in blocks and in a file;
    poses followed along the commands are the wanted ones to 1e-12 m.
    """
    machine = ht.load_hexapod(ht.write_hexapod(extended_machine(rng, (SLACK,), leg=1), tmp_path))
    laws = tuple(dataclasses.replace(law, terms=()) for law in machine.thermal.legs)
    without = dataclasses.replace(machine, thermal=dataclasses.replace(machine.thermal, legs=laws))
    coordinates, temps, time = rng.uniform(-3, 3, (60, 6)), some_rows(rng, 60)[1], np.arange(60) * 20.0
    poses = ht.pose_from_coordinates(coordinates)
    lengths = machine.leg_controllers().corrected_leg_lengths(poses, temps, time)
    row_by_row = machine.leg_controllers()
    rows = [row_by_row.corrected_leg_lengths(poses[k], temps[k], time[k]) for k in range(60)]
    assert np.abs(np.array(rows) - lengths).max() < 1e-12
    moved = lengths - without.corrected_leg_lengths(poses, temps)
    assert np.abs(np.delete(moved, 1, axis=1)).max() < 1e-15
    assert np.allclose(np.abs(moved[1:, 1]), 0.6e-6, rtol=1e-4)
    assert {*np.sign(moved[1:, 1])} == {-1.0, 1.0}
    assert np.abs(machine.leg_controllers().predicted_pose(lengths, temps, time) - poses).max() < 1e-12
    follower = machine.leg_controllers()
    single = [follower.predicted_pose(lengths[k], temps[k], time[k]) for k in range(60)]
    assert np.abs(np.array(single) - poses).max() < 1e-12
    for name, header, table in (
        ("p", ("time_s", *POSE_COLUMNS), np.column_stack([time, coordinates])),
        ("t", ("time_s", *(f"{name}_degC" for name in machine.sensor_names)), np.column_stack([time, temps])),
    ):
        np.savetxt(tmp_path / f"{name}.csv", table, "%.17g", ",", header=",".join(header), comments="")
    correct_trajectory(machine, *(tmp_path / f"{name}.csv" for name in "pto"))
    found = np.genfromtxt(tmp_path / "o.csv", delimiter=",", names=True)
    assert np.abs(found["leg2_length_mm"] - lengths[:, 1] * 1e3).max() < 1e-9


LEG_TERMS = {
    "lag": LegTerm("thermal-lag", "lag", {"sensor": "T1", "ratio": 0.5, "time_constant_s": 900.0}, [1e-6]),
    "lead": LegTerm("thermal-lag", "lead", {"sensor": "T2", "ratio": 0.5, "time_constant_s": 90.0}, [1e-6, -5e-7]),
    "stored heat": LegTerm(
        "hidden-heat", "stored-heat", {"source": "motion", "time_constant_s": 600.0, "ratio": 0.3}, [1e-2]
    ),
    "creep": LegTerm("creep", "relaxation", {"time_constant_s": 200.0, "kick": "step"}, [2e-7]),
    "square": LegTerm("nonlinear-expansion", "square", {"sensor": "T2", "ratio": 0.5}, [2e-8]),
    "bend": LegTerm(
        "nonlinear-expansion", "bend", {"sensor": "T2", "ratio": 0.5, "middle_degC": 22.0, "width_K": 3.0}, [2e-8]
    ),
    "missing": LegTerm("missing-sensor", "temperature", {"sensor": "T2", "ratio": 0.5}, [4e-7]),
    "scale": LegTerm("scale-error", "position", {}, [3e-6]),
    "screw": SCREW,
}
"""What one leg may show, beside backlash."""


@pytest.mark.parametrize("name", LEG_TERMS)
def test_what_one_leg_shows_is_used_from_its_file(name: str, tmp_path: Path, rng: np.random.Generator) -> None:
    """A term of one leg in hexapod.toml changes the commands of that leg alone, and the platform then stands where it
    should; terms of one row count in the budget too, others are refused there.
    """
    term = LEG_TERMS[name]
    machine = ht.load_hexapod(ht.write_hexapod(extended_machine(rng, (term,), leg=3), tmp_path))
    laws = tuple(dataclasses.replace(law, terms=()) for law in machine.thermal.legs)
    without = dataclasses.replace(machine, thermal=dataclasses.replace(machine.thermal, legs=laws))
    poses, temps = some_rows(rng, 30)
    time = np.cumsum(rng.uniform(5.0, 200.0, 30))
    lengths = machine.leg_controllers().corrected_leg_lengths(poses, temps, time)
    moved = lengths - without.corrected_leg_lengths(poses, temps)
    assert np.abs(np.delete(moved, 3, axis=1)).max() < 1e-15
    assert np.abs(moved[:, 3]).max() > 1e-8
    assert np.abs(machine.leg_controllers().predicted_pose(lengths, temps, time) - poses).max() < 1e-12
    if machine.thermal.states:
        with pytest.raises(ThermalModelError, match=term.cause):
            machine.error_budget(poses[0], temps[0])
        return
    assert np.abs(machine.predicted_pose(lengths, temps) - poses).max() < 1e-12
    budget = machine.error_budget(poses[0], temps[0])
    drifted = pose_errors(poses[0], machine.predicted_pose(machine.inverse_kinematics(poses[0]), temps[0]))
    assert np.abs(budget.uncorrected - drifted).max() < 1e-13
    assert np.abs(budget.remaining).max() < 1e-13
    assert any(item.label == "terms of the law" and item.covariance.any() for item in budget.contributions)


def test_poses_that_are_refused_are_not_remembered(rng: np.random.Generator) -> None:
    """A command out of stroke is refused by its row; the next row is as if it had not been asked for."""
    machine = extended_machine(rng, (SLACK,), leg=0)
    poses, temps = some_rows(rng, 3)
    lengths, time = machine.inverse_kinematics(poses), np.arange(3.0)
    one, other = machine.leg_controllers(), machine.leg_controllers()
    one.predicted_pose(lengths[:1], temps[:1], time[:1])
    other.predicted_pose(lengths[:1], temps[:1], time[:1])
    with pytest.raises(HexathermalError, match="index 1"):
        one.predicted_pose(lengths[[1, 1]] + [[0.0] * 6, [0.5] * 6], temps[1:], time[1:])
    assert np.array_equal(
        one.predicted_pose(lengths[1], temps[1], 1.0), other.predicted_pose(lengths[1], temps[1], 1.0)
    )


def test_the_measuring_frame_moves_measured_poses_alone(rng: np.random.Generator) -> None:
    """Commands and predictions do not know the frame; measured poses move by its motion about home, and back."""
    machine = extended_machine(rng)
    blind = dataclasses.replace(machine, measuring_frame=None)
    poses, temps = some_rows(rng, 5)
    lengths = machine.corrected_leg_lengths(poses, temps)
    assert np.array_equal(lengths, blind.corrected_leg_lengths(poses, temps))
    assert np.array_equal(machine.predicted_pose(lengths, temps), blind.predicted_pose(lengths, temps))
    dT, frame = rng.normal(size=5), machine.measuring_frame
    seen = measured_poses(machine, poses, dT)
    assert np.abs(machine_poses(machine, seen, dT) - poses).max() < 1e-15
    assert np.array_equal(measured_poses(blind, poses, dT), poses)
    at_home = pose_errors(machine.home, measured_poses(machine, machine.home, 1.5))
    assert np.allclose(at_home, 1.5 * np.concatenate([frame.shift, frame.turn]), rtol=1e-6, atol=1e-15)


def test_a_late_measuring_frame_needs_the_rows_of_one_run(tmp_path: Path, rng: np.random.Generator) -> None:
    """A frame with a time constant approaches a step as 1 - exp(-t/tau), is undone exactly, and stands in the file."""
    machine = extended_machine(rng)
    late = dataclasses.replace(machine.measuring_frame, time_constant=300.0)
    machine = dataclasses.replace(machine, measuring_frame=late)
    time, poses = np.array([0.0, 1e-6, 300.0, 900.0]), np.repeat(machine.home[None], 4, axis=0)
    rise = np.array([0.0, 2.0, 2.0, 2.0])
    seen = measured_poses(machine, poses, rise, time)
    reached = 2.0 * (1.0 - np.exp(-np.array([0.0, 0.0, 1.0, 3.0])))
    assert np.allclose(pose_errors(machine.home, seen), late.motion(reached), rtol=1e-5, atol=1e-14)
    assert np.abs(machine_poses(machine, seen, rise, time) - poses).max() < 1e-15
    with pytest.raises(ArgumentError, match="give the time of the rows"):
        measured_poses(machine, poses, rise)
    assert ht.load_hexapod(ht.write_hexapod(machine, tmp_path)).measuring_frame == late


@pytest.mark.parametrize("compliance", [1e-7, 3e-7, 1e-6, 1e-5, 1e-4])
def test_a_load_that_no_pose_holds_is_refused(compliance: float) -> None:
    """Legs that give way by decimetres and more have no balance: refused with the row, in a budget too."""
    drawn = ht.load_hexapod("reference")
    soft = dataclasses.replace(
        drawn, base_cone=None, platform_cone=None, compliance=Compliance(compliance, 1e5, [0.3, 0.0, 1.0])
    )
    with pytest.raises(NotConvergedError, match="no pose is in balance under the payload at index 0.*check compliance"):
        soft.predicted_pose(soft.home_lengths[None], [20.0] * 6)
    with pytest.raises(HexathermalError):
        soft.error_budget(POSE, [20.0] * 6, correction=False)


@pytest.mark.parametrize("correction", [True, False])
def test_a_budget_is_that_of_the_extended_machine(correction: bool, rng: np.random.Generator) -> None:
    """Biases are those of predicted_pose to 1e-13; causes add up, and without correction the sag is one of them."""
    machine = extended_machine(rng)
    (_pose, *_rest), (temps, *_more) = some_rows(rng, 2)
    budget = machine.error_budget(POSE, temps, correction=correction)
    drifted = pose_errors(POSE, machine.predicted_pose(machine.inverse_kinematics(POSE), temps))
    assert np.abs(budget.uncorrected - drifted).max() < 1e-13
    assert np.abs(budget.remaining - (0.0 if correction else drifted)).max() < 1e-13
    assert np.abs(budget.cause_parts.sum(axis=0) - budget.remaining).max() < 1e-13
    assert ("sag under the payload" in budget.causes) == (not correction)
    found = ht.budget_map(machine, np.array([POSE, machine.home]), temps, correction=correction)
    assert np.allclose(found.uncertainty[0], budget.uncertainty, rtol=1e-9)
    assert np.abs(found.remaining[0] - budget.remaining).max() < 1e-13


def test_rates_are_those_of_other_machines(rng: np.random.Generator) -> None:
    """Derivatives for load, compliance, lengths and temperatures are differences of predicted poses of machines that
    have these numbers, to 1e-6 of the largest.
    """
    machine = extended_machine(rng)
    temps = some_rows(rng, 1)[1][0]
    soft = machine.compliance
    stiff = dataclasses.replace(soft, leg_compliance=30.0 * soft.leg_compliance)  # the sag moves with the pose
    machine = dataclasses.replace(machine, compliance=stiff)
    here = situation(machine, POSE, temps)
    rates = here.rates()
    names = {"compliance": "leg_compliance", "payload mass": "payload_mass", "payload centre": "payload_centre"}
    steps = {"compliance": 1e-9, "payload mass": 0.1, "payload centre": 1e-3, "length": 1e-5, "temperature": 0.05}

    def reached(quantity: str, k: int, step: float) -> np.ndarray:
        other, told, warm = machine, here.told.copy(), temps.copy()
        if quantity in names:
            value = np.atleast_1d(getattr(stiff, names[quantity])).astype(float)
            value[k] += step
            changed = {names[quantity]: value if len(value) > 1 else value[0]}
            other = dataclasses.replace(machine, compliance=dataclasses.replace(stiff, **changed))
        told[k if quantity == "length" else 0] += step * (quantity == "length")
        warm[k if quantity == "temperature" else 0] += step * (quantity == "temperature")
        return pose_errors(POSE, other.predicted_pose(told, warm))

    for quantity, step in steps.items():
        own = rates[:, blocks(machine, quantity)[0]]
        for k in range(own.shape[1]):
            wanted = (reached(quantity, k, step) - reached(quantity, k, -step)) / (2.0 * step)
            # commanding a length by more moves the law's drift and the screw's waves too, by 1e-3 of it
            tolerance = 3e-3 if quantity == "length" else 1e-6
            assert np.abs(wanted - own[:, k]).max() < tolerance * np.abs(own).max(), (quantity, k)


def test_draws_hold_the_payload(rng: np.random.Generator) -> None:
    """By Monte Carlo the sources of the load give what the linear budget says, to 5 %."""
    machine = extended_machine(rng)
    temps = some_rows(rng, 1)[1][0]
    few = ht.Sources([one for one in ht.default_sources(machine) if one.quantity in OF_LOAD])
    assert {one.quantity for one in few} == {*OF_LOAD}
    drawn = ht.monte_carlo(machine, POSE, temps, few, least_draws=20_000, most_draws=20_000, seed=3)
    assert np.allclose(drawn.uncertainty, drawn.budget.uncertainty, rtol=0.05)
    assert drawn.lost == 0


def parts(machine: ht.Hexapod, temps: object = 26.0) -> dict[str, object]:
    """Return the contributions of a machine's budget by label."""
    warm = np.full(len(machine.sensor_names), temps) if np.isscalar(temps) else temps
    return {item.label: item for item in machine.error_budget(POSE, warm).contributions}


def test_stated_uncertainties_are_counted(reference: ht.Hexapod) -> None:
    """A plate's stated uncertainty takes the place of the engineering value, as do those of compliance and payload."""
    model = reference.thermal
    plates = [ht.PlateLaw(1.1e-5, "T"), ht.PlateLaw(1.1e-5, "T", 1.1e-6 / 3**0.5), ht.PlateLaw(1.1e-5, "T", 0.0)]
    found = []
    for platform in plates:
        thermal = ht.ThermalModel(model.legs, platform, None, 20.0)
        found.append(parts(dataclasses.replace(reference, thermal=thermal)))
    assert "identified plate expansion" not in found[0]
    assert "plate expansion" not in found[1]
    stated, usual = found[1]["identified plate expansion"], found[0]["plate expansion"]
    assert np.allclose(stated.covariance, usual.covariance, rtol=1e-9)
    assert not found[2]["identified plate expansion"].covariance.any()
    soft = Compliance(2e-8, 100.0)
    known = dataclasses.replace(soft, leg_compliance_std=4e-9, payload_mass_std=2.0, payload_centre_std=[1e-2] * 3)
    guess, told = (parts(dataclasses.replace(reference, compliance=own)) for own in (soft, known))
    for label in ("leg compliance", "payload", "centre of the payload"):
        assert np.allclose(told[label].uncertainty, 2.0 * guess[label].uncertainty, rtol=1e-9, atol=1e-15)
        assert guess[label].basis.startswith("engineering value")
        assert "file states" in told[label].basis
    assert guess["leg compliance"].correlation == "common"
    with pytest.raises(HexathermalError, match="compliance, of which the machine has none"):
        reference.error_budget(POSE, [20.0] * 6, [ht.Source("x", "compliance", 1e-9)])


def test_a_leg_of_its_own_leaves_the_others_alike(reference: ht.Hexapod) -> None:
    """Where one leg has coefficients of its own, the five others stay wrong together and differ among each other; the
    budget is that of one common source, one more, and a spread of five legs.
    """
    law = ht.LegLaw("T1", 2e-6, 1e-6, np.diag([4e-16, 1e-16]))
    odd = ht.LegLaw("T1", 2.6e-6, 1e-6, np.diag([9e-16, 1e-16]))
    machine = dataclasses.replace(reference, thermal=ht.ThermalModel([law, law, odd, law, law, law]))
    found = parts(machine)
    here = situation(machine, POSE, np.full(6, 26.0))
    rates = here.rates()[:, blocks(machine, "coefficients")[0]].reshape(6, 6, 2)
    others = np.delete(np.arange(6), 2)
    together = rates[:, others].sum(axis=1) * [2e-8, 1e-8]
    alone = rates[:, 2] * [3e-8, 1e-8]
    assert np.allclose(found["coefficients"].covariance, together @ together.T + alone @ alone.T, rtol=1e-9, atol=1e-24)
    spread = (rates[:, others] * [4e-8, 2e-8]).reshape(6, -1)
    assert np.allclose(found["leg to leg"].covariance, spread @ spread.T, rtol=1e-9, atol=1e-24)
    # a term in one leg leaves its coefficients those of all
    one = ht.LegLaw("T1", 2e-6, 1e-6, law.covariance, terms=(SCREW,))
    termed = dataclasses.replace(reference, thermal=ht.ThermalModel([law, one, law, law, law, law]))
    alike = dataclasses.replace(reference, thermal=ht.ThermalModel(law))
    with_term, without = parts(termed), parts(alike)
    for label in ("coefficients", "leg to leg"):
        assert np.allclose(with_term[label].covariance, without[label].covariance, rtol=1e-4)
    assert with_term["terms of the law"].covariance[2, 2] > 0.0


def test_a_budget_counts_both_sides_of_a_backlash(reference: ht.Hexapod) -> None:
    """One leg's backlash is no bias but the source, half the step to either side, in place of the usual one."""
    law = ht.LegLaw("T1", 2e-6, 1e-6)
    slack = ht.LegLaw("T1", 2e-6, 1e-6, terms=(SLACK,))
    machine = dataclasses.replace(reference, thermal=ht.ThermalModel([law, slack, law, law, law, law]))
    plain = dataclasses.replace(reference, thermal=ht.ThermalModel(law))
    budget, other = machine.error_budget(POSE, [26.0] * 6), plain.error_budget(POSE, [26.0] * 6)
    assert np.allclose(budget.uncorrected, other.uncorrected, rtol=1e-12)
    assert [item.label for item in budget.contributions].count("backlash") == 1
    own, usual = (next(item for item in one.contributions if item.label == "backlash") for one in (budget, other))
    rates = situation(plain, POSE, np.full(6, 26.0)).rates()[:, blocks(plain, "length")[0]]
    half = np.where(np.arange(6) == 1, 0.6e-6, 0.3e-6)
    assert np.allclose(own.covariance, (rates * half**2 / 2.0) @ rates.T, rtol=1e-9, atol=1e-24)
    assert np.allclose(budget.covariance - own.covariance, other.covariance - usual.covariance, rtol=1e-9, atol=1e-24)
    found = ht.budget_map(machine, np.array([POSE]), [26.0] * 6)
    assert np.allclose(found.uncertainty[0], budget.uncertainty, rtol=1e-9)
