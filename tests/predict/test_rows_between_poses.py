"""Trajectories in files of legs that remember: every row of temperatures counts, those that no pose meets too."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest

import hexathermal as ht
from hexathermal.errors import ArgumentError, TemperatureError, ThermalModelError
from hexathermal.machine.leg_terms import LegTerm
from hexathermal.predict.trajectory import POSE_COLUMNS, correct_trajectory
from tests.predict.remembering import MACHINE, SCREW, STATES, motion, seven, with_terms
from tests.trajectory_files import EXACT_MM, POSES, columns, lengths, text_of


@pytest.mark.long
@pytest.mark.parametrize("block", [300, 1 << 21])
def test_a_trajectory_with_times_remembers(tmp_path: Path, block: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Each row of the file is what the controllers answer, however the file is cut; without times it is refused."""
    from hexathermal.predict import table_streams

    monkeypatch.setattr(table_streams, "BLOCK_BYTES", block)
    machine = with_terms(*STATES, SCREW)
    poses, temps, time = motion(60)
    six = ht.coordinates_from_pose(poses, hexapod=machine)
    timed, plain = tmp_path / "timed.csv", tmp_path / "p.csv"
    timed.write_text(text_of(f"time_s,{POSES}", np.column_stack([time, six])), encoding="utf-8")
    plain.write_text(text_of(POSES, six), encoding="utf-8")
    (tmp_path / "t.csv").write_text(text_of(*seven(temps)), encoding="utf-8")
    correct_trajectory(machine, timed, tmp_path / "t.csv", tmp_path / "o.csv")
    wanted = machine.leg_controllers().corrected_leg_lengths(poses, temps, time)
    assert np.abs(lengths(tmp_path / "o.csv") - wanted * 1e3).max() < EXACT_MM
    assert np.array_equal(columns(tmp_path / "o.csv", "time_s")[:, 0], time)
    with pytest.raises(ThermalModelError, match=r"thermal-lag, backlash, hidden-heat, creep.*add time_s"):
        correct_trajectory(machine, plain, tmp_path / "t.csv", tmp_path / "o2.csv")
    assert not (tmp_path / "o2.csv").exists()
    heat = LegTerm("hidden-heat", "stored-heat", {"source": "pump_W", "time_constant_s": 60.0}, [1e-9])
    with pytest.raises(ThermalModelError, match="recorded input 'pump_W'"):
        correct_trajectory(with_terms(heat), timed, tmp_path / "t.csv", tmp_path / "o2.csv")
    assert POSE_COLUMNS == tuple(POSES.split(","))


def test_times_that_are_not_the_poses_own_are_told(tmp_path: Path) -> None:
    """Where only the temperatures have times, these are taken and that is said; one row of them is no motion. One row
    for poses with times leaves a lag at 0, which is said too.
    """
    machine = with_terms(*STATES)
    poses, temps, time = motion(5)
    six = ht.coordinates_from_pose(poses, hexapod=machine)
    head, heat = seven(temps)
    plain, timed, hot, one = (tmp_path / f"{name}.csv" for name in ("plain", "timed", "hot", "one"))
    plain.write_text(text_of(POSES, six), encoding="utf-8")
    timed.write_text(text_of(f"time_s,{POSES}", np.column_stack([time, six])), encoding="utf-8")
    hot.write_text(text_of(f"time_s,{head}", np.column_stack([time, heat])), encoding="utf-8")
    one.write_text(text_of(f"time_s,{head}", np.column_stack([time, heat])[:1]), encoding="utf-8")
    found = correct_trajectory(machine, plain, hot, tmp_path / "o.csv")
    assert "plain.csv has no time_s" in found.warnings[0]
    wanted = machine.leg_controllers().corrected_leg_lengths(poses, temps, time)
    assert np.abs(lengths(tmp_path / "o.csv") - wanted * 1e3).max() < EXACT_MM
    with pytest.raises(ThermalModelError, match=r"add time_s \[s\] to .*plain.csv"):
        correct_trajectory(machine, plain, one, tmp_path / "o2.csv")
    assert not (tmp_path / "o2.csv").exists()
    assert "leave thermal-lag at 0" in correct_trajectory(machine, timed, one, tmp_path / "o3.csv").warnings[0]
    assert not correct_trajectory(machine, timed, hot, tmp_path / "o4.csv").warnings
    assert not correct_trajectory(MACHINE, plain, hot, tmp_path / "o5.csv").warnings


