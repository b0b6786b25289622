"""What a command may write: never over or beside what it reads."""

from __future__ import annotations

import argparse
import json
import tomllib
from collections.abc import Iterator
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any

from hexathermal.errors import ArgumentError

OUTPUTS = ("out", "json", "report", "plots", "netcdf", "truth", "junit", "extend", "save", "figures")
"""Options that name files or folders to be written."""

MAY_BE_FOLDERS = {"--out", "--report", "--plots", "--figures"}
"""Several of them may go into one place."""

OWN_FOLDERS = ("campaign.toml", "hexapod.toml")
"""A folder with one of these files is one thing: nothing is written into it."""

CAMPAIGN = OWN_FOLDERS[0]
MAKING = "simulate"
"""The command that makes campaigns: its --out may name one itself."""

PICTURES = ("*.png", "*.svg")
WRITTEN: dict[str, dict[str, tuple[str, ...]]] = {
    "apply": {"out": ("hexapod.toml",)},
    "budget": {"out": ("*.csv", "*.png")},
    "check": {"plots": PICTURES},
    "compare": {"plots": PICTURES},
    "demo": {"out": ("day.csv", "day.png", "summary.json")},
    "diagnose": {"report": ("report.html", "diagnosis.json", "experiment.json", "*.csv", *PICTURES),
                 "extend": ("hexapod.toml",)},
    "identify": {"out": ("hexapod.toml", "hexapod.origin.toml"), "report": ("*.csv", "identification.json", *PICTURES)},
    "report": {"figures": ("*.csv", *PICTURES)},
    MAKING: {"out": (), "plots": PICTURES},  # nothing goes into its --out: it says so itself
    "validate": {"report": ("validation.json", *PICTURES)},
}  # fmt: skip
"""Names of the files that a command writes into the folder of an option; one not known here may hold any name."""

LAWS = {"hexathermal-leg": "law (leg.toml)", "hexathermal-hexapod": "machine (hexapod.toml)"}
"""Formats of laws, without their version, and what they are called."""

BESIDE = {"identify": "origin.toml"}
"""Ending of a second file that a command writes beside the ``NAME.toml`` of --out."""


def protect(arguments: argparse.Namespace) -> None:
    """Refuse results that would replace a file that is read, or go into a folder that is read.

    Raises
    ------
    ArgumentError
        A result has the name of a file that is read, or lies inside a campaign or a machine that is read, or inside any
        other campaign; or two results have one name, also one that the command gives a file itself; or the file of
        ``--json`` exists and is no earlier answer.
    """
    given = {name: list(_paths(value)) for name, value in vars(arguments).items()}
    read = [path for name, paths in given.items() if name not in OUTPUTS for path in paths if path.exists()]
    for name in OUTPUTS:
        for path in given.get(name, []):
            if str(path) != "-":
                _check(f"--{name}", path, read)
                _check_campaigns(name, path, name == "out" and getattr(arguments, "command", None) == MAKING)
    results = {name: path for name in OUTPUTS for path in given.get(name, []) if str(path) != "-"}
    _check_each_other({f"--{name}": path for name, path in results.items()})
    _check_own_names(results, str(getattr(arguments, "command", "")))
    if given.get("json") and not getattr(arguments, "force", False):
        _check_answer(given["json"][0])


def _paths(value: Any) -> Iterator[Path]:
    """Yield the paths that an argument holds."""
    for item in value if isinstance(value, list | tuple) else [value]:
        if isinstance(item, Path):
            yield item
        elif isinstance(item, str) and item and "\0" not in item:
            yield Path(item)


def _check(option: str, path: Path, read: list[Path]) -> None:
    """Refuse one result."""
    target = path.resolve()
    for source in read:
        own = source.resolve()
        if target == own and not own.is_dir():
            raise ArgumentError(f"{option} {path} is one of the files that are read; give another name")
        folder = own if own.is_dir() else own.parent if own.name in OWN_FOLDERS else None
        if folder is None or not any((folder / name).exists() for name in OWN_FOLDERS):
            continue
        if target == folder or folder in target.parents:
            raise ArgumentError(f"{option} {path} lies inside {folder.name}, which is read; give another place")


