"""The next experiment: what it promises, and what carrying it out on a virtual machine brings."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import hexathermal as ht
from hexathermal.errors import ArgumentError, UnknownNameError
from hexathermal.kinematics.limits import margins
from hexathermal.kinematics.sampled_poses import reachable_coordinates
from hexathermal.learn.machine_diagnosis.plan_files import experiment_facts, write_experiment
from hexathermal.learn.machine_diagnosis.planner import joined
from hexathermal.learn.machine_diagnosis.planning import MachineExperiment, next_experiment
from hexathermal.learn.machine_diagnosis.scenarios import Scenario, usual_scenarios
from hexathermal.learn.machine_diagnosis.single_leg import single_leg_candidates
from hexathermal.learn.machine_diagnosis.tables import Levels
from hexathermal.learn.machine_diagnosis.view import MachineView, planned_view
from tests.learn.machine_diagnosis.planned import (
    BASE,
    PLATFORM,
    chosen,
    random_plan,
    reached,
    residual,
    truth_of,
    usual_noise,
    warmed_at_home,
)

GROWTH = 2e-6
"""Change of a plate's expansion [1/K] that is to be told."""

SLOTS = 20


def planned_for(view: MachineView, *names: str, **more: object) -> MachineExperiment:
    """The next experiment for candidates by name."""
    return next_experiment(view, chosen(view, *names), usual_noise(), slots=SLOTS, **more)  # type: ignore[arg-type]


@pytest.fixture(scope="module")
def plates() -> tuple[MachineView, MachineExperiment]:
    """A machine warmed at home, and the experiment that tells its plates apart."""
    view = warmed_at_home()
    sizes = {PLATFORM: np.array([GROWTH]), BASE: np.array([GROWTH])}
    return view, planned_for(view, PLATFORM, BASE, amplitudes=sizes)


def separations(
    known: MachineView, plan: MachineView, six: np.ndarray, part: int, rng: np.random.Generator, draws: int
) -> np.ndarray:
    """By how much the true plate beats the other after the rows that were there and a plan, shape (draws,)."""
    both = joined([known, plan])
    truth = truth_of(both, np.concatenate([np.zeros((len(known), 6)), six]))
    expansions = truth.expansions.copy()
    expansions[part] += GROWTH
    clean = residual(both, truth.changed(expansions=expansions))
    found = reached(both, chosen(both, PLATFORM, BASE), clean, draws, rng)
    return np.asarray(found[:, part] - found[:, 1 - part])


@pytest.mark.long
def test_the_plan_carried_out_separates_as_promised_and_better_than_random_ones(
    plates: tuple[MachineView, MachineExperiment], rng: np.random.Generator
) -> None:
    """On a virtual machine with a faulty plate, solved by other means, the plan separates platform from base by what
    is promised within 10 % and three standard errors, each plate being the true one; the rows that were there did not
    separate at all; 40 random choices of poses and scenario separate less on average than half of it, random poses in
    the plan's own scenario less than 80 %.
    """
    known, plan = plates
    draws = 40
    for part, true in enumerate((PLATFORM, BASE)):
        got = separations(known, plan.view, plan.coordinates, part, rng, draws)
        promise = next(one for one in plan.promises if one.true == true)
        assert abs(got.mean() - promise.after) < 0.1 * promise.after + 3.0 * got.std() / np.sqrt(draws)
        assert abs(promise.before) < 0.5
        assert promise.after > 6.0
        others = [separations(known, *random_plan(known, SLOTS, rng), part, rng, 2).mean() for _draw in range(40)]
        assert np.mean(others) < 0.5 * got.mean()
        same = [
            separations(known, *random_plan(known, SLOTS, rng, plan.scenarios[0]), part, rng, 2).mean()
            for _ in range(10)
        ]
        assert np.mean(same) < 0.8 * got.mean()


def test_planned_poses_are_within_all_limits(plates: tuple[MachineView, MachineExperiment]) -> None:
    """Each planned pose is within stroke, cones and travel, and is the one in the table."""
    _view, plan = plates
    poses = ht.pose_from_coordinates(plan.coordinates, hexapod=plan.view.hexapod)
    assert margins(plan.view.hexapod, poses).reachable.all()
    assert np.allclose(poses, plan.view.poses, atol=1e-12)


def test_the_design_is_better_than_random_designs_by_its_own_measure(
    plates: tuple[MachineView, MachineExperiment],
) -> None:
    """The least separation beats that of random plans, which is told, more than twice."""
    _view, plan = plates
    assert plan.separation > 2.0 * max(plan.random, 0.0)
    assert f"{plan.random:.1f}" in plan.words


