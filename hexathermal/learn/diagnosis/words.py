"""The diagnosis in words that a test engineer understands, and its parameters with uncertainty."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from hexathermal.learn.diagnosis.causes import catalogue
from hexathermal.learn.diagnosis.course import Found
from hexathermal.learn.diagnosis.result import Effect, Quantity
from hexathermal.learn.diagnosis.stage import Stage
from hexathermal.poses import FloatArray

UM = 1e6
AMPLITUDES: dict[str, tuple[tuple[str, ...], str, float]] = {
    "lag": (("amplitude_per_K",), "1/K", 1.0),
    "lead": (("first_per_K", "second_per_K"), "1/K", 1.0),
    "temperature": (("coefficient_per_K",), "1/K", 1.0),
    "stored-heat": (("amplitude",), "m per unit", 1.0),
    "square": (("curvature_per_K2",), "1/K^2", 1.0),
    "room": (("coefficient_um_per_K",), "um/K", UM),
    "air-index": (("share",), "1", 1.0),
    "tilt": (("lever_x_mm", "lever_y_mm"), "mm", 1e3),
    "direction": (("step_um",), "um", UM),
    "periodic": (("sine_um", "cosine_um"), "um", UM),
    "position": (("scale_ppm",), "1e-6", 1e6),
    "relaxation": (("kick_um",), "um", UM),
    "time": (("rate_um_per_h",), "um/h", UM),
}
"""Names, unit and factor of a shape's amplitudes."""

STEPS: dict[str, tuple[str, str, float]] = {
    "zero-jump": ("step_um", "um", UM),
    "sensor-drift": ("rate_K_per_h", "K/h", 1.0),
    "sensor-detached": ("share", "1", 1.0),
}
"""The same of repairs and steps."""

UNITS = {"time_constant_s": "s", "pitch_m": "m", "time_s": "s", "offset_s": "s"}


def effect_of(found: Found, stage: Stage, final: Stage, covariance: FloatArray, mean: FloatArray) -> Effect:
    """Return a named cause with its parameters.

    Parameters
    ----------
    found : Found
    stage : Stage
        Before the cause joined.
    final : Stage
        With all that joined.
    covariance, mean : array
        Of the coefficients and amplitudes fitted together at the end.
    """
    trial = found.ranked.best.trial
    parameters, settings = _set(trial.parameters)
    amplitudes, spread = _amplitudes(found, final, mean, covariance)
    if trial.shape:
        names, unit, factor = AMPLITUDES[trial.shape]
        for name, value, std in zip(names, amplitudes, spread, strict=True):
            parameters[name] = Quantity(float(value * factor), float(std * factor), unit)
        if trial.shape == "periodic":
            parameters["amplitude_um"] = _length(amplitudes * UM, spread * UM)
    elif trial.cause in STEPS and len(amplitudes):
        name, unit, factor = STEPS[trial.cause]
        value, std = amplitudes[0] * factor, spread[0] * factor
        if trial.cause.startswith("sensor"):
            slope = stage.bench.slopes[str(trial.target)]
            value, std = value / slope, std / abs(slope)
        parameters[name] = Quantity(float(value), float(std), unit)
    visible = found.ranked.best.visible
    sentence = _sentence(trial.cause, trial.target, parameters, settings, visible)
    return Effect(trial.cause, trial.target, parameters, settings, found.decision.probability,
                  found.decision.equivalent, visible, sentence, found.joined)  # fmt: skip


def _set(parameters: Mapping[str, Any]) -> tuple[dict[str, Quantity], dict[str, Any]]:
    """Return parameters of the grid: numbers with units, and names."""
    numbers, names = {}, {}
    for name, value in parameters.items():
        if name in UNITS:
            # a grid of steps g: the parameter lies within half a step
            numbers[name] = Quantity(float(value), float("nan"), UNITS[name])
        elif name != "ratio":
            names[name] = value
    return numbers, names


def _amplitudes(found: Found, final: Stage, mean: FloatArray, covariance: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the amplitudes of what joined, from the last fit; of a repair, from its own step."""
    at = final.view.base_columns.shape[1]
    for item in final.joined:
        k = item.trial.columns.shape[1]
        if item is found.ranked.best:
            own = slice(at, at + k)
            return mean[own], np.sqrt(np.diagonal(covariance)[own])
        at += k
    return found.amplitudes, found.spread


def _length(values: FloatArray, spread: FloatArray) -> Quantity:
    """Return the length of a vector of two amplitudes."""
    size = float(np.hypot(*values))
    return Quantity(size, float(np.hypot(*(values * spread)) / max(size, 1e-30)), "um")


def _sentence(
    cause: str, target: str | None, parameters: Mapping[str, Quantity], settings: Mapping[str, Any], visible: float
) -> str:
    """Return the finding in one sentence."""
    known = catalogue()[cause].CAUSE
    parts = []
    for name, one in parameters.items():
        spread = f" ± {one.std:.2g}" if np.isfinite(one.std) else ""
        words = name.rsplit("_", 1)[0].replace("_", " ")
        parts.append(f"{words} {one.value:.3g}{spread} {one.unit}")
    if "other" in settings:
        parts.append(f"the other is {settings['other']}")
    words = known.words.format(target=target or "the leg")
    inside = f" ({'; '.join(parts)})" if parts else ""
    return (
        f"The residual is {cause}{inside}: {words}; {visible * UM:.2g} um of it stay visible when the law is refitted."
    )


def experiment_of(cause: str) -> str:
    """Return the measurement that decides about a cause."""
    return catalogue()[cause].CAUSE.experiment
