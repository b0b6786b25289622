"""Write docs/paper.md: the paper's figures beside those of the virtual bench, from the command line's own answers.

Run from the repository's root: ``python tools/compare_with_paper.py [SEEDS]`` (default 20 campaigns, some minutes).
Each campaign is simulated with all defaults, identified (``auto``, and T07 alone) and validated on runs never fitted.
"""

from __future__ import annotations

import contextlib
import io
import json
import sys
import tempfile
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np

from hexathermal.cli import main

PAGE = Path(__file__).parent.parent / "docs" / "paper.md"

HEAD = """\
# The paper's figures and ours

Robert et al. identified a leg on a test bench; `hexathermal simulate bench` simulates such a bench. Below, {count}
simulated campaigns (seeds 1 to {count}, all defaults: 8 runs to identify, 3 to validate) went through `simulate bench`,
`identify` and `validate`; smallest, mean and largest are shown. Some of the bench's parameters were chosen so that the
paper's figures come out (see [the virtual bench](virtual-bench.md)): agreement shows that physics can produce them, no
more.
This page is written by `python tools/compare_with_paper.py`.

"""

TAIL = """
The paper prints a mean reduction of 85 %; its own numbers, 2.50 µm to 0.28 µm, make it 88.8 %. The two reductions are
of the mean absolute drift and of the largest drift over all validation runs.
"""


def answer(folder: Path, *words: str) -> dict[str, Any]:
    """Run a command and return its answer."""
    file = folder / "answer.json"
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()) as said:
        code = main([*words, "--json", str(file)])
    if code:
        raise SystemExit(f"hexathermal {' '.join(words)} ended with {code}:\n{said.getvalue()}")
    found: dict[str, Any] = json.loads(file.read_text())
    file.unlink()
    return found


def one(seed: int, folder: Path) -> dict[str, Any]:
    """Return the figures of one campaign."""
    campaign, law, alone = (str(folder / f"{name}-{seed}") for name in ("campaign", "auto.toml", "T07.toml"))
    answer(folder, "simulate", "bench", "--out", campaign, "--seed", str(seed))
    chosen = answer(folder, "identify", campaign, "--out", law)
    single = answer(folder, "identify", campaign, "--sensors", "T07", "--out", alone)
    total = answer(folder, "validate", law, campaign)
    scores = total["total"]
    best = {len(entry["sensors"]): entry for entry in chosen["best"]}
    return {
        "chosen": " + ".join(chosen["sensors"]),
        "single": best[1]["sensors"][0],
        "pair": "-".join(best[2]["sensors"]),
        "A": single["coefficients"][0]["value"],
        "B": single["coefficients"][1]["value"],
        "drift": scores["drift_largest_um"],
        "mean_drift": scores["drift_mean_um"],
        "linf": scores["linf_um"]["value"],
        "mean": scores["mean_um"]["value"],
        "mean_reduction": 100.0 * scores["mean_reduction"]["value"],
        "largest_reduction": 100.0 * scores["largest_reduction"]["value"],
        "single_above_pair": best[1]["rmse_um"] - best[2]["rmse_um"],
        "coverage": 100.0 * total["coverage"],
    }


def spread(found: list[dict[str, Any]], key: str, digits: int) -> str:
    """Return smallest, mean and largest."""
    values = np.array([entry[key] for entry in found])
    return " · ".join(f"{value:.{digits}f}" for value in (values.min(), values.mean(), values.max()))


def counted(found: list[dict[str, Any]], key: str) -> str:
    """Return how often each name came."""
    return ", ".join(f"{name} ({count})" for name, count in Counter(entry[key] for entry in found).most_common())


def page(found: list[dict[str, Any]]) -> str:
    """Return the page."""
    rows = [
        ("largest drift", "7.81 µm", spread(found, "drift", 2) + " µm"),
        ("mean drift", "2.50 µm", spread(found, "mean_drift", 2) + " µm"),
        ("largest residual", "1.28 µm", spread(found, "linf", 2) + " µm"),
        ("mean residual", "0.28 µm", spread(found, "mean", 2) + " µm"),
        ("mean reduction", "“85 %”; 88.8 % by its numbers", spread(found, "mean_reduction", 1) + " %"),
        ("reduction of the largest", "“over 80 %”; 83.6 %", spread(found, "largest_reduction", 1) + " %"),
        ("A of T07", "1.99 µm/m/K", spread(found, "A", 2) + " µm/m/K"),
        ("B of T07", "1.09 µm/m/K", spread(found, "B", 2) + " µm/m/K"),
        ("best single sensor", "T07", counted(found, "single")),
        ("its RMSE above the best pair's", "0.08 µm", spread(found, "single_above_pair", 3) + " µm"),
        ("best pairs", "7-15, 8-14, 6-14, 4-14", counted(found, "pair")),
        ("kept", "T07 alone", counted(found, "chosen")),
        ("rows inside their 95 % prediction interval", "not stated", spread(found, "coverage", 1) + " %"),
    ]
    lines = ["| figure | Robert et al. | virtual bench |", "|---|---|---|"]
    lines += [f"| {what} | {theirs} | {ours} |" for what, theirs, ours in rows]
    return HEAD.format(count=len(found)) + "\n".join(lines) + "\n" + TAIL


def run(count: int) -> None:
    """Measure, and write the page."""
    found = []
    for seed in range(1, count + 1):
        with tempfile.TemporaryDirectory() as folder:
            found.append(one(seed, Path(folder)))
        print(seed, found[-1], flush=True)
    PAGE.write_text(page(found), encoding="utf-8")


if __name__ == "__main__":
    run(int(sys.argv[1]) if len(sys.argv) > 1 else 20)
