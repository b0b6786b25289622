"""A trial is one cause with its parameters set, as columns that may explain the residual; a cause tells of itself."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from hexathermal.learn.diagnosis.channels import Levels
from hexathermal.learn.diagnosis.recorded import noisy_sensors, reading
from hexathermal.learn.diagnosis.sensor_model import Parity, SensorModel, sensor_model
from hexathermal.learn.diagnosis.steepest import believed
from hexathermal.learn.diagnosis.view import View
from hexathermal.poses import FloatArray

if TYPE_CHECKING:
    from hexathermal.machine.leg_repairs import SensorRepair


Item = TypeVar("Item")

PREFIX = "follows "
"""What a nameless trial's cause begins with."""

MOVED, STOOD, WORN = "q", "qt", "travel"
"""Targets of what follows moves, the time that the rod was at each displacement, and the way that it travelled."""

USUAL_BIAS_K = 0.05
"""Slow bias of a thermometer of which nothing is known."""

ASKED = 5
"""Thermometers outside the law that are asked for their bias."""

DRAWN_OUT = 0.5
"""Travels of the rod that are out already where it is farthest in, of a screw that is warm as far as it is out."""

QUICKLY = 0.5
"""Errors of readings, noise and steps, over what smoothing takes from windows, below which that is warming."""


@dataclass(frozen=True)
class Parameter:
    """A parameter of a cause: its name, unit, and what is known of it before."""

    name: str
    unit: str
    prior: str


@dataclass(frozen=True)
class Cause:
    """What a cause of the catalogue is.

    Attributes
    ----------
    name : str
        As in the diagnosis' JSON.
    physics : str
        What happens.
    signature : str
        How it shows.
    parameters : tuple of Parameter
    confused_with : tuple of str
        Other causes that look alike.
    experiment : str
        The measurement that decides.
    thermal : bool
        Whether errors of the thermometers can feign it.
    wanders : bool
        Whether thermometers that wander from run to run can feign it, where runs have one zero.
    words : str
        The effect in a sentence of the report, with ``{target}`` where it sits.
    readings : int
        Of the whole effect in that measurement, each with noise of its own, while what looks alike holds still; 0
        where the measurement shows the fault itself: a finger, a pulse.
    bent : float
        What flexible columns without a name may take beside it and be no more than a bend of its shape, over what it
        takes itself, both whitened.
    misfit : float
        Part of the noise by which errors of the law look like it, besides those that look like any cause.
    """

    name: str
    physics: str
    signature: str
    parameters: tuple[Parameter, ...]
    confused_with: tuple[str, ...]
    experiment: str
    words: str
    thermal: bool = False
    wanders: bool = False
    readings: int = 0
    bent: float = 0.0
    misfit: float = 0.0


@dataclass(frozen=True)
class Delay:
    """Thermometers against the part: the part follows them behind low passes, or they follow it.

    Attributes
    ----------
    sensors : tuple of str
        Of the law, those that are late or early.
    stages : tuple of float [s]
        Time constants, one behind the other.
    late : bool
        Whether the thermometers are late; else the part is.
    smooths : bool
        Whether rates are smoothed: of thermometers whose noise hides them.
    by_motion : bool
        Whether rates are those of the temperature as motion explains it, see `steadied`.
    """

    sensors: tuple[str, ...]
    stages: tuple[float, ...]
    late: bool
    smooths: bool = False
    by_motion: bool = False


