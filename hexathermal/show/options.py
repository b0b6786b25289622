"""What several commands of the command line share: kinds of options, exit codes, the look of ``--help``."""

from __future__ import annotations

import argparse
import math
import os
import re
from pathlib import Path
from typing import Any

from hexathermal.errors import ArgumentError
from hexathermal.machine.hexapod import Hexapod
from hexathermal.machine.library import bundled_hexapods, load_hexapod

COMPILE_TIME = "up to a minute"
"""How long compiling takes where nothing is kept on disk yet; measured: 15 to 35 s."""

EXIT_CODES = """\
exit codes:
  0    done
  1    could not be finished: disk full, file cannot be read, or an error inside hexathermal
  2    wrong usage: unknown option, command or machine, no such file, result file exists already or is no plain file,
       or a machine without a thermal law is to be corrected
  3    bad input: a row, a header or a machine file breaks its format, or a temperature is out of range; also a command
       that is not known and near to none, or to 'accept': its 2 is a verdict
  4    cannot be reached: out of stroke, of a joint's cone or of the maker's travel, singular
  130  interrupted (Ctrl-C, SIGTERM, SIGHUP); nothing half-written is left
Errors are one message on stderr. HEXATHERMAL_TRACEBACK=1 in the environment shows where they come from.
"""


def number(text: str) -> float:
    """Return a finite number."""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise argparse.ArgumentTypeError(f"{text!r} is not a finite number")
    return value


def seed(text: str) -> int:
    """Return a whole number that can start a generator."""
    if not re.fullmatch(r"\d{1,18}", text, re.ASCII):
        raise argparse.ArgumentTypeError(f"{text!r} is not a whole number from 0 on (18 digits at most)")
    return int(text)


def path(text: str) -> Path:
    """Return a path that is not empty."""
    if not text:
        raise argparse.ArgumentTypeError("the name of the file is empty")
    return Path(text)


def formatter(prog: str) -> argparse.HelpFormatter:
    """Return a formatter that keeps texts as they are and sets options and their help side by side."""
    return argparse.RawDescriptionHelpFormatter(prog, max_help_position=30)


STYLE: dict[str, Any] = {"formatter_class": formatter, "allow_abbrev": False}
"""What every parser of a command takes."""

MACHINE: dict[str, Any] = {
    "metavar": "NAME",
    "help": "a bundled machine, or the path of a hexapod.toml or of its folder",
}
"""What every option for a machine takes."""


def machine(name: str) -> Hexapod:
    """Return a machine by name or path; a path that is no plain file is refused before it is opened."""
    file = Path(name) / "hexapod.toml" if os.path.isdir(name) else Path(name)
    if name not in bundled_hexapods() and os.path.exists(file) and not os.path.isfile(file):
        raise ArgumentError(f"{file} is no plain file (a device, pipe or folder); give a hexapod.toml or its folder")
    return load_hexapod(name)
