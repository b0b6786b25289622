"""The report: tables on the terminal, the same as Markdown for the documentation, and all numbers as JSON."""

from __future__ import annotations

import dataclasses
import json
import os
import platform
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

from benchmarks.bars import OURS, Bar, found
from benchmarks.case import Quantity
from benchmarks.fresh_processes import ImportTimes, Memory
from benchmarks.measuring import Measurement

BEGIN, END = "<!-- measured: begin -->", "<!-- measured: end -->"


@dataclass(frozen=True)
class Outcome:
    """Everything that one run found."""

    machine: str
    poses: int
    notes: dict[str, str]
    missing: dict[str, str]
    measurements: list[Measurement]
    imports: list[ImportTimes]
    memories: list[Memory]
    bars: list[Bar]

    @property
    def failed(self) -> bool:
        """Whether a bar that was measured is not met."""
        return any(bar.passed is False for bar in self.bars)


@dataclass(frozen=True)
class Sheet:
    """One table: a title, column heads, rows of text."""

    title: str
    heads: tuple[str, ...]
    rows: Sequence[tuple[str, ...]]


def processor() -> str:
    """Return the processor's model and how many processors this process may use."""
    model = platform.machine()
    info = Path("/proc/cpuinfo")
    if info.exists():
        for line in info.read_text().splitlines():
            if line.startswith("model name"):
                model = line.split(":", 1)[1].strip()
                break
    count = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    return f"{model}, {count} processor" + ("s" if count != 1 else "")


def _error(one: Measurement) -> str:
    """Return the largest errors with their units."""
    if one.quantity is Quantity.POSES:
        return f"{one.errors[0]:.0e} m, {one.errors[1]:.0e}"
    return f"{one.errors[0]:.0e}" + ("" if one.quantity is Quantity.JACOBIANS else " m")


def _rate(one: Measurement, seconds: float) -> str:
    """Return microseconds for one pose, or million poses a second for a batch."""
    return f"{1e-6 / seconds:.3g}" if one.batch else f"{seconds * 1e6:.3g}"


def _versus(one: Measurement, ours: Measurement | None) -> str:
    """Return the ratio of speeds, ours over the other, by the best turns."""
    return "" if ours is None or one.contender == OURS else f"{one.best_seconds / ours.best_seconds:.3g}"


def speed_sheet(measurements: Sequence[Measurement], batch: bool) -> Sheet:
    """Return the table of one pose at a time, or of batches, one processor."""
    unit = "M poses/s" if batch else "us"
    rows = []
    for quantity in Quantity:
        ours = found(measurements, OURS, quantity, batch)
        for one in measurements:
            if (one.quantity, one.batch, one.all_cores) == (quantity, batch, False):
                who = f"{one.contender} ({one.variant})" if one.variant else one.contender
                median, best = _rate(one, one.seconds), _rate(one, one.best_seconds)
                rows.append((quantity.value, who, median, best, _error(one), _versus(one, ours)))
    title = "Batches, one processor" if batch else "One pose a call, one processor"
    heads = ("what", "who", f"median, {unit}", "best", "largest error", "hexathermal : it")
    return Sheet(title, heads, rows)


def all_cores_sheet(measurements: Sequence[Measurement]) -> Sheet:
    """Return the table of batches on all processors."""
    rows = [
        (one.quantity.value, one.contender, _rate(one, one.seconds), _rate(one, one.best_seconds), _error(one))
        for one in measurements
        if one.all_cores
    ]
    heads = ("what", "who", "median, M poses/s", "best", "largest error")
    return Sheet("Batches, all processors, by the clock on the wall", heads, rows)


def process_sheet(imports: Sequence[ImportTimes], memories: Sequence[Memory]) -> Sheet:
    """Return the table of imports and memory."""
    rows = []
    for one in imports:
        seconds = f"{one.seconds * 1e3:.0f} ms (best {one.best_seconds * 1e3:.0f} ms)"
        rows.append((f"import {one.package}", seconds, "compiler loaded" if one.compiler_loaded else "no compiler"))
    for many in memories:
        ratio, added = f"{many.ratio:.2f} times input and output", f"{many.added_bytes / 1e6:.0f} MB added"
        rows.append((f"{many.method}, {many.poses} poses", ratio, added))
    return Sheet("Imports and memory", ("what", "measured", ""), rows)


