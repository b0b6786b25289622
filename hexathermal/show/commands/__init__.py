"""Commands of the command line, one module each: what they accept, what they do, what they answer with.

A command's module holds ``add(commands)``, which declares it and what its ``--help`` teaches, and
``run(arguments, progress)``, which does the work and returns an `Answer`. Only `hexathermal.cli` prints.
"""

from __future__ import annotations

import argparse
import errno
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from difflib import get_close_matches
from importlib import import_module
from pathlib import Path
from pkgutil import iter_modules
from typing import Any, Protocol

import hexathermal

FULL = tuple(getattr(errno, name) for name in ("ENOSPC", "EDQUOT") if hasattr(errno, name))
"""What a system says where a disk, or a share of it, is full."""

Progress = Callable[[int, int, str], None]
"""``progress(done, total, label)`` moves the bar on stderr."""


@dataclass(frozen=True)
class Answer:
    """What a command answers with.

    Attributes
    ----------
    shown : tuple
        In order: a text, or a function ``(pretty, width)`` that returns a `rich` table; `pretty` is True on a terminal,
        `width` its columns.
    data : dict
        The same as plain values (JSON); written to the file of ``--json`` (``-``: stdout, in place of `shown`).
    warnings : tuple of str
        Said on stderr.
    code : int
        Exit code.
    files : mapping of Path to bytes
        Written together with the file of ``--json``: all of them, or none.
    made : str
        What is said of `files`, behind `shown`, once they are written.
    then : callable, optional
        Called when all is written and said, as to serve a page until Ctrl-C; returns a last word for stderr.
    """

    shown: tuple[Any, ...] = ()
    data: dict[str, Any] = field(default_factory=dict)
    warnings: tuple[str, ...] = ()
    code: int = 0
    files: Mapping[Path, bytes] = field(default_factory=dict)
    made: str = ""
    then: Callable[[], str] | None = None


@dataclass(eq=False)
class Writing:
    """Files that go where there is room for them: an answer that took minutes is told nevertheless.

    Attributes
    ----------
    files : list of Path
        That were written.
    lost : list of str
        What was not, for stderr.
    """

    files: list[Path] = field(default_factory=list)
    lost: list[str] = field(default_factory=list)

    def into(self, place: Path, write: Callable[[], Iterable[Path]]) -> list[Path]:
        """Write files and return their paths; none where that fails.

        Parameters
        ----------
        place : Path
            Where, for the message.
        write : function
            Writes files and returns their paths.
        """
        try:
            made = list(write())
        except OSError as error:
            room = "make room, or " if error.errno in FULL else ""
            said = f"cannot write {place}: {error.strerror or error}; {room}give another place"
            self.lost.append(f"error: {said}. The answer on stdout and --json is whole")
            return []
        self.files += made
        return made

    @property
    def names(self) -> list[str]:
        """The files as they stand in JSON."""
        return [str(file) for file in self.files]

    @property
    def words(self) -> list[str]:
        """The files as they are told; nothing where there are none."""
        return ["Written:\n" + "\n".join(f"  {file}" for file in self.files)] if self.files else []

    @property
    def code(self) -> int:
        """The exit code."""
        return int(bool(self.lost))


class Command(Protocol):
    """A command's module."""

    def add(self, commands: Any) -> None:
        """Declare the command: ``commands.add_parser(name, ..., **STYLE)``."""

    def run(self, arguments: argparse.Namespace, progress: Progress) -> Answer:
        """Do the work."""


def error_code(argv: list[str], code: int) -> int:
    """Return the exit code of an error: a command whose own codes are verdicts names one for all errors.

    Such a command's module holds ``ERROR_CODE``; only 0 (help) and 130 (interrupted) stay what they are.  A command
    that is not known ends as the one that its name is nearest to; where it is near to none, it may have been any, and
    ends like one with verdicts.

    Parameters
    ----------
    argv : list of str
    code : int
        Of the error elsewhere.
    """
    name, modules = next((word for word in argv if not word.startswith("-")), ""), found()
    if code in (0, 130) or not name:
        return code
    codes = {own: int(getattr(module, "ERROR_CODE", code)) for own, module in modules.items()}
    if name in codes:
        return codes[name]
    meant = get_close_matches(name, list(codes), 1)
    return codes.get(meant[0], code) if meant else max(codes.values(), default=code)


ORDER = ("demo", "machines", "show-machine", "correct", "simulate", "check", "identify", "validate", "diagnose",
         "compare", "apply", "budget", "accept", "view", "report", "warm-up", "completion")  # fmt: skip
"""Commands in the order of the work; others follow by name."""


def _place(name: str) -> tuple[int, str]:
    """Return where a command stands in ``--help``."""
    return (ORDER.index(name) if name in ORDER else len(ORDER), name)


def found() -> dict[str, Command]:
    """Return the modules of this folder by their command's name (``_`` stands for ``-``)."""
    names = (item.name.replace("_", "-") for item in iter_modules([str(Path(__file__).parent)]))
    return {name: import_module(f"{__name__}.{name.replace('-', '_')}") for name in sorted(names, key=_place)}


def envelope(answer: Answer, command: str) -> dict[str, Any]:
    """Return an answer as every command's ``--json`` tells it.

    `format`, `command`, `version`, `exit_code`, `warnings` and `written` (paths) come first, then what is the command's
    own.

    Examples
    --------
    >>> list(envelope(Answer(data={"rows": 2}), "correct"))
    ['format', 'command', 'version', 'exit_code', 'warnings', 'written', 'rows']
    """
    own = dict(answer.data)
    written = [*own.pop("written", ()), *(str(file) for file in answer.files)]
    warnings = [*own.pop("warnings", ()), *(text.removeprefix("warning: ") for text in answer.warnings
                                            if not text.startswith("note:"))]  # fmt: skip
    return {
        "format": own.pop("format", f"hexathermal-{command}/1"),
        "command": command,
        "version": hexathermal.__version__,
        "exit_code": answer.code,
        "warnings": list(dict.fromkeys(warnings)),
        "written": list(dict.fromkeys(written)),
    } | own
