"""Numbers that later ones made needless are not named; channels that get worse are told."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from hexathermal.compare import steps
from hexathermal.compare.bench_runs import BenchRuns
from hexathermal.compare.comparison import _measured, _worse, _worse_words
from hexathermal.compare.parameters import NAMES
from hexathermal.compare.placing import placed
from hexathermal.compare.scores import ChannelScore
from hexathermal.compare.steps import Fit, Step, calibrated
from hexathermal.learn.campaign_files import load_campaign
from hexathermal.learn.validation_scores import Figure
from hexathermal.poses import FloatArray
from hexathermal.simulate.bench.changed import Change, write_changed_campaign

HOT, NEEDLESS = NAMES.index("motor-heat"), NAMES.index("conduction-motor")


@pytest.mark.long
def test_a_number_that_is_as_it_was_in_the_end_is_not_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A second number is forced upon a bench of which one differs: it goes again, and the bench is as with the one."""
    write_changed_campaign(tmp_path / "hot", Change("motor-heat", "", 2.0), 3, identification=2, duration=5400.0)
    campaign = load_campaign(tmp_path / "hot")
    where = placed(campaign, None)
    runs, _ = _measured(campaign, where, lambda _done, _total, _label: None)
    bench = BenchRuns(where, [run for run in runs if run.role == "identification"])
    alone = calibrated(bench)
    assert alone.named == (HOT,)
    taken = steps._step

    def forced(bench: BenchRuns, now: Fit, gains: FloatArray) -> tuple[Step, Fit]:
        step, fit = taken(bench, now, gains)
        if len(now.free) != 1:
            return replace(step, accepted=step.accepted and not now.free), fit
        fit = steps._settled(bench, steps.followed(bench, now, (*now.free, NEEDLESS)))
        return replace(step, candidate=NEEDLESS, accepted=True), fit

    monkeypatch.setattr(steps, "_step", forced)
    both = calibrated(bench)
    assert [(step.candidate, step.accepted) for step in both.steps][:2] == [(HOT, True), (NEEDLESS, False)]
    assert both.named == both.last.free == (HOT,)
    assert both.last.found.logs[NEEDLESS] == 0.0
    assert both.last.x[HOT] == pytest.approx(alone.last.x[HOT], abs=2e-3)
    assert np.isnan(both.gains[HOT])
    assert np.isfinite(both.gains[NEEDLESS])


def test_channels_that_are_proven_worse_are_told() -> None:
    """Only those whose whole interval is a loss, the worst of them with its figures."""

    def scored(name: str, value: float, low: float, high: float) -> ChannelScore:
        return ChannelScore(name, "body", 0.1, 1.0, 1.0, 1.0, 1.0, Figure(value, low, high), 0.5)

    scores = [scored("T01", 0.5, 0.4, 0.6), scored("T02", -0.3, -0.9, 0.1), scored("T03", -0.4, -0.8, -0.1)]
    assert _worse_words(_worse(scores[:2]), "validation") == []
    (note,) = _worse_words(_worse([*scores, scored("T04", -2.2, -5.4, -0.6)]), "validation")
    assert "T04, T03 are simulated worse on the runs for validation" in note
    assert "T04: RMSE up by 220 %, 95 % interval 60 to 540 %" in note
