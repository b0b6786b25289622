"""A simulated campaign as a folder, written as a logger would: nothing in it tells that no bench stood behind it."""

from __future__ import annotations

import os
import shutil
import tomllib
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.csv
import pyarrow.parquet
import tomli_w

from hexathermal.errors import ArgumentError
from hexathermal.simulate.bench.bench import Bench, BenchRun, RunPlan

FORMAT = "hexathermal-campaign/1"
CAMPAIGN, RUNS = "campaign.toml", "runs"
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
        "runs": [
            {"name": plan.name, "file": f"{RUNS}/{plan.name}{'.parquet' if parquet else '.csv'}", "role": plan.role}
            for plan in plans
        ],
    }


def as_toml(form: dict[str, Any]) -> str:
    """Return a form as TOML, each thermocouple and run under a heading of its own."""
    lists = {key: value for key, value in form.items() if isinstance(value, list)}
    text = tomli_w.dumps({key: value for key, value in form.items() if key not in lists})
    return text + "".join(f"\n[[{key}]]\n{tomli_w.dumps(item)}" for key, items in lists.items() for item in items)


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


def write_run(path: Path, bench: Bench, run: BenchRun) -> None:
    """Write the table of a run: Parquet where the name says so, otherwise CSV."""
    columns = run_columns(bench, run)
    if path.suffix == ".parquet":
        arrays = {
            name: values.astype(np.int64) if name == "settled" else values.round(digits)
            for name, (values, digits) in columns.items()
        }
        pa.parquet.write_table(pa.table(arrays), path)
        return
    texts = [[f"{value:.{digits}f}" for value in values.round(digits) + 0.0] for values, digits in columns.values()]
    lines = [",".join(columns), *(",".join(row) for row in zip(*texts, strict=True))]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


def check_folder(folder: Path, force: bool, kind: str = "leg") -> None:
    """Refuse a folder that holds something else than a campaign of a kind, or one unless it may be replaced.

    Raises
    ------
    ArgumentError
        Says what was found there and what to do.
    """
    if folder.is_symlink() or (folder.exists() and not folder.is_dir()):
        raise ArgumentError(f"cannot write {folder}: it is a link or no folder; give the name of a new folder")
    if folder.resolve() == Path.cwd():
        raise ArgumentError(f"cannot write {folder}: it is the folder you are in; give the name of a new folder")
    parent = folder.absolute().parent
    if not parent.is_dir():
        raise ArgumentError(f"cannot write {folder}: there is no folder {parent}; create it first")
    if not os.access(parent, os.W_OK | os.X_OK):
        raise ArgumentError(f"cannot write {folder}: permission denied in {parent}")
    if not folder.is_dir() or not any(folder.iterdir()):
        return
    foreign = sorted(set(_files(folder)) - _campaign_files(folder, kind))
    if foreign:
        raise ArgumentError(
            f"{folder} holds what no campaign of kind {kind!r} has: {', '.join(foreign[:5])}"
            f"{', ...' if len(foreign) > 5 else ''}; it is not touched, not even with --force: give another folder"
        )
    if not force:
        raise ArgumentError(
            f"{folder} holds a campaign already, and nobody can tell a simulated one from a measured one; give another "
            "folder, or --force to replace it"
        )


def _files(folder: Path) -> Iterator[str]:
    """Return the files below a folder, and its empty folders and links, as relative names."""
    for item in folder.rglob("*"):
        if item.is_symlink() or not item.is_dir() or not any(item.iterdir()):
            yield item.relative_to(folder).as_posix()


def _campaign_files(folder: Path, kind: str) -> set[str]:
    """Return the names of the files that a folder's `campaign.toml` stands for; none where it is of another kind."""
    try:
        found = tomllib.loads((folder / CAMPAIGN).read_text(encoding="utf-8"))
        files = {run["file"] for run in found["runs"]}
    except (OSError, ValueError, KeyError, TypeError):
        return set()
    if found.get("format") != FORMAT or found.get("kind") != kind:
        return set()
    return {CAMPAIGN, *files, *([found["hexapod"]] if isinstance(found.get("hexapod"), str) else [])}


@contextmanager
def new_folder(folder: Path) -> Iterator[Path]:
    """Give a folder beside `folder` to fill; it takes its place at the end, or vanishes on any error."""
    part = folder.absolute().with_name(folder.absolute().name + ".part")
    try:
        part.mkdir()
    except FileExistsError:
        raise ArgumentError(
            f"{part} exists: another run is writing it, or was killed; remove it if none is, and try again"
        ) from None
    try:
        yield part
        old = part.with_name(part.name + ".old")
        if folder.exists():
            os.replace(folder, old)
        try:
            os.replace(part, folder)
        except BaseException:
            if old.exists():
                os.replace(old, folder)
            raise
        shutil.rmtree(old, ignore_errors=True)
    except BaseException:
        with suppress(OSError):
            shutil.rmtree(part)
        raise


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
    folder = Path(folder)
    check_folder(folder, force)
    form = campaign_form(bench, plans, title=title, parquet=parquet)
    with new_folder(folder) as part:
        (part / RUNS).mkdir()
        (part / CAMPAIGN).write_text(as_toml(form), encoding="utf-8")
        for run, entry in zip(runs, form["runs"], strict=True):
            write_run(part / entry["file"], bench, run)
    return (folder / CAMPAIGN, *(folder / entry["file"] for entry in form["runs"]))
