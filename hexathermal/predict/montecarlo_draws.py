"""Draws of a machine that deviates, and what sequences of them say (GUM supplement 1, JCGM 101)."""

from __future__ import annotations

import numpy as np

from hexathermal.errors import ArgumentError, NotConvergedError
from hexathermal.poses import FloatArray, finite_array
from hexathermal.predict.budget_inputs import Situation
from hexathermal.predict.budget_rates import CHECK_SOURCES, TOO_FAR
from hexathermal.predict.sources import Source, Sources

SEQUENCE = 10_000
"""Draws of a sequence (JCGM 101, 7.9.4: at least 1e4, and 100 / (1 - p))."""

SLICE = 2_000
"""Draws that are worked on together: a row of deviations has some 100 numbers."""


FARTHEST = 1e3
"""An error [m, rad] beyond this is lost, whatever it comes from."""


class Drawn:
    """Draws of the platform's error: ``drawn(count, generator)`` gives exact errors (count, 6); lost rows are NaN."""

    def __init__(self, here: Situation, sources: Sources) -> None:
        self.here, self.sources = here, sources
        self.factors = [here.factors(source)[0] for source in sources]

    def deviations(self, count: int, generator: np.random.Generator) -> FloatArray:
        """Return drawn deviations (size + 6, count), one row a number; the last six are the pose's own."""
        out = np.zeros((self.here.size + 6, count))
        for source, factors in zip(self.sources, self.factors, strict=True):
            rows = np.flatnonzero(factors.any(axis=1))
            if rows.size:
                z = variables(source, (factors.shape[1], count), generator)
                used = slice(rows[0], rows[-1] + 1)
                own = factors[used]
                if own.shape[0] == own.shape[1] and np.count_nonzero(own - np.diag(np.diag(own))) == 0:
                    z *= np.diag(own)[:, None]
                    out[used] += z
                else:
                    out[used] += own @ z
        return out

    def __call__(self, count: int, generator: np.random.Generator) -> FloatArray:
        """Return drawn errors (count, 6) [m, rad]."""
        out = np.empty((count, 6))
        for first in range(0, count, SLICE):
            x = self.deviations(min(SLICE, count - first), generator)
            own = self.here.size
            errors, good = self.here.tried(np.ascontiguousarray(x[:own].T))
            errors += x[own:].T
            # the pose's own offsets may be as far off as the tail of a t distribution reaches
            errors[~(good & (np.abs(errors) < FARTHEST).all(axis=1))] = np.nan
            out[first : first + SLICE] = errors
        return out


def variables(source: Source, shape: tuple[int, int], generator: np.random.Generator) -> FloatArray:
    """Return draws (r, count) of a source's own variables, in units of its standard uncertainty.

    Bounded distributions have unit variance; t is scaled, not standardized (JCGM 101, 6.4.9.2), and correlated numbers
    share one chi-square.
    """
    if source.distribution == "uniform":
        return generator.uniform(-(3.0**0.5), 3.0**0.5, shape)
    if source.distribution == "triangular":
        return generator.triangular(-(6.0**0.5), 0.0, 6.0**0.5, shape)
    if source.distribution == "arcsine":
        return np.asarray(2.0**0.5 * np.sin(generator.uniform(-np.pi, np.pi, shape)))
    z = generator.standard_normal(shape)
    if source.distribution == "t":
        own = (1, shape[1]) if source.joint else shape
        with np.errstate(divide="ignore", over="ignore", invalid="ignore"):  # few degrees of freedom reach infinity
            z /= np.sqrt(generator.chisquare(source.dof, own) / source.dof)
    return z


FLAT, FLAT_DRAWS = 0.01, 10_000
"""Intervals longer than the shortest by less than this part, at so many values, cannot be told from it by chance."""


