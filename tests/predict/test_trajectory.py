"""Trajectories corrected from file to file: the right numbers, in constant memory."""

from __future__ import annotations

import csv
import io
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.csv as pa_csv
import pyarrow.parquet as pa_parquet
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import hexathermal as ht
from hexathermal.predict import table_streams
from hexathermal.predict.pairing import interpolated
from hexathermal.predict.trajectory import POSE_COLUMNS, TrajectorySummary, correct_trajectory
from tests.trajectory_files import (
    EXACT_MM,
    HEAT,
    POSE,
    POSES,
    SENSORS,
    columns,
    draw,
    fresh_folder,
    left,
    lengths,
    text_of,
)

Run = Callable[..., TrajectorySummary]


@pytest.mark.parametrize("convention", ["fixed-xyz", "fixed-zyx"])
@pytest.mark.parametrize("block", [300, 1 << 21])
def test_every_row_is_what_the_library_answers(
    run: Run, tmp_path: Path, moved: ht.Hexapod, rng: np.random.Generator, convention: str, block: int,
    monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    """Lengths, strokes and corrected poses of each row are the library's own to 1e-9 mm, however the file is cut."""
    monkeypatch.setattr(table_streams, "BLOCK_BYTES", block)
    six, heat = draw(rng, 200)
    made = run(text_of(POSES, six), text_of(SENSORS, heat), convention=convention)
    pose = ht.pose_from_coordinates(six, convention, moved)
    wanted = np.array([moved.corrected_leg_lengths(T, t) for T, t in zip(pose, heat, strict=True)])
    sent = np.array([moved.corrected_pose(T, t) for T, t in zip(pose, heat, strict=True)])
    out = tmp_path / "o.csv"
    assert np.abs(lengths(out) - wanted * 1e3).max() < EXACT_MM
    assert np.abs(columns(out, *(f"leg{i}_q_mm" for i in range(1, 7))) - (wanted * 1e3 - 600.0)).max() < EXACT_MM
    assert np.array_equal(columns(out, *POSE_COLUMNS), six)
    told = columns(out, *(f"corrected_{name}" for name in POSE_COLUMNS))
    assert np.abs(told - ht.coordinates_from_pose(sent, convention, moved)).max() < EXACT_MM
    drift = np.abs(wanted - moved.inverse_kinematics(pose)) * 1e6
    row, leg = np.unravel_index(drift.argmax(), drift.shape)
    assert made.rows == 200
    assert made.largest_correction_um == pytest.approx(drift.max(), abs=1e-6)
    assert (made.largest_line, made.largest_leg) == (row + 2, leg + 1)
    assert (made.lowest_degC, made.highest_degC) == (heat.min(), heat.max())


def test_frames_are_those_of_the_library(run: Run, tmp_path: Path, moved: ht.Hexapod, rng: np.random.Generator) -> None:
    """With frames, ``T = home U X inv(O)`` reaches the machine, and the corrected pose comes back as an ``X``."""
    frames = ht.Frames((3.0, -4.0, 5.0, 1.0, -2.0, 0.5), (0.0, 10.0, 120.0, 0.5, 0.0, 30.0))
    machine = ht.pose_from_coordinates(rng.uniform(-1, 1, (30, 6)) * [20, 20, 20, 2, 2, 2])
    run(text_of(POSES, ht.coordinates_from_pose(frames.user_pose(machine))), frames=frames)
    heat = np.arange(20.0, 26.0)
    wanted = moved.corrected_leg_lengths(moved.home @ machine, heat)
    assert np.abs(lengths(tmp_path / "o.csv") - wanted * 1e3).max() < EXACT_MM
    told = ht.pose_from_coordinates(columns(tmp_path / "o.csv", *(f"corrected_{name}" for name in POSE_COLUMNS)))
    sent = moved.inverse_kinematics(moved.home @ frames.machine_pose(told))
    assert np.abs(sent - wanted).max() < 1e-12


def test_a_controller_fed_with_corrected_poses_commands_the_corrected_lengths(
    run: Run, tmp_path: Path, moved: ht.Hexapod, rng: np.random.Generator
) -> None:
    """The nominal lengths of corrected_x_mm .. corrected_rz_deg are leg1_length_mm .. leg6_length_mm."""
    six, heat = draw(rng, 50)
    run(text_of(POSES, six), text_of(SENSORS, heat))
    told = columns(tmp_path / "o.csv", *(f"corrected_{name}" for name in POSE_COLUMNS))
    nominal = moved.inverse_kinematics(ht.pose_from_coordinates(told, hexapod=moved)) * 1e3
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


@pytest.mark.long
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
    with pytest.MonkeyPatch.context() as patch, fresh_folder() as folder:
        patch.setattr(table_streams, "BLOCK_BYTES", blocks)
        (folder / "p.csv").write_text(text_of(f"time_s,{POSES}", np.column_stack([times, six])))
        (folder / "t.csv").write_text(text_of(f"time_s,{SENSORS}", np.column_stack([hot_times, heat])))
        correct_trajectory(machine, folder / "p.csv", folder / "t.csv", folder / "o.csv")
        found, stamps = lengths(folder / "o.csv"), columns(folder / "o.csv", "time_s")
    at = np.column_stack([np.interp(times, hot_times, column) for column in heat.T])
    wanted = machine.corrected_leg_lengths(ht.pose_from_coordinates(six, hexapod=machine), at)
    assert np.array_equal(stamps[:, 0], times)
    assert np.abs(found - wanted * 1e3).max() < EXACT_MM


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
    assert made.pairing == "row by row (time_s only in t.csv: not used for pairing)"


def test_a_single_row_of_temperatures_serves_all_poses(
    run: Run, tmp_path: Path, moved: ht.Hexapod, rng: np.random.Generator
) -> None:
    """One row is enough for any number of poses, also where both files have times."""
    six = draw(rng, 40)[0]
    pose = ht.pose_from_coordinates(six, hexapod=moved)
    run(text_of(f"time_s,{POSES}", np.column_stack([np.arange(40.0), six])), f"time_s,{SENSORS}\n99,{HEAT}\n")
    wanted = moved.corrected_leg_lengths(pose, np.arange(20.0, 26.0)) * 1e3
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
def test_what_csv_files_look_like_in_the_wild(run: Run, tmp_path: Path, moved: ht.Hexapod, poses: str) -> None:
    """Byte order marks, other line ends, empty lines, quotes and spaces change nothing."""
    assert run(poses).rows == 2
    pose = ht.pose_from_coordinates([1, 2, 3, 0.1, 0.2, 0.3], hexapod=moved)
    wanted = moved.corrected_leg_lengths(pose, np.arange(20.0, 26.0)) * 1e3
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


def test_parquet_and_csv_give_the_same(run: Run, tmp_path: Path, moved: ht.Hexapod, rng: np.random.Generator) -> None:
    """The same rows as CSV and Parquet give the same numbers; copied columns keep their type in Parquet."""
    six, heat = draw(rng, 70)
    run(text_of(POSES, six), text_of(SENSORS, heat))
    poses = pa.table({name: six[:, k] for k, name in enumerate(POSE_COLUMNS)} | {"step": np.arange(70)})
    pa_parquet.write_table(poses, tmp_path / "p.parquet", row_group_size=11)
    temps = pa.table({name: heat[:, k] for k, name in enumerate(SENSORS.split(","))})
    pa_parquet.write_table(temps, tmp_path / "t.parquet", row_group_size=7)
    for out in ("o.parquet", "again.csv"):
        made = correct_trajectory(moved, tmp_path / "p.parquet", tmp_path / "t.parquet", tmp_path / out)
        assert made.copied == ("step",)
    table = pa_parquet.read_table(tmp_path / "o.parquet")
    assert table.schema.field("step").type == pa.int64()
    again = pa_csv.read_csv(tmp_path / "again.csv")
    found = pa_csv.read_csv(tmp_path / "o.csv")
    for name in found.schema.names:
        assert np.array_equal(table[name].to_numpy(), found[name].to_numpy())
        assert np.array_equal(again[name].to_numpy(), found[name].to_numpy())
    assert left(tmp_path) == ["again.csv", "o.csv", "o.parquet", "p.parquet", "t.parquet"]


MEMORY = """
import resource, sys
import hexathermal as ht
from hexathermal.predict.trajectory import correct_trajectory
correct_trajectory(ht.load_hexapod("reference"), *sys.argv[1:4], overwrite=True)
print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)
"""

LARGEST_GROWTH_KB = 60_000
"""Ten times the rows may take this much more memory at its peak; held whole, they would take 300 MB more."""


@pytest.mark.long
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
