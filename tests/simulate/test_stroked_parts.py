"""Parts with a stroke are a leg's physics under a law of fixed lengths."""

from __future__ import annotations

import numpy as np
import pytest

from hexathermal.simulate.hidden import benches
from hexathermal.simulate.hidden.benches import held_out
from hexathermal.simulate.hidden.truth import CampaignTruth
from hexathermal.simulate.hidden.writing import run_columns

NAMES = ("actuator", "held_out_actuator")


@pytest.fixture(params=NAMES)
def part(request: pytest.FixtureRequest, seed: int) -> CampaignTruth:
    """A part of each bench."""
    return benches.draw(request.param, np.random.default_rng(seed))


def test_the_drift_is_that_of_its_law(part: CampaignTruth) -> None:
    """``sum_s C_s dT_s`` from the first row, a coefficient a thermometer; nothing else goes with the displacement."""
    base = [part.sensors.index(name) for name in part.base]
    assert part.kind == "component"
    assert len(part.coefficients) == len(base)
    for run in part.runs:
        warmed = run.temperatures[:, base] - run.temperatures[0, base]
        np.testing.assert_allclose(run.drift, warmed @ part.coefficients, rtol=0.0, atol=1e-15)
        assert np.ptp(run.q) > 0.01
        assert not run.beam_effects.any()


def test_it_has_the_thermometers_and_the_noise_of_the_leg(seed: int) -> None:
    """The same seed gives the leg of which the part is made; only what the law feigns is told anew."""
    leg, part = (benches.draw(name, np.random.default_rng(seed)) for name in (held_out.NAME, "held_out_actuator"))
    assert part.sensors == leg.sensors
    for one, other in zip(leg.runs, part.runs, strict=True):
        np.testing.assert_array_equal(one.temperatures + one.sensor_errors, other.temperatures + other.sensor_errors)
        np.testing.assert_array_equal(one.noise, other.noise)
    assert part.notes["white_um"] == leg.notes["white_um"]


def test_an_axis_grows_by_what_is_out_of_its_nut(seed: int) -> None:
    """``sum_s C_s dT_s + D_s q dT_s``, two coefficients a thermometer; no column says when it rests."""
    axis = benches.draw("held_out_axis", np.random.default_rng(seed))
    C, D = np.split(axis.coefficients, 2)
    base = [axis.sensors.index(name) for name in axis.base]
    for run in axis.runs:
        warmed = run.temperatures[:, base] - run.temperatures[0, base]
        np.testing.assert_allclose(run.drift, (warmed * (C + D * run.q[:, None])).sum(axis=1), rtol=0.0, atol=1e-15)
        columns = run_columns(axis, run)
        assert "q_mm" in columns
        assert "settled" not in columns
