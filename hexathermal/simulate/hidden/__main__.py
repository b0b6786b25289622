"""Write campaigns that hide something: ``python -m hexathermal.simulate.hidden OUT --bench NAME`` or ``--machines``."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import numpy as np

from hexathermal.errors import HexathermalError
from hexathermal.simulate.hidden import benches
from hexathermal.simulate.hidden.drawing import draw_campaign
from hexathermal.simulate.hidden.machines.drawing import draw_machine_campaign
from hexathermal.simulate.hidden.machines.writing import write_machine_campaign
from hexathermal.simulate.hidden.writing import write_campaign


def main(words: list[str] | None = None) -> int:
    """Write the campaigns; returns the exit code."""
    parser = argparse.ArgumentParser(prog="python -m hexathermal.simulate.hidden", description=__doc__)
    parser.add_argument("out", type=Path, metavar="OUT", help="folder for the campaigns, which is created")
    of = parser.add_mutually_exclusive_group(required=True)
    of.add_argument("--bench", metavar="NAME", help=f"of a leg or a component: {', '.join(benches.found())}")
    of.add_argument("--machines", action="store_true", help="of whole hexapods, machines and halls drawn")
    parser.add_argument("--count", type=int, default=1, metavar="N", help="how many (default 1)")
    parser.add_argument("--seed", type=int, metavar="S", help="of the first; default: fresh, it stands in the answers")
    parser.add_argument("--cause", action="append", metavar="NAME",
                        help="hide this effect, twice for two, 'none' for none; default: drawn")  # fmt: skip
    parser.add_argument("--strength", type=float, metavar="X",
                        help="visible strength over the noise (of a hexapod: whole); default: drawn")  # fmt: skip
    parser.add_argument("--force", action="store_true", help="replace campaigns that stand there")
    given = parser.parse_args(words)
    if given.count < 1:
        parser.error(f"--count must be 1 or more, found {given.count}")
    causes = None if given.cause is None else tuple(name for name in given.cause if name != "none")
    try:
        generator = np.random.default_rng(given.seed)
        given.out.mkdir(parents=True, exist_ok=True)
        for k in range(given.count):
            folder = given.out / f"{given.bench or 'machine'}-{k + 1:03d}"
            if given.machines:
                machine, told = draw_machine_campaign(generator, causes=causes, strength=given.strength)
                write_machine_campaign(folder, machine, told, force=given.force)
                continue
            truth, answer = draw_campaign(given.bench, generator, causes=causes, strength=given.strength)
            write_campaign(folder, truth, answer, force=given.force)
    except (HexathermalError, OSError, ValueError) as error:
        sys.stderr.write(f"error: {error}\n")
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
