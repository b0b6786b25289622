"""``hexathermal check``: what a measured campaign is worth, before anything is fitted."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hexathermal.errors import ArgumentError
from hexathermal.show.commands import Answer, Progress, add_json
from hexathermal.show.options import EXIT_CODES, STYLE, path

if TYPE_CHECKING:
    from hexathermal.learn.campaign import Campaign
    from hexathermal.learn.check import CampaignCheck

CHECK = """\
Reads a campaign row by row and tells what it is worth: duration, noise of every channel, temperature ranges, how alike
the thermocouples are, whether the coefficients A and B of the law can be told apart, and what cleaning leaves out, with
reasons and counts. Every fault of every file is listed at once. Tables are never altered.
"""

EPILOG = f"""\
columns:
  noise       of single readings, robust and blind to trends
  slow        slow deviation that the other sensors do not explain, noise taken off: an upper bound of the sensor's bias
  inflation   variance inflation of a sensor among all of them: above 30 it says what the others say
  r           cosine of the angle between q0 dT and q dT: above 0.97 A and B are hardly told apart
  for 1 um    uncertainty of a coefficient for 1 um of noise of a rest

files of --plots DIR, each as .png and .svg:
  run-NAME      temperatures, drift and q (or the inputs) of a run
  noise, collinearity, coverage

examples:
  hexathermal check my-campaign
  hexathermal check my-campaign --plots plots --json check.json
  hexathermal check my-campaign --netcdf my-campaign.nc

{EXIT_CODES}"""


def add(commands: Any) -> None:
    """Declare the command."""
    check = commands.add_parser("check", help="what a measured campaign is worth", description=CHECK, epilog=EPILOG,
                                **STYLE)  # fmt: skip
    check.add_argument("campaign", type=path, metavar="CAMPAIGN", help="folder with campaign.toml")
    check.add_argument("--plots", type=path, metavar="DIR", help="write pictures into this folder, which is created")
    check.add_argument("--netcdf", type=path, metavar="FILE", help="write all runs, as recorded, into one NetCDF file")
    check.add_argument("--force", action="store_true", help="overwrite an existing NetCDF file")
    check.add_argument("--ranges", action="store_true", help="show the range of every sensor in every run too")
    add_json(check)


def run(arguments: argparse.Namespace, progress: Progress) -> Answer:
    """Check a campaign."""
    from hexathermal.learn.campaign_dataset import refuse_netcdf, save_campaign_netcdf
    from hexathermal.learn.campaign_files import load_campaign

    if arguments.netcdf is not None:
        refuse_netcdf(arguments.netcdf, arguments.force)
    campaign = load_campaign(arguments.campaign, progress=progress)
    if campaign.kind == "hexapod":
        if arguments.plots is not None:
            raise ArgumentError("--plots draws the drift of one leg or component; this campaign measures poses")
        answer = _hexapod(campaign)
    else:
        answer = _checked(campaign, arguments, progress)
    if arguments.netcdf is None:
        return answer
    file = save_campaign_netcdf(campaign, arguments.netcdf, overwrite=arguments.force, progress=progress)
    return Answer((*answer.shown, f"Written:\n  {file}"), answer.data, answer.warnings)


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
    data = as_data(check)
    if arguments.plots is not None:
        written = _plots(check, arguments.plots, progress)
        data["written"] = [str(file) for file in written]
        shown.append(f"Written into {arguments.plots}:\n  " + "\n  ".join(file.name for file in written))
    return Answer(tuple(shown), data, tuple(f"warning: {text}" for text in warnings_of(check)))


def _plots(check: CampaignCheck, folder: Path, progress: Progress) -> list[Path]:
    """Write all pictures; returns their paths."""
    from hexathermal.show.campaign_figures import collinearity_figure, coverage_figure, noise_figure, run_figure
    from hexathermal.show.figures import save_figure

    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise ArgumentError(f"cannot create the folder {folder}: {error.strerror or error}") from None
    sensors = check.campaign.sensors
    written = []
    jobs: list[tuple[str, Any]] = [("noise", lambda: noise_figure(sensors, check.sensor_noise, check.sensor_slow)),
                                   ("collinearity", lambda: collinearity_figure(sensors, check.correlation)),
                                   ("coverage", lambda: coverage_figure(check))]  # fmt: skip
    jobs += [(_file_name(item.run.name), lambda item=item: run_figure(check, item)) for item in check.runs]
    for k, (name, make) in enumerate(jobs):
        progress(k, len(jobs), f"drawing {name}")
        figure = make()
        if figure is not None:
            written += [save_figure(figure, folder / f"{name}{ending}") for ending in (".png", ".svg")]
    return written


def _file_name(run: str) -> str:
    """Return the name of a run's picture."""
    return run if run.startswith("run") else f"run-{run}"


def _hexapod(campaign: Campaign) -> Answer:
    """Return the answer for a whole machine: what was recorded; its poses are judged by the diagnosis."""
    import numpy as np

    from hexathermal.learn.campaign_dataset import read_run

    runs, lines = [], [f"{campaign.title or 'Campaign without a title'} (kind hexapod): {len(campaign.runs)} runs."]
    for one in campaign.runs:
        data = read_run(campaign, one)
        time, count = data["time"].values, int(data.sizes["sample"])
        heat = data["temperature"].values if "temperature" in data else np.full((count, 1), np.nan)
        known = bool(np.isfinite(heat).any())
        low, high = (float(np.nanmin(heat)), float(np.nanmax(heat))) if known else (None, None)
        span = "no temperatures" if low is None else f"{low:.1f} to {high:.1f} degC"
        hours = float(np.nanmax(time) - np.nanmin(time)) / 3600.0
        lines.append(f"  {one.name} ({one.role}): {count} rows, {hours:.2f} h, {span}")
        runs.append({"name": one.name, "role": one.role, "rows": count, "hours": hours, "lowest_degC": low,
                     "highest_degC": high, "unknown_columns": data.attrs["unknown_columns"]})  # fmt: skip
    facts = {"format": "hexathermal-check/1", "title": campaign.title, "kind": campaign.kind, "runs": runs,
             "sensors": list(campaign.sensors)}  # fmt: skip
    return Answer(("\n".join(lines),), facts)
