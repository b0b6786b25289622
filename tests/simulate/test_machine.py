"""The virtual hexapod: heat balances, the true pose is that of the true lengths and joints, nothing of it is told."""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import hexathermal as ht
from hexathermal.errors import ArgumentError, OutOfStrokeError
from hexathermal.learn.campaign_dataset import read_run
from hexathermal.learn.campaign_files import load_campaign
from hexathermal.learn.hexapod_data import hexapod_rows
from hexathermal.learn.machine_diagnosis.diagnosing import diagnose_machine
from hexathermal.learn.machine_diagnosis.gain import residuals
from hexathermal.simulate.bench.leg import VirtualLeg
from hexathermal.simulate.machine.building import as_built, scaled_leg, virtual_machine
from hexathermal.simulate.machine.campaign_folder import write_machine_campaign
from hexathermal.simulate.machine.heat import MachineHeat
from hexathermal.simulate.machine.machine import VirtualMachine
from hexathermal.simulate.machine.motion import displacements, planned_motion
from hexathermal.simulate.machine.parts import Plate, PositioningSystem
from hexathermal.simulate.machine.runs import (
    MachineRun,
    planned_machine_runs,
    simulate_machine,
    true_machine_run,
    true_poses,
)
from hexathermal.simulate.machine.truth import effective_laws, homogeneous_laws, machine_truth
from tests.learn.hexapods import stood

REFERENCE = ht.load_hexapod("reference")
MACHINE = virtual_machine(REFERENCE, seed=2)


@pytest.fixture(scope="module")
def runs() -> list[MachineRun]:
    """Two short runs of a virtual machine."""
    plans = planned_machine_runs(MACHINE, 1, identification=1, validation=1, poses=40)
    return list(simulate_machine(MACHINE, 1, plans))


@given(
    q=st.lists(st.lists(st.floats(0.0, 0.25), min_size=6, max_size=6), min_size=2, max_size=12),
    room=st.floats(-10.0, 50.0),
    start=st.floats(-20.0, 80.0),
    step=st.floats(0.5, 600.0),
)
@settings(max_examples=25)
def test_heat_is_conserved_whatever_the_machine_does(
    q: list[list[float]], room: float, start: float, step: float
) -> None:
    """Heat stored = heat made - heat given to the room, to rounding, for any motion, room and step."""
    heat, n = MACHINE.heat, len(q)
    history = heat.warm(np.arange(n) * step, np.array(q), np.full(n, room), np.full(heat.size, start))
    turned_over = history.heat_in + np.abs(history.stored()).max() + heat.capacities.sum() * 100.0
    assert (np.abs(history.stored() - (history.heat_in - history.heat_out)) <= 1e-12 * turned_over).all()


def test_plates_couple_the_legs() -> None:
    """One leg that works warms both plates, and through them the five that rest; heat flows from warm to cold only:
    the plates stay colder than the working leg, the resting legs colder than the plates.
    """
    heat = MACHINE.heat
    n = 1500
    q = np.full((n, 6), 0.1)
    q[:, 2] = 0.1 + 0.05 * (np.arange(n) % 2)
    start = heat.at_rest(20.0, q[0])
    history = heat.warm(np.arange(n) * 60.0, q, np.full(n, 20.0), start)
    rise = history.temperatures[-1] - start
    legs = [rise[own[leg.upper_joint]] for leg, own in zip(heat.legs, heat.places, strict=True)]
    assert 0.01 < rise[1] < legs[2]
    others = np.delete(legs, 2)
    assert (others > 0.0).all()
    assert (others < rise[1]).all()


