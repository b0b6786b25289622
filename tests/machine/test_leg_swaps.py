"""Plugs that changed places, put right run by run, with the zero that all runs count from."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from hexathermal.errors import ArgumentError
from hexathermal.machine.leg_repairs import SensorRepair, repaired
from tests.learn.extended_laws import drawn_signals


@pytest.mark.parametrize("wrong_zero", [False, True])
def test_plugs_exchanged_since_the_zero_of_all_runs_count_from_their_own(wrong_zero: bool) -> None:
    """What is read and what it counts from are put right, in runs of either kind; a controller has its own zero."""
    signals = drawn_signals(4)
    zeros = signals.zero_degC
    apart = zeros["T02"] - zeros["T01"]
    assert abs(apart) > 0.01
    runs = ("only_in", ["a"]) if wrong_zero else ("not_in", ["a"])
    swap = SensorRepair(
        "swapped-sensors", "swap", {"first": "T01", "second": "T02", runs[0]: runs[1], "zero_else": ["b"]}
    )
    first, later = (repaired(signals, [swap], run) for run in ("a", "b"))
    if wrong_zero:  # exchanged where the zero was read: in b plugs sit right, what they count from does not
        assert np.array_equal(first.dT["T01"], signals.dT["T02"])
        assert np.allclose(later.dT["T01"], signals.dT["T01"] - apart, atol=1e-12)
        assert first.zero_degC == later.zero_degC == {**zeros, "T01": zeros["T02"], "T02": zeros["T01"]}
        assert np.array_equal(repaired(signals, [swap], None).dT["T01"], signals.dT["T01"])
    else:
        assert first.dT["T01"] is signals.dT["T01"]
        assert np.allclose(later.dT["T01"], signals.dT["T02"] + apart, atol=1e-12)
        assert first.zero_degC == later.zero_degC == zeros
        assert np.array_equal(repaired(signals, [swap], None).dT["T01"], signals.dT["T02"])
    unknown = dataclasses.replace(signals, zero_degC={})
    with pytest.raises(ArgumentError, match="at the zero"):
        repaired(unknown, [swap], "b")
