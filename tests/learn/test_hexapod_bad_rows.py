"""A whole machine's rows that tell nothing: constant temperatures, missing codes, misspelt names; said, never nan."""

from __future__ import annotations

import csv
import json
import math
import re
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

from hexathermal.cli import main
from hexathermal.errors import DataError
from hexathermal.learn.campaign_files import load_campaign
from hexathermal.learn.hexapod_data import hexapod_rows


@pytest.fixture(scope="module")
def campaign(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A small simulated campaign."""
    folder = tmp_path_factory.mktemp("rows") / "c"
    assert main(["simulate", "machine", "--out", str(folder), "--runs", "2", "--validation", "1", "--rows", "40"]) == 0
    return folder


def altered(campaign: Path, place: Path, change: Callable[[str, int, str], str]) -> Path:
    """Return a copy of a campaign in which each number of each table is what ``change(column, row, text)`` gives."""
    shutil.copytree(campaign, place)
    for file in (place / "runs").glob("*.csv"):
        with open(file, encoding="utf-8", newline="") as table:
            head, *rows = csv.reader(table)
        rows = [[change(name, k, text) for name, text in zip(head, row, strict=True)] for k, row in enumerate(rows)]
        with open(file, "w", encoding="utf-8", newline="") as table:
            csv.writer(table).writerows([head, *rows])
    return place


@pytest.mark.long
def test_constant_temperatures_are_bad_input(
    campaign: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Thermometers that never change: ``check`` says that nothing can be told, without inf or nan in text, numbers and
    pictures; ``identify`` exits 3.
    """
    still = altered(campaign, tmp_path / "still", lambda name, _k, text: "20.0" if name.endswith("_degC") else text)
    assert main(["check", str(still), "--plots", str(tmp_path / "p"), "--json", str(tmp_path / "check.json")]) == 0
    said = capsys.readouterr()
    assert not re.search(r"\b(nan|inf)\b", said.out + said.err)
    assert "nothing tells of any law" in said.err
    assert json.loads((tmp_path / "check.json").read_text(encoding="utf-8"))["observability"] is None
    assert main(["identify", str(still)]) == 3
    assert "never leaves its zero" in capsys.readouterr().err


@pytest.mark.long
def test_one_leg_that_never_warms_is_named(campaign: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A leg whose thermometer never changes: its two coefficients are said to be unseen, the others have numbers."""
    still = altered(campaign, tmp_path / "one", lambda name, _k, text: "20.0" if name == "leg3_T1_degC" else text)
    assert main(["check", str(still), "--plots", str(tmp_path / "p"), "--json", str(tmp_path / "check.json")]) == 0
    said = capsys.readouterr()
    assert "never leaves its zero: leg3 A T1, leg3 B T1" in said.out
    assert not re.search(r"\b(nan|inf)\b", said.out + said.err)
    seen = json.loads((tmp_path / "check.json").read_text(encoding="utf-8"))["observability"]["coefficients"]
    unseen = [one["name"] for one in seen if one["uncertainty_um_per_m_K"] is None]
    assert unseen == ["leg3 A T1", "leg3 B T1"]
    assert all(math.isfinite(one["inflation"]) for one in seen if one["name"] not in unseen)
    assert (tmp_path / "p" / "observability.png").exists()


def test_missing_codes_are_left_out_and_counted(campaign: Path, tmp_path: Path) -> None:
    """-180 degC of a thermometer, 9999 of a pose: such rows are left out with their reason; temperatures count from the
    first row that has them all; where every row has one, no row can be used and the input is bad (exit 3).
    """

    def change(name: str, k: int, text: str) -> str:
        coded = {("leg2_T1_degC", 0): "-180", ("leg2_T1_degC", 7): "850", ("measured_x_mm", 9): "9999"}
        return coded.get((name, k), text)

    rows = hexapod_rows(load_campaign(altered(campaign, tmp_path / "some", change)), "validation")
    assert len(rows) == 37
    assert sorted(rows.left_out.values()) == [1, 2]
    assert all("missing code" in reason for reason in rows.left_out)
    assert abs(rows.dT).max() < 30.0
    every = altered(campaign, tmp_path / "all", lambda name, _k, text: "-180" if name == "leg1_T1_degC" else text)
    with pytest.raises(DataError, match="no row of the validation runs|no row with all of them"):
        hexapod_rows(load_campaign(every), "validation")
    assert main(["identify", str(every)]) == 3


def test_names_and_folders_are_refused(campaign: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A sensor named twice or not at all, a folder where the machine's file is meant: each in words."""
    for words, said in (("T1,T1", "'T1' is named twice"), ("T1,", "an empty name"), ("T9", "all legs have: T1")):
        assert main(["identify", str(campaign), "--sensors", words]) == 2
        assert said in capsys.readouterr().err
    folder = tmp_path / "folder"
    shutil.copytree(campaign, folder)
    file = folder / "campaign.toml"
    file.write_text(file.read_text(encoding="utf-8").replace('"hexapod.toml"', '"."'), encoding="utf-8")
    assert main(["check", str(folder)]) == 3
    assert "hexapod names a folder" in capsys.readouterr().err
