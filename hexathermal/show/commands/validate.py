"""``hexathermal validate``: a law on runs that were never fitted."""

from __future__ import annotations

import argparse
import json
import tomllib
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hexathermal.errors import ArgumentError
from hexathermal.show.commands import Answer, Progress, Writing
from hexathermal.show.hexapod_answers import EPILOG_VALIDATE, is_hexapod_campaign, validate_answer
from hexathermal.show.options import CAMPAIGN, EXIT_CODES, STYLE, path

if TYPE_CHECKING:
    from hexathermal.learn.campaign import Campaign
    from hexathermal.learn.law import IdentifiedLaw
    from hexathermal.learn.validation import Validation
    from hexathermal.learn.validation_gain import Gain

VALIDATE = """\
Predict the campaign's runs with role "validation", which no law was fitted to, and compare with what was measured:
residuals, by how much the drift shrinks (with intervals), how many rows lie inside their 95 % prediction interval.
"""

EPILOG = f"""\
The verdict is one of: makes it better; no gain proven; makes it worse; nothing proven, every run was fitted. It does
not change the exit code. Runs that were fitted are known by their rows, whatever their name: they are warned of, and do
not count in the verdict and in the row "all".

A law may be extended by named terms: all rows of a run are then run through, since lags and stored heat depend on
those of movements too, and the usable ones are scored. --before tells how much better the law is than another one, on
the same rows.

files of --report DIR:
  RUN.png, RUN.svg    each run: rod and temperature above; measured, predicted drift and residual below
  validation.json     everything as numbers

{EPILOG_VALIDATE}
examples:
  hexathermal validate leg.toml my-campaign
  hexathermal validate my-machine hexapod-campaign --report report
  hexathermal validate extended.toml my-campaign --before leg.toml
  hexathermal validate leg.toml my-campaign --report report --json validation.json

{EXIT_CODES}"""


def add(commands: Any) -> None:
    """Declare the command."""
    one = commands.add_parser("validate", help="a law on runs that were never fitted", description=VALIDATE,
                              epilog=EPILOG, **STYLE)  # fmt: skip
    one.add_argument("law", type=path, metavar="LAW", help="leg.toml, as 'identify' writes it; for a hexapod a machine")
    one.add_argument("campaign", **CAMPAIGN)
    one.add_argument(
        "--report",
        type=path,
        metavar="DIR",
        help="write pictures into this folder, which is created; earlier ones are replaced",
    )
    one.add_argument("--before", type=path, metavar="LAW", help="another leg.toml: tell the gain over it")


def run(arguments: argparse.Namespace, progress: Progress) -> Answer:
    """Validate a law."""
    from hexathermal.learn.campaign_files import load_campaign
    from hexathermal.learn.campaign_laws import validate_campaign
    from hexathermal.learn.leg_law_files import read_leg_law
    from hexathermal.learn.validation_gain import gain
    from hexathermal.predict.table_writing import refuse_no_place
    from hexathermal.show.identification_tables import gain_facts, gain_table, validation_facts, validation_table

    if arguments.report is not None:
        refuse_no_place(arguments.report)
    if is_hexapod_campaign(arguments.campaign):
        if arguments.before is not None:
            raise ArgumentError("--before compares laws of a leg or a component; this campaign is of a whole hexapod")
        if _format(arguments.law) == "hexathermal-leg/1":
            raise ArgumentError(
                f"{arguments.law} is the law of one leg, the campaign is of a whole hexapod: give a machine, as "
                "'hexathermal identify' or 'hexathermal apply' writes it"
            )
        return validate_answer(arguments, progress)
    if (arguments.law / "hexapod.toml").is_file() or _format(arguments.law) == "hexathermal-hexapod/1":
        raise ArgumentError(
            f"{arguments.law} is a machine, the campaign is of one leg or component: give a leg.toml, as 'hexathermal "
            "identify' writes it"
        )
    law = read_leg_law(arguments.law)
    before = None if arguments.before is None else read_leg_law(arguments.before)
    campaign = load_campaign(arguments.campaign, needed=("validation",), progress=progress)
    found = validate_campaign(law, campaign, progress)
    warnings = [*_fitted(found), *_doubts(law, campaign)]
    facts = validation_facts(found) | {"law": _law_facts(law)}
    writing = Writing()
    if arguments.report is not None:
        writing.into(arguments.report, lambda: _report(found, law, facts, arguments.report, progress))
    texts: list[Any] = [*_extended(law), lambda pretty, _: validation_table(found, pretty), _summary(found)]
    if before is not None:
        better = gain(validate_campaign(before, campaign, progress), found)
        facts["gain"] = gain_facts(better)
        texts += [lambda pretty, _: gain_table(better, pretty), _gain(better)]
    return Answer((*texts, *writing.words), facts, (*warnings, *writing.lost), code=writing.code)


