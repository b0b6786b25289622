"""Figures of the report of a leg or a component: runs, the paper's figures 4, 6, 7 and 8, noise, likeness, coverage.

They hold the numbers that `campaign_figures` and `identification_figures` draw; figure 4 is drawn here.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from hexathermal.learn.check import CampaignCheck, RunCheck
from hexathermal.learn.check_sums import Trace
from hexathermal.learn.identification import Identification
from hexathermal.learn.law import IdentifiedLaw
from hexathermal.learn.selection import RankedSets
from hexathermal.learn.validation import RunCurves, Validation
from hexathermal.poses import FloatArray
from hexathermal.show import campaign_figures as drawn
from hexathermal.show import identification_figures as paper
from hexathermal.show.figures import BLACK, BLUE, GREEN, PURPLE, VERMILION, gaps_in
from hexathermal.show.identification_tables import matrix_of
from hexathermal.show.report_chart import Bars, Cells, Chart, Curve, Panel, file_name
from hexathermal.show.report_live import span_of
from hexathermal.show.report_thinning import MOST_POINTS, Rows, kept_of, thinned_words

if TYPE_CHECKING:
    from matplotlib.figure import Figure

HOUR_S = 3600.0

PAUSE_S = 900.0
"""A rod that stands longer than this rests; the paper's phases of rest last an hour and more."""

MOST_DOTS = 250
"""Rows of a run in the figure of all runs."""

MOVED_M = 1e-4
"""A rod that is read so much elsewhere has moved."""


def hex_colour(colour: str | Sequence[float]) -> str:
    """Return a colour of matplotlib as #RRGGBB."""
    from matplotlib.colors import to_hex

    return to_hex(colour).upper()  # type: ignore[arg-type]


def run_words(name: str) -> str:
    """Return a run's name as one: with "Run" before it where it does not say so.

    Examples
    --------
    >>> run_words("run-01"), run_words("warm up")
    ('run-01', 'Run warm up')
    """
    return name if name.lower().startswith("run") else f"Run {name}"


def thinned(run: RunCheck, most: int = MOST_POINTS) -> RunCheck:
    """Return a run whose trace has no more rows than are drawn."""
    one = run.trace
    rows = _drawn_rows(one, most)
    q = None if one.q is None else one.q[rows]
    return replace(run, trace=Trace(one.time[rows], one.dT[rows], one.drift[rows], q, one.inputs[rows]))


def _drawn_rows(one: Trace, most: int) -> Rows:
    """Return which rows of a trace are drawn."""
    inputs = (one.inputs[:, k] for k in range(one.inputs.shape[1]))
    return kept_of(len(one.time), most, one.dT, one.drift, *([] if one.q is None else [one.q]), *inputs)


def _spikes(run: RunCheck, columns: set[str], beside: FloatArray, scale: float) -> tuple[Curve, ...]:
    """Return readings left out as spikes as marks; those farther off than the rest is wide would flatten the plot."""
    found = [marks for name, marks in run.spikes.items() if name in columns]
    if not found:
        return ()
    seconds, values = np.concatenate(found).T * np.array([[1.0], [scale]])
    low, high = span_of(beside)
    near = (values >= 2.0 * low - high) & (values <= 2.0 * high - low)
    return (Curve("left out", seconds[near] / HOUR_S, values[near], BLACK, "rings"),) if near.any() else ()


