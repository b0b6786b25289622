"""The command line: it teaches, answers what the library answers, states its exit codes, shows no traceback."""

from __future__ import annotations

import csv
import dataclasses
import io
import json
import signal
import sys
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
from rich.console import Console

import hexathermal as ht
from hexathermal import cli
from hexathermal.predict.trajectory import POSE_COLUMNS
from hexathermal.show.commands import machines
from hexathermal.show.tables import day_table, framed, reduction, width_of
from hexathermal.simulate.day import WorkingDay
from hexathermal.simulate.demonstration import demonstrate
from tests.trajectory_files import HEAT, POSE, POSES, SENSORS, correct_arguments

COMMANDS = ["demo", "correct", "machines", "show-machine", "warm-up"]
EXIT_CODES = {0, 1, 2, 3, 4, 130}

Said = pytest.CaptureFixture[str]


@pytest.fixture
def files(tmp_path: Path) -> list[str]:
    """Arguments of a `correct` that works: two poses, one row of temperatures."""
    return correct_arguments(tmp_path)


@pytest.mark.parametrize("command", [[], *([name] for name in COMMANDS)], ids=["top", *COMMANDS])
def test_help_teaches(command: list[str], capsys: Said) -> None:
    """Every help states the exit codes; it goes to stdout and succeeds."""
    assert cli.main([*command, "--help"]) == 0
    said = capsys.readouterr()
    assert "exit codes:" in said.out
    assert all(f"  {code} " in said.out for code in EXIT_CODES)
    assert "HEXATHERMAL_TRACEBACK" in said.out
    assert said.err == ""
    assert max(map(len, said.out.splitlines())) <= 120


def test_help_of_correct_names_columns_units_and_conventions(capsys: Said) -> None:
    """A user can write both files after reading the help, and finds every command in the first one."""
    cli.main(["correct", "--help"])
    said = capsys.readouterr().out
    formulas = ("R = Rz(rz) Ry(ry) Rx(rx)", "R = Rx(rx) Ry(ry) Rz(rz)")
    others = ("time_s", "leg1_T1_degC", "leg1_length_mm", "leg1_q_mm", "corrected_x_mm", "--user-frame", "examples:")
    for word in (*POSE_COLUMNS, *formulas, *others):
        assert word in said
    cli.main(["--help"])
    said = capsys.readouterr().out
    assert all(f"  {name} " in said for name in COMMANDS)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ([], "usage: hexathermal"),
        (["corect"], "did you mean 'correct'?"),
        (["machines", "--jso"], "did you mean '--json'?"),
        (["correct"], "required"),
        (["correct", "--mach", "reference"], "required"),
        (["show-machine", "reference", "--js"], "did you mean '--json'?"),
        (["show-machine", "referense"], "did you mean 'reference'?"),
        (["show-machine", "no\0thing"], "zero byte"),
        (["demo", "--seed", "-1"], "whole number"),
        (["demo", "--seed", "1.5"], "whole number"),
        (["demo", "--machine", "rubin-m2", "--out", "{tmp}/d"], "not active"),
        (["demo", "--out", "{tmp}/p.csv"], "no folder"),
        (["demo", "--out", ""], "empty"),
        (["show-machine", ""], "argument NAME: the name is empty"),
        (["demo", "--machine", ""], "argument --machine: the name is empty"),
        (["report", ""], "argument DIR: the name is empty"),
    ],
)
def test_wrong_usage_is_2_and_is_explained(
    files: list[str], tmp_path: Path, arguments: list[str], words: str, capsys: Said
) -> None:
    """Misspelled, shortened, missing or senseless arguments end with 2 and one message on stderr."""
    assert cli.main([word.format(tmp=tmp_path) for word in arguments]) == 2
    said = capsys.readouterr()
    assert words in said.err
    assert "Traceback" not in said.err
    assert said.out == ""


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"--machine": "rubin-m2"}, "not active"),
        ({"--machine": "{tmp}"}, "no machine file"),
        ({"--poses": "{tmp}/none.csv"}, "is not there"),
        ({"--temps": "{tmp}"}, "is a folder"),
        ({"--out": "{tmp}/none/o.csv"}, "there is no folder"),
        ({"--out": "{tmp}"}, "it is a folder"),
        ({"--out": "{tmp}/p.csv"}, "one of the files that are read"),
        ({"--out": "{tmp}/old.csv"}, "exists already"),
        ({"--out": "-"}, "ends in .csv or .parquet"),
        ({"--out": "{tmp}/o.txt"}, "ends in .csv or .parquet"),
        ({"--convention": "euler"}, "invalid choice"),
        ({"--user-frame": "nan"}, "takes 6 finite numbers"),
    ],
)
def test_wrong_arguments_of_correct_are_2(
    files: list[str], tmp_path: Path, change: dict[str, str], words: str, capsys: Said
) -> None:
    """Files that are not there or must not be written end with 2; nothing is written."""
    (tmp_path / "old.csv").write_text("kept")
    before = sorted(tmp_path.iterdir())
    for option, value in change.items():
        arguments = [value.format(tmp=tmp_path)] + (["0"] * 5 if option == "--user-frame" else [])
        if option in files:
            files[files.index(option) + 1] = arguments[0]
        else:
            files += [option, *arguments]
    assert cli.main(files) == 2
    assert words in capsys.readouterr().err
    assert sorted(tmp_path.iterdir()) == before
    assert (tmp_path / "old.csv").read_text() == "kept"


