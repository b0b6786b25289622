"""A controller that takes poses only: send it the corrected pose, in the frames it speaks."""

from __future__ import annotations

import numpy as np

import hexathermal as ht


def main() -> None:
    """Bring a tool point to a user pose on a warm machine through a controller without thermal correction."""
    hexapod = ht.load_hexapod("reference")
    frames = ht.Frames(user=[0, 0, 250, 0, 0, 30], object=[0, 0, 120, 0, 0, 0])  # mm, deg
    wanted = ht.pose_from_coordinates([10, -5, -120, 0.5, 0, -30])  # the object in the user frame
    temps = dict(zip(hexapod.sensor_names, [22.1, 22.4, 23.0, 23.8, 23.1, 22.5], strict=True))

    pose = frames.machine_pose(wanted)
    sent = hexapod.corrected_pose(pose, temps)
    coordinates = ht.coordinates_from_pose(sent, hexapod=hexapod)
    print("send [mm, deg]:", ", ".join(f"{value:.5f}" for value in coordinates))

    # The controller turns the pose into lengths with its nominal geometry; the warm legs then stand here:
    commanded = hexapod.inverse_kinematics(ht.pose_from_coordinates(coordinates, hexapod=hexapod))
    stands = frames.user_pose(hexapod.predicted_pose(commanded, temps))
    error = np.linalg.norm(stands[:3, 3] - wanted[:3, 3]) * 1e9
    plain = frames.user_pose(hexapod.predicted_pose(hexapod.inverse_kinematics(pose), temps))
    before = np.linalg.norm(plain[:3, 3] - wanted[:3, 3]) * 1e6
    print(f"tool point off by {error:.4f} nm; without correction {before:.2f} um")


if __name__ == "__main__":
    main()
