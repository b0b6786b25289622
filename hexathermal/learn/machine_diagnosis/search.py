"""The search for causes: one step ranks all candidates over what was adopted, steps go forward and back again.

Every hypothesis is judged on the same rows at levels of disturbances that are fitted for the null and for each leading
cause: a null that must explain a cause by slow drift is not helped by it, and a cause that feeds on drift does not win.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from hexathermal.learn.machine_diagnosis.candidate import Candidate
from hexathermal.learn.machine_diagnosis.case import Case
from hexathermal.learn.machine_diagnosis.chance import chance_threshold
from hexathermal.learn.machine_diagnosis.evidence import (
    PRIOR_OF_LEVEL,
    Adopted,
    Scored,
    fitted_levels,
    hypothesis,
    log_bayes,
    screened,
    sizes_for,
)
from hexathermal.learn.machine_diagnosis.law_columns import reading_noise
from hexathermal.learn.machine_diagnosis.leg_sensors import exchanged_heat
from hexathermal.learn.machine_diagnosis.tables import Levels, eliminated
from hexathermal.poses import FloatArray

LEADERS = 8
WIDER = 3.0
"""Prior of an amplitude that was adopted, over the size at which it was found."""

LEAST_ODDS = 0.5
"""Log odds that a name needs, however little chance reaches: levels are estimates."""

PAIRS = ("leg-coefficient", "platform-expansion", "base-expansion", "leg-backlash", "tracker-drift",
         "payload-compliance")  # fmt: skip
"""Causes of which two together are asked for at once."""

CLEARLY_APART = 10.0
"""Difference of two legs' temperatures, over a reading's noise, above which it is no error of thermometers."""

FOR_PAIRS = 3
"""Leaders at whose levels pairs are asked."""

NAMELESS_MARGIN = 3.0
"""Log odds by which a flexible shape must be better than the best cause for what it shows to have no name."""

TWO_AT_ONCE = np.log(0.1)
PAIR_MARGIN = 5.0
"""Log odds by which two together must beat the best single cause."""


@dataclass(frozen=True, eq=False)
class Ranked:
    """A candidate of a step.

    Attributes
    ----------
    which : int
    scored : Scored
    odds : float
        Log posterior odds against none of all.
    levels : Levels
    """

    which: int
    scored: Scored
    odds: float
    levels: Levels


@dataclass(frozen=True, eq=False)
class Step:
    """What one step found.

    Attributes
    ----------
    ranking : tuple of Ranked
        Best first.
    null : Levels
        Of what was adopted before alone.
    value : float
        Log evidence of that.
    threshold : float
        Log odds that a name needs.
    S : array
        Of all candidates' columns and the residual at the null's levels, all else eliminated.
    sides : tuple of (float, array)
        The same at the levels of the leaders, with what those levels cost the null: pairs are asked there too.
    """

    ranking: tuple[Ranked, ...]
    null: Levels
    value: float
    threshold: float
    S: FloatArray
    sides: tuple[tuple[float, FloatArray], ...] = ()


@dataclass(frozen=True, eq=False)
class Adoption:
    """A candidate that was adopted.

    Attributes
    ----------
    which : int
        Number of the candidate in the case; -1 for an exchange that was undone.
    candidate : Candidate
    size : float
        Its prior's size.
    ranked : Ranked
    step : Step
        In which it was found.
    case : Case
        Whose numbers that step has.
    pays : tuple of float
        Log likelihood that it gains on each run left out.
    """

    which: int
    candidate: Candidate
    size: float
    ranked: Ranked
    step: Step
    case: Case
    pays: tuple[float, ...] = ()


def priors_of(case: Case, adopted: Sequence[Adoption]) -> list[Adopted]:
    """Return the columns that are adopted, with loose priors of their amplitudes."""
    found = []
    for one in adopted:
        if one.which >= 0:
            k = len(one.candidate.scale)
            found.append((case.tables.places[one.which], np.zeros(k), WIDER * one.size * one.candidate.scale))
    return found


def candidates_left(case: Case, levels: Levels, adopted: Sequence[Adopted], skip: int | None = None) -> FloatArray:
    """Return S of all candidates' columns and the residual, with law, disturbances and what is adopted eliminated."""
    S, _cost = case.tables.reduced(levels, slice(None), skip)
    if adopted:
        own = np.concatenate([np.arange(part.start, part.stop) for part, _mean, _sd in adopted])
        base, rest = np.arange(case.tables.base), np.arange(case.tables.base, len(S))
        order = np.concatenate([base, own, rest])
        sd = np.concatenate([case.tables.sizes(levels), *(sd for _part, _mean, sd in adopted)])
        return eliminated(S[np.ix_(order, order)], sd)[0]
    return eliminated(S, case.tables.sizes(levels))[0]


