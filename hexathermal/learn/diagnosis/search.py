"""One step of the diagnosis: which cause, none of them, or something without a name."""

from __future__ import annotations

import math
from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from hexathermal.learn.diagnosis.borne_out import TRIFLE, borne_out
from hexathermal.learn.diagnosis.cancelled import all_not_cancelled, cancels, most_visible
from hexathermal.learn.diagnosis.channels import Channel, Levels
from hexathermal.learn.diagnosis.evidence import (
    RHO,
    Base,
    Scored,
    Terms,
    changed_base,
    less_feigned,
    screened,
    terms_of,
)
from hexathermal.learn.diagnosis.forms import CLIMBED, as_joined, by_cause, fullest, other_form, other_lines
from hexathermal.learn.diagnosis.ranking import Ranked, Step, most_valued
from hexathermal.learn.diagnosis.rivals import (
    STEP,
    beyond_chance,
    drifting,
    exchanged,
    lagging,
    late_or_off,
    nameless_bounded,
    never_on_its_part,
    nothing_like_it,
    refracted,
    shaped,
    stepping,
    tilted,
    with_a_misfit,
)
from hexathermal.learn.diagnosis.steadied import steadied_price
from hexathermal.learn.diagnosis.trials import Trial, Workbench
from hexathermal.learn.diagnosis.witnesses import Witnesses
from hexathermal.poses import FloatArray

LEADERS = 7
"""Causes whose noise is fitted anew."""

TWINS = {
    "sensor-drift": ("sensor-detached", "swapped-sensors", "missing-sensor"),
    "sensor-detached": ("sensor-drift", "swapped-sensors", "zero-jump"),
    "thermal-lag": ("swapped-sensors", "clock-offset"),
}  # fmt: skip
"""Causes that explain what another one has left of itself."""

REPEATED = "missing-sensor"
"""The cause that may be there more than once, with another target."""

MOST_WITNESSED = 16
"""Trials of a sensor's fault whose parity is asked, besides those that are asked in any case."""

MENDED = 3
"""Trials of a cause that mends data whose data are mended indeed."""

TIMED = 10.0
"""Log evidence that motion must have against the worst of all clocks to know when temperatures were read."""

LEAST_SURE, SURE = 3.0, 3.5
"""Standard deviations by which log likelihoods of data mended and as recorded differ over all windows up to which the
drift does not speak for a clock that is off, and from which it does wholly: neither law contains the other, either
reads errors of thermometers, and the offset is the best of many."""

FREE = 2.0
"""Evidence that a cause needs besides where its decays before each run are free: no threshold is drawn with these."""