@dataclass(frozen=True, eq=False)
class Trial:
    """A cause with its parameters set.

    Attributes
    ----------
    cause : str
    columns : array, shape (n, k)
        What it adds to the drift in windows, for amplitudes to be found.
    target : str or None
        Sensor, input or beam it sits on.
    shape : str
        Of the term that would join the law; empty for a repair.
    parameters : mapping
        Of the shape or the repair.
    base : array, shape (n, p), or None
        The law's columns where the trial changes them.
    repair : function or None
        Gives what it mends in the data.
    lessened : function or None
        Gives another way to mend them, from the size of the error in the drift, see `Stage.with_effect`.
    parity : function or None
        From the model of a sensor to columns in its parity, shape (m, k), and their sizes, shape (k,).
    least_parity : float
        Least log evidence of the parity: 0 where the cause need not show there.
    in_parity : float
        Amplitude in the parity's last column where that in the drift's is the law's own A; 0 where they are no one
        number.
    whole : bool
        Whether the amplitude in the parity's last column is about 1 where the fault is there at all.
    partly : bool
        Whether that amplitude is a part of something, 0 to 1, where the fault is there.
    ratio : bool
        Whether it is such a part s of which the drift's amplitude over the law's own A is the ratio s / (1 - s).
    tight : bool
        Whether the parity is asked beside a contact that lets in little of the air.
    wanders : bool
        Whether the parity is asked how far it wanders, beside that of any other thermometer, since the fault has no
        shape; the drift's last column is the fault as the others tell it, and has the law's own A where it is there.
    by_air : float
        Log evidence of the parity that a share of the air wanders, over that the reading does: it counts up to what the
        drift says.
    anew : bool
        Whether errors of the thermometers are to be made anew of the mended data: all sensors are mended alike.
    delay : Delay or None
        In place of a repair: the law reads its thermometers so.
    unlate : Trial or None
        The same without its lateness: that temperatures are steadier explains something, which is no lateness.
    term : Trial or None
        What joins the law in place of this trial, by which the cause is only compared.
    finer : function or None
        Gives the trial between this one and its neighbours, from a part of the way to the next one, -1 to 1.
    advantage : float
        Log evidence from what the drift does not show: order of positions, clocks against motion.
    most : float
        Most that the drift may say for it, where another witness is against it.
    doubt : float
        So much of its evidence does not count against nothing: errors of the thermometers may say as much.
    feigned : float [m]
        Misfit of this kind that errors of the thermometers may feign.
    unfeigned : bool
        Whether they feign none of it, although they do other trials of its cause.
    asked : bool
        Whether the parity is asked in any case: it led to this trial, or knows more of it than the drift does.
    errors : tuple of str
        Thermometers of whose slow errors such a fault consists, where all are sound.
    alike : float
        Part of the drift's last column, squared, that goes as the fault does in the parity.
    starts : int
        Of the columns so many, the last ones, are carried by no law: they belong to one run each, which had not come to
        rest before, or to what a shape may have besides, as the bow of a scale.
    started : float
        Size of these, over `START` of what the others do.
    """

    cause: str
    columns: FloatArray
    target: str | None = None
    shape: str = ""
    parameters: Mapping[str, Any] = field(default_factory=dict)
    base: FloatArray | None = None
    repair: Callable[[], SensorRepair] | None = None
    lessened: Callable[[float], SensorRepair] | None = None
    parity: Parity | None = None
    least_parity: float = -np.inf
    in_parity: float = 0.0
    whole: bool = False
    partly: bool = False
    ratio: bool = False
    tight: bool = False
    wanders: bool = False
    by_air: float = 0.0
    anew: bool = False
    delay: Delay | None = None
    unlate: Trial | None = None
    term: Trial | None = None
    finer: Callable[[float], Trial] | None = None
    advantage: float = 0.0
    most: float = np.inf
    doubt: float = 0.0
    feigned: float = 0.0
    unfeigned: bool = False
    asked: bool = False
    errors: tuple[str, ...] = ()
    alike: float = 1.0
    starts: int = 0
    started: float = 1.0

    @property
    def carried(self) -> int:
        """Columns that a law carries, the first so many."""
        return int(self.columns.shape[1]) - self.starts

    @property
    def fault(self) -> bool:
        """Whether it is a fault of a thermometer that must show in its parity."""
        return self.parity is not None and self.least_parity < 0.0

    @property
    def way(self) -> tuple[bool, bool, bool, bool]:
        """How it tells a fault: by the reading, by mended data, as a contact that comes and goes; unseen by others."""
        return self.ratio, self.anew, self.by_air > 0.0, self.parity is None

    @property
    def line(self) -> Hashable:
        """What trials that mend data share which stand in the order of their parameter, or begin with the campaign."""
        delay, begins = self.delay, {"from_run", "gains_s_per_h"} & self.parameters.keys()
        own = None if delay is None else (delay.sensors, len(delay.stages), delay.late, delay.smooths, delay.by_motion)
        return self.cause, frozenset(begins), own

    @property
    def origin(self) -> tuple[str, str | None]:
        """Its cause and where that sits: what all terms of one cause have in common."""
        return self.cause, self.target

    @property
    def named(self) -> bool:
        """Whether it is of the catalogue."""
        return not self.cause.startswith(PREFIX)


