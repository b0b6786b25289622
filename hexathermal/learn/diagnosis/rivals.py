"""Causes against each other: a shape that is a little wrong leaves a little, and what takes that too does not lead."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from hexathermal.learn.diagnosis.causes import catalogue
from hexathermal.learn.diagnosis.channels import Channel
from hexathermal.learn.diagnosis.evidence import LEAST, Base, Scored, relevance
from hexathermal.learn.diagnosis.ranking import SURE_WITNESS, Ranked
from hexathermal.learn.diagnosis.spans import beside
from hexathermal.machine.leg_terms import BY_MOTION, PRESSURE
from hexathermal.poses import FloatArray

LATE, OFF, SHIFTED = "thermal-lag", "clock-offset", 0.08
"""A lag, a clock that is off, and the part of a lag's evidence by which the clock must lead it."""

LEAST_PART, MOST_PART, UNLIKELY = 0.3, 2.7, 0.85
"""What a lag acts by over the law's own A, from and to, beyond two standard deviations: a part of the length may be
late, and a time constant of the grid be too short by so much; and the part of what is beyond that counts of its
evidence."""

AIR, MOST_INDEX = "air-refraction", 2.0
"""Air along the beams, and the most of its index that may have been left out: a path may be twice as long as stated."""

RATES = ("lead", BY_MOTION)
"""Shapes of a late thermometer by its rates: with times of a grid, amplitudes tell how late it is."""

MISSING, PLUGS, IMITATED = "missing-sensor", "swapped-sensors", 0.85
"""Another thermometer that matters, exchanged ones, and the part of its evidence, or of a lag's, that these have where
they are it."""

SELDOM = {"swapped-sensors": (1.0 / 3.0, np.inf), "nonlinear-expansion": (1.0, 1.0), "frame-expansion": (1.0, 0.8),
          "air-refraction": (1.0, 0.8), OFF: (0.0, 0.0), LATE: (0.0, 0.0)}  # fmt: skip
SELDOM_ELSE = (1.0 / 6.0, 0.8)
"""Part of a name's evidence that counts against nothing, whatever thermometers may feign, and how much of it something
without a name may say then: errors have neither the amplitude of an exchange nor the square of a temperature by chance,
nor do they follow a room hours later. Of 500 sound legs on six benches one showed an exchange beyond 12, by 23, none of
these others beyond 4, and five any other name beyond 24, by 28 to 49. A clock or a lag moves little, and loggers are
off by seconds everywhere. Of parts, which thermometers' errors move by a micrometre, nothing of this is known."""

NAMELESS_PART, ALL_NAMES = 0.25, 0.8
"""Part of what something without a name says that counts against nothing in any case, and the part of it that all names
must say less than. Of 252 sound legs on nine benches of three hands one had something nameless beyond 9, by 21, of 83
sound parts one, by 12."""

LOST, SURELY, NEARLY, ORDERED = "sensor-detached", 5.0, 0.65, 5.0
"""Lost contact, what a parity must say for it, the part of the evidence for an exchange that it must have, and what the
order along the leg says for an exchange that is beyond doubt."""

TILT, MEASURED = "abbe-tilt", 0.87
"""The cause that the beams measure, and the part of the largest evidence from which on it leads."""

FORETOLD = "foretold"
"""The shape in which other thermometers tell what one lacks: an error of their weights looks like a missing one."""

DRIFT, DRIFTED, LINE = "zero-drift", 0.85, 0.9
"""A drift of the zero, the part of tilt's evidence that it must have, and the part of tilt within runs, squared, that
goes as time where it is the drift of a beam."""

STEP, STEPS = "zero-jump", 0.6
"""A step of the zero, and the part of tilt in its run, squared, that goes as it where it is the step of a beam; and of
all runs' tilt what a step in each explains then."""

System = Callable[[Scored], Base]
"""Gives the base with a trial in it."""

SHAPE_ERROR = 0.03
"""Part of the leader's evidence that the error of its shape may make."""

LITTLE = 0.08
"""What an error of a name's shape may leave, RMS over the noise."""


