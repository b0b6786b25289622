"""The diagnosis in words that a test engineer understands, and its parameters with uncertainty."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from hexathermal.learn.coverage import TWO_SIDED
from hexathermal.learn.diagnosis.alike_by_nature import alike_by_nature
from hexathermal.learn.diagnosis.causes import catalogue
from hexathermal.learn.diagnosis.causes.sensor_detached import share_of
from hexathermal.learn.diagnosis.extension import terms_of_law
from hexathermal.learn.diagnosis.grid_spread import grid_spread
from hexathermal.learn.diagnosis.joining import Found
from hexathermal.learn.diagnosis.result import Effect, Quantity
from hexathermal.learn.diagnosis.stage import Stage
from hexathermal.machine.leg_terms import BY_MOTION
from hexathermal.poses import FloatArray

UM = 1e6
AMPLITUDES: dict[str, tuple[tuple[str, ...], str, float]] = {
    "lag": (("amplitude_per_K",), "1/K", 1.0),
    "lead": (("first_per_K", "second_per_K"), "1/K", 1.0),
    BY_MOTION: (("amplitude_per_K",), "1/K", 1.0),
    "foretold": (("amplitude_per_K",), "1/K", 1.0),
    "temperature": (("coefficient_per_K",), "1/K", 1.0),
    "expansion": (("A_per_K", "B_per_K"), "1/K", 1.0),
    "stored-heat": (("amplitude",), "m per unit", 1.0),
    "square": (("curvature_per_K2",), "1/K^2", 1.0),
    "cube": (("cubic_per_K3",), "1/K^3", 1.0),
    "bend": (("curvature_per_K2",), "1/K^2", 1.0),
    "room": (("coefficient_um_per_K",), "um/K", UM),
    "air-index": (("share",), "1", 1.0),
    "tilt": (("lever_x_mm", "lever_y_mm"), "mm", 1e3),
    "direction": (("step_um",), "um", UM),
    "periodic": (("sine_um", "cosine_um"), "um", UM),
    "wave": (("amplitude_um",), "um", UM),
    "position": (("scale_ppm",), "1e-6", 1e6),
    "relaxation": (("kick_um",), "um", UM),
    "time": (("rate_um_per_h",), "um/h", UM),
}
"""Names, unit and factor of a shape's amplitudes."""

STEPS: dict[str, tuple[str, str, float]] = {
    "zero-jump": ("step_um", "um", UM),
    "sensor-drift": ("rate_K_per_h", "K/h", 1.0),
}
"""The same of repairs and steps."""

SPOKEN = {
    "time_constant_s": "time constant", "pitch_m": "pitch", "time_s": "at", "offset_s": "offset",
    "gains_s_per_h": "gains", "step_um": "step",
    "rate_um_per_h": "rate", "rate_K_per_h": "rate", "wander_K": "wander, RMS,",
    "kick_um": "after each move", "scale_ppm": "scale",
    "coefficient_per_K": "coefficient", "A_per_K": "A", "B_per_K": "B",
    "coefficient_um_per_K": "coefficient", "curvature_per_K2": "curvature", "cubic_per_K3": "cubic part",
    "saturation_m": "long moves from", "amplitude_um": "amplitude", "share": "share", "amplitude_per_K": "coefficient",
    "path_m": "path",
}  # fmt: skip
"""Words of parameters that a sentence tells."""

HIDDEN = ("ratio", "path_m", "stroke_share", "decay_runs", "from_share", "order", "power", "reference_degC",
          "calibration_degC", "weights", "origin_m", "heat_times_s", "once", "twice")  # fmt: skip
"""Settings of shapes that say nothing to a reader."""

LONG_S = 120.0
"""Times from here on are told in minutes."""

POSITIVE = ("time_constant_s", "source_time_constant_s", "pitch_m", "play_m", "saturation_m")
"""Parameters that are above zero by what they are."""


AIR = "air-refraction"
"""The cause whose share below none has a sense of its own."""

ALONG = "B_per_K"
"""The coefficient that multiplies the displacement, of whatever part."""

PER_KELVIN = ("1/K", "1/K^2", "1/K^3")
"""Units of a leg's expansion; of another part it is a length."""

AS_LONG = " in motion"
"""Ending of the unit of heat that lasts as long as anything moves."""

RATE_ERROR = 0.15
"""What rates that motion tells may be wrong by: 330 and 131 s of lateness were 378 and 114."""

UNSURE = 2.0
"""Amplitudes that are together fewer standard uncertainties tell neither size nor sign."""

