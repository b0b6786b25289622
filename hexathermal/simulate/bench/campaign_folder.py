"""A simulated campaign as a folder, written as a logger would: nothing in it tells that no bench stood behind it."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np

from hexathermal.simulate.bench.bench import Bench, BenchRun, RunPlan
from hexathermal.simulate.campaign_writing import FORMAT, run_entries, write_folder

TITLE = "Leg test bench: thermal expansion"


def campaign_form(
    bench: Bench, plans: Iterable[RunPlan], *, title: str = TITLE, parquet: bool = False
) -> dict[str, Any]:
    """Return what `campaign.toml` says of a campaign on the bench."""
    leg, beams = bench.leg, bench.interferometers
    return {
        "format": FORMAT,
        "kind": "leg",
        "title": title,
        "leg": {"q0_mm": _mm(leg.retracted_length), "stroke_mm": [_mm(edge) for edge in leg.stroke]},
        "interferometer": {
            "radius_mm": _mm(beams.radius),
            "azimuth_deg": [round(float(np.degrees(azimuth)), 6) for azimuth in beams.azimuths],
            "dead_path_mm": _mm(beams.dead_path),
            "index_compensated": beams.index_compensated,
        },
        "thermocouples": [
            {"name": name, "part": part, "position_mm": _mm(position)}
            for name, part, position in bench.thermocouples.places
        ],
        "runs": run_entries(plans, parquet),
    }


def _mm(metres: float) -> float:
    """Return metres as millimetres."""
    return round(metres * 1e3, 6)


def run_columns(bench: Bench, run: BenchRun) -> dict[str, tuple[np.ndarray[Any, Any], int]]:
    """Return the columns of a run's table, each with its decimals: what a logger writes."""
    names = [name for name, _part, _position in bench.thermocouples.places]
    whole = bool((run.time == np.round(run.time)).all())
    columns = {"time_s": (run.time, 0 if whole else 3), "q_mm": (run.q * 1e3, 5), "settled": (run.settled * 1.0, 0)}
    columns |= {f"{name}_degC": (run.temperatures[:, k], 3) for k, name in enumerate(names)}
    columns |= {f"beam{k + 1}_mm": (run.beams[:, k] * 1e3, 6) for k in range(3)}
    return columns | {
        "air_temperature_degC": (run.weather.temperature, 2),
        "air_pressure_hPa": (run.weather.pressure * 1e-2, 2),
        "air_humidity_percent": (run.weather.humidity * 1e2, 1),
    }


def write_campaign(
    folder: str | Path,
    bench: Bench,
    plans: tuple[RunPlan, ...],
    runs: Iterable[BenchRun],
    *,
    title: str = TITLE,
    parquet: bool = False,
    force: bool = False,
) -> tuple[Path, ...]:
    """Write a campaign folder, whole or not at all; returns the paths of its files.

    Parameters
    ----------
    folder : str or Path
        Created; its parent must exist.
    bench : Bench
    plans : tuple of RunPlan
        Of all runs.
    runs : iterable of BenchRun
        Taken one after the other: only one is held in memory.
    title : str
    parquet : bool
        Write the runs as Parquet; default CSV.
    force : bool
        Replace a campaign that stands there.

    Raises
    ------
    ArgumentError
        The folder holds something else, or a campaign without `force`, or cannot be written.

    Examples
    --------
    >>> from tempfile import TemporaryDirectory
    >>> from hexathermal.simulate.bench.bench import planned_runs, simulate_bench
    >>> bench = Bench()
    >>> plans = planned_runs(bench, 1, identification=1, validation=0, duration=1800.0)
    >>> with TemporaryDirectory() as place:
    ...     files = write_campaign(Path(place) / "leg", bench, plans, simulate_bench(bench, 1, plans))
    >>> [file.name for file in files]
    ['campaign.toml', 'run-01.csv']
    """
    form = campaign_form(bench, plans, title=title, parquet=parquet)
    return write_folder(folder, form, (run_columns(bench, run) for run in runs), force=force)
