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
from hexathermal.machine.thermal import refreeze
from hexathermal.poses import FloatArray, as_array

LARGEST_DRIFT = 1e-2
"""Drift for each kelvin above which a unit is taken for wrong [m/K, rad/K]."""


@dataclass(frozen=True, eq=False, init=False)
class MeasuringFrame:
    """Drift of the measuring frame with a temperature: all measured poses move by the same small rigid motion.

    ``motion = [shift dT, turn dT]``, turned about the platform's origin at home, base axes; ``dT`` counts from whatever
    zero the measured poses count from (a campaign's zero).

    Parameters
    ----------
    sensor : str
        Name of the recorded temperature that the frame follows, as ``"air_temperature"``.
    shift : array, shape (3,) [m/K]
    turn : array, shape (3,) [rad/K]
    shift_std, turn_std : array, shape (3,), optional
        Standard uncertainties.

    Raises
    ------
    ArgumentError
        No name; wrong shape, not finite, or so large that a unit must be wrong.

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

    def __init__(
        self,
        sensor: str,
        shift: npt.ArrayLike = (0.0, 0.0, 0.0),
        turn: npt.ArrayLike = (0.0, 0.0, 0.0),
        shift_std: npt.ArrayLike | None = None,
        turn_std: npt.ArrayLike | None = None,
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

    def motion(self, dT: npt.ArrayLike) -> FloatArray:
        """Return how far the frame moves measured poses at temperatures since the zero (...,) [K].

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
