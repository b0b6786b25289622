"""``hexathermal identify``: a measured campaign becomes a leg law."""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hexathermal.errors import ArgumentError
from hexathermal.show.commands import Answer, Progress, add_json
from hexathermal.show.hexapod_answers import (
    EPILOG_IDENTIFY,
    IDENTIFY_HEXAPOD,
    add_hexapod_options,
    identify_answer,
    is_hexapod_campaign,
)
from hexathermal.show.options import EXIT_CODES, STYLE, path

if TYPE_CHECKING:
    from hexathermal.learn.campaign import Block, Campaign
    from hexathermal.learn.identification import Identification

IDENTIFY = (
    """\
Which thermometers foretell the drift of a leg, and with which coefficients? Every single thermometer and every pair is
fitted to the campaign's runs for identification and judged on runs left out; the law of the chosen one is written with
its uncertainty and its range. Runs for validation are not touched.

  leg        drift = sum over sensors of  A q0 dT + B q dT     (q0 retracted length, q displacement of the rod)
  component  drift = sum over sensors of  C dT

"""
    + IDENTIFY_HEXAPOD
)

EPILOG = f"""\
--sensors auto takes one sensor, unless the best pair is better on runs left out by more than its uncertainty.
--common asks whether other legs can share the law: one law for all against one each, on runs left out. If it serves
all, the law that is written is fitted to the runs of all legs; else it is that of the first campaign.

files of --report DIR:
  sets.csv                      every set of sensors: RMSE, largest and mean residual, reductions, fitted and left out
  matrix-rmse.csv, -linf.csv    the two criteria of every pair; single sensors on the diagonal
  matrices.png, .svg            the same as pictures, brightest is best
  front.png, .svg               all sets, the Pareto front, and a zoom
  identification.json           everything as numbers

{EPILOG_IDENTIFY}
examples:
  hexathermal identify my-campaign --sensors auto --out leg.toml --report report
  hexathermal identify my-campaign --sensors T07,T14 --triples --json -
  hexathermal identify leg1 --common leg2 leg3 --sensors T07
  hexathermal identify hexapod-campaign --out my-machine --report report --propose 40

{EXIT_CODES}"""


def add(commands: Any) -> None:
    """Declare the command."""
    one = commands.add_parser("identify", help="a measured campaign becomes a leg law", description=IDENTIFY,
                              epilog=EPILOG, **STYLE)  # fmt: skip
    one.add_argument("campaign", type=path, metavar="CAMPAIGN", help="folder with campaign.toml")
    one.add_argument("--sensors", default="auto", metavar="NAMES", help="auto (default), or names with commas: T07,T14")
    one.add_argument("--triples", action="store_true", help="search sets of three sensors too")
    one.add_argument("--quads", action="store_true", help="search sets of three and of four sensors too")
    one.add_argument(
        "--material", metavar="NAME", help="of the fixed part, for the check of the result: invar, steel ..."
    )
    one.add_argument("--common", nargs="+", type=path, default=[], metavar="CAMPAIGN",
                     help="campaigns of other legs: can they share the law?")  # fmt: skip
    one.add_argument("--out", type=path, metavar="FILE", help="write the law: leg.toml")
    one.add_argument("--report", type=path, metavar="DIR", help="write tables and pictures into this folder")
    one.add_argument("--force", action="store_true", help="overwrite an existing law")
    add_hexapod_options(one)
    add_json(one)


