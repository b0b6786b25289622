"""Trajectories corrected from file to file: the right numbers, in constant memory, and every bad row named."""

from __future__ import annotations

import csv
import dataclasses
import io
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.csv as pa_csv
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
from hexathermal.predict.pairing import interpolated
from hexathermal.predict.trajectory import POSE_COLUMNS, TrajectorySummary, correct_trajectory

EXACT_MM = 1e-9
POSES = ",".join(POSE_COLUMNS)
SENSORS = ",".join(f"leg{i}_T1_degC" for i in range(1, 7))
POSE, HEAT = "1,2,3,0.1,0.2,0.3", "20,21,22,23,24,25"
ONE_TEMPS = f"{SENSORS}\n{HEAT}\n"

Run = Callable[..., TrajectorySummary]


@pytest.fixture
def reference(reference: ht.Hexapod) -> ht.Hexapod:
    """The reference machine in a base frame that is turned and lies elsewhere: its home is not the identity."""
    G = ht.pose_from_coordinates([100, -200, 300, 10, 20, 30])
    return dataclasses.replace(reference, base_joints=reference.base_joints @ G[:3, :3].T + G[:3, 3], home=G)


@pytest.fixture
def run(tmp_path: Path, reference: ht.Hexapod) -> Run:
    """Correct texts (or bytes) as files p.csv and t.csv into o.csv."""

    def work(poses: str | bytes, temps: str | bytes = ONE_TEMPS, **options: Any) -> TrajectorySummary:
        for name, text in (("p.csv", poses), ("t.csv", temps)):
            (tmp_path / name).write_bytes(text if isinstance(text, bytes) else text.encode())
        machine = options.pop("machine", reference)
        return correct_trajectory(machine, tmp_path / "p.csv", tmp_path / "t.csv", tmp_path / "o.csv", **options)

    return work


def left(folder: Path) -> list[str]:
    """Return the files in a folder besides the two that were read."""
    return sorted(file.name for file in folder.iterdir() if file.name not in ("p.csv", "t.csv"))


def text_of(names: str, rows: np.ndarray) -> str:
    return names + "\n" + "".join(",".join(map(repr, row)) + "\n" for row in rows.tolist())


def columns(file: Path, *names: str) -> np.ndarray:
    with file.open(encoding="utf-8", newline="") as lines:
        rows = list(csv.DictReader(lines))
    return np.array([[float(row[name]) for name in names] for row in rows])


def lengths(file: Path) -> np.ndarray:
    return columns(file, *(f"leg{i}_length_mm" for i in range(1, 7)))


def draw(rng: np.random.Generator, count: int) -> tuple[np.ndarray, np.ndarray]:
    six = rng.uniform(-1, 1, (count, 6)) * [40, 40, 40, 4, 4, 4]
    return six, rng.uniform(15, 30, (count, 6))


