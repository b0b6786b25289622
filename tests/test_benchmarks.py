"""The benchmarks measure right answers: every contender is right, and a bar can fail."""

from __future__ import annotations

import io
import json
import platform
import shutil
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from rich.console import Console

sys.path.insert(0, str(Path(__file__).parents[1]))

from benchmarks import report
from benchmarks.bars import Bar, error_bar, found, other_bars, speed_bars
from benchmarks.case import Case, Quantity, drawn_case, motions_of, poses_of
from benchmarks.contender import Contender, Unavailable
from benchmarks.contenders import MODULES, cpp_yardstick, entered, mujoco_tendons
from benchmarks.fresh_processes import ImportTimes, Memory, memory
from benchmarks.measuring import Measurement, answered, errors, one_processor

POSES = 200
LENGTH_M, POSE, JACOBIAN = 1e-14, 1e-13, 1e-14
MUJOCO_POSE = 1e-10
"""MuJoCo's Newton stops at a residual of 1e-12 m."""


@pytest.fixture(scope="module")
def case() -> Case:
    return drawn_case(POSES)


def entrant(case: Case, module: str) -> Contender:
    """Return one contender, or skip with its reason."""
    contenders, missing = entered(case, (module,))
    if missing:
        pytest.skip(missing[module])
    return contenders[0]


def assert_all_right(case: Case, contender: Contender, pose_tolerance: float = POSE) -> None:
    jobs = contender.jobs(case)
    assert jobs
    for job in jobs:
        answers = answered(job)
        assert len(answers) >= min(POSES, len(case)) - 8, f"{job.quantity} {job.variant}: answers are missing"
        allowed = {Quantity.POSES: pose_tolerance, Quantity.JACOBIANS: JACOBIAN}.get(job.quantity, LENGTH_M)
        worst = np.max(errors(case, job.quantity, answers))
        assert worst <= allowed, f"{contender.name}, {job.quantity.value}, {job.variant}: {worst:.2e} > {allowed:g}"


@pytest.mark.long
@pytest.mark.parametrize("module", MODULES)
def test_every_answer_of_every_contender_is_right(case: Case, module: str) -> None:
    """Each contender's every job gives the true lengths, corrected lengths, poses and Jacobians of 200 poses."""
    assert_all_right(case, entrant(case, module), MUJOCO_POSE if module == "mujoco_tendons" else POSE)


@pytest.mark.long
@pytest.mark.parametrize(
    ("architecture", "flag"), [("x86-64", "sse2"), ("x86-64-v3", "avx2"), ("x86-64-v4", "avx512f")]
)
def test_the_yardstick_is_right_at_every_vector_width(case: Case, architecture: str, flag: str) -> None:
    """Vectors of 2, 4 and 8 doubles give the same right answers; batches need not be whole vectors."""
    info = Path("/proc/cpuinfo")
    if platform.machine() != "x86_64" or not info.exists() or flag not in info.read_text().split():
        pytest.skip(f"this processor has no {flag}")
    odd = Case(case.hexapod, case.poses[:195].copy(), case.temps[:195].copy())
    try:
        yardstick = cpp_yardstick.CppYardstick(odd, cpp_yardstick.built(f"-march={architecture}"))
    except Unavailable as reason:
        pytest.skip(str(reason))
    assert_all_right(odd, yardstick)


def test_the_yardstick_turns_from_a_home_that_is_turned_by_half_a_turn(case: Case) -> None:
    """A machine whose home is turned by 180 degrees about x has the same lengths and comes back to the same poses."""
    if shutil.which("g++") is None:
        pytest.skip("g++ is not installed")
    flip = np.diag([1.0, -1.0, -1.0, 1.0])
    h = case.hexapod
    turned = replace(h, platform_joints=h.platform_joints @ flip[:3, :3], home=h.home @ flip, platform_cone=None)
    other = Case(turned, case.poses @ flip, case.temps)
    np.testing.assert_allclose(other.lengths, case.lengths, rtol=0, atol=1e-15)
    assert_all_right(other, cpp_yardstick.CppYardstick(other, cpp_yardstick.built()))


def test_a_missing_compiler_is_a_reason_not_an_error(case: Case, monkeypatch: pytest.MonkeyPatch) -> None:
    """Without g++ the yardstick is left out, and the reason names g++."""
    monkeypatch.setattr(shutil, "which", lambda _name: None)
    contenders, missing = entered(case, ("cpp_yardstick",))
    assert contenders == []
    assert "g++" in missing["cpp_yardstick"]


