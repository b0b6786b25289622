"""Rows of a run that may be used: cleaned, zeroed, numbered by rest, as a stream in constant memory.

The order of the steps: clock; missing values, missing codes, stuck channels and spikes of each channel; beams that lose
count while the rod moves; rows that are not settled, or move; beams that spike or lose count; the index of air; the
zero. Each leaves a reason and a count in a `CleaningRecord`. A value that is left out is NaN in `Block.dT`; a row
without a drift is left out. Tables are never altered, and what comes out does not depend on the size of the blocks.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from hexathermal.errors import ArgumentError, DataError, HexathermalError, Problem, UnknownNameError
from hexathermal.learn.campaign import AIR_COLUMN, Block, Campaign, RunFile, joined
from hexathermal.learn.campaign_columns import AIR
from hexathermal.learn.campaign_faults import CampaignError, Faults
from hexathermal.learn.campaign_streams import RunTable
from hexathermal.learn.cleaning_beam_scales import beam_scales, measured, resting
from hexathermal.learn.cleaning_beams import BeamRules, without_missing
from hexathermal.learn.cleaning_channels import (
    UNSETTLED,
    ChannelRules,
    displaced,
    in_order,
    settled_rows,
    studied,
)
from hexathermal.learn.cleaning_landings import Landings
from hexathermal.learn.cleaning_moving_steps import without_moving_steps
from hexathermal.learn.cleaning_record import NOTED, ROW, CleaningRecord, Ledger
from hexathermal.learn.cleaning_rests import MOVES, with_rests
from hexathermal.learn.cleaning_sheets import Sheet, sheets_of
from hexathermal.learn.interferometer import corrected_beams, index_along_run
from hexathermal.poses import FloatArray

BLOCK_ROWS = 16384
"""Rows of a block, unless asked otherwise."""

OLDEST_WEATHER_S = 600.0
"""A missing reading of the weather is taken from the last one, if that is no older."""

LEAST_USED = 0.1
"""Share of a run's rows, those of movements apart, that must be left after cleaning for the run to be used."""

LARGEST_START_M = 1e-4
"""A run that begins farther off the campaign's first row does not count from there."""


@dataclass(frozen=True, eq=False)
class Zero:
    """The row that a run counts from; temperatures [degC], beams [m], displacement [m], drift [m], index of air."""

    heat: FloatArray
    beams: FloatArray
    q: float
    drift: float
    index: float