def test_version(capsys: Said) -> None:
    """``--version`` names the package's version."""
    assert cli.main(["--version"]) == 0
    assert capsys.readouterr().out == f"hexathermal {ht.__version__}\n"


def test_machines_lists_every_bundled_machine(capsys: Said) -> None:
    """Each machine stands on its own line, with grade and whether it can be corrected; plain text in a pipe."""
    assert cli.main(["machines"]) == 0
    lines = capsys.readouterr().out.splitlines()
    for name in ht.bundled_hexapods():
        hexapod = ht.load_hexapod(name)
        row = next(line for line in lines if line.startswith(name)).split()
        assert row[1] == hexapod.grade
        assert ("active," in row) == (hexapod.thermal is not None)
        assert any(hexapod.source in line for line in lines)
    assert all(line == line.rstrip() and line.isascii() for line in lines)


@pytest.mark.parametrize("name", ht.bundled_hexapods())
def test_show_machine_tells_all(name: str, capsys: Said) -> None:
    """The JSON gives geometry, limits and thermal law back; the tables show joints, sensors and the file."""
    hexapod = ht.load_hexapod(name)
    assert cli.main(["show-machine", name, "--json"]) == 0
    facts = json.loads(capsys.readouterr().out)
    assert np.abs(np.array(facts["base_joints_mm"]) / 1e3 - hexapod.base_joints).max() < 1e-12
    assert np.abs(np.array(facts["platform_joints_mm"]) / 1e3 - hexapod.platform_joints).max() < 1e-12
    assert (
        np.abs(np.array(facts["leg_lengths_at_home_mm"]) / 1e3 - hexapod.inverse_kinematics(hexapod.home)).max() < 1e-12
    )
    assert hexapod.stroke is not None
    assert np.abs(np.array(facts["stroke_mm"]) / 1e3 - hexapod.stroke).max() < 1e-12
    assert ht.load_hexapod(facts["file"]) == hexapod
    assert (facts["thermal"] is None) == (hexapod.thermal is None)
    if hexapod.thermal is not None:
        found = np.array([law["A_um_per_m_K"] for law in facts["thermal"]["legs"]])
        assert np.abs(found * 1e-6 - [law.A for law in hexapod.thermal.legs]).max() < 1e-14
        assert tuple(facts["thermal"]["sensors"]) == hexapod.sensor_names
    assert cli.main(["show-machine", name]) == 0
    said = capsys.readouterr().out
    assert facts["file"] in said
    assert all(f"{value:.3f}" in said for row in facts["base_joints_mm"] for value in row)
    assert all(f"{sensor}_degC" in said for sensor in hexapod.sensor_names)