def test_truth_is_better_than_a_double(case: Case) -> None:
    """The true lengths are within half a unit in the last place of those of exact fractions."""
    from fractions import Fraction

    for k in range(5):
        T, true = case.poses[k], case.lengths[k]
        for i in range(6):
            p, b = case.hexapod.platform_joints[i], case.hexapod.base_joints[i]
            d = [
                sum(Fraction(float(T[r, c])) * Fraction(float(p[c])) for c in range(3))
                + Fraction(float(T[r, 3])) - Fraction(float(b[r]))
                for r in range(3)
            ]  # fmt: skip
            square = sum(x * x for x in d)
            half = Fraction(float(np.spacing(true[i]))) * Fraction(501, 1000)
            assert (Fraction(float(true[i])) - half) ** 2 <= square <= (Fraction(float(true[i])) + half) ** 2


def test_poses_lie_where_the_case_says(case: Case) -> None:
    """Poses are inside the stroke, within 50 mm and 10 degrees of home in each coordinate; motions say the same."""
    shortest, longest = case.hexapod.length_limits
    assert ((case.lengths > shortest) & (case.lengths < longest)).all()
    assert np.abs(case.poses[:, :3, 3] - case.hexapod.home[:3, 3]).max() <= 0.05
    angles = np.arccos((np.trace(case.poses[:, :3, :3], axis1=1, axis2=2) - 1) / 2)
    assert np.degrees(angles).max() <= np.sqrt(3) * 10.5
    np.testing.assert_allclose(poses_of(motions_of(case.poses)), case.poses, rtol=0, atol=1e-15)


def test_a_wrong_answer_is_seen(case: Case) -> None:
    """An error of 1 nm or 1 nrad, and a missing answer, show in the recorded errors."""
    wrong = case.poses.copy()
    wrong[7, 1, 3] += 1e-9
    wrong[9, 2, 0] -= 1e-9
    assert errors(case, Quantity.POSES, wrong) == pytest.approx((1e-9, 1e-9), rel=1e-5)
    wrong[11] = np.nan
    assert np.isnan(errors(case, Quantity.POSES, wrong)).all()
    assert errors(case, Quantity.LENGTHS, case.lengths[:50] + 1e-9) == pytest.approx((1e-9,), rel=1e-5)


def made_up(contender: str, quantity: Quantity, batch: bool, seconds: float, variant: str = "") -> Measurement:
    wrong = (1e-15, 1e-15) if quantity is Quantity.POSES else (1e-15,)
    return Measurement(contender, quantity, batch, variant, False, seconds, seconds, 3, 10**6 if batch else 1, wrong)


def made_up_run(corrected: float, forward: float, ik: float, fk: float) -> list[Measurement]:
    """Return measurements of hexathermal as given, of MuJoCo 1 and 60 us, of the yardstick 1 and 1 us."""
    return [
        made_up("hexathermal", Quantity.CORRECTED, False, corrected),
        made_up("hexathermal", Quantity.POSES, False, forward),
        made_up("hexathermal", Quantity.LENGTHS, True, ik),
        made_up("hexathermal", Quantity.POSES, True, fk),
        made_up("MuJoCo", Quantity.LENGTHS, False, 1.0, mujoco_tendons.LENGTHS_ONLY),
        made_up("MuJoCo", Quantity.POSES, False, 60.0, mujoco_tendons.NUMPY),
        made_up("C++ yardstick", Quantity.LENGTHS, True, 1.0, cpp_yardstick.SAME_JOB),
        made_up("C++ yardstick", Quantity.POSES, True, 1.0, cpp_yardstick.SAME_JOB),
    ]


@pytest.mark.parametrize(
    ("times", "passed"),
    [
        ((1.0, 2.0, 2.5, 2.5), [True, True, True, True]),
        ((1.01, 2.01, 2.51, 2.51), [False, False, False, False]),
        ((0.1, 0.1, 0.1, 9.9), [True, True, True, False]),
    ],
)
def test_speed_bars_hold_where_they_say(times: tuple[float, float, float, float], passed: list[bool]) -> None:
    """Met at 1 x, 30 x, 40 % and 40 %, and not beyond."""
    assert [bar.passed for bar in speed_bars(made_up_run(*times), {})] == passed


def test_a_missing_peer_is_not_a_passed_bar() -> None:
    """Without MuJoCo its two bars are neither passed nor failed, and say why."""
    ours = [one for one in made_up_run(1.0, 2.0, 2.5, 2.5) if one.contender != "MuJoCo"]
    bars = speed_bars(ours, {"mujoco_tendons": "MuJoCo is not installed"})
    assert [bar.passed for bar in bars] == [None, None, True, True]
    assert [bar.reason for bar in bars] == ["MuJoCo is not installed"] * 2 + ["", ""]


