"""What a step of the search hands on: causes with their evidence, each at the noise that was fitted for it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from hexathermal.learn.diagnosis.channels import Levels
from hexathermal.learn.diagnosis.evidence import TOLERATED, Scored, relevance
from hexathermal.learn.diagnosis.trials import Item

NONE = "none"
"""That nothing is there, among the hypotheses."""

SURE_WITNESS = 25.0
"""What the parity of a sensor shows beyond that of any other may be chance up to this."""


@dataclass(frozen=True, eq=False)
class Ranked:
    """A cause after the noise was fitted for it.

    Attributes
    ----------
    cause : str
    value : float
        Log evidence less that of the null.
    best : Scored
    levels : Levels
    besides : float
        Of the value, what other witnesses than the drift say.
    witness : float
        What the parity of a faulty thermometer says beyond that of any other; of one that is late, for lateness of all
        that it reads.
    both : float
        What the drift and the parity of a faulty thermometer, beyond that of any other, say alike: the lesser of them.
    seconded : float
        What the parity of a faulty thermometer says by itself, whatever others show.
    agreed : float
        What it says for as large a fault as the drift does, against none; minus infinity where that is not asked.
    withheld : float
        Evidence in the drift that does not count for a thermometer's fault, since its parity says too little.
    repeated : float
        What runs left out say for it, run by run.
    borne : float
        What a clock that is off would show of the same data, which is no misfit.
    unlikely : bool
        Whether it acts by an amplitude that such a cause hardly has.
    """

    cause: str
    value: float
    best: Scored
    levels: Levels
    besides: float = 0.0
    witness: float = 0.0
    both: float = 0.0
    seconded: float = 0.0
    agreed: float = -np.inf
    withheld: float = 0.0
    repeated: float = 0.0
    borne: float = 0.0
    unlikely: bool = False

    @property
    def gated(self) -> float:
        """The evidence against a null that tolerates a small misfit of the same shape in the drift.

        What the parity of this thermometer alone shows beyond `SURE_WITNESS` is no misfit of the drift, nor is what
        drift and parity say alike: chance in one knows nothing of the other. Nor does a misfit of wandering
        thermometers repeat from run to run, nor shift all of them. But what would hardly be visible in the drift is no
        error of the law, whatever thermometers show.
        """
        small = relevance(self.best.visible, self.levels.usual, self.best.trial.feigned)
        said = self.value - self.best.trial.doubt
        if self.hardly_shows:
            return min(said, small)
        return min(said, small + max(self.witness - SURE_WITNESS, self.both, 0.0) + self.repeated + self.borne)

    @property
    def hardly_shows(self) -> bool:
        """Whether less of it is visible in the drift than the null tolerates in any shape."""
        return self.best.visible < TOLERATED * self.levels.usual

    @property
    def named(self) -> bool:
        """Whether it is a cause of the catalogue."""
        return self.best.trial.named


@dataclass(frozen=True, eq=False)
class Step:
    """What one step found.

    Attributes
    ----------
    ranking : tuple of Ranked
        Causes and nameless ones, best first.
    levels : Levels
        Noise of the null.
    null : float
        Its log evidence.
    """

    ranking: tuple[Ranked, ...]
    levels: Levels
    null: float

    def without(self, item: Ranked) -> Step:
        """Return the step as if one cause had not been tried."""
        return replace(self, ranking=tuple(one for one in self.ranking if one is not item))


def most_valued(items: Sequence[Item], most: Callable[[Item], float], value: Callable[[Item], float]) -> Item:
    """Return the first item of the largest value; where what it is worth at most is less, it is not asked its value.

    Parameters
    ----------
    items : sequence
        One or more.
    most : function
        From an item to a bound of its value from above, which is cheap.
    value : function
    """
    bounds = [most(item) for item in items]
    order = sorted(range(len(items)), key=lambda k: -bounds[k])
    best, found = order[0], value(items[order[0]])
    for k in order[1:]:
        if bounds[k] < found:
            break
        own = value(items[k])
        if own > found or (own == found and k < best):
            best, found = k, own
    return items[best]