WORKSHOP: dict[str, tuple[str, float]] = {
    "1/K": ("um/m/K", 1e6),
    "1/K^2": ("um/m/K^2", 1e6),
    "1/K^3": ("um/m/K^3", 1e6),
    "m": ("mm", 1e3),
    "1e-6": ("um/m", 1.0),
    "1": ("", 1.0),
}
"""Unit in which people measure, for a unit of a parameter, and its factor; others stay."""

UNITS = {"time_constant_s": "s", "source_time_constant_s": "s", "saturation_m": "m", "play_m": "m",
         "pitch_m": "m", "time_s": "s", "offset_s": "s", "gains_s_per_h": "s/h", "rate_K_per_h": "K/h",
         "middle_degC": "degC", "width_K": "K"}  # fmt: skip


def amplitudes_of(shape: str, count: int) -> tuple[tuple[str, ...], str, float]:
    """Return names, unit and factor of a shape's amplitudes; of a shape that has none here, micrometres for a unit."""
    return AMPLITUDES.get(shape, (tuple(f"amplitude_{k + 1}_um" for k in range(count)), "um", UM))


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
    parameters, settings = _set(found, stage)
    amplitudes, spread = _amplitudes(found, final, mean, covariance)
    if trial.shape:
        names, unit, factor = amplitudes_of(trial.shape, len(amplitudes))
        if "source" in trial.parameters:
            unit = of_source(trial.parameters)
        for name, value, std in zip(names, amplitudes, spread, strict=True):
            own, times = (unit, factor) if stage.view.kind == "leg" else of_part(name, unit, factor)
            if stage.view.kind != "leg" and "ratio" in trial.parameters:  # told for the middle of its places
                times *= float(stage.view.span(trial.parameters["ratio"]).mean())
            parameters[name] = Quantity(float(value * times), float(std * times), own)
        if trial.shape == BY_MOTION:  # a rate knows no time: its amplitude over the law's, as it was found, does
            late = trial.parameters["time_constant_s"] / stage.bench.slopes[str(trial.target)]
            said, error = late * found.amplitudes[0], abs(late) * found.spread[0]
            parameters["time_constant_s"] = Quantity(float(said), float(np.hypot(error, RATE_ERROR * said)), "s")
            del parameters[names[0]]  # it belongs to the time of the term
        if trial.shape == "air-index" and stage.view.kind != "leg":  # nobody stated a path
            path, share = trial.parameters["path_m"], parameters["share"]
            parameters["path_m"] = Quantity(share.value * path, share.std * path, "m")
            if not trial.parameters["stroke_share"]:
                del parameters["share"]
        if trial.shape == "periodic":
            parameters["amplitude_um"] = _length(amplitudes * UM, spread * UM)
    elif trial.wanders:
        parameters["wander_K"] = _wander(found, stage)
    elif trial.partly:
        shown = stage.search.witnesses.shown(trial)
        parameters |= {} if shown is None else {"share": Quantity(shown.amplitude, shown.uncertainty, "1")}
    elif trial.ratio and len(amplitudes):
        parameters["share"] = _share(found, stage, final)
    elif trial.cause in STEPS and STEPS[trial.cause][0] not in parameters and len(amplitudes):
        name, unit, factor = STEPS[trial.cause]
        value, std = amplitudes[0] * factor, spread[0] * factor
        if trial.cause.startswith("sensor"):
            value, std = stage.search.witnesses.told(found.ranked.best, found.ranked.levels)
        parameters[name] = Quantity(float(value), float(std), unit)
    visible = found.ranked.best.visible
    sentence = _sentence(trial.cause, trial.target, parameters, settings, visible, joined=found.joined)
    sentence = sentence if stage.view.kind == "leg" else sentence.replace("the leg", "the part")
    alike = tuple(dict.fromkeys((*found.decision.equivalent, *alike_by_nature(stage.view, trial))))
    sentence = sentence.removesuffix(".") + _doubts(found, amplitudes, spread, alike) + "."
    rivals = {name: found.decision.probabilities[name] for name in found.decision.equivalent}
    return Effect(trial.cause, trial.target, parameters, settings, found.decision.probability, alike, visible, sentence,
                  found.joined, rivals=rivals)  # fmt: skip


def of_part(name: str, unit: str, factor: float) -> tuple[str, float]:
    """Return unit and factor of an amplitude of a part that is no leg: the length that it acts on is 1 m.

    >>> of_part("A_per_K", "1/K", 1.0), of_part("B_per_K", "1/K", 1.0), of_part("amplitude", "1 per rpm", 1.0)
    (('um/K', 1000000.0), ('1/K', 1.0), ('m per rpm', 1.0))
    """
    if unit in PER_KELVIN and name != ALONG:
        return unit.replace("1/", "um/"), UM
    return unit.replace("1 per", "m per").replace("1" + AS_LONG, "m" + AS_LONG), factor


