"""The error budget of a pose on a warm machine: labelled sources -> 6-D covariance, bias, sorted contributions (GUM).

The error of a point of the platform is reached minus wanted: its shift, and the rotation vector of the platform, both
in the axes of one frame.  Sources move true lengths and joints; the error follows by exact forward kinematics, and its
derivative implicitly: ``J dx = dl - u . R dp + u . db`` (`hexathermal.predict.budget_inputs`).
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, Unpack

import numpy as np
import numpy.typing as npt

from hexathermal.errors import ArgumentError, UnknownNameError
from hexathermal.kinematics.inverse import inverse_kinematics
from hexathermal.machine.hexapod import Hexapod
from hexathermal.machine.shown import Shown
from hexathermal.machine.thermal import TemperaturesLike, frozen, refreeze
from hexathermal.poses import FloatArray, PoseLike, finite_array
from hexathermal.predict.budget_causes import bias_causes
from hexathermal.predict.budget_defaults import default_sources
from hexathermal.predict.budget_gum import (
    Contribution,
    checked_probability,
    contributed,
    coverage_factor,
    effective_dof,
    joint_dof,
    region_factor,
    total,
)
from hexathermal.predict.budget_inputs import Situation, View, situation
from hexathermal.predict.budget_plates import Plates
from hexathermal.predict.sources import Source, Sources

AXES = ("x", "y", "z", "rx", "ry", "rz")
UNITS = ("m", "m", "m", "rad", "rad", "rad")


@dataclass(frozen=True, eq=False, repr=False)
class Budget(Shown):
    """An error budget: bias, covariance, contributions.  Errors are ``[x, y, z, rx, ry, rz]``, m and rad.

    Attributes
    ----------
    machine : str
    frame : str
        ``"machine"``, ``"user"`` or ``"object"``: the axes of all vectors here.
    point : array, shape (3,) [m]
        The point that errors are told of, from the platform's origin in platform axes.
    pose : array, shape (4, 4) [m]
        Wanted pose.
    temps : array, shape (n,) [degC]
    corrected : bool
        Whether corrected lengths were commanded.
    uncorrected : array, shape (6,)
        Expected error with nominal lengths: the drift.
    remaining : array, shape (6,)
        Expected error with the lengths that were commanded; plates without thermometers leave one.
    causes : tuple of str
        Of `remaining`: plates that no thermometer corrects, gradients across plates; without correction the legs too.
    cause_parts : array, shape (causes, 6)
        Part of `remaining` that each cause makes up.
    covariance : array, shape (6, 6) [m^2, m rad, rad^2]
        About `remaining`.
    contributions : tuple of Contribution
        Largest first, by their mean share of the six variances; their covariances add up to `covariance`.
    dof : array, shape (6,)
        Effective degrees of freedom of each axis (Welch-Satterthwaite, `effective_dof`).
    joint_dof : float
        Of the six together (`joint_dof`).
    """

    machine: str
    frame: str
    point: FloatArray
    pose: FloatArray
    temps: FloatArray
    corrected: bool
    uncorrected: FloatArray
    remaining: FloatArray
    causes: tuple[str, ...]
    cause_parts: FloatArray
    covariance: FloatArray
    contributions: tuple[Contribution, ...]
    dof: FloatArray
    joint_dof: float

    @property
    def removed(self) -> FloatArray:
        """What correction takes away: ``uncorrected - remaining``, shape (6,)."""
        return self.uncorrected - self.remaining

    @property
    def uncertainty(self) -> FloatArray:
        """Combined standard uncertainty of each axis, shape (6,)."""
        return np.asarray(np.sqrt(np.diag(self.covariance)))

    @property
    def shares(self) -> FloatArray:
        """Part of each axis' variance that each contribution makes up, shape (sources, 6); columns sum to 1."""
        variances = np.array([np.diag(item.covariance) for item in self.contributions]).reshape(-1, 6)
        whole = np.diag(self.covariance)
        return np.asarray(np.divide(variances, whole, out=np.zeros_like(variances), where=whole > 0.0))

    def expanded(self, probability: float = 0.95) -> FloatArray:
        """Return the expanded uncertainty ``U = t_p(nu) u`` of each axis, shape (6,)."""
        return np.asarray(coverage_factor(self.dof, probability) * self.uncertainty)

    def worst_case(self, probability: float = 0.95) -> FloatArray:
        """Return ``|remaining| + U``, shape (6,): how far off each axis may be."""
        return np.asarray(np.abs(self.remaining) + self.expanded(probability))

    def largest(self, axis: str) -> Contribution:
        """Return the contribution that weighs most in one axis.

        Raises
        ------
        UnknownNameError
            The axis is none of x, y, z, rx, ry, rz.
        ArgumentError
            The budget has no sources.
        """
        if axis not in AXES:
            raise UnknownNameError(f"axis {axis!r} is not known; choose from {', '.join(AXES)}", AXES)
        if not self.contributions:
            raise ArgumentError("the budget has no sources: nothing contributes")
        return max(self.contributions, key=lambda item: item.covariance[AXES.index(axis), AXES.index(axis)])

    def region_factor(self, probability: float = 0.95) -> float | None:
        """Return ``k_p`` of the 6-D region ``e^T V^-1 e <= k_p^2`` with ``e = error - remaining``.

        None where `joint_dof` is too small for a region of six numbers.
        """
        checked_probability(probability)
        try:
            return region_factor(6, self.joint_dof, probability)
        except ArgumentError:
            return None

    def region_note(self, probability: float = 0.95) -> str:
        """Return why there is no 6-D region; empty where there is one."""
        if self.region_factor(probability) is not None:
            return ""
        return (
            f"no 6-D region: {self.joint_dof:.3g} effective degrees of freedom, clearly more than 5 are needed; give "
            "sources more data"
        )

    def inside(self, errors: npt.ArrayLike, probability: float = 0.95) -> npt.NDArray[np.bool_]:
        """Return whether errors (..., 6) lie inside the 6-D region of a probability.

        Raises
        ------
        ArgumentError
            Wrong shape; the covariance is singular: the region has no volume; or too few degrees of freedom.
        """
        e = finite_array(errors, (6,), "errors") - self.remaining
        scale = self.uncertainty
        if not (scale > 0.0).all() or np.linalg.cond(self.covariance / np.outer(scale, scale)) > 1e13:
            raise ArgumentError("the covariance is singular: some combination of axes has no uncertainty, no region")
        root = np.linalg.cholesky(self.covariance / np.outer(scale, scale))
        z = np.linalg.solve(root, (e / scale).reshape(-1, 6).T)
        return np.asarray(
            (z**2).sum(axis=0).reshape(e.shape[:-1]) <= region_factor(6, self.joint_dof, probability) ** 2
        )

    def as_dict(self, probability: float = 0.95) -> dict[str, Any]:
        """Return the budget as plain values: um and urad, as their names say; null where a number is infinite."""
        scale = np.full(6, 1e6)
        shares = self.shares
        return {
            "format": "hexathermal-budget/1",
            "machine": self.machine,
            "frame": self.frame,
            "point_from_platform_origin_mm": (self.point * 1e3).tolist(),
            "pose": self.pose.tolist(),
            "temperatures_degC": self.temps.tolist(),
            "corrected": self.corrected,
            "axes": list(AXES),
            "units": ["um", "um", "um", "urad", "urad", "urad"],
            "bias_uncorrected": (self.uncorrected * scale).tolist(),
            "bias_removed": (self.removed * scale).tolist(),
            "bias_remaining": (self.remaining * scale).tolist(),
            "bias_remaining_causes": {
                name: (part * scale).tolist() for name, part in zip(self.causes, self.cause_parts, strict=True)
            },
            "standard_uncertainty": (self.uncertainty * scale).tolist(),
            "covariance": (self.covariance * np.outer(scale, scale)).tolist(),
            "effective_dof": [_finite(value) for value in self.dof],
            "probability": float(probability),
            "expanded_uncertainty": (self.expanded(probability) * scale).tolist(),
            "worst_case": (self.worst_case(probability) * scale).tolist(),
            "region_factor": self.region_factor(probability),
            "region_note": self.region_note(probability),
            "region_dof": _finite(self.joint_dof),
            "contributions": [
                {
                    "label": item.label,
                    "quantity": item.quantity,
                    "standard_uncertainty": item.standard,
                    "unit": item.unit,
                    "distribution": item.distribution,
                    "correlation": item.correlation,
                    "dof": _finite(item.dof),
                    "uncertainty": (item.uncertainty * scale).tolist(),
                    "share": shares[k].tolist(),
                    "basis": item.basis,
                }
                for k, item in enumerate(self.contributions)
            ],
        }

    def __repr__(self) -> str:
        def line(name: str, values: FloatArray) -> str:
            return f"  {name:<22}" + "".join(f"{value * 1e6:>10.3f}" for value in values)

        place = ", ".join(f"{value * 1e3:g}" for value in self.point)
        lines = [
            f"Budget of {self.machine or '(no name)'} · {self.frame} frame, point ({place}) mm from platform's origin",
            f"  {'um, urad':<22}" + "".join(f"{axis:>10}" for axis in AXES),
            line("drift, uncorrected", self.uncorrected),
            line("bias that remains", self.remaining),
            line("standard uncertainty", self.uncertainty),
            line("expanded (95 %)", self.expanded()),
            *(line(f"  {item.label}", item.uncertainty) for item in self.contributions),
        ]
        return "\n".join(lines)

    def __setstate__(self, state: dict[str, Any]) -> None:
        refreeze(self, state)


