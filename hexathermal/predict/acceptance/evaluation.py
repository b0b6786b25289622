"""Measured poses held against a specification: every limit at every pose decided, and all of them together."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from hexathermal.errors import ArgumentError
from hexathermal.machine.shown import Shown
from hexathermal.poses import FloatArray
from hexathermal.predict.acceptance.decision_rules import FAIL, NOT_DECIDED, PASS, Decision, decide
from hexathermal.predict.acceptance.environmental_variation import (
    allowed_gap,
    environmental_variation,
    warm_up_distortion,
)
from hexathermal.predict.acceptance.measured_poses import UNCERTAINTIES, MeasuredPoses
from hexathermal.predict.acceptance.pose_accuracy import (
    ASKED_CYCLES,
    PoseAccuracy,
    accuracies_of_poses,
    angle_differences,
    pose_drift,
)
from hexathermal.predict.acceptance.quantities import (
    ACCURACY,
    ACCURACY_VALUES,
    AXES,
    DRIFT,
    ETVE,
    WARM_UP,
    WARM_UP_VALUES,
    drift_values,
)
from hexathermal.predict.acceptance.specification import Limit, Specification

ASKED_OF_GROUP = 10
"""Visits of a pose in each group of a drift test that ISO 9283 asks for."""


@dataclass(frozen=True)
class Result:
    """One limit at one pose, decided.

    Attributes
    ----------
    limit : Limit
    pose, group : str
        Where the value comes from; the group is empty where there is none, or where the value is of all groups.
    count : int
        Rows that the value was made from.
    decision : Decision
        In SI units.
    detail : str
        What else belongs to the value: of ETVE the window and its ranges of temperature, of drift the worst group.
    """

    limit: Limit
    pose: str
    group: str
    count: int
    decision: Decision
    detail: str = ""


@dataclass(frozen=True, eq=False)
class Acceptance(Shown):
    """Whether a machine meets its specification.

    Attributes
    ----------
    specification : Specification
    measured : MeasuredPoses
    results : tuple of Result
        Each limit at each pose (and group) it holds for.
    accuracies : dict of (str, str) to PoseAccuracy
        By pose and group, wherever a pose was visited at least twice.
    notes : tuple of str
        What a reader of the verdict must know.
    """

    specification: Specification
    measured: MeasuredPoses
    results: tuple[Result, ...]
    accuracies: dict[tuple[str, str], PoseAccuracy]
    notes: tuple[str, ...]

    @property
    def verdict(self) -> str:
        """``"fail"`` where any limit fails, ``"pass"`` where all pass, else ``"not decided"``."""
        verdicts = {result.decision.verdict for result in self.results}
        return FAIL if FAIL in verdicts else PASS if verdicts == {PASS} else NOT_DECIDED

    @property
    def probability(self) -> tuple[float, float] | None:
        """Bounds of the probability that all limits are met; None where a limit has no probability.

        ``max(0, 1 - sum (1 - p)) <= P <= min p``, whatever the limits have in common.
        """
        each = [result.decision.probability for result in self.results]
        known = [p for p in each if p is not None]
        if len(known) < len(each):
            return None
        return max(0.0, 1.0 - sum(1.0 - p for p in known)), min(known)


@dataclass(frozen=True)
class _Value:
    """A value of a quantity, from some rows."""

    value: float
    rows: Any
    group: str = ""
    detail: str = ""
    lower_bound: bool = False


def accept(measured: MeasuredPoses, specification: Specification) -> Acceptance:
    """Hold measured poses against a specification.

    Parameters
    ----------
    measured : MeasuredPoses
    specification : Specification

    Returns
    -------
    Acceptance

    Raises
    ------
    ArgumentError
        The measurements cannot answer a limit: too few visits, no groups, no times, no measured angles, no
        uncertainty; or a limit names a pose that was not measured. All such limits are told together.
    """
    accuracies = _accuracies(measured)
    results: list[Result] = []
    problems: list[str] = []
    for limit in specification.limits:
        missing = _unanswerable(limit, measured)
        if missing:
            problems.append(f"{limit.key}: {missing}")
            continue
        try:
            results += _decided(limit, specification, measured, accuracies)
        except ArgumentError as error:
            problems.append(f"{limit.key}: {error}")
    if problems:
        lines = "\n".join(f"  {problem}" for problem in problems)
        raise ArgumentError(f"{measured.path} cannot answer {specification.path or 'the specification'}:\n{lines}")
    notes = tuple(_notes(specification, measured, results))
    return Acceptance(specification, measured, tuple(results), accuracies, notes)


def _accuracies(measured: MeasuredPoses) -> dict[tuple[str, str], PoseAccuracy]:
    """Return pose accuracy of each pose in each group that has at least two visits."""
    rows = {
        (pose, group): measured.rows(pose, group) for pose in measured.pose_names for group in measured.groups_of(pose)
    }
    rows = {place: own for place, own in rows.items() if len(own) > 1}
    if not rows:
        return {}
    first = np.array([own[0] for own in rows.values()])
    starts = np.cumsum([0, *(len(own) for own in rows.values())], dtype=np.intp)[:-1]
    try:
        found = accuracies_of_poses(
            measured.measured[np.concatenate(list(rows.values()))], measured.commanded[first], starts,
            measured.convention, [_where(*place) for place in rows],
        )  # fmt: skip
    except ArgumentError as error:
        raise ArgumentError(f"{measured.path}, {error}") from None
    return dict(zip(rows, found, strict=True))


def _where(pose: str, group: str) -> str:
    """Return the words for a place."""
    return f"pose {pose}" + (f", group {group}" if group else "")


def _unanswerable(limit: Limit, measured: MeasuredPoses) -> str:
    """Return what is missing to answer a limit; empty where nothing is."""
    unknown = [pose for pose in limit.poses if pose not in measured.pose_names]
    if unknown:
        return f"pose {unknown[0]!r} was not measured; measured: {', '.join(measured.pose_names[:20])}"
    if limit.quantity.unit == "urad" and not measured.turns:
        return "angles were not measured; add the columns measured_rx_deg, measured_ry_deg and measured_rz_deg"
    if limit.quantity.family in (ETVE, WARM_UP) and measured.time is None:
        return "needs times; add the column time_s"
    if limit.quantity.family == DRIFT and len(measured.group_names) < 2:
        return "needs at least two groups of visits; add the column group (the cold machine's first)"
    turn = limit.quantity.unit == "urad"
    column = measured.u_rotation if turn else measured.u_position
    if limit.uncertainty is None and column is None and limit.rule != "simple":
        key = "rotation_urad" if turn else "position_um"
        return (
            f"no uncertainty is stated; give u or U with the limit, {key} in [uncertainty], or the column "
            f'{UNCERTAINTIES[turn]} in the table; or ask for rule = "simple"'
        )
    return ""


def _decided(
    limit: Limit,
    specification: Specification,
    measured: MeasuredPoses,
    accuracies: dict[tuple[str, str], PoseAccuracy],
) -> Iterator[Result]:
    """Return the decisions about one limit at all its poses."""
    for pose in limit.poses or measured.pose_names:
        for found in _values(limit, specification, measured, accuracies, pose):
            if not np.isfinite(found.value):
                raise _locked(limit, pose)
            u = _from_rows(limit, measured, found) if limit.uncertainty is None else limit.uncertainty
            decision = decide(
                found.value, u, lower=limit.lower, upper=limit.upper, rule=limit.rule, probability=limit.probability,
                coverage_factor=limit.coverage_factor, nonnegative=limit.nonnegative,
            )  # fmt: skip
            if found.lower_bound and decision.verdict == PASS:
                note = "the record has gaps in which the machine may have moved further"
                decision = replace(decision, verdict=NOT_DECIDED, statement=NOT_DECIDED, probability=None, note=note)
            yield Result(limit, pose, found.group, len(found.rows), decision, found.detail)


def _from_rows(limit: Limit, measured: MeasuredPoses, found: _Value) -> float | None:
    """Return the standard uncertainty of a value from those of its rows, or None where they tell none."""
    column = measured.u_rotation if limit.quantity.unit == "urad" else measured.u_position
    if column is None:
        return None
    fewest = min(Counter(measured.groups[row] for row in found.rows).values())
    return float(column[found.rows].max()) * limit.quantity.sensitivity(fewest)


def _locked(limit: Limit, pose: str) -> ArgumentError:
    """Return the error of an angle that does not exist at a pose."""
    turn = limit.quantity.axis.removeprefix("angle_")
    other = limit.quantity.key.replace("angle_", "")
    return ArgumentError(
        f"pose {pose} has ry within 1 degree of +-90 (gimbal lock), where the angle {turn} is not certain; limit the "
        f"turn about the axis instead ({other}), or name other poses (poses = [...])"
    )


def _values(
    limit: Limit,
    specification: Specification,
    measured: MeasuredPoses,
    accuracies: dict[tuple[str, str], PoseAccuracy],
    pose: str,
) -> Iterator[_Value]:
    """Return the values of a limit's quantity at a pose, one for each group where groups are told apart."""
    quantity, rows = limit.quantity, measured.rows(pose)
    if quantity.family == ACCURACY:
        for group in measured.groups_of(pose):
            own = measured.rows(pose, group)
            _check_visits(measured, accuracies, pose, group)
            yield _Value(ACCURACY_VALUES[quantity.name](accuracies[pose, group]), own, group)
    elif quantity.family == DRIFT:
        yield _drift(limit, measured, accuracies, pose)
    else:
        series = _deviations(measured, rows)[:, AXES.index(quantity.axis)]
        if not np.isfinite(series).all():
            raise _locked(limit, pose)
        times = np.zeros(0) if measured.time is None else measured.time[rows]
        if quantity.family == ETVE:
            yield _variation(limit, measured, rows, times, series)
        else:
            found = warm_up_distortion(times, series, specification.warm_up)
            value = WARM_UP_VALUES[quantity.name.partition("_")[0]](found)
            yield _Value(value, rows, detail=f"warming for {found.end:g} s")