class UsableBlocks(Iterator[Block]):
    """The usable rows of a run, block by block.

    Attributes
    ----------
    record : CleaningRecord
        What was left out; whole once the last block has passed.
    zero : Zero or None
        What the run counts from; None before the first block.
    """

    def __init__(
        self, campaign: Campaign, run: RunFile | str, rows: int = BLOCK_ROWS, least: float = LEAST_USED
    ) -> None:
        if campaign.kind == "hexapod":
            raise ArgumentError(
                "a campaign of kind 'hexapod' measures poses, not the drift of one leg; read it with read_run"
            )
        if rows < 1:
            raise ArgumentError(f"rows of a block must be 1 or more, found {rows}")
        self.campaign, self.run = campaign, run_named(campaign, run)
        self._ledger, self._least = Ledger(), least
        self.zero: Zero | None = None
        self.air_sensor: str | None = None
        self._table: RunTable | None = None
        self._blocks = self._cut(rows)

    @property
    def record(self) -> CleaningRecord:
        """What was left out, repaired or noticed up to here."""
        return self._ledger.record(self.run.name)

    @property
    def spikes(self) -> dict[str, FloatArray]:
        """Spikes left out up to here: of each column time [s] and value in the core's units, shape (n, 2)."""
        return self._ledger.marks

    @property
    def done(self) -> float:
        """Which part of the table has been read, 0 to 1."""
        return 0.0 if self._table is None else self._table.done()

    def __next__(self) -> Block:
        return next(self._blocks)

    def _cut(self, rows: int) -> Iterator[Block]:
        """Return blocks of `rows` rows."""
        held: list[Block] = []
        for block in self._zeroed():
            held.append(block)
            while sum(map(len, held)) >= rows:
                whole = joined(held)
                yield _part(whole, slice(0, rows))
                held = [_part(whole, slice(rows, None))]
        if sum(map(len, held)):
            yield joined(held)
        if self._least > 0.0 and is_lost(self.record, self._least):
            raise _lost_runs(self.campaign, self.run, self.record, self._least)

    def _clean(self) -> Iterator[Sheet]:
        """Return the cleaned rows, not zeroed yet."""
        table = self._table = RunTable(self.campaign, self.run)
        study, sheets = studied(in_order(sheets_of(self.campaign, table), self._ledger))
        if not study:
            return
        rules = ChannelRules(self.campaign, study[0], self._ledger)
        sheets = without_moving_steps(displaced(rules.cleaned(sheets), self._ledger), self._ledger)
        whole = self._watched(self._aired(sheets, table))
        why = UNSETTLED if any(column.part == "settled" for column in table.columns) else MOVES
        good = without_missing(settled_rows(with_rests(whole), self._ledger, why), self._ledger)
        first, rest = studied(good)
        if not first:
            return
        beams = BeamRules(beam_scales(first[0], resting(first[0])), self._ledger)
        study.clear()
        first.clear()
        yield from self._with_weather(beams.cleaned(rest))

    def _aired(self, sheets: Iterator[Sheet], table: RunTable) -> Iterator[Sheet]:
        """Fill in the air's temperature where a thermocouple that hangs in the room tells it."""
        column = self.campaign.air_column([column.name for column in table.columns])
        if column in (None, AIR_COLUMN):
            yield from sheets
            return
        self.air_sensor = self.campaign.air_thermometer
        at = self.campaign.sensors.index(str(self.air_sensor))
        for sheet in sheets:
            yield sheet.changed(air=np.column_stack([sheet.heat[:, at], sheet.air[:, 1:]]))

    def _watched(self, sheets: Iterator[Sheet]) -> Iterator[Sheet]:
        """Hand on all rows, those of movements too; who needs them looks here."""
        return sheets

    def _with_weather(self, sheets: Iterator[Sheet]) -> Iterator[Sheet]:
        """Fill short gaps of the weather where the beams must be corrected by it; leave out rows without."""
        if not self._corrects:
            yield from sheets
            return
        last, age = np.full((1, 3), np.nan), np.full((1, 3), -np.inf)
        for sheet in sheets:
            values = np.concatenate([last, sheet.air])
            times = np.concatenate([age, np.broadcast_to(sheet.time, sheet.air.shape)])
            known = np.where(np.isnan(values), 0, np.arange(len(values))[:, None])
            known = np.maximum.accumulate(known, axis=0)
            held, since = np.take_along_axis(values, known, 0), np.take_along_axis(times, known, 0)
            last, age = held[-1:], since[-1:]
            held = np.where(sheet.time - since[1:] <= OLDEST_WEATHER_S, held[1:], np.nan)
            bad, time = np.isnan(held).any(axis=1), sheet.time[:, 0]
            for k, name in enumerate(AIR):
                reason = f"no reading of the weather: the last one, at most {OLDEST_WEATHER_S:g} s old, is used"
                self._ledger.note("weather held", name, NOTED, reason, np.isnan(sheet.air[:, k]) & ~bad, time)
            reason = f"no weather for {OLDEST_WEATHER_S:g} s: the beams cannot be corrected for the index of air"
            self._ledger.note("no weather", "row", ROW, reason, bad, time)
            kept = sheet.changed(air=held).take(~bad)
            if len(kept):
                yield kept

    @property
    def _corrects(self) -> bool:
        """Whether the beams must be corrected for the index of air."""
        beams = self.campaign.beams
        return self.campaign.kind == "leg" and beams is not None and not beams.index_compensated

    def _zeroed(self) -> Iterator[Block]:
        """Return the cleaned rows as blocks that count from the zero."""
        zero: Zero | None = None
        landings = Landings()
        for sheet in self._clean():
            if zero is None:
                self._ledger.zero_time = float(sheet.time[0, 0])
                zero = self._zero(sheet)
                self._note_zero(sheet)
                self._refuse_own_zero(sheet, zero)
            late = np.isnan(zero.heat) & ~np.isnan(sheet.heat).all(axis=0)
            if late.any():
                zero = self._later_zero(zero, sheet, late)
            self.zero = zero
            self._ledger.used += len(sheet)
            yield self._block(sheet, zero, landings.numbered(sheet))

    def _zero(self, sheet: Sheet) -> Zero:
        """Return the zero of the run that begins with a sheet."""
        if self.campaign.zero == "campaign" and self.run != self.campaign.runs[0]:
            first = UsableBlocks(self.campaign, self.campaign.runs[0])
            for other in first._clean():
                return first._zero(other)
            raise _no_zero(self.campaign, first.record)
        index = float(self._index(sheet.take(slice(0, 1)))[0])
        q = float(sheet.q[0, 0]) if sheet.q.shape[1] else 0.0
        return Zero(sheet.heat[0].copy(), sheet.beams[0].copy(), q, float(measured(sheet)[0]), index)

    def _later_zero(self, zero: Zero, sheet: Sheet, late: npt.NDArray[np.bool_]) -> Zero:
        """Return the zero with the first values of channels that had none at the first row."""
        heat = zero.heat.copy()
        for k in np.flatnonzero(late):
            row = int(np.argmax(~np.isnan(sheet.heat[:, k])))
            heat[k] = sheet.heat[row, k]
            reason = "the channel has no value at the zero; it counts from its first value behind it"
            flags = np.arange(len(sheet)) == row
            self._ledger.note("zero", f"{self.campaign.sensors[k]}_degC", NOTED, reason, flags, sheet.time[:, 0])
        return Zero(heat, zero.beams, zero.q, zero.drift, zero.index)

    def _note_zero(self, sheet: Sheet) -> None:
        """Say so where the run does not count from its first row."""
        if self._ledger.zero_time > self._ledger.first_time and self.campaign.zero == "run":
            flags = np.arange(len(sheet)) == 0
            reason = "the table's first row may not be used: temperatures and drift count from the first that may"
            self._ledger.note("zero", "row", NOTED, reason, flags, sheet.time[:, 0])

    def _refuse_own_zero(self, sheet: Sheet, zero: Zero) -> None:
        """Refuse a run whose beams count from its own first row in a campaign whose runs count from the first run."""
        start = float(measured(sheet)[0]) - zero.drift
        if sheet.beams.shape[1] and abs(start) > LARGEST_START_M:
            raise DataError(
                f"run {self.run.name!r} begins {start * 1e3:.3f} mm off the first row of the campaign: its beams count "
                'from its own first row; write zero = "run" in campaign.toml'
            )

    def _index(self, sheet: Sheet) -> FloatArray:
        """Return the index of air of each row, 1 where the laser's electronics applied it."""
        if not self._corrects:
            return np.ones(len(sheet))
        return index_along_run(sheet.air, run=self.run.name)

    def _block(self, sheet: Sheet, zero: Zero, landing: npt.NDArray[np.int64]) -> Block:
        """Return a sheet as a block."""
        q = sheet.q[:, 0] if sheet.q.shape[1] else None
        drift = measured(sheet) - zero.drift
        if self._corrects:
            assert q is not None
            assert self.campaign.beams is not None
            back = corrected_beams(sheet.beams - zero.beams, q, self._index(sheet), zero_index=zero.index,
                                   zero_q=zero.q, dead_path=self.campaign.beams.dead_path)  # fmt: skip
            drift = back.mean(axis=1) - (q - zero.q)
        time = sheet.time[:, 0] - self._ledger.first_time
        return Block(self.run, time, sheet.heat - zero.heat, drift, q, landing, sheet.inputs, sheet.air)


