"""From an unknown time a thermometer reads the air."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from hexathermal.learn.diagnosis.beside_others import air_above_at_zero, air_read, coming_and_going, lost, replaced
from hexathermal.learn.diagnosis.onsets import (
    KINDS,
    SCANNED,
    Onset,
    even_moments,
    promising,
    runs_since,
    sound_rows,
    where,
)
from hexathermal.learn.diagnosis.sensor_model import MOST_SHARE, Parity, SensorModel, part_of
from hexathermal.learn.diagnosis.trials import Cause, Parameter, Trial, Workbench
from hexathermal.machine.leg_repairs import SensorRepair
from hexathermal.poses import FloatArray

CAUSE = Cause(
    name="sensor-detached",
    physics=(
        "The tape or the glue of one thermometer gives way: from then on, or now and then, it shows the air beside "
        "the part, wholly or in part."
    ),
    signature=(
        "From one moment on the thermometer leaves its neighbours and goes towards the air; the drift follows"
        " the neighbours. Where the contact comes and goes, it leaves them the more, the warmer they are than the air."
    ),
    parameters=(
        Parameter("time_s", "s", "any moment of any run, or from the beginning"),
        Parameter("fixed_again", "1", "0: it stays off; 1: before the next run"),
        Parameter("share", "1", "of the air in the reading after that"),
        Parameter("wander", "K", "of a contact that comes and goes, as the other thermometers tell"),
    ),
    confused_with=(
        "sensor-drift",
        "zero-jump",
        "missing-sensor",
    ),
    experiment="Look at that thermometer; touch it and see whether it answers as before.",
    words="{target} has come off and reads the air in part",
    thermal=True,
)

MOST_MOMENTS = 63
"""Evenly in all runs together."""

SHARES = (0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9)
"""Shares of the air beside which readings that were never on the part alone teach, besides the one that the parity
shows and none of what they read."""

SELDOM = -3.0
"""Log evidence beforehand that a reading had a share of the air in all runs, which no other thermometer tells."""

LEAST_WANDERING = 2.0
"""Log evidence by which a share of the air must wander, rather than the reading or than contact is lost for good, for a
contact that comes and goes to be tried."""


def _order(loss: Onset) -> tuple[bool, int, float, float]:
    """Return what losses are sorted by."""
    return not loss.stays, loss.run, loss.moment, loss.beside


def trials(bench: Workbench) -> Iterator[Trial]:
    """Give a loss of contact of each of the law's sensors at moments of each run."""
    view = bench.view
    if view.airs is None:
        return
    for sensor in view.base:
        model = bench.model(sensor)
        if model is None:
            continue
        span, own = bench.slopes_span(sensor), view.temperatures(sensor)
        even = even_moments(model, min(7, MOST_MOMENTS // len(view.runs)))
        broken = set(view.once((CAUSE.name, sensor), partial(promising, model, _parity)))
        yield from _coming_and_going(bench, model, broken)
        yield _never_wholly_on(bench, model)
        for loss in sorted({*even, *broken, *_from_the_beginning(model)}, key=_order):
            told = view.once((CAUSE.name, sensor, loss), partial(_told, model, loss))
            off = (view.channel.run == loss.run) & (view.time >= loss.moment)
            off |= (view.channel.run > loss.run) & loss.stays
            lost = off * (told - own)
            asked = loss in broken
            # of a thermometer that never sat on the part the law's own B over A says nothing
            apart = loss.begun and view.stroked and view.moves
            columns = np.column_stack([view.q, np.full(len(lost), view.length)]) if apart else span[:, None]
            price = math.log(KINDS * SCANNED / len(even))
            whole = Trial(CAUSE.name, columns * lost[:, None], sensor, "", where(model, loss), partly=True,
                          parity=_parity_of(loss), repair=partial(_repair, model, loss), asked=asked or loss.begun,
                          tight=loss.begun, advantage=-price if asked else 0.0)  # fmt: skip
            yield whole if loss.begun else replace(whole, lessened=partial(_loose_as_told, model, loss))
            if loss.begun:
                tables = [told if name == sensor else view.temperatures(name) for name in view.base]
                yield replace(whole, columns=np.zeros((len(lost), 0)), base=view.base_of(tables), anew=True)
            else:
                column = span * view.once((CAUSE.name, sensor, loss, "own"), partial(_aired, model, loss))
                yield replace(whole, columns=column[:, None], partly=False, ratio=True, in_parity=1.0,
                              lessened=partial(_loose, model, loss))  # fmt: skip


def _never_wholly_on(bench: Workbench, model: SensorModel) -> Trial:
    """Give a share of the air in all readings: that the others foretell them says nothing, they were learnt from it."""
    view, loss = bench.view, Onset(0, float(bench.view.signals[0].time[0]), begun=True)
    column = bench.slopes_span(model.sensor) * view.once(
        (CAUSE.name, model.sensor, "all"), partial(_aired, model, loss)
    )
    # its share is what `lessened` is told; half stands for any where none is asked
    return Trial(CAUSE.name, column[:, None], model.sensor, "", where(model, loss), ratio=True, advantage=SELDOM,
                 repair=partial(_loose, model, loss, 1.0), lessened=partial(_loose, model, loss))  # fmt: skip


def _coming_and_going(bench: Workbench, model: SensorModel, losses: Iterable[Onset]) -> Iterator[Trial]:
    """Give a contact that comes and goes, where the parity wanders as the air does beside the part: others speak.

    What it says of a contact lost at one of the moments that were looked at, a share that wanders says as well.
    """
    view, sensor = bench.view, model.sensor
    if model.spoken_for:
        return
    said, known = view.once((CAUSE.name, sensor, "contact"), partial(coming_and_going, model))
    if said >= LEAST_WANDERING:
        once = max((model.shown_of(_parity_of(loss)).gain for loss in losses), default=0.0) - math.log(SCANNED)
        said -= max(once, 0.0)
    if said < LEAST_WANDERING:
        return
    for k, weights in enumerate(known):
        repair = partial(replaced, CAUSE.name, model, weights)
        for left in view.once((CAUSE.name, sensor, "lost", k), partial(lost, model, weights)).T:
            yield Trial(CAUSE.name, (bench.slopes_span(sensor) * left)[:, None], sensor, "",
                        {"contact": "comes and goes"}, parity=_parity_of(Onset(0, 0.0, begun=True)), repair=repair,
                        errors=(sensor,), wanders=True, by_air=said, asked=True)  # fmt: skip


def _from_the_beginning(model: SensorModel) -> list[Onset]:
    """Return losses before the first row: where places along the part tell what the others foretell."""
    if not model.placed or model.spoken_for:
        return []
    begin = float(model.view.signals[0].time[0])
    shown = model.tight.shown_of(_parity_of(Onset(0, begin, begun=True))).amplitude
    shares = {0.0, *SHARES, float(np.clip(shown, 0.0, MOST_SHARE))}
    return [Onset(0, begin, begun=True, beside=share) for share in shares]


def _repair(model: SensorModel, loss: Onset) -> SensorRepair:
    """Return the repair: from the moment on the others speak for the sensor, in all later runs too if it stays.

    They speak for it in whatever run where it was off from the beginning.
    """
    return replaced(CAUSE.name, model, _weights(model, loss), None if loss.begun else runs_since(model, loss))


def _loose(model: SensorModel, loss: Onset, error: float) -> SensorRepair:
    """Return the repair that takes the air out of the reading: `error` is its share over that of the part."""
    read = air_read(model.view, "air_sensor")
    if loss.begun:
        return SensorRepair(CAUSE.name, "loose", {"sensor": model.sensor, "share": share_of(error)} | read)
    since = runs_since(model, loss)
    above = air_above_at_zero(model, loss.run)
    zeros = [model.view.runs[loss.run].run.name] if model.view.zeroed_by_run else list(since["from_s"])
    if not model.view.zeroed_by_run or loss.moment > 0.0:
        since |= {"air_above_K": dict.fromkeys(zeros, above)}
    return SensorRepair(CAUSE.name, "loose", {"sensor": model.sensor, "share": share_of(error)} | since | read)


def _loose_as_told(model: SensorModel, loss: Onset, _error: float) -> SensorRepair:
    """Return the same with the share that the parity shows: what the others foretell is whole in the drift, or not."""
    share = float(np.clip(model.shown_of(_parity_of(loss)).amplitude, 0.0, MOST_SHARE))
    return _loose(model, loss, share / (1.0 - share))


def share_of(error: float) -> float:
    """Return the share of the air in a reading, from its ratio to that of the part.

    >>> share_of(0.25)
    0.2
    """
    return min(part_of(max(error, 0.0)), MOST_SHARE)


def _told(model: SensorModel, loss: Onset) -> FloatArray:
    """Return what the other sensors foretell in windows, learnt while it sat on the part."""
    return model.view.windows_zeroed(model.foretold(_weights(model, loss)))[:, 0]


def _aired(model: SensorModel, loss: Onset) -> FloatArray:
    """Return by how much the reading itself differs from the air in windows, once contact is lost in part [K].

    ``T = (1 - s) T_part + s T_air`` is ``T_part = T + s / (1 - s) (T - T_air)``: no other thermometer need tell.
    """
    return -model.view.windows_zeroed(_off_the_air(model, loss, model.own))[:, 0]


def _weights(model: SensorModel, loss: Onset) -> FloatArray:
    """Return the weights of the profiles that foretell the sensor, learnt while it sat on the part."""
    return model.weights_beside_air(loss.beside) if loss.beside else model.weights(sound_rows(model, loss))


def _parity_of(loss: Onset) -> Parity:
    """Return what the parity is asked of a loss, the same whatever its readings teach: models keep what it shows."""
    return partial(_parity, replace(loss, beside=0.0))


def _parity(loss: Onset, model: SensorModel) -> tuple[FloatArray, FloatArray]:
    """Return by how much the air differs from the foretold temperature once contact is lost, in the parity."""
    gaps = _off_the_air(model, loss, model.foretold(model.weights(sound_rows(model, loss))))
    return model.means(gaps)[:, None], np.array([0.7])


def _off_the_air(model: SensorModel, loss: Onset, told: Sequence[FloatArray]) -> list[FloatArray]:
    """Return by how much the air differs from a temperature once contact is lost, in all rows of each run [K]."""
    airs = model.view.airs
    assert airs is not None  # looked at before
    gaps = []
    for i, (signals, air, own) in enumerate(zip(model.view.signals, airs, told, strict=True)):
        gap, first = np.zeros(len(own)), loss.first_row(i, signals.time)
        gap[first:] = air[first:] - own[first:]
        if (first or not model.view.zeroed_by_run) and not loss.begun:  # else the zero was read in the air, too
            gap[first:] += air_above_at_zero(model, i)
        gaps.append(gap)
    return gaps
