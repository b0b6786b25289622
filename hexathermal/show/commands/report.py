"""``hexathermal report``: a campaign, a budget, a diagnosis or a machine as one page for people."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hexathermal.errors import ArgumentError
from hexathermal.show.commands import Answer, Progress
from hexathermal.show.options import EXIT_CODES, STYLE, named, path

if TYPE_CHECKING:
    from hexathermal.show.report_page import Report

REPORT = """\
One HTML page about a measured campaign, an error budget, a diagnosis or a whole machine: words, tables, plots that
can be zoomed. It opens without a network, in light and dark, on a phone, and prints well (print to PDF).
"""

EPILOG = f"""\
what DIR may be:
  folder with campaign.toml     a measured campaign of a leg, a component or a whole hexapod
  folder with hexapod.toml      a machine; or the name of a bundled one
  folder with diagnosis.json    what 'diagnose --report' wrote; or the file of 'diagnose --json'
  folder with budget.csv        what 'budget --out' wrote; or the file of 'budget --json', which tells more

what the page holds:
  campaign   what was measured, run by run; what the check says; for a leg or a component the search for sensors (the
             paper's figures 4, 6, 7), the law, and its proof on runs for validation (figure 8). Without --law that
             is the law of the campaign's own runs for identification; for a hexapod it is that of its machine
  budget     bias, uncertainty, contributions, and the map, path or day that was asked for
  diagnosis  the finding, the likeliest of all that was tried, gain, limits of detection, what to measure next
  machine    geometry, drawing, workspace, thermal law, a warm day with and without correction, the budget

--figures DIR writes each figure as .png, .svg and .csv; the CSV file holds the numbers that are drawn.
Plots need plotly: pip install 'hexathermal[report]'.

examples:
  hexathermal report my-campaign
  hexathermal report my-campaign --law leg.toml --out report.html --figures figures
  hexathermal report reference --out reference.html --json
  hexathermal budget --machine reference --pose 0 0 0 0 0 0 --day --json day.json
  hexathermal report day.json --out day.html

{EXIT_CODES}"""


def add(commands: Any) -> None:
    """Declare the command."""
    one = commands.add_parser("report", help="a campaign, budget, diagnosis or machine as one page",
                              description=REPORT, epilog=EPILOG, **STYLE)  # fmt: skip
    one.add_argument(
        "subject",
        type=named,
        metavar="DIR",
        help="what the report is of: a folder, a file, or a bundled machine; see below",
    )
    one.add_argument("--out", type=path, metavar="FILE", help="the page (default: NAME-report.html in this folder)")
    one.add_argument("--figures", type=path, metavar="DIR", help="write each figure into this folder, which is created")
    one.add_argument(
        "--law",
        type=named,
        metavar="LAW",
        help="of a campaign: leg.toml of 'identify', or a machine for a whole hexapod",
    )
    one.add_argument("--force", action="store_true", help="overwrite an existing page and existing figures")


def run(arguments: argparse.Namespace, progress: Progress) -> Answer:
    """Write a report."""
    from hexathermal.show.outputs import protect
    from hexathermal.show.report import report_of, subject_of
    from hexathermal.show.report_chart import file_name
    from hexathermal.show.report_live import plotly_part

    subject = subject_of(arguments.subject)
    plotly_part("offline")  # before any work
    name = subject.place.resolve().name if subject.place.exists() else str(subject.place)
    out = arguments.out or Path(f"{file_name(name.removesuffix('.json'))}-report.html")
    protect(argparse.Namespace(**vars(arguments) | {"subject": subject.place, "out": out}))  # a name nobody gave, too
    _check(out, arguments)
    progress(0, 0, f"reading {arguments.subject}")
    report = report_of(subject, arguments.law, progress)
    _check_figures(report, arguments)
    return _written(report, out, arguments, progress)


def _check(out: Path, arguments: argparse.Namespace) -> None:
    """Refuse what cannot be written, before any work is done."""
    from hexathermal.predict.table_writing import refuse_no_folder, refuse_no_place, target_of

    if out.suffix.lower() not in (".html", ".htm"):
        raise ArgumentError(f"cannot write {out}: the name of a page ends in .html")
    if target_of(out).exists() and not arguments.force:
        raise ArgumentError(f"{out} exists already; give another name (--out), or --force to replace it")
    refuse_no_folder(out)
    if arguments.figures is not None:
        refuse_no_place(arguments.figures)


def _check_figures(report: Report, arguments: argparse.Namespace) -> None:
    """Refuse figures that are there already."""
    from hexathermal.show.report_files import ENDINGS

    if arguments.figures is None or arguments.force:
        return
    names = [f"{chart.name}{ending}" for chart in report.charts for ending in ENDINGS]
    there = [name for name in names if (arguments.figures / name).exists()]
    if there:
        some = ", ".join(there[:3]) + (f" and {len(there) - 3} more" if len(there) > 3 else "")
        raise ArgumentError(f"{arguments.figures} holds {some} already; give another folder (--figures), or --force")


def _written(report: Report, out: Path, arguments: argparse.Namespace, progress: Progress) -> Answer:
    """Return the answer; where there are figures, they and the page are written here, all or none."""
    from hexathermal.predict.table_writing import written_whole
    from hexathermal.show.report_files import write_figures
    from hexathermal.show.report_page import report_page

    page = report_page(report, progress).encode()
    figures = []
    if arguments.figures is not None:
        with written_whole(out) as part:
            part.write_bytes(page)
            figures = write_figures(report, arguments.figures, progress)
    size = len(page) / 1e6
    lines = [report.finding, *(f"{what}: {value} ({beside})" for what, value, beside in report.pairs),
             *(f"note: {note}" for note in report.notes)]  # fmt: skip
    made = f"Written:\n  {out} ({size:.1f} MB)"
    if figures:
        made += f"\n  {arguments.figures}: {len(figures)} files of {len(report.charts)} figures"
    data = {
        "format": "hexathermal-report/1", "kind": report.kind, "finding": report.finding,
        "figures": [{"name": chart.name, "title": chart.title, "alt": chart.alt} for chart in report.charts],
        "notes": list(report.notes), **report.facts,
        "written": [str(out), *(str(file) for file in figures)] if figures else [],
    }  # fmt: skip
    return Answer(("\n".join(lines),), data, files={} if figures else {out: page}, made=made)
