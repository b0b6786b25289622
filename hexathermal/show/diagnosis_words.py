"""Words of a diagnosis for people: parameters in units of the workshop, evidence as odds, what names mean."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from hexathermal.learn.coverage import TWO_SIDED
from hexathermal.learn.diagnosis.alike_by_nature import explaining_as_much
from hexathermal.show.diagnosis_labels import CHOICES, LABELS, SHARES, SIGNALS

if TYPE_CHECKING:
    from hexathermal.learn.diagnosis.result import Diagnosis, Effect, Quantity


ENDINGS = ("_degC", "_per_K2", "_urad_per_K", "_um_per_K", "_um_per_h", "_um_per_unit", "_K_per_h", "_per_K", "_um",
           "_mm", "_ppm", "_K", "_s", "_m")  # fmt: skip
"""Of a parameter's name: the unit, which is shown apart."""

NONE_NAMED = ("explains them better than chance could", "can be named")
"""What is said of all causes where none was named: as it is, and where some stand above chance."""

VERDICTS = {
    "effect": "a cause is named",
    "none": "nothing stands above the noise",
    "unexplained": "something real, without a name",
}


UNNAMED = "nothing can be named"
"""The verdict where some candidates stand above chance and none is given as a name."""


def verdict_words(found: Diagnosis) -> str:
    """Return a verdict in words; where some candidates stand above chance, nothing can be named."""
    return UNNAMED if found.unnamed else VERDICTS[found.verdict]


@dataclass(frozen=True)
class Shown:
    """A parameter as it is shown.

    Attributes
    ----------
    name : str
    value, std : float
        `std` is NaN where none could be told.
    unit : str
    positive : bool
        Whether it is above zero by what it is, like a time constant.
    """

    name: str
    value: float
    std: float
    unit: str
    positive: bool = False

    @property
    def cells(self) -> tuple[str, str, str]:
        """Value, standard uncertainty and 95 % interval, rounded to two digits of the uncertainty."""
        ends = span(self.value, self.std, self.positive)
        return (rounded(self.value, self.std), rounded(self.std, self.std), ends)


def parameter(name: str, quantity: Quantity, kind: str = "leg") -> Shown:
    """Return a parameter in a unit that people measure in.

    A part that is no leg has no length that a temperature acts on: its coefficients are lengths for a kelvin, but for
    those that multiply its displacement.

    Examples
    --------
    >>> from hexathermal.learn.diagnosis.result import Quantity
    >>> parameter("pitch_m", Quantity(2e-3, 1e-5, "m")).cells
    ('2.000', '0.010', '1.980 to 2.020')
    >>> parameter("time_constant_s", Quantity(240.0, 180.0, "s")).cells  # never below zero
    ('4.0', '3.0', 'below 9.9')
    """
    from hexathermal.learn.diagnosis.words import ALONG, POSITIVE, workshop

    unit, factor = workshop(quantity)
    if kind != "leg" and name != ALONG:
        unit = unit.replace("/m/K", "/K")
    if unit.startswith(("um per ", "um/m per ")) and abs(quantity.value * factor) < 1e-3:
        unit, factor = unit.replace("um", "pm", 1), factor * 1e6
    return Shown(_label(name), quantity.value * factor, quantity.std * factor, unit, name in POSITIVE)


def rounded(value: float, std: float) -> str:
    """Return a value with as many decimals as two digits of its uncertainty have; "-" for none.

    Examples
    --------
    >>> rounded(-0.14608, 0.00882), rounded(960.0, float("nan")), rounded(float("nan"), 1.0)
    ('-0.1461', '960', '-')
    """
    if not math.isfinite(value):
        return "-"
    if not math.isfinite(std) or not 1e-6 < std < 1e6:
        return f"{value:.3g}"
    return f"{value:.{max(0, 1 - math.floor(math.log10(std)))}f}"


