"""Where the platform stands at true leg lengths when the legs also give way to the payload."""

from __future__ import annotations

import numpy as np

from hexathermal.errors import NotConvergedError, OtherBranchError, SingularPoseError
from hexathermal.kinematics import layout as at
from hexathermal.kinematics.batches import place, where
from hexathermal.kinematics.forward import run
from hexathermal.kinematics.refusals import refuse_forward
from hexathermal.kinematics.statics import payload_sag
from hexathermal.machine.hexapod import Hexapod
from hexathermal.poses import FloatArray

MOST_STEPS = 40
"""Steps to the balance; each leaves some thousandths of the last, so that few are taken."""

NO_BALANCE = "no pose is in balance under the payload"
CHECK_LOAD = (
    "the legs give way too much, or the pose is near a singular one; check compliance and payload in the machine's file"
)


def balanced(
    hexapod: Hexapod, unloaded: FloatArray, told: FloatArray, expansions: FloatArray, lead: tuple[int, ...]
) -> FloatArray:
    """Return the poses at which lengths are ``unloaded + sag(pose)``; without a compliance those of the lengths.

    Forward kinematics and sag by turns, until the sag changes by at most four units in the last place of a length.

    Parameters
    ----------
    hexapod : Hexapod
    unloaded, told : array, shape (n, 6) [m]
        Lengths without the payload, and commanded ones, which strokes are held against.
    expansions : array, shape (n, 2)
        Of platform and base.
    lead : tuple of int
        Leading shape of the results, for messages.

    Returns
    -------
    array, shape (n, 4, 4) [m]

    Raises
    ------
    NotConvergedError
        No pose is in balance; with the place of the worst.
    KinematicsError
        As `forward_kinematics`.
    """
    if hexapod.compliance is None:
        return _standing(hexapod, unloaded, told, expansions, lead)
    # a cone may be left under the load: it is asked for with it
    poses = _standing(hexapod, unloaded, told, expansions, lead, passed=at.OUT_OF_CONE)
    last, stop = np.zeros_like(unloaded), 4.0 * np.finfo(float).eps * float(np.abs(unloaded).max(initial=1.0))
    for _step in range(MOST_STEPS):
        now = payload_sag(hexapod, poses, held=True)
        change, last = np.abs(now - last).max(axis=1, initial=0.0), now
        if not (unloaded + now > 0.0).all():
            break
        try:
            poses = _standing(hexapod, unloaded + now, told, expansions, lead)
        except (NotConvergedError, OtherBranchError, SingularPoseError) as error:
            raise NotConvergedError(f"{NO_BALANCE}{where(error.index)}: {CHECK_LOAD}", index=error.index) from None
        if not (change > stop).any():
            return poses
    bad = place(int(change.argmax()), lead)
    raise NotConvergedError(f"{NO_BALANCE}{where(bad)}: {CHECK_LOAD}", index=bad)


def _standing(
    hexapod: Hexapod, true: FloatArray, told: FloatArray, expansions: FloatArray, lead: tuple[int, ...],
    passed: int = at.OK,
) -> FloatArray:  # fmt: skip
    """Return the poses (n, 4, 4) at true lengths; one outcome may be passed over."""
    poses, codes, _info = run(hexapod, true, None, commands=told, expansions=expansions)
    refused = np.flatnonzero((codes != at.OK) & (codes != passed))
    if refused.size:
        bad = int(refused[0])
        refuse_forward(hexapod, int(codes[bad]), poses[bad], true[bad], place(bad, lead), expansions[bad])
    return poses
