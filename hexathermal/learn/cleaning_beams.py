"""Cleaning of the measured drift: spikes of one beam, beams that lose count, spikes of the mean; rows at rest only.

One beam against the mean of the other two is free of movement and expansion; what is left is tilt and noise. Tilt goes
with the rod: a row that does not rest with its neighbours is held against what the beams part by from rest to rest.
Steps of beams that lose count stand in `hexathermal.learn.cleaning_steps`.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import numpy.typing as npt

from hexathermal.learn.campaign_columns import BEAMS
from hexathermal.learn.cleaning_beam_scales import BeamScales, against_others, jumps, measured, resting
from hexathermal.learn.cleaning_channels import PIECE_ROWS, near_moves
from hexathermal.learn.cleaning_record import NOTED, ROW, Ledger
from hexathermal.learn.cleaning_rules import (
    MARGIN,
    SPIKE_NOISES,
    SPIKE_RULE,
    Flags,
    filled,
    spikes_in,
)
from hexathermal.learn.cleaning_sheets import Sheet, with_margins
from hexathermal.learn.cleaning_steps import MOVE_TIMES, SMALLEST_STEP_M, STEP_RULE, steps_in, taken_back
from hexathermal.poses import FloatArray

ALL_LOST_M, FASTEST_M_S, MOST_GROWN_M = 50e-6, 0.2e-6, 1e-3
"""A jump of the mean drift beyond this between two rows, and so much more for each second between them up to the last,
is no expansion: all beams lost count, the rest is useless. A metre of steel that is warmed by a kelvin a minute grows
by 0.2 um/s, and by a millimetre at 90 K; rows of movement, which are left out, may last for hours of warming up."""

STRAIN = 1e-3
"""Of a part whose drift is measured where its slide stands, what a metre of way may bring: steel grows so at 90 K."""

LOST = (
    f"the drift jumped by more than {ALL_LOST_M * 1e6:g} um, and {FASTEST_M_S * 1e6:g} um for each second "
    f"({MOST_GROWN_M * 1e3:g} mm at most) from one row to the next"
)
BY_WAY = f", and {STRAIN * 1e3:g} mm for each metre of way"
GROWN = (
    f"the drift jumps by more than {ALL_LOST_M * 1e6:g} um while no row may be used: the part warmed up meanwhile, or "
    "count was lost; nothing is changed"
)

JUMP_NOISES = 20.0
"""All beams jump together where the drift of a rest does by more than so many of its noises and `SMALLEST_STEP_M`."""

ABRUPT = 0.8
"""Share of a step of the drift that two rows make."""

RESTLESS = 3.0
"""A row among movements is held against so many times the scatter of drift, or beams, from rest to rest;
beams also against `MOVE_TIMES` times what they part by where the rod moves."""


def without_missing(sheets: Iterator[Sheet], ledger: Ledger) -> Iterator[Sheet]:
    """Leave out rows in which a beam, or the drift, has no value; why was counted where it was taken out."""
    for sheet in sheets:
        lost = np.isnan(np.concatenate([sheet.beams, sheet.drift], axis=1))
        bad = lost.any(axis=1)
        values = "no value of the drift, or not of all beams" if sheet.beams.shape[1] else "no value of the drift"
        reason = f"{values}: missing, or left out above"
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
        tilts = scales.tilts.size
        usual = float(np.quantile(tilts, 0.9)) if len(tilts) else 0.0
        self._restless = np.maximum(RESTLESS * scales.between, MOVE_TIMES * usual / SPIKE_NOISES)

    def cleaned(self, sheets: Iterator[Sheet]) -> Iterator[Sheet]:
        """Leave out spikes, take back steps of one beam, end the run where all beams lost count."""
        without = self._without_beam_spikes(sheets) if len(self.offset) else sheets
        stepped = self._without_steps(without) if len(self.offset) else without
        yield from self._without_outliers(stepped)

    def _without_beam_spikes(self, sheets: Iterator[Sheet]) -> Iterator[Sheet]:
        """Leave out rows in which one beam has a spike against the others."""
        for sheet, own in with_margins(sheets, PIECE_ROWS, MARGIN):
            apart = against_others(sheet.beams)
            steady = _steady(sheet)[:, None]
            strict = np.broadcast_to(near_moves(sheet)[:, None], apart.shape)
            spikes = spikes_in(apart, self.scales.noise, strict) & steady
            spikes |= spikes_in(apart, self._restless, strict)
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
            steps = steps_in(sheet, own, self.scales)
            kept, self.offset = taken_back(sheet, own, steps, self.offset, self.ledger, STEP_RULE)
            yield kept

    def _without_outliers(self, sheets: Iterator[Sheet]) -> Iterator[Sheet]:
        """Leave out spikes of the drift, and all rows behind a jump that no expansion makes."""
        for sheet, own in with_margins(sheets, PIECE_ROWS, MARGIN):
            drift = measured(sheet)
            time = sheet.time[:, 0]
            rest, steady = resting(sheet), _steady(sheet)
            noise = np.array([max(self.scales.at_rest, 1e-12)])
            wide = np.array([RESTLESS * max(self.scales.drift_between, self.scales.at_rest, 1e-12)])
            # a drift that the table gives was judged with the other channels
            spikes = np.zeros(len(drift), dtype=bool)
            if sheet.beams.shape[1]:
                spikes = spikes_in(drift[:, None], noise)[:, 0] & steady
                spikes |= spikes_in(drift[:, None], wide)[:, 0]
            self.ledger.note("drift spike", "row", ROW, f"the drift of a rest {SPIKE_RULE}", spikes[own], time[own])
            self.ledger.mark("drift", time[own][spikes[own]], drift[own][spikes[own]])
            level = filled(np.where(spikes, np.nan, drift)[:, None])[:, 0]
            self._note_jumps(level, rest, time, own)
            # a part is measured where it stands, a leg beside what its scale reads
            way = STRAIN * sheet.q[:, 0] if sheet.q.size and not sheet.beams.shape[1] else np.zeros(len(drift))
            jump, grown = _jumped(drift, time, way, ~spikes)
            jump[: own.start] = False
            gone = np.logical_or.accumulate(jump) | self.lost
            name, sensor = ("beams", "beams") if len(self.scales.noise) else ("count", "the displacement sensor")
            reason = f"{LOST}{BY_WAY if way.any() else ''}: {sensor} lost count"
            self.ledger.note(f"{name} lost", "row", ROW, reason, (gone & ~spikes)[own], time[own])
            self.ledger.note("drift step", "row", NOTED, GROWN, (grown & ~gone)[own], time[own])
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
        size = np.where(still, np.abs(jumps(level[:, None])[: len(level), 0]), 0.0)
        # what a steady slope makes in ten rows is no step: two rows must make the most of it
        made = np.abs(level[2:] - level[:-2])
        around = np.lib.stride_tricks.sliding_window_view(np.pad(made, 3), 5).max(axis=1)
        size = np.where(around >= ABRUPT * size, size, 0.0)
        limit = max(JUMP_NOISES * self.scales.at_rest, SMALLEST_STEP_M)
        slipped = (
            "all beams lost count together, or the leg slipped"
            if len(self.scales.noise)
            else "the displacement sensor lost count, or the part slipped"
        )
        jumped = f"the drift of a rest jumps by more than {limit * 1e6:.2f} um and stays there"
        reason = f"{jumped}: {slipped}; nothing is changed"
        sharp = _sharp(size, limit)
        self.ledger.note("drift step", "row", NOTED, reason, sharp[own], time[own])


def _jumped(drift: FloatArray, time: FloatArray, way: FloatArray, sound: Flags) -> tuple[Flags, Flags]:
    """Return the rows whose drift is farther from the sound row before than anything expands meanwhile; or may be.

    `way` is what expansion may bring on the way of a slide [m], and counts against the jump.
    """
    rows = np.flatnonzero(sound)
    jump, allowed = np.abs(np.diff(drift[rows])), np.minimum(FASTEST_M_S * np.diff(time[rows]), MOST_GROWN_M)
    jump = jump - np.abs(np.diff(way[rows]))
    lost, grown = np.zeros((2, len(drift)), dtype=bool)
    lost[rows[1:]] = jump > ALL_LOST_M + allowed
    grown[rows[1:]] = (jump > ALL_LOST_M) & ~lost[rows[1:]]
    return lost, grown


def _sharp(size: FloatArray, limit: float) -> npt.NDArray[np.bool_]:
    """Return the rows with the largest of four neighbouring sizes above a limit."""
    around = np.lib.stride_tricks.sliding_window_view(np.pad(size, 4), 9).max(axis=1)
    return np.asarray(np.logical_and(size > limit, size == around), dtype=bool)


def _steady(sheet: Sheet) -> Flags:
    """Return the rows whose neighbours rest with them, one before and two behind."""
    rest = resting(sheet)
    return np.asarray(rest & np.roll(rest, -1) & np.roll(rest, 1) & np.roll(rest, -2))


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
