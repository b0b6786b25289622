"""``diagnose`` on a campaign of a whole hexapod: options, work, answer."""

from __future__ import annotations

import argparse
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hexathermal.errors import ArgumentError
from hexathermal.show.commands import Answer, Progress, Writing
from hexathermal.show.hexapod_answers import LARGEST_PROPOSAL, own_machine
from hexathermal.show.options import machine, whole
from hexathermal.show.outputs import machine_place

if TYPE_CHECKING:
    from hexathermal.learn.campaign import Campaign
    from hexathermal.learn.machine_diagnosis.planning import MachineExperiment
    from hexathermal.learn.machine_diagnosis.result import MachineDiagnosis

LAWS = {"keep": "kept", "refit": "refit"}
FEWEST_POSES, USUAL_POSES = 6, 40
"""Of a plan: at least, and in a report where no number was asked for."""

OF_LEGS, OF_MACHINES = ("sensors", "law"), ("laws", "propose", "machine")
"""Options that only one kind of campaign takes."""

DIAGNOSE_HEXAPOD = """\
A campaign of kind hexapod (6-D measurements of the platform alone) is held against its machine: which leg, which plate,
which joint, which plugs, the payload, or the measuring frame; eight causes at every place, and those of a single leg.
"""

EPILOG_DIAGNOSE = """\
causes of a whole hexapod:
  of legs             leg-coefficient, leg-backlash, swapped-legs, and the causes of one leg that poses can show;
                      with several thermometers a leg missing-sensor and swapped-sensors too
  of plates, joints   platform-expansion, base-expansion, joint-offset
  of the load         payload-compliance
  of the measurement  tracker-drift

For a hexapod --extend writes a hexapod.toml, which 'correct', 'validate', 'budget' take as it is. --report adds the
poses of the next experiment, where something is to be told apart: poses-run-1.csv, experiment.json.
"""


def add_machine_options(one: argparse.ArgumentParser) -> None:
    """Declare what ``diagnose`` accepts for hexapod campaigns."""
    group = one.add_argument_group("for a campaign of kind hexapod")
    group.add_argument("--laws", choices=tuple(LAWS),
                       help="laws of the legs: those of the machine, within the uncertainty they state (keep, "
                       "default), or fitted anew beside every cause (refit)")  # fmt: skip
    group.add_argument("--propose", type=whole(FEWEST_POSES, LARGEST_PROPOSAL), metavar="N",
                       help="the N poses and temperatures of a next run that tell open names apart best")  # fmt: skip
    group.add_argument(
        "--machine",
        metavar="NAME",
        help="another machine than the campaign's: a bundled one, a hexapod.toml or its folder",
    )


def refuse_other_kind(arguments: argparse.Namespace, hexapod: bool) -> None:
    """Refuse options of the other kind of campaign, before any work."""
    given = [name for name in (OF_LEGS if hexapod else OF_MACHINES) if getattr(arguments, name) is not None]
    if not given:
        return
    said = " and ".join(f"--{name}" for name in given)
    if hexapod:
        raise ArgumentError(
            f"{said} {'is' if len(given) == 1 else 'are'} for a campaign of one leg or component; this one is of kind "
            "'hexapod': its legs have the laws of its hexapod.toml; give --laws, or another machine by --machine"
        )
    raise ArgumentError(
        f"{said} {'is' if len(given) == 1 else 'are'} for a campaign of kind 'hexapod'; this one is of a leg or a "
        "component: give --sensors or --law"
    )


def diagnose_answer(arguments: argparse.Namespace, progress: Progress) -> Answer:
    """Diagnose a whole machine."""
    from hexathermal.learn.campaign_files import load_campaign
    from hexathermal.learn.machine_diagnosis.diagnosing import diagnose_machine
    from hexathermal.machine.writing import write_hexapod
    from hexathermal.show.machine_report import write_machine_report
    from hexathermal.show.machine_tables import machine_facts
    from hexathermal.show.machine_words import cautions, changed
    from hexathermal.show.report_folder import refuse_foreign

    refuse_other_kind(arguments, True)
    if arguments.report is not None:
        refuse_foreign(arguments.report, arguments.force)
    if arguments.extend is not None:
        _refuse_own_machine(arguments)
    hexapod = None if arguments.machine is None else machine(arguments.machine)
    laws = LAWS[arguments.laws or "keep"]
    campaign = load_campaign(arguments.campaign, needed=("identification",), progress=progress)
    found = diagnose_machine(campaign, hexapod=hexapod, laws=laws, progress=progress)
    warnings = list[str]()
    plan = _planned(arguments, campaign, found, laws, warnings, progress)
    facts, writing = machine_facts(found, plan), Writing()
    if arguments.report is not None:
        report = partial(write_machine_report, found, campaign, plan, facts, arguments.report, progress,
                         force=arguments.force)  # fmt: skip
        writing.into(arguments.report, report)
    if arguments.extend is not None:
        made = writing.into(arguments.extend, lambda: [write_hexapod(found.extended, arguments.extend)])
        if made and not changed(found):
            warnings.append(f"warning: nothing joined the machine: {arguments.extend} holds it as it was")
        warnings += [f"warning: {words}" for words in cautions(found)]
    facts["written"] = writing.names
    shown = _shown(found, plan if arguments.propose is not None else None, arguments.report is None)
    return Answer((*shown, *writing.words), facts, (*warnings, *writing.lost), code=writing.code)


