"""Trajectories that are refused: every bad row, header and file is named, and nothing half-written is left."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pa_parquet
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import hexathermal as ht
from hexathermal.errors import (
    ArgumentError,
    FileFormatError,
    KinematicsError,
    OutOfStrokeError,
    TemperatureError,
    ThermalModelError,
)
from hexathermal.predict import table_streams
from hexathermal.predict.trajectory import POSE_COLUMNS, TrajectorySummary, correct_trajectory
from tests.trajectory_files import (
    HEAT,
    ONE_TEMPS,
    POSE,
    POSES,
    SENSORS,
    fresh_folder,
    left,
)

Run = Callable[..., TrajectorySummary]


BAD_FIELDS = ["abc", "", "nan", "-inf", "1e999", "0x10", "1_0", "--1", "1 2", "١", "NULL", "true"]


@given(
    row=st.integers(0, 30), column=st.integers(0, 6), bad=st.sampled_from(BAD_FIELDS), blocks=st.integers(80, 3000),
    gaps=st.lists(st.integers(0, 30), max_size=4),
)  # fmt: skip
@settings(max_examples=40)
def test_a_bad_field_is_named_wherever_it_stands(row: int, column: int, bad: str, blocks: int, gaps: list[int]) -> None:
    """File, physical line, column, name and value of a bad field are told; nothing is left behind."""
    fields = [[str(k), *POSE.split(",")] for k in range(31)]
    fields[row][column] = bad
    texts = ["time_s," + POSES]
    for k, line in enumerate(fields):
        texts += [""] * gaps.count(k) + [",".join(line)]
    name = ("time_s", *POSE_COLUMNS)[column]
    with pytest.MonkeyPatch.context() as patch, fresh_folder() as folder:
        patch.setattr(table_streams, "BLOCK_BYTES", blocks)
        (folder / "p.csv").write_text("\n".join(texts) + "\n", encoding="utf-8")
        (folder / "t.csv").write_text(ONE_TEMPS)
        with pytest.raises(FileFormatError) as caught:
            correct_trajectory(ht.load_hexapod("reference"), folder / "p.csv", folder / "t.csv", folder / "o.csv")
        assert left(folder) == []
    (problem,) = caught.value.problems
    assert caught.value.path == str(folder / "p.csv")
    assert (problem.line, problem.column) == (2 + row + sum(gap <= row for gap in gaps), column + 1)
    assert name in problem.message
    assert "expected" in problem.message or "too large" in problem.message
    assert not bad or repr(bad) in problem.message


@pytest.mark.parametrize(
    ("line", "column", "words"),
    [
        ("1,2,3,4,5", 6, "found 5 fields, expected 6"),
        ("1,2,3,4,5,6,7", 7, "found 7 fields, expected 6"),
        ("1,5,2,5,3,5,0,0,0,0,0,0", 7, "decimal commas"),
        ("1,2,3,4,5,6;", 6, "rz_deg is '6;'"),
        ('1,2,3,4,5,"6', 1, "quote"),
        ('1,2,"3\n",4,5,6', 1, "quote"),
        ("1,2,3\x00,4,5,6", 3, "z_mm is '3\\x00'"),
        (b"1,2,\xff,4,5,6", 1, "UTF-8"),
        ("1," * 600_000, 1, "longer than"),
    ],
    ids=["short", "long", "commas", "semicolon", "quote", "quoted line end", "zero byte", "latin-1", "huge"],
)
@pytest.mark.parametrize("block", [64, 1 << 21])
def test_a_broken_line_is_named(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, line: str | bytes, column: int, words: str, block: int
) -> None:
    """A line with the wrong number of fields, open quotes or bytes that are no text is told with its number."""
    monkeypatch.setattr(table_streams, "BLOCK_BYTES", block)
    bad = line if isinstance(line, bytes) else line.encode()
    with pytest.raises(FileFormatError) as caught:
        run(f"{POSES}\n{POSE}\n\n".encode() + bad + f"\n{POSE}\n".encode())
    assert (caught.value.problems[0].line, caught.value.problems[0].column) == (4, column)
    assert words in str(caught.value)
    assert left(tmp_path) == []


def test_an_open_quote_in_a_copied_column_is_named(run: Run, tmp_path: Path) -> None:
    """A quote that is not closed would swallow rows without a word: it is refused at its own line."""
    with pytest.raises(FileFormatError, match=r"p\.csv, line 3, column 1: a quote is not closed"):
        run(f'{POSES},note\n{POSE},a\n{POSE},"b\n{POSE},c\n')
    assert left(tmp_path) == []


def test_all_bad_fields_of_the_row_are_told(run: Run) -> None:
    """The first bad row is reported whole, later ones are not."""
    with pytest.raises(FileFormatError) as caught:
        run(f"{POSES}\n{POSE}\n1,,nan,0,zz,0\nx,x,x,x,x,x\n")
    assert [(problem.line, problem.column) for problem in caught.value.problems] == [(3, 2), (3, 3), (3, 5)]


@pytest.mark.parametrize("unit", ["K", "kelvin", "k"])
def test_temperatures_in_kelvin_are_known_by_their_columns(run: Run, tmp_path: Path, unit: str) -> None:
    """A column in kelvin is told as such, with what to give in its place; it is no hint at files that were swapped."""
    with pytest.raises(FileFormatError) as caught:
        run(f"{POSES}\n{POSE}\n", SENSORS.replace("degC", unit) + "\n293,293,293,293,293,293\n")
    said = str(caught.value)
    assert f"'leg1_T1_{unit}' seems to hold kelvin: give degrees Celsius (K - 273.15)" in said
    assert "name the column leg1_T1_degC" in said
    assert "swapped" not in said
    assert left(tmp_path) == []


@pytest.mark.parametrize(
    ("header", "words"),
    [
        ("", "the file is empty"),
        (POSES.replace(",", ";"), "semicolons"),
        (POSES.replace(",", "\t"), "tabs"),
        (POSES + ",x_mm", "line 1, column 7: column x_mm is there twice"),
        (POSES + ",", "line 1, column 7: the column has no name"),
        ("X_mm,y,z_mm,rx_deg,ry_deg,rz_deg", "columns x_mm, y_mm are missing; was 'X_mm' meant for x_mm?"),
        ("X_mm,y,z_mm,rx_deg,ry_deg,rz_deg", "; was 'y' meant for y_mm?"),
        (POSES + ",leg1_q_mm", "would clash"),
        (SENSORS, "were the two files swapped?"),
        ("# " + POSES, "no # before it"),
        ("1,2,3,4,5,6", "is the header line missing?"),
        ('"x_mm', "not a CSV header"),
        ("\x00\x01", "zero bytes"),
        ("a" * (1 << 20), "longer than"),
    ],
)  # fmt: skip
def test_a_bad_header_is_told(run: Run, tmp_path: Path, header: str, words: str) -> None:
    """What is wrong with a header is told, and nothing is written."""
    body = f"\n{POSE}\n" if 0 < len(header) < 1000 else ""
    with pytest.raises(FileFormatError) as caught:
        run(header + body)
    assert words in str(caught.value)
    assert left(tmp_path) == []


@pytest.mark.parametrize("content", [POSES, POSES + "\n", POSES + "\n\n\r\n"])
def test_a_file_without_rows_is_refused(run: Run, tmp_path: Path, content: str) -> None:
    """A header alone is an error, in both files."""
    with pytest.raises(FileFormatError, match=r"p\.csv, line 1, .*no rows"):
        run(content)
    with pytest.raises(FileFormatError, match=r"t\.csv, line 1, .*no rows"):
        run(f"{POSES}\n{POSE}\n", content.replace(POSES, SENSORS))
    assert left(tmp_path) == []


def test_packed_and_foreign_encodings_are_refused(run: Run, tmp_path: Path) -> None:
    """UTF-16 and binary files are named as such."""
    for content in (f"{POSES}\n{POSE}\n".encode("utf-16"), b"\x1f\x8b\x08\x00" + bytes(range(256))):
        with pytest.raises(FileFormatError, match="UTF-8"):
            run(content)
    assert left(tmp_path) == []


@pytest.mark.parametrize(
    ("pose", "kind", "words"),
    [
        ("1,2,500,0,0,0", OutOfStrokeError, "out of stroke"),
        ("0,0,0,0,0,89", KinematicsError, "leg"),
        ("1e9,2,3,0,0,0", KinematicsError, "far outside the machine"),
        ("1e308,0,1e308,0,0,0", KinematicsError, "far outside the machine"),
    ],
)
def test_a_pose_that_cannot_be_reached_is_told_with_its_line(
    run: Run, tmp_path: Path, pose: str, kind: type[KinematicsError], words: str
) -> None:
    """Kinematic refusals name file and line, say nothing of internal indices, and leave nothing."""
    with pytest.raises(kind) as caught:
        run(f"{POSES}\n{POSE}\n\n{POSE}\n{pose}\n{POSE}\n")
    assert f"{tmp_path / 'p.csv'}, line 5: " in str(caught.value)
    assert words in str(caught.value)
    assert "at index" not in str(caught.value)
    assert caught.value.index == (2,)
    assert left(tmp_path) == []


def test_a_temperature_out_of_range_is_told_with_its_line(run: Run, tmp_path: Path) -> None:
    """Temperatures outside the law's range name sensor, file, line and column, even where no pose uses them."""
    poses = f"time_s,{POSES}\n0,{POSE}\n1,{POSE}\n"
    with pytest.raises(TemperatureError) as caught:
        run(poses, f"time_s,{SENSORS}\n0,{HEAT}\n2,{HEAT}\n\n3,20,20,293,20,20,20\n")
    assert f"{tmp_path / 't.csv'}, line 5, column 4: temperature of sensor leg3_T1 is 293 degC" in str(caught.value)
    assert (caught.value.sensor, caught.value.value) == ("leg3_T1", 293.0)
    assert left(tmp_path) == []


