"""Poses, the two rotation conventions, and the user, object and machine frames.

A pose is the platform seen in the base, ``T_base_platform``: a `pinocchio.SE3` or an array ``(..., 4, 4)``, metres.
Controllers speak six coordinates ``[x, y, z, rx, ry, rz]``, millimetres and degrees.  Two conventions are in use:

``fixed-xyz``
    ``R = Rz(rz) Ry(ry) Rx(rx)``: turns about the fixed axes x, then y, then z (SYMETRIE). The default.
``fixed-zyx``
    ``R = Rx(rx) Ry(ry) Rz(rz)``: turns about the fixed axes z, then y, then x (PI, Rubin Observatory).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any, Protocol, TypeAlias

import numpy as np
import numpy.typing as npt
import pinocchio as pin

from hexathermal.errors import ArgumentError, UnknownNameError

FloatArray: TypeAlias = npt.NDArray[np.float64]
PoseLike: TypeAlias = "pin.SE3 | npt.ArrayLike"

ROTATION_TOLERANCE = 1e-9
"""Largest sum of ``|R^T R - I|`` (upper triangle): an error below 1 nm at a joint 1 m from the origin."""

CONVENTIONS: Mapping[str, str] = MappingProxyType(
    {
        "fixed-xyz": "fixed-xyz",
        "moving-zyx": "fixed-xyz",
        "symetrie": "fixed-xyz",
        "fixed-zyx": "fixed-zyx",
        "moving-xyz": "fixed-zyx",
        "rotating-xyz": "fixed-zyx",
        "pi": "fixed-zyx",
        "rubin": "fixed-zyx",
    }
)
"""Accepted names -> the two conventions; turns about moving axes in reverse order are the same rotation."""


_set = object.__setattr__


class HasHome(Protocol):
    """Anything with a home pose ``(4, 4)`` in the base, such as a `Hexapod`."""

    @property
    def home(self) -> FloatArray:
        """Home pose (4, 4) [m]."""
        ...


def _convention(name: str) -> str:
    """Return ``fixed-xyz`` or ``fixed-zyx``."""
    key = name.lower().replace("_", "-") if isinstance(name, str) else ""
    if key not in CONVENTIONS:
        raise UnknownNameError(
            f"convention {name!r} is not known; choose 'fixed-xyz' (R = Rz Ry Rx, SYMETRIE) or "
            f"'fixed-zyx' (R = Rx Ry Rz, PI and Rubin); other accepted names: "
            f"{', '.join(sorted(name for name, meant in CONVENTIONS.items() if name != meant))}",
            tuple(CONVENTIONS),
        )
    return CONVENTIONS[key]


def as_array(value: Any, what: str) -> FloatArray:
    """Return `value` as an array of real numbers, or say why it is none."""
    try:
        array = np.asarray(value.filled(np.nan) if isinstance(value, np.ma.MaskedArray) else value)
        if array.dtype.kind not in "iuf":
            raise TypeError(f"its entries are {array.dtype}")
        return np.asarray(array, dtype=np.float64)
    except (TypeError, ValueError, OverflowError) as error:
        raise ArgumentError(f"{what} is not an array of real numbers: {error}") from None


def finite_array(value: Any, shape: tuple[int, ...], what: str) -> FloatArray:
    """Return `value` as a finite array whose last axes are `shape`, leading axes free."""
    array = as_array(value, what)
    n = len(shape)
    if array.ndim < n or array.shape[array.ndim - n :] != shape:
        wanted = "(..., " + ", ".join(map(str, shape)) + ")"
        raise ArgumentError(f"{what} has shape {array.shape}; expected {wanted}")
    if not np.isfinite(array).all():
        place = tuple(int(k) for k in np.argwhere(~np.isfinite(array))[0])
        raise ArgumentError(f"{what} holds {array[place]} at index {place}; every entry must be finite")
    return array


def pose_array(pose: PoseLike, what: str = "pose") -> FloatArray:
    """Return a pose as an array ``(..., 4, 4)`` after checking that every entry is a rigid motion.

    Raises
    ------
    ArgumentError
        Wrong shape, not finite, last row other than ``[0, 0, 0, 1]``, or ``|R^T R - I| > 1e-9``, or a mirror.
    """
    if isinstance(pose, pin.SE3):
        pose = pose.homogeneous
    array = finite_array(pose, (4, 4), what)
    R = array[..., :3, :3]
    bottom = np.abs(array[..., 3, :] - [0.0, 0.0, 0.0, 1.0]).sum(axis=-1)
    if (bottom > ROTATION_TOLERANCE).any():
        raise ArgumentError(
            f"{what}: the last row must be [0, 0, 0, 1], found "
            f"{array[np.unravel_index(bottom.argmax(), bottom.shape)][3]}; is the matrix transposed?"
        )
    error = np.abs(np.triu(np.swapaxes(R, -1, -2) @ R - np.eye(3))).sum(axis=(-1, -2)) + bottom
    if (error > ROTATION_TOLERANCE).any():
        raise ArgumentError(
            f"{what}: the rotation is not orthonormal: |R^T R - I| = {error.max():.3g} > {ROTATION_TOLERANCE:g}; "
            "build it with pose_from_coordinates, or make it orthonormal first (scipy Rotation.from_matrix)"
        )
    if (np.linalg.det(R) < 0.0).any():
        raise ArgumentError(f"{what}: the rotation is a mirror (its determinant is -1)")
    return array


def _home(hexapod: HasHome | None) -> FloatArray | None:
    """Return the machine's home pose, or None."""
    if hexapod is None:
        return None
    if not hasattr(hexapod, "home"):
        raise ArgumentError(f"hexapod must be a Hexapod, not {hexapod!r}; load one with load_hexapod(name)")
    return hexapod.home


