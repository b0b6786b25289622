"""A stop that ended far from where all others do is told with its run, time and place; tails and parts at rest not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from hexathermal.learn.diagnosis.far_landings import MOST_FAR, far_landings
from hexathermal.learn.diagnosis.stage import Stage
from hexathermal.learn.diagnosis.view import View
from tests.learn.diagnosis.campaigns import viewed

TIMES = 20.0
"""Standard deviations of landings by which one is moved."""


def with_far(view: View, which: dict[int, list[int]]) -> View:
    """The view with some landings of runs moved far away, counted from the second one of each."""
    size = TIMES * Stage(view).levels.rms
    runs = list(view.runs)
    for k, places in which.items():
        kinds = np.unique(runs[k].landing)
        moved = np.isin(runs[k].landing, kinds[[1 + place for place in places]])
        runs[k] = replace(runs[k], drift=runs[k].drift + size * moved)
    return replace(view, runs=tuple(runs))


def test_one_stop_is_told_with_its_run_and_its_size() -> None:
    """The note has the run, a time inside of it, and the size within a fifth; without it nothing is said."""
    view, _answer = viewed("finite_volume", 11, (), 1.0)
    assert far_landings(Stage(view)) == []
    size = TIMES * Stage(view).levels.rms
    (said,) = far_landings(Stage(with_far(view, {1: [4]})))
    assert view.runs[1].run.name in said
    assert view.runs[0].run.name not in said
    told = float(said.partition(" mm: ")[2].partition(" um")[0]) * 1e-6
    assert told == pytest.approx(size, rel=0.2)


def test_many_are_the_scatter_itself() -> None:
    """Of one landing in ten nothing is said: then landings have heavy tails."""
    view, _answer = viewed("finite_volume", 11, (), 1.0)
    count = min(len(np.unique(rows.landing)) for rows in view.runs) - 2
    every = {k: list(range(0, count, 10)) for k in range(len(view.runs))}
    assert sum(map(len, every.values())) > MOST_FAR * sum(len(np.unique(rows.landing)) for rows in view.runs)
    assert far_landings(Stage(with_far(view, every))) == []
