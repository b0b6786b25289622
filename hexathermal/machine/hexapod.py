"""The machine: joints, home, retracted length, stroke, limits and thermal laws; the object that users hold."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt
import pinocchio as pin

from hexathermal.errors import ArgumentError
from hexathermal.machine.bodies import Bodies, PoseLimits
from hexathermal.machine.compliance import Compliance, same_value
from hexathermal.machine.measuring_frame import MeasuringFrame
from hexathermal.machine.shown import Shown
from hexathermal.machine.thermal import TemperaturesLike, ThermalModel, frozen, refreeze
from hexathermal.machine.thermometers import AS_RECORDED
from hexathermal.poses import FloatArray, Frames, PoseLike, as_array, finite_array, pose_array

GRADES = ("A", "B", "C")

FARTHEST_JOINT = 1e9
"""Largest joint coordinate [m]: squares of lengths stay far from what a double can hold."""


def _six(value: npt.ArrayLike | None, what: str) -> FloatArray | None:
    """Return one value for each leg, from one for all or six; None stays None."""
    if value is None:
        return None
    array = as_array(value, what)
    if array.shape not in ((), (1,), (6,)):
        raise ArgumentError(f"{what} has shape {array.shape}; expected one value for all legs, or six")
    return frozen(np.broadcast_to(finite_array(array, (), what), (6,)))


def _joints(value: npt.ArrayLike, what: str) -> FloatArray:
    """Return six joint positions."""
    array = finite_array(value, (6, 3), what)
    if array.shape != (6, 3):
        raise ArgumentError(f"{what} has shape {array.shape}; expected (6, 3), one row for each leg")
    if np.abs(array).max() > FARTHEST_JOINT:
        raise ArgumentError(
            f"{what} holds {array.flat[np.abs(array).argmax()]:.6g} m, beyond {FARTHEST_JOINT:g}; metres are meant"
        )
    return frozen(array)


def _cone(value: npt.ArrayLike | None, what: str) -> FloatArray | None:
    """Return six cone half-angles; None stays None."""
    cone = _six(value, what)
    if cone is not None and not ((cone > 0.0) & (cone <= np.pi)).all():
        raise ArgumentError(f"{what} must lie in (0, pi] rad, found {cone.tolist()}; were degrees meant?")
    return cone


@dataclass(frozen=True, eq=False, repr=False, init=False)
class Hexapod(Shown):
    """A Gough-Stewart hexapod, cold and warm; immutable, its arrays are read-only.

    Leg ``i`` runs from base joint ``b_i`` to platform joint ``p_i``; its inter-articular length at the pose
    ``T_base_platform = (R, t)`` is ``L_i = |t + R p_i - b_i| = q0_i + q_i`` (paper, eq. 2).

    Parameters
    ----------
    base_joints : array, shape (6, 3) [m]
        Joint centres in the base frame.
    platform_joints : array, shape (6, 3) [m]
        Joint centres in the platform frame.
    retracted_length : float or array, shape (6,) [m], optional
        ``q0``, the inter-articular length at ``q = 0``.
    stroke : array, shape (2,) or (6, 2) [m], optional
        ``[low, high]`` of ``q``. Without it no length is out of stroke.
    home : array, shape (3,) or (4, 4), or SE3 [m], optional
        Platform in base at home; (3,) is a pure translation. Default: see `default_home`. A turned home
        cannot be written to `hexapod.toml`, which holds a position only.
    thermal : ThermalModel, optional
        Without it thermal compensation is not active, and methods that need it say so.
    base_cone, platform_cone : float or array, shape (6,) [rad], optional
        Largest angle between a leg and its direction at home, seen from the base and from the platform.
    name, source, grade : str
        Grade "A" identified, "B" measured, "C" drawing or published values.
    bodies, limits : Bodies, PoseLimits, optional
        For collisions, loads and drawings; travel allowed by the maker.
    compliance : Compliance, optional
        Sag of the legs under a payload; joins corrected lengths and predicted poses.
    measuring_frame : MeasuringFrame, optional
        Drift of what measures poses; no part of the machine, commands do not know it.

    Raises
    ------
    ArgumentError
        Wrong shape, not finite, a joint of the base that coincides with its platform joint, a stroke that is no
        interval or lets a leg vanish, or home outside the stroke.

    Notes
    -----
    Ask it `inverse_kinematics(pose)`, `forward_kinematics(lengths)`, `solve_forward(lengths)`, `jacobian(pose)`,
    `assembly_modes(lengths)`, `strokes(lengths)`, `corrected_leg_lengths(pose, temps)`, `corrected_pose(pose, temps)`,
    `predicted_pose(lengths, temps)`, `leg_drift(lengths, temps)`, `leg_controllers()` and `error_budget(pose, temps)`;
    their documentation calls the machine `hexapod`.

    Examples
    --------
    >>> import hexathermal as ht
    >>> hexapod = ht.load_hexapod("reference")
    >>> pose = ht.pose_from_coordinates([5, 0, 12, 0, 1.5, 0])
    >>> lengths = hexapod.inverse_kinematics(pose)
    >>> bool(abs(hexapod.forward_kinematics(lengths) - pose).max() < 1e-12)
    True
    """

    base_joints: FloatArray
    platform_joints: FloatArray
    retracted_length: FloatArray | None = None
    stroke: FloatArray | None = None
    home: FloatArray = field(default_factory=lambda: np.eye(4))
    thermal: ThermalModel | None = None
    base_cone: FloatArray | None = None
    platform_cone: FloatArray | None = None
    name: str = ""
    source: str = ""
    grade: str = "C"
    bodies: Bodies | None = None
    limits: PoseLimits | None = None
    compliance: Compliance | None = None
    measuring_frame: MeasuringFrame | None = None
    _prepared: dict[str, Any] = field(default_factory=dict, init=False, repr=False, compare=False)

    def __init__(
        self,
        base_joints: npt.ArrayLike,
        platform_joints: npt.ArrayLike,
        retracted_length: npt.ArrayLike | None = None,
        stroke: npt.ArrayLike | None = None,
        home: PoseLike | None = None,
        thermal: ThermalModel | None = None,
        base_cone: npt.ArrayLike | None = None,
        platform_cone: npt.ArrayLike | None = None,
        name: str = "",
        source: str = "",
        grade: str = "C",
        bodies: Bodies | None = None,
        limits: PoseLimits | None = None,
        compliance: Compliance | None = None,
        measuring_frame: MeasuringFrame | None = None,
    ) -> None:
        set_ = object.__setattr__
        set_(self, "_prepared", {})
        set_(self, "base_joints", _joints(base_joints, "base_joints"))
        set_(self, "platform_joints", _joints(platform_joints, "platform_joints"))
        set_(self, "retracted_length", _six(retracted_length, "retracted_length"))
        set_(self, "stroke", self._checked_stroke(stroke))
        set_(self, "home", frozen(self._checked_home(home)))
        set_(self, "base_cone", _cone(base_cone, "base_cone"))
        set_(self, "platform_cone", _cone(platform_cone, "platform_cone"))
        for what, text in (("name", name), ("source", source), ("grade", grade)):
            set_(self, what, str(text))
        for what, part, kind in (
            ("thermal", thermal, ThermalModel),
            ("bodies", bodies, Bodies),
            ("limits", limits, PoseLimits),
            ("compliance", compliance, Compliance),
            ("measuring_frame", measuring_frame, MeasuringFrame),
        ):
            if part is not None and not isinstance(part, kind):
                raise ArgumentError(f"{what} must be a {kind.__name__}, found {type(part).__name__}")
            set_(self, what, part)
        self._check_whole()

    def _check_whole(self) -> None:
        """Check what concerns several fields."""
        if self.thermal is not None and self.retracted_length is None:
            raise ArgumentError("a thermal law needs retracted_length: its drift is A q0 dT + B q dT")
        if self.grade not in GRADES:
            raise ArgumentError(f"grade {self.grade!r} is not known; choose 'A' identified, 'B' measured, 'C' drawing")
        lengths = self.home_lengths
        if lengths.max() > 4.0 * FARTHEST_JOINT:
            raise ArgumentError(f"legs would be {lengths.max():.6g} m long at home; coordinates are metres")
        if not (lengths > 0.0).all():
            leg = int(lengths.argmin()) + 1
            raise ArgumentError(
                f"leg {leg} has length 0 at home: its base and platform joint coincide; give another home"
            )
        shortest, longest = self.length_limits
        slack = self.length_slack
        if ((lengths < shortest - slack) | (lengths > longest + slack)).any():
            leg = int(np.maximum(shortest - lengths, lengths - longest).argmax())
            raise ArgumentError(
                f"home is out of stroke: leg {leg + 1} is {lengths[leg]:.6g} m long there, "
                f"allowed [{shortest[leg]:.6g}, {longest[leg]:.6g}] m; check home, q0 and stroke, and their units"
            )

    def _checked_stroke(self, given: npt.ArrayLike | None) -> FloatArray | None:
        """Return the strokes (6, 2), checked together with `retracted_length`."""
        if self.retracted_length is not None and not (self.retracted_length > 0.0).all():
            raise ArgumentError(f"retracted_length must be above 0 m, found {self.retracted_length.tolist()}")
        if given is None:
            return None
        if self.retracted_length is None:
            raise ArgumentError("stroke needs retracted_length: a leg is q0 + q long")
        array = finite_array(given, (2,), "stroke")
        if array.shape not in ((2,), (6, 2)):
            raise ArgumentError(f"stroke has shape {array.shape}; expected [low, high] for all legs, or (6, 2)")
        stroke = np.broadcast_to(array, (6, 2))
        if not (stroke[:, 0] < stroke[:, 1]).all():
            raise ArgumentError(f"stroke must be [low, high] with low < high, found {array.tolist()}")
        if not (self.retracted_length + stroke[:, 0] > 0.0).all():
            raise ArgumentError("stroke lets a leg shrink to nothing: q0 + low must be above 0 m")
        return frozen(stroke)

    def _checked_home(self, home: PoseLike | None) -> FloatArray:
        """Return home as a 4 x 4 array."""
        if home is None:
            return default_home(self)
        if not isinstance(home, pin.SE3) and as_array(home, "home").shape == (3,):
            pose = np.eye(4)
            pose[:3, 3] = finite_array(home, (3,), "home")
            return pose
        pose = pose_array(home, "home")
        if pose.shape != (4, 4):
            raise ArgumentError(f"home has shape {pose.shape}; expected (3,), (4, 4) or an SE3")
        return pose

    @property
    def length_slack(self) -> float:
        """How far beyond a limit a length may lie [m]: what rounding of the coordinates costs, a few 1e-15 m."""
        joints = np.abs(self.base_joints).max() + np.abs(self.platform_joints).max() + np.abs(self.home[:3, 3]).max()
        return float(4.0 * np.finfo(float).eps * (joints + self.home_lengths.max()))

    @property
    def home_lengths(self) -> FloatArray:
        """Inter-articular lengths at home, shape (6,) [m]."""
        moved = self.platform_joints @ self.home[:3, :3].T + self.home[:3, 3]
        with np.errstate(over="ignore"):
            return np.asarray(np.linalg.norm(moved - self.base_joints, axis=1))

    @property
    def length_limits(self) -> tuple[FloatArray, FloatArray]:
        """Shortest and longest inter-articular length of each leg [m]; 0 and infinity without a stroke."""
        if self.stroke is None or self.retracted_length is None:
            return np.zeros(6), np.full(6, np.inf)
        return self.retracted_length + self.stroke[:, 0], self.retracted_length + self.stroke[:, 1]

    @property
    def sensor_names(self) -> tuple[str, ...]:
        """Names of the thermometers, in the order of `temps`; empty without a thermal law."""
        return () if self.thermal is None else self.thermal.sensor_names

    def strokes(self, lengths: npt.ArrayLike) -> FloatArray:
        """Return the rod displacements ``q = L - q0`` [m], shape (..., 6) (paper, eq. 2)."""
        if self.retracted_length is None:
            raise ArgumentError(f"machine {self.name!r} has no retracted_length: strokes are not defined")
        return finite_array(lengths, (6,), "lengths") - self.retracted_length

    # Kinematics and predictions are functions of upper storeys, put in place by `ports.install` on import.
    if TYPE_CHECKING:

        def inverse_kinematics(self, pose: PoseLike) -> FloatArray:
            """Return the inter-articular lengths at a pose."""

        def forward_kinematics(self, lengths: npt.ArrayLike, guess: PoseLike | None = None) -> Any:
            """Return the pose at given lengths, or raise."""

        def solve_forward(self, lengths: npt.ArrayLike, guess: PoseLike | None = None) -> Any:
            """Return a `ForwardResult` with a status for each pose."""

        def jacobian(self, pose: PoseLike) -> FloatArray:
            """Return ``dL/dx``, rows ``[u, (R p) x u]``."""

        def assembly_modes(self, lengths: npt.ArrayLike) -> FloatArray:
            """Return all real postures."""

        def corrected_leg_lengths(self, pose: PoseLike, temps: TemperaturesLike) -> FloatArray:
            """Return the lengths to command."""

        def corrected_pose(self, pose: PoseLike, temps: TemperaturesLike) -> Any:
            """Return the pose to command."""

        def predicted_pose(self, lengths: npt.ArrayLike, temps: TemperaturesLike) -> FloatArray:
            """Return where the platform really stands."""

        def leg_controllers(self) -> Any:
            """Return what corrects row after row, where the legs' laws have states."""

        def leg_drift(self, lengths: npt.ArrayLike, temps: TemperaturesLike) -> FloatArray:
            """Return the drift of each leg [m]."""

        def error_budget(
            self, pose: PoseLike, temps: TemperaturesLike, sources: Iterable[Any] | None = None, *,
            correction: bool = True, frame: str = "machine", frames: Frames | None = None,
            at_tool: npt.ArrayLike | None = None, plates: Any = None, air_degC: float | None = None,
        ) -> Any:  # fmt: skip
            """Return the `Budget` of a pose: bias, 6-D covariance, sorted contributions."""

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Hexapod):
            return NotImplemented
        return all(same_value(getattr(self, name), getattr(other, name)) for name in _FIELDS)

    def __hash__(self) -> int:
        return hash((self.name, self.base_joints.tobytes(), self.platform_joints.tobytes(), self.home.tobytes()))

    def __getstate__(self) -> dict[str, Any]:
        return {name: getattr(self, name) for name in _FIELDS}

    def __setstate__(self, state: dict[str, Any]) -> None:
        refreeze(self, state)
        object.__setattr__(self, "_prepared", {})

    def __repr__(self) -> str:
        lines = [f"Hexapod {self.name or '(no name)'} · grade {self.grade}"]
        lengths = self.home_lengths
        if self.stroke is not None and self.retracted_length is not None:
            lines.append(f"  q0      {_range(self.retracted_length)} mm, stroke {_range(self.stroke)} mm")
        lines.append(f"  home    legs {_range(lengths)} mm, platform origin at {_point(self.home[:3, 3])} mm")
        lines.append(f"  joints  base radius {_range(_radii(self.base_joints))} mm, ")
        lines[-1] += f"platform radius {_range(_radii(self.platform_joints))} mm about their centres"
        lines.append(f"  thermal {self._thermal_line()}")
        if self.compliance is not None:
            soft, centre = self.compliance, _point(self.compliance.payload_centre)
            given = ", ".join(dict.fromkeys(f"{value * 1e6:.4g}" for value in soft.leg_compliance))
            lines.append(f"  payload {soft.payload_mass:.6g} kg at {centre} mm, legs give way by {given} um/N")
        if self.measuring_frame is not None:
            lines.append(f"  poses   measured in a frame that follows {self.measuring_frame.sensor}")
        return "\n".join(lines)

    def _thermal_line(self) -> str:
        """Return one line that says which compensation is active."""
        if self.thermal is None:
            return "compensation not active (no thermal law)"
        law, names = self.thermal.legs[0], self.thermal.sensor_names
        text = "one law for all legs" if self.thermal.common_law else "a law for each leg"
        text += f", A = {_list(law.A * 1e6)}, B = {_list(law.B * 1e6)} um/m/K" if self.thermal.common_law else ""
        for part, plate in (("platform", self.thermal.platform), ("base", self.thermal.base)):
            text += f"; {part} compensated" if plate is not None and plate.sensor else f"; {part} not compensated"
        told = self.thermal.thermometers_of_leg
        if told != AS_RECORDED:
            text += f"; legs 1 to 6 told by the thermometers recorded of legs {', '.join(map(str, told))}"
        return f"{text}; sensors {', '.join(names)}"


