"""An answer that took minutes is told although its files cannot be written, and repairs say whose they are."""

from __future__ import annotations

import errno
import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

import hexathermal as ht
from hexathermal.cli import main
from hexathermal.learn import diagnosis
from hexathermal.learn.leg_law_files import write_leg_law
from hexathermal.machine.leg_repairs import SensorRepair
from hexathermal.show import diagnosis_report
from hexathermal.show.diagnosis_album import file_names
from hexathermal.show.diagnosis_words import verdict_words
from tests.learn.campaign_folders import leg_campaign
from tests.show.drawn_diagnoses import CANDIDATES, drawn


def full(*_arguments: Any, **_named: Any) -> None:
    """What writing to a full disk says."""
    raise OSError(errno.ENOSPC, "No space left on device")


def test_a_full_disk_keeps_no_finding_back(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """The finding and its JSON are whole, stderr says which place is full, nothing is left there, and the code is 1."""
    campaign = leg_campaign(tmp_path / "campaign")
    monkeypatch.setattr(diagnosis, "diagnose", lambda *_given, **_named: drawn())
    monkeypatch.setattr(diagnosis_report, "write_report", full)
    numbers, law = tmp_path / "numbers.json", tmp_path / "extended.toml"
    words = ["diagnose", str(campaign), "--report", str(tmp_path / "report"), "--json", str(numbers)]
    assert main([*words, "--extend", str(law)]) == 1
    said = capsys.readouterr()
    assert said.out.startswith(drawn().sentence)
    assert f"cannot write {tmp_path / 'report'}: No space left on device" in said.err
    assert json.loads(numbers.read_text())["written"] == [str(law)]
    assert not (tmp_path / "report").exists()


def test_repairs_of_another_campaign_are_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A law that puts the data of one campaign right says so before it changes those of another."""
    campaign = leg_campaign(tmp_path / "campaign")
    assert main(["identify", str(campaign), "--out", str(tmp_path / "leg.toml")]) == 0
    own = ht.read_leg_law(tmp_path / "leg.toml")
    repair = SensorRepair("clock-offset", "clock", {"offset_s": 5.0})
    for mark, told in ((own.origin.fingerprint, False), ("0" * 64, True)):
        law = replace(own, repairs=(repair,), origin=replace(own.origin, fingerprint=mark))
        file = write_leg_law(law, tmp_path / f"law-{mark[:4]}.toml")
        capsys.readouterr()
        main(["validate", str(file), str(campaign)])
        assert ("puts data right for faults of the campaign" in capsys.readouterr().err) == told


def test_what_stands_above_chance_without_a_name_is_no_noise() -> None:
    """A verdict of none says "to their noise" only where no candidate stands above chance."""
    nothing = replace(drawn(), verdict="none", effects=(), candidates=())
    assert "to their noise" in nothing.sentence
    assert verdict_words(nothing) == "nothing stands above the noise"
    above = replace(nothing, candidates=tuple(replace(one, evidence=40.0) for one in CANDIDATES))
    assert above.unnamed
    assert "as far as its thermometers can be trusted" in above.sentence
    assert verdict_words(above) == "nothing can be named"


def test_pictures_of_runs_are_named_once() -> None:
    """A run that is called run-01 has a picture run-01, another one run-NAME."""
    assert file_names(["run-01", "day 2"]) == ["run-01", "run-day_2"]


@pytest.mark.parametrize(
    ("words", "writer"),
    [
        (["check", "CAMPAIGN", "--plots", "PLACE"], "hexathermal.show.figures.save_figure"),
        (["check", "CAMPAIGN", "--netcdf", "PLACE.nc"], "hexathermal.learn.campaign_dataset.save_campaign_netcdf"),
        (["identify", "CAMPAIGN", "--report", "PLACE"], "hexathermal.show.identification_tables.ranking_csv"),
        (["identify", "CAMPAIGN", "--out", "PLACE.toml"], "hexathermal.learn.leg_law_files.write_leg_law"),
        (["validate", "LAW", "CAMPAIGN", "--report", "PLACE"], "hexathermal.show.identification_figures.save_both"),
    ],
)
def test_no_command_keeps_its_answer_back(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], words: list[str], writer: str
) -> None:
    """The answer is told and its JSON written although files that were asked for cannot be; the code is 1."""
    campaign, law, place = leg_campaign(tmp_path / "campaign"), tmp_path / "leg.toml", tmp_path / "place"
    assert main(["identify", str(campaign), "--out", str(law)]) == 0
    told = {"CAMPAIGN": str(campaign), "LAW": str(law)}
    said = [told.get(word, word.replace("PLACE", str(place))) for word in words]
    plain, numbers = said[: len(said) - 2], tmp_path / "numbers.json"
    capsys.readouterr()
    assert main(plain) == 0
    whole = capsys.readouterr().out
    monkeypatch.setattr(writer, full)
    assert main([*said, "--json", str(numbers)]) == 1
    out, err = capsys.readouterr()
    assert out == whole
    assert f"cannot write {said[-1]}: No space left on device; make room, or give another place" in err
    assert json.loads(numbers.read_text())["written"] == []
    assert not list(tmp_path.glob("place*"))


def test_an_answer_whose_json_finds_no_room_is_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """The table stands on stdout, stderr names the file, the code is 1."""
    monkeypatch.setattr(Path, "write_bytes", full)
    assert main(["machines", "--json", str(tmp_path / "machines.json")]) == 1
    out, err = capsys.readouterr()
    assert "rubin-m2" in out
    assert err == (f"error: No space left on device: {tmp_path / 'machines.json'}; make room, or give another place\n")
    assert not list(tmp_path.iterdir())


def test_a_full_disk_is_told_with_the_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """A command whose answer is what it writes says where there was no room, and leaves nothing."""
    monkeypatch.setattr("hexathermal.simulate.campaign_writing.write_table", full)
    assert main(["simulate", "bench", "--out", str(tmp_path / "campaign")]) == 1
    assert capsys.readouterr().err.endswith(
        f"error: No space left on device: {tmp_path / 'campaign'}; make room, or give another place\n"
    )
    assert not list(tmp_path.iterdir())


@pytest.mark.long
def test_a_page_that_finds_no_room_is_not_told_as_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """`report` tells its finding, nothing of a page; its JSON has the exit code and no file; one that is whole does."""
    campaign, page = leg_campaign(tmp_path / "campaign"), tmp_path / "page.html"
    words = ["report", str(campaign), "--out", str(page)]
    assert main(words) == 0
    assert f"Written:\n  {page}" in capsys.readouterr().out
    assert main([*words, "--force", "--json", "-"]) == 0
    assert json.loads(capsys.readouterr().out)["written"] == [str(page)]
    page.unlink()
    monkeypatch.setattr(Path, "write_bytes", full)
    assert main(words) == 1
    assert "Written" not in capsys.readouterr().out
    assert main([*words, "--json", "-"]) == 1
    told = json.loads(capsys.readouterr().out)
    assert (told["exit_code"], told["written"]) == (1, [])
    assert not page.exists()


def test_a_law_that_is_not_written_is_not_warned_of(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Where nothing joined and nothing could be written there is no file that holds it."""
    campaign, law = leg_campaign(tmp_path / "campaign"), tmp_path / "extended.toml"
    monkeypatch.setattr(diagnosis, "diagnose", lambda *_given, **_named: drawn())
    monkeypatch.setattr("hexathermal.show.diagnosis_words.changed", lambda _found: False)
    assert main(["diagnose", str(campaign), "--extend", str(law)]) == 0
    assert f"{law} holds it" in capsys.readouterr().err
    law.unlink()
    monkeypatch.setattr("hexathermal.learn.leg_law_files.write_leg_law", full)
    assert main(["diagnose", str(campaign), "--extend", str(law)]) == 1
    assert "holds it" not in capsys.readouterr().err
