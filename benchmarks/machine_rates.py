"""Rates of a set of draws on whole hexapods: by cause and strength; gain over the oracle's; coverage of intervals."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from benchmarks.hidden_effects import CLEAN, ONE, OUTSIDE, TWO
from benchmarks.hidden_machines import BARS, CAUSES, LEG, NORMAL_95, STRENGTHS, UNFRAMED, MachineOutcome
from benchmarks.hidden_rates import part_of, proportion, table

GAIN = 0.02
"""Part of the RMSE on validation runs below which there is nothing to gain."""

VISIBLE = ((0.0, 0.075), (0.075, 0.15), (0.15, 0.3), (0.3, np.inf))
"""Bins of the visible strength."""

Draws = Sequence[MachineOutcome]


def of_kind(draws: Iterable[MachineOutcome], *kinds: str) -> list[MachineOutcome]:
    """Return the draws of some kinds."""
    return [one for one in draws if one.kind in kinds]


def gain_ratio(draws: Draws, end: str = "") -> float:
    """Return the sum of gains over the sum of the oracle's, over translations and rotations with something to gain.

    `end` is ``""``, or `UNFRAMED`: each run may have a frame of its own.
    """
    kinds = [kind + end for kind in ("translation", "rotation")]
    pairs = [(one.gain.get(kind) or 0.0, one.oracle_gain.get(kind) or 0.0) for one in draws for kind in kinds]
    pairs = [pair for pair in pairs if pair[1] > GAIN]
    return sum(pair[0] for pair in pairs) / sum(pair[1] for pair in pairs) if pairs else float("nan")


def _ratios(draws: Draws) -> str:
    """Return both gain ratios."""
    both = (gain_ratio(draws), gain_ratio(draws, UNFRAMED))
    return ", ".join("-" if np.isnan(ratio) else f"{ratio:.2f}" for ratio in both)


def coverage(draws: Draws) -> tuple[int, int]:
    """Return how many parameters lie within their stated 95 % intervals, of how many."""
    pulls = [abs(pull) for one in draws for pull in one.pulls.values()]
    return sum(pull < NORMAL_95 for pull in pulls), len(pulls)


HEAD = ("draws", "cause right", "or equivalent", "place right of these", "or equivalent", "wrong name", "`none`",
        "`unexplained`", "gain / oracle's, unframed", "parameters within 95 %", "s, most")  # fmt: skip


def cells(own: Draws) -> list[str]:
    """Return what is told of any set of draws with effects in them."""
    right = [one for one in own if one.right and one.names]
    return [
        str(len(own)), proportion(own, lambda one: one.right), proportion(own, lambda one: one.right_or_equivalent),
        proportion(right, lambda one: one.place_right), proportion(right, lambda one: one.place_right_or_equivalent),
        proportion(own, lambda one: one.wrong),
        proportion(own, lambda one: one.verdict == "none"), proportion(own, lambda one: one.verdict == "unexplained"),
        _ratios(own), part_of(*coverage(own)),
        f"{max((one.seconds for one in own), default=0.0):.1f}",
    ]  # fmt: skip


def by_strength(draws: Draws) -> str:
    """Return single effects by strength, as wanted, with the rate that is wanted there."""
    single = of_kind(draws, ONE)
    rows = [[f"{size:g}", f"{bar:.2f}", *cells([one for one in single if one.strength == size])]
            for size, bar in zip(STRENGTHS, BARS, strict=True)]  # fmt: skip
    return table(("strength", "wanted", *HEAD), [*rows, ["all", "", *cells(single)]])


def by_visible(draws: Draws) -> str:
    """Return single effects by the strength that is left where each run may have a frame of its own."""
    single = of_kind(draws, ONE)
    rows = [[f"{low:g} to {high:g}", *cells([one for one in single if low <= one.visible[0] < high])]
            for low, high in VISIBLE]  # fmt: skip
    return table(("visible strength", *HEAD), rows)


def by_cause(draws: Draws) -> str:
    """Return single effects by cause: right at each strength, and what is said instead."""
    rows = []
    for cause in CAUSES:
        own = [one for one in of_kind(draws, ONE) if one.causes == [cause]]
        if not own:
            continue
        parts = [[one for one in own if one.strength == size] for size in STRENGTHS]
        instead = [one.names[0] if one.names else one.verdict for one in own if not one.right]
        said = ", ".join(f"{name} {instead.count(name)}" for name in sorted(set(instead)))
        inside, number = coverage(own)
        rows.append([
            f"`{cause}`", *(f"{sum(one.right for one in part)}/{len(part)}" for part in parts),
            f"{sum(one.right_or_equivalent for one in own)}/{len(own)}",
            f"{sum(one.place_right for one in own)}/{sum(one.right for one in own)}", f"{inside}/{number}",
            _ratios(own), said,
        ])  # fmt: skip
    head = ("cause", *(f"right at {size:g}" for size in STRENGTHS), "right or equivalent", "place right",
            "parameters within 95 %", "gain / oracle's, unframed", "said instead")  # fmt: skip
    return table(head, rows)


def by_machine(draws: Draws) -> str:
    """Return single effects, and alarms on clean campaigns, by machine and by hall."""
    rows = []
    for what in ("machine", "hall"):
        for name in sorted({getattr(one, what) for one in draws}):
            own = [one for one in draws if getattr(one, what) == name]
            single, clean = of_kind(own, ONE), of_kind(own, CLEAN)
            rows.append([name, str(len(single)), proportion(single, lambda one: one.right),
                         proportion(single, lambda one: one.right_or_equivalent),
                         proportion(single, lambda one: one.wrong),
                         f"{sum(bool(one.names) for one in clean)}/{len(clean)}"])  # fmt: skip
    return table(("", "draws", "cause right", "or equivalent", "wrong name", "named on clean"), rows)


def others(draws: Draws) -> str:
    """Return what is said of clean campaigns, pairs, causes of a leg, and of what is outside the catalogues."""
    clean, foreign, pairs, legs = (of_kind(draws, kind) for kind in (CLEAN, OUTSIDE, TWO, LEG))
    rows = [
        ["nothing", str(len(clean)), "something named", proportion(clean, lambda one: bool(one.names))],
        [
            "outside the catalogues",
            str(len(foreign)),
            "something named",
            proportion(foreign, lambda one: bool(one.names)),
        ],
        ["", "", "`unexplained`", proportion(foreign, lambda one: one.verdict == "unexplained")],
        ["two effects", str(len(pairs)), "first name right", proportion(pairs, lambda one: one.right)],
        ["", "", "both", proportion(pairs, lambda one: sorted(one.names) == sorted(one.causes))],
        ["", "", "a name that is not hidden", proportion(pairs, lambda one: bool(set(one.names) - set(one.causes)))],
        ["a leg's cause", str(len(legs)), "first name right", proportion(legs, lambda one: one.right)],
    ]
    return table(("hidden", "draws", "said", "rate"), rows)


def failures(draws: Draws) -> str:
    """Return draws that went wrong, with what repeats them: errors, wrong names and places, alarms, misses."""

    def bad(one: MachineOutcome) -> bool:
        named = bool(one.names)
        alarm = named and (one.kind in (CLEAN, OUTSIDE) or bool(set(one.names) - set(one.causes)))
        missed = one.kind == ONE and not one.right and one.visible[0] >= STRENGTHS[0]
        return bool(one.failed) or alarm or missed or (one.kind == ONE and one.right and not one.place_right)

    return "".join(f"- {one.told()}\n" for one in sorted(draws, key=lambda one: (one.kind, *one.causes)) if bad(one))
