"""Figures of a comparison: channels over each other, residuals by part, and the factors with their intervals."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from hexathermal.show.figures import BLACK, BLUE, GREEN, GREY, PURPLE, STYLE, VERMILION

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from hexathermal.compare.bench_runs import RunCurves
    from hexathermal.compare.comparison import Comparison
    from hexathermal.compare.scores import ComparedRun

COLUMNS = 3
SHOWN_ROWS = 1500
"""Rows of a run that are drawn."""

GAP_H = 0.2
"""Lines are not drawn across so many hours without settled rows."""


def channels_figure(found: Comparison, run: ComparedRun) -> Figure:
    """Return a figure of one run: each thermocouple and the drift, measured and simulated, before and after.

    Parameters
    ----------
    found : Comparison
    run : ComparedRun
    """
    import matplotlib as mpl
    from matplotlib.figure import Figure

    count = len(found.sensors) + 1
    lines = -(-count // COLUMNS)
    hours = run.time / 3600.0
    thin = slice(None, None, max(1, len(hours) // SHOWN_ROWS))
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(9.0, 1.0 + 1.45 * lines), layout="constrained")
        axes = figure.subplots(lines, COLUMNS, sharex=True, squeeze=False).ravel()
        for k in range(count):
            drift = k == count - 1
            _pair(axes[k], hours, run, k, thin, bool(found.differences))
            if drift:
                axes[k].set_title("drift (µm)", color=VERMILION)
            else:
                part, position = found.placed.places[k]
                axes[k].set_title(f"{found.sensors[k]}, {part} {position * 1e3:.0f} mm (K)")
            axes[k].set_xlim(0.0, float(hours[-1]))
        for unused in axes[count:]:
            unused.set_visible(False)
        for bottom in axes[max(0, count - COLUMNS) : count]:
            bottom.set_xlabel("time (h)")
            bottom.tick_params(labelbottom=True)
        handles, labels = axes[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside upper right", ncols=3)
        figure.suptitle(f"{run.name} ({run.role}): measured and simulated", x=0.01, ha="left", fontweight="bold")
    return figure


def _channel(curves: RunCurves, k: int) -> Any:
    """Return a channel's course in the unit that is drawn."""
    return curves.rises[:, k] if k < curves.rises.shape[1] else curves.drift * 1e6


def _pair(axes: Axes, hours: Any, run: ComparedRun, k: int, thin: slice, changed: bool) -> None:
    """Draw one channel."""
    # no line across hours without settled rows
    gap = np.flatnonzero(np.diff(hours[thin]) > GAP_H) + 1

    def broken(values: Any) -> Any:
        return np.insert(np.asarray(values[thin], dtype=np.float64), gap, np.nan)

    time = broken(hours)
    axes.plot(hours[thin], _channel(run.measured, k)[thin], ".", color=BLACK, ms=1.2, label="measured")
    axes.plot(time, broken(_channel(run.before, k)), color=VERMILION, lw=1.1, ls="--", label="bench as it is")
    if changed:
        axes.plot(time, broken(_channel(run.after, k)), color=BLUE, lw=1.2, label="with what was named")


def residuals_figure(found: Comparison, run: ComparedRun) -> Figure:
    """Return a figure of one run: simulated less measured, by part, before and after.

    Parameters
    ----------
    found : Comparison
    run : ComparedRun
    """
    import matplotlib as mpl
    from matplotlib.figure import Figure

    parts = [part for part in ("body", "rod") if part in {part for part, _place in found.placed.places}]
    stages = [("bench as it is", run.before)] + ([("with what was named", run.after)] if found.differences else [])
    hours = run.time / 3600.0
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(4.2 * len(stages) + 0.8, 2.1 * (len(parts) + 1) + 0.5), layout="constrained")
        axes = figure.subplots(len(parts) + 1, len(stages), sharex=True, sharey="row", squeeze=False)
        for column, (stage, curves) in enumerate(stages):
            for line, part in enumerate([*parts, "drift"]):
                one = axes[line, column]
                one.axhline(0.0, color=GREY, lw=0.6)
                _residuals(one, found, run, curves, part)
                one.set_title(f"{part}: {stage}")
            axes[-1, column].set_xlabel("time (h)")
            axes[-1, column].set_xlim(0.0, float(hours[-1]))
        for line in range(len(parts)):
            axes[line, 0].set_ylabel("simulated − measured (K)")
        axes[-1, 0].set_ylabel("simulated − measured (µm)")
        figure.suptitle(f"{run.name} ({run.role}): residuals by part", x=0.01, ha="left", fontweight="bold")
    return figure


