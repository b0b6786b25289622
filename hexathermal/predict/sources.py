"""Sources of uncertainty: labelled values with standard uncertainty, distribution, degrees of freedom and correlation.

A source says how far one *quantity* of the machine may be off (`QUANTITIES`).  A quantity is a block of numbers, made
of groups (legs, sensors, plates) of equal width; a source is common to all groups, independent from group to group, or
correlated as a matrix says.  Sources are independent of each other.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Any

import numpy as np
import numpy.typing as npt

from hexathermal.errors import ArgumentError, UnknownNameError
from hexathermal.machine.thermal import frozen, refreeze
from hexathermal.poses import FloatArray, as_array, finite_array

DISTRIBUTIONS: Mapping[str, str] = MappingProxyType(
    {
        "normal": "normal",
        "gaussian": "normal",
        "uniform": "uniform",
        "rectangular": "uniform",
        "triangular": "triangular",
        "arcsine": "arcsine",
        "u-shaped": "arcsine",
        "t": "t",
    }
)
"""Accepted names -> the five distributions."""

HALF_WIDTH: Mapping[str, float] = MappingProxyType({"uniform": 3.0**0.5, "triangular": 6.0**0.5, "arcsine": 2.0**0.5})
"""Half-width over standard uncertainty of the bounded distributions."""

QUANTITIES: Mapping[str, tuple[str, str]] = MappingProxyType(
    {
        "temperature": ("K", "true minus read temperature, one for each sensor"),
        "gain": ("1", "relative error of a sensor's difference from the reference, one for each sensor"),
        "contact": ("1", "part of the difference to the air that a sensor misses, one for each sensor"),
        "coefficients": ("1/K", "error of A_1 .. A_s, B_1 .. B_s, for each leg"),
        "amplitudes": (
            "SI",
            "error of the amplitudes of the terms that extend a leg's law, in their order, for each leg",
        ),
        "growth": ("1/K", "error that A and B of a leg share, as the air's index leaves it, for each leg"),
        "length": ("m", "length of a leg, for each leg"),
        "scale": ("1", "relative error of the stroke, for each leg"),
        "base joints": ("m", "x, y, z of each base joint, base frame"),
        "platform joints": ("m", "x, y, z of each platform joint, platform frame"),
        "plate expansion": ("1/K", "expansion coefficient of platform and base"),
        "plate temperature": ("K", "temperature of platform and base, beyond their thermometers'"),
        "plate gradient": ("K/m", "x, y, z of the temperature gradient of platform and base"),
        "compliance": ("m/N", "compliance of a leg, for each leg of a machine with a payload"),
        "payload mass": ("kg", "mass of the payload"),
        "payload centre": ("m", "x, y, z of the payload's centre of mass, platform frame"),
        "reference temperature": ("K", "temperature at which the machine was calibrated, one for all"),
        "pose": ("m and rad", "x, y, z, rx, ry, rz of the point, in the frame of the budget"),
    }
)
"""What may be off: unit and meaning."""

LARGEST = 1e9
"""Standard uncertainty of any quantity, in its unit, above which squares say nothing."""

CORRELATION_TOLERANCE = 1e-9
"""Smallest eigenvalue of a correlation matrix that still counts as zero: ``-tolerance * size``."""


@dataclass(frozen=True, eq=False)
class Source:
    """One source of uncertainty.

    Parameters
    ----------
    label : str
    quantity : str
        One of `QUANTITIES`.
    standard : float or array
        Standard uncertainty in the quantity's unit: one for all, one for each number of a group, or the whole block.
    distribution : str, optional
        ``"normal"``, ``"uniform"``, ``"triangular"``, ``"arcsine"`` or ``"t"``. Default: ``"t"`` where `dof` is finite
        (a standard deviation from few values), else ``"normal"``.
    dof : float
        Degrees of freedom of `standard`; infinite where it is known.
    correlation : str or array, shape (k, k)
        ``"independent"`` or ``"common"`` to all groups, or a correlation matrix of the whole block.
    within : array, shape (w, w), optional
        Correlation matrix of the numbers of one group, such as A and B of a leg.
    basis : str
        Where the numbers come from.

    Raises
    ------
    UnknownNameError
        Unknown quantity, distribution or correlation.
    ArgumentError
        Negative or not finite, wrong shape, a matrix that is no correlation, or one with a distribution other than
        normal or t, whose joint form is not defined.

    Examples
    --------
    >>> Source("scale", "scale", 1e-6, "uniform").unit
    '1'
    >>> Source.bounded("backlash", "length", 3e-7, "arcsine").standard.round(10).item()
    2.121e-07
    """

    label: str
    quantity: str
    standard: FloatArray
    distribution: str = ""
    dof: float = np.inf
    correlation: Any = "independent"
    within: FloatArray | None = None
    basis: str = field(default="", compare=False)

    def __init__(
        self,
        label: str,
        quantity: str,
        standard: npt.ArrayLike,
        distribution: str | None = None,
        dof: float = np.inf,
        correlation: str | npt.ArrayLike = "independent",
        within: npt.ArrayLike | None = None,
        basis: str = "",
    ) -> None:
        set_ = object.__setattr__
        if not isinstance(label, str) or not label.strip():
            raise ArgumentError(f"a source needs a label, found {label!r}")
        set_(self, "label", label)
        set_(self, "quantity", _known(quantity, dict.fromkeys(QUANTITIES, ""), f"quantity of source {label!r}"))
        values = finite_array(standard, (), f"standard uncertainty of source {label!r}")
        if (values < 0.0).any():
            raise ArgumentError(f"standard uncertainty of source {label!r} is {values.min():g}; it must be 0 or more")
        if (values > LARGEST).any():
            raise ArgumentError(
                f"standard uncertainty of source {label!r} is {values.max():g} {QUANTITIES[self.quantity][0]}, allowed "
                f"{LARGEST:g}; SI units are meant"
            )
        set_(self, "standard", frozen(values))
        if not isinstance(dof, float | int | np.number) or isinstance(dof, bool) or not dof > 0.0:
            raise ArgumentError(f"degrees of freedom of source {label!r} must be above 0 (inf: known), found {dof!r}")
        set_(self, "dof", float(dof))
        chosen = ("t" if np.isfinite(dof) else "normal") if distribution is None else distribution
        name = DISTRIBUTIONS[_known(chosen, DISTRIBUTIONS, f"distribution of source {label!r}")]
        if name == "t" and not np.isfinite(dof):
            raise ArgumentError(f"source {label!r} is distributed as t: give its degrees of freedom (dof)")
        set_(self, "distribution", name)
        set_(self, "within", None if within is None else correlation_matrix(within, f"within of source {label!r}"))
        if isinstance(correlation, str):
            known = {"independent": "", "common": ""}
            set_(self, "correlation", _known(correlation, known, f"correlation of source {label!r}"))
        else:
            set_(self, "correlation", correlation_matrix(correlation, f"correlation of source {label!r}"))
        if self.joint and name not in ("normal", "t"):
            raise ArgumentError(
                f"source {label!r} has a correlation matrix and a {name} distribution: their joint form is not "
                "defined; use 'normal' or 't', or make it 'common' or 'independent'"
            )
        set_(self, "basis", str(basis))

    @classmethod
    def bounded(
        cls, label: str, quantity: str, half_width: npt.ArrayLike, distribution: str = "uniform", **rest: Any
    ) -> Source:
        """Return a source known by its half-width: uniform ``a/sqrt 3``, triangular ``a/sqrt 6``, arcsine ``a/sqrt 2``.

        Further arguments are those of `Source`.
        """
        name = DISTRIBUTIONS[_known(distribution, DISTRIBUTIONS, f"distribution of source {label!r}")]
        if name not in HALF_WIDTH:
            raise ArgumentError(f"a {name} distribution has no half-width; choose {', '.join(HALF_WIDTH)}")
        a = as_array(half_width, f"half-width of source {label!r}")
        return cls(label, quantity, a / HALF_WIDTH[name], name, **rest)

    @property
    def unit(self) -> str:
        """Unit of the standard uncertainty."""
        return QUANTITIES[self.quantity][0]

    @property
    def joint(self) -> bool:
        """Whether numbers of the block are correlated by a matrix."""
        return self.within is not None or not isinstance(self.correlation, str)

    def factors(self, groups: int, width: int) -> FloatArray:
        """Return ``S`` (k, r) with covariance ``S S^T``: each column is moved by one variable of its own.

        Parameters
        ----------
        groups, width : int
            Of the quantity's block on a machine, ``k = groups * width``.
        """
        k = groups * width
        try:
            shape = self.standard.shape
            whole = self.standard.reshape(groups, width) if shape == (k,) and k != width else self.standard
            scale = np.broadcast_to(whole, (groups, width)).reshape(k)
        except ValueError:
            raise ArgumentError(
                f"standard uncertainty of source {self.label!r} has shape {self.standard.shape}; {self.quantity!r} "
                f"takes one value, {width} for each group, or ({groups}, {width}) on this machine"
            ) from None
        if not isinstance(self.correlation, str):
            if self.correlation.shape != (k, k):
                raise ArgumentError(
                    f"correlation of source {self.label!r} has shape {self.correlation.shape}; {self.quantity!r} has "
                    f"{k} numbers on this machine: ({k}, {k})"
                )
            return np.asarray(scale[:, None] * root(self.correlation))
        inner = np.eye(width) if self.within is None else root(self.within)
        if inner.shape != (width, width):
            raise ArgumentError(
                f"within of source {self.label!r} has shape {inner.shape}; a group of {self.quantity!r} has {width} "
                "numbers on this machine"
            )
        outer = np.ones((groups, 1)) if self.correlation == "common" else np.eye(groups)
        return np.asarray(scale[:, None] * np.kron(outer, inner))

    def __setstate__(self, state: dict[str, Any]) -> None:
        refreeze(self, state)


def root(matrix: FloatArray) -> FloatArray:
    """Return ``S`` with ``S S^T`` a positive semidefinite matrix."""
    values, vectors = np.linalg.eigh(matrix)
    return np.asarray(vectors * np.sqrt(np.clip(values, 0.0, None)))


def correlation_matrix(given: npt.ArrayLike, what: str) -> FloatArray:
    """Return a checked correlation matrix: symmetric, ones on the diagonal, no negative eigenvalue."""
    matrix = finite_array(given, (), what)
    if matrix.ndim != 2 or matrix.shape[0] != matrix.shape[1]:
        raise ArgumentError(f"{what} has shape {matrix.shape}; expected a square matrix")
    if not np.allclose(matrix, matrix.T, rtol=0.0, atol=1e-12):
        raise ArgumentError(f"{what} is not symmetric: largest difference {np.abs(matrix - matrix.T).max():.3g}")
    if not np.allclose(np.diag(matrix), 1.0, rtol=0.0, atol=1e-9):
        raise ArgumentError(
            f"{what} must have ones on its diagonal, found {np.diag(matrix).tolist()}; standard uncertainties are "
            "given apart from it"
        )
    lowest = float(np.linalg.eigvalsh(matrix)[0])
    if lowest < -CORRELATION_TOLERANCE * len(matrix):
        raise ArgumentError(
            f"{what} is not positive semidefinite: its smallest eigenvalue is {lowest:.3g}, so some combination would "
            "have a negative variance; check the signs, or that all entries come from the same data"
        )
    return frozen(matrix)


def _known(name: str, names: Mapping[str, str], what: str) -> str:
    """Return a name that is known."""
    if not isinstance(name, str) or name not in names:
        raise UnknownNameError(f"{what} is {name!r}, which is not known; choose from {', '.join(names)}", tuple(names))
    return name


@dataclass(frozen=True)
class Sources:
    """Sources of a budget, in order, each label once.

    Examples
    --------
    >>> some = Sources((Source("encoder", "length", 5e-8), Source("scale", "scale", 1e-6)))
    >>> some.without("scale").labels
    ('encoder',)
    """

    items: tuple[Source, ...]

    def __post_init__(self) -> None:
        object.__setattr__(self, "items", tuple(self.items))
        for item in self.items:
            if not isinstance(item, Source):
                raise ArgumentError(f"a budget takes Source values, found {type(item).__name__}")
        double = [label for label in self.labels if self.labels.count(label) > 1]
        if double:
            raise ArgumentError(f"two sources are called {double[0]!r}; labels must be unique")

    def __iter__(self) -> Iterator[Source]:
        return iter(self.items)

    def __len__(self) -> int:
        return len(self.items)

    def __getitem__(self, label: str) -> Source:
        self._check((label,))
        return next(item for item in self.items if item.label == label)

    @property
    def labels(self) -> tuple[str, ...]:
        """Labels in order."""
        return tuple(item.label for item in self.items)

    def without(self, *labels: str) -> Sources:
        """Return all sources but these."""
        self._check(labels)
        return Sources(tuple(item for item in self.items if item.label not in labels))

    def only(self, *labels: str) -> Sources:
        """Return these sources alone."""
        self._check(labels)
        return Sources(tuple(item for item in self.items if item.label in labels))

    def plus(self, *sources: Source) -> Sources:
        """Return all sources and new ones."""
        return Sources((*self.items, *sources))

    def changed(self, label: str, **fields: Any) -> Sources:
        """Return all sources, one of them with other fields (those of `Source`)."""
        old = self[label]
        unknown = [name for name in fields if name not in Source.__dataclass_fields__]
        if unknown:
            known = tuple(Source.__dataclass_fields__)
            raise UnknownNameError(f"a source has no field {unknown[0]!r}; it has {', '.join(known)}", known)
        new = replace(old, **fields)
        return Sources(tuple(new if item is old else item for item in self.items))

    def _check(self, labels: Iterable[str]) -> None:
        """Refuse labels that no source has."""
        for label in labels:
            _known(label, dict.fromkeys(self.labels, ""), "label of a source")