def span(value: float, std: float, positive: bool = False) -> str:
    """Return a 95 % interval, without what is below zero where that cannot be; "-" where none could be told.

    Examples
    --------
    >>> span(12.0, 4.0), span(12.0, 8.0), span(12.0, 8.0, positive=True), span(12.0, float("nan"))
    ('4.2 to 19.8', '-3.7 to 27.7', 'below 27.7', '-')
    """
    if not math.isfinite(std):
        return "-"
    low, high = rounded(value - TWO_SIDED * std, std), rounded(value + TWO_SIDED * std, std)
    return f"below {high}" if positive and value <= TWO_SIDED * std else f"{low} to {high}"


def effect_rows(effect: Effect, kind: str) -> list[tuple[str, ...]]:
    """Return the parameters of a cause: name, value, standard uncertainty, 95 % interval, unit."""
    shown = [parameter(name, quantity, kind) for name, quantity in effect.parameters.items()]
    shares = {"share": SHARES.get(effect.cause, "share")}
    rows: list[tuple[str, ...]] = [(shares.get(one.name, one.name), *one.cells, one.unit or "-") for one in shown]
    kept = {name: value for name, value in effect.settings.items() if name not in HIDDEN and value != effect.target}
    return rows + [
        (_label(name), CHOICES.get((name, value), _plain(value)), "-", "-", "-") for name, value in kept.items()
    ]


def _plain(value: Any) -> str:
    """Return a setting without digits that nobody reads."""
    return f"{value:.8g}" if isinstance(value, float) else str(value)


def _label(name: str) -> str:
    """Return what a parameter is called, its unit apart."""
    bare = next((name.removesuffix(one) for one in ENDINGS if name.endswith(one)), name)
    return LABELS.get(name, bare.replace("_", " "))


def where(cause: str, target: str | None) -> str:
    """Return where a candidate sits; "-" for the whole, and for a signal, which its name tells already.

    Examples
    --------
    >>> where("missing-sensor", "T15"), where("backlash", None), where("follows the pressure", "the pressure")
    ('T15', '-', '-')
    """
    return "-" if cause.startswith("follows") else target or "-"


def placed(cause: str, target: str | None) -> str:
    """Return a candidate together with where it sits.

    Examples
    --------
    >>> placed("missing-sensor", "T15"), placed("backlash", None), placed("follows the pressure", "the pressure")
    ('missing-sensor, T15', 'backlash', 'follows the pressure')
    """
    at = where(cause, target)
    return cause if at == "-" else f"{cause}, {at}"


def settings_words(settings: Mapping[str, Any]) -> str:
    """Return the parameters at which a cause explains most, in words.

    Examples
    --------
    >>> settings_words({"time_constant_s": 960.0, "order": 2, "ratio": 0.5, "sensor": "T07"})
    'time constant 16 min, order 2'
    >>> settings_words({"run": "run-03", "time_s": 3672.5})
    'in run-03, at 61.2 min'
    """
    said = (_setting(name, value) for name, value in settings.items() if name not in HIDDEN)
    return ", ".join(words for words in said if words)


HIDDEN = ("sensor", "sensors", "ratio", "source", "path_m", "stroke_share", "first", "reference_degC",
          "weights", "heat_times_s", "once", "twice")  # fmt: skip
"""Settings that say nothing beside the target."""


PLACES = {
    "run": "in",
    "time_s": "at",
    "from_run": "from",
    "since": "since",
    "from_share": "since this share of the time measured:",
}
"""Words before settings that tell where and when."""


TOLD = {
    "_s_per_h": " s/h",
    "_K_per_h": " K/h",
    "_um_per_h": " um/h",
    "_ppm": " um/m",
    "_um": " um",
    "_K": " K",
    "_degC": " °C",
}
"""Units of settings by the endings of their names."""

ENDLESS = 1e6
"""A setting above stands for one without an end, and is not said."""


