"""``python -m benchmarks.machine_diagnosis``: hide effects on hexapods, diagnose the folders, write what came of it.

Each draw is a line of the records' file; a run that was stopped goes on where it stood.
"""

from __future__ import annotations

import argparse
import json
import os
import secrets
import sys
from collections.abc import Iterator, Sequence
from multiprocessing import get_context
from pathlib import Path

from rich.console import Console
from rich.progress import track

from benchmarks import machine_rates as rates
from benchmarks.hidden_machines import MachineDraw, MachineOutcome, outcome_of, plan

ABOUT = """\
# The diagnosis of a machine on hidden effects, measured

{count} draws of `hexathermal.simulate.hidden.machines`, seed {seed}: 6 runs of 150 poses, of which 2 are never fitted;
machines, halls, ranges of poses, thermometers, noise (0.4 µm and 1 µrad in most), frames and their creep are drawn. The
generator shares no code with the diagnosis. Each campaign is a folder, diagnosed from its files; the answer is read
afterwards. Repeat:

```text
python -m benchmarks.machine_diagnosis --draws {count} --seed {seed} --measure {measure}
```

- *Strength*: RMS of the effect over that of the white noise, six coordinates, runs for identification ({measure}).
  *Visible*: the same where each run may have a frame of its own.
- *Right*: the first name is hidden. *Equivalent*: it is among the names stated as equivalent. *Wrong*: neither.
  *Place*: leg, plate, pair of legs or joint.
- *Gain*: part of the RMSE on validation runs that the extended machine takes away, translation and rotation. The oracle
  is the true machine; sums over draws in which it gains {gain:.0%} or more. *Unframed*: each run may have a frame of
  its own, before and after.
- Rates are given with their 90 % intervals.
"""


def page(outcomes: Sequence[MachineOutcome], seed: int, measure: str) -> str:
    """Return the page of figures."""
    parts = [ABOUT.format(count=len(outcomes), seed=seed, measure=measure, gain=rates.GAIN)]
    parts += ["## One effect, by strength\n", rates.by_strength(outcomes)]
    parts += ["## One effect, by what is visible of it\n", rates.by_visible(outcomes)]
    parts += ["## One effect, by cause\n", rates.by_cause(outcomes)]
    parts += ["## By machine and hall\n", rates.by_machine(outcomes)]
    parts += ["## Nothing, strangers, two effects\n", rates.others(outcomes)]
    parts += ["## Draws that went wrong\n\nErrors, alarms, names and places that are not hidden, misses; "
              "`machine_campaign_of(seed, causes=..., strength=...)` repeats one.\n"]  # fmt: skip
    return "\n".join([*parts, rates.failures(outcomes)])


def _options(arguments: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.machine_diagnosis", description=__doc__)
    parser.add_argument("--draws", type=int, default=240, metavar="N", help="how many (default 240)")
    parser.add_argument("--seed", type=int, metavar="S", help="of the draws; default: fresh, or the records' own")
    parser.add_argument("--measure", choices=("whole", "visible"), default="whole", help="what strength is meant")
    parser.add_argument("--processes", type=int, default=1, metavar="N", help="(default 1)")
    parser.add_argument("--records", type=Path, default=Path("build/machine-diagnosis.jsonl"), metavar="FILE",
                        help="one line a draw (default build/machine-diagnosis.jsonl)")  # fmt: skip
    parser.add_argument("--page", type=Path, metavar="FILE", help="write the tables")
    return parser.parse_args(arguments)


def recorded(file: Path) -> tuple[int | None, dict[int, MachineOutcome]]:
    """Return the seed and, by their seeds, the outcomes of a records' file; a line that was cut off is left out."""
    seed, found = None, {}
    for line in file.read_text(encoding="utf-8").splitlines() if file.exists() else ():
        try:
            data = json.loads(line)
        except ValueError:
            continue
        if "seed_of_all" in data:
            seed = int(data["seed_of_all"])
            continue
        outcome = MachineOutcome(**data)
        found[outcome.seed] = outcome
    return seed, found


def _run(draws: Sequence[MachineDraw], processes: int, file: Path, console: Console) -> Iterator[MachineOutcome]:
    """Diagnose draws that are not recorded yet, writing each as it comes."""
    os.environ["OMP_NUM_THREADS"] = "1"
    with get_context("spawn").Pool(processes) as pool, file.open("a", encoding="utf-8") as log:
        for outcome in track(pool.imap_unordered(outcome_of, draws), "draws", len(draws), console=console):
            log.write(json.dumps(outcome.to_dict()) + "\n")
            log.flush()
            yield outcome


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the draws that are missing, and write the page."""
    options = _options(arguments)
    console = Console(stderr=True)
    options.records.parent.mkdir(parents=True, exist_ok=True)
    known, found = recorded(options.records)
    seed = next(one for one in (options.seed, known, secrets.randbits(32)) if one is not None)
    if known is not None and seed != known:
        console.print(f"{options.records} holds draws of seed {known}: name another file, or take it away")
        return 1
    if known is None:
        options.records.write_text(json.dumps({"seed_of_all": seed}) + "\n", encoding="utf-8")
    draws = plan(options.draws, seed, options.measure)
    missing = [draw for draw in draws if draw.seed not in found]
    found |= {one.seed: one for one in _run(missing, options.processes, options.records, console)}
    outcomes = [found[draw.seed] for draw in draws]
    text = page(outcomes, seed, options.measure)
    if options.page:
        options.page.write_text(text, encoding="utf-8")
    sys.stdout.write(text)
    return int(any(one.failed for one in outcomes))


if __name__ == "__main__":
    sys.exit(main())
