"""Laws with terms of every shape, and runs with every signal, for tests."""

from __future__ import annotations

from typing import Any

import numpy as np

from hexathermal.learn.law import IdentifiedLaw, Origin, Validity
from hexathermal.learn.noise import ResidualNoise
from hexathermal.learn.sensor_errors import SensorErrors
from hexathermal.machine.leg_repairs import SensorRepair
from hexathermal.machine.leg_signals import LegSignals
from hexathermal.machine.leg_terms import LegTerm

Q0 = 0.6

EXAMPLES: dict[str, list[tuple[str, dict[str, Any], list[float]]]] = {
    "lag": [("thermal-lag", {"sensor": "T01", "ratio": 0.5, "time_constant_s": 900.0}, [1.5e-6]),
            ("thermal-lag", {"sensor": "T02", "ratio": 0.0, "time_constant_s": 70.0, "order": 2}, [-0.7e-6])],
    "lead": [("thermal-lag", {"sensor": "T01", "ratio": 0.5, "time_constant_s": 300.0}, [0.8e-6, -0.3e-6])],
    "lead-by-motion": [("thermal-lag", {"sensor": "T01", "ratio": 0.5, "time_constant_s": 300.0,
                                        "heat_times_s": [120.0, 900.0], "once": [50.0, -20.0],
                                        "twice": [-10.0, 200.0]}, [2e-6])],
    "foretold": [("thermal-lag", {"sensor": "T01", "weights": {"T02": 0.4, "T03": 0.7}, "ratio": 0.5,
                                  "time_constant_s": 1500.0, "order": 2}, [2e-6])],
    "temperature": [("missing-sensor", {"sensor": "T03", "ratio": 0.3}, [0.4e-6]),
                    ("missing-sensor", {"sensor": "T03", "ratio": 0.3, "weights": {"T02": 0.7, "T03": 0.4}}, [0.4e-6])],
    "expansion": [("missing-sensor", {"sensor": "T03"}, [0.2e-6, 0.9e-6])],
    "stored-heat": [("hidden-heat", {"source": "motion", "power": 2, "time_constant_s": 2500.0}, [30.0]),
                    ("hidden-heat", {"source": "motion", "time_constant_s": 900.0,
                                     "source_time_constant_s": 150.0}, [0.1]),
                    ("hidden-heat", {"source": "motion", "time_constant_s": 900.0, "source_time_constant_s": 150.0,
                                     "source_share": 0.4}, [0.1]),
                    ("hidden-heat", {"source": "spindle_rpm", "time_constant_s": 0.0, "ratio": 0.4}, [1e-9])],
    "square": [("nonlinear-expansion", {"sensor": "T01", "ratio": 0.5}, [2e-8]),
               ("nonlinear-expansion", {"sensor": "T02", "ratio": 0.5, "reference_degC": 20.0}, [3e-8]),
               ("nonlinear-expansion", {"sensor": "T02", "ratio": 0.5, "calibration_degC": 20.0}, [3e-8])],
    "cube": [("nonlinear-expansion", {"sensor": "T01", "ratio": 0.5}, [2e-9])],
    "bend": [("nonlinear-expansion", {"sensor": "T01", "ratio": 0.5, "middle_degC": 22.0, "width_K": 1.5}, [-2e-8]),
             ("nonlinear-expansion", {"sensor": "T01", "ratio": 0.5, "middle_degC": 22.0, "width_K": 1.5,
                                      "calibration_degC": 20.0}, [-2e-8])],
    "room": [("frame-expansion", {"time_constant_s": 5000.0}, [3e-7]),
             ("frame-expansion", {"time_constant_s": 5000.0, "sensor": "T03"}, [3e-7]),
             ("frame-expansion", {"time_constant_s": 5000.0, "order": 2}, [3e-7])],
    "air-index": [("air-refraction", {"path_m": 0.7003, "stroke_share": 1.0}, [-1.0]),
                  ("air-refraction", {"path_m": 0.4, "stroke_share": 1.0, "reference_index": 1.000265}, [-0.6]),
                  ("air-refraction", {"path_m": 0.4, "stroke_share": 1.0, "weather": "pressure"}, [0.8]),
                  ("air-refraction", {"path_m": 0.4, "stroke_share": 0.0, "time_constant_s": 600.0}, [-1.0])],
    "tilt": [("abbe-tilt", {}, [2e-3, -1e-3])],
    "direction": [("backlash", {}, [0.31e-6]), ("backlash", {"approach": -0.4}, [0.31e-6]),
                  ("backlash", {"approach": 0.5, "play_m": 0.001}, [0.31e-6])],
    "periodic": [("periodic-screw-error", {"pitch_m": 0.00203}, [0.1e-6, -0.2e-6])],
    "wave": [("periodic-screw-error", {"pitch_m": 0.02, "origin_m": 0.0013}, [0.2e-6])],
    "position": [("scale-error", {}, [3e-6])],
    "relaxation": [("creep", {"time_constant_s": 240.0, "kick": "direction"}, [0.2e-6]),
                   ("creep", {"time_constant_s": 240.0, "kick": "move"}, [0.2e-6]),
                   ("creep", {"time_constant_s": 90.0, "kick": "direction", "saturation_m": 0.004}, [0.3e-6]),
                   ("creep", {"time_constant_s": 60.0, "kick": "step", "decades": 1.5}, [0.2e-6]),
                   ("creep", {"time_constant_s": 90.0, "kick": "direction", "renewed": 1}, [0.3e-6])],
    "time": [("zero-drift", {}, [0.05e-6])],
}  # fmt: skip
"""Cause, parameters and amplitudes of terms of each shape."""

