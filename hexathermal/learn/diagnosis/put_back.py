"""A thermometer that came off in the last of the fitted runs, and sits on the part again in those for validation.

No drift tells of the last run whether contact was lost for good. The other thermometers do, in the runs after it: with
``T_told`` what they foretell, with weights from all windows before the loss, and s the share of the air in its reading,
it reads in later runs, of h hours,

    T_on = T_told,      T_off = T_told + s (T_air - T_told),      log evidence = h/2 log(|T - T_off|^2 / |T - T_on|^2)

since each hour of what a foretelling leaves is worth one value (`hexathermal.learn.diagnosis.replugged`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import reduce

import numpy as np
import numpy.typing as npt

from hexathermal.learn.diagnosis.causes.sensor_detached import CAUSE
from hexathermal.learn.diagnosis.joining import Found
from hexathermal.learn.diagnosis.mending import mended_view
from hexathermal.learn.diagnosis.replugged import FEWEST, HOUR_S, SURE, ridged
from hexathermal.learn.diagnosis.sensor_model import MOST_SHARE
from hexathermal.learn.diagnosis.view import View
from hexathermal.machine.leg_repairs import SensorRepair
from hexathermal.poses import FloatArray

FEWEST_WINDOWS = 3
"""Windows after the loss that must show the share of the air."""


def put_back(repairs: Sequence[SensorRepair], view: View, fitted: Sequence[str]) -> tuple[SensorRepair, ...]:
    """Return repairs; of a thermometer that came off in the last fitted run only until then where it sits right again.

    Parameters
    ----------
    repairs : sequence of SensorRepair
    view : View
        Of all runs, those for validation too, without any of the repairs.
    fitted : sequence of str
        Names of the runs for identification.
    """
    known = list(repairs)
    for k, repair in enumerate(known):
        begins = dict(repair.parameters.get("from_s", {}))
        later = list(begins)[1:]
        if repair.cause != CAUSE.name or not later or set(later) & set(fitted):
            continue
        others = (*known[:k], *known[k + 1 :])
        if _sits_again(repair, reduce(mended_view, others, view), later):
            until = {name: moment for name, moment in begins.items() if name not in later}
            known[k] = replace(repair, parameters={**repair.parameters, "from_s": until, "again_in": later})
    return tuple(known)


def told_back(found: Found, repairs: Sequence[SensorRepair]) -> Found:
    """Return what was named; a loss that was taken to last ended with its run where its repair does."""
    best = found.ranked.best
    trial = best.trial
    ended = any(
        repair.cause == trial.cause == CAUSE.name
        and repair.parameters["sensor"] == trial.target
        and "again_in" in repair.parameters
        for repair in repairs
    )
    if not ended:
        return found
    told = replace(trial, parameters={**trial.parameters, "fixed_again": 1})
    return replace(found, ranked=replace(found.ranked, best=replace(best, trial=told)))


def _sits_again(repair: SensorRepair, view: View, later: Sequence[str]) -> bool:
    """Whether the other thermometers say so of later runs."""
    sensor, (run, moment) = repair.parameters["sensor"], next(iter(repair.parameters["from_s"].items()))
    names = [rows.run.name for rows in view.runs]
    others = [name for name in view.sensors if name != sensor]
    if view.airs is None or not view.zeroed_by_run or len(others) < FEWEST or not {run, *later} <= set(names):
        return False
    of = np.array(names)[view.channel.run]
    lost = (of == run) & (view.time >= moment)
    after = np.isin(of, later)
    if lost.sum() < FEWEST_WINDOWS:
        return False
    own, air = view.temperatures(sensor), view.windows_zeroed(view.airs)[:, 0]
    told = _foretold(np.column_stack([view.temperatures(name) for name in others]), own, ~lost & ~after)
    share = repair.parameters.get("share", _slope((air - told)[lost], (own - told)[lost]))
    off = told + min(max(share, 0.0), MOST_SHARE) * (air - told)
    hours = float(view.channel.rows[after].sum()) * view.sampling / HOUR_S
    tiny = np.finfo(float).tiny
    return bool(0.5 * hours * np.log((_square(own - off, after) + tiny) / (_square(own - told, after) + tiny)) > SURE)


def _foretold(others: FloatArray, own: FloatArray, sound: npt.NDArray[np.bool_]) -> FloatArray:
    """Return what others foretell of a reading, with weights from some windows."""
    X, y = others[sound], own[sound]
    return np.asarray(others @ np.linalg.solve(ridged(X.T @ X), X.T @ y))


def _slope(x: FloatArray, y: FloatArray) -> float:
    """Return the slope of y over x."""
    x = x - x.mean()
    return float(x @ y / max(float(x @ x), np.finfo(float).tiny))


def _square(values: FloatArray, among: npt.NDArray[np.bool_]) -> float:
    """Return the sum of squares of some values."""
    return float(values[among] @ values[among])
