"""Steps of single beams that cleaning took back: jumps of the zero that the residual does not show any more.

A beam that loses count steps alone, within one row, by z times what the beams part by there (`BeamStep`); at a movement
tilt may, now and then. Looked for in each of n rows of three beams, its log evidence is ``1/2 z^2 - log(3 n)``.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from hexathermal.learn.campaign_columns import BEAMS
from hexathermal.learn.cleaning_record import BeamStep
from hexathermal.learn.diagnosis.beforehand import Beforehand, shown_together
from hexathermal.learn.diagnosis.causes.zero_jump import CAUSE
from hexathermal.learn.diagnosis.deciding import SOUND
from hexathermal.learn.diagnosis.pieces import LONGEST_S
from hexathermal.learn.diagnosis.result import Effect, Quantity
from hexathermal.learn.diagnosis.view import View
from hexathermal.learn.diagnosis.words import UM, told, two_digits
from hexathermal.poses import FloatArray

SURE = 8.0
"""Least z. Of 549 simulated campaigns of five generators two had a step at a movement that was none, of 6 and 7."""

COARSE_M = 1e-10
"""Beams that part by less are recorded in coarser steps than they differ by: a step may be one of the last digit."""

SEEN = 0.2
"""A jump is named that the drift would show with so much of its noise, RMS beside the law."""

TOLD = 4
"""Other steps that are told one by one."""


def lost_count(
    view: View, noise: float, named: Iterable[tuple[str, float]] = (), *, tilting: bool = False
) -> Beforehand | None:
    """Return what beams that lost count did to the drift; None where it would not have shown them.

    Where all runs count from one zero, what cleaning took back in one run stays in those after it: nothing is said.

    Parameters
    ----------
    view : View
        Of all runs, those for validation too: what cleaning took back there, no law would have foretold.
    noise : float [m]
        Of the drift beside the law, RMS.
    named : iterable of (str, float [s])
        Runs and moments of jumps that the residual shows: what is left of a step is no second one.
    tilting : bool
        Whether tilt leaks into the drift: at a movement it then looks like a step of one beam, which tells nothing.
    """
    steps = _steps(view, tuple(named)) if view.zeroed_by_run else []
    steps = [(step, k) for step, k in steps if step.at_rest or not tilting]
    if not steps:
        return None
    # a third of each is in the mean of the beams
    shares, errors = (np.array([getattr(step, name) / len(BEAMS) for step, _k in steps]) for name in ("size", "error"))
    columns = np.column_stack([view.step_at(k, step.time) for step, k in steps])
    seen, spread = shown_together(columns, shares, errors, view.base_columns)
    if seen < SEEN * noise:
        return None
    tries = len(BEAMS) * sum(len(rows.signals.time) for rows in view.runs)
    evidence = float(np.maximum(0.5 * (shares / errors) ** 2 - np.log(tries), 0.0).sum())
    effect = _effect(view, steps, shares, errors, seen)
    return Beforehand(effect, evidence, spread)


def _steps(view: View, named: tuple[tuple[str, float], ...]) -> list[tuple[BeamStep, int]]:
    """Return the steps that neither tilt nor a last digit makes, each with its run: with windows behind them."""
    found = []
    for k, rows in enumerate(view.runs):
        begun = float(rows.signals.time[0])
        for step in rows.record.beam_steps:
            sure = step.error > COARSE_M and abs(step.size) >= SURE * step.error
            told_before = any(run == rows.run.name and abs(begun + step.time - at) < LONGEST_S for run, at in named)
            if sure and not told_before and view.step_at(k, step.time).any():
                found.append((step, k))
    return found


def _effect(
    view: View, steps: list[tuple[BeamStep, int]], shares: FloatArray, errors: FloatArray, seen: float
) -> Effect:
    """Return the jumps as one effect, told by the largest of them."""
    at = int(np.argmax(np.abs(shares)))
    step, rows = steps[at][0], view.runs[steps[at][1]]
    time, beam = rows.signals.time, _beam(step)
    moment = float(time[0]) + step.time
    behind = int(np.clip(np.searchsorted(time, moment - 1e-6), 1, len(time) - 1))
    parameters = {
        "time_s": Quantity(moment, float(time[behind] - time[behind - 1]), "s"),
        "step_um": Quantity(float(shares[at]) * UM, float(errors[at]) * UM, "um"),
    }
    others = [f"{_beam(other)} in {view.runs[run].run.name}" for j, (other, run) in enumerate(steps) if j != at]
    settings: dict[str, Any] = {"run": rows.run.name}
    if others:
        more = [f"{len(others) - TOLD} more"] if len(others) > TOLD else []
        settings["also"] = ", ".join(others[:TOLD] + more)
    sentence = _sentence(rows.run.name, beam, parameters, settings.get("also"), seen)
    return Effect(CAUSE.name, beam, parameters, settings, SOUND, (), seen, sentence, joined=False, taken_back=True)


def _beam(step: BeamStep) -> str:
    """Return the name of a step's beam."""
    return step.channel.removesuffix("_mm")


def _sentence(run: str, beam: str, parameters: dict[str, Quantity], also: str | None, seen: float) -> str:
    """Return the finding in one sentence."""
    inside = f"in {run}; at {told(parameters['time_s'])}; step of the drift {told(parameters['step_um'])}"
    alone, of = ("alone", "it") if also is None else (f"(and {also})", "them together")
    return (
        f"Cleaning took back a {CAUSE.name} ({inside}): {beam} {alone} lost count; {two_digits(seen * UM)} um of {of} "
        "would stay visible when the law is refitted."
    )