REPAIRS = (
    SensorRepair("swapped-sensors", "swap", {"first": "T01", "second": "T02"}),
    SensorRepair("sensor-drift", "drift", {"sensor": "T01", "rate_K_per_h": 0.03}),
    SensorRepair("clock-offset", "clock", {"offset_s": -47.5}),
    SensorRepair("sensor-detached", "detached", {"sensor": "T02", "weights": {"T01": 0.4, "T03": 0.7}}),
    SensorRepair("clock-offset", "clock", {"offset_s": -12.0, "gains_s_per_h": -3.5}),
    SensorRepair("sensor-detached", "loose", {"sensor": "T01", "share": 0.2, "air_sensor": "T03"}),
    SensorRepair("sensor-detached", "loose", {"sensor": "T01", "share": 0.2}),
)


def terms_of(shape: str) -> tuple[LegTerm, ...]:
    """Return the examples of a shape."""
    return tuple(LegTerm(cause, shape, parameters, amplitudes) for cause, parameters, amplitudes in EXAMPLES[shape])


def law_with(terms: tuple[LegTerm, ...] = (), repairs: tuple[SensorRepair, ...] = ()) -> IdentifiedLaw:
    """Return a leg's law of T01 and T02 with terms and repairs."""
    root = np.array([[1.0, 0, 0, 0], [0.2, 1.0, 0, 0], [-0.1, 0.3, 1.0, 0], [0.0, 0.1, 0.2, 1.0]]) * 1e-8
    return IdentifiedLaw(
        "leg", ("T01", "T02"), np.array([2.0e-6, 0.5e-6, 1.1e-6, 0.2e-6]), root @ root.T, Q0, (0.0, 0.25), "run",
        Validity(np.array([[-2.0, 8.0], [-2.0, 8.0]]), (0.0, 0.25), (18.0, 28.0)),
        ResidualNoise(2e-8, 1e-7, 5e-8, 3000.0, 0.0), SensorErrors(np.full(2, 0.03), np.full(2, 0.05), 3000.0),
        1.97, Origin("drawn", "0", ("a",), "by hand"), terms, repairs,
    )  # fmt: skip


def drawn_signals(seed: int, rows: int = 160) -> LegSignals:
    """Return a run of uneven steps of time in which everything moves; it rests now and then."""
    rng = np.random.default_rng(seed)
    time = np.concatenate([[0.0], np.cumsum(rng.choice([5.0, 20.0, 60.0, 4000.0], rows - 1, p=[0.4, 0.4, 0.19, 0.01]))])

    def slow(size: float) -> np.ndarray:
        walk = np.cumsum(rng.normal(size=rows)) * size
        return walk - walk[0]

    moves = np.where(rng.random(rows) < 0.3, rng.choice([-0.01, 0.01, 0.0007, 1e-7], rows), 0.0)
    q = np.clip(0.12 + np.cumsum(moves), 0.0, 0.25)
    return LegSignals(
        time, {f"T0{k}": slow(0.2) for k in (1, 2, 3)}, q, Q0, slow(0.1), slow(1e-7),
        np.column_stack([slow(1e-6), slow(1e-6)]), {"spindle_rpm": 3000.0 * (rng.random(rows) < 0.5)},
        {"T01": 21.3, "T02": 20.4, "T03": 22.0}, 1.00027, slow(1e-7),
    )  # fmt: skip


def part(signals: LegSignals, rows: slice) -> LegSignals:
    """Return some rows."""

    def cut(values: Any) -> Any:
        return None if values is None else values[rows]

    return LegSignals(
        signals.time[rows], {name: values[rows] for name, values in signals.dT.items()}, signals.q[rows],
        signals.retracted_length, cut(signals.air), cut(signals.index), cut(signals.tilt),
        {name: values[rows] for name, values in signals.inputs.items()}, signals.zero_degC,
        signals.zero_index, cut(signals.pressure_index),
    )  # fmt: skip
