"""Rates of a set of draws: by strength, cause and bench; calibration, gain against the oracle's; tables in Markdown."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from itertools import pairwise
from operator import attrgetter
from typing import TypeVar

import numpy as np
from scipy.stats import beta

from benchmarks.hidden_effects import CLEAN, KINDS, ONE, OUTSIDE, TWO, Outcome

STRENGTHS = {"0.25 to 0.35": (0.0, 0.354), "0.35 to 0.7": (0.354, 0.707), "0.7 to 1.4": (0.707, 1.414),
             "1.4 to 2": (1.414, np.inf)}  # fmt: skip
"""Bins of the visible strength: about 0.3, 0.5, 1 and 1.7 of the noise."""

STRENGTHS_BESIDE_ZEROS = {"below 0.25": (0.0, 0.25), **STRENGTHS, "0.25 to 0.35": (0.25, 0.354)}
"""The same of the strength that is visible within runs, which no draw asks for."""

PROBABILITIES = (0.0, 0.5, 0.8, 0.95, 0.99, 1.0 + 1e-9)
GAIN = 0.02
"""Part of the law's RMSE on validation runs below which there is nothing to gain."""

Rows = list[list[str]]
Draw = TypeVar("Draw")

_strength = attrgetter("strength")


def rate(draws: Sequence[Outcome], good: Callable[[Outcome], bool]) -> float:
    """Return the part of draws that are good; NaN of none."""
    return float(np.mean([good(one) for one in draws])) if draws else float("nan")


def of_kind(draws: Iterable[Outcome], *kinds: str) -> list[Outcome]:
    """Return the draws of some kinds."""
    return [one for one in draws if one.kind in kinds]


def stronger(
    draws: Iterable[Outcome], low: float, high: float = np.inf, size: Callable[[Outcome], float] = _strength
) -> list[Outcome]:
    """Return the draws whose weakest effect has a strength in ``low <= s < high``."""
    return [one for one in draws if low <= size(one) < high]


def gain_ratio(draws: Iterable[Outcome]) -> float:
    """Return the sum of gains over the sum of the oracle's, over draws in which the oracle gains `GAIN` or more.

    A draw for which the diagnosis states no gain has gained nothing.
    """
    return _ratio([(one.gain, one.oracle_gain) for one in draws])


def true_gain_ratio(draws: Iterable[Outcome]) -> float:
    """Return the same as `gain_ratio` where the validation runs are without noise."""
    return _ratio([(one.true_gain, one.oracle_true_gain) for one in draws])


def _ratio(pairs: Sequence[tuple[float | None, float | None]]) -> float:
    """Return the sum of first items over that of second items, of pairs whose second item is `GAIN` or more."""
    own = [(first or 0.0, second) for first, second in pairs if second is not None and second > GAIN]
    return sum(first for first, _ in own) / sum(second for _, second in own) if own else float("nan")


def worse(gain: float | None) -> bool:
    """Whether there is a gain, and it is a loss."""
    return gain is not None and gain < 0.0


def calibration_error(draws: Sequence[Outcome]) -> float:
    """Return the mean distance between stated probability and rate of being right over bins, weighted by draws."""
    if not draws:
        return float("nan")
    total = 0.0
    for low, high in pairwise(PROBABILITIES):
        own = [one for one in draws if low <= one.probability < high]
        if own:
            total += abs(sum(one.probability - one.right for one in own))
    return total / len(draws)


def part_of(count: int, of: int) -> str:
    """Return a rate with its 90 % interval (Clopper and Pearson, 1934)."""
    if of == 0:
        return "-"
    low = float(beta.ppf(0.05, count, of - count + 1)) if count else 0.0
    high = float(beta.ppf(0.95, count + 1, of - count)) if count < of else 1.0
    return f"{count / of:.2f} ({low:.2f} to {high:.2f})"


def proportion(draws: Sequence[Draw], good: Callable[[Draw], bool]) -> str:
    """Return the part of draws that are good, with its 90 % interval."""
    return part_of(sum(good(one) for one in draws), len(draws))


def _share(draws: Sequence[Outcome], good: Callable[[Outcome], bool]) -> str:
    """Return a rate with two digits."""
    return f"{rate(draws, good):.2f}" if draws else "-"


def number(value: float) -> str:
    """Return a number with two digits."""
    return f"{value:.2f}" if np.isfinite(value) else "-"


