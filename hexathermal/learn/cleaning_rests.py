"""Rows of a part with a stroke whose log does not say when it rests: they are those whose place does not change."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from hexathermal.learn.cleaning_channels import PIECE_ROWS, SMALLEST_MOVE_M, studied
from hexathermal.learn.cleaning_rules import Flags, filled
from hexathermal.learn.cleaning_sheets import Sheet, with_margins
from hexathermal.poses import FloatArray

LEAST_AT_REST = 1.0 / 3.0
"""Share of a run's first rows that must be at rest; of a part that rests less all rows are used."""

QUIETEST, NOISES = 0.1, 30.0
"""Of steps from row to row the quantile that is noise of the scale, were it but a third of the rows that rest; and how
many times that a step must be to be a move: five standard deviations of such noise where all rows rest."""

MOVES = (
    f"no column settled, and q_mm differs from both rows beside by more than {SMALLEST_MOVE_M * 1e6:g} um and its "
    "noise: it moves"
)


def with_rests(sheets: Iterator[Sheet]) -> Iterator[Sheet]:
    """Give rows on, with `Sheet.settled` told by the displacement where the table has no such column.

    What is measured while a part moves is late, and has another noise: of simulated ball screws and stages whose rows
    were used all alike, the residual in motion was two to six times that at rest.
    """
    study, sheets = studied(sheets)
    untold = study and not study[0].settled.shape[1] and study[0].q.shape[1]
    least = least_move(study[0].q) if untold else 0.0
    if not untold or moving(study[0].q, least).mean() > 1.0 - LEAST_AT_REST:
        yield from sheets
        return
    study.clear()
    for whole, own in with_margins(sheets, PIECE_ROWS, 1):
        rests = ~moving(whole.q, least)
        yield whole.changed(settled=rests[:, None].astype(np.float64)).take(own)


def least_move(q: FloatArray) -> float:
    """Return the least step that is a move [m]: of a scale that is noisy at rest more than `SMALLEST_MOVE_M`.

    Parameters
    ----------
    q : array, shape (n, 1) [m]

    Examples
    --------
    >>> rng = np.random.default_rng(1)
    >>> at_rest = 5e-6 * rng.standard_normal((600, 1))
    >>> 1.5e-5 < least_move(at_rest) < 6e-5, least_move(np.round(at_rest, 3))
    (True, 2e-06)
    """
    steps = np.abs(np.diff(filled(q)[:, 0]))
    return max(SMALLEST_MOVE_M, NOISES * float(np.quantile(steps, QUIETEST))) if len(steps) else SMALLEST_MOVE_M


def moving(q: FloatArray, least: float) -> Flags:
    """Return in which rows a part moves: its place differs from that in both rows beside, shape (n,).

    It rested before the first row, and goes on behind the last one.

    Examples
    --------
    >>> moving(np.array([[0.0], [0.01], [0.02], [0.02], [0.02], [0.03]]), 1e-3).tolist()
    [False, True, False, False, False, True]
    """
    step = np.abs(np.diff(filled(q)[:, 0])) > least
    return np.asarray(np.concatenate([[False], step]) & np.concatenate([step, [True]]))
