"""A campaign of the virtual bench: the paper's figures come out, the truth stays out, and folders are safe."""

from __future__ import annotations

import csv
import json
import tomllib
from dataclasses import replace
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest

from hexathermal.cli import main
from hexathermal.errors import ArgumentError, FileFormatError
from hexathermal.simulate.bench.bench import Bench, BenchRun, planned_runs, simulate_bench
from hexathermal.simulate.bench.campaign_folder import write_campaign
from hexathermal.simulate.bench.tables import read_scenario

MICRO = 1e6


def rows(runs: list[BenchRun], role: str) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Settled rows of a role: rises (n, 17), displacement (n,), drift (n,)."""
    chosen = [run for run in runs if run.role == role]
    rises = [(run.temperatures - run.temperatures[0])[run.settled] for run in chosen]
    q = [run.q[run.settled] for run in chosen]
    return np.concatenate(rises), np.concatenate(q), np.concatenate([run.drift()[run.settled] for run in chosen])


def columns(rises: np.ndarray, q: np.ndarray, sensors: tuple[int, ...]) -> np.ndarray:
    """Regressors of eq. 4: q0 dT and q dT of each sensor."""
    chosen = rises[:, sensors]
    return np.hstack([0.6 * chosen, q[:, None] * chosen])


@pytest.fixture(scope="module", params=[1, 4, 12])
def campaign(request: pytest.FixtureRequest) -> list[BenchRun]:
    """A campaign of the published bench: 8 runs to identify, 3 to validate."""
    print(f"seed {request.param}")
    return list(simulate_bench(Bench(), request.param))


@pytest.mark.long
def test_the_figures_of_the_paper_come_out(campaign: list[BenchRun]) -> None:
    """Robert et al., sections 5.3 and 5.4, by least squares on eq. 4, each run zeroed at its first row.

    Largest drift 7 to 9 um; T07's A is 1.99e-6 within 10 % and its B of the published size; the best sensor on the
    body is within 0.1 um of the best pair, reduces the mean drift of runs never fitted by 85 % or more, and leaves no
    more than 1.3 um; the best pair joins a sensor of the lower half of the leg with one of the upper.
    """
    rises, q, drift = rows(campaign, "identification")
    new_rises, new_q, new_drift = rows(campaign, "validation")
    fits: dict[tuple[int, ...], tuple[float, np.ndarray]] = {}
    for sensors in [*((k,) for k in range(17)), *combinations(range(17), 2)]:
        matrix = columns(rises, q, sensors)
        law = np.linalg.solve(matrix.T @ matrix, matrix.T @ drift)
        fits[sensors] = float(np.sqrt(np.mean((drift - matrix @ law) ** 2))), law
    best = min(((k,) for k in range(14)), key=lambda sensors: fits[sensors][0])
    pair = min((sensors for sensors in fits if len(sensors) == 2), key=lambda sensors: fits[sensors][0])
    residual = new_drift - columns(new_rises, new_q, best) @ fits[best][1]
    assert 7.0 < max(np.abs(drift).max(), np.abs(new_drift).max()) * MICRO < 9.0
    assert fits[(6,)][1] * MICRO == pytest.approx([1.99, 1.09], abs=0.5)
    assert fits[(6,)][1][0] * MICRO == pytest.approx(1.99, rel=0.1)
    assert (fits[best][0] - fits[pair][0]) * MICRO < 0.1
    assert np.abs(residual).max() * MICRO <= 1.3
    assert 1.0 - np.abs(residual).mean() / np.abs(new_drift).mean() >= 0.85
    assert min(pair) <= 7 < max(pair)


def test_runs_differ_and_seeds_repeat() -> None:
    """The same seed makes the same runs to the last digit; another seed or run makes another."""
    bench = Bench()
    plans = planned_runs(bench, 5, identification=2, validation=0, duration=2700.0)
    first, second = (list(simulate_bench(bench, 5, plans)) for _time in range(2))
    for a, b in zip(first, second, strict=True):
        assert np.array_equal(a.beams, b.beams)
        assert np.array_equal(a.temperatures, b.temperatures)
    assert not np.array_equal(first[0].beams, first[1].beams)
    other = next(iter(simulate_bench(bench, 6, plans)))
    assert not np.array_equal(first[0].beams, other.beams)


def test_rows_while_moving_are_not_settled_and_useless() -> None:
    """Settled rows scatter by tenths of a micrometre about the truth, unsettled ones by more."""
    bench = replace(Bench(), interval=1.0)
    (run,) = simulate_bench(bench, 7, planned_runs(bench, 7, identification=1, validation=0, duration=3600.0))
    truth = run.truth
    error = (run.drift() - (truth.growth + truth.mechanical))[1:]
    settled = run.settled[1:]
    assert 0.3 < settled.mean() < 0.95
    assert np.abs(error[settled] - np.median(error[settled])).max() < 0.5e-6
    assert error[~settled].std() > 3.0 * error[settled].std()


@pytest.mark.long
def test_weather_is_in_the_beams_only_where_they_are_not_compensated() -> None:
    """Uncompensated drift is off by micrometres over hours of weather; compensated drift by tenths."""
    errors = []
    for compensated in (True, False):
        bench = Bench()
        bench = replace(bench, interferometers=replace(bench.interferometers, index_compensated=compensated))
        plans = planned_runs(bench, 8, identification=3, validation=0, duration=4.0 * 3600.0)
        worst = 0.0
        for run in simulate_bench(bench, 8, plans):
            truth = run.truth.growth + run.truth.mechanical
            worst = max(worst, float(np.abs(run.drift() - truth + truth[0])[run.settled].max()))
        errors.append(worst)
    assert errors[0] < 0.4e-6
    assert errors[1] > 1.0e-6


def simulate(*words: object) -> int:
    return main(["simulate", "bench", *map(str, words)])


SHORT = ("--runs", 1, "--validation", 1, "--hours", 0.75)


def test_a_campaign_looks_measured(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The folder holds what the format asks for and nothing more: no key, column, file or word tells of simulation."""
    folder, truth = tmp_path / "leg", tmp_path / "truth.json"
    assert simulate("--out", folder, *SHORT, "--truth", truth, "--json", tmp_path / "a.json") == 0
    assert {file.relative_to(folder).as_posix() for file in folder.rglob("*") if file.is_file()} == {
        "campaign.toml", "runs/run-01.csv", "runs/run-02.csv",
    }  # fmt: skip
    text = (folder / "campaign.toml").read_text()
    form = tomllib.loads(text)
    assert set(form) == {"format", "kind", "title", "leg", "interferometer", "thermocouples", "runs"}
    assert form["leg"] == {"q0_mm": 600.0, "stroke_mm": [0.0, 250.0]}
    assert [run["role"] for run in form["runs"]] == ["identification", "validation"]
    for word in ("simul", "truth", "virtual", "seed", "hexathermal-bench"):
        assert word not in text.lower()
    with (folder / "runs" / "run-01.csv").open() as file:
        header, *table = csv.reader(file)
    wanted = ["time_s", "q_mm", "settled", *(f"T{k:02d}_degC" for k in range(1, 18))]
    wanted += ["beam1_mm", "beam2_mm", "beam3_mm", "air_temperature_degC", "air_pressure_hPa", "air_humidity_percent"]
    assert header == wanted
    numbers = np.array(table, dtype=float)
    assert np.isfinite(numbers).all()
    assert np.array_equal(numbers[:, 0], np.arange(len(table)) * 20.0)
    assert set(numbers[:, 2]) == {0.0, 1.0}
    assert (numbers[0, 20:23] == 0.0).all()
    told = json.loads(truth.read_text())
    assert len(told["runs"]) == 2
    for kind in ("effective", "as_read"):
        assert set(told["laws"][kind]) == {f"T{k:02d}" for k in range(1, 18)}
    # a taped junction reads less than the surface: its own law is steeper
    laws = [told["laws"][kind]["T07"]["A_per_K"] for kind in ("effective", "as_read")]
    assert 1.0 < laws[1] / laws[0] < 1.1
    assert told["laws"]["homogeneous"]["B_per_K"] == pytest.approx(Bench().leg.rod.scale_expansion)
    assert "run-02" in capsys.readouterr().out


