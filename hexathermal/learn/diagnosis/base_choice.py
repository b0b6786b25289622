"""Which thermometers make the base law where nobody says: those of `identify`, exchanged for likelier ones.

`identify` ranks sets of sensors by the residual of runs left out, in which scatter that a run's rows share weighs most;
near the best many sets are alike, and a neighbour of the thermometer that the leg follows may win. Under a fitted noise
process the evidence of the two differs plainly. A law that reads the neighbour would be diagnosed as wrong, rightly and
to no use. Only thermometers that go alike are exchanged: one that goes otherwise is no neighbour.
"""

from __future__ import annotations

from itertools import combinations

import numpy as np

from hexathermal.learn.diagnosis.evidence import LEAST
from hexathermal.learn.diagnosis.search import base_sizes
from hexathermal.learn.diagnosis.view import View
from hexathermal.poses import FloatArray

FEWEST_WINDOWS = 40
"""Less tells nothing in a diagnosis."""

MOST_TURNS = 4

NEIGHBOURS = 0.9
"""Correlation of temperatures from which on one thermometer may stand for another."""

CLOSER = 3
"""Exchanges of a turn whose noise is fitted anew."""


def _near(view: View, chosen: tuple[str, ...]) -> list[tuple[str, ...]]:
    """Return the sets in which a neighbour stands for one sensor or two of those chosen, or one is left out."""
    alike = dict(zip(view.sensors, np.corrcoef([view.temperatures(name) for name in view.sensors]), strict=True))
    places = [view.sensors.index(name) for name in chosen]
    found = []
    for gone in (*combinations(places, 1), *combinations(places, 2)):
        kept = tuple(name for name in chosen if view.sensors.index(name) not in gone)
        others = [name for name in view.sensors if name not in chosen]
        found += [(*kept, name) for name in others if alike[name][list(gone)].max() >= NEIGHBOURS]
        found += [kept] if kept and len(gone) == 1 else []
    return found


def likelier_sensors(view: View) -> tuple[str, ...]:
    """Return the sensors of a view's law, exchanged or left out as long as that makes the drift likelier.

    Parameters
    ----------
    view : View
        Its `base` is where to start.

    Returns
    -------
    tuple of str
        Those of the view where nothing gains `LEAST` in log evidence.
    """
    chosen, channel = view.base, view.channel
    X = view.base_columns
    if len(X) < FEWEST_WINDOWS:
        return chosen

    def sizes(columns: FloatArray) -> FloatArray:
        return base_sizes(channel, columns)

    levels, best = channel.fitted(X, sizes(X))
    for _turn in range(MOST_TURNS):
        columns = {other: view.base_of([view.temperatures(name) for name in other]) for other in _near(view, chosen)}
        ranked = sorted(columns, key=lambda one: channel.evidence(columns[one], sizes(columns[one]), levels))
        fits = {one: channel.fitted(columns[one], sizes(columns[one]), levels, 30) for one in ranked[-CLOSER:]}
        other = max(fits, key=lambda one: fits[one][1], default=chosen)
        if other == chosen or fits[other][1] < best + LEAST:
            break
        chosen, (levels, best) = other, fits[other]
    return chosen
