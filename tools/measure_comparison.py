"""Measure how often `hexathermal.compare` names what differs in a virtual bench: the table of docs/compare.md.

Usage: ``python tools/measure_comparison.py [DRAWS] [SEED]``; about 5 s a draw on one core. ``--limits`` writes
beside it how large a change must be to be named, by the answer to one draw of which nothing was changed.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections import defaultdict
from pathlib import Path

import numpy as np
from sections import write_section

from hexathermal.compare.comparison import Comparison, compare_campaign
from hexathermal.simulate.bench.changed import NUMBERS, SENSOR, Change, drawn_change, write_changed_campaign

CLEAN_SHARE = 0.2


def outcome(found: Comparison, change: Change) -> tuple[str, bool, bool, float]:
    """Return what was said of the change, whether its interval holds it, whether it could be seen, and its gain."""
    right = [one for one in found.differences if (one.name, one.target) == (change.name, change.target)]
    names = [f"{change.name} {change.target}".strip()]
    same = [one for one in found.differences if any(name in names for name, _value in one.equivalent)]
    wrong = len(found.differences) - len(right) - (0 if right else len(same))
    said = "named" if right and not wrong else "equivalent" if same and not wrong else "wrong" if wrong else "none"
    covered = bool(right and right[0].low <= change.value <= right[0].high)
    own = next((one for one in found.parameters if (one.name, one.target) == (change.name, change.target)), None)
    visible = own is not None and not own.limit_low <= change.value <= own.limit_high
    before = sum(one.rmse_before for one in found.scores if one.channel != "drift")
    after = sum(one.rmse_after for one in found.scores if one.channel != "drift")
    return said, covered, visible, 1.0 - after / before


def main(draws: int, seed: int) -> None:
    """Print the table and every draw."""
    table: dict[str, list[tuple[str, bool, bool, float]]] = defaultdict(list)
    for k in range(draws):
        generator = np.random.default_rng([seed, k])
        clean = generator.uniform() < CLEAN_SHARE
        change = drawn_change(generator, ("",) if clean else None)
        with tempfile.TemporaryDirectory() as place:
            folder = Path(place) / "campaign"
            write_changed_campaign(folder, change, int(generator.integers(2**31)))
            found = compare_campaign(folder)
        result = outcome(found, change)
        table[change.name or "nothing"].append(result)
        print(f"# {k} {change.name or 'nothing'} {change.target} {change.value:.3f}: {result[0]}; {found.sentence}")
        sys.stdout.flush()
    print("| changed | draws | visible | named, visible | equivalent | wrong | named, not visible | interval holds |")
    print("|---|---|---|---|---|---|---|---|")
    for name in (*NUMBERS, SENSOR, "nothing"):
        rows = table.get(name, [])
        seen = [row for row in rows if row[2]]
        counts = [len(rows), len(seen), sum(row[0] == "named" for row in seen),
                  sum(row[0] == "equivalent" for row in rows), sum(row[0] == "wrong" for row in rows),
                  sum(row[0] == "named" for row in rows if not row[2])]  # fmt: skip
        named = [row for row in rows if row[0] == "named"]
        print(f"| {name} | {' | '.join(map(str, counts))} | {sum(row[1] for row in named)} of {len(named)} |")


def limits(seed: int) -> str:
    """Return a table of the smallest factors that an unchanged bench's answer states."""
    generator = np.random.default_rng([seed, 0])
    change = drawn_change(generator, ("",))
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place) / "campaign"
        write_changed_campaign(folder, change, int(generator.integers(2**31)))
        found = compare_campaign(folder)
    classes: dict[str, list[str]] = defaultdict(list)
    for one in (one for one in found.parameters if one.name in NUMBERS):
        size = float(np.sqrt(one.limit_high / one.limit_low)) if one.limit_low > 0.0 else np.inf
        within = next((top for top in (1.15, 1.3, 1.5, 2.0, 4.0) if size <= top), None)
        classes["not shown up to a factor of 4" if within is None else f"{within:g}"].append(f"`{one.name}`")
    rows = [f"| {size} | {', '.join(classes[size])} |" for size in sorted(classes)]
    return "\n".join(["| named from a factor of, at most | numbers |", "|---|---|", *rows])


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n\n")[0])
    parser.add_argument("draws", nargs="?", type=int, default=100, metavar="DRAWS")
    parser.add_argument("seed", nargs="?", type=int, default=1, metavar="SEED")
    parser.add_argument("--limits", action="store_true", help="write what must change to be named, and no draws")
    asked = parser.parse_args()
    if asked.limits:
        write_section("compare.md", "limits", "measure_comparison", limits(asked.seed))
    else:
        main(asked.draws, asked.seed)
