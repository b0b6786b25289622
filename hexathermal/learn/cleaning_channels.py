"""Cleaning of the rows of a table: clock, missing values and codes, stuck channels, spikes, rows not settled."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from hexathermal.learn.air import LIMITS
from hexathermal.learn.campaign import Campaign
from hexathermal.learn.campaign_columns import AIR, BEAMS, SI
from hexathermal.learn.cleaning_record import NOTED, ROW, VALUE, Ledger
from hexathermal.learn.cleaning_rules import (
    CODE_RULE,
    MARGIN,
    SPIKE_RULE,
    WEATHER_RULE,
    Flags,
    codes_in,
    filled,
    jumping_ahead,
    medians_of_five,
    spikes_in,
)
from hexathermal.learn.cleaning_sheets import Sheet, stacked, with_margins
from hexathermal.learn.cleaning_stuck import STUCK_RULE, Scales, scales_of, stuck_in
from hexathermal.machine.leg_signals import SMALLEST_MOVE
from hexathermal.poses import FloatArray

UNSETTLED = "settled is not 1: the part moves or still vibrates"
"""Why a row is left out where the table tells it."""

PIECE_ROWS = 8192
"""Rows that are cleaned at a time."""

STUDY_ROWS = 32768
"""Rows from a run's beginning from which the usual noise of its channels is taken."""

GAP_STEPS = 5.0
"""A step in time of more than so many usual steps is a gap."""


DISPLACED_M = 1e-3
"""A displacement that only one row has, or two, is off its neighbours and all beams by more than this."""

DISPLACED_RULE = (
    f"the displacement leaves that of the rows beside it by more than {DISPLACED_M * 1e3:g} mm and comes back, and no "
    "beam does"
)

SMALLEST_MOVE_M = SMALLEST_MOVE
"""A displacement of the rod [m] beyond this from row to row is a movement: another landing."""

NEAR_ROWS = 3
"""So near to a movement heat comes and fades within rows."""


def in_order(sheets: Iterator[Sheet], ledger: Ledger) -> Iterator[Sheet]:
    """Leave out rows whose time is missing, is not after all before, or jumps ahead for one row only."""
    latest = -np.inf
    for sheet, own in with_margins(sheets, PIECE_ROWS, 2):
        time = sheet.time[:, 0]
        missing = np.isnan(time)
        known = np.where(missing, -np.inf, time)
        ahead = np.zeros(len(time), dtype=bool)
        ahead[~missing] = jumping_ahead(time[~missing], latest)
        known = np.where(ahead, -np.inf, known)
        before = np.maximum.accumulate(np.concatenate([[latest], known]))[:-1]
        # rows of the margin in front were seen already: their times are part of `latest`
        start = own.start
        if start:
            before = np.maximum.accumulate(np.concatenate([[latest], known[start:]]))[:-1]
            before = np.concatenate([np.full(start, -np.inf), before])
        same = ~missing & ~ahead & (known == before)
        back = ~missing & ~ahead & (known < before)
        flags = {
            "no time": (missing, "time_s holds no number"),
            "duplicate": (same, "the same time as the row before"),
            "clock disorder": (back, "time_s is before that of an earlier row"),
            "clock jump": (ahead, "time_s jumps ahead in this row and back behind it"),
        }
        for step, (rows, reason) in flags.items():
            ledger.note(step, "row", ROW, reason, rows[own], time[own])
        keep = ~(missing | same | back | ahead)
        kept = sheet.take(own).take(keep[own])
        ledger.rows += own.stop - own.start
        if len(kept):
            latest = float(kept.time[-1, 0])
            if np.isnan(ledger.first_time):
                ledger.first_time = float(kept.time[0, 0])
            ledger.last_time = latest
            yield kept


def studied(sheets: Iterator[Sheet]) -> tuple[list[Sheet], Iterator[Sheet]]:
    """Return the first `STUDY_ROWS` rows, and all rows."""
    first: list[Sheet] = []
    count = 0
    for sheet in sheets:
        first.append(sheet)
        count += len(sheet)
        if count >= STUDY_ROWS:
            break
    study = [stacked(first).take(slice(0, STUDY_ROWS))] if first else []

    def again() -> Iterator[Sheet]:
        yield from first
        first.clear()
        yield from sheets

    return study, again()


