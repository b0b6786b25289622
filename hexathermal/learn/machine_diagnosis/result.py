"""What the diagnosis of a machine says: verdict, causes, extended machine, gain, and its JSON."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from hexathermal.learn.diagnosis.result import FORMAT, Quantity
from hexathermal.learn.hexapod_data import AXES
from hexathermal.learn.hexapod_scores import PoseScore
from hexathermal.learn.machine_diagnosis.candidate import legs_of
from hexathermal.learn.machine_diagnosis.gain import MachineGain, MachineResidual
from hexathermal.learn.machine_diagnosis.moving import Moved
from hexathermal.learn.machine_diagnosis.plan_files import planned_facts
from hexathermal.learn.machine_diagnosis.planning import MachineExperiment
from hexathermal.machine.hexapod import Hexapod
from hexathermal.machine.shown import Shown
from hexathermal.poses import FloatArray

UM = 1e6
"""From metres to micrometres, and from radians to microradians."""


@dataclass(frozen=True, eq=False)
class MachineEffect:
    """A cause that was named.

    Attributes
    ----------
    cause : str
    target : str or None
        The leg, legs, plate, joint or thermometer.
    parameters : mapping of str to Quantity
    settings : mapping
        What is no number that was fitted: names of thermometers.
    probability : float
        Of the cause, among all and none.
    equivalent : tuple of str
        Names of causes that these data cannot tell from it.
    equivalent_places : tuple of str
        The same with their places, as ``"joint-offset of platform joint 4"``.
    translation, rotation : float [m, rad]
        RMS distance and RMS angle by which it moves the platform in these rows.
    strength : float
        RMS of what of it stays visible, law and disturbances fitted anew, over the noise.
    pays : tuple of float
        Log likelihood that it gains on each run left out of the fit.
    sentence : str
    """

    cause: str
    target: str | None
    parameters: Mapping[str, Quantity]
    settings: Mapping[str, Any]
    probability: float
    equivalent: tuple[str, ...]
    equivalent_places: tuple[str, ...]
    translation: float
    rotation: float
    strength: float
    pays: tuple[float, ...]
    sentence: str


@dataclass(frozen=True)
class MachineCandidate:
    """A line of the ranking: a cause at one place, its log posterior odds against none, and its visible strength.

    `moved` is how far it moves the platform in the rows searched, alone beside the law.
    """

    cause: str
    target: str | None
    evidence: float
    probability: float
    strength: float
    settings: Mapping[str, Any]
    moved: Moved


@dataclass(frozen=True)
class MachineLimit:
    """How large a cause must be at one place to be named: strength over the noise, RMS on the platform [m, rad]."""

    cause: str
    target: str | None
    strength: float
    translation: float
    rotation: float


@dataclass(frozen=True)
class MachineAdvice:
    """What the catalogue advises to measure, in words: for causes, and for these with their places."""

    words: str
    causes: tuple[str, ...]
    places: tuple[str, ...] = ()

    @property
    def purpose(self) -> str:
        """What it is for: causes, and of each the places that are on legs."""
        told = list[str]()
        for cause in self.causes:
            on = [place.partition(" of ")[2] for place in self.places if place.partition(" of ")[0] == cause]
            told.append(f"{cause} of {', '.join(on)}" if on else cause)
        return "; ".join(told)


@dataclass(frozen=True, eq=False)
class Disturbances:
    """What is in the measured poses besides law and causes: noise, and sizes of frames and slow errors.

    Attributes
    ----------
    noise : array, shape (6,) [m, m, m, rad, rad, rad]
        Standard deviations of the measured coordinates.
    freedom : float
        Degrees of freedom of the tails; infinite: normal.
    campaign, frame, slow : array, shape (6,) [m, rad]
        Of the measuring frame: one offset for all runs, one for each run, slow drift within a run.
    leg : float [m]
        Of slow errors of the legs, as those that thermometers misread.
    """

    noise: FloatArray
    freedom: float
    campaign: FloatArray
    frame: FloatArray
    slow: FloatArray
    leg: float


@dataclass(frozen=True, eq=False, repr=False)
class MachineDiagnosis(Shown):
    """What a machine's model gets wrong, and why.

    Attributes
    ----------
    verdict : str
        ``"effect"``, ``"none"`` or ``"unexplained"``.
    probability : float
        Of the verdict; of the first name where there is one.
    effects : tuple of MachineEffect
        The strongest first.
    follows : str or None
        What something unexplained follows.
    candidates : tuple of MachineCandidate
        Best first; effects that were named come first.
    hexapod, extended : Hexapod
        Before, and with the causes in it; the same where none was named.
    gain : MachineGain or None
        On validation runs; None where there are none.
    disturbances : Disturbances
    threshold : float
        Log odds that a name needed in this campaign.
    limits : tuple of MachineLimit
    alike : tuple of str
        What these poses and temperatures cannot tell apart, whatever is in them.
    experiments : tuple of MachineExperiment
        Poses and temperatures that tell the leader from the rival that is open; empty where nothing competes.
    residuals : tuple of MachineResidual
        Run by run, for pictures.
    title : str
    notes : tuple of str
    advice : tuple of MachineAdvice
        What the catalogue advises for what was named and its rivals.
    """

    verdict: str
    probability: float
    effects: tuple[MachineEffect, ...]
    follows: str | None
    candidates: tuple[MachineCandidate, ...]
    hexapod: Hexapod
    extended: Hexapod
    gain: MachineGain | None
    disturbances: Disturbances
    threshold: float
    limits: tuple[MachineLimit, ...]
    alike: tuple[str, ...]
    experiments: tuple[MachineExperiment, ...]
    residuals: tuple[MachineResidual, ...]
    title: str = ""
    notes: tuple[str, ...] = field(default=())
    advice: tuple[MachineAdvice, ...] = field(default=())

    def __repr__(self) -> str:
        return f"{type(self).__name__}: {self.sentence}"

    @property
    def cause(self) -> str | None:
        """The first name, None where there is none."""
        return self.effects[0].cause if self.effects else None

    @property
    def sentence(self) -> str:
        """The diagnosis in words."""
        if self.verdict == "effect":
            return " ".join(effect.sentence for effect in self.effects)
        seen = [one for one in self.limits if np.isfinite(one.strength)]
        if self.verdict == "none" and seen:
            far, turned = max(one.translation for one in seen) * UM, max(one.rotation for one in seen) * UM
            return f"None above {far:.2g} um / {turned:.2g} urad (RMS): the model explains these poses to their noise."
        if self.verdict == "none":
            return "No cause of the catalogue is seen: the model explains these poses to their noise."
        left = next((one.moved for one in self.candidates if one.cause == self.follows), None)
        size = "" if left is None else f" ({left.translation * UM:.2g} um and {left.rotation * UM:.2g} urad RMS)"
        return f"Something real{size} is left that {self.follows}, but no cause of the catalogue explains it."

    def to_json(self) -> dict[str, Any]:
        """Return the diagnosis as its JSON document."""
        first = self.effects[0] if self.effects else None
        return {
            "format": FORMAT,
            "kind": "hexapod",
            "title": self.title,
            "verdict": self.verdict,
            "cause": self.cause,
            "target": None if first is None else first.target,
            "legs": [] if first is None else _legs(first),
            "equivalent": [] if first is None else list(first.equivalent),
            "probability": self.probability,
            "parameters": {} if first is None else _parameters(first),
            "settings": {} if first is None else _plain(first.settings),
            "sentence": self.sentence,
            "effects": [_effect(one) for one in self.effects],
            "follows": self.follows,
            "gain": None if self.gain is None else _gain(self.gain),
            "candidates": [_candidate(one) for one in self.candidates],
            "next_experiment": planned_facts(self.experiments[0]) if self.experiments else None,
            "advice": [_advice(one) for one in self.advice],
            "detection_limits": [_limit(one) for one in self.limits],
            "alike": list(self.alike),
            "disturbances": _disturbances(self.disturbances),
            "threshold": self.threshold,
            "notes": list(self.notes),
        }  # fmt: skip


def _plain(settings: Mapping[str, Any]) -> dict[str, Any]:
    """Return settings with lists for tuples, as JSON has them."""
    return {name: list(value) if isinstance(value, tuple) else value for name, value in settings.items()}


def _legs(effect: MachineEffect) -> list[str]:
    """Return the legs that a cause sits on: of a joint, its leg, whichever end of it these data leave open."""
    return [f"leg{leg + 1}" for leg in legs_of(effect.target)]


def _parameters(effect: MachineEffect) -> dict[str, Any]:
    """Return parameters as the format has them."""
    return {
        name: {"value": one.value, "std": one.std if np.isfinite(one.std) else None, "unit": one.unit}
        for name, one in effect.parameters.items()
    }


def _effect(one: MachineEffect) -> dict[str, Any]:
    """Return a named cause."""
    return {
        "cause": one.cause, "target": one.target, "legs": _legs(one), "probability": one.probability,
        "equivalent": list(one.equivalent),
        "equivalent_places": list(one.equivalent_places), "parameters": _parameters(one),
        "settings": _plain(one.settings), "translation_rms_um": one.translation * UM,
        "rotation_rms_urad": one.rotation * UM, "strength": one.strength, "pays_on_runs_left_out": list(one.pays),
        "sentence": one.sentence,
    }  # fmt: skip


def _candidate(one: MachineCandidate) -> dict[str, Any]:
    """Return a line of the ranking."""
    return {
        "cause": one.cause, "target": one.target, "evidence": one.evidence, "probability": one.probability,
        "strength": one.strength, "settings": _plain(one.settings),
        "translation_rms_um": one.moved.translation * UM, "translation_std_um": one.moved.translation_std * UM,
        "rotation_rms_urad": one.moved.rotation * UM, "rotation_std_urad": one.moved.rotation_std * UM,
    }  # fmt: skip


def _advice(one: MachineAdvice) -> dict[str, Any]:
    """Return what the catalogue advises to measure."""
    return {"words": one.words, "causes": list(one.causes), "places": list(one.places)}


def _limit(one: MachineLimit) -> dict[str, Any]:
    """Return a limit; null where these rows see nothing of a cause."""
    values = {"strength": one.strength, "translation_um": one.translation * UM, "rotation_urad": one.rotation * UM}
    known = {name: value if np.isfinite(value) else None for name, value in values.items()}
    return {"cause": one.cause, "target": one.target} | known


def _disturbances(one: Disturbances) -> dict[str, Any]:
    """Return noise and disturbances, axis by axis."""

    def axes(values: FloatArray) -> dict[str, float]:
        units = ("um", "um", "um", "urad", "urad", "urad")
        return {f"{axis}_{unit}": float(v) * UM for axis, unit, v in zip(AXES, units, values, strict=True)}

    return {
        "noise": axes(one.noise), "tails_freedom": one.freedom if np.isfinite(one.freedom) else None,
        "campaign_frame": axes(one.campaign), "frame_of_each_run": axes(one.frame),
        "slow_frame": axes(one.slow), "slow_leg_um": one.leg * UM,
    }  # fmt: skip


def _gain(gain: MachineGain) -> dict[str, Any]:
    """Return the gain: of all runs, of each, of each axis, and without each run's mean motion."""
    far = _score(gain.total["translation"], "um")
    return (
        {name: far[name] for name in ("rmse_before_um", "rmse_after_um", "linf_before_um", "linf_after_um")}
        | _both(gain.total)
        | {
            "axes": {axis: _score(gain.total[axis], "urad" if axis.startswith("r") else "um") for axis in AXES},
            "runs": {name: _both(run) for name, run in gain.runs.items()},
            "without_frame_of_each_run": _both(gain.unframed),
        }
    )


def _both(scores: Mapping[str, PoseScore]) -> dict[str, Any]:
    """Return the scores of translation and rotation."""
    pairs = (("translation", "um"), ("rotation", "urad"))
    return {f"{key}_{name}": value for key, unit in pairs for name, value in _score(scores[key], unit).items()}


def _score(one: PoseScore, unit: str) -> dict[str, Any]:
    """Return a score with 95 % intervals."""

    def interval(low: float, high: float, factor: float) -> list[float | None]:
        return [value * factor if np.isfinite(value) else None for value in (low, high)]

    return {
        f"rmse_before_{unit}": one.before.value * UM, f"rmse_after_{unit}": one.after.value * UM,
        f"linf_before_{unit}": one.largest_before * UM, f"linf_after_{unit}": one.largest_after * UM,
        f"rmse_before_95_{unit}": interval(one.before.low, one.before.high, UM),
        f"rmse_after_95_{unit}": interval(one.after.low, one.after.high, UM),
        "reduction": one.reduction.value, "reduction_95": interval(one.reduction.low, one.reduction.high, 1.0),
    }  # fmt: skip