@pytest.mark.long
@pytest.mark.parametrize(
    ("names", "scenario"),
    [
        (("joint-offset of base joint 4", "joint-offset of platform joint 4"), "at rest"),
        (("payload-compliance", "joint-offset of base joint 1"), "at rest"),
        (("leg-coefficient of leg2", "leg-coefficient of leg5"), None),
    ],
)
def test_what_is_warmed_fits_what_is_asked(names: tuple[str, str], scenario: str | None) -> None:
    """Faults that no temperature shows need no heat; two legs are told apart by a plan that warms one of them."""
    plan = planned_for(warmed_at_home(), *names)
    way = plan.scenarios[0]
    assert plan.separation > 10.0
    if scenario is not None:
        assert way.name == scenario
    else:
        assert way.legs[1] or way.legs[4]


@pytest.mark.long
def test_swapped_legs_are_told_by_warming_one_of_the_two(rng: np.random.Generator) -> None:
    """Six legs that are always equally warm hide exchanged thermometers; the plan warms exactly one of the two."""
    view, _six = random_plan(warmed_at_home(), SLOTS, rng)
    alike = replace(view, dT=np.linspace(0, 5, SLOTS)[:, None, None] * (1.0 + 1e-3 * np.arange(6)[:, None]))
    plan = planned_for(alike, "swapped-legs of leg3+leg4", "leg-coefficient of leg3")
    legs = plan.scenarios[0].legs
    assert (legs[2] > 0.0) != (legs[3] > 0.0)
    assert plan.separation > 6.0


@pytest.mark.long
def test_backlash_is_promised_for_the_order_in_which_poses_are_written(rng: np.random.Generator) -> None:
    """Backlash depends on the order of the rows: the promise is reached in the order that is written, within 10 % and
    three standard errors; the same poses in one sweep from short to long tell it less.
    """
    known, _six = random_plan(warmed_at_home(), SLOTS, rng)
    names = ("leg-backlash of leg2", "joint-offset of base joint 2")
    step = 1.5e-6
    sizes = {names[0]: np.array([step]), names[1]: np.full(3, 5e-6)}
    plan = planned_for(known, *names, amplitudes=sizes)
    promise = next(one for one in plan.promises if one.true == names[0])
    swept = plan.view.q[:, 1].argsort()
    means = []
    for order in (np.arange(SLOTS), swept):
        rows = replace(plan.view, poses=plan.view.poses[order], q=plan.view.q[order])
        both = joined([known, rows])
        pair = chosen(both, *names)
        got = np.subtract(*reached(both, pair, step * pair[0].columns[..., 0], 60, rng).T)
        means.append((got.mean(), got.std() / np.sqrt(60)))
    assert abs(means[0][0] - promise.after) < 0.1 * promise.after + 3.0 * means[0][1]
    assert means[1][0] < means[0][0] - 3.0 * means[0][1]


def test_two_runs_tell_more_than_one() -> None:
    """A second run adds to the separation, and is a run of its own in the view, the words and the files."""
    view = warmed_at_home()
    names = ("leg-coefficient of leg2", "leg-coefficient of leg5")
    one, two = (planned_for(view, *names, runs=runs, pool=30) for runs in (1, 2))
    assert two.separation > one.separation
    assert two.view.runs == ("run-1", "run-2")
    assert len(two.scenarios) == 2
    assert two.words.count("measure 20 poses") == 2


def test_a_single_candidate_is_told_from_nothing() -> None:
    """One candidate alone: the promise is its evidence against nothing."""
    plan = planned_for(warmed_at_home(), "leg-coefficient of leg3")
    assert [(one.true, one.rival) for one in plan.promises] == [("leg-coefficient of leg3", "nothing")]
    assert plan.promises[0].after > plan.promises[0].before


def test_slow_errors_of_legs_lower_what_is_promised() -> None:
    """Where legs err slowly by as much as the noise, less is promised than where the frame alone is free."""
    view = warmed_at_home()
    sizes = {PLATFORM: np.array([GROWTH]), BASE: np.array([GROWTH])}
    still, slow = (
        planned_for(view, PLATFORM, BASE, amplitudes=sizes, levels=levels)
        for levels in (Levels(frame=1e3), Levels(frame=1e3, slow=0.5, leg=1.0))
    )
    assert 0.0 < slow.separation < 0.9 * still.separation


def test_causes_of_a_single_leg_are_planned_for(rng: np.random.Generator) -> None:
    """A leg's own catalogue is known: a wrong scale is told from a wrong coefficient; what is in none is refused."""
    view, _six = random_plan(warmed_at_home(), SLOTS, rng, usual_scenarios()[2])
    own = [one for one in single_leg_candidates(view) if one.called == "scale-error of leg2"]
    wanted = [*own, *chosen(view, "leg-coefficient of leg2")]
    plan = next_experiment(view, wanted, usual_noise(), slots=SLOTS, pool=30)
    assert plan.separation > plan.promises[0].before
    with pytest.raises(UnknownNameError, match="no cause 'gremlins'"):
        next_experiment(view, [replace(own[0], cause="gremlins")], usual_noise())


