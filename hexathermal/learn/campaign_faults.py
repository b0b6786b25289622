"""What is wrong with a campaign: the faults of `campaign.toml` and of all its tables, in one error."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

from hexathermal.errors import FileFormatError, HexathermalError, Problem

SHOWN = 5
"""Faults of one kind in one column that are listed singly; the rest, and those that read the same, are counted."""


FIELDS = "fields"
"""Kind of the faults of rows with too many or too few fields."""

NAMED = 4
"""Files with the same fault that are named."""


class CampaignError(FileFormatError):
    """A campaign breaks its format; all faults of all its files are listed, not only the first.

    Those that are the same in several files are told once.

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
        lines = "\n".join(_lines(faults, Path(path).parent))
        HexathermalError.__init__(self, f"campaign {path}: {count}{where}\n{lines}")
        self.path, self.faults = path, faults
        self.problems = tuple(problem for _file, problem in faults)

    def __reduce__(self) -> tuple[object, ...]:
        return (CampaignError, (self.path, self.faults))


def _lines(faults: Sequence[tuple[str, Problem]], folder: Path) -> list[str]:
    """Return a line for each fault; what is wrong at the same place in several files is said once, with their names."""
    files: dict[str, list[str]] = {}
    for file, problem in faults:
        files.setdefault(str(problem), []).append(file)
    lines = []
    for words, (first, *others) in files.items():
        lines.append(f"  {first}, {words}")
        if others:
            names = [file.removeprefix(f"{folder}/") for file in others]
            which = "one more file" if len(names) == 1 else f"{len(names)} more files"
            if len(names) > NAMED:
                names = [*names[: NAMED - 1], "...", names[-1]]
            lines.append(f"    the same in {which}: {', '.join(names)}")
    return lines


@dataclass
class _Listed:
    """A problem, how many more read the same, and the last line of them."""

    problem: Problem
    more: int = 0
    last: int = 0

    def told(self, others: int) -> Problem:
        """Return the problem with the count of those that read the same, and of `others` of its kind."""
        message = self.problem.message
        if self.more:
            message += f" (and {self.more} more that read the same, the last in line {self.last})"
        if others:
            message += f" (and {others} more of this kind)"
        return Problem(self.problem.line, self.problem.column, message)


class Faults:
    """Faults being collected; of one kind in one file some are listed, those that read the same once, the rest counted.

    Memory is constant.
    """

    def __init__(self) -> None:
        self._found: dict[tuple[str, str], dict[str, _Listed]] = {}
        self._others: dict[tuple[str, str], int] = {}

    def __bool__(self) -> bool:
        return bool(self._found)

    def add(self, path: Path | str, problem: Problem, kind: str = "") -> None:
        """Note a fault; faults of the same `kind` in the same file are listed up to `SHOWN` times."""
        key = (str(path), kind or f"{problem.line}:{problem.column}:{problem.message}")
        listed = self._found.setdefault(key, {})
        if problem.message in listed:
            listed[problem.message].more += 1
            listed[problem.message].last = problem.line
        elif len(listed) < SHOWN:
            listed[problem.message] = _Listed(problem)
        else:
            self._others[key] = self._others.get(key, 0) + 1

    def extend(self, path: Path | str, problems: Iterable[Problem]) -> None:
        """Note several faults of a file."""
        for problem in problems:
            self.add(path, problem)

    def listed(self) -> tuple[tuple[str, Problem], ...]:
        """Return all faults, file by file as they were first met, by line; rows of a wrong length first.

        What stands in their columns is not what the header says: other faults may follow from it.
        """
        files: dict[str, list[tuple[bool, Problem]]] = {}
        for (file, kind), listed in self._found.items():
            own, later = files.setdefault(file, []), kind != FIELDS
            items = list(listed.values())
            own.extend((later, item.told(0)) for item in items[:-1])
            own.append((later, items[-1].told(self._others.get((file, kind), 0))))
        return tuple(
            (file, problem)
            for file, problems in files.items()
            for _later, problem in sorted(problems, key=lambda item: (item[0], item[1].line, item[1].column))
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
