"""What errs slowly is no cause: the row that a campaign counts from, and thermometers of a leg that grows a lot."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from hexathermal.learn.diagnosis import stage as stages
from hexathermal.learn.diagnosis import steepest, wandering
from hexathermal.learn.diagnosis.stage import Stage
from hexathermal.learn.diagnosis.steepest import STEEPEST
from hexathermal.learn.diagnosis.view import View
from hexathermal.learn.diagnosis.wandering import with_wandering
from tests.learn.diagnosis.campaigns import first_name, viewed


@pytest.mark.long
@pytest.mark.parametrize(("bench", "seed"), [("modal", 1), ("quiet", 2)])
def test_an_error_of_the_first_row_is_in_all_runs_and_is_no_cause(
    bench: str, seed: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Runs of a sound leg count from one row, which errs by three times the noise: the null knows, nothing is named."""
    view, _ = viewed(bench, seed, (), 1.0)
    error = 3.0 * Stage(view).levels.rms
    runs = tuple(replace(rows, drift=rows.drift + error) for rows in view.runs)
    off = replace(view, runs=runs, zeroed_by_run=False)
    assert first_name(off) is None
    known = Stage(off).step.null
    monkeypatch.setattr(stages, "FIRST_ROW", 1e-9)
    assert Stage(replace(off)).step.null < known - 1.0


@pytest.mark.parametrize("column", [1, 2])
@pytest.mark.parametrize("zeroed_by_run", [True, False])
def test_weather_counts_from_the_zero(column: int, zeroed_by_run: bool) -> None:
    """Pressure and humidity are 0 in the first row of each run, or of the campaign, at once and behind an hour."""
    view, _ = viewed("quiet", 2, (), 1.0)
    told = replace(view, zeroed_by_run=zeroed_by_run).weather(column, (0.0, 3600.0))
    plain = [rows.weather[:, [column]] for rows in view.runs if rows.weather is not None]
    assert told is not None
    pairs = list(zip(plain, view.pieces, strict=True))
    zeros = [values[piece.used[0]] for values, piece in pairs]
    zeros = zeros if zeroed_by_run else [zeros[0]] * len(zeros)
    at_once = np.concatenate([piece.means(values - zero) for (values, piece), zero in zip(pairs, zeros, strict=True)])
    at_once = at_once[:, 0]
    assert np.abs(told[:, 0] - at_once).max() < 0.1 * np.ptp(at_once)
    assert np.abs(told[0]).max() < 0.1 * np.ptp(at_once)


def erring(view: View, growth: float, rng: np.random.Generator) -> View:
    """The view of a leg that grows `growth` times as much for q as for q0, moved by what its thermometer errs, too.

    It wanders by 0.1 K within each run, ten times the drift's own noise.
    """
    sensor, runs = view.base[0], []
    for rows in view.runs:
        time = rows.signals.time
        knots = np.arange(0.0, time[-1] + 3600.0, 1800.0)
        error = 0.1 * np.interp(time, knots, rng.standard_normal(len(knots)))
        span = 1e-5 * (view.length + growth * rows.signals.q)
        runs.append(replace(rows, drift=rows.drift + span * (rows.signals.dT[sensor] + error - error[0])))
    return replace(view, runs=tuple(runs))


@pytest.mark.parametrize(("growth", "believed"), [(1.0, 1.0), (4.0, STEEPEST)])
def test_what_erring_thermometers_make_of_a_law_goes_as_the_length_they_speak_for(
    growth: float, believed: float, rng: np.random.Generator
) -> None:
    """Where most of the slow noise is theirs it is larger the farther the rod is out, B over A believed to a limit."""
    view, _ = viewed("quiet", 2, (), 1.0)
    assert with_wandering(view) is view
    steel = with_wandering(erring(view, growth, rng))
    assert steel.erring is not None
    shown, q = steel.channel.wander, steel.q / view.length
    assert shown.mean() == pytest.approx(1.0)
    np.testing.assert_allclose(shown / shown[0], (1.0 + believed * q) / (1.0 + believed * q[0]), rtol=0.05)


def test_a_part_without_a_length_and_a_leg_at_rest_wander_alike_everywhere(rng: np.random.Generator) -> None:
    """There is no length that the noise could go with."""
    part, _ = viewed("component", 7873671558253397, (), 1.0)
    leg = erring(viewed("quiet", 2, (), 1.0)[0], 1.0, rng)
    rest = replace(leg, runs=tuple(
        replace(rows, signals=replace(rows.signals, q=np.zeros_like(rows.signals.q))) for rows in leg.runs
    ))  # fmt: skip
    for view in (part, rest):
        assert with_wandering(view) is view
        np.testing.assert_array_equal(view.channel.wander, 1.0)


@pytest.mark.long
def test_a_scale_that_is_off_is_not_what_wanders(monkeypatch: pytest.MonkeyPatch) -> None:
    """It goes with q in all runs alike, and stands beside the law; else the noise would seem to go with q."""
    view, _ = viewed("modal", 2, ("scale-error",), 2.0)
    assert with_wandering(view) is view
    assert first_name(view) == "scale-error"
    monkeypatch.setattr(wandering, "POWERS", 0)
    monkeypatch.setattr(steepest, "STEEPEST", 1e9)
    assert with_wandering(view).erring is not None
