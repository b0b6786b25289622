"""``hexathermal show-machine``: all that is known of one machine."""

from __future__ import annotations

import argparse
from typing import Any

from hexathermal.show.commands import Answer, Progress
from hexathermal.show.options import EXIT_CODES, MACHINE, STYLE, machine

SHOW = "Geometry, limits, thermal law and sensors of one machine."

SHOW_EPILOG = f"""\
examples:
  hexathermal show-machine reference
  hexathermal show-machine my-machine/hexapod.toml --json

{EXIT_CODES}"""


def add(commands: Any) -> None:
    """Declare the command."""
    one = commands.add_parser("show-machine", help="all that is known of one machine", description=SHOW,
                              epilog=SHOW_EPILOG, **STYLE)  # fmt: skip
    one.add_argument("machine", **MACHINE)


def run(arguments: argparse.Namespace, _progress: Progress) -> Answer:
    """Show one machine."""
    from hexathermal.show.tables import machine_facts, machine_file, machine_tables, singular_at_home

    facts = machine_facts(machine(arguments.machine), machine_file(arguments.machine))
    count = len(machine_tables(facts, False))
    shown = tuple(lambda pretty, _, k=k: machine_tables(facts, pretty)[k] for k in range(count))
    warning = singular_at_home(facts)
    return Answer(shown, facts, (warning,) if warning else ())
