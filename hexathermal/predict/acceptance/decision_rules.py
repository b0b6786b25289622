"""Whether a measured value meets its limits: decision rules, and the probability that it does.

The measurand is taken as normally distributed about the measured value `y` with standard uncertainty `u` (JCGM
106:2012, section 7).  ``p`` is the conformance probability, ``U = k u`` the expanded uncertainty, ``[L, H]`` the zone
between the limits; a limit that is not given is at infinity.

==========================  =====================================  ====================================
rule                        pass                                   fail
==========================  =====================================  ====================================
``iso-14253-1``             ``p >= P``                             ``p <= 1 - P`` and `y` outside
``iso-14253-1:1998``        ``L + U <= y <= H - U``                ``y <= L - U`` or ``y >= H + U``
``simple``                  ``L <= y <= H``                        otherwise
``ilac-g8-guard-band``      ``L + U <= y <= H - U``                otherwise
``ilac-g8``                 ``L + U <= y <= H - U``                ``y < L - U`` or ``y > H + U``
==========================  =====================================  ====================================

What neither passes nor fails is not decided.  ``ilac-g8`` (non-binary, ILAC-G8:09/2019) then says *conditional pass*
between the limits and *conditional fail* outside.  For one limit, ``p >= 0.95`` is ``y <= H - 1.645 u``.  Comparisons
allow for rounding: 1e-12 of the numbers compared.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from numbers import Real
from types import MappingProxyType
from typing import Any

from scipy.optimize import brentq
from scipy.special import ndtr

from hexathermal.errors import ArgumentError, UnknownNameError

PASS, FAIL, NOT_DECIDED = "pass", "fail", "not decided"

RULES: Mapping[str, str] = MappingProxyType(
    {
        "iso-14253-1": "iso-14253-1",
        "iso-14253-1:2017": "iso-14253-1",
        "iso-14253-1:1998": "iso-14253-1:1998",
        "iso-14253-1:2013": "iso-14253-1:1998",
        "u-rule": "iso-14253-1:1998",
        "simple": "simple",
        "iso-10360": "simple",
        "iso-14253-5": "simple",
        "ilac-g8-simple": "simple",
        "ilac-g8-guard-band": "ilac-g8-guard-band",
        "ilac-g8": "ilac-g8",
        "ilac-g8-non-binary": "ilac-g8",
    }
)
"""Accepted names of decision rules -> the rules."""

ROUNDING = 1e-12
"""Part of the numbers compared by which a limit may be missed: rounding of decimals and units."""

FURTHEST = 8.0
"""Standard uncertainties by which the estimate of a quantity that cannot be negative may lie below 0."""


@dataclass(frozen=True)
class Decision:
    """Whether a value meets its limits.

    Attributes
    ----------
    verdict : str
        ``"pass"``, ``"fail"`` or ``"not decided"``.
    statement : str
        The rule's own word: the verdict, or ILAC-G8's ``"conditional pass"`` and ``"conditional fail"``.
    probability : float or None
        Conformance probability; None where no uncertainty was given (rule ``simple``).
    value, uncertainty, lower, upper : float or None
        What was decided about; `uncertainty` is the standard uncertainty.
    rule : str
        One of the values of `RULES`.
    acceptance : (float, float) or None
        Values that pass lie in this closed interval; None where no value could.
    note : str
        What limits the decision; empty where nothing does.
    """

    verdict: str
    statement: str
    probability: float | None
    value: float
    uncertainty: float | None
    lower: float | None
    upper: float | None
    rule: str
    acceptance: tuple[float, float] | None
    note: str = ""


def decide(
    value: float,
    uncertainty: float | None,
    *,
    lower: float | None = None,
    upper: float | None = None,
    rule: str = "iso-14253-1",
    probability: float = 0.95,
    coverage_factor: float = 2.0,
    nonnegative: bool = False,
) -> Decision:
    """Decide whether a measured value meets its limits.

    Parameters
    ----------
    value : float
        Measured value, in any unit.
    uncertainty : float or None
        Its standard uncertainty in the same unit, above 0; None only with the rule ``simple``.
    lower, upper : float, optional
        Limits in the same unit, at least one.
    rule : str
        A name of `RULES`, see the table of this module.
    probability : float
        Of the rule ``iso-14253-1``: conformance probability asked for, above 0.5 and below 1.
    coverage_factor : float
        ``k`` of the rules that use ``U = k u``.
    nonnegative : bool
        Whether the quantity cannot be below 0: see `conformance_probability`.

    Returns
    -------
    Decision

    Raises
    ------
    ArgumentError
        No limit, limits in the wrong order, a number out of its range, or no uncertainty where the rule needs one.
    UnknownNameError
        No such rule.

    Examples
    --------
    A residual of 1.28 um against 1.5 um, standard uncertainty 0.13 um: just accepted, and not under the older rule.

    >>> decide(1.28, 0.13, upper=1.5).verdict
    'pass'
    >>> decide(1.28, 0.13, upper=1.5, rule="iso-14253-1:1998").verdict
    'not decided'
    """
    name = _rule(rule)
    low, high = _zone(value, lower, upper)
    _check_number("probability", probability)
    _check_number("coverage factor", coverage_factor)
    if not 0.5 < probability < 1.0:
        raise ArgumentError(f"probability is {probability:g}; expected above 0.5 and below 1, such as 0.95")
    if not coverage_factor > 0.0:
        raise ArgumentError(f"coverage factor is {coverage_factor:g}; expected above 0, such as 2")
    if uncertainty is None and name != "simple":
        raise ArgumentError(
            f"the rule {rule!r} needs the standard uncertainty of the value; state it, or ask for the rule 'simple'"
        )
    p = None
    if uncertainty is not None:
        p = conformance_probability(value, uncertainty, lower=lower, upper=upper, nonnegative=nonnegative)
    margin = 0.0 if uncertainty is None or name == "simple" else coverage_factor * uncertainty
    if name == "iso-14253-1" and p is not None and uncertainty is not None:
        statement = _by_probability(value, p, (low, high), probability)
        zone, best = _acceptance(uncertainty, lower, upper, probability, nonnegative)
    else:
        statement = _by_guard_band(name, value, margin, (low, high))
        zone = (low + margin, high - margin) if _most(low + margin, high - margin) else None
        best = None
    verdict = statement if statement in (PASS, FAIL) else NOT_DECIDED
    note = "" if zone is not None else _too_coarse(best, probability)
    return Decision(verdict, statement, p, value, uncertainty, lower, upper, name, zone, note)


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
        As in `decide`; the uncertainty must be given.

    Returns
    -------
    float

    Raises
    ------
    ArgumentError
        As in `decide`; or a quantity that cannot be negative was measured more than 8 standard uncertainties below 0.

    Examples
    --------
    Breakdown voltage of a Zener diode (JCGM 106:2012): -5.47 V, standard uncertainty 0.05 V, at most -5.40 V.

    >>> round(conformance_probability(-5.47, 0.05, upper=-5.40), 3)
    0.919
    """
    low, high = _zone(value, lower, upper)
    _check_number("standard uncertainty", uncertainty)
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


