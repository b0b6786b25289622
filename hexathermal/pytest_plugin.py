"""Acceptance tests that read like a sentence: ``assert_pose_accuracy(measured, commanded, AP_um=10, u_um=0.3)``.

The function is a plain one; `pytest_hexathermal` gives it to pytest as a fixture of the same name, and loads this
module only when a test asks for it.

>>> visits = [[0.001, 0, 0, 0, 0, 0], [0.003, 0, 0, 0, 0, 0]]
>>> assert_pose_accuracy(visits, [0] * 6, AP_um=3.0, u_um=0.1).count
2
>>> assert_pose_accuracy(visits, [0] * 6, AP_um=2.1, u_um=0.1)
Traceback (most recent call last):
AssertionError: pose accuracy is not accepted (2 visits, rule iso-14253-1)
  NOT DECIDED  AP = 2.000 um, limit 2.1 um, standard uncertainty 0.1 um, conformance probability 0.8413
    a value up to 1.936 um would pass
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
import pinocchio as pin

from hexathermal.errors import ArgumentError
from hexathermal.poses import FloatArray, pose_array, pose_from_coordinates
from hexathermal.predict.acceptance import PASS, RULES, Decision, PoseAccuracy, decide, pose_accuracy
from hexathermal.predict.acceptance.quantities import QUANTITIES, accuracy_values

PER_UNIT = 1e6


def assert_pose_accuracy(
    measured: Any,
    commanded: Any,
    *,
    AP_um: float | None = None,
    RP_um: float | None = None,
    AP_rotation_urad: float | None = None,
    RP_rotation_urad: float | None = None,
    u_um: float | None = None,
    u_urad: float | None = None,
    rule: str = "iso-14253-1",
    probability: float = 0.95,
    coverage_factor: float = 2.0,
    convention: str = "fixed-xyz",
) -> PoseAccuracy:
    """Assert that the measured visits of one pose meet limits of ISO 9283, their uncertainty counted.

    Parameters
    ----------
    measured : array, shape (n, 6) [mm, deg] or (n, 4, 4) [m], or n SE3
        Visits of the pose, n >= 2: a controller's six coordinates, or poses.
    commanded : array, shape (6,) [mm, deg] or (4, 4) [m], or SE3
    AP_um, RP_um : float, optional [um]
        Largest pose accuracy and repeatability of the position.
    AP_rotation_urad, RP_rotation_urad : float, optional [urad]
        The same of the rotation.
    u_um, u_urad : float, optional [um], [urad]
        Standard uncertainty of these values; may be left out only with the rule ``simple``.
    rule, probability, coverage_factor
        As in `hexathermal.predict.acceptance.decide`.
    convention : str
        Of the angles of coordinates, see `hexathermal.poses`.

    Returns
    -------
    PoseAccuracy

    Raises
    ------
    AssertionError
        A limit is not met, or it is not decided whether it is; every limit is told.
    ArgumentError
        No limit is given, no uncertainty, or poses that are none.
    """
    __tracebackhide__ = True
    wanted = {"AP_um": AP_um, "RP_um": RP_um, "AP_rotation_urad": AP_rotation_urad,
              "RP_rotation_urad": RP_rotation_urad}  # fmt: skip
    limits = {key: limit for key, limit in wanted.items() if limit is not None}
    if not limits:
        raise ArgumentError(f"no limit is given; state one or more of {', '.join(wanted)}")
    found = pose_accuracy(_poses(measured, convention, "measured"), _poses(commanded, convention, "commanded"))
    decided_by = {"rule": rule, "probability": probability, "coverage_factor": coverage_factor}
    decisions = _decisions(found, limits, {"um": u_um, "urad": u_urad}, decided_by)
    if any(decision.verdict != PASS for decision in decisions.values()):
        raise AssertionError(_report(found.count, rule, decisions))
    return found


def _decisions(
    found: PoseAccuracy, limits: dict[str, float], uncertainties: dict[str, float | None], decided_by: dict[str, Any]
) -> dict[str, Decision]:
    """Return the decision about each limit, in um or urad."""
    values, decisions = accuracy_values(found), {}
    for key, limit in limits.items():
        quantity = QUANTITIES[key]
        u = uncertainties[quantity.unit]
        if u is None and RULES.get(str(decided_by["rule"]).lower()) != "simple":
            name = f"u_{quantity.unit}"
            raise ArgumentError(f"{key} needs {name}, the standard uncertainty of the value; or ask for rule='simple'")
        decisions[key] = decide(values[quantity.name] * PER_UNIT, u, upper=limit, **decided_by)
    return decisions


def _poses(given: Any, convention: str, what: str) -> FloatArray:
    """Return poses of coordinates (..., 6) [mm, deg], of matrices or of SE3."""
    if isinstance(given, pin.SE3):
        return pose_array(given)
    if not isinstance(given, np.ndarray) and isinstance(given, Iterable):
        given = [item.homogeneous if isinstance(item, pin.SE3) else item for item in given]
    try:
        shape = np.shape(given)
    except ValueError:
        raise ArgumentError(f"{what} poses differ in shape; expected six coordinates or (4, 4) each") from None
    return pose_from_coordinates(given, convention) if shape[-1:] == (6,) else pose_array(given, f"{what} poses")


def _report(count: int, rule: str, decisions: dict[str, Decision]) -> str:
    """Return what a failed assertion says: every limit, the unmet ones first."""
    lines = [f"pose accuracy is not accepted ({count} visits, rule {rule})"]
    for key, item in sorted(decisions.items(), key=lambda pair: pair[1].verdict == PASS):
        quantity = QUANTITIES[key]
        u = "not stated" if item.uncertainty is None else f"{item.uncertainty:g} {quantity.unit}"
        p = "not known" if item.probability is None else f"{item.probability:.4f}"
        lines.append(
            f"  {item.statement.upper()}  {quantity.name} = {item.value:.3f} {quantity.unit}, limit {item.upper:g} "
            f"{quantity.unit}, standard uncertainty {u}, conformance probability {p}"
        )
        if item.verdict != PASS:
            top = 0.0 if item.acceptance is None else item.acceptance[1]
            lines.append(f"    {item.note or f'a value up to {top:.3f} {quantity.unit} would pass'}")
    return "\n".join(lines)