class Workbench:
    """What causes build their trials from: the view, the law found so far, models of the sensors.

    Attributes
    ----------
    view : View
    ratios : dict of str to float
        B / A of each sensor of the law (D / C [1/m]); 0 where it reads no place.
    slopes : dict of str to float
        A of each sensor [1/K] (C [m/K]).
    noise : float [m]
        RMS of the noise in windows beside the law.
    models : dict, optional
        Models of the view's sensors that were made before; those made here join them.
    slow : float, optional [m]
        What wanders of this noise, RMS; by default all of it may.
    """

    def __init__(
        self, view: View, coefficients: FloatArray, noise: float, models: dict[str, SensorModel | None] | None = None,
        slow: float | None = None,
    ) -> None:  # fmt: skip
        self.view, self.noise, self.slow = view, noise, noise if slow is None else slow
        k = len(view.base)
        A = coefficients[:k]
        B = coefficients[k : 2 * k] if view.stroked else np.zeros(k)
        self.slopes = dict(zip(view.base, A.tolist(), strict=True))
        safe = np.where(np.abs(A) > 1e-12, A, 1e-12)
        self.ratios = dict(zip(view.base, (believed(view, safe, B) / safe).tolist(), strict=True))
        self._models = {} if models is None else models

    def model(self, sensor: str) -> SensorModel | None:
        """Return the model of a sensor by the others: of one outside the law by those outside the law.

        A fault of the law's own thermometers would be seen in every sensor that they help to foretell.
        """
        if sensor not in self._models:
            base = self.view.base
            self._models[sensor] = sensor_model(self.view, sensor, () if sensor in base else base)
        return self._models[sensor]

    @cached_property
    def main(self) -> str:
        """The sensor of the law with the largest share of the drift."""
        size = [abs(self.moved_by(name)) * self.view.temperatures(name).std() for name in self.view.base]
        return self.view.base[int(np.argmax(size))]

    @cached_property
    def noisy(self) -> tuple[str, ...]:
        """Sensors too noisy to be trusted with what moves the part."""
        view = self.view
        return view.once(("noisy",), lambda: tuple(noisy_sensors(view.runs, view.sensors)))

    def bystanders(self, most: int) -> list[str]:
        """Return sensors outside the law, evenly chosen."""
        return evenly([name for name in self.view.sensors if name not in self.view.base], most)

    @cached_property
    def usual_bias(self) -> float:
        """Slow bias that the parity of other thermometers shows, the middle one [K]."""
        return self._usual(lambda levels: levels.slow)

    def _usual(self, level: Callable[[Levels], float]) -> float:
        """Return the middle one of a level of other thermometers' parities [K]."""
        models = [model for name in self.bystanders(ASKED) if (model := self.model(name)) is not None]
        return float(np.median([level(model.null[0]) for model in models])) if models else USUAL_BIAS_K

    def moving(self, sensor: str) -> FloatArray:
        """Return what a sensor of the law moves the part by in each window, shape (n,) [m/K]."""
        return np.asarray(self.slopes[sensor] * self.slopes_span(sensor))

    def moved_by(self, sensor: str) -> float:
        """Return what a sensor of the law moves the part by, RMS over its windows [m/K]."""
        return float(self.slopes[sensor] * np.sqrt((self.slopes_span(sensor) ** 2).mean()))

    def bias(self, sensor: str) -> float:
        """Return a thermometer's slow bias as its parity shows it, or as others' do, if that is less [K]."""
        model = self.model(sensor)
        return USUAL_BIAS_K if model is None else min(model.bias, self.usual_bias)

    @cached_property
    def wandered(self) -> float:
        """Misfit that the law's thermometers may feign by wandering from run to run, RMS [m]; 0 where runs have zeros.

        Each by the offsets of its parity, or by the middle ones of other thermometers.
        """
        if self.view.zeroed_by_run:
            return 0.0
        usual = self._usual(lambda levels: levels.offset)
        parts = []
        for sensor in self.view.base:
            model = self.model(sensor)
            offset = usual if model is None else min(model.null[0].offset, usual)
            parts.append(self.moved_by(sensor) * offset)
        return float(np.linalg.norm(parts))

    def warms_quickly(self, sensor: str) -> bool:
        """Return whether smoothing takes more warming than noise from a sensor's readings."""
        step, noise = self.reading(sensor)
        return float(np.hypot(noise, step / np.sqrt(12.0))) < QUICKLY * float(self.view.quick(sensor)[:, 0].std())

    def reading(self, sensor: str) -> tuple[float, float]:
        """Return a thermometer's resolution, as far as noise does not make up for it, and its noise [K]."""
        return self.view.once(("reading", sensor), partial(reading, self.view.runs, sensor), [sensor])

    @cached_property
    def along_screw(self) -> float:
        """The ratio of a length ``q0 + ratio q`` that is `DRAWN_OUT` travels of the rod where it is farthest in.

        What warms the screw alone acts on what is out of the nut.
        """
        q = self.view.q
        return self.view.length / (DRAWN_OUT * float(np.ptp(q)) - float(q.min()))

    def slopes_span(self, sensor: str) -> FloatArray:
        """Return ``q0 + ratio q`` of a sensor of the law in windows [m]."""
        return self.view.span(self.ratios[sensor])

    def term(self, cause: str, shape: str, target: str | None = None, quick: bool = False, **parameters: Any) -> Trial:
        """Return the trial of a term; `quick` for shapes without a memory, which windows alone give."""
        view = self.view
        columns = view.quick_columns(shape, parameters) if quick else view.columns(shape, parameters)
        return Trial(cause, columns, target, shape, parameters)

    def not_at_rest(self, trial: Trial, time_constant: float) -> Trial:
        """Return a trial whose state had not come to rest before the runs: with a decay of each beside it."""
        view = self.view
        starts = view.once(("starts", time_constant), partial(view.starts, time_constant), ())
        return replace(trial, columns=np.column_stack([trial.columns, starts]), starts=starts.shape[1])


def evenly(items: Sequence[Item], most: int) -> list[Item]:
    """Return at most so many items, evenly chosen, first and last among them."""
    return [items[k] for k in np.unique(np.linspace(0, len(items) - 1, min(most, len(items))).astype(int))]
