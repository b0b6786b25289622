"""Binomial bounds on what the diagnosis says of fresh draws: rates that are stated, and how far chance may carry."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import binom

from benchmarks.hidden_effects import CLEAN, ONE, OUTSIDE, TWO, Outcome
from benchmarks.hidden_rates import of_kind, stronger

CHANCE = 1e-4
"""Chance that a diagnosis of the stated rate breaks one bound; there are ten."""

SHORTFALL = 0.05
"""Stated probabilities may be so much above the rate of being right."""

VISIBLE = 0.7
"""Visible strength from which an effect counts as plain."""


@dataclass(frozen=True)
class Bound:
    """A rate that the diagnosis has at least, or at most, over draws of a kind.

    Attributes
    ----------
    claim : str
    rate : float
        As stated: a little below (above) what 820 draws of these benches had (docs/diagnosis-figures.md and -later.md).
    least : bool
        Whether the rate is a least one.
    draws : function
        Chooses the draws.
    good : function
        Counts one.
    """

    claim: str
    rate: float
    least: bool
    draws: Callable[[Sequence[Outcome]], list[Outcome]]
    good: Callable[[Outcome], bool]

    def broken(self, outcomes: Sequence[Outcome]) -> str:
        """Return how a set of draws breaks the bound; empty where it holds, or where no draw is of the kind."""
        own = self.draws(outcomes)
        count, n = sum(self.good(one) for one in own), len(own)
        if n == 0:
            return ""
        edge = int(binom.ppf(CHANCE, n, self.rate) if self.least else binom.ppf(1.0 - CHANCE, n, self.rate))
        if edge <= count if self.least else count <= edge:
            return ""
        bad = "\n".join(one.told() for one in own if self.good(one) != self.least)
        word = "at least" if self.least else "at most"
        return f"{self.claim}: {count} of {n}, expected {word} {edge} (stated rate {self.rate:g})\n{bad}"


def _plain(kind: str) -> Callable[[Sequence[Outcome]], list[Outcome]]:
    """Return the choice of draws of a kind whose effects are plain."""
    return lambda draws: stronger(of_kind(draws, kind), VISIBLE)


def _all(kind: str) -> Callable[[Sequence[Outcome]], list[Outcome]]:
    """Return the choice of draws of a kind."""
    return lambda draws: of_kind(draws, kind)


def _faint(draws: Sequence[Outcome]) -> list[Outcome]:
    """Return draws with one effect that is hardly visible."""
    return [one for one in of_kind(draws, ONE) if one.strength < VISIBLE]


def _found(one: Outcome) -> bool:
    return one.right_or_equivalent


def _named(one: Outcome) -> bool:
    return bool(one.names)


BOUNDS = (
    Bound("plain single effect, first name right", 0.93, True, _plain(ONE), _found),
    Bound("faint single effect, first name right", 0.72, True, _faint, _found),
    Bound("single effect, wrong name", 0.04, False, _all(ONE), lambda one: one.wrong),
    Bound("nothing hidden, something named", 0.03, False, _all(CLEAN), _named),
    Bound("plain effect outside the catalogue, unexplained", 0.85, True, _plain(OUTSIDE), _found),
    Bound("outside the catalogue, something named", 0.08, False, _all(OUTSIDE), _named),
    Bound("two effects, first name right", 0.90, True, _all(TWO), _found),
    Bound("any effects, first name right", 0.87, True, lambda draws: of_kind(draws, ONE, TWO), _found),
    Bound("worse than the law on runs never fitted", 0.10, False, list, lambda one: (one.gain or 0.0) < -0.02),
    Bound("the same without their noise", 0.04, False, list, lambda one: (one.true_gain or 0.0) < -0.02),
)


def gains_of(outcomes: Sequence[Outcome]) -> tuple[np.ndarray, np.ndarray]:
    """Return gains of the draws in which knowing the truth gains a tenth or more, and those of the truth."""
    own = [one for one in outcomes if (one.oracle_gain or 0.0) > 0.1]
    return np.array([one.gain or 0.0 for one in own]), np.array([one.oracle_gain or 0.0 for one in own])


def overconfidence(outcomes: Sequence[Outcome]) -> float:
    """Return by how many standard deviations fewer verdicts are right than probabilities less `SHORTFALL` say."""
    stated = np.clip([one.probability - SHORTFALL for one in outcomes], 0.0, 1.0 - SHORTFALL)
    right = np.array([one.right_or_equivalent for one in outcomes], dtype=float)
    return float((stated - right).sum() / np.sqrt((stated * (1.0 - stated)).sum() + 1e-12))
