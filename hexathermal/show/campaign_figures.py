"""Figures of a campaign's check: each run against time, noise, collinearity, and where the part was when warm."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from hexathermal.learn.check import CampaignCheck, RunCheck
from hexathermal.show.figures import BLACK, BLUE, GREY, PURPLE, VERMILION
from hexathermal.show.figures import STYLE as STYLE

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

GAP_STEPS = 5.0
"""A curve is broken where the step in time is more than so many usual ones."""


def run_figure(check: CampaignCheck, run: RunCheck) -> Figure:
    """Return temperatures, drift and displacement (or inputs) of a run against time."""
    import matplotlib as mpl
    from matplotlib.figure import Figure

    trace = run.trace
    lower = trace.q is not None or trace.inputs.shape[1] > 0
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(7.6, 6.6 if lower else 5.2), layout="constrained")
        heights = [1.5, 1.0, 0.6] if lower else [1.5, 1.0]
        panels = figure.subplots(len(heights), 1, sharex=True, height_ratios=heights)
        hours = trace.time / 3600.0
        _temperatures(panels[0], hours, run, check.campaign.sensors)
        panels[0].set_title(f"{run.run.name} ({run.run.role}): {run.record.used} of {run.record.rows} rows usable")
        x, y = _broken(hours, trace.drift * 1e6)
        panels[1].plot(x, y, color=VERMILION, lw=0.8, marker=".", ms=2.0)
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


def _temperatures(axes: Axes, hours: Any, run: RunCheck, sensors: tuple[str, ...]) -> None:
    """Draw all temperatures; from the first sensor (dark) to the last (light)."""
    import matplotlib as mpl

    colours = mpl.colormaps["viridis"](np.linspace(0.0, 0.92, max(1, len(sensors))))
    offset = np.nan_to_num(run.highest_degC - run.highest_dT)
    for k, sensor in enumerate(sensors):
        x, y = _broken(hours, run.trace.dT[:, k] + offset[k])
        axes.plot(x, y, color=colours[k], lw=0.8, label=sensor)
    axes.set_ylabel("temperature (°C)")
    if len(sensors) <= 34:
        axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), fontsize=6.5, ncols=1 + (len(sensors) > 17))


def _broken(hours: Any, values: Any) -> tuple[Any, Any]:
    """Return a curve that is broken at gaps in time."""
    step = np.diff(hours)
    if not len(step):
        return hours, values
    gaps = np.flatnonzero(step > GAP_STEPS * np.median(step)) + 1
    return np.insert(hours, gaps, np.nan), np.insert(values, gaps, np.nan)


def noise_figure(check: CampaignCheck) -> Figure:
    """Return noise and slow deviation of each sensor as bars."""
    import matplotlib as mpl
    from matplotlib.figure import Figure

    sensors = check.campaign.sensors
    with mpl.rc_context({**STYLE, "axes.grid.axis": "y"}):
        figure = Figure(figsize=(7.6, 3.4), layout="constrained")
        axes = figure.subplots()
        place = np.arange(len(sensors))
        axes.bar(place - 0.2, check.sensor_noise * 1e3, 0.4, color=BLUE, label="noise of single readings")
        axes.bar(place + 0.2, check.sensor_slow * 1e3, 0.4, color=PURPLE,
                 label="slow deviation that the other sensors do not explain")  # fmt: skip
        axes.set_xticks(place, sensors, rotation=90 if len(sensors) > 10 else 0)
        axes.set_yscale("log")
        axes.set_ylabel("standard deviation (mK)")
        axes.set_title("Noise of the thermocouples")
        axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.16), ncols=2)
    return figure


def collinearity_figure(check: CampaignCheck) -> Figure:
    """Return how alike the sensors are: ``1 - |r|`` on a logarithmic scale, darker is more alike."""
    import matplotlib as mpl
    from matplotlib.colors import LogNorm
    from matplotlib.figure import Figure

    sensors = check.campaign.sensors
    with mpl.rc_context({**STYLE, "axes.grid": False}):
        figure = Figure(figsize=(5.8, 4.9), layout="constrained")
        axes = figure.subplots()
        apart = np.maximum(1.0 - np.abs(check.correlation), 1e-6)
        np.fill_diagonal(apart, np.nan)
        known = apart[np.isfinite(apart)]
        low = float(known.min()) if known.size else 1e-3
        shown = axes.imshow(np.ma.masked_invalid(apart), cmap="cividis", norm=LogNorm(min(low, 0.5), 1.0))
        axes.set_xticks(range(len(sensors)), sensors, rotation=90, fontsize=7.5)
        axes.set_yticks(range(len(sensors)), sensors, fontsize=7.5)
        axes.set_title("Collinearity of the sensors within runs")
        figure.colorbar(shown, ax=axes, shrink=0.88, label="1 - |correlation|; darker: more alike")
    return figure


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
        axes.axvline(item.warm_q * 1e3, color=GREY, lw=1.0, ls="--")
        axes.axhline(0.0, color=GREY, lw=0.6)
        axes.set_xlabel("displacement of the rod q (mm)")
        axes.set_ylabel(f"dT of {item.sensor} (K)")
        axes.set_title(f"Where the leg was when it was warm: A and B of {item.sensor}, r = {item.r:.2f}")
        axes.legend(loc="best", markerscale=3.0)
    return figure
