"""A law that is given brings its sensors; what its coefficients leave is told apart from what a cause gains."""

from __future__ import annotations

import json
from dataclasses import replace
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest

import hexathermal as ht
from hexathermal.cli import main
from hexathermal.learn.campaign import Campaign
from hexathermal.learn.campaign_files import load_campaign
from hexathermal.learn.diagnosis import Diagnosis, diagnose
from hexathermal.learn.leg_law_files import write_leg_law
from hexathermal.simulate.hidden.drawing import campaign_of
from hexathermal.simulate.hidden.writing import write_campaign

SEED = 6


def written(folder: Path, *causes: str) -> tuple[Campaign, tuple[str, ...]]:
    """A quiet leg with these causes, and the sensors of its law."""
    truth, answer = campaign_of("quiet", SEED, causes=causes, strength=1.5, shared=True)
    write_campaign(folder, truth, answer)
    return load_campaign(folder), answer.base


@cache
def by_names(*causes: str) -> Diagnosis:
    """The diagnosis of a campaign with these causes, by the names of the sensors."""
    with TemporaryDirectory() as place:
        return diagnose(*written(Path(place) / "campaign", *causes))


@cache
def told(times: float, *causes: str) -> tuple[Diagnosis, Diagnosis]:
    """Diagnoses by the names of the sensors, and by their law with coefficients so many times too large."""
    plain = by_names(*causes)
    with TemporaryDirectory() as place:
        campaign, _ = written(Path(place) / "campaign", *causes)
        return plain, diagnose(campaign, law=replace(plain.law, coefficients=times * plain.law.coefficients))


@pytest.mark.long
def test_a_wrong_law_is_not_said_to_explain_the_data() -> None:
    """Nothing is hidden, and the law is five times too large: that comes first, with both RMSEs."""
    plain, given = told(5.0)
    assert plain.verdict == given.verdict == "none"
    assert given.given is not None
    (words,) = given.given.words
    assert given.sentence.startswith(words)
    assert words.startswith("The coefficients of the law as it was given do not fit these data")
    assert "the law fitted anew explains these data" in given.sentence
    assert "the law explains these data" in plain.sentence
    facts = given.to_json()["given"]
    assert facts["rmse_um"] > 3.0 * facts["rmse_refitted_um"]
    assert facts["rmse_refitted_um"] == pytest.approx(plain.to_json()["gain"]["rmse_before_um"])
    low, high = facts["rmse_gain_95"]
    assert 0.0 < low <= facts["rmse_gain"] <= high


@pytest.mark.long
def test_what_the_coefficients_leave_is_no_cause_s_gain() -> None:
    """Backlash gains beside the law fitted anew what it gains without a law given; its sentence stays the first."""
    plain, given = told(5.0, "backlash")
    assert given.cause == plain.cause == "backlash"
    assert given.to_json()["gain"] == plain.to_json()["gain"]
    assert given.sentence.startswith(plain.sentence)
    assert given.given is not None
    assert given.sentence.endswith(given.given.words[0])
    assert np.array_equal(given.extended.coefficients, plain.extended.coefficients)


@pytest.mark.long
def test_of_the_campaign_s_own_law_nothing_is_said() -> None:
    """Coefficients that these runs have leave what they leave."""
    plain, given = told(1.0)
    assert given.given is not None
    assert given.given.words == ()
    assert given.sentence == plain.sentence


@pytest.mark.long
def test_the_command_writes_the_law_that_fits(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Nothing joined: the file holds what these runs say, and terminal, page and report tell of the law as given."""
    written(tmp_path / "campaign")
    plain = by_names()
    write_leg_law(replace(plain.law, coefficients=5.0 * plain.law.coefficients), tmp_path / "wrong.toml")
    options = {"law": "wrong.toml", "extend": "fit.toml", "report": "page", "json": "d.json"}
    words = [word for name, file in options.items() for word in (f"--{name}", str(tmp_path / file))]
    assert main(["diagnose", str(tmp_path / "campaign"), *words]) == 0
    shown = capsys.readouterr()
    assert shown.out.startswith("The coefficients of the law as it was given do not fit these data")
    assert "holds it without terms, fitted to these runs" in shown.err
    law = ht.read_leg_law(tmp_path / "fit.toml")
    assert law.coefficients == pytest.approx(plain.law.coefficients)
    facts = json.loads((tmp_path / "d.json").read_text())
    assert type(facts["exit_code"]) is int
    assert facts["exit_code"] == 0
    assert "as it was given do not fit these data" in (tmp_path / "page" / "report.html").read_text(encoding="utf-8")
    assert main(["report", str(tmp_path / "d.json"), "--out", str(tmp_path / "told.html")]) == 0
    assert "as it was given do not fit these data" in (tmp_path / "told.html").read_text(encoding="utf-8")
