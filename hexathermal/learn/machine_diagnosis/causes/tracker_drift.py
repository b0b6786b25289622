"""The frame of the measuring system moves with the room.

The same rigid motion ``[v, w] dT`` about home is in every measured pose, whatever the pose:
``y_i = [J (v + w x (t - h), w)]_i dT`` with the temperature of the air, at once or behind a low pass, or of a plate on
which the tracker stands: six parameters.
"""

from __future__ import annotations

import numpy as np

from hexathermal.learn.diagnosis.trials import Cause, Parameter
from hexathermal.learn.hexapod_data import AIR, PLATES
from hexathermal.learn.machine_diagnosis.candidate import Candidate
from hexathermal.learn.machine_diagnosis.view import MachineView
from hexathermal.machine.measuring_frame import MeasuringFrame
from hexathermal.poses import FloatArray

USUAL_SHIFT_PER_K = 0.5e-6
USUAL_TURN_PER_K = 1e-6

LAGS_S = (0.0, 300.0, 900.0, 2700.0)
"""Time constants with which a frame may follow the air [s]."""

AXES = "xyz"

CAUSE = Cause(
    name="tracker-drift",
    physics="The tracker, its stand or the floor move with the temperature of the room; the machine does not.",
    signature="All measured poses move together as a rigid body, in proportion to a temperature of the room.",
    parameters=tuple(Parameter(f"shift_{axis}_per_K", "m/K", "0, 0.5 um/K") for axis in AXES)
    + tuple(Parameter(f"turn_{axis}_per_K", "rad/K", "0, 1 urad/K") for axis in AXES),
    confused_with=("platform-expansion", "base-expansion", "leg-coefficient"),
    experiment="Measure fixed marks beside the machine along with the platform while the room warms.",
    words="the measuring frame moves with {target}",
)


def candidates(view: MachineView) -> list[Candidate]:
    """Give the air, and the plates' thermometers; where the machine states a frame, what that follows alone."""
    stated = view.hexapod.measuring_frame
    return [
        following(view, sensor, tau)
        for sensor, heat in _followed(view).items()
        if np.isfinite(heat).all() and np.ptp(heat) > 0.0
        if stated is None or sensor == stated.sensor
        for tau in _lags(sensor, stated)
    ]


def _lags(sensor: str, stated: MeasuringFrame | None) -> tuple[float, ...]:
    """Return the time constants that are tried [s]."""
    if stated is not None:
        return (stated.time_constant,)
    return LAGS_S if sensor == AIR else LAGS_S[:1]


def following(view: MachineView, sensor: str, time_constant: float) -> Candidate:
    """Return the frame that follows a thermometer, at once (0) or behind a low pass [s]."""
    heat = _followed(view)[sensor]
    late = view.late(heat, time_constant) if time_constant else heat
    names = tuple(f"{word}_{axis}_per_K" for word in ("shift", "turn") for axis in AXES)
    scale = np.array([USUAL_SHIFT_PER_K] * 3 + [USUAL_TURN_PER_K] * 3)
    settings = {"time_constant_s": time_constant} if time_constant else {}
    return Candidate(CAUSE.name, sensor, names, ("m/K",) * 3 + ("rad/K",) * 3, view.frame * late[:, None, None], scale,
                     np.zeros(6), settings)  # fmt: skip


def _followed(view: MachineView) -> dict[str, FloatArray]:
    """Return temperatures that a frame may follow, by the names of their thermometers."""
    followed = {AIR: view.air}
    for k, part in enumerate(PLATES):
        sensor = view.plate_sensors[k]
        if sensor is not None:
            followed[sensor if sensor.startswith(part) else f"{part}_{sensor}"] = view.plates[:, k]
    return followed
