"""Campaigns as arrays: own names and Parquet, datasets, NetCDF, fingerprint, whole machines."""

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.csv
import pyarrow.parquet
import pytest

from hexathermal.errors import ArgumentError, FileFormatError, UnknownNameError
from hexathermal.learn.campaign_dataset import fingerprint, read_run, save_campaign_netcdf
from hexathermal.learn.campaign_files import load_campaign
from hexathermal.learn.cleaning import used_run

from .campaign_folders import Table, campaign_text, component_campaign, leg_campaign, leg_table, messages, write_table


def test_a_folder_without_campaign_is_refused(tmp_path: Path) -> None:
    """No folder, no campaign.toml, no TOML, no text: an error of the package, with what to give instead."""
    with pytest.raises(ArgumentError, match="no campaign at"):
        load_campaign(tmp_path)
    (tmp_path / "campaign.toml").write_text('format = "x')
    with pytest.raises(FileFormatError, match="not valid TOML"):
        load_campaign(tmp_path)
    (tmp_path / "campaign.toml").write_bytes(b"\xff\xfe")
    with pytest.raises(FileFormatError, match="UTF-8"):
        load_campaign(tmp_path)


@pytest.mark.parametrize("ending", ["csv", "parquet"])
def test_own_names_and_parquet_give_the_same_rows(tmp_path: Path, ending: str) -> None:
    """A table with own column names, as CSV or Parquet, gives the rows of the plain one; unknown columns are kept."""
    table = leg_table(5)
    write_table(tmp_path / "plain" / "runs" / "a.csv", table)
    (tmp_path / "plain" / "campaign.toml").write_text(campaign_text({"a": "identification"}))
    own = {"q_mm": "Position (mm)", "time_s": "t", "T01_degC": "Kanal 1"}
    other: Table = {own.get(name, name): values for name, values in table.items()} | {"motor_W": table["time_s"] * 0.5}
    write_table(tmp_path / "own" / "runs" / "a.csv", other)
    text = campaign_text({"a": "identification"}) + "[columns]\n"
    text += "".join(f'{name} = "{mine}"\n' for name, mine in own.items())
    if ending == "parquet":
        source = tmp_path / "own" / "runs" / "a.csv"
        pa.parquet.write_table(pa.csv.read_csv(source), source.with_suffix(".parquet"))
        text = text.replace("runs/a.csv", "runs/a.parquet")
    (tmp_path / "own" / "campaign.toml").write_text(text)
    campaigns = [load_campaign(tmp_path / name) for name in ("plain", "own")]
    (one, _), (two, _) = (used_run(campaign, "a") for campaign in campaigns)
    assert np.array_equal(one.dT, two.dT)
    assert np.array_equal(one.drift, two.drift)
    data = read_run(campaigns[1], "a")
    assert data.attrs["unknown_columns"] == "motor_W"
    assert np.array_equal(data["motor_W"], table["time_s"] * 0.5)


def test_a_dataset_holds_the_table_as_recorded(tmp_path: Path) -> None:
    """Every number of the table is in the dataset, in SI units with its unit named; nothing is left out."""
    table = leg_table(0)
    table["T01_degC"][5], table["T02_degC"][6] = -180.0, np.nan
    leg_campaign(tmp_path, edit=lambda _table: table)
    data = read_run(load_campaign(tmp_path), "a")
    assert data["temperature"].sel(thermocouple="T01")[5] == -180.0
    assert np.isnan(data["temperature"].sel(thermocouple="T02")[6])
    assert np.allclose(data["q"], table["q_mm"] * 1e-3, rtol=1e-15)
    assert np.allclose(data["air_pressure"], table["air_pressure_hPa"] * 100.0)
    units = {name: data[name].attrs["units"] for name in ("temperature", "beam", "q", "air_pressure", "time")}
    assert units == {"temperature": "degree_Celsius", "beam": "m", "q": "m", "air_pressure": "Pa", "time": "s"}
    assert data["air_temperature"].attrs["standard_name"] == "air_temperature"
    assert data.attrs["Conventions"].startswith("CF-")
    assert str(tmp_path) not in str(data.attrs)
    with pytest.raises(UnknownNameError, match="there are: a, b, c"):
        read_run(load_campaign(tmp_path), "d")


