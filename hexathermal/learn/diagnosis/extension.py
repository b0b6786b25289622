"""The law with the named terms and repairs in it, fitted together, and what that gains on runs never fitted."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from itertools import chain
from typing import Any

import numpy as np
import numpy.typing as npt

from hexathermal.errors import ArgumentError
from hexathermal.learn.campaign import Block, Campaign
from hexathermal.learn.campaign_laws import role_blocks
from hexathermal.learn.diagnosis.channels import Levels
from hexathermal.learn.diagnosis.coefficients import sums_without
from hexathermal.learn.diagnosis.evidence import Scored
from hexathermal.learn.diagnosis.mending import mended
from hexathermal.learn.diagnosis.stage import Stage, view_of
from hexathermal.learn.fitting import prediction_factor
from hexathermal.learn.law import IdentifiedLaw
from hexathermal.learn.noise import ResidualNoise
from hexathermal.learn.signals import RunRows
from hexathermal.learn.validation import LandingsJudged, landings_judged
from hexathermal.learn.validation_gain import Gain, gain
from hexathermal.learn.validation_rows import RowsPredictor
from hexathermal.machine.leg_repairs import SensorRepair
from hexathermal.machine.leg_terms import LegTerm
from hexathermal.poses import FloatArray


def extended_law(law: IdentifiedLaw, stage: Stage) -> IdentifiedLaw:
    """Return the law with everything that joined at a stage; coefficients and amplitudes are fitted together.

    Its noise, and with it the intervals of what it predicts, are those of what it leaves, not of what the law left.
    A step of the zero belongs to one run: it frees the coefficients of it, and joins no law.
    """
    if not stage.joined and not stage.repairs:
        return law
    mean, covariance = joint_law(stage)
    p = len(law.coefficients)
    kept, terms = list(range(p)), []
    for item, own in terms_of_law(stage):
        terms.append(LegTerm(item.trial.cause, item.trial.shape, item.trial.parameters, mean[own],
                             covariance[np.ix_(own, own)]))  # fmt: skip
        kept += own
    joint = covariance[np.ix_(kept, kept)]
    joint = 0.5 * (joint + joint.T)
    levels = stage.channel.counted(stage.levels)
    noise = ResidualNoise(levels.white, levels.landing, levels.slow, levels.slow_time, levels.offset)
    return replace(law, coefficients=mean[:p], covariance=joint[:p, :p], terms=tuple(terms), repairs=stage.repairs,
                   joint_covariance=joint, noise=noise, factor=_factor(stage, levels))  # fmt: skip


def terms_of_law(stage: Stage) -> Iterator[tuple[Scored, list[int]]]:
    """Yield what joined and is a term of the law, not a step of one run, with the places of its coefficients."""
    at = stage.view.base_columns.shape[1]
    for item in stage.joined:
        if item.trial.shape:
            yield item, list(range(at, at + item.trial.carried))
        at += item.trial.carried


def joint_law(stage: Stage) -> tuple[FloatArray, FloatArray]:
    """Return `Stage.law`, with the covariance that runs left out bear out.

    Weights by the noise are as sure as if the law were right but for it. Where runs that are left out move the
    coefficients by more, the covariance C is larger by the mean of ``J / C`` (Efron and Stein, Annals of Statistics 9
    (1981) 586)::

        J = (R - 1) / R sum_r (b_r - b)(b_r - b)',     C := C max(1, tr(C^-1 J) / p)

    over the p coefficients that all runs share: a step of the zero belongs to one.
    """
    mean, covariance = stage.law
    shared = [*range(stage.view.base_columns.shape[1]), *chain.from_iterable(own for _item, own in terms_of_law(stage))]
    without = stage.without_each[:, shared]
    apart = without - without.mean(axis=0)
    J = (len(without) - 1) / len(without) * apart.T @ apart
    wider = float(np.trace(np.linalg.solve(covariance[np.ix_(shared, shared)], J))) / len(shared)
    return mean, covariance * max(1.0, wider)


def _factor(stage: Stage, levels: Levels) -> float:
    """Return half of a 95 % prediction interval over the standard deviation by levels, from runs left out."""
    channel = stage.channel
    variance = levels.variance(channel.rows) + levels.offset**2
    z = stage.left / np.sqrt(variance)
    return prediction_factor([z[channel.run == k] for k in np.unique(channel.run)])


def gained(
    law: IdentifiedLaw, extended: IdentifiedLaw, campaign: Campaign, read: Mapping[str, RunRows] | None = None
) -> Gain | None:
    """Return what the extended law gains on the campaign's runs for validation; None where there are none.

    Both laws meet the rows in which the sensors of both have values. `read` are runs that are in memory already.
    """
    if not campaign.runs_of("validation"):
        return None
    needed = [campaign.sensors.index(name) for name in dict.fromkeys((*law.sensors, *extended.read_sensors))]

    def judged(one: IdentifiedLaw) -> LandingsJudged:
        predictor = RowsPredictor(one, campaign, read) if one.extended else None
        blocks = _with_values(role_blocks(campaign, "validation", read=read), needed)
        return landings_judged(one, blocks, campaign.sensors, predictor)

    before = judged(law)
    return gain(before, before if extended is law else judged(extended))


def _with_values(blocks: Iterable[Block], sensors: Sequence[int]) -> Iterator[Block]:
    """Return the rows of blocks in which some sensors have values."""
    for block in blocks:
        good = np.isfinite(block.dT[:, sensors]).all(axis=1)
        if good.any():
            yield replace(block, time=block.time[good], dT=block.dT[good], drift=block.drift[good],
                          q=None if block.q is None else block.q[good], landing=block.landing[good],
                          inputs=block.inputs[good], air=block.air[good])  # fmt: skip


def reachable(
    campaign: Campaign, last: Stage, rows: Sequence[RunRows], law: IdentifiedLaw, repairs: Sequence[SensorRepair]
) -> float | None:
    """Return the RMSE [m] on validation runs of a free fit: all other temperatures and flexible columns, shrunk.

    It is fitted on the runs for identification by ridge regression whose strength is chosen on runs left out. What it
    reaches is what these channels could give; it says nothing about why.
    """
    if not rows:
        return None
    for repair in repairs:
        rows = [mended(one, repair) for one in rows]
    fresh = Stage(view_of(campaign, rows, law.sensors, placed=law.stroked))
    if fresh.view.sensors != last.view.sensors:
        return None
    train, held = _free_columns(last), _free_columns(fresh)
    if train.shape[1] != held.shape[1]:
        return None
    scale = train.std(axis=0) + 1e-30
    weights = _shrunk(train / scale, last.channel.y, last.channel.run)
    left = fresh.channel.y - (held / scale) @ weights
    return float(np.sqrt(np.average(left**2, weights=fresh.channel.rows)))


def _free_columns(stage: Stage) -> FloatArray:
    """Return the law's columns, every temperature and some flexible ones, in windows."""
    view = stage.view
    parts = [view.base_columns, np.column_stack([view.temperatures(name) for name in view.sensors])]
    for shape, settings in _FREE:
        with suppress(ArgumentError):  # a signal that this campaign does not have
            parts.append(view.columns(shape, settings))
    return np.column_stack(parts)


