"""A logger's clock that gains or loses time, put right."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from hexathermal.errors import ArgumentError
from hexathermal.machine.leg_repairs import SensorRepair, repaired
from tests.learn.extended_laws import drawn_signals, law_with


def test_a_clock_that_gains_time_is_read_the_later_the_longer_a_run_lasts() -> None:
    """``dT(t + offset + gains t)``: what was logged by such a clock is put back, and no controller can do that."""
    time = np.arange(0.0, 14400.0, 20.0)
    true = 1.0 - np.cos(time / 1500.0)
    off = 15.0 + 60.0 * time / 3600.0
    logged = {name: np.interp(time, time + off, true) for name in ("T01", "T02")}
    signals = dataclasses.replace(drawn_signals(3, len(time)), time=time, dT=logged)
    repair = SensorRepair("clock-offset", "clock", {"offset_s": 15.0, "gains_s_per_h": 60.0})
    put_back = repaired(signals, [repair]).dT["T01"]
    inside = time + off < time[-1]
    np.testing.assert_allclose(put_back[inside], true[inside], atol=2e-4)
    assert not repair.causal
    assert SensorRepair("clock-offset", "clock", {"offset_s": 0.0, "gains_s_per_h": -60.0}).causal
    assert not SensorRepair("clock-offset", "clock", {"offset_s": -5.0, "gains_s_per_h": 60.0}).causal
    for gains, words in ((-3600.0, "stands still"), ("x", "finite number"), (np.nan, "finite number")):
        with pytest.raises(ArgumentError, match=words):
            SensorRepair("clock-offset", "clock", {"offset_s": 0.0, "gains_s_per_h": gains})
    with pytest.raises(ArgumentError, match=r"runs 15 s ahead and gains 60 s in an hour"):
        law_with((), (repair,)).controller()
