"""``hexathermal simulate machine``: what it accepts, what it answers."""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator
from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hexathermal.errors import ArgumentError, FileFormatError, KinematicsError, OutOfStrokeError, Problem
from hexathermal.show.commands import Answer, Progress
from hexathermal.show.options import EXIT_CODES, MACHINE, SEED, STYLE, machine, number, path, whole

if TYPE_CHECKING:
    from hexathermal.machine.hexapod import Hexapod
    from hexathermal.poses import FloatArray
    from hexathermal.simulate.machine.machine import VirtualMachine
    from hexathermal.simulate.machine.runs import MachinePlan, MachineRun

IDENTIFICATION, VALIDATION, POSES = 6, 2, 150
LARGEST_RUNS, LARGEST_POSES = 200, 5000

DESCRIPTION = """\
A whole hexapod with a 6-D positioning system: six virtual legs, each with motor, screw, body and rod of its own,
between two plates that six joints warm; a room; thermometers; a tracker that sees the platform. It works, goes from
pose to pose, rests, and is measured. Heat flows, parts grow, and the true pose is the exact forward kinematics of the
true lengths between the true joints (docs/six-legs.md). A payload, exchanged plugs and a drifting measuring frame are
as the machine states them; terms of its legs' laws are not simulated.

--growth heat (default) is a machine like any: it follows no drift law exactly. Its parts differ by --spread, they are
not warm all over, thermometers are taped on. 'identify' finds its laws; 'diagnose' rightly finds that those of
hexapod.toml are off, and that legs lag behind their thermometers. --growth law is a machine that does exactly what its
hexapod.toml says, within the noise of tracker and thermometers: 'diagnose' finds nothing. Change a copy of the
hexapod.toml that was written (a law, a payload, exchanged plugs), simulate that, and diagnose it with --machine of the
one before: the change is found.
"""

GROWN = {
    "heat": "Legs and plates grow as heat flows in them and follow no law exactly (--growth law: they do).",
    "law": "Legs and plates grow exactly as hexapod.toml says, from the first row on.",
}

EPILOG = f"""\
written into the folder of --out:
  campaign.toml      format hexathermal-campaign/1, kind hexapod
  hexapod.toml       the machine as its maker knows it; the base frame stands at the centre of the base joints
  runs/run-01.csv    a row for each measured pose: time_s; commanded x_mm ... rz_deg; leg1_q_mm ... leg6_q_mm;
                     thermometers leg1_T1_degC ..., platform_T1_degC, base_T1_degC; air_temperature_degC;
                     measured_x_mm ... measured_rz_deg
What it truly was made of goes to --truth FILE, never into the folder. Poses count from home, R = Rz Ry Rx.

--poses FILE: a table (CSV or Parquet) with columns x_mm y_mm z_mm rx_deg ry_deg rz_deg; the runs for identification go
through its rows in turn. 'hexathermal identify --propose N' writes such a table.

examples:
  hexathermal simulate machine --out campaign
  hexathermal simulate machine --out campaign --machine rubin-camera --runs 3 --validation 1 --truth truth.json
  hexathermal simulate machine --out campaign --spread 0 --noise-um 0.1 --noise-urad 0.3 --seed 7
  hexathermal simulate machine --out clean --growth law

{EXIT_CODES}"""


def add_machine(kinds: Any) -> None:
    """Declare ``simulate machine``."""
    one = kinds.add_parser("machine", help="a whole hexapod before a 6-D positioning system", description=DESCRIPTION,
                           epilog=EPILOG, **STYLE)  # fmt: skip
    one.add_argument("--out", required=True, type=path, metavar="DIR", help="folder of the campaign, which is created")
    one.add_argument("--machine", default="reference", **MACHINE)
    one.add_argument("--runs", type=whole(0, LARGEST_RUNS), default=IDENTIFICATION, metavar="N",
                     help="runs to identify laws (default: %(default)s)")  # fmt: skip
    one.add_argument("--validation", type=whole(0, LARGEST_RUNS), default=VALIDATION, metavar="N",
                     help="runs to validate them, never fitted (default: %(default)s)")  # fmt: skip
    one.add_argument("--rows", type=whole(2, LARGEST_POSES), default=POSES, metavar="N",
                     help="measured poses of a run (default: %(default)s)")  # fmt: skip
    one.add_argument("--poses", type=path, metavar="FILE", help="poses to measure, see below (default: drawn)")
    one.add_argument("--growth", choices=("heat", "law"), default="heat",
                     help="legs and plates grow as heat flows in them, or exactly as the machine's law says "
                          "(default: %(default)s)")  # fmt: skip
    one.add_argument("--spread", type=number, metavar="PART",
                     help="standard deviation of the legs' expansions (default: 0.05; law: none)")  # fmt: skip
    one.add_argument("--sensors", metavar="NAMES", help="thermometers of each leg: T1,T2 (default: those of its law)")
    one.add_argument("--noise-um", type=number, default=0.4, metavar="UM",
                     help="noise of x, y, z (default: %(default)g)")  # fmt: skip
    one.add_argument("--noise-urad", type=number, default=1.0, metavar="URAD",
                     help="noise of rx, ry, rz (default: %(default)g)")  # fmt: skip
    one.add_argument("--frame-um", type=number, default=0.5, metavar="UM",
                     help="shift of the tracker's frame, drawn for each run (default: %(default)g)")  # fmt: skip
    one.add_argument("--frame-urad", type=number, default=1.0, metavar="URAD",
                     help="turn of the tracker's frame, drawn for each run (default: %(default)g)")  # fmt: skip
    one.add_argument("--zero", choices=("campaign", "run"), default="campaign",
                     help="temperatures count from the first row of this (default: %(default)s)")  # fmt: skip
    one.add_argument("--seed", **SEED)
    one.add_argument("--parquet", action="store_true", help="write the runs as Parquet, not CSV")
    one.add_argument("--truth", type=path, metavar="FILE", help="write what truly was, as JSON, outside of --out")
    one.add_argument("--plots", type=path, metavar="DIR", help="draw every run into this folder, outside of --out")
    one.add_argument("--force", action="store_true", help="replace the campaign in --out, the truth and the plots")