_FREE: list[tuple[str, dict[str, Any]]] = [
    *(("stored-heat", {"source": "motion", "time_constant_s": tau}) for tau in (240.0, 960.0, 3840.0)),
    *(("room", {"time_constant_s": tau}) for tau in (600.0, 5400.0)),
    ("direction", {}), ("position", {}), ("time", {}),
]  # fmt: skip
"""Shapes of the free fit."""


def _shrunk(X: FloatArray, y: FloatArray, run: npt.NDArray[np.int64]) -> FloatArray:
    """Return ridge weights, their strength chosen on runs left out."""

    def weights(products: FloatArray, strength: float) -> FloatArray:
        gram = products[1:, 1:].copy()
        gram[np.diag_indices_from(gram)] += strength * len(y)
        return np.asarray(np.linalg.solve(gram, products[1:, 0]))

    table, runs = np.column_stack([y, X]), [run == k for k in np.unique(run)]
    others = sums_without([table[own].T @ table[own] for own in runs])
    losses = []
    strengths = np.geomspace(1e-6, 1.0, 7)
    for strength in strengths.tolist():
        left = [
            ((y[own] - X[own] @ weights(rest, strength)) ** 2).sum() for own, rest in zip(runs, others, strict=True)
        ]
        losses.append(float(np.sum(left)))
    return weights(table.T @ table, float(strengths[int(np.argmin(losses))]))