def table(head: Sequence[str], rows: Rows) -> str:
    """Return a table in Markdown."""
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    return "\n".join([*lines, *("| " + " | ".join(row) + " |" for row in rows)]) + "\n"


def by_strength(draws: Sequence[Outcome], kinds: Sequence[str] = (ONE,)) -> str:
    """Return one effect by strength: named, named or equivalent, wrong, and what is said else."""
    return _by_strength(of_kind(draws, *kinds), STRENGTHS, _strength)


def by_strength_beside_zeros(draws: Sequence[Outcome]) -> str:
    """Return the same of one effect by what stays visible where a constant of each run is fitted too."""
    return _by_strength(of_kind(draws, ONE), STRENGTHS_BESIDE_ZEROS, attrgetter("strength_beside_zeros"))


def _by_strength(
    draws: Sequence[Outcome], bins: Mapping[str, tuple[float, float]], size: Callable[[Outcome], float]
) -> str:
    """Return draws by their size: named, named or equivalent, wrong, and what is said else."""
    head = ("strength", "draws", "first name right", "or equivalent", "wrong name", "`none`", "`unexplained`",
            "a name too many", "gain / oracle's")  # fmt: skip
    rows = []
    for label, (low, high) in {**bins, "all": (0.0, np.inf)}.items():
        own = stronger(draws, low, high, size)
        right, wrong = sum(one.right for one in own), sum(one.wrong for one in own)
        rows.append([label, str(len(own)), part_of(right, len(own)), _share(own, lambda one: one.right_or_equivalent),
                     part_of(wrong, len(own)), _share(own, lambda one: one.verdict == "none"),
                     _share(own, lambda one: one.verdict == "unexplained"),
                     _share(own, lambda one: one.extra and not one.wrong), number(gain_ratio(own))])  # fmt: skip
    return table(head, rows)


def what_it_gains(draws: Sequence[Outcome]) -> str:
    """Return gain over the oracle's and how often laws are worse, as measured and without noise, by what was hidden."""
    head = ("hidden", "draws", "gain / oracle's", "worse than the law", "the oracle worse",
            "without noise: gain / oracle's", "worse than the law", "the oracle worse")  # fmt: skip
    one = of_kind(draws, ONE)
    sets = {f"one effect, {label}": stronger(one, low, high) for label, (low, high) in STRENGTHS.items()}
    sets |= {"one effect": one, "two effects": of_kind(draws, TWO), "outside the catalogue": of_kind(draws, OUTSIDE),
             "nothing": of_kind(draws, CLEAN), "all": list(draws)}  # fmt: skip
    rows = [[label, str(len(own)), number(gain_ratio(own)), _share(own, lambda one: worse(one.gain)),
             _share(own, lambda one: worse(one.oracle_gain)), number(true_gain_ratio(own)),
             proportion(own, lambda one: worse(one.true_gain)),
             _share(own, lambda one: worse(one.oracle_true_gain))] for label, own in sets.items()]  # fmt: skip
    return table(head, rows)


def by_cause(draws: Sequence[Outcome]) -> str:
    """Return one effect by cause: first name right in each bin of the strength, and what is said instead."""
    rows = []
    for cause in sorted({one.causes[0] for one in of_kind(draws, ONE)}):
        own = [one for one in of_kind(draws, ONE) if one.causes[0] == cause]
        cells = []
        for low, high in STRENGTHS.values():
            part = stronger(own, low, high)
            cells.append(f"{sum(one.right for one in part)}/{len(part)}")
        instead = [one.first or one.verdict for one in own if not one.right]
        counts = {name: instead.count(name) for name in sorted(set(instead))}
        said = ", ".join(f"{name} {count}" for name, count in sorted(counts.items(), key=lambda item: -item[1]))
        rows.append([f"`{cause}`", *cells, _share(own, lambda one: one.wrong), number(gain_ratio(own)), said])
    return table(("cause", *STRENGTHS, "wrong name", "gain / oracle's", "said instead"), rows)


