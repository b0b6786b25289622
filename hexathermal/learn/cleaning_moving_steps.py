"""Beams that lose count while the rod moves: most do so there, where the mean of the beams tells nothing.

The difference of one beam and the others is free of movement, so that it shows a lost count in rows that are not
settled as well as in a rest: one beam against both others alike, once, within one row, and it stays. Tilt goes with the
rod or with heat, and takes many rows, or parts the beams at every movement as far; where it turns over at a reversal,
it turns back at the next; and where the rod is back, so is tilt, but not a count. A target that is knocked at such a
moment looks the same.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from hexathermal.learn.campaign_columns import BEAMS
from hexathermal.learn.cleaning_beam_scales import FEWEST, against_others, jumps, span_at, spans
from hexathermal.learn.cleaning_channels import PIECE_ROWS, studied
from hexathermal.learn.cleaning_record import Ledger
from hexathermal.learn.cleaning_returns import OTHERS
from hexathermal.learn.cleaning_rules import MARGIN, TO_SIGMA, Flags, filled
from hexathermal.learn.cleaning_sheets import Sheet, with_margins
from hexathermal.learn.cleaning_steps import (
    ALIKE,
    FEWEST_MOVES,
    MOVE_STEP_M,
    MOVE_TIMES,
    STEP_SCALES,
    Step,
    alone,
    doubt,
    made,
    sharpest,
    still_there,
    taken_back,
)
from hexathermal.poses import FloatArray

MOST_LOST = 2
"""Other times that beams may lose count in a run's first rows: more jumps are what beams do by themselves."""

NEAR = 5
"""Rows within which jumps are one; twice as many before and behind must be there, without a gap."""

MOVING_RULE = (
    f"while the rod moves, one beam alone jumps against the others within one row, and stays there, by more than "
    f"{MOVE_STEP_M * 1e6:g} um, {STEP_SCALES:g} usual jumps and {MOVE_TIMES:g} times all but {MOST_LOST} others at "
    "movements as far, also where the rod is back at a place where it was before: its step is taken back"
)


@dataclass(frozen=True, eq=False)
class MovingScales:
    """What is usual of beams in rows of a run's first that are not settled, m of them.

    Attributes
    ----------
    usual : float [m]
        Jump of one beam against the others, medians of five rows.
    time, reach, size : array, shape (m,) [s], [m], [m]
        Span of the displacement over five rows before and five behind, and the largest of the beams' jumps.
    """

    usual: float
    time: FloatArray
    reach: FloatArray
    size: FloatArray

    def largest(self, time: tuple[float, float], reach: float) -> float:
        """Return all but `MOST_LOST` jumps at movements that go as far, those between two times apart [m].

        Infinite where there are too few.
        """
        others = (self.reach >= ALIKE * reach) & ~((self.time >= time[0]) & (self.time <= time[1]))
        peaks, size = list[int](), np.where(others, self.size, -1.0)
        for row in np.argsort(-size):
            if len(peaks) == FEWEST_MOVES or size[row] < 0.0:
                break
            if all(abs(row - other) >= NEAR for other in peaks):
                peaks.append(int(row))
        return float(size[peaks[MOST_LOST]]) if len(peaks) == FEWEST_MOVES else np.inf


def without_moving_steps(sheets: Iterator[Sheet], ledger: Ledger) -> Iterator[Sheet]:
    """Take back the steps of single beams in rows that are not settled.

    Parameters
    ----------
    sheets : iterator of Sheet
        All rows of a run, whose first tell what is usual.
    ledger : Ledger
    """
    study, sheets = studied(sheets)
    scales = _scales(study[0]) if study else None
    study.clear()
    if scales is None:
        yield from sheets
        return
    offset = np.zeros(len(BEAMS))
    for sheet, own in with_margins(sheets, PIECE_ROWS, MARGIN):
        kept, offset = taken_back(sheet, own, _steps_in(sheet, own, scales), offset, ledger, MOVING_RULE)
        yield kept


