"""Runs whose thermometers' data are mended, and what is to be made anew of them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, TypeGuard

import numpy as np

from hexathermal.learn.diagnosis.common_error import doubted_alike, outside
from hexathermal.learn.diagnosis.evidence import Scored
from hexathermal.learn.diagnosis.read_later import read_later
from hexathermal.learn.diagnosis.run_after_run import read_by
from hexathermal.learn.diagnosis.sensor_model import FEWEST_DOUBTING, SensorModel, sensor_model
from hexathermal.learn.diagnosis.smoothing import smoothed
from hexathermal.learn.diagnosis.steadied import motion_of
from hexathermal.learn.diagnosis.trials import Delay, Trial
from hexathermal.learn.diagnosis.view import View
from hexathermal.learn.signals import RunRows
from hexathermal.machine.leg_repairs import SensorRepair, repaired
from hexathermal.poses import FloatArray


@dataclass(frozen=True, eq=False)
class Told:
    """What the law's thermometers tell in windows.

    Attributes
    ----------
    law : array, shape (n, p)
        The law's columns.
    doubts : tuple of array, shape (n, k) [K]
        Of each thermometer what the law may rather not believe: its parity, noise of readings, quick warming.
    alike : tuple of array, shape (n, k) [K]
        Of each thermometer what it may err by as all others do.
    """

    law: FloatArray
    doubts: tuple[FloatArray, ...]
    alike: tuple[FloatArray, ...]


def told_by(view: View, model: Callable[[str], SensorModel | None]) -> Told:
    """Return what the law's thermometers tell, by their models."""
    models = [model(sensor) for sensor in view.base]
    parity = [one.innovation if _doubting(one) else np.zeros((len(view.q), 0)) for one in models]
    quick = [view.quick(sensor) for sensor in view.base]
    doubts = tuple(np.column_stack(both) for both in zip(parity, quick, strict=True))
    others = outside(view)
    alike = view.once(("doubted alike",), lambda: view.windows_zeroed(doubted_alike(view)), others)
    return Told(view.base_columns, doubts, (alike,) * len(view.base))


def _doubting(model: SensorModel | None) -> TypeGuard[SensorModel]:
    """Return whether the others foretell a thermometer well enough for the law not to believe it elsewhere."""
    return model is not None and len(model.others) >= FEWEST_DOUBTING


def told_after(view: View, repair: SensorRepair, model: Callable[[str], SensorModel | None]) -> Told:
    """Return what the thermometers tell once data are mended; the mended data themselves are not kept.

    Where all of them are read at another time, so is what the law may rather not believe of each.
    """
    if repair.kind != "clock":
        after = mended_view(view, repair)
        return told_by(after, lambda sensor: sensor_model(after, sensor))
    offset = float(repair.parameters["offset_s"])
    tables = (_rows(view, name, model) for name in view.base)
    return _told(view, [read_later(view, rows, offset, repair.gains) for rows in tables])


def told_late(view: View, delay: Delay, model: Callable[[str], SensorModel | None]) -> Told:
    """Return what the thermometers tell where the part follows them late, or they follow it.

    What the law may rather not believe of a thermometer is as late as its temperature. ``dT + tau dT'``, stage after
    stage, undoes the lateness of a thermometer.
    """

    def rows(sensor: str) -> list[FloatArray]:
        found = _rows(view, sensor, model, recorded=delay.by_motion)
        return motion_of(view).steadied(found) if delay.by_motion else found

    return _told(view, [_delayed(view, name, partial(rows, name), delay) for name in view.base])


def law_late(view: View, delay: Delay) -> FloatArray:
    """Return the law's columns alone of `told_late`."""

    def rows(sensor: str) -> list[FloatArray]:
        return _steadied(view, sensor) if delay.by_motion else view.tables([sensor])

    late = [_delayed(view, name, partial(rows, name), delay, alone=True)[:, 0] for name in view.base]
    return view.base_of(late)


def _steadied(view: View, sensor: str) -> list[FloatArray]:
    """Return a sensor's temperature as motion explains it in all rows of each run, shape (n, 1); it is made once."""
    return view.once(
        ("steadied", sensor), lambda: motion_of(view).steadied(view.as_recorded.tables([sensor])), [sensor]
    )


