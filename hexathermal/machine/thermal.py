"""The thermal model of a machine: expansion laws of legs and plates, and which thermometer speaks for which part.

Leg (paper, eqs. 3, 4 and 8): ``drift = sum_s A_s q0 dT_s + B_s q dT_s``.  Plate (eq. 1): a joint at ``v`` from the
plate's origin moves to ``v (1 + alpha dT)``.  ``dT = T - T_reference``; the reference lives in the model.

This module holds the numbers; the equations themselves stand in `hexathermal.kinematics.formulas`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
import numpy.typing as npt

from hexathermal.errors import ArgumentError, ThermalModelError
from hexathermal.machine.shown import Shown
from hexathermal.machine.thermometers import AS_RECORDED, checked_thermometers, full_name, recorded_names
from hexathermal.poses import FloatArray, as_array, finite_array

if TYPE_CHECKING:
    from hexathermal.machine.leg_terms import LegTerm

TemperaturesLike: TypeAlias = npt.ArrayLike | Mapping[str, npt.ArrayLike]
"""Temperatures [degC]: an array (..., n) in the order of a machine's sensors, or a mapping of their names."""

ABSOLUTE_ZERO_DEGC = -273.15
DEFAULT_RANGE_DEGC = (-60.0, 120.0)
"""Range of a law that states none: metals with constant expansion; 20 degC given in kelvin is caught."""

LARGEST_EXPANSION_PER_K = 1e-3
"""Coefficients above this are taken for a wrong unit: metals stay below 3e-5 /K, polymers below 3e-4 /K."""


LARGEST_STRAIN = 0.2
"""Largest part of its length by which a law may change a leg or a plate within the range of validity."""


def frozen(array: FloatArray) -> FloatArray:
    """Return a read-only copy."""
    copy = np.array(array, dtype=np.float64)
    copy.setflags(write=False)
    return copy


def refreeze(value: object, state: dict[str, Any]) -> None:
    """Give an unpickled frozen value its fields, arrays read-only again."""
    for name, item in state.items():
        if isinstance(item, np.ndarray):
            item.setflags(write=False)
        object.__setattr__(value, name, item)


def _coefficients(values: npt.ArrayLike, count: int, what: str) -> FloatArray:
    """Return checked expansion coefficients, one for each sensor."""
    array = np.atleast_1d(as_array(values, what))
    array = finite_array(array, (count,), what)
    if array.ndim != 1:
        raise ArgumentError(f"{what} has shape {array.shape}; expected ({count},), one value for each sensor")
    if (np.abs(array) > LARGEST_EXPANSION_PER_K).any():
        raise ArgumentError(
            f"{what} holds {array[np.abs(array).argmax()]:g} /K, above {LARGEST_EXPANSION_PER_K:g} /K; "
            "expansion is given in 1/K (the paper's 1.99e-3 um/mm/K is 1.99e-6 /K)"
        )
    return frozen(array)