@pytest.mark.parametrize("block", [300, 1 << 21])
def test_temperatures_between_poses_are_remembered(tmp_path: Path, block: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Few poses among many rows of temperatures: the lengths are those of a controller that is given every row, told to
    stay between the poses; without the rows between, a lag is micrometres off. However the files are cut.
    """
    from hexathermal.predict import table_streams

    monkeypatch.setattr(table_streams, "BLOCK_BYTES", block)
    machine = with_terms(*STATES, SCREW)
    poses, temps, time = motion(80)
    head, heat = seven(temps)
    chosen = [7, 8, 30, 31, 55]
    six = ht.coordinates_from_pose(poses, hexapod=machine)
    timed, hot = tmp_path / "few.csv", tmp_path / "hot.csv"
    timed.write_text(text_of(f"time_s,{POSES}", np.column_stack([time, six])[chosen]), encoding="utf-8")
    hot.write_text(text_of(f"time_s,{head}", np.column_stack([time, heat])), encoding="utf-8")
    found = correct_trajectory(machine, timed, hot, tmp_path / "o.csv")
    assert not found.warnings
    assert f"; {56 - len(chosen)} rows of temperatures before and between poses" in found.pairing
    controllers, wanted = machine.leg_controllers(), []
    early = list(range(chosen[0]))
    for k in range(56):
        if k in chosen:
            between = None if wanted else (time[early], temps[early])
            wanted.append(controllers.corrected_leg_lengths(poses[k], temps[k], time[k], between=between))
        elif wanted:
            controllers.stay(temps[k], time[k])
    told = lengths(tmp_path / "o.csv")
    assert np.abs(told - np.array(wanted) * 1e3).max() < EXACT_MM
    blind = machine.leg_controllers().corrected_leg_lengths(poses[chosen], temps[chosen], time[chosen])
    assert np.abs(told - blind * 1e3).max() > 1e-4


def test_rows_before_the_first_pose_are_no_motion(tmp_path: Path) -> None:
    """In a room that stays, rows of temperatures before the first pose change nothing, whatever the laws remember: no
    backlash is taken up, nothing creeps; and a term of no size changes nothing either.
    """
    lag, *others = STATES
    assert lag.shape == "lag"
    machine, nothing = with_terms(*STATES), dataclasses.replace(lag, amplitudes=1e-30 * lag.amplitudes)
    poses, temps, _time = motion(4)
    warm = np.tile(temps[0] + 3.0, (721, 1))
    six = ht.coordinates_from_pose(poses, hexapod=machine)
    head, time, stands = seven(warm)[0], np.arange(0.0, 7201.0, 10.0), np.array([60.0, 1800.0, 3600.0, 7200.0])
    (tmp_path / "p.csv").write_text(text_of(f"time_s,{POSES}", np.column_stack([stands, six])), encoding="utf-8")
    for name, rows in (("all", slice(None)), ("late", slice(6, None))):
        text = text_of(f"time_s,{head}", np.column_stack([time, warm])[rows])
        (tmp_path / f"{name}.csv").write_text(text, encoding="utf-8")

    def told(law: ht.Hexapod, name: str) -> np.ndarray:
        correct_trajectory(law, tmp_path / "p.csv", tmp_path / f"{name}.csv", tmp_path / "o.csv", overwrite=True)
        return lengths(tmp_path / "o.csv")

    assert np.abs(told(machine, "all") - told(machine, "late")).max() < EXACT_MM
    assert np.abs(told(with_terms(*others), "all") - told(with_terms(nothing, *others), "all")).max() < EXACT_MM


def test_temperatures_between_are_held_against_the_range() -> None:
    """One that the law was never asked for is refused with its sensor, as a wrong order is; nothing is remembered."""
    controllers = with_terms(*STATES).leg_controllers()
    poses, temps, time = motion(2)
    before = controllers.corrected_leg_lengths(poses, temps, time, remember=False)
    for value in (500.0, np.nan):
        with pytest.raises(TemperatureError, match="leg1_T1"):
            controllers.corrected_leg_lengths(poses, temps, time, between=(time[:1], np.full((1, 7), value)))
    with pytest.raises(ArgumentError, match="rows between: time must"):
        controllers.corrected_leg_lengths(poses, temps, time, between=(time[::-1], temps))
    assert np.array_equal(controllers.corrected_leg_lengths(poses, temps, time, remember=False), before)
    with pytest.raises(ArgumentError, match="told nothing yet"):
        controllers.stay(temps[0], time[0])


def test_rows_between_have_no_inputs() -> None:
    """Recorded inputs are of the poses' rows; rows between have none, and that is refused."""
    poses, temps, time = motion(3)
    controllers = with_terms(*STATES).leg_controllers()
    with pytest.raises(ArgumentError, match="no recorded inputs"):
        controllers.corrected_leg_lengths(
            poses, temps, time, inputs={"pump_W": np.zeros(3)}, between=(time[:1], temps[:1])
        )
