"""Cleaning of the measured drift: spikes of one beam, beams that lose count, spikes of the mean; rows at rest only.

One beam against the mean of the other two is free of movement and expansion; what is left is tilt and noise. A beam
that was broken counts on from another value: it alone steps, and stays there. Tilt moves the other two the other way
by half, expansion moves all three alike; so a step is put down to a beam only where the other two moved by less than a
quarter of it. Then it is taken back, and the mean is known again to a third of the usual jump of that beam.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from hexathermal.learn.campaign_columns import BEAMS
from hexathermal.learn.cleaning_channels import PIECE_ROWS
from hexathermal.learn.cleaning_channels import SMALLEST_MOVE_M as SMALLEST_MOVE_M
from hexathermal.learn.cleaning_record import NOTED, REPAIRED, ROW, Ledger
from hexathermal.learn.cleaning_rules import (
    MARGIN,
    SPIKE_RULE,
    TO_SIGMA,
    Flags,
    filled,
    medians_of_five,
    noise_of,
    spikes_in,
)
from hexathermal.learn.cleaning_sheets import Sheet, with_margins
from hexathermal.poses import FloatArray

STEP_SCALES = 10.0
"""A beam steps where it jumps by more than so many usual jumps against the others,"""

SMALLEST_STEP_M = 0.3e-6
"""and by more than this: two quarter wavelengths of a red laser."""

OTHERS = 0.25
"""Share of the step by which the other beams may move with it."""

ALL_LOST_M = 50e-6
"""A jump of the mean drift beyond this between two rows is no expansion: all beams lost count, the rest is useless."""

WORST_REPAIR_M = 0.1e-6
"""A step is taken back only where the mean is then known better than this (standard deviation)."""

JUMP_NOISES = 20.0
"""All beams jump together where the drift of a rest does by more than so many of its noises and `SMALLEST_STEP_M`."""

STEP_RULE = (
    f"one beam alone jumps by more than {STEP_SCALES:g} usual jumps and {SMALLEST_STEP_M * 1e6:g} um and stays there: "
    "its step is taken back"
)
RESTLESS = 3.0
"""A row among movements is held against so many times the scatter of the drift from rest to rest."""


@dataclass(frozen=True, eq=False)
class BeamScales:
    """What is usual of beams: noise [m] of each against the others, their jumps [m], noise of the mean drift [m]."""

    noise: FloatArray
    jump: FloatArray
    at_rest: float
    between: float


def against_others(beams: FloatArray) -> FloatArray:
    """Return each beam less the mean of the others, shape (n, 3)."""
    total = beams.sum(axis=1, keepdims=True)
    return np.asarray(beams - (total - beams) / (beams.shape[1] - 1))


def measured(sheet: Sheet) -> FloatArray:
    """Return the drift as read, up to a constant: mean of the beams less the displacement, or the table's own."""
    if sheet.beams.shape[1]:
        return np.asarray(sheet.beams.mean(axis=1) - sheet.q[:, 0])
    return sheet.drift[:, 0]


def beam_scales(sheet: Sheet, rest: Flags) -> BeamScales:
    """Return what is usual in the first rows of a run; `rest` says which rows rest as the row before."""
    drift = measured(sheet)
    within = rest[1:-1] & rest[2:]
    bend = drift[1:-1] - 0.5 * (drift[:-2] + drift[2:])
    between = float(np.nan_to_num(noise_of(drift[:, None])[0])) if len(drift) > 2 else 0.0
    at_rest = TO_SIGMA * float(np.median(np.abs(bend[within]))) / np.sqrt(1.5) if within.sum() >= 10 else between
    if not sheet.beams.shape[1]:
        return BeamScales(np.zeros(0), np.zeros(0), at_rest, between)
    apart = against_others(sheet.beams)
    jump = _jumps(apart)
    usual = TO_SIGMA * np.median(np.abs(jump), axis=0) if len(jump) else np.zeros(apart.shape[1])
    return BeamScales(np.nan_to_num(noise_of(apart)), usual, at_rest, between)


def _jumps(values: FloatArray) -> FloatArray:
    """Return the median of five rows from a row on less that of the five rows before it, mirrored at the ends."""
    fives = medians_of_five(np.pad(values, ((5, 4), (0, 0)), mode="symmetric"))
    return np.asarray(fives[5:] - fives[:-5])


def without_missing(sheets: Iterator[Sheet], ledger: Ledger) -> Iterator[Sheet]:
    """Leave out rows in which a beam, or the drift, has no value; why was counted where it was taken out."""
    for sheet in sheets:
        lost = np.isnan(np.concatenate([sheet.beams, sheet.drift], axis=1))
        bad = lost.any(axis=1)
        reason = "no value of the drift, or not of all beams: missing, or left out above"
        ledger.note("no drift", "row", ROW, reason, bad, sheet.time[:, 0])
        kept = sheet.take(~bad)
        if len(kept):
            yield kept


