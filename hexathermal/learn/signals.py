"""All rows of a run, those of movements too, as the signals that a law with a memory needs.

A thermometer that lags, heat that is stored, a direction of the last move: they depend on rows that no drift is taken
from. Temperatures, the displacement and the weather of every row are given, cleaned as `hexathermal.learn.cleaning`
does; the drift is that of the usable rows.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from hexathermal.errors import ArgumentError, HexathermalError
from hexathermal.learn.campaign import BeamLayout, Block, Campaign, RunFile, joined
from hexathermal.learn.campaign_columns import AIR
from hexathermal.learn.campaign_streams import RunTable
from hexathermal.learn.cleaning import UsableBlocks
from hexathermal.learn.cleaning_record import CleaningRecord
from hexathermal.learn.cleaning_sheets import Sheet, stacked
from hexathermal.learn.interferometer import index_along_run
from hexathermal.machine.leg_signals import LegSignals
from hexathermal.poses import FloatArray

USUAL_HUMIDITY = 0.5
"""Where it was not recorded."""


@dataclass(frozen=True, eq=False)
class RunRows:
    """All rows of a run, n of them.

    Attributes
    ----------
    run : RunFile
    signals : LegSignals
        Without missing values in temperatures and displacement: they are interpolated.
    drift : array, shape (n,) [m]
        Since the zero; NaN in rows that may not be used.
    landing : array of int, shape (n,)
        As `Block.landing`; -1 in rows that may not be used.
    settled : array of bool, shape (n,)
        Rows that may be used.
    weather : array, shape (n, 3), or None
        Air temperature [degC], pressure [Pa] and relative humidity [1]; columns that were not recorded are NaN.
    missing : mapping of str to int
        Values of each temperature that were interpolated.
    record : CleaningRecord
    usable : Block
        The usable rows alone, missing temperatures left as they are.
    air_sensor : str, optional
        The thermometer that stands for the air, where no column records that.
    """

    run: RunFile
    signals: LegSignals
    drift: FloatArray
    landing: npt.NDArray[np.int64]
    settled: npt.NDArray[np.bool_]
    weather: FloatArray | None
    missing: dict[str, int]
    record: CleaningRecord
    usable: Block
    air_sensor: str | None = None

    def __len__(self) -> int:
        return len(self.drift)


class _WholeRun(UsableBlocks):
    """The usable rows of a run, and all others seen on the way."""

    def __init__(self, campaign: Campaign, run: RunFile | str) -> None:
        super().__init__(campaign, run)
        self.sheets: list[Sheet] = []

    def _watched(self, sheets: Iterator[Sheet]) -> Iterator[Sheet]:
        for sheet in sheets:
            self.sheets.append(sheet)
            yield sheet


def run_rows(campaign: Campaign, run: RunFile | str) -> RunRows:
    """Return all rows of a run.

    Parameters
    ----------
    campaign : Campaign
        Of kind ``"leg"`` or ``"component"``.
    run : RunFile or str

    Raises
    ------
    CampaignError
        The table is at fault, or cleaning left too little of the run.
    """
    reader = _WholeRun(campaign, run)
    block = joined(list(reader))
    assert reader.zero is not None  # a run without a usable row was refused
    sheet = stacked(reader.sheets)
    time = sheet.time[:, 0] - sheet.time[0, 0]
    weather = _weather(time, sheet.air)
    own = float(sheet.time[0, 0]), np.full(len(AIR), math.nan)
    began, first = own if campaign.zero == "run" else _campaign_start(campaign)
    begin = max(float(sheet.time[0, 0]) - began, 0.0)
    rows = np.searchsorted(time, block.time - 1e-9)
    drift = np.full(len(time), np.nan)
    landing = np.full(len(time), -1, dtype=np.int64)
    drift[rows], landing[rows] = block.drift, block.landing
    heat = sheet.heat - reader.zero.heat
    lost = {name: int(np.isnan(heat[:, k]).sum()) for k, name in enumerate(campaign.sensors)}
    dT = {name: _filled(time, heat[:, k]) for k, name in enumerate(campaign.sensors)}
    air, index, zero_index, pressure_index = _counted(weather, first)
    air = dT[reader.air_sensor] if air is not None and reader.air_sensor is not None else air
    signals = LegSignals(
        time + begin,
        dT,
        _filled(time, sheet.q[:, 0]) if sheet.q.shape[1] else np.zeros(len(time)),
        campaign.leg.retracted_length if campaign.leg is not None and campaign.kind == "leg" else 1.0,
        air,
        index,
        _tilt(campaign.beams, sheet, time, block),
        {item.name: _filled(time, sheet.inputs[:, k]) for k, item in enumerate(campaign.inputs)},
        {name: float(value) for name, value in zip(campaign.sensors, reader.zero.heat, strict=True)
         if math.isfinite(value)},
        zero_index,
        pressure_index,
        int(rows[0]) if campaign.zero == "run" else None,
    )  # fmt: skip
    settled, record = landing >= 0, reader.record
    return RunRows(reader.run, signals, drift, landing, settled, weather, lost, record, block, reader.air_sensor)


def follows_on(zero: str, before: LegSignals | None, after: LegSignals) -> bool:
    """Return whether rows come after others on the campaign's own clock, so that what a law remembers goes on."""
    return zero == "campaign" and before is not None and bool(after.time[0] > before.time[-1])


