"""What a diagnosis settles on: amplitudes of what was named, settings between those tried, laws that both change.

A setting (play, time constant) that was tried at several values is uncertain by their evidence ``w_j``; amplitudes
``a_j`` then are, besides their covariance C, by ``sum_j w_j (a_j - a) (a_j - a)'`` about those of the best value.

A law that the file knows within a covariance is off by ``T b``, and a named change adds ``a``: rows know the sum better
than either. Its mean and covariance come from the joint posterior of both,

    mean = a + T b,     covariance = [1 T] C_ab [1 T]'
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hexathermal.learn.hexapod_data import PLATES
from hexathermal.learn.machine_diagnosis.case import Case
from hexathermal.learn.machine_diagnosis.course import Course
from hexathermal.learn.machine_diagnosis.evidence import Adopted, averaged, hypothesis, posterior
from hexathermal.learn.machine_diagnosis.finer import SETTINGS
from hexathermal.learn.machine_diagnosis.law_columns import law_columns
from hexathermal.learn.machine_diagnosis.search import WIDER, Adoption, priors_of
from hexathermal.poses import FloatArray

LEAST_TRUST = 1e-3


@dataclass(frozen=True, eq=False)
class Settled:
    """A named cause as all rows together have it.

    Attributes
    ----------
    adoption : Adoption
    found, covariance : array, shape (k,), (k, k)
        Of its amplitudes.
    whole, whole_covariance : array, shape (k,), (k, k)
        Of what its law changes by, stated uncertainty of the law and all; of others the same as the amplitudes.
    spread : float
        Standard deviation of its setting; NaN where it has none.
    """

    adoption: Adoption
    found: FloatArray
    covariance: FloatArray
    whole: FloatArray
    whole_covariance: FloatArray
    spread: float


def settled(course: Course) -> tuple[Settled, ...]:
    """Return all that was named, exchanges of thermometers first.

    Parameters
    ----------
    course : Course
    """
    case, levels, made = course.case, course.end.null, list[Settled]()
    kept = [one for one in course.adopted if one.which >= 0]
    base = priors_of(case, kept)
    means, covariances = averaged(case.tables, levels, base)
    for one in course.adopted:
        if one.which < 0:
            found, own = share_of(one)
            made.append(Settled(one, found, own, found, own, float("nan")))
    at = 0
    for k, one in enumerate(kept):
        size = len(one.candidate.names)
        found, own = means[at : at + size], covariances[at : at + size, at : at + size]
        spread, more = _setting(course, one, [part for j, part in enumerate(base) if j != k])
        made.append(Settled(one, found, own + more, *_whole(course, base, k, found, own + more), spread))
        at += size
    return tuple(made)


def share_of(one: Adoption) -> tuple[FloatArray, FloatArray]:
    """Return the share of an exchange that its own step would find freely, less what errors of readings make of it."""
    case = one.case
    own = case.tables.places[one.ranked.which]
    place = slice(own.start - case.tables.base, own.stop - case.tables.base)
    S, trust = one.step.S, max(one.candidate.trust, LEAST_TRUST)
    found = S[place, -1] / S[place, place][0]
    return (found - 0.5 * (1.0 - trust)) / trust, np.asarray(np.linalg.inv(S[place, place])) / trust**2


def _setting(course: Course, one: Adoption, others: list[Adopted]) -> tuple[float, FloatArray]:
    """Return the standard deviation of a setting, NaN where there is none, and what that adds to the covariance."""
    case, own = course.case, one.candidate
    k, name = len(own.names), next((name for name in SETTINGS if name in own.settings), "")
    if not name:
        return float("nan"), np.zeros((k, k))
    rest = {key: value for key, value in own.settings.items() if key != name}
    values, means, odds = [], [], []
    for other, place in zip(case.candidates, case.tables.places, strict=True):
        if other.called == own.called and {key: v for key, v in other.settings.items() if key != name} == rest:
            prior = (place, other.mean, WIDER * one.size * other.scale)
            value, mean, _covariance = hypothesis(case.tables, course.end.null, [prior, *others])
            values.append(float(other.settings.get(name, 0.0)))
            means.append(mean[:k])
            odds.append(value)
    weight = np.exp(np.array(odds) - max(odds))
    weight *= _widths(np.array(values))
    weight /= weight.sum()
    best = means[values.index(float(own.settings[name]))]
    away, off = np.array(values) - float(own.settings[name]), np.array(means) - best
    return float(np.sqrt(weight @ away**2)), np.asarray((off.T * weight) @ off)


def _widths(values: FloatArray) -> FloatArray:
    """Return how much of the axis each of some values stands for: half the way to its neighbours."""
    order = np.argsort(values)
    found = np.empty(len(values))
    found[order] = np.gradient(values[order]) if len(values) > 1 else 1.0
    return np.maximum(found, 1e-12)


def _whole(
    course: Course, base: list[Adopted], which: int, found: FloatArray, covariance: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return what a law changes by in all, and its covariance."""
    case, one = course.case, [item for item in course.adopted if item.which >= 0][which].candidate
    at = _coefficients(case, one.cause, str(one.target), one.settings.get("sensors", ()))
    if not at:
        return found, covariance
    T = law_columns(case.view, case.laws).shifts[str(one.target)][at]
    if not T.any():
        return found, covariance
    mean, joint = posterior(case.tables, course.end.null, base)
    begin = case.tables.base + sum(len(sd) for _place, _mean, sd in base[:which])
    to = np.zeros((len(at), len(mean)))
    to[:, : T.shape[1]] = T
    to[:, begin : begin + len(at)] += np.eye(len(at))
    return to @ mean, to @ joint @ to.T


def _coefficients(case: Case, cause: str, target: str, sensors: tuple[str, ...]) -> list[int]:
    """Return where a cause's parameters stand among the coefficients of its law; empty where it changes none."""
    if cause == "leg-coefficient":
        s = len(case.view.sensors)
        return [k + letter * s for k in map(case.view.sensors.index, sensors) for letter in (0, 1)]
    return [0] if target in PLATES and cause.startswith(target) else []
