"""The interactive plot of a report's figure: what plotly draws in the reader's browser, as plain values.

Figures are built, and so checked, by plotly; its program is put into the page once, compressed (`packed`), and the
plots with it. Colours are those for paper; the page turns them into their partners in a dark scheme.
"""

from __future__ import annotations

import base64
import gzip
import html
import json
import math
from importlib import import_module
from typing import Any

import numpy as np

from hexathermal.errors import ArgumentError
from hexathermal.poses import FloatArray
from hexathermal.show.diagnosis_pictures import DARK, GRID
from hexathermal.show.figures import BLACK, GREY
from hexathermal.show.report_chart import Bars, Cells, Chart, Curve, Panel, labelled, rounded

MISSING = "a report needs plotly, which is not installed: pip install 'hexathermal[report]'"

PANEL_PX, BAR_PX, MATRIX_PX, GAP_PX, MATRIX_GAP_PX, TOP_PX, BOTTOM_PX = 210, 22, 400, 76, 96, 30, 56
"""Heights [px]: of a panel, a bar that lies, a matrix, between panels, matrices, above the first and below the last."""

VEIL = "2E"
"""How much of an interval's colour is seen, as a channel of the colour."""

NOTHING = "rgba(0,0,0,0)"
DASHES = {"line": "solid", "steps": "solid", "dashed": "dash", "dashdot": "dashdot", "dotted": "dot"}
SYMBOLS = {"dots": ("circle", 4.0), "rings": ("circle-open", 7.0), "squares": ("square-open", 11.0)}

DARKER = DARK | {"#C0392B": "#F1877B", "#7B4BA8": "#BE9CE8", "#F3F1EA": "#242A31", "#8A6D00": "#D3B24A"}
"""What each colour becomes in a dark scheme; the page lightens those that are not named here until they are seen."""


def plotly_part(name: str) -> Any:
    """Return a module of plotly.

    Raises
    ------
    ArgumentError
        It is not installed.
    """
    try:
        return import_module(f"plotly.{name}")
    except ModuleNotFoundError:
        raise ArgumentError(MISSING) from None


def program() -> str:
    """Return plotly's program for browsers, as the package brings it."""
    text: str = plotly_part("offline").get_plotlyjs()
    return text


def packed(text: str) -> str:
    """Return a text compressed by gzip, in letters.

    Examples
    --------
    >>> packed("a" * 1000) == packed("a" * 1000), len(packed("a" * 1000)) < 60
    (True, True)
    """
    return base64.b64encode(gzip.compress(text.encode(), 9, mtime=0)).decode()


def live_figure(chart: Chart) -> dict[str, Any]:
    """Return what plotly draws of a chart: ``data`` and ``layout``, plain values.

    Parameters
    ----------
    chart : Chart

    Raises
    ------
    ArgumentError
        plotly is not installed.
    """
    graphs = plotly_part("graph_objects")
    heights = [_height(panel) for panel in chart.panels]
    # names below a matrix may stand upright
    gap = MATRIX_GAP_PX if any(isinstance(mark, Cells) for panel in chart.panels for mark in panel.marks) else GAP_PX
    total = sum(heights) + gap * (len(heights) - 1)
    layout: dict[str, Any] = {
        "template": None, "height": total + TOP_PX + BOTTOM_PX, "showlegend": False, "paper_bgcolor": NOTHING,
        "plot_bgcolor": NOTHING, "font": {"color": BLACK, "size": 12, "family": "system-ui, sans-serif"},
        "margin": {"l": 62, "r": 16, "t": TOP_PX, "b": BOTTOM_PX}, "hovermode": "closest", "barmode": "group",
        "annotations": [], "shapes": [], "hoverlabel": {"align": "left", "namelength": 32},
    }  # fmt: skip
    traces: list[dict[str, Any]] = []
    top = float(total)
    for k, (panel, height) in enumerate(zip(chart.panels, heights, strict=True)):
        span = [max(0.0, (top - height) / total), min(1.0, top / total)]
        top -= height + gap
        _panel(panel, k + 1, span, layout, traces, chart.shared and k < len(heights) - 1, chart.shared)
    found: dict[str, Any] = graphs.Figure(_plain({"data": traces, "layout": layout})).to_plotly_json()
    return found


def _height(panel: Panel) -> int:
    """Return the height of a panel [px]."""
    if panel.across:
        return 10 + BAR_PX * max((len(mark.names) for mark in panel.marks if isinstance(mark, Bars)), default=1)
    if panel.equal or any(isinstance(mark, Cells) for mark in panel.marks):
        return round(MATRIX_PX * panel.height)
    return round(PANEL_PX * panel.height)