def _campaign_start(campaign: Campaign) -> tuple[float, FloatArray]:
    """Return the time [s] of a campaign's first row, and its first weather, shape (3,); NaN of what is not recorded."""
    table = RunTable(campaign, campaign.runs[0])
    places = {column.name: (k, column.si[0]) for k, column in enumerate(table.columns)}
    stands = (campaign.air_column(places), *AIR[1:])
    began, first = math.nan, np.full(len(AIR), math.nan)
    for rows in table:
        if math.isnan(began):
            began = float(np.nanmin(rows.numbers[:, 0]))
        for at in np.flatnonzero(np.isnan(first)):
            k, factor = places.get(stands[at] or "", (0, math.nan))
            known = rows.numbers[np.isfinite(rows.numbers[:, k]), k]
            first[at] = factor * known[0] if len(known) else math.nan
        if not any(math.isnan(value) for name, value in zip(stands, first, strict=True) if name in places):
            break
    return (0.0 if math.isnan(began) else began), first


def _filled(time: FloatArray, values: FloatArray) -> FloatArray:
    """Return values with missing ones interpolated; all of them missing stay so."""
    lost = np.isnan(values)
    if not lost.any() or lost.all():
        return np.array(values)
    return np.interp(time, time[~lost], values[~lost])


def _weather(time: FloatArray, air: FloatArray) -> FloatArray | None:
    """Return the weather with short gaps filled, None where nothing of it was recorded."""
    if np.isnan(air).all():
        return None
    return np.column_stack([_filled(time, air[:, k]) for k in range(air.shape[1])])


def _index(weather: FloatArray | None) -> FloatArray | None:
    """Return the index of air; None where the weather does not tell it."""
    if weather is None or np.isnan(weather[:, :2]).any():
        return None
    try:
        return index_along_run(np.where(np.isnan(weather), USUAL_HUMIDITY, weather))
    except HexathermalError:
        return None


def _counted(
    weather: FloatArray | None, first: FloatArray
) -> tuple[FloatArray | None, FloatArray | None, float | None, FloatArray | None]:
    """Return what counts from the zero: the air's temperature, its index, that at the zero, and that by pressure alone.

    `first`, shape (3,), is the weather at the zero; where it is NaN, that of the first row.
    """
    if weather is None:
        return None, None, None, None
    zero = np.where(np.isnan(first), weather[0], first)
    air = None if np.isnan(weather[:, 0]).all() else weather[:, 0] - zero[0]
    still = np.tile(zero, (len(weather), 1))
    still[:, 1] = weather[:, 1]
    at_zero, index, by_pressure = (_index(table) for table in (zero[None, :], weather, still))
    if at_zero is None or index is None or by_pressure is None:
        return air, None, None, None
    return air, index - at_zero, float(at_zero[0]), by_pressure - at_zero


def _tilt(beams: BeamLayout | None, sheet: Sheet, time: FloatArray, block: Block) -> FloatArray | None:
    """Return tilts about x and y [rad] from the differences of the beams, less the first usable row's."""
    if beams is None or sheet.beams.shape[1] != len(beams.azimuths) or beams.radius <= 0.0 or len(beams.azimuths) < 3:
        return None
    angle = np.asarray(beams.azimuths)
    # a beam at azimuth a reads  mean + r (rx sin a - ry cos a)
    design = np.column_stack([np.ones(len(angle)), beams.radius * np.sin(angle), -beams.radius * np.cos(angle)])
    if np.linalg.cond(design) > 1e6:
        return None
    known = np.column_stack([_filled(time, sheet.beams[:, k]) for k in range(sheet.beams.shape[1])])
    tilts = known @ np.linalg.pinv(design)[1:].T
    first = int(np.searchsorted(time, block.time[0] - 1e-9))
    return np.asarray(tilts - tilts[first])


def campaign_rows(campaign: Campaign, role: str) -> list[RunRows]:
    """Return all rows of the runs of a role."""
    if campaign.kind == "hexapod":
        raise ArgumentError("a campaign of kind 'hexapod' has no rows of one leg")
    return [run_rows(campaign, run) for run in campaign.runs_of(role)]
