"""``hexathermal diagnose``: what a law gets wrong on measurements, why, and the law extended by it."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hexathermal.errors import ArgumentError
from hexathermal.show.commands import Answer, Progress, Writing
from hexathermal.show.hexapod_answers import is_hexapod_campaign
from hexathermal.show.machine_answers import (
    DIAGNOSE_HEXAPOD,
    EPILOG_DIAGNOSE,
    add_machine_options,
    diagnose_answer,
    refuse_other_kind,
)
from hexathermal.show.options import CAMPAIGN, EXIT_CODES, STYLE, path, sensor_names
from hexathermal.show.outputs import law_place

if TYPE_CHECKING:
    from hexathermal.learn.campaign import Campaign
    from hexathermal.learn.diagnosis.result import Diagnosis
    from hexathermal.learn.law import IdentifiedLaw

DIAGNOSE = f"""\
What does the law of a leg get wrong, and why? Seventeen causes are tried on what the law leaves of the campaign's runs
for identification. The one that these data demand, above all that chance could do, is named; it joins the law if it
foretells runs left out; and the search goes on. Runs for validation tell what that gains, and whether the zero jumps
there; what makes them be foretold worse stays out of the law.

{DIAGNOSE_HEXAPOD}
The first line is the finding, one of these:
  The residual is CAUSE ...              named, with its size, interval and probability
  No effect ... stands above X um        the law explains these data to their noise; X for each cause in a table
  None above X um / Y urad               the same of a whole hexapod: the largest that could hide
  Something real is left that follows ...   but no cause of the catalogue explains it
"""

EPILOG = f"""\
causes:
  of the leg          thermal-lag, missing-sensor, hidden-heat, nonlinear-expansion, backlash, creep,
                      periodic-screw-error, scale-error
  of the bench        frame-expansion, air-refraction, abbe-tilt, zero-drift, zero-jump
  of the thermometers clock-offset, sensor-drift, sensor-detached, swapped-sensors

{EPILOG_DIAGNOSE}
what the tables say:
  residual      what was measured less what the law foretells
  visible RMS   what stays of an effect when the law is fitted again; only that can be seen in a residual
  evidence      logarithm of how much more probable the data are with the cause than without; 2.3 is 10 to 1, 7 is
                1000 to 1. Named causes stand first, as they were found, each over what those before it left; of
                several thermometers the one is named that foretells runs left out best
  probability   of the name, with all others, none and something nameless as its rivals; of "none", that nothing of
                a quarter of the noise or more is there: the less these data can see, the lower
                What the names do not add up to is left for something without a name and for errors of the models
  not ruled out other names that these data leave a twentieth of its probability or more, or speak for about as much
                though errors of the thermometers might feign them: an experiment decides, it stands under "next"
  confuse       pairs of names that could be taken for each other here, were one twice as large as its limit

The law's sensors are those of --sensors or --law, else the one or two that these data speak for. Around a thermometer
that drifts or came off those are its sound neighbours: name the sensors of your law where you know them. Its
coefficients are always fitted again: an effect biases them. --extend writes the law with what joined it; it is used
like any other: 'validate', 'apply'. Where nothing joined, the law without terms is written, and stderr says so.

files of --report DIR:
  report.html       the whole diagnosis for people: pictures, tables, words; one file, opens without a network
  *.png             its pictures
  diagnosis.json    everything as numbers
Files of an earlier report in DIR are replaced or removed; all others stay.

examples:
  hexathermal diagnose my-campaign
  hexathermal diagnose my-campaign --sensors T07,T14 --report diagnosis --extend extended.toml
  hexathermal diagnose my-campaign --law leg.toml --json -
  hexathermal validate extended.toml my-campaign --before leg.toml
  hexathermal diagnose hexapod-campaign --report diagnosis --extend extended/hexapod.toml --propose 40
  hexathermal validate extended hexapod-campaign