def channel_names(campaign: Campaign, sheet: Sheet) -> tuple[str, ...]:
    """Return the columns of the channels that are cleaned, in the order of `_channels`."""
    heat = tuple(f"{name}_degC" for name in campaign.sensors)
    beams = BEAMS[: sheet.beams.shape[1]]
    return (*heat, *beams, *(("drift_um",) if sheet.drift.shape[1] else ()), *AIR)


def _channels(sheet: Sheet) -> FloatArray:
    """Return temperatures, beams, drift and weather side by side."""
    return np.concatenate([sheet.heat, sheet.beams, sheet.drift, sheet.air], axis=1)


class ChannelRules:
    """The rules for single channels, with what is usual in a run.

    Parameters
    ----------
    study : Sheet
        The run's first rows.
    """

    def __init__(self, campaign: Campaign, study: Sheet, ledger: Ledger) -> None:
        self.names = channel_names(campaign, study)
        self.heat = np.array([name.endswith("_degC") for name in self.names])
        self.recorded = ~np.isnan(_channels(study)).all(axis=0) | (np.arange(len(self.names)) < len(self.names) - 3)
        self.ledger = ledger
        self._factors = np.array([SI[name.rpartition("_")[2]][0] for name in self.names])
        self._weather = np.array([name in AIR for name in self.names])
        limits = [LIMITS[name.split("_")[1]][:2] if name in AIR else (-np.inf, np.inf) for name in self.names]
        self._lowest, self._highest = np.array(limits).T
        values = self._without_codes(_channels(study))
        self.scales: Scales = scales_of(values)
        beams = np.array([name in BEAMS for name in self.names])
        self._judged_stuck, self._judged_spikes = ~self._weather, ~beams
        time = study.time[:, 0]
        ledger.sampling = float(np.median(np.diff(time))) if len(time) > 1 else np.nan

    def _codes(self, values: FloatArray) -> Flags:
        """Return where channels hold codes."""
        found = np.where(self.heat, codes_in(values, True), codes_in(values / self._factors, False))
        return np.asarray(found | (values < self._lowest) | (values > self._highest))

    def _without_codes(self, values: FloatArray) -> FloatArray:
        """Return values with codes as NaN."""
        return np.where(self._codes(values), np.nan, values)

    def cleaned(self, sheets: Iterator[Sheet]) -> Iterator[Sheet]:
        """Set values to NaN that break a rule, and mark gaps in time."""
        last = np.nan
        for sheet, own in with_margins(sheets, PIECE_ROWS, MARGIN):
            values = _channels(sheet)
            time = sheet.time[own, 0]
            missing = np.isnan(values)
            codes = self._codes(values)
            clean = np.where(codes, np.nan, values)
            stuck = np.zeros(clean.shape, dtype=bool)
            k = self._judged_stuck
            stuck[:, k] = stuck_in(clean[:, k], self.scales.of(k))
            clean = np.where(stuck, np.nan, clean)
            spikes = np.zeros_like(stuck)
            k = self._judged_spikes
            strict = near_moves(sheet)[:, None] | self._weather[k]
            spikes[:, k] = spikes_in(clean[:, k], self.scales.noise[k], strict)
            self._note(((missing, "missing", "no number in the table"), (codes, "missing code", CODE_RULE),
                        (stuck, "stuck", STUCK_RULE), (spikes, "spike", SPIKE_RULE)), own, time, values)  # fmt: skip
            clean = np.where(spikes, np.nan, clean)[own]
            sheet = _with_channels(sheet.take(own), clean)
            gap = np.diff(time, prepend=last if np.isfinite(last) else time[0]) > GAP_STEPS * self.ledger.sampling
            reason = f"a step in time of more than {GAP_STEPS:g} usual ones lies before the row"
            self.ledger.note("gap", "row", NOTED, reason, gap, time)
            last = float(time[-1])
            yield sheet.changed(fresh=gap[:, None].astype(np.float64))

    def _note(
        self, found: tuple[tuple[Flags, str, str], ...], own: slice, time: FloatArray, values: FloatArray
    ) -> None:
        """Count what was found, channel by channel."""
        for flags, step, reason in found:
            part = flags[own]
            for k in np.flatnonzero(part.any(axis=0) & self.recorded):
                why = WEATHER_RULE if step == "missing code" and self.names[k] in AIR else reason
                self.ledger.note(step, self.names[k], VALUE, why, part[:, k], time)
                if step == "spike":
                    self.ledger.mark(self.names[k], time[part[:, k]], values[own][part[:, k], k])


