"""Figures of runs on the bench: the scenario, the temperatures, the drift (Robert et al., figs. 4 and 8)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from hexathermal.show.figures import BLACK, BLUE, GREY, PURPLE, STYLE, VERMILION

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from hexathermal.simulate.bench.bench import Bench, BenchRun


def run_figure(bench: Bench, run: BenchRun) -> Figure:
    """Return the figure of one run on the bench, drawn from what is written of it.

    Parameters
    ----------
    bench : Bench
    run : BenchRun

    Returns
    -------
    Figure
        Three panels over time [h]: rod extension [mm], temperature rise of the thermocouples and of the room [K], and
        measured drift of the settled rows [um].
    """
    import matplotlib as mpl
    from matplotlib.figure import Figure

    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(7.2, 7.2), layout="constrained")
        motion, heat, drift = figure.subplots(3, 1, sharex=True, height_ratios=[0.8, 1.25, 1.0])
        hours = run.time / 3600.0
        motion.plot(hours, run.q * 1e3, color=BLACK, lw=1.0)
        motion.set_ylabel("rod extension (mm)")
        motion.set_title(f"{run.name} ({run.role}): scenario")
        _temperatures(heat, hours, bench, run)
        settled = run.settled
        drift.plot(hours[settled], run.drift()[settled] * 1e6, ".", color=VERMILION, ms=2.0)
        drift.axhline(0.0, color=GREY, lw=0.6)
        drift.set_ylabel("measured drift (µm)")
        drift.set_title("Drift since the first row, mean of the three beams, settled rows")
        drift.set_xlabel("time (h)")
        drift.set_xlim(0.0, float(hours[-1]))
        figure.align_ylabels()
    return figure


def _temperatures(axes: Axes, hours: Any, bench: Bench, run: BenchRun) -> None:
    """Draw the rises of all thermocouples, coloured from foot to top, the rod's apart, and the room's."""
    rise = run.temperatures - run.temperatures[0]
    places = bench.thermocouples.places
    body = [k for k, place in enumerate(places) if place[1] == "body"]
    rod = [k for k, place in enumerate(places) if place[1] == "rod"]
    foot, top = np.array([0xD5, 0x5E, 0x00]) / 255.0, np.array([0x00, 0x72, 0xB2]) / 255.0
    for order, k in enumerate(body):
        share = order / max(1, len(body) - 1)
        axes.plot(hours, rise[:, k], color=tuple((1.0 - share) * foot + share * top), lw=0.9)
    for k in rod:
        axes.plot(hours, rise[:, k], color=PURPLE, lw=0.9, ls="--")
    axes.plot(hours, run.weather.temperature - run.weather.temperature[0], color=GREY, ls=":")
    labels = []
    if body:
        labels += [(places[body[0]][0] + ", at the foot", VERMILION), (places[body[-1]][0] + ", at the top", BLUE)]
    if rod:
        labels.append((f"{places[rod[0]][0]} to {places[rod[-1]][0]}, rod", PURPLE))
    for k, (label, colour) in enumerate([*labels, ("room", GREY)]):
        axes.annotate(label, (1.0, 0.92 - 0.13 * k), (5, 0), xycoords="axes fraction", textcoords="offset points",
                      color=colour, va="center", annotation_clip=False)  # fmt: skip
    axes.set_ylabel("temperature rise (K)")
    axes.set_title("Thermocouples on the body from foot to top, on the rod, and the room")
