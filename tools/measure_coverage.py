"""Measure how often 95 % intervals hold the truth, and write the table into docs/identification.md.

Run from the repository's root: ``python tools/measure_coverage.py [SEEDS]`` (default 200, some minutes).  Campaigns of
8 runs of 3 h are drawn by the tests' generator, which shares nothing with the package; T07's law is identified, and
three fresh runs are validated.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parent.parent))

from sections import write_section

from hexathermal.learn.identification import identify
from hexathermal.learn.validation import validate
from tests.learn.legs import LEG, SENSORS, TRUE_A, TRUE_B, drawn_leg

KINDS: dict[str, dict[str, float]] = {
    "noise 30 mK, bias 0.05 K, landings 0.15 µm": {},
    "noise 6 mK, bias 0.05 K, landings 0.1 µm": {"noise": 0.006, "landing": 0.1e-6},
    "noise 70 mK, bias 0.05 K, landings 0.3 µm": {"noise": 0.07, "landing": 0.3e-6},
}


def one(seed: int, drawn: dict[str, float]) -> tuple[bool, bool, float]:
    """Return whether A and B lie in their intervals, and the part of fresh rows inside theirs."""
    rng = np.random.default_rng(seed)
    rows = drawn_leg(rng, **drawn)  # type: ignore[arg-type]
    found = identify(lambda: iter(rows), SENSORS, LEG, wanted=("T07",))
    fresh = drawn_leg(rng, runs=3, role="validation", **drawn)  # type: ignore[arg-type]
    off = np.abs(found.fit.coefficients - [TRUE_A, TRUE_B]) / np.sqrt(np.diagonal(found.fit.covariance))
    return bool(off[0] <= 1.96), bool(off[1] <= 1.96), validate(found.law, fresh, SENSORS).coverage


def table(count: int) -> str:
    """Return the measured table."""
    lines = [f"| drawn campaigns, {count} of each | A | B | fresh rows |", "|---|---|---|---|"]
    for k, (name, drawn) in enumerate(KINDS.items()):
        found = np.array([one(10_000 * k + seed, drawn) for seed in range(count)])
        A, B, rows = (100.0 * found[:, j].mean() for j in range(3))
        lines.append(f"| {name} | {A:.1f} % | {B:.1f} % | {rows:.1f} % |")
        print(lines[-1], flush=True)
    lines.append(f"\nA binomial standard deviation is {100.0 * (0.05 * 0.95 / count) ** 0.5:.1f} %.\n")
    return "\n".join(lines)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n\n")[0])
    parser.add_argument("seeds", nargs="?", type=int, default=200, metavar="SEEDS", help="of each kind (default: 200)")
    write_section("identification.md", "coverage", "measure_coverage", table(parser.parse_args().seeds))
