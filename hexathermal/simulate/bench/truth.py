"""What a simulated campaign truly was made of, for a file of its own: never for the campaign's folder."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

import numpy as np

from hexathermal.poses import FloatArray
from hexathermal.simulate.bench.bench import Bench, BenchRun, mounted

FORMAT = "hexathermal-bench-truth/1"


def law_sums(bench: Bench, run: BenchRun, seed: int) -> FloatArray:
    """Return the normal equations of eq. 4 for each single thermometer, shape (2, s, 2, 3), from what truly happened.

    First with the temperatures of the surfaces, then with what the thermocouples read of them without noise and bias
    (contact, gain). Growth without mechanics and lasers, settled rows, zeroed at the run's first row. Sums of runs add.
    """
    truth, thermocouples = run.truth, mounted(bench, seed).thermocouples
    surfaces = thermocouples.surfaces(truth.history)
    drift = (truth.growth - truth.growth[0])[truth.settled]
    found = []
    for read in (surfaces, thermocouples.quiet(surfaces, truth.weather.temperature)):
        dT = (read - read[0])[truth.settled]
        x = np.stack([bench.leg.retracted_length * dT, truth.q[truth.settled][:, None] * dT])
        left = np.einsum("ins,jns->sij", x, x)
        found.append(np.concatenate([left, np.einsum("ins,n->si", x, drift)[..., None]], axis=-1))
    return np.array(found)


def _laws(bench: Bench, sums: FloatArray | None) -> dict[str, Any]:
    """Return the laws that the truth obeys: exactly where the leg is warm all over, at best where it is not."""
    leg = bench.leg
    cold = np.zeros(leg.size)
    retracted, out = (float(leg.growth(cold[None] + 1.0, np.array([q]), cold)[0]) for q in (0.0, 1e-3))
    laws: dict[str, Any] = {
        "homogeneous": {"A_per_K": retracted / leg.retracted_length, "B_per_K": (out - retracted) / 1e-3}
    }
    if sums is not None:
        names = [name for name, _part, _place in bench.thermocouples.places]
        for kind, of_all in zip(("effective", "as_read"), sums, strict=True):
            found = [np.linalg.lstsq(part[:, :2], part[:, 2])[0] for part in of_all]
            laws[kind] = {
                name: {"A_per_K": float(a), "B_per_K": float(b)} for name, (a, b) in zip(names, found, strict=True)
            }
    return laws


def bench_truth(bench: Bench, seed: int, runs: list[dict[str, Any]], sums: FloatArray | None = None) -> dict[str, Any]:
    """Return what a campaign was made of, ready for JSON; SI units.

    Parameters
    ----------
    bench : Bench
    seed : int
    runs : list of dict
        See `run_truth`.
    sums : array, shape (2, s, 2, 3), optional
        Of the runs for identification, see `law_sums`; gives the coefficients of each thermometer: ``effective``, those
        of the surface under it, and ``as_read``, those of its own readings, which a campaign can find.
    """
    instruments = mounted(bench, seed)
    thermocouples, beams = instruments.thermocouples, instruments.interferometers
    return {
        "format": FORMAT,
        "seed": seed,
        "laws": _laws(bench, sums),
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
