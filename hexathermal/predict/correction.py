"""Corrected leg lengths, corrected pose and predicted pose: the main job.

``drift_i = sum_s A_s q0 dT_s + B_s q dT_s`` (paper, eqs. 4 and 8), with ``q`` the commanded rod displacement, and
plates that expand about their origins (eq. 1).  ``corrected = wanted - drift(corrected)`` is solved exactly; terms that
extend a leg's law (`hexathermal.predict.leg_drift`) join the drift, and are then solved for step by step.  Where legs
give way to a payload, their sag at the wanted pose joins too (`hexathermal.kinematics.statics`).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NoReturn, TypeAlias

import numpy as np
import numpy.typing as npt
from numpy import empty, ndarray

from hexathermal.errors import ArgumentError, ThermalModelError
from hexathermal.kinematics import layout as at
from hexathermal.kinematics.batches import correctors, in_chunks, place
from hexathermal.kinematics.constants import constants
from hexathermal.kinematics.forward import checked_lengths, run
from hexathermal.kinematics.inverse import inverse_kinematics, poses_of, refuse_pose
from hexathermal.kinematics.refusals import refuse_cone, refuse_forward, refuse_stroke
from hexathermal.kinematics.statics import payload_sag
from hexathermal.machine.hexapod import Hexapod
from hexathermal.machine.thermal import TemperaturesLike
from hexathermal.poses import FloatArray, PoseLike, like
from hexathermal.predict.balance import balanced
from hexathermal.predict.leg_drift import added_drift, refuse_states
from hexathermal.predict.temperatures import (
    active_model,
    check_temperatures,
    refuse_temperatures,
    temperature_array,
)

MOST_STALLED = 3
"""Steps that may take away less than half: behind them lies no solution."""

NO_LENGTHS = (
    "no lengths solve the legs' law: its terms change the drift too much with the displacement; check their amplitudes "
    "and lengths in the machine's file"
)

Added: TypeAlias = Callable[[FloatArray, FloatArray], FloatArray]
"""From commanded lengths (n, 6) [m] and temperatures since the reference (n, s) [K] to added drift (n, 6) [m]."""

_ITSELF = np.empty(0, dtype=np.int64)

MOST_STEPS = 40
"""Steps in which terms that extend a law are solved for; each takes away all but some thousandths."""


def corrected_leg_lengths(hexapod: Hexapod, pose: PoseLike, temps: TemperaturesLike) -> FloatArray:
    """Return the leg lengths to command so that a warm machine stands at the wanted pose.

    With ``a = sum A_s dT_s``, ``b = sum B_s dT_s`` and the length ``L`` of the leg between the expanded plates at the
    wanted pose: ``corrected = q0 + (L - q0 - a q0) / (1 + b)``, which solves ``corrected + drift(corrected) = L``
    exactly. Terms of the legs' laws that follow from displacement and temperature join; those with a state are refused.
    The sag under a payload is made up for: ``corrected + drift(corrected) + sag(pose) = L``.

    Parameters
    ----------
    hexapod : Hexapod
    pose : SE3 or array, shape (..., 4, 4) [m]
        Platform in base.
    temps : array, shape (..., n) [degC], or mapping of sensor name to values
        In the order of `hexapod.sensor_names`; for a machine with one sensor a leg, (..., 6). Poses and temperatures
        broadcast against each other.

    Returns
    -------
    array, shape (..., 6) [m]
        Inter-articular lengths ``q0 + q``; `Hexapod.strokes` gives ``q``.

    Raises
    ------
    OutOfStrokeError, JointConeError
        A corrected length is out of stroke, or a leg out of its cone; with leg, value and limits.
    TemperatureError
        A temperature is missing, NaN, impossible or outside the law's range; names the sensor.
    ThermalModelError
        The machine has no thermal law: compensation is not active; or a term of its law has a state, see
        `hexathermal.predict.leg_states`.
    ArgumentError
        Wrong shape, or no rigid motion.

    Examples
    --------
    >>> import hexathermal as ht
    >>> hexapod = ht.load_hexapod("reference")
    >>> warm = hexapod.corrected_leg_lengths(hexapod.home, [22.0] * 6)
    >>> nominal = hexapod.inverse_kinematics(hexapod.home)
    >>> bool((warm < nominal).all())          # warm legs are longer than told: tell them less
    True
    """
    if type(pose) is ndarray and type(temps) is ndarray and hexapod.thermal is not None:
        try:
            correct, numbers = hexapod._prepared["correction"]
        except KeyError:
            correct, numbers = _prepared(hexapod)
        out = empty(6)
        try:
            if correct(numbers, pose, temps, out) == 0:
                return out
        except TypeError:  # not one pose and one set of temperatures in writable doubles: the way for all that follows
            pass
    return _corrected(hexapod, poses_of(pose), temperature_array(hexapod, temps))


def _prepared(hexapod: Hexapod) -> tuple[Any, FloatArray]:
    """Return the loop for one pose and the machine's numbers, kept for the next call."""
    extended = active_model(hexapod).has_terms or hexapod.compliance is not None
    one = _never if extended else correctors().corrected_one
    pair = hexapod._prepared["correction"] = (one, constants(hexapod).both_law)
    return pair


