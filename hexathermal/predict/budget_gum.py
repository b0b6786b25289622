"""The arithmetic of the GUM on vectors: law of propagation, contributions, degrees of freedom, coverage.

``y = f(x)``, ``V = sum_s (C S_s)(C S_s)^T`` with the sensitivities ``C = dy/dx`` and the factors ``S_s`` of each
source (GUM 5.2.2 for several results, JCGM 102).  Sources are independent of each other.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from hexathermal.errors import ArgumentError
from hexathermal.machine.thermal import frozen, refreeze
from hexathermal.poses import FloatArray

LARGEST_FACTOR = 1e4
"""A region that many standard uncertainties wide says nothing."""


@dataclass(frozen=True, eq=False)
class Contribution:
    """What one source adds to the covariance of a result of m numbers.

    Attributes
    ----------
    label, quantity, distribution, correlation, basis : str
    standard : float
        Largest standard uncertainty of the source's numbers, in `unit`.
    unit : str
    dof : float
    covariance : array, shape (m, m)
    columns : array, shape (m, r)
        What one standard uncertainty of each of the source's own variables moves.
    together : bool
        Whether those variables count as one component with `dof` degrees of freedom.
    """

    label: str
    quantity: str
    standard: float
    unit: str
    distribution: str
    correlation: str
    dof: float
    covariance: FloatArray
    columns: FloatArray
    together: bool
    basis: str = ""

    @property
    def uncertainty(self) -> FloatArray:
        """Standard uncertainty that the source gives each result, shape (m,)."""
        return np.asarray(np.sqrt(np.diag(self.covariance)))

    @property
    def fourth(self) -> FloatArray:
        """``sum_j u_j(y)^4 / nu``: the source's part of the Welch-Satterthwaite sum, shape (m,)."""
        return fourth_powers(self.columns, self.dof, self.together)

    @property
    def largest_single(self) -> FloatArray:
        """Variance that the source's largest own variable gives each result, shape (m,)."""
        return np.asarray((self.columns**2).max(axis=1, initial=0.0))

    def __setstate__(self, state: dict[str, Any]) -> None:
        refreeze(self, state)


def contributed(rates: FloatArray, dof: float, together: bool, **told: Any) -> Contribution:
    """Return the contribution of a source whose own variables move the result at `rates` (m, r).

    Parameters
    ----------
    together : bool
        The variables stem from one set of data (a correlation matrix): they count as one component with `dof`.
        Otherwise each variable is a component of its own.
    """
    return Contribution(
        dof=dof, covariance=frozen(rates @ rates.T), columns=frozen(np.array(rates)), together=together, **told
    )


def fourth_powers(columns: FloatArray, dof: float, together: bool) -> FloatArray:
    """Return ``sum_j u_j(y)^4 / nu`` of variables that move results at `columns` (..., m, r), shape (..., m).

    Together they are one component, ``(sum_j u_j(y)^2)^2 / nu``.
    """
    squares = columns**2
    parts = squares.sum(axis=-1, keepdims=True) if together else squares
    return np.asarray((parts**2).sum(axis=-1) / dof)


def welch_satterthwaite(variances: FloatArray, below: FloatArray) -> FloatArray:
    """Return ``u^4 / below`` with the sum ``below`` of `fourth_powers`; infinite where nothing is estimated."""
    return np.asarray(np.divide(variances**2, below, out=np.full_like(variances, np.inf), where=below > 0.0))


def total(contributions: Sequence[Contribution], size: int) -> FloatArray:
    """Return the combined covariance (m, m): contributions add up."""
    return np.asarray(sum((item.covariance for item in contributions), np.zeros((size, size))))


def effective_dof(contributions: Sequence[Contribution], size: int) -> FloatArray:
    """Return the effective degrees of freedom of each result, shape (m,) (GUM G.4.1, Welch-Satterthwaite).

    ``nu = u^4 / sum_i (u_i^4 / nu_i)`` over independent components.  Correlated inputs break the formula's condition:
    those that a source joins by a matrix count as one component with the degrees of freedom of the data they come
    from, and those common to several legs are one variable.
    """
    u2 = np.diag(total(contributions, size))
    below = np.asarray(sum((item.fourth for item in contributions), np.zeros(size)))
    return welch_satterthwaite(u2, below)