def test_show_machine_reads_paths_and_names_bad_machine_files(tmp_path: Path, capsys: Said) -> None:
    """A machine of one's own is shown by the path of its file or folder; a bad file ends with 3 and its line."""
    file = ht.write_hexapod(ht.load_hexapod("reference"), tmp_path)
    for path in (file, tmp_path):
        assert cli.main(["show-machine", str(path), "--json"]) == 0
        assert json.loads(capsys.readouterr().out)["file"] == str(file.resolve())
    file.write_text(file.read_text().replace("q0_mm = 600", 'q0_mm = "long"'))
    assert cli.main(["show-machine", str(file)]) == 3
    assert f"{file}, line " in capsys.readouterr().err


def test_correct_writes_what_the_library_answers(files: list[str], tmp_path: Path, capsys: Said) -> None:
    """Lengths in the file are those of `corrected_leg_lengths` to 1e-9 mm, with options as given; a table tells how."""
    frames = ["--object-frame", "0", "-1e-3", "120", "0.5", "0", "0", "--convention", "pi"]
    assert cli.main([*files, *frames]) == 0
    hexapod = ht.load_hexapod("reference")
    tool = ht.Frames(object=(0, -1e-3, 120, 0.5, 0, 0), convention="fixed-zyx")
    user = ht.pose_from_coordinates([1, 2, 3, 0.1, 0.2, 0.3], "fixed-zyx")
    wanted = hexapod.corrected_leg_lengths(hexapod.home @ tool.machine_pose(user), np.arange(20.0, 26.0)) * 1e3
    with (tmp_path / "o.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 2
    for row in rows:
        assert np.abs([float(row[f"leg{i}_length_mm"]) for i in range(1, 7)] - wanted).max() < 1e-9
        assert "corrected_rz_deg" in row
    said = capsys.readouterr()
    assert "one row of temperatures for all poses" in said.out
    assert str(tmp_path / "o.csv") in said.out
    assert said.err == ""
    assert cli.main([*files, "--lengths-only", "--force"]) == 0
    assert "corrected_x_mm" not in (tmp_path / "o.csv").read_text()


@pytest.mark.parametrize(
    ("poses", "temps", "code", "words"),
    [
        (f"{POSE}\n1,2,x,0,0,0", HEAT, 3, "p.csv, line 3, column 3: z_mm is 'x', expected a number (mm)"),
        (f"{POSE}\n1,2,,0,0,0", HEAT, 3, "p.csv, line 3, column 3: z_mm is missing"),
        (f"{POSE}\n1,2,3", HEAT, 3, "p.csv, line 3, column 4: found 3 fields, expected 6"),
        (POSE, "20,21,nan,23,24,25", 3, "t.csv, line 2, column 3: leg3_T1_degC is 'nan'"),
        (POSE, "20,21,22,23,24,80", 3, "t.csv, line 2, column 6: temperature of sensor leg6_T1 is 80 degC"),
        (POSE, f"{HEAT}\n{HEAT}", 3, "p.csv, line 2, column 1: the file ends too early"),
        ("", HEAT, 3, "p.csv, line 1, column 1: the file has a header but no rows"),
        (f"{POSE}\n0,0,999,0,0,0", HEAT, 4, "p.csv, line 3: leg "),
        (f"{POSE}\n1e12,0,0,0,0,0", HEAT, 4, "p.csv, line 3: the pose is far outside the machine"),
    ],
)
def test_bad_rows_have_their_exit_codes(
    files: list[str], tmp_path: Path, poses: str, temps: str, code: int, words: str, capsys: Said
) -> None:
    """Bad data end with 3, poses out of reach with 4; file, line and column are told and nothing is written."""
    (tmp_path / "p.csv").write_text(f"{POSES}\n{poses}\n")
    (tmp_path / "t.csv").write_text(f"{SENSORS}\n{temps}\n")
    assert cli.main(files) == code
    said = capsys.readouterr()
    assert f"{tmp_path}/{words}" in said.err
    assert said.out == ""
    assert sorted(file.name for file in tmp_path.iterdir()) == ["p.csv", "t.csv"]


def test_travel_limits_stop_a_trajectory(files: list[str], tmp_path: Path, capsys: Said) -> None:
    """Rows outside the maker's travel end with 4 and name line, axis, value and limit; on the limit they pass."""
    hexapod = ht.load_hexapod("reference")
    ranges = [(-0.005, 0.005)] * 3 + [(-0.01, 0.01)] * 3
    ht.write_hexapod(dataclasses.replace(hexapod, limits=ht.PoseLimits(*ranges)), tmp_path / "own")
    files[files.index("--machine") + 1] = str(tmp_path / "own")
    (tmp_path / "p.csv").write_text(f"{POSES}\n5,-5,0,0,0,0\n0,5.001,0,0,0,0\n")
    assert cli.main(files) == 4
    said = capsys.readouterr().err
    for words in ("p.csv, line 3: outside the maker's travel", "y is 5.001 mm", "allowed [-5, 5] mm", "fixed-xyz"):
        assert words in said
    assert not (tmp_path / "o.csv").exists()
    (tmp_path / "p.csv").write_text(f"{POSES}\n0,0,0,0,0,-0.58\n")
    assert cli.main(files) == 4
    assert "rz is -0.58 deg" in capsys.readouterr().err
    (tmp_path / "p.csv").write_text(f"{POSES}\n5,-5,5,0,0,0\n")
    assert cli.main(files) == 0
    assert "travel" in usage_of("correct", capsys)


def usage_of(command: str, capsys: Said) -> str:
    capsys.readouterr()
    cli.main([command, "--help"])
    return capsys.readouterr().out


def test_help_is_honest(capsys: Said) -> None:
    """The demo's help states the deviation that is drawn; correct's says what a missing law and a kill end in."""
    assert f"{100.0 * WorkingDay().law_uncertainty:g} %" in usage_of("demo", capsys)
    said = usage_of("correct", capsys)
    assert all(words in said for words in ("exit code 2", "exit code 4", "NAME.part"))


def test_far_away_frames_are_named(files: list[str], capsys: Said) -> None:
    """A frame that puts every pose out of reach is blamed beside the pose; without frames none are spoken of."""
    assert cli.main([*files, "--object-frame", "1e12", "0", "0", "0", "0", "0"]) == 4
    assert "user and object frames" in capsys.readouterr().err


def test_numbers_stay_whole_in_narrow_terminals() -> None:
    """Columns of numbers are never narrower than their numbers; texts may fold."""
    table = framed(True, "state", *(f"column {k}>" for k in range(12)))
    table.add_row("a long text " * 9, *["1234567.123 % more"] * 12)
    console = Console(width=60, file=io.StringIO())
    console.width = width_of(table, console.width)
    console.print(table)
    assert console.file.getvalue().count("1234567.123 % more") == 12
    assert width_of(framed(True, "a>"), 60) == 60


@pytest.mark.parametrize("width", [30, 45, 60, 80, 100])
def test_the_day_fits_its_terminal(width: int) -> None:
    """Columns are dropped, the turn last, until the day fits: no line is longer than the terminal, none is broken."""
    result = demonstrate(ht.load_hexapod("reference"))
    table = day_table(result, True, width)
    console = Console(width=max(width, width_of(table, 0)), file=io.StringIO())
    console.print(table)
    lines = [line.rstrip() for line in console.file.getvalue().splitlines()]
    if width >= 45:
        assert max(map(len, lines)) <= width
    assert sum(line.split()[:1] == [str(hour)] for hour in range(13) for line in lines) == 13
    assert any("shift" in line for line in lines)
    assert any("correct" in line for line in lines) == (width >= 80)


@pytest.mark.parametrize(
    ("before", "after", "words"),
    [(2.0, 0.9, "55 %"), (1.0, 1.8, "80 % more"), (1.0, 1.0, "none"), (0.0, 0.0, "none"), (0.0, 1.0, "more"),
     (1.0, 0.004, "99.6 %"), (1.0, 0.0001, "99.9 %"), (1.0, 0.0, "100 %"), (1.0, 1.004, "0.4 % more")],
)  # fmt: skip
def test_reductions_hide_nothing(before: float, after: float, words: str) -> None:
    """What grew is said to have grown; 100 % is only said where nothing is left."""
    assert reduction(before, after) == words


def test_a_machine_singular_at_home_is_warned_of(tmp_path: Path, capsys: Said) -> None:
    """Joints on two regular hexagons one above the other hold nothing: a warning, and a short condition number."""
    angle = np.radians(np.arange(0.0, 360.0, 60.0))
    ring = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(6)])
    home = np.eye(4)
    home[2, 3] = 0.5
    ht.write_hexapod(ht.Hexapod(ring, 0.5 * ring, home=home, name="ring"), tmp_path)
    assert cli.main(["show-machine", str(tmp_path)]) == 0
    said = capsys.readouterr()
    assert "singular at home" in said.err
    line = next(line for line in said.out.splitlines() if "condition number" in line)
    assert "singular" in line
    assert len(line) < 60
    cli.main(["show-machine", "reference"])
    assert capsys.readouterr().err == ""


