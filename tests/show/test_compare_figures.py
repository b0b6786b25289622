"""Pictures of a comparison: gaps stay white, what stands out is named, and all that was named is in the picture."""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from hexathermal.compare.bench_runs import RunCurves
from hexathermal.compare.differences import ParameterFound
from hexathermal.compare.scores import ComparedRun
from hexathermal.poses import FloatArray
from hexathermal.show.compare_figures import OTHERS, channels_figure, parameters_figure, piece_starts, residuals_figure
from hexathermal.show.compare_tables import parameters_table

COUNT = 9
"""Thermocouples, all on the body."""

GAP_H = (1.0, 1.6)
"""Hours between which no row is settled."""

MOVE_H = 0.07
"""Hours of a move, in which no row is settled."""


def number(name: str, value: float, low: float, high: float, named: bool, target: str = "") -> ParameterFound:
    """Return a number that was looked for."""
    limits = (-0.04, 0.12) if target else (0.8, 1.25)
    return ParameterFound(name, target, name, value, low, high, named, 0.0, *limits, (), "")


PARAMETERS = (
    number("motor-heat", 3.5, 3.4, 3.7, True), number("friction-heat", 0.02, 0.01, 900.0, False),
    number("conduction-motor", 99.5, 52.2, 189.7, True), number("conduction-joints", 0.12, 0.06, 0.23, True),
    number("sensor-reads-air", 0.30, 0.27, 0.33, True, "T01"), number("sensor-reads-air", 0.1, 0.0, 0.2, False, "T02"),
)  # fmt: skip


def run_of(rms_before: FloatArray, rms_after: FloatArray) -> ComparedRun:
    """Return a run with long gaps, a row alone between them, and a move of some minutes; its residuals are as told."""
    time = np.concatenate([np.arange(0.0, GAP_H[0], 0.01), [GAP_H[1]], np.arange(2.0, 2.5, 0.01),
                           np.arange(2.5 + MOVE_H, 4.0, 0.01)]) * 3600.0  # fmt: skip
    nothing = RunCurves(np.zeros((len(time), COUNT)), np.zeros(len(time)))
    before, after = (RunCurves(np.tile(size, (len(time), 1)), np.full(len(time), 1e-6))
                     for size in (rms_before, rms_after))  # fmt: skip
    return ComparedRun("run-01", "validation", time, np.zeros(len(time)), nothing, before, after)


def comparison(parameters: tuple[ParameterFound, ...] = PARAMETERS, runs: tuple[ComparedRun, ...] = ()) -> Any:
    """Return what a figure needs of a comparison."""
    return SimpleNamespace(
        title="bench", sensors=tuple(f"T{k + 1:02d}" for k in range(COUNT)), differences=("one",),
        placed=SimpleNamespace(places=tuple(("body", 0.05 * k) for k in range(COUNT))), parameters=parameters,
        runs=runs,
    )  # fmt: skip


@pytest.fixture
def run() -> ComparedRun:
    """A run where T04, T05, T06 are worst before, T09 and T05 after."""
    before, after = np.full(COUNT, 0.1), np.full(COUNT, 0.05)
    before[3:6] = 4.0, 5.0, 3.0
    after[[8, 4, 0]] = 2.0, 1.5, 1.0
    return run_of(before, after)


@pytest.mark.parametrize("draw", [residuals_figure, channels_figure])
def test_no_line_bridges_a_gap(draw: Any, run: ComparedRun) -> None:
    """No curve has a piece inside of times without settled rows; a row alone between two such times is a dot."""
    figure = draw(comparison(runs=(run,)), run)
    curves = 0
    for axes in figure.axes:
        for line in axes.lines:
            x = np.asarray(line.get_xdata(), dtype=np.float64)
            if line.get_linestyle() == "None" or len(x) < 10:
                continue
            curves += 1
            ends = np.column_stack([x[:-1], x[1:]])
            longest = np.nanmax(np.diff(ends, axis=1))
            assert longest < MOVE_H
        dots = [line for line in axes.lines if line.get_linestyle() == "None" and len(line.get_xdata()) == 1]
        assert all(line.get_xdata()[0] == pytest.approx(GAP_H[1]) for line in dots)
        assert dots or not axes.get_visible()
    assert curves >= 2 * (COUNT + 1)