_FIELDS = tuple(name for name in Hexapod.__dataclass_fields__ if name != "_prepared")


def default_home(hexapod: Hexapod) -> FloatArray:
    """Return the home of a machine that states none: no rotation, centres of the joints above each other.

    The platform is lifted along the base's z until the mean leg is mid-stroke; without a stroke by twice the larger
    mean joint radius. Where the joints are given in one frame (their centroids stand apart in z, and no leg vanishes
    there), home is the identity.
    """
    pose = np.eye(4)
    base, platform = hexapod.base_joints.mean(axis=0), hexapod.platform_joints.mean(axis=0)
    radius = max(_radii(hexapod.base_joints).mean(), _radii(hexapod.platform_joints).mean())
    if hexapod.stroke is None or hexapod.retracted_length is None:
        as_given = np.linalg.norm(hexapod.platform_joints - hexapod.base_joints, axis=1)
        if abs(platform[2] - base[2]) > 0.1 * radius and as_given.min() > 0.1 * radius:
            return pose
        height = 2.0 * radius
    else:
        wanted = float((hexapod.retracted_length + hexapod.stroke.mean(axis=1)).mean())
        flat = (hexapod.platform_joints - platform) - (hexapod.base_joints - base)
        height = _lift(flat, wanted)
    pose[:3, 3] = base - platform
    pose[2, 3] += height
    return pose


def _lift(flat: FloatArray, wanted: float) -> float:
    """Return the z by which joints must be lifted so that the mean leg is `wanted` long."""
    low, high = 0.0, 2.0 * wanted + float(np.abs(flat).max())
    for _ in range(200):
        middle = 0.5 * (low + high)
        short = np.linalg.norm(flat + [0.0, 0.0, middle], axis=1).mean() < wanted
        low, high = (middle, high) if short else (low, middle)
    return 0.5 * (low + high)


def _radii(joints: FloatArray) -> FloatArray:
    return np.asarray(np.linalg.norm(joints - joints.mean(axis=0), axis=1))


def _range(values: FloatArray) -> str:
    low, high = float(values.min()) * 1e3, float(values.max()) * 1e3
    return f"{low:.6g}" if high - low < 1e-6 else f"{low:.6g} .. {high:.6g}"


def _point(values: FloatArray) -> str:
    return "(" + ", ".join(f"{value * 1e3:.6g}" for value in values) + ")"


def _list(values: FloatArray) -> str:
    return ", ".join(f"{value:.4g}" for value in values)
