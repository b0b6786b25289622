"""A controller that takes poses only: send it the corrected pose, in the user and object frames that it speaks.

Where the package symetrie-hexapod (PyPI, MIT) is installed, its simulator of a SYMETRIE controller takes the command
and says where it went. It asks for PyQt5 (GPL), which its simulator does not need: see the README beside this file.
"""

from __future__ import annotations

import logging
import warnings
from importlib import import_module

import numpy as np

import hexathermal as ht
from hexathermal.poses import FloatArray

USER = [0.0, 0.0, 250.0, 0.0, 0.0, 30.0]
"""User frame in the machine frame [mm, deg]."""
OBJECT = [0.0, 0.0, 120.0, 0.0, 0.0, 0.0]
"""Object frame in the platform frame: the tool point [mm, deg]."""


def simulated_controller(hexapod: ht.Hexapod, command: FloatArray) -> FloatArray | None:
    """Return the machine pose to which the simulated controller goes, None where it is not installed."""
    logging.disable(logging.WARNING)  # it tells every step
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # it asks for settings of its laboratory
            controller = import_module("egse.hexapod.symetrie.hexapod").HexapodSimulator()
        controller.homing()
        controller.configure_coordinates_systems(*USER, *OBJECT)
        controller.move_absolute(*command)
        assert np.allclose(controller.get_user_positions(), command, rtol=0.0, atol=1e-9)
        return ht.pose_from_coordinates(controller.get_machine_positions(), hexapod=hexapod)
    except ImportError:
        return None
    finally:
        logging.disable(logging.NOTSET)


def main() -> None:
    """Bring a tool point to a user pose on a warm machine whose controller knows no heat."""
    hexapod = ht.load_hexapod("reference")
    frames = ht.Frames(user=USER, object=OBJECT)
    wanted = ht.pose_from_coordinates([10, -5, -120, 0.5, 0, -30])  # the object in the user frame
    temps = dict(zip(hexapod.sensor_names, [22.1, 22.4, 23.0, 23.8, 23.1, 22.5], strict=True))

    # machine poses count from home on such controllers: user -> machine, correct, and back to the user frame
    pose = hexapod.home @ frames.machine_pose(wanted)
    corrected = hexapod.corrected_pose(pose, temps)
    command = ht.coordinates_from_pose(frames.user_pose(np.linalg.inv(hexapod.home) @ corrected))
    print("send [mm, deg]:", ", ".join(f"{value:.5f}" for value in command))

    # what a controller makes of it: its frames, then lengths by its nominal geometry
    own = hexapod.home @ frames.machine_pose(ht.pose_from_coordinates(command))
    theirs = simulated_controller(hexapod, command)
    if theirs is None:
        print("simulator of symetrie-hexapod: not installed; the frames of this package stand for the controller")
    else:
        print(f"simulator of symetrie-hexapod: its pose is ours to {np.abs(theirs - own).max() * 1e9:.1g} nm and nrad")
    told = hexapod.inverse_kinematics(own if theirs is None else theirs)

    def off(lengths: FloatArray) -> float:
        """Return how far off the tool point stands [m], the legs being warm."""
        stands = frames.user_pose(np.linalg.inv(hexapod.home) @ hexapod.predicted_pose(lengths, temps))
        return float(np.linalg.norm(stands[:3, 3] - wanted[:3, 3]))

    plain = off(hexapod.inverse_kinematics(pose))
    print(f"tool point off by {off(told) * 1e9:.1g} nm; without correction {plain * 1e6:.2f} um")


if __name__ == "__main__":
    main()
