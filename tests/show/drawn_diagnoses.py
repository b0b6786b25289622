"""Diagnoses made by hand, small and awkward: what a report must stand."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from hexathermal.learn.diagnosis.channels import Levels
from hexathermal.learn.diagnosis.result import (
    Candidate,
    Confusion,
    Diagnosis,
    Effect,
    Experiment,
    Limit,
    Quantity,
    RunResidual,
)
from hexathermal.learn.law import IdentifiedLaw, Origin, Validity
from hexathermal.learn.noise import ResidualNoise
from hexathermal.learn.sensor_errors import SensorErrors
from hexathermal.learn.validation_gain import Gain, RunGain
from hexathermal.learn.validation_scores import Figure
from hexathermal.machine.leg_terms import LegTerm

UM = 1e-6


def plain_law(kind: str = "leg") -> IdentifiedLaw:
    """Return a law of T07."""
    size = 2 if kind == "leg" else 1
    return IdentifiedLaw(
        kind, ("T07",), np.full(size, 2e-6), np.eye(size) * 1e-16, 0.6 if kind == "leg" else None, None, "run",
        Validity(np.array([[-2.0, 8.0]])), ResidualNoise(2e-8, 1e-7, 5e-8, 3000.0, 0.0),
        SensorErrors(np.full(1, 0.03), np.full(1, 0.05), 3000.0), 1.97, Origin("drawn", "0", ("a",), "by hand"),
    )  # fmt: skip


def extended(law: IdentifiedLaw) -> IdentifiedLaw:
    """Return the law with backlash in it."""
    size = len(law.coefficients)
    term = LegTerm("backlash", "direction", {}, np.array([0.31 * UM]), np.array([[4e-16]]))
    return replace(law, terms=(term,), joint_covariance=np.eye(size + 1) * 1e-16)


def run_of(name: str, role: str, seed: int, windows: int = 60) -> RunResidual:
    """Return a run whose residual is a step of 0.3 um at reversals, which is gone afterwards."""
    rng = np.random.default_rng(seed)
    time = 120.0 * np.arange(windows)
    direction = np.where(rng.random(windows) < 0.5, -1.0, 1.0)
    noise = 0.03 * UM * rng.standard_normal(windows)
    signals = {"q": 0.1 + 0.1 * rng.random(windows), "direction": direction, "dT": 3.0 * np.sin(time / 3000.0),
               "rate": np.cos(time / 3000.0) / 1000.0, "since_move": rng.exponential(300.0, windows),
               "pressure": np.full(windows, 1e5)}  # fmt: skip
    step = 0.15 * UM * direction
    return RunResidual(name, role, time, step + noise + 4 * UM * np.sin(time / 3000.0), step + noise, noise, signals)


def _gain(runs: list[str]) -> Gain:
    """Return a gain of one half on every run."""
    half = Figure(0.5, 0.3, 0.6)
    one = RunGain(0.2 * UM, 0.6 * UM, Figure(0.1 * UM, 0.08 * UM, 0.13 * UM), Figure(0.3 * UM, 0.2 * UM, 0.4 * UM),
                  half, half, half)  # fmt: skip
    return Gain(dict.fromkeys(runs, one), one)


BACKLASH = Effect(
    "backlash", None, {"step_um": Quantity(0.31, 0.01, "um"), "pitch_m": Quantity(2e-3, float("nan"), "m")}, {}, 0.98,
    ("creep",), 0.15 * UM, "The residual is backlash of 0.31 ± 0.01 um.", True,
)  # fmt: skip

CANDIDATES = (
    Candidate("backlash", None, 120.0, 0.98, 0.15 * UM, {}),
    Candidate("creep", None, 80.0, 0.02, 0.12 * UM, {"time_constant_s": np.float64(20.0), "kick": "step"}),
    Candidate("follows the way travelled", "travel", -1.4, 0.0, 0.02 * UM, {"bumps": np.int64(6)}),
)


def drawn(verdict: str = "effect", kind: str = "leg", held: bool = True, **more: Any) -> Diagnosis:
    """Return a diagnosis of a verdict; `held` says whether there are runs for validation."""
    law = plain_law(kind)
    effect = verdict == "effect"
    runs = [run_of("warm <b>up</b>", "identification", 1), run_of("a/b", "identification", 2)]
    runs += [run_of("proof & test", "validation", 3), run_of("proof + test", "validation", 4)] if held else []
    given: dict[str, Any] = {
        "verdict": verdict, "probability": 0.98, "effects": (BACKLASH,) if effect else (),
        "follows": "follows the humidity" if verdict == "unexplained" else None, "candidates": CANDIDATES, "law": law,
        "extended": extended(law) if effect else law,
        "gain": _gain([run.run for run in runs if run.role == "validation"]) if held else None,
        "reachable": 0.09 * UM if held else None, "noise": Levels(0.02 * UM, 0.05 * UM, 0.03 * UM, 0.01 * UM),
        "threshold": 6.0,
        "limits": (Limit("backlash", 0.02 * UM, 0.03 * UM), Limit("scale-error", 0.02 * UM, 0.4 * UM)),
        "confusions": (Confusion(("sensor-drift", "zero-drift"), np.float64(0.3)),),
        "experiments": (Experiment("Approach from both sides.", ("backlash", "backlash", "creep"), 120.0),),
        "residuals": tuple(runs), "title": 'bench <1> & "more"', "notes": ("a note of a < b",),
    }  # fmt: skip
    return Diagnosis(**{**given, **more})