def answer(arguments: argparse.Namespace, progress: Progress) -> Answer:
    """Simulate a whole machine."""
    from hexathermal.predict.table_writing import written_folder, written_whole
    from hexathermal.simulate.campaign_writing import HEXAPOD_KIND, check_folder
    from hexathermal.simulate.machine.campaign_folder import write_machine_campaign
    from hexathermal.simulate.machine.runs import planned_machine_runs, simulate_machine
    from hexathermal.simulate.machine.truth import machine_run_summary, machine_truth

    check_folder(arguments.out, arguments.force, HEXAPOD_KIND)
    made = asked_machine(arguments)
    if arguments.runs + arguments.validation < 1:
        raise ArgumentError("nothing to simulate: --runs and --validation are both 0; give at least one run")
    given = None if arguments.poses is None else read_poses(arguments.poses, made.hexapod)
    progress(0, 0, "planning")
    plans = planned_machine_runs(made, arguments.seed, identification=arguments.runs, validation=arguments.validation,
                                 poses=arguments.rows, given=given)  # fmt: skip
    kept: list[MachineRun] = []
    figures: list[Path] = []

    def runs() -> Iterator[MachineRun]:
        """Hand the runs on, and note what is said of them."""
        progress(0, len(plans), "simulating")
        for k, run in enumerate(simulate_machine(made, arguments.seed, plans, arguments.zero)):
            kept.append(run)
            if pictures is not None:
                figures.append(arguments.plots / _drawn(pictures, made, run).name)
            yield run
            progress(k + 1, len(plans), f"{run.name} written")

    with (
        nullcontext() if arguments.plots is None else written_folder(arguments.plots, force=arguments.force) as pictures
    ):
        files = write_machine_campaign(arguments.out, made, plans, runs(), zero=arguments.zero,
                                       parquet=arguments.parquet, force=arguments.force)  # fmt: skip
    extra = list(figures)
    if arguments.truth is not None:
        with written_whole(arguments.truth) as part:
            part.write_text(json.dumps(machine_truth(made, arguments.seed, kept)) + "\n", encoding="utf-8")
        extra.append(arguments.truth)
    summaries = [machine_run_summary(made, run) for run in kept]
    data = {"folder": str(arguments.out), "machine": made.hexapod.name, "seed": arguments.seed, "zero": arguments.zero,
            "growth": made.growth, "sensors": list(made.columns), "runs": summaries,
            "written": [str(file) for file in (*files, *extra)]}  # fmt: skip
    warnings = [f"warning: {text}" for text in _left_out(machine(arguments.machine))]
    return Answer(_shown(arguments, made, plans, summaries, extra), data, tuple(warnings))


def _left_out(hexapod: Hexapod) -> list[str]:
    """Return what the machine states and a virtual one does not have."""
    laws = () if hexapod.thermal is None else hexapod.thermal.legs
    return [
        f"leg {leg + 1}: {', '.join(term.cause for term in law.terms)} is not simulated, nor in the campaign's machine"
        for leg, law in enumerate(laws)
        if law.terms
    ]


