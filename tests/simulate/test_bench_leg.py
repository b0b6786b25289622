"""The virtual leg: heat is conserved, step and cells are fine enough, and simple legs have exact answers."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from hexathermal.errors import ArgumentError
from hexathermal.simulate.bench.bench import Bench, planned_runs
from hexathermal.simulate.bench.leg import LARGEST_STEP, MOTOR, LegHistory, VirtualLeg
from hexathermal.simulate.bench.parts import Contact, Drive, EndJoints, LegBody, Rod
from hexathermal.simulate.bench.scenario import Motion

LEG = VirtualLeg()


def working(leg: VirtualLeg, step: float, hours: float = 6.0) -> LegHistory:
    """A published leg that works and rests in a room that swings by 1 K."""
    bench = Bench(leg=leg)
    (plan,) = planned_runs(bench, 3, identification=1, validation=0, duration=hours * 3600.0)
    motion = Motion(plan.commands, leg.drive.speed)
    time = np.arange(0.0, hours * 3600.0 + 0.5 * step, step)
    room = 20.0 + np.sin(2.0 * np.pi * time / 20000.0)
    q = motion.displacement(time)
    return leg.warm(time, q, room, leg.at_rest(20.0, q[0]), way=motion.way(time))


@given(
    q=st.lists(st.floats(0.0, 0.25), min_size=2, max_size=40),
    room=st.floats(-10.0, 50.0),
    start=st.floats(-20.0, 80.0),
    step=st.floats(0.1, 600.0),
)
@settings(max_examples=40)
def test_heat_is_conserved_whatever_the_leg_does(q: list[float], room: float, start: float, step: float) -> None:
    """Heat stored = heat made - heat given to the room, to rounding, for any motion, room and step."""
    n = len(q)
    history = LEG.warm(np.arange(n) * step, np.array(q), np.full(n, room), np.full(LEG.size, start))
    turned_over = history.heat_in + np.abs(history.stored()).max() + LEG.capacities.sum() * 100.0
    assert (np.abs(history.stored() - (history.heat_in - history.heat_out)) <= 1e-12 * turned_over).all()


def test_six_working_hours_balance_to_rounding() -> None:
    """Over 6 h of work and rest, some 4000 steps, the balance closes within 1e-12 of the heat that was made."""
    history = working(LEG, LARGEST_STEP)
    made = history.heat_in[-1]
    assert made > 5e4
    assert np.abs(history.stored() - (history.heat_in - history.heat_out)).max() < 1e-12 * made


def test_the_step_of_time_has_converged() -> None:
    """Half the step changes the drift of a 6 h run by less than 2 nm at every time."""
    reference = LEG.at_rest(20.0, 0.1)
    coarse = working(LEG, LARGEST_STEP)
    fine = working(LEG, 0.5 * LARGEST_STEP).every(2)
    assert np.array_equal(coarse.q, fine.q)
    assert np.abs(coarse.growth(reference)).max() > 4e-6
    assert np.abs(coarse.growth(reference) - fine.growth(reference)).max() < 2e-9


def test_the_cells_are_fine_enough() -> None:
    """Twice as many cells change the drift of a working leg by less than 1 % of its largest value."""
    finer = replace(LEG, body=replace(LEG.body, cells=54), rod=replace(LEG.rod, cells=54))
    drift = [working(leg, LARGEST_STEP, 3.0).growth(leg.at_rest(20.0, 0.1)) for leg in (LEG, finer)]
    assert np.abs(drift[0] - drift[1]).max() < 0.01 * np.abs(drift[0]).max()


def test_the_leg_follows_its_differential_equation() -> None:
    """Another integrator, on the same conductances, gives the same temperatures to 1 mK."""
    q = 0.12
    matrix, to_room = LEG.conductances(q)
    heat = np.zeros(LEG.size)
    heat[MOTOR] = LEG.drive.holding_power

    def rate(_time: float, T: np.ndarray) -> np.ndarray:
        return (heat - matrix @ T - to_room * (T - 25.0)) / LEG.capacities

    time = np.arange(0.0, 3601.0, 5.0)
    history = LEG.warm(time, np.full(time.size, q), np.full(time.size, 25.0), np.full(LEG.size, 20.0))
    found = solve_ivp(rate, (0.0, 3600.0), np.full(LEG.size, 20.0), method="BDF", rtol=1e-8, atol=1e-8)
    assert np.abs(history.temperatures[-1] - found.y[:, -1]).max() < 1e-3


def test_a_leg_at_rest_stays_at_rest() -> None:
    """The steady state is one: nothing changes, and the room takes what the motor makes."""
    start = LEG.at_rest(21.0, 0.2)
    time = np.arange(0.0, 7201.0, 5.0)
    history = LEG.warm(time, np.full(time.size, 0.2), np.full(time.size, 21.0), start)
    assert np.abs(history.temperatures - start).max() < 1e-9
    assert history.heat_out[-1] == pytest.approx(LEG.drive.holding_power * 7200.0, rel=1e-9)


@given(q=st.floats(0.0, 0.25))
@settings(max_examples=40)
def test_contact_is_mutual_and_matter_keeps_its_place(q: float) -> None:
    """Conductances are symmetric, rows sum to 0, none is negative; all friction heat enters somewhere."""
    matrix, to_room = LEG.conductances(q)
    assert np.array_equal(matrix, matrix.T)
    assert np.abs(matrix.sum(axis=1)).max() < 1e-9 * np.abs(matrix).max()
    assert (matrix - np.diag(np.diag(matrix)) <= 0.0).all()
    assert (to_room >= 0.0).all()
    assert LEG.friction_places(q).sum() == pytest.approx(1.0, abs=1e-12)


@given(q=st.floats(0.0, 0.24))
@settings(max_examples=40)
def test_overlap_falls_by_what_the_rod_slides(q: float) -> None:
    """Of 10 mm of motion, 10 mm of the rod leave the gap for the room: areas add up."""
    bare = replace(LEG, contact=Contact(nut_conductance=0.0, guide_conductance=0.0))
    change = {}
    for place in (q, q + 0.01):
        matrix, to_room = bare.conductances(place)
        joined = -matrix[bare.in_body, bare.in_rod].sum()
        change[place] = (joined, to_room[bare.in_rod].sum())
    perimeter = np.pi * LEG.rod.outer_diameter
    joined, room = np.subtract(change[q + 0.01], change[q])
    assert joined == pytest.approx(-0.01 * perimeter * LEG.contact.gap_conductance, rel=1e-6)
    assert room == pytest.approx(0.01 * perimeter * LEG.rod.convection, rel=1e-6)


@given(rise=st.floats(-5.0, 5.0), q=st.floats(0.0, 0.25))
@settings(max_examples=40)
def test_a_homogeneous_leg_obeys_the_published_law(rise: float, q: float) -> None:
    """A leg that is everywhere warmer by dT grows by A q0 dT + B q dT (eq. 3), with B the scale's expansion."""
    reference = LEG.at_rest(20.0, 0.0)
    body, rod, joints = LEG.body, LEG.rod, LEG.joints
    top = LEG.retracted_length - joints.length
    fixed = (
        2.0 * joints.expansion * joints.length
        + body.expansion * (body.head_position - joints.length)
        + body.head_bracket_expansion * body.head_bracket
        + rod.scale_expansion * (top - rod.scale_held - body.head_position)
        + rod.expansion * rod.scale_held
    )
    found = LEG.growth((reference + rise)[None, :], np.array([q]), reference)[0]
    assert found == pytest.approx((fixed + rod.scale_expansion * q) * rise, abs=1e-15)