def _residuals(axes: Axes, found: Comparison, run: ComparedRun, curves: RunCurves, part: str) -> None:
    """Draw the residuals of one part as means over some minutes, coloured from foot to top."""
    width = max(1, len(run.time) // 120)
    count = len(run.time) // width * width

    def smooth(values: Any) -> Any:
        cut = values[:count].reshape(-1, width)
        good = np.isfinite(cut)
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.where(good, cut, 0.0).sum(axis=1) / good.sum(axis=1)

    hours = smooth(run.time) / 3600.0
    if part == "drift":
        axes.plot(hours, smooth(curves.drift - run.measured.drift) * 1e6, color=VERMILION, lw=1.1)
        return
    own = [k for k, place in enumerate(found.placed.places) if place[0] == part]
    foot, top = np.array([0xD5, 0x5E, 0x00]) / 255.0, np.array([0x00, 0x72, 0xB2]) / 255.0
    for order, k in enumerate(own):
        share = order / max(1, len(own) - 1)
        name = found.sensors[k] if order in (0, len(own) - 1) else None
        axes.plot(hours, smooth(curves.rises[:, k] - run.measured.rises[:, k]), lw=0.9,
                  color=tuple((1.0 - share) * foot + share * top), label=name)  # fmt: skip
    # beside the title: curves fill the panel
    axes.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=2, fontsize=7.5, borderaxespad=0.1)


def parameters_figure(found: Comparison) -> Figure:
    """Return a figure of all physical numbers: factor with its 95 % interval, and from where it would be named.

    Parameters
    ----------
    found : Comparison
    """
    import matplotlib as mpl
    from matplotlib.figure import Figure

    shown = [one for one in found.parameters if not one.target][::-1]
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(7.4, 0.9 + 0.27 * len(shown)), layout="constrained")
        axes = figure.subplots()
        axes.set_xscale("log")
        low, high = 0.2, 5.0
        for k, one in enumerate(shown):
            edges = np.clip([max(one.limit_low, 1e-9), one.limit_high], low, high)
            axes.barh(k, edges[1] - edges[0], left=edges[0], height=0.72, color="#ECECEC", zorder=1)
            colour = VERMILION if one.named else BLACK
            ends = np.clip([one.low, one.high], low, high)
            axes.plot(ends, [k, k], color=colour, lw=2.2 if one.named else 1.0, zorder=3)
            marker = "<" if one.value < low else ">" if one.value > high else "o"
            axes.plot(np.clip(one.value, low, high), k, marker, color=colour, ms=5.0 if one.named else 3.0, zorder=4,
                      clip_on=False)  # fmt: skip
            for arrow, edge, beyond in (("<", low, one.low < low), (">", high, one.high > high)):
                if beyond and marker == "o":
                    axes.plot(edge, k, arrow, color=colour, ms=4.0, zorder=3, clip_on=False)
            if marker != "o":
                side = (8, "left") if marker == "<" else (-8, "right")
                axes.annotate(f"{one.value:.2g}", (np.clip(one.value, low, high), k), (side[0], 0), ha=side[1],
                              textcoords="offset points", va="center", fontsize=7.5, color=colour)  # fmt: skip
            if one.alike:
                names = ", ".join(name for name, _value in one.alike)
                axes.annotate(f"not separated from {names}", (1.0, k), (5, 0), xycoords=("axes fraction", "data"),
                              textcoords="offset points", va="center", fontsize=7.0, color=PURPLE,
                              annotation_clip=False)  # fmt: skip
        axes.axvline(1.0, color=GREEN, lw=0.9)
        axes.set_yticks(range(len(shown)), [one.name for one in shown])
        for tick, one in zip(axes.get_yticklabels(), shown, strict=True):
            tick.set_color(VERMILION if one.named else BLACK)
        axes.set_xlim(low, high)
        axes.set_xticks([0.2, 0.5, 1.0, 2.0, 5.0], ["0.2", "0.5", "1", "2", "5"])
        axes.minorticks_off()
        axes.set_ylim(-0.6, len(shown) - 0.4)
        axes.set_xlabel("factor on the bench's number, 95 % interval\n(grey: too small to be named; orange: named)")
        axes.set_title(f"{found.title}: the bench's numbers")
    return figure
