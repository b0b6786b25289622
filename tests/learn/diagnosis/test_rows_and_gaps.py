"""Rows that are not usable, gaps, many landings, a rod that stands still: what counts from where, and what is told."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from hexathermal.learn.campaign import Campaign
from hexathermal.learn.campaign_files import load_campaign
from hexathermal.learn.diagnosis import diagnose
from hexathermal.learn.diagnosis.pieces import MOST_WINDOWS, pieces_of
from hexathermal.learn.diagnosis.smoothing import noise_left, smoothed
from hexathermal.learn.diagnosis.stage import Stage, view_of
from hexathermal.learn.diagnosis.words import AMPLITUDES, PER_KELVIN
from hexathermal.learn.signals import RunRows, campaign_rows
from hexathermal.learn.validation_scores import scores
from hexathermal.machine.leg_states import terms_columns, terms_drift
from hexathermal.machine.leg_terms import LegTerm, term_columns
from hexathermal.show.identification_tables import figure_facts
from hexathermal.show.shares import bounded, less, proven
from hexathermal.simulate.hidden.drawing import campaign_of
from hexathermal.simulate.hidden.writing import write_campaign
from tests.learn.diagnosis.campaigns import rewritten

SHAPES: tuple[tuple[str, str, dict[str, Any]], ...] = (
    ("backlash", "direction", {}),
    ("creep", "relaxation", {"time_constant_s": 600.0, "kick": "move"}),
    ("creep", "relaxation", {"time_constant_s": 3000.0, "kick": "begin"}),
    ("hidden-heat", "stored-heat", {"source": "motion", "time_constant_s": 1800.0}),
    ("frame-expansion", "room", {"time_constant_s": 3000.0}),
    ("scale-error", "position", {}),
    ("zero-drift", "time", {}),
    ("periodic-screw-error", "periodic", {"pitch_m": 4e-3}),
)

Row = dict[str, str]


def written(folder: Path, change: Callable[[list[Row]], None], causes: tuple[str, ...] = ()) -> Campaign:
    """Write a quiet leg, the rows of its runs changed, and read it again; its title names its law's sensors."""
    truth, answer = campaign_of("quiet", 6, causes=causes, strength=2.0, shared=True)
    write_campaign(folder, truth, answer)
    for file in sorted((folder / "runs").glob("*.csv")):
        rewritten(file, change)
    return replace(load_campaign(folder), title=",".join(answer.base))


def as_it_is(rows: list[Row]) -> None:
    """Leave the rows of a run as they are."""


def settling_late(rows: list[Row]) -> None:
    """Let the rod come to where a run begins from 30 mm above, in ten minutes that may not be used."""
    step = float(rows[1]["time_s"]) - float(rows[0]["time_s"])
    began = [step * k for k in range(int(600.0 / step))]
    for row in rows:
        row["time_s"] = f"{float(row['time_s']) + began[-1] + step:g}"
    coming = []
    for time in began:
        above = 30.0 * max(1.0 - time / 300.0, 0.0)
        moved = {name: f"{float(value) + above:.6f}" for name, value in rows[0].items()
                 if name == "q_mm" or name.startswith("beam")}  # fmt: skip
        coming.append(rows[0] | moved | {"time_s": f"{time:g}", "settled": "0"})
    rows[:0] = coming


def test_terms_count_from_the_row_from_which_the_drift_does(tmp_path: Path) -> None:
    """Rows before the first usable one move, cool and warm: every shape is 0 in that row, in a fit and in a law."""
    campaign = written(tmp_path / "campaign", settling_late)
    rows = campaign_rows(campaign, "identification")
    view = view_of(campaign, rows, tuple(campaign.title.split(",")))
    assert all(one.signals.zero_row == np.flatnonzero(one.settled)[0] > 0 for one in rows)
    for cause, shape, parameters in SHAPES:
        term = LegTerm(cause, shape, parameters, np.ones(term_columns(shape, view.signals[0], parameters).shape[1]))
        fitted = view.columns(shape, parameters)
        quick = view.quick_columns(shape, parameters) if shape in ("position", "time", "periodic") else fitted
        for k, (signals, piece) in enumerate(zip(view.signals, view.pieces, strict=True)):
            own = signals.counted(terms_columns((term,), signals))
            assert np.abs(own[piece.used[0]]).max() == 0.0
            size = 1e-9 + 1e-6 * np.abs(own).max()
            np.testing.assert_allclose(fitted[view.channel.run == k], piece.means(own), atol=size)
            if shape != "periodic":  # its mean over a window in which the rod stands is not that of its place
                np.testing.assert_allclose(quick[view.channel.run == k], piece.means(own), atol=size)


