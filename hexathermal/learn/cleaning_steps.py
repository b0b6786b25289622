"""Beams that lose count: which steps of one beam are taken back, and which are only told.

A beam that was broken counts on from another value: it alone steps, once, within one row, and stays there. Tilt parts
the beams too, and where they do not stand evenly about the leg it may move one of them alone; but it goes with the
displacement or the temperatures: it parts them at every movement, and at rest it creeps. So a step is put down to a
beam

- within a rest, where it is made from one row to the next, or to the next but one where a row averages over its
  interval, and the other two beams moved by less than a quarter of it;
- at a movement of the rod, or beside a gap, only where besides it is several times larger than what the beams part by
  at the other movements of that size and length, these leave the mean known well enough, and the beam is off by as much
  between rows before and behind in which the rod stands at about one place: tilt that goes with the rod comes back.

What is taken back is what the beam stepped by against the others; the mean is then known again to a third of what the
beams part by of themselves.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from hexathermal.learn.campaign_columns import BEAMS
from hexathermal.learn.cleaning_beam_scales import BeamScales, against_others, jumps, resting, span_at
from hexathermal.learn.cleaning_record import BEAM_STEP, NOTED, REPAIRED, BeamStep, Ledger
from hexathermal.learn.cleaning_returns import OTHERS, stays
from hexathermal.learn.cleaning_rules import Flags
from hexathermal.learn.cleaning_sheets import Sheet
from hexathermal.poses import FloatArray

STEP_SCALES = 10.0
"""A beam steps where it jumps by more than so many usual jumps against the others,"""

SMALLEST_STEP_M = 0.3e-6
"""and by more than this: two quarter wavelengths of a red laser."""

ONE_ROW = 0.8
"""Share of a step within a rest that one row must make, or two: the one within which it fell is its mean,"""

REST_ROWS = 3
"""with so many rows of the rest before and from it on; any other step is one at a movement."""

MOVE_STEP_M = 1e-6
"""At a movement a step is larger than this,"""

MOVE_TIMES = 3.0
"""and so many times the 90 % quantile of what the beams part by at other movements of that size,"""

FEWEST_MOVES, ALIKE = 5, 0.5
"""of which there must be so many: of at least this share of its reach, and of the time that its ten rows span."""

WORST_REPAIR_M = 0.1e-6
"""A step is taken back only where the mean is then known better than this (standard deviation)."""

STEP_RULE = (
    f"one beam alone jumps by more than {STEP_SCALES:g} usual jumps and {SMALLEST_STEP_M * 1e6:g} um from one row of a "
    "rest to the next, or the next but one, and stays there (at a movement: by more than "
    f"{MOVE_STEP_M * 1e6:g} um and {MOVE_TIMES:g} times what the beams part by at others as far and long, also "
    "where the rod is back at a place where it stood before): its step is taken back"
)
NOT_ALONE = "the beams move apart by more than usual, but not one of them alone: a tilt, or several lost count"
NOT_SHARP = "one beam moves away from the others over three or more rows of a rest: a tilt that creeps"
AS_OTHERS = (
    "one beam moves away from the others where the rod moves, by no more than tilt at such a movement might, or "
    "only as long as the rod is there: nothing is changed"
)


@dataclass(frozen=True)
class Step:
    """A step of a beam: its row and size [m], and why it is not taken back, or nothing.

    `error` [m] is what the beams part by of themselves there; `at_rest` says whether it is within a rest; `part` is
    what the row before has of it [m], within which the beam stepped.
    """

    row: int
    beam: int
    size: float
    error: float
    at_rest: bool
    kept: str = ""
    part: float = 0.0


def steps_in(sheet: Sheet, own: slice, scales: BeamScales) -> list[Step]:
    """Return the steps of beams that begin in a piece's own rows, those that are only told too."""
    n = len(sheet)
    if n < 10:
        return []
    apart = against_others(sheet.beams)
    jump = jumps(apart)[:n]
    rest = resting(sheet)
    calm = np.maximum(STEP_SCALES * scales.calm, SMALLEST_STEP_M)
    limit = np.where(_within(rest)[:, None], calm, np.maximum(STEP_SCALES * scales.jump, SMALLEST_STEP_M))
    worst = (np.abs(jump) / limit).max(axis=1)
    found: list[Step] = []
    for row in np.flatnonzero(worst > 1.0):
        near = worst[max(0, row - 4) : row + 5]
        if row < 3 or row > n - 3 or worst[row] < near.max():
            continue
        k = int(np.argmax(np.abs(jump[row])))
        sharp = sharpest(apart[:, k], int(row))
        before, behind, within = _beside(rest, sharp)
        size = float(np.median(apart[behind, k]) - np.median(apart[before, k]))
        against = np.median(apart[behind], axis=0) - np.median(apart[before], axis=0)
        single = alone(against, size, k) and _others_stay(sheet, k, before, behind, size, scales.at_rest)
        why, error = "" if single else NOT_ALONE, float(scales.calm[k])
        part = 0.0
        if within and not why:
            level = float(np.median(apart[before, k]))
            sharp, part, once = made(apart[:, k] - level, sharp, size)
            why = doubt(error) if once and abs(size) > calm[k] else NOT_SHARP
        elif not why:
            why, error = _at_movement(sheet, sharp, abs(size), k, scales)
        if all(abs(sharp - other.row) >= 5 for other in found):
            found.append(Step(sharp, k, size, error, within, why, part))
    own_steps = [one for one in found if own.start <= one.row - (one.part != 0.0) < own.stop]
    q = sheet.q[:, 0]
    return [one if one.kept or still_there(one, found, q, apart) else replace(one, kept=AS_OTHERS) for one in own_steps]


