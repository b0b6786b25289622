"""``hexathermal budget``: how far off a warm machine is, which cause weighs most, what correction leaves."""

from __future__ import annotations

import argparse
from contextlib import nullcontext
from pathlib import Path
from typing import Any

from hexathermal.errors import ArgumentError
from hexathermal.poses import Frames
from hexathermal.show.budget_options import Grid, Request, draws, grid, percent, probability, requested
from hexathermal.show.commands import Answer, Progress
from hexathermal.show.options import (
    EXIT_CODES,
    MACHINE,
    SEED,
    STYLE,
    add_frames,
    frames_of,
    machine,
    number,
    numbers,
    path,
    pose_given,
    three,
    tool_given,
)

TOLERANCE, DRAWS = 5.0, 4_000_000
"""Of a Monte Carlo: percent of the standard uncertainty, and most draws."""

BUDGET = """\
The error budget of a warm machine at a pose: its drift, what correction removes, the bias and the uncertainty that
remain, as a 6-D covariance of one point (the tool) in one frame, with every source's contribution, largest first.
"""

EPILOG = f"""\
numbers may be parted by blanks or commas: --pose 5 0 12 0 1.5 0, --at-tool 0,0,120.

--temps    one temperature for all thermometers, or one for each in the order of 'hexathermal show-machine', degC;
           or a CSV or Parquet file with a column NAME_degC for each: one row, or a day (time_s is optional)
--day      the day that 'hexathermal demo' simulates, with its plates' temperatures
--map      a grid of poses about --pose: 'x=-50:50:11 y=-50:50:11' (low:high:count, mm and deg; counted from home)
--path     a CSV or Parquet file with columns x_mm, y_mm, z_mm, rx_deg, ry_deg, rz_deg, counted from home (time_s is
           optional); a file of temperatures belongs to it as in 'hexathermal correct': one row for all, interpolated
           by time_s where both have it, else row by row
--sources  a TOML file of own sources; 'docs/budget.md' shows one. Without it the machine gets default sources:
           documented values, most of them engineering values that should be replaced by what is known of the machine

Errors are reached minus wanted: shift of the point, and rotation vector of the platform, in the axes of --frame.
Worst case: |bias| + expanded uncertainty. A plate without a thermometer is taken at the legs' mean temperature unless
--plate-temps says otherwise. Poses of a map that cannot be reached are listed with the reason.

--out DIR writes budget.csv and contributions.png; map.csv and map.png; path or day likewise, as they were asked for.

examples:
  hexathermal budget --machine reference --pose 5 0 12 0 1.5 0 --temps 25 --at-tool 0 0 120
  hexathermal budget --machine reference --pose 0 0 0 0 0 0 --temps 24 24 25 25 26 26 --monte-carlo --out budget
  hexathermal budget --machine reference --pose 0 0 0 0 0 0 --temps 25 --map x=-50:50:11 y=-50:50:11 --out map
  hexathermal budget --machine reference --pose 0 0 0 0 0 0 --day --out day

{EXIT_CODES}"""


def add(commands: Any) -> None:
    """Declare the command."""
    budget = commands.add_parser("budget", help="how far off a warm machine is, and why", description=BUDGET,
                                 epilog=EPILOG, **STYLE)  # fmt: skip
    budget.add_argument("--machine", required=True, **MACHINE)
    budget.add_argument(
        "--pose",
        nargs="+",
        metavar="V",
        help="x y z rx ry rz from home, mm and deg; only with --path it may be left out",
    )
    heat = budget.add_mutually_exclusive_group(required=True)
    heat.add_argument("--temps", nargs="+", metavar="T", help="temperatures, degC, or a file of them (see below)")
    heat.add_argument("--day", action="store_true", help="a simulated working day")
    budget.add_argument("--at-tool", nargs="+", metavar="V", help="x y z of the point from the platform's origin, mm")
    budget.add_argument(
        "--monte-carlo", action="store_true", help="by simulation too, with a verdict on the linear one"
    )
    budget.add_argument("--tolerance", type=percent, metavar="PERCENT", help="of --monte-carlo: how far a linear limit "
                        f"may be off, of each axis' standard uncertainty (default: {TOLERANCE:g})")  # fmt: skip
    budget.add_argument("--most-draws", type=draws, metavar="N", help=f"of --monte-carlo (default: {DRAWS})")
    budget.add_argument("--map", nargs="+", type=grid, metavar="GRID", help="over a grid of poses (see below)")
    budget.add_argument("--path", type=path, metavar="FILE", help="along the poses of a CSV or Parquet file")
    budget.add_argument("--uncorrected", action="store_true", help="nominal lengths are commanded, not corrected ones")
    budget.add_argument("--sources", type=path, metavar="FILE", help="own sources of uncertainty, TOML")
    budget.add_argument(
        "--without", nargs="+", metavar="LABEL", default=[], help="leave these sources out, by the names in the table"
    )
    budget.add_argument(
        "--probability",
        type=probability,
        default=0.95,
        metavar="P",
        help="of intervals and of the expanded uncertainty (default: %(default)s)",
    )
    budget.add_argument("--frame", choices=("machine", "user", "object"), default="machine",
                        help="axes of the errors (default: %(default)s)")  # fmt: skip
    add_frames(budget, "axes of --frame user", "the point of --frame object")
    budget.add_argument("--plate-temps", nargs=2, type=number, metavar=("PLATFORM", "BASE"),
                        help="plates without thermometers, degC (default: the legs' mean)")  # fmt: skip
    for part in ("leg", "platform", "base"):
        whose = "across the legs" if part == "leg" else f"across the {part}"
        budget.add_argument(
            f"--{part}-gradient", nargs="+", metavar="G", help=f"gradient {whose}, x y z, K/m (default: 0)"
        )
    budget.add_argument("--air", type=number, metavar="T", help="air, degC (default: reference temperature)")
    budget.add_argument("--seed", **SEED)
    budget.add_argument("--out", type=path, metavar="DIR", help="folder for tables and figures, which is created")
    budget.add_argument("--force", action="store_true", help="overwrite results in the folder of --out")


