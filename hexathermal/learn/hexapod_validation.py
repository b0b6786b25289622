"""The proof on runs of a whole hexapod that were never fitted: errors of the platform before and after correction.

Before: the measured pose less the pose that the scales say (the forward kinematics of ``q0 + q``): what a controller
without correction leaves.  After: the measured pose less the pose that the law predicts, with its legs' drift, its
plates' expansion and the sag under its payload, through the exact forward kinematics.  Errors are ``[t - t_w, log(R
R_w^T)]`` in base axes. Measured poses are freed of the drift of the measuring frame that the machine states: it is no
error of the platform. Misses of the positioning system are left out by the rule of identification; runs that were
fitted are known by their rows.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from hexathermal.errors import ArgumentError, UnknownNameError
from hexathermal.kinematics.forward import forward_kinematics
from hexathermal.learn.campaign import Campaign
from hexathermal.learn.hexapod_data import PLATES, HexapodRows, hexapod_rows
from hexathermal.learn.hexapod_noise import without_misses
from hexathermal.learn.hexapod_offset import far_poses
from hexathermal.learn.hexapod_scores import PoseScore, best_factor, pose_scores
from hexathermal.learn.hexapod_stated import in_machine_frame, stated_notes
from hexathermal.learn.law import Origin
from hexathermal.learn.validation import TRIFLE, Figure, Verdict
from hexathermal.machine.hexapod import Hexapod
from hexathermal.machine.shown import Shown
from hexathermal.machine.thermal import ThermalModel
from hexathermal.poses import FloatArray
from hexathermal.predict.correction import predicted_pose
from hexathermal.predict.leg_states import leg_controllers
from hexathermal.predict.pose_errors import moved_poses, pose_errors

FEWEST_RUNS = 3
"""Runs from which on their scatter alone says whether a law makes it better."""

CORRECTED_ON_LINE_M = 1e-6
"""Commanded and nominal pose differ by more where a correction was active while measuring."""


@dataclass(frozen=True, eq=False, repr=False)
class HexapodValidation(Shown):
    """What the validation found.

    Runs that were fitted have their own scores, but count in `total`, `framed`, `gain` and `verdict` only where every
    run was fitted.

    Attributes
    ----------
    rows : HexapodRows
        Of all runs, without misses of the positioning system.
    before, after : array, shape (n, 6) [m, m, m, rad, rad, rad]
    total : dict of str to PoseScore
        By `QUANTITIES`.
    runs : dict of str to dict of str to PoseScore
    frames : array, shape (runs, 6) [m, rad]
        Mean error after correction of each run, as one motion about home: a frame, or an offset that is not heat.
    framed : (float, float) [m, rad]
        Root mean square distances after correction and without these frames.
    framed_before : (float, float) [m, rad]
        The same before correction, each run without its own mean motion.
    gain : Figure
        Least-squares factor by which the predicted drift would have to be multiplied; below 1: over-corrected.
    verdict : dict of str to Verdict
        Of ``"translation"`` and ``"rotation"``.
    notes : tuple of str
    fitted : dict of str to str
        Runs whose rows were fitted, and the names that they had then.
    fits_known : bool
        Whether it is known which runs the law was fitted to.
    """

    rows: HexapodRows
    before: FloatArray
    after: FloatArray
    total: dict[str, PoseScore]
    runs: dict[str, dict[str, PoseScore]]
    frames: FloatArray
    framed: tuple[float, float]
    gain: Figure
    verdict: dict[str, Verdict]
    notes: tuple[str, ...]
    fitted: dict[str, str] = field(default_factory=dict)
    fits_known: bool = False
    framed_before: tuple[float, float] = (float("nan"), float("nan"))

    def __repr__(self) -> str:
        said = (f"{key} {verdict.value}" for key, verdict in self.verdict.items())
        return f"HexapodValidation: {', '.join(said)}; {len(self.rows)} poses"


def validate_hexapod(
    hexapod: Hexapod, campaign: Campaign, role: str = "validation", *, origin: Origin | None = None
) -> HexapodValidation:
    """Return what a machine's law leaves of the platform's errors in runs that were never fitted.

    Temperatures count as the campaign says: ``dT`` from its zero; the machine's own reference does not matter.

    Parameters
    ----------
    hexapod : Hexapod
        With a thermal law; its geometry predicts.
    campaign : Campaign
        Of kind ``"hexapod"``.
    role : str
        Of the runs.
    origin : Origin, optional
        Where the law comes from, as `hexathermal.learn.hexapod_origin.read_origin` gives it: tells which runs were
        fitted.

    Raises
    ------
    UnknownNameError
        The campaign lacks a thermometer of the law, or that which the machine's measuring frame follows; `available`
        lists those recorded.
    ArgumentError
        The machine has no law; a `DataError` where no row is usable.
    """
    model = readable_law(hexapod, campaign)
    wanted = tuple(dict.fromkeys(name for law in model.legs for name in law.sensors))
    rows, note = without_misses(hexapod_rows(campaign, role, hexapod=hexapod, sensors=wanted))
    told, stood = forward_kinematics(hexapod, rows.retracted + rows.q), in_machine_frame(rows)
    before, after = pose_errors(told, stood), pose_errors(_predicted(rows, model), stood)
    names = [name for k, name in enumerate(rows.runs) if (rows.run == k).any()]
    fitted = _fitted(rows, names, origin)
    judged = [name for name in names if name not in fitted] or names
    parts = {name: rows.run == rows.runs.index(name) for name in names}
    some = [[errors[parts[name]] for name in judged] for errors in (before, after)]
    total, gain = pose_scores(*some), best_factor(*some)
    each = {name: pose_scores([before[part]], [after[part]]) for name, part in parts.items()}
    frames, framed = _frames(rows, after, judged)
    every = len(fitted) == len(names)
    verdict = {key: _verdict(total[key], [each[name][key] for name in judged], every)
               for key in ("translation", "rotation")}  # fmt: skip
    notes = [*_notes(rows, model, told), *([note] if note else []), *_doubts(each, gain, len(judged))]
    if fitted and not every:
        notes.append(f"{', '.join(fitted)}: fitted, and left out of the verdict and of what is said of all runs")
    return HexapodValidation(
        rows,
        before,
        after,
        total,
        each,
        frames,
        framed,
        gain,
        verdict,
        tuple(notes),
        fitted,
        origin is not None,
        _frames(rows, before, judged)[1],
    )


def readable_law(hexapod: Hexapod, campaign: Campaign) -> ThermalModel:
    """Return the law of a machine, all of whose thermometers a campaign has.

    Raises
    ------
    ArgumentError
        The machine has no law.
    UnknownNameError
        The campaign lacks a thermometer of the law; `available` lists those recorded.
    """
    model = hexapod.thermal
    if model is None:
        raise ArgumentError(
            f"machine {hexapod.name!r} has no thermal law to hold against measured poses; 'identify' makes one"
        )
    for name in model.sensor_names:
        if name not in campaign.sensors:
            raise UnknownNameError(
                f"the law reads thermometer {name!r} (column {name}_degC), which the campaign does not have; it has "
                f"{', '.join(campaign.sensors) or 'none'}",
                campaign.sensors,
            )
    return model


def _fitted(rows: HexapodRows, names: list[str], origin: Origin | None) -> dict[str, str]:
    """Return the runs that were fitted, and the names that they had then."""
    known = {} if origin is None else dict(zip(origin.run_fingerprints, origin.runs, strict=False))
    return {name: known[mark] for name, mark in rows.fingerprints.items() if mark in known and name in names}


def law_temperatures(rows: HexapodRows, model: ThermalModel) -> FloatArray:
    """Return temperatures that give a law what a campaign says since its zero, shape (n, sensors) [degC].

    ``reference + dT``, in the order of the law's thermometers; what exchanged plugs read stays where it was read.

    Parameters
    ----------
    rows : HexapodRows
    model : ThermalModel
    """
    found = []
    for name in model.sensor_names:
        part, _, sensor = name.partition("_")
        if part in PLATES:
            found.append(rows.plates[:, PLATES.index(part)])
        else:
            found.append(rows.dT[:, int(part[3:]) - 1, rows.sensors.index(sensor)])
    return np.column_stack(found) + model.reference_temperature_degC


def _predicted(rows: HexapodRows, model: ThermalModel) -> FloatArray:
    """Return where the law puts the platform, (n, 4, 4); legs that remember begin anew in each run."""
    lengths, temps = rows.retracted + rows.q, law_temperatures(rows, model)
    if not model.states:
        return predicted_pose(rows.hexapod, lengths, temps)
    poses = np.empty(rows.measured.shape)
    for run in np.unique(rows.run):
        own = rows.run == run
        poses[own] = leg_controllers(rows.hexapod).predicted_pose(lengths[own], temps[own], rows.time[own])
    return poses


def _notes(rows: HexapodRows, model: ThermalModel, told: FloatArray) -> list[str]:
    """Return what is to be said before anything is judged."""
    notes = [
        *far_poses(rows),
        *stated_notes(rows),
        *(f"{count} rows were left out: {reason}" for reason, count in rows.left_out.items()),
    ]
    apart = np.abs(pose_errors(told, rows.commanded)[:, :3]).max()
    if apart > CORRECTED_ON_LINE_M:
        notes.append(
            f"the scales say another pose than was commanded, by up to {apart * 1e6:.2f} um: a correction was active, "
            "or the controller has other joints; 'before' counts from the scales"
        )
    for k, part in enumerate(PLATES):
        law = getattr(model, part)
        if law is None or law.sensor is None:
            where = "it is recorded" if rows.recorded_plates[k] else "it has no thermometer"
            notes.append(f"the law does not correct the {part} ({where})")
    return notes


def _frames(rows: HexapodRows, errors: FloatArray, judged: list[str]) -> tuple[FloatArray, tuple[float, float]]:
    """Return each run's mean error as one motion about home, and what is left without it in the runs judged."""
    frames, squares, count = np.zeros((len(rows.runs), 6)), np.zeros(2), 0
    home = rows.hexapod.home[:3, 3]
    for k in range(len(rows.runs)):
        here = rows.run == k
        if not here.any():
            continue
        arm = rows.measured[here][:, :3, 3] - home
        n = len(arm)
        X = np.zeros((n, 6, 6))
        X[:, :, :] = np.eye(6)
        for axis in range(3):
            turned = moved_poses(rows.measured[here], 1e-6 * np.eye(6)[3 + axis], home)
            X[:, :3, 3 + axis] = (turned[:, :3, 3] - rows.measured[here][:, :3, 3]) * 1e6
        # metres and radians weigh alike at the platform's joints
        radius = float(np.linalg.norm(rows.hexapod.platform_joints, axis=1).mean())
        w = np.array([1.0] * 3 + [radius] * 3)
        A, y = (X * w[:, None]).reshape(-1, 6), (errors[here] * w).ravel()
        frames[k] = np.linalg.lstsq(A, y, rcond=None)[0]
        if rows.runs[k] not in judged:
            continue
        left = errors[here] - X @ frames[k]
        squares += [(left[:, :3] ** 2).sum(), (left[:, 3:] ** 2).sum()]
        count += n
    root = np.sqrt(squares / count)
    return frames, (float(root[0]), float(root[1]))