def pose_from_coordinates(
    coordinates: npt.ArrayLike, convention: str = "fixed-xyz", hexapod: HasHome | None = None
) -> FloatArray:
    """Return the pose that a controller's six coordinates mean.

    ``T = [R | (x, y, z)]``, and ``T_base_platform = T_base_home T`` where a machine is given.

    Parameters
    ----------
    coordinates : array, shape (..., 6) [mm, mm, mm, deg, deg, deg]
        ``x, y, z, rx, ry, rz``.
    convention : str
        ``"fixed-xyz"``: ``R = Rz Ry Rx`` (default, SYMETRIE); ``"fixed-zyx"``: ``R = Rx Ry Rz`` (PI, Rubin).
    hexapod : Hexapod, optional
        Coordinates then count from this machine's home; without it from the base frame's origin.

    Returns
    -------
    array, shape (..., 4, 4) [m]

    Examples
    --------
    >>> pose_from_coordinates([5, 0, 12, 0, 0, 90]).round(3).tolist()[0]
    [0.0, -1.0, 0.0, 0.005]
    """
    name = _convention(convention)
    six = finite_array(coordinates, (6,), "coordinates")
    # Rx Ry Rz = (Rz(-rz) Ry(-ry) Rx(-rx))^T: one product serves both conventions
    sign = 1.0 if name == "fixed-xyz" else -1.0
    a, b, c = (np.radians(sign * six[..., k]) for k in (3, 4, 5))
    (ca, sa), (cb, sb), (cc, sc) = ((np.cos(angle), np.sin(angle)) for angle in (a, b, c))
    pose = np.zeros((*six.shape[:-1], 4, 4))
    R = pose[..., :3, :3] if name == "fixed-xyz" else np.swapaxes(pose[..., :3, :3], -1, -2)
    R[..., 0, 0], R[..., 0, 1], R[..., 0, 2] = cc * cb, cc * sb * sa - sc * ca, cc * sb * ca + sc * sa
    R[..., 1, 0], R[..., 1, 1], R[..., 1, 2] = sc * cb, sc * sb * sa + cc * ca, sc * sb * ca - cc * sa
    R[..., 2, 0], R[..., 2, 1], R[..., 2, 2] = -sb, cb * sa, cb * ca
    pose[..., :3, 3] = six[..., :3] / 1000.0
    pose[..., 3, 3] = 1.0
    home = _home(hexapod)
    return pose if home is None else home @ pose


