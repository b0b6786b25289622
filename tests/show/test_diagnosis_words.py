"""Words of a diagnosis: units of the workshop, honest digits, odds."""

from __future__ import annotations

import html
import math
import re
from collections import defaultdict
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hexathermal.learn.diagnosis.channels import Levels
from hexathermal.learn.diagnosis.result import Candidate, Experiment, Quantity
from hexathermal.learn.diagnosis.words import AMPLITUDES, STEPS, UNITS
from hexathermal.learn.validation_scores import Figure
from hexathermal.show.diagnosis_gain import gain_words
from hexathermal.show.diagnosis_sections import all_sections, opening
from hexathermal.show.diagnosis_tables import visible_words
from hexathermal.show.diagnosis_words import (
    ENDINGS,
    how_apart,
    noise_rows,
    parameter,
    rounded,
    sentences,
    settings_words,
    shared_words,
    span,
    unexplained_words,
)
from hexathermal.show.experiment_words import alike_words, odds, told_apart
from tests.show.drawn_diagnoses import BACKLASH, CANDIDATES, drawn

PICTURES: dict[str, str] = defaultdict(str)
"""No pictures."""


@given(st.floats(-1e3, 1e3), st.floats(1e-5, 1e3))
def test_rounding_costs_less_than_a_tenth_of_the_uncertainty(value: float, std: float) -> None:
    """What is shown is the value to a tenth of its uncertainty, and holds no more digits than that."""
    shown = rounded(value, std)
    assert abs(float(shown) - value) <= 0.1 * std
    digits = len(shown.partition(".")[2])
    assert 10.0**-digits > 0.009 * std or digits == 0


@given(st.floats(-50.0, 50.0))
def test_an_interval_holds_its_value_in_the_middle(value: float) -> None:
    """The 95 % interval spans 1.96 standard uncertainties on each side, to the digits shown."""
    low, high = map(float, span(value, 0.31).split(" to "))
    assert low == pytest.approx(value - 1.96 * 0.31, abs=0.0051)
    assert high == pytest.approx(value + 1.96 * 0.31, abs=0.0051)


@given(st.floats(1.0, 1e4), st.floats(0.01, 3.0))
def test_an_interval_of_what_is_above_zero_has_no_end_below_it(value: float, part: float) -> None:
    """A time constant's interval ends where that of the plain number does, and has no negative end."""
    shown = parameter("time_constant_s", Quantity(value, part * value, "s")).cells[2]
    factor = 1.0 if value < 120.0 else 60.0
    assert "-" not in shown
    assert shown.startswith("below ") == (part >= 1.0 / 1.96)
    assert float(shown.split()[-1]) == pytest.approx((1.0 + 1.96 * part) * value / factor, rel=0.06)
    assert parameter("offset_s", Quantity(1.0, 1.0, "s")).cells[2] == "-1.0 to 3.0"


@pytest.mark.parametrize(
    ("unit", "kind", "shown", "value"),
    [("1/K", "leg", "um/m/K", 2.0), ("1/K", "component", "um/K", 2.0), ("1/K^2", "leg", "um/m/K^2", 2.0),
     ("m", "leg", "mm", 2e-3), ("um", "leg", "um", 2e-6), ("1e-6", "leg", "um/m", 2e-6)],
)  # fmt: skip
def test_units_are_those_of_the_workshop(unit: str, kind: str, shown: str, value: float) -> None:
    """A coefficient of 2e-6 1/K is 2 um/m/K of a leg, and 2 um/K of a part without a length."""
    found = parameter("x", Quantity(2e-6, 1e-7, unit), kind)
    assert found.unit == shown
    assert found.value == pytest.approx(value)
    assert found.std == pytest.approx(0.05 * value)