def test_alone_between_fixed_plates_a_leg_is_that_of_the_bench() -> None:
    """With plates that are as one bench's platform pieces, the legs' temperatures follow the bench's leg: identical
    legs in identical motion, a sixth of the plate each, agree to 1e-9 K.
    """
    leg = scaled_leg(0.6, 0.25)
    pieces = Plate(6 * leg.joints.piece_capacity, 6 * leg.joints.piece_convection)
    heat = MachineHeat((leg,) * 6, pieces, pieces)
    time = np.arange(0.0, 7200.0, 20.0)
    q = 0.12 + 0.1 * np.sin(time / 400.0)
    room = 20.0 + 0.5 * np.sin(time / 3000.0)
    alone = leg.warm(time, q, room, leg.at_rest(20.0, q[0]))
    whole = heat.warm(time, np.repeat(q[:, None], 6, axis=1), room, heat.at_rest(20.0, np.full(6, q[0])))
    assert np.abs(whole.temperatures[:, heat.places[4]] - alone.temperatures).max() < 1e-9


@pytest.mark.long
def test_steps_of_time_and_cells_are_fine_enough() -> None:
    """A quarter of the steps changes no growth in a run by more than 20 nm; legs of 27 cells instead of 16 change no
    growth by more than 0.15 um, and the laws that fit best by less than 1.5 % (A) and 6 % (B).
    """

    def made_at(step: float, machine: VirtualMachine = MACHINE) -> np.ndarray:
        generator = np.random.default_rng(5)
        six = np.random.default_rng(6).uniform(-1, 1, (20, 6)) * [60, 60, 40, 6, 6, 8]
        motion = planned_motion(
            machine.hexapod, machine.scenario, six, six[::-1], 0.002, generator, count=60, step=step
        )
        own = motion.q - machine.lowest
        start = machine.heat.at_rest(20.0, own[0])
        history = machine.heat.warm(motion.time, own, np.full(len(motion.time), 20.0), start).at(motion.rows)
        return history.growth(machine.reference())

    coarse = made_at(1.0)
    assert np.abs(coarse).max() > 4e-6
    assert np.abs(coarse - made_at(0.25)).max() < 2e-8
    fine = virtual_machine(REFERENCE, seed=2, cells=27)
    plans = planned_machine_runs(MACHINE, 1, identification=1, validation=0, poses=150)
    both = [list(simulate_machine(one, 1, plans)) for one in (MACHINE, fine)]
    assert np.abs(both[0][0].truth.growth - both[1][0].truth.growth).max() < 1.5e-7
    laws = [effective_laws(one, made) for one, made in zip((MACHINE, fine), both, strict=True)]
    assert (np.abs(laws[0] / laws[1] - 1.0).max(axis=0) < [0.015, 0.06]).all()


def test_the_true_pose_is_that_of_a_second_solver(runs: list[MachineRun]) -> None:
    """True poses agree to 1e-11 m at the joints with a Newton solver of the tests, from growths and expanded joints."""
    machine = dataclasses.replace(MACHINE, landing=0.0)
    plan = planned_machine_runs(machine, 1, identification=1, validation=0, poses=30)[0]
    truth = true_machine_run(machine, plan, np.random.default_rng(3))
    hexapod = machine.hexapod
    commanded = ht.pose_from_coordinates(plan.motion.coordinates, hexapod=hexapod)
    grown = 1.0 + truth.expansions
    found = stood(
        hexapod.base_joints * grown[:, 1, None, None], hexapod.platform_joints * grown[:, 0, None, None],
        0.6 + truth.q + truth.growth, commanded,
    )  # fmt: skip
    joints = np.einsum("nij,kj->nki", found[:, :3, :3] - truth.poses[:, :3, :3], hexapod.platform_joints)
    assert np.abs(joints + (found - truth.poses)[:, None, :3, 3]).max() < 1e-11
    assert np.abs(truth.growth).max() > 1e-6
    assert np.abs(truth.expansions).max() > 1e-7


