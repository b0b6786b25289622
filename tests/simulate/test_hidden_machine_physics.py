"""The truth behind hexapod campaigns: solved another way than the house does, and in agreement with it; effects."""

from __future__ import annotations

import ast
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import hexathermal as ht
from hexathermal.machine.compliance import Compliance
from hexathermal.machine.hexapod import Hexapod
from hexathermal.machine.thermal import LegLaw, PlateLaw, ThermalModel
from hexathermal.simulate.hidden import machines
from hexathermal.simulate.hidden.effect import Parameters
from hexathermal.simulate.hidden.machines.campaign import draw_clean
from hexathermal.simulate.hidden.machines.effects import CATALOGUE, OUTSIDE, found, named
from hexathermal.simulate.hidden.machines.effects.payload_compliance import GRAVITY
from hexathermal.simulate.hidden.machines.geometry import DRAWN, WORST, condition, draw_machine, machine_names
from hexathermal.simulate.hidden.machines.motion import WAYS, draw_poses, reachable
from hexathermal.simulate.hidden.machines.physics import (
    Heat,
    effect,
    nominal,
    read_heats,
    rises,
    seen,
    stood,
    told_heats,
    true_heats,
)
from hexathermal.simulate.hidden.machines.posture import Posture, lengths_of, standing
from hexathermal.simulate.hidden.machines.rotation import angles_of, from_angles, product, turned
from hexathermal.simulate.hidden.machines.truth import MachineTruth

LENGTH_TOLERANCE_M, ANGLE_TOLERANCE_RAD = 2e-12, 1e-11
ANGLE = st.floats(-1.4, 1.4)


@pytest.fixture(scope="module")
def clean(seed: int) -> MachineTruth:
    """A campaign in which nothing is hidden, all thermometers recorded."""
    return draw_clean(np.random.default_rng(seed), recorded=True)[0]


def hidden(truth: MachineTruth, name: str, generator: np.random.Generator, **fixed: float | str) -> MachineTruth:
    """The campaign with an effect, some of its parameters given."""
    one = named(name)
    return one.hide(truth, {**one.draw(truth, generator), **fixed})


def leg_changes(truth: MachineTruth) -> np.ndarray:
    """By how much the legs seem longer than filed, between the joints as filed, shape (n, 6) [m]."""
    hexapod = truth.hexapod
    six = stood(truth, true_heats(truth))
    plates = 1.0 + np.concatenate([heat.plates for heat in told_rises(truth)]) * filed_expansions(truth)
    platform, base = hexapod.platform_joints * plates[:, :1, None], hexapod.base_joints * plates[:, 1:, None]
    dT = np.concatenate([heat.legs for heat in told_rises(truth)])
    q = truth.all("q")
    A, B = (np.array([getattr(law, name) for law in hexapod.thermal.legs]) for name in "AB")
    law = ((A * truth.retracted[:, None] + B * q[..., None]) * dT).sum(-1)
    return np.asarray(lengths_of(nominal(truth, six), base, platform) - truth.retracted - q - law)


def told_rises(truth: MachineTruth) -> list[Heat]:
    """Temperatures since the zero, as recorded without errors."""
    return rises(truth, told_heats(truth))


def filed_expansions(truth: MachineTruth) -> np.ndarray:
    """Of platform and base, as filed."""
    model = truth.hexapod.thermal
    return np.array([0.0 if law is None else law.expansion for law in (model.platform, model.base)])


@given(ANGLE, ANGLE, ANGLE)
def test_quaternions_turn_as_the_convention_says(rx: float, ry: float, rz: float) -> None:
    """Rz Ry Rx of the house's poses and the quaternion of the same angles turn points alike; angles come back."""
    angles = np.array([rx, ry, rz])
    R = ht.pose_from_coordinates([0, 0, 0, *np.degrees(angles)])[:3, :3]
    points = np.array([[1.0, -2.0, 0.5], [0.3, 0.1, -0.7]])
    turn = from_angles(angles)
    assert np.abs(turned(turn, points) - points @ R.T).max() < 1e-14
    assert np.abs(angles_of(turn) - angles).max() < 1e-12
    assert np.abs(turned(product(turn, turn), points) - points @ R.T @ R.T).max() < 1e-14


