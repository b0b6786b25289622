"""The zero drifts with time."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from hexathermal.learn.diagnosis.causes.creep import begins_anew, often_begun
from hexathermal.learn.diagnosis.own_rates import own_rates
from hexathermal.learn.diagnosis.trials import Cause, Parameter, Trial, Workbench

CAUSE = Cause(
    name="zero-drift",
    physics="The laser, the optics, a clamp or a foundation drifts steadily, whatever the temperatures do.",
    signature="The residual is proportional to time; that of an instrument that warms up comes to rest in each run.",
    parameters=(
        Parameter("rate", "m/h", "visible effect of 0.25 to 4 times the noise; runs may differ about it"),
        Parameter("time_constant_s", "s", "1000 s to 150 min, of an instrument that warms up when a run begins"),
        Parameter("decades", "1", "of such times, 0 or 1.5"),
    ),
    confused_with=(
        "creep",
        "frame-expansion",
        "sensor-drift",
        "air-refraction",
    ),
    experiment="A night at rest at constant temperature.",
    words="the zero drifts with time",
    wanders=True,
    readings=12,
)

WARMED_S = (1000.0, 1700.0, 3000.0, 5200.0, 9000.0)
"""Times in which an instrument warms up."""

BROAD_S, DECADES = (300.0, 800.0, 2000.0), 1.5
"""The shortest of times over so many decades, with which it goes as the logarithm of time."""

SELDOM, LONG_S, AT_LONG, BROADLY = -3.0, 4000.0, -2.0, -4.0
"""Log evidence of that beforehand: it is what creep from the beginning of runs is, by more of a name's few trials. What
takes longer than an hour is an instrument's warming rather than what gives way; what goes as the logarithm of time
rather gives way: eight of eight did of one generator of another hand."""

UNLIKE = (0.5, 1.5)
"""Sizes of what rates of single runs differ by, as `Trial.started`: a third of the common rate, or as much as it."""


def trials(bench: Workbench) -> Iterator[Trial]:
    """Give the time since the zero, at one rate or one of its own besides in each run; and what warms up in each."""
    trial = bench.term(CAUSE.name, "time", None, quick=True)
    yield trial
    if often_begun(bench.view):
        # of a part that never moves nothing else is told from its beginnings on: fewer do
        anew = begins_anew(bench.view)
        forms: list[dict[str, Any]] = [{"time_constant_s": tau} for tau in (WARMED_S if anew else WARMED_S[::2])]
        forms += [{"time_constant_s": tau, "decades": DECADES} for tau in BROAD_S if anew]
        for form in forms:
            warming = bench.term(CAUSE.name, "relaxation", None, kick="begin", **form)
            seldom = BROADLY if "decades" in form else SELDOM
            yield replace(warming, advantage=AT_LONG if form["time_constant_s"] > LONG_S else seldom)
    own = own_rates(bench.view)
    if own is not None:
        for unlike in UNLIKE:
            yield replace(trial, columns=np.column_stack([trial.columns, own]), starts=own.shape[1],
                          started=unlike)  # fmt: skip
