"""Legs give way under a load that the machine does not know.

The weight ``w = m g`` at the centre ``c`` of the platform is held by axial pushes ``F`` of the legs, and each leg of
compliance ``k`` becomes shorter by ``k F_i``: ``y_i = -k F_i``. The forces of the static balance
(`hexathermal.kinematics.statics`), ``J' F = -[w, R c x w]``, are linear in ``w`` and ``w c``, so that sag is linear in
``k m g`` and ``k m g c``: four parameters, of which none depends on a temperature.
"""

from __future__ import annotations

import numpy as np

from hexathermal.kinematics.statics import leg_forces
from hexathermal.learn.diagnosis.trials import Cause, Parameter
from hexathermal.learn.machine_diagnosis.candidate import Candidate
from hexathermal.learn.machine_diagnosis.view import MachineView
from hexathermal.machine.compliance import STANDARD_GRAVITY

USUAL_SAG = 3e-6
"""Sag of one leg that carried the whole load alone [m]."""

USUAL_CENTRE = 0.5
"""Prior of the load's centre, over the mean radius of the platform's joints."""

CAUSE = Cause(
    name="payload-compliance",
    physics="A payload presses on the legs, and each gives way by its force times its compliance.",
    signature="An error that depends on the pose alone, at any temperature, largest where a leg carries most.",
    parameters=(
        Parameter("sag", "m", "0, 3 um: compliance times weight"),
        Parameter("sag_times_x", "m^2", "0, the sag times half the platform's radius"),
        Parameter("sag_times_y", "m^2", "0, the sag times half the platform's radius"),
        Parameter("sag_times_z", "m^2", "0, the sag times half the platform's radius"),
    ),
    confused_with=("joint-offset", "scale-error"),
    experiment="Take the payload off, or double it, at constant temperature, and measure the same poses again.",
    words="the legs sag under a load that the machine does not know",
)


def candidates(view: MachineView) -> list[Candidate]:
    """Give one load, its centre free."""
    stated = view.hexapod.compliance
    g = np.array(STANDARD_GRAVITY) if stated is None else stated.gravity
    size = float(np.linalg.norm(g))
    if not size > 0.0:
        return []
    down, poses = g / size, view.poses
    middle = leg_forces(view.hexapod, poses, down, np.zeros(3))
    each = [leg_forces(view.hexapod, poses, down, axis) - middle for axis in np.eye(3)]
    columns = -np.stack([middle, *each], axis=-1)
    arm = USUAL_CENTRE * float(np.linalg.norm(view.hexapod.platform_joints, axis=1).mean())
    names = ("sag", "sag_times_x", "sag_times_y", "sag_times_z")
    return [Candidate(CAUSE.name, None, names, ("m", "m^2", "m^2", "m^2"), columns,
                      USUAL_SAG * np.array([1.0, arm, arm, arm]), np.zeros(4))]  # fmt: skip
