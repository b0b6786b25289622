"""The singular poses of a machine at one orientation: a cubic surface of the platform's position.

``det [d_i, s_i x d_i]`` with the leg's vector ``d_i = t + s_i - b_i`` and ``s_i = R p_i`` is a polynomial of degree 3
in the position ``t`` (B. Mayer St-Onge and C. M. Gosselin, Singularity analysis and representation of the general
Gough-Stewart platform, Int. J. Robotics Research 19, 2000).  It is ``det J`` times the product of the lengths.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product
from math import comb

import numpy as np
import numpy.typing as npt

from hexathermal.kinematics.constants import constants, dimensionless
from hexathermal.kinematics.jacobian import at_centre
from hexathermal.kinematics.limits import rates
from hexathermal.machine.hexapod import Hexapod
from hexathermal.poses import FloatArray

EXPONENTS = tuple(e for e in product(range(4), repeat=3) if sum(e) <= 3)
"""Exponents of the 20 monomials, the constant first."""

ROUNDING_SAFETY = 10.0


@dataclass(frozen=True, eq=False)
class SingularSurface:
    """The polynomial over the box ``low + size (1 + y) / 2``, ``|y| <= 1``, positive on home's side.

    Attributes
    ----------
    low, size : array, shape (3,) [m]
    coefficients : array, shape (20,)
        Of the monomials of ``y``.
    error : float
        Allowance for rounding: 10 times the largest difference from the determinant at the points it was made from.
    """

    low: FloatArray
    size: FloatArray
    coefficients: FloatArray
    error: float

    def over_boxes(self, x: FloatArray, half: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return two parallel planes that hold the polynomial between them in boxes, and their slopes.

        Parameters
        ----------
        x, half : array, shape (N, 3) [m]
            Centres and half edges.

        Returns
        -------
        low, high : array, shape (N,)
            Heights of the planes at the centres: value at the centre less and plus all terms above the first order.
        slopes : array, shape (N, 3)
            Change of the planes over a half edge.
        """
        y, e = 2.0 * (x - self.low) / self.size - 1.0, 2.0 * half / self.size
        powers = np.stack([y**n for n in range(4)])
        terms = {}
        for about in EXPONENTS:
            # Taylor's coefficient about y: sum over a >= about of c_a binomial(a, about) y^(a - about)
            terms[about] = np.zeros(len(y))
            for a, c in zip(EXPONENTS, self.coefficients, strict=True):
                if all(i >= j for i, j in zip(a, about, strict=True)):
                    factor = c * np.prod([comb(i, j) for i, j in zip(a, about, strict=True)])
                    terms[about] += factor * np.prod([powers[a[k] - about[k], :, k] for k in range(3)], axis=0)
            terms[about] *= np.prod([e[:, k] ** about[k] for k in range(3)], axis=0)
        rest = sum((np.abs(terms[a]) for a in EXPONENTS if sum(a) > 1), np.zeros(len(y))) + self.error
        value = terms[0, 0, 0]
        slopes = np.abs(np.stack([terms[1, 0, 0], terms[0, 1, 0], terms[0, 0, 1]], axis=1))
        return value - rest, value + rest, slopes


def _determinant(hexapod: Hexapod, poses: FloatArray) -> FloatArray:
    """Return the determinant of the dimensionless Jacobian times the product of the lengths over the machine's size."""
    made = constants(hexapod)
    L, J = rates(hexapod, poses)
    scaled = dimensionless(at_centre(J, poses, made.centre), made.radius)
    return np.asarray(np.linalg.det(scaled) * (L / made.size).prod(axis=1))


def singular_surface(
    hexapod: Hexapod, points: FloatArray, poses: FloatArray, low: FloatArray, size: FloatArray
) -> SingularSurface:
    """Return the polynomial that meets the determinant at points (N, 3) of a box and their poses (N, 4, 4)."""
    y = 2.0 * (points - low) / size - 1.0
    monomials = np.stack([np.prod([y[:, k] ** a[k] for k in range(3)], axis=0) for a in EXPONENTS], axis=1)
    values = _determinant(hexapod, poses) * np.sign(_determinant(hexapod, np.array(hexapod.home)[None])[0])
    met = np.isfinite(values)  # a leg of length 0 has no direction
    coefficients = np.linalg.lstsq(monomials[met], values[met], rcond=None)[0]
    error = ROUNDING_SAFETY * float(np.abs(monomials @ coefficients - values)[met].max())
    return SingularSurface(low, size, coefficients, error)


def nodes() -> npt.NDArray[np.float64]:
    """Return 125 points of the cube [0, 1]^3, Chebyshev's along each axis: more than degree 3 needs."""
    along = 0.5 - 0.5 * np.cos(np.pi * (np.arange(5) + 0.5) / 5.0)
    return np.array(list(product(along, repeat=3)))