def _panel(
    panel: Panel, number: int, span: list[float], layout: dict[str, Any], traces: list[dict[str, Any]], bare: bool,
    shared: bool,
) -> None:  # fmt: skip
    """Add the axes and the marks of a panel; `bare`: the panel below tells the x axis."""
    end = "" if number == 1 else str(number)
    x = _axis("" if bare else labelled(panel.x, panel.x_unit), f"y{end}", panel.log and panel.across)
    y = _axis(labelled(panel.y, panel.y_unit), f"x{end}", panel.log and not panel.across) | {"domain": span}
    if shared and number > 1:
        x["matches"] = "x"
    if bare:
        x["showticklabels"] = False
    if panel.across:
        y |= {"autorange": "reversed", "showgrid": False, "ticklabelstandoff": 4}
        layout["margin"]["l"] = max(layout["margin"]["l"], 20)
    if any(isinstance(mark, Bars) for mark in panel.marks):
        (y if panel.across else x)["type"] = "category"
    for mark in panel.marks:
        if isinstance(mark, Cells):
            for names, axis in ((mark.columns, x), (mark.rows, y)):
                axis["type"] = "category" if isinstance(names, tuple) else "linear"
    if panel.equal:
        y |= {"scaleanchor": f"x{end}", "scaleratio": 1.0}
    for limits, axis in ((panel.x_range, x), (panel.y_range, y)):
        if limits is not None:
            axis["range"] = list(limits)
    layout[f"xaxis{end}"], layout[f"yaxis{end}"] = x, y
    right = f"y{100 + number}"
    if panel.right:
        layout[f"yaxis{100 + number}"] = _axis(labelled(panel.right, panel.right_unit), f"x{end}", False) | {
            "overlaying": f"y{end}", "side": "right", "showgrid": False, "tickmode": "auto"
        }  # fmt: skip
        layout["margin"]["r"] = 56
    layout["annotations"].append({
        "text": f"<b>{_escaped(panel.title)}</b>", "xref": "paper", "yref": "paper", "x": 0.0, "y": span[1],
        "xanchor": "left", "yanchor": "bottom", "yshift": 4, "showarrow": False, "align": "left",
        "font": {"size": 12},
    })  # fmt: skip
    for first, last in panel.shaded:
        layout["shapes"].append({"type": "rect", "xref": f"x{end}", "yref": f"y{end} domain", "x0": first, "x1": last,
                                 "y0": 0.0, "y1": 1.0, "fillcolor": "#F3F1EA", "line": {"width": 0},
                                 "layer": "below"})  # fmt: skip
    if panel.line is not None:
        ends = {"x0": 0.0, "x1": 1.0, "y0": panel.line, "y1": panel.line, "xref": f"x{end} domain", "yref": f"y{end}"}
        if panel.across:
            ends = {"y0": 0.0, "y1": 1.0, "x0": panel.line, "x1": panel.line, "yref": f"y{end} domain",
                    "xref": f"x{end}"}  # fmt: skip
        layout["shapes"].append(ends | {"type": "line", "line": {"color": GREY, "width": 1.2, "dash": "dot"}})
    if panel.stacked:
        layout["barmode"] = "stack"
    named: set[tuple[float, float]] = set()
    for mark in panel.marks:
        own = right if isinstance(mark, Curve) and mark.right else f"y{end}"
        drawn = _matrix(mark, span) if isinstance(mark, Cells) else (
            [_bar(mark, panel)] if isinstance(mark, Bars) else _curve(mark, panel, named))  # fmt: skip
        traces += [one | {"xaxis": f"x{end}", "yaxis": own} for one in drawn]


def _axis(title: str, anchor: str, log: bool) -> dict[str, Any]:
    """Return an axis."""
    return {
        "title": {"text": _escaped(title), "standoff": 6}, "anchor": anchor, "type": "log" if log else "-",
        "gridcolor": GRID, "zerolinecolor": GRID, "linecolor": GREY, "showline": True, "ticks": "outside",
        "tickcolor": GREY, "ticklen": 4, "automargin": True, "exponentformat": "power",
    }  # fmt: skip


def _escaped(words: str) -> str:
    """Return words without marks that plotly would read as tags."""
    return html.escape(words, quote=False)


