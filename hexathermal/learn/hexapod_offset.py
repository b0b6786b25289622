"""Measured poses that lie further from what the scales say than heat can move a platform."""

from __future__ import annotations

import numpy as np

from hexathermal.kinematics.forward import forward_kinematics
from hexathermal.learn.hexapod_data import HexapodRows
from hexathermal.predict.pose_errors import pose_errors

FAR = 1e-3
"""Part of the machine's legs, and turn [rad], that no heat moves a platform by: 40 K at 25 um/m/K."""

HOME_PART = 0.01
"""Part of home's distance within which an offset is taken for home itself."""


def far_poses(rows: HexapodRows) -> list[str]:
    """Return a note where measured poses lie in another frame than commanded ones, else nothing.

    Parameters
    ----------
    rows : HexapodRows
    """
    apart = pose_errors(forward_kinematics(rows.hexapod, rows.retracted + rows.q), rows.measured)
    offset = np.median(apart, axis=0)
    shift, turn = float(np.linalg.norm(offset[:3])), float(np.linalg.norm(offset[3:]))
    if shift <= FAR * float(rows.hexapod.home_lengths.mean()) and turn <= FAR:
        return []
    home = rows.hexapod.home[:3, 3]
    if np.linalg.norm(offset[:3] - home) <= HOME_PART * np.linalg.norm(home):
        why = "That is home: measured poses must count from home, as commanded ones do."
    else:
        why = "Another frame, unit or convention of the angles?"
    return [
        f"measured poses lie {shift * 1e3:.4g} mm and {turn * 1e3:.3g} mrad (medians) from those that the scales say, "
        f"further than heat moves a platform. {why} Errors before and after correction hold it; laws do not, where the "
        "frame is free"
    ]
