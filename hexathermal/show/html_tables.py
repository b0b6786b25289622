"""Tables of the command line as tables of a page."""

from __future__ import annotations

import re
from collections.abc import Sequence

from rich.table import Table

from hexathermal.show.diagnosis_page import table


def from_table(shown: Table, caption: str = "", *, without: Sequence[int] = (), named: Sequence[int] = ()) -> str:
    """Return a table of the command line as HTML.

    Parameters
    ----------
    shown : rich.table.Table
    caption : str
        Default: the first column's name, which is that of the whole in tables of two columns without a second name.
    without : sequence of int
        Columns that are left out.
    named : sequence of int
        Rows that stand out.

    Examples
    --------
    >>> from hexathermal.show.tables import framed
    >>> shown = framed(True, "run", "RMSE um>")
    >>> shown.add_row("warm up", "0.12")
    >>> '<th scope="row">warm up</th><td class="n">0.12</td>' in from_table(shown, "Runs")
    True
    """
    kept = [column for k, column in enumerate(shown.columns) if k not in without]
    heads = [" ".join(str(column.header).split()) for column in kept]
    if len(heads) == 2 and not heads[1]:
        caption, heads = caption or heads[0], ["what", "value"]
    heads = [head or "value" for head in heads]
    numbers = [">" if column.justify == "right" else "" for column in kept]
    rows = list(zip(*([str(cell) for cell in column.cells] for column in kept), strict=True))
    for k, (first, *others) in enumerate(rows):
        # on a terminal an empty name means the one above
        rows[k] = (first or (rows[k - 1][0] if k else ""), *map(_unbroken, others))
    return table(caption or heads[0], [a + b for a, b in zip(heads, numbers, strict=True)], rows, named)


def _unbroken(cell: str) -> str:
    """Return a cell in which an interval stays on one line, with the signs that a page has for arrow and infinity.

    Examples
    --------
    >>> _unbroken("0.1 to 0.2 K") == "0.1\N{NO-BREAK SPACE}to\N{NO-BREAK SPACE}0.2\N{NO-BREAK SPACE}K"
    True
    >>> _unbroken("up to 3 rows of the run")
    'up to 3 rows of the run'
    >>> _unbroken("4 -> 0.87").split(), _unbroken("inf")
    (['4', '→', '0.87'], '∞')
    """
    if cell in ("inf", "-inf"):
        return cell.replace("inf", "\N{INFINITY}")
    if re.fullmatch(r"[-+]?\S+ -> [-+]?\S+", cell):
        return cell.replace(" -> ", "\N{NO-BREAK SPACE}\N{RIGHTWARDS ARROW}\N{NO-BREAK SPACE}")
    return cell.replace(" ", "\N{NO-BREAK SPACE}") if re.match(r"[-+]?\d\S*( %)? to [-+]?\d\S*( \S+)?$", cell) else cell
