"""A beam that lost count: cleaning takes it back, and the diagnosis says so by its name, its moment and its size."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from hexathermal.learn.campaign_files import load_campaign
from hexathermal.learn.cleaning_record import BeamStep
from hexathermal.learn.diagnosis import diagnose
from hexathermal.learn.diagnosis import lost_counts as module
from hexathermal.learn.diagnosis.beforehand import Beforehand
from hexathermal.learn.diagnosis.lost_counts import lost_count
from hexathermal.learn.diagnosis.result import Diagnosis
from hexathermal.learn.diagnosis.stage import Stage
from hexathermal.learn.diagnosis.view import View
from hexathermal.simulate.hidden.drawing import campaign_of
from hexathermal.simulate.hidden.writing import write_campaign
from tests.learn.diagnosis.campaigns import rewritten, viewed

Found = tuple[Diagnosis, float]


def _lost(
    place: Path, causes: tuple[str, ...], step_um: float, strength: float = 1.0, role: str = "identification"
) -> Found:
    """The diagnosis of a campaign in whose run a beam loses count within a rest, and the moment of that [s]."""
    truth, answer = campaign_of("quiet", 8, causes=causes, strength=strength)
    place.mkdir(exist_ok=True)
    write_campaign(place / "campaign", truth, answer)
    file = load_campaign(place / "campaign").runs_of(role)[1].path
    moments = []

    def losing(rows: list[dict[str, str]]) -> None:
        rest = np.array([float(row["settled"]) for row in rows]) > 0.5
        long = np.flatnonzero(np.convolve(rest, np.ones(21), "valid") > 20.5)
        at = int(long[len(long) // 2]) + 10
        for row in rows[at:]:
            row["beam2_mm"] = repr(float(row["beam2_mm"]) + step_um * 1e-3)
        moments.append(float(rows[at]["time_s"]) - float(rows[0]["time_s"]))

    rewritten(file, losing)
    return diagnose(load_campaign(place / "campaign"), answer.base), moments[0]


@pytest.mark.long
@pytest.mark.parametrize("role", ["identification", "validation"])
def test_a_beam_that_lost_count_is_named(tmp_path: Path, role: str) -> None:
    """In a sound campaign one beam loses 3 um: a zero jump of 1 um of the drift, to its row and within three standard
    uncertainties; the beam is the target, no law holds it, and the JSON says that it is taken back.
    """
    found, moment = _lost(tmp_path, (), 3.0, role=role)
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


@pytest.mark.long
def test_it_stands_beside_what_the_residual_shows(tmp_path: Path) -> None:
    """Beside a screw error both have their names, that which the drift would show more of first; the next experiment is
    for the screw, since the count is mended.
    """
    first = []
    for step_um, strength in ((0.4, 8.0), (9.0, 1.0)):
        found, _moment = _lost(tmp_path / str(step_um), ("periodic-screw-error",), step_um, strength)
        assert {one.cause for one in found.effects} == {"periodic-screw-error", "zero-jump"}
        assert [one.taken_back for one in found.effects if one.cause == "zero-jump"] == [True]
        assert [one.cause for one in found.candidates[:2]] == [one.cause for one in found.effects]
        sizes = [one.visible for one in found.effects]
        assert sizes == sorted(sizes, reverse=True)
        assert "pitch" in found.experiments[0].words
        first.append(found.cause)
    assert first == ["periodic-screw-error", "zero-jump"]


def _with_steps(steps: dict[int, tuple[BeamStep, ...]], zero: str = "run") -> View:
    """A sound campaign's runs in whose records cleaning took back steps."""
    view = viewed("quiet", 8, (), 1.0)[0]
    runs = [replace(rows, record=replace(rows.record, beam_steps=steps.get(k, ()))) for k, rows in enumerate(view.runs)]
    return replace(view, runs=tuple(runs), zeroed_by_run=zero == "run")


