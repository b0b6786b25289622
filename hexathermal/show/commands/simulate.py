"""``hexathermal simulate``: virtual benches that write what real ones would."""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator
from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hexathermal.errors import ArgumentError
from hexathermal.show.commands import Answer, Progress
from hexathermal.show.hexapod_simulation import add_machine, answer
from hexathermal.show.options import EXIT_CODES, SEED, STYLE, number, path, whole

if TYPE_CHECKING:
    from hexathermal.simulate.bench.bench import Bench, BenchRun, RunPlan

IDENTIFICATION, VALIDATION = 8, 3
LARGEST_COUNT = 999

SIMULATE = """\
Simulates measurements, for planning a campaign and for trying out what is made of one. What is written looks measured;
what it truly was made of goes to a file of its own, and only where one is asked for.
"""

SIMULATE_EPILOG = f"""\
examples:
  hexathermal simulate bench --out DIR     a leg on a test bench: thermocouples, interferometers, room
  hexathermal simulate machine --out DIR   a whole hexapod before a 6-D positioning system

{EXIT_CODES}"""

BENCH = """\
A leg on the test bench of Robert et al.: fixed body with motor and nut, sliding rod with scale, seventeen
thermocouples, three interferometers, a room within 2 K. It works and rests, warms by some 5 K and grows by up to some
8 um. Heat flows by finite volumes along the leg; every number has a name, a unit and a source
(docs/virtual-bench.md).
"""

BENCH_EPILOG = f"""\
written into the folder of --out:
  campaign.toml      format hexathermal-campaign/1, kind leg: runs and their roles, thermocouples, beams
  runs/run-01.csv    a row every --interval seconds: time_s, q_mm, settled, T01_degC ... T17_degC, beam1_mm beam2_mm
                     beam3_mm, air_temperature_degC, air_pressure_hPa, air_humidity_percent
The folder appears whole or not at all. One that holds something else is never touched; one that holds a campaign is
replaced with --force only, since nobody can tell a simulated campaign from a measured one.

a table for --scenario (CSV, or Parquet by its name) has a header and two columns or more:
  time_s, q_mm       the first row says where the rod rests; a row with another q_mm starts a move there; the last
                     row's time ends the run. The rod moves at 2 mm/s within its stroke of 0 to 250 mm
  air_temperature_degC, air_pressure_hPa, air_humidity_percent
                     optional: the room, linear between the rows; drawn where they are not given
Given once or several times; the runs take the tables in turn. Without --runs and --validation there is one run to
identify for each table, and one to validate.

examples:
  hexathermal simulate bench --out campaign
  hexathermal simulate bench --out campaign --seed 7 --truth campaign-truth.json --plots campaign-plots
  hexathermal simulate bench --out short --runs 2 --validation 1 --hours 4 --interval 10 --not-compensated
  hexathermal simulate bench --out mine --scenario monday.csv --scenario tuesday.csv

{EXIT_CODES}"""


def add(commands: Any) -> None:
    """Declare the command and what can be simulated."""
    simulate = commands.add_parser("simulate", help="a virtual bench writes a campaign", description=SIMULATE,
                                   epilog=SIMULATE_EPILOG, **STYLE)  # fmt: skip
    kinds = simulate.add_subparsers(dest="what", metavar="WHAT OPTIONS", title="what is simulated")
    bench = kinds.add_parser("bench", help="a leg on a test bench", description=BENCH, epilog=BENCH_EPILOG, **STYLE)
    bench.add_argument(
        "--out", required=True, type=path, metavar="DIR", help="folder of the campaign, which is created"
    )
    bench.add_argument("--runs", type=whole(0, LARGEST_COUNT), metavar="N",
                       help=f"runs to identify a law (default: {IDENTIFICATION})")  # fmt: skip
    bench.add_argument("--validation", type=whole(0, LARGEST_COUNT), metavar="N",
                       help=f"runs to validate it, never fitted (default: {VALIDATION})")  # fmt: skip
    bench.add_argument("--hours", type=number, metavar="H", help="length of every run (default: 4 to 6, drawn)")
    bench.add_argument("--interval", type=number, default=20.0, metavar="S",
                       help="seconds between two rows (default: %(default)g)")  # fmt: skip
    bench.add_argument("--seed", **SEED)
    bench.add_argument("--scenario", type=path, action="append", metavar="FILE",
                       help="move as this table says, see below; may be given again")  # fmt: skip
    bench.add_argument("--not-compensated", action="store_true",
                       help="the lasers do not follow the index of air: weather is in the beams")  # fmt: skip
    bench.add_argument("--parquet", action="store_true", help="write the runs as Parquet, not CSV")
    bench.add_argument("--truth", type=path, metavar="FILE", help="write what truly was, as JSON, outside of --out")
    bench.add_argument("--plots", type=path, metavar="DIR", help="draw every run into this folder, outside of --out")
    bench.add_argument("--force", action="store_true", help="replace the campaign in --out, the truth and the plots")
    add_machine(kinds)


