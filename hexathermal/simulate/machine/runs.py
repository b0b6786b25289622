"""Runs of the virtual hexapod, made in two stages, so that something may happen to the truth before it is recorded.

    truth = true_machine_run(machine, plan, generator)                # heat, growth, true pose: what happens
    run   = recorded_poses(machine, truth, thermometers, generator)   # what instruments write

The true pose is the forward kinematics of the true lengths between the expanded joints; no thermal law is used.
Legs give way to the payload that the machine states, and its measuring frame moves with the temperature it follows.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from hexathermal.errors import ArgumentError
from hexathermal.kinematics.sampled_poses import reachable_coordinates
from hexathermal.machine.hexapod import Hexapod
from hexathermal.machine.thermal import frozen
from hexathermal.poses import FloatArray, coordinates_from_pose
from hexathermal.predict.balance import balanced
from hexathermal.predict.measuring import measured_poses
from hexathermal.predict.pose_errors import moved_poses
from hexathermal.simulate.bench.bench import SCALE_RESOLUTION, roles
from hexathermal.simulate.bench.room import Weather
from hexathermal.simulate.bench.thermocouples import MountedThermocouples
from hexathermal.simulate.machine.heat import MachineHistory
from hexathermal.simulate.machine.machine import VirtualMachine
from hexathermal.simulate.machine.motion import MachineMotion, planned_motion

AIR = "air_temperature"


@dataclass(frozen=True, eq=False)
class MachinePlan:
    """What is to happen in a run: its name, its role and its motion."""

    name: str
    role: str
    motion: MachineMotion


@dataclass(frozen=True, eq=False)
class TrueMachineRun:
    """What truly happens in a run, n measured poses.

    Attributes
    ----------
    plan : MachinePlan
    time : array, shape (n,) [s]
    q : array, shape (n, 6) [m]
        Displacements by the scales.
    poses : array, shape (n, 4, 4) [m]
        True platform in base.
    growth : array, shape (n, 6) [m]
        By how much heat makes the legs longer than their scales say.
    expansions : array, shape (n, 2)
        Relative growth of platform and base.
    history : MachineHistory
    weather : Weather
    """

    plan: MachinePlan
    time: FloatArray
    q: FloatArray
    poses: FloatArray
    growth: FloatArray
    expansions: FloatArray
    history: MachineHistory
    weather: Weather


@dataclass(frozen=True, eq=False)
class MachineRun:
    """What is written of a run, n measured poses.

    Attributes
    ----------
    name, role : str
    time : array, shape (n,) [s]
    commanded, measured : array, shape (n, 6) [mm, deg]
        From home.
    q : array, shape (n, 6) [m]
    temperatures : array, shape (n, c) [degC]
        In the order of `VirtualMachine.columns`.
    air : array, shape (n,) [degC]
    truth : TrueMachineRun
        Never written into a campaign.
    frame : array, shape (6,) [m, rad]
        Error of the positioning system's frame: never written either.
    """

    name: str
    role: str
    time: FloatArray
    commanded: FloatArray
    measured: FloatArray
    q: FloatArray
    temperatures: FloatArray
    air: FloatArray
    truth: TrueMachineRun
    frame: FloatArray


def planned_machine_runs(
    machine: VirtualMachine,
    seed: int = 1,
    *,
    identification: int = 6,
    validation: int = 2,
    poses: int = 150,
    given: FloatArray | None = None,
) -> tuple[MachinePlan, ...]:
    """Return the plan of a campaign.

    Parameters
    ----------
    machine : VirtualMachine
    seed : int
    identification, validation : int
        Numbers of runs.
    poses : int
        Measurements in each.
    given : array, shape (m, 6) [mm, deg], optional
        Poses of the runs for identification, taken in turn; default: drawn at random.
    """
    if identification < 0 or validation < 0 or identification + validation < 1:
        raise ArgumentError(f"a campaign needs at least one run, found {identification} + {validation}")
    plans = []
    loads = machine.scenario.loads
    for k, role in enumerate(roles(identification, validation)):
        generator = np.random.default_rng([seed, 11, k])
        number = k if role == "identification" else k - identification
        drawn = given is None or role == "validation"
        six = reachable_coordinates(machine.hexapod, poses, generator) if drawn else np.asarray(given)
        errands = reachable_coordinates(machine.hexapod, 12, generator, share=0.1)
        motion = planned_motion(machine.hexapod, machine.scenario, six, errands, machine.heat.legs[0].drive.speed,
                                generator, count=poses, load=loads[number % len(loads)])  # fmt: skip
        plans.append(MachinePlan(f"run-{k + 1:02d}", role, motion))
    return tuple(plans)


def true_machine_run(
    machine: VirtualMachine, plan: MachinePlan, generator: np.random.Generator, zero: FloatArray | None = None
) -> TrueMachineRun:
    """Return what truly happens in a run: the machine starts at rest, in equilibrium with its room.

    Parameters
    ----------
    machine : VirtualMachine
    plan : MachinePlan
    generator : numpy.random.Generator
    zero : array, shape (c,) [degC], optional
        Temperatures under the thermometers from which a machine that follows its law grows; default: those with which
        the run begins.
    """
    motion, hexapod = plan.motion, machine.hexapod
    weather = machine.room.weather(motion.time, generator)
    own = np.clip(motion.q - machine.lowest, 0.0, None)
    start = machine.heat.at_rest(float(weather.temperature[0]), own[0])
    history = machine.heat.warm(motion.time, own, weather.temperature, start).at(motion.rows)
    growth, expansions = _grown(machine, history, motion.q[motion.rows], zero)
    told = np.array(machine.retracted + motion.q[motion.rows])
    landed = machine.landing * generator.standard_normal(growth.shape)
    poses = true_poses(hexapod, told + growth + landed, told, expansions)
    air = Weather(*(frozen(part[motion.rows]) for part in (weather.temperature, weather.pressure, weather.humidity)))
    return TrueMachineRun(
        plan, history.time, frozen(motion.q[motion.rows]), frozen(poses), frozen(growth), frozen(expansions), history,
        air,
    )  # fmt: skip


def _grown(
    machine: VirtualMachine, history: MachineHistory, q: FloatArray, zero: FloatArray | None
) -> tuple[FloatArray, FloatArray]:
    """Return the growth of the legs (n, 6) [m] and the relative one of platform and base (n, 2)."""
    if machine.growth == "law":
        surfaces = machine.surfaces(history)
        return machine.told_growth(surfaces - (surfaces[0] if zero is None else zero), q)
    reference = machine.reference()
    rise = np.column_stack([history.platform - reference[1], history.base - reference[0]])
    return history.growth(reference), rise * [machine.heat.platform.expansion, machine.heat.base.expansion]


def true_poses(hexapod: Hexapod, lengths: FloatArray, told: FloatArray, expansions: FloatArray) -> FloatArray:
    """Return the poses at true lengths between expanded joints, shape (n, 4, 4) [m]; `told` keeps to the strokes.

    Lengths are those without the machine's payload, under which legs give way.
    """
    return balanced(hexapod, lengths, told, np.array(expansions), (len(lengths),))


def mounted_thermometers(machine: VirtualMachine, seed: int) -> MountedThermocouples:
    """Return the machine's thermometers with their constant errors, the same in all runs."""
    kind, count = machine.thermocouples, len(machine.columns)
    generator = np.random.default_rng([seed, 12])
    return MountedThermocouples(
        kind, frozen(kind.offset * generator.standard_normal(count)),
        frozen(1.0 + kind.gain * generator.standard_normal(count)),
        frozen(generator.uniform(*kind.contact_error, count)),
    )  # fmt: skip


