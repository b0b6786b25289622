"""Pieces of a report's page: sections, tables, the page itself with its style; nothing is loaded from elsewhere."""

from __future__ import annotations

import html
import re
from collections.abc import Sequence

CSS = """
:root{color-scheme:light dark;--paper:#fff;--ink:#1a1a1a;--soft:#5c5c5c;--line:#dedede;--panel:#f5f6f8;--accent:#0072b2;
--warm:#b24a00;--shade:#c4c8ce}
@media screen and (prefers-color-scheme:dark){:root{--paper:#171b21;--ink:#e8eaed;--soft:#a9b0b9;--line:#343b44;
--panel:#1f252d;--accent:#5db7ec;--warm:#f28c4e;--shade:#4a535e}}
*{box-sizing:border-box}
html{-webkit-text-size-adjust:100%;scroll-behavior:smooth}
@media (prefers-reduced-motion:reduce){html{scroll-behavior:auto}}
body{margin:0;background:var(--paper);color:var(--ink);font:1rem/1.55 system-ui,-apple-system,"Segoe UI",Roboto,
"Liberation Sans",sans-serif}
main,header,footer,nav{max-width:50rem;margin:0 auto;padding:0 1rem}
header{padding-top:2rem}
h1{font-size:1.05rem;font-weight:600;color:var(--soft);margin:0 0 .4rem}
.finding{font-size:1.4rem;line-height:1.35;font-weight:600;margin:0 0 1rem;text-wrap:pretty}
h2{font-size:1.3rem;margin:2.6rem 0 .5rem;padding-top:.9rem;border-top:1px solid var(--line);scroll-margin-top:.5rem}
h3{font-size:1.05rem;margin:1.6rem 0 .3rem}
p{margin:.5rem 0;max-width:44rem}
a{color:var(--accent)}
a:focus-visible,[tabindex]:focus-visible{outline:3px solid var(--accent);outline-offset:2px}
.skip{position:absolute;left:-99rem}
.skip:focus{left:1rem;top:.5rem;background:var(--paper);padding:.4rem .8rem;z-index:2}
nav ul{list-style:none;display:flex;flex-wrap:wrap;gap:.3rem 1.1rem;padding:0;margin:1rem 0 0;font-size:.92rem}
dl.facts{display:grid;grid-template-columns:repeat(auto-fit,minmax(10rem,1fr));gap:.7rem;margin:1.2rem 0}
dl.facts div{background:var(--panel);border-radius:.5rem;padding:.6rem .8rem}
dt{font-size:.82rem;color:var(--soft)}
dd{margin:0;font-size:1.15rem;font-weight:600;font-variant-numeric:tabular-nums}
dd small{font-size:.82rem;font-weight:400;display:block}
.scroll{overflow-x:auto;margin:.8rem 0;--cover:var(--paper);background:
linear-gradient(90deg,var(--cover) 40%,transparent) 0 0/2rem 100% no-repeat local,
linear-gradient(270deg,var(--cover) 40%,transparent) 100% 0/2rem 100% no-repeat local,
linear-gradient(90deg,var(--shade),transparent) 0 0/.7rem 100% no-repeat scroll,
linear-gradient(270deg,var(--shade),transparent) 100% 0/.7rem 100% no-repeat scroll}
.card .scroll{--cover:var(--panel)}
table{border-collapse:collapse;width:100%;font-size:.92rem;font-variant-numeric:tabular-nums}
caption{text-align:left;color:var(--soft);font-size:.88rem;padding-bottom:.3rem}
th,td{text-align:left;vertical-align:top;padding:.32rem .9rem .32rem 0;border-bottom:1px solid var(--line)}
thead th{font-size:.84rem;color:var(--soft);vertical-align:bottom}
tbody th{font-weight:500;min-width:9.5rem}
td.n,th.n{text-align:right}
td:last-child:not(.n){min-width:8rem}
.card td:last-child:not(.n){min-width:0}
.dense th,.dense td{padding-right:.5rem}
.dense td,.dense tbody th{font-size:.86rem}
.dense tbody th{min-width:4rem}
.dense td:last-child:not(.n){min-width:4.5rem}
tr.named th,tr.named td{color:var(--warm);font-weight:650}
figure{margin:1.1rem 0 1.6rem}
figure img{display:block;width:100%;height:auto}
figcaption{color:var(--soft);font-size:.9rem;margin-top:.3rem;max-width:44rem}
.card{background:var(--panel);border-left:4px solid var(--warm);border-radius:0 .5rem .5rem 0;padding:.2rem 1rem .6rem;
margin:1rem 0}
.card h3{margin-top:.8rem}
.note{max-width:none;background:var(--panel);border-left:4px solid var(--accent);border-radius:0 .5rem .5rem 0;
padding:.5rem 1rem;margin:.8rem 0}
ol.next li{margin:.5rem 0}
ol.next small{display:block;color:var(--soft)}
footer{color:var(--soft);font-size:.88rem;padding:2rem 1rem 3rem}
@media (max-width:40rem){.finding{font-size:1.15rem}h2{font-size:1.15rem}table{font-size:.86rem}
th,td{padding-right:.6rem}
tbody th{min-width:6.5rem}td:last-child:not(.n){min-width:9rem}.card tbody th,.card td:last-child:not(.n){min-width:0}}
@media screen and (max-width:40rem){.stacked,.stacked caption,.stacked tbody,.stacked tr{display:block}
.stacked tbody th{display:block}
.stacked thead{position:absolute;width:1px;height:1px;overflow:hidden;clip-path:inset(50%)}
.stacked tr{border-bottom:1px solid var(--line);padding:.35rem 0}
.stacked tbody th{border:0;padding:.1rem 0;font-weight:600}
.stacked td,.stacked td.n{display:flex;gap:1rem;justify-content:space-between;border:0;padding:.1rem 0;text-align:right;
white-space:normal;overflow-wrap:anywhere}
.stacked td:not(.n){text-align:left}
.stacked td::before{content:attr(data-of);color:var(--soft);font-weight:400;text-align:left;flex:none;max-width:45%}}
@media print{:root{color-scheme:light}nav,.skip{display:none}body{font-size:10pt}main,header,footer{max-width:none}
h2,h3,h2+p:not(:last-child){break-after:avoid}figure,tr,p,.card,.note{break-inside:avoid}
caption,thead{break-after:avoid}tbody tr:nth-child(-n+2){break-before:avoid}
.scroll{overflow:visible}figure img{max-width:17cm}
@page{size:A4;margin:16mm 15mm}}
"""
"""The page's style: one column, the reader's colour scheme, paper."""


