"""``hexathermal correct``: corrected leg lengths of a trajectory."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, Any

from hexathermal.poses import CONVENTIONS
from hexathermal.show.commands import Answer, Progress
from hexathermal.show.options import COMPILE_TIME, EXIT_CODES, MACHINE, STYLE, add_frames, frames_of, machine, path

if TYPE_CHECKING:
    from hexathermal.predict.trajectory import TrajectorySummary


def _others(convention: str) -> str:
    """Return the other names of a convention."""
    return ", ".join(name for name, meant in CONVENTIONS.items() if meant == convention != name)


CORRECT = """\
Corrected leg lengths for every pose of a trajectory. Files of any length are read and written in blocks; the result
appears whole or not at all. A bad row stops the run and is reported with its line, column and value.
"""

CORRECT_EPILOG = f"""\
files are CSV (commas, decimal points, one header line, UTF-8), or Parquet where the name ends in .parquet:
  --poses  x_mm, y_mm, z_mm, rx_deg, ry_deg, rz_deg   the wanted pose, counted from the machine's home
           time_s                                      optional, increasing
           other columns are copied to the result
  --temps  one column NAME_degC for each thermometer of the machine ('hexathermal show-machine' lists them);
           for the reference machine leg1_T1_degC to leg6_T1_degC
           time_s                                      optional, increasing
           other columns are not used, and listed
  --out    time_s if given, the wanted pose, leg1_length_mm to leg6_length_mm (between the joint centres),
           leg1_q_mm to leg6_q_mm (stroke: length minus retracted length q0), and corrected_x_mm to corrected_rz_deg
           (for controllers that take poses only: the pose whose nominal leg lengths are the corrected ones)

which temperatures go with which pose:
  one row of temperatures       it serves all poses
  time_s in both files          temperatures are interpolated linearly; poses outside their time span are refused
  otherwise                     row k goes with row k; both files must have as many rows

a law that remembers ('hexathermal apply' names what: a lag, stored heat, creep, backlash):
  poses need time_s, rows in the order of the motion. Where both files have it, rows of temperatures up to the last pose
  are read, also those that no pose meets: the platform stands at each pose, and moves on between the last row before
  the next pose and that. The legs are taken to be at rest in the first row of all. Where only the temperatures have
  time_s, row k of the poses is taken to be at the time of row k there, with a warning

conventions of the three angles:
  fixed-xyz   R = Rz(rz) Ry(ry) Rx(rx), the default (also called {_others("fixed-xyz")})
  fixed-zyx   R = Rx(rx) Ry(ry) Rz(rz) (also called {_others("fixed-zyx")})
Frames follow user_pose = inv(U) M O: M platform in machine frame, U user frame, O object frame.

Rows outside the legs' strokes, the joints' cones or the maker's travel ([limits] of the machine, counted from home in
the limits' own convention) stop the run with exit code 4. A machine without a thermal law ('thermal: not active' in
'hexathermal machines') cannot be corrected: exit code 2. The first call compiles ({COMPILE_TIME}).

--out ends in .csv or .parquet; its folder must exist. A result file that exists is kept unless --force is given; a file
that is read is never overwritten, nor is a device or a pipe. Links are followed, permissions are kept. The result is
written to NAME.part and renamed; only a killed process (kill -9, power loss) leaves NAME.part behind: remove it then.

examples:
  hexathermal correct --machine reference --poses poses.csv --temps temps.csv --out corrected.csv
  hexathermal correct --machine reference --poses poses.csv --temps temps.csv --out corrected.parquet \\
      --object-frame 0 0 120 0 0 0

{EXIT_CODES}"""


def add(commands: Any) -> None:
    """Declare the command."""
    one = commands.add_parser("correct", help="corrected leg lengths of a trajectory", description=CORRECT,
                              epilog=CORRECT_EPILOG, **STYLE)  # fmt: skip
    one.add_argument("--machine", required=True, **MACHINE)
    for option, what in (("--poses", "wanted poses"), ("--temps", "temperatures"), ("--out", "results")):
        one.add_argument(option, required=True, type=path, metavar="FILE", help=f"{what}, CSV or .parquet")
    add_frames(one)
    one.add_argument("--lengths-only", action="store_true", help="leave out the corrected poses")
    one.add_argument("--force", action="store_true", help="overwrite an existing result file")


def run(arguments: argparse.Namespace, progress: Progress) -> Answer:
    """Correct the leg lengths of a trajectory."""
    from hexathermal.predict.trajectory import correct_trajectory
    from hexathermal.show.tables import trajectory_table

    frames = frames_of(arguments)
    hexapod = machine(arguments.machine)
    progress(0, 0, f"correcting (the first run compiles: {COMPILE_TIME})")
    summary = correct_trajectory(
        hexapod, arguments.poses, arguments.temps, arguments.out, convention=arguments.convention, frames=frames,
        lengths_only=arguments.lengths_only, overwrite=arguments.force,
        progress=lambda done, total: progress(done, total, "correcting"),
    )  # fmt: skip
    return Answer(
        (lambda pretty, _: trajectory_table(summary, pretty),),
        _facts(hexapod.name, summary),
        tuple(f"warning: {text}" for text in summary.warnings),
    )


def _facts(name: str, summary: TrajectorySummary) -> dict[str, Any]:
    """Return what the trajectory was made of, as plain values."""
    from hexathermal.predict.trajectory import POSE_COLUMNS

    spans = zip(POSE_COLUMNS, summary.lowest_pose, summary.highest_pose, strict=True)
    return {
        "machine": name,
        "rows": summary.rows,
        "temperatures_degC": [summary.lowest_degC, summary.highest_degC],
        "pairing": summary.pairing,
        "sensors": list(summary.sensors),
        "largest_correction_um": summary.largest_correction_um,
        "largest_correction_leg": summary.largest_leg,
        "largest_correction_line": summary.largest_line,
        "span": {column: [low, high] for column, low, high in spans},
        "columns_copied": list(summary.copied),
        "columns_not_used": list(summary.unused),
        "notes": list(summary.notes),
        "warnings": list(summary.warnings),
        "written": [str(summary.out)],
    }
