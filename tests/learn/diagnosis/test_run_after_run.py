"""Shapes in the rows of several runs at once are what they are run by run."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from hexathermal.errors import ArgumentError
from hexathermal.learn.diagnosis.run_after_run import RunAfterRun
from hexathermal.machine.leg_signals import LegSignals, Memory
from hexathermal.machine.leg_terms import LegTerm
from hexathermal.poses import FloatArray
from tests.learn.extended_laws import EXAMPLES, drawn_signals, terms_of


def _runs() -> RunAfterRun:
    """Four runs of different lengths and zeros; the third goes on where the second ended."""
    found = [drawn_signals(seed, rows) for seed, rows in ((3, 160), (4, 90), (5, 1), (6, 200))]
    found[2] = replace(found[2], time=found[2].time + found[1].time[-1] + 20.0)
    warmer = {name: value + 3.0 for name, value in found[3].zero_degC.items()}
    found[3] = replace(found[3], zero_degC=warmer, zero_index=1.00031)
    return RunAfterRun(tuple(found), (False, False, True, False))


def _run_by_run(runs: RunAfterRun, term: LegTerm) -> FloatArray:
    """A term's columns made of one run after the other, each with what it remembers."""
    found, memory = [], Memory()
    for signals, goes_on in zip(runs.runs, runs.goes_on, strict=True):
        memory = memory if goes_on else Memory()
        found.append(term.columns(signals, memory))
    return np.concatenate(found)


@pytest.mark.parametrize("shape", EXAMPLES)
def test_every_shape_is_what_it_is_run_by_run(shape: str) -> None:
    """Runs that begin anew forget, one that goes on remembers; each has its own zero."""
    runs = _runs()
    for term in terms_of(shape):
        wanted = _run_by_run(runs, term)
        found = runs.columns(shape, term.parameters)
        np.testing.assert_allclose(found, wanted, rtol=1e-12, atol=1e-12 * np.abs(wanted).max())


def test_creep_from_the_beginning_begins_with_each_run() -> None:
    """What relaxes from the beginning of a run relaxes in each that begins anew."""
    term = LegTerm("creep", "relaxation", {"time_constant_s": 900.0, "kick": "begin"}, [1e-7])
    runs = _runs()
    np.testing.assert_allclose(runs.columns("relaxation", term.parameters), _run_by_run(runs, term), atol=1e-15)


def test_a_missing_value_stays_in_its_run() -> None:
    """Where the air is not known in one row, what follows it is unknown to the end of that run, and of no other."""
    runs = _runs()
    air = runs.runs[1].recorded("air").copy()
    air[40] = np.nan
    known = RunAfterRun((runs.runs[0], replace(runs.runs[1], air=air), runs.runs[3]), (False, False, False))
    found = np.isnan(known.columns("room", {"time_constant_s": 900.0})[:, 0])
    assert found.tolist() == [False] * 160 + [False] * 40 + [True] * 50 + [False] * 200


@pytest.mark.parametrize("lost", [{"air": None}, {"inputs": {}}, {"dT": {"T01": np.zeros(90)}}])
def test_runs_that_record_less_are_asked_one_by_one(lost: dict[str, object]) -> None:
    """What one run does not record is missed by name; what all record is there all the same."""
    runs = _runs()
    poorer: LegSignals = replace(runs.runs[1], **lost)  # type: ignore[arg-type]
    known = replace(runs, runs=(runs.runs[0], poorer, *runs.runs[2:]))
    for shape, words in (("room", "air"), ("stored-heat", "spindle_rpm"), ("expansion", "T03")):
        term = terms_of(shape)[-1]
        missed = words in {"air": "air", "inputs": "spindle_rpm", "dT": "T03"}[next(iter(lost))]
        if missed:
            with pytest.raises(ArgumentError, match=words):
                known.columns(shape, term.parameters)
        else:
            np.testing.assert_allclose(known.columns(shape, term.parameters), _run_by_run(known, term), atol=1e-12)