@pytest.mark.parametrize(
    ("times", "heats", "file", "line", "words"),
    [
        ((0, 1, 1), (0, 2), "p.csv", 4, "time_s is 1.0, expected more than 1.0"),
        ((0, 1), (0, 2, 1), "t.csv", 4, "time_s is 1.0, expected more than 2.0"),
        ((-1, 1, 2), (0, 2), "p.csv", 2, "spans [0.0, 2.0] s, poses span [-1.0, 2.0] s"),
        ((1, 2, 2.5, 7), (0, 1, 2), "p.csv", 4, "spans [0.0, 2.0] s, poses span [1.0, 7.0] s"),
    ],
)
@pytest.mark.parametrize("block", [40, 1 << 21])
def test_times_that_go_back_or_reach_too_far_are_refused(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, times: tuple[float, ...], heats: tuple[float, ...],
    file: str, line: int, words: str, block: int,
) -> None:  # fmt: skip
    """Times must increase, also from block to block, and nothing is extrapolated: both time spans are told."""
    monkeypatch.setattr(table_streams, "BLOCK_BYTES", block)
    poses = f"time_s,{POSES}\n" + "".join(f"{t},{POSE}\n" for t in times)
    with pytest.raises(FileFormatError) as caught:
        run(poses, f"time_s,{SENSORS}\n" + "".join(f"{t},{HEAT}\n" for t in heats))
    assert f"{tmp_path / file}, line {line}, column 1: " in str(caught.value)
    assert words in str(caught.value)
    assert left(tmp_path) == []


