"""Thermocouples: what they read of the leg's surface, and how they are wrong."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hexathermal.errors import ArgumentError
from hexathermal.machine.thermal import frozen
from hexathermal.poses import FloatArray
from hexathermal.simulate.bench.leg import LegHistory
from hexathermal.simulate.bench.parts import require_finite


def slow_process(time: FloatArray, correlation_time: float, count: int, generator: np.random.Generator) -> FloatArray:
    """Return stationary noise of unit variance that forgets itself within `correlation_time`, shape (n, count)."""
    found = np.empty((time.size, count))
    found[0] = generator.standard_normal(count)
    kept = np.exp(-np.diff(time) / correlation_time)
    fresh = np.sqrt(1.0 - kept * kept)[:, None] * generator.standard_normal((time.size - 1, count))
    for k in range(time.size - 1):
        found[k + 1] = kept[k] * found[k] + fresh[k]
    return found


@dataclass(frozen=True)
class Thermocouples:
    """Seventeen thermocouples, taped to body and rod.

    Attributes
    ----------
    body_positions, rod_positions : tuple of float [m]
        From the lower joint's centre, rod retracted; those on the rod move with it. Source of the count: Robert et al.;
        engineering value: evenly along the body, three where the rod shows when it is retracted.
    noise : float [K]
        Standard deviation of a reading. Source: 6 to 14 mK every 15 s on machine tools.
    bias, bias_time : float [K], [s]
        Slow bias of each channel: standard deviation, and the time after which it is another one. Engineering value.
    cold_junction, cold_junction_time : float [K], [s]
        The same for what all channels share. Source: 0.05 to 0.2 K; engineering value for the time.
    offset : float [K]
        Constant error of each, standard deviation; differences do not see it. Source: class 1, type T, within 0.5 K.
    gain : float [1]
        Standard deviation of each one's gain error. Source: class 1, type T, 0.4 %.
    contact_error : tuple of float [1]
        Smallest and largest part ``gamma`` by which a taped junction follows the air:
        ``T_read = T_surface - gamma (T_surface - T_air)``. Source: 0.02 to 0.1.
    resolution_K : float [K]
        Of the logger. Engineering value.
    """

    body_positions: tuple[float, ...] = tuple(np.linspace(0.030, 0.537, 14).round(4).tolist())
    rod_positions: tuple[float, ...] = (0.552, 0.564, 0.576)
    noise: float = 0.010
    bias: float = 0.02
    bias_time: float = 7200.0
    cold_junction: float = 0.03
    cold_junction_time: float = 14400.0
    offset: float = 0.15
    gain: float = 0.004
    contact_error: tuple[float, float] = (0.02, 0.06)
    resolution_K: float = 0.001

    def __post_init__(self) -> None:
        require_finite(self, above_zero=("bias_time", "cold_junction_time", "resolution_K"))
        low, high = self.contact_error
        if not low <= high < 1.0:
            raise ArgumentError(f"Thermocouples.contact_error is (smallest, largest), below 1, found {(low, high)!r}")
        if not self.places:
            raise ArgumentError("a bench needs at least one thermocouple")

    @property
    def places(self) -> tuple[tuple[str, str, float], ...]:
        """Name, part and position [m] of each."""
        found = [("body", position) for position in self.body_positions]
        found += [("rod", position) for position in self.rod_positions]
        return tuple((f"T{k + 1:02d}", part, position) for k, (part, position) in enumerate(found))

    def mounted(self, generator: np.random.Generator) -> MountedThermocouples:
        """Return the thermocouples as they are on one bench, their constant errors drawn."""
        count = len(self.places)
        offset = self.offset * generator.standard_normal(count)
        gain = 1.0 + self.gain * generator.standard_normal(count)
        return MountedThermocouples(
            self, frozen(offset), frozen(gain), frozen(generator.uniform(*self.contact_error, count))
        )


@dataclass(frozen=True, eq=False)
class MountedThermocouples:
    """Thermocouples with their constant errors: offset [K], gain [1] and contact error [1] of each, shape (s,)."""

    kind: Thermocouples
    offset: FloatArray
    gain: FloatArray
    contact_error: FloatArray

    def surfaces(self, history: LegHistory) -> FloatArray:
        """Return the true temperatures under the thermocouples, shape (n, s) [degC]."""
        return np.column_stack([history.surface(part, position) for _name, part, position in self.kind.places])

    def quiet(self, surfaces: FloatArray, air: FloatArray) -> FloatArray:
        """Return readings with the constant errors alone, shape (n, s) [degC]: contact, gain and offset."""
        junction = surfaces - self.contact_error * (surfaces - air[:, None])
        # linearised at 20 degC: a gain error is that of the distance from there
        return np.asarray(20.0 + self.gain * (junction - 20.0) + self.offset)

    def read(
        self, time: FloatArray, surfaces: FloatArray, air: FloatArray, generator: np.random.Generator
    ) -> FloatArray:
        """Return what the logger writes, shape (n, s) [degC].

        Parameters
        ----------
        time : array, shape (n,) [s]
        surfaces : array, shape (n, s) [degC]
        air : array, shape (n,) [degC]
            About the leg.
        """
        kind, count = self.kind, surfaces.shape[1]
        found = self.quiet(surfaces, air)
        found += kind.bias * slow_process(time, kind.bias_time, count, generator)
        found += kind.cold_junction * slow_process(time, kind.cold_junction_time, 1, generator)
        found += kind.noise * generator.standard_normal(surfaces.shape)
        return frozen(np.round(found / kind.resolution_K) * kind.resolution_K)
