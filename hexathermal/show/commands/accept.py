"""``hexathermal accept``: does a machine meet its specification?"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from hexathermal.errors import ArgumentError
from hexathermal.show.commands import Answer, Progress
from hexathermal.show.options import STYLE, add_frames, frames_of, path

ERROR_CODE = 3
"""Every error, wrong usage too: 1 and 2 are verdicts."""

ACCEPT = """\
Hold measured poses against a specification: pose accuracy and repeatability with their drift (ISO 9283), environmental
variation and warm-up distortion (ISO 230-3), each decided with its uncertainty (ISO 14253-1 and other rules).
"""

EPILOG = """\
MEASURED.csv (or .parquet): one row for each visit of a pose, commas, decimal points, one header line
  x_mm, y_mm, z_mm, rx_deg, ry_deg, rz_deg       commanded pose
  measured_x_mm ... measured_rz_deg              measured pose; the three angles may be left out together
  pose                                           optional name; without it rows with the same command are one pose
  group                                          groups of visits in the order of time, for drift
  cycle                                          optional; a cycle visits a pose once
  time_s                                         increasing; for ETVE, d60 and dt
  NAME_degC                                      temperatures, told beside ETVE
  u_position_um, u_rotation_urad                 optional standard uncertainty of each measured coordinate

SPEC.toml:
  format = "hexathermal-spec/1"
  title = "Hexapod 12"
  rule = "iso-14253-1"          # default; others: iso-14253-1:1998 (U rule), simple, ilac-g8, ilac-g8-guard-band
  probability = 0.95            # default, of iso-14253-1
  [uncertainty]                 # standard uncertainty of every quantity that states none; never taken as 0
  position_um = 0.3
  rotation_urad = 1.0
  [limits]
  AP_um = 10.0
  RP_um = { upper = 2.0, U = 0.4, k = 2 }
  AP_rz_urad = { within = 20.0, u = 1.5 }
  ETVE_z_um = { upper = 3.0, window_s = 3600 }
quantities (with _um, or _urad for turns; all keys: docs/acceptance.md):
  AP, AP_x .. AP_rz, AP_rotation   pose accuracy            RP, RP_rx .. RP_rz, RP_rotation   repeatability
  dAP, dAP_x .. dAP_rz, shift      its drift over groups    dRP, dRP_rx .. dRP_rz             its drift over groups
  ETVE_x .. ETVE_rz                largest range in any window (the whole record where window_s is left out)
  d60_x .. d60_rz, dt_x .. dt_rz   change after 60 minutes, and at the end
  AP, RP: ISO 9283; dAP, dRP: their drift.  ETVE: environmental temperature variation error, d60, dt: distortion while
  warming up (ISO 230-3)
  AP_rx: turn about an axis.  AP_angle_rx: difference of the angle rx, which is ISO's AP_a, AP_b or AP_c; the letters
  themselves need letters = "zyx" (a is rz, b is ry, c is rx) or "xyz"; likewise for the other quantities of turns

examples:
  hexathermal accept measured.csv --spec spec.toml
  hexathermal accept measured.csv --spec spec.toml --junit accept.xml --json accept.json

exit codes:
  0    pass: every limit is met
  1    fail: at least one limit is not met
  2    not decided: the uncertainty is too large for these values
  3    no verdict: wrong usage, bad input, a result file that cannot be written, or any other error
  130  interrupted (Ctrl-C, SIGTERM, SIGHUP); nothing half-written is left
Errors are one message on stderr. HEXATHERMAL_TRACEBACK=1 in the environment shows where they come from.
"""


def add(commands: Any) -> None:
    """Declare the command."""
    accept = commands.add_parser("accept", help="does a machine meet its specification?", description=ACCEPT,
                                 epilog=EPILOG, **STYLE)  # fmt: skip
    accept.add_argument("measured", type=path, metavar="MEASURED", help="measured poses, CSV or .parquet")
    accept.add_argument("--spec", required=True, type=path, metavar="FILE", help="limits and decision rules")
    add_frames(accept, "axes in which poses are judged", "the point that is judged: the tool")
    accept.add_argument("--junit", type=path, metavar="FILE",
                        help="write JUnit XML for test systems; an earlier one is replaced")  # fmt: skip
    accept.add_argument("--force", action="store_true", help="overwrite files that are no earlier results")


def run(arguments: argparse.Namespace, progress: Progress) -> Answer:
    """Hold measured poses against a specification."""
    from hexathermal.predict.acceptance import accept, read_measured_poses, read_specification
    from hexathermal.show.acceptance_tables import CODES, acceptance_data, results_table, verdict_lines
    from hexathermal.show.junit import junit

    _check_targets(arguments)
    progress(0, 0, "reading")
    specification = read_specification(arguments.spec)
    measured = read_measured_poses(arguments.measured, arguments.convention, frames_of(arguments))
    acceptance = accept(measured, specification)
    return Answer(
        shown=(lambda pretty, _: results_table(acceptance, pretty), verdict_lines(acceptance)),
        data=acceptance_data(acceptance),
        warnings=tuple(f"note: {note}" for note in acceptance.notes),
        code=CODES[acceptance.verdict],
        files={} if arguments.junit is None else {arguments.junit: junit(acceptance)},
    )


def _check_targets(arguments: argparse.Namespace) -> None:
    """Refuse result files that are read, that are one and the same, or that are no earlier results."""
    from hexathermal.predict.table_writing import refuse_no_folder
    from hexathermal.show.junit import is_junit

    targets = {"--junit": arguments.junit, "--json": None if arguments.json in (None, "-") else Path(arguments.json)}
    named = {name: target for name, target in targets.items() if target is not None}
    for name, target in named.items():
        if target.exists() and any(
            target.samefile(file) for file in (arguments.measured, arguments.spec) if file.exists()
        ):
            raise ArgumentError(f"will not write {target} ({name}): it is one of the files that are read")
    if len(named) == 2 and len({target.resolve() for target in named.values()}) == 1:
        raise ArgumentError("--junit and --json name the same file; give two names")
    if arguments.junit is not None:
        refuse_no_folder(arguments.junit)
    if (there := arguments.junit) is not None and there.is_file() and not arguments.force and not is_junit(there):
        raise ArgumentError(
            f"--junit {there} exists and is no earlier JUnit XML; give another name, or --force to replace it"
        )
