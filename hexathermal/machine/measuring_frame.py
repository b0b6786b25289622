"""The frame in which poses are measured, as it drifts with a recorded temperature.

It is no part of the machine: commands do not know it. It enters only where measured poses are held against predicted
ones (`hexathermal.predict.measuring`).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from hexathermal.errors import ArgumentError
from hexathermal.machine.compliance import same_value, vector
from hexathermal.machine.leg_signals import Memory
from hexathermal.machine.thermal import refreeze
from hexathermal.poses import FloatArray, as_array

LARGEST_DRIFT = 1e-2
"""Drift for each kelvin above which a unit is taken for wrong [m/K, rad/K]."""

LONGEST_DELAY = 1e6
"""Time constant above which a unit is taken for wrong [s]: eleven days."""


@dataclass(frozen=True, eq=False, init=False)
class MeasuringFrame:
    """Drift of the measuring frame with a temperature: all measured poses move by the same small rigid motion.

    ``motion = [shift dT, turn dT]``, turned about the platform's origin at home, base axes; ``dT`` counts from whatever
    zero the measured poses count from (a campaign's zero). A frame on a heavy stand follows late: then ``dT`` is behind
    a first-order low pass, ``tau dy/dt = dT - y``, that has rested at the first value of each run.

    Parameters
    ----------
    sensor : str
        Name of the recorded temperature that the frame follows, as ``"air_temperature"``.
    shift : array, shape (3,) [m/K]
    turn : array, shape (3,) [rad/K]
    shift_std, turn_std : array, shape (3,), optional
        Standard uncertainties.
    time_constant : float [s]
        With which the frame follows; 0: at once.

    Raises
    ------
    ArgumentError
        No name; wrong shape, not finite, or so large that a unit must be wrong; a time constant below 0.

    Examples
    --------
    >>> room = MeasuringFrame("air_temperature", [1e-6, 0, 0], [0, 0, 2e-6])
    >>> room.motion([0.0, 2.0]).tolist()[1]
    [2e-06, 0.0, 0.0, 0.0, 0.0, 4e-06]
    """

    sensor: str
    shift: FloatArray
    turn: FloatArray
    shift_std: FloatArray | None
    turn_std: FloatArray | None
    time_constant: float

    def __init__(
        self,
        sensor: str,
        shift: npt.ArrayLike = (0.0, 0.0, 0.0),
        turn: npt.ArrayLike = (0.0, 0.0, 0.0),
        shift_std: npt.ArrayLike | None = None,
        turn_std: npt.ArrayLike | None = None,
        time_constant: float = 0.0,
    ) -> None:
        set_ = object.__setattr__
        if not isinstance(sensor, str) or not sensor:
            raise ArgumentError(f"a measuring frame follows a recorded temperature by its name, found {sensor!r}")
        set_(self, "sensor", sensor)
        for name, unit, given in (("shift", "m/K", shift), ("turn", "rad/K", turn),
                                  ("shift_std", "m/K", shift_std), ("turn_std", "rad/K", turn_std)):  # fmt: skip
            value = None if given is None else vector(given, name)
            if value is not None and np.abs(value).max() > LARGEST_DRIFT:
                raise ArgumentError(f"{name} is {value.tolist()}, above {LARGEST_DRIFT:g} {unit}; check its unit")
            if value is not None and name.endswith("_std") and (value < 0.0).any():
                raise ArgumentError(f"{name} must be 0 or more, found {value.tolist()}")
            set_(self, name, value)
        if not (np.isfinite(time_constant) and 0.0 <= time_constant <= LONGEST_DELAY):
            raise ArgumentError(f"time_constant must be in [0, {LONGEST_DELAY:g}] s, found {time_constant!r}")
        set_(self, "time_constant", float(time_constant))

    def followed(self, dT: npt.ArrayLike, time: npt.ArrayLike) -> FloatArray:
        """Return the temperature that the frame has reached behind the recorded one, shape (n,) [K].

        Parameters
        ----------
        dT : array, shape (n,) [K]
            Recorded, of one run in order of time.
        time : array, shape (n,) [s]

        Examples
        --------
        >>> late = MeasuringFrame("air_temperature", [1e-6, 0, 0], time_constant=600.0)
        >>> late.followed([0.0, 1.0, 1.0, 1.0], [0.0, 1.0, 600.0, 6000.0]).round(3).tolist()
        [0.0, 0.001, 0.632, 1.0]
        """
        values = as_array(dT, "dT")
        if self.time_constant == 0.0:
            return values
        seconds = as_array(time, "time")
        if values.ndim != 1 or seconds.shape != values.shape:
            raise ArgumentError(
                f"a frame with a time constant needs rows of one run: dT {values.shape} and time {seconds.shape} must "
                "both have shape (n,)"
            )
        if not np.isfinite(seconds).all() or (np.diff(seconds) < 0.0).any():
            raise ArgumentError("time must be finite and must not run backwards within a run")
        return np.asarray(Memory().low_pass("frame", seconds, values, self.time_constant)) if len(values) else values

    def motion(self, dT: npt.ArrayLike) -> FloatArray:
        """Return how far the frame moves measured poses where it has reached temperatures since the zero (...,) [K].

        Returns
        -------
        array, shape (..., 6) [m, m, m, rad, rad, rad]
        """
        return np.asarray(as_array(dT, "dT")[..., None] * np.concatenate([self.shift, self.turn]))

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, MeasuringFrame):
            return NotImplemented
        return all(same_value(getattr(self, name), getattr(other, name)) for name in self.__dataclass_fields__)

    __hash__ = None  # type: ignore[assignment]

    def __setstate__(self, state: dict[str, Any]) -> None:
        refreeze(self, state)
