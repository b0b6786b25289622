"""Parts that light may have measured, and names that no data of a part tell apart."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from hexathermal.learn.diagnosis.alike_by_nature import alike_by_nature
from hexathermal.learn.diagnosis.causes import air_refraction
from hexathermal.learn.diagnosis.stage import Stage
from hexathermal.learn.diagnosis.trials import Trial
from hexathermal.learn.diagnosis.view import View
from hexathermal.learn.interferometer import index_along_run
from tests.learn.diagnosis.campaigns import first_name, viewed

PATH_M = 0.8


def with_weather(view: View, path: float, rng: np.random.Generator) -> View:
    """A view whose runs record pressure, humidity and their air, read through so much of it [m]."""
    runs, level = [], 101_000.0
    for rows in view.runs:
        air, count = rows.signals.air, len(rows.drift)
        assert air is not None
        walk = np.cumsum(rng.standard_normal(count)) * 600.0 / np.sqrt(count)
        weather = np.column_stack([21.0 + air, level + walk, np.full(count, 0.45)])
        index = index_along_run(weather) - index_along_run(weather[:1])[0]
        signals = replace(rows.signals, index=index, pressure_index=index, zero_index=1.00027)
        runs.append(
            replace(rows, signals=signals, weather=weather, drift=rows.drift + path * (index - index[rows.settled][0]))
        )
    return replace(view, runs=tuple(runs))


@pytest.mark.long
@pytest.mark.parametrize("bench", ["component", "actuator"])
def test_an_index_that_was_not_applied_is_found_on_a_part(bench: str, rng: np.random.Generator) -> None:
    """Where the weather is recorded it is tried over a path that nobody stated, and is no other thermometer."""
    view = next(view for view in (viewed(bench, seed, (), 1.0)[0] for seed in range(2, 20))
                if all(rows.signals.air is not None for rows in view.runs))  # fmt: skip
    assert first_name(with_weather(view, PATH_M, rng)) == "air-refraction"


def test_without_weather_no_index_of_a_part_is_tried() -> None:
    """Nothing tells it from the room then."""
    view, _ = viewed("component", 5, (), 1.0)
    assert list(air_refraction.trials(Stage(view).bench))
    blind = tuple(replace(rows, signals=replace(rows.signals, index=None)) for rows in view.runs)
    assert not list(air_refraction.trials(Stage(replace(view, runs=blind)).bench))


def test_what_no_data_of_a_part_tell_apart_is_stated() -> None:
    """Another thermometer or a tilt; a zero that warms up in each run or what gives way. Legs have beams, and move."""
    part = next(view for view in (viewed("component", seed, (), 1.0)[0] for seed in range(20)) if not view.moves)
    leg, moving = viewed("quiet", 3, (), 1.0)[0], viewed("actuator", 2, (), 1.0)[0]
    another, warming = (
        Trial("missing-sensor", np.zeros((1, 1))),
        Trial("zero-drift", np.zeros((1, 1)), None, "relaxation"),
    )
    assert alike_by_nature(part, another) == alike_by_nature(moving, another) == ("abbe-tilt",)
    assert alike_by_nature(part, warming) == ("creep",)
    assert alike_by_nature(moving, warming) == alike_by_nature(leg, warming) == alike_by_nature(leg, another) == ()
    assert alike_by_nature(part, replace(warming, shape="time")) == ()