def _check_each_other(results: dict[str, Path]) -> None:
    """Refuse two results of one name, unless both may be folders: the second would replace the first."""
    taken: dict[Path, str] = {}
    for option, path in results.items():
        other = taken.setdefault(path.resolve(), option)
        folders = {option, other} <= MAY_BE_FOLDERS and path.suffix != ".toml"  # that is the file of a law or a machine
        if other != option and not folders:
            raise ArgumentError(f"{option} and {other} both name {path}; give each a name of its own")


def _check_own_names(results: dict[str, Path], command: str) -> None:
    """Refuse a result that has the name of a file which the command writes itself: one of the two would be lost."""
    for holder, place in results.items():
        folder, names = place.resolve(), WRITTEN.get(command, {}).get(holder, ("*",))
        beside = None
        if holder == "out" and folder.suffix == ".toml" and command in BESIDE:
            beside = folder.with_suffix(f".{BESIDE[command]}")
        for name, path in results.items():
            target = path.resolve()
            inside = folder in target.parents and _is_among(target.relative_to(folder).parts[0], names)
            if inside or target == beside:
                raise ArgumentError(
                    f"--{name} {path} names a file that --{holder} {place} writes itself; give it a name of its own"
                )


def _is_among(name: str, patterns: tuple[str, ...]) -> bool:
    """Whether a name is one of those written; small and large letters are one, as on some file systems."""
    return any(fnmatchcase(name.casefold(), pattern) for pattern in patterns)


def _check_campaigns(option: str, path: Path, making: bool) -> None:
    """Refuse a result inside a folder of measurements, also where nothing of it is read."""
    target = path.resolve()
    around = target.parents if making else (target, *target.parents)
    folder = next((one for one in around if (one / CAMPAIGN).is_file()), None)
    if folder is not None:
        raise ArgumentError(
            f"--{option} {path} lies inside {folder.name}, which holds {CAMPAIGN}: measurements stay as they are; give "
            f"a place outside of {folder}"
        )


def _check_answer(path: Path) -> None:
    """Refuse to replace a file that is no earlier answer of this program."""
    if str(path) == "-" or not path.is_file():
        return
    try:
        found = json.loads(path.read_text(encoding="utf-8"))
        known = isinstance(found, dict) and str(found.get("format", "")).startswith("hexathermal-")
    except (OSError, ValueError):
        known = False
    if not known:
        raise ArgumentError(f"--json {path} exists and is no earlier answer; give another name")


NO_LAWS = (".csv", ".parquet", ".json", ".nc", ".html", ".png", ".svg", ".pdf")
"""Endings of files that hold other things."""


def law_place(place: Path, option: str, force: bool) -> None:
    """Refuse the file of a law that is none, that exists, or that cannot be written, before any work is done.

    Parameters
    ----------
    place : Path
    option : str
        That names it.
    force : bool
        An earlier law may be replaced, nothing else.
    """
    if place.exists() and not place.is_file():
        raise ArgumentError(f"{place} is a folder or a device; give the name of a file for {option}")
    if place.suffix.lower() in NO_LAWS:
        raise ArgumentError(f"{place}: {option} writes TOML; give a name as {place.with_suffix('.toml').name}")
    _refuse_there(place, option, force, "hexathermal-leg")


def machine_place(place: Path, option: str, force: bool) -> Path:
    """Return the file of a machine, which goes to a ``.toml`` file or a folder; refuse it as `law_place` does."""
    from hexathermal.machine.writing import machine_file
    from hexathermal.predict.table_writing import refuse_no_folder, refuse_no_place

    file = machine_file(place)
    if file.parent == place and place.exists() and not place.is_dir():
        raise ArgumentError(f"{place} is no folder; {option} names a hexapod.toml, or the folder that gets it")
    _refuse_there(file, option, force, "hexathermal-hexapod")
    if file.parent.is_dir():
        refuse_no_folder(file)
    else:
        refuse_no_place(file.parent)  # it is made at the end
    return file


def _refuse_there(file: Path, option: str, force: bool, kind: str) -> None:
    """Refuse a file that exists, unless it is of the kind that is written and may be replaced."""
    if not file.exists():
        return
    if not force:
        raise ArgumentError(f"{file} exists already; give another place for {option}, or --force to replace it")
    try:
        found = str(tomllib.loads(file.read_text(encoding="utf-8-sig")).get("format", ""))
    except (OSError, ValueError):
        found = ""
    if found.partition("/")[0] != kind:
        raise ArgumentError(
            f"{file} is no {LAWS[kind]}, and --force replaces nothing else; give another name for {option}"
        )