def run(arguments: argparse.Namespace, progress: Progress) -> Answer:
    """Identify a law."""
    from hexathermal.learn.campaign_files import load_campaign
    from hexathermal.learn.leg_law_files import write_leg_law
    from hexathermal.show.identification_tables import identification_facts, law_table, sets_table

    if is_hexapod_campaign(arguments.campaign):
        return identify_answer(arguments, progress)
    if arguments.out is not None:
        free(arguments.out, arguments.force)
    campaign = load_campaign(arguments.campaign, needed=("identification",), progress=progress)
    found = identified(campaign, arguments, progress)
    facts = identification_facts(found)
    shared = ""
    if arguments.common:
        shared, pooled = _common(campaign, found, arguments, progress)
        found = pooled or found
        facts = identification_facts(found) | {"common": shared, "common_law_written": pooled is not None}
    written = [] if arguments.out is None else [write_leg_law(found.law, arguments.out)]
    if arguments.report is not None:
        progress(0, 0, "drawing")
        written += _report(found, facts, arguments.report)
    facts["written"] = [str(file) for file in written]
    texts = [_summary(campaign, found), lambda pretty, _: law_table(found, pretty),
             lambda pretty, _: sets_table(found, pretty)]  # fmt: skip
    if shared:
        texts.append(shared)
    if written:
        texts.append("Written:\n" + "\n".join(f"  {file}" for file in written))
    return Answer(tuple(texts), facts, tuple(f"warning: {text}" for text in found.warnings))


def free(file: Path, force: bool) -> None:
    """Refuse a result file that exists, or is none."""
    if file.exists() and not file.is_file():
        raise ArgumentError(f"{file} is a folder or a device; give the name of a file for --out")
    if file.exists() and not force:
        raise ArgumentError(f"{file} exists already; give another name, or --force to replace it")


def blocks_of(campaign: Campaign, role: str) -> Iterator[Block]:
    """Give the usable blocks of all runs of a role."""
    from hexathermal.learn.cleaning import usable_blocks

    for one in campaign.runs_of(role):
        yield from usable_blocks(campaign, one)


def identified(campaign: Campaign, arguments: argparse.Namespace, progress: Progress) -> Identification:
    """Return the identification of a campaign."""
    from hexathermal.learn.campaign_dataset import fingerprint
    from hexathermal.learn.identification import identify
    from hexathermal.learn.law import Origin

    if campaign.kind == "hexapod":
        raise ArgumentError("a campaign of kind 'hexapod' has no single drift; identify its legs one by one on a bench")
    if not campaign.sensors:
        raise ArgumentError("the campaign has no thermocouples, so there is nothing that a law could read")
    sizes = (1, 2, 3, 4) if arguments.quads else (1, 2, 3) if arguments.triples else (1, 2)
    return identify(
        lambda: blocks_of(campaign, "identification"), campaign.sensors, campaign.leg, wanted=arguments.sensors,
        sizes=sizes, zero=campaign.zero, origin=Origin(campaign.title, fingerprint(campaign)),
        material=arguments.material, positions=[one.position for one in campaign.thermocouples], progress=progress,
    )  # fmt: skip


def _common(
    campaign: Campaign, found: Identification, arguments: argparse.Namespace, progress: Progress
) -> tuple[str, Identification | None]:
    """Return in words whether several legs can share a law, and that law where they can."""
    from hexathermal.learn.campaign_files import load_campaign
    from hexathermal.learn.common import fit_common
    from hexathermal.learn.gram import columns_for, gather

    campaigns = [campaign]
    for place in arguments.common:
        other = load_campaign(place, needed=("identification",), progress=progress)
        if other.leg != campaign.leg:
            raise ArgumentError(
                f"{place} is of another kind, retracted length or stroke than {campaign.folder}: no common law"
            )
        campaigns.append(other)
    names = [f"{k + 1} ({one.title or one.folder.name})" for k, one in enumerate(campaigns)]
    legs = {names[0]: found.grams}
    for name, other in zip(names[1:], campaigns[1:], strict=True):
        legs[name] = gather(blocks_of(other, "identification"), columns_for(other.sensors, other.leg))
    result = fit_common(legs, found.law.sensors)
    lines = [f"One law for {len(legs)} legs: {result.reason}."]
    lines += [f"  {name}: RMSE left out {common * 1e6:.3f} um with the common law, {own * 1e6:.3f} um with its own"
              for name, (common, own) in result.by_leg.items()]  # fmt: skip
    if not result.use_common:
        lines.append(f"  the law above is that of leg {names[0]}; identify the other legs one by one")
        return "\n".join(lines), None
    lines.append("  the law above is fitted to the runs of all legs")
    return "\n".join(lines), _pooled(campaigns, names, found.law.sensors, arguments, progress)


