"""``hexathermal budget``: what it answers is what the library answers; wrong input is explained."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import numpy as np
import pytest

import hexathermal as ht
from hexathermal import cli

Said = pytest.CaptureFixture[str]
HOME = ["budget", "--machine", "reference", "--pose", "0", "0", "0", "0", "0", "0"]
WARM = [*HOME, "--temps", "25"]


def test_json_is_the_budget_of_the_library(capsys: Said, reference: ht.Hexapod) -> None:
    """--json - prints the library's budget and nothing else; commas and blanks part numbers alike."""
    words = ["budget", "--machine", "reference", "--pose", "5", "-10", "12", "0", "1.5", "0", "--temps",
             "25,24,26,25.5,23,22", "--at-tool", "-5,0,120", "--frame", "object", "--json", "-"]  # fmt: skip
    assert cli.main(words) == 0
    said = json.loads(capsys.readouterr().out)["budget"]
    pose = ht.pose_from_coordinates([5, -10, 12, 0, 1.5, 0], hexapod=reference)
    own = reference.error_budget(pose, [25, 24, 26, 25.5, 23, 22], at_tool=[-0.005, 0, 0.12], frame="object")
    assert np.allclose(said["covariance"], own.covariance * 1e12, rtol=1e-12)
    assert np.allclose(said["bias_remaining"], own.remaining * 1e6, rtol=1e-9, atol=1e-12)
    assert [item["label"] for item in said["contributions"]] == [item.label for item in own.contributions]


@pytest.mark.long
def test_tables_files_and_verdict(capsys: Said, tmp_path: Path) -> None:
    """A budget with Monte Carlo says its verdict, what was assumed, and writes a table and a picture."""
    out = tmp_path / "b"
    few = ["--without", "base joint position", "platform joint position", "plate temperature"]
    assert cli.main([*WARM, "--monte-carlo", *few, "--out", str(out)]) == 0
    said = capsys.readouterr().out
    for words in ("worst case", "law residual", "linear budget may be used", "No thermometer on the base", "Written"):
        assert words in said
    assert "base joint position" not in said
    with (out / "budget.csv").open() as file:
        rows = list(csv.DictReader(file))
    squares = sum(float(row["z_um"]) ** 2 for row in rows if row["kind"] == "source")
    assert squares == pytest.approx(float(rows[-1]["z_um"]) ** 2)
    assert (out / "contributions.png").read_bytes().startswith(b"\x89PNG")
    assert cli.main([*WARM, "--out", str(out)]) == 2
    assert "already" in capsys.readouterr().err
    assert cli.main([*WARM, "--out", str(out), "--force"]) == 0


def test_a_monte_carlo_keeps_to_its_tolerance_and_draws(capsys: Said) -> None:
    """The tolerance is a percentage of each axis' standard uncertainty; a fine one is not decided with few draws."""
    said = []
    for words in (["--tolerance", "20"], ["--tolerance", "1", "--most-draws", "100000"]):
        assert cli.main([*WARM, "--monte-carlo", *words, "--json", "-"]) == 0
        said.append(json.loads(capsys.readouterr().out))
    for one, part in zip(said, (0.2, 0.01), strict=True):
        u = one["budget"]["standard_uncertainty"]
        assert one["monte_carlo"]["tolerance"] == pytest.approx([part * value for value in u])
    assert [one["monte_carlo"]["linear_may_be_used"] for one in said] == [True, None]
    assert said[1]["monte_carlo"]["draws"] == 100_000


