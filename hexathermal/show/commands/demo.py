"""``hexathermal demo``: a machine warms through a working day."""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any

import hexathermal
from hexathermal.errors import ArgumentError
from hexathermal.show.commands import Answer, Progress
from hexathermal.show.options import COMPILE_TIME, EXIT_CODES, MACHINE, SEED, STYLE, machine, path

DEMO_FILES = ("day.csv", "day.png", "summary.json")

DEMO = """\
A machine works for 8 hours and rests for 4. Its legs warm up by some 5 K above the room, its plates follow slowly.
For every minute and work pose: leg lengths with and without correction, and where the platform really stands.
The controller knows only what the machine's own thermometers read, with noise and gain errors, and a law whose
coefficients are 3 % (standard deviation) off the true ones. A simulation: nothing of it was measured.
"""

DEMO_EPILOG = f"""\
files written into the folder of --out, which is created:
  day.csv       every minute and work pose: temperatures (degC), corrected leg lengths (mm), and the platform's error
                without and with correction (x y z in um, rx ry rz in urad, base axes)
  day.png       temperatures and errors against time
  summary.json  the largest errors, their reduction, and all numbers of the simulated day
Results of an earlier demo are replaced; files that are no demo's are kept unless --force is given.

examples:
  hexathermal demo
  hexathermal demo --machine my-machine/hexapod.toml --out day1 --seed 7

{EXIT_CODES}"""


def add(commands: Any) -> None:
    """Declare the command."""
    demo = commands.add_parser("demo", help="a machine warms through a working day", description=DEMO,
                               epilog=DEMO_EPILOG, **STYLE)  # fmt: skip
    demo.add_argument("--machine", default="reference", **MACHINE)
    demo.add_argument("--out", type=path, default=Path("hexathermal-demo"), metavar="DIR",
                      help="folder for the results (default: %(default)s)")  # fmt: skip
    demo.add_argument("--seed", **SEED)
    demo.add_argument("--force", action="store_true", help="overwrite files in the folder of --out that no demo wrote")


def run(arguments: argparse.Namespace, progress: Progress) -> Answer:
    """A machine warms through a working day."""
    from hexathermal.predict.budget_plates import blind_plates
    from hexathermal.predict.table_writing import written_folder
    from hexathermal.show.figures import day_figure, draw
    from hexathermal.show.tables import day_table, percent
    from hexathermal.simulate.demonstration import demonstrate, save, summary

    hexapod = machine(arguments.machine)
    folder = _demo_folder(arguments.out, arguments.force)
    progress(0, 0, f"simulating the day (the first run compiles: {COMPILE_TIME})")
    result = demonstrate(hexapod, seed=arguments.seed)
    with written_folder(folder, force=arguments.force) as part:
        made = save(result, part, {"day.png": lambda file: draw(day_figure(result), file, "png")})
    files = [folder / file.name for file in made]
    numbers = summary(result)
    lines = [
        f"Machine {hexapod.name or arguments.machine}: {numbers['hours']:g} h, {numbers['work_poses']} work poses, "
        f"seed {arguments.seed}.\nlegs: mean above the reference temperature; correct: mean correction of the legs;\n"
        "shift and turn: largest error of the platform in any work pose.",
    ]
    for key, what, unit in (("largest_shift_um", "shift", "um"), ("largest_turn_urad", "turn", "urad")):
        pair = numbers[key]
        change = pair["reduction_percent"]
        lines.append(
            f"Largest {what} of the platform: {pair['without']:.2f} {unit} without correction, "
            f"{pair['with']:.2f} {unit} with it: {percent(change)} % {'less' if change >= 0.0 else 'more'}."
        )
    blind = blind_plates(hexapod)
    if blind:
        lines.append(f"No thermometer on: {', '.join(blind)}. Their expansion is part of the error in both columns.")
    lines.append(_demo_bounds(hexapod, numbers["day"]["law_uncertainty"]))
    lines.append("Written:\n" + "\n".join(f"  {file}" for file in files))
    return Answer(
        (lines[0], lambda pretty, width: day_table(result, pretty, width), "\n".join(lines[1:])),
        numbers | {"written": [str(file) for file in files]},
    )


def _demo_bounds(hexapod: hexathermal.Hexapod, uncertainty: float) -> str:
    """Return what the simulated truth knows and what it leaves out: no measurement stands behind it."""
    model = hexapod.thermal
    unmeasured = model is not None and model.base is not None and model.base.sensor is None
    lines = [
        "This is a simulation, not a measurement:",
        f"  - each leg's true A and B are drawn about the law's, {100.0 * uncertainty:g} % standard deviation; the "
        "form of the law is taken as exact",
        "  - a leg has one temperature: lag between thermometer and leg, and gradients along a leg, are not in it",
        "  - temperatures are generic (2 K swing of the room, 5 K rise of the legs), not those of your machine",
    ]
    if unmeasured:
        lines.append("  - the base has no thermometer: it expands about the centre of its joints")
    return "\n".join(lines)


def _demo_folder(folder: Path, force: bool) -> Path:
    """Return the demo's folder; keep files that no demo wrote."""
    from hexathermal.predict.table_writing import refuse_no_place

    refuse_no_place(folder)
    found = [name for name in DEMO_FILES if (folder / name).exists()]
    if found and not force and not _is_demo(folder / "summary.json"):
        raise ArgumentError(
            f"{folder} holds {', '.join(found)}, which no demo wrote; give another folder (--out), or --force"
        )
    return folder


def _is_demo(file: Path) -> bool:
    """Whether a file is the summary of an earlier demo."""
    from hexathermal.simulate.demonstration import FORMAT

    try:
        found = json.loads(file.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return False
    return isinstance(found, dict) and found.get("format") == FORMAT
