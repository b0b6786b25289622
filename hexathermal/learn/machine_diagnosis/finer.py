"""Candidates with a setting that is tried at several values, tried again at values between."""

from __future__ import annotations

import numpy as np

from hexathermal.learn.machine_diagnosis.candidate import Candidate
from hexathermal.learn.machine_diagnosis.causes.tracker_drift import CAUSE, following
from hexathermal.learn.machine_diagnosis.leg_terms import term_candidate
from hexathermal.learn.machine_diagnosis.view import MachineView

SETTINGS = ("play_m", "time_constant_s", "pitch_m")
STEPS = 2.0 ** (np.arange(-4, 5) / 4.0)
"""Factors of a setting: a quarter of an octave each."""


def finer_setting(view: MachineView, one: Candidate) -> str:
    """Return the setting of a candidate that may be tried finer, empty where there is none or the machine states it."""
    if one.cause == CAUSE.name and view.hexapod.measuring_frame is not None:
        return ""
    return next((name for name in SETTINGS if one.settings.get(name)), "")


def finer_candidates(view: MachineView, one: Candidate) -> list[Candidate]:
    """Return a candidate at values of its setting from half to twice as much."""
    name = finer_setting(view, one)
    found = []
    for value in (float(one.settings[name]) * STEPS).tolist():
        settings = dict(one.settings) | {name: value}
        if value == one.settings[name]:
            continue
        if one.leg_shape:
            found.append(term_candidate(view, one.cause, one.legs[0], one.leg_shape, one.names, one.units, settings))
        else:
            found.append(following(view, str(one.target), value))
    return found
