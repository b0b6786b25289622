"""Readings in another unit, out of the stroke or in motion: told as a warning, whatever the finding."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from hexathermal.cli import main
from hexathermal.errors import DataError
from hexathermal.learn.campaign_files import load_campaign
from hexathermal.learn.diagnosis import diagnose
from hexathermal.learn.diagnosis.doubtful import doubtful_readings
from hexathermal.learn.diagnosis.stage import Stage, view_of
from hexathermal.learn.signals import campaign_rows
from hexathermal.simulate.hidden.drawing import campaign_of
from hexathermal.simulate.hidden.writing import write_campaign
from tests.learn.diagnosis.campaigns import rewritten

Row = dict[str, str]


def changed(folder: Path, change: Callable[[Row], None]) -> tuple[str, ...]:
    """Write a quiet leg whose every row is changed; return its law's sensors."""
    truth, answer = campaign_of("quiet", 6, causes=(), shared=True)
    write_campaign(folder, truth, answer)
    for file in sorted((folder / "runs").glob("*.csv")):
        rewritten(file, lambda rows: [change(row) for row in rows] and None)
    return answer.base


def told(folder: Path, change: Callable[[Row], None]) -> tuple[str, ...]:
    """What a diagnosis of such a leg would doubt."""
    base = changed(folder, change)
    campaign = load_campaign(folder)
    rows = campaign_rows(campaign, "identification")
    stage = Stage(view_of(campaign, rows, base))
    return doubtful_readings(campaign, [*rows, *campaign_rows(campaign, "validation")], stage.channel.y, stage.levels)


def scaled(name: str, factor: float, less: float = 0.0) -> Callable[[Row], None]:
    """Return what writes a column in another unit."""

    def change(row: Row) -> None:
        row[name] = f"{factor * float(row[name]) + less:.4f}"

    return change


@pytest.mark.long
@pytest.mark.parametrize(
    ("change", "words"),
    [
        (
            scaled("T03_degC", 0.1),
            r"T03: [12]\.\d degC when runs begin, where most others read [12]\d\.\d: is it",
        ),
        (scaled("T03_degC", 1.8, 32.0), r"T03: never below \d\d degC, where the others read \d\d: degrees Fahrenheit"),
        (scaled("air_temperature_degC", 1.8, 32.0), r"air_temperature_degC: never below \d\d degC: degrees Fahrenheit"),
        (
            scaled("q_mm", 1.0, 400.0),
            r"and \d+ more: q_mm runs from \d+\.\d to \d.*outside stroke_mm.*is a column",
        ),
        (
            scaled("time_s", 1.0 / 60.0),
            r"temperatures change by \d+\.\d K in \d min \(run-\d+\): is time_s in minutes\?",
        ),
        (
            scaled("air_pressure_hPa", 1.0 / 1.33322),
            r"air_pressure_hPa reads 7\d\d hPa, that of 2\d00 m above the sea: is it in millimetres of mercury\?",
        ),
    ],
)
def test_units_and_strokes_are_doubted(tmp_path: Path, change: Callable[[Row], None], words: str) -> None:
    """One sentence that names the column, what it reads, and what that looks like."""
    assert any(re.search(words, one) for one in told(tmp_path / "campaign", change))


@pytest.mark.filterwarnings("ignore::hexathermal.learn.campaign_clocks.ClockWarning")
def test_rows_hours_apart_are_refused(tmp_path: Path) -> None:
    """Times in milliseconds would make every cause look like another: the unit is asked for, and nothing is named."""
    base = changed(tmp_path / "campaign", scaled("time_s", 1000.0))
    with pytest.raises(DataError, match=r"one row every \d.*is time_s in milliseconds\?"):
        diagnose(load_campaign(tmp_path / "campaign"), base)


@pytest.mark.long
def test_a_diagnosis_tells_its_doubts_first(tmp_path: Path) -> None:
    """They lead its notes, and stand in its JSON."""
    base = changed(tmp_path / "campaign", scaled("T03_degC", 0.1))
    found = diagnose(load_campaign(tmp_path / "campaign"), base)
    assert len(found.doubtful) == 1
    assert "T03" in found.doubtful[0]
    assert found.notes[:1] == found.doubtful
    assert found.to_json()["doubtful"] == list(found.doubtful)


@pytest.mark.long
def test_a_leg_shorter_than_its_stroke_is_doubted(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A length in centimetres, which makes A ten times too large, is told by `check`, `identify` and `diagnose`."""
    base = changed(tmp_path / "campaign", lambda row: None)
    place = tmp_path / "campaign" / "campaign.toml"
    words = place.read_text(encoding="utf-8")
    length = float(re.search(r"^q0_mm = (.*)$", words, re.M)[1])  # type: ignore[index]
    place.write_text(re.sub(r"^q0_mm = .*$", f"q0_mm = {length / 10.0:.6g}", words, flags=re.M), encoding="utf-8")
    for command in (["check"], ["identify", "--sensors", ",".join(base)], ["diagnose", "--sensors", ",".join(base)]):
        assert main([*command, str(place.parent)]) == 0
        assert f"warning: q0_mm is {length / 10.0:.6g}, the stroke" in capsys.readouterr().err


@pytest.mark.long
def test_landings_that_scatter_as_the_drift_does_are_doubted(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Each stop lands micrometres elsewhere: rows of motion are suspected, as a warning before all else."""
    rng = np.random.default_rng(3)
    last = {"q": "", "off": 0.0}

    def change(row: Row) -> None:
        if abs(float(row["q_mm"]) - float(last["q"] or "inf")) > 0.1:
            last["off"] = float(rng.normal(0.0, 0.02))
        last["q"] = row["q_mm"]
        for beam in [name for name in row if name.startswith("beam")]:
            row[beam] = f"{float(row[beam]) + float(last['off']):.6f}"

    base = changed(tmp_path / "campaign", change)
    assert main(["diagnose", str(tmp_path / "campaign"), "--sensors", ",".join(base)]) == 0
    shown = capsys.readouterr()
    assert "warning: landings scatter by" in shown.err
    assert "are rows of a moving rod among them?" in shown.err


def test_sound_readings_are_not_doubted(tmp_path: Path) -> None:
    """Nothing is said of a leg as it was measured."""
    assert told(tmp_path / "campaign", lambda row: None) == ()