def step(case: Case, adopted: Sequence[Adoption], begin: Levels | None = None) -> Step:
    """Return the ranking of all candidates over what is adopted.

    Parameters
    ----------
    case : Case
    adopted : sequence of Adoption
    begin : Levels, optional
        At which levels of disturbances are begun with.
    """
    base = priors_of(case, adopted)
    null = fitted_levels(case.tables, base, begin)[0]
    taken = {one.candidate.called for one in adopted if one.which >= 0}
    pool = {levels: _seen(case, levels, base) for levels in _simpler(null)}
    out = {which for which, one in enumerate(case.candidates) if one.called in taken}
    for one, at in _leaders(case, _best(case, pool, out)):
        levels = fitted_levels(case.tables, [*base, _prior(case, one)], at)[0]
        if levels not in pool:
            pool[levels] = _seen(case, levels, base)
    first = max(pool, key=lambda levels: pool[levels].value)
    S, none = pool[first].S, pool[first].value
    ranked = [Ranked(one.which[0], one, pool[at].value + one.value - none + float(case.prior[one.which[0]]), at)
              for one, at in _best(case, pool, out)]  # fmt: skip
    threshold = max(chance_threshold(case, S[:-1, :-1]), LEAST_ODDS)
    open_ = dict.fromkeys([first, *(one.levels for one in ranked[:FOR_PAIRS])])
    sides = tuple((pool[levels].value - none, pool[levels].S) for levels in open_)
    return Step(tuple(ranked), first, none, threshold, S, sides)


def _simpler(null: Levels) -> list[Levels]:
    """Return levels, and those without each of its disturbances: what stands for a cause may be none where it is named.

    A payload looks like a frame's offset, a drifting frame like slow errors: screened beside those alone, too little of
    it would be visible to begin with.
    """
    there = [name for name in PRIOR_OF_LEVEL if getattr(null, name) > 0.0]
    subsets = [names for k in range(len(there) + 1) for names in combinations(there, k)]
    return [replace(null, **dict.fromkeys(names, 0.0)) for names in subsets]


@dataclass(frozen=True, eq=False)
class _Seen:
    """All candidates at one set of levels: the log evidence of none, S, and each candidate over none."""

    value: float
    S: FloatArray
    scored: tuple[Scored, ...]


def _seen(case: Case, levels: Levels, base: Sequence[Adopted]) -> _Seen:
    """Return all candidates at levels."""
    S = candidates_left(case, levels, base)
    return _Seen(hypothesis(case.tables, levels, base)[0], S, tuple(screened(S, case.tables, case.candidates)))


def _best(case: Case, pool: Mapping[Levels, _Seen], out: set[int]) -> list[tuple[Scored, Levels]]:
    """Return each candidate at those levels of a pool that suit it best, the likeliest first."""
    found: dict[int, tuple[float, Scored, Levels]] = {}
    for levels, seen in pool.items():
        for one in seen.scored:
            which, value = one.which[0], seen.value + one.value
            if which in out or _doubtful(case, seen.S, which):
                continue
            if which not in found or value > found[which][0]:
                found[which] = (value, one, levels)
    order = sorted(found.values(), key=lambda item: -(item[0] + case.prior[item[1].which[0]]))
    return [(one, levels) for _value, one, levels in order]


