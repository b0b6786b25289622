"""The page of a report: words, tables, figures that are still on paper and interactive on a screen; one file."""

from __future__ import annotations

import html
import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from importlib.resources import files
from itertools import count
from typing import Any

from hexathermal.show.diagnosis_page import facts, page, paragraph, section, table
from hexathermal.show.diagnosis_pictures import themed_svg
from hexathermal.show.report_chart import Chart, cell, columns_of, csv_text
from hexathermal.show.report_live import DARKER, curves_named, live_text, packed, program
from hexathermal.show.report_still import still_figure
from hexathermal.show.report_thinning import kept_of
from hexathermal.show.svg_size import compact_svg, svg_address

MOST_ROWS = 24
"""Rows of a figure's numbers that the page shows as a table; its CSV file has all."""

MOST_COLUMNS = 19
"""Columns of such a table."""

COARSEST_PT = 0.6
"""Still pictures of the page leave out what moves a line by less [pt]; the files of pictures do not."""

TALL = 1.1
"""A picture that is higher than so many times its width takes more of a sheet of paper."""

KEYS = "arrow keys move the view, plus and minus zoom, 0 shows all again"


@dataclass(frozen=True, eq=False)
class Section:
    """A section of a report: its name, a short title for the list, its heading, and what stands in it.

    `parts` are HTML and charts, in their order.
    """

    name: str
    short: str
    title: str
    parts: tuple[str | Chart, ...]


