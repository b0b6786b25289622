"""What is no cause of the catalogue is given no name of it, and what a name explains beside it is still named."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from hexathermal.learn.machine_diagnosis.case import case_of
from hexathermal.learn.machine_diagnosis.causes.joint_offset import candidates as joints
from hexathermal.learn.machine_diagnosis.course import searched
from hexathermal.learn.machine_diagnosis.deciding import verdict
from hexathermal.learn.machine_diagnosis.diagnosing import diagnosed
from hexathermal.learn.machine_diagnosis.noise_levels import coordinates_of, scatter_of
from hexathermal.learn.machine_diagnosis.unexplained import wide_candidates
from hexathermal.learn.machine_diagnosis.view import machine_view
from tests.learn.machine_diagnosis.machines import Fault, drawn

JUMP = 1.2e-6
STRANGERS = {
    "jumped": (Fault(), "follows the run, in leg3"),
    "friction": (Fault(friction=1e-6), "follows the last move of every leg"),
    "bent": (Fault(bent=(1, 1.5e-6)), "follows the pose, in leg2"),
}


@pytest.mark.long
@pytest.mark.parametrize("stranger", STRANGERS)
def test_a_stranger_gets_no_name_of_a_part_of_it(stranger: str) -> None:
    """All legs with friction are no leg-backlash of one, a leg that waves with the pose no offset of its joint, nor one
    whose scale lost its zero between two runs.
    """
    fault, follows = STRANGERS[stranger]
    rows = drawn(31, fault, runs=3, poses=60)
    if stranger == "jumped":
        q = rows.q.copy()
        q[rows.run > 0, 2] -= JUMP
        rows = replace(rows, q=q)
    course = searched(case_of(rows))
    assert not course.adopted
    named, probability, said = verdict(course)
    assert (named, said) == ("unexplained", follows)
    assert probability > 0.9


@pytest.mark.parametrize(("follows", "leg", "surely"), [("the pose, in leg2", 1, 0.2), ("the run, in leg4", 3, 0.05)])
def test_what_has_no_name_has_a_size(follows: str, leg: int, surely: float) -> None:
    """A leg that is longer by the square of a coordinate, or in other runs, moves the platform as far as is told,
    within its uncertainty, which is small: no error of frame or legs holds a part of it. So do sentence and JSON.
    """
    rows = drawn(37, runs=3, poses=60)
    view = machine_view(rows)
    x = view.poses[:, 0, 3] - view.poses[:, 0, 3].mean()
    longer = np.zeros((len(rows), 6))
    longer[:, leg] = 2e-6 * ((x / x.std()) ** 2 - 1.0 if "pose" in follows else np.array([1.0, -0.5, -0.5])[view.run])
    found = diagnosed(replace(rows, q=rows.q - longer))
    assert (found.verdict, found.follows) == ("unexplained", f"follows {follows}")
    true = np.sqrt((coordinates_of(view, longer)[:, :3] ** 2).sum(axis=1).mean())
    told = found.candidates[0].moved
    assert told.translation_std < surely * told.translation
    assert abs(told.translation - true) < 3.0 * told.translation_std
    assert f"{told.translation * 1e6:.2g} um" in found.sentence
    assert found.to_json()["candidates"][0]["translation_rms_um"] == pytest.approx(told.translation * 1e6)


def test_advice_names_all_legs_that_a_cause_was_named_on() -> None:
    """Two legs with backlash: the measurement is for both, the stronger one first."""
    rows = drawn(32, Fault(backlash=(4, 9e-7)), runs=3, poses=60)
    q = rows.q.copy()
    q[:, 1] -= 0.5 * 9e-7 * np.sign(np.diff(q[:, 1], prepend=q[0, 1]))
    found = diagnosed(replace(rows, q=q))
    assert found.advice[0].purpose == f"leg-backlash of {', '.join(str(one.target) for one in found.effects)}"
    assert len(found.effects) == 2


def test_two_legs_with_backlash_are_no_friction_of_all() -> None:
    """Two of a cause are named as two, though a shape of all legs holds both."""
    rows = drawn(32, Fault(backlash=(4, 9e-7)), runs=3, poses=60)
    q = rows.q.copy()  # the second leg's scale lags behind it, which is the same
    q[:, 1] -= 0.5 * 9e-7 * np.sign(np.diff(q[:, 1], prepend=q[0, 1]))
    course = searched(case_of(replace(rows, q=q)))
    assert {one.candidate.called for one in course.adopted} == {"leg-backlash of leg2", "leg-backlash of leg5"}


def test_a_smooth_function_of_the_pose_holds_what_a_joint_makes() -> None:
    """In a leg's length, any offset of its joint is a smooth function of the pose within a twentieth of its spread."""
    view = machine_view(drawn(33, runs=1, poses=200))
    wide = {one.cause: one.columns for one in wide_candidates(view)}
    for one in joints(view):
        leg = one.legs[0]
        shapes, own = wide[f"follows the pose, in leg{leg + 1}"][:, leg], one.columns[:, leg]
        left = own - shapes @ np.linalg.lstsq(shapes, own, rcond=None)[0]
        assert (left.std(axis=0) < 0.05 * own.std(axis=0)).all()


def test_a_run_that_scatters_more_counts_less_and_is_told() -> None:
    """A disturbed half of a run is told, nothing is named for it, and the noise stays that of the rest."""
    found = diagnosed(drawn(34, Fault(loud=(1, 3.0)), poses=90))
    assert found.verdict == "none"
    assert any("scatter more" in note and "run-2" in note and "run-1" not in note for note in found.notes)
    assert found.disturbances.noise == pytest.approx([4e-7] * 3 + [1e-6] * 3, rel=0.25)


@pytest.mark.parametrize("tails", [np.inf, 4.0])
def test_usual_runs_scatter_alike(tails: float) -> None:
    """White noise, normal or with heavy tails, leaves hardly any stretch apart; one three times as loud is found."""
    view = machine_view(drawn(35, runs=4, poses=90))
    rng, apart = np.random.default_rng(36), 0
    for _draw in range(50):
        square = (rng.standard_normal((len(view), 6)) ** 2).sum(axis=1)
        if np.isfinite(tails):
            square *= (tails - 2.0) / rng.chisquare(tails, len(view))
        apart += bool((scatter_of(view, square) != 1.0).any())
        loud = np.where((view.run == 2) & (np.arange(len(view)) % 90 >= 60), 9.0, 1.0)
        assert np.median(scatter_of(view, square * loud)[240:270]) > 2.0
    assert apart <= 5
