"""Seconds by which all thermometers are late hide no cause, and are none."""

from __future__ import annotations

from functools import partial
from pathlib import Path

import numpy as np
import pytest

from hexathermal.learn.campaign_files import load_campaign
from hexathermal.learn.diagnosis import Diagnosis, diagnose
from hexathermal.learn.diagnosis.little_errors import LATE_S, SEEN_S, little_errors
from hexathermal.learn.diagnosis.stage import Stage
from hexathermal.machine.leg_signals import Memory
from hexathermal.simulate.hidden.drawing import campaign_of
from hexathermal.simulate.hidden.writing import write_campaign
from tests.learn.diagnosis.campaigns import rewritten, viewed

QUIET_UM = 0.005
"""Noise of the drift in a row: what is late by seconds stands above it."""


def late(rows: list[dict[str, str]], tau: float) -> None:
    """Let all thermometers be late by first order, and the drift have a little noise."""
    time = np.array([float(row["time_s"]) for row in rows])
    noise = QUIET_UM * np.random.default_rng(len(rows)).standard_normal(len(rows))
    for name in (name for name in rows[0] if name.endswith("_degC") and name.startswith("T")):
        behind = Memory().low_pass("late", time, np.array([float(row[name]) for row in rows]), tau)
        for row, value in zip(rows, behind, strict=True):
            row[name] = f"{value:.4f}"
    for beam in (name for name in rows[0] if name.startswith("beam")):
        for row, error in zip(rows, noise, strict=True):
            row[beam] = f"{float(row[beam]) + 1e-3 * error:.7f}" if row[beam] else ""


def told(folder: Path, tau: float) -> Diagnosis:
    """The diagnosis of a sound leg with such thermometers."""
    truth, answer = campaign_of("quiet", 8, causes=())
    write_campaign(folder, truth, answer)
    for file in sorted((folder / "runs").glob("*.csv")):
        rewritten(file, partial(late, tau=tau))
    return diagnose(load_campaign(folder), answer.base)


@pytest.mark.long
def test_lateness_that_every_thermometer_has_is_told_and_not_named(tmp_path: Path) -> None:
    """Twelve seconds stand far above noise of 5 nm; a note says how many they are."""
    found = told(tmp_path / "campaign", 12.0)
    assert (found.verdict, found.effects) == ("none", ())
    (note,) = (note for note in found.notes if note.startswith("the temperatures are late by some "))
    assert float(note.split()[6]) == pytest.approx(12.0, abs=2.0)


@pytest.mark.long
def test_lateness_of_a_minute_is_a_lag(tmp_path: Path) -> None:
    """It is more than thermometers are late as a rule: named, and no note says otherwise."""
    found = told(tmp_path / "campaign", 60.0)
    assert found.cause == "thermal-lag"
    assert not any("late by some" in note for note in found.notes)


def test_columns_of_lateness_are_what_late_readings_leave() -> None:
    """Of a law that reads a thermometer ten seconds late, where its rates are slow."""
    view, _ = viewed("finite_volume", 5, (), 1.0)
    bench = Stage(view).bench
    columns, sizes = little_errors(bench, late=True)
    before, _ = little_errors(bench, late=False)
    own = columns[:, before.shape[1] :]
    assert own.shape[1] == len(SEEN_S) * len(view.base)
    assert sizes[before.shape[1] :] == pytest.approx(LATE_S)
    (sensor, *_) = view.base
    behind = [np.interp(one.time - LATE_S, one.time, one.dT[sensor])[:, None] for one in view.signals]
    late_by = view.windows_zeroed(behind)[:, 0] - view.windows_zeroed(view.tables([sensor]))[:, 0]
    left = bench.slopes[sensor] * bench.slopes_span(sensor) * late_by
    # the second column is smoothed by a minute
    assert np.corrcoef(left, own[:, 1])[0, 1] > 0.9
    assert LATE_S * (own[:, 1] @ own[:, 1]) == pytest.approx(left @ own[:, 1], rel=0.2)