def test_netcdf_gives_back_every_run(tmp_path: Path) -> None:
    """A saved campaign is opened by xarray group by group and is what was read; an existing file is kept."""
    xr = pytest.importorskip("xarray")
    pytest.importorskip("h5py", reason="h5py is not installed")
    campaign = load_campaign(component_campaign(tmp_path))
    file = save_campaign_netcdf(campaign, tmp_path / "all.nc")
    for run in campaign.runs:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            with xr.open_dataset(file, group=run.name, engine="h5netcdf") as opened:
                assert opened.identical(read_run(campaign, run))
    with xr.open_dataset(file, engine="h5netcdf") as top:
        assert top.attrs["fingerprint_sha256"] == fingerprint(campaign)
    with pytest.raises(ArgumentError, match="exists already"):
        save_campaign_netcdf(campaign, file)


def test_a_full_disk_is_one_error_and_leaves_nothing(tmp_path: Path) -> None:
    """Where no more can be written HDF5 is not left half closed, which ends the process: one error, and no file."""
    pytest.importorskip("h5py", reason="h5py is not installed")
    resource = pytest.importorskip("resource", reason="no limits of files here")
    campaign = load_campaign(component_campaign(tmp_path))
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (10_000, before[1]))
    try:
        with pytest.raises(OSError, match="too large"):
            save_campaign_netcdf(campaign, tmp_path / "all.nc")
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    assert not list(tmp_path.glob("all.nc*"))


def test_the_fingerprint_is_that_of_the_contents(tmp_path: Path) -> None:
    """A copied campaign has the same fingerprint, one changed digit another."""
    one = fingerprint(load_campaign(leg_campaign(tmp_path / "one")))
    assert fingerprint(load_campaign(leg_campaign(tmp_path / "two"))) == one
    file = tmp_path / "two" / "runs" / "c.csv"
    text = file.read_text()
    file.write_text(text[:-2] + ("1" if text[-2] != "1" else "2") + "\n")
    assert fingerprint(load_campaign(tmp_path / "two")) != one


def test_a_campaign_of_a_whole_machine_is_read(tmp_path: Path) -> None:
    """Kind hexapod: thermometers are found in the header, poses and strokes are in SI units; the machine must exist."""
    pose = [
        f"{axis}_{unit}" for axis, unit in zip(("x", "y", "z", "rx", "ry", "rz"), ["mm"] * 3 + ["deg"] * 3, strict=True)
    ]
    names = ["time_s", *pose, *(f"leg{k}_q_mm" for k in range(1, 7)), *(f"leg{k}_T1_degC" for k in range(1, 7)),
             "platform_T1_degC", "air_temperature_degC", *(f"measured_{name}" for name in pose)]  # fmt: skip
    write_table(tmp_path / "a.csv", {name: np.arange(5.0) + k for k, name in enumerate(names)})
    text = 'format = "hexathermal-campaign/1"\nkind = "hexapod"\nhexapod = "machine"\n'
    text += '[[runs]]\nname = "a"\nfile = "a.csv"\nrole = "identification"\n'
    (tmp_path / "campaign.toml").write_text(text)
    assert "there is no machine file" in messages(tmp_path)[0]
    (tmp_path / "machine").mkdir()
    (tmp_path / "machine" / "hexapod.toml").write_text("")
    assert "hexapod names a folder" in messages(tmp_path)[0]
    (tmp_path / "campaign.toml").write_text(text.replace('"machine"', '"machine/hexapod.toml"'))
    campaign = load_campaign(tmp_path)
    assert campaign.sensors == (*(f"leg{k}_T1" for k in range(1, 7)), "platform_T1")
    data = read_run(campaign, "a")
    assert data["leg_q"].shape == (5, 6)
    assert np.allclose(data["measured_rz"], np.radians(np.arange(5.0) + len(names) - 1))
    with pytest.raises(ArgumentError, match="measures poses"):
        used_run(campaign, "a")