def _format(file: Path) -> str:
    """Return which format a TOML file says it has; nothing where it is none, which is judged elsewhere."""
    try:
        return str(tomllib.loads(file.read_text(encoding="utf-8-sig")).get("format", "")) if file.is_file() else ""
    except (OSError, ValueError):
        return ""


def _law_facts(law: IdentifiedLaw) -> dict[str, Any]:
    """Return what the law is, as plain values."""
    facts: dict[str, Any] = {"sensors": list(law.sensors), "title": law.origin.title}
    if law.extended:
        facts |= {"terms": [term.cause for term in law.terms], "repairs": [one.cause for one in law.repairs]}
    return facts


def _extended(law: IdentifiedLaw) -> list[str]:
    """Return by what the law is extended, in words."""
    terms = dict.fromkeys(term.cause for term in law.terms)
    repairs = dict.fromkeys(one.cause for one in law.repairs)
    said = [f"The law is extended by {', '.join(terms)}."] if terms else []
    return [*said, *([f"Data are put right first: {', '.join(repairs)}."] if repairs else [])]


def _gain(found: Gain) -> str:
    """Return what the law gains over the one before, in words."""
    from hexathermal.show.shares import proven

    one = found.total
    sure = proven(one.rmse_gain)
    skipped = f"\nnot compared, rows differ: {', '.join(found.skipped)}" if found.skipped else ""
    return (
        f"Gain over the law before: RMSE {one.rmse_before * 1e6:z.3f} -> {one.rmse_after.value * 1e6:z.3f} um "
        f"({_less(one.rmse_gain.value)}, {sure}), largest residual {one.linf_before * 1e6:z.2f} -> "
        f"{one.linf_after.value * 1e6:z.2f} um.{skipped}"
    )


def _fitted(found: Validation) -> list[str]:
    """Return warnings about runs that were fitted."""
    return [
        f"warning: run {name} was fitted: the law was identified on its rows, then named {before}; it proves nothing"
        for name, before in found.fitted.items()
    ]


def _doubts(law: IdentifiedLaw, campaign: Campaign) -> list[str]:
    """Return warnings about a law that meets another leg, or whose repairs are of another campaign."""
    from hexathermal.learn.campaign_dataset import fingerprint

    leg, others = campaign.leg, list[str]()
    if law.repairs and law.origin.fingerprint and law.origin.fingerprint != fingerprint(campaign):
        names = ", ".join(dict.fromkeys(one.cause for one in law.repairs))
        others = [
            f"warning: the law puts data right for faults of the campaign {law.origin.title!r} ({names}); these files "
            "are others: where their runs have the same names, they are changed as well. If the fault is not theirs, "
            "give the law before it was extended, or diagnose this campaign"
        ]
    if leg is None or law.retracted_length is None or abs(leg.retracted_length - law.retracted_length) < 1e-6:
        return others
    return [
        *others,
        f"warning: the law was identified on a leg of q0 = {law.retracted_length * 1e3:g} mm, this one has "
        f"{leg.retracted_length * 1e3:g} mm; the law's own q0 is used",
    ]


def _summary(found: Validation) -> str:
    """Return the verdict, in words."""
    total = found.total
    lines = [
        f"Verdict: {'the law ' if found.verdict.name in ('BETTER', 'WORSE') else ''}{found.verdict.value}.",
        f"Largest drift {total.drift_largest * 1e6:z.2f} um -> largest residual {total.linf.value * 1e6:z.2f} um "
        f"({_less(total.largest_reduction.value)}); mean {total.drift_mean * 1e6:z.2f} -> "
        f"{total.mean.value * 1e6:z.2f} um ({_less(total.mean_reduction.value)}).",
        f"{100.0 * found.coverage:z.1f} % of {found.rows} rows lie inside their 95 % prediction interval.",
    ]
    lines += [f"note: {note}" for note in found.notes]
    return "\n".join(lines)


def _less(reduction: float) -> str:
    """Return a reduction in words."""
    return f"{abs(100.0 * reduction):z.1f} % {'less' if reduction >= 0.0 else 'more'}"


def _report(
    found: Validation, law: IdentifiedLaw, facts: dict[str, Any], folder: Path, progress: Progress
) -> list[Path]:
    """Write pictures and numbers, all or none; returns their paths."""
    from hexathermal.predict.table_writing import written_folder
    from hexathermal.show.identification_figures import save_both, validation_figure

    with written_folder(folder) as part:
        files: list[Path] = []
        for k, curves in enumerate(found.curves):
            progress(k, len(found.curves), "drawing")
            name = "".join(letter if letter.isalnum() or letter in "-_." else "_" for letter in curves.run)
            files += save_both(validation_figure(found, curves, law.sensors), part, name)
        files.append(part / "validation.json")
        files[-1].write_text(json.dumps(facts, indent=2, allow_nan=False) + "\n", encoding="utf-8")
    return [folder / file.name for file in files]