def _part(block: Block, rows: slice) -> Block:
    """Return some rows of a block."""
    q = None if block.q is None else block.q[rows]
    return Block(block.run, block.time[rows], block.dT[rows], block.drift[rows], q, block.landing[rows],
                 block.inputs[rows], block.air[rows])  # fmt: skip


def parts_of(block: Block, rows: int = BLOCK_ROWS) -> Iterator[Block]:
    """Give the rows of a block in blocks of so many, as `usable_blocks` gives them."""
    for first in range(0, len(block), rows):
        yield _part(block, slice(first, first + rows))


def run_named(campaign: Campaign, run: RunFile | str) -> RunFile:
    """Return a run of a campaign by its name, or as it is."""
    if isinstance(run, RunFile):
        return run
    names = tuple(item.name for item in campaign.runs)
    if run not in names:
        raise UnknownNameError(f"no run {run!r} in this campaign; there are: {', '.join(names)}", names)
    return campaign.runs[names.index(run)]


def is_lost(record: CleaningRecord, least: float = LEAST_USED) -> bool:
    """Whether cleaning left less than the share `least` of a run's rows, those of movements apart, or none at all."""
    return not record.used or 1.0 - record.lost < least


def _lost_runs(campaign: Campaign, run: RunFile, record: CleaningRecord, least: float) -> CampaignError:
    """Return the error about a run that cleaning took away, and all others of its role that it took away."""
    faults = Faults()
    for other in campaign.runs if campaign.zero == "campaign" else campaign.runs_of(run.role):
        own = record
        if other != run:
            blocks = UsableBlocks(campaign, other, least=0.0)
            try:
                for _block in blocks:
                    pass
            except HexathermalError:
                continue
            own = blocks.record
        if is_lost(own, least):
            faults.add(other.path, Problem(1, 1, f"{_lost_words(other, own)} (hexathermal check shows more)"))
    return CampaignError(str(campaign.file), faults.listed())