def still_there(step: Step, found: Sequence[Step], q: FloatArray, apart: FloatArray) -> bool:
    """Return whether a step is one within a rest, or still there where the rod is back, beside all that were found."""
    lost = [(one.row, one.beam, one.size) for one in found if not one.kept]
    return step.at_rest or stays(q, apart, (step.row, step.beam, step.size), step.error, lost)


def taken_back(
    sheet: Sheet, own: slice, steps: list[Step], offset: FloatArray, ledger: Ledger, rule: str
) -> tuple[Sheet, FloatArray]:
    """Return a piece's own rows without the steps that begin in them, and what the rows behind are off by, (3,) [m].

    Parameters
    ----------
    sheet : Sheet
        With its margins.
    own : slice
    steps : list of Step
        Those that are kept are only noted.
    offset : array, shape (3,) [m]
        By steps before.
    ledger : Ledger
    rule : str
        By which steps are taken back.
    """
    offsets = np.tile(offset, (own.stop - own.start + 1, 1))  # and of the row behind
    for step in steps:
        flags = np.arange(len(sheet)) == min(step.row, own.stop - 1)
        name, action, reason = BEAM_STEP, REPAIRED, rule
        if step.kept:
            name, action, reason = "tilt or step", NOTED, step.kept
        else:
            offsets[step.row - own.start :, step.beam] += step.size
            if step.part:
                offsets[step.row - 1 - own.start, step.beam] += step.part
            moment = float(sheet.time[step.row, 0])
            ledger.beam_steps.append(BeamStep(BEAMS[step.beam], moment, step.size, step.error, step.at_rest))
        ledger.note(name, BEAMS[step.beam], action, reason, flags[own], sheet.time[own, 0])
    kept = sheet.take(own)
    return kept.changed(beams=kept.beams - offsets[:-1]), offsets[-1].copy()


def made(level: FloatArray, sharp: int, size: float) -> tuple[int, float, bool]:
    """Return the first row that has the whole of a step, what the row before has of it, and whether that is all."""
    whole = ONE_ROW * abs(size)
    if abs(level[sharp] - level[sharp - 1]) >= whole:
        return sharp, 0.0, True
    for row in (sharp, sharp + 1):
        if row < len(level) and abs(level[row] - level[row - 2]) >= whole and 0.0 < level[row - 1] / size < 1.0:
            return row, float(level[row - 1]), True
    return sharp, 0.0, False


def sharpest(apart: FloatArray, row: int) -> int:
    """Return the row near `row` at which a beam steps."""
    low, high = max(1, row - 3), min(len(apart), row + 4)
    return low + int(np.argmax(np.abs(np.diff(apart[low - 1 : high]))))


def _beside(rest: Flags, sharp: int) -> tuple[slice, slice, bool]:
    """Return up to five rows before a row and from it on, and whether they are `REST_ROWS` or more of one rest each."""
    moves = np.flatnonzero(~rest)
    at = int(np.searchsorted(moves, sharp, side="right"))
    begun = int(moves[at - 1]) if at else 0
    left = int(moves[at]) if at < len(moves) else len(rest)
    if sharp - begun >= REST_ROWS and left - sharp >= REST_ROWS:
        return slice(max(begun, sharp - 5), sharp), slice(sharp, min(left, sharp + 5)), True
    return slice(max(0, sharp - 5), sharp), slice(sharp, sharp + 5), False


def _within(rest: Flags) -> Flags:
    """Return the rows with `REST_ROWS` rows of their rest before and from it on."""
    windows = np.lib.stride_tricks.sliding_window_view(np.pad(rest, REST_ROWS - 1), 2 * REST_ROWS - 1)
    return np.asarray(windows.all(axis=1))


def alone(step: FloatArray, size: float, k: int) -> bool:
    """Whether a beam steps by a size and both others stay: against it each goes by half of that the other way."""
    expected = np.full(len(step), -0.5 * size)
    expected[k] = size
    return bool((np.abs(step - expected) <= OTHERS * abs(size)).all())


def _others_stay(sheet: Sheet, k: int, before: slice, behind: slice, size: float, noise: float) -> bool:
    """Whether the other beams do not step with one, nor all of them together."""
    others = [j for j in range(sheet.beams.shape[1]) if j != k]
    level = sheet.beams[:, others] - sheet.q
    moved = np.abs(np.median(level[behind], axis=0) - np.median(level[before], axis=0))
    return bool((moved <= OTHERS * abs(size) + 2.0 * noise).all())


def _at_movement(sheet: Sheet, sharp: int, size: float, k: int, scales: BeamScales) -> tuple[str, float]:
    """Return why a step at a movement is not taken back, nothing where it is, and what beams part by there [m]."""
    tilts, time = scales.tilts, sheet.time[:, 0]
    reach, lasted = (span_at(values, sharp) for values in (sheet.q[:, 0], time))
    near = (tilts.time >= time[max(0, sharp - 6)]) & (tilts.time <= time[min(len(time) - 1, sharp + 6)])
    others = tilts.size[~near & (tilts.reach >= ALIKE * reach) & (tilts.lasted >= ALIKE * lasted)]
    if len(others) < FEWEST_MOVES:
        return AS_OTHERS, float(scales.jump[k])
    usual = float(np.quantile(others, 0.9))
    # the 90 % quantile of the size of a normal deviate is 1.645 of its standard deviation
    error = max(float(scales.jump[k]), usual / 1.645)
    return AS_OTHERS if size <= max(MOVE_STEP_M, MOVE_TIMES * usual) else doubt(error), error


def doubt(apart: float) -> str:
    """Return that the mean would be known too badly by what beams part by of themselves [m]; nothing where not."""
    error = apart / 3.0
    if error <= WORST_REPAIR_M:
        return ""
    return f"a beam steps and the mean is no better known than {error * 1e6:.2f} um behind it"
