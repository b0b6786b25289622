"""The proof on runs of a whole hexapod that were never fitted: errors of the platform before and after correction.

Before: the measured pose less the pose that the scales say (the forward kinematics of ``q0 + q``): what a controller
without correction leaves.  After: the measured pose less the pose that the law predicts, with its legs' drift and its
plates' expansion, through the exact forward kinematics.  Errors are ``[t - t_w, log(R R_w^T)]`` in base axes. Intervals
come from drawing runs, and within each stretches of consecutive rows, with replacement.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hexathermal.errors import ArgumentError, UnknownNameError
from hexathermal.kinematics.forward import forward_kinematics
from hexathermal.learn.campaign import Campaign
from hexathermal.learn.hexapod_data import PLATES, HexapodRows, hexapod_rows
from hexathermal.learn.validation import DRAWS, SEED, TRIFLE, Figure, Verdict
from hexathermal.machine.hexapod import Hexapod
from hexathermal.machine.thermal import ThermalModel
from hexathermal.poses import FloatArray
from hexathermal.predict.correction import predicted_pose
from hexathermal.predict.pose_errors import moved_poses, pose_errors

QUANTITIES = ("x", "y", "z", "rx", "ry", "rz", "translation", "rotation")
STRETCH = 10
"""Consecutive rows that are drawn together."""

CORRECTED_ON_LINE_M = 1e-6
"""Commanded and nominal pose differ by more where a correction was active while measuring."""


@dataclass(frozen=True)
class PoseScore:
    """One quantity before and after correction, with 95 % intervals; m or rad.

    Attributes
    ----------
    before, after : Figure
        Root mean square.
    largest_before, largest_after : float
    reduction : Figure
        ``1 - after / before``; negative where the law makes it worse.
    """

    before: Figure
    after: Figure
    largest_before: float
    largest_after: float
    reduction: Figure


@dataclass(frozen=True, eq=False)
class HexapodValidation:
    """What the validation found.

    Attributes
    ----------
    rows : HexapodRows
    before, after : array, shape (n, 6) [m, m, m, rad, rad, rad]
    total : dict of str to PoseScore
        By `QUANTITIES`.
    runs : dict of str to dict of str to PoseScore
    frames : array, shape (runs, 6) [m, rad]
        Mean error after correction of each run, as one motion about home: a frame, or an offset that is not heat.
    framed : (float, float) [m, rad]
        Root mean square distances after correction and without these frames.
    gain : Figure
        Least-squares factor by which the predicted drift would have to be multiplied; below 1: over-corrected.
    verdict : dict of str to Verdict
        Of ``"translation"`` and ``"rotation"``.
    notes : tuple of str
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


def validate_hexapod(hexapod: Hexapod, campaign: Campaign, role: str = "validation") -> HexapodValidation:
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

    Raises
    ------
    UnknownNameError
        The campaign lacks a thermometer of the law; `available` lists those recorded.
    ArgumentError
        The machine has no law, or there are no usable rows.
    """
    model = hexapod.thermal
    if model is None:
        raise ArgumentError(
            f"machine {hexapod.name!r} has no thermal law: there is nothing to validate; 'identify' makes one"
        )
    legs = {name for law in model.legs for name in law.sensors}
    for name in model.sensor_names:
        if name not in campaign.sensors:
            raise UnknownNameError(
                f"the law reads thermometer {name!r} (column {name}_degC), which the campaign does not have; it has "
                f"{', '.join(campaign.sensors) or 'none'}",
                campaign.sensors,
            )
    shared = tuple(sorted(legs)) if all(set(law.sensors) == legs for law in model.legs) else None
    rows = hexapod_rows(campaign, role, hexapod=hexapod, sensors=shared)
    lengths = rows.retracted + rows.q
    told = forward_kinematics(hexapod, lengths)
    warm = predicted_pose(hexapod, lengths, _temperatures(rows, model))
    before, after = pose_errors(told, rows.measured), pose_errors(warm, rows.measured)
    notes = _notes(rows, model, told)
    generator = np.random.default_rng(SEED)
    parts = [rows.run == k for k in range(len(rows.runs)) if (rows.run == k).any()]
    names = [name for k, name in enumerate(rows.runs) if (rows.run == k).any()]
    total, gain = _scores([before[part] for part in parts], [after[part] for part in parts], generator)
    each = {name: _scores([before[part]], [after[part]], generator)[0] for name, part in zip(names, parts, strict=True)}
    frames, framed = _frames(rows, after)
    verdict = {key: _verdict(total[key]) for key in ("translation", "rotation")}
    notes += _doubts(each, gain, len(parts))
    return HexapodValidation(rows, before, after, total, each, frames, framed, gain, verdict, tuple(notes))


def _temperatures(rows: HexapodRows, model: ThermalModel) -> FloatArray:
    """Return temperatures that give the law the campaign's dT, shape (n, sensors) [degC]."""
    found = []
    for name in model.sensor_names:
        part, _, sensor = name.partition("_")
        if part in PLATES:
            found.append(rows.plates[:, PLATES.index(part)])
        else:
            found.append(rows.dT[:, int(part[3:]) - 1, rows.sensors.index(sensor)])
    return np.column_stack(found) + model.reference_temperature_degC


def _notes(rows: HexapodRows, model: ThermalModel, told: FloatArray) -> list[str]:
    """Return what is to be said before anything is judged."""
    notes = [f"{count} rows were left out: {reason}" for reason, count in rows.left_out.items()]
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


