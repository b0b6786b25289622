"""What is said of clocks that gain time, and of thermometers that are late by rates that motion tells."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from hexathermal.learn.campaign_files import load_campaign
from hexathermal.learn.diagnosis import Diagnosis, diagnose
from hexathermal.learn.diagnosis.mending import law_late
from hexathermal.learn.diagnosis.smoothing import smoothed
from hexathermal.learn.diagnosis.trials import Delay
from hexathermal.learn.leg_law_files import read_leg_law, write_leg_law
from hexathermal.machine.leg_signals import Memory
from hexathermal.poses import FloatArray
from hexathermal.simulate.hidden.drawing import campaign_of
from hexathermal.simulate.hidden.writing import write_campaign
from tests.learn.diagnosis.campaigns import rewritten, viewed

TAU = 330.0
Rows = list[dict[str, str]]


def told(folder: Path, change: Callable[[Rows], None]) -> Diagnosis:
    """The diagnosis of a sound, quiet leg whose tables are changed."""
    truth, answer = campaign_of("quiet", 5, causes=())
    write_campaign(folder, truth, answer)
    for file in sorted((folder / "runs").glob("*.csv")):
        rewritten(file, change)
    return diagnose(load_campaign(folder), answer.base)


def columns(rows: Rows) -> tuple[FloatArray, list[str]]:
    """The times of a table, and the names of its thermometers."""
    names = [name for name in rows[0] if name.startswith("T") and name.endswith("_degC")]
    return np.array([float(row["time_s"]) for row in rows]), names


def losing(rows: Rows) -> None:
    """Log temperatures by a clock that loses a minute in each hour."""
    time, names = columns(rows)
    for name in names:
        values = np.array([float(row[name]) for row in rows])
        for row, value in zip(rows, np.interp(time * (1.0 + 60.0 / 3600.0), time, values), strict=True):
            row[name] = f"{value:.4f}"


def late(rows: Rows) -> None:
    """Let all thermometers be late, and noisy."""
    time, names = columns(rows)
    rng = np.random.default_rng(len(rows))
    for name in names:
        values = np.array([float(row[name]) for row in rows])
        behind = Memory().low_pass("late", time, values, TAU) + 0.05 * rng.standard_normal(len(time))
        for row, value in zip(rows, behind, strict=True):
            row[name] = f"{value:.4f}"


@pytest.mark.parametrize("smooths", [True, False])
def test_lateness_is_undone_one_stage_after_another(smooths: bool) -> None:
    """Whatever is kept between time constants: each stage adds its time constant times the rate."""
    view, _ = viewed("quiet", 5, (), 1.0)
    (sensor,) = view.base
    for stages in ((200.0, 450.0), (600.0,), (80.0, 80.0)):
        undone = []
        for signals in view.signals:
            values = signals.dT[sensor]
            for tau in stages:
                rate = np.gradient(values, signals.time)
                values = values + tau * (smoothed(signals.time, rate[:, None])[:, 0] if smooths else rate)
            undone.append(values)
        law = law_late(view, Delay((sensor,), stages, late=True, smooths=smooths))
        assert law == pytest.approx(view.base_of([view.windows_zeroed(undone)[:, 0]]), rel=1e-9, abs=1e-9)


@pytest.mark.long
def test_a_clock_that_loses_time_is_told_as_such(tmp_path: Path) -> None:
    """By how much in an hour, and no offset besides; the law's file puts it back."""
    found = told(tmp_path / "campaign", losing)
    assert found.cause == "clock-offset"
    assert set(found.effects[0].parameters) == {"gains_s_per_h"}
    gains = found.effects[0].parameters["gains_s_per_h"]
    assert gains.value == pytest.approx(-60.0, abs=3.0 * gains.std)
    assert "the clock of the temperatures loses time against that of the displacement" in found.sentence
    (repair,) = read_leg_law(write_leg_law(found.extended, tmp_path / "leg.toml")).repairs
    assert repair.parameters == {"offset_s": 0.0, "gains_s_per_h": gains.value}


@pytest.mark.long
def test_a_noisy_thermometer_is_told_by_how_much_it_is_late(tmp_path: Path) -> None:
    """Of a rate only the product with a time is known: the law's own A tells the time; its term is read back."""
    found = told(tmp_path / "campaign", late)
    assert found.cause == "thermal-lag"
    tau = found.effects[0].parameters["time_constant_s"]
    assert tau.value == pytest.approx(TAU, abs=2.0 * tau.std)
    assert tau.std < 0.25 * TAU
    term, *_ = read_leg_law(write_leg_law(found.extended, tmp_path / "leg.toml")).terms
    assert term == found.extended.terms[0]
    assert term.shape == "lead-by-motion"
    assert not {"once", "twice", "heat_times_s"} & set(found.effects[0].settings)
