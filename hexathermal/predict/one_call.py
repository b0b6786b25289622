"""The main job in one call, for a machine or the name of one."""

from __future__ import annotations

from hexathermal.machine.hexapod import Hexapod
from hexathermal.machine.library import load_hexapod
from hexathermal.machine.thermal import TemperaturesLike
from hexathermal.poses import FloatArray, PoseLike


def corrected_leg_lengths(pose: PoseLike, temps: TemperaturesLike, hexapod: Hexapod | str = "reference") -> FloatArray:
    """Return the leg lengths to command at a pose and temperatures, in one call.

    See `hexathermal.predict.correction.corrected_leg_lengths`; `hexapod` is a machine, or the name or path of one.

    Examples
    --------
    >>> import hexathermal as ht
    >>> ht.corrected_leg_lengths(ht.load_hexapod("reference").home, [21.5] * 6).shape
    (6,)
    """
    machine = hexapod if isinstance(hexapod, Hexapod) else load_hexapod(hexapod)
    return machine.corrected_leg_lengths(pose, temps)