@dataclass(eq=False)
class Search:
    """Screens all trials, then fits the noise anew for the leaders and for the null.

    Attributes
    ----------
    bench : Workbench
    channel : Channel
    base : Base
    largest : float
        RMS of the largest effect thought possible.
    repaired : function, optional
        From a trial that mends data to the base made of the mended data.
    trials : list of Trial
    null : (Levels, float), optional
        Noise and evidence of the base alone; by default they are fitted.
    """

    bench: Workbench
    channel: Channel
    base: Base
    largest: float
    repaired: Callable[[Trial], Base] | None = None
    trials: list[Trial] = field(default_factory=list)
    null: tuple[Levels, float] | None = None
    _bases: dict[int, tuple[Trial, Base]] = field(default_factory=dict)

    @cached_property
    def witnesses(self) -> Witnesses:
        """The parities of the thermometers."""
        return Witnesses(self.bench, self.channel, self.base, self.system)

    @cached_property
    def _most_visible(self) -> float:
        """The most that an effect may show [m]: of more, a part cancels with errors of thermometers."""
        levels, _null = self.null or self.channel.fitted(self.base.X, self.base.sd)
        return most_visible(self.channel, self.base, levels)

    @cached_property
    def _timed(self) -> bool:
        """Whether motion knows when the temperatures were read."""
        return max((abs(trial.advantage) for trial in self.trials if trial.cause in CLIMBED), default=0.0) > TIMED

    @cached_property
    def terms(self) -> list[Terms]:
        """All trials that add columns, as every noise meets them."""
        return terms_of(self.base, self.trials)

    def scored(self, levels: Levels, trials: list[Trial], terms: list[Terms] | None = None) -> list[Scored]:
        """Return trials with their evidence at one noise; `terms` are those of them, where they were made before."""
        found = screened(self.channel, self.base, levels, trials, self.largest, terms)
        found = borne_out(self.channel, self.base, levels, found, self.largest)
        return all_not_cancelled(found, self._most_visible)

    def step(self, trials: list[Trial]) -> Step:
        """Return the ranking of trials over the present base."""
        levels, null = self.null or self.channel.fitted(self.base.X, self.base.sd)
        ranked: dict[str, Ranked] = {}
        terms = self.terms if trials == self.trials else terms_of(self.base, trials)
        for _again in range(2):
            scored = self._closer(self.scored(levels, trials, terms), levels, null)
            families = by_cause(scored)
            leaders = sorted(families, key=lambda name: -self._standing(*families[name], scored))[:LEADERS]
            pool = [levels]
            fits, quicker = {}, {}
            for name in leaders:
                value, best = families[name]
                witnessed = self._witnessed(best, scored)
                families[name] = (witnessed.value + value - best.value, witnessed)
                others = *other_form(witnessed, scored), *other_lines(witnessed, scored)
                fits[name] = [witnessed, *others, *self._told_otherwise(witnessed, scored)]
                found = [self._fit(item, levels)[0] for item in fits[name]]
                pool += found
                quicker[name] = self._in_quick_noise(witnessed, found[0], trials)
                pool += [noise for _grid, _item, noise in quicker[name]]
            # every noise is open to the null and to every leader
            nulls = self.channel.evidences(self.base.X, self.base.sd, pool)
            better = int(np.argmax(nulls))
            believing = self._all_believed(pool)
            for name, (value, best) in families.items():
                if name in fits:
                    grid = value - best.value
                    each = [self._beside(item, grid, pool, nulls, believing, scored) for item in fits[name]]
                    again = [
                        self._beside(item, own, pool, nulls, believing, scored) for own, item, _noise in quicker[name]
                    ]
                    ranked[name] = fullest([max([each[0], *again], key=lambda one: one.value), *each[1:]])
                else:
                    value = min(value, 0.0) if name not in ranked else ranked[name].value
                    ranked[name] = Ranked(name, value, as_joined(best, scored), levels)
            gained = nulls[better] - null
            levels, null = pool[better], nulls[better]
            if gained < TRIFLE:
                break
        order = tuple(sorted(self._weighed(list(ranked.values())), key=lambda item: -item.value))
        return Step(order, levels, null)

    def _in_quick_noise(self, best: Scored, beside: Levels, trials: list[Trial]) -> list[tuple[float, Scored, Levels]]:
        """Return the best trial of a cause if all that is slow were not noise, what its grid costs, and its own noise.

        In noise that has the cause in it, as a walk has anything slow, all its trials look alike. Not of a thermometer,
        whose errors are slow, too; and steps are weighed against landings that stand off, in the null's noise alone.
        """
        own = [one for one in trials if one.cause == best.trial.cause and bool(one.starts) == bool(best.trial.starts)]
        read = best.trial.target in self.bench.view.sensors
        if read or best.trial.cause == STEP or not all(_of_drift_alone(one) for one in (best.trial, *own)):
            return []
        found = by_cause(self.scored(self.channel.quick(beside), own)).get(best.trial.cause)
        if found is None or found[1].trial.columns is best.trial.columns:
            return []
        levels, _ = self._fit(found[1], beside)
        return [(found[0] - found[1].value, self.scored(levels, [found[1].trial])[0], levels)]

    def _weighed(self, ranked: list[Ranked]) -> list[Ranked]:
        """Return causes as they stand against each other."""
        channel, system = self.channel, self.system
        acting = refracted(channel, system, lagging(channel, system, self.bench.view.base, ranked))
        timed = exchanged(late_or_off(shaped(acting), timed=self._timed))
        believed = with_a_misfit(channel, system, never_on_its_part(timed))
        beams = drifting(channel, system, stepping(channel, system, believed))
        led = nothing_like_it(tilted(nameless_bounded(channel, system, beams)))
        return beyond_chance(led) if self.bench.view.kind == "leg" else led

    def _beside(
        self, best: Scored, grid: float, pool: list[Levels], nulls: list[float],
        believing: Callable[[Scored], float], scored: list[Scored],
    ) -> Ranked:  # fmt: skip
        """Return a trial as it stands beside the null, every noise open to both."""
        own, at = max(zip(self._at(best, pool), pool, strict=True), key=lambda pair: pair[0])
        drift = min(own - max(nulls), believing(best)) + grid - np.log(len(RHO)) * bool(best.rho)
        drift = min(drift, 0.0) if cancels(best, self._most_visible) else drift
        joining = self._doubted(as_joined(best, scored), pool, max(nulls))
        joining = self.less_feigned(joining, at, pool[int(np.argmax(nulls))])
        ranked = self.witnesses.heard(Ranked(best.trial.cause, drift, self._unsure(joining, drift, at), at))
        # a fault of a thermometer may be there all the same; of what is late the drift must say something
        alone = not best.trial.fault and cancels(ranked.best, self._most_visible)
        return replace(ranked, value=min(ranked.value, 0.0)) if alone else ranked

    def less_feigned(self, scored: Scored, beside: Levels, null: Levels) -> Scored:
        """Return a trial of which thermometers feign the less, the less wanders beside it, in untied offsets too."""
        free = not self.channel.tied_offsets
        left, slow = (math.hypot(one.slow, free * one.offset) for one in (beside, null))
        return less_feigned(scored, left, slow, null.rms)

    def _all_believed(self, pool: list[Levels]) -> Callable[[Scored], float]:
        """Return what gives a trial's evidence where thermometers share no error, over its price: the most it may say.

        Together with such an error it may be what better thermometers would have read.
        """
        if not self.base.little:
            return lambda _scored: math.inf
        base = self.base.believing
        noises = [*pool, self.channel.fitted(base.X, base.sd, pool[0], 40)[0]]
        null = max(self.channel.evidences(base.X, base.sd, noises))

        def evidence(scored: Scored) -> float:
            own = self.system(scored).believing
            return max(self.channel.evidences(own.X, own.sd, noises)) - null

        return evidence

    def _closer(self, scored: list[Scored], levels: Levels, null: float) -> list[Scored]:
        """Return trials of which those that mend data, the best of each cause, are scored on data that are mended.

        Errors of a thermometer that stand in the null are those of what was recorded under its name.
        """
        lines: dict[Hashable, list[Scored]] = {}
        for item in scored:
            if item.trial.anew:
                lines.setdefault(item.trial.line, []).append(item)
        chosen: dict[int, Scored] = {}
        for line in lines.values():
            climbed = line[0].trial.delay is not None or line[0].trial.cause in CLIMBED
            # a trial that can say nothing takes no other's place
            may = [k for k, item in enumerate(line) if item.trial.most > 0.0]
            best = sorted(may, key=lambda k: -line[k].value)[: 1 if line[0].trial.delay else MENDED]
            if not best:
                continue
            made = {k: self._on_mended(line[k], levels, null) for k in best}
            while climbed:
                top = max(made, key=lambda k: made[k].value)
                beside = [k for k in (top - 1, top + 1) if 0 <= k < len(line) and k not in made]
                if not beside:
                    break
                made.update({k: self._on_mended(line[k], levels, null) for k in beside})
            made.update(self._between(made, levels, null))
            chosen.update({id(line[k]): item for k, item in made.items()})
        return [chosen.get(id(item), item) for item in scored]

    def _between(self, made: dict[int, Scored], levels: Levels, null: float) -> dict[int, Scored]:
        """Return the best trial of a cause made finer, where a parabola through its neighbours tops beside it."""
        top = max(made, key=lambda k: made[k].value)
        finer = made[top].trial.finer
        if finer is None or top - 1 not in made or top + 1 not in made:
            return {}
        before, own, after = (made[k].value for k in (top - 1, top, top + 1))
        bent = before - 2.0 * own + after
        step = 0.5 * (before - after) / bent if bent < 0.0 else 0.0
        best = self._on_mended(replace(made[top], trial=finer(step)), levels, null) if step else made[top]
        return {top: best} if best.value > own else {}

    def _on_mended(self, item: Scored, levels: Levels, null: float) -> Scored:
        """Return a trial that mends data with its evidence on data that are mended, where that is more."""
        value = min(self._at(item, [levels])[0] - null, item.trial.most) + item.trial.advantage
        return replace(item, value=max(item.value, value))

    def system(self, scored: Scored) -> Base:
        """Return the base with the trial in it."""
        trial = scored.trial
        if trial.anew and self.repaired is not None:
            return self._mended(trial)
        base = changed_base(self.base, trial)
        return base.extended(scored.trial.columns, scored.size) if scored.trial.columns.shape[1] else base

    def _mended(self, trial: Trial) -> Base:
        """Return the base of the data that a trial mends."""
        assert self.repaired is not None  # asked before
        if id(trial) not in self._bases:
            self._bases[id(trial)] = trial, self.repaired(trial)
        return self._bases[id(trial)][1]

    def _fit(self, scored: Scored, begin: Levels) -> tuple[Levels, float]:
        base = self.system(scored)
        return self.channel.fitted(base.X, base.sd, begin, 40)

    def _at(self, scored: Scored, pool: Sequence[Levels]) -> list[float]:
        """Return the evidence of the base with a trial in it at each of some levels."""
        base = self.system(scored)
        values = self.channel.evidences(base.X, base.sd, pool)
        if scored.trial.unlate is None:
            return values
        other = self._mended(scored.trial.unlate) if self.repaired else changed_base(self.base, scored.trial.unlate)
        nulls, unlate = (self.channel.evidences(one.X, one.sd, pool) for one in (self.base, other))
        each = zip(values, nulls, unlate, strict=True)
        return [value - steadied_price(value - null, own - null) for value, null, own in each]

    def _doubted(self, scored: Scored, pool: list[Levels], null: float) -> Scored:
        """Return a trial that counts against nothing only as far as what a law carries of it does.

        What had not come to rest before the runs is free in each of them, and imitates anything slow: what it explains
        by itself is no evidence for the cause.
        """
        trial, first = scored.trial, scored.trial.carried
        if not trial.starts:
            return scored
        before = self.base.extended(trial.columns[:, first:], scored.size[first:])
        alone = max(self.channel.evidences(before.X, before.sd, pool))
        return replace(scored, trial=replace(trial, doubt=max(alone - null, 0.0) + FREE))

    def _unsure(self, scored: Scored, drift: float, levels: Levels) -> Scored:
        """Return a trial whose evidence in the drift does not count against nothing where it may be chance.

        Laws that do not contain one another differ by chance in each window, although neither is better: with d the
        windows' differences of log likelihood, ``sum(d) / sqrt(sum(d^2))`` is standard normal then (Vuong, Econometrica
        57 (1989) 307). What motion says of a clock counts no further than what the drift says: heat on its way to a
        thermometer is late, too.
        """
        if scored.trial.cause not in CLIMBED:
            return scored
        before, after = (self._whitened_left(base, levels) for base in (self.base, self.system(scored)))
        d = 0.5 * (before**2 - after**2)
        z = d.sum() / max(np.sqrt((d**2).sum()), np.finfo(float).tiny)
        doubted = 1.0 - np.clip((z - LEAST_SURE) / (SURE - LEAST_SURE), 0.0, 1.0)
        said = max(drift, 0.0)
        seconded = min(scored.trial.advantage, said)
        return replace(scored, trial=replace(scored.trial, doubt=float(doubted * said), advantage=seconded))

    def _whitened_left(self, base: Base, levels: Levels) -> FloatArray:
        """Return what a base leaves of the channel, whitened, shape (n,)."""
        _, mean = self.channel.solved(base.X, base.sd, levels)
        left, _ = self.channel.whitened((self.channel.y - base.X @ mean)[:, None], levels)
        return left[:, 0]

    def _standing(self, value: float, best: Scored, scored: list[Scored]) -> float:
        """Return what makes a cause a leader: its evidence in the drift, and what a fault shows in the parity.

        The drift knows little of a fault late in the last run: the null may rather not believe that thermometer.
        """
        chosen = self._witnessed(best, scored)
        trial = chosen.trial
        if trial.wanders:
            return value + self.witnesses.spoken(chosen)
        if trial.least_parity >= 0.0:
            return value + self.witnesses.whole(trial)
        return value if trial.parity is None else value + max(self.witnesses.parity(trial), 0.0)

    def _told_otherwise(self, best: Scored, scored: list[Scored]) -> list[Scored]:
        """Return the best trial of each other way to tell the same fault, see `Trial.way`.

        Each has witnesses of its own: what the others foretell shows large losses better, the reading small ones.
        """
        ways: dict[tuple[bool, ...], list[Scored]] = {}
        for item in scored:
            if item.trial.cause == best.trial.cause and (item.trial.fault or item.trial.ratio):
                ways.setdefault(item.trial.way, []).append(item)
        ways.pop(best.trial.way, None)
        return [self._witnessed(max(items, key=lambda item: item.value), items) for items in ways.values()]

    def _witnessed(self, best: Scored, scored: list[Scored]) -> Scored:
        """Return the trial of a sensor's fault that drift and parity together speak for; others as they are."""
        own = [item for item in scored if item.trial.cause == best.trial.cause]
        if all(item.trial.parity is None for item in own):
            return best
        asked = [item for item in own if item.trial.asked]
        rest = sorted((item for item in own if not item.trial.asked), key=lambda item: -item.value)
        top = asked + rest[:MOST_WITNESSED]
        return most_valued(top, lambda item: item.value + self.witnesses.most_spoken(item),
                           lambda item: item.value + self.witnesses.spoken(item))  # fmt: skip


def _of_drift_alone(trial: Trial) -> bool:
    """Whether only the drift tells of a trial, which mends nothing."""
    return trial.parity is None and trial.delay is None and not trial.anew