def _never(numbers: FloatArray, pose: FloatArray, temps: FloatArray, out: FloatArray) -> int:
    """Refuse: the loop for one pose knows neither terms nor sag."""
    return at.BAD_SHAPE


def _corrected(hexapod: Hexapod, poses: FloatArray, temps: FloatArray) -> FloatArray:
    """Return corrected lengths of checked-in arrays of any leading shapes that broadcast."""
    if not active_model(hexapod).has_terms and hexapod.compliance is None:
        return _by_law(hexapod, poses, temps, constants(hexapod).both_law)
    refuse_states(hexapod)
    return with_added(hexapod, poses, temps, lambda told, dT: added_drift(hexapod, told, dT))


def with_added(hexapod: Hexapod, poses: FloatArray, temps: FloatArray, added: Added, jump: float = 0.0) -> FloatArray:
    """Return corrected lengths where `added` joins the drift of the laws, ``c + drift(c) + added(c) + sag = L``.

    Parameters
    ----------
    hexapod : Hexapod
    poses, temps : array
        As `corrected_leg_lengths`, checked in.
    added : function
        From commanded lengths (n, 6) and temperatures since the reference (n, s) to what is added (n, 6) [m].
    jump : float [m]
        What may be left where `added` jumps at the solution, so that the steps do not end.

    Raises
    ------
    ThermalModelError
        The steps do not end: `added` changes too much with the length.
    """
    made = constants(hexapod)
    unlimited = made.both_law.copy()
    unlimited[0, : len(made.unlimited)] = made.unlimited
    told = _by_law(hexapod, poses, temps, unlimited)
    wanted = base_warm(hexapod, told, temps)[0] - payload_sag(hexapod, poses)
    lead, close = told.shape[:-1], 4.0 * np.finfo(float).eps * float(np.abs(wanted).max(initial=1.0))
    flat, dT = told.reshape(-1, 6), since_reference(hexapod, temps, lead)
    size, stalled = np.inf, 0
    for _step in range(MOST_STEPS):
        wrong = (wanted - base_warm(hexapod, told, temps)[0]).reshape(-1, 6) - added(flat, dT)
        flat = flat + wrong
        told = flat.reshape(*lead, 6)
        last, size = size, float(np.abs(wrong).max(initial=0.0))
        stalled += int(size > 0.5 * last)
        if size <= close or stalled > MOST_STALLED:
            break
    if not size <= max(close, jump):
        raise ThermalModelError(NO_LENGTHS)
    check_strokes(hexapod, flat, lead)
    return told


def since_reference(hexapod: Hexapod, temps: FloatArray, lead: tuple[int, ...]) -> FloatArray:
    """Return temperatures (n, s) [K] since the reference, one row for each of the results of leading shape `lead`."""
    dT = temps - active_model(hexapod).reference_temperature_degC
    return np.broadcast_to(dT, (*lead, dT.shape[-1])).reshape(-1, dT.shape[-1])


