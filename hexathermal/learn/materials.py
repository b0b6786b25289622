"""The physical check of a law: effective expansion against materials, and warnings where the model is doubtful.

Expansion and conductivity near room temperature: engineering values as handbooks give them, rounded outwards; Invar's
range is the paper's. They decide no fit; they only tell whether a result is plausible.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hexathermal.errors import UnknownNameError
from hexathermal.learn.coverage import TWO_SIDED
from hexathermal.learn.law import IdentifiedLaw
from hexathermal.poses import FloatArray

LOW_CONDUCTIVITY = 5.0
"""Below this [W/m/K], heat is not spread by conduction within a run: the paper's model presumes that it is."""

HIGH_EXPANSION = 30e-6
"""Above this [1/K]: polymers; the paper's model was proved on metals only."""

FAR_FROM_LINEAR = 0.5
"""Temperatures along a leg whose deviation from a line exceeds this part of them are no low-order gradient."""


@dataclass(frozen=True)
class Material:
    """Range of expansion [1/K] and conductivity [W/m/K]."""

    expansion: tuple[float, float]
    conductivity: float


MATERIALS = {
    "invar": Material((1.2e-6, 2.0e-6), 10.0),
    "super-invar": Material((0.0, 1.0e-6), 10.0),
    "titanium": Material((8.0e-6, 9.5e-6), 7.0),
    "cast-iron": Material((9.5e-6, 12.0e-6), 50.0),
    "steel": Material((10.5e-6, 13.0e-6), 45.0),
    "stainless-steel": Material((9.5e-6, 17.5e-6), 16.0),
    "brass": Material((18.0e-6, 21.0e-6), 110.0),
    "aluminium": Material((22.0e-6, 24.5e-6), 150.0),
    "granite": Material((4.0e-6, 9.0e-6), 3.0),
    "carbon-fibre": Material((-1.0e-6, 3.0e-6), 4.0),
    "polymer": Material((30.0e-6, 200.0e-6), 0.3),
}


@dataclass(frozen=True)
class PhysicalCheck:
    """What the coefficients mean for a leg warming evenly.

    Attributes
    ----------
    expansion, expansion_uncertainty : float [1/K]
        Of the fixed part: the sum of the A (paper: 1.99e-6, Invar).
    rod, rod_uncertainty : float [1/K]
        Of the sliding part less that of its scale: the sum of the B.
    like : tuple of str
        Materials whose range holds the expansion within its 95 % interval.
    warnings : tuple of str
    """

    expansion: float
    expansion_uncertainty: float
    rod: float
    rod_uncertainty: float
    like: tuple[str, ...]
    warnings: tuple[str, ...]


def physical_check(law: IdentifiedLaw, material: str | None = None) -> PhysicalCheck | None:
    """Return the physical check of a leg's law; None for a component, whose C is no expansion.

    Parameters
    ----------
    law : IdentifiedLaw
    material : str, optional
        Material of the fixed part, a name in `MATERIALS`.

    Raises
    ------
    UnknownNameError
        There is no such material.
    """
    if material is not None and material not in MATERIALS:
        known = tuple(MATERIALS)
        raise UnknownNameError(f"unknown material {material!r}; known: {', '.join(known)}", known)
    if law.kind != "leg":
        return None
    k = len(law.sensors)
    A, B = float(law.A.sum()), float(law.B.sum())
    u_A = float(np.sqrt(max(law.covariance[:k, :k].sum(), 0.0)))
    u_B = float(np.sqrt(max(law.covariance[k:, k:].sum(), 0.0)))

    def fits(one: Material) -> bool:
        return one.expansion[0] <= A + TWO_SIDED * u_A and A - TWO_SIDED * u_A <= one.expansion[1]

    like = tuple(name for name, one in MATERIALS.items() if fits(one))
    said = f"effective expansion A = {A * 1e6:.2f} +- {TWO_SIDED * u_A * 1e6:.2f} um/m/K (95 %)"
    warnings = []
    if material is not None:
        one = MATERIALS[material]
        if not fits(one):
            low, high = (bound * 1e6 for bound in one.expansion)
            warnings.append(
                f"{said} lies outside {material}'s {low:g} to {high:g}: the sensor does not see the leg's mean "
                "temperature, another part expands too, or the units of q0 or of the beams are wrong"
            )
        if one.conductivity < LOW_CONDUCTIVITY:
            warnings.append(
                f"{material} conducts {one.conductivity:g} W/m/K, below {LOW_CONDUCTIVITY:g}: the model presumes that "
                "conduction spreads the heat; expect errors while temperatures change"
            )
    elif not like:
        warnings.append(f"{said} is that of no common material: check the units, the sensors and q0")
    if max(abs(A), abs(B)) > HIGH_EXPANSION:
        warnings.append(
            f"an expansion above {HIGH_EXPANSION * 1e6:g} um/m/K ({max(abs(A), abs(B)) * 1e6:.1f}): the model was "
            "proved on metals only; high expansion may require another model"
        )
    if A < -TWO_SIDED * u_A:
        warnings.append(f"{said}: a leg that shrinks when it warms; check the sign of the drift and of the beams")
    return PhysicalCheck(A, u_A, B, u_B, like, tuple(warnings))


def profile_warning(positions: FloatArray, profiles: FloatArray) -> str:
    """Return a warning where temperatures along a leg are far from a line; empty where they are not.

    Parameters
    ----------
    positions : array, shape (s,) [m]
        Of the sensors along the leg.
    profiles : array, shape (n, s) [K]
        Temperatures less their zero.
    """
    if len(positions) < 4 or not len(profiles):
        return ""
    X = np.column_stack([np.ones(len(positions)), positions])
    off = profiles.T - X @ np.linalg.lstsq(X, profiles.T, rcond=None)[0]
    part = float(np.sqrt((off**2).mean() / max(float((profiles**2).mean()), 1e-12)))
    if part <= FAR_FROM_LINEAR:
        return ""
    return (
        f"temperatures along the leg deviate from a line by {100.0 * part:.0f} % of themselves: low conductivity or a "
        "local source of heat; one or two sensors may not see the leg's mean temperature"
    )