def shortest_interval(values: FloatArray, probability: float) -> tuple[FloatArray, FloatArray]:
    """Return the shortest intervals (JCGM 101, 7.7.4) that hold a part of values (n, k); one for each column.

    Among all intervals between sorted values with ``q = p n`` values inside, the narrowest; where `n` is so small that
    ``q`` is all of them, the whole range.  Near the narrowest the widths hardly differ, and chance would choose among
    them: of its neighbours that are longer by less than ``0.01 (1e4 / n)^(2/3)`` of it, at most 1 %, the middle one is
    taken, unless they end at one end of the values, as those of a distribution that only falls do.

    Examples
    --------
    >>> low, high = shortest_interval(np.array([[0.0], [10.0], [11.0], [12.0], [13.0]]), 0.6)
    >>> low.item(), high.item()
    (10.0, 13.0)
    """
    ordered = np.sort(values, axis=0)
    q = min(int(probability * len(ordered) + 0.5), len(ordered) - 1)
    widths = ordered[q:] - ordered[: len(ordered) - q]
    longest = 1.0 + FLAT * min(1.0, (FLAT_DRAWS / len(ordered)) ** (2.0 / 3.0))
    first = np.array([_middle(column, longest) for column in widths.T], dtype=np.intp)
    columns = np.arange(ordered.shape[1])
    return ordered[first, columns], ordered[first + q, columns]


def _middle(widths: FloatArray, longest: float) -> int:
    """Return the middle of the widths beside the least that are at most `longest` times as long."""
    least = int(widths.argmin())
    longer = np.flatnonzero(widths > widths[least] * longest)
    place = int(np.searchsorted(longer, least))
    low = int(longer[place - 1]) + 1 if place else 0
    high = int(longer[place]) - 1 if place < len(longer) else len(widths) - 1
    return (low + high) // 2 if (low == 0) == (high == len(widths) - 1) else least


MOST_LOST = 1e-3
"""Largest part of the draws that may be lost; a tenth of ``1 - p`` where that is less."""


class Sample:
    """Drawn errors in sequences of equal length, and the results of each sequence; lost draws are counted."""

    def __init__(self, probability: float, most_lost: float | None = None) -> None:
        self.probability, self.share = probability, _share(most_lost, probability)
        # 1 - 0.9999 is rounded: a millionth of a draw is none
        self.length = max(SEQUENCE, int(np.ceil(100.0 / (1.0 - probability) - 1e-6)))
        self.errors: list[FloatArray] = []
        self.found: list[FloatArray] = []

    @property
    def draws(self) -> int:
        """Number of draws, lost ones too."""
        return len(self.errors) * self.length

    @property
    def lost(self) -> int:
        """Number of lost draws."""
        return self.draws - sum(map(len, self.errors))

    @property
    def scatter(self) -> FloatArray:
        """Twice the standard deviation of the averages over sequences; infinite for a single one."""
        if len(self.found) < 2:
            return np.full((4, 6), np.inf)
        return np.asarray(2.0 * np.std(self.found, axis=0, ddof=1) / np.sqrt(len(self.found)))

    def add(self, errors: FloatArray, least: int) -> None:
        """Add a sequence (n, 6); rows of NaN are lost. Refuse more of them than `least` draws may have."""
        self.errors.append(errors[~np.isnan(errors[:, 0])])
        self.refuse_lost(max(self.draws, least))
        self.found.append(self._summary(self.errors[-1], len(errors)))

    def refuse_lost(self, draws: int) -> None:
        """Raise where more draws are lost than so many may have."""
        if self.lost > self.share * draws:
            raise NotConvergedError(
                f"{self.lost} of {self.draws} draws ({percent(self.lost / self.draws)}, allowed "
                f"{percent(self.share)}: most_lost) {TOO_FAR}; {CHECK_SOURCES}"
            )

    def whole(self) -> FloatArray:
        """Return the results of all draws together, shape (4, 6)."""
        return self._summary(np.concatenate(self.errors), self.draws)

    def _summary(self, errors: FloatArray, draws: int) -> FloatArray:
        """Return mean, standard deviation and shortest interval of errors, which holds a part of all draws."""
        low, high = shortest_interval(errors, self.probability * draws / len(errors))
        return np.array([errors.mean(axis=0), errors.std(axis=0, ddof=1), low, high])


def _share(given: float | None, p: float) -> float:
    """Return the checked part of the draws that may be lost."""
    if given is None:
        return min(MOST_LOST, 0.1 * (1.0 - p))
    number = finite_array(given, (), "most_lost")
    if number.shape or not 0.0 <= number < 1.0 - p:
        raise ArgumentError(f"most_lost must lie between 0 and {1.0 - p:.3g} (1 - probability), found {given!r}")
    return float(number)


def percent(part: float) -> str:
    """Return a part as percent, for people."""
    return f"{100.0 * part:.3g} %"