@dataclass(frozen=True, eq=False, init=False)
class LegLaw(Shown):
    """Expansion law of one leg: ``drift = sum_s A_s q0 dT_s + B_s q dT_s`` (paper, eqs. 4 and 8).

    Parameters
    ----------
    sensors : tuple of str
        Names of the leg's thermometers, unique within the leg.
    A, B : array, shape (s,) [1/K]
        Coefficients of the retracted length and of the stroke, one for each sensor.
    covariance : array, shape (2 s, 2 s) [1/K^2], optional
        Covariance of ``[A_1 .. A_s, B_1 .. B_s]``.
    campaign : str
        Where the coefficients come from.
    terms : sequence of LegTerm
        That extend the law, of these sensors; what belongs to the bench is no term of a leg.
    spread : array, shape (2 s,) [1/K], optional
        Standard deviation of each coefficient between the legs that share this law, which `covariance` holds on its
        diagonal: it is independent from leg to leg, the rest of the covariance is common to them.
    """

    sensors: tuple[str, ...]
    A: FloatArray
    B: FloatArray
    covariance: FloatArray | None = None
    campaign: str = ""
    terms: tuple[LegTerm, ...] = ()
    spread: FloatArray | None = None

    def __init__(
        self,
        sensors: str | Sequence[str],
        A: npt.ArrayLike,
        B: npt.ArrayLike,
        covariance: npt.ArrayLike | None = None,
        campaign: str = "",
        terms: Sequence[LegTerm] = (),
        spread: npt.ArrayLike | None = None,
    ) -> None:
        set_ = object.__setattr__
        names: tuple[str, ...] = (sensors,) if isinstance(sensors, str) else _tuple(sensors)
        if not names or not all(isinstance(name, str) and name for name in names):
            raise ArgumentError(f"a leg law needs at least one sensor name, found {names!r}")
        if len(set(names)) != len(names):
            raise ArgumentError(f"a leg law names a sensor twice: {names}")
        set_(self, "sensors", names)
        set_(self, "A", _coefficients(A, len(names), "A_per_K"))
        set_(self, "B", _coefficients(B, len(names), "B_per_K"))
        set_(self, "covariance", None)
        set_(self, "campaign", str(campaign))
        set_(self, "terms", _terms_of_leg(terms, names))
        if covariance is not None:
            n = 2 * len(names)
            matrix = finite_array(covariance, (n, n), "covariance")
            if matrix.shape != (n, n) or not np.allclose(matrix, matrix.T, rtol=1e-9, atol=0.0):
                raise ArgumentError(f"covariance must be a symmetric ({n}, {n}) matrix of [A, B]")
            if np.linalg.eigvalsh(matrix).min() < -1e-9 * abs(np.diag(matrix)).max():
                raise ArgumentError("covariance has a negative eigenvalue: it is no covariance")
            set_(self, "covariance", frozen(matrix))
        set_(self, "spread", None if spread is None else _spread(spread, self.covariance))

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, LegLaw):
            return NotImplemented
        return (
            self.sensors == other.sensors
            and np.array_equal(self.A, other.A)
            and np.array_equal(self.B, other.B)
            and (self.covariance is None) == (other.covariance is None)
            and (self.covariance is None or np.array_equal(self.covariance, other.covariance))  # type: ignore[arg-type]
            and self.campaign == other.campaign
            and self.terms == other.terms
            and (self.spread is None) == (other.spread is None)
            and (self.spread is None or np.array_equal(self.spread, other.spread))  # type: ignore[arg-type]
        )

    __hash__ = None  # type: ignore[assignment]

    def __setstate__(self, state: dict[str, Any]) -> None:
        refreeze(self, state)

    @property
    def states(self) -> tuple[LegTerm, ...]:
        """Terms that depend on the rows before: no single set of temperatures tells their drift."""
        if not self.terms:
            return ()
        from hexathermal.machine.leg_states import stateless

        return tuple(term for term in self.terms if not stateless(term))

    def without_states(self) -> LegLaw:
        """Return the law without the terms of `states`: that of a machine which has long been at rest."""
        left = tuple(term for term in self.terms if term not in self.states)
        return LegLaw(self.sensors, self.A, self.B, self.covariance, self.campaign, left, self.spread)


def _spread(values: npt.ArrayLike, covariance: FloatArray | None) -> FloatArray:
    """Return a spread between legs, checked against the covariance that holds it."""
    if covariance is None:
        raise ArgumentError("spread needs a covariance that holds it")
    array = finite_array(values, (len(covariance),), "spread")
    if array.ndim != 1:
        raise ArgumentError(f"spread has shape {array.shape}; expected one value for each coefficient of [A, B]")
    if (array < 0.0).any() or (np.square(array) > np.diag(covariance) * (1.0 + 1e-9)).any():
        raise ArgumentError("spread must be 0 or more, and no larger than the covariance, which holds it, says")
    return frozen(array)


def _terms_of_leg(terms: Sequence[LegTerm], sensors: tuple[str, ...]) -> tuple[LegTerm, ...]:
    """Return checked terms of a machine's leg."""
    if not len(terms):
        return ()
    # terms know this module
    from hexathermal.machine.leg_states import of_bench, sensors_of
    from hexathermal.machine.leg_terms import LegTerm

    for term in terms:
        if not isinstance(term, LegTerm):
            raise ArgumentError(f"terms of a leg law must be LegTerm, found {type(term).__name__}")
        if of_bench(term):
            raise ArgumentError(f"term {term.cause!r} tells of a bench, not of the leg: a machine cannot carry it")
    unknown = [name for name in sensors_of(terms) if name not in sensors]
    if unknown:
        raise ArgumentError(
            f"a term reads sensor {unknown[0]!r}, which the leg law does not name; it names {', '.join(sensors)}: add "
            "it with A and B of 0"
        )
    return tuple(terms)


