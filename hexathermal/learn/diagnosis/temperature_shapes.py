"""What temperatures make that no cause does: the product of two, and the highest and the lowest of one so far."""

from __future__ import annotations

from itertools import combinations, product

import numpy as np

from hexathermal.learn.diagnosis.spans import beside, squares
from hexathermal.learn.diagnosis.view import View
from hexathermal.poses import FloatArray

ITS_SQUARE = 0.8
"""Part of a product beside the law, squared, from which on squares of the law's temperatures are it."""

AIRS, LATE_S = ("the air", "the air, late", "the air, very late"), (180.0, 600.0)
"""What stands for the air, and low passes of it [s]: what it warms is late, and knows no gusts."""


def reached(view: View, sensor: str) -> tuple[tuple[str, FloatArray], ...]:
    """Return the highest and the lowest temperature of a sensor so far, in windows, shape (n,) [K].

    So goes what sets where it is warmer, or colder, than ever before, and stays: from the first row of each run on, or
    from that of the campaign where all runs count from one zero.
    """
    found = list[tuple[str, FloatArray]]()
    for extreme, most in (("highest", np.maximum), ("lowest", np.minimum)):
        rows = list[FloatArray]()
        for signals in view.signals:
            warm = signals.dT[sensor]
            first = warm[0] if view.zeroed_by_run or not rows else rows[-1][-1]
            rows.append(most(most.accumulate(warm), first))
        found.append((extreme, view.windows_zeroed(rows)[:, 0]))
    return tuple(found)


def _airs(view: View) -> dict[str, FloatArray]:
    """Return by how much the air is warmer than at the zero, in windows, at once and late; empty if not recorded."""
    if view.airs is None:
        return {}
    late = [np.column_stack([air, *(memory.low_pass(f"air {tau}", signals.time, air, tau) for tau in LATE_S)])
            for signals, memory, air in zip(view.signals, view.rows.memories(), view.airs, strict=True)]  # fmt: skip
    return dict(zip(AIRS, view.windows_zeroed(late).T, strict=True))


def products(view: View) -> list[tuple[tuple[str, str], FloatArray]]:
    """Return products of two warmings in windows, shape (n,) [K^2]: of the law's with others, of all with the air's.

    So goes what one place does only as far as another is warm: a clamp, a clearance, a film of grease. Left out are
    those that squares of the law's own temperatures are for the most part: expansion that is not linear.
    """
    warm = {name: view.temperatures(name) for name in dict.fromkeys((*view.base, *view.sensors))}
    airs = _airs(view)
    pairs = [both for both in combinations(warm, 2) if both[0] in view.base] + list(product(warm, airs))
    warm |= airs
    if not pairs:
        return []
    table = np.column_stack([warm[one] * warm[other] for one, other in pairs])
    law = np.column_stack([np.ones(len(table)), *(warm[name] for name in view.base)])
    own = squares(beside(table, law))
    left = squares(beside(table, np.column_stack([law, *(warm[name] ** 2 for name in view.base)])))
    kept = np.flatnonzero(left > (1.0 - ITS_SQUARE) * own)
    return [(pairs[k], table[:, k]) for k in kept]