@pytest.mark.long
def test_an_extended_law_foretells_runs_that_settle_late(tmp_path: Path) -> None:
    """Backlash is named, and what it adds at the first usable row of a run for validation is no error of the law."""
    campaign = written(tmp_path / "campaign", settling_late, ("backlash",))
    found = diagnose(campaign, campaign.title.split(","))
    assert [one.cause for one in found.effects] == ["backlash"]
    assert found.gain is not None
    assert found.gain.total.rmse_gain.value > 0.3
    for rows in campaign_rows(campaign, "validation"):
        law = found.extended
        first = int(np.flatnonzero(rows.settled)[0])
        assert law.predict_signals(rows.signals)[first] == 0.0
        moved = terms_drift(law.terms, rows.signals)
        assert np.allclose(law.predict_signals(rows.signals) - found.law.predict_signals(rows.signals),
                           moved - moved[first] + law.base_columns(rows.signals)
                           @ (law.coefficients - found.law.coefficients))  # fmt: skip


def test_temperatures_are_smoothed_in_time_and_not_across_gaps() -> None:
    """A line and a parabola stay what they are, also where rows are missing or closer together in motion."""
    even = np.arange(0.0, 7200.0, 20.0)
    lost = even[(even < 3000.0) | (even > 6000.0)]
    dense = np.unique(np.concatenate([np.arange(0.0, 7200.0, 60.0), np.arange(1800.0, 1830.0)]))
    for time in (even, lost, dense):
        values = np.column_stack([time / 720.0, (time / 3600.0) ** 2])
        np.testing.assert_allclose(smoothed(time, values), values, atol=2e-4)
    rng = np.random.default_rng(1)
    noise = rng.normal(size=(len(lost), 1))
    assert smoothed(lost, noise).std() < 0.5 * noise.std()


BURSTS = np.concatenate([np.arange(480.0 * k, 480.0 * k + 240.0, 20.0) for k in range(40)])
THIN_AT_REST = np.concatenate(
    [np.concatenate([600.0 * k + np.arange(0.0, 300.0), 600.0 * k + np.arange(300.0, 600.0, 60.0)]) for k in range(20)]
)


@pytest.mark.long
@pytest.mark.parametrize(
    ("time", "least", "most"),
    [(np.arange(0.0, 2e4, 20.0), 0.0, 2e4), (BURSTS, 0.0, 2e4), (THIN_AT_REST, 330.0, 600.0),
     (np.arange(0.0, 600.0, 0.05), 0.0, 600.0)],
    ids=["even", "four minutes in eight", "once a minute at rest", "twenty a second"],
)  # fmt: skip
def test_smoothing_leaves_the_noise_that_is_told(time: np.ndarray, least: float, most: float) -> None:
    """By whatever rows: a fifth more or less, and less than all of it."""
    own = (time % most >= least) if least else np.ones(len(time), dtype=bool)
    noise = smoothed(time, np.random.default_rng(3).standard_normal((len(time), 100)))
    told = float(np.sqrt((noise_left(time)[own] ** 2).mean()))
    assert told == pytest.approx(float(np.sqrt((noise[own] ** 2).mean())), rel=0.2)
    assert told < 0.65


