"""What thermometers say of a fault of one of them, beside what the drift says."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from hexathermal.learn.diagnosis.beside_the_law import BesideTheLaw
from hexathermal.learn.diagnosis.channels import Channel, Levels
from hexathermal.learn.diagnosis.evidence import Base, Scored
from hexathermal.learn.diagnosis.ranking import SURE_WITNESS, Ranked
from hexathermal.learn.diagnosis.sensor_model import MOST_SHARE, SensorModel, Shown, part_of
from hexathermal.learn.diagnosis.trials import Trial, Workbench

BYSTANDERS = 8
"""Sensors outside the law whose parity is asked for the same fault: what they show of it is chance."""

USUAL, UNUSUAL = 0.8, 2.0
"""Quantile of the bystanders, or their mean and so many of their standard deviations, that counts as chance."""

MOST_PARITY = 1000.0
"""Most that the parity says for or against a fault."""

FOLLOWED, LEAST_WITNESS = 5.0, 2.0
"""What the drift says for a sensor's fault counts up to so many times what the parity says beyond so much."""

WHOLE, PARTLY = 0.15, 0.3
"""Error of what is 1 where a fault is whole: the shape of it is a sketch; and how far off 1 it still counts in part."""

IN_DRIFT = 0.15
"""Part of a whole fault that the drift must show of it for all that the parity says of it to count."""

SEEN = 3.0
"""Log evidence that a parity would have to say of an error in the drift to be asked for all of it; from half of it on
for a part."""

MOST_LATE, SECOND_LATE = 3.0, 7.0
"""Most that a parity says for lateness, and how many times what it says for a whole one, if that is more: heat that
comes from one end makes sound thermometers late."""

RATES = (1.0, 2.0)
"""Time constants by which a first and a second low pass are late."""

FEWEST_BYSTANDERS = 3
"""Fewer do not tell what a sound thermometer shows of a whole fault."""

AGREED, LEAST_AGREED = 10.0, 1.0
"""Where both tell of one error, it counts up to so many times the evidence for that beyond so much: sound thermometers
wander a little."""