def test_an_error_inside_is_1_and_shows_its_origin_on_request(capsys: Said, monkeypatch: pytest.MonkeyPatch) -> None:
    """A bug is one line that says how to see more; with HEXATHERMAL_TRACEBACK=1 the traceback comes."""

    def broken(*_given: object) -> None:
        raise ZeroDivisionError("oh")

    monkeypatch.setattr(machines, "run", broken)
    monkeypatch.delenv("HEXATHERMAL_TRACEBACK", raising=False)
    assert cli.main(["machines"]) == 1
    said = capsys.readouterr().err
    assert "ZeroDivisionError: oh" in said
    assert "HEXATHERMAL_TRACEBACK=1" in said
    assert "Traceback" not in said
    monkeypatch.setenv("HEXATHERMAL_TRACEBACK", "1")
    assert cli.main(["machines"]) == 1
    assert "Traceback" in capsys.readouterr().err


@pytest.mark.skipif(sys.platform == "win32", reason="signals")
def test_an_interrupt_that_a_library_swallows_still_stops(capsys: Said, monkeypatch: pytest.MonkeyPatch) -> None:
    """Ctrl-C while a library loads that catches everything: the work stops at its next step, and nothing is said."""
    if signal.getsignal(signal.SIGINT) is not signal.default_int_handler:
        pytest.skip("the tests run where this signal is not Python's own")

    def swallowing(_arguments: object, progress: Callable[[int, int, str], None]) -> None:
        with suppress(KeyboardInterrupt):
            signal.raise_signal(signal.SIGINT)
        progress(0, 1, "next step")
        pytest.fail("the work went on")

    monkeypatch.setattr(machines, "run", swallowing)
    assert cli.main(["machines"]) == 130
    said = capsys.readouterr()
    assert "interrupted" in said.err
    assert not said.out
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


@pytest.mark.parametrize(
    ("error", "code", "words"),
    [
        (OSError(28, "No space left on device", "o.csv"), 1, "No space left on device: o.csv"),
        (MemoryError(), 1, "out of memory"),
        (KeyboardInterrupt(), 130, "interrupted"),
        (BrokenPipeError(), 0, ""),
    ],
)
def test_the_worlds_troubles_have_their_codes(
    error: BaseException, code: int, words: str, capsys: Said, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Full disks and memory, Ctrl-C and readers that leave end without a traceback."""

    def troubled(*_given: object) -> None:
        raise error

    monkeypatch.setattr(machines, "run", troubled)
    monkeypatch.setattr(cli, "_drop", lambda _stream: None)
    assert cli.main(["machines"]) == code
    said = capsys.readouterr().err
    assert words in said
    assert "Traceback" not in said