def _pooled(
    campaigns: list[Campaign], names: list[str], sensors: tuple[str, ...], arguments: argparse.Namespace,
    progress: Progress,
) -> Identification:  # fmt: skip
    """Return the law of given sensors, fitted to the runs of several legs."""
    import hashlib

    from hexathermal.learn.campaign_dataset import fingerprint
    from hexathermal.learn.identification import identify
    from hexathermal.learn.law import Origin

    shared = [name for name in campaigns[0].sensors if all(name in one.sensors for one in campaigns)]

    def rows() -> Iterator[Block]:
        for name, one in zip(names, campaigns, strict=True):
            columns = [one.sensors.index(sensor) for sensor in shared]
            for block in blocks_of(one, "identification"):
                run = replace(block.run, name=f"{name}/{block.run.name}")
                yield replace(block, run=run, dT=block.dT[:, columns])

    together = hashlib.sha256("".join(map(fingerprint, campaigns)).encode()).hexdigest()
    title = ", ".join(one.title or one.folder.name for one in campaigns)
    origin = Origin(title, together)
    return identify(rows, shared, campaigns[0].leg, wanted=sensors, zero=campaigns[0].zero, origin=origin,
                    material=arguments.material, progress=progress)  # fmt: skip


def _summary(campaign: Campaign, found: Identification) -> str:
    """Return what was found, in words."""
    grams, choice, ranked = found.grams, found.choice, found.ranked
    lines = [
        f"Campaign {campaign.title or campaign.folder.name}: {len(grams.runs)} runs for identification, "
        f"{int(grams.rows.sum())} rows, {len(grams.kept)} sensors, {len(ranked.names)} sets of sensors.",
        f"Chosen: {' + '.join(choice.sensors)} - {choice.reason}.",
    ]
    if choice.nested_rmse == choice.nested_rmse:
        lines.append(
            f"The whole search on runs left out of it: RMSE {choice.nested_rmse * 1e6:.3f} um (expected of new runs)."
        )
    off = ranked.off_front(ranked.best(1, left_out=False))
    lines.append(
        f"Best single sensor {ranked.names[ranked.best(1, left_out=False)][0]}: {off[0] * 1e6:.3f} um (RMSE) and "
        f"{off[1] * 1e6:.3f} um (largest residual) off the best of the Pareto front."
    )
    if found.check is not None:
        like = ", ".join(found.check.like) or "no common material"
        lines.append(
            f"Effective expansion of the fixed part {found.check.expansion * 1e6:.2f} +- "
            f"{1.96 * found.check.expansion_uncertainty * 1e6:.2f} um/m/K (95 %): like {like}."
        )
    lines.append(
        f"Reliability of the temperatures {found.fit.reliability:.3f} (1: no error of the thermometers); "
        f"{'corrected for' if found.fit.corrected else 'not corrected for'}."
    )
    lines += [f"note: {note}" for note in found.notes]
    return "\n".join(lines)


def _report(found: Identification, facts: dict[str, Any], folder: Path) -> list[Path]:
    """Write tables and pictures; returns their paths."""
    from hexathermal.predict.table_writing import written_whole
    from hexathermal.show.identification_figures import front_figure, matrices_figure, save_both
    from hexathermal.show.identification_tables import matrix_csv, ranking_csv

    made_folder(folder)
    files = [ranking_csv(found.ranked, folder / "sets.csv")]
    files += [matrix_csv(found.ranked, by, folder / f"matrix-{by}.csv") for by in ("rmse", "linf")]
    files += save_both(matrices_figure(found.ranked), folder, "matrices")
    files += save_both(front_figure(found.ranked, found.chosen), folder, "front")
    with written_whole(folder / "identification.json") as part:
        part.write_text(json.dumps(facts, indent=2, allow_nan=False) + "\n", encoding="utf-8")
    return [*files, folder / "identification.json"]


def made_folder(folder: Path) -> None:
    """Make a folder for results."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise ArgumentError(f"cannot make the folder {folder}: {error.strerror or error}") from None