def nameless_bounded(channel: Channel, system: System, ranked: list[Ranked]) -> list[Ranked]:
    """Return the ranking in which what is nameless leads a name only as far as it shows beside that name.

    A name whose shape is a little wrong leaves a little: the lead of anything that takes that too is bounded as
    that of any small misfit, by what it takes over `LITTLE` of the noise. Of a name whose shape is hardly ever as pure
    as its sketch (`Cause.bent`), what flexible columns take beside it may be its bend: then they do not lead at all.
    """
    best = _first_name(ranked)
    if best is None or best.gated < LEAST:
        return ranked
    base, own = system(best.best), best.best.trial
    law = np.column_stack([base.X[:, : base.plain], own.columns])
    most, found = catalogue()[best.cause].CAUSE.bent, list[Ranked]()
    for item in ranked:
        if not item.named and item.value > best.value:
            trial = item.best.trial
            both = base.extended(trial.columns, item.best.size)
            _, mean = channel.solved(both.X, both.sd, item.levels)
            amplitudes = mean[len(mean) - trial.columns.shape[1] :]
            taken = beside(trial.columns, law) @ amplitudes
            lead = 0.5 * float((taken**2).mean()) / (LITTLE * item.levels.rms) ** 2
            if most > 0.0 and trial.columns.shape[1] > 1:
                bend = _bend(channel, base, item, best, amplitudes)
                lead = lead if bend > most else 0.0
            item = replace(item, value=min(item.value, float(best.value + lead)))
        found.append(item)
    return found


def _bend(channel: Channel, base: Base, item: Ranked, name: Ranked, amplitudes: FloatArray) -> float:
    """Return what flexible columns take beside a name and the law over what that name takes itself, both whitened.

    `base` is the null with the name, `amplitudes` are those of the columns beside it.
    """
    p, k = base.plain, name.best.trial.columns.shape[1]
    table = np.column_stack([base.X[:, :p], name.best.trial.columns, item.best.trial.columns])
    white, _ = channel.whitened(table, item.levels)
    _, mean = channel.solved(base.X, base.sd, item.levels)
    own = beside(white[:, p : p + k], white[:, :p]) @ mean[len(mean) - k :]
    taken = beside(white[:, p + k :], white[:, : p + k]) @ amplitudes
    return float(np.linalg.norm(taken)) / max(float(np.linalg.norm(own)), 1e-300)


def with_a_misfit(channel: Channel, system: System, ranked: list[Ranked]) -> list[Ranked]:
    """Return the ranking in which a name leads a smaller one that need only be its misfit.

    Any law may leave a small misfit, also in the shape of the leader: that costs what so small an effect may say,
    `Ranked.gated`. A larger effect that explains more than this beside the leader, and more than the error of the
    leader's own shape may leave, leads by the rest. Where the leader itself may be no more than such a misfit, the null
    has it as well, and nothing is gained.
    """
    first = _first_name(ranked)
    if first is None or first.gated < LEAST or not first.best.trial.columns.shape[1]:
        return ranked
    return [
        _over(channel, system, item, first) if item.named and not item.unlikely and item.gated > first.gated else item
        for item in ranked
    ]


def lagging(channel: Channel, system: System, sensors: tuple[str, ...], ranked: list[Ranked]) -> list[Ranked]:
    """Return the ranking in which a lag that does not act by about the law's own A of its sensor counts for less.

    What warms late moves the part by its A, or by that of a part of it, and in no other direction; a thermometer that
    is late shows what is yet to come, and not the reverse. Low passes and rates of a temperature imitate stored heat,
    another place, or a clock that is far off, by any amplitude.
    """
    late = of_cause(ranked, LATE)
    if late is None or late.best.trial.target not in sensors or not late.best.trial.carried:
        return ranked
    trial, base = late.best.trial, system(late.best)
    mean, covariance = channel.estimated(base.X, base.sd, late.levels)
    first, own = len(mean) - trial.columns.shape[1], sensors.index(str(trial.target))
    bounds = np.zeros((2, len(mean)))
    if trial.shape in RATES:  # at rates that are slow two columns both go as T', the second twice
        bounds[0, first:] = (1.0, 2.0)[: len(mean) - first]
    else:
        bounds[:, first], bounds[:, own] = (1.0, -1.0), (-LEAST_PART, MOST_PART)
    spread = np.maximum(np.einsum("ij,jk,ik->i", bounds, covariance, bounds), 0.0)
    over = np.sign(mean[own]) * (bounds @ mean) + 2.0 * np.sqrt(spread)
    if np.all(over >= 0.0):
        return ranked
    return _with(ranked, replace(late, value=UNLIKELY * late.value, unlikely=True))


