"""``hexathermal compare`` as a user meets it: words, tables, JSON, pictures, and clear errors."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import numpy as np
import pytest

from hexathermal.cli import main
from hexathermal.learn.campaign_files import load_campaign
from hexathermal.simulate.bench.changed import Change, write_changed_campaign


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A campaign of a bench whose motor is twice as hot, two runs to identify, one to validate."""
    place = tmp_path_factory.mktemp("compare") / "hot-motor"
    write_changed_campaign(place, Change("motor-heat", "", 2.0), 3, identification=2, duration=5400.0)
    return place


@pytest.mark.long
def test_the_cause_is_said_first_and_drawn(folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The first line names the motor's heat; JSON holds the same; every picture is there."""
    pictures, answer = tmp_path / "pictures", tmp_path / "answer.json"
    pictures.mkdir()
    (pictures / "run-08-channels.png").write_text("of another campaign")
    assert main(["compare", str(folder), "--plots", str(pictures), "--json", str(answer)]) == 0
    out = capsys.readouterr().out
    assert out.startswith("The bench differs in heat of the motor")
    row = next(line for line in out.splitlines() if line.startswith("motor-heat") and " yes " in line)
    assert "is named" in row
    assert "never" not in row
    assert "T07" in out
    facts = json.loads(answer.read_text())
    assert facts["format"] == "hexathermal-comparison/1"
    assert facts["verdict"] == "difference"
    first = facts["differences"][0]
    assert first["name"] == "motor-heat"
    assert first["low"] < first["value"] < first["high"]
    assert first["value"] == pytest.approx(2.0, rel=0.15)
    channels = {one["channel"]: one for one in facts["channels"]}
    assert len(channels) == 18
    assert channels["drift"]["unit"] == "um"
    assert channels["T01"]["rmse_after"] < 0.5 * channels["T01"]["rmse_before"]
    names = {f"{run}-{kind}.png" for run in ("run-01", "run-02", "run-03") for kind in ("channels", "residuals")}
    assert {file.name for file in pictures.iterdir()} == {"parameters.png", "run-08-channels.png", *names}
    assert f"Older pictures stay in {pictures}: run-08-channels.png" in out
    assert sorted(Path(file).name for file in facts["written"]) == sorted({"parameters.png", *names})


def test_a_component_is_refused_with_the_reason(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A part without a rod cannot be simulated: one message, no traceback, exit code of wrong usage."""
    lines = ["time_s,T01_degC,drift_um", *(f"{t},{20.0 + t * 1e-4:.4f},{t * 1e-3:.4f}" for t in range(0, 3600, 10))]
    (tmp_path / "run.csv").write_text("\n".join(lines) + "\n")
    (tmp_path / "campaign.toml").write_text(
        'format = "hexathermal-campaign/1"\nkind = "component"\n[[runs]]\nname = "a"\nfile = "run.csv"\n'
        'role = "identification"\n[[thermocouples]]\nname = "T01"\n'
    )
    assert main(["compare", str(tmp_path)]) == 2
    shown = capsys.readouterr()
    assert "kind 'component'" in shown.err
    assert "Traceback" not in shown.err
    assert not shown.out


def test_pictures_never_go_into_the_campaign(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A folder inside of the campaign is refused before any work."""
    before = {file.name for file in folder.rglob("*")}
    assert main(["compare", str(folder), "--plots", str(folder / "plots")]) == 2
    assert "read" in capsys.readouterr().err
    assert {file.name for file in folder.rglob("*")} == before


def test_too_short_a_run_says_how_long_it_must_be(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Twenty minutes tell nothing of a leg that warms for hours: the reason names the run and the limit, and stands
    before all else; runs for validation and thermocouples are no part of it.
    """
    from hexathermal.compare.measured import measured_run

    place = tmp_path / "short"
    (place / "runs").mkdir(parents=True)
    (place / "campaign.toml").write_text((folder / "campaign.toml").read_text())
    for name in ("run-01", "run-02", "run-03"):
        rows = (folder / "runs" / f"{name}.csv").read_text().splitlines()
        time = np.array([float(row.split(",")[0]) for row in rows[1:]])
        (place / "runs" / f"{name}.csv").write_text("\n".join(rows[: 1 + int((time < 1200.0).sum())]) + "\n")
    campaign = load_campaign(place)
    found = measured_run(campaign, campaign.runs[0], (0, 1))
    assert isinstance(found, str)
    assert "run-01" in found
    assert "45 min" in found
    assert main(["compare", str(place)]) == 3
    said = capsys.readouterr().err.splitlines()
    assert said[0].endswith("no run for identification can be compared")
    assert said[1].startswith("  run run-01 is not compared: its usable rows last 1")
    assert said[2].startswith("  run run-02 is not compared")
    assert len(said) == 3


def test_one_run_names_nothing(folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """With one run for identification none can be left out: refused, with what there is and what it needs."""
    place = tmp_path / "one"
    shutil.copytree(folder, place)
    text = (place / "campaign.toml").read_text()
    (place / "campaign.toml").write_text(text.replace('"identification"', '"validation"', 1))
    assert main(["compare", str(place)]) == 3
    shown = capsys.readouterr()
    assert "1 run for identification can be compared; it needs 2" in shown.err
    assert "left out is foretold better: measure more runs" in shown.err
    assert not shown.out


@pytest.mark.parametrize("still", [("T",), ("T", "beam", "q_")])
def test_data_that_never_change_are_refused(
    still: tuple[str, ...], folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Columns that hold one value throughout: the message asks whether anything changes, none of numerics."""
    place = tmp_path / "still"
    shutil.copytree(folder, place)
    for file in place.rglob("*.csv"):
        rows = [row.split(",") for row in file.read_text().splitlines()]
        for k, name in enumerate(rows[0]):
            if name.startswith(still):
                for row in rows[2:]:
                    row[k] = rows[1][k]
        file.write_text("".join(",".join(row) + "\n" for row in rows))
    assert main(["compare", str(place)]) == 3
    shown = capsys.readouterr()
    assert "no thermocouple changes in any run for identification: do the temperatures" in shown.err
    assert "inside hexathermal" not in shown.err


def test_channels_that_cannot_be_weighed_are_refused(
    folder: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Where the covariance of the channels cannot be inverted, the data are named, not the numerics."""
    from hexathermal.compare import comparison

    def singular(*_: object) -> None:
        raise np.linalg.LinAlgError("not positive definite")

    monkeypatch.setattr(comparison, "calibrated", singular)
    assert main(["compare", str(folder)]) == 3
    shown = capsys.readouterr()
    assert "leave nothing to weigh by: do the temperatures, the drift or q change at all?" in shown.err
    assert "inside hexathermal" not in shown.err
