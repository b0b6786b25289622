"""The unit border of files: exact decimal conversion, so that reading and writing lose nothing.

A file holds decimal numbers in millimetres or degrees, the core doubles in metres or radians.  Files are read as
decimals and rounded once; a double is written as the shortest decimal that is read back as the same double.
"""

from __future__ import annotations

from collections.abc import Callable
from decimal import Decimal, localcontext

PI = Decimal("3.14159265358979323846264338327950288419716939937510582097494")


def metres(value_mm: Decimal) -> float:
    """Return millimetres as metres."""
    return float(value_mm.scaleb(-3))


def radians(value_deg: Decimal) -> float:
    """Return degrees as radians."""
    with localcontext() as context:
        context.prec = 50
        return float(value_deg * PI / 180)


def same(value: Decimal) -> float:
    """Return a number as it is."""
    return float(value)


_FACTORS: dict[Callable[[Decimal], float], Decimal] = {metres: Decimal(1000), radians: 180 / PI, same: Decimal(1)}


def shortest(value: float, reader: Callable[[Decimal], float]) -> Decimal:
    """Return the decimal with the fewest digits that `reader` turns into exactly `value`.

    Examples
    --------
    >>> str(shortest(0.25, metres)), str(shortest(radians(Decimal("12.5")), radians))
    ('250', '12.5')
    """
    with localcontext() as context:
        context.prec = 60
        exact = Decimal(value) * (180 / PI if reader is radians else _FACTORS[reader])
        for digits in range(1, 26):
            context.prec = digits
            rounded = +exact
            if reader(rounded) == value:
                context.prec = 60
                return _plain(rounded)
        return exact


def _plain(value: Decimal) -> Decimal:
    """Return the same number without an exponent, unless it is very small."""
    value = value.normalize()
    sign, digits, exponent = value.as_tuple()
    if isinstance(exponent, int) and exponent > 0:
        return Decimal((sign, digits + (0,) * exponent, 0))
    return value
