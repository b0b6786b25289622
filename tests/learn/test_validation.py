"""Validation on runs never fitted: scores, intervals, coverage, over-correction, motion."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from hexathermal.errors import ArgumentError, UnknownNameError
from hexathermal.learn.campaign import RunFile
from hexathermal.learn.identification import identify
from hexathermal.learn.law import IdentifiedLaw
from hexathermal.learn.validation import MOST_LANDINGS, Verdict, validate
from tests.learn.legs import LEG, SENSORS, drawn_leg
from tests.learn.test_selection import cut


def learned(rng: np.random.Generator) -> IdentifiedLaw:
    blocks = drawn_leg(rng, runs=6)
    return identify(lambda: blocks, SENSORS, LEG, wanted="T07", sizes=(1,)).law


def test_prediction_intervals_cover_fresh_runs() -> None:
    """Over 12 campaigns of 3 fresh runs, 92 to 98 % of the rows lie inside their 95 % prediction interval."""
    inside = []
    for seed in range(12):
        rng = np.random.default_rng([seed, 3])
        inside.append(validate(learned(rng), drawn_leg(rng, runs=3, role="validation"), SENSORS).coverage)
    assert 0.92 <= np.mean(inside) <= 0.98, np.mean(inside)


def test_scores_are_those_of_the_rows(rng: np.random.Generator) -> None:
    """RMSE, largest, mean and reductions are those that the rows give, in blocks of any size; intervals hold them."""
    law, runs = learned(rng), drawn_leg(rng, runs=3, role="validation")
    found, parts = validate(law, runs, SENSORS), validate(law, cut(runs, 41), SENSORS)
    e = np.concatenate([block.drift - law.predict(block.dT[:, [6]], block.q) for block in runs])
    y = np.concatenate([block.drift for block in runs])
    for total in (found.total, parts.total):
        assert total.rmse.value == pytest.approx(np.sqrt(np.mean(e**2)), rel=1e-9)
        assert total.linf.value == pytest.approx(np.abs(e).max(), rel=1e-9)
        assert total.mean_reduction.value == pytest.approx(1.0 - np.abs(e).mean() / np.abs(y).mean(), rel=1e-9)
        assert total.largest_reduction.value == pytest.approx(1.0 - np.abs(e).max() / np.abs(y).max(), rel=1e-9)
        assert total.rmse.low < total.rmse.value < total.rmse.high
    assert found.verdict is Verdict.BETTER
    assert found.total.mean_reduction.value > 0.8
    assert found.coverage == pytest.approx(parts.coverage, abs=1e-12)
    assert len(found.curves) == 3


def test_a_law_that_makes_it_worse_is_found_and_said(rng: np.random.Generator) -> None:
    """A law with the wrong sign: verdict, negative reduction, and the runs are named."""
    law = learned(rng)
    wrong = dataclasses.replace(law, coefficients=-law.coefficients)
    found = validate(wrong, drawn_leg(rng, runs=2, role="validation"), SENSORS)
    assert found.verdict is Verdict.WORSE
    assert found.total.mean_reduction.value < 0.0
    assert any(note.startswith("over-correction: in validation-0, validation-1") for note in found.notes)


def test_a_step_at_reversals_is_found(rng: np.random.Generator) -> None:
    """Backlash of 1 um: residuals step at reversals by 1 um within the interval given; without it none is claimed."""
    law, runs = learned(rng), drawn_leg(rng, runs=3, role="validation")
    clean = validate(law, runs, SENSORS).motion[0]
    assert abs(clean.mean) < 4.0 * clean.uncertainty
    for block in runs:
        step = np.sign(np.diff(block.q, prepend=block.q[0]))
        held = np.maximum.accumulate(np.where(step != 0, np.arange(len(step)), 0))
        block.drift[:] += 0.5e-6 * step[held]
    found = validate(law, runs, SENSORS).motion[0]
    assert found.notable
    assert found.mean == pytest.approx(1e-6, abs=4.0 * found.uncertainty)


def test_rows_beyond_the_range_are_said(rng: np.random.Generator) -> None:
    """Extrapolation in dT and q is counted."""
    law = learned(rng)
    runs = drawn_leg(rng, runs=1, role="validation")
    narrow = dataclasses.replace(
        law, validity=dataclasses.replace(law.validity, dT=np.array([[0.0, 0.1]]), q=(0.1, 0.11))
    )
    found = validate(narrow, runs, SENSORS)
    assert found.outside["dT"] > 0.5
    assert found.outside["q"] > 0.5
    assert not found.fitted


def test_fitted_rows_are_told_again_under_another_name(rng: np.random.Generator) -> None:
    """A fitted run is known by its rows, renamed and cut anew, and is left out of the verdict; all fitted: no proof.

    A fresh run of a fitted one's name is no fitted run; a law without fingerprints can only compare names.
    """
    blocks = drawn_leg(rng, runs=4)
    law = identify(lambda: cut(blocks, 77), SENSORS, LEG, wanted="T07", sizes=(1,)).law
    renamed = dataclasses.replace(blocks[2], run=RunFile("fresh", Path("other.csv"), "validation"))
    fresh = drawn_leg(rng, runs=1)[0]
    assert fresh.run.name == "identification-0"
    mixed = validate(law, [*cut([renamed], 50), fresh], SENSORS)
    assert mixed.fitted == {"fresh": "identification-2"}
    assert mixed.verdict is Verdict.BETTER
    assert mixed.rows == len(fresh)
    assert mixed.total.rmse.value == mixed.runs["identification-0"].rmse.value
    assert any(note.startswith("fresh: fitted, and left out of the verdict") for note in mixed.notes)
    assert validate(law, [renamed], SENSORS).verdict is Verdict.FITTED
    old = dataclasses.replace(law, origin=dataclasses.replace(law.origin, run_fingerprints=()))
    unknown = validate(old, [fresh], SENSORS)
    assert not unknown.fits_known
    assert any("a run of the same name was: identification-0" in note for note in unknown.notes)


def test_every_row_a_landing_is_held_in_bounded_tables(rng: np.random.Generator) -> None:
    """With a landing a row, intervals come from a bounded number of pieces, whatever blocks the rows come in."""
    law, block = learned(rng), drawn_leg(rng, runs=1, hours=30.0, role="validation")[0]
    many = dataclasses.replace(block, landing=np.arange(len(block)))
    assert len(many) > 3 * MOST_LANDINGS
    whole, parts = validate(law, [many], SENSORS), validate(law, cut([many], 313), SENSORS)
    e = block.drift - law.predict(block.dT[:, [6]], block.q)
    for one in (whole, parts):
        assert one.total.rmse.value == pytest.approx(np.sqrt(np.mean(e**2)), rel=1e-9)
        assert one.total.linf.value == pytest.approx(np.abs(e).max(), rel=1e-12)
        assert one.total.rmse.low < one.total.rmse.value < one.total.rmse.high
    assert whole.total.rmse.low == pytest.approx(parts.total.rmse.low, rel=1e-9)
    assert [group.landings for group in whole.motion] == [group.landings for group in parts.motion]
    assert [group.mean for group in whole.motion] == pytest.approx([group.mean for group in parts.motion], abs=1e-15)


def test_intervals_that_say_nothing_are_noted(rng: np.random.Generator) -> None:
    """Prediction intervals wider than the largest drift are pointed out; those of a good law are not."""
    law, runs = learned(rng), drawn_leg(rng, runs=1, role="validation")
    wide = dataclasses.replace(law, factor=1e3)
    assert any("says nothing about the law" in note for note in validate(wide, runs, SENSORS).notes)
    assert not any("says nothing" in note for note in validate(law, runs, SENSORS).notes)


def test_missing_sensors_rows_and_displacements_are_refused(rng: np.random.Generator) -> None:
    """A sensor that the campaign lacks, no row at all, a part without q: one clear error each; gaps are counted."""
    law, runs = learned(rng), drawn_leg(rng, runs=1, hours=1.0, role="validation")
    with pytest.raises(UnknownNameError, match="reads sensor 'T07'"):
        validate(law, runs, ["other"])
    with pytest.raises(ArgumentError, match="no row to validate on"):
        validate(law, [], SENSORS)
    with pytest.raises(ArgumentError, match="no displacement"):
        validate(law, [dataclasses.replace(runs[0], q=None)], SENSORS)
    runs[0].dT[3:5, 6] = np.nan
    assert any(note.startswith("2 rows were left out") for note in validate(law, runs, SENSORS).notes)