def coordinates_from_pose(pose: PoseLike, convention: str = "fixed-xyz", hexapod: HasHome | None = None) -> FloatArray:
    """Return a controller's six coordinates of a pose: the inverse of `pose_from_coordinates`.

    ``ry`` lies in [-90, 90] degrees.  At ``ry = +-90`` (gimbal lock) only a combination of ``rx`` and ``rz`` is
    defined; ``rz`` is set to 0, and the same rotation comes back.

    Parameters
    ----------
    pose : SE3 or array, shape (..., 4, 4) [m]
    convention, hexapod
        As in `pose_from_coordinates`.

    Returns
    -------
    array, shape (..., 6) [mm, mm, mm, deg, deg, deg]

    Examples
    --------
    >>> coordinates_from_pose(pose_from_coordinates([5, 0, 12, 0, 1.5, 0])).round(9).tolist()
    [5.0, 0.0, 12.0, 0.0, 1.5, 0.0]
    """
    name = _convention(convention)
    array = pose_array(pose)
    home = _home(hexapod)
    if home is not None:
        array = inverse_pose(home) @ array
    R = array[..., :3, :3]
    # Both conventions read the same numbers once 'fixed-zyx' is transposed: R^T = Rz(-rz) Ry(-ry) Rx(-rx).
    M, sign = (R, 1.0) if name == "fixed-xyz" else (np.swapaxes(R, -1, -2), -1.0)
    across = np.hypot(M[..., 0, 0], M[..., 1, 0])
    ry = np.arctan2(-M[..., 2, 0], across)
    rz = np.arctan2(M[..., 1, 0], M[..., 0, 0])
    # With rz known, rx follows from a rotation that is exact also in gimbal lock, where rz is set to 0 (to 1e-15).
    rz = np.where(across < 1e-15, 0.0, rz)
    c, s = np.cos(rz), np.sin(rz)
    rx = np.arctan2(s * M[..., 0, 2] - c * M[..., 1, 2], c * M[..., 1, 1] - s * M[..., 0, 1])
    angles = np.degrees(np.stack([rx, ry, rz], axis=-1)) * sign
    return np.concatenate([array[..., :3, 3] * 1000.0, angles + 0.0], axis=-1)


def inverse_pose(T: FloatArray) -> FloatArray:
    """Return the inverse of rigid motions, shape (..., 4, 4)."""
    inverse = np.zeros_like(T)
    R_back = np.swapaxes(T[..., :3, :3], -1, -2)
    inverse[..., :3, :3] = R_back
    inverse[..., :3, 3] = -np.einsum("...ij,...j->...i", R_back, T[..., :3, 3])
    inverse[..., 3, 3] = 1.0
    return inverse


@dataclass(frozen=True, init=False)
class Frames:
    """The user's and the object's frame, as SYMETRIE's controllers define them.

    The user frame ``U`` is given in the machine frame, the object frame ``O`` in the platform frame.  A machine pose
    ``M`` (platform in machine frame) and a user pose (object in user frame) are related by
    ``user_pose = inv(U) M O`` and ``machine_pose = U user_pose inv(O)``.

    Parameters
    ----------
    user, object : array, shape (6,) [mm, mm, mm, deg, deg, deg]
        Six coordinates of the frame, default all zero.
    convention : str
        Rotation convention of both, see `pose_from_coordinates`.

    Examples
    --------
    >>> tool = Frames(object=[0, 0, 100, 0, 0, 0])          # the point of interest is 100 mm above the platform
    >>> tool.user_pose(np.eye(4))[2, 3].item()
    0.1
    """

    user: tuple[float, ...] = (0.0,) * 6
    object: tuple[float, ...] = (0.0,) * 6
    convention: str = "fixed-xyz"
    _T_machine_user: FloatArray = field(init=False, repr=False, compare=False)
    _T_platform_object: FloatArray = field(init=False, repr=False, compare=False)

    def __init__(
        self,
        user: npt.ArrayLike = (0.0,) * 6,
        object: npt.ArrayLike = (0.0,) * 6,
        convention: str = "fixed-xyz",
    ) -> None:
        for name, given in (("user", user), ("object", object)):
            six = finite_array(given, (6,), f"{name} frame")
            if six.shape != (6,):
                raise ArgumentError(f"{name} frame has shape {six.shape}; expected six coordinates (6,)")
            _set(self, name, tuple(float(value) for value in six))
        _set(self, "convention", convention)
        for name, coordinates in (("_T_machine_user", self.user), ("_T_platform_object", self.object)):
            pose = pose_from_coordinates(coordinates, convention)
            pose.setflags(write=False)
            _set(self, name, pose)

    def user_pose(self, machine_pose: PoseLike) -> Any:
        """Return ``inv(U) M O``: the object seen in the user frame. An SE3 gives an SE3."""
        moved = inverse_pose(self._T_machine_user) @ pose_array(machine_pose) @ self._T_platform_object
        return like(machine_pose, moved)

    def machine_pose(self, user_pose: PoseLike) -> Any:
        """Return ``U X inv(O)``: the platform in the machine frame. An SE3 gives an SE3."""
        moved = self._T_machine_user @ pose_array(user_pose) @ inverse_pose(self._T_platform_object)
        return like(user_pose, moved)


def like(given: Any, pose: FloatArray) -> Any:
    """Return `pose` as an SE3 where the caller gave an SE3, else as the array it is."""
    return pin.SE3(pose) if isinstance(given, pin.SE3) and pose.shape == (4, 4) else pose
