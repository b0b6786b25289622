"""What stands off in place of a step of the zero: windows, landings, and parts of these."""

from __future__ import annotations

import math
from collections import defaultdict
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from hexathermal.learn.campaign_files import load_campaign
from hexathermal.learn.diagnosis import diagnose
from hexathermal.learn.diagnosis.borne_out import JOLT, STEP_ALONE
from hexathermal.learn.diagnosis.deciding import decided
from hexathermal.learn.diagnosis.evidence import LEAST
from hexathermal.learn.diagnosis.stage import Stage
from hexathermal.learn.diagnosis.stand_offs import FADES_S, fadings, stand_offs
from hexathermal.learn.diagnosis.tolerating import tolerant
from hexathermal.show.diagnosis_sections import all_sections
from hexathermal.simulate.hidden.drawing import campaign_of
from hexathermal.simulate.hidden.writing import write_campaign
from tests.learn.diagnosis.campaigns import rewritten, viewed
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


@pytest.mark.long
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


@pytest.mark.long
@pytest.mark.parametrize(
    ("tau", "fades", "sign"), [(300.0, True, 1.0), (900.0, True, -1.0), (math.inf, False, 1.0), (math.inf, False, -1.0)]
)
def test_a_jolt_that_fades_is_no_step(tau: float, fades: bool, sign: float) -> None:
    """It is left without a name, told as what it is, and what stays is a step of the zero with nothing beside it."""
    view, _ = viewed("quiet", 2, (), 1.0)
    size, runs = sign * 8.0 * Stage(view).levels.rms, list(view.runs)
    time = runs[3].signals.time
    moment = 0.4 * time[-1]
    shape = (time >= moment) * np.exp(-np.maximum(time - moment, 0.0) / tau)
    runs[3] = replace(runs[3], drift=runs[3].drift + size * shape)
    found = tolerant(Stage(replace(view, runs=tuple(runs))), LEAST).step
    leader = decided(found, LEAST).leader
    assert leader is not None
    assert leader.cause == (JOLT if fades else "zero-jump")
    assert leader.best.trial.parameters["run"] == view.runs[3].run.name
    assert abs(leader.best.trial.parameters["time_s"] - moment) < 300.0
    by_name = {item.cause: item.value for item in found.ranking}
    if fades:
        assert by_name["zero-jump"] <= STEP_ALONE
    else:
        assert JOLT not in by_name


def test_a_step_that_fades_begins_with_it_and_keeps_to_its_run() -> None:
    """One at its moment, a part 1/e of it a time constant later, and nothing in other runs, which a zero goes on to."""
    channel = channel_like(np.random.default_rng(5), windows=40)
    step = (np.arange(len(channel)) >= 50).astype(float)[:, None]
    since = np.cumsum(channel.step) - np.cumsum(channel.step)[50]
    for tau, column in zip(FADES_S, fadings(step, channel), strict=True):
        own = (channel.run == 1) & (np.arange(len(channel)) >= 50)
        assert column[:, 0] == pytest.approx(own * np.exp(-np.maximum(since, 0.0) / tau))
        assert column[50, 0] == 1.0


@pytest.mark.long
def test_a_jolt_is_told_with_its_run_and_its_moment(tmp_path: Path) -> None:
    """From files: something real without a name, in the run and at the minute where a door opened."""
    truth, answer = campaign_of("quiet", 6, causes=(), shared=True)
    write_campaign(tmp_path / "campaign", truth, answer)
    run = load_campaign(tmp_path / "campaign").runs_of("identification")[1]

    def jolted(rows: list[dict[str, str]]) -> None:
        """All beams move by 2 um within 90 s, 40 % into the run, and come back within minutes."""
        begin = float(rows[-1]["time_s"]) * 0.4
        for row in rows:
            since = float(row["time_s"]) - begin
            more = 2e-3 * min(max(since / 90.0, 0.0), 1.0) * math.exp(-max(since, 0.0) / 700.0)
            row.update({name: repr(float(value) + more) for name, value in row.items() if name.startswith("beam")})

    rewritten(run.path, jolted)
    found = diagnose(load_campaign(tmp_path / "campaign"), answer.base)
    assert (found.verdict, found.follows) == ("unexplained", JOLT)
    minutes = float(found.candidates[0].settings["time_s"]) / 60.0
    assert f"in {run.name} from {minutes:.3g} min on" in found.sentence
    assert "at best in " + run.name in all_sections(found, defaultdict(str))[0][2]


@pytest.mark.long
def test_a_larger_jolt_says_more() -> None:
    """A step minutes away, which explains a little of it, does not bound what has no name: it is not there itself."""
    view, _ = viewed("quiet", 3, (), 1.0)
    noise, said = Stage(view).levels.rms, []
    time = view.runs[3].signals.time
    shape = (time >= 0.4 * time[-1]) * np.exp(-np.maximum(time - 0.4 * time[-1], 0.0) / 300.0)
    for size in (2.0, 2.5, 3.0, 4.0, 6.0):
        runs = list(view.runs)
        runs[3] = replace(runs[3], drift=runs[3].drift + size * noise * shape)
        ranking = Stage(replace(view, runs=tuple(runs))).step.ranking
        said.append(max((item.value for item in ranking if item.cause == JOLT), default=0.0))
    assert all(after > before for before, after in pairwise(said))
    assert said[-1] > 100.0
