"""The folder of a diagnosis's report: an earlier report makes room for the next one, what others put there stays."""

from __future__ import annotations

import json
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path

from hexathermal.errors import ArgumentError
from hexathermal.learn.diagnosis.result import FORMAT
from hexathermal.predict.table_writing import refuse_no_place

PAGE, NUMBERS = "report.html", "diagnosis.json"

FILES = "files"
"""In the JSON of a report: the names of the files that were written with it."""

END = f"In the sentences at the top, ± is one standard uncertainty. All numbers stand in {NUMBERS}, by hexathermal."
"""The last line of a page; by it an earlier page is known."""


def refuse_foreign(folder: Path, force: bool) -> None:
    """Refuse a folder whose page or numbers no diagnosis wrote, before any work is done.

    Parameters
    ----------
    folder : Path
        There or not.
    force : bool
        Such files may be overwritten.

    Raises
    ------
    ArgumentError
        The folder is none, or holds such files without `force`.
    """
    refuse_no_place(folder)
    foreign = [] if force else [name for name in (PAGE, NUMBERS) if not _may_be_replaced(folder / name)]
    if foreign:
        raise ArgumentError(
            f"{folder} holds {' and '.join(foreign)}, which no diagnosis wrote; give another folder (--report), or "
            "--force"
        )


def _may_be_replaced(file: Path) -> bool:
    """Return whether a file is missing, or one that an earlier diagnosis wrote."""
    if not file.exists():
        return True
    if file.name == NUMBERS:
        return _earlier(file) is not None
    try:
        return END.rpartition(". ")[2] in file.read_text(encoding="utf-8")
    except (OSError, ValueError):
        return False


def _earlier(numbers: Path) -> dict[str, object] | None:
    """Return the JSON of an earlier diagnosis; None where there is none."""
    try:
        found = json.loads(numbers.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None
    return found if isinstance(found, dict) and found.get("format") == FORMAT else None


def files_of_earlier(folder: Path) -> frozenset[str]:
    """Return the names of the files that an earlier report says it wrote into a folder."""
    named = (_earlier(folder / NUMBERS) or {}).get(FILES)
    # plain names only: nothing outside of the folder is ever touched
    return frozenset(
        name for name in (named if isinstance(named, list) else ()) if isinstance(name, str) and Path(name).name == name
    )


def remove_stale(folder: Path, earlier: Iterable[str], written: Iterable[str]) -> None:
    """Remove the files of an earlier report that the one just written does not have.

    Parameters
    ----------
    folder : Path
    earlier, written : iterable of str
        Names of files.
    """
    for name in sorted(set(earlier) - set(written)):
        file = folder / name
        with suppress(OSError):  # gone already
            if file.is_file():
                file.unlink()