def _finite(value: float) -> float | None:
    """Return a number, or None where it is infinite."""
    return float(value) if np.isfinite(value) else None


def error_budget(
    hexapod: Hexapod,
    pose: PoseLike,
    temps: TemperaturesLike,
    sources: Iterable[Source] | None = None,
    **view: Unpack[View],
) -> Budget:
    """Return how far off a warm machine stands at a pose, which cause weighs most, and what correction leaves.

    Parameters
    ----------
    hexapod : Hexapod
    pose : SE3 or array, shape (4, 4) [m]
        Wanted pose, platform in base.
    temps : array, shape (n,) [degC], or mapping of sensor name to value
    sources : Sources or Source values, optional
        Default: `default_sources`.
    correction : bool
        Whether corrected lengths are commanded; False: nominal ones.
    frame : str
        Axes of the errors: ``"machine"`` (base), ``"user"`` or ``"object"`` of `frames`.
    frames : Frames, optional
    at_tool : array, shape (3,) [m], optional
        The point, from the platform's origin in platform axes. Default: the object frame's origin. The tool itself does
        not expand.
    plates : Plates, optional
        Temperatures of plates without thermometers, and gradients.
    air_degC : float, optional
        Air about the sensors (for their contact). Default: the reference temperature.

    Returns
    -------
    Budget

    Raises
    ------
    ThermalModelError
        The machine has no thermal law, or none for a plate that is said to be warm.
    SingularPoseError, OutOfStrokeError, JointConeError
        The pose cannot be held, or its lengths cannot be commanded.
    NotConvergedError
        The drift is too large for the branch of the pose to be certain.
    TemperatureError, ArgumentError, UnknownNameError
        As the arguments' own checks say.

    Examples
    --------
    >>> import hexathermal as ht
    >>> hexapod = ht.load_hexapod("reference")
    >>> budget = hexapod.error_budget(hexapod.home, [25.0] * 6)
    >>> bool(abs(budget.remaining[2]) < abs(budget.uncorrected[2]))
    True
    >>> bool(abs(budget.shares.sum(axis=0) - 1.0).max() < 1e-12)              # contributions add up
    True
    """
    return budget_of(situation(hexapod, pose, temps, **view), checked_sources(hexapod, sources, view.get("plates")))


