"""The command line: reads the arguments, runs a command, prints its answer. The only file that prints.

Results go to stdout, progress and errors to stderr. What each command accepts stands in `hexathermal.show.usage`.
"""

from __future__ import annotations

import json
import os
import re
import signal
import sys
import tempfile
import threading
import time
import traceback
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, TextIO

from rich.console import Console
from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeRemainingColumn

import hexathermal
from hexathermal.errors import (
    ArgumentError,
    DataError,
    FileFormatError,
    HexathermalError,
    KinematicsError,
    TemperatureError,
    UnknownNameError,
)
from hexathermal.loading import INTERRUPTED, WORDS
from hexathermal.predict.table_writing import refuse_no_folder
from hexathermal.show.commands import FULL, Answer, envelope, error_code, found
from hexathermal.show.options import in_millimetres
from hexathermal.show.outputs import protect
from hexathermal.show.parsing import parsed, suggestion
from hexathermal.show.usage import parser

DONE, UNFINISHED, USAGE, BAD_INPUT, UNREACHABLE = 0, 1, 2, 3, 4

PLAIN_WIDTH = 100_000
"""Columns of a table that goes to a file or a pipe: lines are never folded there."""

TRACEBACK = "HEXATHERMAL_TRACEBACK"

_STOP = threading.Event()
"""A stop was asked for. Libraries that catch everything while they load would swallow the exception alone."""

_NO_GLYPH = re.compile(r"Glyph (\d+) ")
"""How matplotlib begins to warn of a letter that its font lacks."""

_XDG = (("XDG_CONFIG_HOME", ".config"), ("XDG_CACHE_HOME", ".cache"))


def main(argv: list[str] | None = None) -> int:
    """Run the command line and return its exit code; nothing is raised.

    Parameters
    ----------
    argv : list of str, optional
        Arguments without the program's name; default those of the process.

    Returns
    -------
    int
        0 done, 1 not finished, 2 wrong usage, 3 bad input, 4 cannot be reached, 130 interrupted; of a command with
        verdicts those, and 3 for every error.
    """
    _open_streams()
    _STOP.clear()
    words = sys.argv[1:] if argv is None else list(argv)
    try:
        with _stopped_by_termination():
            code = _run(words)
            sys.stdout.flush()
        return code
    except BrokenPipeError:
        _drop(sys.stdout)
        return DONE
    except KeyboardInterrupt:
        _say(WORDS)
        return INTERRUPTED
    except SystemExit as error:
        return error_code(words, error.code if isinstance(error.code, int) else USAGE)
    except Exception as error:
        if os.environ.get(TRACEBACK):
            traceback.print_exc()
        return error_code(words, _explain(error))


def _open_streams() -> None:
    """Give a process that was started without stdout or stderr (``>&-``) ones that nobody reads."""
    for name in ("stdout", "stderr"):
        if getattr(sys, name) is None:
            setattr(sys, name, open(os.devnull, "w", encoding="utf-8"))  # noqa: SIM115 (lives as long as the process)


def _explain(error: Exception) -> int:
    """Say what went wrong and return the exit code."""
    if isinstance(error, UnknownNameError):
        word = str(error).split("'")[1] if "'" in str(error) else ""
        _say(f"error: {error}{suggestion(word, error.available)}")
        return USAGE
    if isinstance(error, HexathermalError):
        _say(f"error: {in_millimetres(str(error))}")
        if isinstance(error, FileFormatError | TemperatureError | DataError):
            return BAD_INPUT
        return UNREACHABLE if isinstance(error, KinematicsError) else USAGE
    if isinstance(error, OSError):
        _say(f"error: {_lacking(error)}")
        return UNFINISHED
    if isinstance(error, UnicodeEncodeError):
        _say(
            f"error: the name {error.object!a} holds letters that this locale does not know; "
            "start with PYTHONUTF8=1 or a UTF-8 locale (LC_ALL=C.UTF-8), or rename the file"
        )
        return USAGE
    if isinstance(error, MemoryError):
        _say("error: out of memory")
        return UNFINISHED
    _say(
        f"error inside hexathermal: {type(error).__name__}: {error}\nplease report it; {TRACEBACK}=1 shows where it is"
    )
    return UNFINISHED


