"""``hexathermal machines``: the machines that come with the package."""

from __future__ import annotations

import argparse
from typing import Any

import hexathermal
from hexathermal.show.commands import Answer, Progress
from hexathermal.show.options import EXIT_CODES, STYLE

MACHINES_EPILOG = f"""\
Grades: A identified from measurements, B measured, C drawing or published values.
A machine without a thermal law can be moved but not corrected: 'thermal' says 'not active'.

examples:
  hexathermal machines
  hexathermal machines --json

{EXIT_CODES}"""


def add(commands: Any) -> None:
    """Declare the command."""
    commands.add_parser("machines", help="the bundled machines", description="The bundled machines.",
                        epilog=MACHINES_EPILOG, **STYLE)  # fmt: skip


def run(_arguments: argparse.Namespace, _progress: Progress) -> Answer:
    """List the bundled machines."""
    from hexathermal.show.tables import machine_facts, machine_file, machines_table

    found = {name: hexathermal.load_hexapod(name) for name in hexathermal.bundled_hexapods()}
    sources = [f"{name}: {hexapod.source or 'source not said'}" for name, hexapod in found.items()]
    facts = {name: machine_facts(hexapod, machine_file(name)) for name, hexapod in found.items()}
    return Answer(
        (lambda pretty, _: machines_table(found, pretty), "\n".join(["sources", *sources])), {"machines": facts}
    )