@pytest.mark.parametrize(
    ("poses", "heats", "file"), [(3, 2, "t.csv"), (2, 3, "p.csv"), (1, 2, "p.csv"), (900, 2, "t.csv")]
)
def test_unequal_numbers_of_rows_are_refused(run: Run, tmp_path: Path, poses: int, heats: int, file: str) -> None:
    """Without times both files need as many rows; the shorter one is named, with both numbers."""
    with pytest.raises(FileFormatError) as caught:
        run(f"{POSES}\n" + f"{POSE}\n" * poses, f"{SENSORS}\n" + f"{HEAT}\n" * heats)
    assert caught.value.path == str(tmp_path / file)
    assert f"has {poses} row" in str(caught.value)
    assert f"has {heats} row" in str(caught.value)
    assert left(tmp_path) == []


@pytest.mark.parametrize(("bad", "words"), [(None, "is missing"), (np.nan, "is nan"), (np.inf, "is inf")])
def test_bad_rows_of_parquet_are_named(tmp_path: Path, moved: ht.Hexapod, bad: float | None, words: str) -> None:
    """A null, NaN or infinity is told with its row and column."""
    values: dict[str, list[float | None]] = {name: [0.0] * 40 for name in POSE_COLUMNS}
    values["ry_deg"][33] = bad
    pa_parquet.write_table(pa.table(values), tmp_path / "p.parquet", row_group_size=8)
    (tmp_path / "t.csv").write_text(ONE_TEMPS)
    with pytest.raises(FileFormatError) as caught:
        correct_trajectory(moved, tmp_path / "p.parquet", tmp_path / "t.csv", tmp_path / "o.csv")
    assert (caught.value.problems[0].line, caught.value.problems[0].column) == (34, 5)
    assert f"ry_deg {words}" in str(caught.value)
    assert left(tmp_path) == ["p.parquet"]


