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
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from hexathermal.errors import ArgumentError, UnknownNameError
from hexathermal.predict.acceptance.conformance import (
    acceptance_by_probability,
    check_number,
    conformance_probability,
    zone_of,
)

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
    value, lower, upper : float
        Measured value and its limits, at least one of them, in any unit.
    uncertainty : float or None
        Standard uncertainty in the same unit, above 0; None only with the rule ``simple``.
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
    ArgumentError, UnknownNameError
        No limit, wrong order of limits, a number out of range, no uncertainty though the rule needs one; no such rule.

    Examples
    --------
    >>> decide(1.28, 0.13, upper=1.5).verdict
    'pass'
    >>> decide(1.28, 0.13, upper=1.5, rule="iso-14253-1:1998").verdict
    'not decided'
    """
    name = _rule(rule)
    _check_question(rule, uncertainty, probability, coverage_factor)
    zone = zone_of(value, lower, upper)
    best, p, U = None, None, 0.0
    if uncertainty is not None:
        p = conformance_probability(value, uncertainty, lower=lower, upper=upper, nonnegative=nonnegative)
        U = 0.0 if name == "simple" else coverage_factor * uncertainty
    if name == "iso-14253-1" and p is not None and uncertainty is not None:
        statement = _by_probability(value, p, zone, probability)
        passing, best = acceptance_by_probability(uncertainty, lower, upper, probability, nonnegative)
    else:
        statement = _by_guard_band(name, value, U, zone)
        passing = (zone[0] + U, zone[1] - U) if _most(zone[0] + U, zone[1] - U) else None
    verdict = statement if statement in (PASS, FAIL) else NOT_DECIDED
    note = "" if passing is not None else _too_coarse(best, probability)
    return Decision(verdict, statement, p, value, uncertainty, lower, upper, name, passing, note)


def _check_question(rule: str, uncertainty: float | None, probability: float, coverage_factor: float) -> None:
    """Refuse what no rule could decide by."""
    check_number("probability", probability)
    check_number("coverage factor", coverage_factor)
    if not 0.5 < probability < 1.0:
        raise ArgumentError(f"probability is {probability:g}; expected above 0.5 and below 1, such as 0.95")
    if not coverage_factor > 0.0:
        raise ArgumentError(f"coverage factor is {coverage_factor:g}; expected above 0, such as 2")
    if uncertainty is None and _rule(rule) != "simple":
        raise ArgumentError(
            f"the rule {rule!r} needs the standard uncertainty of the value; state it, or ask for the rule 'simple'"
        )


def _rule(name: str) -> str:
    """Return the rule of a name."""
    key = name.lower() if isinstance(name, str) else ""
    if key not in RULES:
        raise UnknownNameError(f"decision rule {name!r} is not known; choose one of {', '.join(RULES)}", tuple(RULES))
    return RULES[key]


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


def _too_coarse(best: float | None, wanted: float) -> str:
    """Return why no value could pass."""
    reached = "" if best is None else f" (highest conformance probability {best:.3g}, asked for {wanted:g})"
    return f"no value could pass: the uncertainty is too large for these limits{reached}"
