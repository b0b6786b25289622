"""What the command line accepts and what its ``--help`` teaches."""

from __future__ import annotations

import argparse
import re
from decimal import Decimal

from hexathermal.poses import CONVENTIONS
from hexathermal.show.commands import found
from hexathermal.show.options import COMPILE_TIME, EXIT_CODES, MACHINE, STYLE, number, path


def _others(convention: str) -> str:
    """Return the other names of a convention."""
    return ", ".join(name for name, meant in CONVENTIONS.items() if meant == convention != name)


TOP = """\
A Gough-Stewart hexapod drifts when its legs warm up. hexathermal tells which leg lengths to command so that the
platform stands where it should: pose and temperatures in, corrected leg lengths out. It learns the law of a leg from
measurements, tells what is left, and decides whether a machine passes.
"""

TOP_EPILOG = f"""\
first steps:
  hexathermal demo                       a simulated working day: what correction does, with a table and a figure
  hexathermal machines                   the machines that come with the package
  hexathermal show-machine reference     all that is known of one machine
  hexathermal correct --help             correct your own trajectories
  hexathermal simulate bench --help      a virtual test bench; then check, identify, validate, apply
  hexathermal diagnose --help            what the law, or the whole machine, gets wrong and which cause
  hexathermal view                       look at a machine and its drift in three dimensions
  hexathermal budget --help              how far off a warm machine is, why, and what correction leaves
  hexathermal accept --help              does a measured machine meet its specification?
  hexathermal warm-up                    compile everything now ({COMPILE_TIME}), so that later calls are quick

{EXIT_CODES}"""

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

MACHINES_EPILOG = f"""\
Grades: A identified from measurements, B measured, C drawing or published values.
A machine without a thermal law can be moved but not corrected: 'thermal' says 'not active'.

{EXIT_CODES}"""

SHOW = "Geometry, limits, thermal law and sensors of one machine."

SHOW_EPILOG = f"""\
examples:
  hexathermal show-machine reference
  hexathermal show-machine my-machine/hexapod.toml --json

{EXIT_CODES}"""

WARM_UP = f"""\
Compiles every kernel and keeps the result on disk, so that no later call waits for the compiler. Takes {COMPILE_TIME}
the first time and a second afterwards.
"""


_SMALL_NEGATIVE = re.compile(r"-(\d+\.?\d*|\.\d+)[eE][+-]?\d{1,3}", re.ASCII)


def readable(argv: list[str]) -> list[str]:
    """Return arguments with numbers such as ``-1e-3`` written out: argparse would take them for options."""
    return [f"{Decimal(word):f}" if _SMALL_NEGATIVE.fullmatch(word) else word for word in argv]


def parser(version: str) -> argparse.ArgumentParser:
    """Return the parser of the command line."""
    top = argparse.ArgumentParser(prog="hexathermal", description=TOP, epilog=TOP_EPILOG, **STYLE)
    top.add_argument("--version", action="version", version=f"hexathermal {version}")
    commands = top.add_subparsers(dest="command", metavar="COMMAND OPTIONS", title="commands")

    correct = commands.add_parser("correct", help="corrected leg lengths of a trajectory", description=CORRECT,
                                  epilog=CORRECT_EPILOG, **STYLE)  # fmt: skip
    correct.add_argument("--machine", required=True, **MACHINE)
    for option, what in (("--poses", "wanted poses"), ("--temps", "temperatures"), ("--out", "results")):
        correct.add_argument(option, required=True, type=path, metavar="FILE", help=f"{what}, CSV or .parquet")
    correct.add_argument("--convention", choices=sorted(CONVENTIONS), default="fixed-xyz", metavar="NAME",
                         help="of the three angles: fixed-xyz (default) or fixed-zyx, see below")  # fmt: skip
    for frame in ("user", "object"):
        correct.add_argument(f"--{frame}-frame", nargs=6, type=number, default=[0.0] * 6,
                             metavar=("X", "Y", "Z", "RX", "RY", "RZ"),
                             help=f"{frame} frame, mm and deg (default: 0)")  # fmt: skip
    correct.add_argument("--lengths-only", action="store_true", help="leave out the corrected poses")
    correct.add_argument("--force", action="store_true", help="overwrite an existing result file")

    commands.add_parser("machines", help="the bundled machines", description="The bundled machines.",
                        epilog=MACHINES_EPILOG, **STYLE)  # fmt: skip
    show = commands.add_parser("show-machine", help="all that is known of one machine", description=SHOW,
                               epilog=SHOW_EPILOG, **STYLE)  # fmt: skip
    show.add_argument("machine", **MACHINE)
    show.add_argument("--json", action="store_true", help="for other programs: the same as JSON")
    commands.add_parser("warm-up", help="compile everything now", description=WARM_UP, epilog=EXIT_CODES, **STYLE)
    for command in found().values():
        command.add(commands)
    return top