def _told(view: View, found: Sequence[FloatArray]) -> Told:
    """Return what thermometers tell, from the windows of `_rows`."""
    count = doubted_alike(view)[0].shape[1]
    last = found[0].shape[1] - count
    alike = tuple(table[:, last:] for table in found)
    return Told(view.base_of([table[:, 0] for table in found]), tuple(table[:, 1:last] for table in found), alike)


def _rows(
    view: View, sensor: str, model: Callable[[str], SensorModel | None], *, recorded: bool = False
) -> list[FloatArray]:
    """Return a sensor's temperature, and what the law may rather not believe of it, in all rows of each run."""
    one = model(sensor)
    doubted = [one.doubted] if _doubting(one) else []
    own = (view.as_recorded if recorded else view).tables([sensor])
    parts = [own, *doubted, view.bands(sensor), doubted_alike(view)]
    return [np.column_stack(each) for each in zip(*parts, strict=True)]


def _delayed(
    view: View, sensor: str, rows: Callable[[], list[FloatArray]], delay: Delay, *, alone: bool = False
) -> FloatArray:
    """Return a sensor's rows as a delay has them, in windows, shape (n, k); `alone` rows know no other sensor.

    What undoes lateness is ``(1 + tau D) (1 + tau' D) .. dT``, D being the rate: those of each order are made once.
    """
    if sensor not in delay.sensors:
        return view.windows_zeroed(rows())
    if not delay.late:
        return view.windows_zeroed(view.rows.behind(rows(), delay.stages))
    factors = np.ones(1)
    for tau in delay.stages:
        factors = np.convolve(factors, [1.0, tau])
    key = ("rates", sensor, len(delay.stages), delay.smooths, delay.by_motion, alone)
    rates = view.once(key, lambda: _rates(view, rows(), delay), [sensor] if alone else None)
    return np.asarray(np.tensordot(factors, rates, 1))


def _rates(view: View, rows: Sequence[FloatArray], delay: Delay) -> FloatArray:
    """Return rows' values and their rates, one order after the other, in windows, shape (1 + stages, n, k)."""
    found, times = [view.windows_zeroed(rows)], [signals.time for signals in view.signals]
    for _ in delay.stages:
        rows = [np.gradient(values, time, axis=0) for values, time in zip(rows, times, strict=True)]
        if delay.smooths:
            rows = [smoothed(time, values) for values, time in zip(rows, times, strict=True)]
        found.append(view.windows_zeroed(rows))
    return np.stack(found)


def remade(scored: Scored, repair: SensorRepair, before: View, view: View) -> Scored:
    """Return a term that joined, its columns made of mended data where it reads what the repair mends."""
    trial = scored.trial
    own = trial.parameters
    if not trial.shape or not read_by(own) & touched(view, repair):
        return scored
    starts = trial.columns[:, trial.carried :]
    anew = columns_anew(trial, own, before, view)
    return replace(scored, trial=replace(trial, columns=np.column_stack([anew, starts])))


def columns_anew(trial: Trial, parameters: Mapping[str, Any], before: View, view: View) -> FloatArray:
    """Return the columns of a trial that a law carries, with other parameters, or of another view, as they were made.

    That is of rows or of windows, of smoothed temperatures or of those as recorded.
    """
    carried = trial.columns[:, : trial.carried]
    pairs = [(before, view), (before.as_recorded, view.as_recorded)]
    ways = [(one.columns, other.columns) for one, other in pairs] + [
        (one.quick_columns, other.quick_columns) for one, other in pairs
    ]
    apart = [float(np.abs(made(trial.shape, trial.parameters) - carried).max()) for made, _other in ways]
    return ways[int(np.argmin(apart))][1](trial.shape, parameters)


def mended_view(view: View, repair: SensorRepair) -> View:
    """Return runs whose temperatures are repaired, as the diagnosis sees them."""
    return view.mended(tuple(mended(rows, repair) for rows in view.runs), touched(view, repair))


def touched(view: View, repair: SensorRepair) -> frozenset[str]:
    """Return the thermometers whose readings a repair changes; a clock's are all of them."""
    names = ("sensor", "first", "second")
    return frozenset(repair.parameters[name] for name in names if name in repair.parameters) or frozenset(view.sensors)


def mended(rows: RunRows, repair: SensorRepair) -> RunRows:
    """Return a run whose temperatures are repaired, the air too where a thermometer stands for it."""
    signals = repaired(rows.signals, (repair,), rows.run.name)
    air = signals.air if rows.air_sensor is None else signals.dT[rows.air_sensor]
    return replace(rows, signals=replace(signals, air=air))