def _distances(errors: FloatArray) -> FloatArray:
    """Return the absolute errors by `QUANTITIES`, shape (n, 8)."""
    shift, turn = np.linalg.norm(errors[:, :3], axis=1), np.linalg.norm(errors[:, 3:], axis=1)
    return np.column_stack([np.abs(errors), shift, turn])


def _drawn(sizes: list[int], generator: np.random.Generator) -> FloatArray:
    """Return how often each stretch of rows counts in each draw, shape (DRAWS, stretches)."""
    counts = []
    runs = len(sizes)
    times = generator.multinomial(runs, np.full(runs, 1.0 / runs), size=DRAWS)
    for r, n in enumerate(sizes):
        stretches = -(-n // STRETCH)
        counts.append(generator.multinomial(times[:, r] * stretches, np.full(stretches, 1.0 / stretches)))
    return np.concatenate(counts, axis=1).astype(np.float64)


def _sums(parts: list[FloatArray]) -> FloatArray:
    """Return sums over stretches of consecutive rows, shape (stretches, k)."""
    return np.concatenate([np.add.reduceat(part, np.arange(0, len(part), STRETCH)) for part in parts])


def _scores(
    before: list[FloatArray], after: list[FloatArray], generator: np.random.Generator
) -> tuple[dict[str, PoseScore], Figure]:
    """Return the scores of runs, and by how much the predicted drift would have to be multiplied."""
    counts = _drawn([len(part) for part in before], generator)
    near, far = ([_distances(part) for part in errors] for errors in (before, after))
    n = _sums([np.ones((len(part), 1)) for part in before])
    squares = [_sums([part**2 for part in one]) for one in (near, far)]
    rms = [np.sqrt(one.sum(axis=0) / n.sum()) for one in squares]
    some = [np.sqrt(counts @ one / (counts @ n)) for one in squares]
    largest = [np.max([part.max(axis=0) for part in one], axis=0) for one in (near, far)]
    scores = {}
    for k, name in enumerate(QUANTITIES):
        with np.errstate(divide="ignore", invalid="ignore"):
            value = 1.0 - rms[1][k] / rms[0][k] if rms[0][k] > 0.0 else 0.0
            draws = np.where(some[0][:, k] > 0.0, 1.0 - some[1][:, k] / some[0][:, k], 0.0)
        scores[name] = PoseScore(
            _figure(rms[0][k], some[0][:, k]), _figure(rms[1][k], some[1][:, k]), float(largest[0][k]),
            float(largest[1][k]), _figure(value, draws),
        )  # fmt: skip
    return scores, _gain(before, after, counts)


def _figure(value: float, draws: FloatArray) -> Figure:
    """Return a number with its 95 % interval from draws."""
    low, high = np.quantile(draws, [0.025, 0.975])
    return Figure(float(value), float(min(low, value)), float(max(high, value)))


def _gain(before: list[FloatArray], after: list[FloatArray], counts: FloatArray) -> Figure:
    """Return ``sum p m / sum p p`` of measured against predicted drift, each less its run's mean, translations."""
    up, down = [], []
    for b, a in zip(before, after, strict=True):
        predicted, measured = (b - a)[:, :3], b[:, :3]
        predicted, measured = predicted - predicted.mean(axis=0), measured - measured.mean(axis=0)
        up.append((predicted * measured).sum(axis=1)[:, None])
        down.append((predicted**2).sum(axis=1)[:, None])
    top, bottom = _sums(up), _sums(down)
    if not bottom.sum() > 0.0:
        return Figure(float("nan"), float("nan"), float("nan"))
    some = counts @ bottom
    draws = (counts @ top)[:, 0] / np.where(some[:, 0] > 0.0, some[:, 0], np.inf)
    return _figure(float(top.sum() / bottom.sum()), draws)


def _frames(rows: HexapodRows, after: FloatArray) -> tuple[FloatArray, tuple[float, float]]:
    """Return each run's mean error as one motion about home, and what is left without it."""
    frames, squares = np.zeros((len(rows.runs), 6)), np.zeros(2)
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
        A, y = (X * w[:, None]).reshape(-1, 6), (after[here] * w).ravel()
        frames[k] = np.linalg.lstsq(A, y, rcond=None)[0]
        left = after[here] - X @ frames[k]
        squares += [(left[:, :3] ** 2).sum(), (left[:, 3:] ** 2).sum()]
    root = np.sqrt(squares / len(rows))
    return frames, (float(root[0]), float(root[1]))


def _verdict(score: PoseScore) -> Verdict:
    """Return what the reduction says: worse beyond doubt or by more than a trifle, better beyond doubt, or neither."""
    gain = score.reduction
    if gain.value < 0.0 and (gain.high < 0.0 or gain.value < -TRIFLE):
        return Verdict.WORSE
    return Verdict.BETTER if score.reduction.low > 0.0 else Verdict.UNPROVEN


def _doubts(each: dict[str, dict[str, PoseScore]], gain: Figure, runs: int) -> list[str]:
    """Return over-correction and weak intervals in words."""
    notes = []
    for key in ("translation", "rotation"):
        worse = [name for name, one in each.items() if one[key].reduction.value < 0.0]
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
    if runs < 3:
        notes.append(f"intervals rest on {runs} run{'s' if runs > 1 else ''}: between-run scatter is hardly in them")
    return notes