LETTERS = (
    (r"(?<!-)\bu(m|rad)\b", r"µ\1"),
    (r"\bK\^2\b", "K²"),
    (r"(?<![-\w])degC\b", "°C"),
    (r"\+-(?=\s?\d)", "±"),
)
"""What words written for a terminal become where people read."""

UNITS = re.compile(r"(?<=\d) (?=(?:%|µm|µrad|mm|nm|m?K|°C|s|min|h)(?![\w-]))")
"""Between a number and its unit no line breaks."""


def text(words: str) -> str:
    """Return words as they stand on a page: escaped, with the letters that a plain terminal lacks.

    Examples
    --------
    >>> text("0.2 um < 1 um/m/K"), text("21 degC +-0.09 K: column T1_degC")
    ('0.2 µm &lt; 1 µm/m/K', '21 °C ±0.09 K: column T1_degC')
    """
    for pattern, letters in LETTERS:
        words = re.sub(pattern, letters, words)
    return html.escape(words)


def running(words: str) -> str:
    """Return words that run over lines, as they stand on a page: a number keeps its unit beside it.

    Examples
    --------
    >>> running("0.2 um, 12 % less").replace(chr(160), "~")
    '0.2~µm, 12~% less'
    """
    return UNITS.sub("\N{NO-BREAK SPACE}", text(words))


def paragraph(words: str, kind: str = "") -> str:
    """Return a paragraph."""
    return f'<p class="{kind}">{running(words)}</p>' if kind else f"<p>{running(words)}</p>"


def section(name: str, title: str, *parts: str) -> str:
    """Return a section with its heading."""
    return f'<section aria-labelledby="{name}"><h2 id="{name}">{text(title)}</h2>{"".join(parts)}</section>'