def test_a_fault_that_no_thermometer_can_show_is_refused_by_name() -> None:
    """Where the platform has no thermometer no plan shows its expansion: the refusal names channel and column."""
    view = warmed_at_home(plates=False)
    wanted = chosen(warmed_at_home(), PLATFORM)
    blind = [replace(wanted[0], columns=np.zeros((len(view), 6, 1)))]
    with pytest.raises(ArgumentError, match=r"no scenario shows platform-expansion.*platform_T1_degC"):
        next_experiment(view, blind, usual_noise(), slots=4)


@pytest.mark.parametrize(
    ("more", "says"),
    [
        ({"slots": 1}, "slots of at least 2"),
        ({"runs": 0}, "runs of at least 1"),
        ({"pool": 1}, "pool of at least 2"),
        ({"strength": -1.0}, "above 0"),
        ({"amplitudes": {PLATFORM: np.zeros(3)}}, "has 1 parameters"),
        ({"scenarios": ()}, "at least one"),
        ({"laws": "some"}, "laws is 'some'"),
    ],
)
def test_numbers_that_make_no_plan_are_refused(more: dict[str, object], says: str) -> None:
    """Each wrong number is refused with the limit it breaks."""
    view = warmed_at_home()
    with pytest.raises(ArgumentError, match=says):
        next_experiment(view, chosen(view, PLATFORM, BASE), usual_noise(), **more)  # type: ignore[arg-type]


def test_scenarios_are_checked() -> None:
    """A rise that is none, and legs that are not six, are refused; two of one name as well."""
    with pytest.raises(ArgumentError, match="above 0 K"):
        usual_scenarios(0.0)
    with pytest.raises(ArgumentError, match="six legs"):
        Scenario("x", "y", (1.0,))
    with pytest.raises(ArgumentError, match="finite"):
        Scenario("x", "y", (np.nan,) * 6)
    view, twice = warmed_at_home(), usual_scenarios()[:1] * 2
    with pytest.raises(ArgumentError, match="names of their own"):
        next_experiment(view, chosen(view, PLATFORM), usual_noise(), scenarios=twice)


def test_files_tell_the_plan(plates: tuple[MachineView, MachineExperiment], tmp_path: Path) -> None:
    """The table holds the commanded poses to their last digit under a campaign's column names; the JSON tells
    scenario, rises and separations; writing again replaces both.
    """
    _view, plan = plates
    for _time in range(2):
        files = write_experiment(plan, tmp_path / "next")
    table, facts = files
    assert table.read_text().splitlines()[0] == "time_s,x_mm,y_mm,z_mm,rx_deg,ry_deg,rz_deg"
    read = np.loadtxt(table, delimiter=",", skiprows=1)
    assert np.array_equal(read[:, 1:], plan.coordinates)
    told = json.loads(facts.read_text())
    assert told == json.loads(json.dumps(experiment_facts(plan)))
    assert told["runs"][0]["poses"] == table.name
    assert told["runs"][0]["rise_K"]["platform"] == pytest.approx(plan.scenarios[0].platform)
    assert told["separation"] == pytest.approx(plan.separation, abs=1e-3)
    blocked = tmp_path / "file"
    blocked.write_text("x")
    with pytest.raises(ArgumentError):
        write_experiment(plan, blocked)


def test_noisy_thermometers_of_what_is_measured_do_not_disturb_the_plan(rng: np.random.Generator) -> None:
    """Errors of readings belong to the rows that are there: with thermometers that flicker by 0.05 K the plan stands,
    and what is known before is less than with quiet ones.
    """
    quiet, _six = random_plan(warmed_at_home(), SLOTS, rng, usual_scenarios()[2])
    noisy = replace(quiet, dT=quiet.dT + 0.05 * rng.standard_normal(quiet.dT.shape))
    names = ("leg-coefficient of leg2", "leg-coefficient of leg5")
    sizes = {name: np.full(2, 2e-7) for name in names}
    one, two = (planned_for(view, *names, amplitudes=sizes, pool=30) for view in (quiet, noisy))
    assert two.promises[0].before < one.promises[0].before
    assert two.separation > 6.0


@pytest.mark.long
def test_every_bundled_machine_is_planned_for(hexapod: ht.Hexapod, rng: np.random.Generator) -> None:
    """Machines of long and of short stroke, with two thermometers a leg: poses within their limits, and a promise above
    what random plans bring.
    """
    law = ht.LegLaw(("T1", "T2"), [1.0e-6, 1.0e-6], [0.5e-6, 0.6e-6])
    plate = ht.PlateLaw(6e-6, "T1")
    machine = replace(hexapod, thermal=ht.ThermalModel(law, plate, plate))
    six = reachable_coordinates(machine, SLOTS, rng)
    dT, plates, air = usual_scenarios()[1].temperatures(np.linspace(0.0, 1.0, SLOTS), 2)
    poses = ht.pose_from_coordinates(six, hexapod=machine)
    view = planned_view(machine, poses, dT, plates=plates, air=air)
    plan = planned_for(view, PLATFORM, "leg-coefficient of leg1", pool=30)
    planned = ht.pose_from_coordinates(plan.coordinates, hexapod=machine)
    assert margins(machine, planned).reachable.all()
    assert plan.separation > plan.random