def test_uniform_expansion_scales_the_machine() -> None:
    """Joints and legs that all grow by 1e-5 leave the platform's turn and move it off the base's origin by 1e-5."""
    six = np.array([[0, 0, 0, 0, 0, 0.0], [40, -30, 25, 4, -3, 5], [-60, 10, -40, -5, 6, -8]])
    poses = ht.pose_from_coordinates(six, hexapod=MACHINE.hexapod)
    lengths = MACHINE.hexapod.inverse_kinematics(poses)
    grown = true_poses(MACHINE.hexapod, lengths * (1 + 1e-5), lengths, np.full((3, 2), 1e-5))
    assert np.abs(grown[:, :3, :3] - poses[:, :3, :3]).max() < 1e-12
    assert np.abs(grown[:, :3, 3] - poses[:, :3, 3] * (1 + 1e-5)).max() < 1e-12


def test_the_homogeneous_law_is_exact() -> None:
    """A leg that is 1 K warmer all over grows by A q0 + B q at every displacement, to 1e-15 m; without spread all legs
    have one law, with it they differ by some 5 %.
    """
    laws = homogeneous_laws(MACHINE)
    for leg, (A, B) in zip(MACHINE.heat.legs, laws, strict=True):
        cold = np.zeros(leg.size)
        for q in (0.0, 0.07, 0.25):
            assert float(leg.growth(cold[None] + 1.0, np.array([q]), cold)[0]) == pytest.approx(
                0.6 * A + q * B, abs=1e-15
            )
    equal = homogeneous_laws(virtual_machine(REFERENCE, seed=2, spread=0.0))
    assert np.ptp(equal, axis=0).max() < 1e-15
    assert 0.01 < np.std(laws[:, 0] / laws[:, 0].mean()) < 0.12


@pytest.mark.long
def test_the_tracker_has_its_noise_and_its_frame() -> None:
    """Measured less true pose: noise of 0.4 um and 1 urad a coordinate within 10 %, about one motion for each run."""
    plans = planned_machine_runs(MACHINE, 4, identification=1, validation=0, poses=400)
    (run,) = simulate_machine(MACHINE, 4, plans)
    seen = ht.pose_from_coordinates(run.measured, hexapod=MACHINE.hexapod)
    true = run.truth.poses
    off = ht.coordinates_from_pose(seen, hexapod=MACHINE.hexapod) - ht.coordinates_from_pose(
        true, hexapod=MACHINE.hexapod
    )
    off = off * [1e3, 1e3, 1e3, *([1e6 * np.pi / 180.0] * 3)]
    assert off.std(axis=0) == pytest.approx(np.array([0.4, 0.4, 0.4, 1, 1, 1]), rel=0.12)
    exact = dataclasses.replace(MACHINE, tracker=PositioningSystem((0.0,) * 6, 0.0, 0.0))
    (run,) = simulate_machine(exact, 4, planned_machine_runs(exact, 4, identification=1, validation=0, poses=10))
    assert np.abs(ht.pose_from_coordinates(run.measured, hexapod=MACHINE.hexapod) - run.truth.poses).max() < 1e-12


def test_the_campaign_reads_as_any_other(runs: list[MachineRun], tmp_path: Path) -> None:
    """The folder is a campaign of kind hexapod that loads without a fault, CSV and Parquet alike; its machine is beside
    it; what is read is what was recorded.
    """
    plans = tuple(run.truth.plan for run in runs)
    for parquet in (False, True):
        folder = tmp_path / f"campaign-{parquet}"
        files = write_machine_campaign(folder, MACHINE, plans, runs, parquet=parquet)
        assert all(file.is_file() for file in files)
        campaign = load_campaign(folder, needed=("identification", "validation"))
        assert campaign.kind == "hexapod"
        assert campaign.sensors == MACHINE.columns
        assert campaign.hexapod is not None
        assert ht.load_hexapod(campaign.hexapod) == MACHINE.hexapod
        data = read_run(campaign, "run-01")
        assert np.allclose(data["measured_x"].values, runs[0].measured[:, 0] * 1e-3, atol=1e-9)
        assert np.allclose(data["measured_rz"].values, np.radians(runs[0].measured[:, 5]), atol=2e-10)
        assert np.allclose(data["leg_q"].values, runs[0].q, atol=1e-9)
        assert np.allclose(data["rz"].values, np.radians(runs[0].commanded[:, 5]), atol=1e-15)