def test_rare_rows_are_no_gaps() -> None:
    """Rows every half an hour are joined; a night without rows is not."""
    assert piece_starts(0.5 * np.arange(20)) == [0]
    assert piece_starts(np.concatenate([0.5 * np.arange(20), [20.0, 20.5]])) == [0, 20]


def test_thermocouples_that_stand_out_are_named_in_their_colours(run: ComparedRun) -> None:
    """The largest residuals before and after are named, each in one colour on both sides; all others are grey.

    They are those of all runs: the same in each figure.
    """
    other = run_of(np.full(COUNT, 0.1), np.full(COUNT, 0.05))
    found = comparison(runs=(run, other))
    figure = residuals_figure(found, run)
    legends = [axes.get_legend() for axes in figure.axes if axes.get_legend() is not None]
    assert len(legends) == 1
    said = {text.get_text(): line.get_color() for text, line in zip(legends[0].get_texts(), legends[0].get_lines(),
                                                                    strict=True)}  # fmt: skip
    assert list(said) == ["T01", "T04", "T05", "T06", "T09", "others"]
    assert len(set(said.values())) == len(said)
    elsewhere = residuals_figure(found, other).axes[1].get_legend()
    assert [line.get_color() for line in elsewhere.get_lines()] == list(said.values())
    for axes in figure.axes[:2]:
        colours = [line.get_color() for line in axes.lines if len(line.get_xdata()) > 10]
        assert sorted(colours) == sorted([*said.values(), *[OTHERS] * (COUNT - 6)])


def test_all_that_was_named_is_inside_the_picture_of_the_numbers() -> None:
    """Each named number, a thermocouple too, has its row, its whole interval is on the axis, and no text hides it."""
    figure = parameters_figure(comparison())
    rows = {label.get_text(): (axes, k) for axes in figure.axes for k, label in enumerate(axes.get_yticklabels())}
    assert set(rows) == {*(one.name for one in PARAMETERS[:4]), "sensor-reads-air T01", "sensor-reads-air T02"}
    for one in PARAMETERS:
        if not one.named:
            continue
        axes, k = rows[f"{one.name} {one.target}".strip()]
        low, high = axes.get_xlim()
        assert low < one.low < one.high < high
        drawn = [line.get_xdata() for line in axes.lines if list(line.get_ydata()) == [k, k]]
        assert [list(ends) for ends in drawn] == [pytest.approx([one.low, one.high])]
    factors = rows["motor-heat"][0]
    assert factors.get_xlim()[1] < 300.0  # what is not named does not widen it without end
    assert not factors.texts
    without = parameters_figure(comparison(PARAMETERS[:4]))
    assert len(without.axes) == 1


def test_picture_and_table_tell_the_same_numbers() -> None:
    """A thermocouple of which the data say nothing is in neither; what was named lies on no grey."""
    silent = replace(PARAMETERS[5], target="T03", log_evidence=-3.0)
    never = replace(PARAMETERS[2], limit_low=0.0, limit_high=math.inf)
    needless = replace(PARAMETERS[1], name="convection", value=0.2, low=0.1, high=0.3)
    found = comparison((*PARAMETERS[:2], never, needless, *PARAMETERS[4:], silent))
    figure, table = parameters_figure(found), parameters_table(found, False)
    shown = [label.get_text() for axes in figure.axes for label in axes.get_yticklabels()]
    names, named = (list(table.columns[k].cells) for k in (0, 3))
    assert sorted(shown) == sorted(names)
    assert "sensor-reads-air T03" not in shown
    assert [named[names.index(one)] for one in ("motor-heat", "convection", "sensor-reads-air T02")] == [
        "yes", "not needed", ""]  # fmt: skip
    row = [label.get_text() for label in figure.axes[0].get_yticklabels()].index("conduction-motor")
    greys = [bar.get_y() + 0.5 * bar.get_height() for bar in figure.axes[0].patches]
    assert len(greys) == 3
    assert row not in np.round(greys, 6)
