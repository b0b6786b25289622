"""Axes that are measured where they stand are diagnosed beside ``C dT + D q dT``, other parts beside ``C dT``."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from hexathermal.learn.campaign_files import load_campaign
from hexathermal.learn.campaign_laws import identify_campaign, validate_campaign
from hexathermal.learn.diagnosis import diagnose
from hexathermal.learn.diagnosis.law_form import ALONG, grows_along
from hexathermal.learn.diagnosis.result import Quantity
from hexathermal.learn.diagnosis.stage import Stage
from hexathermal.learn.diagnosis.words import of_part
from hexathermal.learn.leg_law_files import read_leg_law, write_leg_law
from hexathermal.show.diagnosis_words import parameter
from hexathermal.simulate.hidden.drawing import campaign_of
from hexathermal.simulate.hidden.writing import write_campaign
from tests.learn.diagnosis.campaigns import viewed

AXIS, FIXED = "held_out_axis", "held_out_actuator"


def written(folder: Path, cause: str, seed: int, strength: float = 1.2) -> tuple[str, ...]:
    """Write a campaign of an axis; returns the law's sensors."""
    truth, answer = campaign_of(AXIS, seed, causes=(cause,) if cause else (), strength=strength)
    write_campaign(folder, truth, answer)
    return answer.base


@pytest.mark.long
@pytest.mark.parametrize("cause", ["", "backlash", "scale-error", "creep"])
@pytest.mark.parametrize("seed", [3, 77])
def test_the_form_of_a_law_is_known_beside_what_is_hidden(cause: str, seed: int) -> None:
    """Axes grow with their stroke, whatever else goes with the place; a screw of fixed length does not."""
    hidden = (cause,) if cause else ()
    assert grows_along(viewed(AXIS, seed, hidden, 1.2)[0])
    assert not grows_along(viewed(FIXED, seed, hidden, 1.2)[0])


def test_an_error_of_the_scale_is_no_stroke_because_of_what_stands_beside() -> None:
    """In a part that warms up a strong one would be taken for D, were there no powers of the displacement."""
    view = viewed(FIXED, 77, ("scale-error",), 2.0)[0]
    said = []
    for placed in (False, True):
        base = Stage(replace(view, placed=placed)).base
        said.append(view.channel.fitted(base.X, base.sd)[1])
    assert said[1] > said[0] + ALONG
    assert not grows_along(view)


@pytest.mark.long
def test_an_effect_is_named_beside_it_and_pays(tmp_path: Path) -> None:
    """Backlash of an axis, whose search of laws on runs left out is not sure of D, has its name; the law reads q."""
    base = written(tmp_path / "axis", "backlash", 77)
    campaign = load_campaign(tmp_path / "axis")
    plain = identify_campaign(campaign, base, along=False).law
    found = diagnose(campaign, base, law=plain)
    assert [one.cause for one in found.effects] == ["backlash"]
    assert "the part stops in another place" in found.effects[0].sentence
    assert found.law.stroked
    assert any("these data speak for C dT + D q dT" in note for note in found.notes)
    assert found.gain is not None
    assert found.gain.total.rmse_gain.value > 0.1
    law = read_leg_law(write_leg_law(found.extended, tmp_path / "law.toml"))
    assert np.array_equal(law.coefficients, found.extended.coefficients)
    assert validate_campaign(law, campaign).total.rmse.value == pytest.approx(found.gain.total.rmse_after.value)


@pytest.mark.long
def test_a_sound_axis_has_nothing(tmp_path: Path) -> None:
    """Nothing is hidden, nothing is named; beside ``C dT`` it would be something that follows place and warmth."""
    base = written(tmp_path / "axis", "", 12)
    found = diagnose(load_campaign(tmp_path / "axis"), base)
    assert (found.verdict, found.law.stroked) == ("none", True)


def test_coefficients_have_the_units_of_what_they_multiply() -> None:
    """Of a part a length for a kelvin, of what multiplies its displacement a strain for a kelvin."""
    assert of_part("A_per_K", "1/K", 1.0) == ("um/K", 1e6)
    assert of_part("B_per_K", "1/K", 1.0) == ("1/K", 1.0)
    assert of_part("amplitude", "1 per (m/s)^2", 1.0) == ("m per (m/s)^2", 1.0)
    assert parameter("B_per_K", Quantity(1e-5, 1e-6, "1/K"), "component").unit == "um/m/K"
    assert parameter("coefficient_per_K", Quantity(1e-5, 1e-6, "1/K"), "component").unit == "um/K"


def test_a_part_without_a_stroke_is_not_asked() -> None:
    """What stands still has one coefficient a sensor, whatever its drift does."""
    view = viewed(AXIS, 3, (), 1.0)[0]
    still = tuple(
        replace(rows, signals=replace(rows.signals, q=np.full(len(rows.signals.time), 0.1))) for rows in view.runs
    )
    assert not grows_along(replace(view, runs=still))
