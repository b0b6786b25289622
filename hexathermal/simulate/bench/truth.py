"""What a simulated campaign truly was made of, for a file of its own: never for the campaign's folder."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

import numpy as np

from hexathermal.simulate.bench.bench import Bench, BenchRun, mounted

FORMAT = "hexathermal-bench-truth/1"


def bench_truth(bench: Bench, seed: int, runs: list[dict[str, Any]]) -> dict[str, Any]:
    """Return the parameters, the instruments' constant errors and the runs of a campaign, ready for JSON; SI units."""
    instruments = mounted(bench, seed)
    thermocouples, beams = instruments.thermocouples, instruments.interferometers
    return {
        "format": FORMAT,
        "seed": seed,
        "parameters": asdict(bench),
        "thermocouples": {
            name: {"offset_K": float(offset), "gain": float(gain), "contact_error": float(contact)}
            for (name, _part, _position), offset, gain, contact in zip(
                bench.thermocouples.places, thermocouples.offset, thermocouples.gain, thermocouples.contact_error,
                strict=True,
            )
        },
        "beams": {
            "radius_m": beams.radii.tolist(),
            "optics_m_per_K": beams.optics.tolist(),
            "misalignment_rad": beams.angles.tolist(),
            "tilt_rad_per_m": beams.tilt_with_q.tolist(),
        },
        "station_errors": dict(zip(("temperature_K", "pressure_Pa", "humidity"), instruments.station, strict=True)),
        "runs": runs,
    }  # fmt: skip


def run_truth(run: BenchRun) -> dict[str, Any]:
    """Return the true course of a run, ready for JSON: one entry a row of its log."""
    truth = run.truth
    return {
        "name": run.name,
        "role": run.role,
        "growth_um": (truth.growth * 1e6).round(5).tolist(),
        "mechanical_um": (truth.mechanical * 1e6).round(5).tolist(),
        "room_degC": truth.weather.temperature.round(5).tolist(),
    }


def run_summary(run: BenchRun) -> dict[str, Any]:
    """Return a run in numbers, from what was written of it alone, ready for JSON."""
    settled, rise = run.settled, run.temperatures - run.temperatures[0]
    drift = run.drift()[settled] * 1e6
    return {
        "name": run.name,
        "role": run.role,
        "hours": float(run.time[-1] / 3600.0),
        "rows": int(run.time.size),
        "settled_percent": round(100.0 * float(settled.mean()), 2),
        "q_lowest_mm": round(float(run.q.min()) * 1e3, 5),
        "q_highest_mm": round(float(run.q.max()) * 1e3, 5),
        "largest_rise_K": round(float(rise.max()), 3),
        "room_lowest_degC": round(float(run.weather.temperature.min()), 2),
        "room_highest_degC": round(float(run.weather.temperature.max()), 2),
        "largest_drift_um": round(float(np.abs(drift).max()), 3),
        "mean_drift_um": round(float(np.abs(drift).mean()), 3),
    }
