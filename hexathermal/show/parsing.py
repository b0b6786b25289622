"""How the command line is parsed: options that every command has, suggestions for what is misspelt."""

from __future__ import annotations

import argparse
import re
from collections.abc import Iterable, Sequence
from typing import Any, NoReturn

from hexathermal.machine.forms import nearest

NUMBERS = re.compile(r"-[\d.][\d.,eE+-]*$", re.ASCII)
"""What is a number although it begins like an option: -5, -1e-3, -5,0,120."""


class _Once(argparse.Action):
    """Keep the value of an option; refuse the option a second time, where one of the two would be lost."""

    def __call__(
        self,
        parser: argparse.ArgumentParser,
        namespace: argparse.Namespace,
        values: str | Sequence[Any] | None,
        option_string: str | None = None,
    ) -> None:
        """Store the value."""
        given = vars(namespace).setdefault("given_once", set())
        if self.option_strings and self.dest in given:
            raise argparse.ArgumentError(self, "given twice; give it once")
        given.add(self.dest)
        setattr(namespace, self.dest, values)


class Parser(argparse.ArgumentParser):
    """A parser that takes -1e-3 for a number, refuses an option given twice, and suggests what was meant."""

    def __init__(self, **named: Any) -> None:
        super().__init__(**named)
        self._negative_number_matcher = NUMBERS
        for kind in (None, "store"):
            self.register("action", kind, _Once)

    def error(self, message: str) -> NoReturn:
        """Say what is wrong in one message, and where help is."""
        self.exit(2, f"error: {message}\nsee '{self.prog} --help'\n")

    def refuse_unknown(self, words: Sequence[str]) -> NoReturn:
        """Say which words are not known, and what may have been meant.

        Parameters
        ----------
        words : sequence of str
            What was left over, in the order of the command line.
        """
        options = [name for name in self._option_string_actions if name.startswith("--")]
        first = next((word for word in words if word.startswith("-")), None)
        if first is None:
            self.error(f"unexpected argument{'s' if len(words) > 1 else ''}: {' '.join(words)}")
        name = first.split("=")[0]
        if name in self._option_string_actions:
            self.error(f"{name} stands before the command; options stand after it: {self.prog} {name} ...")
        self.error(f"unknown option {name}{suggestion(name, options)}")

    def _check_value(self, action: argparse.Action, value: Any) -> None:
        """Refuse a value that is none of the choices, and suggest one."""
        if action.choices is None or value in action.choices:
            return
        names = list(map(str, action.choices))
        if isinstance(action, argparse._SubParsersAction):
            self.error(f"unknown {_kind(action)} {value!r}{suggestion(str(value), names)}; known: {', '.join(names)}")
        raise argparse.ArgumentError(
            action, f"invalid choice: {value!r}{suggestion(str(value), names)}; choose from {', '.join(names)}"
        )


def _kind(action: argparse.Action) -> str:
    """Return what a group of commands is called."""
    return "command" if action.dest == "command" else "kind"


def suggestion(word: str, names: Iterable[str]) -> str:
    """Return ``; did you mean 'name'?`` for the name nearest to a word, or nothing.

    Examples
    --------
    >>> suggestion("--jso", ["--json", "--out"])
    "; did you mean '--json'?"
    >>> suggestion("--xyz", ["--json", "--out"])
    ''
    """
    known = {name.lower(): name for name in names}
    short = word.lower()
    close = [low for low in known if len(short) > 2 and low.startswith(short)] or nearest(short, known)
    return f"; did you mean {known[close[0]]!r}?" if close else ""


def complete_parsers(parser: argparse.ArgumentParser) -> None:
    """Give every command below a parser the options of all, and every parser its place for suggestions."""
    parser.set_defaults(leaf=parser)
    groups = [action for action in parser._actions if isinstance(action, argparse._SubParsersAction)]
    if not groups:
        _add_common(parser)
    for group in groups:
        for one in group.choices.values():
            complete_parsers(one)


def _target(text: str) -> str:
    """Return the name of the file of an answer."""
    if not text:
        raise argparse.ArgumentTypeError("the name of the file is empty")
    return text


def _add_common(parser: argparse.ArgumentParser) -> None:
    """Declare what every command accepts: ``--json``, ``--quiet`` and ``--verbose``."""
    group = parser.add_argument_group("options of every command")
    group.add_argument(
        "--json", nargs="?", const="-", type=_target, metavar="FILE",
        help="write the answer as JSON into FILE too; without FILE, or with -, to stdout, and nothing else there",
    )  # fmt: skip
    voice = group.add_mutually_exclusive_group()
    voice.add_argument("--quiet", action="store_true", help="say nothing but warnings and errors, on stderr")
    voice.add_argument("--verbose", action="store_true", help="tell every step and its time, on stderr")


def parsed(parser: Parser, words: Sequence[str]) -> argparse.Namespace:
    """Return the arguments; what is not known ends the program with a suggestion.

    Raises
    ------
    SystemExit
        The words are no call of a command (code 2), or ask for help (code 0).
    """
    arguments, rest = parser.parse_known_args(words)
    if rest:
        leaf: Parser = arguments.leaf
        leaf.refuse_unknown(rest)
    return arguments
