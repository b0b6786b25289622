"""One leg expands otherwise than its law says.

``y_i = q0 dA_s dT_is + q_i dB_s dT_is`` (paper, eq. 4) for each thermometer s of leg i: two parameters a thermometer.
"""

from __future__ import annotations

import numpy as np

from hexathermal.learn.diagnosis.trials import Cause, Parameter
from hexathermal.learn.machine_diagnosis.candidate import Candidate
from hexathermal.learn.machine_diagnosis.view import MachineView

USUAL = 0.3
LEAST_PER_K = 3e-7
"""Prior of a change: 30 % of the law's coefficient, and at least this."""

CAUSE = Cause(
    name="leg-coefficient",
    physics="The leg's material, its thermometer's place or its bench campaign differ from what the law was made of.",
    signature="One leg is too long in proportion to its own temperature, retracted or not.",
    parameters=(
        Parameter("A_change_per_K", "1/K", "0, 30 % of A and at least 0.3 um/m/K"),
        Parameter("B_change_per_K", "1/K", "0, 30 % of A and at least 0.3 um/m/K"),
    ),
    confused_with=("swapped-legs", "platform-expansion", "base-expansion", "thermal-lag"),
    experiment="Warm this leg alone by a few kelvin, and measure with it retracted and extended.",
    words="{target} expands otherwise than its law says",
)


def candidates(view: MachineView) -> list[Candidate]:
    """Give each leg, with all its thermometers."""
    found = []
    for leg in range(6):
        used = np.flatnonzero(view.laws[leg].any(axis=0))
        heat = view.heat[:, leg, used]
        if not heat.any():
            continue
        columns = np.zeros((len(view), 6, 2 * len(used)))
        columns[:, leg, 0::2] = view.retracted[leg] * heat
        columns[:, leg, 1::2] = view.q[:, leg, None] * heat
        names = [view.sensors[k] for k in used]
        words = [f"{letter}_change_per_K" + (f"_{name}" if len(names) > 1 else "") for name in names for letter in "AB"]
        size = float(np.maximum(USUAL * np.abs(view.laws[leg, 0, used]).sum(), LEAST_PER_K))
        found.append(Candidate(CAUSE.name, f"leg{leg + 1}", tuple(words), ("1/K",) * len(words), columns,
                               np.full(len(words), size), np.zeros(len(words)), {"sensors": tuple(names)}))  # fmt: skip
    return found