def near_moves(sheet: Sheet) -> Flags:
    """Return the rows within `NEAR_ROWS` of a movement of the rod; none of a part without one."""
    if not sheet.q.shape[1]:
        return np.zeros(len(sheet), dtype=bool)
    step = np.abs(np.diff(filled(sheet.q)[:, 0])) > SMALLEST_MOVE_M
    padded = np.pad(step, NEAR_ROWS)
    return np.asarray(np.lib.stride_tricks.sliding_window_view(padded, 2 * NEAR_ROWS).any(axis=1))


def _with_channels(sheet: Sheet, values: FloatArray) -> Sheet:
    """Return a sheet with other temperatures, beams, drift and weather."""
    ends = np.cumsum([sheet.heat.shape[1], sheet.beams.shape[1], sheet.drift.shape[1]])
    heat, beams, drift, air = np.split(values, ends, axis=1)
    return sheet.changed(heat=heat, beams=beams, drift=drift, air=air)


def displaced(sheets: Iterator[Sheet], ledger: Ledger) -> Iterator[Sheet]:
    """Leave out displacements that are codes where the rod moves, or that single rows alone have, and no beam.

    Rows that are not settled are used too: what moves warms, and where it went before a rest matters behind it.
    """
    for sheet, own in with_margins(sheets, PIECE_ROWS, MARGIN):
        if not sheet.q.shape[1]:
            yield sheet.take(own)
            continue
        settled = sheet.settled[:, 0] == 1.0 if sheet.settled.shape[1] else np.ones(len(sheet), dtype=bool)
        codes, off = codes_in(sheet.q[:, 0] * 1e3, False) & ~settled, _off_beams(sheet)
        time = sheet.time[own, 0]
        ledger.note("missing code", "q_mm", VALUE, CODE_RULE, codes[own], time)
        ledger.note("spike", "q_mm", VALUE, DISPLACED_RULE, (off & ~codes)[own], time)
        q = np.where((codes | off)[:, None], np.nan, sheet.q)
        yield sheet.take(own).changed(q=q[own])


def _off_beams(sheet: Sheet) -> Flags:
    """Return rows of which the displacement leaves its neighbours and comes back, but the beams do not."""
    n, q = len(sheet), filled(sheet.q)[:, 0]
    if n < 2 * NEAR_ROWS or not sheet.beams.shape[1]:
        return np.zeros(n, dtype=bool)
    apart = filled(sheet.beams) - q[:, None]
    fives = medians_of_five(np.pad(apart, ((5, 5), (0, 0)), mode="edge"))
    before, behind = apart - fives[:n], apart - fives[6:]
    alike = (np.sign(before) == np.sign(behind)).all(axis=1)
    off = alike & (np.minimum(np.abs(before), np.abs(behind)) > DISPLACED_M).all(axis=1)
    around = np.lib.stride_tricks.sliding_window_view(np.pad(q, 2, mode="edge"), 5)[:, [0, 1, 3, 4]]
    return np.asarray(off & ((q > around.max(axis=1) + DISPLACED_M) | (q < around.min(axis=1) - DISPLACED_M)))


def settled_rows(sheets: Iterator[Sheet], ledger: Ledger, why: str) -> Iterator[Sheet]:
    """Leave out rows that are not settled, or without a displacement; mark the rows behind them as fresh."""
    count, last = 0, 0
    for sheet in sheets:
        time = sheet.time[:, 0]
        keep = np.ones(len(sheet), dtype=bool)
        if sheet.settled.shape[1]:
            value = sheet.settled[:, 0]
            unknown, moving = np.isnan(value), value == 0.0
            ledger.note("not settled", "row", ROW, why, moving, time)
            ledger.note("not settled", "row", ROW, "settled holds no number", unknown, time)
            keep &= value == 1.0
        breaks = count + np.cumsum(sheet.fresh[:, 0].astype(bool) | ~keep)
        count = int(breaks[-1])
        if sheet.q.shape[1]:
            value = sheet.q[:, 0]
            bad = keep & (np.isnan(value) | codes_in(value * 1e3, False))
            ledger.note("missing", "q_mm", ROW, "no number, or a missing code", bad, time)
            keep &= ~bad
        if keep.any():
            kept = sheet.take(keep)
            fresh = np.diff(breaks[keep], prepend=last) > 0
            last = int(breaks[keep][-1])
            yield kept.changed(fresh=fresh[:, None].astype(np.float64))
