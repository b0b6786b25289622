"""Checks of a campaign: numbers that are known come out, what cannot be told apart is said, the command answers."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from hexathermal.cli import main
from hexathermal.learn.campaign_files import load_campaign
from hexathermal.learn.check import CampaignCheck, check_campaign
from hexathermal.learn.check_cycles import cycles
from hexathermal.learn.check_remarks import of_noise, of_one_fahrenheit
from hexathermal.learn.check_sums import PairSums, collinearity
from hexathermal.learn.check_words import as_data, told_apart, warnings_of

from .campaign_folders import Q0_M, SENSORS, Table, component_campaign, leg_campaign, leg_table

SHARED = Path(__file__).resolve().parents[3] / "shared"


def checked(folder: Path, **options: object) -> CampaignCheck:
    """Return the check of a small campaign."""
    return check_campaign(load_campaign(leg_campaign(folder, **options)))  # type: ignore[arg-type]


def test_noise_and_ranges_are_those_put_in(tmp_path: Path) -> None:
    """Noise of 50 mK and 30 nm a beam (17 nm of the mean) is found within 15 %; ranges are those of the tables."""
    check = checked(tmp_path)
    assert np.allclose(check.sensor_noise, 0.05, rtol=0.15)
    assert np.allclose([run.drift_noise for run in check.runs], 30e-9 / np.sqrt(3.0), rtol=0.15)
    table = leg_table(0)
    settled = table["settled"] == 1.0
    assert np.isclose(check.runs[0].highest_degC[0], table["T01_degC"][settled].max())
    assert np.isclose(check.runs[0].lowest_degC[3], table["T04_degC"][settled].min())
    assert check.runs[0].landings == 24
    assert check.runs[0].record.duration == 599 * 20.0


def test_told_apart_is_what_least_squares_says(tmp_path: Path) -> None:
    """Cosine and uncertainties are those of the columns q0 dT and q dT, one independent reading a landing."""
    from hexathermal.learn.cleaning import used_run

    check = checked(tmp_path)
    blocks = [used_run(check.campaign, run)[0] for run in check.campaign.runs_of("identification")]
    dT = np.concatenate([block.dT[:, 1] for block in blocks])
    q = np.concatenate([block.q for block in blocks if block.q is not None])
    columns = np.column_stack([Q0_M * dT, q * dT])
    share = sum(int(block.landing[-1]) + 1 for block in blocks) / len(dT)
    covariance = np.linalg.inv(share * columns.T @ columns)
    item = check.separability[1]
    norms = np.linalg.norm(columns, axis=0)
    assert np.isclose(item.r, columns[:, 0] @ columns[:, 1] / norms.prod())
    assert np.allclose([item.std_A, item.std_B], np.sqrt(np.diag(covariance)))
    assert told_apart(item).startswith("told apart")


def test_heating_at_one_place_only_confounds_the_coefficients(tmp_path: Path) -> None:
    """A leg that is warm at one q only: A and B cannot be told apart, and what to do is said."""

    def edit(table: Table) -> None:
        shift = 120.0 + 0.1 * table["q_mm"] - table["q_mm"]
        table["q_mm"] += shift
        for beam in (1, 2, 3):
            table[f"beam{beam}_mm"] += shift - shift[0]

    folder = leg_campaign(tmp_path, edit=edit, validation=False)
    head, _, tail = (folder / "campaign.toml").read_text().rpartition("identification")
    (folder / "campaign.toml").write_text(head + "validation" + tail)
    check = check_campaign(load_campaign(folder))
    assert all(item.r > 0.99 for item in check.separability)
    assert told_apart(check.separability[0]).startswith("cannot be told apart")
    assert any("run it hot at fixed q" in text for text in warnings_of(check))


def test_sensors_that_say_the_same_are_named(tmp_path: Path) -> None:
    """A copy of a sensor has a correlation near 1 and a large variance inflation; an own one has neither."""

    def edit(table: Table) -> None:
        rng = np.random.default_rng(9)
        table["T02_degC"] = table["T01_degC"] + 5e-3 * rng.standard_normal(600)
        table["T04_degC"] = 20.0 + 2.0 * np.sin(table["time_s"] / 130.0) + 0.05 * rng.standard_normal(600)

    folder = leg_campaign(tmp_path, edit=edit, validation=False)
    text = (folder / "campaign.toml").read_text()
    (folder / "campaign.toml").write_text(text[: text.index('[[runs]]\nname = "b"')])
    check = check_campaign(load_campaign(folder))
    assert check.correlation[0, 1] > 0.999
    assert check.inflation[1] > 1e4
    assert check.inflation[3] < 1.2
    assert any(line.startswith("T01, T02") and "the others say nearly the same" in line for line in warnings_of(check))
    assert np.allclose(check.correlation, check.correlation.T)
    assert np.allclose(np.diag(check.correlation), 1.0)
    assert np.isclose(check.condition, np.linalg.cond(check.correlation) ** 0.5)


def test_a_dead_sensor_does_not_hide_the_others(tmp_path: Path) -> None:
    """A channel without a value is not known; everything is still said of the others, and the record names it."""

    def edit(table: Table) -> None:
        table["T02_degC"][:] = -180.0

    folder = leg_campaign(tmp_path, edit=edit, validation=False)
    text = (folder / "campaign.toml").read_text()
    (folder / "campaign.toml").write_text(text[: text.index('[[runs]]\nname = "b"')])
    check = check_campaign(load_campaign(folder))
    assert np.isnan(check.sensor_noise[1])
    assert np.isfinite(check.inflation[[0, 2, 3]]).all()
    said = " ".join(warnings_of(check))
    assert "no validation run" in said
    assert "a, T02_degC: dead channel" in said
    json.dumps(as_data(check), allow_nan=False)


def test_a_cycle_of_the_room_is_seen(tmp_path: Path) -> None:
    """A sensor that swings by 1 K every 20 minutes is named with period and amplitude; the others are not."""
    folder = component_campaign(tmp_path, rows=800)
    for name in ("a", "b"):
        file = folder / "runs" / f"{name}.csv"
        head, *lines = file.read_text().splitlines()
        k = head.split(",").index("T1_degC")
        rng, rows = np.random.default_rng(1), [line.split(",") for line in lines]
        for row in rows:
            row[k] = str(21.0 + np.sin(2.0 * np.pi * float(row[0]) / 1200.0) + 0.01 * rng.standard_normal())
        file.write_text("\n".join([head, *(",".join(row) for row in rows)]) + "\n")
    (found,) = cycles(check_campaign(load_campaign(folder)))
    assert found.sensor == "T1"
    assert abs(found.period - 1200.0) < 100.0
    assert abs(found.amplitude - 1.0) < 0.1


@pytest.mark.parametrize(("driver", "period"), [("spindle_speed_rpm", 3600.0), ("", 4200.0)])
def test_a_rhythm_of_an_input_is_no_cycle_of_the_room(tmp_path: Path, driver: str, period: float) -> None:
    """A thermometer that follows a spindle switched on and off every hour is put down to it; one that follows a room
    with a rhythm near the spindle's is not.
    """
    folder = component_campaign(tmp_path, rows=2400)
    for run, name in enumerate(("a", "b")):
        file = folder / "runs" / f"{name}.csv"
        head, *lines = file.read_text().splitlines()
        names = head.split(",")
        rows = np.array([[float(value) for value in line.split(",")] for line in lines])
        rng, time = np.random.default_rng(run), rows[:, 0] + 1000.0 * run
        turning = (time % 3600.0 < 1700.0) * 5000.0
        heat = np.sin(2.0 * np.pi * (time / period + rng.uniform()))
        for k in range(1, len(rows) if driver else 0):
            heat[k] = heat[k - 1] + (turning[k] / 1000.0 - heat[k - 1]) * (time[k] - time[k - 1]) / 1500.0
        rows[:, names.index("T1_degC")] = 20.0 + heat + 0.01 * rng.standard_normal(len(rows))
        rows[:, names.index("spindle_speed_rpm")] = turning
        file.write_text("\n".join([head, *(",".join(map(repr, row)) for row in rows.tolist())]) + "\n")
    (found,) = cycles(check_campaign(load_campaign(folder)))
    assert found.input == driver
    assert ("no cycle of the room" in found.cause) == bool(driver)
    assert abs(found.period - period) < 0.1 * period


def test_thermometers_without_noise_are_checked_without_a_fault() -> None:
    """Two exact thermometers of which one is twice the other: their inflation is infinite and nothing slow is left of
    them, the others keep finite numbers; a noisy one among exact ones is named without a factor.
    """
    time = np.arange(600)
    warm = 5.0 * (1.0 - np.exp(-time / 400.0))
    total = PairSums(4)
    total.add_heat(np.column_stack([warm, 2.0 * warm, 4.0 * np.sin(time / 100.0), np.cos(time / 37.0)]))
    correlation, inflation, condition, slow = collinearity([total], np.zeros(4))
    assert np.isinf(condition)
    assert np.isinf(inflation[:2]).all()
    assert np.isfinite(inflation[2:]).all()
    assert (inflation[2:] >= 1.0).all()
    assert (slow[:2] == 0.0).all()
    assert slow[2] > 0.1
    assert correlation[0, 1] == pytest.approx(1.0)
    said = of_noise(("T1", "T2", "T3"), np.array([0.0, 0.0, 0.2]))
    assert said == ["T3: noise 0.200 K, most other sensors show none"]
    assert of_noise(("T1", "T2", "T3"), np.array([0.0, 0.0, 5e-4])) == []
    assert of_noise(("T1", "T2", "T3", "T4", "T5"), np.array([0.0, 0.0, 0.0, 0.05, 0.06])) == []


def milliseconds(table: Table) -> None:
    """Write milliseconds under the name of seconds."""
    table["time_s"] *= 1e3


def hours_of_time(table: Table) -> None:
    """Write hours under the name of seconds."""
    table["time_s"] /= 3600.0


def fahrenheit(table: Table) -> None:
    """Write degrees Fahrenheit of all thermocouples and of the air."""
    for name in table:
        if name.endswith("_degC"):
            table[name] = 32.0 + 1.8 * table[name]


def all_metres(table: Table) -> None:
    """Write rod and beams in metres."""
    for name in ("q_mm", "beam1_mm", "beam2_mm", "beam3_mm"):
        table[name] *= 1e-3


def never_settled(table: Table) -> None:
    """Let the flag be 0 throughout."""
    table["settled"][:] = 0.0


def beams_lost_early(table: Table) -> None:
    """Let all beams lose count in the 30th row."""
    for beam in (1, 2, 3):
        table[f"beam{beam}_mm"][30:] += 5.0


def stuck(table: Table) -> None:
    """Let all thermocouples read one temperature."""
    for name in ("T01", "T02", "T03", "T04"):
        if f"{name}_degC" in table:
            table[f"{name}_degC"][:] = 20.0


def hardly_warm(table: Table) -> None:
    """Let all thermocouples rise by a twentieth of a kelvin."""
    for name in table:
        if name.startswith("T") and name.endswith("_degC"):
            table[name] = 20.0 + 0.05 * np.linspace(0.0, 1.0, len(table[name]))


@pytest.mark.parametrize(
    ("edit", "wanted"),
    [
        (stuck, "no thermometer changes at all: no law can be identified"),
        (hardly_warm, "no thermometer rises or falls by more than 0.05 K: a law learns next to nothing"),
        (milliseconds, "a: one row every 5.56 h: is time_s in milliseconds?"),
        (hours_of_time, "rows a second over the whole run: is time_s in hours or minutes?"),
        (fahrenheit, "all sensors: never below 6"),
        (fahrenheit, "air_temperature_degC: never below 6"),
        (all_metres, "the stroke is 250 mm: are q_mm and the beams in metres?"),
        (never_settled, "a: no row may be used: 600 not settled"),
        (beams_lost_early, "a: cleaning left only 28 of 600 rows, identify and validate refuse it"),
    ],
)
def test_what_is_probably_wrong_is_a_warning(tmp_path: Path, edit: Callable[[Table], None], wanted: str) -> None:
    """Clocks and temperatures in other units, and runs of which nothing is left: `check` goes on and says so."""
    folder = leg_campaign(tmp_path, edit=edit, validation=False)
    text = (folder / "campaign.toml").read_text()
    (folder / "campaign.toml").write_text(text[: text.index('[[runs]]\nname = "b"')])
    said = warnings_of(check_campaign(load_campaign(folder, clocks=False)))
    assert any(wanted in line for line in said), said
    assert not any("weather is not recorded" in line for line in said)


def test_one_run_or_one_thermometer_in_fahrenheit_is_a_warning(tmp_path: Path) -> None:
    """Beside others in degrees Celsius; a motor that starts at 55 degC is none."""
    said = warnings_of(check_campaign(load_campaign(leg_campaign(tmp_path / "run", edit=fahrenheit))))
    assert any("a: all sensors never below 6" in line and "in this run?" in line for line in said), said

    def one(table: Table) -> None:
        table["T02_degC"] = 32.0 + 1.8 * table["T02_degC"]

    said = warnings_of(check_campaign(load_campaign(leg_campaign(tmp_path / "one", edit=one))))
    assert any(line.startswith("a: T02 never below 6") for line in said), said

    def hot(table: Table) -> None:
        table["T02_degC"] += 35.0

    said = warnings_of(check_campaign(load_campaign(leg_campaign(tmp_path / "hot", edit=hot))))
    assert not any("Fahrenheit" in line for line in said), said
    everywhere = {run: np.array([19.0, 67.0, 20.0]) for run in ("a", "b")}
    assert of_one_fahrenheit(("T1", "T2", "T3"), everywhere)[0].startswith("T2: never below 67 degC, where the others")


def test_spikes_that_were_left_out_are_kept_for_the_pictures(tmp_path: Path) -> None:
    """Each with its time, its reading in degC, and for the drift in metres from the zero."""

    def edit(table: Table) -> None:
        table["time_s"] += 1000.0
        table["T02_degC"][100] += 3.0
        for beam in (1, 2, 3):
            table[f"beam{beam}_mm"][212] += 0.004

    check = checked(tmp_path, edit=edit)
    spikes = check.runs[0].spikes
    assert set(spikes) == {"T02_degC", "drift"}
    assert spikes["T02_degC"][0, 0] == 2000.0
    assert spikes["T02_degC"][0, 1] == leg_table(0)["T02_degC"][100] + 3.0
    assert spikes["drift"][0, 0] == 20.0 * 212
    assert abs(spikes["drift"][0, 1] - check.runs[0].trace.drift[190:200].mean() - 4e-6) < 3e-6


@pytest.mark.parametrize("size", [3.0, -300.0, 90.0])
def test_spikes_near_and_far_are_drawn_and_the_panels_keep_their_size(tmp_path: Path, size: float) -> None:
    """Spikes that were left out are in the picture of their run, with their number, and do not squeeze its curves."""
    from hexathermal.show.campaign_figures import run_figure

    def edit(table: Table) -> None:
        table["T02_degC"][100] += np.clip(size, -90.0, 90.0)
        for beam in (1, 2, 3):
            table[f"beam{beam}_mm"][212] += 1e-3 * size

    check = checked(tmp_path, edit=edit)
    figure = run_figure(check, check.runs[0])
    figure.draw_without_rendering()
    heat, drift = figure.axes[:2]
    assert any("left out as a spike (1)" in text.get_text() for text in drift.texts)
    assert {text.get_text() for text in heat.texts} >= set(SENSORS)
    assert min(axes.get_position().height for axes in figure.axes) > 0.1
    low, high = drift.get_ylim()
    values = check.runs[0].trace.drift * 1e6
    assert high - low < 2.5 * np.ptp(values)


@pytest.mark.long
def test_the_command_prints_and_writes(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Tables on stdout, warnings on stderr, pictures, JSON and NetCDF in their places."""
    pytest.importorskip("h5py", reason="h5py is not installed")
    leg_campaign(tmp_path / "bench", validation=False)
    code = main(["check", str(tmp_path / "bench"), "--plots", str(tmp_path / "plots"), "--ranges",
                 "--json", str(tmp_path / "check.json"), "--netcdf", str(tmp_path / "bench.nc")])  # fmt: skip
    printed = capsys.readouterr()
    assert code == 0, printed.err
    assert "small bench (kind leg): 2 runs" in printed.out
    for sensor in SENSORS:
        assert sensor in printed.out
    assert "warning: no validation run" in printed.err
    names = {file.name for file in (tmp_path / "plots").iterdir()}
    assert {"noise.png", "collinearity.svg", "coverage.png", "run-a.png", "run-b.svg"} <= names
    data = json.loads((tmp_path / "check.json").read_text())
    assert data["format"] == "hexathermal-check/1"
    assert len(data["sensors"]) == len(SENSORS)
    assert (tmp_path / "bench.nc").stat().st_size > 10_000


