"""What several commands of the command line share: kinds of options, exit codes, the look of ``--help``."""

from __future__ import annotations

import argparse
import math
import os
import re
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

from hexathermal.errors import ArgumentError, KinematicsError
from hexathermal.machine.hexapod import Hexapod
from hexathermal.machine.library import bundled_hexapods, load_hexapod, refuse_two_meanings
from hexathermal.poses import CONVENTIONS, FloatArray, Frames, pose_from_coordinates

WIDTH = 118
"""Columns of ``--help`` where it does not go to a narrower terminal."""

COMPILE_TIME = "up to a minute"
"""How long compiling takes where nothing is kept on disk yet; measured: 15 to 35 s."""

EXIT_CODES = """\
exit codes:
  0    done
  1    could not be finished: disk full, file cannot be read, or an error inside hexathermal
  2    wrong usage: unknown option, command or machine, no such file, result file exists already or is no plain file,
       or a machine without a thermal law is to be corrected
  3    bad input: a row, a header or a machine file breaks its format, a temperature is out of range, or measurements do
       not suffice for what is asked of them; also a command that is not known and near to none, or to 'accept': its 2
       is a verdict
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


def sensor_names(text: str, allowed: str = "auto, or names with commas, as T07,T14") -> tuple[str, ...]:
    """Return the names of ``--sensors``, without the blanks around them.

    Raises
    ------
    ArgumentError
        There is none, or one of several is empty: a name may have been lost there.
    """
    names = tuple(name.strip() for name in text.split(","))
    if not any(names):
        raise ArgumentError(f"--sensors names no sensor; give {allowed}")
    if not all(names):
        raise ArgumentError(f"--sensors {text!r} holds an empty name; give {allowed}")
    return names


def seed(text: str) -> int:
    """Return a whole number that can start a generator."""
    if not re.fullmatch(r"\d{1,18}", text, re.ASCII):
        raise argparse.ArgumentTypeError(f"{text!r} is not a whole number from 0 on (18 digits at most)")
    return int(text)


def whole(low: int, high: int) -> Callable[[str], int]:
    """Return a reader of whole numbers in a range."""

    def read(text: str) -> int:
        """Return a whole number."""
        if not re.fullmatch(r"-?\d{1,9}", text, re.ASCII) or not low <= int(text) <= high:
            raise argparse.ArgumentTypeError(f"{text!r} is not a whole number from {low} to {high}")
        return int(text)

    return read


def named(text: str) -> str:
    """Return a name that is not empty: that of the folder one is in would be taken for it."""
    if not text:
        raise argparse.ArgumentTypeError("the name is empty")
    return text


def path(text: str) -> Path:
    """Return a path that is not empty."""
    if not text:
        raise argparse.ArgumentTypeError("the name of the file is empty")
    return Path(text)


def numbers(words: list[str], count: int, option: str, what: str) -> tuple[float, ...]:
    """Return `count` numbers from words parted by blanks or commas."""
    found = [part for word in words for part in word.split(",") if part]
    try:
        values = tuple(float(part) for part in found)
    except ValueError:
        values = (math.nan,)
    if len(values) != count or not all(map(math.isfinite, values)):
        wanted = "one finite number" if count == 1 else f"{count} finite numbers"
        raise ArgumentError(f"{option} takes {wanted} ({what}), found {' '.join(words)!r}")
    return values


def three(words: list[str] | None, option: str, unit: str) -> tuple[float, ...] | None:
    """Return three numbers, or None where there are none."""
    return None if words is None else numbers(words, 3, option, f"x y z, {unit}")


def tool_given(words: list[str] | None) -> tuple[float, ...] | None:
    """Return the point of ``--at-tool`` [mm], None where it is not given.

    Raises
    ------
    ArgumentError
        The words are no three numbers, or no point of a tool.
    """
    from hexathermal.predict.budget_view import LONGEST_ARM

    point = three(words, "--at-tool", "mm")
    if point is not None and max(map(abs, point)) > LONGEST_ARM * 1e3:
        raise ArgumentError(
            f"--at-tool {' '.join(words or ())} is more than {LONGEST_ARM:g} m from the platform's origin; it is in mm"
        )
    return point


def in_millimetres(text: str) -> str:
    """Return a message of the library without its question for the units of metres: people give mm and deg here.

    Examples
    --------
    >>> in_millimetres("9 m; poses are in metres, were millimetres given?; choose a pose closer to home")
    '9 m; choose a pose closer to home'
    """
    return re.sub(r"; [^;]*\bwere millimetres given\?", "", text)


def add_frames(
    command: argparse.ArgumentParser, user: str = "axes of the poses", own: str = "the point that is moved: the tool"
) -> None:
    """Declare ``--user-frame``, ``--object-frame`` and ``--convention``.

    Parameters
    ----------
    command : ArgumentParser
    user, own : str
        What the two frames mean to the command.
    """
    for frame, what in (("user", user), ("object", own)):
        command.add_argument(f"--{frame}-frame", nargs="+", metavar="V",
                             help=f"{what}; x y z rx ry rz, mm and deg (default: 0)")  # fmt: skip
    command.add_argument("--convention", choices=sorted(CONVENTIONS), default="fixed-xyz", metavar="NAME",
                         help="of the angles: fixed-xyz (default: R = Rz Ry Rx) or fixed-zyx (Rx Ry Rz)")  # fmt: skip


def pose_given(words: list[str], hexapod: Hexapod, convention: str = "fixed-xyz") -> FloatArray:
    """Return the pose of ``--pose``, counted from home.

    Raises
    ------
    ArgumentError
        The words are no six numbers.
    KinematicsError
        The pose cannot be reached.
    """
    six = numbers(words, 6, "--pose", "x y z rx ry rz, mm and deg")
    pose = pose_from_coordinates(six, convention, hexapod=hexapod)
    try:
        hexapod.inverse_kinematics(pose)
    except ArgumentError as error:
        if "far outside" not in str(error):
            raise
        raise KinematicsError(f"--pose {' '.join(words)} (mm and deg): {in_millimetres(str(error))}") from None
    return pose


def frames_of(arguments: argparse.Namespace) -> Frames | None:
    """Return the frames that `add_frames` declared, None where none is given or both are zero."""
    user, own = (
        numbers(given, 6, f"--{name}-frame", "x y z rx ry rz, mm and deg") if given else (0.0,) * 6
        for name, given in (("user", arguments.user_frame), ("object", arguments.object_frame))
    )
    return Frames(user, own, arguments.convention) if any(user) or any(own) else None


def formatter(prog: str) -> argparse.HelpFormatter:
    """Return a formatter that keeps texts as they are and sets options and their help side by side."""
    width = min(WIDTH, shutil.get_terminal_size((WIDTH, 24)).columns - 2)
    return argparse.RawDescriptionHelpFormatter(prog, max_help_position=30, width=width)


STYLE: dict[str, Any] = {"formatter_class": formatter, "allow_abbrev": False}
"""What every parser of a command takes."""

MACHINE: dict[str, Any] = {
    "metavar": "NAME",
    "type": named,
    "help": "a bundled machine, or the path of a hexapod.toml or of its folder",
}
"""What every option for a machine takes."""

CAMPAIGN: dict[str, Any] = {
    "metavar": "CAMPAIGN",
    "type": path,
    "help": "measured runs: a folder with campaign.toml and its tables; 'hexathermal simulate bench' makes one",
}
"""What every argument for a campaign takes."""

SEED: dict[str, Any] = {
    "type": seed,
    "default": 1,
    "metavar": "N",
    "help": "of the random numbers; the same seed gives the same result (default: %(default)s)",
}
"""What every option for a seed takes."""

LETTERS = """\
letters: q0 is a leg's length between its joints when retracted, q how far its rod stands out, dT the rise of a
thermometer since the campaign's zero; the law's coefficients are A (um per metre of q0 and K), B (of q), C (um per K)
"""
"""The letters of the laws, for the end of a help."""


def machine(name: str) -> Hexapod:
    """Return a machine by name or path; a path that is no plain file is refused before it is opened.

    A name that is a bundled machine's and that of a folder with another one is refused.
    """
    refuse_two_meanings(name)
    file = Path(name) / "hexapod.toml" if os.path.isdir(name) else Path(name)
    if name not in bundled_hexapods() and os.path.exists(file) and not os.path.isfile(file):
        raise ArgumentError(f"{file} is no plain file (a device, pipe or folder); give a hexapod.toml or its folder")
    return load_hexapod(name)
