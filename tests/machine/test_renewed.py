"""Creep that each move renews: what is left of earlier moves is wiped out, as friction's force is by sliding."""

from __future__ import annotations

import numpy as np
import pytest

from hexathermal.machine.leg_signals import LegSignals, Memory
from hexathermal.machine.leg_terms import term_columns

TAU, SLID = 300.0, 0.002


def column(time: np.ndarray, q: np.ndarray, memory: Memory | None = None, **settings: object) -> np.ndarray:
    """The term's column."""
    own = {"time_constant_s": TAU, "kick": "direction", "renewed": 1.0, **settings}
    return term_columns("relaxation", LegSignals(time, {}, q), own, memory)[:, 0]


def drawn(seed: int, step: float) -> tuple[np.ndarray, np.ndarray]:
    """Moves of some millimetres or tenths of one, either way, between rests."""
    rng = np.random.default_rng(seed)
    knots, places = [0.0], [0.1]
    for _move in range(12):
        knots += [knots[-1] + rng.choice([40.0, 200.0, 800.0])]
        places += [places[-1]]
        knots += [knots[-1] + 20.0]
        places += [places[-1] + rng.choice([-1.0, 1.0]) * rng.choice([3e-4, 2e-3, 8e-3])]
    time = np.arange(0.0, knots[-1] + 100.0, step)
    return time, np.interp(time, knots, places)


@pytest.mark.parametrize("seed", range(4))
def test_sliding_renews_as_a_friction_force_does(seed: int) -> None:
    """``dy/dt = (way - y) |dq/dt| / slid`` while it slides and ``-y / tau`` all the time, by many small steps."""
    time, q = drawn(seed, 20.0)
    found = column(time, q, saturation_m=SLID)
    fine = np.arange(0.0, time[-1], 0.05)
    moved, y, wanted = np.diff(np.interp(fine, time, q)), 0.0, [0.0]
    for dq in moved:
        y += (np.sign(dq) - y) * abs(dq) / SLID - y * 0.05 / TAU
        wanted.append(y)
    # rows decay before they slide: a row's worth of a decay apart
    assert found[:-1] == pytest.approx(np.interp(time[:-1], fine, wanted), abs=20.0 / TAU)


def test_moves_in_quick_succession_do_not_add_up() -> None:
    """After any number of whole moves one way the same is left as after one; where they add up it is more."""
    time = np.arange(0.0, 1000.0, 10.0)
    q = 0.1 + 0.01 * np.minimum(np.floor(time / 100.0), 8.0)
    renewed, added = column(time, q), column(time, q, renewed=0.0)
    after = time == 800.0
    assert renewed[after] == pytest.approx(1.0)
    assert added[after] > 2.0
    alone = np.where(time >= 800.0, 0.11, 0.1)
    assert renewed[time >= 800.0] == pytest.approx(column(time, alone)[time >= 800.0])
    assert column(time, q, kick="move")[after] == pytest.approx(1.0)
    assert column(time, 0.3 - q)[after] == pytest.approx(-1.0)
    assert column(time, 0.3 - q, kick="move")[after] == pytest.approx(1.0)


@pytest.mark.parametrize("decades", [0.0, 1.5])
def test_blocks_of_rows_are_rows_at_once(decades: float) -> None:
    """Rows in two blocks, cut anywhere, within a move too, give what they give at once."""
    time, q = drawn(5, 7.0)
    whole = column(time, q, decades=decades, saturation_m=SLID)
    for cut in range(1, len(time) - 1, 29):
        memory = Memory()
        parts = [column(time[own], q[own], memory, decades=decades, saturation_m=SLID)
                 for own in (slice(0, cut), slice(cut, None))]  # fmt: skip
        assert np.concatenate(parts) == pytest.approx(whole, abs=1e-12)