def _curve(mark: Curve, panel: Panel, named: set[tuple[float, float]]) -> list[dict[str, Any]]:
    """Return a curve, an interval as a band behind it; points in `named` have their name, its own are added."""
    unit = panel.right_unit if mark.right else panel.y_unit
    hover = f"%{{x:.5~g}} {panel.x_unit}: %{{y:.5~g}} {unit}<extra>{_escaped(mark.name)}</extra>"
    one: dict[str, Any] = {"type": "scatter", "name": _escaped(mark.name), "x": mark.x, "y": mark.y,
                           "hovertemplate": hover}  # fmt: skip
    if mark.look in SYMBOLS:
        symbol, size = SYMBOLS[mark.look]
        one |= {"mode": "markers", "marker": {"symbol": symbol, "size": size, "color": mark.colour}}
        if mark.low is not None and mark.high is not None:
            one["error_y"] = {"type": "data", "array": mark.high - mark.y, "arrayminus": mark.y - mark.low,
                              "color": mark.colour, "thickness": 1.2}  # fmt: skip
    else:
        one |= {"mode": "lines", "line": {"color": mark.colour, "dash": DASHES[mark.look], "width": 1.6,
                                          "shape": "hv" if mark.look == "steps" else "linear"}}  # fmt: skip
    if mark.labels:
        labels = [_escaped(label) for label in mark.labels]
        if mark.written and len(labels) <= 12:
            points = list(zip(mark.x.tolist(), mark.y.tolist(), strict=True))
            once = ["" if point in named else label for point, label in zip(points, labels, strict=True)]
            named.update(points)
            one |= {"mode": f"{one['mode']}+text", "text": once, "textfont": {"color": mark.colour},
                    "textposition": list(mark.places) or "top right", "cliponaxis": False}  # fmt: skip
        one |= {"hovertext": labels, "hovertemplate": "%{hovertext}: " + hover}
    if mark.low is None or mark.high is None or mark.look in SYMBOLS:
        return [one]
    group = {"legendgroup": _escaped(mark.name), "hoverinfo": "skip", "type": "scatter", "mode": "lines",
             "x": mark.x, "line": {"width": 0, "color": mark.colour}}  # fmt: skip
    return [group | {"y": mark.low, "name": "low"},
            group | {"y": mark.high, "name": "high", "fill": "tonexty", "fillcolor": f"{mark.colour}{VEIL}"},
            one | {"legendgroup": _escaped(mark.name)}]  # fmt: skip


def _bar(mark: Bars, panel: Panel) -> dict[str, Any]:
    """Return bars, or marks over them."""
    names, unit = [_escaped(name) for name in mark.names], panel.x_unit if panel.across else panel.y_unit
    value, name = ("x", "y") if panel.across else ("y", "x")
    hover = f"%{{{name}}}: %{{{value}:.4~g}} {unit}<extra>{_escaped(mark.name)}</extra>"
    one: dict[str, Any] = {"name": _escaped(mark.name), value: mark.values, name: names, "hovertemplate": hover,
                           "marker": {"color": mark.colour}}  # fmt: skip
    if mark.mark:
        return one | {"type": "scatter", "mode": "markers",
                      "marker": {"color": mark.colour, "symbol": "diamond", "size": 9}}  # fmt: skip
    return one | {"type": "bar", "orientation": "h" if panel.across else "v"}


def _cividis() -> list[list[Any]]:
    """Return matplotlib's cividis, in a form of colours that the page does not turn in a dark scheme."""
    from matplotlib import colormaps

    steps = np.linspace(0.0, 1.0, 17)
    colours = np.round(255.0 * colormaps["cividis"](steps)[:, :3]).astype(int)
    return [[float(step), f"rgb({r},{g},{b})"] for step, (r, g, b) in zip(steps, colours.tolist(), strict=True)]


def _matrix(mark: Cells, span: list[float]) -> list[dict[str, Any]]:
    """Return a matrix with its scale of colours."""
    names = [list(side) if isinstance(side, tuple) else side for side in (mark.columns, mark.rows)]
    return [{
        "type": "heatmap", "name": _escaped(mark.name), "x": names[0], "y": names[1], "z": mark.values,
        "zmin": mark.low, "zmax": mark.high, "colorscale": _cividis(), "reversescale": mark.reversed,
        "hovertemplate": f"%{{x}}, %{{y}}: %{{z:.4~g}} {mark.unit}<extra></extra>", "hoverongaps": False,
        "colorbar": {"title": {"text": _escaped(labelled(mark.name, mark.unit)), "side": "right"}, "thickness": 12,
                     "len": span[1] - span[0], "lenmode": "fraction", "y": 0.5 * sum(span), "outlinewidth": 0},
    }]  # fmt: skip


def _plain(value: Any) -> Any:
    """Return plain values: arrays become lists of rounded numbers, what is no number null."""
    if isinstance(value, dict):
        return {name: _plain(item) for name, item in value.items()}
    if isinstance(value, list | tuple | np.ndarray):
        return [_plain(item) for item in value]
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, float):
        return rounded(value) if math.isfinite(value) else None
    return value


def live_text(charts: list[Chart]) -> str:
    """Return the interactive plots of a page as JSON, by the names of their figures."""
    return json.dumps({chart.name: live_figure(chart) for chart in charts}, separators=(",", ":"), allow_nan=False)


def curves_named(chart: Chart) -> list[tuple[str, str]]:
    """Return name and colour of every mark that a reader may hide, each once."""
    found: dict[str, str] = {}
    for panel in chart.panels:
        for mark in panel.marks:
            if not isinstance(mark, Cells):
                found.setdefault(mark.name, mark.colour)
    return list(found.items()) if len(found) > 1 else []


def span_of(values: FloatArray) -> tuple[float, float]:
    """Return lowest and highest of the numbers that are there; 0 and 1 where there is none."""
    known = values[np.isfinite(values)]
    return (float(known.min()), float(known.max())) if known.size else (0.0, 1.0)