def of_source(parameters: Mapping[str, Any]) -> str:
    """Return the unit of stored heat's amplitude: a length, or a strain, for the unit of what heats, or its square.

    Of heat as long as anything moves (power 0) it is what that comes to in the end.

    >>> of_source({"source": "motion", "power": 2}), of_source({"source": "spindle_speed_rpm", "ratio": 0.4})
    ('m per (m/s)^2', '1 per rpm')
    >>> of_source({"source": "motion", "power": 0})
    'm in motion'
    """
    source, own = str(parameters["source"]), "1" if "ratio" in parameters else "m"
    unit = "m/s" if source == "motion" else source.rpartition("_")[2] if "_" in source else "unit"
    power = parameters.get("power", 1)
    if power == 0:
        return own + AS_LONG
    of = unit if power == 1 else f"({unit})^2" if "/" in unit else f"{unit}^2"
    return f"{own} per {of}"


def _wander(found: Found, stage: Stage) -> Quantity:
    """Return how far a reading wanders, RMS, as sure as its size in the drift is."""
    column, size, spread = found.ranked.best.trial.columns[:, -1], found.amplitudes[-1], found.spread[-1]
    error = float(np.sqrt(np.mean((column / stage.bench.slopes_span(str(found.ranked.best.trial.target))) ** 2)))
    return Quantity(error, error * float(spread / max(abs(size), np.finfo(float).tiny)), "K")


def _share(found: Found, stage: Stage, final: Stage) -> Quantity:
    """Return the share of the air in a reading: what the repair takes out, else what the drift tells.

    Of a ratio r of the shares of air and part it is ``r / (1 + r)``, its uncertainty that of r over ``(1 + r)²``.
    """
    out = [repair.parameters["share"] for repair in final.repairs
           if repair.kind == "loose" and repair.parameters["sensor"] == found.ranked.best.trial.target]  # fmt: skip
    ratio, std = stage.search.witnesses.told(found.ranked.best, found.ranked.levels)
    share = float(out[-1]) if out else share_of(ratio)
    return Quantity(share, std * (1.0 - share) ** 2, "1")


def _set(found: Found, stage: Stage) -> tuple[dict[str, Quantity], dict[str, Any]]:
    """Return parameters of the trials: numbers with units and uncertainty, and names."""
    numbers, names = {}, {}
    for name, value in found.ranked.best.trial.parameters.items():
        if name in UNITS:
            numbers[name] = Quantity(float(value), grid_spread(found.ranked, stage, name), UNITS[name])
        elif name not in HIDDEN and (name != "sensor" or found.ranked.best.trial.target is not None):
            names[name] = value  # of all places together one alone would tell a wrong story
    return numbers, names