def test_scales_say_what_was_commanded(runs: list[MachineRun]) -> None:
    """The displacements are the inverse kinematics of the commanded pose: no correction was active."""
    q = displacements(MACHINE.hexapod, runs[0].commanded)
    assert np.abs(q - runs[0].q).max() < 1e-8


def test_nothing_of_the_truth_is_in_the_folder(runs: list[MachineRun], tmp_path: Path) -> None:
    """No number of the truth, and no word that it is simulated, stands in any file of the folder."""
    plans = tuple(run.truth.plan for run in runs)
    files = write_machine_campaign(tmp_path / "campaign", MACHINE, plans, runs)
    text = "".join(file.read_text(encoding="utf-8") for file in files).lower()
    for word in ("simul", "virtual", "truth", "seed"):
        assert word not in text
    told = machine_truth(MACHINE, 1, runs)
    json.dumps(told)
    numbers = [leg["homogeneous"]["A_per_K"] for leg in told["legs"]] + [told["platform"]["expansion"]]
    for number in numbers:
        assert f"{number:.12g}" not in text


def test_the_same_seed_makes_the_same_campaign(runs: list[MachineRun], tmp_path: Path) -> None:
    """Files of the same seed are the same to the byte, of another seed they are not."""
    texts = []
    for name, seed in (("a", 1), ("b", 1), ("c", 2)):
        machine = virtual_machine(REFERENCE, seed=seed)
        plans = planned_machine_runs(machine, seed, identification=1, validation=0, poses=12)
        files = write_machine_campaign(tmp_path / name, machine, plans, simulate_machine(machine, seed, plans))
        texts.append(b"".join(file.read_bytes() for file in files))
    assert texts[0] == texts[1]
    assert texts[0] != texts[2]


def test_a_base_frame_elsewhere_moves_nothing() -> None:
    """Setting the base frame to the centre of the base joints changes no leg length at any pose counted from home."""
    built = as_built(REFERENCE)
    six = np.array([[10, 20, -30, 4, 5, 6.0], [-50, 3, 20, -6, 2, 9]])
    lengths = [one.inverse_kinematics(ht.pose_from_coordinates(six, hexapod=one)) for one in (REFERENCE, built)]
    assert np.abs(lengths[0] - lengths[1]).max() < 1e-12
    assert np.abs(built.base_joints.mean(axis=0)).max() < 1e-9


@pytest.mark.long
def test_a_machine_that_follows_its_law_does_so_from_the_first_row(tmp_path: Path) -> None:
    """Its file, held against what is measured without noise, leaves less than 20 nm and 50 nrad (scales resolve 5 nm)
    in every run, whatever temperatures count from; the same machine through which heat flows leaves more than that.
    It has the law of its file, no spread, and does not grow without a law.
    """
    quiet = PositioningSystem((0.0,) * 6, 0.0, 0.0)
    for growth, zero in (("law", "campaign"), ("law", "run"), ("heat", "campaign")):
        machine = virtual_machine(REFERENCE, tracker=quiet, growth=growth)
        exact = dataclasses.replace(machine.thermocouples, noise=0.0, offset=0.0, resolution_K=1e-9)
        machine = dataclasses.replace(machine, thermocouples=exact)
        plans = planned_machine_runs(machine, 1, identification=1, validation=1, poses=12)
        folder = tmp_path / f"{growth}-{zero}"
        write_machine_campaign(folder, machine, plans, simulate_machine(machine, 1, plans, zero), zero=zero)
        campaign = load_campaign(folder)
        for role in ("identification", "validation"):
            rows = hexapod_rows(campaign, role)
            left = residuals(rows, role, rows.hexapod, rows.hexapod)[0].before
            worst = np.abs(left).max(axis=0)
            assert (worst < [2e-8] * 3 + [5e-8] * 3).all() == (growth == "law"), (growth, zero, role, worst)
    told = homogeneous_laws(virtual_machine(REFERENCE, growth="law"))
    assert told == pytest.approx(np.array([[1.99e-6, 1.09e-6]] * 6))
    with pytest.raises(ArgumentError, match="have no spread"):
        virtual_machine(REFERENCE, spread=0.1, growth="law")
    with pytest.raises(ArgumentError, match="no law of the thermometers T1 that its legs could follow"):
        virtual_machine(dataclasses.replace(REFERENCE, thermal=None), growth="law")
    with pytest.raises(ArgumentError, match="growth is 'wood'"):
        virtual_machine(REFERENCE, growth="wood")