def _scales(study: Sheet) -> MovingScales | None:
    """Return what is usual of the beams while the rod moves; None where it hardly does, or they part by too much."""
    if not study.settled.shape[1] or not study.beams.shape[1] or not study.q.shape[1]:
        return None
    moving = np.flatnonzero(_moving(study) & _whole(study))
    if len(moving) < FEWEST:
        return None
    size = np.abs(jumps(against_others(filled(study.beams)))[moving]).max(axis=1)
    usual = TO_SIGMA * float(np.median(size))
    if doubt(usual):
        return None
    return MovingScales(usual, study.time[moving, 0], spans(filled(study.q)[:, 0])[moving], size)


def _steps_in(sheet: Sheet, own: slice, scales: MovingScales) -> list[Step]:
    """Return the steps that begin in a piece's own rows; what goes and comes back, in its margins too, is none."""
    found: list[Step] = []
    if len(sheet) < 4 * NEAR:
        return found
    apart = against_others(filled(sheet.beams))
    jump, moving, q = jumps(apart)[: len(sheet)], _moving(sheet), filled(sheet.q)[:, 0]
    size = np.where(moving & _whole(sheet), np.abs(jump).max(axis=1), 0.0)
    for row in np.flatnonzero(size > max(MOVE_STEP_M, STEP_SCALES * scales.usual)):
        if size[row] < size[max(0, row - NEAR + 1) : row + NEAR].max():
            continue
        k = int(np.argmax(np.abs(jump[row])))
        sharp = sharpest(apart[:, k], int(row))
        if not 2 * NEAR <= sharp <= len(sheet) - 2 * NEAR:
            continue
        step = _step_at(apart, sharp, k, scales.usual)
        if step is None or not moving[step.row] or any(step.row - other.row < NEAR for other in found):
            continue
        near = float(sheet.time[sharp - NEAR, 0]), float(sheet.time[sharp + NEAR, 0])
        reach = max(span_at(q, at) for at in (sharp - 1, sharp, sharp + 1))
        if abs(step.size) > MOVE_TIMES * scales.largest(near, reach):
            found.append(step)
    own_steps = (step for step in found if own.start <= step.row - (step.part != 0.0) < own.stop)
    return [step for step in own_steps if not _comes_back(step, found) and still_there(step, found, q, apart)]


def _step_at(apart: FloatArray, sharp: int, k: int, usual: float) -> Step | None:
    """Return the step of one beam at a row; None where it is not alone, takes longer than a row, or does not stay."""
    firsts = (sharp - 2 * NEAR, sharp - NEAR, sharp, sharp + NEAR)
    early, level, soon, later = (np.median(apart[first : first + NEAR], axis=0) for first in firsts)
    size = float(soon[k] - level[k])
    row, part, once = made(apart[:, k] - level[k], sharp, size)
    stood = bool((np.abs(early - level) <= OTHERS * abs(size)).all())
    if not once or not stood or not alone(soon - level, size, k) or not alone(later - level, size, k):
        return None
    return Step(row, k, size, usual, at_rest=False, part=part)


def _comes_back(step: Step, found: Sequence[Step]) -> bool:
    """Whether the same beam makes as large a step the other way: play, not a count that is lost."""
    others = (other for other in found if other.beam == step.beam and other.size * step.size < 0.0)
    return any(abs(abs(other.size) - abs(step.size)) <= OTHERS * abs(step.size) for other in others)


def _moving(sheet: Sheet) -> Flags:
    """Return the rows that are not settled, or behind one that is not."""
    still = sheet.settled[:, 0] == 1.0
    return np.asarray(~(still & np.append(True, still[:-1])))


def _whole(sheet: Sheet) -> Flags:
    """Return the rows around which no beam lacks a value, and no gap is."""
    bad = np.isnan(sheet.beams).any(axis=1) | np.isnan(sheet.q[:, 0]) | sheet.fresh[:, 0].astype(bool)
    around = np.lib.stride_tricks.sliding_window_view(np.pad(bad, (2 * NEAR + 1, 2 * NEAR)), 4 * NEAR + 2)
    return np.asarray(~around.any(axis=1))
