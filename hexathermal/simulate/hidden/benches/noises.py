"""Noise of instruments and slow changes, on rows of equal steps."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import numpy.typing as npt
from scipy.signal import lfilter

from hexathermal.poses import FloatArray
from hexathermal.simulate.hidden.truth import CampaignTruth


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


def thermometer_errors(
    level: Mapping[str, float], shape: tuple[int, int], generator: np.random.Generator
) -> FloatArray:
    """Return errors [K] of thermometers, shape (n, s): noise of readings, a constant of each, and a slow walk of each.

    Parameters
    ----------
    level : mapping
        ``sensor_noise_K``, ``sensor_bias_K``, ``sensor_walk_6h_K`` and ``sample_s``, as benches note them.
    shape : (int, int)
    generator : numpy.random.Generator
    """
    errors = level["sensor_noise_K"] * generator.standard_normal(shape)
    errors += level["sensor_bias_K"] * generator.standard_normal(shape[1])
    errors += level["sensor_walk_6h_K"] * walk(21600.0 / level["sample_s"], shape, generator)
    return errors


def noted(campaign: CampaignTruth, usual: Sequence[npt.NDArray[np.bool_]] | None = None) -> CampaignTruth:
    """Return a campaign with what its noise and its law's thermometers do to the measured drift in its notes.

    ``noise_rms_um`` is the RMS of the displacement's noise, ``thermometers_rms_um`` that of the drift which errors of
    the law's thermometers feign, counted from each run's mean; both on settled rows of identification runs.

    Parameters
    ----------
    campaign : CampaignTruth
    usual : sequence of arrays of bool, optional
        Of each run, the rows that count (no spikes); without it, all.
    """
    base = [campaign.sensors.index(name) for name in campaign.base]
    own, feigned = [], []
    for k, run in enumerate(campaign.runs):
        if run.role == "identification":
            rows = run.settled if usual is None else run.settled & usual[k]
            wrong = (run.sensor_errors[rows][:, base] * campaign.slopes(run.q[rows])).sum(axis=1)
            own.append(run.noise[rows])
            feigned.append(wrong - wrong.mean())
    rms = {
        name: float(np.sqrt(np.mean(np.concatenate(parts) ** 2)) * 1e6)
        for name, parts in (("noise_rms_um", own), ("thermometers_rms_um", feigned))
    }
    return campaign.changed(notes={**campaign.notes, **rms})
