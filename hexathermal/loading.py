"""A program that is stopped while its modules load ends in one line, with the code of an interrupt.

The package imports this module before all else: numerical libraries take a moment, and none of them can be stopped
without a traceback. Where hexathermal is imported by another program, nothing is changed.
"""

from __future__ import annotations

import os
import signal
import sys
from itertools import pairwise
from pathlib import Path
from typing import Any, NoReturn

INTERRUPTED = 130
WORDS = "interrupted; nothing half-written is left"

_BEFORE: dict[signal.Signals, Any] = {}
"""What was done with a signal before."""


def own_program() -> bool:
    """Whether this process is the command line: the script ``hexathermal``, or ``python -m hexathermal``."""
    first = sys.argv[0] if sys.argv and sys.argv[0] else ""
    if first == "-m":  # so it reads while the package of a module to be run is imported
        return ("-m", "hexathermal") in pairwise(sys.orig_argv) or "-mhexathermal" in sys.orig_argv
    return Path(first).name.removesuffix(".exe").removesuffix("-script.py") == "hexathermal"


def watch() -> None:
    """End this process quietly where it is interrupted or terminated from now on; signals that are ignored stay so."""
    for name in ("SIGINT", "SIGTERM", "SIGHUP"):
        number = getattr(signal, name, None)
        if number is not None and signal.getsignal(number) in (signal.default_int_handler, signal.SIG_DFL):
            _BEFORE[number] = signal.signal(number, _end)


def release() -> None:
    """Give the signals back: all is loaded."""
    while _BEFORE:
        signal.signal(*_BEFORE.popitem())


def _end(_number: int, _frame: object) -> NoReturn:
    """End at once: an exception could be swallowed by what is being loaded, and nothing was begun."""
    os.write(2, f"{WORDS}\n".encode())
    os._exit(INTERRUPTED)


if own_program():
    watch()
