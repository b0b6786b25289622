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