def run_chart(check: CampaignCheck, run: RunCheck) -> Chart:
    """Return one run: temperatures, drift, and displacement or inputs against time."""
    shown = thinned(run)
    trace, name = shown.trace, run.run.name
    hours, heat = trace.time / HOUR_S, drawn.heat_degC(shown)
    looks = {"-": "line", "--": "dashed", "-.": "dashdot", ":": "dotted"}
    curves = []
    for item, (colour, style), values in zip(
        check.campaign.thermocouples, drawn.looks(check.campaign.thermocouples), heat.T, strict=True
    ):
        curves.append(Curve(item.name, *drawn.broken(hours, values), hex_colour(colour), looks[style]))
    drift = Curve("drift", *drawn.broken(hours, trace.drift * 1e6), VERMILION)
    names = {f"{name}_degC" for name in check.campaign.sensors}
    hot, cold = _spikes(run, names, heat, 1.0), _spikes(run, {"drift"}, trace.drift * 1e6, 1e6)
    panels = [
        Panel("Temperatures", (*curves, *hot), "time", "temperature", "h", "°C", height=1.5),
        Panel("Drift", (drift, *cold), "time", "drift", "h", "µm"),
    ]
    if trace.q is not None:
        panels.append(Panel("Displacement of the rod", (Curve("q", hours, trace.q * 1e3, BLACK, "dots"),), "time", "q",
                            "h", "mm", height=0.7))  # fmt: skip
    elif trace.inputs.shape[1]:
        inputs = tuple(
            Curve(one.name, hours, values, (BLUE, VERMILION, GREEN, PURPLE)[k % 4])
            for k, (one, values) in enumerate(zip(check.campaign.inputs, trace.inputs.T, strict=True))
        )
        panels.append(Panel("Inputs", inputs, "time", "inputs", "h", "", height=0.7))
    low, high = span_of(heat)
    left, most = (value * 1e6 for value in span_of(trace.drift))
    spikes = sum(len(one) for one in run.spikes.values())
    said = f"{run.record.used} of {run.record.rows} rows usable."
    marked = sum(len(one.x) for one in (*hot, *cold))
    if spikes:
        said += f" {spikes} reading{'s were' if spikes > 1 else ' was'} left out as spikes (rings)."
    if marked < spikes:
        said += f" Of these {spikes - marked} lay too far off to be drawn."
    return Chart(
        file_name(run_words(name)), f"{run_words(name)} ({run.run.role})",
        f"{run_words(name)}: over {hours[-1]:.1f} hours the thermocouples read {low:.1f} to {high:.1f} °C and the "
        f"measured drift goes from {left:.2f} to {most:.2f} µm.",
        said + thinned_words(len(hours), len(run.trace.time)), tuple(panels),
        lambda: drawn.run_figure(check, shown), True,
    )  # fmt: skip


def scenario_chart(run: RunCheck) -> Chart | None:
    """Return the setpoint of a run against time, phases of movement shaded (paper, fig. 4); None without a stroke."""
    trace = thinned(run).trace
    if trace.q is None or len(trace.time) < 2:
        return None
    hours = trace.time / HOUR_S
    phases = tuple((float(a) / HOUR_S, float(b) / HOUR_S) for a, b in movements(run.trace.time, run.trace.q))
    q = Curve("setpoint", *drawn.broken(hours, trace.q * 1e3), BLACK, "steps")
    low, high = (value * 1e3 for value in span_of(trace.q))
    panel = Panel("Movement (shaded) and rest", (q,), "time", "displacement of the rod", "h", "mm", shaded=phases,
                  height=1.3)  # fmt: skip
    return Chart(
        "paper-figure-4", f"A scenario: {run_words(run.run.name)}",
        f"The rod's displacement against time: {len(phases)} phases of movement between {low:.0f} and {high:.0f} mm, "
        "each followed by a rest.",
        "As figure 4 of the paper: movement heats the leg, rest lets it cool. Settled rows only; where there are none "
        f"it is taken to move. A rod that stands for more than {PAUSE_S / 60.0:.0f} minutes rests."
        f"{thinned_words(len(hours), len(run.trace.time))}", (panel,),
    )  # fmt: skip