def _rule(name: str) -> str:
    """Return the rule of a name."""
    key = name.lower() if isinstance(name, str) else ""
    if key not in RULES:
        raise UnknownNameError(f"decision rule {name!r} is not known; choose one of {', '.join(RULES)}", tuple(RULES))
    return RULES[key]


def _zone(value: float, lower: float | None, upper: float | None) -> tuple[float, float]:
    """Return the limits with infinity for those not given."""
    if lower is None and upper is None:
        raise ArgumentError("no limit is given; state lower, upper or both")
    for what, number in (("value", value), ("lower limit", lower), ("upper limit", upper)):
        if number is not None or what == "value":
            _check_number(what, number)
    low, high = -math.inf if lower is None else lower, math.inf if upper is None else upper
    if not low < high:
        raise ArgumentError(f"lower limit {low:g} is not below the upper limit {high:g}")
    return low, high


def _check_number(what: str, number: Any) -> None:
    """Refuse what is no finite number."""
    if not isinstance(number, Real) or not math.isfinite(number):
        raise ArgumentError(f"{what} is {number!r}; expected a finite number (leave out a limit that is not there)")


def _most(a: float, b: float) -> bool:
    """Whether ``a <= b``, rounding allowed for."""
    if math.isinf(a) or math.isinf(b):
        return a <= b
    return a - b <= ROUNDING * max(abs(a), abs(b))


def _by_probability(value: float, p: float, zone: tuple[float, float], wanted: float) -> str:
    """Return the statement of ISO 14253-1:2017."""
    if p >= wanted - ROUNDING:
        return PASS
    outside = not (zone[0] <= value <= zone[1])
    return FAIL if outside and p <= 1.0 - wanted + ROUNDING else NOT_DECIDED


def _by_guard_band(rule: str, y: float, U: float, zone: tuple[float, float]) -> str:
    """Return the statement of a rule that holds a value against limits moved by U."""
    low, high = zone
    if _most(low, y - U) and _most(y + U, high):
        return PASS
    if rule in ("simple", "ilac-g8-guard-band"):
        return FAIL
    if rule == "iso-14253-1:1998":
        return FAIL if _most(y + U, low) or _most(high, y - U) else NOT_DECIDED
    if not _most(low, y + U) or not _most(y - U, high):
        return FAIL
    return "conditional pass" if _most(low, y) and _most(y, high) else "conditional fail"


def _acceptance(
    u: float, lower: float | None, upper: float | None, wanted: float, nonnegative: bool
) -> tuple[tuple[float, float] | None, float]:
    """Return the values that pass by probability (None: there are none), and the highest probability reached."""

    def p(y: float) -> float:
        return conformance_probability(y, u, lower=lower, upper=upper, nonnegative=nonnegative)

    start = -FURTHEST * u if nonnegative else -math.inf
    low, high = -math.inf if lower is None else lower, math.inf if upper is None else upper
    if nonnegative:
        low = max(low, 0.0)
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
    return float(brentq(lambda y: p(y) - wanted, out, inside, xtol=1e-13 * max(abs(out), abs(inside), u), rtol=1e-14))


def _too_coarse(best: float | None, wanted: float) -> str:
    """Return why no value could pass."""
    reached = "" if best is None else f" (highest conformance probability {best:.3g}, asked for {wanted:g})"
    return f"no value could pass: the uncertainty is too large for these limits{reached}"
