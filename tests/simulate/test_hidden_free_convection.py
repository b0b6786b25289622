"""The bench that cools by free convection and radiation."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from hexathermal.simulate.hidden.benches import free_convection
from hexathermal.simulate.hidden.benches.free_convection import CELLS, ROD_CELLS, Chain, Heat, warmed
from hexathermal.simulate.hidden.drawing import campaign_of

BODY = Chain(0.03, 4e3, 0.05, 0.25, 0.09, 0.3)
ROD = Chain(0.05, 1.5e3, 0.02, 0.09, 0.03, 0.3)
NOTHING = Heat(0.0, 0.0, 0.0, 3.0, 0.2)


def after(body: Chain, rod: Chain, heat: Heat, hours: float, start: float, moving: float = 0.0) -> list[np.ndarray]:
    """Return body and rod at the end of some hours in air of 20 degC."""
    rows = int(3600.0 * hours / free_convection.SUBSTEP)
    speed, place, air = np.full((rows, 1), moving), np.full((rows, 1), 0.05), np.full((rows, 1), 20.0)
    return [part[-1, 0] for part in warmed(body, rod, heat, speed, place, air, np.array([start]))]


def test_what_is_warmer_cools_more_than_in_proportion() -> None:
    """Of an excess of 16 K a smaller part is left after half an hour than of 1 K."""
    much, little = (after(BODY, ROD, NOTHING, 0.5, 20.0 + excess)[0].mean() - 20.0 for excess in (16.0, 1.0))
    assert much / 16.0 < 0.9 * little / 1.0


def test_heat_is_kept_where_no_surface_loses_it() -> None:
    """What motor and nut give, no more and no less, warms body and rod, wherever the rod is."""
    heat = Heat(10.0, 20.0, 0.3, 3.0, 0.2)
    body, rod = replace(BODY, surface=0.0), replace(ROD, surface=0.0)
    tube, bar = after(body, rod, heat, 1.0, 20.0, 0.5)
    stored = body.capacity * body.cell * (tube - 20.0).sum() + rod.capacity * rod.cell * (bar - 20.0).sum()
    assert stored == pytest.approx((10.0 + 20.0 * 0.5) * 3600.0, rel=1e-9)
    assert (tube.size, bar.size) == (CELLS, ROD_CELLS)


def test_steps_are_short_enough(monkeypatch: pytest.MonkeyPatch) -> None:
    """Half the step changes no temperature by more than a hundredth of the warming."""
    heat = Heat(10.0, 20.0, 0.3, 3.0, 0.2)
    coarse = np.concatenate(after(BODY, ROD, heat, 1.0, 20.0, 0.5))
    monkeypatch.setattr(free_convection, "SUBSTEP", free_convection.SUBSTEP / 2.0)
    fine = np.concatenate(after(BODY, ROD, heat, 1.0, 20.0, 0.5))
    assert np.abs(fine - coarse).max() < 0.01 * (fine.max() - 20.0)


def test_campaigns_are_as_the_bench_says() -> None:
    """Ten runs of 5 h, rows of one of five steps, warming by kelvins, the stated law without any noise."""
    for seed in range(4):
        truth = free_convection.draw(np.random.default_rng(seed))
        assert len(truth.runs) == 10
        assert truth.notes["sample_s"] in free_convection.STEPS
        for run in truth.runs:
            assert run.time[-1] == pytest.approx(18000.0, abs=60.0)
            assert np.diff(run.time) == pytest.approx(truth.notes["sample_s"])
        rise = max(float((run.temperatures - run.temperatures[0]).max()) for run in truth.runs)
        assert 1.0 < rise < 40.0
        base = [truth.sensors.index(name) for name in truth.base]
        A, B = np.split(truth.coefficients, 2)
        for run in truth.runs:
            dT = run.temperatures[:, base] - run.temperatures[0, base]
            assert run.drift == pytest.approx(truth.retracted_length * (dT @ A) + run.q * (dT @ B), abs=1e-15)


def test_effects_hide_in_it() -> None:
    """An effect has the strength that is asked for, and the same seed makes the same campaign."""
    seed = 20261123
    truth, answer = campaign_of("free_convection", seed, causes=("backlash",), strength=1.0)
    assert answer.strengths[0] == pytest.approx(1.0, rel=0.05)
    again, _ = campaign_of("free_convection", seed, causes=("backlash",), strength=1.0)
    assert np.array_equal(again.runs[3].drift + again.runs[3].effect, truth.runs[3].drift + truth.runs[3].effect)
