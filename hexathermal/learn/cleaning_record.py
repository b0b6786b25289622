"""What cleaning left out, repaired or noticed: each with a reason, a channel and a count."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from hexathermal.poses import FloatArray

ROW, VALUE, REPAIRED, NOTED = "row left out", "value left out", "value repaired", "noted"
"""What a step did."""

BEAM_STEP = "beam step"
"""The step that takes back what one beam stepped by."""

MOST_MARKS = 500
"""Readings left out of a channel that are kept with their time and value, for plots."""

HARMLESS = ("not settled", "duplicate")
"""Steps that leave out rows without a loss: movements, and rows that are there twice."""


@dataclass(frozen=True)
class CleaningStep:
    """One step of cleaning in one channel.

    Attributes
    ----------
    step : str
        As ``"spike"``, ``"not settled"``, ``"missing code"``.
    channel : str
        Column of the format, ``"row"`` where it concerns the whole row.
    action : str
        `ROW`, `VALUE`, `REPAIRED` or `NOTED`.
    count : int
        Rows, or values of the channel.
    reason : str
        The rule that was broken.
    first_time : float [s]
        Time in the table of the first of them.
    taken_by : str
        Of a dead channel, the step that took its values: ``"stuck"``, ``"missing"``; empty otherwise.
    """

    step: str
    channel: str
    action: str
    count: int
    reason: str
    first_time: float
    taken_by: str = ""


@dataclass(frozen=True)
class BeamStep:
    """What one beam stepped by against the others, and was taken back.

    Attributes
    ----------
    channel : str
        Column of the format.
    time : float [s]
        Of the first row behind it, since the table's first row.
    size, error : float [m]
        Of the beam against the mean of the others; what they part by of themselves there, standard deviation.
    at_rest : bool
        Whether it is within a rest, where nothing but a lost count makes one.
    """

    channel: str
    time: float
    size: float
    error: float
    at_rest: bool


@dataclass(frozen=True)
class CleaningRecord:
    """All that cleaning did to one run; the table itself is never altered.

    Attributes
    ----------
    run : str
    rows, used : int
        Rows of the table, and those that may be used.
    duration, sampling : float [s]
        From the first to the last row, and the median step between rows.
    zero_time : float [s]
        Time in the table of the row that the run counts from.
    steps : tuple of CleaningStep
    beam_steps : tuple of BeamStep
        That were taken back, one by one.
    """

    run: str
    rows: int
    used: int
    duration: float
    sampling: float
    zero_time: float
    steps: tuple[CleaningStep, ...]
    beam_steps: tuple[BeamStep, ...] = ()

    def count(self, step: str, channel: str | None = None) -> int:
        """Return how many rows or values a step concerned, in one channel or in all."""
        return sum(item.count for item in self.steps if item.step == step and channel in (None, item.channel))

    @property
    def lost(self) -> float:
        """Share of the rows, those of movements and double ones apart, that cleaning left out; 1 where none is left."""
        harmless = sum(item.count for item in self.steps if item.action == ROW and item.step in HARMLESS)
        return 1.0 - self.used / max(1, self.rows - harmless)

    def why_values(self, channel: str) -> str:
        """Return by which steps values of a channel were left out, most first, as text; empty where none were."""
        taken = [item for item in self.steps if item.channel == channel and item.action == VALUE]
        taken.sort(key=lambda item: -item.count)
        return ", ".join(dict.fromkeys(item.taken_by or item.step for item in taken))

    @property
    def why_rows(self) -> str:
        """Which steps left out rows, with counts and reasons, as text."""
        order = sorted((item for item in self.steps if item.action == ROW), key=lambda item: -item.count)
        return "; ".join(f"{item.count} {item.step} ({item.reason})" for item in order) or "the table is empty"

    def as_data(self) -> dict[str, Any]:
        """Return the record as plain values."""
        return {key: _plain(value) for key, value in asdict(self).items()}


def cleaning_words(records: Sequence[CleaningRecord]) -> tuple[str, ...]:
    """Return what cleaning did to some runs together, in words; nothing where it did nothing."""
    counts: dict[str, int] = {}
    channels: dict[str, dict[str, None]] = {}
    for item in (item for record in records for item in record.steps):
        counts[item.step] = counts.get(item.step, 0) + item.count
        channels.setdefault(item.step, {}).update(
            {} if item.action == ROW or item.channel == "row" else {item.channel: None}
        )
    if not counts:
        return ()
    rows, used = (sum(getattr(record, name) for record in records) for name in ("rows", "used"))
    words = ", ".join(f"{step} {count}{_values_of(list(channels[step]))}" for step, count in counts.items())
    return (f"{used} of {rows} rows are usable; cleaning: {words} ('hexathermal check' says where and why)",)


def _values_of(channels: Sequence[str]) -> str:
    """Return whose values a count is of; nothing where it is of rows."""
    if not channels:
        return ""
    return f" values of {channels[0] if len(channels) == 1 else f'{len(channels)} channels'}"


def _plain(value: Any) -> Any:
    """Return a value that JSON knows: no NaN, tuples as lists."""
    if isinstance(value, float):
        return value if np.isfinite(value) else None
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    return {key: _plain(item) for key, item in value.items()} if isinstance(value, dict) else value


class Ledger:
    """Counts of cleaning as the rows pass."""

    def __init__(self) -> None:
        self._entries: dict[tuple[str, str, str, str], list[float]] = {}
        self._marks: dict[str, list[tuple[float, float]]] = {}
        self.beam_steps: list[BeamStep] = []
        self.rows, self.used = 0, 0
        self.first_time, self.last_time, self.zero_time, self.sampling = np.nan, np.nan, np.nan, np.nan

    def note(
        self, step: str, channel: str, action: str, reason: str, flags: npt.NDArray[np.bool_], time: FloatArray
    ) -> None:
        """Add the flagged rows to a step's count."""
        count = int(flags.sum())
        if count:
            entry = self._entries.setdefault((step, channel, action, reason), [0, float(time[int(flags.argmax())])])
            entry[0] += count

    def mark(self, channel: str, time: FloatArray, values: FloatArray) -> None:
        """Keep readings that were left out, with their time in the table, in the core's units."""
        if not len(time):
            return
        kept = self._marks.setdefault(channel, [])
        free = MOST_MARKS - len(kept)
        kept.extend((float(t), float(value)) for t, value in zip(time[:free], values[:free], strict=True))

    @property
    def marks(self) -> dict[str, FloatArray]:
        """Readings that were left out: of each channel time [s] since the first row, and value, shape (n, 2)."""
        return {channel: np.array(kept) - [self.first_time, 0.0] for channel, kept in self._marks.items()}

    def record(self, run: str) -> CleaningRecord:
        """Return what was counted so far."""
        steps = tuple(
            CleaningStep(step, channel, action, int(count), reason, first)
            for (step, channel, action, reason), (count, first) in self._entries.items()
        )
        beam_steps = tuple(replace(step, time=step.time - self.first_time) for step in self.beam_steps)
        return CleaningRecord(run, self.rows, self.used, self.last_time - self.first_time, self.sampling,
                              self.zero_time, self._with_dead(steps), beam_steps)  # fmt: skip

    def _with_dead(self, steps: tuple[CleaningStep, ...]) -> tuple[CleaningStep, ...]:
        """Return the steps with those of channels that never had a value named so."""
        lost: dict[str, int] = {}
        for item in steps:
            if item.action == VALUE:
                lost[item.channel] = lost.get(item.channel, 0) + item.count
        dead = {channel for channel, count in lost.items() if count >= self.rows > 0}
        return tuple(
            CleaningStep("dead channel", item.channel, item.action, item.count,
                         f"no usable value in the whole run ({item.reason})", item.first_time, item.step)
            if item.channel in dead and item.action == VALUE
            else item
            for item in steps
        )  # fmt: skip