@pytest.mark.parametrize("name", machine_names())
def test_postures_are_those_of_the_forward_kinematics(name: str, seed: int) -> None:
    """Newton on position and quaternion and the house's forward kinematics find the same platform."""
    generator = np.random.default_rng([seed, 5])
    hexapod = draw_machine(generator, name)
    six = draw_poses(hexapod, 40, 0.8, "anywhere", generator)
    there = Posture(hexapod.home[:3, 3] + six[:, :3], from_angles(six[:, 3:]))
    lengths = lengths_of(there, hexapod.base_joints, hexapod.platform_joints)
    near = Posture(there.position + 1e-3 * generator.standard_normal(3), there.turn)
    ours = standing(lengths, hexapod.base_joints, hexapod.platform_joints, near)
    guess = ht.pose_from_coordinates(np.hstack([six[:, :3] * 1e3, np.degrees(six[:, 3:])]), hexapod=hexapod)
    house = ht.coordinates_from_pose(hexapod.forward_kinematics(lengths, guess), hexapod=hexapod)
    scale = 30.0  # what an ill-conditioned machine makes of rounding
    assert np.abs(ours.position - hexapod.home[:3, 3] - house[:, :3] * 1e-3).max() < scale * LENGTH_TOLERANCE_M
    assert np.abs(angles_of(ours.turn) - np.radians(house[:, 3:])).max() < scale * ANGLE_TOLERANCE_RAD


def foretold(truth: MachineTruth, hexapod: Hexapod) -> np.ndarray:
    """Coordinates that the house's `predicted_pose` of a machine has for a campaign's rows, shape (n, 6) [m, rad]."""
    heats = told_rises(truth)
    legs, plates = (20.0 + np.concatenate([getattr(heat, name) for heat in heats]) for name in ("legs", "plates"))
    temps = {f"leg{leg + 1}_{sensor}": legs[:, leg, k] for leg in range(6) for k, sensor in enumerate(truth.sensors)}
    temps |= {f"{part}_T1": plates[:, k] for k, part in enumerate(("platform", "base"))}
    known = {name: temps[name] for name in hexapod.sensor_names}
    poses = hexapod.predicted_pose(truth.retracted + truth.all("q"), known)
    return ht.coordinates_from_pose(poses, hexapod=hexapod) * np.repeat([1e-3, np.pi / 180.0], 3)


def test_clean_machines_stand_where_the_law_says(clean: MachineTruth) -> None:
    """Where nothing is hidden, `predicted_pose` of the filed machine is the truth, plates and zero included."""
    apart = np.abs(stood(clean, true_heats(clean)) - foretold(clean, clean.hexapod))
    assert apart[:, :3].max() < 1e-10
    assert apart[:, 3:].max() < 1e-9


def extended(truth: MachineTruth) -> Hexapod:
    """The machine whose file says what is true, where a file can say it."""
    hexapod, load = truth.hexapod, truth.load
    laws = [LegLaw(truth.sensors, A, B) for A, B in zip(truth.A, truth.B, strict=True)]
    model = ThermalModel(
        laws, *(PlateLaw(float(alpha), "T1") for alpha in truth.expansions), valid_degC=(-100.0, 150.0),
        thermometers_of_leg=[leg + 1 for leg in truth.read_from],
    )  # fmt: skip
    soft = None if load is None else Compliance(load.compliance, float(load.weight[2] / GRAVITY[2]), load.centre)
    return replace(
        hexapod, thermal=model, compliance=soft, base_joints=truth.base_joints, platform_joints=truth.platform_joints
    )


@pytest.mark.parametrize(
    "name",
    ["leg-coefficient", "platform-expansion", "base-expansion", "swapped-legs", "payload-compliance", "joint-offset"],
)
def test_a_file_that_states_the_effect_foretells_the_truth(
    name: str, clean: MachineTruth, generator: np.random.Generator
) -> None:
    """The extended `hexapod.toml` and the generator, which share no formula, put the platform in the same place."""
    truth = hidden(clean, name, generator)
    apart = np.abs(stood(truth, true_heats(truth)) - foretold(truth, extended(truth)))
    assert np.abs(effect(truth)).max() > 50.0 * apart.max()
    assert apart[:, :3].max() < 1e-9
    assert apart[:, 3:].max() < 1e-8


def test_a_uniformly_warm_machine_of_one_metal_only_grows(clean: MachineTruth) -> None:
    """Legs, platform and base that grow alike scale the platform's place about the base's origin, and turn nothing."""
    alpha, rise = 11e-6, 7.0
    each = np.full_like(clean.A, alpha / clean.A.shape[1])
    same = clean.changed(A=each, B=each, expansions=np.full(2, alpha), zero="campaign")
    heats = []
    for k, run in enumerate(clean.runs):
        warm = np.full(run.legs.shape, 20.0 + rise), np.full(run.plates.shape, 20.0 + rise)
        if k == 0:  # the first row is the zero
            warm[0][0], warm[1][0] = 20.0, 20.0
        heats.append(Heat(*warm))
    cold = stood(same, [Heat(0.0 * heat.legs, 0.0 * heat.plates) for heat in heats])[1:]
    hot = stood(same, heats)[1:]
    home = clean.hexapod.home[:3, 3]
    assert np.abs(hot[:, :3] + home - (cold[:, :3] + home) * (1.0 + alpha * rise)).max() < 1e-11
    assert np.abs(hot[:, 3:] - cold[:, 3:]).max() < 1e-10


