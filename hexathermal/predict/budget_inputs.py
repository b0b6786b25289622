"""What a budget is taken at: one machine, pose and temperatures, and the block of numbers that may be off there."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cache
from types import ModuleType
from typing import TypedDict

import numpy as np
import numpy.typing as npt

from hexathermal.errors import ArgumentError, NotConvergedError, UnknownNameError
from hexathermal.kinematics import layout as at
from hexathermal.kinematics.constants import LARGEST_CONDITION, constants
from hexathermal.kinematics.inverse import inverse_kinematics
from hexathermal.kinematics.jacobian import condition_number, jacobian
from hexathermal.kinematics.refusals import refuse_forward
from hexathermal.machine.hexapod import Hexapod
from hexathermal.machine.thermal import ABSOLUTE_ZERO_DEGC, TemperaturesLike
from hexathermal.poses import FloatArray, Frames, PoseLike, finite_array, pose_array
from hexathermal.predict.budget_blocks import blocks, sensor_counts, source_factors
from hexathermal.predict.budget_plates import Plates as Plates
from hexathermal.predict.budget_plates import plate_rows
from hexathermal.predict.correction import corrected_leg_lengths, predicted_pose
from hexathermal.predict.sources import Source
from hexathermal.predict.temperatures import active_model, check_temperatures, temperature_array

FRAMES = ("machine", "user", "object")


class View(TypedDict, total=False):
    """How a machine is driven and looked at: keywords that all budgets share, see `error_budget`."""

    correction: bool
    frame: str
    frames: Frames | None
    at_tool: npt.ArrayLike | None
    plates: Plates | None
    air_degC: float | None


@cache
def drawers() -> ModuleType:
    """Return the compiled loops over deviations."""
    from hexathermal.kinematics import draws_loops

    return draws_loops


@dataclass(frozen=True, eq=False)
class Situation:
    """One machine at one pose and one set of temperatures, ready to be deviated from.

    Attributes
    ----------
    told : array, shape (6,) [m]
        Commanded lengths.
    dT, lag : array, shape (n,) [K]
        Reading minus reference, and minus the air, for each sensor.
    plates : array, shape (2, 8)
        Expansion [1/K], temperature [K] (0 where a sensor tells it), gradient [K/m] and the point that does not move
        [m] of platform and base.
    axes : array, shape (3, 3)
        Turns base axes into those of the budget's frame.
    arm : array, shape (3,) [m]
        The point of the budget, from the platform's origin, in platform axes.
    correction : bool
    frame : str
    """

    hexapod: Hexapod
    pose: FloatArray
    temps: FloatArray
    told: FloatArray
    dT: FloatArray
    lag: FloatArray
    plates: FloatArray
    axes: FloatArray
    arm: FloatArray
    correction: bool
    frame: str
    _numbers: FloatArray = field(repr=False)

    @property
    def size(self) -> int:
        """How many numbers may be off."""
        n, m = sensor_counts(self.hexapod)
        return 3 * n + 2 * m + 65

    def blocks(self, quantity: str) -> tuple[npt.NDArray[np.int64], int, int]:
        """Return where a quantity's numbers stand in a deviation, see `hexathermal.predict.budget_blocks.blocks`."""
        return blocks(self.hexapod, quantity)

    def factors(self, source: Source) -> tuple[FloatArray, bool]:
        """Return how the variables of a source move a deviation, shape (size + 6, r); the last six are the pose's.

        The second value tells whether they count as one component.
        """
        own = source_factors(self.hexapod, source)
        pose = source.quantity == "pose"
        index = np.arange(self.size, self.size + 6) if pose else self.blocks(source.quantity)[0]
        out = np.zeros((self.size + 6, own.shape[1]))
        out[index] = own
        return out, source.joint

    def errors(self, deviations: FloatArray | None = None, told: FloatArray | None = None) -> FloatArray:
        """Return exact errors (N, 6) of the point for many deviations (N, size); one row where there is none."""
        x = np.zeros((1, self.size)) if deviations is None else deviations
        lengths, joints = np.empty((len(x), 6)), np.empty((len(x), 36))
        both = constants(self.hexapod).both_law
        commands = self.told if told is None else told
        drawers().deviated_many(both, commands, self.dT, self.lag, self.plates, x, lengths, joints)
        return chord_errors(self._numbers, lengths, joints)

    def rates(self) -> FloatArray:
        """Return the derivatives (6, size + 6) of the error for each deviation, at the expected true pose.

        Implicit derivative of ``|t + R p - b| = l``: ``J dx = dl - u . R dp + u . db``; the last six are the pose's
        own.  It is moved to the point and turned into the budget's axes.
        """
        zero = self.errors()[0]
        made, x = constants(self.hexapod), np.zeros((1, self.size))
        lengths, joints = np.empty((1, 6)), np.empty((1, 36))
        drawers().deviated_many(made.both_law, self.told, self.dT, self.lag, self.plates, x, lengths, joints)
        R, t = self._true_pose(zero)
        s = joints[0, :18].reshape(6, 3) @ R.T
        d = s + t - joints[0, 18:].reshape(6, 3)
        units = d / lengths[0][:, None]
        out = np.empty((6, self.size))
        drawers().length_rates(
            made.both_law, self.told, self.dT, self.lag, self.plates, R, units, self._steps(), out
        )  # fmt: skip
        c = R @ self.arm
        J = np.hstack([units, np.cross(s - c, units)])
        moved = np.linalg.solve(J, out)
        turned = np.vstack([self.axes @ moved[:3], self.axes @ moved[3:]])
        turned[3:] = _vector_rate(zero[3:]) @ turned[3:]
        return np.hstack([turned, np.eye(6)])

    def _true_pose(self, error: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return rotation and origin of the platform that is off by an error of the point."""
        from scipy.spatial.transform import Rotation

        turn = Rotation.from_rotvec(self.axes.T @ error[3:]).as_matrix()
        R = turn @ self.pose[:3, :3]
        point = self.pose[:3, 3] + self.pose[:3, :3] @ self.arm + self.axes.T @ error[:3]
        return R, point - R @ self.arm

    def _steps(self) -> FloatArray:
        """Return steps that move lengths and joints by metres, so that differences lose no digits."""
        steps = np.ones(self.size)
        for quantity in ("temperature", "gain", "contact", "plate temperature", "plate gradient",
                         "reference temperature"):  # fmt: skip
            steps[self.blocks(quantity)[0]] = 1e6
        return steps


def chord_errors(numbers: FloatArray, lengths: FloatArray, joints: FloatArray) -> FloatArray:
    """Return exact errors (N, 6) of a pose's point for true lengths (N, 6) and joints (N, 36; empty: the machine's).

    Raises
    ------
    NotConvergedError
        The branch of a pose is not certain.
    """
    out, codes = np.empty((len(lengths), 6)), np.zeros(len(lengths), dtype=np.int8)
    bad = drawers().draw_errors(numbers, lengths, joints, out, codes)
    if bad:
        first = int(np.flatnonzero(codes)[0])
        raise NotConvergedError(
            f"{bad} of {len(lengths)} deviations (the first at index {first}) move the platform too far for the branch "
            "of its pose to be certain (more than 3 % of the machine's size, or across a singular pose); check "
            "the standard uncertainties and their units, or choose a pose farther from singular ones"
        )
    return out


def _vector_rate(r: FloatArray) -> FloatArray:
    """Return the rate of a rotation vector for an angular velocity: the inverse of SO(3)'s left Jacobian."""
    angle = float(np.linalg.norm(r))
    K = np.array([[0.0, -r[2], r[1]], [r[2], 0.0, -r[0]], [-r[1], r[0], 0.0]])
    k = 1.0 / 12.0 if angle < 1e-4 else 1.0 / angle**2 - (1.0 + np.cos(angle)) / (2.0 * angle * np.sin(angle))
    return np.asarray(np.eye(3) - 0.5 * K + k * K @ K)


