"""The volume that the platform can reach at a given orientation, between rigorous bounds."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from hexathermal.errors import ArgumentError, SingularPoseError
from hexathermal.kinematics.cells import DEEPEST, Bools, Cells, connected, cut_bounds, neighbours, root
from hexathermal.kinematics.constants import LARGEST_CONDITION
from hexathermal.kinematics.limit_functions import LimitFunctions, limit_functions
from hexathermal.kinematics.limits import (
    ROUNDING,
    rates,
    reshaped,
    standing,
    travel_coordinates,
    travel_range,
)
from hexathermal.kinematics.path import check_path
from hexathermal.kinematics.singular_surface import SingularSurface, nodes, singular_surface
from hexathermal.machine.hexapod import Hexapod
from hexathermal.poses import ROTATION_TOLERANCE, FloatArray, finite_array

MOST_CELLS = 1_000_000
"""Boxes at which refinement ends although the wanted resolution is not reached; the bounds tell."""

FIRST_LEVELS = 3
"""The root box is halved so often before anything is asked."""


@dataclass(frozen=True, eq=False)
class Volume:
    """A reachable volume and how well it is known; arrays for a batch of orientations.

    Attributes
    ----------
    value : float or array, shape (...) [m^3]
        Middle of the bounds.
    uncertainty : float or array, shape (...) [m^3]
        Standard uncertainty of a value that may lie anywhere between the bounds: ``(upper - lower) / (2 sqrt(3))``.
    bounds : array, shape (..., 2) [m^3]
        Lower and upper.
    reached : bool or array, shape (...)
        Whether home lies in the volume, or a straight move from home into it is certified by `check_path`.
    """

    value: Any
    uncertainty: Any
    bounds: FloatArray
    reached: Any


@dataclass(frozen=True, eq=False)
class _Slice:
    """All positions at one orientation: positions ``x`` [m] count from home along home's axes, in a root box."""

    hexapod: Hexapod
    rotation: FloatArray
    functions: LimitFunctions
    directions: FloatArray
    surface: SingularSurface
    low: FloatArray
    size: FloatArray

    def poses(self, x: FloatArray) -> FloatArray:
        """Return poses (N, 4, 4) at positions (N, 3)."""
        return poses_from_home(self.hexapod, x, self.rotation)


def poses_from_home(hexapod: Hexapod, x: FloatArray, rotation: FloatArray) -> FloatArray:
    """Return ``T_base_home [rotation | x]`` for positions (..., 3) [m] and rotations (..., 3, 3) that broadcast."""
    lead = np.broadcast_shapes(x.shape[:-1], rotation.shape[:-2])
    poses = np.zeros((*lead, 4, 4))
    poses[..., :3, :3], poses[..., :3, 3], poses[..., 3, 3] = rotation, x, 1.0
    return np.asarray(hexapod.home @ poses)


def rotation_array(rotation: npt.ArrayLike | None) -> FloatArray:
    """Return turns from home (..., 3, 3), checked; None is no turn."""
    R = finite_array(np.eye(3) if rotation is None else rotation, (3, 3), "rotation")
    error = np.abs(np.swapaxes(R, -1, -2) @ R - np.eye(3)).max(initial=0.0)
    if error > ROTATION_TOLERANCE or (np.linalg.det(R) < 0.0).any():
        raise ArgumentError(
            f"rotation is no rotation matrix: |R^T R - I| = {error:.3g}, allowed {ROTATION_TOLERANCE:g}, and its "
            "determinant must be 1; take it from a pose: pose_from_coordinates([0, 0, 0, rx, ry, rz])[:3, :3]"
        )
    return R


