"""A step of the zero in a run for validation, which no search sees, is told; what only looks like one is not."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest

from hexathermal.learn.campaign_files import load_campaign
from hexathermal.learn.campaign_laws import identify_campaign
from hexathermal.learn.cleaning_record import BeamStep
from hexathermal.learn.diagnosis import diagnose
from hexathermal.learn.diagnosis.judged_steps import SURE, JudgedStep, judged_steps, told_steps
from hexathermal.learn.diagnosis.result import ALSO
from hexathermal.learn.diagnosis.stage import Stage, view_of
from hexathermal.learn.diagnosis.view import View
from hexathermal.learn.law import IdentifiedLaw
from hexathermal.learn.signals import RunRows, campaign_rows
from hexathermal.poses import FloatArray
from hexathermal.simulate.hidden.drawing import campaign_of
from hexathermal.simulate.hidden.writing import write_campaign
from tests.learn.diagnosis.campaigns import rewritten
from tests.learn.shared_draws import fresh_entropy

THRESHOLD = 6.0


@cache
def sound(bench: str, seed: int) -> tuple[View, IdentifiedLaw, tuple[RunRows, ...]]:
    """All runs of a campaign in which nothing is hidden, its law, and its runs for validation."""
    truth, answer = campaign_of(bench, seed, causes=(), shared=True)
    with TemporaryDirectory() as place:
        write_campaign(Path(place) / "campaign", truth, answer)
        campaign = load_campaign(Path(place) / "campaign")
        rows, held = campaign_rows(campaign, "identification"), campaign_rows(campaign, "validation")
        law = identify_campaign(campaign, answer.base).law
        return view_of(campaign, (*rows, *held), answer.base), law, tuple(held)


def steps_with(bench: str, seed: int, run: int, shape: Callable[[FloatArray], FloatArray]) -> list[JudgedStep]:
    """What is told where a run for validation has something more in it, from its time [s] to noises of the drift."""
    view, law, held = sound(bench, seed)
    time, noise = held[run].signals.time, Stage(view).levels.rms
    changed = replace(held[run], drift=held[run].drift + noise * shape(time))
    return judged_steps(view, law, [*held[:run], changed, *held[run + 1 :]], THRESHOLD)


@pytest.mark.long
@pytest.mark.parametrize("bench", ["quiet", "held_out"])
@pytest.mark.parametrize("run", [0, 1])
def test_a_step_is_found_in_its_run_at_its_time(bench: str, run: int) -> None:
    """A step of four times the noise, a ramp of two minutes: within three standard uncertainties and a window."""
    view, _law, held = sound(bench, 5)
    moment = 0.55 * held[run].signals.time[-1]
    found = steps_with(bench, 5, run, lambda time: 4.0 * np.clip((time - moment) / 120.0, 0.0, 1.0))
    assert [one.run for one in found] == [held[run].run.name]
    assert found[0].evidence >= SURE
    assert found[0].time == pytest.approx(moment, abs=450.0)
    assert abs(found[0].size - 4.0 * Stage(view).levels.rms) < 3.0 * found[0].error + 0.2 * found[0].size


KINK = "follows the temperature beyond a kink"


@pytest.mark.long
def test_what_has_no_name_is_no_step_of_a_run_for_validation(tmp_path: Path) -> None:
    """A kink without a name, which a run for validation passes at once, is told as a kink; beside it no jump stands."""
    truth, answer = campaign_of("held_out_axis", 5441576012203089, shared=True)
    write_campaign(tmp_path / "campaign", truth, answer)
    found = diagnose(load_campaign(tmp_path / "campaign"), answer.base)
    assert (found.verdict, found.follows, found.effects) == ("unexplained", KINK, ())


@pytest.mark.long
def test_a_step_stands_beside_what_has_no_name() -> None:
    """A step that all forms of a kink do not make is told where a kink was left, at the same time."""
    view, law, held = sound("quiet", 5)
    time, noise = held[0].signals.time, Stage(view).levels.rms
    changed = replace(held[0], drift=held[0].drift + 6.0 * noise * (time >= 0.55 * time[-1]))
    alone, beside = (judged_steps(view, law, [changed, *held[1:]], THRESHOLD, left) for left in (None, KINK))
    assert [(one.run, one.time) for one in beside] == [(one.run, one.time) for one in alone] != []


def test_what_cleaning_took_back_is_no_jump_of_the_zero() -> None:
    """A step where cleaning mended a beam is what that left; at another time of the run it is one."""
    view, law, held = sound("quiet", 5)
    time, noise = held[0].signals.time, Stage(view).levels.rms
    moment = float(time[len(time) // 2])
    for apart, told in ((60.0, 0), (4000.0, 1)):
        back = BeamStep("beam2_mm", moment - float(time[0]) - apart, 1e-5, 1e-7, False)
        record = replace(held[0].record, beam_steps=(back,))
        changed = replace(held[0], drift=held[0].drift + 5.0 * noise * (time >= moment), record=record)
        assert len(judged_steps(view, law, [changed, *held[1:]], THRESHOLD)) == told


def test_two_runs_may_have_one_each() -> None:
    """Both are told, the surer one first."""
    view, law, held = sound("quiet", 5)
    noise = Stage(view).levels.rms
    high = [5.0, -4.0]
    changed = [replace(rows, drift=rows.drift + noise * size * (rows.signals.time > 0.5 * rows.signals.time[-1]))
               for rows, size in zip(held, high, strict=False)]  # fmt: skip
    found = judged_steps(view, law, [*changed, *held[2:]], THRESHOLD)
    assert {one.run for one in found} == {rows.run.name for rows in held[:2]}
    assert [one.evidence for one in found] == sorted((one.evidence for one in found), reverse=True)


@pytest.mark.parametrize(
    "shape",
    [lambda time: 6.0 * time / time[-1], lambda time: 6.0 * np.sin(2.0 * np.pi * time / time[-1]),
     lambda time: 6.0 * (time > 0.5 * time[-1]) * np.exp(-np.maximum(time - 0.5 * time[-1], 0.0) / 1200.0)],
    ids=["slope", "rhythm", "shock that relaxes"],
)  # fmt: skip
def test_what_wanders_bends_or_relaxes_is_no_step(shape: Callable[[FloatArray], FloatArray]) -> None:
    """A run that drifts, goes up and down, or is struck and comes back is not one in which the zero jumps."""
    assert steps_with("quiet", 5, 0, shape) == []


@pytest.mark.long
def test_sound_campaigns_have_none() -> None:
    """Of campaigns of three benches in which nothing is hidden hardly one has a step where it is judged."""
    rng = np.random.default_rng(seed := fresh_entropy())
    benches = ["quiet", "held_out", "rough"]
    drawn = [(bench, int(rng.integers(2**53))) for bench in benches for _draw in range(3)]
    told = [key for key in drawn if judged_steps(*sound(*key), THRESHOLD)]
    assert len(told) <= 1, (seed, told)


@pytest.mark.parametrize("tau", [300.0, 900.0, 1800.0])
@pytest.mark.parametrize("size", [4.0, 12.0])
def test_a_jolt_that_fades_is_no_step(tau: float, size: float) -> None:
    """What comes back within minutes is none, however clear; a step in another run beside it is found still."""
    view, law, held = sound("quiet", 5)
    time, noise = held[0].signals.time, Stage(view).levels.rms
    moment = 0.4 * time[-1]
    shape = (time >= moment) * np.exp(-np.maximum(time - moment, 0.0) / tau)
    jolted = replace(held[0], drift=held[0].drift + size * noise * shape)
    assert judged_steps(view, law, [jolted, *held[1:]], THRESHOLD) == []
    late = held[1].signals.time
    ramp = np.clip((late - 0.55 * late[-1]) / 120.0, 0.0, 1.0)
    stepped = replace(held[1], drift=held[1].drift + 12.0 * noise * ramp)
    found = judged_steps(view, law, [jolted, stepped, *held[2:]], THRESHOLD)
    assert [one.run for one in found] == [held[1].run.name]


def test_runs_that_a_step_is_told_of_besides_are_told_once() -> None:
    """Of steps in two runs the second is told with the first, and is nothing new."""
    view, _law, held = sound("quiet", 5)
    names = [rows.run.name for rows in held[:2]]
    steps = [JudgedStep(name, 3600.0, size, 1e-8, 50.0) for name, size in zip(names, (1e-6, 2e-6), strict=True)]
    told = told_steps(steps, view)
    assert told is not None
    assert str(told.effect.settings["also"]).split(ALSO) == names[:1]


def test_where_all_runs_count_from_one_zero_nothing_is_said() -> None:
    """There a step in one run stays in those after it."""
    view, law, held = sound("quiet", 5)
    assert judged_steps(replace(view, zeroed_by_run=False), law, held, THRESHOLD) == []


@pytest.mark.long
def test_the_diagnosis_names_it_and_no_law_holds_it(tmp_path: Path) -> None:
    """From the files on: verdict, run, moment and size; the law stays as it was."""
    truth, answer = campaign_of("quiet", 8, causes=())
    write_campaign(tmp_path / "campaign", truth, answer)
    run = load_campaign(tmp_path / "campaign").runs_of("validation")[0]

    def stepped(rows: list[dict[str, str]]) -> None:
        """2 um in all beams from the middle on, 90 s long, so that no row is a step that cleaning takes back."""
        middle = float(rows[len(rows) // 2]["time_s"])
        for row in rows:
            higher = 2e-3 * min(max((float(row["time_s"]) - middle) / 90.0, 0.0), 1.0)
            row.update({name: repr(float(value) + higher) for name, value in row.items() if name.startswith("beam")})

    rewritten(run.path, stepped)
    found = diagnose(load_campaign(tmp_path / "campaign"), answer.base)
    assert [(one.cause, one.target) for one in found.effects] == [("zero-jump", run.name)]
    effect = found.effects[0]
    assert effect.of_judged_run
    assert not effect.joined
    assert abs(effect.parameters["step_um"].value - 2.0) < 3.0 * effect.parameters["step_um"].std + 0.1
    assert found.extended is found.law
    document = json.loads(json.dumps(found.to_json()))
    assert (document["cause"], document["verdict"]) == ("zero-jump", "effect")
    assert "In a run for validation the zero jumps" in document["sentence"]