def _by_law(hexapod: Hexapod, poses: FloatArray, temps: FloatArray, numbers: FloatArray) -> FloatArray:
    """Return corrected lengths under the laws without terms; `numbers` are those of the machine and its laws."""
    if poses.ndim == 2 and temps.ndim == 1:
        out = np.empty(6)
        if correctors().corrected_one(numbers, poses, temps, out) == 0:
            return out
    lead, which_pose, which_temps = _joined(poses.shape[:-2], temps.shape[:-1])
    flat, hot = poses.reshape(-1, 4, 4), temps.reshape(-1, temps.shape[-1])
    out = np.empty((int(np.prod(lead, dtype=np.int64)), 6))

    def work(i: int, j: int) -> int:
        own_pose, own_temps = which_pose[i:j], which_temps[i:j]
        T = flat[i:j] if not which_pose.size and flat.shape[0] > 1 else flat
        hot_ = hot[i:j] if not which_temps.size and hot.shape[0] > 1 else hot
        bad = correctors().corrected_many(numbers, T, hot_, own_pose, own_temps, out[i:j])
        return -1 if bad < 0 else i + int(bad)

    for bad in in_chunks(out.shape[0], work):
        if bad >= 0:
            m = int(which_pose[bad]) if which_pose.size else (bad if flat.shape[0] > 1 else 0)
            n = int(which_temps[bad]) if which_temps.size else (bad if hot.shape[0] > 1 else 0)
            _refuse(hexapod, flat[m], hot[n], place(bad, lead), place(n, temps.shape[:-1]))
    return out.reshape(*lead, 6)


def _joined(
    poses: tuple[int, ...], temps: tuple[int, ...]
) -> tuple[tuple[int, ...], npt.NDArray[np.int64], npt.NDArray[np.int64]]:
    """Return the joint leading shape, and for each result which pose and which temperatures it takes.

    The index arrays stay empty where results and entries run in step, or where there is one entry for all.
    """
    try:
        lead = np.broadcast_shapes(poses, temps)
    except ValueError:
        raise ArgumentError(
            f"poses with leading shape {poses} and temps with leading shape {temps} do not broadcast; "
            "add an axis: poses[:, None], or temps[None]"
        ) from None
    return lead, _which(poses, lead), _which(temps, lead)


def _which(own: tuple[int, ...], lead: tuple[int, ...]) -> npt.NDArray[np.int64]:
    """Return the flat index of the entry behind each result; empty when in step or only one."""
    count = int(np.prod(own, dtype=np.int64))
    if count <= 1 or count == int(np.prod(lead, dtype=np.int64)):
        return _ITSELF
    return np.ascontiguousarray(np.broadcast_to(np.arange(count).reshape(own), lead)).reshape(-1)


def _refuse(
    hexapod: Hexapod, pose: FloatArray, temps: FloatArray, index: tuple[int, ...], reading: tuple[int, ...]
) -> NoReturn:
    """Say why a pose and its temperatures were refused; `index` is the result's place, `reading` that of the temps."""
    made = constants(hexapod)
    out = np.empty(6)
    code = correctors().corrected_one(made.both_law, np.array(pose), np.array(temps), out)
    if code == at.BAD_TEMPERATURE:
        refuse_temperatures(hexapod, temps, reading)
    if code == at.OUT_OF_STROKE:
        inverse_kinematics(hexapod, pose)
        refuse_stroke(hexapod, out, index)
    if code == at.OUT_OF_CONE:
        refuse_cone(hexapod, pose, index, _expansions(hexapod, temps))
    refuse_pose(hexapod, pose, index)


def _expansions(hexapod: Hexapod, temps: FloatArray) -> FloatArray:
    """Return ``alpha dT`` of platform and base at one set of temperatures, shape (2,)."""
    return base_warm(hexapod, hexapod.home_lengths, temps)[1]


def corrected_pose(hexapod: Hexapod, pose: PoseLike, temps: TemperaturesLike) -> Any:
    """Return the pose to send to a controller that takes poses only.

    The nominal forward kinematics of the corrected lengths: the controller's own inverse kinematics turns it back into
    exactly those lengths.

    Parameters, broadcasting and errors as in `corrected_leg_lengths`; forward errors as in `forward_kinematics`.

    Returns
    -------
    array, shape (..., 4, 4) [m], or SE3 where one SE3 and one set of temperatures were given
    """
    lengths = corrected_leg_lengths(hexapod, pose, temps)
    lead = lengths.shape[:-1]
    flat = lengths.reshape(-1, 6)
    poses, codes, _info = run(hexapod, flat, None)
    if codes.any():
        bad = int(np.flatnonzero(codes)[0])
        refuse_forward(hexapod, int(codes[bad]), poses[bad], flat[bad], place(bad, lead))
    return like(pose, poses.reshape(*lead, 4, 4))


