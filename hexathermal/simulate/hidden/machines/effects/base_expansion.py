"""The base grows otherwise than its file says: its joints move away from the origin of its frame, or towards it."""

from __future__ import annotations

from functools import partial

from hexathermal.simulate.hidden.machines.effect import MachineEffect
from hexathermal.simulate.hidden.machines.plates import draw_growth, grow, plate_recorded

EFFECT = MachineEffect(
    "base-expansion", partial(draw_growth, "base"), grow, partial(plate_recorded, "base"), "expansion",
    (1e-10, 2e-4),
)  # fmt: skip
