"""A beam that lost count: cleaning takes it back, and the diagnosis says so by its name, its moment and its size."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import numpy as np
import pytest

from hexathermal.learn.campaign_files import load_campaign
from hexathermal.learn.cleaning_record import BeamStep
from hexathermal.learn.diagnosis import diagnose
from hexathermal.learn.diagnosis import lost_counts as module
from hexathermal.learn.diagnosis.lost_counts import lost_count
from hexathermal.learn.diagnosis.result import Diagnosis
from hexathermal.learn.diagnosis.stage import Stage, view_of
from hexathermal.learn.signals import campaign_rows
from hexathermal.simulate.hidden.drawing import campaign_of
from hexathermal.simulate.hidden.writing import write_campaign

Found = tuple[Diagnosis, float]


def _lost(place: Path, causes: tuple[str, ...], step_um: float, run: int = 1, beam: int = 2) -> Found:
    """The diagnosis of a campaign in whose run a beam loses count within a rest, and the moment of that [s]."""
    truth, answer = campaign_of("quiet", 8, causes=causes, strength=1.0)
    write_campaign(place / "campaign", truth, answer)
    file = load_campaign(place / "campaign").runs_of("identification")[run].path
    with file.open() as lines:
        rows = list(csv.DictReader(lines))
    rest = np.array([float(row["settled"]) for row in rows]) > 0.5
    long = np.flatnonzero(np.convolve(rest, np.ones(21), "valid") > 20.5)
    at = int(long[len(long) // 2]) + 10
    for row in rows[at:]:
        row[f"beam{beam}_mm"] = repr(float(row[f"beam{beam}_mm"]) + step_um * 1e-3)
    with file.open("w", newline="") as lines:
        table = csv.DictWriter(lines, list(rows[0]))
        table.writeheader()
        table.writerows(rows)
    moment = float(rows[at]["time_s"]) - float(rows[0]["time_s"])
    return diagnose(load_campaign(place / "campaign"), answer.base), moment


def test_a_beam_that_lost_count_is_named(tmp_path: Path) -> None:
    """In a sound campaign one beam loses 3 um: a zero jump of 1 um of the drift, to its row and within three standard
    uncertainties; the beam is the target, no law holds it, and the JSON says that it is taken back.
    """
    found, moment = _lost(tmp_path, (), 3.0)
    assert found.verdict == "effect"
    assert [one.cause for one in found.effects] == ["zero-jump"]
    effect = found.effects[0]
    assert effect.taken_back
    assert not effect.joined
    assert effect.target == "beam2"
    assert effect.parameters["time_s"].value == pytest.approx(moment, abs=1e-6)
    step = effect.parameters["step_um"]
    assert abs(step.value - 1.0) < 3.0 * step.std < 0.3
    assert found.extended is found.law
    assert found.candidates[0].cause == "zero-jump"
    document = json.loads(json.dumps(found.to_json()))
    assert (document["cause"], document["target"]) == ("zero-jump", "beam2")
    assert document["effects"][0]["taken_back"] is True
    assert "Cleaning took back a zero-jump" in document["sentence"]


def test_it_stands_beside_what_the_residual_shows(tmp_path: Path) -> None:
    """Beside a screw error both have their names, the one with more evidence first."""
    found, _moment = _lost(tmp_path, ("periodic-screw-error",), 3.0)
    assert {one.cause for one in found.effects} == {"periodic-screw-error", "zero-jump"}
    assert [one.taken_back for one in found.effects if one.cause == "zero-jump"] == [True]
    evidence = [next(item.evidence for item in found.candidates if item.cause == one.cause) for one in found.effects]
    assert evidence == sorted(evidence, reverse=True)


def test_what_the_drift_would_not_show_is_only_noted(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A lost count that leaves less than `SEEN` of the noise beside the law has no name; asked for less, it has one."""
    truth, answer = campaign_of("quiet", 8, causes=(), strength=1.0)
    write_campaign(tmp_path / "campaign", truth, answer)
    campaign = load_campaign(tmp_path / "campaign")
    view = view_of(campaign, campaign_rows(campaign, "identification"), answer.base)
    middle = float(view.signals[1].time.mean())
    view.runs[1].record.__dict__["beam_steps"] = (BeamStep("beam1_mm", middle, 0.02e-6, 1e-9, True),)
    stage = Stage(view)
    assert lost_count(stage) is None
    monkeypatch.setattr(module, "SEEN", 0.0)
    small = lost_count(stage)
    assert small is not None
    assert small.effect.visible < 0.02e-6 / 3.0


@pytest.mark.parametrize(("z", "named"), [(6.9, False), (9.0, True)])
def test_tilt_at_a_movement_is_no_lost_count(tmp_path: Path, z: float, named: bool) -> None:
    """A step at a movement counts where it is `SURE` times what the beams part by there."""
    truth, answer = campaign_of("quiet", 8, causes=(), strength=1.0)
    write_campaign(tmp_path / "campaign", truth, answer)
    campaign = load_campaign(tmp_path / "campaign")
    view = view_of(campaign, campaign_rows(campaign, "identification"), answer.base)
    middle = float(view.signals[1].time.mean())
    view.runs[1].record.__dict__["beam_steps"] = (BeamStep("beam1_mm", middle, z * 0.5e-6, 0.5e-6, False),)
    assert (lost_count(Stage(view)) is not None) == named
