"""``python -m benchmarks``: measure everything once, print the tables, exit with 1 where a bar is not met."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from rich.console import Console

from benchmarks import report
from benchmarks.bars import error_bar, other_bars, speed_bars
from benchmarks.case import drawn_case
from benchmarks.contenders import entered
from benchmarks.draws import draw_bar, draw_times
from benchmarks.fresh_processes import MEMORY_METHODS, import_times, memory
from benchmarks.measuring import measured
from benchmarks.sensor_search import measured_search, search_bars

POSES, QUICK_POSES = 1_000_000, 100_000


def _options(arguments: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m benchmarks", description=__doc__)
    parser.add_argument("--quick", action="store_true", help=f"batches of {QUICK_POSES} poses instead of {POSES}")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write all numbers into a file")
    parser.add_argument("--page", type=Path, metavar="FILE", help="write the tables into a documentation page")
    return parser.parse_args(arguments)


def run(poses: int, console: Console) -> report.Outcome:
    """Measure everything."""
    with console.status("poses and true answers") as status:
        case = drawn_case(poses)
        contenders, missing = entered(case)
        measurements = measured(case, contenders, status.update)
        status.update("draws around a pose")
        draws = draw_times(case, poses)
        status.update("search for sensors")
        search = measured_search(poses)
        status.update("imports")
        imports = import_times()
        status.update("memory")
        linux = Path("/proc/self/clear_refs").exists()
        memories = [memory(method, poses) for method in MEMORY_METHODS] if linux else []
    bars = [
        *speed_bars(measurements, missing),
        draw_bar(draws),
        *search_bars(search),
        error_bar(measurements),
        *other_bars(imports, memories, "needs Linux (/proc/self/clear_refs)"),
    ]
    notes = {contender.name: contender.note for contender in contenders}
    return report.Outcome(report.processor(), poses, notes, missing, measurements, imports, memories, bars)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the benchmarks; return 1 where a bar is not met."""
    options = _options(arguments)
    console = Console(width=None if sys.stdout.isatty() else 160)
    outcome = run(QUICK_POSES if options.quick else POSES, console)
    report.shown(outcome, console)
    if options.json:
        options.json.write_text(report.as_json(outcome), encoding="utf-8")
    if options.page:
        report.written_into(options.page, outcome)
    return int(outcome.failed)


if __name__ == "__main__":
    sys.exit(main())
