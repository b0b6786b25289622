"""What the command line accepts and what its ``--help`` teaches."""

from __future__ import annotations

from hexathermal.show.commands import found
from hexathermal.show.options import COMPILE_TIME, EXIT_CODES, STYLE
from hexathermal.show.parsing import Parser, complete_parsers

TOP = """\
A Gough-Stewart hexapod drifts when its legs warm up. hexathermal tells which leg lengths to command so that the
platform stands where it should: pose and temperatures in, corrected leg lengths out. It learns the law of a leg from
measurements, tells what is left, and decides whether a machine passes.
"""

TOP_EPILOG = f"""\
first steps:
  hexathermal demo                       a simulated working day: what correction does, with a table and a figure
  hexathermal machines                   the machines that come with the package
  hexathermal show-machine reference     all that is known of one machine
  hexathermal correct --help             correct your own trajectories
  hexathermal simulate bench --help      a virtual test bench; then check, identify, validate, apply
  hexathermal diagnose --help            what the law, or the whole machine, gets wrong and which cause
  hexathermal view                       look at a machine and its drift in three dimensions
  hexathermal budget --help              how far off a warm machine is, why, and what correction leaves
  hexathermal accept --help              does a measured machine meet its specification?
  hexathermal report reference           one page of a machine, a campaign, a budget or a diagnosis
  hexathermal completion --help          let your shell complete all of this
  hexathermal warm-up                    compile everything now ({COMPILE_TIME}), so that later calls are quick

{EXIT_CODES}"""


def parser(version: str) -> Parser:
    """Return the parser of the command line."""
    top = Parser(prog="hexathermal", description=TOP, epilog=TOP_EPILOG, **STYLE)
    top.add_argument("--version", action="version", version=f"hexathermal {version}", help="tell the version")
    commands = top.add_subparsers(dest="command", metavar="COMMAND OPTIONS", title="commands")
    for command in found().values():
        command.add(commands)
    complete_parsers(top)
    return top
