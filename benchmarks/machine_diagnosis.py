"""``python -m benchmarks.machine_diagnosis``: hide effects on hexapods, diagnose the folders, write what came of it.

Each draw is a line of the records' file; a run that was stopped goes on where it stood.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from rich.console import Console

from benchmarks import machine_rates as rates
from benchmarks.hidden_machines import MachineOutcome, outcome_of, plan
from benchmarks.recording import judged, opened

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


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the draws that are missing, and write the page."""
    options = _options(arguments)
    console = Console(stderr=True)
    begun = opened(options.records, options.seed, console)
    if begun is None:
        return 1
    seed, lines = begun
    found = {one.seed: one for one in (MachineOutcome(**line) for line in lines)}
    draws = plan(options.draws, seed, options.measure)
    missing = [draw for draw in draws if draw.seed not in found]
    made = judged(outcome_of, missing, MachineOutcome.to_dict, options.processes, options.records, console)
    found |= {one.seed: one for one in made}
    outcomes = [found[draw.seed] for draw in draws]
    text = page(outcomes, seed, options.measure)
    if options.page:
        options.page.write_text(text, encoding="utf-8")
    sys.stdout.write(text)
    return int(any(one.failed for one in outcomes))


if __name__ == "__main__":
    sys.exit(main())
