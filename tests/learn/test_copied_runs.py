"""A run for validation that is a copy of a fitted one proves nothing, and everybody who judges by it says so."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest

from hexathermal.cli import main
from hexathermal.learn.campaign import Campaign
from hexathermal.learn.campaign_files import load_campaign
from hexathermal.learn.check import check_campaign
from hexathermal.learn.check_words import warnings_of
from hexathermal.learn.copied_runs import copied_runs, copy_words, twin_words, without_copies
from hexathermal.learn.diagnosis import diagnose
from hexathermal.simulate.hidden.drawing import campaign_of
from hexathermal.simulate.hidden.writing import write_campaign

from .campaign_folders import leg_campaign


def with_copy(folder: Path) -> Campaign:
    """Return a campaign of two runs in which the run for validation has the table of the one that is fitted."""
    campaign = load_campaign(leg_campaign(folder))
    fitted, held = (campaign.runs_of(role)[0] for role in ("identification", "validation"))
    shutil.copy(fitted.path, held.path)
    return campaign


def test_a_copy_is_found_and_left_out(tmp_path: Path) -> None:
    """Runs of one table are told by name, and the campaign without the copy has the other runs, in their order."""
    campaign = with_copy(tmp_path)
    fitted, held = (campaign.runs_of(role)[0].name for role in ("identification", "validation"))
    assert copied_runs(campaign) == {held: fitted}
    kept, said = without_copies(campaign)
    assert [run.name for run in kept.runs] == [run.name for run in campaign.runs if run.name != held]
    assert len(said) == 1
    assert held in said[0]
    assert copy_words(campaign)[held] in warnings_of(check_campaign(campaign))


def test_different_runs_stay(tmp_path: Path) -> None:
    """A campaign whose runs differ is handed on as it is, and nothing is said."""
    campaign = load_campaign(leg_campaign(tmp_path))
    assert copied_runs(campaign) == {}
    assert without_copies(campaign) == (campaign, [])


def test_the_first_run_stays(tmp_path: Path) -> None:
    """What all others count from is not taken away, but it is told of."""
    campaign = with_copy(tmp_path)
    turned = replace(campaign, runs=campaign.runs[::-1])
    kept, said = without_copies(turned)
    assert kept.runs == turned.runs
    assert said == list(copy_words(turned).values())


@pytest.mark.long
def test_no_gain_is_told_on_copies_alone() -> None:
    """A diagnosis whose every run for validation was fitted tells no gain, and says why."""
    truth, answer = campaign_of("modal", 1, causes=("backlash",), strength=1.0)
    with TemporaryDirectory() as place:
        write_campaign(Path(place) / "campaign", truth, answer)
        campaign = load_campaign(Path(place) / "campaign")
        fitted = campaign.runs_of("identification")[0]
        for held in campaign.runs_of("validation"):
            shutil.copy(fitted.path, held.path)
        found = diagnose(campaign, answer.base)
    assert found.gain is None
    assert sum("holds the same table as" in note for note in found.notes) == len(campaign.runs_of("validation"))
    assert sum("holds the same table as" in note for note in found.doubtful) == len(campaign.runs_of("validation"))


def test_fitted_twins_are_told_and_stay(tmp_path: Path) -> None:
    """A run that is fitted twice is told of by `check` and beside a diagnosis; which one to give up people decide."""
    campaign = load_campaign(leg_campaign(tmp_path))
    first, second = campaign.runs_of("identification")[:2]
    assert twin_words(campaign) == []
    shutil.copy(first.path, second.path)
    (said,) = twin_words(campaign)
    assert said.startswith(f"{second.name} holds the same table as {first.name}")
    assert said in warnings_of(check_campaign(campaign))
    assert without_copies(campaign) == (campaign, [said])


def test_identify_warns_of_twins(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Coefficients of runs that count twice look surer than they are: stderr says so."""
    folder = leg_campaign(tmp_path / "campaign")
    first, second = load_campaign(folder).runs_of("identification")[:2]
    shutil.copy(first.path, second.path)
    assert main(["identify", str(folder), "--sensors", "T01"]) == 0
    assert f"warning: {second.name} holds the same table as {first.name}" in capsys.readouterr().err


@pytest.mark.parametrize("role", ["identification", "validation"])
def test_a_campaign_of_one_role_has_no_copies(tmp_path: Path, role: str) -> None:
    """Twins of one role are no matter of proof."""
    campaign = with_copy(tmp_path)
    same = replace(campaign, runs=tuple(replace(run, role=role) for run in campaign.runs))
    assert copied_runs(same) == {}
