"""Where a move really ends: scatter of each landing, the settling after it, and the scale's short-period error."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hexathermal.errors import ArgumentError
from hexathermal.poses import FloatArray
from hexathermal.simulate.bench.parts import require_finite
from hexathermal.simulate.bench.scenario import Motion


@dataclass(frozen=True)
class Mechanics:
    """Mechanical errors of the leg that no thermometer sees.

    Attributes
    ----------
    scatter : float [m]
        Scale of the scatter of each landing: Student's t, heavy-tailed. Source of the kind: residual peaks that
        coincide with moves (Robert et al.); engineering value, below the 0.2 to 2 um of hysteresis of preloaded joints,
        which the controller corrects where it repeats.
    freedom : float [1]
        Degrees of freedom of that distribution. Engineering value.
    limit : float [m]
        Preload holds the joints: a landing beyond is drawn again. Engineering value.
    settling, settling_time : float [m], [s]
        Scale of what creeps back after each landing, and its time constant. Source: 1 to 10 s to settle, stick-slip
        seconds to minutes.
    scale_error, scale_period : float [m], [m]
        Height and period of the scale's short-period error. Source: 20 to 100 nm at 20 to 40 um.
    servo : float [m]
        Standard deviation of the position that the controller holds; the scale reads it. Engineering value.
    """

    scatter: float = 0.10e-6
    freedom: float = 4.0
    limit: float = 0.5e-6
    settling: float = 0.10e-6
    settling_time: float = 15.0
    scale_error: float = 20e-9
    scale_period: float = 20e-6
    servo: float = 10e-9

    def __post_init__(self) -> None:
        require_finite(self, above_zero=("freedom", "settling_time", "scale_period"))
        if self.limit < self.scatter or self.limit < self.settling:
            raise ArgumentError(
                f"Mechanics.limit ({self.limit:g} m) must not be below scatter ({self.scatter:g} m) and settling "
                f"({self.settling:g} m): hardly any landing would be kept"
            )

    def _landings(self, size: float, count: int, generator: np.random.Generator) -> FloatArray:
        """Return the scatter of landings, shape (count,) [m]."""
        found = size * generator.standard_t(self.freedom, count)
        while size > 0.0 and (beyond := np.abs(found) > self.limit).any():
            found[beyond] = size * generator.standard_t(self.freedom, int(beyond.sum()))
        return np.asarray(found)

    def error(self, motion: Motion, time: FloatArray, generator: np.random.Generator) -> FloatArray:
        """Return by how much the leg is longer than scale and temperatures say, shape (n,) [m].

        Where a run starts, the leg has rested for long: there is no scatter before the first move.
        """
        count = motion.commands.times.size + 1
        scatter = self._landings(self.scatter, count, generator)
        creep = self._landings(self.settling, count, generator)
        scatter[0] = creep[0] = 0.0
        landing = motion.landing(time)
        since = np.clip(motion.since_arrival(time), 0.0, None)
        phase = 2.0 * np.pi * (motion.displacement(time) / self.scale_period + generator.uniform())
        return np.asarray(
            scatter[landing] + creep[landing] * np.exp(-since / self.settling_time) + self.scale_error * np.sin(phase)
        )
