"""The report of a diagnosis: a folder with one page for people, its pictures, and the numbers."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from hexathermal.learn.diagnosis.result import Diagnosis
from hexathermal.predict.table_writing import written_folder
from hexathermal.show import diagnosis_album as album
from hexathermal.show import diagnosis_sections as sections
from hexathermal.show.commands import Progress
from hexathermal.show.diagnosis_page import page
from hexathermal.show.diagnosis_pictures import Picture
from hexathermal.show.diagnosis_words import sentences
from hexathermal.show.report_folder import END, FILES, NUMBERS, PAGE, files_of_earlier, remove_stale


def report_page(found: Diagnosis, drawn: dict[str, str]) -> str:
    """Return the page of a diagnosis.

    Parameters
    ----------
    found : Diagnosis
    drawn : dict of str to str
        HTML of the pictures of each section.
    """
    title = found.title or "campaign without a title"
    return page(
        f"Diagnosis: {title}", f"Diagnosis of {title}, law of {' + '.join(found.law.sensors)}", sentences(found)[0],
        sections.opening(found), sections.all_sections(found, drawn),
        END,
    )  # fmt: skip


def write_report(
    found: Diagnosis, facts: dict[str, Any], folder: Path, progress: Progress, *, force: bool = False
) -> list[Path]:
    """Write the page, its pictures and the numbers into a folder, all or none; returns the paths.

    Parameters
    ----------
    found : Diagnosis
    facts : dict
        The diagnosis as plain values, see `hexathermal.show.diagnosis_tables.diagnosis_facts`.
    folder : Path
    progress : function
        Called as ``progress(done, total, label)``.
    force : bool
        Pictures that others drew may be replaced.

    Raises
    ------
    ArgumentError
        The folder is none, or cannot be made.
    FileExistsError
        It holds a picture that others drew.
    """
    return write_pages(album.pictures_of(found), lambda drawn: report_page(found, drawn), facts, folder, progress,
                       force=force)  # fmt: skip


def write_pages(
    pictures: Mapping[str, Sequence[Picture]], page_of: Callable[[dict[str, str]], str], facts: dict[str, Any],
    folder: Path, progress: Progress, beside: Callable[[Path], Sequence[Path]] | None = None, *, force: bool = False,
) -> list[Path]:  # fmt: skip
    """Write a page with pictures by section, and its numbers, into a folder, all or none; returns the paths.

    The files of an earlier report in that folder are replaced or removed, all others stay.

    Parameters
    ----------
    pictures : mapping of str to sequence of Picture
    page_of : function
        From the HTML of each section's pictures to the page.
    facts : dict
    folder : Path
    progress : function
        Called as ``progress(done, total, label)``.
    beside : function, optional
        Writes further files into a folder and returns their paths.
    force : bool
        Pictures that others drew may be replaced.

    Raises
    ------
    ArgumentError
        The folder is none, or cannot be made.
    """
    earlier = files_of_earlier(folder)
    total = sum(len(group) for group in pictures.values())
    with written_folder(folder, force=force) as part:
        files, drawn = [part / PAGE], dict[str, str]()
        for name, group in pictures.items():
            drawn[name] = ""
            for one in group:
                progress(len(files) - 1, total, "drawing")
                files.append(part / f"{one.name}.png")
                drawn[name] += one.drawn(files[-1])
        files[0].write_text(page_of(drawn), encoding="utf-8")
        files += beside(part) if beside is not None else ()
        files.append(part / NUMBERS)
        names = [file.name for file in files]
        told = {**facts, FILES: names}
        files[-1].write_text(json.dumps(told, indent=2, allow_nan=False) + "\n", encoding="utf-8")
    remove_stale(folder, earlier, names)
    return [folder / file.name for file in files]
