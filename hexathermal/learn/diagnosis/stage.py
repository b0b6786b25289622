"""One stage of a diagnosis: a view, the law's columns and what joined them, ready to be searched."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np

from hexathermal.learn.campaign import Campaign
from hexathermal.learn.diagnosis.all_trials import all_trials
from hexathermal.learn.diagnosis.channels import Channel, Levels
from hexathermal.learn.diagnosis.evidence import Base, Scored
from hexathermal.learn.diagnosis.foresight import FAINT, repeated
from hexathermal.learn.diagnosis.little_errors import little_errors
from hexathermal.learn.diagnosis.mending import Told, mended_view, remade, told_after, told_by, told_late
from hexathermal.learn.diagnosis.ranking import Ranked, Step
from hexathermal.learn.diagnosis.recorded import silent_inputs, silent_sensors, without_inputs
from hexathermal.learn.diagnosis.rivals import FORETOLD, STEP, TILT, steps_with
from hexathermal.learn.diagnosis.search import REPEATED, TWINS, Search
from hexathermal.learn.diagnosis.sensor_model import SensorModel
from hexathermal.learn.diagnosis.trials import Trial, Workbench
from hexathermal.learn.diagnosis.view import View
from hexathermal.learn.signals import RunRows
from hexathermal.machine.leg_repairs import SensorRepair
from hexathermal.poses import FloatArray

TAKEN_BACK = 0.5e-6
"""What a step of a beam that cleaning took back may be wrong by in the mean of the beams [m]."""

DISBELIEVED = float(1.0 / np.sqrt(3.0))
"""Part of what a thermometer of the law tells beside the others, or quickly, that is not believed: none to all of it,
RMS."""

FIRST_ROW = 2.0
"""Size of the error of the row from which all runs of a campaign count, over the noise: one row's, and readings'."""

LARGEST = 3.0
"""RMS of the largest effect thought possible, over that of the drift."""

OWN_READING = 1.05
"""What a thermometer's own reading, put right, may leave of runs left out (squared) over what is left where others
speak for it: they have errors of their own, which look like causes."""

MOST_OWN, LARGE_SHARE = 0.5, 0.9
"""Share of the air, by either estimate, beyond which its own reading must leave so much less, since what is left of it
is divided by what it has of its part."""


def view_of(campaign: Campaign, runs: Sequence[RunRows], base: tuple[str, ...], *, placed: bool = False) -> View:
    """Return runs as the diagnosis sees them, without what has no values in one of them; see `View.placed`."""
    order = [run.name for run in campaign.runs]
    runs = sorted(runs, key=lambda rows: order.index(rows.run.name))
    silent, inputs = silent_sensors(runs), silent_inputs(runs)
    sensors = tuple(name for name in campaign.sensors if name not in silent)
    places = [item for item in campaign.thermocouples if item.position is not None]
    return View(
        tuple(without_inputs(rows, inputs) for rows in runs), sensors, base, campaign.kind, campaign.zero == "run",
        campaign.beams.dead_path if campaign.beams is not None else 0.0,
        {item.name: float(item.position or 0.0) for item in places},
        tuple(order), placed=placed,
    )  # fmt: skip


@dataclass(frozen=True, eq=False)
class Stage:
    """A view with what joined the law so far.

    Attributes
    ----------
    view : View
    joined : tuple of Scored
        Terms, and steps of the zero, whose columns stand beside the law's.
    repairs : tuple of SensorRepair
        Mended in the view's data.
    tolerated : tuple of Scored
        Misfit that errors of the thermometers feign: its columns stand beside the law's, and say nothing.
    refused : tuple of str
        Causes that are not asked any more: they predict runs left out no better.
    models : dict of str to SensorModel or None
        Of the view's sensors, as far as they were made: stages with the same view share them.
    most : mapping of str to float, optional
        Most that causes may say beside what the null tolerates.
    late : float, optional [s]
        By how much the law's thermometers are late, as such are, where the null has that.
    """

    view: View
    joined: tuple[Scored, ...] = ()
    repairs: tuple[SensorRepair, ...] = ()
    tolerated: tuple[Scored, ...] = ()
    refused: tuple[str, ...] = ()
    models: dict[str, SensorModel | None] = field(default_factory=dict)
    most: Mapping[str, float] | None = None
    late: float | None = None

    @cached_property
    def channel(self) -> Channel:
        """The drift in windows."""
        return self.view.channel

    @cached_property
    def bench(self) -> Workbench:
        """What trials are built from, with the law as it fits at first.

        Weights by the noise look at what is quick, where readings of a part, of ten times a leg's micrometres for a
        kelvin, are mostly noise and make a law too small: of a part it is the law that runs left out speak for.
        """
        p, noise = self.view.base_columns.shape[1], self.levels.rms
        if self.view.kind == "leg":
            coefficients, _ = self.fit(self.levels)
        else:
            coefficients, _ = self.law
            left = self.channel.y - self.predicted(coefficients)
            noise = min(noise, float(np.sqrt(np.average(left**2, weights=self.channel.rows))))
        return Workbench(self.view, coefficients[:p], noise, self.models, self.levels.slow)

    @cached_property
    def _plain(self) -> tuple[FloatArray, FloatArray]:
        """The law's columns with those that joined, and the sizes of their priors: what a law can carry."""
        return self._with_joined(self.view.base_columns)

    def _with_joined(self, law: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return columns of the law with those that joined, and the sizes of their priors."""
        terms = [(item.trial.columns, 4.0 * item.size, item.trial.carried) for item in self.joined]
        X = np.column_stack([law, *(columns[:, :carried] for columns, _sizes, carried in terms)])
        return X, np.concatenate([self.channel.loose(law), *(sizes[:carried] for _, sizes, carried in terms)])

    @cached_property
    def base(self) -> Base:
        """What trials must beat: the law, what joined it, and errors of its thermometers."""
        X, sd = self._plain
        base = self._doubting(Base(X, sd, X.shape[1]), self.bench, told_by(self.view, self.bench.model))
        for item in self.tolerated:
            base = base.extended(item.trial.columns, item.size)
        return self._with_starts(base)

    def _with_starts(self, base: Base) -> Base:
        """Return a base with what had not come to rest before each run, of causes that joined."""
        for item in self.joined:
            first = item.trial.carried
            base = base.extended(item.trial.columns[:, first:], item.size[first:])
        return base

    def _doubting(self, base: Base, bench: Workbench, told: Told) -> Base:
        """Return a base with errors of the law's thermometers, of the beams' repairs, and of the campaign's first row.

        Each thermometer may err by itself, or as all of them do.

        Where all runs count from that row, its noise stands in all of them.
        """
        if not self.view.zeroed_by_run:
            base = base.extended(np.ones((len(self.channel), 1)), np.array([FIRST_ROW * self.levels.rms]))
        for sensor, doubts in zip(self.view.base, told.doubts, strict=True):
            sizes = np.full(doubts.shape[1], DISBELIEVED * abs(bench.slopes[sensor]))
            base = base.extended(bench.slopes_span(sensor)[:, None] * doubts, sizes)
        moved = [bench.moving(sensor) for sensor in self.view.base]
        alike = np.sum([one[:, None] * table for one, table in zip(moved, told.alike, strict=True)], axis=0)
        base = base.extended(alike, np.full(alike.shape[1], DISBELIEVED), little=True)
        base = base.extended(*little_errors(bench, late=self.late is not None), little=True)
        steps = self.view.taken_back
        return base.extended(steps, np.full(steps.shape[1], TAKEN_BACK))

    @cached_property
    def search(self) -> Search:
        """The search over all causes."""
        repaired, trials = self._repaired_base, self._trials
        return Search(self.bench, self.channel, self.base, self.largest, repaired, trials, self._null)

    @property
    def largest(self) -> float:
        """RMS of the largest effect thought possible [m]."""
        return LARGEST * float(np.sqrt((self.channel.y**2).mean()))

    @cached_property
    def _null(self) -> tuple[Levels, float]:
        """Noise of the drift beside all that the null doubts, and the evidence of that."""
        return self.channel.fitted(self.base.X, self.base.sd, near=self.levels)

    @cached_property
    def _trials(self) -> list[Trial]:
        """All trials."""
        return all_trials(self.bench, self._null[0].slow)

    def against(self, **changes: Any) -> Stage:
        """Return the stage with another null, or other causes out of the race: what joined is as it was."""
        other = replace(self, **changes)
        known = ("_plain", "levels", "plain", "bench", "_trials", "_left")
        other.__dict__.update({name: self.__dict__[name] for name in known if name in self.__dict__})
        return other

    def tolerating(self, scored: Scored, *, feigned: bool = False) -> Stage:
        """Return the stage whose null has a trial's columns.

        Beside what thermometers may feign nothing says more than it did before: both together may be what a better
        thermometer of the law would have read.
        """
        most = {item.cause: item.value for item in self.step.ranking} if feigned else self.most
        return self.against(tolerated=(*self.tolerated, scored), most=most)

    def _repaired_base(self, trial: Trial) -> Base:
        """Return the base of the data that a trial mends, errors of the thermometers as they are then."""
        told = self._told_anew(trial)
        X, sizes = self._with_joined(told.law)
        _, mean = self.channel.solved(X, sizes, self.levels)
        bench = Workbench(self.view, mean[: told.law.shape[1]], self.levels.rms, self.models, self.levels.slow)
        # the same priors as without the repair: evidence is compared
        return self._with_starts(self._doubting(Base(X, self._plain[1], X.shape[1]), bench, told))

    def _told_anew(self, trial: Trial) -> Told:
        """Return what the thermometers tell of the data that a trial mends, or of those that it reads late."""
        view, model = self.view, self.bench.model
        if trial.delay is not None:
            delay = trial.delay
            return view.once(("told", delay), lambda: told_late(view, delay, model))
        assert trial.repair is not None  # of trials that mend data alone
        repair = trial.repair()
        same = ("told", repair.kind, repr(sorted(repair.parameters.items())))
        return view.once(same, lambda: told_after(view, repair, model))

    @cached_property
    def trials_left(self) -> list[Trial]:
        """Trials of causes that have not joined, nor their twins; another thermometer may join a second time.

        What is left of a thermometer that came off looks like a step of the zero in that run, not in another one.
        """
        taken = {item.trial.cause for item in self.joined} | {repair.cause for repair in self.repairs}
        gone = (taken - {REPEATED}) | set(self.refused)
        twins = {twin for name in taken for twin in TWINS.get(name, ())}
        spoken = any(repair.kind == "detached" and "from_s" not in repair.parameters for repair in self.repairs)
        if spoken or any(item.trial.shape == FORETOLD for item in self.joined):
            gone.add(REPEATED)
        sensors = {item.trial.target for item in self.joined}
        if any(item.trial.cause == STEP and self._tilts_with(item.trial) for item in self.joined):
            gone.add(TILT)
        late = {item.trial.target for item in self.joined if item.trial.shape == FORETOLD}
        off = {next(iter(repair.parameters["from_s"])) for repair in self.repairs
               if "from_s" in repair.parameters}  # fmt: skip
        return [trial for trial in self.search.trials
                if trial.cause not in gone and not (trial.cause == REPEATED and trial.target in sensors)
                and (trial.cause not in twins or (trial.cause == STEP and trial.target not in off))
                and not (trial.fault and trial.target in late)]  # fmt: skip

    def _tilts_with(self, step: Trial) -> bool:
        """Return whether the target tilts at a step of the zero: then other steps of that beam look like tilt."""
        tilts = (tilt for trial in self.search.trials if trial.cause == TILT for tilt in trial.columns.T)
        return any(steps_with(self.channel, step.columns[:, 0], tilt) for tilt in tilts)

    def beside(self, scored: Scored) -> Stage:
        """Return the stage in which a trial was named, but joins no law: its columns stand in the null.

        What explains the same is not asked either.
        """
        without = self.without(scored)
        return replace(without, refused=(*without.refused, *TWINS.get(scored.trial.cause, ())), most=None)

    def without(self, scored: Scored) -> Stage:
        """Return the stage with a trial's cause out of the race, and its columns among what the null tolerates."""
        tolerated = (*self.tolerated, scored) if scored.trial.columns.shape[1] else self.tolerated
        return self.against(tolerated=tolerated, refused=(*self.refused, scored.trial.cause))

    @cached_property
    def step(self) -> Step:
        """The ranking of all causes that have not joined, with what runs left out say for those that may be feigned."""
        step = self.search.step(self.trials_left)
        ranking = [self.asked_of_runs(item) for item in step.ranking]
        if self.most is not None:
            capped = [replace(item, value=min(item.value, self.most.get(item.cause, 0.0))) for item in ranking]
            ranking = sorted(capped, key=lambda item: -item.value)
        return replace(step, ranking=tuple(ranking))

    def asked_of_runs(self, item: Ranked) -> Ranked:
        """Return a cause that thermometers may feign with what runs left out say for it, where it is faint without."""
        if not item.best.trial.feigned or not item.gated < FAINT <= item.value:
            return item
        return replace(item, repeated=repeated(self, self.with_effect(item.best), item))

    def with_effect(self, scored: Scored) -> Stage:
        """Return the stage with a trial joined, or with its repair made.

        Where a thermometer's own reading can be put right, that is done by the error that the drift tells beside all
        that the null doubts or beside the law alone, whichever leaves less of runs left out; unless the others, who
        speak for it where its parity does, leave less by `OWN_READING`, or of a large share not more by `LARGE_SHARE`.
        """
        trial = scored.trial
        if trial.repair is None:
            return replace(self, joined=(*self.joined, scored), most=None)
        if trial.lessened is None:
            return self._repaired(trial.repair())
        ask = self.search.witnesses
        repairs = [trial.lessened(size) for size in (ask.error(scored, self.levels), ask.beside_the_law.error(trial))]
        stages = [self._repaired(repair) for k, repair in enumerate(repairs) if repair not in repairs[:k]]
        lessened = min(stages, key=lambda stage: stage.kinder_left)
        told = lessened if trial.parity is None else self._repaired(trial.repair())
        large = any(repair.parameters.get("share", 0.0) > MOST_OWN for repair in repairs)
        return lessened if lessened.kinder_left < (LARGE_SHARE if large else OWN_READING) * told.kinder_left else told

    def _repaired(self, repair: SensorRepair) -> Stage:
        """Return the stage with a repair made."""
        view = mended_view(self.view, repair)
        joined = tuple(remade(item, repair, self.view, view) for item in self.joined)
        repairs = (*self.repairs, repair)
        return replace(self, view=view, joined=joined, repairs=repairs, tolerated=(), models={}, most=None)

    def amplitudes(self, leader: Ranked) -> tuple[FloatArray, FloatArray]:
        """Return the amplitudes of a leader's columns beside the base, and their standard uncertainties.

        Those that a law carries alone.
        """
        base = self.search.system(leader.best)
        mean, covariance = self.channel.estimated(base.X, base.sd, leader.levels)
        first = len(mean) - leader.best.trial.columns.shape[1]
        own = slice(first, first + leader.best.trial.carried)
        return mean[own], np.sqrt(np.diagonal(covariance)[own])

    def fit(self, levels: Levels) -> tuple[FloatArray, FloatArray]:
        """Return the coefficients of the law and of what joined it, and their covariance, at one noise."""
        mean, covariance = self.channel.estimated(*self._plain, levels)
        return mean, covariance

    @cached_property
    def plain(self) -> Levels:
        """A noise of least squares."""
        return self.channel.plain(self.levels)

    def left_squares(self, levels: Levels) -> float:
        """Return the mean square of what runs left out of a fit leave in a row [m^2]."""
        return float(np.average(self.left_out(levels)[0] ** 2, weights=self.channel.rows))

    @cached_property
    def kinder_left(self) -> float:
        """The mean square of what runs left out leave, at the kinder of two noises [m^2]."""
        return min(self.left_squares(self.levels), self.left_squares(self.plain))

    @cached_property
    def law(self) -> tuple[FloatArray, FloatArray]:
        """The coefficients between those of `fit` and of plain least squares that leave least of runs left out.

        Returns them and their covariance. Weights by the noise are best where the law is right; where it is not, they
        may trust its small steps too much. The two are stacked (Breiman, Machine Learning 24 (1996) 49):
        ``b = w b_noise + (1 - w) b_plain``, ``0 <= w <= 1``. The better estimate's covariance with the other is its own
        (Hausman, Econometrica 46 (1978) 1251), so that that of b is ``(1 - (1 - w)^2) C_noise + (1 - w)^2 C_plain``.
        """
        best, covariance = self.fit(self.levels)
        w = self._trust
        if w == 1.0:
            return best, covariance
        X, _sd = self._plain
        mean, inverse = self.fit(self.plain)
        G = (X / self.channel.alone(self.plain)[:, None]) @ inverse
        # sandwich: estimated by least squares under the noise as it is
        other = self.channel.spread(G, self.levels)
        return w * best + (1.0 - w) * mean, (1.0 - (1.0 - w) ** 2) * covariance + (1.0 - w) ** 2 * other

    @property
    def left(self) -> FloatArray:
        """What runs left out of the fit of `law` leave in windows, shape (n,) [m]."""
        w = self._trust
        return np.asarray(w * self.left_out(self.levels)[0] + (1.0 - w) * self.left_out(self.plain)[0])

    @property
    def without_each(self) -> FloatArray:
        """The coefficients of `fit` by all runs but one, shape (r, m)."""
        return self.channel.without_each(*self._plain, self.levels)

    @property
    def _trust(self) -> float:
        """The part of weights by the noise that leaves least of runs left out."""
        weighted, plain = (self.left_out(levels)[0] for levels in (self.levels, self.plain))
        apart, rows = plain - weighted, self.channel.rows
        size = float(rows @ apart**2)
        return float(np.clip((rows * plain) @ apart / size, 0.0, 1.0)) if size > 0.0 else 1.0

    def predicted(self, coefficients: FloatArray) -> FloatArray:
        """Return the drift in windows that coefficients give."""
        return np.asarray(self._plain[0] @ coefficients)

    @cached_property
    def levels(self) -> Levels:
        """Noise of the drift beside the law and what joined it."""
        return self.channel.fitted(*self._plain)[0]

    def left_out(self, levels: Levels) -> tuple[FloatArray, FloatArray]:
        """Return residuals in windows of each run by a fit of all others, as they are [m] and whitened, shape (n,)."""
        if levels not in self._left:
            self._left[levels] = self.channel.left_out(*self._plain, levels)
        return self._left[levels]

    def left_likelihood(self, levels: Levels) -> float:
        """Return the log likelihood of runs left out, each by a fit of all others, at one noise."""
        _, logdet = self.channel.whitened(np.empty((len(self.channel), 0)), levels)
        return -0.5 * (float((self.left_out(levels)[1] ** 2).sum()) + logdet)

    @cached_property
    def _left(self) -> dict[Levels, tuple[FloatArray, FloatArray]]:
        """What `left_out` found at each noise: a stage is compared with many that follow it."""
        return {}