def test_a_scale_that_does_not_expand_has_no_part_in_q() -> None:
    """With a scale of zero expansion a warm leg's error does not depend on where the rod stands."""
    leg = VirtualLeg(rod=Rod(scale_expansion=0.0))
    warm = leg.at_rest(20.0, 0.0)[None, :] + np.linspace(0.0, 5.0, leg.size)
    found = [leg.growth(warm, np.array([q]), leg.at_rest(20.0, 0.0))[0] for q in (0.0, 0.1, 0.25)]
    assert np.ptp(found) < 1e-18


def test_more_friction_warms_the_middle_and_more_motor_heat_the_foot() -> None:
    """Friction heat enters at the nut, motor heat at the foot."""

    def rise(drive: Drive) -> tuple[float, float]:
        history = working(VirtualLeg(drive=drive), 5.0, 2.0)
        return tuple(history.surface("body", place)[-1] for place in (0.03, 0.33))  # type: ignore[return-value]

    usual, friction, motor = (rise(drive) for drive in (Drive(), Drive(screw_torque=2.0), Drive(moving_power=30.0)))
    assert friction[1] - usual[1] > 2.0 * (friction[0] - usual[0]) > 0.0
    assert motor[0] - usual[0] > 2.0 * (motor[1] - usual[1]) > 0.0


def test_what_no_leg_can_do_is_refused() -> None:
    """Wrong shapes, clocks, strokes and parts are errors that name the limit."""
    time = np.arange(3.0)
    still, room, start = np.full(3, 0.1), np.full(3, 20.0), np.full(LEG.size, 20.0)
    wrong = (
        ({"q": np.full(3, 0.26)}, "stroke is 0 to 250 mm"),
        ({"time": time[::-1]}, "time must increase"),
        ({"room": np.full(2, 20.0)}, "one shape"),
        ({"start": np.full(4, 20.0)}, "one value for each node"),
        ({"q": np.array([0.1, np.nan, 0.1])}, "finite"),
        ({"way": np.array([0.0, 1.0, 0.5])}, "must not decrease"),
    )
    given_ = {"time": time, "q": still, "room": room, "start": start}
    for change, text in wrong:
        with pytest.raises(ArgumentError, match=text):
            LEG.warm(**(given_ | change))  # type: ignore[arg-type]
    with pytest.raises(ArgumentError, match="no 'nut'"):
        LEG.weights("nut", 0.1)
    with pytest.raises(ArgumentError, match="there is nothing at"):
        LEG.weights("body", 0.58)


@pytest.mark.parametrize(
    ("make", "text"),
    [
        (lambda: LegBody(length=-1.0), "LegBody.length"),
        (lambda: Rod(cells=1), "Rod.cells"),
        (lambda: LegBody(inner_diameter=0.08), "inner_diameter < outer_diameter"),
        (lambda: Rod(inner_diameter=0.05), "inner_diameter < outer_diameter"),
        (lambda: Drive(rod_share=1.5), "rod_share"),
        (lambda: EndJoints(capacity=float("nan")), "EndJoints.capacity"),
        (lambda: VirtualLeg(stroke=(0.0, 0.5)), "in the nut"),
        (lambda: VirtualLeg(body=LegBody(head_position=0.59)), "reading head"),
        (lambda: VirtualLeg(retracted_length=-1.0), "retracted length above 0"),
    ],
)
def test_impossible_parts_are_refused(make, text: str) -> None:
    """A part that cannot be says which number is wrong."""
    with pytest.raises(ArgumentError, match=text):
        make()