def refracted(channel: Channel, system: System, ranked: list[Ranked]) -> list[Ranked]:
    """Return the ranking in which an index of which far more than all was left out counts for less.

    A thermometer of the law that reads the air makes the law lack what goes with the air, by any amount. A pressure
    alone by which the path seems shorter counts for nothing: no index was left out, it presses.
    """
    air = of_cause(ranked, AIR)
    if air is None or not air.best.trial.columns.shape[1]:
        return ranked
    base = system(air.best)
    mean, covariance = channel.estimated(base.X, base.sd, air.levels)
    sure = 2.0 * np.sqrt(covariance[-1, -1])
    presses = air.best.trial.parameters.get("weather") == PRESSURE and mean[-1] < -sure
    if abs(mean[-1]) - sure <= MOST_INDEX and not presses:
        return ranked
    return _with(ranked, replace(air, value=0.0 if presses else UNLIKELY * air.value, unlikely=True))


def late_or_off(ranked: list[Ranked], *, timed: bool) -> list[Ranked]:
    """Return the ranking in which a clock that is off leads a lag only where it does so clearly.

    A clock is a pure shift, and where one is off the evidence knows it, and motion speaks for it. A lag is sketched by
    low passes: any error of that sketch is one that a shift may mend. Where the two are as good, what stands for the
    clock stands for the lag: where the clock leads without motion, and where times are known (`timed`), since motion
    would know of a clock.
    """
    late, off = of_cause(ranked, LATE), of_cause(ranked, OFF)
    if late is None or off is None or late.hardly_shows or off.gated < LEAST:
        return ranked
    if off.value > (1.0 + SHIFTED) * late.value:
        return ranked
    if off.value < late.value and not timed:
        return ranked
    if off.value >= late.value and off.best.trial.advantage > 0.0:
        return ranked
    ahead, behind = max(late.value, off.value), min(late.value, off.value)
    return _with(ranked, replace(late, value=ahead, borne=off.gated), replace(off, value=behind))


def exchanged(ranked: list[Ranked]) -> list[Ranked]:
    """Return the ranking in which another thermometer, or a lag, leads exchanged plugs only where it does so clearly.

    An exchange has no amplitude. What is missing, or late, has one, and imitates an exchange by taking all of the law
    for itself; where it is there indeed, an exchange explains little of it. What stands for the best of these stands
    for the exchange, then.
    """
    plugs = of_cause(ranked, PLUGS)
    rivals = sorted((item for item in ranked if _imitates(item)), key=lambda item: -item.value)
    if plugs is None or plugs.hardly_shows or not rivals or plugs.value < IMITATED * rivals[0].value:
        return ranked
    first = rivals[0]
    if max(plugs.gated, first.gated) < LEAST:
        return ranked
    leads = replace(plugs, value=max(plugs.value, first.value))
    if first.gated > plugs.gated:
        sound = replace(plugs.best, trial=replace(plugs.best.trial, doubt=0.0))
        leads = replace(leads, best=sound, borne=first.gated)
    behind = min(plugs.value, first.value)
    return _with(ranked, leads, *(replace(item, value=min(item.value, behind)) for item in rivals))


def beyond_chance(ranked: list[Ranked]) -> list[Ranked]:
    """Return the ranking in which a part of what is said for each name is no misfit of the drift.

    But not where something without a name says as much, or nearly: a kink is no square, and imitates one.
    """
    nameless = max((item.value for item in ranked if not item.named), default=0.0)
    found = []
    for item in ranked:
        part, most = SELDOM.get(item.cause, SELDOM_ELSE)
        counts = item.named and nameless < most * item.value
        found.append(_at_least(item, part) if counts else item)
    return found