def test_every_parameter_of_the_catalogue_is_named_without_its_unit() -> None:
    """No name on a page ends with a unit, and every unit is one that people read."""
    names = [(name, unit) for parts, unit, _ in AMPLITUDES.values() for name in parts]
    names += [(name, unit) for name, unit, _ in STEPS.values()] + list(UNITS.items())
    for name, unit in names:
        shown = parameter(name, Quantity(1.0, 0.1, unit))
        assert "_" not in shown.name
        assert not shown.name.endswith((" per", " K", " um", " mm", " ppm"))
        assert shown.unit not in ("1/K", "m", "1e-6", "1")
    assert any(name.endswith(ENDINGS) for name, _ in names)


@given(st.floats(-6.9, 6.9))
def test_odds_say_the_evidence_within_a_rounding(evidence: float) -> None:
    """Odds of a log evidence, read back, differ by less than a rounding to the next whole number or two digits."""
    left, right = map(float, odds(evidence).split(" to "))
    assert math.log(left / right) == pytest.approx(evidence, abs=0.41)
    assert (left >= right) == (evidence >= 0.0) or left == right


def test_more_evidence_never_reads_as_less_apart() -> None:
    """Not at all, barely, weakly: in this order."""
    assert [how_apart(value) for value in (0.0, 0.99, 1.0, 2.9, 3.0, 5.9)] == [
        "not at all", "not at all", "barely", "barely", "weakly", "weakly"
    ]  # fmt: skip


def test_a_setting_without_an_end_is_not_said() -> None:
    """1e9 runs stand for "never": nobody wants to read that; a sensor that is the target is not said twice."""
    assert settings_words({"decay_runs": 1e9, "sensor": "T07"}) == ""
    assert settings_words({"run": "a", "time_s": 4320.0, "kick": "move"}) == "in a, at 72 min, kick at each move"
    assert settings_words({"kick": "direction"}) == "kick at each move, with its sign"
    assert settings_words({"reference_index": 1.0002714}) == "reference index 1.000271"
    assert settings_words({"approach": 1.0}) == "direction of arrival at the first position of a run from below"
    assert settings_words({"fixed_again": 1}) == "fixed to the part again before the next run"
    for one in ("pressure", "temperature"):
        assert settings_words({"weather": one}) == f"index left out of the {one} alone"


def test_the_visible_part_is_as_uncertain_as_the_amplitude() -> None:
    """A step known to 3 % leaves a visible part known to 3 %."""
    from hexathermal.show.diagnosis_words import visible_std

    assert visible_std(BACKLASH) == pytest.approx(BACKLASH.visible * 0.01 / 0.31)


def test_a_free_fit_that_is_worse_is_not_said_to_reach_more() -> None:
    """What all channels give is a mark to reach only where it lies below what the extended law leaves."""
    better = drawn()
    assert "; a free fit of all channels reaches 0.090 um. " in gain_words(better)
    assert "; a free fit of all channels does no better: 0.150 um. " in gain_words(replace(better, reachable=0.15e-6))


def test_tiny_amounts_and_rates_are_said_in_units_that_people_read() -> None:
    """An amplitude for a squared input stands without powers of ten, a rate among settings with its unit."""
    shown = parameter("amplitude", Quantity(6.864e-13, 3.1e-14, "m per unit"), "component")
    assert (shown.cells, shown.unit) == (("0.686", "0.031", "0.626 to 0.747"), "pm per unit")
    assert parameter("amplitude", Quantity(2e-7, 1e-8, "m per unit"), "component").unit == "um per unit"
    assert parameter("amplitude", Quantity(2e-13, 1e-14, "m per rpm^2"), "component").unit == "pm per rpm^2"
    moved = parameter("amplitude", Quantity(9.1e-4, 7e-5, "m per m/s"))
    assert (moved.cells[0], moved.unit) == ("0.910", "um per mm/s")
    assert parameter("amplitude", Quantity(3.0, 0.1, "1 per (m/s)^2")).unit == "um/m per (mm/s)^2"
    assert settings_words({"rate_K_per_h": -0.01312, "width_K": 0.358}) == "rate -0.0131 K/h, width 0.358 K"


