"""``hexathermal identify``: a measured campaign becomes a leg law."""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hexathermal.errors import ArgumentError
from hexathermal.learn.coverage import TWO_SIDED
from hexathermal.show.commands import Answer, Progress, Writing
from hexathermal.show.hexapod_answers import (
    EPILOG_IDENTIFY,
    IDENTIFY_HEXAPOD,
    add_hexapod_options,
    identify_answer,
    is_hexapod_campaign,
)
from hexathermal.show.options import CAMPAIGN, EXIT_CODES, LETTERS, STYLE, path, sensor_names
from hexathermal.show.outputs import law_place

if TYPE_CHECKING:
    from hexathermal.learn.campaign import Campaign
    from hexathermal.learn.identification import Identification
    from hexathermal.learn.selection import RankedSets

OF_HEXAPODS = frozenset({"frame", "plates", "noise_um", "noise_urad", "legs", "propose", "criterion"})
"""Options for a whole machine."""

IDENTIFY = (
    """\
Which thermometers foretell the drift of a leg, and with which coefficients? Every single thermometer and every pair is
fitted to the campaign's runs for identification and judged on runs left out; the law of the chosen one is written with
its uncertainty and its range. Runs for validation are not touched.

  leg        drift = sum over sensors of  A q0 dT + B q dT     (q0 retracted length, q displacement of the rod)
  component  drift = sum over sensors of  C dT, or C dT + D q dT where runs left out say that it grows with its stroke

"""
    + IDENTIFY_HEXAPOD
)

