"""The residual folded on what repeats: an error of the screw on its pitch, a rhythm on its period."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from hexathermal.learn.diagnosis.result import Diagnosis
from hexathermal.poses import FloatArray
from hexathermal.show.diagnosis_run_figures import clouds_figure, known_windows

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True)
class Fold:
    """What a residual is folded on: `signal`, ``"q"`` or ``"time"``, and its `period` [m] or [s]."""

    signal: str
    period: float

    @property
    def words(self) -> str:
        """What stands at the axis."""
        if self.signal == "q":
            return f"displacement within the pitch of {self.period * 1e3:.4g} mm"
        return f"time within the period of {self.period / 60.0:.3g} min"

    @property
    def unit(self) -> tuple[str, float]:
        """The unit that is shown, and its factor."""
        return ("mm", 1e3) if self.signal == "q" else ("min", 1.0 / 60.0)


def folds_of(found: Diagnosis) -> list[Fold]:
    """Return what the residual is folded on: pitches that were named, and the period of a rhythm without a name.

    Only what at least one run knows the signal of.
    """
    pitches = [one.parameters["pitch_m"].value for one in found.effects if "pitch_m" in one.parameters]
    nameless = [one.settings for one in found.candidates if one.cause == found.follows]
    periods = [float(settings["period_s"]) for settings in nameless if "period_s" in settings]
    folds = [*(Fold("q", pitch) for pitch in pitches), *(Fold("time", period) for period in periods)]
    return [fold for fold in folds if any(len(signal) for signal, *_left in known_windows(found, fold.signal))]


def folded(found: Diagnosis, fold: Fold) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return places within a period, and the residual before and after [m], each run less its mean.

    The phase of a rhythm is another one in each run: each is turned by that of the sine that fits it best.
    """
    parts = []
    for at, before, after in known_windows(found, fold.signal):
        if len(at):
            turn = _phase(at, before, fold.period) if fold.signal == "time" else 0.0
            parts.append(((at + turn) % fold.period, before - before.mean(), after - after.mean()))
    place, before, after = (np.concatenate(columns) for columns in zip(*parts, strict=True))
    return place, before, after


def _phase(time: FloatArray, left: FloatArray, period: float) -> float:
    """Return by how much a run is turned [s], so that its wave is a sine from the beginning of a period on."""
    angle = 2.0 * np.pi * time / period
    X = np.column_stack([np.sin(angle), np.cos(angle), np.ones(len(angle))])
    sine, cosine, _mean = np.linalg.lstsq(X, left)[0]
    return float(np.arctan2(cosine, sine) / (2.0 * np.pi) * period)


def fold_figure(found: Diagnosis, fold: Fold, width: float) -> Figure:
    """Return the residual within a period, before and, where something joined the law, after."""
    unit, factor = fold.unit
    return clouds_figure(found, folded(found, fold), (fold.words, unit, factor), fold.signal, width)