def test_a_loss_is_told_with_an_interval_of_losses() -> None:
    """8 % more comes with 27 % less to 59 % more, in the sign of the word; an interval of losses alone is proven."""
    found = drawn()
    assert found.gain is not None
    for ends, said in (
        ((-0.59, 0.27), "8.0 % more, 95 %: -27 to 59 %; not proven: the interval holds 0"),
        ((-0.59, -0.02), "8.0 % more, 95 %: 2.0 to 59 %; proven to be worse"),
    ):
        total = replace(found.gain.total, rmse_gain=Figure(-0.08, *ends))
        worse = replace(found, gain=replace(found.gain, total=total))
        assert said in gain_words(worse)
        assert said.partition(";")[0] in html.unescape(opening(worse)).replace("\xa0", " ")


def test_of_several_causes_the_later_ones_are_what_is_left() -> None:
    """The residual cannot be one cause and another: each sentence after the first tells of what those before left."""
    two = drawn(effects=(BACKLASH, replace(BACKLASH, cause="creep", sentence="The residual is creep: it creeps.")))
    assert sentences(two) == [BACKLASH.sentence, "What is then left is creep: it creeps."]
    assert two.sentence == " ".join(sentences(two))


def test_what_stands_above_chance_without_a_name_is_explained() -> None:
    """Where nothing is named, but evidence passes the dotted line, the page says why; else it says nothing of it."""
    above = drawn("none")
    (said,) = above.unnamed
    assert said.startswith("backlash; creep: these stand above chance, but are not named")
    page = words_of(all_sections(above, PICTURES))
    assert said in page
    assert "better than chance could" not in page
    assert said.removesuffix(".") in above.to_json()["notes"]
    below = drawn("none", candidates=(replace(CANDIDATES[0], evidence=5.9),))
    assert below.unnamed == ()
    assert "better than chance could" in words_of(all_sections(below, PICTURES))
    assert drawn().unnamed == ()


def test_a_size_whose_interval_holds_0_is_explained() -> None:
    """A cause that is sure with a size that is not: the law's own coefficients share it."""
    assert shared_words(BACKLASH) == []
    unsure = replace(BACKLASH, parameters={"step_um": Quantity(0.31, 0.3, "um"), "time_s": Quantity(50.0, 1.0, "s")})
    assert len(shared_words(unsure)) == 1


def test_the_visible_part_has_the_interval_of_the_json() -> None:
    """Where the ranking knows the uncertainty of what stays visible, the page tells it, not that of the last fit."""
    known = replace(CANDIDATES[0], spread=0.01e-6)
    assert visible_words(drawn(candidates=(known,)), 0) == "0.150 (0.130 to 0.170)"
    assert visible_words(drawn(), 0) == "0.1500 (0.1405 to 0.1595)"


def test_a_part_without_moves_has_no_noise_of_landings() -> None:
    """Where nothing moves nothing lands; where the campaign has one zero, a run's shift is not of its first row."""
    found = drawn(kind="component", noise=Levels(2e-8, 0.0, 3e-8, 1e-8))
    still = replace(found, law=replace(found.law, zero="campaign"),
                    residuals=tuple(replace(run, signals={}) for run in found.residuals))  # fmt: skip
    assert [name for name, *_ in noise_rows(still)] == ["white", "slow", "zero of a run"]
    assert "first row" not in noise_rows(still)[-1][2]
    assert [name for name, *_ in noise_rows(drawn())] == ["white", "landings", "slow", "zero of a run"]
    assert "first row" in noise_rows(drawn())[-1][2]


def words_of(sections: list[tuple[str, str, str]]) -> str:
    """Return the words of sections."""
    text = " ".join(re.sub(r"<[^>]+>", " ", body) for _name, _short, body in sections)
    return html.unescape(text).replace("\xa0", " ")


