"""Noise of instruments and slow changes, on rows of equal steps."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.signal import lfilter

from hexathermal.poses import FloatArray
from hexathermal.simulate.hidden.truth import RunTruth


def log_uniform(low: float, high: float, generator: np.random.Generator) -> float:
    """Return a number whose logarithm is uniform between those of two bounds."""
    return float(np.exp(generator.uniform(np.log(low), np.log(high))))


def remembering(forgotten: float, shape: tuple[int, ...], generator: np.random.Generator) -> FloatArray:
    """Return a stationary Ornstein-Uhlenbeck process of unit variance along the first axis.

    ``x[k+1] = a x[k] + sqrt(1 - a^2) e[k]``, ``a = exp(-1 / forgotten)``, `forgotten` the correlation time in rows.
    """
    kept = np.exp(-1.0 / forgotten)
    fresh = generator.standard_normal(shape)
    fresh[1:] *= np.sqrt(1.0 - kept * kept)
    return np.asarray(lfilter([1.0], [1.0, -kept], fresh, axis=0))


def walk(rows_to_unit: float, shape: tuple[int, ...], generator: np.random.Generator) -> FloatArray:
    """Return random walks from zero along the first axis, of unit standard deviation after `rows_to_unit` rows."""
    steps = generator.standard_normal(shape) / np.sqrt(rows_to_unit)
    steps[0] = 0.0
    return np.asarray(np.cumsum(steps, axis=0))


def noise_rms_um(runs: Sequence[RunTruth], usual: Sequence[np.ndarray] | None = None) -> float:
    """Return the RMS [um] of the displacement's noise on settled rows of identification runs.

    Parameters
    ----------
    runs : sequence of RunTruth
    usual : sequence of arrays of bool, optional
        Of each run, the rows that count; without it, all.
    """
    parts = [
        run.noise[run.settled & (True if usual is None else usual[k])]
        for k, run in enumerate(runs)
        if run.role == "identification"
    ]
    return float(np.sqrt(np.mean(np.concatenate(parts) ** 2)) * 1e6)