def test_parquet_of_other_types_is_refused(tmp_path: Path, moved: ht.Hexapod) -> None:
    """Texts where numbers belong, nested columns for a CSV, and files that are no Parquet are refused."""
    (tmp_path / "t.csv").write_text(ONE_TEMPS)
    numbers: dict[str, list[Any]] = {name: [0.0] for name in POSE_COLUMNS}
    for change, words in (({"x_mm": ["0"]}, "x_mm holds string"), ({"bag": [[1, 2]]}, "cannot be written as CSV")):
        pa_parquet.write_table(pa.table(numbers | change), tmp_path / "p.parquet")
        with pytest.raises(FileFormatError, match=words):
            correct_trajectory(moved, tmp_path / "p.parquet", tmp_path / "t.csv", tmp_path / "o.csv")
    (tmp_path / "p.parquet").write_text("x_mm\n1\n")
    with pytest.raises(FileFormatError, match="not a Parquet file"):
        correct_trajectory(moved, tmp_path / "p.parquet", tmp_path / "t.csv", tmp_path / "o.csv")
    assert left(tmp_path) == ["p.parquet"]


@pytest.mark.parametrize("error", [KeyboardInterrupt, OSError, RuntimeError])
def test_whatever_happens_nothing_half_written_is_left(run: Run, tmp_path: Path, error: type[BaseException]) -> None:
    """The result appears whole at the end; an interruption or error on the way removes what was written."""
    seen = []

    def stop(done: int, total: int) -> None:
        seen.append((left(tmp_path), done <= total))
        raise error

    with pytest.raises(error):
        run(f"{POSES}\n{POSE}\n", progress=stop)
    assert seen == [(["o.csv.part"], True)]
    assert left(tmp_path) == []


def test_results_are_not_overwritten_unasked(run: Run, tmp_path: Path, moved: ht.Hexapod) -> None:
    """An existing result stays unless asked for, and survives a failing run; a file that is read is never replaced."""
    good = f"{POSES}\n{POSE}\n"
    run(good)
    before = (tmp_path / "o.csv").read_bytes()
    with pytest.raises(ArgumentError, match="exists already"):
        run(good)
    with pytest.raises(FileFormatError):
        run(good + "bad\n", overwrite=True)
    assert (tmp_path / "o.csv").read_bytes() == before
    run(good * 1 + f"{POSE}\n", overwrite=True)
    assert (tmp_path / "o.csv").read_bytes() != before
    (tmp_path / "same.csv").hardlink_to(tmp_path / "p.csv")
    for own in ("p.csv", "t.csv", "same.csv"):
        with pytest.raises(ArgumentError, match="one of the files that are read"):
            correct_trajectory(moved, tmp_path / "p.csv", tmp_path / "t.csv", tmp_path / own, overwrite=True)


