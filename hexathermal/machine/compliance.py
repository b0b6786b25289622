"""Legs that give way under the weight of a payload: stiffnesses and the load, not the equations.

A leg that carries the axial force ``F`` (compression positive) is ``c F`` shorter than without it.  Which force each
leg carries depends on the pose; the static balance stands in `hexathermal.kinematics.statics`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from hexathermal.errors import ArgumentError
from hexathermal.machine.thermal import frozen, refreeze
from hexathermal.poses import FloatArray, as_array, finite_array

STANDARD_GRAVITY = (0.0, 0.0, -9.80665)
"""Acceleration of free fall in a base frame that stands upright [m/s^2]."""

LARGEST_COMPLIANCE = 1e-4
"""Compliance above which a unit is taken for wrong [m/N]: 100 um/N is a rubber mount, legs stay below 0.1 um/N."""

LARGEST_GRAVITY = 1e3
"""Acceleration above which a unit is taken for wrong [m/s^2]."""

LARGEST_MASS = 1e6
"""Payload above which a unit is taken for wrong [kg]."""


@dataclass(frozen=True, eq=False, init=False)
class Compliance:
    """Compliance of six legs and the payload that presses on them.

    ``sag_i = -c_i F_i`` with ``J^T F = -[m g, (R r) x m g]``: only the payload counts, which is what the platform
    carries beyond what lay on it when the machine was calibrated. Weights of platform and legs were there already.

    Parameters
    ----------
    leg_compliance : float or array, shape (6,) [m/N]
        One for all legs, or six; 0 or more.
    payload_mass : float [kg]
        Below 0 where something was taken off since the calibration.
    payload_centre : array, shape (3,) [m]
        Centre of mass in the platform frame.
    gravity : array, shape (3,) [m/s^2]
        In the base frame; a machine that hangs or leans has another than the default.
    leg_compliance_std : float or array, shape (6,) [m/N], optional
    payload_mass_std : float [kg], optional
    payload_centre_std : array, shape (3,) [m], optional
        Standard uncertainties; where there is none, a budget counts an engineering value.

    Raises
    ------
    ArgumentError
        Wrong shape, not finite, below 0, or so large that a unit must be wrong.

    Examples
    --------
    >>> soft = Compliance(2e-8, 40.0, [0.0, 0.0, 0.12])
    >>> soft.leg_compliance.shape, soft.weight.round(3).tolist()
    ((6,), [0.0, 0.0, -392.266])
    """

    leg_compliance: FloatArray
    payload_mass: float
    payload_centre: FloatArray
    gravity: FloatArray
    leg_compliance_std: FloatArray | None
    payload_mass_std: float | None
    payload_centre_std: FloatArray | None

    def __init__(
        self,
        leg_compliance: npt.ArrayLike,
        payload_mass: float,
        payload_centre: npt.ArrayLike = (0.0, 0.0, 0.0),
        gravity: npt.ArrayLike = STANDARD_GRAVITY,
        leg_compliance_std: npt.ArrayLike | None = None,
        payload_mass_std: float | None = None,
        payload_centre_std: npt.ArrayLike | None = None,
    ) -> None:
        set_ = object.__setattr__
        set_(self, "leg_compliance", _compliances(leg_compliance, "leg_compliance"))
        set_(self, "payload_mass", _number(payload_mass, "payload_mass", LARGEST_MASS, "kg"))
        set_(self, "payload_centre", vector(payload_centre, "payload_centre"))
        set_(self, "gravity", vector(gravity, "gravity"))
        if np.abs(self.gravity).max() > LARGEST_GRAVITY:
            raise ArgumentError(f"gravity is {self.gravity.tolist()}, above {LARGEST_GRAVITY:g}; m/s^2 are meant")
        soft = leg_compliance_std
        known = None if soft is None else _compliances(soft, "leg_compliance_std")
        set_(self, "leg_compliance_std", known)
        mass = payload_mass_std
        set_(self, "payload_mass_std", None if mass is None else _number(mass, "payload_mass_std", LARGEST_MASS, "kg"))
        if self.payload_mass_std is not None and self.payload_mass_std < 0.0:
            raise ArgumentError(f"payload_mass_std must be 0 or more, found {self.payload_mass_std:g} kg")
        spread = None if payload_centre_std is None else vector(payload_centre_std, "payload_centre_std")
        if spread is not None and (spread < 0.0).any():
            raise ArgumentError(f"payload_centre_std must be 0 or more, found {spread.tolist()}")
        set_(self, "payload_centre_std", spread)

    @property
    def weight(self) -> FloatArray:
        """Force of gravity on the payload, base axes, shape (3,) [N]."""
        return np.asarray(self.payload_mass * self.gravity)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Compliance):
            return NotImplemented
        return all(same_value(getattr(self, name), getattr(other, name)) for name in self.__dataclass_fields__)

    __hash__ = None  # type: ignore[assignment]

    def __setstate__(self, state: dict[str, Any]) -> None:
        refreeze(self, state)


def same_value(a: Any, b: Any) -> bool:
    """Whether two fields, arrays or not, hold the same."""
    if isinstance(a, np.ndarray) or isinstance(b, np.ndarray):
        return a is not None and b is not None and np.array_equal(a, b)
    return bool(a == b)


def vector(values: npt.ArrayLike, what: str) -> FloatArray:
    """Return a checked vector of three, read-only."""
    array = finite_array(values, (3,), what)
    if array.shape != (3,):
        raise ArgumentError(f"{what} has shape {array.shape}; expected (3,)")
    return frozen(array)


def _compliances(values: npt.ArrayLike, what: str) -> FloatArray:
    """Return six checked compliances, from one for all or six."""
    array = as_array(values, what)
    if array.shape not in ((), (1,), (6,)):
        raise ArgumentError(f"{what} has shape {array.shape}; expected one value for all legs, or six")
    array = finite_array(array, (), what)
    if (array < 0.0).any() or (array > LARGEST_COMPLIANCE).any():
        odd = array.min() if (array < 0.0).any() else array.max()
        raise ArgumentError(
            f"{what} holds {odd:g} m/N; it must lie in [0, {LARGEST_COMPLIANCE:g}]: a leg gives way to its load; were "
            "um/N given?"
        )
    return frozen(np.broadcast_to(array, (6,)))


def _number(value: float, what: str, largest: float, unit: str) -> float:
    """Return one checked number."""
    array = finite_array(value, (), what)
    if array.shape != () or abs(float(array)) > largest:
        raise ArgumentError(f"{what} must be one number up to {largest:g} {unit}, found {value!r}")
    return float(array)