def reachable_volume(
    hexapod: Hexapod,
    rotation: npt.ArrayLike | None = None,
    *,
    resolution: float = 0.01,
) -> Volume:
    """Return the volume of the platform's positions that can be reached without turning, with rigorous bounds.

    Counted are positions within stroke, joint cones and the maker's travel, on home's side of all singular poses
    (sign of ``det J``), and connected with home; at another orientation, with the reachable position nearest to home's
    (`Volume.reached` tells whether a straight move gets there).  Boxes of positions are halved until the bounds are
    close enough: in a box of half diagonal ``h`` about ``x`` a length differs from its tangent ``L + u . dx`` by no
    more than ``h^2 / (2 (L - h))``, so that planes bound every limit from both sides and the part of the box between
    them is known (`cut_bounds`).  The singular poses, a cubic surface of the position, are cut off likewise
    (`SingularSurface`).

    Connected means through boxes that share a face, for the lower bound through boxes known to hold reachable
    positions; a neck or gap finer than the boxes is not seen.  Legs that touch are not asked, see `margins`.

    Parameters
    ----------
    hexapod : Hexapod
    rotation : array, shape (..., 3, 3), optional
        Turn from home, ``R_base_platform = R_base_home rotation``; default none.
    resolution : float
        Refinement ends when half the distance of the bounds is below this part of the value, or at a million boxes.

    Returns
    -------
    Volume

    Raises
    ------
    ArgumentError
        The machine has no stroke; no rotation; resolution not in (0, 1).
    SingularPoseError
        Home is singular: no side of it is home's.

    Examples
    --------
    >>> import hexathermal as ht
    >>> volume = reachable_volume(ht.load_hexapod("reference"))
    >>> volume.uncertainty < 0.01 * volume.value
    True
    """
    _check(hexapod, resolution)
    turns = rotation_array(rotation)
    found = [_volume(hexapod, turn, resolution) for turn in turns.reshape(-1, 3, 3)]
    lead = turns.shape[:-2]
    bounds = np.array([row[:2] for row in found]).reshape(-1, 2)
    columns = {
        "value": bounds.mean(axis=1),
        "uncertainty": (bounds[:, 1] - bounds[:, 0]) / (2.0 * np.sqrt(3.0)),
        "reached": np.array([row[2] for row in found], dtype=np.bool_),
    }
    named = {name: reshaped(column, lead, name) for name, column in columns.items()}
    return Volume(bounds=bounds.reshape((*lead, 2)), **named)


def _check(hexapod: Hexapod, resolution: float) -> None:
    """Refuse what has no volume."""
    if hexapod.stroke is None:
        raise ArgumentError(
            f"machine {hexapod.name!r} has no stroke: its workspace has no bounds. Give retracted_length and stroke"
        )
    if not (isinstance(resolution, float) and 0.0 < resolution < 1.0):
        raise ArgumentError(f"resolution must lie in (0, 1), found {resolution!r}; 0.01 asks for 1 %")
    if standing(hexapod, np.array(hexapod.home)[None]).side[0] == 0:
        raise SingularPoseError(
            f"home of machine {hexapod.name!r} is singular (condition number above {LARGEST_CONDITION:g}): no side of "
            "it is home's; give another home",
            value=float(np.inf), upper=LARGEST_CONDITION,
        )  # fmt: skip


def _volume(hexapod: Hexapod, rotation: FloatArray, resolution: float) -> tuple[float, float, bool]:
    """Return lower and upper bound at one orientation, and whether it is reached from home."""
    space = _space(hexapod, rotation)
    if space is None:
        return 0.0, 0.0, False
    cells = root()
    for _ in range(FIRST_LEVELS):
        cells = cells.halved()
    cells = _asked(space, cells)
    while True:
        cells = _refined(space, cells, resolution)
        if not (cells.least > 0.0).any():
            return 0.0, _content(space, cells, cells.most), False
        centre, half = cells.boxes(space.low, space.size)
        away = np.linalg.norm(np.maximum(np.abs(centre) - half, 0.0), axis=1)
        seed = int(np.lexsort((-cells.least, away + np.where(cells.least > 0.0, 0.0, np.inf)))[0])
        pairs = neighbours(cells)
        surely = connected(cells, pairs, cells.least > 0.0, seed)
        maybe = connected(cells, pairs, cells.most > 0.0, seed)
        lower = _content(space, cells, np.where(surely, cells.least, 0.0))
        upper = _content(space, cells, np.where(maybe, cells.most, 0.0))
        if upper - lower <= resolution * (upper + lower) or maybe.all():
            return lower, upper, _reached(space, cells[surely])
        cells = cells[maybe]


def _space(hexapod: Hexapod, rotation: FloatArray) -> _Slice | None:
    """Return the positions at one orientation, in a box that surely holds them; None where there are none."""
    home, longest = hexapod.home, hexapod.length_limits[1][:, None]
    # where a leg would have length 0; every position is within the longest leg of it
    centres = hexapod.base_joints - hexapod.platform_joints @ (home[:3, :3] @ rotation).T - home[:3, 3]
    low, high = (centres @ home[:3, :3] - longest).max(axis=0), (centres @ home[:3, :3] + longest).min(axis=0)
    travel = travel_range(hexapod)
    if travel is not None:
        turned = travel_coordinates(hexapod, poses_from_home(hexapod, np.zeros(3), rotation))[3:]
        if ((turned < travel[3:, 0] - ROUNDING) | (turned > travel[3:, 1] + ROUNDING)).any():
            return None
        low, high = np.maximum(low, travel[:3, 0]), np.minimum(high, travel[:3, 1])
    if not (low < high).all():
        return None
    functions = limit_functions(hexapod)
    directions = functions.directions(home[:3, :3] @ rotation)
    points = low + (high - low) * nodes()
    surface = singular_surface(hexapod, points, poses_from_home(hexapod, points, rotation), low, high - low)
    return _Slice(hexapod, rotation, functions, directions, surface, low, high - low)