{EXIT_CODES}"""


def add(commands: Any) -> None:
    """Declare the command."""
    one = commands.add_parser("diagnose", help="what a law gets wrong on a campaign, and why", description=DIAGNOSE,
                              epilog=EPILOG, **STYLE)  # fmt: skip
    one.add_argument("campaign", **CAMPAIGN)
    one.add_argument("--sensors", metavar="NAMES",
                     help="of the law: T07,T14 (default: the likeliest near those of 'identify')")  # fmt: skip
    one.add_argument("--law", type=path, metavar="FILE", help="leg.toml of 'identify': its sensors are taken")
    one.add_argument(
        "--extend", type=path, metavar="FILE", help="write the law with what was found in it: leg.toml, or hexapod.toml"
    )
    one.add_argument(
        "--report",
        type=path,
        metavar="DIR",
        help="write report.html and its pictures into this folder, which is created; an earlier report is replaced",
    )
    one.add_argument(
        "--force", action="store_true", help="overwrite an existing law or machine, or a page that no diagnosis wrote"
    )
    add_machine_options(one)


def run(arguments: argparse.Namespace, progress: Progress) -> Answer:
    """Diagnose a campaign."""
    from hexathermal.learn.campaign_files import load_campaign
    from hexathermal.learn.diagnosis import diagnose
    from hexathermal.learn.leg_law_files import read_leg_law, write_leg_law
    from hexathermal.show.diagnosis_tables import diagnosis_facts
    from hexathermal.show.diagnosis_words import changed
    from hexathermal.show.report_folder import refuse_foreign
    from hexathermal.show.shares import less

    if is_hexapod_campaign(arguments.campaign):
        return diagnose_answer(arguments, progress)
    names = _names(arguments)
    if arguments.report is not None:
        refuse_foreign(arguments.report, arguments.force)
    if arguments.extend is not None:
        _refuse_extended(arguments)
    law = None if arguments.law is None else read_leg_law(arguments.law)
    campaign = load_campaign(arguments.campaign, needed=("identification",), progress=progress)
    refuse_other_kind(arguments, False)
    _refuse_other_law(campaign, law)
    found = diagnose(campaign, names, law=law, progress=progress)
    facts, writing, warnings = diagnosis_facts(found), Writing(), list[str]()
    if arguments.report is not None:
        writing.into(arguments.report, lambda: _report(found, facts, arguments, progress))
    if arguments.extend is not None:
        made = writing.into(arguments.extend, lambda: [write_leg_law(found.extended, arguments.extend)])
        if made and not changed(found):
            warnings.append(
                f"warning: nothing joined the law: {arguments.extend} holds it without terms, fitted to these runs"
            )
        if made and found.gain is not None and (worse := found.gain.total.rmse_gain).high < 0.0:
            warnings.append(
                f"warning: on runs never fitted the extended law is worse, {less(worse)} of the RMSE: do not use "
                f"{arguments.extend} before the next campaign says otherwise"
            )
    warnings = [*(f"warning: {one}" for one in found.doubtful), *warnings]
    facts["written"] = writing.names
    return Answer((*_shown(found), *writing.words), facts, (*warnings, *writing.lost), code=writing.code)


def _names(arguments: argparse.Namespace) -> tuple[str, ...] | None:
    """Return the sensors that were named, None for those of a law or of `identify`."""
    if arguments.sensors is None:
        return None
    if arguments.law is not None:
        raise ArgumentError("--law brings its own sensors; give --sensors or --law, not both")
    names = sensor_names(arguments.sensors, "names with commas, as T07,T14")
    return None if names == ("auto",) else names


def _refuse_extended(arguments: argparse.Namespace) -> None:
    """Refuse a law file that exists, is read, or cannot be written, before any work is done."""
    from hexathermal.predict.table_writing import refuse_no_folder, target_of

    if str(arguments.extend) == "-":
        raise ArgumentError("--extend needs the name of a file, as extended.toml; only --json writes to stdout with -")
    law_place(arguments.extend, "--extend", arguments.force)
    if arguments.report is not None:
        report = arguments.report.resolve()
        if target_of(arguments.extend).parent in (report, *report.parents):
            return  # the report is written first, and its folder with it
    refuse_no_folder(arguments.extend)


def _refuse_other_law(campaign: Campaign, law: IdentifiedLaw | None) -> None:
    """Refuse a law of another kind, and one that is extended already."""
    if law is None:
        return
    if law.extended:
        names = dict.fromkeys([*(one.cause for one in law.terms), *(one.cause for one in law.repairs)])
        raise ArgumentError(
            f"the law is extended already, by {', '.join(names)}; all causes are looked for together, so give the law "
            f"before it was extended, or --sensors {','.join(law.sensors)}"
        )
    if law.kind != campaign.kind:
        raise ArgumentError(
            f"the law is of kind {law.kind!r}, the campaign of kind {campaign.kind!r}; give a law of this campaign, or "
            "leave --law out"
        )


def _shown(found: Diagnosis) -> list[Any]:
    """Return texts and tables, the finding first."""
    from hexathermal.show import diagnosis_tables as tables
    from hexathermal.show.diagnosis_gain import gain_words
    from hexathermal.show.diagnosis_words import changed, sentences
    from hexathermal.show.identification_tables import gain_table

    texts: list[Any] = ["\n".join(sentences(found)), _summary(found)]
    if found.effects:
        texts.append(lambda pretty, _: tables.effects_table(found, pretty))
    texts.append(lambda pretty, _: tables.ranking_table(found, pretty))
    texts += found.unnamed
    if found.gain is not None and changed(found):
        better = found.gain
        texts.append(lambda pretty, _: gain_table(better, pretty))
    texts.append(gain_words(found))
    texts += [lambda pretty, _: tables.limits_table(found, pretty)]
    if found.confusions:
        texts.append(lambda pretty, _: tables.confusions_table(found, pretty))
    if found.experiments:
        texts.append(lambda pretty, _: tables.experiments_table(found, pretty))
    return texts


def _summary(found: Diagnosis) -> str:
    """Return what stands around the finding, in words."""
    from hexathermal.show.diagnosis_tables import verdict_probability
    from hexathermal.show.diagnosis_words import noise_rows, unexplained_words

    noise = ", ".join(f"{name} {value * 1e6:.3f}" for name, value, _words in noise_rows(found))
    lines = [
        f"Campaign {found.title or 'without a title'}: law of {' + '.join(found.law.sensors)}; verdict "
        f"'{found.verdict}', {verdict_probability(found.verdict, len(found.effects), found.probability)}; a name "
        f"needed a log evidence of {found.threshold:.1f}.",
        f"Noise (um): {noise}.",
    ]
    if found.verdict == "unexplained":
        lines.append(unexplained_words(found))
    if found.effects and found.follows:
        lines.append(f"Besides, something without a name is left: it {found.follows}.")
    lines += [f"note: {note}" for note in found.notes if note not in found.doubtful]
    return "\n".join(lines)


def _report(found: Diagnosis, facts: dict[str, Any], arguments: argparse.Namespace, progress: Progress) -> list[Path]:
    """Write the report, all or nothing; returns the paths."""
    from hexathermal.show.diagnosis_report import write_report

    return write_report(found, facts, arguments.report, progress, force=arguments.force)
