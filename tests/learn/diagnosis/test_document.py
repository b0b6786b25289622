"""The JSON of a diagnosis, made from a campaign's folder, is that of the format; and a diagnosis repeats."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from hexathermal.errors import ArgumentError, UnknownNameError
from hexathermal.learn.campaign_files import load_campaign
from hexathermal.learn.diagnosis import Diagnosis, diagnose
from hexathermal.learn.diagnosis.causes import catalogue
from hexathermal.learn.diagnosis.evidence import LEAST
from hexathermal.simulate.hidden.drawing import campaign_of
from hexathermal.simulate.hidden.writing import write_campaign

SEED, CAUSE = 8, "backlash"


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A quiet leg with a backlash that nobody could miss."""
    place = tmp_path_factory.mktemp("diagnosis") / "campaign"
    truth, answer = campaign_of("quiet", SEED, causes=(CAUSE,), strength=3.0)
    write_campaign(place, truth, answer)
    return place


@pytest.fixture(scope="module")
def diagnosis(folder: Path) -> Diagnosis:
    base = json.loads(folder.with_name("campaign.answer.json").read_text(encoding="utf-8"))["base"]
    return diagnose(load_campaign(folder), base)


@pytest.fixture(scope="module")
def document(diagnosis: Diagnosis) -> dict[str, Any]:
    found: dict[str, Any] = json.loads(json.dumps(diagnosis.to_json(), allow_nan=False))
    return found


def test_the_document_has_the_keys_of_the_format(document: dict[str, Any]) -> None:
    """Every key of the format is there, with a value of its kind."""
    assert document["format"] == "hexathermal-diagnosis/1"
    assert document["verdict"] in ("effect", "none", "unexplained")
    assert document["cause"] in catalogue()
    assert document["target"] is None or isinstance(document["target"], str)
    assert set(document["equivalent"]) <= set(catalogue())
    assert 0.0 <= document["probability"] <= 1.0
    assert isinstance(document["next_experiment"], str)
    for one in document["parameters"].values():
        assert set(one) == {"value", "std", "unit"}
        assert one["std"] is None or one["std"] >= 0.0
    assert {"rmse_before_um", "rmse_after_um", "linf_before_um", "linf_after_um"} <= set(document["gain"])


def test_what_is_hidden_is_named_and_sized(document: dict[str, Any]) -> None:
    """A backlash three times the noise is the cause, its step is given in micrometres, and knowing it pays."""
    assert (document["verdict"], document["cause"]) == ("effect", CAUSE)
    step = document["parameters"]["step_um"]
    assert step["unit"] == "um"
    assert abs(step["value"]) > 5.0 * step["std"] > 0.0
    assert document["gain"]["rmse_after_um"] < 0.8 * document["gain"]["rmse_before_um"]
    assert CAUSE in document["sentence"]


def test_candidates_are_ranked(document: dict[str, Any]) -> None:
    """What was named leads; behind it evidence falls, and each candidate has evidence and probability."""
    candidates = document["candidates"]
    assert candidates[0]["cause"] == CAUSE
    evidence = [one["evidence"] for one in candidates[len(document["effects"]) :]]
    assert evidence == sorted(evidence, reverse=True)
    assert all(0.0 <= one["probability"] <= 1.0 for one in candidates)


def test_limits_are_those_of_causes_and_above_nothing(document: dict[str, Any]) -> None:
    """Each cause that these data can show has a limit in micrometres between a thousandth and a hundred noises."""
    limits, noise = document["detection_limits_um"], document["noise_um"]
    size = np.hypot(np.hypot(noise["white"], noise["landing"]), noise["slow"])
    assert set(limits) <= set(catalogue())
    assert len(limits) >= 12
    assert all(1e-3 * size < value < 100.0 * size for value in limits.values())
    assert document["threshold"] >= LEAST


@pytest.mark.long
def test_a_diagnosis_repeats(folder: Path, document: dict[str, Any]) -> None:
    """The same folder gives the same document, to the last digit: nothing in it is drawn anew."""
    again = diagnose(load_campaign(folder), document["sensors"]).to_json()
    assert json.loads(json.dumps(again)) == document


def test_too_little_data_is_said(folder: Path, tmp_path: Path) -> None:
    """One run of a campaign is too little: it says what it has, what it needs, and what to do."""
    from dataclasses import replace

    campaign = load_campaign(folder)
    runs = campaign.runs_of("identification")[:1]
    with pytest.raises(ArgumentError, match=r"too little data.*it needs.*measure more"):
        diagnose(replace(campaign, runs=tuple(runs)), campaign.sensors[:1])


def test_an_unknown_sensor_is_said(folder: Path) -> None:
    """A sensor that the campaign does not have is an error that names those it has."""
    campaign = load_campaign(folder)
    with pytest.raises((UnknownNameError, ArgumentError)) as caught:
        diagnose(campaign, ["T99"])
    assert campaign.sensors[0] in str(caught.value)
