"""hexathermal: Gough-Stewart hexapods when heat moves their platform.

``pose -> leg lengths -> thermal correction of each leg -> forward kinematics -> Cartesian error``

>>> import hexathermal as ht
>>> hexapod = ht.load_hexapod("reference")
>>> pose = ht.pose_from_coordinates([5, 0, 12, 0, 1.5, 0])       # mm, deg
>>> hexapod.corrected_leg_lengths(pose, [21.5] * 6).shape        # degC, one thermometer a leg
(6,)
"""

from hexathermal.errors import HexathermalError
from hexathermal.kinematics.forward import ForwardResult, ForwardStatus
from hexathermal.machine import ports as _ports
from hexathermal.machine.bodies import Bodies, PoseLimits
from hexathermal.machine.hexapod import Hexapod
from hexathermal.machine.library import bundled_hexapods, load_hexapod
from hexathermal.machine.thermal import LegLaw, PlateLaw, ThermalModel
from hexathermal.machine.writing import write_hexapod
from hexathermal.poses import Frames, coordinates_from_pose, pose_from_coordinates
from hexathermal.predict import answers as _answers
from hexathermal.predict.one_call import corrected_leg_lengths

_ports.install(Hexapod, _answers)

__version__ = "0.1.0"

__all__ = [
    "Bodies",
    "ForwardResult",
    "ForwardStatus",
    "Frames",
    "Hexapod",
    "HexathermalError",
    "LegLaw",
    "PlateLaw",
    "PoseLimits",
    "ThermalModel",
    "bundled_hexapods",
    "coordinates_from_pose",
    "corrected_leg_lengths",
    "load_hexapod",
    "pose_from_coordinates",
    "write_hexapod",
]
