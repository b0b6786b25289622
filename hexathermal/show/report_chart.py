"""A figure of a report as numbers: one description for the interactive plot, the still picture and the CSV file.

A `Chart` holds panels under each other; a panel holds curves, bars or a matrix. What is drawn is what the chart holds:
long curves are thinned before (`report_thinning`), and the page says so.
"""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from hexathermal.machine.thermal import frozen
from hexathermal.poses import FloatArray
from hexathermal.show.figures import BLUE

if TYPE_CHECKING:
    from matplotlib.figure import Figure

DIGITS = 7
"""Significant digits of a number that is drawn."""

UNITS = {"µm": "um", "µrad": "urad", "°C": "degC", "µm/m/K": "um_per_m_K", "µm/K": "um_per_K", "%": "percent"}
"""Units as people read them, and as names of columns have them; others are alike."""

LOOKS = ("line", "dashed", "dashdot", "dotted", "steps", "dots", "rings", "squares")

SIDES = ("middle right", "top right", "top center", "top left", "middle left", "bottom left", "bottom center",
         "bottom right")  # fmt: skip
"""Round a point by eighths of a turn, from the right over the top."""


@dataclass(frozen=True, eq=False)
class Curve:
    """Numbers against numbers.

    Attributes
    ----------
    name : str
    x, y : array, shape (n,)
        In the units of the panel; NaN breaks a line.
    colour : str
    look : str
        One of `LOOKS`.
    low, high : array, shape (n,), optional
        An interval about `y`.
    labels : tuple of str
        Names of the points, where they have any.
    places : tuple of str
        Where each name stands from its point, one of `SIDES`; without them all stand at the top right.
    written : bool
        Whether names of a few points stand beside them, not only in what is told of a point.
    right : bool
        Whether it belongs to the axis on the right.
    """

    name: str
    x: FloatArray
    y: FloatArray
    colour: str = BLUE
    look: str = "line"
    low: FloatArray | None = None
    high: FloatArray | None = None
    labels: tuple[str, ...] = ()
    places: tuple[str, ...] = ()
    written: bool = True
    right: bool = False

    def __post_init__(self) -> None:
        for name in ("x", "y", "low", "high"):
            value = getattr(self, name)
            if value is not None:
                object.__setattr__(self, name, frozen(np.asarray(value, dtype=np.float64)))


@dataclass(frozen=True, eq=False)
class Bars:
    """A number for each name; stacked upon the bars before where the panel says so."""

    name: str
    names: tuple[str, ...]
    values: FloatArray
    colour: str = BLUE
    mark: bool = False

    def __post_init__(self) -> None:
        object.__setattr__(self, "values", frozen(np.asarray(self.values, dtype=np.float64)))


@dataclass(frozen=True, eq=False)
class Cells:
    """A matrix of numbers; the first row stands at the bottom.

    Attributes
    ----------
    name : str
    columns, rows : tuple of str, or array
        Names, or places along the axes.
    values : array, shape (rows, columns)
    unit : str
    low, high : float
        Of the colours; dark is high where `reversed`.
    reversed : bool
    """

    name: str
    columns: tuple[str, ...] | FloatArray
    rows: tuple[str, ...] | FloatArray
    values: FloatArray
    unit: str
    low: float
    high: float
    reversed: bool = False

    def __post_init__(self) -> None:
        object.__setattr__(self, "values", frozen(np.asarray(self.values, dtype=np.float64)))


@dataclass(frozen=True, eq=False)
class Panel:
    """One pair of axes.

    Attributes
    ----------
    title : str
    marks : tuple of Curve, Bars or Cells
    x, y, right : str
        What the axes tell, without the unit; `right` is empty where there is no axis on the right.
    x_unit, y_unit, right_unit : str
    height : float
        As compared with the other panels.
    across : bool
        Bars lie: names stand on the left.
    log : bool
        The numbers' axis is logarithmic.
    equal : bool
        Both axes have one scale.
    shaded : tuple of (float, float)
        Stretches of x that are shaded.
    line : float, optional
        A level that is marked by a dotted line across the numbers' axis.
    """

    title: str
    marks: tuple[Curve | Bars | Cells, ...]
    x: str = ""
    y: str = ""
    x_unit: str = ""
    y_unit: str = ""
    right: str = ""
    right_unit: str = ""
    height: float = 1.0
    across: bool = False
    log: bool = False
    equal: bool = False
    stacked: bool = False
    shaded: tuple[tuple[float, float], ...] = ()
    line: float | None = None
    x_range: tuple[float, float] | None = None
    y_range: tuple[float, float] | None = None


@dataclass(frozen=True, eq=False)
class Chart:
    """A figure of a report.

    Attributes
    ----------
    name : str
        Of its files, without an ending.
    title : str
    alt : str
        What it shows, for people who do not see it.
    caption : str
    panels : tuple of Panel
    still : callable, optional
        Draws the same numbers by a figure of the house; else `hexathermal.show.report_still` draws the panels.
    shared : bool
        Whether all panels have the same x axis.
    """

    name: str
    title: str
    alt: str
    caption: str
    panels: tuple[Panel, ...]
    still: Callable[[], Figure] | None = None
    shared: bool = False


def labelled(what: str, unit: str) -> str:
    """Return an axis' label.

    Examples
    --------
    >>> labelled("drift", "µm"), labelled("condition number", "")
    ('drift (µm)', 'condition number')
    """
    return f"{what} ({unit})" if unit else what


def file_name(words: str) -> str:
    """Return a name that every file system and address takes, in small letters.

    Examples
    --------
    >>> file_name("run: Warm up/2")
    'run-warm-up-2'
    """
    return re.sub(r"[^a-z0-9_.]+", "-", words.lower()).strip("-.") or "figure"


