"""A run as labelled arrays with units (xarray), raw as its table gives it, and a campaign as one NetCDF file.

Units are those of the core: metres, radians, pascals, seconds and 1; temperatures stay degrees Celsius. Attributes
follow the CF conventions, version 1.11.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from hexathermal.errors import ArgumentError, DataError
from hexathermal.learn.campaign import Campaign, RunFile
from hexathermal.learn.campaign_columns import Column
from hexathermal.learn.campaign_streams import RunTable
from hexathermal.learn.cleaning import run_named
from hexathermal.poses import FloatArray

if TYPE_CHECKING:
    import xarray as xr

CONVENTIONS = "CF-1.11"
GROUPED: dict[str, tuple[str, str | None, str]] = {
    "temperature": ("temperature", "thermocouple", "temperature at the thermocouples"),
    "beam": ("beam", "beam_number", "change of length read by an interferometer beam since the run's first row"),
    "input": ("input", "input_name", "recorded inputs, in the file's own units"),
    "leg_q": ("leg_q", "leg", "displacement of a leg's rod"),
}
"""Parts of a table that become one variable: its name, its second dimension, and what it is."""

SINGLE = {
    "q_mm": ("q", "displacement of the rod read by the scale, 0 where it is retracted", None),
    "settled": ("settled", "1 where the part rests, 0 while it moves or vibrates", None),
    "drift_um": ("drift", "measured displacement of the component", None),
    "air_temperature_degC": ("air_temperature", "temperature of the air along the beams", "air_temperature"),
    "air_pressure_hPa": ("air_pressure", "pressure of the air along the beams", "air_pressure"),
    "air_humidity_percent": ("air_humidity", "relative humidity of the air along the beams", "relative_humidity"),
}
"""Columns that are variables of their own: name, what it is, and the CF standard name where there is one."""

Progress = Callable[[int, int, str], None]


def read_run(campaign: Campaign, run: RunFile | str) -> xr.Dataset:
    """Return a run as it stands in its table, labelled and in SI units; nothing is left out, zeroed or repaired.

    Parameters
    ----------
    campaign : Campaign
    run : RunFile or str
        A run, or its name.

    Returns
    -------
    dataset : xarray.Dataset
        Dimensions `sample`, `thermocouple`, `beam_number`, `input_name`, `leg`; missing numbers are NaN. Columns that
        the format does not know keep their names and are listed in the attribute `unknown_columns`.

    Raises
    ------
    CampaignError
        The table is at fault.
    """
    import pyarrow as pa
    import xarray as xr

    chosen = run_named(campaign, run)
    table = RunTable(campaign, chosen)
    parts = list(table)
    if not parts:
        raise DataError(f"run {chosen.name!r} has no rows")
    numbers = np.concatenate([part.numbers for part in parts])
    data = xr.Dataset(attrs=_attributes(campaign, chosen, table.others))
    for part, (name, dimension, words) in GROUPED.items():
        chosen_columns = [k for k, column in enumerate(table.columns) if column.part == part]
        if chosen_columns:
            columns = [table.columns[k] for k in chosen_columns]
            data[name] = (("sample", dimension), _si(numbers[:, chosen_columns], columns), _units(columns[0], words))
            data = data.assign_coords({dimension: _labels(campaign, part, columns)})
    for k, column in enumerate(table.columns):
        if column.part not in GROUPED:
            name, words, standard = _single(column)
            attributes = _units(column, words) | ({"standard_name": standard} if standard else {})
            data[name] = ("sample", _si(numbers[:, [k]], [column])[:, 0], attributes)
    for k, name in enumerate(table.others):
        values = pa.chunked_array([part.extras[k] for part in parts]).to_pylist()
        data[_free(name, data)] = ("sample", _plain_column(values), {"long_name": f"column {name}, not of the format"})
    data = data.set_coords("time")
    dataset: xr.Dataset = _with_positions(campaign, data)
    return dataset


def _attributes(campaign: Campaign, run: RunFile, others: tuple[str, ...]) -> dict[str, Any]:
    """Return the attributes of a run's dataset; no path of this machine is in them."""
    from hexathermal import __version__

    history = f"read from the campaign's table {run.path.name} by hexathermal {__version__}; values as recorded"
    found: dict[str, Any] = {"Conventions": CONVENTIONS, "title": campaign.title or "campaign without a title",
                             "history": history, "run": run.name, "role": run.role, "campaign_kind": campaign.kind,
                             "zero": campaign.zero, "unknown_columns": ", ".join(others)}  # fmt: skip
    if campaign.leg is not None:
        low, high = campaign.leg.stroke
        found |= {"retracted_length_m": campaign.leg.retracted_length, "stroke_m": [low, high]}
    if campaign.beams is not None:
        layout = campaign.beams
        found |= {"beam_radius_m": layout.radius, "beam_azimuths_rad": list(layout.azimuths),
                  "dead_path_m": layout.dead_path, "index_compensated": int(layout.index_compensated)}  # fmt: skip
    return found


def _si(numbers: FloatArray, columns: list[Column]) -> FloatArray:
    """Return columns in the core's units."""
    return np.asarray(numbers * np.array([column.si[0] for column in columns]))