def test_an_error_of_ours_fails_its_bar() -> None:
    """An error of 1e-13 m in one answer, or a missing answer, is enough."""
    run = made_up_run(1.0, 2.0, 2.5, 2.5)
    assert error_bar(run).passed
    assert error_bar([*run, replace(run[0], errors=(1e-13,))]).passed is False
    assert error_bar([*run, replace(run[0], errors=(1e-15, float("nan")))]).passed is False


def test_import_and_memory_bars_hold_where_they_say() -> None:
    """Twice pinocchio's import and three times the data are the ends; a loaded compiler fails."""
    slow = [ImportTimes("hexathermal", 0.3, 0.201, 3, True), ImportTimes("pinocchio", 0.1, 0.1, 3, False)]
    assert [bar.passed for bar in other_bars(slow, [Memory("f", 1, 100, 100, 501)])] == [False, False, False]
    fast = [ImportTimes("hexathermal", 0.2, 0.2, 3, False), ImportTimes("pinocchio", 0.1, 0.1, 3, False)]
    assert [bar.passed for bar in other_bars(fast, [Memory("f", 1, 100, 100, 500)])] == [True, True, True]


@pytest.fixture
def outcome() -> report.Outcome:
    run = made_up_run(1.0, 2.0, 2.5, 2.6)
    imports = [ImportTimes("hexathermal", 0.15, 0.15, 3, False), ImportTimes("pinocchio", 0.1, 0.1, 3, False)]
    memories = [Memory("inverse_kinematics", 1000, 128000, 48000, 48000)]
    bars = [*speed_bars(run, {}), *other_bars(imports, memories)]
    return report.Outcome("a processor", 10**6, {"hexathermal": "a note"}, {}, run, imports, memories, bars)


def test_a_failed_bar_fails_the_run_and_shows(outcome: report.Outcome) -> None:
    """One bar that is not met marks the run as failed, in the tables too; without it the run is good."""
    console = Console(record=True, width=200, file=io.StringIO())
    report.shown(outcome, console)
    assert outcome.failed
    assert console.export_text().count("NOT MET") == 1
    good = replace(outcome, bars=[bar for bar in outcome.bars if bar.passed])
    assert not good.failed


def test_json_holds_every_number(outcome: report.Outcome) -> None:
    """All measurements, ratios and verdicts come back from the JSON text."""
    numbers = json.loads(report.as_json(outcome))
    assert [one["seconds"] for one in numbers["measurements"]] == [one.seconds for one in outcome.measurements]
    assert [bar["passed"] for bar in numbers["bars"]] == [bar.passed for bar in outcome.bars]
    assert numbers["memories"][0]["ratio"] == pytest.approx(outcome.memories[0].ratio)


def test_a_page_gets_new_tables_and_keeps_its_words(outcome: report.Outcome, tmp_path: Path) -> None:
    """Only what stands between the two marks is replaced; writing twice changes nothing more."""
    page = tmp_path / "page.md"
    page.write_text(f"before\n{report.BEGIN}\nold\n{report.END}\nafter\n")
    report.written_into(page, outcome)
    text = page.read_text()
    assert text.startswith("before\n")
    assert text.endswith("\nafter\n")
    assert "old" not in text
    assert "| NOT MET |" in text
    report.written_into(page, outcome)
    assert page.read_text() == text


def test_a_measurement_is_found_by_its_variant() -> None:
    """The same job with another variant, or on all processors, is not taken for it."""
    run = made_up_run(1.0, 2.0, 2.5, 2.5)
    assert found(run, "MuJoCo", Quantity.POSES, False, mujoco_tendons.LAPACK) is None
    everywhere = [replace(one, all_cores=True) for one in run]
    assert found(everywhere, "hexathermal", Quantity.POSES, True) is None


def test_one_processor_is_given_back() -> None:
    """Inside, the process may use one processor; afterwards as many as before."""
    import os

    if not hasattr(os, "sched_getaffinity"):
        pytest.skip("this system has no processor affinity")
    before = os.sched_getaffinity(0)
    with one_processor():
        assert len(os.sched_getaffinity(0)) == 1
    assert os.sched_getaffinity(0) == before


@pytest.mark.long
def test_memory_counts_the_result_of_a_batch() -> None:
    """A batch of 200 000 poses adds at least its result of 9.6 MB, and its inputs are counted."""
    if not Path("/proc/self/clear_refs").exists():
        pytest.skip("needs Linux")
    found = memory("inverse_kinematics", 200_000)
    assert found.input_bytes == 200_000 * 128
    assert found.output_bytes == 200_000 * 48
    assert found.added_bytes > 0.9 * found.output_bytes


def test_bar_without_ratio_has_no_verdict() -> None:
    """A bar that was not measured is None, neither met nor not."""
    assert Bar("x", None, 1.0, True).passed is None
