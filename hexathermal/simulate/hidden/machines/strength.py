"""How strong an effect on a hexapod is against the noise, and what knowing it would gain.

    strength = rms(effect_k / level_k)     over the rows of the runs for identification, and the six coordinates k

`whole` counts all that `physics.effect` says; `visible` what is left of it when each run may have a frame of its own,
the six motions about home that fit it best: a constant motion of a run tells of the tracker as well as of anything.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hexathermal.poses import FloatArray
from hexathermal.simulate.hidden.machines.physics import (
    as_filed,
    effect,
    measured,
    mended_heats,
    read_heats,
    seen,
    stood,
    true_heats,
)
from hexathermal.simulate.hidden.machines.rotation import from_angles, product
from hexathermal.simulate.hidden.machines.truth import MachineTruth

TINY = 1e-6
"""By which a frame is moved to see what it does to the coordinates [m, rad]."""


def whole(truth: MachineTruth) -> float:
    """Return the strength of all that hides in a campaign."""
    rows = truth.rows("identification")
    return float(np.sqrt(np.mean((effect(truth)[rows] / truth.levels) ** 2)))


def visible(truth: MachineTruth) -> float:
    """Return the strength that is left where each run may have a frame of its own."""
    rows = truth.rows("identification")
    return float(np.sqrt(np.mean((unframed(truth, effect(truth))[rows] / truth.levels) ** 2)))


def feigned(truth: MachineTruth) -> float:
    """Return the strength of what errors of the thermometers feign through the machine's law."""
    rows = truth.rows("identification")
    apart = stood(truth, mended_heats(truth)) - stood(truth, true_heats(truth))
    return float(np.sqrt(np.mean((apart[rows] / truth.levels) ** 2)))


def unframed(truth: MachineTruth, values: FloatArray) -> FloatArray:
    """Return differences of coordinates of all rows (n, 6) less the motion about home that fits each run best."""
    here = truth.all("commanded")
    slopes = np.stack([(seen(here, np.broadcast_to(TINY * axis, here.shape)) - here) / TINY for axis in np.eye(6)], -1)
    found, begin = np.empty_like(values), 0
    for run in truth.runs:
        own = slice(begin, begin + run.time.size)
        columns = (slopes[own] / truth.levels[:, None]).reshape(-1, 6)
        best = np.linalg.lstsq(columns, (values[own] / truth.levels).ravel())[0]
        found[own] = values[own] - slopes[own] @ best
        begin = own.stop
    return found


@dataclass(frozen=True)
class Distances:
    """Root mean squares of distances between platforms in runs for validation.

    Attributes
    ----------
    translation : float [m]
    rotation : float [rad]
    """

    translation: float
    rotation: float


@dataclass(frozen=True)
class MachineOracle:
    """What the measured poses of the validation runs differ from, and by how much.

    Attributes
    ----------
    filed, known : Distances
        From those that the machine as filed foretells from what the thermometers read; and the true machine.
    noise : Distances
        Of the noise.
    filed_unframed, known_unframed : Distances
        The same where each run may have a frame of its own.
    """

    filed: Distances
    known: Distances
    noise: Distances
    filed_unframed: Distances
    known_unframed: Distances


def oracle(truth: MachineTruth) -> MachineOracle:
    """Return what knowing the effects would gain on runs for validation."""
    shown = measured(truth)
    filed = stood(as_filed(truth), read_heats(truth))
    known = seen(stood(truth, mended_heats(truth)), truth.all("moved"))
    noise = truth.all("noise")
    return MachineOracle(
        _distances(truth, filed, shown), _distances(truth, known, shown), _distances(truth, shown - noise, shown),
        _distances(truth, filed, filed + unframed(truth, shown - filed)),
        _distances(truth, known, known + unframed(truth, shown - known)),
    )  # fmt: skip


def _distances(truth: MachineTruth, some: FloatArray, others: FloatArray) -> Distances:
    """Return the distances between coordinates (n, 6) of all rows; NaN without a run for validation."""
    rows = truth.rows("validation")
    if not rows.any():
        return Distances(float("nan"), float("nan"))
    apart = np.linalg.norm(others[rows, :3] - some[rows, :3], axis=1)
    back = from_angles(some[rows, 3:]) * np.array([1.0, -1.0, -1.0, -1.0])
    vector = product(from_angles(others[rows, 3:]), back)[:, 1:]
    turn = 2.0 * np.arcsin(np.clip(np.linalg.norm(vector, axis=1), 0.0, 1.0))
    return Distances(float(np.sqrt(np.mean(apart**2))), float(np.sqrt(np.mean(turn**2))))