def _units(column: Column, words: str) -> dict[str, Any]:
    """Return unit and long name of a variable; an input's unit is not known."""
    unit = column.si[1]
    if column.part == "settled":
        unit = "1"
    return {"long_name": words} | ({"units": unit} if unit else {})


def _single(column: Column) -> tuple[str, str, str | None]:
    """Return name, meaning and CF standard name of a column that is a variable of its own."""
    if column.part == "time":
        return "time", "time since the beginning of the table's clock", None
    if column.name in SINGLE:
        return SINGLE[column.name]
    stem = column.name.rpartition("_")[0]
    which = "measured" if column.part == "measured" else "commanded"
    axis = stem.removeprefix("measured_")
    return stem, f"{which} pose of the platform in the base frame, {axis}, 0 at home", None


def _labels(campaign: Campaign, part: str, columns: list[Column]) -> list[Any]:
    """Return the labels of the second dimension of a variable."""
    if part == "temperature":
        return list(campaign.sensors)
    return [column.name for column in columns] if part == "input" else list(range(1, len(columns) + 1))


def _free(name: str, data: Any) -> str:
    """Return a name for a column that is not taken yet and that NetCDF allows."""
    name = name.replace("/", "_per_") or "column"
    return name if name not in data.variables and name not in data.dims else f"column_{name}"


def _plain_column(values: list[Any]) -> Any:
    """Return an unknown column as numbers where all its fields are such, else as texts."""
    try:
        return np.array([np.nan if value in (None, "") else float(value) for value in values])
    except (TypeError, ValueError):
        return np.array(["" if value is None else str(value) for value in values], dtype=object)


def _with_positions(campaign: Campaign, data: Any) -> Any:
    """Return a dataset with where the thermocouples sit."""
    if "thermocouple" not in data.dims:
        return data
    position = [np.nan if item.position is None else item.position for item in campaign.thermocouples]
    words = "distance along the leg from the lower joint's centre, rod retracted"
    part = np.array([item.part for item in campaign.thermocouples], dtype=object)
    data = data.assign_coords(part=("thermocouple", part, {"long_name": "part that the thermocouple sits on"}))
    return data.assign_coords(position=("thermocouple", position, {"long_name": words, "units": "m"}))


def refuse_netcdf(out: Path, overwrite: bool) -> None:
    """Refuse a NetCDF file that must not or cannot be written, before any work is done."""
    from hexathermal.predict.table_writing import refuse_no_folder

    if out.suffix != ".nc":
        raise ArgumentError(f"cannot write {out}: the name of a NetCDF file ends in .nc")
    if out.exists() and not overwrite:
        raise ArgumentError(f"{out} exists already; give another name, or ask for it to be overwritten (--force)")
    refuse_no_folder(out)


def save_campaign_netcdf(
    campaign: Campaign, path: str | Path, *, overwrite: bool = False, progress: Progress | None = None
) -> Path:
    """Write a campaign as one NetCDF file, a group for each run; returns the path.

    ``xarray.open_dataset(path, group="run-01", engine="h5netcdf")`` gives what `read_run` gives. The file is
    made in memory, compressed, and written at the end: HDF5 cannot be closed on a disk that is full.

    Parameters
    ----------
    campaign : Campaign
    path : str or Path
        Its name ends in ``.nc``.
    overwrite : bool
    progress : callable, optional
        Called as ``progress(done, total, label)``.

    Raises
    ------
    ArgumentError
        The file exists and `overwrite` is false, or cannot be written.
    """
    import io

    import xarray as xr

    from hexathermal.predict.table_writing import written_whole

    out = Path(path)
    refuse_netcdf(out, overwrite)
    count = len(campaign.runs)
    whole = io.BytesIO()
    top = xr.Dataset(attrs={"Conventions": CONVENTIONS, "title": campaign.title or "campaign without a title",
                            "history": "one group for each run, values as recorded",
                            "campaign_kind": campaign.kind, "runs": [run.name for run in campaign.runs],
                            "fingerprint_sha256": fingerprint(campaign)})  # fmt: skip
    top.to_netcdf(whole, mode="w", engine="h5netcdf")
    for k, run in enumerate(campaign.runs):
        if progress is not None:
            progress(k, count, f"writing {run.name}")
        data = read_run(campaign, run)
        packed = {name: {"zlib": True, "complevel": 4} for name in data.data_vars if data[name].dtype.kind == "f"}
        data.to_netcdf(whole, mode="a", group=run.name, engine="h5netcdf", encoding=packed)
    with written_whole(out) as part:
        part.write_bytes(whole.getbuffer())
    return out


def fingerprint(campaign: Campaign) -> str:
    """Return the SHA-256 of a campaign: of its `campaign.toml` and all its tables, in the order of the runs.

    Names of folders and times of files do not enter; one changed digit changes it.
    """
    whole = hashlib.sha256()
    for file in (campaign.file, *(run.path for run in campaign.runs)):
        whole.update(table_digest(file))
    return whole.hexdigest()


def table_digest(file: Path) -> bytes:
    """Return the SHA-256 of a file."""
    try:
        with file.open("rb") as stream:
            return hashlib.file_digest(stream, "sha256").digest()
    except OSError as error:
        raise ArgumentError(f"{file} cannot be read: {error.strerror or error}") from None
