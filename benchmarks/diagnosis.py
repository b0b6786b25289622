"""``python -m benchmarks.diagnosis``: hide effects, diagnose the folders, write what came of it into a page.

Each draw is a line of the records' file; a run that was stopped goes on where it stood. ``--ablation`` diagnoses the
first draws again with each ingredient of the method off in turn.
"""

from __future__ import annotations

import argparse
import platform
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from rich.console import Console

from benchmarks import hidden_rates as rates
from benchmarks.ablation import SWITCHES, without
from benchmarks.hidden_effects import (
    AXES,
    BENCHES,
    CLEAN,
    HELD_OUT,
    LATER,
    ONE,
    OUTSIDE,
    PARTS,
    Outcome,
    outcome_of,
    plan,
)
from benchmarks.hidden_timing import Timed, timed
from benchmarks.recording import judged, opened

WHOLE = next(iter(SWITCHES))
Job = tuple[str, str, int]
"""What is taken off, the bench, the seed."""


def _options(arguments: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.diagnosis", description=__doc__)
    parser.add_argument("--draws", type=int, default=500, metavar="N", help="how many (default 500)")
    parser.add_argument("--seed", type=int, metavar="S", help="of the draws; default: fresh, or the records' own")
    parser.add_argument("--bench", action="append", choices=(*BENCHES, HELD_OUT, LATER, PARTS, AXES), metavar="NAME",
                        help=f"one, again for more (default all but {HELD_OUT}, {LATER}, {PARTS}, {AXES})")  # fmt: skip
    parser.add_argument("--ablation", type=int, default=0, metavar="N", help="draws for each ingredient (default none)")
    parser.add_argument("--processes", type=int, default=2, metavar="N", help="(default 2)")
    parser.add_argument("--records", type=Path, default=Path("build/diagnosis.jsonl"), metavar="FILE",
                        help="one line a draw (default build/diagnosis.jsonl)")  # fmt: skip
    parser.add_argument("--page", type=Path, metavar="FILE", help="write the tables, as docs/diagnosis-figures.md")
    parser.add_argument("--no-timing", action="store_true", help="leave the seconds a campaign out")
    return parser.parse_args(arguments)


def _judged(job: Job) -> tuple[str, Outcome]:
    """Return the outcome of a draw with an ingredient taken off."""
    name, bench, seed = job
    with without(name):
        return name, outcome_of(bench, seed)


def _job(found: tuple[str, Outcome]) -> tuple[Job, Outcome]:
    """Return an outcome with the job that it is of."""
    name, outcome = found
    return (name, outcome.bench, outcome.seed), outcome


def _line(found: tuple[str, Outcome]) -> dict[str, Any]:
    """Return an outcome as a line of the records."""
    return {"without": found[0], "outcome": found[1].to_dict()}


def ablated(found: dict[Job, Outcome], count: int, draws: Sequence[tuple[str, int]]) -> str:
    """Return the table of ingredients: what the first draws come to without each."""
    rows = []
    for name in SWITCHES:
        own = [found[(name, *draw)] for draw in draws[:count] if (name, *draw) in found]
        single, plain = rates.of_kind(own, ONE), rates.stronger(rates.of_kind(own, ONE), 0.707)
        clean, strange = rates.of_kind(own, CLEAN), rates.of_kind(own, OUTSIDE)
        cells = [rates.proportion(single, lambda one: one.right_or_equivalent),
                 rates.proportion(plain, lambda one: one.right_or_equivalent),
                 rates.proportion(single, lambda one: one.wrong), rates.proportion(clean, lambda one: bool(one.names)),
                 rates.proportion(strange, lambda one: bool(one.names)),
                 rates.proportion(strange, lambda one: one.right), rates.number(rates.gain_ratio(own)),
                 rates.number(rates.calibration_error(own))]  # fmt: skip
        rows.append([name, str(len(own)), *cells])
    head = ("", "draws", "right or equivalent", "the same from 0.7", "wrong name", "named on clean", "named outside",
            "`unexplained` outside", "gain / oracle's", "calibration error")  # fmt: skip
    return rates.table(head, rows)


ABOUT = """\
# The diagnosis on {what}, measured

{count} draws of `hexathermal.simulate.hidden`, seed {seed}, bench: {benches}.
Causes, strengths (log-uniform 0.25 to 2), noise, bias of the sensors and the number of effects are drawn. Each campaign
is a folder, diagnosed from its files with the sensors of the base law; the answer is read afterwards. The generator
shares no code with the diagnosis; [what was seen](diagnosis-figures-seen.md) of its draws before these is kept book of.
[How it is done](diagnosis.md). Repeat:

```text
python -m benchmarks.diagnosis --draws {count} --seed {seed} {options}--page docs/{name}
```

- *Strength*: RMS of what stays visible of the effect after the law is fitted again, over the RMS of the noise, which is
  what the law leaves with nothing hidden: noise of the displacement, and what errors of the law's thermometers feign.
- *Right*: the first name is hidden. *Equivalent*: it is among the names that the diagnosis states as equivalent.
  *Wrong*: neither.
- *Gain*: part of the RMSE on validation runs that the extension takes away. The oracle knows the effect's shape and
  fits its size; sums over draws in which it gains {gain:.0%} or more.
- *Worse*: the RMSE on validation runs rises, by whatever. Runs as measured are few, and their noise is larger
  than most of the effects: the oracle's rises often, too. *Without noise*: the same laws, on the same runs for
  validation with the drift as it is, before the noise of its measurement is added: what a law is meant to foretell.
- Intervals hold 90 %.
"""


BESIDE_ZEROS = """\
## By what shows within runs

A displacement counts from a run's first reading, noise and all: a constant of each run tells little. Here the strength
is what stays visible where such constants are fitted again too: of an effect that changes over hours about half, of one
that comes and goes within a run all.
"""


PAGES = {
    HELD_OUT: ("hidden effects", "diagnosis-figures.md"),
    LATER: ("a bench that came later", "diagnosis-figures-later.md"),
    PARTS: ("parts with a stroke", "diagnosis-figures-parts.md"),
    AXES: ("axes that are measured where they stand", "diagnosis-figures-axes.md"),
    "": ("the other benches", "diagnosis-figures-benches.md"),
}
"""What a page is called, and its name in `docs`: of the benches that no figure was chosen by, and of the others."""


def page(outcomes: Sequence[Outcome], seed: int, ablation: str, times: Sequence[Timed], each: int = 0) -> str:
    """Return the page of figures; with a table of the ablation, of `each` draws a row."""
    drawn = list(dict.fromkeys(one.bench for one in outcomes))
    options = "" if set(drawn) == set(BENCHES) else "".join(f"--bench {name} " for name in drawn)
    options += f"--ablation {each} " if each else ""
    what, name = PAGES[next((bench for bench in PAGES if bench in drawn), "")]
    about = ABOUT.format(what=what, name=name, count=len(outcomes), seed=seed, gain=rates.GAIN,
                         benches=", ".join(drawn), options=options)  # fmt: skip
    parts = [about]
    parts += ["## One effect, by strength\n", rates.by_strength(outcomes)]
    parts += [BESIDE_ZEROS, rates.by_strength_beside_zeros(outcomes)]
    parts += ["## What the extension gains\n", rates.what_it_gains(outcomes)]
    parts += ["## One effect, by cause\n\nFirst name right / draws at each strength.\n", rates.by_cause(outcomes)]
    parts += ["## By bench\n", rates.by_bench(outcomes)]
    parts += ["## Nothing, strangers, two effects\n", rates.others(outcomes), rates.outside(outcomes)]
    parts += ["## What a probability means\n", rates.calibration(outcomes)]
    if ablation:
        parts += ["## Each ingredient off in turn\n\nThe same draws for every row.\n", ablation]
    if times:
        rows = [
            [one.label, str(one.rows), f"{one.seconds:.1f}", f"{1e6 * one.seconds / one.rows:.0f}"] for one in times
        ]
        parts += [f"## Seconds\n\nProcessor time of one core ({platform.machine()}), reading the files included.\n"]
        parts += [rates.table(("campaign", "rows", "s", "µs a row"), rows)]
    parts += ["## Draws that went wrong\n\nWrong or superfluous names, alarms on clean data, misses from 0.7 on; "
              "`campaign_of(bench, seed, shared=True)` of `hexathermal.simulate.hidden.drawing` "
              "repeats one.\n"]  # fmt: skip
    return "\n".join([*parts, rates.failures(outcomes)])


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the draws that are missing, and write the page."""
    options = _options(arguments)
    console = Console(stderr=True)
    begun = opened(options.records, options.seed, console)
    if begun is None:
        return 1
    seed, lines = begun
    found = dict(map(_job, ((str(line["without"]), Outcome(**line["outcome"])) for line in lines)))
    draws = plan(options.draws, seed, options.bench or BENCHES)
    jobs: list[Job] = [(WHOLE, *draw) for draw in draws]
    jobs += [(name, *draw) for draw in draws[: options.ablation] for name in SWITCHES if name != WHOLE]
    missing = [job for job in jobs if job not in found]
    found |= dict(map(_job, judged(_judged, missing, _line, options.processes, options.records, console)))
    outcomes = [found[(WHOLE, *draw)] for draw in draws]
    table = ablated(found, options.ablation, draws) if options.ablation else ""
    text = page(outcomes, seed, table, () if options.no_timing else timed(), options.ablation)
    if options.page:
        options.page.write_text(text, encoding="utf-8")
    sys.stdout.write(text)
    return int(any(one.failed for one in outcomes))


if __name__ == "__main__":
    sys.exit(main())
