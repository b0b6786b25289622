"""A leg stops in another place when it comes from the other side.

``y_i = a s_i / 2``, where ``s_i`` is +1 or -1, the direction of the leg's last move (shape ``direction`` of
`hexathermal.machine.leg_terms`), or goes from one to the other within a way that is tried at several values: one
parameter, the whole step at a reversal. Each run begins with no direction.
"""

from __future__ import annotations

import numpy as np

from hexathermal.learn.diagnosis.trials import Cause, Parameter
from hexathermal.learn.machine_diagnosis.candidate import Candidate
from hexathermal.learn.machine_diagnosis.leg_terms import term_candidate
from hexathermal.learn.machine_diagnosis.view import MachineView

PLAYS_M = (0.0, 30e-6, 60e-6, 120e-6, 240e-6, 480e-6)
"""Ways of the rod in which a reversal becomes whole; 0: at once."""

CAUSE = Cause(
    name="leg-backlash",
    physics="Play between screw and nut of a leg, or friction in its guide.",
    signature="A step of constant size in one leg at each reversal of it, at any temperature.",
    parameters=(Parameter("step", "m", "0, 1 um"),),
    confused_with=("creep", "scale-error"),
    experiment="Approach the same poses from both sides, twenty times, without warming.",
    words="{target} stops in another place when it comes from the other side",
)


def candidates(view: MachineView) -> list[Candidate]:
    """Give each leg that moves."""
    found = [
        term_candidate(view, CAUSE.name, leg, "direction", ("step",), ("m",), {"play_m": play} if play else {})
        for leg in range(6)
        for play in PLAYS_M
    ]
    return [one for one in found if np.ptp(one.columns)]