def run(arguments: argparse.Namespace, progress: Progress) -> Answer:
    """How far off a warm machine is, which cause weighs most, and what correction leaves."""
    hexapod = machine(arguments.machine)
    if arguments.pose is None and arguments.path is None:
        raise ArgumentError("give --pose X Y Z RX RY RZ, or --path FILE")
    six = numbers(arguments.pose or ["0"] * 6, 6, "--pose", "x y z rx ry rz, mm and deg")
    if arguments.pose is not None and arguments.frame == "machine":
        pose_given(arguments.pose, hexapod, arguments.convention)
    frames = frames_of(arguments) or Frames(convention=arguments.convention)
    if arguments.frame == "user" and not arguments.user_frame:
        raise ArgumentError("--frame user needs --user-frame")
    tool = tool_given(arguments.at_tool)
    gradients = {part: three(getattr(arguments, f"{part}_gradient"), f"--{part}-gradient", "K/m")
                 for part in ("leg", "platform", "base")}  # fmt: skip
    grids: list[Grid] = arguments.map or []
    if len({one.name for one in grids}) < len(grids):
        raise ArgumentError("--map names a coordinate twice")
    asked = [name for name, given in (("--map", grids), ("--path", arguments.path), ("--day", arguments.day)) if given]
    if not arguments.monte_carlo and (arguments.tolerance or arguments.most_draws):
        raise ArgumentError("--tolerance and --most-draws are of --monte-carlo: give it too")
    if len(asked) > 1:
        raise ArgumentError(f"{' and '.join(asked)} are different questions; ask one at a time")
    request = requested(
        hexapod, six, arguments.temps, day=arguments.day, seed=arguments.seed, frames=frames, frame=arguments.frame,
        at_tool=None if tool is None else tuple(value / 1e3 for value in tool), gradients=gradients,
        plate_temps=arguments.plate_temps, air=arguments.air, convention=arguments.convention,
        sources=arguments.sources, without=tuple(arguments.without), correction=not arguments.uncorrected,
        probability=arguments.probability,
    )  # fmt: skip
    kinds = ["map"] * bool(grids) + ["path"] * (arguments.path is not None)
    _check_folder(arguments.out, arguments.force, kinds + ["day"] * (request.many and not kinds))
    return _answered(request, grids, arguments, progress)


def _check_folder(folder: Path | None, force: bool, kinds: list[str]) -> None:
    """Refuse a folder of results that is none, and files that are there already."""
    from hexathermal.predict.table_writing import refuse_no_place

    if folder is None:
        return
    refuse_no_place(folder)
    names = ["budget.csv", "contributions.png", *(f"{kind}{end}" for kind in kinds for end in (".csv", ".png"))]
    there = [name for name in names if (folder / name).exists()]
    if there and not force:
        raise ArgumentError(f"{folder} holds {', '.join(there)} already; give another folder (--out), or --force")


def _answered(request: Request, grids: list[Grid], arguments: argparse.Namespace, progress: Progress) -> Answer:
    """Return the answer, and write its files."""
    from hexathermal.predict.table_writing import written_folder
    from hexathermal.show import budget_answers as answers

    progress(0, 0, "error budget (the first run compiles)")
    with nullcontext() if arguments.out is None else written_folder(arguments.out, force=arguments.force) as part:
        answer = answers.Report(request, part)
        if grids:
            answer.add_map(grids, progress)
        elif arguments.path is not None:
            answer.add_path(arguments.path, progress)
        elif request.many:
            answer.add_day(progress)
        else:
            answer.add_budget()
        if arguments.monte_carlo:
            answer.add_simulation(
                arguments.seed, arguments.tolerance or TOLERANCE, arguments.most_draws or DRAWS, progress
            )
    answer.files = [arguments.out / file.name for file in answer.files]
    answer.data["written"] = [str(file) for file in answer.files]
    return answer.finished()
