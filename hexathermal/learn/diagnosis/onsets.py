"""From when on a thermometer is at fault: moments of runs, and those at which its parity breaks most clearly."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, TypeAlias

import numpy as np

from hexathermal.learn.diagnosis.sensor_model import BIAS_K, SensorModel
from hexathermal.poses import FloatArray

LAST = 0.98
"""Part of a run in which it may happen: what begins near the end still shows in later runs."""

LEARNT_S = 600.0
"""So long it must have been sound before, for the others to be able to speak for it; and so long at fault, where it is
sound again in the next run: a part that warms in another place for the last minutes looks like that."""

KINDS = 2
"""It stays, or is mended before the next run."""

SCANNED, CLOSER, PROMISING = 360, 3, 10
"""Moments at which the parity is asked where it breaks, the best of them that are looked at more closely, and so many
of the best that are tried besides."""


@dataclass(frozen=True)
class Onset:
    """When a fault begins: in which run, at what time [s], and whether it stays or is mended before the next run.

    Or whether it was there before the first row of all (`begun`); of a thermometer in the air what it reads besides a
    share `beside` of that then teaches what the others foretell, nothing where that is zero.
    """

    run: int
    moment: float
    stays: bool = True
    begun: bool = False
    beside: float = 0.0

    def first_row(self, run: int, time: FloatArray) -> int:
        """Return the first row of a run that shows it, of rows at `time`; as many as there are where none does."""
        if run == self.run:
            return int(np.searchsorted(time, self.moment))
        return 0 if run > self.run and self.stays else len(time)


InParity: TypeAlias = Callable[[Onset, SensorModel], tuple[FloatArray, FloatArray]]
"""Gives the columns of a fault in the parity, and their sizes."""


def span(model: SensorModel, run: int) -> tuple[float, float]:
    """Return the first and the last moment of a run [s] at which a fault may begin."""
    time = model.view.signals[run].time
    begin, end = float(time[0]), float(time[-1])
    return (begin if run else min(begin + LEARNT_S, 0.5 * (begin + end))), end


def even_moments(model: SensorModel, each: int, *, stays: bool = True) -> list[Onset]:
    """Return moments evenly in each run; in the first, after what the others learn from.

    What is mended before the next run ends with its run: in the last one there is no difference; it is taken to stay.
    """
    found = []
    for k in range(len(model.view.runs) - (not stays)):
        begin, end = span(model, k)
        last = begin + LAST * (end - begin)
        last = last if stays else min(last, end - LEARNT_S)
        if last < begin:
            continue
        found += [Onset(k, round(float(moment), 3), stays) for moment in np.linspace(begin, last, max(2, each))]
    return found


def promising(model: SensorModel, shape: InParity, scanned: int = SCANNED) -> list[Onset]:
    """Return the moments of either kind at which the parity shows a fault most clearly."""
    return [one for stays in (True, False) for one in promising_moments(model, shape, stays=stays, scanned=scanned)]


def promising_moments(
    model: SensorModel, shape: InParity, *, stays: bool, scanned: int = SCANNED
) -> list[Onset]:  # fmt: skip
    """Return the moments from which on the parity shows a fault most clearly.

    They are compared at a noise without a fault: what was fitted with the fault in it forgives any.
    """
    levels = model.null[0]
    sound = replace(levels, slow=min(levels.slow, BIAS_K), offset=min(levels.offset, BIAS_K))
    scores: dict[Onset, float] = {}

    def scan(places: Sequence[Onset]) -> list[Onset]:
        """Score places; return the best of all so far."""
        for one in places:
            columns, sizes = shape(one, model)
            X, sd = np.column_stack([model.X, columns]), np.concatenate([model.sd, sizes])
            scores[one] = model.channel.evidence(X, sd, sound)
        return sorted(scores, key=lambda place: -scores[place])

    each = max(2, scanned // len(model.view.runs))
    best = scan(even_moments(model, each, stays=stays))[:CLOSER]
    for one in best:
        begin, end = span(model, one.run)
        step = LAST * (end - begin) / (each - 1)
        end = end if stays else max(begin, end - LEARNT_S)
        near = np.clip(one.moment + step * np.array([-0.75, -0.5, -0.25, 0.25, 0.5, 0.75]), begin, end)
        scan([replace(one, moment=round(float(moment), 3)) for moment in near])
    return scan([])[:PROMISING]


def where(model: SensorModel, onset: Onset, ends: str = "fixed_again") -> dict[str, Any]:
    """Return where and when a fault begins, as a trial tells it; `ends` is what it says where that is with its run."""
    if onset.begun:
        return {"since": "the beginning"}
    told = {"run": model.view.runs[onset.run].run.name, "time_s": round(onset.moment, 1)}
    return told if onset.stays else told | {ends: 1}


def runs_since(model: SensorModel, onset: Onset) -> dict[str, Any]:
    """Return the runs that a fault concerns, from which time on in each [s], and in which it was mended again."""
    runs = model.view.order
    at = runs.index(model.view.runs[onset.run].run.name)
    later = runs[at + 1 :]
    begins = {runs[at]: onset.moment} | (dict.fromkeys(later, 0.0) if onset.stays else {})
    return {"from_s": begins} | ({} if onset.stays else {"again_in": list(later)})


def sound_rows(model: SensorModel, onset: Onset) -> list[slice]:
    """Return the rows of each run before a fault, or of runs that it does not concern."""
    firsts = [onset.first_row(i, signals.time) for i, signals in enumerate(model.view.signals)]
    return [slice(None) if first == len(signals) else slice(0, first)
            for first, signals in zip(firsts, model.view.signals, strict=True)]  # fmt: skip