def movements(time: FloatArray, q: FloatArray | None) -> list[tuple[float, float]]:
    """Return first and last time of each phase of movement: rests shorter than `PAUSE_S` are none.

    Where rows are missing for longer, as where none is settled, the rod is taken to move.

    Examples
    --------
    >>> time = np.arange(0.0, 3000.0, 60.0)
    >>> movements(time, 0.01 * np.minimum(time, 120.0))
    [(0.0, 120.0)]
    >>> late = np.append(time, [6000.0, 6060.0])
    >>> movements(late, np.full(len(late), 0.01))
    [(2940.0, 6000.0)]
    """
    if q is None:
        return []
    moved = np.union1d(np.flatnonzero(np.abs(np.diff(q)) > MOVED_M), gaps_in(time) - 1)
    phases: list[tuple[float, float]] = []
    for k in moved:
        start, end = float(time[k]), float(time[k + 1])
        if phases and start - phases[-1][1] <= PAUSE_S:
            phases[-1] = (phases[-1][0], end)
        else:
            phases.append((start, end))
    return phases


def noise_chart(sensors: tuple[str, ...], noise: FloatArray, slow: FloatArray) -> Chart | None:
    """Return noise and slow deviation of each sensor; None where no noise is seen."""
    if not (noise > 0.0).any():
        return None
    bars = (Bars("noise of single readings", sensors, noise * 1e3, BLUE),
            Bars("slow deviation", sensors, slow * 1e3, PURPLE))  # fmt: skip
    usual, worst = float(np.nanmedian(noise)) * 1e3, int(np.nanargmax(noise))
    panel = Panel("Noise of the thermocouples", bars, "sensor", "standard deviation", "", "mK",
                  log=drawn.wide(noise, slow), height=1.3)  # fmt: skip
    return Chart(
        "noise", "Noise of the thermocouples",
        f"Noise of {len(sensors)} thermocouples: {usual:.0f} mK in the middle, most {sensors[worst]} with "
        f"{noise[worst] * 1e3:.0f} mK; and the slow deviation of each.",
        "Slow deviation: what the other sensors do not explain, noise taken off; an upper bound of a sensor's bias.",
        (panel,), lambda: drawn.noise_figure(sensors, noise, slow),
    )  # fmt: skip


def collinearity_chart(sensors: tuple[str, ...], correlation: FloatArray) -> Chart | None:
    """Return how alike the sensors are; None for fewer than two."""
    if len(sensors) < 2:
        return None
    apart = np.maximum(1.0 - np.abs(correlation), 1e-6)
    np.fill_diagonal(apart, np.nan)
    low, high = span_of(np.log10(apart))
    cells = Cells("log10(1 - |r|)", sensors, sensors[::-1], np.log10(apart)[::-1], "", low, max(high, low + 1e-9))
    return Chart(
        "collinearity", "How alike the thermocouples are",
        f"Matrix of {len(sensors)} by {len(sensors)} thermocouples: 1 - |correlation| within runs, from "
        f"{10.0**low:.1e} to {10.0**high:.2g}.",
        "Darker pairs are more alike: one of two says what the other says. The plot shows the decimal logarithm.",
        (Panel("Collinearity within runs", (cells,), "thermocouple", "thermocouple"),),
        lambda: drawn.collinearity_figure(sensors, correlation),
    )  # fmt: skip


