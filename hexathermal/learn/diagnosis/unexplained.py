"""Flexible columns without a name: what follows q, T, t, the weather or an input, but is no cause of the catalogue."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import numpy as np
import numpy.typing as npt
from scipy.integrate import cumulative_trapezoid

from hexathermal.learn.diagnosis.drag import drags
from hexathermal.learn.diagnosis.last_move import last_moves, steps_at_rest
from hexathermal.learn.diagnosis.own_rates import OWN_RATES, each_run, own_rates
from hexathermal.learn.diagnosis.pace import paces
from hexathermal.learn.diagnosis.pieces import going_on
from hexathermal.learn.diagnosis.stuck import stuck
from hexathermal.learn.diagnosis.temperature_shapes import products, reached
from hexathermal.learn.diagnosis.trials import MOVED, PREFIX, STOOD, WORN, Trial, Workbench
from hexathermal.learn.diagnosis.view import View
from hexathermal.poses import FloatArray

THERMAL = ("T", "qT", "input", "the humidity")
"""What errors of thermometers can feign; the relative humidity of a room goes as its temperature."""

WANDERING = (WORN, "the humidity", "the pressure")
"""What thermometers that wander from run to run can feign: it grows all along the campaign, or changes by the day."""

SHORTEST_S, LONGEST_S, LONGER_S = 480.0, 7200.0, (14400.0, 28800.0, 86400.0)
"""Periods of a rhythm."""

FINER, MOST_PERIODS = 1.5, 80
"""Frequencies are tried so closely that one between two is off by 1 / FINER half turns at most at a run's ends; and so
many of them at most."""

WEAR = (1.0, 0.75, 0.5)
"""Powers of the way with which a part wears: straight on, or running in."""

LATE_S, SWELLING_S = 1800.0, (7200.0, 21600.0)
"""Low passes of pressure and humidity [s], and of the humidity alone: granite, polymers and glue swell for hours."""

IMITATING = 3.0
"""Log evidence that the time at each displacement has less, the highest temperature so far, products of two, and rests
before moves: where a rod is out as long as it is in, or it warms all along, the first two go as time does, as a zero
that drifts, a product as either temperature where the other stays, and rests as reversals where they are much alike.
By so much they lead it by chance."""

KINKS = (0.3, 0.4, 0.5, 0.6, 0.7, 0.8)
"""Where a kink in temperature may be, quantiles of it."""


def flexible_trials(bench: Workbench) -> Iterator[Trial]:
    """Give banks of smooth bumps in position, temperature and time, rhythms, weather, inputs and travel."""
    view = bench.view
    if view.moves:
        yield from _moved(view)
    for sensor in view.base:
        T = view.temperatures(sensor)
        yield from _kinks(bench, sensor)
        for count in (4, 8, 16):
            yield Trial(PREFIX + "the temperature", bench.slopes_span(sensor)[:, None] * _hinges(T, count), "T", "",
                        {"sensor": sensor, "hinges": count})  # fmt: skip
        for width in (0.05, 0.1, 0.2, 0.4):
            yield Trial(PREFIX + "the temperature", _play(view.channel.run, T, width * np.ptp(T))[:, None], "T", "",
                        {"sensor": sensor, "play_K": width * float(np.ptp(T))})  # fmt: skip
        if view.moves:
            both = _bumps(view.q, 5)[:, :, None] * _bumps(T, 4)[:, None, :]
            yield Trial(PREFIX + "displacement and temperature", both.reshape(len(T), -1), "qT")
    yield from _of_temperatures(bench.view)
    yield from view.once((PREFIX, "rhythms"), lambda: (*_rhythms(view), *_rates(view)), ())
    yield from view.once((PREFIX, "weather"), lambda: tuple(_weather(bench)), ())
    yield from view.once((PREFIX, "inputs"), lambda: tuple(_inputs(view)), ())


def _moved(view: View) -> Iterator[Trial]:
    """Give what follows the displacement, the way travelled, and how, and how long ago, the rod came where it is."""
    q = view.q
    for count in (6, 14, 30):
        yield Trial(PREFIX + "the displacement", _bumps(q, count), MOVED, "", {"bumps": count})
    for power in (2, 3):
        yield Trial(PREFIX + "the displacement", _powers(q, power), MOVED, "", {"power": power})
    way, zero = view.travelled
    for wear in WEAR:
        yield Trial(PREFIX + "the way travelled", (way**wear - zero**wear)[:, None], WORN, "", {"power": wear})
    since = np.maximum(way - zero, 0.0)
    for columns in (since * q / np.ptp(q), np.sqrt(since), _worn_at_place(view)):
        yield Trial(PREFIX + "the way travelled", columns[:, None], WORN)
    stood = view.once((PREFIX, "stood"), lambda: _stood(view), ())
    for columns in (stood[:, None], np.column_stack([view.time, stood])):
        yield Trial(PREFIX + "the time at each displacement", columns, STOOD, advantage=-IMITATING)
    for columns in view.once((PREFIX, "last moves"), lambda: tuple(last_moves(view)), ()):
        yield Trial(PREFIX + "the last move", columns, MOVED)
    for columns in view.once((PREFIX, "paces"), lambda: tuple(paces(view)), ()):
        yield Trial(PREFIX + "the speed of the last move", columns, MOVED)
    for way_m, columns in view.once((PREFIX, "drags"), lambda: tuple(drags(view)), ()):
        yield Trial(PREFIX + "the way since a reversal", columns, MOVED, "", {"way_m": way_m})
    for rest_s, column in view.once((PREFIX, "stuck"), lambda: tuple(stuck(view)), ()):
        yield Trial(PREFIX + "the rests before moves", column, MOVED, "", {"rest_s": rest_s}, advantage=-IMITATING)
    for time, step in view.once((PREFIX, "steps at rest"), lambda: tuple(steps_at_rest(view)), ()):
        yield Trial(PREFIX + "the rest since a move", step, MOVED, "", {"step_after_s": time})


def _of_temperatures(view: View) -> Iterator[Trial]:
    """Give what temperatures make together, and what stays of the highest and the lowest."""
    for sensor in view.base:
        held = view.once((PREFIX, "reached", sensor), partial(reached, view, sensor), [sensor])
        for extreme, column in held:
            yield Trial(PREFIX + f"the {extreme} temperature so far", column[:, None], "T", "", {"reading_of": sensor},
                        advantage=-IMITATING)  # fmt: skip
    for names, column in view.once((PREFIX, "products"), partial(products, view)):
        both = {"product_of": " and ".join(names)}
        yield Trial(PREFIX + "the product of two temperatures", column[:, None], "T", "", both,
                    advantage=-IMITATING)  # fmt: skip


def _worn_at_place(view: View) -> FloatArray:
    """Return the way gone times the displacement, less that at the zero, shape (n,): what wears more farther out."""
    way, zero = view.travelled
    at_zero = view.q[view.channel.start][view.channel.run]
    return np.asarray((way * view.q - zero * at_zero) / np.ptp(view.q))


def _stood(view: View) -> FloatArray:
    """Return the displacement summed over time since the zero, in windows, shape (n,) [m s]: what slips under a load.

    Where there is one zero it goes on from run to run.
    """
    sums = (cumulative_trapezoid(signals.q, signals.time, initial=0.0) for signals in view.signals)
    stood, zero = going_on(sums, view.pieces, zeroed_by_run=view.zeroed_by_run)
    return stood - zero


def _rates(view: View) -> Iterator[Trial]:
    """Give a rate of each run's own, as of a floor that tilts with the day."""
    lines = own_rates(view)
    if lines is not None:
        yield Trial(PREFIX + OWN_RATES, lines, "t")


