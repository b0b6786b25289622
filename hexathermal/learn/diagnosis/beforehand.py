"""What is told before any law is fitted, by others than the drift: beams that lost count, plugs that changed places."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from hexathermal.learn.diagnosis.result import Candidate, Effect
from hexathermal.learn.diagnosis.spans import visible
from hexathermal.poses import FloatArray

Told = TypeVar("Told")


@dataclass(frozen=True, eq=False)
class Beforehand:
    """An effect that others than the drift tell.

    Attributes
    ----------
    effect : Effect
    evidence : float
    spread : float [m]
        Standard uncertainty of what would be visible.
    """

    effect: Effect
    evidence: float
    spread: float

    @property
    def candidate(self) -> Candidate:
        """Its line in the ranking."""
        one = self.effect
        settings = dict(one.settings) | {name: own.value for name, own in one.parameters.items()}
        return Candidate(one.cause, one.target, self.evidence, one.probability, one.visible, settings, self.spread)


def shown_together(columns: FloatArray, sizes: FloatArray, errors: FloatArray, law: FloatArray) -> tuple[float, float]:
    """Return what is visible of steps together beside a law, RMS, and its standard uncertainty [m].

    Parameters
    ----------
    columns : array, shape (n, k)
    sizes, errors : array, shape (k,) [m]
        Of the steps, and their standard uncertainties.
    law : array, shape (n, p)
    """
    seen = float(visible((columns @ sizes)[:, None], law)[0])
    return seen, float(np.linalg.norm(visible(columns, law) * errors))


def among(
    found: Sequence[Told], before: Sequence[Beforehand], largest: float, told: Callable[[Beforehand], Told]
) -> list[Told]:
    """Return what was found with what was told before: first what shows more than all of that, else last.

    Parameters
    ----------
    found : sequence
        Effects, or their lines in the ranking.
    before : sequence of Beforehand
    largest : float [m]
        Most that is visible of an effect that was found.
    told : function
        What stands for one of those told before.
    """
    first = [told(one) for one in _by_size(before) if one.effect.visible > largest]
    last = [told(one) for one in _by_size(before) if one.effect.visible <= largest]
    return [*first, *found, *last]


def _by_size(before: Sequence[Beforehand]) -> list[Beforehand]:
    """Return what was told before, the largest first."""
    return sorted(before, key=lambda one: -one.effect.visible)