def _told(view: View, named: Sequence[tuple[str, float]] = ()) -> Beforehand | None:
    """What is told of the steps of a view."""
    return lost_count(view, Stage(view).levels.rms, named)


def _step(size_um: float = 3.0, error_um: float = 0.03, time: float = 9000.0, beam: int = 1) -> BeamStep:
    """A step within a rest."""
    return BeamStep(f"beam{beam}_mm", time, size_um * 1e-6, error_um * 1e-6, True)


def test_what_the_drift_would_not_show_is_only_noted(monkeypatch: pytest.MonkeyPatch) -> None:
    """A lost count that leaves less than `SEEN` of the noise beside the law has no name; asked for less, it has one."""
    view = _with_steps({1: (_step(0.02, 1e-3),)})
    assert _told(view) is None
    monkeypatch.setattr(module, "SEEN", 0.0)
    small = _told(view)
    assert small is not None
    assert small.effect.visible < 0.02e-6 / 3.0


@pytest.mark.parametrize(("z", "named"), [(6.9, False), (9.0, True)])
def test_tilt_at_a_movement_is_no_lost_count(z: float, named: bool) -> None:
    """A step counts where it is `SURE` times what the beams part by there."""
    step = replace(_step(z * 0.5, 0.5), at_rest=False)
    assert (_told(_with_steps({1: (step,)})) is not None) == named


def test_where_tilt_leaks_into_the_drift_a_step_at_a_movement_tells_nothing() -> None:
    """At rest it is a lost count all the same."""
    for at_rest in (True, False):
        view = _with_steps({1: (replace(_step(), at_rest=at_rest),)})
        noise = Stage(view).levels.rms
        assert (lost_count(view, noise, tilting=True) is not None) == at_rest
        assert lost_count(view, noise) is not None


def test_beams_that_differ_by_less_than_their_last_digit_lose_no_count() -> None:
    """Recorded so coarsely that they part by nothing, they step by one digit now and then."""
    steps = tuple(_step(0.5, 1e-11, 600.0 * k, 1 + k % 3) for k in range(1, 30))
    assert _told(_with_steps({1: steps})) is None


def test_steps_behind_the_last_row_that_is_used_are_none() -> None:
    """A larger step of another beam, in rows that cleaning left out afterwards, is told by nobody."""
    found = _told(_with_steps({1: (_step(), _step(30.0, 0.03, 1e6, 3))}))
    assert found is not None
    assert found.effect.target == "beam1"
    assert "also" not in found.effect.settings


def test_steps_of_several_beams_are_told_together() -> None:
    """The largest is the target, the others are listed, and what would be visible is that of all."""
    view = _with_steps({1: (_step(3.0, beam=2),), 2: (_step(2.0, beam=1),)})
    both, one = _told(view), _told(_with_steps({1: (_step(3.0, beam=2),)}))
    assert both is not None
    assert one is not None
    assert both.effect.target == one.effect.target == "beam2"
    assert both.effect.settings["also"] == f"beam1 in {view.runs[2].run.name}"
    assert both.effect.visible > one.effect.visible
    assert "alone" not in both.effect.sentence
    assert "beam2 alone lost count" in one.effect.sentence


def test_what_is_left_of_a_step_is_no_second_one() -> None:
    """A jump that the residual shows in the same run at the same time is what taking back left; elsewhere it is not."""
    view = _with_steps({1: (_step(),)})
    run = view.runs[1].run.name
    assert _told(view, [(run, 9100.0)]) is None
    assert _told(view, [(run, 15000.0)]) is not None
    assert _told(view, [(view.runs[2].run.name, 9000.0)]) is not None


def test_where_all_runs_count_from_one_zero_nothing_is_said() -> None:
    """What was taken back in one run stays in those after it."""
    assert _told(_with_steps({1: (_step(),)})) is not None
    assert _told(_with_steps({1: (_step(),)}, zero="campaign")) is None