@pytest.mark.long
def test_map_tells_the_worst_pose(capsys: Said, tmp_path: Path) -> None:
    """A map writes every pose, those out of reach with their reason, and names the worst."""
    out = tmp_path / "m"
    assert cli.main([*WARM, "--map", "x=-40:40:3", "z=0:400:2", "--out", str(out)]) == 0
    said = capsys.readouterr().out
    assert "Worst shift:" in said
    assert "Out of reach: 3 of 6" in said
    with (out / "map.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [row["refused"] == "" for row in rows] == [True, False] * 3
    assert (out / "map.png").stat().st_size > 10_000


@pytest.mark.long
@pytest.mark.parametrize("grids", [["x=0:0:1"], ["x=0:0:1", "y=1:1:3"], ["x=0:40:2", "y=0:40:2", "z=0:1:1"]])
def test_maps_of_one_value(grids: list[str], tmp_path: Path) -> None:
    """Grids with one value, or with equal ends, are drawn without a warning; three coordinates are not drawn."""
    assert cli.main([*WARM, "--map", *grids, "--out", str(tmp_path / "m")]) == 0
    assert (tmp_path / "m" / "map.png").exists() == (len(grids) < 3)


def test_a_path_from_a_file(capsys: Said, tmp_path: Path) -> None:
    """Poses of a file are budgets of the library, in their order; those out of reach are told."""
    file, out = tmp_path / "p.csv", tmp_path / "out"
    file.write_text("time_s,x_mm,y_mm,z_mm,rx_deg,ry_deg,rz_deg\n0,0,0,0,0,0,0\n1,30,0,0,0,2,0\n2,0,0,900,0,0,0\n")
    words = ["budget", "--machine", "reference", "--temps", "25"]
    assert cli.main([*words, "--path", str(file), "--out", str(out)]) == 0
    assert "Out of reach: 1 of 3" in capsys.readouterr().out
    with (out / "path.csv").open() as table:
        rows = list(csv.DictReader(table))
    reference = ht.load_hexapod("reference")
    pose = ht.pose_from_coordinates([30, 0, 0, 0, 2, 0], hexapod=reference)
    own = reference.error_budget(pose, [25.0] * 6)
    assert float(rows[1]["worst_case_x_um"]) == pytest.approx(own.worst_case()[0] * 1e6)
    assert (out / "path.png").stat().st_size > 10_000
    assert cli.main(words) == 2
    assert "--path FILE" in capsys.readouterr().err


@pytest.mark.long
def test_temperatures_of_a_path_pair_up_as_in_correct(capsys: Said, tmp_path: Path) -> None:
    """Where both files have time_s, `correct` and `budget` interpolate alike; files that do not fit are refused."""
    poses, temps, out = tmp_path / "p.csv", tmp_path / "t.csv", tmp_path / "out"
    poses.write_text(
        "time_s,x_mm,y_mm,z_mm,rx_deg,ry_deg,rz_deg\n" + "".join(f"{30 * k},0,0,0,0,0,0\n" for k in range(6))
    )
    names = ",".join(f"leg{i}_T1_degC" for i in range(1, 7))
    temps.write_text(f"time_s,{names}\n0,20,20,20,20,20,20\n60,22,22,22,22,22,23\n150,25,25,25,25,25,25\n")
    words = ["--machine", "reference", "--temps", str(temps)]
    assert cli.main(["budget", *words, "--path", str(poses), "--out", str(out)]) == 0
    assert "interpolated linearly at the poses' time_s" in capsys.readouterr().out
    with (out / "path.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [float(row["leg1_T1_degC"]) for row in rows] == pytest.approx([20, 21, 22, 23, 24, 25])
    assert [float(row["leg6_T1_degC"]) for row in rows] == pytest.approx([20, 21.5, 23, 71 / 3, 73 / 3, 25])
    assert cli.main(["correct", *words, "--poses", str(poses), "--out", str(tmp_path / "c.csv")]) == 0
    temps.write_text(f"{names}\n" + "20,20,20,20,20,20\n" * 3)
    capsys.readouterr()
    assert cli.main(["budget", *words, "--path", str(poses)]) == 3
    assert "give as many, or one row of temperatures for all, or time_s in both files" in capsys.readouterr().err


def test_a_bounded_value_that_rules_is_hinted_at(capsys: Said, tmp_path: Path) -> None:
    """Where one uniform value rules an axis, Monte Carlo is advised; few degrees of freedom are warned of."""
    file = tmp_path / "s.toml"
    head = 'format = "hexathermal-sources/1"\ndefaults = false\n[[source]]\nlabel = "l"\nquantity = '
    file.write_text(head + '"pose"\nhalf_width = [1e-6, 0, 0, 0, 0, 0]\n')
    assert cli.main([*WARM, "--sources", str(file)]) == 0
    assert "One bounded value rules x (l)" in capsys.readouterr().out
    file.write_text(head + '"length"\nstandard = 1e-6\ndof = 1\n')
    assert cli.main([*WARM, "--sources", str(file)]) == 0
    assert "no 6-D region" in capsys.readouterr().err


def test_day_from_a_file_and_simulated(capsys: Said, tmp_path: Path) -> None:
    """A file of temperatures is a day; so is the simulated one, with its plates' temperatures."""
    names = ",".join(f"leg{i}_T1_degC" for i in range(1, 7))
    table = tmp_path / "t.csv"
    table.write_text(f"time_s,{names}\n" + "".join(f"{600 * k},{','.join([str(20 + k)] * 6)}\n" for k in range(4)))
    out = tmp_path / "d"
    assert cli.main([*HOME, "--temps", str(table), "--out", str(out)]) == 0
    assert "Worst shift:" in capsys.readouterr().out
    with (out / "day.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [float(row["time_s"]) for row in rows] == [0, 600, 1200, 1800]
    assert (out / "day.png").exists()
    assert cli.main([*HOME, "--day", "--json", "-"]) == 0
    said = json.loads(capsys.readouterr().out)
    assert len(said["day"]["rows"]) > 50
    assert said["day"]["worst"]["shift"]["reason"]


def test_gradients_and_plates(capsys: Said) -> None:
    """Gradients and temperatures of plates change the bias as the library's do."""
    words = [*WARM, "--plate-temps", "22", "21", "--leg-gradient", "2", "0", "0", "--base-gradient", "0", "3", "0"]
    assert cli.main([*words, "--json", "-"]) == 0
    said = json.loads(capsys.readouterr().out)["budget"]
    assert max(said["temperatures_degC"]) > 25.1
    assert abs(said["bias_remaining"][3]) > 1e-3


@pytest.mark.parametrize(
    ("words", "code", "message"),
    [
        (["--pose", "1", "2"], 2, "6 finite numbers"),
        (["--pose", "1", "2", "3", "4", "5", "nan"], 2, "6 finite numbers"),
        (["--temps", "1", "2"], 2, "one temperature"),
        (["--temps", "none.csv"], 2, "not there"),
        (["--temps", "90"], 3, "range of validity"),
        (["--plate-temps", "23", "900"], 3, "temperature of the base is 900 degC, outside the law's range of validity"),
        (["--plate-temps", "296", "21"], 3, "of the platform is 296 degC, outside the law's range of validity [0, 50] "
         "degC; was it given in kelvin?"),
        (["--air", "293"], 3, "of the air is 293 degC, outside the law's range of validity [0, 50] degC; was it given "
         "in kelvin?"),
        (["--pose", "0", "0", "900", "0", "0", "0"], 4, "out of stroke"),
        (["--machine", "rubin-camera"], 2, "no thermal law"),
        (["--map", "x=1:2"], 2, "no span"),
        (["--map", "x=0:1:2", "x=0:1:2"], 2, "twice"),
        (["--map", "x=0:1:0"], 2, "whole number"),
        (["--probability", "2"], 2, "probability"),
        (["--without", "backlsh"], 2, "did you mean 'backlash'?"),
        (["--frame", "user"], 2, "needs --user-frame"),
        (["--at-tool", "1"], 2, "3 finite numbers"),
        (["--at-tool", "0", "0", "1e9"], 2, "--at-tool 0 0 1e9 is more than 1000 m from the platform's origin"),
        (["--object-frame", "0", "0", "1e9", "0", "0", "0"], 2, "the origin of the object frame holds 1e+06 m"),
        (["--temps", "nan"], 2, "one finite number"),
        (["--path", "none.csv"], 2, "not there"),
        (["--path", "none.csv", "--map", "x=0:1:2"], 2, "different questions"),
        (["--sources", "none.toml"], 2, "no file of sources"),
        (["--frame", "tool"], 2, "invalid choice"),
        (["--tolerance", "5"], 2, "--monte-carlo"),
        (["--monte-carlo", "--tolerance", "0"], 2, "no percentage"),
        (["--monte-carlo", "--most-draws", "1e6"], 2, "no whole number of draws"),
        (["--monte-carlo", "--most-draws", "900"], 2, "most_draws is 900"),
    ],
)  # fmt: skip
def test_wrong_input_is_explained(words: list[str], code: int, message: str, capsys: Said) -> None:
    """Wrong input ends with its exit code and one message; no traceback, nothing on stdout."""
    given = list(WARM)
    if words[0] in ("--pose", "--temps", "--machine"):
        first = given.index(words[0])
        last = next((k for k in range(first + 1, len(given)) if given[k].startswith("--")), len(given))
        given[first:last] = words
    else:
        given += words
    assert cli.main(given) == code
    said = capsys.readouterr()
    assert message in said.err
    assert "Traceback" not in said.err
    assert said.out == ""