def joint_dof(contributions: Sequence[Contribution], size: int) -> float:
    """Return the effective degrees of freedom of the whole result (Nel and van der Merwe 1986).

    ``nu = (m + m^2) / sum_i ((tr W_i^2 + (tr W_i)^2) / nu_i)`` with ``W_i = V^-1 V_i``: unchanged by the choice of
    frame and of units; the formula of one number is its case m = 1.  Components are those of `effective_dof`: each
    variable of a source, whose standard uncertainty is an estimate of its own, or all of a source that a matrix joins.
    """
    finite = [item for item in contributions if np.isfinite(item.dof)]
    V = total(contributions, size)
    scaled, scale = _scaled(V)
    rank = int(np.linalg.matrix_rank(scaled)) if V.any() else 0
    if not finite or rank == 0:
        return float("inf")
    inverse = np.asarray(np.linalg.pinv(scaled), dtype=np.float64)
    below = sum((_spread(item, inverse, scale) / item.dof for item in finite), 0.0)
    return (rank + rank**2) / below if below > 0.0 else float("inf")


def _spread(item: Contribution, inverse: FloatArray, scale: FloatArray) -> float:
    """Return ``tr W^2 + (tr W)^2``, summed over the components of a source."""
    if item.together:
        w = inverse @ (item.covariance * np.outer(scale, scale))
        return float(np.trace(w @ w)) + float(np.trace(w)) ** 2
    columns = item.columns * scale[:, None]
    # one variable: tr W = g^T V^-1 g = q and tr W^2 = q^2
    return 2.0 * float((np.einsum("ir,ij,jr->r", columns, inverse, columns) ** 2).sum())


def _scaled(V: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return a covariance with ones on its diagonal, and the scales: metres and radians made comparable."""
    u = np.sqrt(np.diag(V))
    scale = np.divide(1.0, u, out=np.zeros_like(u), where=u > 0.0)
    return np.asarray(V * np.outer(scale, scale)), np.asarray(scale)


def checked_probability(probability: float) -> float:
    """Return a coverage probability inside (0, 1)."""
    if not isinstance(probability, float | int | np.floating) or not 0.0 < probability < 1.0:
        raise ArgumentError(f"probability must lie between 0 and 1, such as 0.95, found {probability!r}")
    return float(probability)


def coverage_factor(dof: Any, probability: float = 0.95) -> FloatArray:
    """Return ``k = t_p(nu)``: the two-sided quantile of Student's t (GUM G.3.2); of the normal where `dof` is infinite.

    ``dof`` is not rounded down to a whole number.

    Examples
    --------
    >>> coverage_factor(16.0, 0.99).round(2).item(), coverage_factor(np.inf, 0.95).round(2).item()
    (2.92, 1.96)
    """
    from scipy import special

    p = 0.5 * (1.0 + checked_probability(probability))
    nu = np.asarray(dof, dtype=np.float64)
    finite = np.isfinite(nu)
    return np.asarray(np.where(finite, special.stdtrit(np.where(finite, nu, 1.0), p), special.ndtri(p)))


def region_factor(size: int, dof: float, probability: float = 0.95) -> float:
    """Return ``k_p`` of the ellipsoid ``e^T V^-1 e <= k_p^2`` of `size` results (JCGM 102, 6.5; Hotelling's T^2).

    ``k^2 = chi^2_p(m)``, or ``m nu / (nu - m + 1) F_p(m, nu - m + 1)`` for finite degrees of freedom.

    Raises
    ------
    ArgumentError
        Too few degrees of freedom: ``nu <= m - 1``, or so little above that the region is larger than `LARGEST_FACTOR`.
    """
    from scipy import special

    p = checked_probability(probability)
    if not np.isfinite(dof):
        return float(np.sqrt(special.chdtri(size, 1.0 - p)))
    left = dof - size + 1.0
    with np.errstate(over="ignore"):
        k = float(np.sqrt(size * dof / left * special.fdtri(size, left, p))) if left > 0.0 else np.inf
    if not k <= LARGEST_FACTOR:
        raise ArgumentError(
            f"{dof:.3g} effective degrees of freedom hold no region of {size} numbers: clearly more than {size - 1} "
            "are needed; give sources more data"
        )
    return k