def situation(
    hexapod: Hexapod,
    pose: PoseLike,
    temps: TemperaturesLike,
    *,
    correction: bool = True,
    frame: str = "machine",
    frames: Frames | None = None,
    at_tool: npt.ArrayLike | None = None,
    plates: Plates | None = None,
    air_degC: float | None = None,
) -> Situation:
    """Return the situation of a budget; parameters and errors as in `hexathermal.predict.budget.error_budget`."""
    model = active_model(hexapod)
    wanted = pose_array(pose)
    readings = temperature_array(hexapod, temps)
    if wanted.shape != (4, 4) or readings.ndim != 1:
        raise ArgumentError(
            f"a budget is taken at one pose and one set of temperatures, found shapes {wanted.shape} and "
            f"{readings.shape}; budget_map takes many"
        )
    check_temperatures(hexapod, readings)
    refuse_singular(hexapod, wanted)
    if correction:
        told = corrected_leg_lengths(hexapod, wanted, readings)
    else:
        told = inverse_kinematics(hexapod, wanted)
        predicted_pose(hexapod, told, readings)
    reference = np.asarray(model.reference_temperature_degC)
    air = float(reference.mean()) if air_degC is None else float(finite_array(air_degC, (), "air_degC"))
    if air < ABSOLUTE_ZERO_DEGC:
        raise ArgumentError(f"air_degC is {air:g} degC, which is impossible")
    axes, arm = axes_and_arm(frame, frames, at_tool, wanted)
    rows = plate_rows(hexapod, readings, plates or Plates())
    numbers = pose_numbers(hexapod, wanted, axes, arm)
    return Situation(
        hexapod,
        wanted,
        readings,
        told,
        readings - reference,
        readings - air,
        rows,
        axes,
        arm,
        correction,
        frame,
        numbers,
    )