def checked_sources(hexapod: Hexapod, sources: Iterable[Source] | None, plates: Plates | None = None) -> Sources:
    """Return the sources of a budget: those given, or the machine's default ones for plates as they are stated."""
    if sources is None:
        return default_sources(hexapod, plates)
    if isinstance(sources, Sources):
        return sources
    if isinstance(sources, Source) or not isinstance(sources, Iterable):
        raise ArgumentError(f"sources must be Sources or several Source values, found {type(sources).__name__}")
    return Sources(tuple(sources))


def budget_of(here: Situation, sources: Sources) -> Budget:
    """Return the budget of a situation."""
    rates = here.rates()
    parts = [_contribution(here, source, rates) for source in sources]
    covariance = total(parts, 6)
    whole = np.diag(covariance)
    weight = [np.divide(np.diag(item.covariance), whole, out=np.zeros(6), where=whole > 0.0).sum() for item in parts]
    ordered = tuple(parts[k] for k in sorted(range(len(parts)), key=lambda k: -weight[k]))
    remaining = here.errors()[0]
    nominal = inverse_kinematics(here.hexapod, here.pose)
    drift = here.errors(told=nominal)[0] if here.correction else remaining
    return Budget(
        here.hexapod.name, here.frame, frozen(here.arm), frozen(here.pose), frozen(here.temps), here.correction,
        frozen(drift), frozen(remaining), *bias_causes(here), frozen(covariance), ordered,
        frozen(effective_dof(parts, 6)), joint_dof(parts, 6),
    )  # fmt: skip


def _contribution(here: Situation, source: Source, rates: FloatArray) -> Contribution:
    """Return what one source adds."""
    factors, together = here.factors(source)
    correlation = source.correlation if isinstance(source.correlation, str) else "matrix"
    return contributed(
        rates @ factors, source.dof, together, label=source.label, quantity=source.quantity,
        standard=float(source.standard.max()), unit=source.unit, distribution=source.distribution,
        correlation=correlation, basis=source.basis,
    )  # fmt: skip
