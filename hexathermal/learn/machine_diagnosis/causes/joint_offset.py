"""A joint sits elsewhere than the machine's drawing says.

A base joint at ``b_i + d`` makes ``y_i = u_i . d``, a platform joint at ``p_i + d`` makes ``y_i = -u_i . R d``: three
parameters, the offset in the plate's own axes. Along the leg the two look alike, and like a wrong zero of its scale;
only where poses turn the leg against base and platform can they be told apart.
"""

from __future__ import annotations

import numpy as np

from hexathermal.learn.diagnosis.trials import Cause, Parameter
from hexathermal.learn.machine_diagnosis.candidate import Candidate
from hexathermal.learn.machine_diagnosis.view import MachineView

USUAL_OFFSET = 10e-6

CAUSE = Cause(
    name="joint-offset",
    physics="A joint was mounted, or has moved, off the place that the kinematic model has for it.",
    signature="One leg is wrong by an amount that depends on its direction alone, at any temperature, from the start.",
    parameters=(
        Parameter("offset_x", "m", "0, 10 um"),
        Parameter("offset_y", "m", "0, 10 um"),
        Parameter("offset_z", "m", "0, 10 um"),
    ),
    confused_with=("payload-compliance", "scale-error"),
    experiment="Measure at constant temperature at poses turned and shifted as far as they go, about all axes.",
    words="{target} sits elsewhere than the machine says",
)


def candidates(view: MachineView) -> list[Candidate]:
    """Give the twelve joints."""
    found = []
    for part in ("base", "platform"):
        own = view.directions
        if part == "platform":
            own = -np.einsum("nij,nli->nlj", view.poses[:, :3, :3], view.directions)
        for leg in range(6):
            columns = np.zeros((len(view), 6, 3))
            columns[:, leg] = own[:, leg]
            found.append(Candidate(CAUSE.name, f"{part} joint {leg + 1}", ("offset_x", "offset_y", "offset_z"),
                                   ("m",) * 3, columns, np.full(3, USUAL_OFFSET), np.zeros(3)))  # fmt: skip
    return found
