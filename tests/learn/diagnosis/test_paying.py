"""What runs never fitted speak against joins no law, and it is said; the rest of what was named does."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from hexathermal.learn.campaign_files import load_campaign
from hexathermal.learn.diagnosis import Diagnosis, diagnose
from hexathermal.learn.diagnosis.constants_beside import BesideConstants
from hexathermal.learn.diagnosis.paying import _without, loses
from hexathermal.learn.diagnosis.refused import Refused
from hexathermal.learn.diagnosis.trials import Trial
from hexathermal.learn.validation_gain import Gain, RunGain
from hexathermal.learn.validation_scores import Figure
from hexathermal.show.diagnosis_gain import gain_words
from hexathermal.simulate.hidden.drawing import campaign_of
from hexathermal.simulate.hidden.writing import write_campaign
from tests.learn.diagnosis.campaigns import rewritten

SCALE = 5e-6
"""Of the scale in runs for identification."""

LARGE = 4.0
"""Strength of what is hidden besides: more than the scale."""


@cache
def with_scale(judged: float, *hidden: str) -> Diagnosis:
    """What is said of a leg whose scale is wrong by `SCALE`, in runs for validation by that times a factor."""
    truth, answer = campaign_of("quiet", 5, causes=hidden, strength=LARGE if hidden else None, shared=True)
    with TemporaryDirectory() as place:
        folder = Path(place) / "campaign"
        write_campaign(folder, truth, answer)
        for run in load_campaign(folder).runs:
            size = SCALE * (judged if run.role == "validation" else 1.0)

            def stretched(rows: list[dict[str, str]], size: float = size) -> None:
                start = float(rows[0]["q_mm"])
                for row in rows:
                    for beam in ("beam1_mm", "beam2_mm", "beam3_mm"):
                        row[beam] = repr(float(row[beam]) + size * (float(row["q_mm"]) - start))

            rewritten(run.path, stretched)
        return diagnose(load_campaign(folder), answer.base)


@pytest.mark.long
def test_a_law_that_foretells_runs_worse_is_not_made() -> None:
    """A scale that errs the other way in runs for validation is named, and the law stays as it was."""
    found = with_scale(-1.0)
    assert found.cause == "scale-error"
    assert found.extended is found.law
    assert found.gain is not None
    assert found.gain.total.rmse_gain.value == 0.0
    assert not found.effects[0].joined
    assert found.effects[0].refused
    assert found.effects[0].sentence.endswith("foretold worse with it: it stays out of the law.")
    assert found.refused is not None
    assert found.refused.gain.total.rmse_gain.value < -0.02
    assert all(np.array_equal(run.before, run.after) for run in found.residuals)
    told = found.to_json()
    assert told["refused"]["rmse_after_um"] > told["refused"]["rmse_before_um"] == told["gain"]["rmse_after_um"]
    assert told["refused"]["beside_constants"]["rmse_after_um"] > told["refused"]["beside_constants"]["rmse_before_um"]
    assert not found.refused.better_beside
    assert "nothing joined it; with what stays out, too, it would leave" in gain_words(found)
    assert "um: it does not pay; a free fit" in gain_words(found)


@pytest.mark.long
def test_the_same_law_is_made_where_runs_bear_it_out() -> None:
    """With the same scale in all runs it joins, and takes most of what the law left."""
    found = with_scale(1.0)
    assert found.cause == "scale-error"
    assert found.effects[0].joined
    assert not found.effects[0].refused
    assert found.refused is None
    assert found.to_json()["refused"] is None
    assert found.gain is not None
    assert found.gain.total.rmse_gain.low > 0.0


@pytest.mark.long
def test_the_rest_of_what_was_named_is_made() -> None:
    """Beside backlash that all runs have, the scale alone stays out, and the law is the one with backlash alone."""
    found = with_scale(-1.0, "backlash")
    assert [one.cause for one in found.effects] == ["scale-error", "backlash"]
    assert [one.joined for one in found.effects] == [False, True]
    assert [one.refused for one in found.effects] == [True, False]
    assert [one.cause for one in found.extended.terms] == ["backlash"]
    assert found.gain is not None
    assert found.refused is not None
    assert found.gain.total.rmse_gain.value > 0.0 > found.refused.gain.total.rmse_gain.value
    (told,), term = found.effects[1].parameters.values(), found.extended.terms[0]
    assert told.value == pytest.approx(1e6 * float(term.amplitudes[0]))
    assert "; with what stays out, too, it would leave" in gain_words(found)


@dataclass(frozen=True)
class Joined:
    """What a stage has of what joined."""

    joined: tuple[Any, ...]


def test_what_stays_out_takes_all_its_terms_with_it() -> None:
    """Terms that a cause took beside its first one go with it, also made anew in mended data; other places stay."""

    def term(cause: str, target: str) -> Any:
        return SimpleNamespace(trial=Trial(cause, np.zeros((4, 1)), target))

    named = [term("thermal-lag", "T05"), term("missing-sensor", "T02"), term("missing-sensor", "T09")]
    course: Any = SimpleNamespace(found=[SimpleNamespace(ranked=SimpleNamespace(best=one)) for one in named])
    last: Any = Joined((term("thermal-lag", "T05"), named[1], term("thermal-lag", "T05"), named[2]))
    assert _without(last, course, frozenset({0})).joined == (named[1], named[2])
    assert len(_without(last, course, frozenset({2})).joined) == 3


def gain_of(part: float) -> Gain:
    """A gain, of all runs."""
    one = Figure(part, part - 0.1, part + 0.1)
    return Gain({}, RunGain(1e-6, 1e-6, replace(one, value=1e-6 * (1.0 - part)), one, one, one, one))


def beside(part: float, falls: int = 3, runs: int = 3) -> BesideConstants:
    """What is left beside a constant in each run, of one before."""
    return BesideConstants(1e-6, (1.0 - part) * 1e-6, falls, runs)


@pytest.mark.parametrize(
    ("part", "told", "lost"),
    [
        (-0.3, None, True),
        (-0.001, None, True),
        (0.0, None, False),
        (-1e-12, None, False),
        (0.1, None, False),
        (0.1, beside(-0.3, 0), False),
        (-0.3, beside(0.2), False),  # first rows alone speak against it
        (-0.3, beside(0.04), True),
        (-0.3, beside(0.2, 2), True),
        (-0.3, beside(0.35, 2, 2), True),
        (-0.3, beside(0.5, 2, 2), False),
        (-0.3, beside(0.5, 1, 1), True),
    ],
)
def test_any_rise_is_a_loss_but_of_first_rows(part: float, told: BesideConstants | None, lost: bool) -> None:
    """A law that leaves more of runs never fitted does not pay, but where each of three says so beside a constant."""
    assert loses(Refused(gain_of(part), told)) is lost
