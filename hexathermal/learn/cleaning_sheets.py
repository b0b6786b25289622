"""Rows on their way through cleaning: pieces of one run, cut so that every rule sees the rows around."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, fields, replace

import numpy as np
import numpy.typing as npt

from hexathermal.learn.campaign import Campaign
from hexathermal.learn.campaign_columns import AIR
from hexathermal.learn.campaign_streams import RunTable
from hexathermal.poses import FloatArray


@dataclass(eq=False)
class Sheet:
    """Consecutive rows, SI units and degrees Celsius; every array has shape (n, k).

    Attributes
    ----------
    time : array, shape (n, 1) [s]
    heat : array, shape (n, s) [degC]
    beams : array, shape (n, 3) or (n, 0) [m]
    drift : array, shape (n, 1) or (n, 0) [m]
        As the table gives it, for a part without beams.
    q, settled : array, shape (n, 1) or (n, 0)
    air : array, shape (n, 3)
        Degrees Celsius, Pa, 1; NaN where not recorded.
    inputs : array, shape (n, k)
    fresh : array, shape (n, 1)
        1 where rows of a movement, or a gap, lie between a row and the one before.
    """

    time: FloatArray
    heat: FloatArray
    beams: FloatArray
    drift: FloatArray
    q: FloatArray
    settled: FloatArray
    air: FloatArray
    inputs: FloatArray
    fresh: FloatArray

    def __len__(self) -> int:
        return len(self.time)

    def take(self, rows: slice | npt.NDArray[np.bool_]) -> Sheet:
        """Return some of the rows."""
        return Sheet(**{item.name: getattr(self, item.name)[rows] for item in fields(self)})

    def changed(self, **arrays: FloatArray) -> Sheet:
        """Return the rows with other values; these are never altered themselves."""
        return replace(self, **arrays)


def stacked(sheets: list[Sheet]) -> Sheet:
    """Return consecutive sheets as one."""
    if len(sheets) == 1:
        return sheets[0]
    return Sheet(**{item.name: np.concatenate([getattr(s, item.name) for s in sheets]) for item in fields(Sheet)})


def sheets_of(campaign: Campaign, table: RunTable) -> Iterator[Sheet]:
    """Return the rows of a run as they stand in its table, in the core's units."""
    parts = [column.part for column in table.columns]
    factors = np.array([column.si[0] for column in table.columns])
    names = [column.name for column in table.columns]
    air = {name: k for k, name in enumerate(names) if parts[k] == "air"}

    for rows in table:
        numbers = rows.numbers * factors

        def of(part: str, numbers: FloatArray = numbers) -> FloatArray:
            return numbers[:, [k for k, name in enumerate(parts) if name == part]]

        weather = np.full((len(numbers), 3), np.nan)
        for k, name in enumerate(AIR):
            if name in air:
                weather[:, k] = numbers[:, air[name]]
        fresh = np.zeros((len(numbers), 1))
        yield Sheet(of("time"), of("temperature"), of("beam"), of("drift"), of("q"), of("settled"), weather,
                    of("input"), fresh)  # fmt: skip


def with_margins(sheets: Iterable[Sheet], rows: int, margin: int) -> Iterator[tuple[Sheet, slice]]:
    """Return pieces of `rows` rows with up to `margin` rows of the neighbours on either side.

    Each piece comes with the slice of its own rows; together these are all rows, once and in order. The pieces do not
    depend on how the sheets were cut.
    """
    held: list[Sheet] = []
    count, before = 0, 0
    for sheet in sheets:
        held.append(sheet)
        count += len(sheet)
        while count >= before + rows + margin:
            whole = stacked(held)
            end = before + rows
            yield whole.take(slice(0, end + margin)), slice(before, end)
            rest = max(0, end - margin)
            held, before, count = [whole.take(slice(rest, None))], end - rest, count - rest
    if count > before:
        yield stacked(held), slice(before, count)