def _doubtful(case: Case, S: FloatArray, which: int) -> bool:
    """Whether an exchange of thermometers may as well be their own errors.

    Where two legs differ in temperature by little more than thermometers err, errors that are slower than white noise
    look like half an exchange. A whole one, whose fit has the share ``m`` that errors leave of 1
    (`hexathermal.learn.machine_diagnosis.causes.swapped_legs`), must be likelier: ``m g - m^2 S / 2 > g / 2 - S / 8``.
    """
    one, own = case.candidates[which], case.tables.places[which]
    if not one.mean.any():
        return False
    apart = float(exchanged_heat(case.view, one).std(axis=0).max())
    if apart > CLEARLY_APART * reading_noise(case.view):
        return False
    at, m = own.start - case.tables.base, 0.5 * (1.0 + one.trust)
    return bool((m - 0.5) * S[at, -1] <= 0.5 * (m**2 - 0.25) * S[at, at])


def _leaders(case: Case, order: Sequence[tuple[Scored, Levels]]) -> list[tuple[Scored, Levels]]:
    """Return the two best of each leading cause."""
    found: list[tuple[Scored, Levels]] = []
    seen: dict[str, int] = {}
    for one, levels in order:
        cause = case.candidates[one.which[0]].cause
        if seen.get(cause, 0) < 2 and len(found) < LEADERS:
            found.append((one, levels))
            seen[cause] = seen.get(cause, 0) + 1
    return found


def _prior(case: Case, one: Scored) -> Adopted:
    """Return a candidate's columns with the prior of its best size."""
    candidate = case.candidates[one.which[0]]
    return case.tables.places[one.which[0]], candidate.mean, one.size * candidate.scale


def best_pair(case: Case, found: Step) -> tuple[int, int, float] | None:
    """Return the two candidates that together beat the best single one clearly, and their log odds."""
    some: dict[str, int] = {}
    for item in found.ranking:
        if case.candidates[item.which].cause in PAIRS:
            some.setdefault(case.candidates[item.which].called, item.which)
    best: tuple[int, int, float] | None = None
    for one, two in combinations(some.values(), 2):
        prior = float(case.prior[one] + case.prior[two] + TWO_AT_ONCE)
        for cost, S in found.sides:
            value = _together(case, S, one, two) + cost + prior
            if best is None or value > best[2]:
                best = (one, two, value)
    single, nameless = (next((one.odds for one in found.ranking if case.named(one.which) == of), -np.inf)
                        for of in (True, False))  # fmt: skip
    if best is None or best[2] < max(single + PAIR_MARGIN, nameless - NAMELESS_MARGIN):
        return None
    return best


def _together(case: Case, S: FloatArray, one: int, two: int) -> float:
    """Return the log evidence of two candidates together over none; minus infinity where one is not seen."""
    pair, at = (case.candidates[one], case.candidates[two]), case.tables.base
    own = np.concatenate([np.arange(case.tables.places[k].start, case.tables.places[k].stop) for k in (one, two)]) - at
    A, g, k = S[np.ix_(own, own)], S[own, -1], len(pair[0].scale)
    sizes = [sizes_for(part, each.scale, case.tables.rows)
             for part, each in zip((A[:k, :k], A[k:, k:]), pair, strict=True)]  # fmt: skip
    if not (sizes[0].size and sizes[1].size):
        return -np.inf
    values = [log_bayes(A, g, np.zeros(len(own)), np.concatenate([a * pair[0].scale, b * pair[1].scale]))[0]
              for a, b in zip(*sizes, strict=True)]  # fmt: skip
    return float(np.logaddexp.reduce(values) - np.log(len(values)))