def _lost_words(run: RunFile, record: CleaningRecord) -> str:
    """Return that cleaning took a run away, why, and what to do."""
    left = "no row" if not record.used else f"no more than {record.used} of {record.rows} rows"
    return (
        f"{left} of {run.role} run {run.name!r} may be used: {record.why_rows}; mend the table, or take the run out of "
        "campaign.toml"
    )


def _no_zero(campaign: Campaign, record: CleaningRecord) -> CampaignError:
    """Return the error of a campaign whose first run, which all count from, has no row: the others have no zero."""
    faults, first = Faults(), campaign.runs[0]
    words = f"{_lost_words(first, record)}; all runs count from its first row, as zero = 'campaign' asks"
    faults.add(first.path, Problem(1, 1, words))
    return CampaignError(str(campaign.file), faults.listed())


def usable_blocks(
    campaign: Campaign, run: RunFile | str, *, rows: int = BLOCK_ROWS, least: float = LEAST_USED
) -> UsableBlocks:
    """Return the usable rows of a run as blocks, in constant memory.

    Parameters
    ----------
    campaign : Campaign
    run : RunFile or str
        A run, or its name.
    rows : int
        Rows of a block; the last one may be shorter.
    least : float
        After the last block a run is refused of whose rows, those of movements apart, cleaning left a smaller share;
        0: never.

    Returns
    -------
    blocks : iterator of Block
        With `record`, a `CleaningRecord`, whole after the last block.

    Raises
    ------
    ArgumentError
        The campaign is of kind ``"hexapod"``.
    DataError
        No weather is there to correct the beams by.
    CampaignError
        The table is at fault, or cleaning left less than `least` of the run; all such runs of its role are listed.
    """
    return UsableBlocks(campaign, run, rows, least)


def used_run(campaign: Campaign, run: RunFile | str) -> tuple[Block, CleaningRecord]:
    """Return all usable rows of a run that fits into memory, and what was left out.

    Raises
    ------
    ArgumentError, CampaignError
        As `usable_blocks`.
    """
    blocks = usable_blocks(campaign, run)
    return joined(list(blocks)), blocks.record