def _verdict(score: PoseScore, runs: list[PoseScore], all_fitted: bool) -> Verdict:
    """Return what the reduction says: worse beyond doubt or by more than a trifle, better beyond doubt, or neither.

    One or two runs tell next to nothing of their scatter: there every run has to be better beyond its own doubt.
    """
    if _worse(score):
        return Verdict.WORSE
    if all_fitted:
        return Verdict.FITTED
    each = len(runs) < FEWEST_RUNS and all(one.reduction.low > 0.0 for one in runs)
    return Verdict.BETTER if score.reduction.low > 0.0 or each else Verdict.UNPROVEN


def _worse(score: PoseScore) -> bool:
    """Whether correction makes it worse, beyond doubt or by more than a trifle."""
    gain = score.reduction
    return gain.value < 0.0 and (gain.high < 0.0 or gain.value < -TRIFLE)


def _doubts(each: dict[str, dict[str, PoseScore]], gain: Figure, runs: int) -> list[str]:
    """Return over-correction and weak intervals in words."""
    notes = []
    for key in ("translation", "rotation"):
        worse = [name for name, one in each.items() if _worse(one[key])]
        if worse:
            notes.append(
                f"over-correction, or a frame that moved between runs: in {', '.join(worse)} the {key} error is larger "
                "with correction than without (see what is left without each run's mean motion)"
            )
    if gain.high < 1.0:
        notes.append(
            f"over-correction: the predicted drift is too large, {gain.value:.2f} of it would fit best "
            f"({gain.low:.2f} to {gain.high:.2f})"
        )
    elif gain.low > 1.0:
        notes.append(
            f"under-correction: the predicted drift is too small, {gain.value:.2f} times it would fit best "
            f"({gain.low:.2f} to {gain.high:.2f})"
        )
    if runs == 1:
        notes.append("intervals rest on one run: they speak of its rows, and say nothing of other runs")
    elif runs < FEWEST_RUNS:
        notes.append(
            f"intervals rest on {runs} runs, whose scatter says little: they are wide, and the verdict asks whether "
            "each run is better beyond its own doubt"
        )
    return notes
