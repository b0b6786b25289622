"""The house's least squares against certified regressions."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

from hexathermal.errors import ArgumentError
from hexathermal.learn.least_squares import least_squares
from tests.learn.strd import Regression, regressions

CERTIFIED = regressions()


def close(found: float, certified: str) -> bool:
    """Whether a number agrees with all printed digits: within one unit of the last of 15."""
    return abs(found - float(certified)) <= 1e-14 * max(abs(float(certified)), 1e-300) * 2.0


@pytest.mark.parametrize("one", CERTIFIED, ids=lambda one: one.name)
def test_certified_regressions_of_nist_to_the_printed_digits(one: Regression) -> None:
    """Coefficients, their standard deviations and the residual's, of NIST's eleven regressions, to 15 digits."""
    fit = least_squares(one.X, one.y)
    for value, certified in zip(fit.coefficients, one.coefficients, strict=True):
        assert close(value, certified), (value, certified)
    if one.residual == "0":
        assert fit.residual_sd <= 1e-14 * float(max(abs(one.y)))
        return
    for value, certified in zip(np.sqrt(np.diagonal(fit.covariance)), one.deviations, strict=True):
        assert close(value, certified), (value, certified)
    assert close(fit.residual_sd, one.residual)


@pytest.mark.parametrize("one", [one for one in CERTIFIED if one.name != "Filip"], ids=lambda one: one.name)
def test_doubles_alone_keep_nine_digits(one: Regression) -> None:
    """With the design matrix rounded to doubles, as data come, at least 9 digits are right."""
    fit = least_squares(one.X.astype(np.float64), one.y.astype(np.float64))
    certified = np.array([float(text) for text in one.coefficients])
    assert np.abs(fit.coefficients / certified - 1.0).max() < 1e-9


def test_filip_rounded_to_doubles_keeps_what_its_condition_allows() -> None:
    """Filip's powers, rounded to doubles, still give 6 digits."""
    one = next(one for one in CERTIFIED if one.name == "Filip")
    fit = least_squares(one.X.astype(np.float64), one.y.astype(np.float64))
    assert np.abs(fit.coefficients / np.array([float(text) for text in one.coefficients]) - 1.0).max() < 1e-6
    assert fit.condition > 1e9


def test_the_calibration_line_of_the_gum() -> None:
    """GUM H.3: the thermometer's calibration line, its uncertainties and its prediction at 30 degC, as printed."""
    t = [21.521, 22.012, 22.512, 23.003, 23.507, 23.999, 24.513, 25.002, 25.503, 26.010, 26.511]
    b = [-0.171, -0.169, -0.166, -0.159, -0.164, -0.165, -0.156, -0.157, -0.159, -0.161, -0.160]
    fit = least_squares(np.column_stack([np.ones(11), np.array(t) - 20.0]), b)
    y1, y2 = fit.coefficients
    s1, s2 = np.sqrt(np.diagonal(fit.covariance))
    assert f"{y1:.4f} {s1:.4f} {y2:.5f} {s2:.5f}" == "-0.1712 0.0029 0.00218 0.00067"
    assert f"{fit.covariance[0, 1] / s1 / s2:.3f} {fit.residual_sd:.4f}" == "-0.930 0.0035"
    x = np.array([1.0, 10.0])
    assert f"{x @ fit.coefficients:.4f} {np.sqrt(x @ fit.covariance @ x):.4f}" == "-0.1494 0.0041"


def test_columns_that_depend_on_each_other_are_refused() -> None:
    """No silent answer where coefficients cannot be told apart, where rows are missing, or a value is not finite."""
    x = np.linspace(0.0, 1.0, 20)
    with pytest.raises(ArgumentError, match="depend on each other"):
        least_squares(np.column_stack([x, 2.0 * x]), x)
    with pytest.raises(ArgumentError, match="column 2 of X is zero"):
        least_squares(np.column_stack([x, 0.0 * x]), x)
    with pytest.raises(ArgumentError, match="1 rows cannot determine 2"):
        least_squares([[1.0, 2.0]], [1.0])
    with pytest.raises(ArgumentError, match="not finite"):
        least_squares([[1.0], [np.nan]], [1.0, 2.0])
    with pytest.raises(ArgumentError, match="shape"):
        least_squares([1.0, 2.0], [1.0, 2.0])


def test_fractions_give_the_exact_answer() -> None:
    """Exact numbers in, the answer correctly rounded out: 1/3."""
    fit = least_squares(np.array([[Fraction(3)], [Fraction(6)]], dtype=object), np.array([Fraction(1), Fraction(2)]))
    assert fit.coefficients[0] == 1.0 / 3.0