def bar_sheet(bars: Sequence[Bar]) -> Sheet:
    """Return the table of bars."""
    rows = []
    for bar in bars:
        verdict = {True: "met", False: "NOT MET", None: f"not measured: {bar.reason}"}[bar.passed]
        limit = f"{'>=' if bar.at_least else '<='} {bar.threshold:g}" + (f" (aim {bar.aim:g})" if bar.aim else "")
        rows.append((bar.name, "" if bar.ratio is None else f"{bar.ratio:.3g}", limit, verdict))
    return Sheet("Bars", ("what", "ratio", "bar", ""), rows)


def sheets(outcome: Outcome) -> list[Sheet]:
    """Return all tables of a run."""
    return [
        bar_sheet(outcome.bars),
        speed_sheet(outcome.measurements, batch=False),
        speed_sheet(outcome.measurements, batch=True),
        all_cores_sheet(outcome.measurements),
        process_sheet(outcome.imports, outcome.memories),
    ]


def shown(outcome: Outcome, console: Console) -> None:
    """Print the tables."""
    console.print(f"{outcome.machine}; batches of {outcome.poses} poses")
    for name, note in outcome.notes.items():
        console.print(f"  {name}: {note}", highlight=False)
    for name, reason in outcome.missing.items():
        console.print(f"  [yellow]{name} is left out: {reason}[/]")
    first, *others = sheets(outcome)
    for sheet in (*others, first):
        table = Table(title=sheet.title, title_justify="left")
        numbers = [k for k in range(len(sheet.heads)) if all(_number(row[k]) for row in sheet.rows)]
        for k, head in enumerate(sheet.heads):
            table.add_column(head, justify="right" if k in numbers else "left", overflow="fold")
        for row in sheet.rows:
            style = "red" if row[-1] == "NOT MET" else None
            table.add_row(*row, style=style)
        console.print(table)


def _number(text: str) -> bool:
    try:
        float(text or 0)
    except ValueError:
        return False
    return True


def markdown(outcome: Outcome) -> str:
    """Return the tables as Markdown."""
    lines = [f"Measured on: {outcome.machine}; batches of {outcome.poses} poses.", ""]
    lines += [f"- {name}: {note}" for name, note in outcome.notes.items()]
    lines += [f"- {name} is left out: {reason}" for name, reason in outcome.missing.items()]
    for sheet in sheets(outcome):
        lines += ["", f"### {sheet.title}", "", "| " + " | ".join(sheet.heads) + " |", "|---" * len(sheet.heads) + "|"]
        lines += ["| " + " | ".join(row) + " |" for row in sheet.rows]
    return "\n".join(lines) + "\n"


def written_into(page: Path, outcome: Outcome) -> None:
    """Replace the measured part of a documentation page."""
    text = page.read_text(encoding="utf-8")
    if BEGIN not in text or END not in text:
        raise ValueError(f"{page} has no lines {BEGIN} and {END}: nowhere to write the tables")
    before, rest = text.split(BEGIN, 1)
    page.write_text(f"{before}{BEGIN}\n{markdown(outcome)}{END}{rest.split(END, 1)[1]}", encoding="utf-8")


def as_json(outcome: Outcome) -> str:
    """Return all numbers of a run."""

    def plain(value: Any) -> Any:
        return value.value if isinstance(value, Quantity) else str(value)

    numbers = dataclasses.asdict(outcome)
    for bar, entry in zip(outcome.bars, numbers["bars"], strict=True):
        entry["passed"] = bar.passed
    for memory, entry in zip(outcome.memories, numbers["memories"], strict=True):
        entry["ratio"] = memory.ratio
    return json.dumps(numbers, indent=2, default=plain)
