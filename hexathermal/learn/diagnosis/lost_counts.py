"""Steps of single beams that cleaning took back: jumps of the zero that the residual does not show any more.

A beam that loses count steps alone, within one row, by z times what the beams part by there (`BeamStep`); at a movement
tilt may, now and then. Looked for in each of n rows of three beams, its log evidence is ``1/2 z^2 - log(3 n)``.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hexathermal.learn.cleaning_record import BeamStep
from hexathermal.learn.diagnosis.causes.zero_jump import CAUSE
from hexathermal.learn.diagnosis.deciding import SOUND
from hexathermal.learn.diagnosis.evidence import visible
from hexathermal.learn.diagnosis.result import Candidate, Effect, Quantity
from hexathermal.learn.diagnosis.stage import Stage
from hexathermal.learn.diagnosis.view import View
from hexathermal.learn.diagnosis.words import UM, told, two_digits
from hexathermal.poses import FloatArray

BEAMS = 3

SURE = 8.0
"""Least z of a step at a movement. Of 549 simulated campaigns of five authors two had one that was none, of 6 and 7."""

SEEN = 0.2
"""A jump is named that the drift would show with so much of its noise, RMS beside the law."""


@dataclass(frozen=True, eq=False)
class LostCount:
    """Beams that lost count.

    Attributes
    ----------
    effect : Effect
    evidence : float
    spread : float [m]
        Standard uncertainty of what would be visible.
    """

    effect: Effect
    evidence: float
    spread: float

    @property
    def candidate(self) -> Candidate:
        """Its line in the ranking."""
        one = self.effect
        settings = dict(one.settings) | {name: own.value for name, own in one.parameters.items()}
        return Candidate(one.cause, one.target, self.evidence, one.probability, one.visible, settings, self.spread)


def lost_count(stage: Stage) -> LostCount | None:
    """Return what beams that lost count did to the drift; None where it would not have shown them.

    Parameters
    ----------
    stage : Stage
        Before anything joined the law.
    """
    view = stage.view
    steps = _steps(view)
    if not steps:
        return None
    # a third of each is in the mean of the beams
    shares, errors = (np.array([getattr(step, name) / BEAMS for step, _k in steps]) for name in ("size", "error"))
    columns = np.column_stack([view.step_at(k, step.time) for step, k in steps])
    law = stage.base.hiding[:, : stage.base.plain]
    seen, apart = float(visible((columns @ shares)[:, None], law)[0]), visible(columns, law)
    if seen < SEEN * stage.levels.rms:
        return None
    tries = BEAMS * sum(len(rows.signals.time) for rows in view.runs)
    evidence = float(np.maximum(0.5 * (shares / errors) ** 2 - np.log(tries), 0.0).sum())
    return LostCount(_effect(view, shares, errors, seen), evidence, float(np.linalg.norm(apart * errors)))


def _steps(view: View) -> list[tuple[BeamStep, int]]:
    """Return the steps that no tilt makes, each with its run."""
    return [(step, k) for k, rows in enumerate(view.runs) for step in rows.record.beam_steps
            if step.at_rest or abs(step.size) >= SURE * step.error]  # fmt: skip


def _effect(view: View, shares: FloatArray, errors: FloatArray, seen: float) -> Effect:
    """Return the jumps as one effect, told by the largest of them."""
    steps, at = _steps(view), int(np.argmax(np.abs(shares)))
    step, rows = steps[at][0], view.runs[steps[at][1]]
    beam, moment = step.channel.removesuffix("_mm"), float(rows.signals.time[0]) + step.time
    parameters = {
        "time_s": Quantity(moment, float(rows.record.sampling), "s"),
        "step_um": Quantity(float(shares[at]) * UM, float(errors[at]) * UM, "um"),
    }
    told_of = f"at {told(parameters['time_s'])}; step of the drift {told(parameters['step_um'])}"
    more = "" if len(steps) == 1 else f"; the largest of {len(steps)}"
    sentence = (
        f"Cleaning took back a {CAUSE.name} (in {rows.run.name}; {told_of}{more}): {beam} alone lost count; "
        f"{two_digits(seen * UM)} um of it would stay visible when the law is refitted."
    )
    return Effect(CAUSE.name, beam, parameters, {"run": rows.run.name}, SOUND, (), seen, sentence, joined=False,
                  taken_back=True)  # fmt: skip
