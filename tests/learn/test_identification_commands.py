"""identify, validate and apply from the command line, on a campaign drawn into a folder."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import hexathermal as ht
from hexathermal.cli import main
from tests.learn.legs import SENSORS, drawn_leg


@pytest.fixture(scope="module")
def campaign(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A campaign folder with four runs to identify and two to validate."""
    folder = tmp_path_factory.mktemp("campaign")
    rng = np.random.default_rng(5)
    blocks = drawn_leg(rng, runs=4, hours=1.5) + drawn_leg(rng, runs=2, hours=1.5, role="validation")
    lines = ['format = "hexathermal-campaign/1"', 'kind = "leg"', 'title = "drawn"', "[leg]", "q0_mm = 600.0",
             "stroke_mm = [0.0, 250.0]", "[interferometer]", "radius_mm = 60.0", "azimuth_deg = [0.0, 120.0, 240.0]",
             "dead_path_mm = 750.0", "index_compensated = true"]  # fmt: skip
    lines += [line for name in SENSORS for line in ("[[thermocouples]]", f'name = "{name}"')]
    for block in blocks:
        name = block.run.name
        lines += ["[[runs]]", f'name = "{name}"', f'file = "{name}.csv"', f'role = "{block.run.role}"']
        head = ["time_s", "q_mm", "settled", *(f"{sensor}_degC" for sensor in SENSORS), "beam1_mm", "beam2_mm",
                "beam3_mm", "air_temperature_degC", "air_pressure_hPa", "air_humidity_percent"]  # fmt: skip
        n = len(block)
        beam = (block.drift + block.q - block.q[0]) * 1e3
        table = np.column_stack([block.time, block.q * 1e3, np.ones(n), 20.0 + block.dT, beam, beam, beam,
                                 np.full((n, 3), [20.0, 1013.0, 45.0]) + 0.01 * rng.normal(size=(n, 3))])  # fmt: skip
        np.savetxt(folder / f"{name}.csv", table, delimiter=",", header=",".join(head), comments="", fmt="%.9g")
    (folder / "campaign.toml").write_text("\n".join(lines) + "\n", encoding="utf-8")
    return folder


def test_from_campaign_to_machine(campaign: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """identify, validate and apply in a row: a law near the truth, a validation that says so, a machine that reads."""
    law, report = tmp_path / "leg.toml", tmp_path / "report"
    assert main(["identify", str(campaign), "--sensors", "T07", "--out", str(law), "--report", str(report),
                 "--json", str(tmp_path / "i.json")]) == 0  # fmt: skip
    facts = json.loads((tmp_path / "i.json").read_text(encoding="utf-8"))
    assert facts["sensors"] == ["T07"]
    for one, truth in zip(facts["coefficients"], (2.0, 1.1), strict=True):
        assert abs(one["value"] - truth) < 4.0 * one["standard_uncertainty"]
    names = {"sets.csv", "matrix-rmse.csv", "matrix-linf.csv", "matrices.png", "matrices.svg", "front.png", "front.svg",
             "identification.json"}  # fmt: skip
    assert {file.name for file in report.iterdir()} == names
    assert len((report / "sets.csv").read_text(encoding="utf-8").splitlines()) == 1 + 153
    assert main(["validate", str(law), str(campaign), "--report", str(report), "--json", str(tmp_path / "v.json")]) == 0
    found = json.loads((tmp_path / "v.json").read_text(encoding="utf-8"))
    assert found["verdict"] == "makes it better"
    assert found["total"]["mean_reduction"]["value"] > 0.7
    assert (report / "validation-0.png").exists()
    assert main(["apply", str(law), "--machine", "reference", "--out", str(tmp_path / "machine")]) == 0
    hexapod = ht.load_hexapod(str(tmp_path / "machine"))
    assert hexapod.thermal is not None
    assert hexapod.thermal.legs[0].A[0] * 1e6 == pytest.approx(facts["coefficients"][0]["value"], rel=1e-12)
    assert hexapod.thermal.legs[0].covariance is not None
    capsys.readouterr()


def test_wrong_input_is_one_message(campaign: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Unknown sensor, existing file, missing law, five laws: each one message that says what to do, no traceback."""
    law = tmp_path / "leg.toml"
    assert main(["identify", str(campaign), "--sensors", "T07", "--out", str(law)]) == 0
    cases = [
        (["identify", str(campaign), "--sensors", "T77"], "it has T01"),
        (["identify", str(campaign), "--sensors", "T07", "--out", str(law)], "--force"),
        (["identify", str(tmp_path)], "campaign.toml"),
        (["validate", str(tmp_path / "no.toml"), str(campaign)], "'hexathermal identify' writes"),
        (
            ["apply", *[str(law)] * 5, "--machine", "reference", "--out", str(tmp_path / "m")],
            "one for all legs, or six",
        ),
        (["apply", str(law), "--machine", "reference", "--out", str(tmp_path / "m"), "--margin", "-1"], "0 or more"),
    ]
    capsys.readouterr()
    for arguments, said in cases:
        assert main(arguments) in (2, 3)
        err = capsys.readouterr().err
        assert said in err, (arguments, err)
        assert "Traceback" not in err


def test_legs_that_are_alike_get_one_law(campaign: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """--common writes a law fitted to the runs of all legs where one serves all: twice the runs, less uncertainty."""
    own, common = tmp_path / "own.json", tmp_path / "common.json"
    assert main(["identify", str(campaign), "--sensors", "T07", "--json", str(own)]) == 0
    law = tmp_path / "leg.toml"
    words = ["--sensors", "T07", "--common", str(campaign), "--out", str(law), "--json", str(common)]
    assert main(["identify", str(campaign), *words]) == 0
    one, two = (json.loads(file.read_text(encoding="utf-8")) for file in (own, common))
    assert two["common_law_written"]
    assert len(two["runs"]) == 2 * len(one["runs"])
    for alone, shared in zip(one["coefficients"], two["coefficients"], strict=True):
        assert shared["standard_uncertainty"] < alone["standard_uncertainty"]
    assert "one law serves all legs" in capsys.readouterr().out
