"""Pictures of a report: wide for a desk and narrow for a phone, each in the reader's light or dark colours.

An SVG file that a page shows as a picture knows the reader's colour scheme: its colours are variables that a rule for
dark schemes sets anew. Letters are drawn as curves, so that a page looks alike everywhere and asks for no font.
"""

from __future__ import annotations

import html
import io
import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hexathermal.show.diagnosis_page import running
from hexathermal.show.figures import BLACK, BLUE, GREEN, GREY, PURPLE, STYLE, VERMILION, draw, laid_out
from hexathermal.show.svg_size import compact_svg, svg_address

if TYPE_CHECKING:
    from matplotlib.figure import Figure

WIDE_IN, NARROW_IN = 7.5, 3.75
"""Widths of a picture [in]: at 96 dots an inch a page's column, and a phone."""

PAPER, GRID = "#FFFFFF", "#E4E4E4"
DARK = {
    PAPER: "#171B21", GRID: "#343B44", BLACK: "#E8EAED", GREY: "#A0A7B0", BLUE: "#5DB7EC", VERMILION: "#F28C4E",
    GREEN: "#41C9A0", PURPLE: "#DB92C4",
}  # fmt: skip
"""What each colour becomes in a dark scheme: of the same hue, as far from the paper."""

LOOK: Any = {
    **STYLE,
    "text.color": BLACK,
    "axes.edgecolor": BLACK,
    "axes.labelcolor": BLACK,
    "xtick.color": BLACK,
    "ytick.color": BLACK,
    "figure.facecolor": PAPER,
    "axes.facecolor": PAPER,
    "axes.titlesize": 9.0,
    "legend.fontsize": 8.0,
    "svg.fonttype": "path",
}
"""The house's style, with every colour named, so that it can be changed."""

Drawing = Callable[[float], "Figure"]
"""Draws a figure of a given width [in]."""


@dataclass(frozen=True)
class Picture:
    """A picture of the report.

    Attributes
    ----------
    name : str
        Of the PNG file, without its ending.
    alt : str
        What it shows, for people who do not see it.
    caption : str
    drawing : callable
        ``drawing(width)`` returns the figure [in].
    """

    name: str
    alt: str
    caption: str
    drawing: Drawing

    def drawn(self, png: Path) -> str:
        """Write the picture as PNG and return it as a figure of a page, with both widths inside."""
        figure = laid_out(self.drawing(WIDE_IN))
        wide = svg_address(compact_svg(themed_svg(figure, self.name)))
        draw(figure, png, "png")
        narrow = svg_address(compact_svg(themed_svg(laid_out(self.drawing(NARROW_IN)), self.name)))
        return (
            f'<figure id="{self.name}"><picture><source media="(max-width: 40rem)" srcset="{narrow}">'
            f'<img src="{wide}" alt="{html.escape(self.alt, quote=True)}"></picture>'
            f"<figcaption>{running(self.caption)}</figcaption></figure>"
        )


def themed_svg(figure: Figure, salt: str) -> str:
    """Return a figure as SVG whose colours follow the reader's scheme.

    Parameters
    ----------
    figure : Figure
    salt : str
        The same figure with the same salt gives the same text.
    """
    import matplotlib as mpl

    stream = io.StringIO()
    with mpl.rc_context({"svg.fonttype": "path", "svg.hashsalt": salt}):
        figure.savefig(stream, format="svg", metadata={"Date": None, "Creator": None})
    text = stream.getvalue()
    names = {colour.lower(): f"--c{k}" for k, colour in enumerate(DARK)}
    text = re.sub(r"#[0-9a-f]{6}\b", lambda found: f"var({names[found[0]]})" if found[0] in names else found[0], text)
    light = ";".join(f"--c{k}:{colour}" for k, colour in enumerate(DARK))
    dark = ";".join(f"--c{k}:{colour}" for k, colour in enumerate(DARK.values()))
    rules = f"<style>:root{{{light}}}@media screen and (prefers-color-scheme:dark){{:root{{{dark}}}}}</style>"
    text = _smaller(text)
    return re.sub(r"(<svg\b[^>]*>)", lambda found: found[1] + rules, text[text.index("<svg") :], count=1)


_DOT = r'<use xlink:href="#\w+" x="[^"]*" y="[^"]*" style="{}"/>\s*'


def _smaller(text: str) -> str:
    """Return an SVG text with coordinates of 0.01 pt, and the style of many equal dots said once."""

    def said_once(found: re.Match[str]) -> str:
        style = found[1]
        bare = found[0].replace(f' style="{style}"', "")
        return f'<g style="{style}">{bare}</g>'

    text = re.sub(_DOT.format('([^"]*)') + "(?:" + _DOT.format(r"\1") + ")+", said_once, text)
    short = re.compile(r"-?\d+\.\d{3,}")
    return re.sub(r'(?<= )(?:d|x|y)="[^"]*"',
                  lambda part: short.sub(lambda number: f"{float(number[0]):.2f}", part[0]), text)  # fmt: skip
