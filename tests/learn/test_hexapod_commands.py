"""A whole machine from the command line: simulate, identify, validate, propose; and wrong input."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import hexathermal as ht
from hexathermal.cli import main
from hexathermal.learn.hexapod_data import AXES
from hexathermal.learn.law import IdentifiedLaw, Origin, Validity
from hexathermal.learn.leg_law_files import write_leg_law
from hexathermal.learn.noise import ResidualNoise
from hexathermal.learn.sensor_errors import SensorErrors


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a simulated campaign of unequal legs and its truth."""
    folder = tmp_path_factory.mktemp("six")
    assert main(["simulate", "machine", "--out", str(folder / "campaign"), "--runs", "4", "--validation", "2", "--rows",
                 "80", "--spread", "0.15", "--truth", str(folder / "truth.json"), "--json",
                 str(folder / "s.json")]) == 0  # fmt: skip
    return folder


@pytest.mark.long
def test_from_simulation_to_validation(place: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """simulate, identify, validate in a row: laws near those that fit the truth best from what the thermometers
    read; a machine that reads; errors of the platform on runs never fitted fall by more than 70 %; pictures and numbers
    are written.
    """
    machine, report = tmp_path / "machine", tmp_path / "report"
    assert main(["identify", str(place / "campaign"), "--out", str(machine), "--report", str(report), "--propose", "20",
                 "--json", str(tmp_path / "i.json")]) == 0  # fmt: skip
    facts = json.loads((tmp_path / "i.json").read_text(encoding="utf-8"))
    truth = json.loads((place / "truth.json").read_text(encoding="utf-8"))
    own = {one["name"]: one for one in facts["laws"]["leg-specific"]["coefficients"]}
    for leg in range(6):
        effective = truth["legs"][leg]["as_read"]
        found = own[f"leg{leg + 1} A T1"]
        assert abs(found["value"] - effective["A_per_K"] * 1e6) < max(4.0 * found["standard_uncertainty"], 0.15)
    assert facts["chosen"] == "leg-specific"
    assert ht.load_hexapod(machine).thermal is not None
    names = {"laws.png", "laws.svg", "observability.png", "observability.svg", "poses.csv", "identification.json"}
    assert {file.name for file in report.iterdir()} == names
    assert len(facts["proposal"]["poses"]) == 20
    assert np.mean(np.divide(facts["proposal"]["proposed_um_per_m_K"], facts["proposal"]["random_um_per_m_K"])) < 1.0
    assert main(["validate", str(machine), str(place / "campaign"), "--report", str(report), "--json",
                 str(tmp_path / "v.json")]) == 0  # fmt: skip
    found = json.loads((tmp_path / "v.json").read_text(encoding="utf-8"))
    assert found["verdict"]["translation"] == "makes it better"
    assert found["total"]["translation"]["reduction"]["value"] > 0.7
    assert found["total"]["z"]["unit"] == "um"
    assert found["total"]["rz"]["unit"] == "urad"
    assert set(found["runs"]) == {"run-05", "run-06"}
    assert (report / "run-05.png").exists()
    assert "Verdict on translation" in capsys.readouterr().out


def test_proposed_poses_can_be_simulated(place: Path, tmp_path: Path) -> None:
    """The table of proposed poses is what ``simulate machine --poses`` takes, and those poses are measured."""
    assert main(["identify", str(place / "campaign"), "--report", str(tmp_path), "--propose", "12"]) == 0
    assert main(["simulate", "machine", "--out", str(tmp_path / "next"), "--poses", str(tmp_path / "poses.csv"),
                 "--runs", "1", "--validation", "0", "--rows", "24"]) == 0  # fmt: skip
    told = np.genfromtxt(tmp_path / "poses.csv", delimiter=",", names=True)
    done = np.genfromtxt(tmp_path / "next" / "runs" / "run-01.csv", delimiter=",", names=True)
    want = {tuple(row[f"{axis}_{'mm' if len(axis) == 1 else 'deg'}"] for axis in AXES) for row in told}
    assert {tuple(row[f"{axis}_{'mm' if len(axis) == 1 else 'deg'}"] for axis in AXES) for row in done} <= want


def test_laws_of_a_bench_are_compared(place: Path, tmp_path: Path) -> None:
    """Six leg.toml with the laws that fit the truth are compared beside; one that is far off is not chosen."""
    truth = json.loads((place / "truth.json").read_text(encoding="utf-8"))

    def law(A: float, B: float, file: Path) -> str:
        made = IdentifiedLaw("leg", ("T1",), np.array([A, B]), np.eye(2) * 1e-16, 0.6, (0.0, 0.25), "campaign",
                             Validity(np.array([[-1.0, 10.0]])), ResidualNoise(1e-7, 1e-7, 1e-7, 600.0, 1e-7),
                             SensorErrors(np.array([0.01]), np.array([0.01]), 3600.0),
                             origin=Origin("bench", "-", ("run-1",), "-"))  # fmt: skip
        return str(write_leg_law(made, file))

    files = [law(leg["as_read"]["A_per_K"], leg["as_read"]["B_per_K"], tmp_path / f"leg{k}.toml")
             for k, leg in enumerate(truth["legs"])]  # fmt: skip
    wrong = law(4e-6, 0.0, tmp_path / "wrong.toml")
    chosen = []
    for legs in (files, [wrong]):
        assert main(["identify", str(place / "campaign"), "--legs", *legs, "--json", str(tmp_path / "i.json")]) == 0
        facts = json.loads((tmp_path / "i.json").read_text(encoding="utf-8"))
        chosen.append((facts["chosen"], facts["laws"]["bench"]["left_out_rmse"]["translation_um"]))
    assert chosen[1][0] == "leg-specific"
    assert chosen[0][1] < 0.5 * chosen[1][1]


def test_wrong_input_is_one_message(place: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """What cannot be is said in one message with what to try, no traceback."""
    campaign = str(place / "campaign")
    (tmp_path / "poses.csv").write_text("x_mm,y_mm,z_mm,rx_deg,ry_deg,rz_deg\n0,0,900,0,0,0\n", encoding="utf-8")
    far = "x_mm,y_mm,z_mm,rx_deg,ry_deg,rz_deg\n0,0,0,0,0,0\n\n0,0,3e9,0,0,0\n"
    (tmp_path / "far.csv").write_text(far, encoding="utf-8")
    (tmp_path / "bad.csv").write_text("x_mm,y_mm,z_mm,rx_deg,ry_deg,rz_deg\n0,0,zero,0,0,0\n", encoding="utf-8")
    new = str(tmp_path / "new")
    cases = [
        (["identify", campaign, "--out", campaign], "give another"),
        (["identify", campaign, "--sensors", "T9"], "all legs have: T1"),
        (["identify", campaign, "--propose", "2"], "6 to 500"),
        (["identify", campaign, "--noise-um", "1"], "both --noise-um and --noise-urad"),
        (["identify", campaign, "--triples"], "campaigns of one leg"),
        (["identify", campaign, "--legs", "a.toml", "b.toml"], "one leg.toml for all legs, or six"),
        (["validate", "rubin-camera", campaign], "no thermal law"),
        (["validate", "nothing", campaign], "neither a bundled machine"),
        (["simulate", "machine", "--out", campaign], "holds a campaign already"),
        (["simulate", "machine", "--out", new, "--spread", "2"], "--spread must be 0 to 0.3"),
        (["simulate", "machine", "--out", new, "--poses", str(tmp_path / "poses.csv")], "poses.csv, line 2: leg"),
        (
            ["simulate", "machine", "--out", new, "--poses", str(tmp_path / "far.csv")],
            "far.csv, line 4: the pose is far outside the machine (x_mm = 0, y_mm = 0, z_mm = 3e+09",
        ),
        (["simulate", "machine", "--out", new, "--poses", str(tmp_path / "bad.csv")], "line 2, column 3"),
        (["simulate", "machine", "--out", new, "--truth", new + "/t.json"], "inside the campaign's folder"),
        (["simulate", "machine", "--out", new, "--runs", "0", "--validation", "0"], "nothing to simulate"),
        (["simulate", "machine", "--out", new, "--sensors", "T1,,"], "give different names"),
        (["simulate", "bench", "--out", campaign], "holds what no campaign of kind 'leg' has"),
    ]
    for argv, words in cases:
        capsys.readouterr()
        assert main(argv) in (2, 3, 4), argv
        said = capsys.readouterr()
        assert words in said.err, said.err
        assert "Traceback" not in said.err
        assert said.out == ""
    assert not Path(new).exists()


def test_a_lost_pose_does_not_move_the_zero_of_temperatures(tmp_path: Path) -> None:
    """Temperatures count from the first row of the first run, also where the tracker lost its first poses."""
    from hexathermal.learn.campaign_files import load_campaign
    from hexathermal.learn.hexapod_data import hexapod_rows

    words = ["simulate", "machine", "--out", str(tmp_path / "c"), "--runs", "1", "--validation", "1", "--rows", "30"]
    assert main(words) == 0
    before = hexapod_rows(load_campaign(tmp_path / "c"), "identification")
    table = next(iter(sorted((tmp_path / "c" / "runs").iterdir())))
    lines = table.read_text(encoding="utf-8").splitlines()
    column = lines[0].split(",").index("measured_x_mm")
    for k in range(1, 6):
        fields = lines[k].split(",")
        fields[column] = ""
        lines[k] = ",".join(fields)
    table.write_text("\n".join(lines) + "\n", encoding="utf-8")
    after = hexapod_rows(load_campaign(tmp_path / "c"), "identification")
    assert len(after.time) == len(before.time) - 5
    assert np.array_equal(after.zero_degC, before.zero_degC)
    assert np.array_equal(after.dT, before.dT[5:])


def test_laws_of_a_bench_choose_their_thermometer(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Legs with two thermometers, a bench law that reads the one which the machine's own law does not: it is taken
    without further options; --sensors that leave it out are refused.
    """
    words = ["simulate", "machine", "--out", str(tmp_path / "c"), "--sensors", "T1,T2", "--runs", "2", "--validation"]
    assert main([*words, "0", "--rows", "40"]) == 0
    made = IdentifiedLaw("leg", ("T2",), np.array([2e-6, 1e-6]), np.eye(2) * 1e-16, 0.6, (0.0, 0.25), "campaign",
                         Validity(np.array([[-1.0, 10.0]])), ResidualNoise(1e-7, 1e-7, 1e-7, 600.0, 1e-7),
                         SensorErrors(np.array([0.01]), np.array([0.01]), 3600.0),
                         origin=Origin("bench", "-", ("run-1",), "-"))  # fmt: skip
    file = str(write_leg_law(made, tmp_path / "leg.toml"))
    assert main(["identify", str(tmp_path / "c"), "--legs", file, "--json", str(tmp_path / "i.json")]) == 0
    facts = json.loads((tmp_path / "i.json").read_text(encoding="utf-8"))
    assert facts["sensors"] == ["T2"]
    assert "bench" in facts["laws"]
    capsys.readouterr()
    assert main(["identify", str(tmp_path / "c"), "--legs", file, "--sensors", "T1"]) == 2
    assert "read 'T2', which --sensors leaves out" in capsys.readouterr().err