def test_the_command_lists_all_faults_and_no_traceback(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A damaged campaign: exit code 3, every fault with its place on stderr, nothing else."""
    leg_campaign(tmp_path)
    (tmp_path / "runs" / "a.csv").unlink()
    (tmp_path / "runs" / "b.csv").write_text("time_s,q_m\n0,1\n")
    assert main(["check", str(tmp_path)]) == 3
    printed = capsys.readouterr()
    assert not printed.out
    assert "a.csv, line 1, column 1: the table is not there" in printed.err
    assert "'q_m' has another unit" in printed.err
    assert "Traceback" not in printed.err
    assert main(["check", str(tmp_path / "nowhere")]) == 2
    assert "no campaign at" in capsys.readouterr().err


@pytest.mark.skipif(not (SHARED / "measured").is_dir(), reason="the measured campaigns are not beside the checkout")
def test_the_measured_machine_tools_are_seen_as_they_are(capsys: pytest.CaptureFixture[str]) -> None:
    """T16 is the noisy thermometer, near 0.1 K; T04 swings with the room, every 20 to 30 minutes by 0.4 K or more."""
    for name in ("machine-tool-ch1", "machine-tool-ch2"):
        assert main(["check", str(SHARED / "measured" / name), "--json", "-"]) == 0
        printed = capsys.readouterr()
        data = json.loads(printed.out)
        noise = {item["name"]: item["noise_K"] for item in data["sensors"]}
        assert 0.07 < noise.pop("T16") < 0.13
        assert max(noise.values()) < 0.03
        assert "T16: noise 0." in printed.err
        (cycle,) = data["cycles"]
        assert cycle["sensor"] == "T04"
        assert 20.0 < cycle["period_min"] < 30.0
        assert cycle["amplitude_K"] > 0.4
