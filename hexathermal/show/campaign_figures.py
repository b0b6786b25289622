"""Figures of a campaign's check: each run against time, noise, collinearity, and where the part was when warm."""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING, Any

import numpy as np

from hexathermal.learn.campaign import Thermocouple
from hexathermal.learn.check import CampaignCheck, RunCheck
from hexathermal.poses import FloatArray
from hexathermal.show.figures import BLACK, BLUE, GREEN, GREY, PURPLE, STYLE, VERMILION, gaps_in, spaced

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

PART_COLOURS = (BLUE, VERMILION, GREEN, PURPLE, "#8A6D00", "#56B4E9", BLACK, GREY)
STYLES = ("-", "--", "-.", ":")

HUES = -0.07, 0.05
"""A part's many sensors turn its hue from the first to the last, as parts of the whole circle."""

MOST_LABELS = 26
"""So many sensors are named at their lines; more in a legend."""

NARROWEST_MM = 1.0
"""A rod that stood still is drawn on an axis at least so long: its last digits are noise of the scale."""


def run_figure(check: CampaignCheck, run: RunCheck) -> Figure:
    """Return temperatures, drift and displacement (or inputs) of a run against time; spikes left out are marked."""
    import matplotlib as mpl
    from matplotlib.figure import Figure

    trace = run.trace
    lower = trace.q is not None or trace.inputs.shape[1] > 0
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(7.6, 7.2 if lower else 5.8), layout="constrained")
        heights = [1.7, 1.0, 0.6] if lower else [1.7, 1.0]
        panels = figure.subplots(len(heights), 1, sharex=True, height_ratios=heights)
        hours = trace.time / 3600.0
        heat = heat_degC(run)
        columns = [f"{name}_degC" for name in check.campaign.sensors]
        marked = [run.spikes[column] for column in columns if column in run.spikes]
        temperatures(panels[0], hours, heat, check.campaign.thermocouples, marked)
        panels[0].set_title(f"{run.run.name} ({run.run.role}): {run.record.used} of {run.record.rows} rows usable")
        x, y = broken(hours, trace.drift * 1e6)
        panels[1].plot(x, y, color=VERMILION, lw=0.8, marker=".", ms=2.0)
        _mark(panels[1], [run.spikes["drift"] * [1.0, 1e6]] if "drift" in run.spikes else [])
        panels[1].set_ylabel("drift (µm)")
        if trace.q is not None:
            panels[2].plot(hours, trace.q * 1e3, ".", color=BLACK, ms=2.0)
            panels[2].set_ylabel("q (mm)")
        elif lower:
            for k, item in enumerate(check.campaign.inputs):
                panels[2].plot(hours, trace.inputs[:, k], lw=1.0, label=item.name)
            panels[2].legend(loc="upper right", fontsize=7.5)
            panels[2].set_ylabel("inputs")
        panels[-1].set_xlabel("time since the run's first row (h)")
        figure.align_ylabels()
    return figure


def heat_degC(run: RunCheck) -> FloatArray:
    """Return the temperatures of a run's trace, shape (n, s) [degC]."""
    return run.trace.dT + np.nan_to_num(run.highest_degC - run.highest_dT)


