"""The report of a machine's diagnosis: a folder with one page for people, its pictures, numbers, and planned poses."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from hexathermal.learn.campaign import Campaign
from hexathermal.learn.machine_diagnosis.plan_files import write_experiment
from hexathermal.learn.machine_diagnosis.planning import MachineExperiment
from hexathermal.learn.machine_diagnosis.result import MachineDiagnosis
from hexathermal.show import machine_sections as sections
from hexathermal.show.commands import Progress
from hexathermal.show.diagnosis_page import page
from hexathermal.show.diagnosis_report import write_pages
from hexathermal.show.machine_album import pictures_of
from hexathermal.show.machine_words import sentences
from hexathermal.show.report_folder import END


def machine_page(found: MachineDiagnosis, drawn: dict[str, str], plan: MachineExperiment | None) -> str:
    """Return the page of a machine's diagnosis.

    Parameters
    ----------
    found : MachineDiagnosis
    drawn : dict of str to str
        HTML of the pictures of each section.
    plan : MachineExperiment or None
    """
    title = found.title or "campaign without a title"
    machine = f", machine {found.hexapod.name}" if found.hexapod.name else ""
    return page(
        f"Diagnosis: {title}", f"Diagnosis of {title}{machine}", sentences(found)[0], sections.opening(found),
        sections.all_sections(found, drawn, plan),
        END,
    )  # fmt: skip


def write_machine_report(
    found: MachineDiagnosis, campaign: Campaign, plan: MachineExperiment | None, facts: dict[str, Any], folder: Path,
    progress: Progress, *, force: bool = False,
) -> list[Path]:  # fmt: skip
    """Write page, pictures, numbers and planned poses into a folder, all or none; returns the paths.

    Parameters
    ----------
    found : MachineDiagnosis
    campaign : Campaign
        That was diagnosed: what the residual is held against.
    plan : MachineExperiment or None
    facts : dict
        The diagnosis as plain values.
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
    return write_pages(
        pictures_of(found, campaign, plan), lambda drawn: machine_page(found, drawn, plan), facts, folder, progress,
        beside=None if plan is None else lambda part: write_experiment(plan, part), force=force,
    )  # fmt: skip