def test_clean_campaigns_hide_nothing(clean: MachineTruth) -> None:
    """The effect of nothing is zero, to rounding."""
    assert np.abs(effect(clean)).max() < 1e-12


@pytest.mark.parametrize("name", list(found()))
def test_an_effect_does_something_and_the_same_each_time(
    name: str, clean: MachineTruth, generator: np.random.Generator
) -> None:
    """The same parameters hide the same; the truth that was given stays; a stronger one does more."""
    one = named(name)
    parameters: Parameters = one.draw(clean, generator)
    first, again = effect(one.hide(clean, parameters)), effect(one.hide(clean, parameters))
    assert np.array_equal(first, again)
    assert np.abs(first).max() > 1e-9
    assert np.abs(effect(clean)).max() < 1e-12
    more = effect(one.hide(clean, {**parameters, one.amplitude: 1.5 * float(parameters[one.amplitude])}))
    assert np.square(more / clean.levels).mean() > 1.2 * np.square(first / clean.levels).mean()


def test_a_leg_off_its_law_is_longer_by_its_own_heat(clean: MachineTruth, generator: np.random.Generator) -> None:
    """Leg 3 seems longer by ``dA q0 dT + dB q dT``; the others as their laws say."""
    truth = hidden(clean, "leg-coefficient", generator, target="leg3", sensor="T1", size=2e-6, of_A=0.6, of_B=0.8)
    dT = np.concatenate([heat.legs for heat in told_rises(clean)])[:, 2, 0]
    wanted = np.zeros((len(dT), 6))
    wanted[:, 2] = 2e-6 * (0.6 * clean.retracted[2] + 0.8 * clean.all("q")[:, 2]) * dT
    assert np.abs(leg_changes(truth) - wanted).max() < LENGTH_TOLERANCE_M


def test_backlash_sits_on_one_leg_within_its_gap(clean: MachineTruth, generator: np.random.Generator) -> None:
    """Leg 5 alone is off, by half the gap at most; where it has come a long way, by just that, against its way."""
    truth = hidden(clean, "leg-backlash", generator, target="leg5", gap=1e-6, engagement=2e-5)
    change, q = leg_changes(truth), clean.all("q")[:, 4]
    assert np.abs(np.delete(change, 4, axis=1)).max() < LENGTH_TOLERANCE_M
    assert np.abs(change[:, 4]).max() < 0.5e-6 + LENGTH_TOLERANCE_M
    far = np.flatnonzero(np.abs(np.diff(q)) > 2.2 * 2e-5) + 1
    assert np.abs(change[far, 4] - 0.5e-6 * np.sign(q[far] - q[far - 1])).max() < LENGTH_TOLERANCE_M


def test_swapped_legs_change_what_is_recorded_only(clean: MachineTruth, generator: np.random.Generator) -> None:
    """Legs 2 and 6 read each other; the platform stands where it did; the others' columns stay."""
    truth = hidden(clean, "swapped-legs", generator, target="leg2+leg6", apart=1.0)
    before, after = ([heat.legs for heat in read_heats(one)] for one in (clean, truth))
    for old, new in zip(before, after, strict=True):
        assert np.abs(new - old[:, [0, 5, 2, 3, 4, 1]]).max() < 1e-9
    places = [stood(one, true_heats(one)) for one in (clean, truth)]
    assert np.abs(places[1] - places[0]).max() < 1e-12


def test_a_drifting_tracker_moves_all_poses_alike(clean: MachineTruth, generator: np.random.Generator) -> None:
    """Poses at the same temperature of the room are moved by the same rigid motion about home."""
    truth = hidden(clean, "tracker-drift", generator, delay=0.0, size=1e-6)
    motion = truth.all("moved")
    air = clean.all("air")
    zero = np.concatenate([np.full(run.time.size, (run if clean.zero == "run" else clean.runs[0]).air[0])
                           for run in clean.runs])  # fmt: skip
    slope = (air - zero) @ motion / ((air - zero) @ (air - zero))
    assert np.abs(motion - np.outer(air - zero, slope)).max() < 1e-12
    six = stood(clean, true_heats(clean))
    assert np.abs(effect(truth) - (seen(six, motion) - six)).max() < 1e-12