def nothing_like_it(ranked: list[Ranked]) -> list[Ranked]:
    """Return the ranking in which a part of what has no name, and is unlike all names, is no misfit of the drift."""
    names = max((item.value for item in ranked if item.named), default=0.0)
    return [
        _at_least(item, NAMELESS_PART) if not item.named and names < ALL_NAMES * item.value else item for item in ranked
    ]


def _at_least(item: Ranked, part: float) -> Ranked:
    """Return a cause of whose evidence, over its doubts, a part counts whatever thermometers feign."""
    # no thermometer feigns it, but no model is exact
    most = relevance(item.best.visible, item.levels.usual, 0.0)
    counts = min(part * (item.value - item.best.trial.doubt), most) - item.gated
    return replace(item, borne=item.borne + counts) if counts > 0.0 and item.gated > 0.0 else item


def never_on_its_part(ranked: list[Ranked]) -> list[Ranked]:
    """Return the ranking in which a thermometer that reads the air from the beginning leads exchanged plugs.

    What reads mostly air tells of no place, and a neighbour's reading stands for its own as well as all others do: of
    an exchange the order along the leg knows, of the air the parity.
    """
    plugs, lost = of_cause(ranked, PLUGS), of_cause(ranked, LOST)
    if plugs is None or lost is None or not NEARLY * plugs.value < lost.value < plugs.value or lost.gated < LEAST:
        return ranked
    begun = "since" in lost.best.trial.parameters and "from_run" not in plugs.best.trial.parameters
    if not begun or lost.witness < SURELY or plugs.best.trial.advantage > ORDERED:
        return ranked
    leads = replace(lost, value=plugs.value, borne=max(lost.borne, plugs.gated))
    return _with(ranked, leads, replace(plugs, value=lost.value))


def _imitates(item: Ranked) -> bool:
    """Return whether a cause may take all of the law for itself: not a reading that is late with all that it reads."""
    return item.cause == MISSING or (item.cause == LATE and item.best.trial.shape != FORETOLD)


def steps_with(channel: Channel, step: FloatArray, values: FloatArray) -> bool:
    """Return whether values, shape (n,), go as a step in the run of that."""
    runs = [k for k in np.unique(channel.run) if np.ptp(step[channel.run == k]) > 0.0]
    if not runs:
        return False
    within = channel.run == runs[0]
    both = values[within] - values[within].mean(), step[within] - step[within].mean()
    size = float((both[0] @ both[0]) * (both[1] @ both[1]))
    return float(both[0] @ both[1]) ** 2 > STEPS * size


def stepped(channel: Channel, values: FloatArray) -> float:
    """Return the part of values' squares within runs, shape (n,), that the best step in each run explains."""
    said, whole = 0.0, 0.0
    for run in np.unique(channel.run):
        own = values[channel.run == run] - values[channel.run == run].mean()
        before = np.arange(1, len(own))
        said += float(np.max(np.cumsum(own)[:-1] ** 2 * len(own) / (before * before[::-1]), initial=0.0))
        whole += float(own @ own)
    return said / whole if whole > 0.0 else 0.0


def drifting(channel: Channel, system: System, ranked: list[Ranked]) -> list[Ranked]:
    """Return the ranking in which tilt that goes as time is the drift of the zero: of a beam, or of its target."""
    tilt, drift = of_cause(ranked, TILT), of_cause(ranked, DRIFT)
    if tilt is None or drift is None or drift.gated < LEAST or drift.value < DRIFTED * tilt.value:
        return ranked
    base, columns = system(tilt.best), tilt.best.trial.columns
    _, mean = channel.solved(base.X, base.sd, tilt.levels)
    both = np.column_stack([columns @ mean[len(mean) - columns.shape[1] :], drift.best.trial.columns[:, 0]])
    for run in np.unique(channel.run):
        both[channel.run == run] -= both[channel.run == run].mean(axis=0)
    size = both.T @ both
    if size[0, 1] ** 2 <= LINE * size[0, 0] * size[1, 1]:
        return ranked
    least, most = sorted((tilt.value, drift.value))
    return _with(ranked, replace(tilt, value=least), replace(drift, value=most))


