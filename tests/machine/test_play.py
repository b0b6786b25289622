"""A reversal that takes its way: the nut in its play."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import hexathermal as ht
from hexathermal.errors import FileFormatError
from hexathermal.machine.leg_signals import LegSignals, Memory
from hexathermal.machine.leg_terms import term_columns
from tests.learn.machine_diagnosis.machines import filed

WAYS = st.lists(st.floats(-1e-3, 1e-3), min_size=2, max_size=40)


@given(WAYS, st.integers(1, 39), st.floats(1e-5, 1e-3))
def test_rows_in_parts_are_rows_at_once(way: list[float], cut: int, width: float) -> None:
    """The memory carries the nut's place from block to block, and it never leaves its play."""
    q = np.array(way)
    cut = min(cut, len(q) - 1)
    memory = Memory()
    parts = np.concatenate([memory.play(q[:cut], width), memory.play(q[cut:], width)])
    whole = Memory().play(q, width)
    assert np.array_equal(parts, whole)
    assert np.abs(whole).max() <= 0.5


@given(st.lists(st.sampled_from([0.0, 1e-4, 3e-4, -2e-4]), min_size=1, max_size=40), st.sampled_from([-0.5, 0.0, 0.2]))
def test_a_nut_goes_with_the_rod_until_it_meets_the_other_side(steps: list[float], start: float) -> None:
    """Row by row, at rest too: it is pushed by either side of its play."""
    q, width, place, wanted = np.cumsum([0.0, *steps]), 5e-4, start, []
    for step in np.diff(q, prepend=0.0):
        place = float(np.clip(place + step / width, -0.5, 0.5))
        wanted.append(place)
    assert Memory().play(q, width, start) == pytest.approx(wanted)


def test_a_narrow_play_is_the_direction_of_the_last_move() -> None:
    """With moves longer than the play, the place is half the direction."""
    q = np.array([0.0, 1e-3, 3e-3, 2e-3, 1e-3, 4e-3])
    signals = LegSignals(np.arange(6.0), {}, q)
    at_once, within = (term_columns("direction", signals, own)[:, 0] for own in ({}, {"play_m": 1e-4}))
    assert at_once == pytest.approx(within)
    slow = term_columns("direction", signals, {"play_m": 4e-3})[:, 0]
    assert slow == pytest.approx([0.0, 0.25, 0.5, 0.25, 0.0, 0.5])


def test_a_play_stands_in_the_file(tmp_path: Path) -> None:
    """A term within a play is written and read back; a play of 0 is refused."""
    term = ht.LegTerm("leg-backlash", "direction", {"play_m": 2e-4}, [1e-6], [[1e-16]])
    machine = filed(legs=[ht.LegLaw("T1", 2e-6, 1e-6, terms=(term,) if leg == 2 else ()) for leg in range(6)])
    file = tmp_path / "hexapod.toml"
    ht.write_hexapod(machine, file)
    assert "play_mm" in file.read_text()
    read = ht.load_hexapod(file)
    assert read.thermal is not None
    assert read.thermal.legs[2].terms[0].parameters["play_m"] == pytest.approx(2e-4)
    file.write_text(file.read_text().replace("play_mm = 0.2", "play_mm = 0.0"))
    with pytest.raises(FileFormatError, match="play_mm"):
        ht.load_hexapod(file)


@pytest.mark.parametrize("settings", [{}, {"play_m": 2e-4}])
def test_a_reversal_counts_from_where_the_first_position_was_reached(settings: dict[str, float]) -> None:
    """From below, moves upwards change nothing, and the first one downwards takes the whole step; blocks are as one."""
    q = np.array([0.0, 1e-3, 2e-3, 1e-3, 0.0, 1e-3])
    signals = LegSignals(np.arange(6.0), {}, q)
    below, above, partly = (
        term_columns("direction", signals, {**settings, "approach": own})[:, 0] for own in (1.0, -1.0, 0.5)
    )
    assert below == pytest.approx([0.0, 0.0, 0.0, -1.0, -1.0, 0.0])
    assert above == pytest.approx([0.0, 1.0, 1.0, 0.0, 0.0, 1.0])
    assert partly == pytest.approx([0.0, 0.25, 0.25, -0.75, -0.75, 0.25])
    memory, own = Memory(), {**settings, "approach": 1.0}
    halves = [LegSignals(signals.time[part], {}, q[part]) for part in (slice(0, 2), slice(2, 6))]
    joined = np.concatenate([term_columns("direction", half, own, memory)[:, 0] for half in halves])
    assert joined == pytest.approx(below)
