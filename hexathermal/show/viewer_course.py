"""What the viewer shows, frame by frame: wanted poses, where the platform stands, temperatures, regions of the budget.

All poses come from `hexathermal.predict`: without correction ``predicted_pose(inverse_kinematics(pose), temps)``, with
it ``predicted_pose(corrected_leg_lengths(pose, temps), temps)``, row after row where a leg's law remembers. Errors are
those of the tool point, reached minus wanted, in base axes.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from hexathermal.errors import ArgumentError, HexathermalError, ThermalModelError
from hexathermal.machine.hexapod import Hexapod
from hexathermal.machine.thermal import frozen
from hexathermal.poses import FloatArray
from hexathermal.show.options import in_millimetres

if TYPE_CHECKING:
    from hexathermal.predict.budget_plates import Plates

Progress = Callable[[int, int, str], None]

FRAMES = 145
"""Most frames of an animation: every fifth minute of a day of twelve hours."""

PROBABILITY = 0.95
"""Of the region that the ellipsoid bounds."""

ORIGIN = (0.0, 0.0, 0.0)


@dataclass(frozen=True, eq=False)
class Course:
    """An animation of a machine; n frames. Pairs are without and with correction.

    Attributes
    ----------
    hexapod : Hexapod
    title : str
    labels : tuple of str
        When each frame is, in words.
    group : array, shape (n,), int
        Frames of one run; the trail begins anew with each.
    ideal : array, shape (n, 4, 4) [m]
        Wanted poses, platform in base.
    errors : array, shape (2, n, 6) [m, m, m, rad, rad, rad]
        Of the tool point and the platform's rotation.
    legs_degC : array, shape (n, 6) [degC]
        Mean of each leg's thermometers; NaN where there is none.
    centres : array, shape (2, n, 3) [m]
        Error that the budget expects of the tool point; NaN where there is no budget.
    regions : array, shape (2, n, 3, 3) [m]
        Semi-axes of the ellipsoid about it, as columns; see `semi_axes`.
    tool : array, shape (3,) [m]
        The tool point, from the platform's origin in platform axes.
    smooth : bool
        Whether the platform moves from frame to frame, so that what lies between may be drawn.
    words : (str, str)
        What the two sets of poses are.
    notes : tuple of str
    """

    hexapod: Hexapod
    title: str
    labels: tuple[str, ...]
    group: npt.NDArray[np.int64]
    ideal: FloatArray
    errors: FloatArray
    legs_degC: FloatArray
    centres: FloatArray
    regions: FloatArray
    tool: FloatArray
    smooth: bool
    words: tuple[str, str]
    notes: tuple[str, ...] = ()

    def __len__(self) -> int:
        return len(self.labels)

    @property
    def shift(self) -> FloatArray:
        """Distance of the tool point from where it is wanted, shape (2, n) [m]."""
        return np.asarray(np.linalg.norm(self.errors[..., :3], axis=-1))

    @property
    def turn(self) -> FloatArray:
        """Angle of the platform from where it is wanted, shape (2, n) [rad]."""
        return np.asarray(np.linalg.norm(self.errors[..., 3:], axis=-1))


def tool_errors(wanted: FloatArray, reached: FloatArray, tool: FloatArray) -> FloatArray:
    """Return the errors of a point of the platform: ``[t + R c - t_w - R_w c, log(R R_w^T)]`` in base axes.

    Parameters
    ----------
    wanted, reached : array, shape (n, 4, 4) [m]
    tool : array, shape (3,) [m]
        Point ``c`` from the platform's origin in platform axes.

    Examples
    --------
    >>> lifted = np.eye(4)[None].copy()
    >>> lifted[0, 2, 3] = 1e-6
    >>> round(tool_errors(np.eye(4)[None], lifted, np.array([0, 0, 0.1]))[0, 2].item(), 12)
    1e-06
    """
    from hexathermal.predict.pose_errors import pose_errors

    moved = np.eye(4)
    moved[:3, 3] = tool
    return pose_errors(wanted @ moved, reached @ moved)


def evenly(count: int, most: int = FRAMES) -> npt.NDArray[np.int64]:
    """Return at most `most` of `count` rows, evenly, with the first and the last.

    Examples
    --------
    >>> evenly(11, 3).tolist(), evenly(2, 3).tolist()
    ([0, 5, 10], [0, 1])
    """
    return np.unique(np.linspace(0, count - 1, min(count, most)).round().astype(np.int64))


def leg_temperatures(hexapod: Hexapod, temps: FloatArray) -> FloatArray:
    """Return the mean temperature of each leg's thermometers, shape (n, 6) [degC].

    Exchanged thermometers are put right: the colour is that of the leg that is warm.
    """
    from hexathermal.predict.temperatures import active_model

    return np.column_stack([temps[:, own].mean(axis=1) for own in active_model(hexapod).columns_of_leg])


def commanded_pair(hexapod: Hexapod, ideal: FloatArray, temps: FloatArray, time: FloatArray) -> FloatArray:
    """Return the lengths to command without and with correction, shape (2, n, 6) [m], in the order of time."""
    corrected = hexapod.leg_controllers().corrected_leg_lengths(ideal, temps, time)
    return np.stack([hexapod.inverse_kinematics(ideal), corrected])


def reached_pair(machine: Hexapod, lengths: FloatArray, temps: FloatArray, time: FloatArray) -> FloatArray:
    """Return where a warm machine stands with these lengths, shape (2, n, 4, 4) [m], in the order of time."""
    return np.stack([machine.leg_controllers().predicted_pose(told, temps, time) for told in lengths])


def semi_axes(covariance: FloatArray, factor: float) -> FloatArray:
    """Return the semi-axes of ``e^T V^-1 e <= k^2`` as the columns of a right-handed matrix (3, 3).

    Examples
    --------
    >>> np.abs(semi_axes(np.diag([1.0, 4.0, 9.0]), 2.0)).sum(axis=0).tolist()
    [2.0, 4.0, 6.0]
    """
    variances, axes = np.linalg.eigh(covariance)
    axes = axes * np.sign(np.linalg.det(axes))
    return np.asarray(axes * (factor * np.sqrt(np.maximum(variances, 0.0))))


def budget_regions(
    hexapod: Hexapod,
    ideal: FloatArray,
    temps: FloatArray,
    tool: FloatArray,
    progress: Progress,
    *,
    plates: Sequence[Plates] | None = None,
    air_degC: FloatArray | None = None,
) -> tuple[FloatArray, FloatArray, list[str]]:
    """Return what the error budget says of the tool point in each frame.

    Returns
    -------
    centres : array, shape (2, n, 3) [m]
        The error that is expected.
    regions : array, shape (2, n, 3, 3) [m]
        Semi-axes of the region of 95 % about it.
    notes : list of str
        Why a frame has none.
    """
    from hexathermal.predict.budget_gum import region_factor
    from hexathermal.predict.leg_drift import between_reversals, refuse_states
    from hexathermal.predict.temperatures import active_model

    notes, model = [], active_model(hexapod)
    try:
        refuse_states(between_reversals(hexapod))
    except ThermalModelError:
        hexapod = replace(hexapod, thermal=model.without_states())
        causes = ", ".join(dict.fromkeys(term.cause for term in model.states))
        notes.append(f"the ellipsoid is that of a machine without {causes}: a budget does not know what was before")
    n, refused = len(ideal), []
    centres, regions = np.full((2, n, 3), np.nan), np.full((2, n, 3, 3), np.nan)
    for k in range(n):
        progress(k, n, "error budget")
        view: dict[str, Any] = {} if plates is None else {"plates": plates[k]}
        if air_degC is not None:
            view["air_degC"] = float(air_degC[k])
        try:
            for way in range(2):
                budget = hexapod.error_budget(ideal[k], temps[k], correction=bool(way), at_tool=tool, **view)
                factor = region_factor(3, budget.joint_dof, PROBABILITY)
                centres[way, k] = budget.remaining[:3]
                regions[way, k] = semi_axes(budget.covariance[:3, :3], factor)
        except HexathermalError as error:
            centres[:, k] = regions[:, k] = np.nan
            refused.append(str(error))
    progress(n, n, "error budget")
    if refused:
        notes.append(
            f"{len(refused)} of {n} frames have no error budget, and no ellipsoid: {in_millimetres(refused[0])}"
        )
    return centres, regions, notes


def still_course(hexapod: Hexapod, pose: FloatArray, tool: FloatArray) -> Course:
    """Return one frame of a machine without a thermal law: it is drawn, nothing is predicted."""
    return Course(
        hexapod, "as it is drawn", ("no temperatures",), np.zeros(1, dtype=np.int64), frozen(pose[None]),
        frozen(np.zeros((2, 1, 6))), frozen(np.full((1, 6), np.nan)), frozen(np.full((2, 1, 3), np.nan)),
        frozen(np.full((2, 1, 3, 3), np.nan)), frozen(tool), False, ("no drift known", "no drift known"),
        ("the machine has no thermal law: nobody has told how it drifts, and no drift is shown",),
    )  # fmt: skip


def temperatures_course(
    hexapod: Hexapod, pose: FloatArray, temps: FloatArray, time: FloatArray | None, tool: FloatArray,
    progress: Progress,
) -> Course:  # fmt: skip
    """Return what measured temperatures do to a machine that holds a pose.

    Parameters
    ----------
    hexapod : Hexapod
        With a thermal law, which is taken for the truth.
    pose : array, shape (4, 4) [m]
    temps : array, shape (n, s) [degC]
        In the order of `hexapod.sensor_names`.
    time : array, shape (n,) [s], or None
    tool : array, shape (3,) [m]
    progress : callable

    Raises
    ------
    TemperatureError, KinematicsError
        As `predicted_pose` and `corrected_leg_lengths`.
    ArgumentError
        The legs' law remembers what was before, and there are no times.
    """
    from hexathermal.predict.temperatures import active_model

    if time is None and active_model(hexapod).states:
        raise ArgumentError("the legs' law depends on what was before: add time_s [s] to the temperatures")
    progress(0, 0, "predicting poses (the first run compiles)")
    ideal = np.broadcast_to(pose, (len(temps), 4, 4)).copy()
    when = np.arange(len(temps), dtype=np.float64) if time is None else time
    reached = reached_pair(hexapod, commanded_pair(hexapod, ideal, temps, when), temps, when)
    errors = np.stack([tool_errors(ideal, poses, tool) for poses in reached])
    kept = evenly(len(temps))
    labels = [f"row {k + 1} of {len(temps)}" if time is None else clock(time[k] - time[0]) for k in kept]
    centres, regions, notes = budget_regions(hexapod, ideal[kept], temps[kept], tool, progress)
    notes.insert(0, "the machine's own law is taken for the truth: what correction leaves is what the law does not "
                 "know, and only the ellipsoid tells of that")  # fmt: skip
    if len(kept) < len(temps):
        notes.append(f"{len(kept)} of {len(temps)} rows are shown, evenly")
    return Course(
        hexapod, "measured temperatures at one pose", tuple(labels), np.zeros(len(kept), dtype=np.int64),
        frozen(ideal[kept]), frozen(errors[:, kept]), frozen(leg_temperatures(hexapod, temps[kept])), frozen(centres),
        frozen(regions), frozen(tool), True, ("predicted without correction", "predicted with correction"),
        tuple(notes),
    )  # fmt: skip


def clock(seconds: float) -> str:
    """Return a time in words.

    Examples
    --------
    >>> clock(3900.0), clock(59.0)
    ('1 h 05 min', '0 h 00 min 59 s')
    """
    whole = round(float(seconds))
    hours, minutes, left = whole // 3600, whole % 3600 // 60, whole % 60
    return f"{hours} h {minutes:02d} min" + (f" {left:02d} s" if left else "")