def _refuse_own_machine(arguments: argparse.Namespace) -> None:
    """Refuse to write over the machine that is read, or one that exists."""
    from hexathermal.machine.writing import machine_file

    file = machine_file(arguments.extend)
    read = {own_machine(arguments.campaign)}
    if arguments.machine is not None and Path(arguments.machine).exists():
        other = Path(arguments.machine)
        read.add((other / "hexapod.toml" if other.is_dir() else other).resolve())
    if file.resolve() in read:
        raise ArgumentError(f"--extend {file} is the machine that is read; give another place for the extended one")
    machine_place(arguments.extend, "--extend", arguments.force)


def _planned(
    arguments: argparse.Namespace, campaign: Campaign, found: MachineDiagnosis, laws: str, warnings: list[str],
    progress: Progress,
) -> MachineExperiment | None:  # fmt: skip
    """Return the next experiment where it is asked for, or where a report is written; None where nothing is open."""
    from hexathermal.learn.machine_proposal import propose_experiment

    if arguments.propose is None and arguments.report is None:
        return None
    progress(0, 0, "designing the next experiment")
    try:
        return propose_experiment(campaign, found, arguments.propose or USUAL_POSES, laws=laws)
    except ArgumentError as error:
        if arguments.propose is not None:
            warnings.append(f"warning: no poses are proposed: {error}")
        return None


def _shown(found: MachineDiagnosis, plan: MachineExperiment | None, poses: bool) -> list[Any]:
    """Return texts and tables, the finding first; poses of a plan where they stand in no file."""
    from hexathermal.show import machine_tables as tables
    from hexathermal.show.machine_limits import LIMITS_WORDS
    from hexathermal.show.machine_words import changed, gain_words, sentences

    shown: list[Any] = ["\n".join(sentences(found)), _summary(found)]
    if found.effects:
        shown.append(lambda pretty, _: tables.effects_table(found, pretty))
    shown.append(lambda pretty, _: tables.ranking_table(found, pretty))
    if found.gain is not None and changed(found):
        shown.append(lambda pretty, _: tables.gain_table(found, pretty))
    shown.append(gain_words(found))
    if found.limits:
        shown += [lambda pretty, _: tables.limits_table(found, pretty), LIMITS_WORDS]
    if found.alike:
        shown.append("These poses and temperatures cannot tell apart:\n" + "\n".join(f"  {one}" for one in found.alike))
    if found.advice:
        shown.append("next:\n" + "\n".join(f"  for {one.purpose}: {one.words}" for one in found.advice))
    if plan is None:
        shown += [f"Planned: {one.words}." for one in found.experiments]
    if plan is not None:
        shown += [f"Planned: {plan.words}.", lambda pretty, _: tables.promises_table(plan, pretty)]
    if plan is not None and poses:
        shown.append(lambda pretty, _: tables.poses_table(plan, pretty))
        if len(plan.coordinates) > tables.MOST_POSES:
            shown.append(f"{len(plan.coordinates) - tables.MOST_POSES} more: --report writes all of them into a file.")
    return shown


def _summary(found: MachineDiagnosis) -> str:
    """Return what stands around the finding, in words."""
    from hexathermal.show.machine_words import noise_words, notes_of
    from hexathermal.show.shares import probability

    poses = sum(len(run.time) for run in found.residuals if run.role == "identification")
    notes, bench = notes_of(found)
    lines = [
        f"Campaign {found.title or 'without a title'}, machine {found.hexapod.name or 'without a name'}: "
        f"{poses} poses searched; probability of the verdict '{found.verdict}' {probability(found.probability)}; "
        f"a name needed a log evidence of {found.threshold:.1f}.",
        noise_words(found),
    ]
    if found.effects and found.follows:
        lines.append(f"Besides, something is left that {found.follows}.")
    lines += [f"note: {note}" for note in notes]
    if bench:
        names = ", ".join(one.partition(":")[0] for one in bench)
        lines.append(f"note: these runs cannot show {names}; the report says which measurement would")
    return "\n".join(lines)