def table(
    caption: str, columns: Sequence[str], rows: Sequence[Sequence[str]], named: Sequence[int] = (),
    stacked: bool | None = None,
) -> str:  # fmt: skip
    """Return a table: the first column names its row; a column whose name ends in ``>`` holds numbers.

    Parameters
    ----------
    caption : str
    columns : sequence of str
    rows : sequence of sequences of str
    named : sequence of int
        Rows that stand out.
    stacked : bool, optional
        Whether a phone shows a cell in a line; default: where there is no room for its columns.
    """
    stacked = _wide(columns, rows) if stacked is None else stacked
    # a table whose rows are blocks is none to a reader's aid, unless it says so
    role = ' role="{}"' if stacked else ""
    numbers = ["", *(' class="n"' if column.endswith(">") else "" for column in columns[1:])]
    head = "".join(
        f'<th scope="col"{number}{role.format("columnheader")}>{running(column.removesuffix(">"))}</th>'
        for column, number in zip(columns, numbers, strict=True)
    )
    body = []
    for k, row in enumerate(rows):
        first, *others = row
        names = [f' data-of="{text(one.removesuffix(">"))}"' if stacked else "" for one in columns[1:]]
        cells = "".join(
            f"<td{number}{role.format('cell')}{name}>{_number(cell) if number else text(cell)}</td>"
            for cell, number, name in zip(others, numbers[1:], names, strict=True)
        )
        mark = ' class="named"' if k in named else ""
        body.append(
            f'<tr{mark}{role.format("row")}><th scope="row"{role.format("rowheader")}>{text(first)}</th>{cells}</tr>'
        )
    classes = " ".join(["stacked"] * stacked + ["dense"] * (len(columns) > DENSE))
    kind = (f' class="{classes}"' if classes else "") + role.format("table")
    return (
        f'<div class="scroll" role="region" aria-label="{text(caption)}" tabindex="0"><table{kind}>'
        f"<caption>{text(caption)}</caption><thead><tr{role.format('row')}>{head}</tr></thead><tbody>{''.join(body)}</tbody></table></div>"
    )


def _number(cell: str) -> str:
    """Return a cell of a column of numbers: where there is no room, a line breaks before an interval, and nowhere else.

    Examples
    --------
    >>> _number("0.68 (0.61 to 0.74)").replace(chr(160), "~")
    '0.68 (0.61~to~0.74)'
    """
    return text(cell).replace(" ", "\N{NO-BREAK SPACE}").replace("\N{NO-BREAK SPACE}(", " (")


MOST_COLUMNS, LONG, MOST_CELLS, DENSE = 4, 50, 200, 6
"""A table with more columns, or one whose last column tells in words, is stacked on a phone, unless it has more cells.
One with more columns than the last is set closely."""


def _wide(columns: Sequence[str], rows: Sequence[Sequence[str]]) -> bool:
    """Return whether a table has no room on a phone, and is short enough to have each cell on a line of its own."""
    words = len(columns) == MOST_COLUMNS and any(len(row[-1]) > LONG for row in rows)
    return len(rows) * len(columns) <= MOST_CELLS and (len(columns) > MOST_COLUMNS or words)


def facts(pairs: Sequence[tuple[str, str, str]]) -> str:
    """Return key figures: what, value, and what stands beside it."""
    items = "".join(
        f"<div><dt>{text(what)}</dt><dd>{running(value)}<small>{running(beside)}</small></dd></div>"
        for what, value, beside in pairs
    )
    return f'<dl class="facts">{items}</dl>'


def page(
    title: str, heading: str, finding: str, opening: str, sections: Sequence[tuple[str, str, str]], end: str, *,
    style: str = "", program: str = "",
) -> str:  # fmt: skip
    """Return the whole page.

    Parameters
    ----------
    title : str
        Of the window.
    heading : str
        What the page is about.
    finding : str
        The one sentence that stands first.
    opening : str
        HTML between the finding and the list of sections.
    sections : sequence of (name, short title, HTML)
    end : str
        The last line.
    style : str
        Further rules of the page's style.
    program : str
        HTML at the end of the page: what its scripts need, and they.
    """
    links = "".join(f'<li><a href="#{name}">{text(short)}</a></li>' for name, short, _body in sections)
    return (
        '<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1"><meta name="color-scheme" '
        f'content="light dark"><link rel="icon" href="data:,"><title>{text(title)}</title><style>{CSS}{style}</style>'
        "</head><body>"
        f'<a class="skip" href="#content">Skip to the content</a><header><h1>{text(heading)}</h1>'
        f'<p class="finding">{running(finding)}</p>{opening}</header><nav aria-label="Sections"><ul>{links}</ul></nav>'
        f'<main id="content">{"".join(body for _name, _short, body in sections)}</main>'
        f"<footer>{paragraph(end)}</footer>{program}</body></html>\n"
    )