@pytest.mark.parametrize(("name", "field"), [("platform", "platform_joints"), ("base", "base_joints")])
def test_a_growing_plate_moves_its_joints(name: str, field: str, clean: MachineTruth) -> None:
    """More expansion is the same as joints moved away from the origin by the plate's own heat, row by row."""
    k = ("platform", "base").index(name)
    truth = named(f"{name}-expansion").hide(clean, {"target": name, "expansion": 3e-6})
    dT = np.concatenate([heat.plates for heat in told_rises(clean)])[:, k]
    row = int(np.abs(dT).argmax())
    factor = (1.0 + (filed_expansions(clean)[k] + 3e-6) * dT[row]) / (1.0 + filed_expansions(clean)[k] * dT[row])
    moved = clean.changed(**{field: getattr(clean, field) * factor})
    heats = true_heats(clean)
    assert np.abs(stood(truth, heats)[row] - stood(moved, heats)[row]).max() < 1e-12


def test_a_payload_is_held_by_virtual_work(clean: MachineTruth, generator: np.random.Generator) -> None:
    """Legs give way by compliance times a thrust that does the work of the weight in any small motion."""
    truth = hidden(clean, "payload-compliance", generator, mass=80.0)
    load = truth.load
    assert load is not None
    thrust = -leg_changes(truth) / load.compliance
    six = stood(truth, true_heats(truth))
    plates = 1.0 + np.concatenate([heat.plates for heat in told_rises(truth)]) * filed_expansions(truth)
    platform = truth.platform_joints * plates[:, :1, None]
    base = truth.base_joints * plates[:, 1:, None]
    step = 1e-6
    for axis in range(6):
        away = [nominal(truth, seen(six, np.tile(sign * step * np.eye(6)[axis], (len(six), 1)))) for sign in (1, -1)]
        longer = (lengths_of(away[0], base, platform) - lengths_of(away[1], base, platform)) / (2.0 * step)
        centres = [one.position + turned(one.turn, load.centre) for one in away]
        fallen = (centres[0] - centres[1]) @ load.weight / (2.0 * step)
        # the arm of the weight about home: forces are some 1e3 N
        assert np.abs((thrust * longer).sum(axis=1) + fallen).max() < 1e-4 * np.abs(load.weight).max()


def test_a_joint_off_its_place_is_where_it_is_said(clean: MachineTruth, generator: np.random.Generator) -> None:
    """Platforms stand on legs of told lengths between joints of which one is moved; only that leg seems off."""
    truth = hidden(clean, "joint-offset", generator, target="platform joint 2", size=1e-4)
    change = leg_changes(truth)
    assert np.abs(np.delete(change, 1, axis=1)).max() < LENGTH_TOLERANCE_M
    assert 0.0 < np.abs(change[:, 1]).max() <= 1.1e-4


def test_what_is_outside_is_no_cause_of_the_catalogue() -> None:
    """The eight causes of a machine, two of a leg, and at least three that no catalogue has."""
    names = set(found())
    foreign = {name for name in names if name.startswith(OUTSIDE)}
    assert set(CATALOGUE) <= names
    assert len(foreign) >= 3
    assert names - foreign - set(CATALOGUE) == {"periodic-screw-error", "scale-error"}


@pytest.mark.parametrize("way", WAYS)
def test_poses_stay_within_strokes_and_limits(way: str, seed: int) -> None:
    """Every pose of every way, on machines of all kinds, is one that the machine can reach."""
    generator = np.random.default_rng([seed, 6])
    for name in machine_names():
        hexapod = draw_machine(generator, name)
        six = draw_poses(hexapod, 60, 0.95, way, generator)
        assert reachable(hexapod, six).all()
        low, high = hexapod.length_limits
        told = np.hstack([six[:, :3] * 1e3, np.degrees(six[:, 3:])])
        lengths = hexapod.inverse_kinematics(ht.pose_from_coordinates(told, hexapod=hexapod))
        assert ((lengths > low) & (lengths < high)).all()
        hexapod.forward_kinematics(lengths, ht.pose_from_coordinates(told, hexapod=hexapod))  # within cones, or raises


def test_drawn_machines_hold_their_platform(seed: int) -> None:
    """Drawn machines differ, none is near a singular posture at home."""
    generator = np.random.default_rng([seed, 7])
    drawn = [draw_machine(generator, DRAWN) for _k in range(10)]
    sizes = [float(np.linalg.norm(one.base_joints[0] - one.base_joints[3])) for one in drawn]
    assert len(set(sizes)) == 10
    assert all(condition(one.base_joints, one.platform_joints + one.home[:3, 3]) <= WORST for one in drawn)


def test_the_generator_shares_nothing_with_what_it_tries() -> None:
    """No module of the generator imports the house's kinematics, predictions, or diagnosis."""
    folder = Path(machines.__file__).parent
    banned = ("hexathermal.kinematics", "hexathermal.predict", "hexathermal.learn", "hexathermal.machine.pinocchio")
    for file in folder.rglob("*.py"):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            names = [node.module or ""] if isinstance(node, ast.ImportFrom) else []
            names += [item.name for item in node.names] if isinstance(node, ast.Import) else []
            assert not [name for name in names if name.startswith(banned)], file
