"""Names of what can be limited, and their values at one pose.

Lengths are in micrometres in a specification, turns in microradians; both are SI here.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from hexathermal.poses import FloatArray
from hexathermal.predict.acceptance.environmental_variation import WarmUpDistortion
from hexathermal.predict.acceptance.pose_accuracy import PoseAccuracy, PoseDrift

SHIFTS, TURNS = ("x", "y", "z"), ("rx", "ry", "rz")
ANGLES = tuple(f"angle_{turn}" for turn in TURNS)
AXES = (*SHIFTS, *TURNS, *ANGLES)
"""Shifts along axes, turns about axes (rotation vector), differences of the angles of coordinates (ISO: a, b, c)."""

ACCURACY, DRIFT, ETVE, WARM_UP = "accuracy", "drift", "ETVE", "warm-up"
"""Families: what a quantity is made of."""


@dataclass(frozen=True)
class Quantity:
    """Something that can be limited.

    Attributes
    ----------
    name : str
        As ``AP`` or ``ETVE_rx``.
    unit : str
        ``um`` or ``urad``, of files and tables.
    family : str
    signed : bool
        Whether it may be negative: it is then limited on both sides.
    """

    name: str
    unit: str
    family: str
    signed: bool

    @property
    def key(self) -> str:
        """Name with its unit, as in files."""
        return f"{self.name}_{self.unit}"

    @property
    def axis(self) -> str:
        """Axis of the name, one of `AXES`; empty where it has none."""
        return self.name.partition("_")[2]

    def sensitivity(self, count: int) -> float:
        """Return how many times the standard uncertainty of a measured coordinate the quantity may be uncertain.

        A bound, whichever part of it the measurements have in common: a mean is taken as fully common (1), a
        difference as independent (sqrt 2).  ``RP = mean l + 3 S`` of n independent visits changes by ``1 / n +
        3 (l_j - mean l) / ((n - 1) S)`` with each distance, together by at most ``sqrt(1 / n + 9 / (n - 1))``.
        """
        spread = math.sqrt(1.0 / count + 9.0 / (count - 1)) if count > 1 else math.inf
        factor = spread if "RP" in self.name else 1.0
        return factor if self.family == ACCURACY else math.sqrt(2.0) * factor


def _all() -> dict[str, Quantity]:
    """Return every quantity by its key."""
    found = []

    def add(stem: str, axes: tuple[str, ...], family: str, signed: bool) -> None:
        for axis in axes:
            unit = "um" if axis in ("", *SHIFTS) else "urad"
            found.append(Quantity(f"{stem}_{axis}" if axis else stem, unit, family, signed))

    add("AP", ("",), ACCURACY, False)
    add("AP", AXES, ACCURACY, True)
    add("AP", ("rotation",), ACCURACY, False)
    add("RP", ("", "rotation", *TURNS, *ANGLES), ACCURACY, False)
    add("dAP", ("", *AXES), DRIFT, False)
    add("dRP", ("", *TURNS, *ANGLES), DRIFT, False)
    add("shift", ("",), DRIFT, False)
    add("ETVE", AXES, ETVE, False)
    add("d60", AXES, WARM_UP, True)
    add("dt", AXES, WARM_UP, True)
    return {item.key: item for item in found}


QUANTITIES: dict[str, Quantity] = _all()
"""Every quantity by its key, as ``AP_um``."""


def _by_axis(stem: str, axes: tuple[str, ...], values: FloatArray) -> dict[str, float]:
    """Return components by name."""
    return {f"{stem}_{axis}": float(value) for axis, value in zip(axes, values, strict=True)}


def _component(field: str, k: int) -> Callable[[PoseAccuracy], float]:
    """Return what takes one component of a field."""
    return lambda found: float(getattr(found, field)[k])


def _components(stem: str, axes: tuple[str, ...], field: str) -> dict[str, Callable[[PoseAccuracy], float]]:
    """Return what takes each component of a field, by name."""
    return {f"{stem}_{axis}": _component(field, k) for k, axis in enumerate(axes)}


ACCURACY_VALUES: dict[str, Callable[[PoseAccuracy], float]] = {
    "AP": lambda found: found.AP,
    **_components("AP", SHIFTS, "position"),
    "AP_rotation": lambda found: found.AP_rotation,
    **_components("AP", TURNS, "rotation"),
    **_components("AP", ANGLES, "angles"),
    "RP": lambda found: found.RP,
    "RP_rotation": lambda found: found.RP_rotation,
    **_components("RP", TURNS, "RP_axes"),
    **_components("RP", ANGLES, "RP_angles"),
}
"""Pose accuracy and repeatability by the names of quantities."""


def accuracy_values(found: PoseAccuracy) -> dict[str, float]:
    """Return pose accuracy and repeatability by the names of quantities."""
    return {name: value(found) for name, value in ACCURACY_VALUES.items()}


def drift_values(found: PoseDrift) -> dict[str, float]:
    """Return drift by the names of quantities."""
    return {
        "dAP": found.dAP,
        **_by_axis("dAP", SHIFTS, found.dAP_axes),
        **_by_axis("dAP", TURNS, found.dAP_rotations),
        **_by_axis("dAP", ANGLES, found.dAP_angles),
        "dRP": found.dRP,
        **_by_axis("dRP", TURNS, found.dRP_rotations),
        **_by_axis("dRP", ANGLES, found.dRP_angles),
        "shift": found.shift,
    }


WARM_UP_VALUES: dict[str, Callable[[WarmUpDistortion], float]] = {
    "d60": lambda found: found.d_60,
    "dt": lambda found: found.d_t,
}
"""Stems of names and what they mean."""