def coverage_chart(check: CampaignCheck) -> Chart | None:
    """Return where the leg was when it was warm; None for a part without a stroke."""
    usable = [k for k, item in enumerate(check.separability) if np.isfinite(item.std_B)]
    if not usable:
        return None
    thin = replace(check, runs=tuple(thinned(run, MOST_DOTS) for run in check.runs))
    best = min(usable, key=lambda k: check.separability[k].std_B)
    item, marks = check.separability[best], []
    for role, colour, look in (("identification", BLUE, "dots"), ("validation", VERMILION, "dots")):
        traces = [run.trace for run in thin.runs if run.run.role == role and run.trace.q is not None]
        if traces:
            q = np.concatenate([one.q for one in traces if one.q is not None]) * 1e3
            marks.append(Curve(role, q, np.concatenate([one.dT[:, best] for one in traces]), colour, look))
    ends = span_of(np.concatenate([one.x for one in marks])) if marks else (0.0, 1.0)
    wide = drawn.room_about(ends)
    panel = Panel(f"Displacement and dT of {item.sensor}", tuple(marks), "q", "dT", "mm", "K", height=1.6,
                  x_range=None if wide == ends else wide)  # fmt: skip

    def still() -> Figure:
        figure = drawn.coverage_figure(thin)
        assert figure is not None  # asked above
        return figure

    longest = max(len(run.trace.time) for run in check.runs)
    thinner = f" Of a run {MOST_DOTS} rows are drawn evenly, and what stands out." if longest > MOST_DOTS else ""
    return Chart(
        "coverage", "Where the leg was when it was warm",
        f"Temperature rise of {item.sensor} against the rod's displacement; cosine between the columns of A and B: "
        f"{item.r:.2f}.",
        f"A and B are told apart where the leg was warm at many displacements.{thinner}", (panel,), still,
    )  # fmt: skip


def matrices_chart(ranked: RankedSets) -> Chart:
    """Return the two matrices of the criteria (paper, fig. 6)."""
    panels, words = [], []
    for by, what in paper.CRITERIA.items():
        sensors, matrix = matrix_of(ranked, by)
        values = matrix * 1e6
        known = values[np.isfinite(values)]
        high = float(np.quantile(known, 0.9)) if known.size else 1.0
        low = span_of(values)[0]
        cells = Cells(what, sensors, sensors, values, "µm", low, max(high, low + 1e-9), True)
        i, j = np.unravel_index(int(np.nanargmin(values)), values.shape)
        pair = sensors[i] if i == j else f"{sensors[min(i, j)]} and {sensors[max(i, j)]}"
        words.append(f"{what} is least for {pair}: {low:.2f} µm")
        panels.append(Panel(f"{what[0].upper()}{what[1:]} of the rows fitted", (cells,), "sensor", "sensor",
                            height=1.15))  # fmt: skip
    return Chart(
        "paper-figure-6", "Every pair of thermocouples",
        f"Two matrices over pairs of thermocouples, single ones on the diagonal: {'; '.join(words)}.",
        "As figure 6 of the paper: the brightest pixel is the best pair, single sensors on the diagonal. Colours end "
        "at the ninth tenth of the values.", tuple(panels), lambda: paper.matrices_figure(ranked),
    )  # fmt: skip


def front_chart(found: Identification) -> Chart:
    """Return the scatter of all sets and the Pareto front (paper, fig. 7)."""
    ranked, chosen = found.ranked, found.chosen
    x, y = ranked.fit.linf * 1e6, ranked.fit.rmse * 1e6
    names = ["–".join(one) for one in ranked.names]

    def of(which: Sequence[int] | npt.NDArray[np.int64], name: str, colour: str, look: str) -> Curve:
        kept = [int(k) for k in which]
        return Curve(name, x[kept], y[kept], colour, look, labels=tuple(names[k] for k in kept))

    front = list(ranked.front())
    line = Curve("Pareto front", x[front], y[front], BLACK, "line", labels=tuple(names[k] for k in front))
    marks = [of(np.flatnonzero(ranked.sizes == 2), "pairs", BLUE, "dots"),
             of(np.flatnonzero(ranked.sizes == 1), "single sensors", paper.ORANGE, "dots"), line]  # fmt: skip
    if chosen >= 0 and ranked.sizes[chosen] <= 2:
        marks.append(of([chosen], f"chosen: {' + '.join(ranked.names[chosen])}", paper.RED, "squares"))
    shown, best = tuple(one for one in marks if len(one.x)), ranked.best(1, left_out=False)
    kept = [*front, best, *([chosen] if chosen >= 0 and ranked.sizes[chosen] <= 2 else [])]
    axes = ("largest residual", "RMSE", "µm", "µm")
    nameless = tuple(replace(one, written=False) for one in shown)  # the zoom has room for names
    panels = (Panel("All sets, fitted rows", nameless, *axes, height=1.3),
              Panel("Zoom on the front", shown, *axes, height=1.6, x_range=_about(x[kept]),
                    y_range=_about(y[kept])))  # fmt: skip
    off = ranked.off_front(best)
    return Chart(
        "paper-figure-7", "The Pareto front",
        f"RMSE against largest residual of {len(names)} sets of thermocouples; on the front: "
        f"{', '.join(names[k] for k in front)}. Best single sensor: {names[best]}, RMSE {y[best]:.2f} µm.",
        f"As figure 7 of the paper. The best single sensor, {names[best]}, is {off[0] * 1e6:.3f} µm in RMSE and "
        f"{off[1] * 1e6:.3f} µm in the largest residual off the front.",
        panels, lambda: paper.front_figure(ranked, chosen),
    )  # fmt: skip