EPILOG = f"""\
--sensors auto takes one sensor, unless the best pair is better on runs left out by more than its uncertainty.
--common asks whether other legs can share the law: one law for all against one each, on runs left out. It serves unless
it is clearly worse for one of the legs, or for all together: RMSE larger by more than the 95 % bound of the spread
between runs. The law that is written is then fitted to the runs of all legs; else it is that of the first campaign.
"Left out" is the error on each run under the law fitted to all others; "fit" that on the rows fitted, the paper's
criterion, by which more sensors always look better. RMSE is the root of the mean square of what the law leaves; on the
Pareto front stand the sets that no other beats in RMSE and in the largest residual at once.

files of --report DIR:
  sets.csv                      every set of sensors: RMSE, largest and mean residual, reductions, fitted and left out
  matrix-rmse.csv, -linf.csv    the two criteria of every pair; single sensors on the diagonal
  matrices.png, .svg            the same as pictures, brightest is best
  front.png, .svg               all sets, the Pareto front, and a zoom
  identification.json           everything as numbers

{EPILOG_IDENTIFY}
{LETTERS}
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
    one.add_argument("campaign", **CAMPAIGN)
    one.add_argument("--sensors", default="auto", metavar="NAMES", help="auto (default), or names with commas: T07,T14")
    one.add_argument("--triples", action="store_true", help="search sets of three sensors too")
    one.add_argument("--quads", action="store_true", help="search sets of three and of four sensors too")
    one.add_argument(
        "--material", metavar="NAME", help="of the fixed part, for the check of the result: invar, steel ..."
    )
    one.add_argument("--common", nargs="+", type=path, default=[], metavar="CAMPAIGN",
                     help="campaigns of other legs: can they share the law?")  # fmt: skip
    one.add_argument("--out", type=path, metavar="FILE", help="write the law: leg.toml")
    one.add_argument(
        "--report",
        type=path,
        metavar="DIR",
        help="write tables and pictures into this folder, which is created; earlier ones are replaced",
    )
    one.add_argument("--force", action="store_true", help="overwrite an existing law")
    add_hexapod_options(one)


def run(arguments: argparse.Namespace, progress: Progress) -> Answer:
    """Identify a law."""
    from hexathermal.learn.campaign_files import load_campaign
    from hexathermal.learn.campaign_laws import identify_campaign
    from hexathermal.learn.copied_runs import repeated_words
    from hexathermal.learn.identification import AUTO
    from hexathermal.learn.leg_law_files import write_leg_law
    from hexathermal.predict.table_writing import refuse_no_folder, refuse_no_place
    from hexathermal.show.identification_tables import identification_facts, law_table, sets_table

    names = sensor_names(arguments.sensors)
    if arguments.report is not None:
        refuse_no_place(arguments.report)
    if is_hexapod_campaign(arguments.campaign):
        return identify_answer(arguments, progress)
    _refuse_of_hexapods(arguments)
    if arguments.out is not None:
        law_place(arguments.out, "--out", arguments.force)
        refuse_no_folder(arguments.out)
    campaign = load_campaign(arguments.campaign, needed=("identification",), progress=progress)
    sizes = (1, 2, 3, 4) if arguments.quads else (1, 2, 3) if arguments.triples else (1, 2)
    wanted = AUTO if names == (AUTO,) else names
    found = identify_campaign(campaign, wanted, sizes=sizes, material=arguments.material, progress=progress)
    facts = identification_facts(found)
    shared = ""
    if arguments.common:
        shared, legs, pooled = _common(campaign, found, arguments, progress)
        found = pooled or found
        facts = identification_facts(found)
        facts |= {"common": shared, "common_legs": legs, "common_law_written": pooled is not None}
    writing = Writing()
    if arguments.report is not None:
        progress(0, 0, "drawing")
        writing.into(arguments.report, lambda: _report(found, facts, arguments.report))
    if arguments.out is not None:
        writing.into(arguments.out, lambda: [write_leg_law(found.law, arguments.out)])
    facts["written"] = writing.names
    texts = [_summary(campaign, found), lambda pretty, _: law_table(found, pretty),
             lambda pretty, _: sets_table(found, pretty)]  # fmt: skip
    if shared:
        texts.append(shared)
    warnings = [f"warning: {text}" for text in (*repeated_words(campaign), *found.warnings)]
    return Answer((*texts, *writing.words), facts, (*warnings, *writing.lost), code=writing.code)


def _refuse_of_hexapods(arguments: argparse.Namespace) -> None:
    """Refuse options that a campaign of one leg or component has no use for, before any work."""
    given = sorted(f"--{name.replace('_', '-')}" for name in OF_HEXAPODS & arguments.given_once)
    if given:
        raise ArgumentError(
            f"{' and '.join(given)}: for a campaign of kind 'hexapod' only; this one is of a leg or a component"
        )


def _common(
    campaign: Campaign, found: Identification, arguments: argparse.Namespace, progress: Progress
) -> tuple[str, dict[str, Any], Identification | None]:
    """Return in words and numbers whether several legs can share a law, and that law where they can."""
    from hexathermal.learn.campaign_files import load_campaign
    from hexathermal.learn.campaign_laws import identify_together, refuse_other_build, refuse_same_runs, role_blocks
    from hexathermal.learn.common import fit_common
    from hexathermal.learn.gram import columns_for, gather

    campaigns = [campaign]
    for place in arguments.common:
        other = load_campaign(place, needed=("identification",), progress=progress)
        refuse_other_build(campaign, other)
        refuse_same_runs(campaigns, other)
        campaigns.append(other)
    legs = {f"{k + 1} ({one.title or one.folder.name})": one for k, one in enumerate(campaigns)}
    first, *others = legs
    grams = {first: found.grams}
    for name in others:
        one = legs[name]
        grams[name] = gather(role_blocks(one, "identification", progress), columns_for(one.sensors, one.leg))
    result = fit_common(grams, found.law.sensors)
    lines = [f"One law for {len(legs)} legs: {result.reason}."]
    for name, leg in result.by_leg.items():
        lines.append(
            f"  {name}: RMSE left out {leg.common_rmse * 1e6:.3f} um with the common law, {leg.own_rmse * 1e6:.3f} um "
            f"with its own; by run {leg.loss * 1e6:+z.3f} um (standard uncertainty {leg.loss_uncertainty * 1e6:z.3f}): "
            f"{'clearly worse' if leg.worse else 'served'}"
        )
    numbers = {name: {"common_rmse_um": leg.common_rmse * 1e6, "own_rmse_um": leg.own_rmse * 1e6,
                      "loss_um": leg.loss * 1e6, "loss_uncertainty_um": leg.loss_uncertainty * 1e6,
                      "clearly_worse": leg.worse} for name, leg in result.by_leg.items()}  # fmt: skip
    if not result.use_common:
        lines.append(f"  the law above is that of leg {first}; identify the other legs one by one")
        return "\n".join(lines), numbers, None
    lines.append("  the law above is fitted to the runs of all legs")
    pooled = identify_together(legs, found.law.sensors, material=arguments.material, progress=progress)
    return "\n".join(lines), numbers, pooled


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
            f"The whole search on runs left out of it: RMSE {choice.nested_rmse * 1e6:z.3f} um (expected of new runs)."
        )
    lines.append(_fitted_best(ranked))
    if found.check is not None:
        like = ", ".join(found.check.like) or "no common material"
        lines.append(
            f"Effective expansion of the fixed part {found.check.expansion * 1e6:z.2f} +- "
            f"{TWO_SIDED * found.check.expansion_uncertainty * 1e6:z.2f} um/m/K (95 %): like {like}."
        )
    lines.append(_reliability(found))
    lines += [f"note: {note}" for note in found.notes]
    return "\n".join(lines)


def _fitted_best(ranked: RankedSets) -> str:
    """Return how far the best single sensor is off the front, by the paper's criterion."""
    single = ranked.best(1, left_out=False)
    off, front = ranked.off_front(single), ranked.front()
    by_linf, by_rmse = (" + ".join(ranked.names[k]) for k in (front[0], front[-1]))
    return (
        f"By the paper's criterion, the rows fitted (not that of the choice): best single sensor "
        f"{ranked.names[single][0]}, RMSE {ranked.fit.rmse[single] * 1e6:z.3f} um, {off[0] * 1e6:z.3f} um off that of "
        f"{by_rmse}; largest residual {ranked.fit.linf[single] * 1e6:z.3f} um, {off[1] * 1e6:z.3f} um off that of "
        f"{by_linf} (ends of the Pareto front)."
    )


