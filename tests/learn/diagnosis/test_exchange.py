"""The first of two names is asked again beside the second; and exchanged plugs, of all runs and of later ones."""

from __future__ import annotations

from pathlib import Path

import pytest

from hexathermal.learn.diagnosis import course
from hexathermal.learn.diagnosis.channels import Levels
from hexathermal.learn.diagnosis.course import Course
from hexathermal.learn.diagnosis.evidence import Scored
from hexathermal.learn.diagnosis.search import MENDED, Search
from hexathermal.learn.diagnosis.stage import Stage
from hexathermal.learn.diagnosis.trials import Trial
from tests.learn.diagnosis.campaigns import course_of, viewed

PAIRS = [(2033, ("clock-offset", "abbe-tilt"))]


def diagnosed(folder: Path, seed: int, causes: tuple[str, ...]) -> Course:
    """The course of a diagnosis of two effects of a little more than the noise."""
    return course_of(folder, "finite_volume", seed, causes, 1.1)


@pytest.mark.long
@pytest.mark.parametrize(("seed", "causes"), PAIRS)
def test_a_first_name_that_the_second_effect_feigned_is_exchanged(
    tmp_path: Path, seed: int, causes: tuple[str, ...]
) -> None:
    """Two effects together looked like a third cause: beside the second name the right first one leads, and both stand
    alone at the end.
    """
    found = diagnosed(tmp_path / "campaign", seed, causes)
    assert {one.ranked.cause for one in found.found} == set(causes)
    assert all(one.joined for one in found.found)


@pytest.mark.long
def test_without_the_exchange_the_first_name_stays(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Forward steps alone keep the wrong one."""
    monkeypatch.setattr(course, "rival_beside", lambda *_arguments: None)
    seed, causes = PAIRS[0]
    found = diagnosed(tmp_path / "campaign", seed, causes)
    assert found.found[0].ranked.cause not in causes


@pytest.mark.long
@pytest.mark.parametrize(("bench", "seed"), [("rough", 42), ("quiet", 43)])
def test_plugs_exchanged_for_all_runs_are_looked_at_beside_later_exchanges(
    monkeypatch: pytest.MonkeyPatch, bench: str, seed: int
) -> None:
    """Before data are mended exchanges of the last run alone fit best, since they change little: they take no place of
    one of the whole campaign, nor does one that the order along the leg denies.
    """
    mended: list[Trial] = []
    once = Search._on_mended

    def counted(search: Search, item: Scored, levels: Levels, null: float) -> Scored:
        mended.append(item.trial)
        return once(search, item, levels, null)

    monkeypatch.setattr(Search, "_on_mended", counted)
    stage = Stage(viewed(bench, seed, ("swapped-sensors",), 0.8)[0])
    leader = next(item for item in stage.step.ranking if item.cause == "swapped-sensors")
    asked = [trial for trial in mended if trial.cause == "swapped-sensors"]
    assert all(trial.most > 0.0 for trial in asked)
    exchanges = [trial for trial in stage.search.trials if trial.cause == "swapped-sensors" and trial.most > 0.0]
    allowed = [trial for trial in exchanges if "from_run" not in trial.parameters]
    whole = {id(trial) for trial in asked if "from_run" not in trial.parameters}
    assert len(whole) == min(MENDED, len(allowed))
    assert "from_run" not in leader.best.trial.parameters
