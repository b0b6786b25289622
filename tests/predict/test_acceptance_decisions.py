"""Decision rules: published examples, exact boundaries, and properties that any rule must have."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from hexathermal.errors import ArgumentError, UnknownNameError
from hexathermal.predict.acceptance import FAIL, NOT_DECIDED, PASS, RULES, conformance_probability, decide

ALL = sorted(set(RULES.values()))
VALUES = st.floats(-5.0, 5.0)
SIZES = st.floats(0.01, 3.0)


@pytest.mark.parametrize(
    ("value", "u", "limits", "published"),
    [
        (-5.47, 0.05, {"upper": -5.40}, 0.919),
        (509.7, 8.6, {"lower": 490.0}, 0.989),
    ],
    ids=["Zener diode", "metal container"],
)
def test_worked_examples_of_jcgm_106(value: float, u: float, limits: dict[str, float], published: float) -> None:
    """Conformance probabilities that JCGM 106:2012 prints come out with its digits."""
    assert round(conformance_probability(value, u, **limits), 3) == published


@pytest.mark.parametrize(("p", "z"), [(0.80, 0.84), (0.90, 1.28), (0.95, 1.64), (0.99, 2.33), (0.999, 3.09)])
def test_guard_bands_of_jcgm_106_table_1(p: float, z: float) -> None:
    """For one limit the guard band is z u, with the z that JCGM 106:2012 tabulates, and 1.645 at 95 %."""
    zone = decide(0.0, 0.1, upper=1.0, probability=p).acceptance
    assert zone is not None
    assert (1.0 - zone[1]) / 0.1 == pytest.approx(z, abs=0.006)
    if p == 0.95:
        assert (1.0 - zone[1]) / 0.1 == pytest.approx(1.644854, abs=1e-6)


def test_speed_limit_of_jcgm_106() -> None:
    """A radar with 2 % standard uncertainty proves 100 km/h exceeded, with 99.9 %, from 107 km/h on."""
    said = [decide(v, 0.02 * v, lower=100.0, probability=0.999).verdict for v in (106.0, 107.0)]
    assert said == [NOT_DECIDED, PASS]


def test_the_residual_of_the_paper_against_its_target() -> None:
    """1.28 um against 1.5 um with u = 0.13 um: accepted up to 1.286 um, and not by the U rule, up to 1.24 um."""
    new, old = (decide(1.28, 0.13, upper=1.5, rule=rule) for rule in ("iso-14253-1", "iso-14253-1:1998"))
    assert (new.verdict, old.verdict) == (PASS, NOT_DECIDED)
    assert new.acceptance is not None
    assert old.acceptance is not None
    assert new.acceptance[1] == pytest.approx(1.28617, abs=1e-5)
    assert old.acceptance[1] == pytest.approx(1.24, abs=1e-12)


@pytest.mark.parametrize(
    ("value", "statement", "verdict"),
    [
        (0.79, "pass", PASS),
        (0.8, "pass", PASS),
        (0.81, "conditional pass", NOT_DECIDED),
        (1.0, "conditional pass", NOT_DECIDED),
        (1.01, "conditional fail", NOT_DECIDED),
        (1.2, "conditional fail", NOT_DECIDED),
        (1.21, "fail", FAIL),
        (-1.21, "fail", FAIL),
        (-1.1, "conditional fail", NOT_DECIDED),
    ],
)
def test_four_statements_of_ilac_g8(value: float, statement: str, verdict: str) -> None:
    """With w = U = 0.2 about limits of +-1: four statements, two of them decided; the binary rules know two."""
    said = decide(value, 0.1, lower=-1.0, upper=1.0, rule="ilac-g8")
    assert (said.statement, said.verdict) == (statement, verdict)
    binary = decide(value, 0.1, lower=-1.0, upper=1.0, rule="ilac-g8-guard-band").verdict
    assert binary == (PASS if statement == "pass" else FAIL)
    simple = decide(value, 0.1, lower=-1.0, upper=1.0, rule="simple").verdict
    assert simple == (PASS if abs(value) <= 1.0 else FAIL)


@pytest.mark.parametrize(("value", "verdict"), [(0.8, PASS), (0.81, NOT_DECIDED), (1.19, NOT_DECIDED), (1.2, FAIL)])
def test_u_rule_at_its_boundaries(value: float, verdict: str) -> None:
    """The older rule passes up to H - U and fails from H + U on, both included, whatever decimals round to."""
    assert decide(value, 0.1, upper=1.0, rule="u-rule").verdict == verdict
    assert decide(value * 3e-7, 0.3e-7, upper=3e-7, rule="iso-14253-1:2013").verdict == verdict


def test_rounding_decides_nothing() -> None:
    """0.1 + 0.2 = 0.30000000000000004 keeps a limit of 0.3."""
    assert decide(0.2, 0.05, upper=0.3, rule="u-rule").verdict == PASS
    assert decide(0.1 + 0.2, None, upper=0.3, rule="simple").verdict == PASS


def test_narrow_zone_counts_both_sides() -> None:
    """In a zone of +-1.8 u the centre has p = 0.928: one-sided bands of 1.645 u would pass it, both sides do not."""
    said = decide(0.0, 1.0, lower=-1.8, upper=1.8)
    assert said.verdict == NOT_DECIDED
    assert said.probability == pytest.approx(0.92814, abs=1e-5)
    assert said.acceptance is None
    assert "no value could pass" in said.note
    assert "0.928" in said.note


def test_a_measurement_that_knows_nothing_fails_nobody() -> None:
    """A value inside its limits is never called a fail, though a vast uncertainty makes conformity improbable."""
    said = decide(0.0, 50.0, lower=-1.0, upper=1.0)
    assert said.probability is not None
    assert said.probability < 0.05
    assert said.verdict == NOT_DECIDED


def test_consumers_risk_at_the_limit_is_five_percent(rng: np.random.Generator) -> None:
    """Of machines exactly at the limit, the default rule passes 5 % and fails 5 %: 4000 draws."""
    said = [decide(y, 0.2, upper=1.0).verdict for y in rng.normal(1.0, 0.2, 4000)]
    assert said.count(PASS) / 4000 == pytest.approx(0.05, abs=0.012)
    assert said.count(FAIL) / 4000 == pytest.approx(0.05, abs=0.012)


def test_probability_of_a_quantity_that_cannot_be_negative(rng: np.random.Generator) -> None:
    """Cut at zero and scaled, the probability is the share of positive draws below the limit: 4e5 draws."""
    draws = rng.normal(0.3, 0.5, 400_000)
    share = (draws[draws >= 0.0] <= 0.9).mean()
    assert conformance_probability(0.3, 0.5, upper=0.9, nonnegative=True) == pytest.approx(share, abs=0.004)
    assert conformance_probability(0.3, 0.5, upper=0.9) == pytest.approx((draws <= 0.9).mean(), abs=0.004)


def test_improbable_conformity_keeps_its_digits() -> None:
    """Ten standard uncertainties outside a zone, on either side, p = 7.6199e-24: no difference of ones."""
    for side in (1.0, -1.0):
        limits = sorted((0.0, side))
        p = conformance_probability(-10.0 * side, 1.0, lower=limits[0], upper=limits[1])
        assert p == pytest.approx(7.6199e-24, rel=1e-4)


def test_cut_at_zero_matters_only_near_zero() -> None:
    """Far above zero the cut changes nothing; a lower limit at zero then is no limit."""
    assert conformance_probability(9.0, 0.5, upper=9.5, nonnegative=True) == pytest.approx(
        conformance_probability(9.0, 0.5, upper=9.5), abs=1e-15
    )
    assert conformance_probability(0.1, 0.5, lower=0.0, nonnegative=True) == 1.0


@given(VALUES, SIZES, VALUES, SIZES, st.sampled_from(ALL))
def test_mirrored_quantities_are_decided_alike(y: float, u: float, low: float, width: float, rule: str) -> None:
    """Changing the sign of value and limits changes no verdict and no probability."""
    one = decide(y, u, lower=low, upper=low + width, rule=rule)
    other = decide(-y, u, lower=-low - width, upper=-low, rule=rule)
    assert one.statement == other.statement
    assert one.probability == pytest.approx(other.probability, abs=1e-14)


@given(VALUES, SIZES, VALUES, SIZES, st.sampled_from(ALL), st.sampled_from([1e-9, 1e-6, 1e3]))
def test_units_do_not_matter(y: float, u: float, low: float, width: float, rule: str, unit: float) -> None:
    """Metres or micrometres: the same verdict, unless the value sits on a boundary within rounding."""
    high = low + width
    one = decide(y, u, lower=low, upper=high, rule=rule)
    for edge in (low - 2 * u, low, low + 2 * u, high - 2 * u, high, high + 2 * u, *(one.acceptance or ())):
        assume(abs(y - edge) > 1e-9)
    assume(one.probability is not None and min(abs(one.probability - 0.05), abs(one.probability - 0.95)) > 1e-9)
    other = decide(y * unit, u * unit, lower=low * unit, upper=high * unit, rule=rule)
    assert one.statement == other.statement


@given(VALUES, SIZES, st.one_of(st.none(), VALUES), SIZES, st.sampled_from(ALL), st.booleans())
def test_acceptance_zone_is_where_values_pass(
    y: float, u: float, low: float | None, width: float, rule: str, cut: bool
) -> None:
    """A value passes if, and only if, it lies in the acceptance zone of the decision."""
    upper = width if low is None else low + width
    assume(not cut or (upper > 0.1 and y > -5.0 * u and (low is None or low > 0.05)))
    said = decide(y, u, lower=low, upper=upper, rule=rule, nonnegative=cut)
    zone = said.acceptance or (math.inf, -math.inf)
    assume(min(abs(y - zone[0]), abs(y - zone[1])) > 1e-7)
    assert (said.verdict == PASS) == (zone[0] <= y <= zone[1])
    assert (said.acceptance is None) == bool(said.note)


@given(VALUES, SIZES, st.sampled_from(ALL))
def test_better_values_are_never_judged_worse(y: float, u: float, rule: str) -> None:
    """Below an upper limit, less is never worse: verdicts go from pass over not decided to fail."""
    order = {PASS: 0, NOT_DECIDED: 1, FAIL: 2}
    verdicts = [order[decide(y + step, u, upper=1.0, rule=rule).verdict] for step in (0.0, 0.3, 0.9, 3.0)]
    assert verdicts == sorted(verdicts)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"uncertainty": None}, "needs the standard uncertainty"),
        ({"uncertainty": 0.0}, "above 0"),
        ({"uncertainty": -1.0}, "above 0"),
        ({"uncertainty": math.nan}, "finite"),
        ({"value": math.nan}, "finite"),
        ({"value": "0.5"}, "finite number"),
        ({"value": None}, "finite number"),
        ({"uncertainty": [0.1]}, "finite number"),
        ({"upper": math.inf}, "finite"),
        ({"upper": None}, "no limit"),
        ({"lower": 2.0}, "not below"),
        ({"lower": 1.0}, "not below"),
        ({"probability": 1.0}, "probability is 1"),
        ({"probability": 0.5}, "probability is 0.5"),
        ({"probability": 95.0}, "probability is 95"),
        ({"coverage_factor": 0.0}, "coverage factor is 0"),
        ({"value": -1.0, "nonnegative": True}, "cannot be negative"),
    ],
)
def test_senseless_questions_are_refused(change: dict[str, float], words: str) -> None:
    """A missing or zero uncertainty is never taken as exact; each refusal says what is wrong."""
    fields = {"value": 0.5, "uncertainty": 0.1, "upper": 1.0} | change
    with pytest.raises(ArgumentError, match=words):
        decide(**fields)  # type: ignore[arg-type]


@pytest.mark.parametrize("u", [1e-320, 1e-200, 1e-30, 1e-13])
@pytest.mark.parametrize("limits", [{"upper": 1.0}, {"lower": -1.0}, {"lower": -1.0, "upper": 1.0}, {"upper": 1e300}])
def test_tiny_uncertainties_leave_the_limits_themselves(u: float, limits: dict[str, float]) -> None:
    """Where the guard band is lost in rounding, what lies inside passes, and what lies outside fails."""
    assert decide(0.5, u, **limits).verdict == PASS
    assert decide(1.5e301 if "upper" in limits else -2.0, u, **limits).verdict == FAIL


@pytest.mark.parametrize("unit", [1e-310, 1e-150, 1e150])
def test_extreme_units_are_decided_too(unit: float) -> None:
    """Numbers near the ends of what a double holds are decided, never a failed search."""
    assert decide(1.28 * unit, 0.13 * unit, upper=1.5 * unit).verdict == PASS
    assert decide(0.0, 0.13 * unit, upper=0.0).verdict == NOT_DECIDED


def test_unknown_rules_list_the_known_ones() -> None:
    """A misspelled rule is refused, and names are found whatever their letters' case."""
    with pytest.raises(UnknownNameError, match="ilac-g8") as caught:
        decide(0.0, 1.0, upper=1.0, rule="iso")
    assert set(caught.value.available) == set(RULES)
    assert decide(0.0, 1.0, upper=9.0, rule="ISO-14253-1:2017").rule == "iso-14253-1"


def test_simple_acceptance_needs_no_uncertainty_and_tells_no_probability() -> None:
    """Asked for by name, a value counts as it is; without an uncertainty nothing is said of probability."""
    said = decide(1.0, None, upper=1.0, rule="iso-10360")
    assert (said.verdict, said.probability, said.acceptance) == (PASS, None, (-math.inf, 1.0))
    assert decide(1.0, 0.1, upper=1.0, rule="simple").probability == pytest.approx(0.5)