def frame_rise(machine: VirtualMachine, truth: TrueMachineRun) -> FloatArray:
    """Return how much warmer than the usual room that is which the machine's measuring frame follows, shape (n,) [K].

    Zeros for a frame that does not drift.

    Raises
    ------
    ArgumentError
        It follows what a virtual machine does not have.
    """
    frame = machine.hexapod.measuring_frame
    if frame is None:
        return np.zeros(len(truth.time))
    if frame.sensor == AIR:
        return truth.weather.temperature - machine.room.temperature
    names = machine.recorded_columns
    if frame.sensor not in names:
        raise ArgumentError(
            f"the measuring frame of machine {machine.hexapod.name!r} follows {frame.sensor!r}; a virtual machine "
            f"records {AIR}, {', '.join(names)}"
        )
    return np.asarray(machine.surfaces(truth.history)[:, names.index(frame.sensor)] - machine.room.temperature)


def recorded_poses(
    machine: VirtualMachine, truth: TrueMachineRun, thermometers: MountedThermocouples, generator: np.random.Generator
) -> MachineRun:
    """Return what is written of a run."""
    hexapod, tracker = machine.hexapod, machine.tracker
    frame = tracker.frame(generator)
    drifted = measured_poses(hexapod, truth.poses, frame_rise(machine, truth), truth.time)
    seen = moved_poses(drifted, frame, hexapod.home[:3, 3])
    noise = generator.standard_normal((len(seen), 6)) * tracker.noise
    noise[:, :3] *= 1e3
    noise[:, 3:] = np.degrees(noise[:, 3:])
    measured = coordinates_from_pose(seen, hexapod=hexapod) + noise
    air = truth.weather.temperature
    temperatures = thermometers.read(truth.time, machine.surfaces(truth.history), air, generator)
    q = np.round(truth.q / SCALE_RESOLUTION) * SCALE_RESOLUTION
    return MachineRun(
        truth.plan.name, truth.plan.role, truth.time, truth.plan.motion.coordinates, frozen(measured), frozen(q),
        temperatures, frozen(air), truth, frame,
    )  # fmt: skip


def simulate_machine(
    machine: VirtualMachine, seed: int = 1, plans: tuple[MachinePlan, ...] | None = None, zero: str = "campaign"
) -> Iterator[MachineRun]:
    """Simulate a campaign, one run after the other; the same seed makes the same campaign.

    Parameters
    ----------
    machine : VirtualMachine
    seed : int
        Of all that is drawn besides the machine itself.
    plans : tuple of MachinePlan, optional
        Default: `planned_machine_runs`, 6 runs to identify and 2 to validate, 150 poses each.
    zero : str
        A machine that follows its law has the geometry of its file at the first row of the ``"campaign"`` or of each
        ``"run"``: what temperatures of the campaign are to count from.

    Yields
    ------
    MachineRun

    Examples
    --------
    >>> import hexathermal as ht
    >>> from hexathermal.simulate.machine.building import virtual_machine
    >>> machine = virtual_machine(ht.load_hexapod("reference"))
    >>> (run,) = simulate_machine(machine, 1, planned_machine_runs(machine, identification=1, validation=0, poses=20))
    >>> run.measured.shape, run.temperatures.shape
    ((20, 6), (20, 8))
    """
    thermometers = mounted_thermometers(machine, seed)
    first: FloatArray | None = None
    for k, plan in enumerate(planned_machine_runs(machine, seed) if plans is None else plans):
        truth = true_machine_run(machine, plan, np.random.default_rng([seed, 13, k]), first)
        if zero == "campaign" and first is None:
            first = machine.surfaces(truth.history)[0]
        yield recorded_poses(machine, truth, thermometers, np.random.default_rng([seed, 14, k]))