def by_bench(draws: Sequence[Outcome]) -> str:
    """Return the main rates of each bench."""
    rows = []
    for bench in dict.fromkeys(one.bench for one in draws):
        own = [one for one in draws if one.bench == bench]
        single, clean, strange = of_kind(own, ONE), of_kind(own, CLEAN), of_kind(own, OUTSIDE)
        rates = [_share(stronger(single, *bounds), lambda one: one.right) for bounds in STRENGTHS.values()]
        rows.append([bench, str(len(own)), *rates, _share(stronger(single, 0.707), lambda one: one.right_or_equivalent),
                     _share(single, lambda one: one.wrong), _share(clean, lambda one: bool(one.names)),
                     _share(strange, lambda one: bool(one.names)),
                     _share(stronger(strange, 0.707), lambda one: one.right),
                     number(gain_ratio(of_kind(own, ONE, TWO))),
                     f"{np.mean([one.seconds for one in own]):.1f}" if own else "-"])  # fmt: skip
    head = ("bench", "draws", *(f"right, {name}" for name in STRENGTHS), "right or equivalent from 0.7", "wrong name",
            "named on clean", "named outside", "`unexplained` outside from 0.7", "gain / oracle's", "s")  # fmt: skip
    return table(head, rows)


def others(draws: Sequence[Outcome]) -> str:
    """Return clean campaigns, effects outside the catalogue and pairs."""
    rows = []
    clean = of_kind(draws, CLEAN)
    rows.append(
        [
            "nothing hidden",
            str(len(clean)),
            "something named",
            proportion(clean, lambda one: bool(one.names)),
        ]
    )
    rows.append(["", "", "`unexplained`", proportion(clean, lambda one: one.verdict == "unexplained")])
    for label, low in (("outside the catalogue", 0.0), ("outside, from 0.7", 0.707)):
        own = stronger(of_kind(draws, OUTSIDE), low)
        rows.append([label, str(len(own)), "something named", proportion(own, lambda one: bool(one.names))])
        rows.append(["", "", "`unexplained`", proportion(own, lambda one: one.right)])
    for label, low in (("two effects", 0.0), ("two, both from 0.7", 0.707)):
        own = stronger(of_kind(draws, TWO), low)
        rows.append([label, str(len(own)), "exact pair", proportion(own, lambda one: one.pair)])
        rows.append(["", "", "first name right", proportion(own, lambda one: one.right)])
        rows.append(["", "", "a wrong name among them", proportion(own, lambda one: one.extra)])
    return table(("hidden", "draws", "said", "rate"), rows)


def outside(draws: Sequence[Outcome]) -> str:
    """Return what is said of each effect outside the catalogue."""
    rows = []
    for cause in sorted({one.causes[0] for one in of_kind(draws, OUTSIDE)}):
        own = [one for one in of_kind(draws, OUTSIDE) if one.causes[0] == cause]
        part = stronger(own, 0.707)
        named = ", ".join(sorted({one.first for one in own if one.first}))
        seen = f"{sum(one.right for one in part)}/{len(part)}"
        rows.append([cause.removeprefix("outside: "), str(len(own)), _share(own, lambda one: one.right), seen,
                     str(sum(bool(one.names) for one in own)), named])  # fmt: skip
    return table(("outside", "draws", "`unexplained`", "from 0.7", "named", "as"), rows)


def calibration(draws: Sequence[Outcome]) -> str:
    """Return stated probability against the rate of being right, of all verdicts and of names."""
    rows = []
    for low, high in pairwise(PROBABILITIES):
        cells = [f"{low:g} to {min(high, 1.0):g}"]
        for own in (list(draws), [one for one in draws if one.names]):
            part = [one for one in own if low <= one.probability < high]
            mean = f"{np.mean([one.probability for one in part]):.3f}" if part else "-"
            cells += [str(len(part)), mean, f"{rate(part, lambda one: one.right):.3f}" if part else "-"]
        rows.append(cells)
    names = [one for one in draws if one.names]
    rows.append(["error", str(len(draws)), "", f"{calibration_error(draws):.3f}", str(len(names)), "",
                 f"{calibration_error(names):.3f}"])  # fmt: skip
    return table(("stated probability", "verdicts", "mean stated", "right", "names", "mean stated", "right"), rows)


def failures(draws: Sequence[Outcome]) -> str:
    """Return draws that went wrong, with what repeats them: errors, wrong names, false alarms, misses from 0.7."""

    def bad(one: Outcome) -> bool:
        missed = one.kind in (ONE, OUTSIDE) and one.strength >= 0.707 and not one.right_or_equivalent
        return bool(one.failed) or one.extra or (one.kind == CLEAN and not one.right) or missed

    return "".join(
        f"- {one.told()}\n" for one in sorted(draws, key=lambda one: (KINDS.index(one.kind), *one.causes)) if bad(one)
    )