def run(arguments: argparse.Namespace, progress: Progress) -> Answer:
    """Simulate what is asked for."""
    if arguments.what is None:
        raise ArgumentError(
            "what is to be simulated is missing: 'hexathermal simulate bench --out DIR' (a leg on a test bench) or "
            "'hexathermal simulate machine --out DIR' (a whole hexapod); --help tells more"
        )
    check_outside(arguments)
    return _bench(arguments, progress) if arguments.what == "bench" else answer(arguments, progress)


def _bench(arguments: argparse.Namespace, progress: Progress) -> Answer:
    """Simulate a leg on its bench."""
    from hexathermal.predict.table_writing import written_folder, written_whole
    from hexathermal.simulate.bench.bench import simulate_bench
    from hexathermal.simulate.bench.campaign_folder import write_campaign
    from hexathermal.simulate.bench.truth import bench_truth, law_sums, run_summary, run_truth
    from hexathermal.simulate.campaign_writing import check_folder

    bench = _asked(arguments)
    check_folder(arguments.out, arguments.force)
    plans = _plans(arguments, bench)
    summaries: list[dict[str, Any]] = []
    truths: list[dict[str, Any]] = []
    figures: list[Path] = []
    sums: list[Any] = []

    def runs() -> Iterator[BenchRun]:
        """Hand the runs on, and note what is said of them."""
        progress(0, len(plans), "simulating")
        for k, made in enumerate(simulate_bench(bench, arguments.seed, plans)):
            summaries.append(run_summary(made))
            if arguments.truth is not None:
                truths.append(run_truth(made))
                sums.extend([law_sums(bench, made, arguments.seed)] * (made.role == "identification"))
            if pictures is not None:
                figures.append(arguments.plots / _drawn(pictures, bench, made).name)
            yield made
            progress(k + 1, len(plans), f"{made.name} written")

    with (
        nullcontext() if arguments.plots is None else written_folder(arguments.plots, force=arguments.force) as pictures
    ):
        files = write_campaign(arguments.out, bench, plans, runs(), parquet=arguments.parquet, force=arguments.force)
    extra = list(figures)
    if arguments.truth is not None:
        with written_whole(arguments.truth) as part:
            told = bench_truth(bench, arguments.seed, truths, sum(sums) if sums else None)
            part.write_text(json.dumps(told) + "\n", encoding="utf-8")
        extra.append(arguments.truth)
    data = {"folder": str(arguments.out), "seed": arguments.seed, "interval_s": bench.interval,
            "index_compensated": bench.interferometers.index_compensated, "runs": summaries,
            "written": [str(file) for file in (*files, *extra)]}  # fmt: skip
    return Answer(_shown(arguments, bench, summaries, extra), data)


def _asked(arguments: argparse.Namespace) -> Bench:
    """Return the bench that is asked for."""
    from hexathermal.simulate.bench.bench import Bench
    from hexathermal.simulate.bench.interferometers import Interferometers
    from hexathermal.simulate.bench.tables import LONGEST_RUN_H

    if not 1.0 <= arguments.interval <= 600.0:
        raise ArgumentError(f"--interval must be 1 to 600 s, found {arguments.interval:g}")
    if arguments.hours is not None and not 0.5 <= arguments.hours <= LONGEST_RUN_H:
        raise ArgumentError(f"--hours must be 0.5 to {LONGEST_RUN_H:g}, found {arguments.hours:g}")
    if arguments.hours is not None and arguments.scenario:
        raise ArgumentError("--hours and --scenario contradict each other: the table's last row ends the run; drop one")
    beams = Interferometers(index_compensated=not arguments.not_compensated)
    return replace(Bench(), interferometers=beams, interval=arguments.interval)