@dataclass(frozen=True)
class PlateLaw:
    """Expansion of a plate about its origin: ``v -> v (1 + expansion dT)`` (paper, eq. 1).

    Parameters
    ----------
    expansion : float [1/K]
    sensor : str or None
        Name of its thermometer; None: the plate is not compensated, its expansion enters the error budget.
    expansion_std : float [1/K], optional
        Standard uncertainty of the expansion; without it a budget counts an engineering value.
    """

    expansion: float
    sensor: str | None = None
    expansion_std: float | None = None

    def __post_init__(self) -> None:
        value = _coefficients([self.expansion], 1, "expansion_per_K")[0]
        object.__setattr__(self, "expansion", float(value))
        if self.expansion_std is not None:
            spread = float(_coefficients([self.expansion_std], 1, "expansion_std_per_K")[0])
            if spread < 0.0:
                raise ArgumentError(f"expansion_std_per_K must be 0 or more, found {spread:g} /K")
            object.__setattr__(self, "expansion_std", spread)
        if self.sensor is not None and not (isinstance(self.sensor, str) and self.sensor):
            raise ArgumentError(f"the plate's sensor must be a name or left out, found {self.sensor!r}")


@dataclass(frozen=True, eq=False, init=False)
class ThermalModel(Shown):
    """Laws of six legs and two plates, reference temperatures and range of validity.

    Parameters
    ----------
    legs : LegLaw or six of them
        One law for all legs (each with its own sensors), or one a leg.
    platform, base : PlateLaw, optional
    reference_temperature_degC : float or array, shape (n,)
        Temperature at which the machine was calibrated; one, or one for each of `sensor_names`.
    valid_degC : (float, float)
        Temperatures outside are refused.
    thermometers_of_leg : six int
        Leg ``i`` is told by the thermometers that are recorded as those of leg ``thermometers_of_leg[i]``, from 1:
        other than 1 to 6 where the plugs of legs were exchanged. Readings stay as they are recorded.

    Attributes
    ----------
    sensor_names : tuple of str
        ``leg1_<sensor>`` .. ``leg6_<sensor>``, then ``platform_<sensor>`` and ``base_<sensor>`` where they exist: names
        under which temperatures are recorded.
    """

    legs: tuple[LegLaw, ...]
    platform: PlateLaw | None = None
    base: PlateLaw | None = None
    reference_temperature_degC: FloatArray = field(default_factory=lambda: np.array(20.0))
    valid_degC: tuple[float, float] = DEFAULT_RANGE_DEGC
    thermometers_of_leg: tuple[int, ...] = AS_RECORDED
    sensor_names: tuple[str, ...] = field(init=False)

    def __init__(
        self,
        legs: LegLaw | Sequence[LegLaw],
        platform: PlateLaw | None = None,
        base: PlateLaw | None = None,
        reference_temperature_degC: npt.ArrayLike = 20.0,
        valid_degC: Sequence[float] | FloatArray = DEFAULT_RANGE_DEGC,
        thermometers_of_leg: Sequence[int] = AS_RECORDED,
    ) -> None:
        set_ = object.__setattr__
        laws: tuple[LegLaw, ...] = (legs,) * 6 if isinstance(legs, LegLaw) else _tuple(legs)
        if len(laws) != 6 or not all(isinstance(law, LegLaw) for law in laws):
            raise ArgumentError(f"legs must be one LegLaw or six, found {len(laws)}")
        for plate in (platform, base):
            if plate is not None and not isinstance(plate, PlateLaw):
                raise ArgumentError(f"platform and base must be PlateLaw or None, found {type(plate).__name__}")
        set_(self, "legs", laws)
        set_(self, "platform", platform)
        set_(self, "base", base)
        set_(self, "thermometers_of_leg", checked_thermometers(thermometers_of_leg))
        names = recorded_names([law.sensors for law in laws], self.legs_as_recorded)
        for part, plate in (("platform", self.platform), ("base", self.base)):
            if plate is not None and plate.sensor is not None:
                names.append(full_name(part, plate.sensor))
        double = sorted({name for name in names if names.count(name) > 1})
        if double:
            raise ArgumentError(f"two sensors would be called {double[0]}; sensor names must be unique within a part")
        set_(self, "sensor_names", tuple(names))
        reference = finite_array(np.atleast_1d(as_array(reference_temperature_degC, "reference")), (), "reference")
        if reference.shape not in ((1,), (len(names),)):
            raise ArgumentError(
                f"reference_temperature_degC has shape {reference.shape}; expected one value or {len(names)}, "
                f"in the order {', '.join(names)}"
            )
        set_(self, "reference_temperature_degC", frozen(np.broadcast_to(reference, (len(names),))))
        pair = finite_array(valid_degC, (2,), "valid_degC")
        if pair.shape != (2,):
            raise ArgumentError(f"valid_degC has shape {pair.shape}; expected [low, high]")
        low, high = (float(value) for value in pair)
        if not ABSOLUTE_ZERO_DEGC <= low < high:
            raise ArgumentError(f"valid_degC must be [low, high] above absolute zero, found [{low:g}, {high:g}]")
        set_(self, "valid_degC", (low, high))
        if ((reference < low) | (reference > high)).any():
            k = int(((reference < low) | (reference > high)).argmax())
            whose = f" of {names[k]}" if len(reference) > 1 else ""
            raise ArgumentError(
                f"reference temperature{whose}, {reference[k]:g} degC, lies outside valid_degC [{low:g}, {high:g}]"
            )
        self._check_size()

    def _check_size(self) -> None:
        """Refuse laws under which a part could double or vanish within the range."""
        span = max(abs(bound - value) for bound in self.valid_degC for value in self.reference_temperature_degC)
        parts = [(f"leg {i + 1}", max(np.abs(law.A).sum(), np.abs(law.B).sum())) for i, law in enumerate(self.legs)]
        plates = (("platform", self.platform), ("base", self.base))
        parts += [(name, abs(plate.expansion)) for name, plate in plates if plate is not None]
        for name, coefficient in parts:
            if coefficient * span > LARGEST_STRAIN:
                raise ThermalModelError(
                    f"the law of {name} would change its length by {coefficient * span:.2g} of itself within "
                    f"valid_degC {list(self.valid_degC)}, allowed {LARGEST_STRAIN:g}; check the coefficients "
                    "(1/K) and the range"
                )

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, ThermalModel):
            return NotImplemented
        return (
            self.legs == other.legs
            and (self.platform, self.base, self.valid_degC) == (other.platform, other.base, other.valid_degC)
            and self.thermometers_of_leg == other.thermometers_of_leg
            and np.array_equal(self.reference_temperature_degC, other.reference_temperature_degC)
        )

    __hash__ = None  # type: ignore[assignment]

    def __setstate__(self, state: dict[str, Any]) -> None:
        refreeze(self, state)

    @property
    def has_terms(self) -> bool:
        """Whether terms extend the law of a leg."""
        return any(law.terms for law in self.legs)

    @property
    def states(self) -> tuple[LegTerm, ...]:
        """Terms of legs that depend on the rows before."""
        return tuple(term for law in self.legs for term in law.states)

    def without_states(self) -> ThermalModel:
        """Return the model without the terms of `states`: that of a machine which has long been at rest."""
        return ThermalModel(
            [law.without_states() for law in self.legs], self.platform, self.base, self.reference_temperature_degC,
            self.valid_degC, self.thermometers_of_leg,
        )  # fmt: skip

    @property
    def legs_as_recorded(self) -> tuple[int, ...]:
        """Leg, from 0, whose temperatures are recorded as those of leg 1, 2 .. 6."""
        return tuple(self.thermometers_of_leg.index(recorded) for recorded in AS_RECORDED)

    @property
    def columns_of_leg(self) -> tuple[slice, ...]:
        """Columns of temperatures, in the order of `sensor_names`, that tell each leg, in the order of its sensors."""
        found, first = [slice(0)] * 6, 0
        for leg in self.legs_as_recorded:
            found[leg] = slice(first, first + len(self.legs[leg].sensors))
            first = found[leg].stop
        return tuple(found)

    @property
    def common_law(self) -> bool:
        """Whether all six legs follow the same law."""
        return all(law == self.legs[0] for law in self.legs)


def _tuple(value: Any) -> tuple[Any, ...]:
    """Return a sequence as a tuple; what is none becomes a tuple of itself, and is refused by its type later."""
    return tuple(value) if isinstance(value, Sequence) else (value,)