def refuse_singular(hexapod: Hexapod, pose: FloatArray) -> None:
    """Raise where leg lengths do not hold the platform."""
    if not condition_number(hexapod, pose) <= LARGEST_CONDITION:
        refuse_forward(hexapod, at.SINGULAR, pose, inverse_kinematics(hexapod, pose))


def axes_and_arm(
    frame: str, frames: Frames | None, at_tool: npt.ArrayLike | None, pose: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return what turns base axes into the frame's, and the point from the platform's origin."""
    if frame not in FRAMES:
        raise UnknownNameError(f"frame {frame!r} is not known; choose from {', '.join(FRAMES)}", FRAMES)
    if frames is not None and not isinstance(frames, Frames):
        raise ArgumentError(f"frames must be a Frames, found {type(frames).__name__}")
    own = Frames() if frames is None else frames
    T_platform_object = np.asarray(Frames(object=own.object, convention=own.convention).user_pose(np.eye(4)))
    T_machine_user = np.asarray(Frames(user=own.user, convention=own.convention).machine_pose(np.eye(4)))
    arm = T_platform_object[:3, 3] if at_tool is None else finite_array(at_tool, (3,), "at_tool")
    if arm.shape != (3,):
        raise ArgumentError(f"at_tool has shape {arm.shape}; expected (3,), metres from the platform's origin")
    if np.abs(arm).max() > 1e3:
        raise ArgumentError(f"at_tool holds {np.abs(arm).max():g} m; metres are meant, were millimetres given?")
    turned = {
        "machine": np.eye(3),
        "user": T_machine_user[:3, :3].T,
        "object": (pose[:3, :3] @ T_platform_object[:3, :3]).T,
    }
    return np.ascontiguousarray(turned[frame]), np.array(arm)


def pose_numbers(hexapod: Hexapod, pose: FloatArray, axes: FloatArray, arm: FloatArray) -> FloatArray:
    """Return the numbers of a pose that `draw_errors` reads."""
    d, made = drawers(), constants(hexapod)
    R, p, b = pose[:3, :3], hexapod.platform_joints - made.centre, hexapod.base_joints
    origin = pose[:3, 3] + R @ made.centre
    f = np.zeros(d.DRAW_LENGTH)
    f[d.D_PLATFORM : d.D_PLATFORM + 18], f[d.D_BASE : d.D_BASE + 18] = (p @ R.T).ravel(), (b - origin).ravel()
    J = jacobian(hexapod, pose).copy()
    J[:, 3:] -= np.cross(R @ made.centre, J[:, :3])
    lengths = inverse_kinematics(hexapod, pose)
    f[d.D_INVERSE : d.D_INVERSE + 36] = (np.linalg.inv(J) / lengths).ravel()
    f[d.D_ARM : d.D_ARM + 3], f[d.D_AXES : d.D_AXES + 9] = R @ (arm - made.centre), axes.ravel()
    f[d.D_INVERSE_SIZE] = 1.0 / made.size
    f[d.D_ROTATION : d.D_ROTATION + 9] = R.ravel()
    f[d.D_CENTRE : d.D_CENTRE + 3], f[d.D_ORIGIN : d.D_ORIGIN + 3] = made.centre, origin
    return f