def column_name(words: str, unit: str) -> str:
    """Return the name of a column, its unit at the end.

    Examples
    --------
    >>> column_name("drift, measured", "µm"), column_name("T07", "°C")
    ('drift_measured_um', 'T07_degC')
    """
    name = re.sub(r"[^\w.+-]+", "_", words).strip("_")
    end = UNITS.get(unit, re.sub(r"\W+", "_", unit))
    return "_".join(part for part in (name, end) if part)


@dataclass(frozen=True, eq=False)
class Column:
    """A column of the numbers that a chart draws."""

    name: str
    cells: tuple[float | str, ...]


def columns_of(chart: Chart) -> list[list[Column]]:
    """Return the numbers that a chart draws as tables, one for each set of rows that belong together.

    Curves that share their x share a table; a matrix is a table of its own.
    """
    tables: list[list[Column]] = []
    xs: list[tuple[str, FloatArray | tuple[str, ...]]] = []
    for panel in chart.panels:
        before = panel.title if len(chart.panels) > 1 and not chart.shared else ""
        for mark in panel.marks:
            if isinstance(mark, Cells):
                tables.append(_matrix(mark, panel))
                xs.append(("", ()))
                continue
            x, others = _x_of(mark, panel), list(_ys_of(mark, panel, before))
            at = _place(xs, x)
            if at == len(tables):
                xs.append(x)
                tables.append([Column(x[0], _plain(x[1]))])
            taken = {column.name for column in tables[at]}
            tables[at] += [Column(_free(name, panel.title, taken), cells) for name, cells in others]
    return tables


def _x_of(mark: Curve | Bars, panel: Panel) -> tuple[str, FloatArray | tuple[str, ...]]:
    """Return the name of the column of x, and its cells."""
    if isinstance(mark, Bars):
        return panel.y if panel.across else panel.x or "name", mark.names
    return column_name(panel.x, panel.x_unit), mark.x


def _place(xs: list[tuple[str, FloatArray | tuple[str, ...]]], x: tuple[str, FloatArray | tuple[str, ...]]) -> int:
    """Return which table has the same x; one more than there are where none has."""
    for k, (name, values) in enumerate(xs):
        if name != x[0] or len(values) != len(x[1]):
            continue
        if isinstance(values, tuple) or isinstance(x[1], tuple):
            if tuple(values) == tuple(x[1]):
                return k
        elif np.array_equal(values, x[1], equal_nan=True):
            return k
    return len(xs)


def _ys_of(mark: Curve | Bars, panel: Panel, before: str) -> Iterator[tuple[str, tuple[float | str, ...]]]:
    """Yield name and cells of the columns of a mark."""
    head = f"{before} " if before else ""
    if isinstance(mark, Bars):
        yield column_name(head + mark.name, panel.x_unit if panel.across else panel.y_unit), _plain(mark.values)
        return
    unit = panel.right_unit if mark.right else panel.y_unit
    if mark.labels:
        yield column_name(f"{head}{mark.name} name", ""), mark.labels
    yield column_name(head + mark.name, unit), _plain(mark.y)
    for end, values in (("low", mark.low), ("high", mark.high)):
        if values is not None:
            yield column_name(f"{head}{mark.name} {end}", unit), _plain(values)


def _matrix(mark: Cells, panel: Panel) -> list[Column]:
    """Return a matrix as a table: the names of its rows, then its columns."""
    rows = mark.rows if isinstance(mark.rows, tuple) else _plain(mark.rows)
    first = Column(column_name(mark.name, mark.unit), rows)
    names = mark.columns if isinstance(mark.columns, tuple) else tuple(f"{value:g}" for value in mark.columns)
    return [first, *(Column(name, _plain(cells)) for name, cells in zip(names, mark.values.T, strict=True))]


def _free(name: str, title: str, taken: set[str]) -> str:
    """Return a name that no column has yet."""
    if name in taken:
        name = column_name(f"{title} {name}", "")
    free, k = name, 2
    while free in taken:
        free, k = f"{name}_{k}", k + 1
    taken.add(free)
    return free


def rounded(value: float, digits: int = DIGITS) -> float:
    """Return a number of so many significant digits."""
    return float(f"{value:.{digits}g}")


def _plain(values: FloatArray | tuple[str, ...]) -> tuple[float | str, ...]:
    """Return cells: rounded numbers, or texts."""
    return values if isinstance(values, tuple) else tuple(rounded(float(value)) for value in values)


def cell(value: float | str) -> str:
    """Return a cell's text; empty for a number that is none."""
    if isinstance(value, str):
        return value
    return f"{value:.{DIGITS}g}" if np.isfinite(value) else ""


def csv_text(tables: Sequence[Sequence[Column]]) -> str:
    """Return tables as CSV, side by side with a column of nothing between them.

    Examples
    --------
    >>> csv_text([[Column("time_h", (0.0, 0.5)), Column("drift_um", (0.0, float("nan")))]]).splitlines()
    ['time_h,drift_um', '0,0', '0.5,']
    """
    text = io.StringIO()
    out = csv.writer(text, lineterminator="\n")
    blocks: list[list[Column]] = []
    for k, columns in enumerate(tables):
        blocks += [[Column("", ())]] if k else []
        blocks.append(list(columns))
    whole = [column for block in blocks for column in block]
    out.writerow([column.name for column in whole])
    for k in range(max((len(column.cells) for column in whole), default=0)):
        out.writerow([cell(column.cells[k]) if k < len(column.cells) else "" for column in whole])
    return text.getvalue()