@pytest.mark.long
def test_a_machine_that_follows_its_law_is_called_clean_and_a_changed_file_is_found(tmp_path: Path) -> None:
    """The campaign of a machine that follows its law is answered none; simulated with a leg's law changed by 20 % and
    held against the file before, that leg is named.
    """
    model = MACHINE.hexapod.thermal
    assert model is not None
    legs = list(model.legs)
    legs[3] = ht.LegLaw(legs[3].sensors, 1.2 * legs[3].A, legs[3].B)
    changed = dataclasses.replace(MACHINE.hexapod, thermal=dataclasses.replace(model, legs=tuple(legs)))
    for name, hexapod in (("clean", MACHINE.hexapod), ("changed", changed)):
        machine = virtual_machine(hexapod, growth="law")
        plans = planned_machine_runs(machine, 1, identification=3, validation=0, poses=60)
        write_machine_campaign(tmp_path / name, machine, plans, simulate_machine(machine, 1, plans))
        found = diagnose_machine(load_campaign(tmp_path / name), hexapod=MACHINE.hexapod)
        named = [(one.cause, one.target) for one in found.effects]
        assert (found.verdict, named) == (
            ("none", []) if name == "clean" else ("effect", [("leg-coefficient", "leg4")])
        )


def test_other_machines_get_legs_of_their_size() -> None:
    """A machine with shorter legs and small strokes has virtual legs in its size, whose law is near the bench leg's."""
    camera = virtual_machine(ht.load_hexapod("rubin-camera"), spread=0.0)
    assert camera.heat.legs[0].retracted_length == pytest.approx(0.478917809)
    bench, own = VirtualLeg(), homogeneous_laws(camera)
    cold = np.zeros(bench.size)
    A = float(bench.growth(cold[None] + 1.0, np.zeros(1), cold)[0]) / 0.6
    assert own[0, 0] == pytest.approx(A, rel=0.12)


def test_what_cannot_be_is_refused() -> None:
    """A machine without stroke, a stroke too long for a telescope, poses out of stroke, five legs: said by name."""
    bare = dataclasses.replace(REFERENCE, stroke=None, thermal=None)
    with pytest.raises(ArgumentError, match="no q0 or no stroke"):
        virtual_machine(bare)
    with pytest.raises(ArgumentError, match="no virtual leg of 300 mm has a stroke of 290 mm"):
        scaled_leg(0.3, 0.29)
    with pytest.raises(OutOfStrokeError, match="pose 2: leg"):
        displacements(MACHINE.hexapod, np.array([[0, 0, 0, 0, 0, 0.0], [0, 0, 300, 0, 0, 0]]))
    with pytest.raises(ArgumentError, match="six legs, found 5"):
        MachineHeat((VirtualLeg(),) * 5, Plate(1.0, 1.0), Plate(1.0, 1.0))
    with pytest.raises(ArgumentError, match="spread"):
        virtual_machine(REFERENCE, spread=0.5)
    with pytest.raises(ArgumentError, match="a noise for each"):
        PositioningSystem((1e-6,) * 3)