def _setting(name: str, value: Any) -> str:
    """Return one setting in words."""
    label = PLACES.get(name) or _label(name)
    if (name, value) in CHOICES:
        return f"{label} {CHOICES[name, value]}"
    if isinstance(value, str | bool) or not isinstance(value, int | float):
        return f"{label} {value}"
    if abs(value) > ENDLESS:
        return ""
    if name.endswith("_s"):
        return f"{label} {duration(float(value))}"
    if name.endswith("_m"):
        return f"{label} {float(value) * 1e3:.3g} mm"
    if name.endswith("_index"):
        return f"{label} {float(value):.6f}"
    unit = next((unit for ending, unit in TOLD.items() if name.endswith(ending)), "")
    return f"{label} {float(value):.3g}{unit}"


def duration(seconds: float) -> str:
    """Return a time as people say it.

    Examples
    --------
    >>> duration(45.0), duration(960.0), duration(15360.0)
    ('45 s', '16 min', '4.27 h')
    """
    size = abs(seconds)
    return (
        f"{seconds:.3g} s"
        if size < 120.0
        else f"{seconds / 60.0:.3g} min"
        if size < 7200.0
        else f"{seconds / 3600.0:.3g} h"
    )


def how_apart(separation: float) -> str:
    """Return how well two causes are told apart by so much log evidence."""
    return "not at all" if separation < 1.0 else "barely" if separation < 3.0 else "weakly"


def signal_words(name: str, found: Diagnosis) -> tuple[str, str, float]:
    """Return what a signal of a residual is called, its unit and its factor; others are recorded inputs."""
    words, unit, factor = SIGNALS.get(name, (f"recorded input {name}", "", 1.0))
    law = found.law
    return words.format(sensor=law.sensors[0], zero=law.zero, follows=found.follows), unit, factor


def visible_std(effect: Effect) -> float:
    """Return the standard uncertainty of what stays visible [m], NaN where it could not be told.

    The visible part is proportional to the amplitude: it has the same relative uncertainty; of several amplitudes, that
    of the one that is known best.
    """
    from hexathermal.learn.diagnosis.words import UNITS as OF_GRIDS

    shares = [
        one.std / abs(one.value)
        for name, one in effect.parameters.items()
        if name not in OF_GRIDS and math.isfinite(one.std) and one.value
    ]
    return effect.visible * min(shares) if shares else math.nan


READ = 0.05
"""Noise of readings that is told, over all noise."""


def noise_rows(found: Diagnosis) -> list[tuple[str, float, str]]:
    """Return the parts of the noise: name, standard deviation [m], and what makes it."""
    noise = found.noise
    lands = noise.landing > 0.0 or any("direction" in run.signals for run in found.residuals)
    read = noise.least > READ * noise.rms
    first = ", from the noise of its first row" if found.law.zero == "run" else " against the others"
    return [
        ("white", noise.white, "differs from row to row; means of many rows hardly feel it"),
        *[("landings", noise.landing, "each stop after a move lands a little elsewhere")] * lands,
        *[("readings", noise.least, "what noise of the law's thermometers leaves in the mean of minutes")] * read,
        ("slow", noise.slow, f"wanders within about {duration(noise.slow_time)}"),
        ("zero of a run", noise.offset, f"shifts a whole run{first}"),
    ]


def changed(found: Diagnosis) -> bool:
    """Return whether something joined the law, so that there is an after."""
    return found.extended is not found.law


MOST_OUTSIDE = 0.2
"""Part of the lags beyond the band of independent noise from which on windows share something that is left."""


def lags_outside(found: Diagnosis) -> list[int]:
    """Return how many lags stand out of the band of independent noise, before and, where something joined, after."""
    told = found.whiteness
    if told is None:
        return []
    shown = [told.before, told.after] if changed(found) else [told.before]
    return [int((np.abs(one) > told.band).sum()) for one in shown]


def shares_windows(found: Diagnosis) -> bool:
    """Return whether something is left that windows share, before as after."""
    outside = lags_outside(found)
    return found.whiteness is not None and min(outside) > MOST_OUTSIDE * len(found.whiteness.before)