def _rhythms(view: View) -> Iterator[Trial]:
    """Give waves in time, in each run with a phase of its own."""
    own = each_run(view)
    for period in _periods(view):
        phase = 2.0 * np.pi * view.time / period
        waves = np.column_stack([np.sin(phase), np.cos(phase)])
        yield Trial(PREFIX + "time (a rhythm)", (waves[:, :, None] * own[:, None, :]).reshape(len(phase), -1), "t", "",
                    {"period_s": float(period)})  # fmt: skip


def _periods(view: View) -> list[float]:
    """Return periods of a rhythm that the longest run tells apart [s]."""
    longest = max(float(np.ptp(view.time[view.channel.run == k])) for k in range(len(view.runs)))
    first, last = 1.0 / LONGEST_S, 1.0 / SHORTEST_S
    count = 1 + int(np.ceil((last - first) * FINER * max(longest, SHORTEST_S)))
    return [*(1.0 / np.linspace(first, last, min(count, MOST_PERIODS))).tolist(), *LONGER_S]


def _kinks(bench: Workbench, sensor: str) -> Iterator[Trial]:
    """Give straight lines above some warmings, and above some temperatures, where those are known.

    Less what they are at the zero.
    """
    warming = bench.view.temperatures(sensor)
    places = [("kink_K", warming, np.zeros_like(warming))]
    told = bench.view.degC(sensor)
    if told is not None and np.ptp(told[1]) > 0.0:  # else both are the same
        places.append(("kink_degC", *told))
    for name, now, zero in places:
        for kink in np.quantile(now, KINKS).tolist():
            line = np.maximum(now - kink, 0.0) - np.maximum(zero - kink, 0.0)
            yield Trial(PREFIX + "the temperature beyond a kink", line[:, None], "T", "",
                        {"sensor": sensor, name: kink})  # fmt: skip


