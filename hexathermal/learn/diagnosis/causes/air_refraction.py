"""The index of air was not applied, or not over the dead path."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np

from hexathermal.learn.diagnosis.trials import Cause, Parameter, Trial, Workbench
from hexathermal.learn.diagnosis.view import View
from hexathermal.learn.interferometer import index_along_run
from hexathermal.machine.leg_terms import PRESSURE, WARMTH

CAUSE = Cause(
    name="air-refraction",
    physics=(
        "Light is slower in dense air: a path L read without its index is wrong by L (n - n0), 0.27 um per "
        "metre and hPa, -0.95 um per metre and kelvin."
    ),
    signature=(
        "The residual follows the pressure, which nothing thermal does, or the air's temperature at once; it grows "
        "with the path."
    ),
    parameters=(
        Parameter("share", "1", "of the index that was not applied; 1: all of it"),
        Parameter("weather", "name", "all of it, the pressure alone, or the temperature alone"),
        Parameter("time_constant_s", "s", "none, 5 or 15 min: the air in a tube follows that at the station"),
    ),
    confused_with=(
        "frame-expansion",
        "zero-drift",
    ),
    experiment="A day at rest on which the weather changes, compared with a refractometer every hour.",
    thermal=True,
    words="the index of refraction of air was not applied over the whole path",
    readings=24,
)


ENCLOSED_S = (300.0, 900.0)
"""Time constants of air along the beams behind that at the station."""

STATED_M, SHORT_M = 1.0, 0.2
"""Path of light before a part of which none is stated, the share tells the rest; and before one that moves along it."""


def trials(bench: Workbench) -> Iterator[Trial]:
    """Give the index over the dead path, over the path with the stroke, and with the leg, along which light may pass.

    The laser's scale, too: it may have taken the standard index for the air's, or that of the first run's first row.
    Where air temperature and humidity are read and the pressure was typed in once, the pressure alone is lacking;
    or the temperature was: what it does follows the air at once, which no frame does.
    """
    view = bench.view
    if view.kind != "leg":
        yield from _of_part(bench)
        return
    if not view.indexed:
        return
    zeros = [rows.signals.zero_index for rows in view.runs]
    references = [] if None in zeros else [_standard_index(), *zeros[:1]]
    if not view.zeroed_by_run:
        references = references[:1]
    for path, share in _paths(view):
        own: dict[str, Any] = {"path_m": path, "stroke_share": share}
        ways: list[dict[str, Any]] = [{}, {"weather": PRESSURE}]
        ways += [{"reference_index": one} for one in references if share > 0.0 and view.moves]
        known = [bench.term(CAUSE.name, "air-index", None, quick=True, **own, **way) for way in ways]
        known += [bench.term(CAUSE.name, "air-index", None, time_constant_s=late, **own) for late in ENCLOSED_S]
        yield from (replace(trial, unfeigned=True) for trial in known)
        yield bench.term(CAUSE.name, "air-index", None, quick=True, weather=WARMTH, **own)
    if view.dead_path <= 0.0:
        yield bench.term(CAUSE.name, "air-index", None, quick=True, weather=WARMTH, path_m=view.length,
                         stroke_share=0.0)  # fmt: skip


def _of_part(bench: Workbench) -> Iterator[Trial]:
    """Give the whole index over a path that nobody stated, of a part that light may have measured.

    Pressure and temperature together, as the index has them: what follows one of them alone may be the part itself.
    """
    if not bench.view.weathered:
        return
    for share in (0.0, 1.0) if bench.view.moves else (0.0,):
        own: dict[str, Any] = {"path_m": STATED_M if share == 0.0 else SHORT_M, "stroke_share": share}
        yield replace(bench.term(CAUSE.name, "air-index", None, quick=True, **own), unfeigned=True)
        for late in ENCLOSED_S:
            yield replace(bench.term(CAUSE.name, "air-index", None, time_constant_s=late, **own), unfeigned=True)


def _paths(view: View) -> list[tuple[float, float]]:
    """Return paths with the rod retracted [m], and the part of the stroke that lengthens them."""
    dead, leg = view.dead_path, view.length
    return [(leg, 1.0)] if dead <= 0.0 else [(dead, 0.0), (dead, 1.0), (dead + leg, 1.0)]


@cache
def _standard_index() -> float:
    """Return the index of air at 20 degC, 1013.25 hPa and 50 %, which a laser takes for the air's if nothing is set."""
    return round(float(index_along_run(np.array([[20.0, 101325.0, 0.5]]))[0]), 7)
