"""Causes of a single leg's catalogue that a machine can show through the leg they sit on.

Each is a term of that leg's law (`hexathermal.machine.leg_terms`). What belongs to a bench and its interferometer
(`hexathermal.machine.leg_states.BENCH_CAUSES`) is no cause of a machine; which thermometers tell the leg is asked where
it has several (`leg_sensors`), other faults of a single thermometer in the leg's own campaign.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from hexathermal.learn.diagnosis.words import AMPLITUDES
from hexathermal.learn.machine_diagnosis.candidate import Candidate
from hexathermal.learn.machine_diagnosis.leg_sensors import MISSING, SWAPPED
from hexathermal.learn.machine_diagnosis.leg_terms import term_candidate
from hexathermal.learn.machine_diagnosis.view import MachineView

LAGS_S = (300.0, 900.0, 2700.0)
PITCHES_M = (2e-3, 4e-3, 5e-3, 10e-3)
"""Usual pitches of ball and roller screws."""

FURTHER = "further thermometers on all legs (leg1_T2_degC to leg6_T2_degC) in runs as these, or the leg on a bench"
CANNOT_SHOW = " cannot be seen in these runs; it takes "
ONLY_ON_A_BENCH = {
    MISSING: FURTHER,
    "sensor-drift": "two thermometers side by side on the leg",
    "sensor-detached": "two thermometers side by side on the leg",
    "clock-offset": "a fast change of all temperatures, with time stamps of the controller",
    SWAPPED: f"{FURTHER}; a warm hand on each thermometer in turn",
}
"""Causes of a leg that poses of a machine do not show, and the measurement that would."""


def only_on_a_bench(view: MachineView) -> dict[str, str]:
    """Return the causes of a leg that these rows cannot show, and the measurement that would show each."""
    several = [MISSING] * bool((~view.read).any()) + [SWAPPED] * (len(view.sensors) > 1)
    return {name: words for name, words in ONLY_ON_A_BENCH.items() if name not in several}


def single_leg_candidates(view: MachineView) -> list[Candidate]:
    """Return the leg's causes on each leg, where it moves or warms."""
    return [
        term_candidate(view, cause, leg, shape, *_amplitudes(shape), settings)
        for leg in range(6)
        for cause, shape, settings in _terms(view, leg)
    ]


def _amplitudes(shape: str) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Return names and units of a shape's amplitudes, in the core's units."""
    names, unit, _factor = AMPLITUDES[shape]
    plain = tuple(name.replace("_um_per_h", "").replace("_um", "").replace("_ppm", "") for name in names)
    return plain, ("m" if unit.startswith("um") else "1" if unit == "1e-6" else unit,) * len(names)


def _terms(view: MachineView, leg: int) -> Iterator[tuple[str, str, dict[str, Any]]]:
    """Give cause, shape and parameters."""
    A, B = view.laws[leg]
    for k in np.flatnonzero(A):
        if np.ptp(view.heat[:, leg, k]) > 0.0:
            own = {"sensor": view.sensors[k], "ratio": float(np.clip(B[k] / A[k], -1.5, 1.5))}
            yield "nonlinear-expansion", "square", own
            for tau in LAGS_S:
                yield "thermal-lag", "lag", own | {"time_constant_s": tau}
    if np.ptp(view.q[:, leg]) > 0.0:
        yield "scale-error", "position", {}
        for pitch in PITCHES_M:
            yield "periodic-screw-error", "periodic", {"pitch_m": pitch}
        if (np.diff(view.time) > 0.0).any():
            yield "hidden-heat", "stored-heat", {"source": "motion", "time_constant_s": LAGS_S[1]}
            yield "creep", "relaxation", {"kick": "step", "time_constant_s": LAGS_S[0]}