def resting(rows: RunRows, rests: list[float]) -> RunRows:
    """Rows of a run that rests so often, for so long each [s]."""
    time = np.arange(0.0, sum(rests), 20.0)
    landing = np.searchsorted(np.cumsum(rests), time, side="right").astype(np.int64)
    settled = np.ones(len(time), dtype=bool)
    return replace(rows, signals=replace(rows.signals, time=time), landing=landing, settled=settled)


def test_a_run_of_many_rests_has_windows(tmp_path: Path) -> None:
    """Three hundred landings of four minutes: windows end, each landing has one, and there are not too many.

    A night behind them keeps windows of its own.
    """
    rows = campaign_rows(written(tmp_path / "campaign", as_it_is), "identification")[0]
    for last in ([], [12.0 * 3600.0]):
        piece = pieces_of(resting(rows, [240.0] * 300 + last))
        assert set(piece.landing) == set(range(300 + len(last)))
        assert 300 <= len(piece.edges) <= 300 + len(last) + MOST_WINDOWS
    assert (piece.landing == 300).sum() >= 100


@pytest.mark.long
def test_a_validation_run_without_the_laws_sensor_is_passed_over(tmp_path: Path) -> None:
    """It is not judged, and that is said; the others are."""
    folder = tmp_path / "campaign"
    campaign = written(folder, as_it_is, ("backlash",))
    last = campaign.runs_of("validation")[-1].name
    sensor = campaign.title.split(",")[0]
    rewritten(
        folder / "runs" / f"{last}.csv", lambda rows: [row.update({f"{sensor}_degC": ""}) for row in rows] and None
    )
    found = diagnose(load_campaign(folder), campaign.title.split(","))
    assert f"not judged, what the law reads has no values there: {last}" in found.notes
    assert found.gain is not None
    assert last not in found.gain.runs


@pytest.mark.long
def test_a_rod_that_stands_still_in_every_run_does_not_move(tmp_path: Path) -> None:
    """Each run at another place: nothing that goes with the place is looked for, and that is said."""
    places = iter(range(100))

    def still(rows: list[Row]) -> None:
        place = 2.0 * next(places)
        for row in rows:
            moved = place - float(row["q_mm"])
            for name in [name for name in row if name == "q_mm" or name.startswith("beam")]:
                row[name] = f"{float(row[name]) + moved:.6f}"

    campaign = written(tmp_path / "campaign", still)
    rows = campaign_rows(campaign, "identification")
    assert np.ptp([one.signals.q[0] for one in rows]) > 1e-3
    view = view_of(campaign, rows, tuple(campaign.title.split(",")))
    assert not view.moves
    tried = {trial.cause for trial in Stage(view).search.trials}
    assert not tried & {"scale-error", "periodic-screw-error", "backlash"}


def test_one_landing_alone_has_no_interval() -> None:
    """A gain on one run of one landing is told with no interval, and proves nothing; of two landings it has one."""
    one = np.array([[100.0, 1e-12, 1e-5, 1e-6, 4e-12, 2e-5, 2e-6]])
    alone, two = (
        scores([table], np.random.default_rng(1)) for table in (one, np.concatenate([one, one * [1, 3, 2, 2, 1, 1, 1]]))
    )
    assert alone.rms_reduction.value == pytest.approx(0.5)
    assert proven(alone.rms_reduction) == "not proven"
    assert less(alone.rms_reduction).endswith("one landing: no interval")
    each = scores([one, 2.0 * one], np.random.default_rng(1))  # drawn again they are the same
    assert not bounded(each.linf)
    assert not bounded(each.largest_reduction)
    assert bounded(each.rms_reduction)
    assert json.dumps(figure_facts(alone.rms_reduction), allow_nan=False)
    assert two.rmse.low < two.rmse.value < two.rmse.high


def test_every_expansion_of_a_part_is_a_length_for_a_kelvin() -> None:
    """Units of a leg's expansion that a part without a stroke has as lengths are all known."""
    assert {unit for _names, unit, _factor in AMPLITUDES.values() if unit.startswith("1/K")} == set(PER_KELVIN)