@pytest.mark.parametrize("convention", ["fixed-xyz", "fixed-zyx"])
@pytest.mark.parametrize("block", [300, 1 << 21])
def test_every_row_is_what_the_library_answers(
    run: Run, tmp_path: Path, reference: ht.Hexapod, rng: np.random.Generator, convention: str, block: int,
    monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    """Lengths, strokes and corrected poses of each row are the library's own to 1e-9 mm, however the file is cut."""
    monkeypatch.setattr(table_streams, "BLOCK_BYTES", block)
    six, heat = draw(rng, 200)
    made = run(text_of(POSES, six), text_of(SENSORS, heat), convention=convention)
    pose = ht.pose_from_coordinates(six, convention, reference)
    wanted = np.array([reference.corrected_leg_lengths(T, t) for T, t in zip(pose, heat, strict=True)])
    sent = np.array([reference.corrected_pose(T, t) for T, t in zip(pose, heat, strict=True)])
    out = tmp_path / "o.csv"
    assert np.abs(lengths(out) - wanted * 1e3).max() < EXACT_MM
    assert np.abs(columns(out, *(f"leg{i}_q_mm" for i in range(1, 7))) - (wanted * 1e3 - 600.0)).max() < EXACT_MM
    assert np.array_equal(columns(out, *POSE_COLUMNS), six)
    told = columns(out, *(f"corrected_{name}" for name in POSE_COLUMNS))
    assert np.abs(told - ht.coordinates_from_pose(sent, convention, reference)).max() < EXACT_MM
    drift = np.abs(wanted - reference.inverse_kinematics(pose)) * 1e6
    row, leg = np.unravel_index(drift.argmax(), drift.shape)
    assert made.rows == 200
    assert made.largest_correction_um == pytest.approx(drift.max(), abs=1e-6)
    assert (made.largest_line, made.largest_leg) == (row + 2, leg + 1)
    assert (made.lowest_degC, made.highest_degC) == (heat.min(), heat.max())


def test_frames_are_those_of_the_library(
    run: Run, tmp_path: Path, reference: ht.Hexapod, rng: np.random.Generator
) -> None:
    """With frames, ``T = home U X inv(O)`` reaches the machine, and the corrected pose comes back as an ``X``."""
    frames = ht.Frames((3.0, -4.0, 5.0, 1.0, -2.0, 0.5), (0.0, 10.0, 120.0, 0.5, 0.0, 30.0))
    machine = ht.pose_from_coordinates(rng.uniform(-1, 1, (30, 6)) * [20, 20, 20, 2, 2, 2])
    run(text_of(POSES, ht.coordinates_from_pose(frames.user_pose(machine))), frames=frames)
    heat = np.arange(20.0, 26.0)
    wanted = reference.corrected_leg_lengths(reference.home @ machine, heat)
    assert np.abs(lengths(tmp_path / "o.csv") - wanted * 1e3).max() < EXACT_MM
    told = ht.pose_from_coordinates(columns(tmp_path / "o.csv", *(f"corrected_{name}" for name in POSE_COLUMNS)))
    sent = reference.inverse_kinematics(reference.home @ frames.machine_pose(told))
    assert np.abs(sent - wanted).max() < 1e-12


def test_a_controller_fed_with_corrected_poses_commands_the_corrected_lengths(
    run: Run, tmp_path: Path, reference: ht.Hexapod, rng: np.random.Generator
) -> None:
    """The nominal lengths of corrected_x_mm .. corrected_rz_deg are leg1_length_mm .. leg6_length_mm."""
    six, heat = draw(rng, 50)
    run(text_of(POSES, six), text_of(SENSORS, heat))
    told = columns(tmp_path / "o.csv", *(f"corrected_{name}" for name in POSE_COLUMNS))
    nominal = reference.inverse_kinematics(ht.pose_from_coordinates(told, hexapod=reference)) * 1e3
    assert np.abs(nominal - lengths(tmp_path / "o.csv")).max() < EXACT_MM


def test_a_machine_with_plates_and_two_sensors_a_leg(run: Run, tmp_path: Path, two_plates: ht.Hexapod) -> None:
    """Columns of temperatures go by name, in any order."""
    names = list(reversed(two_plates.sensor_names))
    heat = {name: 18.0 + 0.5 * k for k, name in enumerate(two_plates.sensor_names)}
    temps = ",".join(f"{name}_degC" for name in names) + "\n" + ",".join(str(heat[name]) for name in names) + "\n"
    made = run(f"{POSES}\n{POSE}\n", temps, machine=two_plates)
    pose = ht.pose_from_coordinates([1, 2, 3, 0.1, 0.2, 0.3], hexapod=two_plates)
    assert np.abs(lengths(tmp_path / "o.csv") - two_plates.corrected_leg_lengths(pose, heat) * 1e3).max() < EXACT_MM
    assert made.sensors == two_plates.sensor_names


@given(data=st.data())
@settings(max_examples=25)
def test_interpolation_in_blocks_is_interpolation_of_the_whole(data: st.DataObject) -> None:
    """Temperatures at the poses' times are linear between the rows around them, however both files are cut."""
    seed = data.draw(st.integers(0, 2**32 - 1))
    blocks = data.draw(st.integers(150, 4000))
    rng = np.random.default_rng(seed)
    hot_times = np.cumsum(rng.uniform(0.01, 10.0, data.draw(st.integers(2, 60)))) - 5.0
    count = data.draw(st.integers(1, 60))
    times = np.unique(np.concatenate([rng.uniform(hot_times[0], hot_times[-1], count), rng.choice(hot_times, 2)]))
    heat = rng.uniform(15, 30, (len(hot_times), 6))
    machine = ht.load_hexapod("reference")
    six = rng.uniform(-1, 1, (len(times), 6)) * [40, 40, 40, 4, 4, 4]
    with pytest.MonkeyPatch.context() as patch, _folder() as folder:
        patch.setattr(table_streams, "BLOCK_BYTES", blocks)
        (folder / "p.csv").write_text(text_of(f"time_s,{POSES}", np.column_stack([times, six])))
        (folder / "t.csv").write_text(text_of(f"time_s,{SENSORS}", np.column_stack([hot_times, heat])))
        correct_trajectory(machine, folder / "p.csv", folder / "t.csv", folder / "o.csv")
        found, stamps = lengths(folder / "o.csv"), columns(folder / "o.csv", "time_s")
    at = np.column_stack([np.interp(times, hot_times, column) for column in heat.T])
    wanted = machine.corrected_leg_lengths(ht.pose_from_coordinates(six, hexapod=machine), at)
    assert np.array_equal(stamps[:, 0], times)
    assert np.abs(found - wanted * 1e3).max() < EXACT_MM


def _folder() -> Any:
    """Return a context that gives a fresh folder."""
    import contextlib
    import tempfile

    @contextlib.contextmanager
    def fresh() -> Any:
        with tempfile.TemporaryDirectory() as name:
            yield Path(name)

    return fresh()


def test_interpolation_is_exact_at_the_rows() -> None:
    """At the time of a row its own temperatures come back, to the last bit."""
    time, values = np.array([0.0, 0.1, 0.7]), np.array([[20.1], [23.7], [19.3]])
    assert np.array_equal(interpolated(time, values, time), values)


def test_rows_go_together_where_times_are_missing(run: Run, tmp_path: Path, rng: np.random.Generator) -> None:
    """With ``time_s`` in one file only, row k goes with row k, and the result has that time."""
    six, heat = draw(rng, 9)
    stamps = np.arange(9.0)[:, None]
    made = run(text_of(POSES, six), text_of(f"time_s,{SENSORS}", np.hstack([stamps, heat])))
    assert np.array_equal(columns(tmp_path / "o.csv", "time_s"), stamps)
    again = lengths(tmp_path / "o.csv")
    run(text_of(f"time_s,{POSES}", np.hstack([stamps, six])), text_of(SENSORS, heat), overwrite=True)
    assert np.array_equal(lengths(tmp_path / "o.csv"), again)
    assert made.pairing == "row by row"


def test_a_single_row_of_temperatures_serves_all_poses(
    run: Run, tmp_path: Path, reference: ht.Hexapod, rng: np.random.Generator
) -> None:
    """One row is enough for any number of poses, also where both files have times."""
    six = draw(rng, 40)[0]
    pose = ht.pose_from_coordinates(six, hexapod=reference)
    run(text_of(f"time_s,{POSES}", np.column_stack([np.arange(40.0), six])), f"time_s,{SENSORS}\n99,{HEAT}\n")
    wanted = reference.corrected_leg_lengths(pose, np.arange(20.0, 26.0)) * 1e3
    assert np.abs(lengths(tmp_path / "o.csv") - wanted).max() < EXACT_MM


@pytest.mark.parametrize(
    "poses",
    [
        f"\ufeff{POSES}\n{POSE}\n{POSE}\n",
        f"{POSES}\r\n{POSE}\r\n{POSE}\r\n",
        f"{POSES}\r{POSE}\r{POSE}\r",
        f"\n\n{POSES}\n\n{POSE}\n\n\n{POSE}\n\n",
        f"{POSES}\n{POSE}\n{POSE}",
        f'x_mm , "y_mm",  z_mm,"rx_deg",ry_deg,rz_deg\n"1", 2 ,+3.0,1e-1,.2,3E-1\n{POSE}\n',
    ],
    ids=["bom", "crlf", "cr", "empty lines", "no last line end", "quotes and spaces"],
)
def test_what_csv_files_look_like_in_the_wild(run: Run, tmp_path: Path, reference: ht.Hexapod, poses: str) -> None:
    """Byte order marks, other line ends, empty lines, quotes and spaces change nothing."""
    assert run(poses).rows == 2
    pose = ht.pose_from_coordinates([1, 2, 3, 0.1, 0.2, 0.3], hexapod=reference)
    wanted = reference.corrected_leg_lengths(pose, np.arange(20.0, 26.0)) * 1e3
    assert np.abs(lengths(tmp_path / "o.csv") - wanted).max() < EXACT_MM


def test_unknown_columns_are_kept_and_listed(run: Run, tmp_path: Path) -> None:
    """Other columns of the poses are copied word for word, those of the temperatures listed as not used."""
    notes = ['say "hi", you', "", " 007 ", "µ"]
    rows = io.StringIO()
    csv.writer(rows).writerows([["note", *POSE_COLUMNS], *([note, *POSE.split(",")] for note in notes)])
    made = run(rows.getvalue(), f"{SENSORS},air_degC\n{HEAT},warm\n")
    with (tmp_path / "o.csv").open(encoding="utf-8", newline="") as file:
        assert [row["note"] for row in csv.DictReader(file)] == notes
    assert (made.copied, made.unused) == (("note",), ("air_degC",))


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
    with pytest.MonkeyPatch.context() as patch, _folder() as folder:
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


@pytest.mark.parametrize(
    ("header", "words"),
    [
        ("", "the file is empty"),
        (POSES.replace(",", ";"), "semicolons"),
        (POSES.replace(",", "\t"), "tabs"),
        (POSES + ",x_mm", "line 1, column 7: column x_mm is there twice"),
        (POSES + ",", "line 1, column 7: the column has no name"),
        ("X_mm,y,z_mm,rx_deg,ry_deg,rz_deg", "column x_mm is missing; was 'X_mm' meant?"),
        ("X_mm,y,z_mm,rx_deg,ry_deg,rz_deg", "column y_mm is missing; was 'y' meant?"),
        (POSES + ",leg1_q_mm", "would clash"),
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


def test_parquet_and_csv_give_the_same(
    run: Run, tmp_path: Path, reference: ht.Hexapod, rng: np.random.Generator
) -> None:
    """The same rows as CSV and Parquet give the same numbers; copied columns keep their type in Parquet."""
    six, heat = draw(rng, 70)
    run(text_of(POSES, six), text_of(SENSORS, heat))
    poses = pa.table({name: six[:, k] for k, name in enumerate(POSE_COLUMNS)} | {"step": np.arange(70)})
    pa_parquet.write_table(poses, tmp_path / "p.parquet", row_group_size=11)
    temps = pa.table({name: heat[:, k] for k, name in enumerate(SENSORS.split(","))})
    pa_parquet.write_table(temps, tmp_path / "t.parquet", row_group_size=7)
    for out in ("o.parquet", "again.csv"):
        made = correct_trajectory(reference, tmp_path / "p.parquet", tmp_path / "t.parquet", tmp_path / out)
        assert made.copied == ("step",)
    table = pa_parquet.read_table(tmp_path / "o.parquet")
    assert table.schema.field("step").type == pa.int64()
    again = pa_csv.read_csv(tmp_path / "again.csv")
    found = pa_csv.read_csv(tmp_path / "o.csv")
    for name in found.schema.names:
        assert np.array_equal(table[name].to_numpy(), found[name].to_numpy())
        assert np.array_equal(again[name].to_numpy(), found[name].to_numpy())
    assert left(tmp_path) == ["again.csv", "o.csv", "o.parquet", "p.parquet", "t.parquet"]


@pytest.mark.parametrize(("bad", "words"), [(None, "is missing"), (np.nan, "is nan"), (np.inf, "is inf")])
def test_bad_rows_of_parquet_are_named(tmp_path: Path, reference: ht.Hexapod, bad: float | None, words: str) -> None:
    """A null, NaN or infinity is told with its row and column."""
    values: dict[str, list[float | None]] = {name: [0.0] * 40 for name in POSE_COLUMNS}
    values["ry_deg"][33] = bad
    pa_parquet.write_table(pa.table(values), tmp_path / "p.parquet", row_group_size=8)
    (tmp_path / "t.csv").write_text(ONE_TEMPS)
    with pytest.raises(FileFormatError) as caught:
        correct_trajectory(reference, tmp_path / "p.parquet", tmp_path / "t.csv", tmp_path / "o.csv")
    assert (caught.value.problems[0].line, caught.value.problems[0].column) == (34, 5)
    assert f"ry_deg {words}" in str(caught.value)
    assert left(tmp_path) == ["p.parquet"]


def test_parquet_of_other_types_is_refused(tmp_path: Path, reference: ht.Hexapod) -> None:
    """Texts where numbers belong, nested columns for a CSV, and files that are no Parquet are refused."""
    (tmp_path / "t.csv").write_text(ONE_TEMPS)
    numbers: dict[str, list[Any]] = {name: [0.0] for name in POSE_COLUMNS}
    for change, words in (({"x_mm": ["0"]}, "x_mm holds string"), ({"bag": [[1, 2]]}, "cannot be written as CSV")):
        pa_parquet.write_table(pa.table(numbers | change), tmp_path / "p.parquet")
        with pytest.raises(FileFormatError, match=words):
            correct_trajectory(reference, tmp_path / "p.parquet", tmp_path / "t.csv", tmp_path / "o.csv")
    (tmp_path / "p.parquet").write_text("x_mm\n1\n")
    with pytest.raises(FileFormatError, match="not a Parquet file"):
        correct_trajectory(reference, tmp_path / "p.parquet", tmp_path / "t.csv", tmp_path / "o.csv")
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


def test_results_are_not_overwritten_unasked(run: Run, tmp_path: Path, reference: ht.Hexapod) -> None:
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
            correct_trajectory(reference, tmp_path / "p.csv", tmp_path / "t.csv", tmp_path / own, overwrite=True)


def test_files_that_cannot_be_used_are_told(run: Run, tmp_path: Path, reference: ht.Hexapod) -> None:
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
            correct_trajectory(reference, **(paths | change))
    (tmp_path / "o.csv.part").touch()
    with pytest.raises(ArgumentError, match="another run is writing it, or was killed"):
        correct_trajectory(reference, **paths)
    assert left(tmp_path) == ["o.csv.part"]
    with pytest.raises(ThermalModelError, match="not active"):
        correct_trajectory(ht.load_hexapod("rubin-m2"), **paths)


MEMORY = """
import resource, sys
import hexathermal as ht
from hexathermal.predict.trajectory import correct_trajectory
correct_trajectory(ht.load_hexapod("reference"), *sys.argv[1:4], overwrite=True)
print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)
"""

LARGEST_GROWTH_KB = 60_000
"""Ten times the rows may take this much more memory at its peak; held whole, they would take 300 MB more."""


@pytest.mark.skipif(sys.platform == "win32", reason="peak memory is read with getrusage")
def test_memory_does_not_grow_with_the_file(tmp_path: Path) -> None:
    """Ten times as many rows take no more memory."""
    peaks = []
    for count in (40_000, 400_000):
        k = np.arange(count)
        poses = {name: np.round(20.0 * np.sin(k * 1e-3 * (j + 1)), 6) for j, name in enumerate(POSE_COLUMNS[:3])}
        poses |= {name: np.round(2.0 * np.cos(k * 1e-3 * (j + 1)), 6) for j, name in enumerate(POSE_COLUMNS[3:])}
        heat = {name: np.round(22.0 + 2.0 * np.sin(k * 1e-5 * (j + 1)), 3) for j, name in enumerate(SENSORS.split(","))}
        for name, table in (("p.csv", {"time_s": k * 0.01} | poses), ("t.csv", {"time_s": k * 0.01} | heat)):
            pa_csv.write_csv(pa.table(table), tmp_path / name)
        files = [str(tmp_path / name) for name in ("p.csv", "t.csv", "o.csv")]
        done = subprocess.run([sys.executable, "-c", MEMORY, *files], capture_output=True, text=True, check=True)
        peaks.append(int(done.stdout) // (1024 if sys.platform == "darwin" else 1))
    assert peaks[1] - peaks[0] < LARGEST_GROWTH_KB, peaks