def sentences(found: Diagnosis) -> list[str]:
    """Return the finding: a sentence for each cause, what a law that was given lacks, and which runs are unlike."""
    return list(found.framed(found.sentences or (found.finding,)))


ADVICE = {
    "rhythm": " A rhythm that no cause has is often that of the room or of a supply: see what switches on and off with "
    "this period, as air conditioning, a chiller or a pump does.",
    "a rate of each run's own": " What drifts at another rate in each run, as up in some and down in others, often "
    "goes with the day or with who works beside the bench: a floor or a foundation that tilts, a door, the sun. A zero "
    "that drifts at a rate of its own in each run is the same to these data. Look at the rates against the hour, and "
    "let the bench stand still for a day and a night.",
    "the rest since a move": " A step some time after each stop, all at once, is no creep: see what lets go, closes or "
    "is switched off when nothing has moved for so long, as a brake or the current of a motor at rest does.",
    "the rests before moves": " What a move leaves behind, the more, the longer the rod had rested before, sticks: a "
    "seal or a guide whose friction grows at rest, grease that is pressed out. Make the same moves after a minute and "
    "after an hour of rest; a few quick strokes should set it free.",
    "the way since a reversal": " What turns round over centimetres after each reversal, and stays when the rod rests, "
    "is drawn along: see what hangs on the rod, as a cable, a hose or a cover, and what the guide wipes.",
    "the product of two temperatures": " What moves only where two places are warm is moved by the one as far as the "
    "other lets it: a clamp that holds, a clearance that closes, grease that thins. Warm each alone, then both.",
    "temperature so far": " What moves only where it is warmer, or colder, than ever before, and stays, has set: "
    "a seat, a screw or a joint that slips as parts grow apart. Warm it as far again: the second time it is still.",
    "the speed of the last move": " What depends on how fast the rod came, and stays when it rests, is often a film of "
    "grease or a controller that stops short: drive to the same places slowly and quickly.",
}
"""What to look for, by what the name of something unexplained holds."""


def unexplained_words(found: Diagnosis) -> str:
    """Return what to do where something real has no name."""
    best = next((settings_words(one.settings) for one in found.candidates if one.cause == found.follows), "")
    at = f" (at best {'' if best.startswith('in ') else 'with '}{best})" if best else ""
    return (
        f"What is left {found.follows}{at} more than chance could make it, but none of the seventeen causes of the "
        "catalogue explains that. Look at the pictures of that signal, and at what changes with it on the bench: it is "
        "real, and it is not noise. The law was left as it is."
        + "".join(advice for shape, advice in ADVICE.items() if shape in (found.follows or ""))
        + _nearly_named(found)
    )


def _nearly_named(found: Diagnosis) -> str:
    """Return the name that explains nearly what something nameless does, or more, but not clearly more; or nothing."""
    best = next(iter(explaining_as_much(found.follows or "", found.candidates)), None)
    if best is None:
        return ""
    left = next(one.evidence for one in found.candidates if one.cause == found.follows)
    name = best.cause if best.target is None else f"{best.cause} ({best.target})"
    return (
        f" The cause {name} explains about as much (log evidence {best.evidence:.1f}, against {left:.1f}) and is not "
        "ruled out: a name must be clearly ahead of what follows one signal alone."
    )


def shared_words(one: Effect) -> list[str]:
    """Return why the sizes of a cause may be uncertain although it is sure; nothing where they are not."""
    from hexathermal.learn.diagnosis.words import UNITS as OF_GRIDS

    sizes = [size for name, size in one.parameters.items() if name not in OF_GRIDS and math.isfinite(size.std)]
    if not sizes or any(abs(size.value) > TWO_SIDED * size.std for size in sizes):
        return []
    return [
        "The interval of its size holds 0 although something of it is seen: the law's own coefficients can take up a "
        "part of it, and these data do not tell how much."
    ]