def _lacking(error: OSError) -> str:
    """Return what the system refused, with the file, and what to do where a disk is full."""
    place = f": {error.filename}" if error.filename else ""
    room = "; make room, or give another place" if error.errno in FULL else ""
    return f"{error.strerror or error}{place}{room}"


def _run(argv: list[str]) -> int:
    """Run one command, print its answer and return its exit code."""
    if any("\0" in word for word in argv):
        raise ArgumentError("an argument holds a zero byte")
    top = parser(hexathermal.__version__)
    arguments = parsed(top, argv)
    if arguments.command is None:
        top.print_help(sys.stderr)
        return USAGE
    protect(arguments)
    target = getattr(arguments, "json", None)
    if target not in (None, "-"):
        refuse_no_folder(Path(target))
    began = time.perf_counter()
    voice = Voice(getattr(arguments, "quiet", False), getattr(arguments, "verbose", False))
    with _plain_warnings(voice), _bar(arguments.command, voice) as progress, _place_for_fonts():
        answer = found()[arguments.command].run(arguments, progress)
    _obey_stop()
    _finish(answer, arguments.command, target, voice)
    if voice.verbose:
        _say(f"{time.perf_counter() - began:7.1f} s  done, exit code {answer.code}")
    if answer.then is not None:
        last = answer.then()
        if not voice.quiet:
            _say(last)
    return answer.code


def _finish(answer: Answer, command: str, target: str | None, voice: Voice) -> None:
    """Say warnings, write the files that belong to an answer, and print it."""
    from hexathermal.predict.table_writing import written_together

    for warning in answer.warnings:
        if not (voice.quiet and warning.startswith("note:")):
            _say(warning)
    files = dict(answer.files)
    if target not in (None, "-"):
        files[Path(str(target))] = f"{_json(answer, command)}\n".encode()
    lost: OSError | None = None
    try:
        with written_together(tuple(files)) as parts:
            for part, content in zip(parts, files.values(), strict=True):
                part.write_bytes(content)
    except OSError as error:  # an answer that took minutes is told nevertheless
        lost = error
        answer = replace(answer, code=UNFINISHED, files={}, made="")
    try:
        if target == "-":
            print(_json(answer, command))
        elif not voice.quiet:
            _show(*answer.shown, *([answer.made] if answer.made else []))
        sys.stdout.flush()
    except BrokenPipeError:
        _drop(sys.stdout)  # the reader has gone; the code is still the answer's
    if lost is not None:
        raise lost


def _json(answer: Answer, command: str) -> str:
    """Return an answer as JSON."""
    return json.dumps(envelope(answer, command), indent=2, allow_nan=False)


