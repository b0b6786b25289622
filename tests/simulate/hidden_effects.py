"""Campaigns with an effect in them that several tests look at, and campaigns of one run made up for a purpose."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from hexathermal.simulate.hidden.effect import Parameters
from hexathermal.simulate.hidden.effects import named
from hexathermal.simulate.hidden.truth import CampaignTruth


def hidden(
    name: str, truth: CampaignTruth, generator: np.random.Generator, **fixed: float | int | str
) -> tuple[CampaignTruth, Parameters]:
    """A campaign with an effect, some of its parameters given."""
    effect = named(name)
    parameters = {**effect.draw(truth, generator), **fixed}
    return effect.hide(truth, parameters), parameters


def made_up(truth: CampaignTruth, q: Callable[[np.ndarray], np.ndarray], step: float = 5.0) -> CampaignTruth:
    """The campaign with one run of four hours, its rod moved as told."""
    run = truth.runs[0]
    time = np.arange(0.0, 14401.0, step)
    rows = {
        name: np.repeat(getattr(run, name)[:1], time.size, axis=0)
        for name in ("temperatures", "sensor_errors", "air", "inputs")
    }
    still = {name: np.zeros(time.size) for name in ("drift", "noise", "effect")}
    own = run.changed(
        time=time, q=q(time), settled=np.ones(time.size, dtype=bool), beam_effects=np.zeros((time.size, 3)), **rows,
        **still,
    )  # fmt: skip
    return truth.changed(runs=(own,))


def with_channel(truth: CampaignTruth, sensor: str, values: np.ndarray) -> CampaignTruth:
    """The campaign of one run with other temperatures of a sensor."""
    (run,) = truth.runs
    temperatures = run.temperatures.copy()
    temperatures[:, truth.sensors.index(sensor)] = values
    return truth.changed(runs=(run.changed(temperatures=temperatures),))
