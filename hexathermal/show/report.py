"""What a report is of, by what lies in a folder; and the report of it.

A folder with ``campaign.toml`` is a measured campaign, with ``hexapod.toml`` a machine, with ``diagnosis.json`` what
``diagnose --report`` wrote, with ``budget.csv`` what ``budget --out`` wrote; a JSON file is what ``budget --json`` or
``diagnose --json`` wrote, told apart by its ``format``; a name is a bundled machine.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hexathermal.errors import ArgumentError, FileFormatError, Problem, UnknownNameError
from hexathermal.machine.library import bundled_hexapods, refuse_two_meanings, unmistakable

if TYPE_CHECKING:
    from hexathermal.show.report_page import Report

KINDS = {
    "campaign.toml": "campaign",
    "hexapod.toml": "machine",
    "diagnosis.json": "diagnosis",
    "budget.csv": "budget",
}
"""What a folder is of, by a file in it."""

FORMATS = {"hexathermal-budget/1": "budget", "hexathermal-diagnosis/1": "diagnosis"}
"""What a JSON file is of, by its format."""

LOOKED_FOR = (
    "a folder with campaign.toml (a measured campaign), hexapod.toml (a machine), diagnosis.json (of 'diagnose "
    "--report') or budget.csv (of 'budget --out'); a file of 'budget --json' or 'diagnose --json'; or the name of a "
    "bundled machine"
)

Progress = Callable[[int, int, str], None]


@dataclass(frozen=True)
class Subject:
    """What a report is of.

    Attributes
    ----------
    kind : str
        ``"campaign"``, ``"machine"``, ``"diagnosis"`` or ``"budget"``.
    place : Path
        The folder or file; of a bundled machine its name.
    """

    kind: str
    place: Path


def subject_of(place: str) -> Subject:
    """Return what lies at a place.

    Parameters
    ----------
    place : str
        A folder, a file in it, or the name of a bundled machine.

    Raises
    ------
    ArgumentError
        There is nothing of which a report could be, or more than one thing; or a name has two meanings.
    UnknownNameError
        Neither a place nor a bundled machine.
    FileFormatError
        A JSON file is none, or of another format.

    Examples
    --------
    >>> subject_of("reference").kind
    'machine'
    """
    path = Path(place)
    refuse_two_meanings(place)
    if not path.exists():
        if place in bundled_hexapods():
            return Subject("machine", path)
        raise UnknownNameError(f"there is nothing at {place!r}; looked for {LOOKED_FOR}", tuple(bundled_hexapods()))
    if path.is_dir():
        return _of_folder(path)
    if path.name in KINDS and path.suffix != ".json":
        return Subject(KINDS[path.name], path.resolve().parent)
    if path.is_file() and path.suffix.lower() == ".json":
        return Subject(FORMATS[read_json(path)["format"]], path)
    raise ArgumentError(f"cannot tell what {place} is; looked for {LOOKED_FOR}")


def _of_folder(folder: Path) -> Subject:
    """Return what lies in a folder."""
    found = [name for name in KINDS if (folder / name).is_file()]
    # a campaign of a whole hexapod brings its machine with it; so does what was diagnosed
    if found[:2] == ["campaign.toml", "hexapod.toml"]:
        found.remove("hexapod.toml")
    if len(found) == 1:
        return Subject(KINDS[found[0]], folder)
    if found:
        raise ArgumentError(
            f"{folder} holds {', '.join(found)}: unclear which of them the report is of; give one of the files, "
            "or move them apart"
        )
    raise ArgumentError(f"{folder} holds nothing that a report can be of; looked for {LOOKED_FOR}")


def read_json(file: Path) -> dict[str, Any]:
    """Return an answer of the command line that was written as JSON.

    Raises
    ------
    FileFormatError
        It is no JSON, or of a format that no report is of.
    """
    try:
        found = json.loads(file.read_text(encoding="utf-8-sig"))
    except json.JSONDecodeError as error:
        raise FileFormatError(str(file), (Problem(error.lineno, error.colno, f"no JSON: {error.msg}"),)) from None
    except UnicodeDecodeError:
        raise FileFormatError(str(file), (Problem(1, 1, "no text in UTF-8"),)) from None
    told = found.get("format") if isinstance(found, dict) else None
    if told not in FORMATS:
        raise FileFormatError(str(file), (Problem(1, 1, (
            f"{'it names no format' if told is None else f'the format is {told!r}'}; a report is made of "
            f"{' or '.join(FORMATS)}: what 'budget --json' or 'diagnose --json' writes"
        )),))  # fmt: skip
    answer: dict[str, Any] = found
    return answer


def report_of(subject: Subject, law: Path | str | None, progress: Progress) -> Report:
    """Return the report of a subject.

    Parameters
    ----------
    subject : Subject
    law : Path or str, optional
        Of a campaign: the law that is held against it, leg.toml, or a machine for a whole hexapod.
    progress : callable
        Called as ``progress(done, total, label)``.

    Raises
    ------
    ArgumentError
        A law is given for something else than a campaign.
    """
    if law is not None and subject.kind != "campaign":
        raise ArgumentError(f"--law is held against a measured campaign; {subject.place} is a {subject.kind}")
    if subject.kind == "campaign":
        return _campaign(subject.place, law, progress)
    if subject.kind == "machine":
        from hexathermal.show.options import machine
        from hexathermal.show.report_machine import machine_report

        named = unmistakable(subject.place) if subject.place.exists() else str(subject.place)
        return machine_report(machine(named), str(subject.place), progress)
    if subject.kind == "budget":
        from hexathermal.show.report_budget import budget_report, read_budget

        return budget_report(read_budget(subject.place), subject.place)
    from hexathermal.show.report_diagnosis import diagnosis_report

    file = subject.place / "diagnosis.json" if subject.place.is_dir() else subject.place
    return diagnosis_report(read_json(file), subject.place)


def _campaign(place: Path, law: Path | str | None, progress: Progress) -> Report:
    """Return the report of a campaign."""
    from hexathermal.learn.campaign_files import load_campaign
    from hexathermal.learn.leg_law_files import read_leg_law
    from hexathermal.show.report_campaign import campaign_report
    from hexathermal.show.report_hexapod import hexapod_report

    campaign = load_campaign(place, progress=progress)
    if campaign.kind == "hexapod":
        _refuse_leg_law(law)
        return hexapod_report(campaign, None if law is None else str(law), progress)
    return campaign_report(campaign, None if law is None else read_leg_law(Path(law)), progress)


def _refuse_leg_law(law: Path | str | None) -> None:
    """Refuse the law of one leg where the law of a machine is wanted."""
    if law is None or not Path(law).is_file():
        return
    if b"hexathermal-leg/" in Path(law).read_bytes()[:200]:
        raise ArgumentError(
            f"{law} is the law of a leg; a campaign of a whole hexapod takes a machine: "
            f"'hexathermal apply {law} --machine NAME --out DIR' makes one, then --law DIR"
        )
