"""``hexathermal view``: a machine in three dimensions, coloured by temperature, its drift magnified."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hexathermal.errors import ArgumentError, TemperatureError
from hexathermal.show.commands import Answer, Progress
from hexathermal.show.options import (
    EXIT_CODES,
    MACHINE,
    SEED,
    STYLE,
    machine,
    number,
    path,
    pose_given,
    tool_given,
    whole,
)

if TYPE_CHECKING:
    from hexathermal.machine.hexapod import Hexapod
    from hexathermal.poses import FloatArray
    from hexathermal.show.viewer_course import Course

VIEW = """\
Look at what heat does to a machine: plates, joints and legs in three dimensions, legs coloured by temperature, the
platform where it is wanted and where it stands, its drift magnified by a factor that is stated. With play, pause and a
time slider; a switch between uncorrected and corrected; the trail of the tool point; the error budget as an ellipsoid.
"""

EPILOG = f"""\
what is shown:
  (nothing else)    a simulated working day: the machine works along a figure of eight, warms up, and rests
  --temps FILE      measured temperatures, CSV or Parquet: a column NAME_degC for each thermometer ('hexathermal
                    show-machine' lists them), time_s optional; the machine holds --pose
  --campaign DIR    a measured campaign of kind hexapod: measured poses, and what the machine's law leaves of them
A machine without a thermal law is drawn as it stands.

Without --save the page is served to this computer alone (127.0.0.1) and opened in a browser; Ctrl-C is the way to
end it, with exit code 0. --save writes the same page as one HTML file that works offline.

A machine's folder may hold own meshes: meshes/base.stl, platform.stl, body.stl, rod.stl in mm; 'docs/viewer.md' says in
which frames. What is not there is drawn from the geometry and [bodies] of hexapod.toml.

numbers may be parted by blanks or commas: --pose 5 0 12 0 1.5 0, --at-tool 0,0,120.

examples:
  hexathermal view --machine reference
  hexathermal view --machine reference --at-tool 0 0 120 --save day.html
  hexathermal view --machine my-machine --temps temps.csv --save warm.html --magnify 5000
  hexathermal view --campaign hexapod-campaign --save campaign.html

{EXIT_CODES}"""


def add(commands: Any) -> None:
    """Declare the command."""
    one = commands.add_parser("view", help="look at a machine and its drift, in three dimensions", description=VIEW,
                              epilog=EPILOG, **STYLE)  # fmt: skip
    one.add_argument(
        "--machine", **MACHINE | {"help": f"{MACHINE['help']} (default: the campaign's own, or reference)"}
    )
    what = one.add_mutually_exclusive_group()
    what.add_argument("--campaign", type=path, metavar="DIR", help="a measured campaign of kind hexapod")
    what.add_argument("--temps", type=path, metavar="FILE", help="measured temperatures, CSV or .parquet")
    one.add_argument("--pose", nargs="+", metavar="V", help="x y z rx ry rz from home that is held, mm and deg")
    one.add_argument("--at-tool", nargs="+", metavar="V", help="x y z of the tool point from the platform's origin, mm")
    one.add_argument(
        "--magnify", type=number, metavar="N", help="draw the drift N times larger (default: so that it is seen)"
    )
    one.add_argument("--seed", **SEED)
    one.add_argument("--save", type=path, metavar="FILE", help="write one HTML file instead of serving a page")
    one.add_argument("--force", action="store_true", help="overwrite an existing page")
    one.add_argument("--no-browser", action="store_true", help="serve the page, but open no browser")
    one.add_argument(
        "--port", type=whole(0, 65535), default=0, metavar="N", help="to serve at (default: any that is free)"
    )


def run(arguments: argparse.Namespace, progress: Progress) -> Answer:
    """Make the page, and write or serve it."""
    _check(arguments)
    course, name = _course(arguments, progress)
    from hexathermal.show.viewer import PageServer, machine_folder, magnification, viewer_page

    progress(0, 0, "making the page")
    drawn = magnification(course) if arguments.magnify is None else arguments.magnify
    html = viewer_page(course, folder=machine_folder(name), magnify=drawn)
    data, lines = _facts(course, drawn), [_said(course, drawn), *(f"note: {note}" for note in course.notes)]
    if arguments.save is not None:
        made = f"Written:\n  {arguments.save} ({len(html.encode()) / 1e6:.1f} MB)"
        return Answer(("\n".join(lines),), data, files={arguments.save: html.encode()}, made=made)
    server = PageServer(html, arguments.port)
    data["address"] = server.address

    def serve() -> str:
        server.serve(not arguments.no_browser)
        return "note: the page is no longer served; nothing was written (--save FILE.html keeps one)"

    text = "\n".join([*lines, f"Open {server.address} in a browser on this computer; Ctrl-C ends it."])
    return Answer((text,), data, then=serve)


def _check(arguments: argparse.Namespace) -> None:
    """Refuse what does not go together, before any work is done."""
    from hexathermal.predict.table_writing import refuse_no_folder, target_of

    if arguments.campaign is not None and arguments.pose is not None:
        raise ArgumentError("a campaign brings its own poses; leave --pose out")
    if arguments.magnify is not None and not 1.0 <= arguments.magnify <= 1e7:
        raise ArgumentError(f"--magnify takes a number from 1 to 1e7, found {arguments.magnify:g}")
    file: Path | None = arguments.save
    if file is None:
        return
    if arguments.port or arguments.no_browser:
        raise ArgumentError("--port and --no-browser are of a page that is served; leave them out with --save")
    if file.suffix.lower() not in (".html", ".htm"):
        raise ArgumentError(f"cannot write {file}: the name of a page ends in .html")
    if target_of(file).exists() and not arguments.force:
        raise ArgumentError(f"{file} exists already; give another name, or --force to replace it")
    refuse_no_folder(file)


def _course(arguments: argparse.Namespace, progress: Progress) -> tuple[Course, str]:
    """Return what is shown, and the name or path of the machine."""
    from hexathermal.show.budget_options import table
    from hexathermal.show.viewer import tool_point
    from hexathermal.show.viewer_course import still_course, temperatures_course

    tool = tool_point(tool_given(arguments.at_tool))
    if arguments.campaign is not None:
        return _campaign(arguments, tool, progress)
    name = arguments.machine or "reference"
    hexapod = machine(name)
    pose = None
    if arguments.pose is not None:
        pose = pose_given(arguments.pose, hexapod)
    if arguments.temps is not None:
        from hexathermal.predict.temperatures import active_model

        columns = tuple(f"{sensor}_degC" for sensor in active_model(hexapod).sensor_names)
        temps, time = table(arguments.temps, columns, "temperatures")
        held = hexapod.home if pose is None else pose
        try:
            return temperatures_course(hexapod, held, temps, time, tool, progress), name
        except TemperatureError as error:
            raise _of_file(error, arguments.temps) from None
    if hexapod.thermal is None:
        return still_course(hexapod, hexapod.home if pose is None else pose, tool), name
    from hexathermal.show.viewer_day import day_course

    return day_course(hexapod, pose, tool, arguments.seed, progress), name


def _of_file(error: TemperatureError, file: Path) -> TemperatureError:
    """Return what is wrong with a temperature, told by the file's row, from 1."""
    words = str(error)
    if error.index:
        words = words.replace(f" at index {error.index[0]}", f" in row {error.index[0] + 1}", 1)
    return TemperatureError(
        f"{file}: {words}", sensor=error.sensor, value=error.value, lower=error.lower, upper=error.upper,
        index=error.index,
    )  # fmt: skip


def _campaign(arguments: argparse.Namespace, tool: FloatArray, progress: Progress) -> tuple[Course, str]:
    """Return a campaign's course, of its own machine where none is named."""
    from hexathermal.learn.campaign_files import load_campaign
    from hexathermal.show.viewer_campaign import campaign_course, refuse_other_kind

    campaign = load_campaign(arguments.campaign, progress=progress)
    refuse_other_kind(campaign)
    name = str(arguments.machine or campaign.hexapod)
    hexapod: Hexapod = machine(name)
    return campaign_course(hexapod, campaign, tool, progress), name


def _facts(course: Course, drawn: float) -> dict[str, Any]:
    """Return what the page shows as plain values."""
    from hexathermal.show.viewer import temperature_range

    span = temperature_range(course)
    return {
        "format": "hexathermal-view/1",
        "machine": course.hexapod.name,
        "shown": course.title,
        "frames": len(course),
        "magnification": drawn,
        "range_degC": None if span is None else list(span),
        "tool_point_mm": (course.tool * 1e3).tolist(),
        "largest_shift_um": {"uncorrected": float(course.shift[0].max()) * 1e6,
                             "corrected": float(course.shift[1].max()) * 1e6},
        "largest_turn_urad": {"uncorrected": float(course.turn[0].max()) * 1e6,
                              "corrected": float(course.turn[1].max()) * 1e6},
        "notes": list(course.notes),
    }  # fmt: skip


def _said(course: Course, drawn: float) -> str:
    """Return what the page shows, in words."""
    name = course.hexapod.name or "without a name"
    if course.hexapod.thermal is None:
        return f"Machine {name}, as it is drawn: without a thermal law no drift is known."
    (shift, left), (turn, rest) = course.shift.max(axis=1) * 1e6, course.turn.max(axis=1) * 1e6
    return (
        f"Machine {name}: {course.title}, {len(course)} frame{'s' if len(course) > 1 else ''}; drift drawn {drawn:g} "
        f"times larger.\nLargest shift of the tool point: {shift:.2f} um uncorrected, {left:.2f} um corrected; largest "
        f"turn: {turn:.2f} urad uncorrected, {rest:.2f} urad corrected."
    )