@contextmanager
def _stopped_by_termination() -> Iterator[None]:
    """Let SIGTERM and SIGHUP end the work like Ctrl-C does, half-written files removed; keep all three in mind."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return

    def stop(_number: int, _frame: object) -> None:
        _STOP.set()
        raise KeyboardInterrupt

    numbers = [getattr(signal, name) for name in ("SIGTERM", "SIGHUP") if hasattr(signal, name)]
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        numbers.append(signal.SIGINT)
    # a signal that is ignored (nohup) stays ignored
    before: dict[signal.Signals, Any] = {
        number: signal.signal(number, stop)
        for number in numbers
        if signal.getsignal(number) not in (signal.SIG_IGN, None)
    }
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def _obey_stop() -> None:
    """Stop where a stop was asked for and something swallowed it."""
    if _STOP.is_set():
        raise KeyboardInterrupt


def _drop(stream: TextIO) -> None:
    """Send what is still to be written to nowhere: its reader has gone."""
    with suppress(OSError, ValueError):
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, stream.fileno())
        os.close(nowhere)


def _printable(text: str, stream: TextIO) -> str:
    """Return a text with letters written out that a stream cannot take."""
    encoding = stream.encoding or "utf-8"
    return text.encode(encoding, "backslashreplace").decode(encoding)


def _say(text: str) -> None:
    """Write one message to stderr."""
    with suppress(OSError):
        print(_printable(text, sys.stderr), file=sys.stderr, flush=True)


def _console(stream: TextIO) -> Console:
    """Return a console: ruled tables and colours on a terminal, plain long lines elsewhere."""
    width = None if stream.isatty() else PLAIN_WIDTH
    return Console(file=stream, width=width, markup=False, emoji=False, highlight=False)


def _show(*tables: Callable[[bool, int], Any] | str) -> None:
    """Print tables and texts to stdout."""
    from hexathermal.show.tables import width_of

    console = _console(sys.stdout)
    width = console.width
    with console.capture() as printed:
        for k, item in enumerate(tables):
            if k and not console.is_terminal:
                console.print()
            if isinstance(item, str):
                console.print(item, soft_wrap=True)
            else:
                table = item(console.is_terminal, width)
                console.width = width_of(table, width)
                console.print(table)
    print(_printable("\n".join(line.rstrip() for line in printed.get().splitlines()), sys.stdout))


@dataclass(frozen=True)
class Voice:
    """How much is said: `quiet` leaves warnings and errors only, `verbose` tells every step."""

    quiet: bool = False
    verbose: bool = False


@contextmanager
def _plain_warnings(voice: Voice) -> Iterator[None]:
    """Say what libraries warn of in one line each, at the end, without places in their code."""
    found: dict[str, str] = {}

    def keep(
        message: Warning | str, category: type[Warning], filename: str, lineno: int, file: TextIO | None = None,
        line: str | None = None,
    ) -> None:  # fmt: skip
        own = category.__module__.partition(".")[0] == hexathermal.__name__  # its name says nothing to a reader
        found.setdefault(str(message).strip(), "" if own else f" ({category.__name__})")

    before, warnings.showwarning = warnings.showwarning, keep
    try:
        yield
    finally:
        warnings.showwarning = before
        lacking = [(text, _NO_GLYPH.match(text)) for text in found]
        letters = "".join(dict.fromkeys(chr(int(number[1])) for _text, number in lacking if number))
        notes = [f"{text}{found[text]}" for text, number in lacking if number is None]
        if letters:
            notes.append(
                f"pictures show boxes for {letters}: their font lacks these letters; texts and tables have them"
            )
        for note in notes if not voice.quiet else ():
            _say(f"note: {note}")


@contextmanager
def _bar(label: str, voice: Voice) -> Iterator[Callable[[int, int, str], None]]:
    """Give a function ``(done, total, label)`` that moves a bar on stderr; silent where that is no terminal."""
    columns = (TextColumn("{task.description}"), BarColumn(), TaskProgressColumn(), TimeRemainingColumn())
    console, began, last = _console(sys.stderr), time.perf_counter(), [""]
    hidden = voice.quiet or not console.is_terminal
    with Progress(*columns, console=console, transient=True, disable=hidden) as progress:
        task = progress.add_task(label, total=None)

        def move(done: int, total: int, text: str = label) -> None:
            _obey_stop()
            progress.update(task, completed=done, total=total or None, description=text)
            if voice.verbose and text != last[0]:
                last[0] = text
                console.print(_printable(f"{time.perf_counter() - began:7.1f} s  {text}", sys.stderr))

        yield move


@contextmanager
def _place_for_fonts() -> Iterator[None]:
    """Give matplotlib a folder of its own for a while where the home folder cannot be written."""
    home, name = os.path.expanduser("~"), "MPLCONFIGDIR"
    places = [Path(os.environ.get(key) or Path(home, own)) for key, own in _XDG]
    nearest = [next(place for place in (wanted, *wanted.parents) if place.exists()) for wanted in places]
    if name in os.environ or all(os.access(place, os.W_OK | os.X_OK) for place in nearest):
        yield
        return
    with tempfile.TemporaryDirectory(prefix="hexathermal-") as folder:
        os.environ[name] = folder
        try:
            yield
        finally:
            del os.environ[name]
