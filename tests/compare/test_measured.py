"""What drives the bench and what it is held against: motion of all rows, settled rows in windows, places of sensors."""

from __future__ import annotations

import csv
import shutil
from pathlib import Path

import numpy as np
import pytest

from hexathermal.compare.comparison import compare_campaign
from hexathermal.compare.measured import MeasuredRun, measured_run
from hexathermal.compare.placing import placed
from hexathermal.errors import ArgumentError
from hexathermal.learn.campaign_files import load_campaign
from hexathermal.simulate.bench.bench import Bench, planned_runs, simulate_bench
from hexathermal.simulate.bench.campaign_folder import write_campaign
from hexathermal.simulate.bench.scenario import Motion

SEED = 5


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A campaign of the virtual bench, one run of 90 min."""
    place = tmp_path_factory.mktemp("measured") / "campaign"
    bench = Bench()
    plans = planned_runs(bench, SEED, identification=1, validation=0, duration=5400.0)
    write_campaign(place, bench, plans, simulate_bench(bench, SEED, plans))
    return place


def run_of(folder: Path) -> MeasuredRun:
    """Return the campaign's first run as the bench takes it."""
    campaign = load_campaign(folder)
    found = measured_run(campaign, campaign.runs[0], placed(campaign).sensors)
    assert isinstance(found, MeasuredRun)
    return found


def copied(folder: Path, place: Path, *changes: tuple[str, str]) -> Path:
    """Return a copy of a campaign with words of its campaign.toml replaced."""
    shutil.copytree(folder, place)
    text = (place / "campaign.toml").read_text()
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    (place / "campaign.toml").write_text(text)
    return place


def test_the_way_is_that_of_the_motion(folder: Path) -> None:
    """Rows every 20 s hide turns; the way that is taken lies within three of its own standard deviations."""
    run = run_of(folder)
    (plan,) = planned_runs(Bench(), SEED, identification=1, validation=0, duration=5400.0)
    true = float(Motion(plan.commands, Bench().leg.drive.speed).way(np.array([5400.0]))[0])
    assert 0.0 < run.way_doubt < 0.03
    assert run.way.sum() == pytest.approx(true, rel=3.0 * run.way_doubt)
    assert run.q.min() >= -1e-6
    assert run.q.max() <= 0.25 + 1e-6


def test_windows_are_means_and_slopes(folder: Path) -> None:
    """A drift of ``3 um + 2 um/m (q - mean)`` in each window has that mean and that slope, where q spreads."""
    windows = run_of(folder).windows
    values = 3.0 + 2.0 * windows.centred
    says = windows.spread > 0.0
    assert says.any()
    np.testing.assert_allclose(windows.mean(values), 3.0, atol=1e-12)
    np.testing.assert_allclose(windows.slope(values), np.where(says, 2.0, 0.0), atol=1e-9)
    np.testing.assert_allclose(windows.landings.sum(axis=1), 1.0)


def test_the_scatter_of_landings_is_found(folder: Path) -> None:
    """The scatter from landing to landing is that of the bench's mechanics and settling, some 0.15 um."""
    assert run_of(folder).landing_scatter == pytest.approx(0.15e-6, rel=0.35)


def test_a_long_gap_leaves_a_run_out_with_a_reason(folder: Path, tmp_path: Path) -> None:
    """Where rows are missing for 20 min the motor's heat is not known: the run is left out, and it is said why."""
    place = copied(folder, tmp_path / "gap")
    file = place / "runs" / "run-01.csv"
    lines = file.read_text().splitlines()
    file.write_text("\n".join(lines[:100] + lines[165:]) + "\n")
    with pytest.raises(ArgumentError, match=r"no row is recorded for 2\d min"):
        compare_campaign(place)


def test_without_the_room_there_is_nothing_to_drive(folder: Path, tmp_path: Path) -> None:
    """A campaign without air temperature is refused with the column's name."""
    place = copied(folder, tmp_path / "room")
    file = place / "runs" / "run-01.csv"
    file.write_text(file.read_text().replace("air_temperature_degC", "outside_degC"))
    with pytest.raises(ArgumentError, match="air_temperature_degC"):
        compare_campaign(place)


def test_a_thermocouple_off_the_leg_is_left_out_with_a_reason(folder: Path, tmp_path: Path) -> None:
    """A place beyond the rod's end cannot be simulated: the others are compared, and a note says which and why."""
    place = copied(folder, tmp_path / "off", ("position_mm = 576.0", "position_mm = 676.0"))
    found = placed(load_campaign(place))
    assert len(found.sensors) == 16
    assert any("T17" in note and "676" in note for note in found.notes)


def test_without_places_the_campaign_is_refused(folder: Path, tmp_path: Path) -> None:
    """Thermocouples on no known part leave nothing to compare."""
    place = copied(folder, tmp_path / "parts", ('part = "body"', 'part = "nut"'), ('part = "rod"', 'part = "nut"'))
    with pytest.raises(ArgumentError, match="position_mm"):
        placed(load_campaign(place))


@pytest.mark.parametrize("factor", [0.8, 1.6])
def test_another_length_is_the_bench_longer_or_shorter(folder: Path, tmp_path: Path, factor: float) -> None:
    """A leg of another q0 gets a bench of that length with its sensors on it, and a note says so."""
    place = copied(folder, tmp_path / "length", ("q0_mm = 600.0", f"q0_mm = {600.0 * factor}"),
                   ("250.0,", f"{200.0 * factor},"))  # fmt: skip
    file = place / "runs" / "run-01.csv"
    head, *rows = file.read_text().splitlines()
    cut = [row.split(",") for row in rows]
    lines = [",".join([row[0], f"{0.8 * factor * float(row[1]):.5f}", *row[2:]]) for row in cut]
    file.write_text("\n".join([head, *lines]) + "\n")
    found = placed(load_campaign(place))
    assert found.leg.retracted_length == pytest.approx(0.6 * factor)
    assert any("multiplied" in note for note in found.notes)


@pytest.mark.long
def test_what_is_odd_about_the_thermocouples_is_told(tmp_path: Path) -> None:
    """A thermocouple without values in a run, and readings in degrees Fahrenheit, are told of with their names."""
    bench, place = Bench(), tmp_path / "odd"
    plans = planned_runs(bench, SEED, identification=2, validation=0, duration=5400.0)
    write_campaign(place, bench, plans, simulate_bench(bench, SEED, plans))
    for file in sorted((place / "runs").glob("*.csv")):
        with file.open(newline="") as stream:
            head, *rows = csv.reader(stream)
        for k, name in enumerate(head):
            if name.endswith("_degC") and name != "air_temperature_degC":
                for row in rows:
                    row[k] = f"{1.8 * float(row[k]) + 32.0:.3f}"
            if name == "T05_degC" and file.stem == "run-02":
                for row in rows:
                    row[k] = ""
        with file.open("w", newline="") as stream:
            csv.writer(stream).writerows([head, *rows])
    notes = compare_campaign(place).notes
    assert any("T05 lacks more than 10 % of the settled rows of run-02" in note for note in notes)
    assert any(note.startswith("all sensors") and "degrees Fahrenheit" in note for note in notes)
