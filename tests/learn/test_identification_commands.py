"""identify, validate and apply from the command line, on a campaign drawn into a folder."""

from __future__ import annotations

import dataclasses
import json
import shutil
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.csv
import pyarrow.parquet as pq
import pytest

import hexathermal as ht
from hexathermal.cli import main
from hexathermal.learn.campaign_dataset import read_run
from hexathermal.learn.campaign_files import load_campaign
from hexathermal.learn.campaign_laws import identify_campaign, validate_campaign
from hexathermal.learn.leg_law_files import read_leg_law, write_leg_law
from hexathermal.show import identification_figures
from tests.learn.legs import SENSORS, drawn_leg


@pytest.fixture(scope="module")
def campaign(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A campaign folder with four runs to identify and two to validate."""
    return written(tmp_path_factory.mktemp("campaign"), 5)


def written(folder: Path, seed: int, degrees: float = 1.0, shift: float = 0.0) -> Path:
    """Write a drawn campaign; its thermometers show so many degrees for each kelvin, its scale is shifted [mm]."""
    rng = np.random.default_rng(seed)
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
        shown = 32.0 * (degrees > 1.0) + degrees * (20.0 + block.dT)
        table = np.column_stack([block.time, block.q * 1e3 + shift, np.ones(n), shown, beam, beam, beam,
                                 np.full((n, 3), [20.0, 1013.0, 45.0]) + 0.01 * rng.normal(size=(n, 3))])  # fmt: skip
        np.savetxt(folder / f"{name}.csv", table, delimiter=",", header=",".join(head), comments="", fmt="%.9g")
    (folder / "campaign.toml").write_text("\n".join(lines) + "\n", encoding="utf-8")
    return folder


@pytest.mark.long
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


def test_python_gives_what_the_command_line_gives(campaign: Path, tmp_path: Path) -> None:
    """`identify_campaign` and `validate_campaign` give the written law and the printed figures; the law tells the
    temperatures that its sensor met.
    """
    law, answer = tmp_path / "leg.toml", tmp_path / "v.json"
    assert main(["identify", str(campaign), "--sensors", "T07", "--out", str(law)]) == 0
    assert main(["validate", str(law), str(campaign), "--json", str(answer)]) == 0
    loaded = load_campaign(campaign)
    found = identify_campaign(loaded, "T07")
    assert np.array_equal(found.law.coefficients, read_leg_law(law).coefficients)
    assert found.law.origin == read_leg_law(law).origin
    heat = [read_run(loaded, run)["temperature"].sel(thermocouple="T07") for run in loaded.runs_of("identification")]
    assert found.law.validity.degC == pytest.approx(
        (min(float(one.min()) for one in heat), max(float(one.max()) for one in heat))
    )
    assert read_leg_law(law).validity.degC == found.law.validity.degC
    steps: list[tuple[int, int]] = []
    total = validate_campaign(found.law, loaded, lambda done, of, _label: steps.append((done, of))).total
    shown = json.loads(answer.read_text(encoding="utf-8"))["total"]["rmse_um"]
    assert total.rmse.value * 1e6 == pytest.approx(shown["value"], rel=1e-12)
    assert steps == sorted(steps)
    assert steps[-1][0] == steps[-1][1] > 0


def test_a_fitted_run_is_warned_of_under_any_name(
    campaign: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A fitted table as a run for validation, renamed and stored as Parquet: warned of, marked, no proof."""
    law, other = tmp_path / "leg.toml", tmp_path / "other"
    assert main(["identify", str(campaign), "--sensors", "T07", "--out", str(law)]) == 0
    shutil.copytree(campaign, other)
    pq.write_table(pa.csv.read_csv(other / "identification-1.csv"), other / "night.parquet")
    text = (other / "campaign.toml").read_text(encoding="utf-8")
    text = text.replace('file = "validation-1.csv"', 'file = "night.parquet"').replace('"validation-1"', '"night"')
    (other / "campaign.toml").write_text(text, encoding="utf-8")
    capsys.readouterr()
    answer = tmp_path / "v.json"
    assert main(["validate", str(law), str(other), "--json", str(answer)]) == 0
    said = capsys.readouterr()
    assert "run night was fitted: the law was identified on its rows, then named identification-1" in said.err
    assert "night (fitted)" in said.out
    assert "all never fitted" in said.out
    facts = json.loads(answer.read_text(encoding="utf-8"))
    assert facts["fitted_runs"] == {"night": "identification-1"}
    assert facts["total"]["rmse_um"]["value"] == facts["runs"]["validation-0"]["rmse_um"]["value"]
    shutil.copy(other / "identification-0.csv", other / "validation-0.csv")
    assert main(["validate", str(law), str(other)]) == 0
    assert "Verdict: nothing proven: every run was fitted." in capsys.readouterr().out


@pytest.mark.long
def test_an_interrupted_report_leaves_nothing(
    campaign: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Ctrl-C while pictures are drawn: no law, no part of a report, an older report as it was."""
    law, report = tmp_path / "leg.toml", tmp_path / "deep" / "report"
    assert main(["identify", str(campaign), "--sensors", "T07", "--out", str(law)]) == 0

    def stopped(*_arguments: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(identification_figures, "front_figure", stopped)
    monkeypatch.setattr(identification_figures, "validation_figure", stopped)
    again = tmp_path / "again.toml"
    words = ["identify", str(campaign), "--sensors", "T07", "--out", str(again), "--report"]
    assert main([*words, str(report)]) == 130
    assert main(["validate", str(law), str(campaign), "--report", str(report)]) == 130
    assert [item.name for item in tmp_path.iterdir()] == ["leg.toml"]
    report.mkdir(parents=True)
    (report / "sets.csv").write_text("older", encoding="utf-8")
    assert main([*words, str(report)]) == 130
    assert [item.name for item in report.iterdir()] == ["sets.csv"]
    assert (report / "sets.csv").read_text(encoding="utf-8") == "older"
    assert not again.exists()
    assert "nothing half-written is left" in capsys.readouterr().err


def test_a_law_of_another_kind_is_refused_by_its_kind(
    campaign: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The law of a component meets a leg's campaign, or a machine: the kind is what is said."""
    law, text = tmp_path / "leg.toml", tmp_path / "component.toml"
    assert main(["identify", str(campaign), "--sensors", "T07", "--out", str(law)]) == 0
    leg = read_leg_law(law)
    component = dataclasses.replace(leg, kind="component", sensors=("other",), coefficients=leg.A.copy(),
                                    covariance=leg.covariance[:1, :1], retracted_length=None, stroke=None)  # fmt: skip
    write_leg_law(component, text)
    capsys.readouterr()
    assert main(["validate", str(text), str(campaign)]) == 2
    assert "the law of a component" in capsys.readouterr().err
    assert main(["apply", str(text), "--machine", "reference", "--out", str(tmp_path / "m")]) == 2
    assert "component.toml is the law of a component (C)" in capsys.readouterr().err


def test_a_law_that_makes_it_worse_says_how_much_more(
    campaign: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Residuals larger than the drift are so many per cent more, not less than nothing."""
    law = tmp_path / "leg.toml"
    assert main(["identify", str(campaign), "--sensors", "T07", "--out", str(law)]) == 0
    right = read_leg_law(law)
    write_leg_law(dataclasses.replace(right, coefficients=-right.coefficients), law)
    assert main(["validate", str(law), str(campaign)]) == 0
    said = capsys.readouterr().out
    assert "Verdict: the law makes it worse." in said
    assert " % more); mean " in said
    assert "(-" not in said


def test_wrong_input_is_one_message(campaign: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Unknown sensor, existing file, missing law, five laws: each one message that says what to do, no traceback."""
    law = tmp_path / "leg.toml"
    assert main(["identify", str(campaign), "--sensors", "T07", "--out", str(law)]) == 0
    cases = [
        (["identify", str(campaign), "--sensors", "T77"], "it has T01"),
        (["identify", str(campaign), "--sensors", "T07", "--out", str(law)], "--force"),
        (["identify", str(campaign), "--out", str(tmp_path / "no" / "leg.toml")], "create it first"),
        (["identify", str(campaign), "--report", str(campaign / "campaign.toml")], "campaign.toml"),
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
    other = tmp_path / "other"
    other.mkdir()
    words = ["--sensors", "T07", "--common", str(written(other, 6)), "--out", str(law), "--json", str(common)]
    assert main(["identify", str(campaign), *words]) == 0
    one, two = (json.loads(file.read_text(encoding="utf-8")) for file in (own, common))
    assert two["common_law_written"]
    assert len(two["runs"]) == 2 * len(one["runs"])
    for alone, shared in zip(one["coefficients"], two["coefficients"], strict=True):
        assert shared["standard_uncertainty"] < alone["standard_uncertainty"]
        assert abs(shared["value"] - alone["value"]) < 4.0 * alone["standard_uncertainty"]
    assert all(not leg["clearly_worse"] for leg in two["common_legs"].values())
    assert "one law serves all legs" in capsys.readouterr().out


def test_a_run_never_counts_for_two_legs(campaign: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A campaign that is its own other leg, by its name or as a copy, is refused; no law is written."""
    copy, law = tmp_path / "copy", tmp_path / "leg.toml"
    shutil.copytree(campaign, copy)
    for other in (campaign, copy):
        words = ["identify", str(campaign), "--sensors", "T07", "--common", str(other), "--out", str(law)]
        assert main(words) == 2
        assert "a run must not count for two legs" in capsys.readouterr().err
    assert not law.exists()


@pytest.mark.parametrize("command", ["identify", "diagnose"])
@pytest.mark.parametrize(
    ("names", "said"),
    [("T7", "did you mean 'T07'?"), ("T07,", "'T07,' holds an empty name"), (" , ", "names no sensor")],
)
def test_a_misspelt_sensor_is_told_alike(
    campaign: Path, command: str, names: str, said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """The suggestion is the sensor of the same number; an empty name is refused by every command."""
    assert main([command, str(campaign), "--sensors", names]) == 2
    assert said in capsys.readouterr().err


def test_blanks_around_a_sensor_do_not_matter(campaign: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """``--sensors "T07, T14"`` is the law of T07 and T14."""
    assert main(["identify", str(campaign), "--sensors", "T07, T14", "--quiet"]) == 0
    capsys.readouterr()


@pytest.mark.parametrize(
    ("degrees", "shift", "said"), [(1.8, 0.0, "degrees Fahrenheit?"), (1.0, 400.0, "outside stroke_mm")]
)
def test_a_law_of_other_units_is_warned_of(
    tmp_path: Path, degrees: float, shift: float, said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """Temperatures in degrees Fahrenheit and a scale with another zero make a law that `check` alone would doubt."""
    assert main(["identify", str(written(tmp_path, 5, degrees, shift)), "--sensors", "T07"]) == 0
    assert said in capsys.readouterr().err


def test_a_machine_is_never_written_into_measurements(
    campaign: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """apply leaves the folder of a campaign as it is, with --force too; bounds are told by their option."""
    law, before = tmp_path / "leg.toml", sorted(campaign.iterdir())
    assert main(["identify", str(campaign), "--sensors", "T07", "--out", str(law)]) == 0
    words = ["apply", str(law), "--machine", "reference", "--out"]
    cases = [
        ([str(campaign), "--force"], "measurements stay as they are"),
        ([str(tmp_path / "m"), "--margin", "1e9"], "--margin 1e+09 K"),
        ([str(tmp_path / "m"), "--reference", "1e9"], "is 1e+09 degC, outside what is usual [-60, 120] degC"),
        (
            [str(tmp_path / "m"), "--reference", "300"],
            "is 300 degC, outside what is usual [-60, 120] degC; was it given in kelvin?",
        ),
    ]
    capsys.readouterr()
    for last, said in cases:
        assert main([*words, *last]) == 2
        assert said in capsys.readouterr().err
    assert sorted(campaign.iterdir()) == before
    assert not (tmp_path / "m").exists()


def test_a_folder_named_as_a_bundled_machine_is_not_mistaken(
    campaign: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """`apply` proposes a path that means the new machine; the bare name, which has two meanings then, is refused."""
    monkeypatch.chdir(tmp_path)
    law = write_leg_law(identify_campaign(load_campaign(campaign), ["T07"]).law, tmp_path / "leg.toml")
    assert main(["apply", str(law), "--machine", "reference", "--out", "reference"]) == 0
    assert capsys.readouterr().out.endswith("next: hexathermal demo --machine ./reference\n")
    for command in ("show-machine", "report"):
        assert main([command, "reference"]) == 2
        said = capsys.readouterr().err
        assert "give ./reference for the folder, or " in said
    bundled = said.rpartition(", or ")[2].partition(" for")[0]
    for name, sensors in (("./reference", "T07"), (bundled, "T1")):
        assert main(["show-machine", name, "--json", "-"]) == 0
        assert sensors in capsys.readouterr().out
    monkeypatch.chdir(Path(bundled).parent)
    assert main(["show-machine", "reference"]) == 0  # the folder is the bundled machine itself
