"""Runs left out of the fit: what they deny is not named."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from hexathermal.learn.diagnosis import foresight
from hexathermal.learn.diagnosis.channels import Levels
from hexathermal.learn.diagnosis.evidence import LEAST, Scored
from hexathermal.learn.diagnosis.foresight import FAINT, worth
from hexathermal.learn.diagnosis.ranking import Ranked
from hexathermal.learn.diagnosis.trials import Trial

LEVELS = Levels(1e-7, 1e-7, 1e-7, 1e-7)


@pytest.mark.parametrize(("evidence", "share", "pays"), [
    (LEAST + 1.0, -0.01, False), (LEAST + 1.0, 0.01, True), (FAINT + 1.0, -0.01, True), (FAINT + 1.0, -0.9, False),
])  # fmt: skip
def test_a_faint_name_must_lessen_the_squares_of_runs_left_out(
    monkeypatch: pytest.MonkeyPatch, evidence: float, share: float, pays: bool
) -> None:
    """A name that is hardly above chance, and foretells no run better, is not given; a clear one may be."""

    def saved(*_stages: Any, within: bool = False) -> float:
        return -1.0 if within else share

    monkeypatch.setattr(foresight, "part_saved", saved)
    monkeypatch.setattr(foresight, "part_spread", lambda *_stages: 0.1)
    monkeypatch.setattr(foresight, "foresight", lambda *_stages: 40.0)
    trial = Trial("frame-expansion", np.zeros((1, 1)))
    best = Scored(trial, evidence, 10.0 * LEVELS.rms, LEVELS.rms, 0.0, 1.0, np.ones(1))
    nothing: Any = None
    assert worth(nothing, nothing, Ranked("frame-expansion", evidence, best, LEVELS), later=False)[0] == pays