def test_a_gain_that_is_not_proven_is_told_beside_a_constant_in_each_run() -> None:
    """The noise of a first row shifts a whole run: what fell without it is told; nothing where the gain is proven."""
    found = drawn()
    assert found.gain is not None
    assert found.gain.proven
    assert "first row" not in gain_words(found)
    doubtful = replace(found.gain.total, rmse_gain=Figure(-0.1, -0.4, 0.2))
    unsure = replace(found, gain=replace(found.gain, total=doubtful))
    held = [one for one in found.residuals if one.role == "validation"]
    spreads = np.array([(one.before.std(), one.after.std()) for one in held])
    before, after = np.sqrt((spreads**2).mean(axis=0)) * 1e6
    said = gain_words(unsure)
    assert "The noise of its first row shifts a run as a whole" in said
    assert f"goes from {before:.3f} to {after:.3f} um, and falls in {len(held)} of {len(held)} runs." in said
    assert "first row" not in gain_words(replace(unsure, extended=unsure.law))
    shared = replace(unsure, law=replace(unsure.law, zero="campaign"))
    assert "first row" not in gain_words(shared)


@pytest.mark.parametrize(("count", "words"), [(1, "That is of one run;"), (2, "That is of 2 runs;"), (3, None)])
def test_few_judged_runs_are_told(count: int, words: str | None) -> None:
    """One or two runs for validation do not tell how much runs differ, whatever the interval in them."""
    found = drawn()
    assert found.gain is not None
    runs = {f"run-{k}": found.gain.total for k in range(count)}
    said = gain_words(replace(found, gain=replace(found.gain, runs=runs)))
    assert ("three or more tell how much runs differ" in said) == (words is not None)
    assert words is None or words in said


def test_rivals_of_a_name_are_told_with_their_probability_and_others_with_what_decides() -> None:
    """What data speak of has a number; what no data of a part tell apart has the measurement that does."""
    rivals = {"hidden-heat": 0.066}
    one = replace(BACKLASH, cause="missing-sensor", equivalent=("hidden-heat", "abbe-tilt"), rivals=rivals)
    said = alike_words(one, "component")
    assert "do not rule out hidden-heat (probability 0.066): an experiment must decide" in said
    assert "No data of this kind rule out abbe-tilt: one displacement does not tell a part's tilt" in said
    assert alike_words(replace(one, equivalent=()), "component").startswith("No other cause")
    held_back = alike_words(replace(one, rivals={"hidden-heat": 0.001}), "component")
    assert (
        "These data speak about as much for hidden-heat, but errors of the thermometers might feign that" in held_back
    )
    assert "0.001" not in held_back
    assert "rule out hidden-heat" not in held_back


def test_a_cause_alone_is_told_from_no_effect() -> None:
    """An experiment that shows one cause tells it from nothing; of two, which they are."""
    alone = Experiment("Warm one.", ("swapped-sensors", "swapped-sensors"), 9.0)
    assert told_apart(alone) == "swapped-sensors, no effect"
    assert told_apart(Experiment("Rest.", ("creep", "zero-drift"), 9.0)) == "creep, zero-drift"


@pytest.mark.parametrize(("evidence", "told"), [(349.5, True), (352.5, True), (300.0, False)])
def test_a_name_that_explains_as_much_as_what_has_none_is_told(evidence: float, told: bool) -> None:
    """A reader of "unexplained" learns of the cause that is not ruled out; far behind, it is no rival."""
    left = Candidate("follows the input field_uT", None, 352.2, 0.5, 1e-7, {})
    heat = Candidate("hidden-heat", "field_uT", evidence, 0.4, 1e-7, {})
    found = drawn("unexplained", candidates=(left, heat), follows=left.cause)
    words = unexplained_words(found)
    assert (f"hidden-heat (field_uT) explains about as much (log evidence {evidence}, against 352.2)" in words) is told
    assert found.possible == (("hidden-heat",) if told else ())
    assert ("(hidden-heat not ruled out)" in found.finding) is told