def check_outside(arguments: argparse.Namespace) -> None:
    """Refuse truth, plots and answer inside the campaign's folder, and those that exist, before any work."""
    from hexathermal.predict.table_writing import refuse_no_folder, refuse_no_place

    folder = arguments.out.resolve()
    answer = None if arguments.json in (None, "-") else Path(arguments.json)
    for option, place in (("--truth", arguments.truth), ("--plots", arguments.plots), ("--json", answer)):
        if place is not None and folder in (place.resolve(), *place.resolve().parents):
            raise ArgumentError(
                f"{option} {place} is inside the campaign's folder {arguments.out}, where nothing may tell that it is "
                "simulated; give a place outside"
            )
    if arguments.truth is not None:
        refuse_no_folder(arguments.truth)
        if arguments.truth.exists() and not arguments.force:
            raise ArgumentError(f"{arguments.truth} exists already; give another name, or --force to replace it")
    if arguments.plots is not None:
        refuse_no_place(arguments.plots)
        old = sorted(arguments.plots.glob("run-*.png"))
        if old and not arguments.force:
            raise ArgumentError(f"{arguments.plots} holds {old[0].name} already; give another folder, or --force")


def _plans(arguments: argparse.Namespace, bench: Bench) -> tuple[RunPlan, ...]:
    """Return the runs that are asked for."""
    from hexathermal.simulate.bench.bench import planned_runs, roles
    from hexathermal.simulate.bench.tables import given_plans, read_scenario

    tables = tuple(read_scenario(file, bench) for file in arguments.scenario or ())
    default = (len(tables), 1) if tables else (IDENTIFICATION, VALIDATION)
    identification = default[0] if arguments.runs is None else arguments.runs
    validation = default[1] if arguments.validation is None else arguments.validation
    if identification + validation < 1:
        raise ArgumentError("nothing to simulate: --runs and --validation are both 0; give at least one run")
    if tables:
        return given_plans(tables, roles(identification, validation), bench, arguments.seed)
    duration = None if arguments.hours is None else arguments.hours * 3600.0
    return planned_runs(bench, arguments.seed, identification=identification, validation=validation, duration=duration)


def _drawn(folder: Path, bench: Bench, made: BenchRun) -> Path:
    """Draw a run into a folder; returns the picture's path."""
    from hexathermal.show.bench_figures import run_figure
    from hexathermal.show.figures import save_figure

    return save_figure(run_figure(bench, made), folder / f"{made.name}.png")


def _shown(
    arguments: argparse.Namespace, bench: Bench, summaries: list[dict[str, Any]], extra: list[Path]
) -> tuple[Any, ...]:
    """Return what is said of a campaign."""
    from hexathermal.show.tables import framed

    def table(pretty: bool, _width: int | None) -> Any:
        """Return the runs as a table."""
        found = framed(pretty, "run", "role", "hours>", "rows>", "settled\n%>", "q\nmm>", "rise\nK>", "room\ndegC>",
                       "drift\num>", "mean drift\num>")  # fmt: skip
        for item in summaries:
            found.add_row(
                item["name"], item["role"], f"{item['hours']:.2f}", f"{item['rows']}", f"{item['settled_percent']:.0f}",
                f"{item['q_lowest_mm']:.0f} to {item['q_highest_mm']:.0f}", f"{item['largest_rise_K']:.2f}",
                f"{item['room_lowest_degC']:.2f} to {item['room_highest_degC']:.2f}",
                f"{item['largest_drift_um']:.2f}", f"{item['mean_drift_um']:.2f}",
            )  # fmt: skip
        return found

    air = "applied by the lasers" if bench.interferometers.index_compensated else "NOT applied: weather is in the beams"
    first = (
        f"A leg on the virtual bench, seed {arguments.seed}; a row every {bench.interval:g} s; index of air {air}.\n"
        "rise: largest of any thermocouple; drift: largest and mean, settled rows, as measured."
    )
    if not bench.interferometers.index_compensated:
        first += " It holds the index of air until that is corrected."
    last = f"Written:\n  {arguments.out}: campaign.toml and {len(summaries)} run{'s' if len(summaries) != 1 else ''}"
    last += "".join(f"\n  {file}" for file in extra)
    if arguments.truth is None:
        last += "\nWhat it truly was made of is not kept (--truth FILE keeps it; the same --seed makes the same again)."
    return (first, table, last)