def stepping(channel: Channel, system: System, ranked: list[Ranked]) -> list[Ranked]:
    """Return the ranking in which tilt that only steps is the step of the zero: a beam, or its target, that jumped.

    In the run of the step what tilt explains correlates with it, and other runs have steps of their own: in all of them
    together one step in each is most of it. Where the rod moves once, all that goes with its place steps.
    """
    tilt, step = of_cause(ranked, TILT), of_cause(ranked, STEP)
    if tilt is None or step is None or step.gated < LEAST or tilt.value < step.value:
        return ranked
    base, columns = system(tilt.best), tilt.best.trial.columns
    _, mean = channel.solved(base.X, base.sd, tilt.levels)
    shown = columns @ mean[len(mean) - columns.shape[1] :]
    if not steps_with(channel, step.best.trial.columns[:, 0], shown) or stepped(channel, shown) < STEPS:
        return ranked
    return _with(ranked, replace(tilt, value=step.value), replace(step, value=tilt.value))


def tilted(ranked: list[Ranked]) -> list[Ranked]:
    """Return the ranking in which tilt that the beams measured leads what explains hardly more.

    Tilt is measured, with the beams' noise, and it is there for a reason: temperatures, heat or the place of the rod go
    with it, and imitate it. Where it is not the cause, it explains little, but for a beam that jumps, or drifts.
    """
    tilt = of_cause(ranked, TILT)
    if tilt is None or tilt.gated < LEAST:
        return ranked
    first = max(ranked, key=lambda item: item.value)
    if first.cause in (STEP, DRIFT) or tilt.value < MEASURED * first.value:
        return ranked
    return [replace(item, value=first.value if item is tilt else min(item.value, tilt.value)) for item in ranked]


def shaped(ranked: list[Ranked]) -> list[Ranked]:
    """Return the ranking in which what a thermometer's error is leads that it wanders.

    A reading that wanders is held against the noise of other thermometers, a fault with a shape against its own, which
    was fitted with the fault in it. What the parity says for the shape beyond any chance, it says beside the wandering.
    """
    readings = (item for item in ranked if item.best.trial.wanders and "contact" not in item.best.trial.parameters)
    wandering = {item.best.trial.target: item.value for item in readings}
    return [_beside_wandering(item, wandering.get(item.best.trial.target, -np.inf)) for item in ranked]


def _beside_wandering(item: Ranked, wandering: float) -> Ranked:
    """Return a fault that the parity shows with what the same thermometer says for wandering besides."""
    trial, sure = item.best.trial, item.witness - SURE_WITNESS
    if not trial.fault or trial.wanders or sure <= 0.0:
        return item
    return replace(item, value=max(item.value, wandering + sure))


def _over(channel: Channel, system: System, item: Ranked, first: Ranked) -> Ranked:
    """Return a name with the evidence that it has with a misfit in the shape of the first one, where that leads."""
    own = system(item.best)
    both = own.extended(first.best.trial.columns, first.best.size)
    noises = first.levels, item.levels
    alone, together = (max(channel.evidences(base.X, base.sd, noises)) for base in (system(first.best), both))
    lead = together - alone - first.gated - SHAPE_ERROR * first.value
    # what other witnesses say for the first one, no misfit of the drift does
    value = first.value - max(first.besides, 0.0) + lead + item.besides
    return replace(item, value=max(item.value, value)) if lead > 0.0 else item


def of_cause(ranked: Sequence[Ranked], cause: str) -> Ranked | None:
    """Return a cause of the ranking, where it is there."""
    return next((item for item in ranked if item.cause == cause), None)


def _with(ranked: list[Ranked], *items: Ranked) -> list[Ranked]:
    """Return the ranking with some causes as they are now."""
    changed = {item.cause: item for item in items}
    return [changed.get(item.cause, item) for item in ranked]


def _first_name(ranked: list[Ranked]) -> Ranked | None:
    """Return the name with the largest evidence, where it has any."""
    names = [item for item in ranked if item.named and item.value > 0.0]
    return max(names, key=lambda item: item.value, default=None)
