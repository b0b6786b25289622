"""The probability that a measurand lies between its limits, and the measured values that make it large enough."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import lru_cache
from numbers import Real
from typing import Any

from scipy.optimize import brentq
from scipy.special import ndtr

from hexathermal.errors import ArgumentError

FURTHEST = 8.0
"""Standard uncertainties by which the estimate of a quantity that cannot be negative may lie below 0."""


NO_GUARD = 1e-12
"""Standard uncertainties below this part of the limits have a guard band that is lost in rounding."""

SMALLEST = 1e-300
"""Tolerance of a search that no number is below."""


def conformance_probability(
    value: float,
    uncertainty: float,
    *,
    lower: float | None = None,
    upper: float | None = None,
    nonnegative: bool = False,
) -> float:
    """Return the probability that the measurand lies between its limits.

    ``p = F((H - y) / u) - F((L - y) / u)``, F the normal distribution (JCGM 106:2012, section 7).  For a quantity that
    cannot be negative the distribution is cut at 0 and scaled: ``p = P(max(L, 0) <= Y <= H) / P(Y >= 0)``.

    Parameters
    ----------
    value, uncertainty, lower, upper, nonnegative
        As in `hexathermal.predict.acceptance.decide`; the uncertainty must be given.

    Returns
    -------
    float

    Raises
    ------
    ArgumentError
        As in `hexathermal.predict.acceptance.decide`; or a quantity that cannot be negative was measured more than 8
        standard uncertainties below 0.

    Examples
    --------
    Breakdown voltage of a Zener diode (JCGM 106:2012): -5.47 V, standard uncertainty 0.05 V, at most -5.40 V.

    >>> round(conformance_probability(-5.47, 0.05, upper=-5.40), 3)
    0.919
    """
    low, high = zone_of(value, lower, upper)
    check_number("standard uncertainty", uncertainty)
    if not uncertainty > 0.0:
        raise ArgumentError(
            f"standard uncertainty is {uncertainty:g}; expected above 0 (no measurement is exact; "
            "ask for the rule 'simple' by name where uncertainty shall not count)"
        )
    if not nonnegative:
        return _within(value, uncertainty, low, high)
    if value < -FURTHEST * uncertainty:
        raise ArgumentError(
            f"value {value:g} lies {-value / uncertainty:.3g} standard uncertainties below 0, allowed {FURTHEST:g}: "
            "the quantity cannot be negative; check value and uncertainty"
        )
    return _within(value, uncertainty, max(low, 0.0), high) / float(ndtr(value / uncertainty))


def _within(y: float, u: float, low: float, high: float) -> float:
    """Return the probability between two limits; mirrored where that keeps more digits."""
    a, b = (low - y) / u, (high - y) / u
    a, b = (a, b) if a + b <= 0.0 or math.isinf(a) else (-b, -a)
    return max(0.0, float(ndtr(b)) - float(ndtr(a)))


@lru_cache(maxsize=1024)  # one limit is asked at every pose, with one uncertainty
def acceptance_by_probability(
    u: float, lower: float | None, upper: float | None, wanted: float, nonnegative: bool
) -> tuple[tuple[float, float] | None, float]:
    """Return the values that pass by probability (None: there are none), and the highest probability reached."""

    def p(y: float) -> float:
        return conformance_probability(y, u, lower=lower, upper=upper, nonnegative=nonnegative)

    start = -FURTHEST * u if nonnegative else -math.inf
    low, high = -math.inf if lower is None else lower, math.inf if upper is None else upper
    if nonnegative:
        low = max(low, 0.0)
    if u < NO_GUARD * max(abs(limit) for limit in (lower, upper) if limit is not None):
        return (low, high), 1.0
    if math.isinf(high):
        return (_crossing(p, wanted, low - FURTHEST * u, low + FURTHEST * u, u, start), math.inf), 1.0
    if math.isinf(low) or (nonnegative and low == 0.0):
        # cut at 0, the probability falls with y from the very start
        first = start if nonnegative else high - 2.0 * FURTHEST * u
        if p(first) < wanted:
            return None, p(first)
        return (start, _crossing(p, wanted, high + FURTHEST * u, first, u, start)), 1.0
    middle = 0.5 * (low + high)
    if p(middle) < wanted:
        return None, p(middle)
    ends = (_crossing(p, wanted, end, middle, u, start) for end in (low - FURTHEST * u, high + FURTHEST * u))
    first, last = ends
    return (first, last), 1.0


def _crossing(p: Callable[[float], float], wanted: float, out: float, inside: float, u: float, start: float) -> float:
    """Return where the probability reaches what is asked for, between a value that fails and one that passes."""
    out = max(out, start)
    if p(out) >= wanted:
        return out
    tolerance = max(SMALLEST, 1e-13 * max(abs(out), abs(inside), u))
    return float(brentq(lambda y: p(y) - wanted, out, inside, xtol=tolerance, rtol=1e-14))


def zone_of(value: float, lower: float | None, upper: float | None) -> tuple[float, float]:
    """Return the limits with infinity for those not given."""
    if lower is None and upper is None:
        raise ArgumentError("no limit is given; state lower, upper or both")
    for what, number in (("value", value), ("lower limit", lower), ("upper limit", upper)):
        if number is not None or what == "value":
            check_number(what, number)
    low, high = -math.inf if lower is None else lower, math.inf if upper is None else upper
    if not low < high:
        raise ArgumentError(f"lower limit {low:g} is not below the upper limit {high:g}")
    return low, high


def check_number(what: str, number: Any) -> None:
    """Refuse what is no finite number."""
    if not isinstance(number, Real) or not math.isfinite(number):
        raise ArgumentError(f"{what} is {number!r}; expected a finite number (leave out a limit that is not there)")