def temperatures(
    axes: Axes, hours: Any, heat: FloatArray, sensors: tuple[Thermocouple, ...], spikes: list[FloatArray] | None = None
) -> None:
    """Draw temperatures [degC], shape (n, s), each named at its line's end, and mark spikes (time [s], degC).

    A part has a colour, its sensors differ in style, and a little in hue where they are many; where no parts are named,
    colours go from the first sensor to the last.
    """
    ends = []
    drawn = looks(sensors)
    for item, (colour, style), values in zip(sensors, drawn, heat.T, strict=True):
        x, y = broken(hours, values)
        axes.plot(x, y, color=colour, ls=style, lw=0.9, label=item.name)
        known = np.flatnonzero(np.isfinite(values))
        if known.size:
            ends.append((item.name, colour, float(hours[known[-1]]), float(values[known[-1]])))
    axes.set_ylabel("temperature (°C)")
    _mark(axes, spikes or [])
    if len(sensors) > MOST_LABELS:
        axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), fontsize=6.0, ncols=2)
        return
    _name_ends(axes, ends)
    parts = _parts(sensors)
    if len(parts) > 1:
        of = {part: [look[0] for item, look in zip(sensors, drawn, strict=True) if item.part == part] for part in parts}
        lines = [axes.plot([], [], color=own[len(own) // 2], lw=2.5)[0] for own in of.values()]
        axes.legend(lines, [part or "no part named" for part in parts], loc="best", fontsize=7.0)


def _name_ends(axes: Axes, ends: list[tuple[str, Any, float, float]]) -> None:
    """Write names beside the axes, each joined to its line's end: name, colour, and where the line ends."""
    if not ends:
        return
    low, high = axes.get_ylim()
    axes.set_ylim(low, high)
    gap = min(0.042, 0.96 / len(ends))
    places = np.array(spaced([(end[3] - low) / (high - low) for end in ends], gap))
    places = places - max(0.0, places.max() - 0.98) + max(0.0, 0.02 - places.min())
    line = {"arrowstyle": "-", "lw": 0.4, "shrinkA": 0.0, "shrinkB": 0.0}
    for (name, colour, x_end, y_end), place in zip(ends, places, strict=True):
        axes.annotate(
            name, (x_end, y_end), (1.03, place), textcoords="axes fraction", color=colour, fontsize=6.8, va="center",
            annotation_clip=False, arrowprops={**line, "color": colour},
        )  # fmt: skip


def looks(sensors: tuple[Thermocouple, ...]) -> list[tuple[Any, str]]:
    """Return colour and style of each sensor's line."""
    import matplotlib as mpl

    parts = _parts(sensors)
    if len(parts) == 1 or len(parts) > len(PART_COLOURS):
        colours: list[Any] = list(mpl.colormaps["viridis"](np.linspace(0.0, 0.86, max(1, len(sensors)))))
        return [(colour, STYLES[k % len(STYLES)]) for k, colour in enumerate(colours)]
    before = dict.fromkeys(parts, 0)
    beside = Counter(item.part for item in sensors)
    found = []
    for item in sensors:
        colour, place = PART_COLOURS[parts.index(item.part)], before[item.part]
        if beside[item.part] > len(STYLES):
            colour = _turned(colour, float(np.interp(place, [0, beside[item.part] - 1], HUES)))
        found.append((colour, STYLES[place % len(STYLES)]))
        before[item.part] += 1
    return found


def _parts(sensors: tuple[Thermocouple, ...]) -> list[str]:
    """Return the parts that carry a sensor, in their order."""
    return list(dict.fromkeys(item.part for item in sensors))


def _turned(colour: str, turn: float) -> str:
    """Return a colour with its hue turned, as a part of the whole circle."""
    from matplotlib.colors import hsv_to_rgb, rgb_to_hsv, to_hex, to_rgb

    hue, saturation, value = rgb_to_hsv(to_rgb(colour))
    return to_hex(tuple(hsv_to_rgb(((hue + turn) % 1.0, saturation, value)).tolist()))


def _mark(axes: Axes, spikes: list[FloatArray]) -> None:
    """Mark readings that were left out as spikes; those far off the picture by a triangle at its edge."""
    if not spikes:
        return
    time, value = np.concatenate(spikes).T
    low, high = axes.get_ylim()
    room = 0.5 * (high - low)
    far = (value < low - room) | (value > high + room)
    if (~far).any():
        low, high = min(low, float(value[~far].min())), max(high, float(value[~far].max()))
    if far.any():
        low, high = (low - 0.05 * room if (value < low).any() else low), high + 0.05 * room * (value > high).any()
    label = f"left out as a spike ({len(value)})"
    axes.plot(time[~far] / 3600.0, value[~far], "x", color=BLACK, ms=5.0, mew=1.0, label=label)
    for beyond, edge, mark in ((far & (value > high), high, "^"), (far & (value < low), low, "v")):
        if beyond.any():
            axes.plot(time[beyond] / 3600.0, np.full(int(beyond.sum()), edge), mark, color=BLACK, ms=5.0)
    pad = 0.03 * (high - low)
    axes.set_ylim(low - pad, high + pad)
    axes.annotate(f"x {label}" + ("; triangles: farther off" if far.any() else ""), (0.01, 0.02),
                  xycoords="axes fraction", fontsize=7.5, color=BLACK)  # fmt: skip


def broken(hours: Any, values: Any) -> tuple[Any, Any]:
    """Return a curve that is broken at gaps in time."""
    gaps = gaps_in(hours)
    return np.insert(hours, gaps, np.nan), np.insert(values, gaps, np.nan)


WIDE = 20.0
"""Largest over least noise from which on they are drawn on a logarithmic scale."""


def wide(*values: FloatArray) -> bool:
    """Return whether values above zero are drawn on a logarithmic scale; else bars stand on zero."""
    shown = np.concatenate(values)
    shown = shown[np.isfinite(shown) & (shown > 0.0)]
    return bool(shown.size and shown.max() > WIDE * shown.min())


def noise_figure(sensors: tuple[str, ...], noise: FloatArray, slow: FloatArray) -> Figure:
    """Return noise and slow deviation [K] of each sensor as bars."""
    import matplotlib as mpl
    from matplotlib.figure import Figure
    from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator

    with mpl.rc_context({**STYLE, "axes.grid.axis": "y"}):
        figure = Figure(figsize=(7.6, 3.4), layout="constrained")
        axes = figure.subplots()
        place = np.arange(len(sensors))
        axes.bar(place - 0.2, noise * 1e3, 0.4, color=BLUE, label="noise of single readings")
        axes.bar(place + 0.2, slow * 1e3, 0.4, color=PURPLE,
                 label="slow deviation that the other sensors do not explain")  # fmt: skip
        axes.set_xticks(place, sensors, rotation=90 if len(sensors) > 10 else 0)
        if wide(noise, slow):
            axes.set_yscale("log")
            axes.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
            axes.yaxis.set_minor_locator(NullLocator())
            axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _place: f"{value:g}"))
        axes.set_ylabel("standard deviation (mK)")
        axes.set_title("Noise of the thermocouples")
        figure.legend(loc="outside lower center", ncols=2)
    return figure


def collinearity_figure(sensors: tuple[str, ...], correlation: FloatArray) -> Figure:
    """Return how alike the sensors are: ``1 - |r|`` on a logarithmic scale, darker is more alike."""
    import matplotlib as mpl
    from matplotlib.colors import LogNorm
    from matplotlib.figure import Figure

    with mpl.rc_context({**STYLE, "axes.grid": False}):
        figure = Figure(figsize=(5.8, 4.9), layout="constrained")
        axes = figure.subplots()
        apart = np.maximum(1.0 - np.abs(correlation), 1e-6)
        np.fill_diagonal(apart, np.nan)
        known = apart[np.isfinite(apart)]
        low = float(known.min()) if known.size else 1e-3
        shown = axes.imshow(np.ma.masked_invalid(apart), cmap="cividis", norm=LogNorm(min(low, 0.5), 1.0))
        axes.set_xticks(range(len(sensors)), sensors, rotation=90, fontsize=7.5)
        axes.set_yticks(range(len(sensors)), sensors, fontsize=7.5)
        axes.set_title("Collinearity of the sensors within runs")
        figure.colorbar(shown, ax=axes, shrink=0.88, label="1 - |correlation|; darker: more alike")
    return figure


def room_about(ends: tuple[float, float]) -> tuple[float, float]:
    """Return ends of an axis of displacements [mm] that are no nearer than `NARROWEST_MM`, about the same middle.

    Examples
    --------
    >>> room_about((124.9999, 125.0001)), room_about((0.0, 250.0))
    ((124.5, 125.5), (0.0, 250.0))
    """
    middle, half = 0.5 * (ends[0] + ends[1]), max(0.5 * (ends[1] - ends[0]), 0.5 * NARROWEST_MM)
    return middle - half, middle + half


def coverage_figure(check: CampaignCheck) -> Figure | None:
    """Return where each run was in `q` and `dT` of the sensor that best tells `A` from `B`; None without a stroke."""
    import matplotlib as mpl
    from matplotlib.figure import Figure

    usable = [k for k, item in enumerate(check.separability) if np.isfinite(item.std_B)]
    if not usable:
        return None
    best = min(usable, key=lambda k: check.separability[k].std_B)
    item = check.separability[best]
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(6.4, 4.2), layout="constrained")
        axes = figure.subplots()
        for role, colour, mark in (("identification", BLUE, "."), ("validation", VERMILION, "x")):
            runs = [run for run in check.runs if run.run.role == role and run.trace.q is not None]
            if runs:
                q = np.concatenate([run.trace.q for run in runs if run.trace.q is not None]) * 1e3
                heat = np.concatenate([run.trace.dT[:, best] for run in runs])
                axes.plot(q, heat, mark, color=colour, ms=2.5, mew=0.7, alpha=0.6, label=role)
        axes.set_xlim(*room_about(axes.get_xlim()))
        axes.axvline(item.warm_q * 1e3, color=GREY, lw=1.0, ls="--")
        axes.axhline(0.0, color=GREY, lw=0.6)
        axes.set_xlabel("displacement of the rod q (mm)")
        axes.set_ylabel(f"dT of {item.sensor} (K)")
        axes.set_title(f"Where the leg was when it was warm: A and B of {item.sensor}, r = {item.r:.2f}")
        axes.legend(loc="best", markerscale=3.0)
    return figure
