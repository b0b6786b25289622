"""``hexathermal compare``: the virtual bench driven by a measured campaign, simulated against measured."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hexathermal.show.commands import Answer, Progress, Writing
from hexathermal.show.options import CAMPAIGN, EXIT_CODES, STYLE, path

if TYPE_CHECKING:
    from hexathermal.compare.comparison import Comparison
    from hexathermal.compare.scores import ChannelScore

COMPARE = """\
Drive the virtual bench ('hexathermal simulate bench') by a campaign's own motion and room, and hold what it simulates
against what was measured: each thermocouple where it sits, and the drift. Where they part, the physics is named, with a
factor and its interval: heat of motor or screw, convection, contact, conduction, stored heat, expansion, or a
thermometer that reads the air. Runs for validation are never fitted; the gain is measured on them.
"""

EPILOG = f"""\
The campaign must be of kind "leg", its thermocouples with part = "body" or "rod" and position_mm, and the air's
temperature must be recorded, in two runs for identification or more. Where the bench's leg is of another length, its
lengths are multiplied; notes say so.

A number is named where it is more probable than 0.99 that it differs by more than its tolerance (3 to 6 %), and where
runs left out of the estimate are foretold better; at most eight are named. "would have been named" says how large a
difference these data show; below it nothing is claimed. Intervals hold while the other numbers are within their
tolerances. Channels that stay more than twice as far from the simulation as foretold (tolerances of the bench and slow
errors of thermometers) are explained by none of its numbers, and that is said. "not told apart" lists what explains the
data as well; "cannot be separated from", of what is not named, those whose marks in these data are alike by more than
0.95. See docs/compare.md.

It takes about a minute for eleven runs of four hours.

files of --plots DIR:
  parameters.png      factors of all numbers with intervals, and how large a difference would have been named
  RUN-channels.png    each run: every channel, measured, and simulated before and after
  RUN-residuals.png   each run: simulated less measured, by part; thermocouples with the largest are named
Gaps between curves are times without a settled row, longer than five usual steps.

examples:
  hexathermal compare my-campaign
  hexathermal compare my-campaign --plots pictures --json comparison.json

{EXIT_CODES}"""

KINDS = ("channels", "residuals")
"""Pictures of each run."""


def add(commands: Any) -> None:
    """Declare the command."""
    one = commands.add_parser("compare", help="the virtual bench against a measured leg", description=COMPARE,
                              epilog=EPILOG, **STYLE)  # fmt: skip
    one.add_argument("campaign", **CAMPAIGN)
    one.add_argument(
        "--plots",
        type=path,
        metavar="DIR",
        help="draw channels, residuals and factors into this folder, which is created; pictures of the same names are "
        "replaced, others stay and are named",
    )


def run(arguments: argparse.Namespace, progress: Progress) -> Answer:
    """Compare a campaign with the virtual bench."""
    from hexathermal.compare.comparison import compare_campaign
    from hexathermal.learn.campaign_files import load_campaign
    from hexathermal.predict.table_writing import refuse_no_place
    from hexathermal.show.compare_tables import (
        comparison_facts,
        differences_table,
        parameters_table,
        scores_table,
    )

    if arguments.plots is not None:
        refuse_no_place(arguments.plots)
    campaign = load_campaign(arguments.campaign, needed=("identification",), progress=progress)
    found = compare_campaign(campaign, progress=progress)
    facts = comparison_facts(found)
    writing = Writing()
    if arguments.plots is not None:
        writing.into(arguments.plots, lambda: _drawn(found, arguments.plots, progress))
    facts["written"] = writing.names
    texts: list[Any] = [_summary(found)]
    if found.differences:
        texts.append(lambda pretty, _: differences_table(found, pretty))
    texts += [lambda pretty, _: scores_table(found, pretty), lambda pretty, _: parameters_table(found, pretty)]
    if writing.files:
        texts += writing.words
        old = sorted({file for kind in KINDS for file in arguments.plots.glob(f"*-{kind}.png")} - set(writing.files))
        if old:
            texts.append(f"Older pictures stay in {arguments.plots}: {', '.join(file.name for file in old)}")
    return Answer(tuple(texts), facts, tuple(writing.lost), code=writing.code)


def _summary(found: Comparison) -> str:
    """Return what was found, in words."""
    runs = [f"{sum(one.role == role for one in found.runs)} for {role}" for role in ("identification", "validation")]
    lines = [
        found.sentence,
        f"Campaign {found.title}: runs {', '.join(runs)}; {len(found.sensors)} thermocouples and the drift; scores on "
        f"the runs for {found.scored_role}.",
        *(_gains(found) if found.differences else []),
        f"The simulation's own steps of {found.step:g} s cost at most {1e3 * found.step_error_K:z.0f} mK in "
        f"temperatures and {1e9 * found.step_error_m:z.0f} nm in the drift (one run).",
    ]
    lines += [f"To decide on {one.name} {one.target}".rstrip() + f": {one.experiment}." for one in found.differences
              if one.equivalent]  # fmt: skip
    lines += [f"note: {note}" for note in found.notes]
    return "\n".join(lines)


def _gains(found: Comparison) -> list[str]:
    """Return what naming the differences gains in the drift, and in the thermocouple that gains most, in words."""
    from hexathermal.show.compare_tables import scale_of
    from hexathermal.show.shares import less, proven

    def said(one: ChannelScore, what: str) -> str:
        factor, unit = scale_of(one)
        return (
            f"{what} is simulated to an RMSE of {one.rmse_before * factor:.3f} {unit} by the bench as it is, of "
            f"{one.rmse_after * factor:.3f} {unit} with what was named ({less(one.reduction)}; {proven(one.reduction)})"
        )

    drift = next(one for one in found.scores if one.channel == "drift")
    lines = [f"On the runs for {found.scored_role} {said(drift, 'the drift')}."]
    rest = [one for one in found.scores if one is not drift]
    if rest:
        most = max(rest, key=lambda one: one.rmse_before - one.rmse_after)
        better = sum(one.reduction.low > 0.0 for one in rest)
        lines.append(
            f"Of {len(rest)} thermocouples {better} are proven to be simulated better; {said(most, most.channel)}."
        )
    return lines


def _drawn(found: Comparison, folder: Path, progress: Progress) -> list[Path]:
    """Write all pictures, or none; returns their paths."""
    from hexathermal.predict.table_writing import written_folder
    from hexathermal.show.compare_figures import channels_figure, parameters_figure, residuals_figure
    from hexathermal.show.figures import draw

    with written_folder(folder) as part:
        names = ["parameters.png"]
        draw(parameters_figure(found), part / names[0], "png")
        for k, one in enumerate(found.runs):
            progress(k, len(found.runs), "drawing")
            stem = "".join(letter if letter.isalnum() or letter in "-_." else "_" for letter in one.name)
            for kind, figure in zip(KINDS, (channels_figure, residuals_figure), strict=True):
                names.append(f"{stem}-{kind}.png")
                draw(figure(found, one), part / names[-1], "png")
    return [folder / name for name in names]