class BeamRules:
    """The rules for the measured drift of one run, in rows that are handed on one piece after the other."""

    def __init__(self, scales: BeamScales, ledger: Ledger) -> None:
        self.scales, self.ledger = scales, ledger
        self.offset = np.zeros(len(scales.noise))
        self.lost = False
        self._last: tuple[float, float] | None = None

    def cleaned(self, sheets: Iterator[Sheet]) -> Iterator[Sheet]:
        """Leave out spikes, take back steps of one beam, end the run where all beams lost count."""
        without = self._without_beam_spikes(sheets) if len(self.offset) else sheets
        stepped = self._without_steps(without) if len(self.offset) else without
        yield from self._without_outliers(stepped)

    def _without_beam_spikes(self, sheets: Iterator[Sheet]) -> Iterator[Sheet]:
        """Leave out rows in which one beam has a spike against the others."""
        for sheet, own in with_margins(sheets, PIECE_ROWS, MARGIN):
            apart = against_others(sheet.beams)
            spikes = spikes_in(apart, self.scales.noise)
            rows: Flags = np.asarray(spikes.any(axis=1))
            worst = np.argmax(np.where(spikes, np.abs(apart - np.median(apart, axis=0)), 0.0), axis=1)
            for k in np.unique(worst[own][rows[own]]):
                flags = (rows & (worst == k))[own]
                self.ledger.note("beam spike", BEAMS[k], ROW, f"against the other beams {SPIKE_RULE}", flags,
                                 sheet.time[own, 0])  # fmt: skip
            kept = _kept(sheet, own, ~rows)
            if len(kept):
                yield kept

    def _without_steps(self, sheets: Iterator[Sheet]) -> Iterator[Sheet]:
        """Take back the steps of single beams."""
        for sheet, own in with_margins(sheets, PIECE_ROWS, MARGIN):
            offsets = np.tile(self.offset, (own.stop - own.start, 1))
            for row, k, size in self._steps(sheet, own):
                doubt = self.scales.jump[k] / 3.0
                flags = np.arange(len(sheet)) == row
                if doubt > WORST_REPAIR_M:
                    reason = f"a beam steps and the mean is no better known than {doubt * 1e6:.2f} um behind it"
                    self.ledger.note("beam step", BEAMS[k], NOTED, reason, flags[own], sheet.time[own, 0])
                    continue
                self.ledger.note("beam step", BEAMS[k], REPAIRED, STEP_RULE, flags[own], sheet.time[own, 0])
                offsets[row - own.start :, k] += size
            self.offset = offsets[-1].copy()
            kept = sheet.take(own)
            yield kept.changed(beams=kept.beams - offsets)

    def _steps(self, sheet: Sheet, own: slice) -> list[tuple[int, int, float]]:
        """Return row, beam and size of each step among a piece's own rows."""
        n = len(sheet)
        if n < 10:
            return []
        apart = _jumps(against_others(sheet.beams))[:n]
        limit = np.maximum(STEP_SCALES * self.scales.jump, SMALLEST_STEP_M)
        size = np.abs(apart) / limit
        worst = size.max(axis=1)
        found: list[tuple[int, int, float]] = []
        seen: list[int] = []
        for row in np.flatnonzero(worst > 1.0):
            near = worst[max(0, row - 4) : row + 5]
            if row < 3 or row > n - 3 or worst[row] < near.max():
                continue
            k = int(np.argmax(np.abs(apart[row])))
            sharp = self._sharpest(sheet, int(row), k)
            if not own.start <= sharp < own.stop or any(abs(sharp - other) < 5 for other in seen):
                continue
            seen.append(sharp)
            if self._alone(sheet, sharp, k):
                found.append((sharp, k, self._size(sheet, sharp, k)))
        return found

    def _sharpest(self, sheet: Sheet, row: int, k: int) -> int:
        """Return the row near `row` at which a beam steps."""
        apart = against_others(sheet.beams)[:, k]
        low, high = max(1, row - 3), min(len(apart), row + 4)
        return low + int(np.argmax(np.abs(np.diff(apart[low - 1 : high]))))

    def _alone(self, sheet: Sheet, sharp: int, k: int) -> bool:
        """Whether a beam steps alone at a row; a note is taken where others moved with it."""
        total = self._size(sheet, sharp, k)
        others = [j for j in range(sheet.beams.shape[1]) if j != k]
        level = sheet.beams[:, others] - sheet.q
        before, behind = level[max(0, sharp - 5) : sharp], level[sharp : sharp + 5]
        moved = np.abs(np.median(behind, axis=0) - np.median(before, axis=0))
        alone = bool((moved <= OTHERS * abs(total) + 2.0 * self.scales.at_rest).all())
        if not alone:
            flags = np.arange(len(sheet)) == sharp
            reason = "the beams move apart by more than usual, but not one of them alone: a tilt, or several lost count"
            self.ledger.note("tilt or step", BEAMS[k], NOTED, reason, flags, sheet.time[:, 0])
        return alone

    def _size(self, sheet: Sheet, row: int, k: int) -> float:
        """Return by how much a beam steps against the others at a row."""
        apart = against_others(sheet.beams)[:, k]
        return float(np.median(apart[row : row + 5]) - np.median(apart[max(0, row - 5) : row]))

    def _without_outliers(self, sheets: Iterator[Sheet]) -> Iterator[Sheet]:
        """Leave out spikes of the drift, and all rows behind a jump that no expansion makes."""
        for sheet, own in with_margins(sheets, PIECE_ROWS, MARGIN):
            drift = measured(sheet)
            time = sheet.time[:, 0]
            rest = resting(sheet)
            steady = rest & np.roll(rest, -1) & np.roll(rest, 1) & np.roll(rest, -2)
            noise = np.array([max(self.scales.at_rest, 1e-12)])
            wide = np.array([RESTLESS * max(self.scales.between, self.scales.at_rest, 1e-12)])
            # a drift that the table gives was judged with the other channels
            spikes = np.zeros(len(drift), dtype=bool)
            if sheet.beams.shape[1]:
                spikes = spikes_in(drift[:, None], noise)[:, 0] & steady
                spikes |= spikes_in(drift[:, None], wide)[:, 0]
            self.ledger.note("drift spike", "row", ROW, f"the drift of a rest {SPIKE_RULE}", spikes[own], time[own])
            self.ledger.mark("drift", time[own][spikes[own]], drift[own][spikes[own]])
            level = filled(np.where(spikes, np.nan, drift)[:, None])[:, 0]
            self._note_jumps(level, rest, time, own)
            jump = np.abs(np.diff(level, prepend=level[0])) > ALL_LOST_M
            jump[: own.start] = False
            gone = np.logical_or.accumulate(jump) | self.lost
            reason = f"the drift jumped by more than {ALL_LOST_M * 1e6:g} um from one row to the next: beams lost count"
            self.ledger.note("beams lost", "row", ROW, reason, (gone & ~spikes)[own], time[own])
            self.lost = bool(gone[own][-1])
            kept = _kept(sheet, own, ~(spikes | gone))
            if len(kept):
                yield kept

    def _note_jumps(self, level: FloatArray, rest: Flags, time: FloatArray, own: slice) -> None:
        """Note where the drift of a rest jumps and stays: all beams lost count, or the leg truly slipped."""
        if len(level) < 10:
            return
        windows = np.lib.stride_tricks.sliding_window_view(np.pad(rest, (4, 5)), 10)
        still: Flags = np.all(windows, axis=1)[: len(level)]
        size = np.where(still, np.abs(_jumps(level[:, None])[: len(level), 0]), 0.0)
        limit = max(JUMP_NOISES * self.scales.at_rest, SMALLEST_STEP_M)
        reason = (
            f"the drift of a rest jumps by more than {limit * 1e6:.2f} um and stays there: all beams lost count "
            "together, or the leg slipped; nothing is changed"
        )
        sharp = _sharp(size, limit)
        self.ledger.note("drift step", "row", NOTED, reason, sharp[own], time[own])


def _sharp(size: FloatArray, limit: float) -> npt.NDArray[np.bool_]:
    """Return the rows with the largest of four neighbouring sizes above a limit."""
    around = np.lib.stride_tricks.sliding_window_view(np.pad(size, 4), 9).max(axis=1)
    return np.asarray(np.logical_and(size > limit, size == around), dtype=bool)


def resting(sheet: Sheet) -> Flags:
    """Return which rows rest as the row before them."""
    fresh = sheet.fresh[:, 0].astype(bool)
    if sheet.q.shape[1]:
        moved = np.abs(np.diff(sheet.q[:, 0], prepend=sheet.q[0, 0])) > SMALLEST_MOVE_M
        fresh = fresh | moved
    return np.asarray(~fresh)


def _kept(sheet: Sheet, own: slice, keep: Flags) -> Sheet:
    """Return those of a piece's own rows that are kept; a new landing is not lost with a row that is left out."""
    part = sheet.take(own)
    keep = keep[own]
    fresh = part.fresh[:, 0].astype(bool)
    breaks = np.cumsum(fresh)
    if not keep.any():
        return part.take(keep)
    marked = np.diff(breaks[keep], prepend=0) > 0
    return part.take(keep).changed(fresh=marked[:, None].astype(np.float64))
