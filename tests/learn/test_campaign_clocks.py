"""Clocks that no measurement has are refused before anything is made of them; those of long campaigns pass."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from hexathermal import cli
from hexathermal.learn.campaign_clocks import DAY_S, ClockWarning, RunClock, impossible, unlike_others
from hexathermal.learn.campaign_files import load_campaign

from .campaign_folders import Table, leg_campaign, leg_table, messages, write_table

EPOCH_S = 1.7e9


def set_anew(table: Table) -> None:
    """Write an epoch for the time since the start from row 400 on."""
    table["time_s"][400:] += EPOCH_S


def last_is_huge(table: Table) -> None:
    """Write a time in the last row that is no time at all."""
    table["time_s"][-1] = 1e300


def nanoseconds(table: Table) -> None:
    """Write all times in nanoseconds."""
    table["time_s"] *= 1e9


def still(table: Table) -> None:
    """Write one time into all rows."""
    table["time_s"][:] = 40.0


def milliseconds(table: Table) -> None:
    """Write all times in milliseconds."""
    table["time_s"] *= 1e3


@pytest.mark.parametrize(
    ("edit", "wanted"),
    [
        (set_anew, "a.csv:402:1 run 'a': time_s jumps by 53.9 years from line 401 to 402, from 7980 to 1700008000; "),
        (set_anew, "a run pauses for no more than 30 days: is time_s in milliseconds there, or did the logger's clock"),
        (last_is_huge, "a.csv:601:1 run 'a': time_s jumps by 3.17e+292 years from line 600 to 601"),
        (nanoseconds, "a.csv:2:1 run 'a': one row every 634 years, in the other runs every 20 s"),
        (still, "a.csv:2:1 run 'a': time_s is 40 in all 600 rows: it does not advance"),
        (milliseconds, "a.csv:2:1 run 'a': one row every 5.56 h, in the other runs every 20 s; runs of one campaign"),
        (milliseconds, "is its time_s in milliseconds?"),
    ],
    ids=lambda item: item.__name__ if callable(item) else "",
)
def test_an_impossible_clock_is_a_fault(tmp_path: Path, edit: Callable[[Table], None], wanted: str) -> None:
    """The run is refused with the line, both times, the limit and what may have happened; one fault."""
    found = messages(leg_campaign(tmp_path, edit=edit))
    assert len(found) == 1
    assert wanted in found[0]


def test_check_tells_of_an_impossible_clock_and_goes_on(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """`check` shows a campaign that `identify` and `diagnose` refuse, with its warning, in numbers that can be read."""
    folder = str(leg_campaign(tmp_path, edit=last_is_huge))
    assert cli.main(["check", folder]) == 0
    said = capsys.readouterr()
    assert "years: is time_s in milliseconds?" in said.err
    assert max(map(len, said.out.split())) < 60
    for command in ("identify", "diagnose", "report"):
        assert cli.main([command, folder]) == 3
        assert "time_s jumps by" in capsys.readouterr().err


def test_milliseconds_in_every_run_are_warned_of(tmp_path: Path) -> None:
    """Where all runs are alike nothing tells the unit, and rows hours apart are taken, with a warning."""
    folder = leg_campaign(tmp_path)
    for seed, name in enumerate(("a", "b", "c")):
        table = leg_table(seed)
        milliseconds(table)
        write_table(folder / "runs" / f"{name}.csv", table)
    with pytest.warns(ClockWarning, match="every run: one row every 5.56 h: is time_s in milliseconds?"):
        load_campaign(folder)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        load_campaign(folder, clocks=False)


def months(table: Table) -> None:
    """A telescope: a row every ten minutes, down for a fortnight, its clock a Unix epoch."""
    table["time_s"] = EPOCH_S + 30.0 * table["time_s"]
    table["time_s"][300:] += 14.0 * DAY_S


def one_row_is_off(table: Table) -> None:
    """Write one wrong time, as a logger does that loses its clock for a row: cleaning leaves it out."""
    table["time_s"][300] = EPOCH_S


@pytest.mark.parametrize("edit", [months, one_row_is_off], ids=lambda item: item.__name__)
def test_honest_clocks_pass(tmp_path: Path, edit: Callable[[Table], None]) -> None:
    """Months at ten minutes a row beside runs at 20 s, and what cleaning makes good, are no fault."""
    assert len(load_campaign(leg_campaign(tmp_path, edit=edit)).runs) == 3


def test_years_without_a_pause_are_a_fault() -> None:
    """A run of decades is refused though no step in it is long."""
    clock = RunClock()
    for first in range(0, 5000, 1000):
        clock.add(DAY_S * np.arange(first, first + 1000.0), np.arange(first, first + 1000))
    problem = impossible(clock, (0, 0, 5001), 1)
    assert problem is not None
    assert problem.line == 5001
    assert "time_s runs over 13.7 years" in problem.message


@pytest.mark.parametrize(
    ("intervals", "named"),
    [
        ([20.0, 20.0, 20.0], []),
        ([1.0, 600.0, 600.0], []),  # a warm-up among months
        ([0.01, 60.0], []),  # a tracker's rate beside a logger's
        ([20.0, 20000.0], [1]),
        ([20000.0, 20.0, 20000.0, 20000.0], [1]),
        ([1.0, 1000.0, 1.001], [1]),  # less than an hour, and a thousand times to the row
        ([np.nan, 20.0, 20.0, 20000.0], [3]),
        ([np.nan], []),
    ],
)
def test_one_run_in_another_unit_is_named(intervals: list[float], named: list[int]) -> None:
    """A run a thousand times slower than the others is told, whatever their order; other rates are not."""
    assert sorted(unlike_others(intervals)) == named


def test_the_clock_does_not_depend_on_the_blocks() -> None:
    """Jump, interval and duration are the same however the rows are cut."""
    rng = np.random.default_rng(5)
    time = np.cumsum(rng.uniform(0.0, 40.0, 300))
    time[120:] += 40.0 * DAY_S
    whole, cut = RunClock(), RunClock()
    whole.add(time, np.arange(300))
    for first in range(0, 300, 40):
        cut.add(time[first : first + 40], np.arange(first, min(first + 40, 300)))
        cut.add(np.zeros(0), np.zeros(0, dtype=np.int64))
    assert whole.jump is not None
    assert (whole.jump.before, whole.jump.behind) == (119, 120)
    assert (cut.jump, cut.interval, cut.duration) == (whole.jump, whole.interval, whole.duration)
