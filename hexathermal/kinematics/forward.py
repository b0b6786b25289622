"""Forward kinematics: the pose of the platform at given leg lengths, or a clear refusal."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum
from typing import Any

import numpy as np
import numpy.typing as npt
from numpy import empty, ndarray

from hexathermal.errors import ArgumentError, KinematicsError
from hexathermal.kinematics import layout as at
from hexathermal.kinematics.batches import in_chunks, place, slices, solvers, where
from hexathermal.kinematics.constants import LARGEST_CONDITION, constants, reach
from hexathermal.kinematics.inverse import inverse_kinematics, plain
from hexathermal.kinematics.jacobian import condition_number
from hexathermal.kinematics.refusals import refuse_forward
from hexathermal.machine.hexapod import Hexapod
from hexathermal.poses import FloatArray, PoseLike, as_array, finite_array, like, pose_array

_NO_INFO = np.empty((0, 3))
_NO_EXPANSION = np.zeros((1, 2))


class ForwardStatus(IntEnum):
    """How a forward solution ended.

    Attributes
    ----------
    OK
        The pose was found, reached from the start without a singular pose between, within all limits.
    OUT_OF_STROKE, OUT_OF_CONE
        Found, but a length lies outside its stroke; a joint is turned beyond its cone.
    SINGULAR
        On the way the legs lose control of a direction.
    NOT_CONVERGED
        No pose was found that has these lengths.
    OTHER_BRANCH
        A pose has these lengths, but not one that is reached from the start.
    """

    OK = at.OK
    OUT_OF_STROKE = at.OUT_OF_STROKE
    OUT_OF_CONE = at.OUT_OF_CONE
    SINGULAR = at.SINGULAR
    NOT_CONVERGED = at.NOT_CONVERGED
    OTHER_BRANCH = at.OTHER_BRANCH


@dataclass(frozen=True, eq=False)
class ForwardResult:
    """Forward kinematics with everything that was learnt on the way; nothing is raised for a status.

    Attributes
    ----------
    pose : array, shape (..., 4, 4) [m]
        Platform in base; where the status is not `ForwardStatus.OK`, the last iterate or the pose that breaks a limit.
    status : ForwardStatus, or array, shape (...), int
        How it ended; one for a single set of lengths, an array of its values for a batch. The same goes for all below.
    iterations : array, shape (...), int
        Linear systems solved.
    residual : array, shape (...) [m]
        Largest difference between wanted and reached length.
    condition_number : array, shape (...)
        Of the Jacobian at the pose, see `condition_number`.
    assembly_mode : array, shape (...), int
        Sign of ``det J`` as compared with home: 1 the same, -1 another, 0 singular.
    """

    pose: FloatArray
    status: Any
    iterations: Any
    residual: Any
    condition_number: Any
    assembly_mode: Any

    @property
    def ok(self) -> Any:
        """Whether the pose was reached within all limits: a bool, or an array of them, shape (...)."""
        return self.status == ForwardStatus.OK


def lengths_of(lengths: npt.ArrayLike) -> FloatArray:
    """Return lengths as a contiguous array (..., 6); the loops judge its entries."""
    array = as_array(lengths, "lengths")
    if array.ndim < 1 or array.shape[-1] != 6:
        raise ArgumentError(f"lengths has shape {array.shape}; expected (..., 6)")
    return array if plain(array) else np.array(array, dtype=np.float64, order="C")


def checked_lengths(lengths: npt.ArrayLike) -> FloatArray:
    """Return lengths as a contiguous array (..., 6) of positive numbers."""
    array = finite_array(lengths, (6,), "lengths")
    if array.size and not array.min() > 0.0:
        index = tuple(int(k) for k in np.argwhere(array <= 0.0)[0])
        raise ArgumentError(
            f"leg {index[-1] + 1} has length {array[index]:g} m{where(index[:-1])}; lengths are inter-articular "
            "(q0 + q) and above 0: were strokes given?"
        )
    return array if plain(array) else np.array(array, order="C")


def _starts(guess: PoseLike | None, hexapod: Hexapod, lead: tuple[int, ...]) -> FloatArray:
    """Return start poses, one or as many as there are lengths."""
    if guess is None:
        return np.array(hexapod.home)[None]
    array = np.array(pose_array(guess, "guess"), order="C")
    if (inverse_lengths(hexapod, array) > reach(hexapod)).any():
        raise ArgumentError("guess is far outside the machine; poses are in metres, were millimetres given?")
    if array.ndim == 2:
        return array[None]
    try:
        return np.array(np.broadcast_to(array, (*lead, 4, 4)), order="C").reshape(-1, 4, 4)
    except ValueError:
        wanted = f"(4, 4) or {(*lead, 4, 4)}" if lead else "(4, 4), as there is one set of lengths"
        raise ArgumentError(f"guess has shape {array.shape}; expected {wanted}") from None


def inverse_lengths(hexapod: Hexapod, poses: FloatArray) -> FloatArray:
    """Return leg lengths of poses that may be anywhere; infinite where a pose is refused."""
    try:
        return inverse_kinematics(hexapod, poses)
    except ArgumentError:
        return np.full((*poses.shape[:-2], 6), np.inf)


def run(
    hexapod: Hexapod,
    lengths: FloatArray,
    starts: FloatArray | None,
    *,
    commands: FloatArray | None = None,
    expansions: FloatArray = _NO_EXPANSION,
    with_info: bool = False,
) -> tuple[FloatArray, npt.NDArray[np.int8], FloatArray]:
    """Solve a flat batch: poses, codes and info (empty unless asked for).

    Parameters
    ----------
    lengths : array, shape (N, 6) [m]
        True lengths.
    starts : array, shape (1 or N, 4, 4) [m], or None
        None: home, with the fast solver first.
    commands : array, shape (N, 6) [m]
        Lengths that the strokes are held against; default the lengths themselves.
    expansions : array, shape (1 or N, 2)
        ``alpha dT`` of platform and base.
    """
    made = constants(hexapod)
    n = lengths.shape[0]
    held = lengths if commands is None else commands
    limits = made.machine if commands is None else made.unlimited
    out, codes = np.empty((n, 4, 4)), np.zeros(n, dtype=np.int8)
    info = np.zeros((n, 3)) if with_info else _NO_INFO
    fast, careful = solvers()
    from_home = starts is None and bool(np.isfinite(made.forward[at.F_DETERMINANT]))
    home = np.array(hexapod.home)[None]
    cold = not expansions.any()

    def part(array: FloatArray, i: int, j: int) -> FloatArray:
        return array if array.shape[0] <= 1 else array[i:j]

    def work(i: int, j: int) -> int:
        notes = info[i:j] if with_info else info
        begin = home if starts is None else part(starts, i, j)
        if from_home:
            not_ok = fast.forward_many(limits, made.forward, lengths[i:j], out[i:j], codes[i:j], notes)
            if cold and not_ok == 0:
                return 0
            if not cold:
                begin = np.where((codes[i:j] == at.OK)[:, None, None], out[i:j], home)
        return int(
            careful.careful_many(
                made.machine, made.centre, made.origin, made.size, lengths[i:j], held[i:j], begin,
                part(expansions, i, j), from_home and cold, out[i:j], codes[i:j], notes,
            )
        )  # fmt: skip

    if sum(in_chunks(n, work)):
        _mark_singular(hexapod, out, codes)
    return out, codes, info


def _mark_singular(hexapod: Hexapod, poses: FloatArray, codes: npt.NDArray[np.int8]) -> None:
    """Decide by the condition number which doubtful poses are singular."""
    codes[codes == at.SINGULAR_START] = at.SINGULAR
    doubtful = np.isin(codes, (at.NOT_CONVERGED, at.OTHER_BRANCH, at.NEAR_SINGULAR))
    chosen = np.flatnonzero(doubtful & np.isfinite(poses).all(axis=(1, 2)))
    singular = _conditions(hexapod, poses[chosen]) > LARGEST_CONDITION
    codes[codes == at.NEAR_SINGULAR] = at.OK
    codes[chosen[singular]] = at.SINGULAR


def _conditions(hexapod: Hexapod, poses: FloatArray) -> FloatArray:
    """Return condition numbers; infinite where a leg has vanished."""
    try:
        return condition_number(hexapod, poses)
    except KinematicsError:
        if len(poses) == 1:
            return np.full(1, np.inf)
        half = len(poses) // 2
        return np.concatenate([_conditions(hexapod, poses[:half]), _conditions(hexapod, poses[half:])])


def solve_forward(hexapod: Hexapod, lengths: npt.ArrayLike, guess: PoseLike | None = None) -> ForwardResult:
    """Return the pose of the platform at given leg lengths, with status, residual and conditioning.

    The pose with ``|t + R p_i - b_i| = L_i`` that a straight move from the start reaches without a singular pose.
    Newton works on the squared lengths until its step is below 3e-8 (rad, or parts of the machine's size; the error
    left is its square), then the lengths are checked: ``max |L(pose) - L| <= 2e-14 size``.  Where Newton's steps do not
    contract at once, the lengths are changed from the start's to the wanted ones in small parts, the posture is
    followed, and the straight move to it is checked.

    Parameters
    ----------
    hexapod : Hexapod
    lengths : array, shape (..., 6) [m]
        Inter-articular lengths ``q0 + q``.
    guess : SE3 or array, shape (4, 4) or (..., 4, 4) [m], optional
        Where to start, and whose branch to stay on. Default: home.

    Returns
    -------
    ForwardResult
        Arrays with the leading shape of `lengths`.

    Raises
    ------
    ArgumentError
        Wrong shape, not finite, lengths not above 0, or a guess far outside the machine.

    Examples
    --------
    >>> import hexathermal as ht
    >>> hexapod = ht.load_hexapod("reference")
    >>> result = hexapod.solve_forward(hexapod.inverse_kinematics(hexapod.home))
    >>> result.status.name, result.residual < 1e-14
    ('OK', True)
    """
    array = checked_lengths(lengths)
    lead = array.shape[:-1]
    flat = array.reshape(-1, 6)
    starts = None if guess is None else _starts(guess, hexapod, lead)
    poses, codes, info = run(hexapod, flat, starts, with_info=True)
    condition = np.full(len(codes), np.inf)
    good = np.isfinite(poses).all(axis=(1, 2)) & (codes != at.NOT_CONVERGED)
    if good.any():
        condition[good] = _conditions(hexapod, poses[good])
    if not lead:
        mode = 0 if codes[0] == at.SINGULAR else int(_modes(hexapod, poses)[0])
        steps, residual = int(info[0, 0]), float(info[0, 1])
        return ForwardResult(poses[0], ForwardStatus(int(codes[0])), steps, residual, float(condition[0]), mode)
    return ForwardResult(
        pose=poses.reshape(*lead, 4, 4),
        status=codes.reshape(lead),
        iterations=info[:, 0].astype(np.int64).reshape(lead),
        residual=info[:, 1].reshape(lead),
        condition_number=condition.reshape(lead),
        assembly_mode=np.where(codes == at.SINGULAR, 0, _modes(hexapod, poses)).reshape(lead),
    )


def _modes(hexapod: Hexapod, poses: FloatArray) -> npt.NDArray[np.int8]:
    """Return the sign of ``det J`` as compared with home."""
    own = _signs(hexapod, hexapod.home[None])[0]
    out = np.zeros(len(poses), dtype=np.int8)
    for part in slices(len(poses)):
        out[part] = np.nan_to_num(_signs(hexapod, poses[part]) * own)
    return out


def _signs(hexapod: Hexapod, poses: FloatArray) -> FloatArray:
    """Return the sign of the determinant of the rows ``[d, s x d]``, NaN where a pose is not finite."""
    s = np.einsum("nij,kj->nki", poses[:, :3, :3], hexapod.platform_joints)
    d = s + poses[:, None, :3, 3] - hexapod.base_joints
    with np.errstate(all="ignore"):
        return np.asarray(np.sign(np.linalg.det(np.concatenate([d, np.cross(s, d)], axis=-1))))


def _prepared(hexapod: Hexapod) -> tuple[Any, FloatArray]:
    """Return the solver for one set of lengths and the machine's numbers, kept for the next call."""
    pair = hexapod._prepared["forward"] = (solvers()[0].forward_one, constants(hexapod).both_forward)
    return pair


