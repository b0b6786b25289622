"""Faults of one table: what others may follow from stands first."""

from __future__ import annotations

from hexathermal.errors import Problem
from hexathermal.learn.campaign_faults import FIELDS, Faults


def test_rows_of_a_wrong_length_are_told_before_what_may_follow_from_them() -> None:
    """Decimal commas move all columns: their fault comes first though others stand in earlier lines and columns."""
    faults = Faults()
    faults.add("a.csv", Problem(2, 3, "settled is 2000, expected 1 at rest, 0 otherwise"))
    faults.add("b.csv", Problem(2, 1, "time_s does not increase"))
    faults.add("a.csv", Problem(9, 27, "found 50 fields, expected 26; were decimal commas written?"), FIELDS)
    faults.add("a.csv", Problem(2, 1, "time_s runs backwards"))
    assert [(file, problem.line, problem.column) for file, problem in faults.listed()] == [
        ("a.csv", 9, 27), ("a.csv", 2, 1), ("a.csv", 2, 3), ("b.csv", 2, 1),
    ]  # fmt: skip
