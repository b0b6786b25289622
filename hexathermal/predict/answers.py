"""The functions behind the methods of `Hexapod`, gathered for `hexathermal.machine.ports`."""

from __future__ import annotations

from hexathermal.kinematics.forward import forward_kinematics, solve_forward
from hexathermal.kinematics.inverse import inverse_kinematics
from hexathermal.kinematics.jacobian import jacobian
from hexathermal.kinematics.postures import assembly_modes
from hexathermal.predict.budget import error_budget
from hexathermal.predict.correction import corrected_leg_lengths, corrected_pose, leg_drift, predicted_pose
from hexathermal.predict.leg_states import leg_controllers

__all__ = [
    "assembly_modes",
    "corrected_leg_lengths",
    "corrected_pose",
    "error_budget",
    "forward_kinematics",
    "inverse_kinematics",
    "jacobian",
    "leg_controllers",
    "leg_drift",
    "predicted_pose",
    "solve_forward",
]