@pytest.mark.parametrize("mode", [0o600, 0o640, 0o666])
def test_links_are_followed_and_permissions_kept(run: Run, tmp_path: Path, mode: int) -> None:
    """A link stays a link, what it leads to is replaced, and a private file stays private; a circle is refused."""
    kept = tmp_path / "deep"
    kept.mkdir()
    (kept / "real.csv").write_text("old")
    (kept / "real.csv").chmod(mode)
    (tmp_path / "o.csv").symlink_to(kept / "real.csv")
    run(f"{POSES}\n{POSE}\n", overwrite=True)
    assert (tmp_path / "o.csv").is_symlink()
    assert (kept / "real.csv").read_text().startswith("x_mm,")
    assert (kept / "real.csv").stat().st_mode & 0o777 == mode
    assert [file.name for file in kept.iterdir()] == ["real.csv"]
    (tmp_path / "o.csv").unlink()
    (tmp_path / "o.csv").symlink_to(tmp_path / "o.csv")
    with pytest.raises(ArgumentError, match="leads in a circle"):
        run(f"{POSES}\n{POSE}\n", overwrite=True)


def test_a_leg_out_of_stroke_is_told_in_lengths_and_strokes(run: Run) -> None:
    """Length, stroke and allowed stroke belong together: length = q0 + q with q0 = 600 mm."""
    with pytest.raises(OutOfStrokeError) as caught:
        run(f"{POSES}\n0,0,500,0,0,0\n")
    found = re.search(r"length ([\d.]+) mm \(q ([\d.]+) mm\), allowed q \[0, 250\] mm: ([\d.]+) mm", str(caught.value))
    assert found is not None
    length, q, over = map(float, found.groups())
    assert length == pytest.approx(600.0 + q, abs=1e-5)
    assert over == pytest.approx(q - 250.0, abs=1e-3)
    assert caught.value.value == pytest.approx(length / 1e3, abs=1e-8)


def test_what_looks_like_a_mistake_is_noted(run: Run) -> None:
    """The span of the poses is told; metres, more than half a turn and unread times get a note, others none."""
    made = run(f"{POSES}\n1,-2,3,0.1,0.2,0.3\n4,2,0,0,0,-0.3\n")
    assert made.lowest_pose == (1.0, -2.0, 0.0, 0.0, 0.0, -0.3)
    assert made.highest_pose == (4.0, 2.0, 3.0, 0.1, 0.2, 0.3)
    assert made.notes == ()
    (note,) = run(f"{POSES}\n0.001,0,0,0,0,0\n", overwrite=True).notes
    assert "were metres given?" in note
    assert run(f"{POSES}\n0,0,0,0,0,1\n", overwrite=True).notes == ()
    (note,) = run(f"{POSES}\n1,0,0,0,0,361\n", overwrite=True).notes
    assert "361 deg" in note
    (note,) = run(f"time_ms,{POSES}\n0,{POSE}\n", overwrite=True).notes
    assert "p.csv: column time_ms is not read as time" in note


def test_files_that_cannot_be_used_are_told(run: Run, tmp_path: Path, moved: ht.Hexapod) -> None:
    """Missing files and folders, folders in place of files, and the rest of a killed run."""
    (tmp_path / "p.csv").write_text(f"{POSES}\n{POSE}\n")
    (tmp_path / "t.csv").write_text(ONE_TEMPS)
    paths = {"poses": tmp_path / "p.csv", "temps": tmp_path / "t.csv", "out": tmp_path / "o.csv"}
    for change, words in (
        ({"poses": tmp_path / "none.csv"}, "poses file .* is not there"),
        ({"temps": tmp_path}, "temperatures file .* is a folder"),
        ({"out": tmp_path / "none" / "o.csv"}, "there is no folder"),
        ({"out": tmp_path}, "it is a folder"),
    ):
        with pytest.raises(ArgumentError, match=words):
            correct_trajectory(moved, **(paths | change))
    (tmp_path / "o.csv.part").touch()
    with pytest.raises(ArgumentError, match="another run is writing it, or was killed"):
        correct_trajectory(moved, **paths)
    assert left(tmp_path) == ["o.csv.part"]
    with pytest.raises(ThermalModelError, match="not active"):
        correct_trajectory(ht.load_hexapod("rubin-m2"), **paths)
