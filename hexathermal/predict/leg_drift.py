"""What the terms of a machine's legs add to their drift, at given commands and temperatures.

Terms that follow from displacement and temperatures of one row are told here; those with a state need the rows before,
see `hexathermal.predict.leg_states`. Displacements count from the retracted leg, temperatures from the reference.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from hexathermal.errors import ThermalModelError
from hexathermal.machine.hexapod import Hexapod
from hexathermal.machine.leg_signals import LegSignals
from hexathermal.machine.leg_states import LegMemory, terms_columns, terms_drift
from hexathermal.poses import FloatArray
from hexathermal.predict.budget_blocks import blocks, deviation_size
from hexathermal.predict.temperatures import active_model

DIRECTION = "direction"
"""Shape of the backlash: half its amplitude to either side."""

OF_TEMPERATURES = ("temperature", "gain", "contact", "reference temperature")
"""Quantities of a deviation that tell how far thermometers are off."""


def refuse_states(hexapod: Hexapod) -> None:
    """Refuse a machine whose legs remember the rows before, where there is one row only."""
    found = active_model(hexapod).states
    if found:
        causes = ", ".join(dict.fromkeys(term.cause for term in found))
        raise ThermalModelError(
            f"the legs' law holds {causes}, which depends on what was before: a pose and temperatures do not tell it. "
            "Use hexapod.leg_controllers(), row by row; or 'hexathermal correct' with time_s; or leave it out "
            "('hexathermal apply --at-rest'; dataclasses.replace(hexapod, thermal=hexapod.thermal.without_states()))"
        )


def between_reversals(hexapod: Hexapod) -> Hexapod:
    """Return the machine in the middle of its legs' backlash: without terms of the direction of the last move.

    Budgets are taken there, since a pose does not tell how it was reached; half the step either way is a source
    (`hexathermal.predict.budget_defaults`). Terms that remember more are left, and are refused where they are met.
    """
    model = hexapod.thermal
    if model is None or not any(term.shape == DIRECTION for term in model.states):
        return hexapod
    if "between reversals" not in hexapod._prepared:
        legs = tuple(
            replace(law, terms=tuple(term for term in law.terms if term.shape != DIRECTION)) for law in model.legs
        )
        hexapod._prepared["between reversals"] = replace(hexapod, thermal=replace(model, legs=legs))
    found: Hexapod = hexapod._prepared["between reversals"]
    return found


def machine_memories(hexapod: Hexapod) -> list[LegMemory]:
    """Return the memories that the legs of a machine begin with."""
    return [LegMemory(law.terms) for law in active_model(hexapod).legs]


def leg_signals(
    hexapod: Hexapod, leg: int, lengths: FloatArray, dT: FloatArray, time: FloatArray | None = None,
    inputs: Mapping[str, FloatArray] | None = None,
) -> LegSignals:  # fmt: skip
    """Return the signals of leg 0 to 5 at commanded lengths (n, 6) [m] and temperatures since the reference (n, s)."""
    model = active_model(hexapod)
    own = dict(zip(model.legs[leg].sensors, dT[:, model.columns_of_leg[leg]].T, strict=True))
    q = hexapod.strokes(lengths)[:, leg]
    zero = dict(zip(own, model.reference_temperature_degC[model.columns_of_leg[leg]].tolist(), strict=True))
    assert hexapod.retracted_length is not None  # a thermal law asks for it
    q0 = float(hexapod.retracted_length[leg])
    return LegSignals(np.zeros(len(q)) if time is None else time, own, q, q0, inputs=inputs or {}, zero_degC=zero)


def added_drift(
    hexapod: Hexapod, lengths: FloatArray, dT: FloatArray, time: FloatArray | None = None,
    memories: Sequence[LegMemory] | None = None, inputs: Mapping[str, FloatArray] | None = None,
) -> FloatArray:  # fmt: skip
    """Return what terms add to the drift of six legs, shape (n, 6) [m].

    Parameters
    ----------
    hexapod : Hexapod
    lengths : array, shape (n, 6) [m]
        Commanded.
    dT : array, shape (n, s) [K]
        Of all sensors, since the reference.
    time : array, shape (n,) [s], optional
    memories : sequence of LegMemory, optional
        Of the rows before; they go on. Without it rows stand by themselves, and only terms without a state are told.
    inputs : mapping, optional
        Recorded inputs, shape (n,).

    Raises
    ------
    ThermalModelError
        A term has a state, and there are no memories.
    """
    if memories is None:
        refuse_states(hexapod)
    added = np.zeros((len(lengths), 6))
    if not len(lengths):
        return added
    for leg, law in enumerate(active_model(hexapod).legs):
        if law.terms:
            signals = leg_signals(hexapod, leg, lengths, dT, time, inputs)
            memory = LegMemory(law.terms) if memories is None else memories[leg]
            memory.count_from_retracted(law.terms, signals)
            added[:, leg] = terms_drift(law.terms, signals, memory)
    return added


def deviated_drift(
    hexapod: Hexapod, told: FloatArray, dT: FloatArray, lag: FloatArray, x: FloatArray
) -> FloatArray | float:
    """Return what terms add to the drift of legs that deviate, shape (m, 6) [m]; 0 without terms.

    Thermometers and the terms' own amplitudes may be off.

    True temperatures are those of `hexathermal.kinematics.draws_loops.true_machine`.

    Parameters
    ----------
    hexapod : Hexapod
    told : array, shape (6,) [m]
    dT, lag : array, shape (s,) [K]
        Reading minus reference, and minus the air.
    x : array, shape (m, size)
        Deviations, see `hexathermal.predict.budget_blocks`.
    """
    if not active_model(hexapod).has_terms:
        return 0.0
    off, gain, contact, reference = (x[:, blocks(hexapod, quantity)[0]] for quantity in OF_TEMPERATURES)
    true = dT * (1.0 + gain) + contact * lag + off - reference
    lengths = np.broadcast_to(told, (len(x), 6))
    added, wrong = added_drift(hexapod, lengths, true), x[:, blocks(hexapod, "amplitudes")[0]]
    first = 0
    for leg, law in enumerate(active_model(hexapod).legs):
        if law.terms:
            signals, memory = leg_signals(hexapod, leg, lengths, true), LegMemory(law.terms)
            memory.count_from_retracted(law.terms, signals)
            columns = terms_columns(law.terms, signals, memory)
            added[:, leg] += (columns * wrong[:, first : first + columns.shape[1]]).sum(axis=1)
            first += columns.shape[1]
    return added


def deviated_rates(hexapod: Hexapod, told: FloatArray, dT: FloatArray, lag: FloatArray) -> FloatArray | float:
    """Return the derivatives of `deviated_drift` for each deviation, shape (6, size); 0 without terms.

    Terms without a state are of second degree in temperatures at most, and linear in their amplitudes: differences
    about the middle are exact.
    """
    if not active_model(hexapod).has_terms:
        return 0.0
    chosen = np.concatenate([blocks(hexapod, quantity)[0] for quantity in (*OF_TEMPERATURES, "amplitudes")])
    size = deviation_size(hexapod)
    steps = np.eye(size)[chosen]
    above, below = (deviated_drift(hexapod, told, dT, lag, sign * steps) for sign in (1.0, -1.0))
    rates = np.zeros((6, size))
    rates[:, chosen] = np.transpose(0.5 * (above - below))
    return rates