def _reliability(found: Identification) -> str:
    """Return what is known of the errors of the law's thermometers, and whether the law is corrected for it."""
    fit, names = found.fit, ", ".join(found.law.sensors)
    value = f"Reliability of the temperatures {fit.reliability:z.3f} (1: no error of the thermometers)"
    done = "corrected for" if fit.corrected else "not corrected for"
    if fit.errors.slow.any():
        return f"{value}: noise and slow bias; {done}."
    return f"{value} as far as noise goes; {done} it. No slow bias of {names} could be told: there is none in it."


def _report(found: Identification, facts: dict[str, Any], folder: Path) -> list[Path]:
    """Write tables and pictures, all or none; returns their paths."""
    from hexathermal.predict.table_writing import written_folder
    from hexathermal.show.identification_figures import front_figure, matrices_figure, save_both
    from hexathermal.show.identification_tables import matrix_csv, ranking_csv

    with written_folder(folder) as part:
        files = [ranking_csv(found.ranked, part / "sets.csv")]
        files += [matrix_csv(found.ranked, by, part / f"matrix-{by}.csv") for by in ("rmse", "linf")]
        files += save_both(matrices_figure(found.ranked), part, "matrices")
        files += save_both(front_figure(found.ranked, found.chosen), part, "front")
        files.append(part / "identification.json")
        files[-1].write_text(json.dumps(facts, indent=2, allow_nan=False) + "\n", encoding="utf-8")
    return [folder / file.name for file in files]
