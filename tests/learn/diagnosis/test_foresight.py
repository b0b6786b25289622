"""Runs left out of the fit: what they deny is not named."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from hexathermal.learn.diagnosis import foresight
from hexathermal.learn.diagnosis.channels import Levels
from hexathermal.learn.diagnosis.course import _not_denied
from hexathermal.learn.diagnosis.deciding import Decision
from hexathermal.learn.diagnosis.evidence import LEAST, Scored
from hexathermal.learn.diagnosis.foresight import FAINT, worth
from hexathermal.learn.diagnosis.ranking import Ranked
from hexathermal.learn.diagnosis.trials import Trial

LEVELS = Levels(1e-7, 1e-7, 1e-7, 1e-7)


@pytest.mark.parametrize(("evidence", "share", "pays"), [
    (LEAST + 1.0, -0.2, False), (LEAST + 1.0, -0.05, True), (FAINT + 1.0, -0.05, True), (FAINT + 1.0, -0.9, False),
])  # fmt: skip
def test_a_faint_name_may_not_add_to_the_squares_of_runs_left_out(
    monkeypatch: pytest.MonkeyPatch, evidence: float, share: float, pays: bool
) -> None:
    """A name that is hardly above chance, and foretells runs clearly worse, is not given; a clear one may be."""

    def saved(*_stages: Any, within: bool = False) -> float:
        return -1.0 if within else share

    monkeypatch.setattr(foresight, "part_saved", saved)
    monkeypatch.setattr(foresight, "part_spread", lambda *_stages: 0.1)
    monkeypatch.setattr(foresight, "foresight", lambda *_stages: 40.0)
    trial = Trial("frame-expansion", np.zeros((1, 1)))
    best = Scored(trial, evidence, 10.0 * LEVELS.rms, LEVELS.rms, 0.0, 1.0, np.ones(1))
    nothing: Any = None
    assert worth(nothing, nothing, Ranked("frame-expansion", evidence, best, LEVELS), later=False)[0] == pays


@pytest.mark.parametrize(("evidence", "share", "stands"), [(LEAST + 1.0, -0.2, False), (LEAST + 1.0, 0.01, True)])
def test_something_faint_without_a_name_is_denied_alike(
    monkeypatch: pytest.MonkeyPatch, evidence: float, share: float, stands: bool
) -> None:
    """A rhythm that is hardly above chance, and foretells runs worse, is nothing."""
    monkeypatch.setattr(foresight, "part_saved", lambda *_stages: share)
    monkeypatch.setattr(foresight, "part_spread", lambda *_stages: 0.1)
    best = Scored(Trial("follows time", np.zeros((1, 1))), evidence, 1.0, LEVELS.rms, 0.0, 1.0, np.ones(1))
    leader = Ranked("follows time", evidence, best, LEVELS)
    stage: Any = SimpleNamespace(with_effect=lambda _best: None)
    assert (_not_denied(stage, Decision(leader, 0.9, {}, ())).leader is leader) == stands


@pytest.mark.parametrize(("evidence", "seen", "given"), [
    (LEAST + 1.0, 10.0, False), (FAINT + 1.0, 10.0, True), (FAINT + 1.0, 0.17, True),
])  # fmt: skip
def test_a_faint_step_of_one_run_is_not_given(
    monkeypatch: pytest.MonkeyPatch, evidence: float, seen: float, given: bool
) -> None:
    """No run left out can tell of a step in one run: it must be clear by itself, however small it is over all runs."""
    monkeypatch.setattr(foresight, "part_spread", lambda *_stages: 0.1)
    best = Scored(Trial("zero-jump", np.zeros((1, 1))), evidence, seen * LEVELS.rms, LEVELS.rms, 0.0, 1.0, np.ones(1))
    nothing: Any = None
    assert worth(nothing, nothing, Ranked("zero-jump", evidence, best, LEVELS), later=False)[0] == given