def _amplitudes(found: Found, final: Stage, mean: FloatArray, covariance: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the amplitudes of terms of the law, from the last fit; of a repair or a step, as they were found.

    A step of the zero is no term: the last fit stacks what a law needs on new runs, where there is no such step.
    """
    for item, own in terms_of_law(final):
        if item is found.ranked.best:
            return mean[own], np.sqrt(np.diagonal(covariance)[own])
    return found.amplitudes, found.spread


def _length(values: FloatArray, spread: FloatArray) -> Quantity:
    """Return the length of a vector of two amplitudes."""
    size = float(np.hypot(*values))
    return Quantity(size, float(np.hypot(*(values * spread)) / max(size, 1e-30)), "um")


def _sentence(
    cause: str, target: str | None, parameters: Mapping[str, Quantity], settings: Mapping[str, Any], visible: float,
    *, joined: bool = True,
) -> str:  # fmt: skip
    """Return the finding in one sentence."""
    known = catalogue()[cause].CAUSE
    words = known.words.format(target=target or "the part")
    if "other" in settings:
        words = words.replace("another thermometer", str(settings["other"]))
    if "contact" in settings:
        words = words.replace("has come off and reads the air in part", "reads the air in part, now more, now less")
    if "offset_s" in parameters and parameters["offset_s"].value < 0.0:
        words = words.replace("runs ahead of", "runs behind")
    if "gains_s_per_h" in parameters:
        gains = parameters["gains_s_per_h"].value > 0.0
        words = words.replace("runs ahead of", "gains time on" if gains else "loses time against")
    if cause == "backlash" and "step_um" in parameters:
        words += f", {'longer' if parameters['step_um'].value > 0.0 else 'shorter'} where q grew last"
    spoken = SPOKEN | ({"kick_um": "after each long move"} if "saturation_m" in parameters else {})
    if settings.get("kick") == "begin":
        spoken |= {"kick_um": "from the beginning of each run"}
        words = words.replace("after each move", "from the beginning of each run on")
    parts = [f"{spoken[name]} {_spoken_size(name, one)}" for name, one in parameters.items() if name in spoken]
    if "run" in settings and settings["run"] != target:
        lasts = cause.startswith("sensor-") and not settings.keys() & {"fixed_again", "ends_with_run"}
        parts.insert(0, f"from {settings['run']} on" if lasts else f"in {settings['run']}")
    if "since" in settings:
        parts.insert(0, f"since {settings['since']}")
    if "from_run" in settings:
        parts.insert(0, f"from {settings['from_run']} on")
    inside = f" ({'; '.join(parts)})" if parts else ""
    stays = f"{two_digits(visible * UM)} um of it stays visible when the law is refitted"
    if not joined:  # it is seen, but nobody knows that it moves anything
        words = words.replace("moves the part", "goes along with the drift")
    alone = "" if joined else ", but runs left out do without it: it stays out of the law"
    return f"The residual is {cause}{inside}: {words}; {stays}{alone}."


def _doubts(found: Found, amplitudes: FloatArray, spread: FloatArray, alike: Sequence[str]) -> str:
    """Return what a sentence adds where a size is not told from none, or another name is not ruled out."""
    shape = found.ranked.best.trial.shape
    seen = float(np.linalg.norm(amplitudes / np.maximum(spread, 1e-300)))
    loose = bool(shape) and len(amplitudes) > 0 and seen < UNSURE
    size = "; beside the law's own coefficients neither its size nor its sign is sure" if loose else ""
    if found.ranked.cause == AIR and len(amplitudes) and amplitudes[0] < 0.0 and not loose:
        size += "; its share is negative: the beams were corrected too much, or with the wrong sign"
    return size + (f"; not ruled out by these data: {', '.join(alike)}" if alike else "")


def two_digits(value: float) -> str:
    """Return a value to two digits, zeros at the end among them.

    >>> two_digits(4.98), two_digits(0.02), two_digits(130.4), two_digits(0.0)
    ('5.0', '0.020', '130', '0')
    """
    if value == 0.0 or not np.isfinite(value):
        return f"{value:g}"
    rounded = float(f"{value:.1e}")
    return f"{rounded:.{max(1 - int(np.floor(np.log10(abs(rounded)))), 0)}f}"


def workshop(one: Quantity) -> tuple[str, float]:
    """Return the unit in which people measure a quantity, and the factor that leads to it."""
    if one.unit == "s" and abs(one.value) >= LONG_S:
        return "min", 1.0 / 60.0
    if one.unit.endswith(AS_LONG):
        return ("um/m" if one.unit[0] == "1" else "um") + AS_LONG, 1e6
    if " per " in one.unit:
        size, of = one.unit.split(" per ")
        factor = {"m/s": 1e-3, "(m/s)^2": 1e-6}.get(of, 1.0) * 1e6
        return f"{'um/m' if size == '1' else 'um'} per {of.replace('m/s', 'mm/s')}", factor
    return WORKSHOP.get(one.unit, (one.unit, 1.0))


def _spoken_size(name: str, one: Quantity) -> str:
    """Return a parameter's size; of what is above zero by what it is, and hardly known, how large it is at most (95 %).

    >>> _spoken_size("time_constant_s", Quantity(30.0, 73.0, "s")), _spoken_size("offset_s", Quantity(3.0, 7.0, "s"))
    ('below 2.88 min', '3.0 ± 7.0 s')
    """
    if name in POSITIVE and 0.0 < one.value <= TWO_SIDED * one.std < np.inf:
        return f"below {told(Quantity(one.value + TWO_SIDED * one.std, 0.0, one.unit))}"
    return told(one)


def told(one: Quantity) -> str:
    """Return a quantity as a text in a unit that people measure in, rounded to two digits of its uncertainty.

    >>> told(Quantity(0.31294, 0.0213, "um")), told(Quantity(9.66e-07, 6e-08, "1/K"))
    ('0.313 ± 0.021 um', '0.966 ± 0.060 um/m/K')
    >>> told(Quantity(1920.0, 280.0, "s"))
    '32.0 ± 4.7 min'
    """
    unit, factor = workshop(one)
    one = Quantity(one.value * factor, one.std * factor, unit)
    if not np.isfinite(one.std) or one.std <= 0.0:
        return f"{one.value:.3g} {one.unit}".rstrip()
    digits = 1 - int(np.floor(np.log10(one.std)))
    if not -6 < digits < 6:
        return f"{one.value:.3g} ± {one.std:.2g} {one.unit}".rstrip()
    places = max(digits, 0)
    return f"{round(one.value, digits):.{places}f} ± {round(one.std, digits):.{places}f} {one.unit}".rstrip()
