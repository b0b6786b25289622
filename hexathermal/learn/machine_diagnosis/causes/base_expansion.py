"""The base grows otherwise than the machine says.

``y_i = dalpha_b dT_b (u_i . b_i)`` (paper, eq. 1): one parameter, the change of its expansion.
"""

from __future__ import annotations

from hexathermal.learn.diagnosis.trials import Cause, Parameter
from hexathermal.learn.machine_diagnosis.candidate import Candidate
from hexathermal.learn.machine_diagnosis.plates import plate_candidates
from hexathermal.learn.machine_diagnosis.view import MachineView

CAUSE = Cause(
    name="base-expansion",
    physics="The base expands with its own temperature: the machine says nothing of it, or a wrong coefficient.",
    signature="All legs look wrong in proportion to the base's temperature, the more the more they lean.",
    parameters=(Parameter("expansion_change_per_K", "1/K", "0, 5 um/m/K"),),
    confused_with=("platform-expansion", "leg-coefficient", "tracker-drift"),
    experiment="Warm the base alone, and measure at poses tilted and shifted to both sides.",
    words="the base expands otherwise than the machine says",
)


def candidates(view: MachineView) -> list[Candidate]:
    """Give the base, where its temperature is recorded and moves."""
    return plate_candidates(view, CAUSE.name, "base")