def _about(values: FloatArray) -> tuple[float, float]:
    """Return limits about some numbers, with room for names."""
    low, high = span_of(values)
    room = 0.3 * max(high - low, 0.02 * high, 1e-6)
    return low - room, high + 2.0 * room


def validation_chart(found: Validation, whole: RunCurves, law: IdentifiedLaw) -> Chart:
    """Return one run of a validation (paper, fig. 8)."""
    rows = kept_of(len(whole.time), MOST_POINTS, np.stack([whole.measured, whole.predicted], axis=1), whole.dT)
    q = None if whole.q is None else whole.q[rows]
    curves = RunCurves(whole.run, whole.time[rows], q, *(getattr(whole, name)[rows] for name in (
        "dT", "measured", "predicted", "half_width")))  # fmt: skip
    hours, one = curves.time / HOUR_S, found.runs[curves.run]
    looks = ("line", "dashed", "dotted", "dashdot")
    heat = [Curve(f"ΔT {name}", hours, curves.dT[:, k], paper.VIOLET, looks[k % 4], right=q is not None)
            for k, name in enumerate(law.sensors)]  # fmt: skip
    if q is None:
        top = Panel("Temperature", tuple(heat), "time", "ΔT", "h", "K", height=0.9)
    else:
        rod = Curve("rod extension", hours, q * 1e3, BLACK, "steps")
        top = Panel("Rod and temperature", (rod, *heat), "time", "rod extension", "h", "mm", "ΔT", "K", height=0.9)
    wide = curves.half_width * 1e6
    predicted, measured = curves.predicted * 1e6, curves.measured * 1e6
    bottom = Panel("Drift", (
        Curve("predicted", hours, predicted, BLUE, low=predicted - wide, high=predicted + wide),
        Curve("measured", hours, measured, paper.RED, "dots"), Curve("residual", hours, measured - predicted, GREEN),
    ), "time", "drift", "h", "µm", height=1.5)  # fmt: skip
    fitted = curves.run in found.fitted
    told = (
        "was fitted: it proves nothing" if fitted else "was never fitted" if found.fits_known else "is for validation"
    )
    less = 100.0 * one.mean_reduction.value
    return Chart(
        f"paper-figure-8-{file_name(curves.run)}", f"{run_words(curves.run)}: predicted and measured",
        f"{run_words(curves.run)}: the drift reaches {one.drift_largest * 1e6:.2f} µm, the residual "
        f"{one.linf.value * 1e6:.2f} µm; {100.0 * found.run_coverage[curves.run]:.0f} % of the rows lie inside their "
        "95 % prediction interval.",
        f"As figure 8 of the paper; the run {told}. RMSE {one.rmse.value * 1e6:.3f} µm; the mean residual is "
        f"{less:.0f} % less than the mean drift.{thinned_words(len(rows), len(whole.time))}", (top, bottom),
        lambda: paper.validation_figure(found, curves, law.sensors), True,
    )  # fmt: skip
