"""What truly happens in a campaign, before an effect is hidden in it and before it is written.

A bench (`hexathermal.simulate.hidden.benches`) makes a `CampaignTruth`; an effect
(`hexathermal.simulate.hidden.effects`) changes it; the writer records it. All arrays of a run have n rows, one for each
row of the log, SI units (temperatures in degC).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
import numpy.typing as npt

from hexathermal.poses import FloatArray


@dataclass(frozen=True, eq=False)
class RunTruth:
    """What truly happens in one run.

    Attributes
    ----------
    name, role : str
        Role ``"identification"`` or ``"validation"``.
    time : array, shape (n,) [s]
    q : array, shape (n,) [m]
        Displacement of the rod; of a part without a stroke, zeros.
    settled : array of bool, shape (n,)
    temperatures : array, shape (n, s) [degC]
        Of the places where the thermometers sit, without any error of a thermometer.
    sensor_errors : array, shape (n, s) [K]
        Noise and slow bias of each thermometer, to be added when it is recorded.
    air : array, shape (n, 3)
        True air temperature [degC], pressure [Pa], relative humidity [1].
    inputs : array, shape (n, k)
        Recorded inputs in their own units.
    drift : array, shape (n,) [m]
        By the law of the base sensors at their true temperatures, from the run's first row (see `CampaignTruth.zero`).
    noise : array, shape (n,) [m]
        Of the displacement's measurement: white, scatter of each landing, slow process, as the bench has them.
    effect : array, shape (n,) [m]
        What hidden effects add to the measured drift.
    beam_effects : array, shape (n, 3) [m]
        What hidden effects add to single beams (kind leg).
    """

    name: str
    role: str
    time: FloatArray
    q: FloatArray
    settled: npt.NDArray[np.bool_]
    temperatures: FloatArray
    sensor_errors: FloatArray
    air: FloatArray
    inputs: FloatArray
    drift: FloatArray
    noise: FloatArray
    effect: FloatArray
    beam_effects: FloatArray

    def changed(self, **fields: object) -> RunTruth:
        """Return the run with some fields changed."""
        return replace(self, **fields)  # type: ignore[arg-type]


@dataclass(frozen=True, eq=False)
class CampaignTruth:
    """What truly happens in a campaign.

    Attributes
    ----------
    kind : str
        ``"leg"`` or ``"component"``.
    bench : str
        Name of the bench that made it.
    runs : tuple of RunTruth
    sensors : tuple of str
    parts : tuple of str
        Of each sensor, as in campaign.toml.
    positions : array, shape (s,) [m]
        Along the leg; NaN where not stated.
    base : tuple of str
        Sensors of the law.
    coefficients : array
        ``[A_1 .. A_k, B_1 .. B_k]`` [1/K] of a leg; ``[C_1 .. C_k]`` [m/K] of a component, ``[C .. D ..]`` of one
        whose expansion goes with its stroke, D in 1/K.
    retracted_length : float [m]
    stroke : (float, float) [m]
    dead_path : float [m]
    index_compensated : bool
    input_names : tuple of str
    zero : str
        ``"run"`` or ``"campaign"``.
    notes : mapping
        Whatever a test may want to know: levels of noise, seed, parameters of the effect.
    """

    kind: str
    bench: str
    runs: tuple[RunTruth, ...]
    sensors: tuple[str, ...]
    parts: tuple[str, ...]
    positions: FloatArray
    base: tuple[str, ...]
    coefficients: FloatArray
    retracted_length: float
    stroke: tuple[float, float]
    dead_path: float
    index_compensated: bool
    input_names: tuple[str, ...] = ()
    zero: str = "run"
    notes: Mapping[str, object] = field(default_factory=dict)

    @property
    def along(self) -> bool:
        """Whether the law reads the displacement."""
        return len(self.coefficients) > len(self.base)

    @property
    def length(self) -> float:
        """What the first coefficients multiply beside the temperature: q0 of a leg [m], 1 of a component."""
        return self.retracted_length if self.kind == "leg" else 1.0

    def slopes(self, q: FloatArray) -> FloatArray:
        """Return what the law makes of a kelvin of each of its sensors at some displacements, shape (n, k) [m/K]."""
        fixed, moved = self.coefficients[: len(self.base)], self.coefficients[len(self.base) :]
        if not self.along:
            return np.broadcast_to(fixed, (q.size, len(self.base)))
        return np.asarray(fixed * self.length + q[:, None] * moved)

    def changed(self, **fields: object) -> CampaignTruth:
        """Return the campaign with some fields changed."""
        return replace(self, **fields)  # type: ignore[arg-type]