def _check_visits(
    measured: MeasuredPoses, accuracies: dict[tuple[str, str], PoseAccuracy], pose: str, group: str
) -> None:
    """Refuse a pose that was visited too few times."""
    if (pose, group) not in accuracies:
        count = len(measured.rows(pose, group))
        raise ArgumentError(
            f"{_where(pose, group)} has {count} visit{'s' * (count != 1)}; expected at least 2, ISO 9283 asks for "
            f"{ASKED_CYCLES} (rows of one pose have the same name in column pose, or the same command)"
        )


def _drift(limit: Limit, measured: MeasuredPoses, accuracies: dict[tuple[str, str], PoseAccuracy], pose: str) -> _Value:
    """Return the drift of a pose over its groups."""
    groups = measured.groups_of(pose)
    for group in groups:
        _check_visits(measured, accuracies, pose, group)
    if len(groups) < 2:
        raise ArgumentError(f"pose {pose} was visited in group {groups[0]} only; drift needs a later group")
    drift = pose_drift([accuracies[pose, group] for group in groups])
    worst = drift.worst.get(limit.quantity.name)
    detail = "" if worst is None else f"largest in group {groups[worst]}, counted from group {groups[0]}"
    return _Value(drift_values(drift)[limit.quantity.name], measured.rows(pose), detail=detail)