def test_parquet_holds_the_same_as_csv(tmp_path: Path) -> None:
    """Both forms of a run hold the same numbers, to the decimals of the log."""
    import pyarrow.parquet as parquet

    bench = Bench()
    plans = planned_runs(bench, 9, identification=1, validation=0, duration=2700.0)
    texts = write_campaign(tmp_path / "a", bench, plans, simulate_bench(bench, 9, plans))
    tables = write_campaign(tmp_path / "b", bench, plans, simulate_bench(bench, 9, plans), parquet=True)
    found = parquet.read_table(tables[1])
    with texts[1].open() as file:
        header, *lines = csv.reader(file)
    assert found.column_names == header
    numbers = np.array(lines, dtype=float)
    assert np.abs(np.column_stack([found[name].to_numpy() for name in header]) - numbers).max() < 1e-9


def test_folders_of_others_are_safe(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A campaign is replaced with --force only, and a folder with anything else in it never; nothing is left behind."""
    folder = tmp_path / "leg"
    assert simulate("--out", folder, *SHORT) == 0
    before = (folder / "runs" / "run-01.csv").read_bytes()
    assert simulate("--out", folder, *SHORT, "--seed", 2) == 2
    assert "--force to replace it" in capsys.readouterr().err
    assert (folder / "runs" / "run-01.csv").read_bytes() == before
    assert simulate("--out", folder, *SHORT, "--seed", 2, "--force") == 0
    assert (folder / "runs" / "run-01.csv").read_bytes() != before
    (folder / "notes.txt").write_text("mine")
    assert simulate("--out", folder, *SHORT, "--force") == 2
    assert "notes.txt" in capsys.readouterr().err
    assert (folder / "notes.txt").read_text() == "mine"
    assert sorted(item.name for item in tmp_path.iterdir()) == ["leg"]


def test_a_broken_run_leaves_nothing(tmp_path: Path) -> None:
    """An error half-way removes what was written and keeps what stood there."""
    bench = Bench()
    plans = planned_runs(bench, 1, identification=2, validation=0, duration=1800.0)
    whole = write_campaign(tmp_path / "leg", bench, plans, simulate_bench(bench, 1, plans))
    before = whole[1].read_bytes()

    def breaking():
        yield next(iter(simulate_bench(bench, 2, plans)))
        raise OSError("disk full")

    with pytest.raises(OSError, match="disk full"):
        write_campaign(tmp_path / "leg", bench, plans, breaking(), force=True)
    assert whole[1].read_bytes() == before
    assert sorted(item.name for item in tmp_path.iterdir()) == ["leg"]


@pytest.mark.parametrize(
    ("words", "text"),
    [
        (("--hours", "0.1"), "--hours must be 0.5"),
        (("--hours", "nan"), "not a finite number"),
        (("--interval", "0"), "--interval must be 1"),
        (("--runs", "0", "--validation", "0"), "nothing to simulate"),
        (("--runs", "-1"), "whole number"),
        (("--truth", "leg/truth.json"), "inside the campaign's folder"),
        (("--plots", "leg/plots"), "inside the campaign's folder"),
        (("--json", "leg/answer.json"), "there is no folder"),
        (("--out", "."), "the folder you are in"),
        (("--truth", "nowhere/truth.json"), "there is no folder"),
        (("--scenario", "none.csv"), "is not there"),
        (("--hours", "4", "--scenario", "none.csv"), "contradict"),
    ],
)
def test_wrong_use_is_told(
    words: tuple[str, ...], text: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:  # fmt: skip
    """What cannot be done is said in one message, exit code 2, and nothing is written."""
    monkeypatch.chdir(tmp_path)
    assert simulate(*(() if "--out" in words else ("--out", "leg")), *words) == 2
    assert text in capsys.readouterr().err
    assert not any(tmp_path.iterdir())


def test_simulate_alone_teaches(capsys: pytest.CaptureFixture[str]) -> None:
    """``hexathermal simulate`` is no whole command; it says what can be simulated."""
    assert main(["simulate"]) == 2
    assert "hexathermal simulate bench --out DIR" in capsys.readouterr().err


def test_a_scenario_is_followed(tmp_path: Path) -> None:
    """The rod goes where the table says at 2 mm/s, and the room is the table's."""
    table = tmp_path / "day.csv"
    table.write_text(
        "time_s,q_mm,air_temperature_degC,air_pressure_hPa\n"
        "0,100,21,990\n600,110,21,990\n1200,100,22,1000\n3600,100,22,1000\n"
    )
    bench = Bench()
    plan = read_scenario(table, bench).plan(bench, "run-01", "identification", (1, 2))
    (run,) = simulate_bench(bench, 1, (plan,))
    at = {int(time): k for k, time in enumerate(run.time)}
    assert run.q[[at[0], at[620], at[1180], at[1220]]] * 1e3 == pytest.approx([100.0, 110.0, 110.0, 100.0], abs=1e-3)
    assert run.truth.weather.temperature[[at[0], at[900], at[3600]]] == pytest.approx([21.0, 21.5, 22.0])
    assert run.truth.weather.pressure[at[3600]] == pytest.approx(1e5)
    assert run.settled[at[580]]
    assert not run.settled[at[600]]
    assert simulate("--out", tmp_path / "leg", "--scenario", table) == 0
    runs = tomllib.loads((tmp_path / "leg" / "campaign.toml").read_text())["runs"]
    assert [item["role"] for item in runs] == ["identification", "validation"]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("time_s,q_mm\n0,100\n600,300\n1200,400\n", ("line 3, column 2", "line 4, column 2", "expected 0 to 250")),
        ("time_s,q_mm\n0,100\n600,200\n610,100\n900,100\n", ("line 4", "it takes 50.0 s at 2 mm/s")),
        ("time_s\n0\n600\n", ("q_mm",)),
        ("q_mm\n0\n1\n", ("time_s",)),
        ("time_s,q_mm\n0,100\n0,110\n", ("time_s",)),
        ("time_s,q_mm\n0,100\n600,far\n", ("line 3",)),
        ("time_s,q_mm\n0,100\n", ("two rows",)),
        ("time_s,q_mm\n", ("no rows",)),
        ("time_s,q_mm,air_pressure_hPa\n0,100,101325\n600,110,1000\n", ("line 2, column 3", "100 to 1400")),
    ],
)
def test_a_wrong_scenario_is_told_line_by_line(text: str, said: tuple[str, ...], tmp_path: Path) -> None:
    """Every bad row is named with line, column, value and limit."""
    table = tmp_path / "day.csv"
    table.write_text(text)
    with pytest.raises(FileFormatError) as caught:
        read_scenario(table, Bench())
    for part in said:
        assert part in str(caught.value)


def test_too_few_runs_are_refused() -> None:
    """A campaign without a run, and a run that ends before its first movement, are no campaigns."""
    with pytest.raises(ArgumentError, match="at least one run"):
        planned_runs(Bench(), 1, identification=0, validation=0)
    with pytest.raises(ArgumentError, match="ends before its first movement"):
        planned_runs(Bench(), 1, duration=60.0)


def test_pictures_are_drawn(tmp_path: Path) -> None:
    """``--plots`` draws each run, outside of the campaign."""
    assert simulate("--out", tmp_path / "leg", *SHORT, "--plots", tmp_path / "plots") == 0
    assert sorted(file.name for file in (tmp_path / "plots").iterdir()) == ["run-01.png", "run-02.png"]
    assert all(file.read_bytes().startswith(b"\x89PNG") for file in (tmp_path / "plots").iterdir())
