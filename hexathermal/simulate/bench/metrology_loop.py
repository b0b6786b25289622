"""The metrology loop: from the leg's temperatures to how much longer it is than its scale says."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from hexathermal.poses import FloatArray
from hexathermal.simulate.bench.cells import overlaps

if TYPE_CHECKING:
    from hexathermal.simulate.bench.leg import VirtualLeg


def growth(leg: VirtualLeg, temperatures: FloatArray, q: FloatArray, reference: FloatArray) -> FloatArray:
    """Return by how much the leg is longer than its scale says, shape (n,) [m].

    The metrology loop, from the lower to the upper joint's centre: lower joint, body up to the reading head, the
    head's bracket, scale from the mark under the head to where it is held, rod from there to its end, upper joint:

        growth = sum over the loop of  alpha * integral of (T - T_reference) dx

    Parameters
    ----------
    leg : VirtualLeg
    temperatures : array, shape (n, m) [degC]
    q : array, shape (n,) [m]
        What the scale reads.
    reference : array, shape (m,) [degC]
        Temperatures at which the scale reads true.
    """
    rise = np.atleast_2d(temperatures) - reference
    q = np.broadcast_to(np.asarray(q, dtype=np.float64), rise.shape[:1])
    body, rod, joints = leg.body, leg.rod, leg.joints
    ends = np.array([leg.body_edges[0], body.head_position])
    found = body.expansion * (rise[:, leg.in_body] @ overlaps(leg.body_edges, ends)[:, 0])
    bracket = body.head_bracket * body.head_bracket_expansion
    found += bracket * (rise @ leg.weights("body", body.head_position))
    top = leg.rod_edges[-1]
    held = top - rod.scale_held
    # the mark under the head, in the rod's own coordinates
    mark = body.head_position - q
    low, high = leg.rod_edges[:-1], leg.rod_edges[1:]

    def length(first: FloatArray | float, last: FloatArray | float) -> FloatArray:
        """Return the length of each rod cell between two places, shape (n, cells)."""
        a, b = np.reshape(first, (-1, 1)), np.reshape(last, (-1, 1))
        return np.asarray(np.clip(np.minimum(high, b) - np.maximum(low, a), 0.0, None))

    scale = length(mark, held) - length(held, mark)
    found += rod.scale_expansion * (rise[:, leg.in_rod] * scale).sum(axis=1)
    found += rod.expansion * (rise[:, leg.in_rod] @ length(held, top)[0])
    found += joints.expansion * joints.length * (rise[:, leg.lower_joint] + rise[:, leg.upper_joint])
    return np.asarray(found)
