"""A campaign of a hexapod with nothing hidden in it: a machine, a hall, poses, roles, levels of noise, all drawn."""

from __future__ import annotations

import numpy as np

from hexathermal.machine.hexapod import Hexapod
from hexathermal.poses import FloatArray
from hexathermal.simulate.bench.thermocouples import slow_process
from hexathermal.simulate.hidden.found_modules import chosen
from hexathermal.simulate.hidden.machines import halls
from hexathermal.simulate.hidden.machines.geometry import draw_machine, machine_names
from hexathermal.simulate.hidden.machines.halls.warmth import Warmth
from hexathermal.simulate.hidden.machines.motion import SHARES, WAYS, displaced, draw_course, draw_poses
from hexathermal.simulate.hidden.machines.physics import as_filed
from hexathermal.simulate.hidden.machines.strength import feigned
from hexathermal.simulate.hidden.machines.truth import MachineRunTruth, MachineTruth
from hexathermal.simulate.hidden.shapes import log_uniform

RUNS, POSES, VALIDATION = 6, 150, 2

NOISE = (0.4e-6, 1e-6)
"""White noise of a coordinate [m], [rad], as most campaigns have it."""

USUAL = 0.6
"""Part of the campaigns with `NOISE`; the others have 0.3 to 3 times of it, each kind of coordinate by itself."""

STILL = 0.4
"""Part of the campaigns in which the measuring frame does not creep, and part in which it is true in all runs."""

CREEP, FRAMES = (0.05, 0.3), (1.0, 40.0)
"""Of the others, over the levels of the noise: how far the frame creeps within hours, how far runs stand off."""

ZERO_BY_RUN, AIR, PLATES = 0.3, 0.9, 0.85
"""Parts of the campaigns that count temperatures from each run; that record the air; that record each plate."""

FEIGNED = 0.1
"""Most that errors of thermometers may feign through the law as filed, over the noise: clean means clean. Where drawn
ones feign more, as through a plate far from its frame's origin, they are made smaller."""

LANDING = 2e-8
"""By which a rod comes to rest beside its command [m]; the scale sees it."""


def draw_clean(
    generator: np.random.Generator, *, hall: str | None = None, machine: str | None = None, recorded: bool = False
) -> tuple[MachineTruth, str]:
    """Draw a campaign of a machine that is as filed; and what the machine is called.

    Parameters
    ----------
    generator : numpy.random.Generator
    hall, machine : str, optional
        Default: drawn.
    recorded : bool
        Plates and air are recorded; otherwise that is drawn.
    """
    if machine is not None:
        chosen(machine, dict.fromkeys(machine_names(), True), "machine")
    hexapod = draw_machine(generator, machine)
    hall = str(generator.choice(list(halls.found()))) if hall is None else hall
    course = draw_course(RUNS, POSES, generator)
    joints = hexapod.platform_joints - hexapod.platform_joints.mean(axis=0)
    assert hexapod.thermal is not None  # just drawn
    count = len(hexapod.thermal.legs[0].sensors)
    warmth = halls.warm(hall, course, np.arctan2(joints[:, 1], joints[:, 0]), count, generator)
    levels = draw_levels(generator)
    share, way = log_uniform(*SHARES, generator), str(generator.choice(WAYS))
    roles = draw_roles(generator)
    frames, creep = draw_frames(levels, course.rows, generator)
    noise_K, bias_K, walk_K = log_uniform(0.002, 0.02, generator), 0.1, log_uniform(0.001, 0.01, generator)
    shape = 6 * count + 3
    bias = bias_K * generator.standard_normal(shape)
    walk = walk_K * slow_process(np.concatenate(course.rows), 21600.0, shape, generator)
    errors = np.split(bias + walk, RUNS)
    runs = []
    for k, time in enumerate(course.rows):
        read = errors[k] + noise_K * generator.standard_normal((POSES, shape))
        runs.append(_run(f"run-{k + 1:02d}", roles[k], time, draw_poses(hexapod, POSES, share, way, generator),
                         hexapod, warmth.at(course, time), read, frames[k] + creep[k], levels, generator))  # fmt: skip
    plates = tuple(bool(law is not None or recorded or generator.random() < PLATES)
                   for law in (hexapod.thermal.platform, hexapod.thermal.base))  # fmt: skip
    truth = MachineTruth(
        hexapod, hall, tuple(runs), "run" if generator.random() < ZERO_BY_RUN else "campaign", levels,
        (plates[0], plates[1]), bool(recorded or generator.random() < AIR), np.zeros(0), np.zeros(0), np.zeros(0),
        hexapod.base_joints, hexapod.platform_joints, notes={"share": share, "way": way, "sensor_noise_K": noise_K},
    )  # fmt: skip
    return with_true_thermometers(as_filed(truth)), machine or hexapod.name


def with_true_thermometers(truth: MachineTruth) -> MachineTruth:
    """Return a campaign with errors of thermometers that feign `FEIGNED` at most."""
    size = feigned(truth)
    if size <= FEIGNED:
        return truth
    names = ("leg_errors", "plate_errors", "air_errors")
    runs = tuple(run.changed(**{name: FEIGNED / size * getattr(run, name) for name in names}) for run in truth.runs)
    return truth.changed(runs=runs)


def _run(
    name: str, role: str, time: FloatArray, commanded: FloatArray, hexapod: Hexapod, heat: Warmth, read: FloatArray,
    frame: FloatArray, levels: FloatArray, generator: np.random.Generator,
) -> MachineRunTruth:  # fmt: skip
    """Return a run in which nothing is hidden."""
    n, count = time.size, heat.legs.shape[2]
    q = np.round(displaced(hexapod, commanded) + LANDING * generator.standard_normal((n, 6)), 9)
    return MachineRunTruth(
        name, role, time, commanded, q, heat.legs, heat.plates, heat.air, read[:, : 6 * count].reshape(n, 6, count),
        read[:, -3:-1], read[:, -1], frame, levels * generator.standard_normal((n, 6)), np.zeros((n, 6)),
        np.zeros((n, 6, 3)), np.zeros((n, 6)),
    )  # fmt: skip


def draw_levels(generator: np.random.Generator) -> FloatArray:
    """Draw the standard deviations of the six coordinates, shape (6,) [m, m, m, rad, rad, rad]."""
    levels = np.repeat(NOISE, 3)
    if generator.random() < USUAL:
        return levels
    return np.asarray(levels * np.repeat([log_uniform(0.3, 3.0, generator) for _kind in NOISE], 3))


def draw_roles(generator: np.random.Generator) -> list[str]:
    """Draw which runs are never fitted: `VALIDATION` of them, anywhere."""
    kept = generator.choice(RUNS, VALIDATION, replace=False)
    return ["validation" if k in kept else "identification" for k in range(RUNS)]


def draw_frames(
    levels: FloatArray, rows: tuple[FloatArray, ...], generator: np.random.Generator
) -> tuple[FloatArray, list[FloatArray]]:
    """Draw how far the measuring frame stands off in each run, shape (runs, 6), and how it creeps, (n, 6) of each."""
    frames = np.zeros((len(rows), 6))
    if generator.random() >= STILL:
        frames = log_uniform(*FRAMES, generator) * levels * generator.standard_normal(frames.shape)
    creep = np.zeros((sum(time.size for time in rows), 6))
    if generator.random() >= STILL:
        hours = log_uniform(2.0, 12.0, generator)
        creep = (
            log_uniform(*CREEP, generator) * levels * slow_process(np.concatenate(rows), 3600.0 * hours, 6, generator)
        )
    return frames, np.split(creep, np.cumsum([time.size for time in rows])[:-1])