def forward_kinematics(hexapod: Hexapod, lengths: npt.ArrayLike, guess: PoseLike | None = None) -> Any:
    """Return the pose of the platform at given leg lengths, or raise.

    See `solve_forward` for the equation and the stopping rule.

    Parameters
    ----------
    hexapod : Hexapod
    lengths : array, shape (..., 6) [m]
        Inter-articular lengths ``q0 + q``.
    guess : SE3 or array, shape (4, 4) or (..., 4, 4) [m], optional
        Where to start, and whose branch to stay on. Default: home. An SE3 gives an SE3.

    Returns
    -------
    array, shape (..., 4, 4) [m], or SE3

    Raises
    ------
    OutOfStrokeError, JointConeError, SingularPoseError, NotConvergedError, OtherBranchError
        With leg, value and limits, for the first pose of the batch that is refused.
    ArgumentError
        Wrong shape, not finite, or lengths not above 0.
    """
    if guess is None and type(lengths) is ndarray:
        try:
            solve, numbers = hexapod._prepared["forward"]
        except KeyError:
            solve, numbers = _prepared(hexapod)
        out = empty((4, 4))
        try:
            if solve(numbers, lengths, out) == 0:
                return out
        except TypeError:  # not one writable array of six doubles: the way for all that follows
            pass
    array = lengths_of(lengths)
    lead = array.shape[:-1]
    flat = array.reshape(-1, 6)
    starts = None if guess is None else _starts(guess, hexapod, lead)
    poses, codes, _info = run(hexapod, flat, starts)
    if codes.any():
        checked_lengths(array)
        bad = int(np.flatnonzero(codes)[0])
        start = None if starts is None else starts[bad % len(starts)]
        refuse_forward(hexapod, int(codes[bad]), poses[bad], flat[bad], place(bad, lead), start=start)
    return like(guess, poses.reshape(*lead, 4, 4))
