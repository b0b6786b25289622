"""``hexathermal check``: what a measured campaign is worth, before anything is fitted."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hexathermal.show.commands import Answer, Progress, Writing
from hexathermal.show.options import CAMPAIGN, EXIT_CODES, LETTERS, STYLE, path

if TYPE_CHECKING:
    from hexathermal.learn.campaign import Campaign
    from hexathermal.learn.check import CampaignCheck
    from hexathermal.learn.check_hexapod import HexapodCheck

CHECK = """\
Reads a campaign row by row and tells what it is worth: duration, noise of every channel, temperature ranges, how alike
the thermometers are, what the data can tell apart (the coefficients A and B of a leg's law; the laws of six legs and
two plates), and what is left out, with reasons and counts. Every fault of every file is listed at once. Tables are
never altered.
"""

EPILOG = f"""\
columns:
  noise         of single readings, robust and blind to trends
  slow          slow deviation that the other sensors do not explain, noise taken off: an upper bound of its bias
  inflation     variance inflation of a sensor among all of them: above 30 it says what the others say;
                of a hexapod's coefficient: its uncertainty over that if all others were known
  r             cosine of the angle between q0 dT and q dT: above 0.97 A and B are hardly told apart
  for 1 um      uncertainty of a coefficient for 1 um of noise of a rest
  pose held     kind hexapod: noise of the measured pose where the commanded one stays; from pose to pose the errors of
                the machine are in it

files of --plots DIR, each as .png and .svg:
  run-NAME      leg: temperatures, drift, q · component: temperatures, drift, inputs · hexapod: temperatures, measured
                less commanded pose; spikes that were left out are marked (leg, component)
  noise, collinearity           of the thermometers
  coverage                      leg: where it was when it was warm
  observability                 hexapod: which laws the poses and temperatures tell apart

{LETTERS}
examples:
  hexathermal check my-campaign
  hexathermal check my-campaign --plots plots --json check.json
  hexathermal check my-campaign --netcdf my-campaign.nc

{EXIT_CODES}"""


def add(commands: Any) -> None:
    """Declare the command."""
    check = commands.add_parser("check", help="what a measured campaign is worth", description=CHECK, epilog=EPILOG,
                                **STYLE)  # fmt: skip
    check.add_argument("campaign", **CAMPAIGN)
    check.add_argument(
        "--plots",
        type=path,
        metavar="DIR",
        help="write pictures into this folder, which is created; earlier ones are replaced",
    )
    check.add_argument("--netcdf", type=path, metavar="FILE", help="write all runs, as recorded, into one NetCDF file")
    check.add_argument("--force", action="store_true", help="overwrite an existing NetCDF file")
    check.add_argument(
        "--ranges", action="store_true", help="show the range of every sensor in every run too (leg, component)"
    )


def run(arguments: argparse.Namespace, progress: Progress) -> Answer:
    """Check a campaign."""
    from hexathermal.learn.campaign_dataset import refuse_netcdf, save_campaign_netcdf
    from hexathermal.learn.campaign_files import load_campaign
    from hexathermal.predict.table_writing import refuse_no_place

    if arguments.plots is not None:
        refuse_no_place(arguments.plots)
    if arguments.netcdf is not None:
        refuse_netcdf(arguments.netcdf, arguments.force)
    campaign = load_campaign(arguments.campaign, clocks=False, progress=progress)
    answer = (_hexapod if campaign.kind == "hexapod" else _checked)(campaign, arguments, progress)
    if arguments.netcdf is None:
        return answer
    writing = Writing()
    save = partial(save_campaign_netcdf, campaign, arguments.netcdf, overwrite=arguments.force, progress=progress)
    writing.into(arguments.netcdf, lambda: [save()])
    written = [*answer.data.get("written", ()), *writing.names]
    return Answer((*answer.shown, *writing.words), answer.data | {"written": written},
                  (*answer.warnings, *writing.lost), max(answer.code, writing.code))  # fmt: skip


def _checked(campaign: Campaign, arguments: argparse.Namespace, progress: Progress) -> Answer:
    """Return the answer for a leg or a component."""
    from hexathermal.learn.check import check_campaign
    from hexathermal.learn.check_words import as_data, warnings_of
    from hexathermal.show import campaign_tables as tables

    check = check_campaign(campaign, progress)
    shown: list[Any] = [tables.overview(check), lambda pretty, _: tables.runs_table(check, pretty),
                        lambda pretty, _: tables.sensors_table(check, pretty)]  # fmt: skip
    if arguments.ranges:
        shown.append(lambda pretty, _: tables.ranges_table(check, pretty))
    shown += [
        lambda pretty, _: tables.apart_table(check, pretty),
        lambda pretty, _: tables.cleaning_table(check, pretty),
    ]
    if text := tables.remarks(check):
        shown.append(text)
    warnings = [f"warning: {text}" for text in warnings_of(check)]
    return _with_plots(Answer(tuple(shown), as_data(check), tuple(warnings)), arguments.plots,
                       lambda: _plots(check, arguments.plots, progress))  # fmt: skip


def _with_plots(answer: Answer, folder: Path | None, draw: Callable[[], list[Path]]) -> Answer:
    """Return an answer with the pictures that were asked for, drawn into a folder."""
    if folder is None:
        return answer
    writing = Writing()
    files = writing.into(folder, draw)
    told = [f"Written into {folder}:\n  " + "\n  ".join(file.name for file in files)] if files else []
    return Answer((*answer.shown, *told), answer.data | {"written": writing.names},
                  (*answer.warnings, *writing.lost), writing.code)  # fmt: skip


def _plots(check: CampaignCheck, folder: Path, progress: Progress) -> list[Path]:
    """Write all pictures of a leg or component; returns their paths."""
    from hexathermal.show.campaign_figures import collinearity_figure, coverage_figure, noise_figure, run_figure

    sensors, noises = check.campaign.sensors, (check.sensor_noise, check.sensor_slow)
    jobs: list[tuple[str, Any]] = [
        ("noise", lambda: noise_figure(sensors, *noises) if (noises[0] > 0.0).any() else None),
        ("collinearity", lambda: collinearity_figure(sensors, check.correlation)),
        ("coverage", lambda: coverage_figure(check)),
    ]
    jobs += [(_file_name(item.run.name), lambda item=item: run_figure(check, item)) for item in check.runs]
    return _drawn(jobs, folder, progress)


def _drawn(jobs: list[tuple[str, Any]], folder: Path, progress: Progress) -> list[Path]:
    """Draw and write pictures, each as PNG and SVG, all or none; returns their paths."""
    from hexathermal.predict.table_writing import written_folder
    from hexathermal.show.figures import save_figure

    written = []
    with written_folder(folder) as part:
        for k, (name, make) in enumerate(jobs):
            progress(k, len(jobs), f"drawing {name}")
            figure = make()
            if figure is not None:
                written += [save_figure(figure, part / f"{name}{ending}") for ending in (".png", ".svg")]
    return [folder / file.name for file in written]


def _file_name(run: str) -> str:
    """Return the name of a run's picture."""
    return run if run.startswith("run") else f"run-{run}"


