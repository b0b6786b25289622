"""What is named where frames, thermometers and stated laws blur it, and how certain it is."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import hexathermal as ht
from hexathermal.learn.machine_diagnosis.case import case_of
from hexathermal.learn.machine_diagnosis.causes.swapped_legs import calm_heat
from hexathermal.learn.machine_diagnosis.course import searched
from hexathermal.learn.machine_diagnosis.diagnosing import diagnosed
from hexathermal.learn.machine_diagnosis.law_columns import law_columns
from hexathermal.learn.machine_diagnosis.search import step
from hexathermal.learn.machine_diagnosis.settled import settled
from hexathermal.machine.measuring_frame import MeasuringFrame
from hexathermal.predict.measuring import measured_poses
from tests.learn.machine_diagnosis.machines import A, B, Fault, drawn, filed


def noisy(rows, size: float, seed: int = 3):  # type: ignore[no-untyped-def]
    """Return rows whose thermometers err by `size` [K]."""
    errors = size * np.random.default_rng(seed).standard_normal(rows.dT.shape)
    return replace(rows, dT=rows.dT + errors)


def test_an_offset_of_a_joint_is_not_lost_in_an_offset_of_the_frame() -> None:
    """In poses of small range an offset moves all poses nearly alike: it is asked with and without a frame's offset."""
    rows = drawn(11, Fault(base_joint=(3, (2e-7, -3e-7, 8e-7))), share=0.1, runs=3, poses=100)
    case = case_of(rows)
    best = step(case, []).ranking[0]
    assert case.candidates[best.which].cause == "joint-offset"
    assert case.candidates[best.which].legs == (3,)
    assert best.levels.campaign == 0.0
    assert best.odds > step(case, []).threshold


def test_a_step_of_one_leg_in_time_is_no_offset_of_its_joint() -> None:
    """What no cause explains has no name, though a joint of that leg explains half of it."""
    course = searched(case_of(drawn(18, Fault(later=(2, 1e-6)), runs=3, poses=60)))
    assert not course.adopted
    assert course.left is not None
    assert course.case.candidates[course.left.which].cause == "follows time within a run, in leg3"


def test_flicker_that_is_noise_is_taken_off_readings_and_heat_is_kept() -> None:
    """Of smooth temperatures read with noise most of the noise goes; what is fast heat of one leg alone stays."""
    rows, rng = drawn(12, runs=2, poses=100), np.random.default_rng(4)
    smooth = 3.0 * np.sin(np.linspace(0.0, 6.0, 100) + np.arange(6)[:, None]).T
    true = np.concatenate([smooth, -smooth])[..., None]
    true[:, 5, 0] += 0.5 * rng.standard_normal(200)
    read = true + 0.02 * rng.standard_normal(true.shape)
    left = calm_heat(case_of(replace(rows, dT=read)).view) - true
    assert left[:, :5].std() < 0.6 * 0.02
    assert left[:, 5].std() < 1.2 * 0.02


def test_errors_of_thermometers_count_where_temperatures_count_from() -> None:
    """Runs that begin at zero share no error of it; a campaign that does has one for all runs."""
    rows = noisy(drawn(14, runs=3, poses=40), 0.02)
    own = rows.dT.copy()
    for run in range(3):
        own[rows.run == run] -= own[rows.run == run][0]
    each = case_of(replace(rows, dT=own)).view.zeros
    all_rows = case_of(replace(rows, dT=rows.dT - rows.dT[0])).view.zeros
    assert [int(part.sum()) for part in each] == [40, 40, 40]
    assert [int(part.sum()) for part in all_rows] == [120]


def test_a_law_known_within_a_covariance_is_known_better_with_rows_than_without() -> None:
    """The changed law's covariance is that of both: smaller than the change's, and it holds the true coefficients."""
    spread = np.diag([(1e-7) ** 2, (3e-7) ** 2])
    legs = [ht.LegLaw("T1", A, B, spread) for _leg in range(6)]
    rows = drawn(15, Fault(legs=((2, 1e-6, 0.0),)))
    thermal = replace(rows.hexapod.thermal, legs=legs)
    case = case_of(replace(rows, hexapod=replace(rows.hexapod, thermal=thermal)))
    (one,) = settled(searched(case))
    assert one.adoption.candidate.called == "leg-coefficient of leg3"
    assert (np.diagonal(one.whole_covariance) < np.diagonal(one.covariance)).all()
    assert one.whole_covariance[0, 0] < 0.95 * one.covariance[0, 0]
    pulls = (one.whole - [1e-6, 0.0]) / np.sqrt(np.diagonal(one.whole_covariance))
    assert np.abs(pulls).max() < 3.5
    assert law_columns(case.view).shifts["leg3"].any()


@pytest.mark.long
def test_settings_between_those_tried_are_uncertain_by_their_evidence() -> None:
    """A frame that follows 600 s late is found with its delay, within three of the standard deviations stated."""
    rows = drawn(16, runs=4, poses=80)
    room = MeasuringFrame("air_temperature", [4e-7, -3e-7, 2e-7], [6e-7, 0.0, 4e-7], time_constant=600.0)
    late = replace(filed(), measuring_frame=room)
    moved = rows.measured.copy()
    for run in range(4):
        own = rows.run == run
        moved[own] = measured_poses(late, rows.measured[own], rows.air[own], rows.time[own])
    found = diagnosed(replace(rows, measured=moved))
    assert (found.cause, found.effects[0].target) == ("tracker-drift", "air_temperature")
    delay = found.effects[0].parameters["time_constant_s"]
    assert 0.0 < delay.std < 150.0
    assert abs(delay.value - 600.0) < 3.0 * delay.std
    assert found.extended.measuring_frame.time_constant == delay.value
    again = diagnosed(replace(rows, measured=moved, hexapod=found.extended))
    assert again.verdict == "none"
    plan = found.to_json()["next_experiment"]
    assert plan["separation"] > 0.0
    assert len(plan["runs"][0]["poses_mm_deg"]) == 20
