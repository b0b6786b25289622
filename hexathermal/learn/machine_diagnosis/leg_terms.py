"""Candidates that are terms of one leg's law: the catalogue of a single leg, as far as a machine can show it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from hexathermal.learn.machine_diagnosis.candidate import Candidate
from hexathermal.learn.machine_diagnosis.view import MachineView
from hexathermal.machine.leg_states import LegMemory, terms_columns
from hexathermal.machine.leg_terms import LegTerm

USUAL_EFFECT = 1e-6
"""Prior of a term's effect on its leg, RMS [m]."""


def term_candidate(
    view: MachineView,
    cause: str,
    leg: int,
    shape: str,
    names: tuple[str, ...],
    units: tuple[str, ...],
    parameters: Mapping[str, Any],
) -> Candidate:
    """Return a term of a leg as a candidate; its memory begins anew in each run, as on a machine.

    Parameters
    ----------
    view : MachineView
    cause : str
    leg : int
        0 to 5.
    shape : str
        See `hexathermal.machine.leg_terms.SHAPES`.
    names, units : tuple of str
        Of the shape's amplitudes.
    parameters : mapping
        Of the shape.
    """
    columns = np.zeros((len(view), 6, len(names)))
    term = LegTerm(cause, shape, parameters, np.zeros(len(names)))
    for rows, signals in view.signals(leg):
        memory = LegMemory((term,))
        memory.count_from_retracted((term,), signals)
        columns[rows, leg] = terms_columns((term,), signals, memory)
    rms = np.sqrt((columns[:, leg] ** 2).mean(axis=0))
    scale = USUAL_EFFECT / np.where(rms > 0.0, rms, 1.0)
    return Candidate(
        cause, f"leg{leg + 1}", names, units, columns, scale, np.zeros(len(names)), dict(parameters), shape
    )
