"""``hexathermal warm-up``: compile everything now."""

from __future__ import annotations

import argparse
import time
from typing import Any

from hexathermal.show.commands import Answer, Progress
from hexathermal.show.options import COMPILE_TIME, EXIT_CODES, STYLE

WARM_UP = f"""\
Compiles the equations to machine code and keeps the result on disk, so that no later call waits for the compiler.
Takes {COMPILE_TIME} the first time and a second afterwards.
"""

EPILOG = f"""\
example:
  hexathermal warm-up

{EXIT_CODES}"""


def add(commands: Any) -> None:
    """Declare the command."""
    commands.add_parser("warm-up", help="compile everything now", description=WARM_UP, epilog=EPILOG, **STYLE)


def run(_arguments: argparse.Namespace, progress: Progress) -> Answer:
    """Compile everything."""
    from hexathermal.predict.warm_up import steps

    began = time.perf_counter()
    jobs = list(steps())
    for k, (label, job) in enumerate(jobs):
        progress(k, len(jobs), label)
        job()
    seconds = time.perf_counter() - began
    text = f"{len(jobs)} kinds of calls are compiled and kept on disk ({seconds:.1f} s)"
    return Answer((text,), {"kinds_of_calls": len(jobs), "seconds": seconds})