def _variation(limit: Limit, measured: MeasuredPoses, rows: Any, times: FloatArray, series: FloatArray) -> _Value:
    """Return the environmental variation of one coordinate."""
    heat = {name: values[rows] for name, values in measured.temperatures.items()}
    found = environmental_variation(times, series, limit.window, heat)
    spans = ", ".join(f"{name} {span:.3g} K" for name, span in found.temperature_ranges.items())
    detail = f"window of {found.window:g} s, {found.start:g} to {found.end:g} s; temperature range: "
    detail += spans or "no temperatures recorded"
    allowed = allowed_gap(times, found.window) if limit.gap is None else limit.gap
    sparse = found.longest_gap > allowed
    if sparse:
        detail += f"; longest gap {found.longest_gap:g} s, allowed {allowed:g} s: a lower bound"
    return _Value(found.value, rows, detail=detail, lower_bound=sparse)


def _deviations(measured: MeasuredPoses, rows: Any) -> FloatArray:
    """Return measured less commanded, in the order of `AXES`: shifts [m], rotation vectors and angles [rad], (n, 9)."""
    found, wanted = measured.measured[rows], measured.commanded[rows]
    turns = Rotation.from_matrix(found[:, :3, :3] @ np.swapaxes(wanted[:, :3, :3], -1, -2)).as_rotvec()
    angles = angle_differences(found, wanted, measured.convention)
    return np.concatenate([found[:, :3, 3] - wanted[:, :3, 3], turns, angles], axis=1)


def _notes(specification: Specification, measured: MeasuredPoses, results: list[Result]) -> Iterator[str]:
    """Return what a reader of the verdict must know."""
    families = {limit.quantity.family for limit in specification.limits}
    if families & {ACCURACY, DRIFT}:
        counts = {
            (pose, group): len(measured.rows(pose, group))
            for pose in measured.pose_names
            for group in measured.groups_of(pose)
        }
        place = min(counts, key=counts.__getitem__)
        asked = ASKED_OF_GROUP if len(measured.group_names) > 1 else ASKED_CYCLES
        if counts[place] < asked:
            yield f"{_where(*place)} was visited {counts[place]} times; ISO 9283 asks for {asked}"
    if not measured.turns:
        yield "angles were not measured: nothing is said about turns"
    if measured.unused:
        yield f"columns not used: {', '.join(measured.unused)}"
    coarse = dict.fromkeys(f"{item.limit.key}: {item.decision.note}" for item in results if item.decision.note)
    yield from coarse
    if any(result.decision.probability is None and result.decision.uncertainty is None for result in results):
        yield "limits decided by the rule 'simple' without an uncertainty have no probability"
