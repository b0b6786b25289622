"""A machine whose legs carry terms, and motions of it, for tests."""

from __future__ import annotations

import dataclasses

import numpy as np

import hexathermal as ht
from hexathermal.machine.leg_terms import LegTerm
from tests.machines import random_poses
from tests.trajectory_files import SENSORS

Q0 = 0.6
SQUARE = LegTerm("nonlinear-expansion", "square", {"sensor": "T1", "ratio": 0.5}, [2e-8])
AGAIN = LegTerm("missing-sensor", "temperature", {"sensor": "T1", "ratio": 0.3}, [0.4e-6])
SCALE = LegTerm("scale-error", "position", {}, [3e-6])
SCREW = LegTerm("periodic-screw-error", "periodic", {"pitch_m": 0.00203}, [0.1e-6, -0.2e-6])
LAG = LegTerm("thermal-lag", "lag", {"sensor": "T1", "ratio": 0.5, "time_constant_s": 900.0}, [1e-6])
SLACK = LegTerm("backlash", "direction", {}, [0.31e-6])
HEAT = LegTerm("hidden-heat", "stored-heat", {"source": "motion", "time_constant_s": 600.0, "ratio": 0.3}, [1e-2])
CREEP = LegTerm("creep", "relaxation", {"time_constant_s": 200.0, "kick": "step"}, [0.2e-6])
ONE_ROW, STATES = (SQUARE, AGAIN, SCALE, SCREW), (LAG, SLACK, HEAT, CREEP)


def with_terms(*terms: LegTerm, legs: tuple[int, ...] = tuple(range(6))) -> ht.Hexapod:
    """Return the reference machine whose legs carry terms."""
    hexapod = ht.load_hexapod("reference")
    model = hexapod.thermal
    laws = [ht.LegLaw(law.sensors, law.A, law.B, terms=terms if k in legs else ()) for k, law in enumerate(model.legs)]
    plates = (ht.PlateLaw(1.6e-6, "T1"), model.base)
    reference = model.reference_temperature_degC[0]
    return dataclasses.replace(hexapod, thermal=ht.ThermalModel(laws, *plates, reference, model.valid_degC))


MACHINE = with_terms(*ONE_ROW)


def motion(rows: int, seed: int = 5) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return poses that rest and move, temperatures that wander, and uneven times."""
    rng = np.random.default_rng(seed)
    some = random_poses(MACHINE, rows, rng)
    poses = some[np.maximum.accumulate(np.where(rng.random(rows) < 0.4, np.arange(rows), 0))]
    temps = 22.0 + np.cumsum(rng.normal(size=(rows, 7)) * 0.1, axis=0)
    return poses, temps, 50.0 + np.cumsum(rng.choice([1.0, 20.0, 300.0], rows))


def seven(temps: np.ndarray) -> tuple[str, np.ndarray]:
    """Return the temperatures' header and rows of a machine with a thermometer on its platform."""
    return f"{SENSORS},platform_T1_degC", temps
