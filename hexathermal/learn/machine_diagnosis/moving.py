"""How far a candidate moves the platform: RMS distance and angle of what it takes, with standard uncertainties.

With the amplitudes' mean a and covariance C, and Q the mean over rows of ``G' G``, G being the motion for a unit of
each amplitude:

    RMS = sqrt(a' Q a),     u(RMS) = sqrt(a' Q C Q a) / RMS

(first order: JCGM 100:2008, 5.1.2)
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hexathermal.learn.machine_diagnosis.case import Case
from hexathermal.learn.machine_diagnosis.evidence import log_bayes
from hexathermal.learn.machine_diagnosis.noise_levels import coordinates_of
from hexathermal.learn.machine_diagnosis.search import Ranked
from hexathermal.learn.machine_diagnosis.tables import eliminated
from hexathermal.learn.machine_diagnosis.view import MachineView
from hexathermal.poses import FloatArray


@dataclass(frozen=True)
class Moved:
    """RMS by which something moves the platform [m], [rad], with standard uncertainties."""

    translation: float
    rotation: float
    translation_std: float
    rotation_std: float


def moved(case: Case, one: Ranked) -> Moved:
    """Return how far a candidate moves the platform in the rows searched, alone beside the law.

    At the disturbances beside which it was ranked: those of a null without it may hold a part of it.

    Parameters
    ----------
    case : Case
    one : Ranked
    """
    candidate, own = case.candidates[one.which], case.tables.places[one.which]
    tables = case.tables
    which = np.concatenate([np.arange(tables.base), np.arange(own.start, own.stop), [tables.count]]).astype(np.int64)
    left = eliminated(tables.reduced(one.levels, which)[0], tables.sizes(one.levels))[0]
    S, sd = left[:-1, :-1], one.scored.size * candidate.scale
    found = log_bayes(S, left[:-1, -1], candidate.mean, sd)[1]
    covariance = np.linalg.inv(S * np.outer(sd, sd) + np.eye(len(sd))) * np.outer(sd, sd)
    return moved_by(case.view, candidate.columns, found, covariance)


def moved_by(view: MachineView, columns: FloatArray, found: FloatArray, covariance: FloatArray) -> Moved:
    """Return how far columns (n, 6, k) [m per unit] of amplitudes (k,), with their covariance, move the platform."""
    motion = np.stack([coordinates_of(view, columns[..., k]) for k in range(len(found))], axis=2)
    far, turned = (_rms(motion[:, axes], found, covariance) for axes in (slice(0, 3), slice(3, 6)))
    return Moved(far[0], turned[0], far[1], turned[1])


def _rms(motion: FloatArray, found: FloatArray, covariance: FloatArray) -> tuple[float, float]:
    """Return the RMS over rows of a motion (n, 3, k) with amplitudes (k,), and its standard uncertainty."""
    Q = np.einsum("nik,nij->kj", motion, motion) / len(motion)
    value = float(np.sqrt(max(float(found @ Q @ found), 0.0)))
    along = Q @ found
    return value, float(np.sqrt(max(float(along @ covariance @ along), 0.0))) / max(value, float(np.finfo(float).tiny))
