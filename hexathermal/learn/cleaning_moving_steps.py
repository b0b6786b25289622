"""Beams that lose count while the rod moves: most do so there, where the mean of the beams tells nothing.

The difference of one beam and the others is free of movement, so that it shows a lost count in rows that are not
settled as well as in a rest: one beam against both others alike, once, within one row. Tilt goes with the rod or with
heat, and takes many rows; where it turns over at a reversal, it does so at each of them.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from hexathermal.learn.campaign_columns import BEAMS
from hexathermal.learn.cleaning_beam_scales import FEWEST, against_others, jumps
from hexathermal.learn.cleaning_channels import PIECE_ROWS
from hexathermal.learn.cleaning_record import BEAM_STEP, REPAIRED, BeamStep, Ledger
from hexathermal.learn.cleaning_rules import MARGIN, TO_SIGMA, Flags, filled
from hexathermal.learn.cleaning_sheets import Sheet, with_margins
from hexathermal.learn.cleaning_steps import MOVE_STEP_M, MOVE_TIMES, OTHERS, STEP_SCALES, Step, doubt, made, sharpest
from hexathermal.poses import FloatArray

MOST_LOST = 3
"""Times that beams may lose count in a run's first rows: more jumps than these are what the beams do by themselves."""

NEAR = 5
"""Rows within which jumps are one."""

MOVING_RULE = (
    f"while the rod moves, one beam alone jumps against the others within one row by more than {MOVE_STEP_M * 1e6:g} "
    f"um, {STEP_SCALES:g} usual jumps and {MOVE_TIMES:g} times all but {MOST_LOST} others: its step is taken back"
)


@dataclass(frozen=True)
class MovingScales:
    """What is usual of beams in rows that are not settled: their jumps against the others, and a limit to them [m]."""

    usual: float
    limit: float


def without_moving_steps(study: Sheet, sheets: Iterator[Sheet], ledger: Ledger) -> Iterator[Sheet]:
    """Take back the steps of single beams in rows that are not settled.

    Parameters
    ----------
    study : Sheet
        A run's first rows, which tell what is usual.
    sheets : iterator of Sheet
        All its rows.
    ledger : Ledger
    """
    scales = _scales(study) if study.settled.shape[1] and study.beams.shape[1] else None
    if scales is None:
        yield from sheets
        return
    offset = np.zeros(study.beams.shape[1])
    for sheet, own in with_margins(sheets, PIECE_ROWS, MARGIN):
        offsets = np.tile(offset, (own.stop - own.start + 1, 1))  # and of the row behind
        for step in _steps_in(sheet, own, scales):
            first = step.row - own.start
            offsets[first:, step.beam] += step.size
            if step.part:
                offsets[first - 1, step.beam] += step.part
            time = sheet.time[step.row]
            ledger.beam_steps.append(BeamStep(BEAMS[step.beam], float(time[0]), step.size, step.error, step.at_rest))
            ledger.note(BEAM_STEP, BEAMS[step.beam], REPAIRED, MOVING_RULE, np.ones(1, dtype=bool), time)
        offset = offsets[-1].copy()
        kept = sheet.take(own)
        yield kept.changed(beams=kept.beams - offsets[:-1])


def _scales(study: Sheet) -> MovingScales | None:
    """Return what is usual of the beams while the rod moves; None where it hardly does."""
    moving = _moving(study)
    if moving.sum() < FEWEST:
        return None
    jump = jumps(against_others(filled(study.beams)))[: len(study)]
    size = np.where(moving, np.abs(jump).max(axis=1), 0.0)
    usual = TO_SIGMA * float(np.median(size[moving]))
    peaks: list[int] = []
    for row in np.argsort(-size):
        if all(abs(row - other) >= NEAR for other in peaks):
            peaks.append(int(row))
        if len(peaks) > MOST_LOST:
            break
    largest = float(size[peaks[-1]]) if len(peaks) > MOST_LOST else 0.0
    return MovingScales(usual, max(MOVE_STEP_M, STEP_SCALES * usual, MOVE_TIMES * largest))


def _steps_in(sheet: Sheet, own: slice, scales: MovingScales) -> list[Step]:
    """Return the steps that begin in a piece's own rows."""
    found: list[Step] = []
    if len(sheet) < 2 * NEAR or doubt(scales.usual):
        return found
    apart = against_others(filled(sheet.beams))
    jump = jumps(apart)[: len(sheet)]
    size = np.where(_moving(sheet), np.abs(jump).max(axis=1), 0.0)
    for row in np.flatnonzero(size > scales.limit):
        if size[row] < size[max(0, row - NEAR + 1) : row + NEAR].max():
            continue
        k = int(np.argmax(np.abs(jump[row])))
        sharp = sharpest(apart[:, k], int(row))
        level = np.median(apart[max(0, sharp - NEAR) : sharp], axis=0)
        steps = np.median(apart[sharp : sharp + NEAR], axis=0) - level
        sharp, part, once = made(apart[:, k] - level[k], sharp, float(steps[k]))
        begins = own.start <= sharp - (part != 0.0) < own.stop
        if once and begins and _alone(steps, k) and all(abs(sharp - other.row) >= NEAR for other in found):
            found.append(Step(sharp, k, float(steps[k]), scales.usual, at_rest=False, part=part))
    return found


def _moving(sheet: Sheet) -> Flags:
    """Return the rows that are not settled, or behind one that is not."""
    still = sheet.settled[:, 0] == 1.0
    return np.asarray(~(still & np.append(True, still[:-1])))


def _alone(step: FloatArray, k: int) -> bool:
    """Whether both others stayed: against them a beam steps by all, and each of them by half of it the other way."""
    others = np.delete(step, k)
    return bool((np.abs(others + 0.5 * step[k]) <= OTHERS * abs(step[k])).all())
