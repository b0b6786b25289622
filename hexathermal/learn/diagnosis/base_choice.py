"""Which thermometers make the base law where nobody says: the one or two that make the drift likeliest.

`identify` ranks sets of sensors by the residual of runs left out, in which scatter that a run's rows share weighs most;
near the best many sets are alike, and a neighbour of the thermometer that the leg follows may win, or one of two be
left out. Under a fitted noise process the evidence of all ones and pairs differs plainly. A law that reads others than
the part follows would be diagnosed as wrong, rightly and to no use.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import combinations

import numpy as np

from hexathermal.learn.diagnosis.channels import Levels
from hexathermal.learn.diagnosis.coefficients import solution
from hexathermal.learn.diagnosis.evidence import LEAST
from hexathermal.learn.diagnosis.stage import Stage
from hexathermal.learn.diagnosis.view import View

FEWEST_WINDOWS = 40
"""Less tells nothing in a diagnosis."""

MOST_TURNS = 4

CLOSER = 2
"""Ones, and pairs, of a turn whose noise is fitted anew."""


def likelier_sensors(view: View) -> tuple[str, ...]:
    """Return the one or two sensors that make the drift likeliest.

    All sets are compared at the noise of the best one so far; the best of them with noise of their own and with what
    their thermometers may err, until none is better by `LEAST`. So must a pair be beside one: two thermometers err less
    than one of them, which is no reason to read both.

    Parameters
    ----------
    view : View
        Its `base` is where to start, and what stays where nothing moves: without landings
        noise is not told from what is quick.

    Returns
    -------
    tuple of str
    """
    chosen, channel = view.base, view.channel
    if len(channel) < FEWEST_WINDOWS or not view.moves:
        return chosen

    def fitted(names: tuple[str, ...], begin: Levels | None = None) -> tuple[Levels, float]:
        base = Stage(replace(view, base=names)).base
        levels, said = channel.fitted(base.X, base.sd, begin, 30 if begin else 90)
        return levels, said - LEAST * len(names)

    levels, best = fitted(chosen)
    for _turn in range(MOST_TURNS):
        ranked = [names for names in _ranked(view, levels) if names != chosen]
        near = [names for size in (1, 2) for names in [one for one in ranked if len(one) == size][:CLOSER]]
        fits = {names: fitted(names, levels) for names in near}
        other = max(fits, key=lambda names: fits[names][1], default=chosen)
        if other == chosen or fits[other][1] < best + LEAST * (len(other) == len(chosen)):
            break
        chosen, (levels, best) = other, fits[other]
    return chosen


def _ranked(view: View, levels: Levels) -> list[tuple[str, ...]]:
    """Return all sensors and pairs of them, the likeliest at one noise first, more sensors behind by `LEAST`."""
    channel = view.channel
    columns = view.base_of([view.temperatures(name) for name in view.sensors])
    table, _ = channel.whitened(np.column_stack([channel.y, columns * channel.loose(columns)]), levels)
    products, count = table.T @ table, len(view.sensors)
    own = np.arange(1, 1 + columns.shape[1]).reshape(-1, count)  # of each sensor
    said = {}
    for size in (1, 2):
        for places in combinations(range(count), size):
            used = np.concatenate([[0], own[:, list(places)].ravel()])
            said[places] = solution(products[np.ix_(used, used)])[0] - LEAST * (size - 1)
    return [tuple(view.sensors[k] for k in places) for places in sorted(said, key=lambda one: -said[one])]