def asked_machine(arguments: argparse.Namespace) -> VirtualMachine:
    """Return the virtual machine that is asked for."""
    from hexathermal.simulate.machine.building import placed, virtual_machine
    from hexathermal.simulate.machine.parts import PositioningSystem

    for name, value, most in (("--noise-um", arguments.noise_um, 1e3), ("--noise-urad", arguments.noise_urad, 1e3),
                              ("--frame-um", arguments.frame_um, 1e3), ("--frame-urad", arguments.frame_urad, 1e3),
                              ("--spread", arguments.spread or 0.0, 0.3)):  # fmt: skip
        if not 0.0 <= value <= most:
            raise ArgumentError(f"{name} must be 0 to {most:g}, found {value:g}")
    sensors = None
    if arguments.sensors is not None:
        names = tuple(name.strip() for name in arguments.sensors.split(","))
        if not all(name.isidentifier() for name in names) or len(set(names)) < len(names):
            raise ArgumentError(f"--sensors {arguments.sensors!r}: give different names of letters and digits: T1,T2")
        sensors = placed(names)
    shift, turn = arguments.noise_um * 1e-6, arguments.noise_urad * 1e-6
    tracker = PositioningSystem(
        (shift, shift, shift, turn, turn, turn), arguments.frame_um * 1e-6, arguments.frame_urad * 1e-6
    )
    return virtual_machine(
        machine(arguments.machine), arguments.seed, spread=arguments.spread, sensors=sensors, tracker=tracker,
        growth=arguments.growth,
    )  # fmt: skip


def read_poses(file: Path, hexapod: Hexapod) -> FloatArray:
    """Return the poses of a table, shape (n, 6) [mm, deg].

    Raises
    ------
    FileFormatError
        A column is missing, or a value is no number; says the line.
    KinematicsError
        The machine cannot reach a pose; says the line.
    """
    import numpy as np

    from hexathermal.predict.table_streams import open_table
    from hexathermal.simulate.campaign_writing import COORDINATES

    stream = open_table(file, COORDINATES, "pose")
    blocks = []
    while (rows := stream.next_rows()) is not None:
        blocks.append(rows.numbers)
    found = np.concatenate(blocks)
    if len(found) > LARGEST_POSES:
        problem = Problem(stream.line(LARGEST_POSES), 1, f"{len(found)} poses, at most {LARGEST_POSES} are taken")
        raise FileFormatError(str(file), (problem,))
    for row, six in enumerate(found):
        _refuse_unreachable(hexapod, six, f"{file}, line {stream.line(row)}: ", row)
    return found


def _refuse_unreachable(hexapod: Hexapod, six: FloatArray, where: str, row: int) -> None:
    """Refuse a pose out of reach, told by its place in a file."""
    from hexathermal.kinematics.refusals import refuse_stroke
    from hexathermal.poses import pose_from_coordinates
    from hexathermal.predict.trajectory import far_words

    try:
        lengths = hexapod.inverse_kinematics(pose_from_coordinates(six, hexapod=hexapod))
        low, high = hexapod.length_limits
        if ((lengths < low) | (lengths > high)).any():
            refuse_stroke(hexapod, lengths)
    except OutOfStrokeError as error:
        raise OutOfStrokeError(f"{where}{error}", leg=error.leg, value=error.value, lower=error.lower,
                               upper=error.upper, index=(row,)) from None  # fmt: skip
    except ArgumentError:
        raise KinematicsError(f"{where}{far_words(six)}", index=(row,)) from None


def _drawn(folder: Path, made: VirtualMachine, run: MachineRun) -> Path:
    """Draw a run into a folder; returns the picture's path."""
    from hexathermal.show.figures import save_figure
    from hexathermal.show.hexapod_figures import simulated_run_figure

    return save_figure(simulated_run_figure(made, run), folder / f"{run.name}.png")


def _shown(
    arguments: argparse.Namespace, made: VirtualMachine, plans: tuple[MachinePlan, ...],
    summaries: list[dict[str, Any]], extra: list[Path],
) -> tuple[Any, ...]:  # fmt: skip
    """Return what is said of a campaign."""
    from hexathermal.show.tables import framed

    def table(pretty: bool, _width: int | None) -> Any:
        """Return the runs as a table."""
        found = framed(pretty, "run", "role", "hours>", "poses>", "legs\nK>", "platform\nK>", "base\nK>",
                       "shift\num>", "RMS\num>", "turn\nurad>", "RMS\nurad>")  # fmt: skip
        for item in summaries:
            found.add_row(
                item["name"], item["role"], f"{item['hours']:.2f}", f"{item['poses']}",
                f"{item['largest_leg_rise_K']:.2f}", f"{item['largest_platform_rise_K']:.2f}",
                f"{item['largest_base_rise_K']:.2f}", f"{item['largest_shift_um']:.2f}", f"{item['rms_shift_um']:.2f}",
                f"{item['largest_turn_urad']:.2f}", f"{item['rms_turn_urad']:.2f}",
            )  # fmt: skip
        return found

    first = (
        f"Machine {made.hexapod.name or arguments.machine} on the virtual stand, seed {arguments.seed}: "
        f"{len(plans)} runs, thermometers {', '.join(made.columns[: len(made.sensors)])} ... on each leg.\n"
        "legs, platform, base: largest rise; shift and turn: largest and RMS distance of the measured from the "
        "commanded pose."
    )
    last = GROWN[made.growth] + f"\nWritten:\n  {arguments.out}: campaign.toml, hexapod.toml and {len(plans)} runs"
    last += "".join(f"\n  {file}" for file in extra)
    if arguments.truth is None:
        last += "\nWhat it truly was made of is not kept (--truth FILE keeps it; the same --seed makes the same again)."
    return (first, table, last)