@dataclass(frozen=True, eq=False)
class Report:
    """A report before it is a page.

    Attributes
    ----------
    kind : str
        What it is of: ``"campaign"``, ``"budget"``, ``"diagnosis"`` or ``"machine"``.
    title : str
        Of the window.
    heading : str
        What the page is about.
    finding : str
        The one sentence that stands first.
    pairs : tuple of (what, value, beside)
        Key figures.
    notes : tuple of str
        Under the key figures.
    sections : tuple of Section
    facts : dict
        Key figures as plain values.
    """

    kind: str
    title: str
    heading: str
    finding: str
    pairs: tuple[tuple[str, str, str], ...]
    sections: tuple[Section, ...]
    notes: tuple[str, ...] = ()
    facts: dict[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Number the figures whose names are alike: files and anchors are called after them."""
        taken: set[str] = set()
        apart = (replace(one, parts=tuple(_named_apart(part, taken) for part in one.parts)) for one in self.sections)
        object.__setattr__(self, "sections", tuple(apart))

    @property
    def charts(self) -> tuple[Chart, ...]:
        """All figures, in their order."""
        return tuple(part for one in self.sections for part in one.parts if isinstance(part, Chart))


def _named_apart(part: str | Chart, taken: set[str]) -> str | Chart:
    """Return a part of a section; a figure whose name is taken with a number behind it, as ``run-1-2``."""
    if isinstance(part, str):
        return part
    name = next(name for n in count(1) if (name := f"{part.name}-{n}" if n > 1 else part.name) not in taken)
    taken.add(name)
    return part if name == part.name else replace(part, name=name)


def report_page(report: Report, progress: Callable[[int, int, str], None] = lambda *_told: None) -> str:
    """Return the whole page of a report, to be written as one file.

    Parameters
    ----------
    report : Report
    progress : callable
        Called as ``progress(done, total, label)``.

    Raises
    ------
    ArgumentError
        plotly is not installed.
    """
    charts, shown, tables = report.charts, list[tuple[str, str, str]](), dict[str, str]()
    drawn = 0
    for one in report.sections:
        body = []
        for part in one.parts:
            if isinstance(part, Chart):
                progress(drawn, len(charts), f"drawing {part.name}")
                body.append(figure_html(part))
                tables[part.name] = csv_text(columns_of(part))
                drawn += 1
            else:
                body.append(part)
        name = f"s-{one.name}"
        shown.append((name, one.short, section(name, one.title, *body)))
    progress(len(charts), len(charts), "writing the page")
    notes = "".join(paragraph(f"Note: {note.rstrip('.')}.", "note") for note in report.notes)
    hint = (
        f'<p class="hint">In a plot, {KEYS}; drag to zoom into a part, double-click to see all.</p>' if charts else ""
    )
    return page(
        report.title, report.heading, report.finding, facts(report.pairs) + notes, shown,
        "Written by hexathermal; the page needs no network. Plots by plotly.js (MIT).",
        style=_beside("report.css"), program=hint and _programs(list(charts), tables),
    ).replace('<main id="content">', f'<main id="content">{hint}', 1)  # fmt: skip


def _programs(charts: list[Chart], tables: dict[str, str]) -> str:
    """Return the scripts of a page, and what they need: each once, compressed."""
    kept = (("plotly", packed(program())), ("plots", packed(live_text(charts))), ("tables", packed(json.dumps(tables))))
    stored = "".join(f'<script id="store-{name}" type="text/plain">{text}</script>' for name, text in kept)
    colours = json.dumps({light.upper(): dark for light, dark in DARKER.items()})
    return (
        f'{stored}<script id="store-colours" type="application/json">{colours}</script>'
        f"<script>{_beside('report.js')}</script>"
    )


def _beside(name: str) -> str:
    """Return a file that stands beside this module."""
    return (files("hexathermal.show") / name).read_text(encoding="utf-8")


def figure_html(chart: Chart) -> str:
    """Return a figure of the page: the still picture, room for the plot, buttons, caption, and its numbers.

    Parameters
    ----------
    chart : Chart
    """
    import matplotlib as mpl

    with mpl.rc_context({"path.simplify_threshold": COARSEST_PT}):
        figure = still_figure(chart)
        svg = compact_svg(themed_svg(figure, chart.name))
    kind = "still tall" if figure.get_figheight() > TALL * figure.get_figwidth() else "still"
    alt, title = html.escape(chart.alt, quote=True), html.escape(chart.title, quote=True)
    curves = "".join(
        f'<button type="button" class="curve" aria-pressed="true" data-curve="{html.escape(html.escape(name, False))}" '
        f'data-colour="{colour}">{html.escape(name)}</button>'
        for name, colour in curves_named(chart)
    )
    legend = f'<fieldset aria-label="Shown in {title}">{curves}</fieldset>' if curves else ""
    return (
        f'<h3>{html.escape(chart.title)}</h3><figure id="{chart.name}" data-plot>'
        f'<img class="{kind}" src="{svg_address(svg)}" alt="{alt}">'
        f'<div class="live" tabindex="0" role="application" aria-roledescription="plot" '
        f'aria-label="{alt} Interactive: {KEYS}."></div>'
        f'<div class="tools">{legend}'
        f'<button type="button" data-do="+" aria-label="Zoom in: {title}">+</button>'
        f'<button type="button" data-do="-" aria-label="Zoom out: {title}">&minus;</button>'
        f'<button type="button" data-do="0" aria-label="Show all again: {title}">All</button>'
        f'<button type="button" class="save" aria-label="Save the numbers as CSV: {title}">CSV</button></div>'
        f"<figcaption>{html.escape(chart.caption or chart.title)}</figcaption>{_numbers(chart)}</figure>"
    )


def _numbers(chart: Chart) -> str:
    """Return the numbers of a figure as tables that open; long ones with some rows, evenly."""
    tables, found = [], columns_of(chart)
    for number, columns in enumerate(found, 1):
        shown = columns[:MOST_COLUMNS]
        count = len(columns[0].cells)
        rows = [[cell(column.cells[k]) for column in shown] for k in kept_of(count, MOST_ROWS)]
        said = f"Numbers of {chart.title}" + (f", table {number} of {len(found)}" if len(found) > 1 else "")
        said += f": {len(rows)} of {count} rows" if len(rows) < count else ""
        if len(shown) < len(columns):
            said += f", {len(shown)} of {len(columns)} columns"
        heads = [column.name + ("" if _texts(column.cells) else ">") for column in shown]
        tables.append(table(said, heads, rows))
    return f'<details class="data"><summary>Numbers of this figure</summary>{"".join(tables)}</details>'


def _texts(cells: Sequence[float | str]) -> bool:
    """Return whether cells are texts."""
    return any(isinstance(one, str) for one in cells)