def _hexapod(campaign: Campaign, arguments: argparse.Namespace, progress: Progress) -> Answer:
    """Return the answer for a whole machine."""
    from hexathermal.learn.check_hexapod import check_hexapod_campaign, hexapod_warnings
    from hexathermal.show import campaign_hexapod as tables
    from hexathermal.show.hexapod_tables import observability_table

    check = check_hexapod_campaign(campaign, progress)
    shown: list[Any] = [tables.overview(check), lambda pretty, _: tables.runs_table(check, pretty),
                        lambda pretty, _: tables.coordinates_table(check, pretty)]  # fmt: skip
    if campaign.sensors:
        shown.append(lambda pretty, _: tables.thermometers_table(check, pretty))
    if check.observability is not None:
        seen = check.observability
        shown.append(lambda pretty, _: observability_table(seen, pretty))
    if text := tables.remarks(check):
        shown.append(text)
    warnings = [f"warning: {text}" for text in hexapod_warnings(check)]
    return _with_plots(Answer(tuple(shown), tables.hexapod_check_facts(check), tuple(warnings)), arguments.plots,
                       lambda: _hexapod_plots(check, arguments.plots, progress))  # fmt: skip


def _hexapod_plots(check: HexapodCheck, folder: Path, progress: Progress) -> list[Path]:
    """Write all pictures of a whole machine; returns their paths."""
    from hexathermal.show.campaign_figures import collinearity_figure, noise_figure
    from hexathermal.show.campaign_hexapod import hexapod_run_figure
    from hexathermal.show.hexapod_figures import observability_figure

    sensors, seen = check.campaign.sensors, check.observability
    noises = (check.sensor_noise, check.sensor_slow)
    jobs: list[tuple[str, Any]] = []
    if sensors:
        jobs = [("noise", lambda: noise_figure(sensors, *noises) if (noises[0] > 0.0).any() else None),
                ("collinearity", lambda: collinearity_figure(sensors, check.correlation))]  # fmt: skip
    if seen is not None:
        jobs.append(("observability", lambda: observability_figure(seen)))
    jobs += [(_file_name(item.run.name), lambda item=item: hexapod_run_figure(check, item))
             for item in check.runs if len(item.time)]  # fmt: skip
    return _drawn(jobs, folder, progress)