def _bumps(values: FloatArray, count: int) -> FloatArray:
    """Return smooth bumps over the range of values, shape (n, count)."""
    low, high = float(values.min()), float(values.max())
    centres = np.linspace(low, high, count)
    width = (high - low) / (count - 1) * 0.8
    return np.asarray(np.exp(-0.5 * ((values[:, None] - centres) / max(width, 1e-12)) ** 2))


def _powers(values: FloatArray, power: int) -> FloatArray:
    """Return powers of values scaled to -1 .. 1, up to one, the first apart."""
    low, high = float(values.min()), float(values.max())
    x = (2.0 * values - low - high) / max(high - low, 1e-12)
    return np.column_stack([x**k for k in range(1, power + 1)])


def _hinges(values: FloatArray, count: int) -> FloatArray:
    """Return straight lines that begin at places of the range, shape (n, count)."""
    places = np.quantile(values, np.linspace(0.0, 1.0, count + 2)[1:-1])
    scale = max(float(np.ptp(values)), 1e-12)
    return np.maximum(values[:, None] - places, 0.0) / scale


def _play(run: npt.NDArray[np.int64], values: FloatArray, width: float) -> FloatArray:
    """Return values behind a play of some width: hysteresis that knows no rate."""
    out = np.empty_like(values)
    held = 0.0
    for i, value in enumerate(values):
        if i == 0 or run[i] != run[i - 1]:
            held = value
        held = min(max(held, value - 0.5 * width), value + 0.5 * width)
        out[i] = held
    return out


def _inputs(view: View) -> Iterator[Trial]:
    """Give each recorded input as it is, and bent: less what it is at the zero, from which the drift counts."""
    for name in view.runs[0].signals.inputs:
        values = np.concatenate([signals.inputs[name] for signals in view.signals])
        if np.ptp(values) > 0.0:
            for columns in (values[:, None] / np.ptp(values), _hinges(values, 5)):
                yield Trial(PREFIX + f"the input {name}", view.windows_zeroed([columns]), "input")


def _weather(bench: Workbench) -> Iterator[Trial]:
    """Give what the station recorded beside the temperature: humidity and pressure, at once and late.

    What swells takes hours, and did so before the runs.
    """
    view = bench.view
    for name, rows in (("the humidity", 2), ("the pressure", 1)):
        late = view.weather(rows, (0.0, LATE_S))
        if late is not None:
            yield Trial(PREFIX + name, late, name)
    for tau in SWELLING_S:
        late = view.weather(2, (tau,))
        if late is not None:
            swelling = Trial(PREFIX + "the humidity", late, "the humidity", "", {"time_constant_s": tau})
            yield bench.not_at_rest(swelling, tau)
