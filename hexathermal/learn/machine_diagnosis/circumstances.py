"""What of the poses and temperatures of a machine keeps faults from being seen or told apart, in words."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import TYPE_CHECKING

import numpy as np

from hexathermal.kinematics.inverse import inverse_kinematics
from hexathermal.learn.hexapod_data import PLATES
from hexathermal.poses import FloatArray

if TYPE_CHECKING:
    from hexathermal.learn.machine_diagnosis.view import MachineView

STILL_K = 0.1
"""A temperature that stays within this standard deviation does not tell [K]: thermometers err by as much."""

ONE_COURSE = 0.995
"""Part of the square of all temperatures that one course explains where they are called alike."""

FEW_POSES = 7
"""Fewer different poses than this leave no row beside a frame and one unknown."""

STILL_STROKE = 0.005
"""A leg that moves by less of its length stands still."""

STILL_TURN = 0.005
"""A platform that turns by less [rad] does not turn."""

THERMAL = ("leg-coefficient", "platform-expansion", "base-expansion", "swapped-legs", "tracker-drift")
SHARED = ("platform-expansion", "base-expansion", "tracker-drift")
POSED = ("joint-offset", "payload-compliance", *(cause for cause in THERMAL if cause != "swapped-legs"))


@dataclass(frozen=True)
class Circumstance:
    """Something of the rows that hides faults: in words, and the causes that it hides."""

    words: str
    causes: tuple[str, ...]

    def concerns(self, causes: Sequence[str]) -> bool:
        """Whether it hides one of some causes."""
        return any(cause in self.causes for cause in causes)


def circumstances(view: MachineView) -> tuple[Circumstance, ...]:
    """Return what of the poses and temperatures of a view hides faults."""
    return (*_of_temperatures(view), *_of_poses(view))


def missing_channels(view: MachineView) -> tuple[str, ...]:
    """Return what is not recorded although causes of the catalogue follow it, and what that costs."""
    lines = [
        f"no thermometer on the {part} is recorded (column {part}_T1_degC): {part}-expansion cannot be looked for"
        for k, part in enumerate(PLATES)
        if not np.isfinite(view.plates[:, k]).any()
    ]
    if not np.isfinite(view.air).any():
        lines.append(
            "the air's temperature is not recorded (column air_temperature_degC): tracker-drift that follows the room "
            "cannot be looked for"
        )
    return tuple(lines)


def _of_temperatures(view: MachineView) -> Iterator[Circumstance]:
    """Give what of the temperatures hides faults."""
    told = view.read.any(axis=0) if view.read.any() else np.ones(len(view.sensors), dtype=bool)
    legs = view.dT[..., told].mean(axis=2)
    each = {f"leg {leg + 1}": legs[:, leg] for leg in range(6)}
    each |= {f"the {part}": view.plates[:, k] for k, part in enumerate(PLATES)} | {"the air": view.air}
    known = {name: course for name, course in each.items() if np.isfinite(course).all()}
    still = [name for name, course in known.items() if _size(course) < STILL_K]
    if len(still) == len(known):
        yield Circumstance(f"no temperature leaves its zero by more than {STILL_K:g} K (RMS)", THERMAL)
        return
    if still:
        follows = {"the platform": "platform-expansion", "the base": "base-expansion", "the air": "tracker-drift"}
        causes = {follows.get(name, "leg-coefficient") for name in still}
        yield Circumstance(f"constant within {STILL_K:g} K: {', '.join(still)}", tuple(sorted(causes)))
    moving = np.column_stack([course for name, course in known.items() if name not in still])
    if moving.shape[1] > 1 and _one_course(_scaled(moving)) > ONE_COURSE:
        yield Circumstance("all temperatures follow one course: no part is warm while another is cold", THERMAL)
    else:
        if _one_course(legs) > ONE_COURSE and _size(legs.mean(axis=1)) >= STILL_K:
            yield Circumstance("the six legs follow one course", ("leg-coefficient", "swapped-legs"))
        parts = [name for name in known if not name.startswith("leg") and name not in still]
        for one, two in combinations(parts, 2):
            if _one_course(_scaled(np.column_stack([known[one], known[two]]))) > ONE_COURSE:
                yield Circumstance(f"{one} and {two} follow one course", SHARED)
    twins = [f"{a + 1} and {b + 1}" for a, b in combinations(range(6), 2) if _size(legs[:, a] - legs[:, b]) < STILL_K]
    if twins:
        some = ", ".join(twins[:4]) + (" ..." if len(twins) > 4 else "")
        yield Circumstance(f"equally warm within {STILL_K:g} K: legs {some}", ("swapped-legs",))


def _of_poses(view: MachineView) -> Iterator[Circumstance]:
    """Give what of the poses hides faults."""
    poses = view.poses
    different = len(np.unique(np.round(poses[:, :3].reshape(len(poses), -1), 5), axis=0))
    if different < FEW_POSES:
        yield Circumstance(f"only {different} different pose{'s' if different > 1 else ''}", POSED)
    turns = np.linalg.norm(poses[:, :3, :3] - poses[0, :3, :3], axis=(1, 2)) / np.sqrt(2.0)
    if turns.max() < STILL_TURN:
        yield Circumstance(f"the platform never turns by more than {1e3 * STILL_TURN:g} mrad", POSED)
    lengths = inverse_kinematics(view.hexapod, poses)
    moved = np.ptp(lengths, axis=0)
    still = [str(leg + 1) for leg in range(6) if moved[leg] < STILL_STROKE * lengths[:, leg].mean()]
    if still:
        which = "no leg moves" if len(still) == 6 else f"leg {', '.join(still)} never moves"
        yield Circumstance(f"{which} by more than {100 * STILL_STROKE:g} % of its length", (*POSED, "leg-backlash"))
    one_way = [str(leg + 1) for leg in range(6) if _one_way(view, lengths[:, leg])]
    if one_way:
        yield Circumstance(f"always approached from the same side: leg {', '.join(one_way)}", ("leg-backlash",))


def _one_way(view: MachineView, length: FloatArray) -> bool:
    """Whether a leg moves in one direction only within every run."""
    steps = np.diff(length)[np.diff(view.run) == 0]
    signs = np.sign(steps[np.abs(steps) > 1e-9])
    return bool(signs.size and np.all(signs == signs[0]))


def _size(course: FloatArray) -> float:
    """Return the root mean square of a course of temperatures [K]."""
    return float(np.sqrt(np.mean(np.square(course))))


def _scaled(courses: FloatArray) -> FloatArray:
    """Return courses (n, m) of unit size each, so that a small one counts as much as a large one."""
    return np.asarray(courses / np.maximum(np.sqrt(np.mean(np.square(courses), axis=0)), 1e-12))


def _one_course(courses: FloatArray) -> float:
    """Return which part of the square of courses (n, m) the best single one explains."""
    values = np.square(np.linalg.svd(courses, compute_uv=False))
    return float(values[0] / values.sum()) if values.sum() > 0.0 else 1.0
