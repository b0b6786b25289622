"""Figures of the report of a diagnosis, from its plain values: ranking, gain, limits of detection, disturbances."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from hexathermal.learn.machine_diagnosis.result import UM
from hexathermal.show.diagnosis_words import where
from hexathermal.show.figures import BLUE, GREEN, GREY, PURPLE, VERMILION
from hexathermal.show.machine_limits import limits_by_cause, limits_told
from hexathermal.show.report_chart import Bars, Chart, Panel

MOST_BARS = 20
"""Candidates that are drawn; the table has all."""

Facts = dict[str, Any]


def ranking_chart(told: Facts) -> Chart:
    """Return the evidence of each candidate, best first."""
    shown = told["candidates"][:MOST_BARS]
    names = _each_once([f"{one['cause']} {where(one['cause'], one['target']).strip('-')}".strip() for one in shown])
    values = np.array([float(one["evidence"]) for one in shown])
    named = np.arange(len(shown)) < len(told["effects"])
    bars = [
        Bars(what, names, np.where(which, values, 0.0), colour)
        for what, which, colour in (("named", named, VERMILION), ("not named", ~named, BLUE))
        if which.any()
    ]
    panel = Panel("Evidence", tuple(bars), "log evidence", "", across=True, line=float(told["threshold"]), stacked=True)
    best = "; ".join(f"{name} {value:.1f}" for name, value in list(zip(names, values, strict=True))[:4])
    some = f" The first {len(shown)} of {len(told['candidates'])}." if len(shown) < len(told["candidates"]) else ""
    return Chart(
        "ranking", "Evidence of each candidate",
        f"Evidence of {len(shown)} candidates; a name needs {told['threshold']:.1f}. First: {best}.",
        f"What ends left of the dotted line is too weak for a name in this campaign.{some}", (panel,),
    )  # fmt: skip


def _each_once(names: list[str]) -> tuple[str, ...]:
    """Return names, those that come again with their number."""
    found: list[str] = []
    for k, name in enumerate(names):
        found.append(name if name not in found else f"{name} ({k + 1})")
    return tuple(found)


def gain_chart(gain: Facts, measures: Callable[[Facts], list[tuple[str, str]]], joined: bool) -> list[Chart]:
    """Return errors before and after of each run; where nothing joined, there is no after."""
    names, panels, words = tuple(gain["runs"]), [], []
    for key, unit in measures(gain):
        pairs = [[float(one[f"{key}_{when}_{unit}"]) for one in gain["runs"].values() if f"{key}_{when}_{unit}" in one]
                 for when in ("before", "after")]  # fmt: skip
        if len(pairs[0]) != len(names):
            continue
        shown = unit.replace("um", "µm").replace("urad", "µrad")
        bars: tuple[Bars, ...] = (Bars("before", names, np.array(pairs[0]), VERMILION),)
        if joined:
            bars += (Bars("after", names, np.array(pairs[1]), BLUE),)
        title = key.replace("_", " ").replace("rmse", "RMSE")
        panels.append(Panel(title[0].upper() + title[1:], bars, "run", "RMSE", "", shown))
        words += [f"{name} {a:.3f}{f' to {b:.3f}' if joined else ''} {shown}"
                  for name, a, b in zip(names, *pairs, strict=True)]  # fmt: skip
    if not panels:
        return []
    title = "Before and after" if joined else "What is left of each run"
    told = "before and after the extension" if joined else "of the law as it is"
    said = (
        "All runs for validation, to which no law was fitted, each without the motion of the measuring frame that "
        "suits it best."
        if "all, no frame" in names
        else "Each run for validation, to which no law was fitted."
    )
    return [Chart("gain", title, f"RMSE {told}: {'; '.join(words)}.", said, tuple(panels))]


def limits_chart(told: Facts) -> Chart | None:
    """Return how large each effect must be to be named: of a machine at its best place; None where nothing is known."""
    if "detection_limits_um" in told:
        sizes = {cause: float(value) for cause, value in told["detection_limits_um"].items() if value}
        what = "visible RMS"
    else:
        sizes, what = {}, "RMS shift of the platform"
        for cause, places in limits_by_cause(limits_told(told)):
            if places[0].translation:
                sizes[cause] = places[0].translation * UM
    if not sizes:
        return None
    order = sorted(sizes, key=lambda cause: sizes[cause])
    bars = (Bars(what, tuple(order), np.array([sizes[cause] for cause in order]), PURPLE),)
    return Chart(
        "limits", "Limits of detection",
        f"Smallest effects that would be named, from {sizes[order[0]]:.2g} µm ({order[0]}) to "
        f"{sizes[order[-1]]:.2g} µm ({order[-1]}).",
        "How large an effect of each cause must be in this campaign to be named"
        + ("." if "detection_limits_um" in told else ", at the leg, joint or plate where it is seen best."),
        (Panel("Smallest effect that would be named", bars, what, "", "µm", across=True),),
    )  # fmt: skip


def disturbances_chart(told: Facts) -> tuple[Chart, ...]:
    """Return noise and disturbances of each axis of a machine."""
    kinds = [name for name, values in told.items() if isinstance(values, dict) and any(values.values())]
    if not kinds:
        return ()
    panels = []
    for title, unit, shown in (("Shift", "um", "µm"), ("Turn", "urad", "µrad")):
        axes = tuple(name for name in told[kinds[0]] if name.endswith(f"_{unit}"))
        bars = tuple(Bars(name.replace("_", " "), tuple(axis.rpartition("_")[0] for axis in axes),
                          np.array([float(told[name][axis]) for axis in axes]), colour)
                     for name, colour in zip(kinds, (BLUE, VERMILION, GREEN, PURPLE, GREY), strict=False))  # fmt: skip
        panels.append(Panel(title, bars, "axis", "standard deviation", "", shown))
    words = ", ".join(name.replace("_", " ") for name in kinds)
    return (Chart("noise", "Noise and disturbances", f"Standard deviations of six axes: {words}.",
                  "What the measurement of the platform brings, axis by axis.", tuple(panels)),)  # fmt: skip
