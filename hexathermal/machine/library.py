"""The machines that come with the package: one folder each under `models/`."""

from __future__ import annotations

import os
from functools import cache
from pathlib import Path

from hexathermal.errors import ArgumentError, UnknownNameError
from hexathermal.machine.files import read_hexapod
from hexathermal.machine.hexapod import Hexapod


def models_folder() -> Path:
    """Return the folder of the bundled machines: inside the installed package, or beside it in a checkout."""
    package = Path(__file__).resolve().parent.parent
    inside = package / "models"
    return inside if inside.is_dir() else package.parent / "models"


def _folders() -> dict[str, Path]:
    """Return the machines' folders by name."""
    return {file.parent.name: file.parent for file in sorted(models_folder().glob("*/hexapod.toml"))}


def bundled_hexapods() -> tuple[str, ...]:
    """Return the names of the bundled machines, sorted.

    Examples
    --------
    >>> "reference" in bundled_hexapods()
    True
    """
    return tuple(_folders())


def unmistakable(place: Path) -> str:
    """Return a path that is never taken for the name of a bundled machine.

    Examples
    --------
    >>> unmistakable(Path("mine")), unmistakable(Path("reference"))
    ('mine', './reference')
    """
    return f".{os.sep}{place}" if str(place) in _folders() else str(place)


def refuse_two_meanings(name: str) -> None:
    """Refuse a name that is that of a bundled machine and of another machine's folder, here.

    Raises
    ------
    ArgumentError
        Tells the paths of both.
    """
    bundled, own = _folders().get(name), Path(name) / "hexapod.toml"
    if bundled is None or not own.is_file() or own.samefile(bundled / "hexapod.toml"):
        return
    raise ArgumentError(
        f"{name!r} is the name of a bundled machine, and a folder here holds a machine too: give "
        f"{unmistakable(Path(name))} for the folder, or {bundled} for the bundled one"
    )


def _exists(path: Path) -> bool:
    """Whether there is such a file or folder; a text that cannot be a path names none."""
    try:
        return path.exists()
    except (OSError, ValueError):
        return False


@cache
def _bundled(name: str) -> Hexapod:
    return read_hexapod(_folders()[name])


def load_hexapod(name_or_path: str | Path) -> Hexapod:
    """Return a bundled machine by name, or the machine of a hexapod.toml, or of a folder that holds one.

    The name of a bundled machine means that one, also where a folder of that name is here: ``./NAME`` is the folder.

    Raises
    ------
    UnknownNameError
        Neither a bundled name nor a path; `available` lists the names.
    FileFormatError
        The file has bad fields; all are listed with line and column.

    Examples
    --------
    >>> load_hexapod("reference").name
    'reference'
    """
    if isinstance(name_or_path, str) and name_or_path in _folders():
        return _bundled(name_or_path)
    if not isinstance(name_or_path, str | Path):
        raise ArgumentError(f"a machine is named by a text or a path, not by {type(name_or_path).__name__}")
    if _exists(Path(name_or_path)):
        return read_hexapod(name_or_path)
    raise UnknownNameError(
        f"{str(name_or_path)!r} is neither a bundled machine ({', '.join(bundled_hexapods())}) "
        "nor the path of a hexapod.toml or of a folder that holds one",
        bundled_hexapods(),
    )
