"""What stands off in place of a step of the zero: windows, landings, and parts of these."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from hexathermal.learn.diagnosis.evidence import LEAST
from hexathermal.learn.diagnosis.stage import Stage
from hexathermal.learn.diagnosis.stand_offs import stand_offs
from tests.learn.diagnosis.campaigns import viewed
from tests.learn.diagnosis.noises import channel_like


def test_what_comes_before_or_behind_a_step_in_its_landing_may_stand_off() -> None:
    """In a long rest the scatter of a landing may be drawn anew: that part of it stands off, and the next one not."""
    channel = channel_like(np.random.default_rng(5), windows=40)
    landing = np.cumsum(channel.fresh)
    run = channel.run == 1
    own = np.flatnonzero(run & (landing == np.bincount(landing[run]).argmax()))
    assert len(own) > 3
    middle = own[len(own) // 2]
    step = (run & (np.arange(len(channel)) >= middle)).astype(float)[:, None]
    bumps, _pairs = stand_offs(step, channel)
    for part in (own[own < middle], own[own >= middle]):
        wanted = np.isin(np.arange(len(channel)), part).astype(float)[:, None]
        assert any(np.array_equal(bump, wanted) for bump in bumps)


def test_a_step_at_the_beginning_of_a_landing_has_nothing_before_it_there() -> None:
    """The part of a landing before its first window is empty, and nothing fails."""
    channel = channel_like(np.random.default_rng(5), windows=40)
    middle = int(np.flatnonzero(channel.fresh & ~channel.start & (channel.run == 1))[3])
    step = ((channel.run == 1) & (np.arange(len(channel)) >= middle)).astype(float)[:, None]
    bumps, _pairs = stand_offs(step, channel)
    assert all(np.isfinite(bump).all() and bump.shape == step.shape for bump in bumps)


@pytest.mark.parametrize(("bench", "seed", "run"), [("quiet", 2, 3), ("actuator", 3, 1), ("machine_tool", 1, 0)])
def test_a_step_in_the_last_landing_of_a_run_is_named(bench: str, seed: int, run: int) -> None:
    """What of it comes behind the step is the step: nothing that stands off in its place."""
    view, _ = viewed(bench, seed, (), 1.0)
    height, runs = 8.0 * Stage(view).levels.rms, list(view.runs)
    rows = runs[run]
    own = np.flatnonzero(view.channel.run == run)
    last = own[view.channel.fresh[own]][-1]
    assert own[-1] - last > 5
    moment = view.time[last + 3]
    runs[run] = replace(rows, drift=rows.drift + height * (rows.signals.time >= moment))
    stepped = replace(view, runs=tuple(runs))
    best = next(item for item in Stage(stepped).step.ranking if item.cause == "zero-jump")
    assert best.value > LEAST
    assert best.best.trial.target == view.runs[run].run.name
