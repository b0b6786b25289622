"""What is wrong with a campaign: the faults of `campaign.toml` and of all its tables, in one error."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from hexathermal.errors import FileFormatError, HexathermalError, Problem

SHOWN = 5
"""Faults of one kind in one column that are listed singly; the rest are counted."""


class CampaignError(FileFormatError):
    """A campaign breaks its format; all faults of all its files are listed, not only the first.

    Attributes
    ----------
    path : str
        The campaign's `campaign.toml`.
    faults : tuple of (str, Problem)
        File and problem, in the order of the campaign.
    """

    def __init__(self, path: str, faults: tuple[tuple[str, Problem], ...]) -> None:
        files = len({file for file, _problem in faults})
        count = f"{len(faults)} fault" + ("s" if len(faults) != 1 else "")
        where = f" in {files} files" if files > 1 else ""
        lines = "\n".join(f"  {file}, {problem}" for file, problem in faults)
        HexathermalError.__init__(self, f"campaign {path}: {count}{where}\n{lines}")
        self.path, self.faults = path, faults
        self.problems = tuple(problem for _file, problem in faults)

    def __reduce__(self) -> tuple[object, ...]:
        return (CampaignError, (self.path, self.faults))


class Faults:
    """Faults being collected; of one kind in one column some are listed, the rest counted."""

    def __init__(self) -> None:
        self._found: dict[tuple[str, str], list[Problem]] = {}
        self._counts: dict[tuple[str, str], int] = {}

    def __bool__(self) -> bool:
        return bool(self._found)

    def add(self, path: Path | str, problem: Problem, kind: str = "") -> None:
        """Note a fault; faults of the same `kind` in the same file are listed up to `SHOWN` times."""
        key = (str(path), kind or f"{problem.line}:{problem.column}:{problem.message}")
        listed = self._found.setdefault(key, [])
        self._counts[key] = self._counts.get(key, 0) + 1
        if len(listed) < SHOWN:
            listed.append(problem)

    def extend(self, path: Path | str, problems: Iterable[Problem]) -> None:
        """Note several faults of a file."""
        for problem in problems:
            self.add(path, problem)

    def listed(self) -> tuple[tuple[str, Problem], ...]:
        """Return all faults, file by file as they were first met, by line."""
        files: dict[str, list[Problem]] = {}
        for key, problems in self._found.items():
            own = files.setdefault(key[0], [])
            left = self._counts[key] - len(problems)
            last = problems[-1]
            own.extend(problems[:-1] if left else problems)
            if left:
                more = f"{last.message} (and {left} more of this kind)"
                own.append(Problem(last.line, last.column, more))
        return tuple(
            (file, problem)
            for file, problems in files.items()
            for problem in sorted(problems, key=lambda item: (item.line, item.column))
        )

    def finish(self, path: Path | str) -> None:
        """Raise all faults together.

        Raises
        ------
        CampaignError
            There is a fault.
        """
        if self._found:
            raise CampaignError(str(path), self.listed())