def leg_drift(hexapod: Hexapod, lengths: npt.ArrayLike, temps: TemperaturesLike) -> FloatArray:
    """Return how much longer each warm leg is than it was told to be.

    ``drift = sum_s A_s q0 dT_s + B_s q dT_s`` with ``q = lengths - q0`` (paper, eqs. 4 and 8), and the terms beside
    it. The sag under a payload is no drift: it follows from the pose (`hexathermal.kinematics.statics.payload_sag`).

    Parameters
    ----------
    hexapod : Hexapod
    lengths : array, shape (..., 6) [m]
        Commanded lengths ``q0 + q``.
    temps : array, shape (..., n) [degC], or mapping

    Returns
    -------
    array, shape (..., 6) [m]
    """
    commands = checked_lengths(lengths)
    warm, _scales = _warm_lengths(hexapod, commands, temps)
    return warm - commands


def _warm_lengths(hexapod: Hexapod, commands: FloatArray, temps: TemperaturesLike) -> tuple[FloatArray, FloatArray]:
    """Return true lengths (..., 6), terms included, and expansions (..., 2) of platform and base."""
    if not active_model(hexapod).has_terms:
        return base_warm(hexapod, commands, temps)
    refuse_states(hexapod)
    array = temperature_array(hexapod, temps)
    warm, expansions = base_warm(hexapod, commands, array)
    told = np.broadcast_to(commands, warm.shape).reshape(-1, 6)
    added = added_drift(hexapod, told, since_reference(hexapod, array, warm.shape[:-1]))
    return warm + added.reshape(warm.shape), expansions


def base_warm(hexapod: Hexapod, commands: FloatArray, temps: TemperaturesLike) -> tuple[FloatArray, FloatArray]:
    """Return true lengths (..., 6) under the laws without terms, and expansions (..., 2) of platform and base."""
    array = temperature_array(hexapod, temps)
    check_temperatures(hexapod, array)
    lead, which_command, which_temps = _joined(commands.shape[:-1], array.shape[:-1])
    told, hot = np.array(commands).reshape(-1, 6), array.reshape(-1, array.shape[-1])
    count = int(np.prod(lead, dtype=np.int64))
    warm, expansions = np.empty((count, 6)), np.empty((count, 2))
    made = constants(hexapod)
    correctors().warm_many(made.both_law, told, hot, which_command, which_temps, warm, expansions)
    return warm.reshape(*lead, 6), expansions.reshape(*lead, 2)


def predicted_pose(hexapod: Hexapod, lengths: npt.ArrayLike, temps: TemperaturesLike) -> FloatArray:
    """Return where the platform of a warm machine really stands at given commanded lengths.

    Each leg is ``commanded + drift`` long and runs between the expanded plates; the pose is their exact forward
    kinematics.  Where legs give way to a payload, ``commanded + drift + sag(pose)`` is solved for the pose.

    With nominal lengths (`inverse_kinematics`) this is the platform without correction, with `corrected_leg_lengths`
    the platform with correction.

    Parameters
    ----------
    hexapod : Hexapod
    lengths : array, shape (..., 6) [m]
        Commanded lengths ``q0 + q``.
    temps : array, shape (..., n) [degC], or mapping of sensor name to values
        Broadcast against `lengths`.

    Returns
    -------
    array, shape (..., 4, 4) [m]

    Raises
    ------
    OutOfStrokeError
        A commanded length is out of stroke.
    TemperatureError, ThermalModelError, ArgumentError, and the errors of `forward_kinematics`.

    Examples
    --------
    >>> import hexathermal as ht
    >>> hexapod = ht.load_hexapod("reference")
    >>> warm = hexapod.predicted_pose(hexapod.inverse_kinematics(hexapod.home), [25.0] * 6)
    >>> bool(warm[2, 3] > hexapod.home[2, 3])             # warm legs lift the platform
    True
    """
    commands = checked_lengths(lengths)
    warm, expansions = _warm_lengths(hexapod, commands, temps)
    lead = warm.shape[:-1]
    true = np.array(warm.reshape(-1, 6))
    told = np.array(np.broadcast_to(commands, warm.shape).reshape(-1, 6))
    flat = np.array(expansions.reshape(-1, 2))
    check_strokes(hexapod, told, lead)
    return balanced(hexapod, true, told, flat, lead).reshape(*lead, 4, 4)


def check_strokes(hexapod: Hexapod, told: FloatArray, lead: tuple[int, ...]) -> None:
    """Refuse commands that are out of stroke."""
    c = constants(hexapod).machine
    out = (told < c[at.SHORTEST : at.SHORTEST + 6]) | (told > c[at.LONGEST : at.LONGEST + 6])
    if out.any():
        bad = int(np.flatnonzero(out.any(axis=1))[0])
        refuse_stroke(hexapod, told[bad], place(bad, lead))