@dataclass(frozen=True, eq=False)
class Witnesses:
    """The parities of thermometers, asked for what trials say of them.

    Attributes
    ----------
    bench : Workbench
    channel : Channel
        The drift in windows.
    base : Base
        What trials must beat.
    system : function
        From a trial to the base with it.
    """

    bench: Workbench
    channel: Channel
    base: Base
    system: Callable[[Scored], Base]

    @cached_property
    def beside_the_law(self) -> BesideTheLaw:
        """Faults in the drift beside the law, and what joined it, alone."""
        first = slice(self.base.plain)
        return BesideTheLaw(self.channel, self.base.X[:, first], self.base.sd[first], self.bench.view.base)

    def spoken(self, item: Scored) -> float:
        """Return what the parity says for a trial, as far as it counts; of a fault that need show there, all of it."""
        trial = item.trial
        if trial.wanders:
            drift = max(item.value, 0.0)
            return min(self._beyond(trial), drift) + self._by_air(trial, drift)
        if trial.least_parity >= 0.0:
            return self._late(trial, item.value)
        own = self._gain(trial, trial.target)
        return own * self._in_drift(trial) if (trial.partly or trial.ratio) and own > 0.0 else own

    def most_spoken(self, item: Scored) -> float:
        """Return the most that `spoken` may be, without asking other thermometers."""
        trial = item.trial
        if trial.wanders:
            drift = max(item.value, 0.0)
            return drift + min(trial.by_air, drift)
        own = self._gain(trial, trial.target)
        return own if trial.least_parity < 0.0 else max(own, 0.0)

    def _late(self, trial: Trial, drift: float) -> float:
        """Return what the parity says for lateness: as the drift does, a little, or what it says for a whole one."""
        whole = self.whole(trial)
        most = max(MOST_LATE, SECOND_LATE * whole)
        return max(self._partly(trial) * min(self.parity(trial), max(drift, 0.0), most), whole)

    def _partly(self, trial: Trial) -> float:
        """Return the part that counts of what a parity says: less where what should be whole is not."""
        shown = self.shown(trial) if trial.whole else None
        return 1.0 if shown is None else float(np.exp(-0.5 * ((shown.amplitude - 1.0) / PARTLY) ** 2))

    def heard(self, ranked: Ranked) -> Ranked:
        """Return a cause whose value is the evidence in the drift with that of other witnesses.

        A fault of a thermometer must show against the other thermometers too: what the drift says for it counts up to
        `FOLLOWED` times what they say beyond `LEAST_WITNESS`; where both tell of one number, `AGREED` times what they
        say alike beyond `LEAST_AGREED`. Every thermometer is late against some other: what they say of lateness counts
        as far as the drift says it, up to `SECOND_LATE` times what they say for all of it, or as far as the thermometer
        is late with all that it reads. Of one that wanders they say how far it does, as much as the drift at most; an
        error that they could not show counts without them. What they say of a loss of contact counts as far as the
        drift may show that reading, with the law's own A; of a thermometer that was never on its part all of the drift
        counts as far as the error there has the law's own A.
        """
        trial, most = ranked.best.trial, min(ranked.value, ranked.best.trial.most)
        drift, agreed = most, self._agreed(ranked.best, ranked.levels)
        if not trial.fault:
            if trial.ratio and self.error(ranked.best, ranked.levels) <= 0.0:
                drift = min(drift, 0.0)
            late = self._late(trial, drift) if self._same_way(ranked) else 0.0
            parity, sure = late, self.whole(trial)
        elif trial.wanders:
            # heat of its own, which no other has, lets a sound thermometer wander: the drift must say as much
            said, own = max(drift, 0.0), self._own(ranked.best, ranked.levels)
            parity = sure = own * min(self._beyond(trial), said)
            by_air = own * self._by_air(trial, said)
            drift = min(drift, FOLLOWED * max(parity + by_air - LEAST_WITNESS, 0.0))
            parity += by_air
        elif np.isfinite(agreed):
            if trial.ratio:  # a reading runs towards the air, never away from it
                agreed *= self._in_drift(trial) if agreed > 0.0 else 1.0
                drift = drift if self.error(ranked.best, ranked.levels) > 0.0 else min(drift, 0.0)
            parity = sure = agreed
            drift = min(drift, max(AGREED * max(agreed - LEAST_AGREED, 0.0), self._unseen(ranked, agreed) * drift))
        else:
            parity, sure = self._parities(trial)
            if trial.partly and parity > 0.0:
                shown = self._in_drift(trial)
                parity, sure = shown * parity, shown * max(sure, 0.0)
            whole = self._own(ranked.best, ranked.levels) if trial.tight and parity > LEAST_WITNESS else 0.0
            drift = min(drift, max(FOLLOWED * max(parity - LEAST_WITNESS, 0.0), whole * drift))
        besides = trial.advantage + parity
        best = ranked.best
        if trial.fault and sure > SURE_WITNESS:
            best = replace(best, visible=max(best.visible, self.beside_the_law.visible(trial)))
        return replace(ranked, best=best, value=drift + besides, besides=besides, witness=sure, agreed=agreed,
                       both=min(drift, sure) * trial.fault, seconded=self._seconded(trial),
                       withheld=most - drift)  # fmt: skip

    def would_say(self, trial: Trial, amplitude: float) -> float:
        """Return the log evidence that the parity would have on average for a fault of an amplitude in the drift.

        ``1/2 (error / t)^2`` with t the RMS of what the parity of a sound thermometer shows of the same; 0 where an
        error in the drift and one in the parity are no one number.
        """
        shown = self.shown(trial)
        if trial.target is None or shown is None or not trial.in_parity:
            return 0.0
        error = amplitude / self.bench.slopes[trial.target] * trial.in_parity
        error = part_of(error) if trial.ratio else error
        return float(min(0.5 * error**2 / self._chance(trial, shown), MOST_PARITY))

    def parity(self, trial: Trial) -> float:
        """Return the log evidence of the parity for a trial, less what other sensors show of the same by chance."""
        return self._parities(trial)[0]

    def _parities(self, trial: Trial) -> tuple[float, float]:
        """Return the log evidence of the parity less what others usually show, and less the most that one shows."""
        if trial.parity is None or trial.target is None:
            return 0.0, 0.0
        own = self._gain(trial, trial.target)
        if own <= trial.least_parity == 0.0:  # whatever others show
            return 0.0, 0.0
        others = [self._gain(trial, sensor) for sensor in self.bench.bystanders(BYSTANDERS)]
        usual = most = 0.0
        if others:
            usual = max(float(np.quantile(others, USUAL)), float(np.mean(others) + UNUSUAL * np.std(others)))
            most = max(others)
        # of lateness no more counts than the drift says, or than `whole` does
        most_said = MOST_PARITY if trial.least_parity < 0.0 else np.inf
        least = max(trial.least_parity, -MOST_PARITY)
        beyond, sure = np.clip(own - np.maximum([usual, most], 0.0), least, most_said).tolist()
        return beyond, sure

    def _gain(self, trial: Trial, sensor: str | None) -> float:
        """Return the log evidence of one sensor's parity for a trial; less where what is a part is not 0 to 1."""
        shown = self._shown(trial, sensor)
        if shown is None:
            return 0.0
        if len(shown.amplitudes) == 1 and sensor == trial.target and self._few:
            shown = replace(shown, gain=min(shown.gain, 0.5 * shown.amplitude**2 / self._chance(trial, shown)))
        if not trial.partly:
            return shown.gain
        beyond = shown.amplitude - np.clip(shown.amplitude, 0.0, 1.0)
        return float(shown.gain - 0.5 * beyond**2 / (shown.uncertainty**2 + WHOLE**2))

    def shown(self, trial: Trial) -> Shown | None:
        """Return what the parity of a trial's own sensor shows of it; None where nobody foretells that sensor."""
        return self._shown(trial, trial.target)

    def _shown(self, trial: Trial, sensor: str | None) -> Shown | None:
        """Return what one sensor's parity shows of a trial."""
        model = self._model(trial, sensor)
        return None if model is None or trial.parity is None else model.shown_of(trial.parity)

    def _model(self, trial: Trial, sensor: str | None) -> SensorModel | None:
        """Return the model of a sensor that a trial asks; None where nobody foretells it."""
        model = None if sensor is None else self.bench.model(sensor)
        return model.tight if model is not None and trial.tight else model

    def _agreed(self, best: Scored, levels: Levels) -> float:
        """Return the log evidence of the parity for as large an error of a sensor as the drift says, against none.

        With d +- s the error by the drift, p +- r that in the parity, and t the RMS of what the parities of bystanders
        show of the same, ``log N(p; d, s^2 + r^2 + t^2) - log N(p; 0, r^2 + t^2)``. Minus infinity where an error in
        the drift and one in the parity are no one number. Of a moment that the parity led to, no more than it gains.
        """
        trial = best.trial
        shown = self.shown(trial)
        if trial.target is None or shown is None or not trial.in_parity:
            return -np.inf
        error, std = (trial.in_parity * part for part in self.told(best, levels))
        if not np.isfinite(std):
            return -np.inf
        if trial.ratio:
            error, std = part_of(error), std / (1.0 + max(error, 0.0)) ** 2
        chance = self._chance(trial, shown)
        said = _likelier(shown.amplitude, error, chance + std**2, chance)
        return min(said, max(shown.gain, 0.0)) if trial.asked else said

    def _seconded(self, trial: Trial) -> float:
        """Return what the parity of a faulty thermometer says by itself; 0 of what is no fault."""
        if not trial.fault:
            return 0.0
        if trial.wanders:
            return self._beyond(trial) + self._by_air(trial, np.inf)
        return self._gain(trial, trial.target)

    def _same_way(self, ranked: Ranked) -> bool:
        """Return whether a thermometer is late in the drift and against the others, or early in both.

        Where the parity has its first and second rate, and the drift both or one alone: the first low pass is late by
        one time constant, the second by two.
        """
        trial = ranked.best.trial
        shown = self.shown(trial)
        rates = RATES[: trial.columns.shape[1]]
        if shown is None or trial.columns.shape[1] > len(RATES) or len(shown.amplitudes) != len(RATES):
            return True
        base = self.system(ranked.best)
        _, mean = self.channel.solved(base.X, base.sd, ranked.levels)
        A = float(mean[self.bench.view.base.index(str(trial.target))])
        # what the law must add, a late thermometer lacks
        return float(np.dot(rates, mean[len(mean) - len(rates) :])) * A * float(np.dot(RATES, shown.amplitudes)) <= 0.0

    def _unseen(self, ranked: Ranked, agreed: float) -> float:
        """Return the part of the drift's evidence for an error that counts since no parity could show it, 0 to 1.

        A parity that would say more than `SEEN` of such an error leaves none, nor one that denies it by 1 or more. Nor
        does what the column has besides: a thermometer that wanders as any other does is no error of that shape.
        """
        if ranked.value <= 0.0:
            return 0.0
        base = self.system(ranked.best)
        _, mean = self.channel.solved(base.X, base.sd, ranked.levels)
        said = self.would_say(ranked.best.trial, float(mean[-1]))
        alike = ranked.best.trial.alike
        return float(alike * np.clip(2.0 * (1.0 - said / SEEN), 0.0, 1.0) * np.clip(1.0 + agreed, 0.0, 1.0))

    def _beyond(self, trial: Trial) -> float:
        """Return the log evidence of a parity for wandering as none of the others does."""
        model = None if trial.target is None else self.bench.model(trial.target)
        return max(model.beyond(self._bystanding), 0.0) if model is not None and self._told else 0.0

    def _by_air(self, trial: Trial, drift: float) -> float:
        """Return what a parity says for a share of the air that wanders, up to what the drift says for the fault."""
        return min(trial.by_air, drift) if self._told else 0.0

    @cached_property
    def _bystanding(self) -> list[Levels]:
        """Noise of the parities of bystanders with nothing hidden in them."""
        others = (self.bench.model(sensor) for sensor in self.bench.bystanders(BYSTANDERS))
        return [one.null[0] for one in others if one is not None]

    @property
    def _told(self) -> bool:
        """Whether enough bystanders tell how far a sound thermometer wanders."""
        return len(self._bystanding) >= FEWEST_BYSTANDERS

    def _own(self, best: Scored, levels: Levels) -> float:
        """Return the part that counts of a fault whose size in the drift should be the law's own A."""
        if best.trial.base is not None:  # as in `_in_drift`
            return 1.0
        return float(np.exp(-0.5 * ((self.error(best, levels) - 1.0) / PARTLY) ** 2))

    def error(self, best: Scored, levels: Levels) -> float:
        """Return the size of a thermometer's error by the drift: its amplitude there over the law's own A."""
        base = self.system(best)
        _, mean = self.channel.solved(base.X, base.sd, levels)
        A = float(mean[self.bench.view.base.index(str(best.trial.target))])
        return float(mean[-1]) / A if A else 0.0

    def told(self, best: Scored, levels: Levels) -> tuple[float, float]:
        """Return the same with its standard uncertainty, infinite where the law has no A.

        The law's A is that beside the fault: without it, the fault would have changed that as well.
        """
        base = self.system(best)
        mean, covariance = self.channel.estimated(base.X, base.sd, levels)
        own = [self.bench.view.base.index(str(best.trial.target)), len(mean) - 1]
        A, fault = mean[own].tolist()
        if not A:
            return 0.0, np.inf
        slope = np.array([-fault / A, 1.0]) / A
        return fault / A, float(np.sqrt(slope @ covariance[np.ix_(own, own)] @ slope))

    def whole(self, trial: Trial) -> float:
        """Return the log evidence of the parity for a fault that is whole, against none; 0 where it is not asked so.

        With p +- r in the parity and t as in `_agreed`, ``log N(p; 1, r^2 + WHOLE^2) - log N(p; 0, r^2 + t^2)``; of it
        a part where p is not about 1 or the drift does not show the fault, and no more than what the parity gains by
        the fault of any size. In a part of many lumps a sound thermometer may be late against all others.
        """
        shown = self.shown(trial) if trial.whole else None
        if shown is None or shown.gain <= 0.0 or len(self._others(trial)) < FEWEST_BYSTANDERS:
            return 0.0
        variance = shown.uncertainty**2 + WHOLE**2
        said = _likelier(shown.amplitude, 1.0, variance, self._chance(trial, shown))
        counts = self._partly(trial) * min(max(said, 0.0), shown.gain)
        return counts * self._in_drift(trial) if counts > 0.0 else 0.0

    def _in_drift(self, trial: Trial) -> float:
        """Return the part that counts of a whole fault for what the drift shows of it, 0 to 1.

        With c +- s the coefficient of the fault's last column in the drift beside the law alone, which would be the
        law's own A were it whole, ``(c + s) / A`` over `IN_DRIFT`; of a part p of a reading it would be p / (1 - p).
        """
        if trial.base is not None:  # no amplitude: the reading is replaced as it is
            return 1.0
        A, fault, spread = self.beside_the_law.amplitude(trial)
        shown, whole = fault * np.sign(A) + spread, abs(A)
        if trial.ratio and (own := self.shown(trial)) is not None:
            part = float(np.clip(own.amplitude, 0.0, MOST_SHARE))
            whole *= part / (1.0 - part)
        return float(np.clip(shown / max(IN_DRIFT * whole, np.finfo(float).tiny), 0.0, 1.0))

    def _others(self, trial: Trial) -> list[Shown]:
        """Return what the parities of bystanders show of a fault."""
        found = [self._shown(trial, sensor) for sensor in self.bench.bystanders(BYSTANDERS)]
        return [one for one in found if one is not None]

    def _chance(self, trial: Trial, shown: Shown) -> float:
        """Return the variance of what the parity of a sound thermometer shows of a fault.

        Where too few others tell, it is that of a parity which wanders alike in all runs, as parts do that warm alike:
        its slow noise over the RMS of the fault's column.
        """
        scatter = [one.amplitude**2 for one in self._others(trial)]
        usual = float(np.mean(scatter)) if scatter else 0.0
        if self._few:
            usual = max(usual, self._wandered(trial))
        return shown.uncertainty**2 + usual

    @cached_property
    def _few(self) -> bool:
        """Whether fewer than `FEWEST_BYSTANDERS` tell what is usual."""
        models = [self.bench.model(sensor) for sensor in self.bench.bystanders(BYSTANDERS)]
        return sum(model is not None for model in models) < FEWEST_BYSTANDERS

    def _wandered(self, trial: Trial) -> float:
        """Return the variance of a fault's amplitude where the parity's slow noise goes as the fault in all runs."""
        model = self._model(trial, trial.target)
        if model is None or trial.parity is None:
            return 0.0
        column = trial.parity(model)[0][:, -1]
        return float(model.null[0].slow ** 2 / max((column**2).mean(), np.finfo(float).tiny))


def _likelier(p: float, error: float, variance: float, chance: float) -> float:
    """Return by how much (log) p is likelier about an error, with its variance, than about 0 with that of chance."""
    said = 0.5 * (p**2 / chance - (p - error) ** 2 / variance - np.log(variance / chance))
    return float(np.clip(said, -MOST_PARITY, MOST_PARITY))
