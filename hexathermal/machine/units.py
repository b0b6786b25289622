"""The unit border of files: exact decimal conversion, so that reading and writing lose nothing.

A file holds decimal numbers in millimetres or degrees, the core doubles in metres or radians.  Files are read as
decimals and rounded once; a double is written as the shortest decimal that is read back as the same double.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from decimal import MAX_EMAX, MIN_EMIN, ROUND_HALF_EVEN, Context, Decimal, localcontext

PI = Decimal("3.14159265358979323846264338327950288419716939937510582097494")

_OWN = Context(prec=60, rounding=ROUND_HALF_EVEN, Emin=MIN_EMIN, Emax=MAX_EMAX, capitals=1, clamp=0, flags=[], traps=[])
"""The caller's decimal context may be of any precision; a machine must not depend on it."""


def metres(value_mm: Decimal) -> float:
    """Return millimetres as metres."""
    sign, digits, exponent = value_mm.as_tuple()
    if not isinstance(exponent, int):
        return float(value_mm)
    return float(f"{'-' * sign}{''.join(map(str, digits))}e{exponent - 3}")


def radians(value_deg: Decimal) -> float:
    """Return degrees as radians."""
    with localcontext(_OWN):
        return float(value_deg * PI / 180)


def same(value: Decimal) -> float:
    """Return a number as it is."""
    return float(value)


def millionths(value: float, power: int = 1) -> Decimal:
    """Return a number in millionths (squared: `power` 2), to the last digit: micrometres of metres.

    Examples
    --------
    >>> str(millionths(2.5e-7)), from_millionths(millionths(2.5e-7))
    ('0.25', 2.5e-07)
    """
    number = Decimal(repr(float(value)))
    with localcontext(_OWN):
        return number.scaleb(6 * power) if number else number.quantize(1)


def from_millionths(value: Decimal | int, power: int = 1) -> float:
    """Return what `millionths` made, as it was."""
    with localcontext(_OWN):
        return float(Decimal(value).scaleb(-6 * power))


def shortest(value: float, reader: Callable[[Decimal], float]) -> Decimal:
    """Return the decimal with the fewest digits that `reader` turns into exactly `value`, its sign included.

    Examples
    --------
    >>> str(shortest(0.25, metres)), str(shortest(radians(Decimal("12.5")), radians))
    ('250', '12.5')
    """
    if value == 0.0:
        return Decimal("-0" if math.copysign(1.0, value) < 0.0 else "0")
    with localcontext(_OWN) as context:
        exact = Decimal(value)
        if reader is not same:
            exact = exact * 180 / PI if reader is radians else exact * 1000
        for digits in range(1, 26):
            context.prec = digits
            rounded = +exact
            context.prec = _OWN.prec
            if reader(rounded) == value:
                return _plain(rounded)
        return exact


def _plain(value: Decimal) -> Decimal:
    """Return the same number without an exponent, unless it is very small."""
    value = value.normalize()
    sign, digits, exponent = value.as_tuple()
    if isinstance(exponent, int) and exponent > 0:
        return Decimal((sign, digits + (0,) * exponent, 0))
    return value