def _content(space: _Slice, cells: Cells, part: FloatArray) -> float:
    """Return the volume of parts of boxes [m^3]."""
    return float((part / 8.0**cells.level).sum() * space.size.prod())


def _refined(space: _Slice, cells: Cells, resolution: float) -> Cells:
    """Halve the boxes that leave most open until the bounds of their sum are close enough."""
    while True:
        lower, upper = _content(space, cells, cells.least), _content(space, cells, cells.most)
        most = (MOST_CELLS - len(cells)) // 7
        if upper - lower <= resolution * (upper + lower) or most <= 0:
            return cells
        open_ = (cells.most - cells.least) / 8.0**cells.level * space.size.prod()
        order = np.argsort(open_)
        # the boxes that together leave little open stay as they are
        stays = np.cumsum(open_[order]) <= 0.25 * resolution * (upper + lower)
        splits = np.zeros(len(cells), dtype=np.bool_)
        splits[order[~stays][-most:]] = True
        splits &= cells.level < DEEPEST
        if not splits.any():
            return cells
        cells = cells[~splits].joined(_asked(space, cells[splits].halved()))


def _asked(space: _Slice, cells: Cells) -> Cells:
    """Return the boxes that may hold reachable positions, with the bounds of their part."""
    x, half = cells.boxes(space.low, space.size)
    low, high, slopes = _planes(space, x, half, ~cells.clear)
    reach = slopes.sum(axis=-1)
    keep = (high + reach >= 0.0).all(axis=1)
    least, most = np.ones(len(cells)), np.ones(len(cells))
    row, column = np.nonzero((low < reach) & keep[:, None])
    below, above = cut_bounds(low[row, column], high[row, column], slopes[row, column])
    np.subtract.at(least, row, 1.0 - below)
    np.minimum.at(most, row, above)
    clear = low[:, -1] >= reach[:, -1]
    return Cells(cells.level, cells.place, clear, np.maximum(least, 0.0), most)[keep & (most > 0.0)]


def _planes(space: _Slice, x: FloatArray, half: FloatArray, ask: Bools) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return planes below and above every limit and the singular surface over each box, as `cut_bounds` takes them.

    The surface, in the last column, is asked for some boxes only; elsewhere it is infinitely far.  A length is no
    shorter than its tangent, and longer by ``h^2 / (2 (L - h))`` at most, or by ``2 h``.
    """
    L, J = rates(space.hexapod, space.poses(x))
    h, u = np.linalg.norm(half, axis=1, keepdims=True), np.nan_to_num(J[..., :3])
    near = L > h
    bend = np.minimum(np.where(near, 0.5 * h**2 / np.where(near, L - h, 1.0), np.inf), 2.0 * h)
    legs, k = space.functions.leg, space.functions.k
    f, gradients = space.functions.with_gradients(L, u, space.directions)
    low, high, slopes = np.full(len(ask), np.inf), np.full(len(ask), np.inf), np.zeros((len(ask), 3))
    low[ask], high[ask], slopes[ask] = space.surface.over_boxes(x[ask], half[ask])
    return (
        np.column_stack([f + np.minimum(k, 0.0) * bend[:, legs], low]),
        np.column_stack([f + np.maximum(k, 0.0) * bend[:, legs], high]),
        np.concatenate([np.abs(gradients @ space.hexapod.home[:3, :3]) * half[:, None], slopes[:, None]], axis=1),
    )


def _reached(space: _Slice, cells: Cells) -> bool:
    """Return whether home is in one of the boxes, or a straight move from it to the nearest whole box is allowed."""
    x, half = cells.boxes(space.low, space.size)
    if np.array_equal(space.rotation, np.eye(3)) and (np.abs(x) <= half).all(axis=1).any():
        return True
    whole = np.flatnonzero(cells.least == 1.0)
    if not len(whole):
        return False
    nearest = whole[np.linalg.norm(x[whole], axis=1).argmin()]
    return bool(check_path(space.hexapod, space.hexapod.home, space.poses(x[nearest])).ok)
