"""Parts of an error in words: by how much it became less, and whether that is proven; and probabilities."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from hexathermal.learn.validation_scores import Figure


def percent(part: float) -> str:
    """Return a part in whole percent.

    Examples
    --------
    >>> percent(-0.002), percent(0.207)
    ('0', '21')
    """
    return f"{round(100.0 * part) + 0:d}" if math.isfinite(part) else "-"


def parts(part: float) -> str:
    """Return a part in percent, with a decimal below 10 %.

    Examples
    --------
    >>> parts(0.207), parts(0.0042), parts(-1e-9)
    ('21', '0.4', '0.0')
    """
    return f"{round(100.0 * part, 1) + 0.0:.1f}" if abs(part) < 0.0995 else percent(part)


def bounded(part: Figure) -> bool:
    """Return whether a number has an interval; one landing alone gives none."""
    return math.isfinite(part.low) and math.isfinite(part.high)


def interval(part: Figure) -> str:
    """Return the ends of a number's interval in percent, for a table.

    Examples
    --------
    >>> from hexathermal.learn.validation_scores import Figure
    >>> interval(Figure(0.213, 0.102, 0.307)), interval(Figure(0.3, -math.inf, math.inf))
    ('10 to 31', 'none: one landing')
    """
    return f"{parts(part.low)} to {parts(part.high)}" if bounded(part) else "none: one landing"


def less(part: Figure) -> str:
    """Return by how much an error became less, in words.

    Examples
    --------
    >>> from hexathermal.learn.validation_scores import Figure
    >>> less(Figure(0.213, 0.102, 0.307)), less(Figure(-0.005, -0.08, 0.06))
    ('21 % less, 95 %: 10 to 31 %', '0.5 % more, 95 %: -6.0 to 8.0 %')
    >>> less(Figure(0.3, -math.inf, math.inf)), proven(Figure(0.3, -math.inf, math.inf))
    ('30 % less, one landing: no interval', 'not proven')
    """
    sign, word = (1.0, "less") if part.value >= 0.0 else (-1.0, "more")
    if not bounded(part):
        return f"{parts(sign * part.value)} % {word}, one landing: no interval"
    ends = sorted((sign * part.low, sign * part.high))
    return f"{parts(sign * part.value)} % {word}, 95 %: {parts(ends[0])} to {parts(ends[1])} %"


def proven(part: Figure) -> str:
    """Return what the interval of a gain proves.

    Examples
    --------
    >>> from hexathermal.learn.validation_scores import Figure
    >>> proven(Figure(0.2, 0.1, 0.3)), proven(Figure(-0.2, -0.3, -0.1)), proven(Figure(0.2, -0.1, 0.3))
    ('proven', 'proven to be worse', 'not proven: the interval holds 0')
    """
    if not bounded(part):
        return "not proven"
    return (
        "proven" if part.low > 0.0 else "proven to be worse" if part.high < 0.0 else "not proven: the interval holds 0"
    )


def probability(value: float) -> str:
    """Return a probability without claiming certainty.

    Examples
    --------
    >>> probability(0.99999), probability(0.974), probability(0.0001)
    ('>0.999', '0.974', '<0.001')
    """
    return ">0.999" if value > 0.999 else "<0.001" if value < 0.001 else f"{value:z.3f}"
