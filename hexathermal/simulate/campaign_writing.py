"""Simulated campaigns as folders, written as a logger would: whole or not at all, never over what was measured."""

from __future__ import annotations

import os
import shutil
import tomllib
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol, TypeAlias

import numpy as np
import numpy.typing as npt
import pyarrow as pa
import pyarrow.parquet
import tomli_w

from hexathermal.errors import ArgumentError
from hexathermal.predict.table_writing import refuse_no_place, say_where

FORMAT = "hexathermal-campaign/1"
CAMPAIGN, RUNS = "campaign.toml", "runs"

Columns: TypeAlias = Mapping[str, tuple[npt.NDArray[Any], int]]
"""Columns of a table, each with its decimals."""


HEXAPOD_KIND, HEXAPOD_FILE = "hexapod", "hexapod.toml"
HEXAPOD_TITLE = "Hexapod: thermal drift of the platform"
COORDINATES = ("x_mm", "y_mm", "z_mm", "rx_deg", "ry_deg", "rz_deg")


class Plan(Protocol):
    """What is said of a run before it is driven."""

    @property
    def name(self) -> str:
        """Name of the run."""

    @property
    def role(self) -> str:
        """What the run is for."""


def run_entries(plans: Iterable[Plan], parquet: bool) -> list[dict[str, str]]:
    """Return what `campaign.toml` says of runs."""
    ending = ".parquet" if parquet else ".csv"
    return [{"name": plan.name, "file": f"{RUNS}/{plan.name}{ending}", "role": plan.role} for plan in plans]


@dataclass(frozen=True, eq=False)
class HexapodTable:
    """What a logger writes of a run of a hexapod, n rows.

    Attributes
    ----------
    time : array, shape (n,) [s]
    commanded, measured : array, shape (n, 6) [mm, deg]
        Coordinates from home.
    q : array, shape (n, 6) [m]
        Displacements by the scales.
    temperatures : mapping of str to array, shape (n,) [degC]
        By the names of the thermometers, as ``leg1_T1``.
    air : array, shape (n,) [degC], or None
    """

    time: npt.NDArray[np.float64]
    commanded: npt.NDArray[np.float64]
    q: npt.NDArray[np.float64]
    temperatures: Mapping[str, npt.NDArray[np.float64]]
    air: npt.NDArray[np.float64] | None
    measured: npt.NDArray[np.float64]


def hexapod_columns(table: HexapodTable) -> Columns:
    """Return the columns of a hexapod's run, each with its decimals."""
    columns: dict[str, tuple[npt.NDArray[Any], int]] = {"time_s": (table.time, 1)}
    columns |= {name: (table.commanded[:, k], 4) for k, name in enumerate(COORDINATES)}
    columns |= {f"leg{leg + 1}_q_mm": (table.q[:, leg] * 1e3, 6) for leg in range(6)}
    columns |= {f"{name}_degC": (values, 3) for name, values in table.temperatures.items()}
    if table.air is not None:
        columns["air_temperature_degC"] = (table.air, 2)
    return columns | {f"measured_{name}": (table.measured[:, k], 6 if k < 3 else 8)
                      for k, name in enumerate(COORDINATES)}  # fmt: skip


def hexapod_form(plans: Iterable[Plan], *, title: str, zero: str, parquet: bool = False) -> dict[str, Any]:
    """Return what `campaign.toml` says of a campaign of a hexapod."""
    return {"format": FORMAT, "kind": HEXAPOD_KIND, "title": title, "zero": zero, "hexapod": HEXAPOD_FILE,
            "runs": run_entries(plans, parquet)}  # fmt: skip


def as_toml(form: dict[str, Any]) -> str:
    """Return a form as TOML, each thermocouple and run under a heading of its own."""
    lists = {key: value for key, value in form.items() if isinstance(value, list)}
    text = tomli_w.dumps({key: value for key, value in form.items() if key not in lists})
    return text + "".join(f"\n[[{key}]]\n{tomli_w.dumps(item)}" for key, items in lists.items() for item in items)


def write_table(path: Path, columns: Columns) -> None:
    """Write the table of a run: Parquet where the name says so, otherwise CSV."""
    rounded = {name: values.round(digits) + 0.0 for name, (values, digits) in columns.items()}
    if path.suffix == ".parquet":
        arrays = {name: values.astype(np.int64) if name == "settled" else values for name, values in rounded.items()}
        pa.parquet.write_table(pa.table(arrays), path)
        return
    row = ",".join(f"%.{digits}f" for _, digits in columns.values())
    lines = [",".join(columns), *(row % tuple(values) for values in np.column_stack([*rounded.values()]).tolist())]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


def write_folder(
    folder: str | Path,
    form: dict[str, Any],
    tables: Iterable[Columns],
    *,
    force: bool = False,
    beside: Mapping[str, Callable[[Path], object]] | None = None,
) -> tuple[Path, ...]:
    """Write a campaign folder, whole or not at all; returns the paths of its files.

    Parameters
    ----------
    folder : str or Path
        Created; its parent must exist.
    form : dict
        What `campaign.toml` says.
    tables : iterable of Columns
        Of the runs, taken one after the other: only one is held in memory.
    force : bool
        Replace a campaign of the same kind that stands there.
    beside : mapping of str to callable, optional
        Further files by name, each with what writes it to a path.

    Raises
    ------
    ArgumentError
        As `check_folder`.
    """
    folder, others = Path(folder), beside or {}
    check_folder(folder, force, form["kind"])
    with new_folder(folder) as part:
        (part / RUNS).mkdir()
        (part / CAMPAIGN).write_text(as_toml(form), encoding="utf-8")
        for name, write in others.items():
            write(part / name)
        for columns, entry in zip(tables, form["runs"], strict=True):
            write_table(part / entry["file"], columns)
    names = (CAMPAIGN, *others, *(entry["file"] for entry in form["runs"]))
    return tuple(folder / name for name in names)


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
    refuse_no_place(folder)
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
    except BaseException as error:
        with suppress(OSError):
            shutil.rmtree(part)
        say_where(error, folder)
        raise
