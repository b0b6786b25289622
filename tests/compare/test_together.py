"""Legs warmed side by side: the scheme of `VirtualLeg.warm`, on a grid of places."""

from __future__ import annotations

from dataclasses import replace
from math import log

import numpy as np
import pytest

from hexathermal.compare.parameters import NAMES, PARAMETERS, scaled_leg
from hexathermal.errors import ArgumentError, UnknownNameError
from hexathermal.simulate.bench.changed import NUMBERS
from hexathermal.simulate.bench.leg import VirtualLeg
from hexathermal.simulate.bench.together import GRID, LegsTogether

STEP = 20.0


def test_on_the_grid_the_steps_are_those_of_one_leg() -> None:
    """At rest on a place of the grid, in a room that warms, both schemes agree to rounding."""
    leg = VirtualLeg()
    q = 20 * GRID
    time = STEP * np.arange(91.0)
    air = 20.0 + 0.5 * time / 3600.0
    start = leg.at_rest(20.0, q) + np.linspace(0.0, 2.0, leg.size)
    one = leg.warm(time, np.full(91, q), air, start)
    found = LegsTogether([leg], STEP).warm(np.full(90, q), np.zeros(90), 0.5 * (air[1:] + air[:-1]), start[None])
    assert np.abs(found[:, 0] - one.temperatures).max() < 1e-9


def test_a_moving_leg_warms_as_with_short_steps() -> None:
    """Half an hour of motion back and forth: the drift within 20 nm, the body within 20 mK of steps of 1 s."""
    leg = VirtualLeg()
    fine = np.arange(0.0, 1801.0)
    q = 0.12 + 0.1 * np.sin(2.0 * np.pi * fine / 400.0)
    way = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(q)))])
    start = leg.at_rest(20.0, float(q[0]))
    exact = leg.warm(fine, q, np.full(fine.size, 20.0), start)
    edges = np.arange(0.0, 1801.0, STEP)
    mean = np.array([q[int(a) : int(a + STEP) + 1].mean() for a in edges[:-1]])
    air = np.full(edges.size - 1, 20.0)
    found = LegsTogether([leg], STEP).warm(mean, np.diff(np.interp(edges, fine, way)), air, start[None])[:, 0]
    rows = edges.astype(int)
    body = np.abs(found - exact.temperatures[rows])[:, leg.in_body]
    assert body.max() < 0.08
    assert body[-1].max() < 0.05
    assert np.abs(leg.growth(found, q[rows], start) - exact.growth(start)[rows]).max() < 20e-9


def test_legs_of_other_cells_are_refused() -> None:
    """Legs that are warmed together share their cells; a step is longer than nothing."""
    leg = VirtualLeg()
    with pytest.raises(ArgumentError, match="one number of cells"):
        LegsTogether([leg, replace(leg, body=replace(leg.body, cells=20))], STEP)
    with pytest.raises(ArgumentError, match="above 0 s"):
        LegsTogether([leg], 0.0)


def test_every_parameter_scales_what_the_hidden_changes_scale() -> None:
    """The names of what is looked for are those of what tests hide, and each moves the same fields."""
    assert set(NAMES) == set(NUMBERS)
    for one in PARAMETERS:
        assert {f"{part}.{field}" for part, field in one.fields} == set(NUMBERS[one.name])
        leg = scaled_leg(VirtualLeg(), {one.name: log(2.0)})
        for part, field in one.fields:
            assert getattr(getattr(leg, part), field) == pytest.approx(
                2.0 * getattr(getattr(VirtualLeg(), part), field)
            )


def test_an_unknown_parameter_says_what_there_is() -> None:
    """A misspelt name is refused with the names that exist."""
    with pytest.raises(UnknownNameError, match="motor-heat"):
        scaled_leg(VirtualLeg(), {"motor-heta": 0.1})
