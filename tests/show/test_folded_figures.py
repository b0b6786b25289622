"""What repeats is drawn within its period: the residual against it shows nothing else of an error with a pitch."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from hexathermal.learn.campaign_files import load_campaign
from hexathermal.learn.diagnosis import diagnose
from hexathermal.learn.diagnosis.result import Candidate, Diagnosis, RunResidual
from hexathermal.poses import FloatArray
from hexathermal.show.diagnosis_album import pictures_of
from hexathermal.show.diagnosis_run_figures import binned, pooled
from hexathermal.show.folded_figures import Fold, folded, folds_of
from hexathermal.simulate.hidden.drawing import campaign_of
from hexathermal.simulate.hidden.writing import write_campaign
from tests.show.drawn_diagnoses import UM, drawn

PERIOD = 1020.0


def with_wave(found: Diagnosis, wave: dict[str, FloatArray]) -> Diagnosis:
    """The diagnosis with waves by the run in its residuals, beside what shifts each run."""

    def waved(run: RunResidual) -> RunResidual:
        return replace(run, before=run.after + wave[run.run] + 3.0 * UM)

    return replace(found, residuals=tuple(waved(run) for run in found.residuals))


def test_an_error_of_the_screw_is_drawn_within_its_pitch() -> None:
    """A sine of 2 mm over 100 mm: its means go through its amplitude twice, and through nothing where it is mended."""
    found = drawn()
    assert folds_of(found) == [Fold("q", 2e-3)]
    waves = {run.run: 0.5 * UM * np.sin(2.0 * np.pi * run.signals["q"] / 2e-3) for run in found.residuals}
    place, before, after = folded(with_wave(found, waves), Fold("q", 2e-3))
    assert place.min() >= 0.0
    assert place.max() < 2e-3
    assert np.ptp(binned(place, before)[1]) == pytest.approx(1.0 * UM, rel=0.1)
    assert np.ptp(binned(place, after)[1]) < 0.1 * UM
    names = [one.name for one in pictures_of(found)["signals"]]
    assert names[0] == "residual-pitch"
    assert "residual-q" in names


def test_a_rhythm_is_drawn_within_its_period_whatever_its_phase_in_a_run() -> None:
    """Four runs with phases of their own show one sine that begins at zero."""
    rhythm = Candidate("follows time (a rhythm)", "t", 40.0, 0.9, 0.3 * UM, {"period_s": PERIOD})
    found = drawn("unexplained", follows=rhythm.cause, candidates=(rhythm,))
    assert folds_of(found) == [Fold("time", PERIOD)]
    waves = {run.run: 0.5 * UM * np.sin(2.0 * np.pi * run.time / PERIOD + k) for k, run in enumerate(found.residuals)}
    place, before, _after = folded(with_wave(found, waves), Fold("time", PERIOD))
    assert np.abs(before - 0.5 * UM * np.sin(2.0 * np.pi * place / PERIOD)).std() < 0.1 * UM
    picture = pictures_of(found)["signals"][0]
    assert picture.name == "residual-period"
    assert "turned by its own phase" in picture.caption


def test_nothing_is_folded_where_nothing_repeats() -> None:
    """A part without a stroke has no place within a pitch, and what follows the humidity has no period."""
    found = drawn("unexplained")
    assert folds_of(found) == []
    still = [replace(run, signals={"dT": run.signals["dT"]}) for run in drawn().residuals]
    names = [one.name for one in pictures_of(drawn(residuals=tuple(still)))["signals"]]
    assert not [name for name in names if name.startswith(("residual-pitch", "residual-period"))]


@pytest.mark.long
def test_the_residual_is_held_against_what_has_no_name(tmp_path: Path) -> None:
    """First of all pictures of signals, of the runs that were fitted: the residual goes with what is explained."""
    truth, answer = campaign_of("quiet", 801, causes=("outside: ratchet",), strength=1.2)
    write_campaign(tmp_path / "campaign", truth, answer)
    found = diagnose(load_campaign(tmp_path / "campaign"), answer.base)
    assert found.follows == "follows the highest temperature so far"
    having = [run for run in found.residuals if "followed" in run.signals]
    assert {run.role for run in having} == {"identification"}
    explained, before, _after = pooled(found, "followed")
    assert np.corrcoef(explained, before)[0, 1] > 0.4
    assert pictures_of(found)["signals"][0].name == "residual-followed"
    assert "follows the highest temperature so far" in pictures_of(found)["signals"][0].caption
