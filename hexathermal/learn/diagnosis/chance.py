"""The evidence that chance alone reaches in this campaign: the threshold for a name.

Data are drawn from the fit, law and noise and nothing else, and every trial is scored on them as on the real ones. In
whitened data a draw is a vector of independent normal numbers, so that hundreds of campaigns cost one product.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hexathermal.learn.diagnosis.channels import Channel, Levels
from hexathermal.learn.diagnosis.evidence import RHO, Base, Terms, mean_log, null_of, stacked, terms_of
from hexathermal.learn.diagnosis.trials import Trial
from hexathermal.poses import FloatArray

DRAWS = 120
MOST_COLUMNS = 2
"""Trials of more columns are few, and chance says less for each."""

FALSE_ALARMS = 0.01
"""Part of the campaigns with nothing in them in which chance may reach the threshold."""

LEAST_THRESHOLD = 6.0
"""Log evidence that a name needs in any campaign: noise as it is has heavier tails than the one that draws are made of.
Of 50 clean campaigns of four benches looked at meanwhile three were named with 5.0 and 5.1, and of 72 effects from 0.35
of the noise on that were named rightly none had less than 9."""


def chance_threshold(
    channel: Channel, base: Base, levels: Levels, trials: list[Trial], largest: float, seed: int,
    terms: Sequence[Terms] | None = None,
) -> float:  # fmt: skip
    """Return the log evidence that the best of all trials passes in `FALSE_ALARMS` of campaigns with nothing in them.

    The maxima of the draws follow Gumbel's law; its quantile is taken, since draws are few.

    Parameters
    ----------
    channel, base, levels, trials, largest, terms
        As `hexathermal.learn.diagnosis.evidence.screened`.
    seed : int
    """
    found = terms_of(base, trials) if terms is None else terms
    few = [own for own in found if own.rms.shape[1] <= MOST_COLUMNS]
    if not few:
        return 0.0
    null = null_of(channel, base, levels)
    left = null.left(np.random.default_rng(seed).standard_normal((len(channel), DRAWS)))
    families: dict[str, list[FloatArray]] = {}
    for own in few:
        stack = stacked(channel, null, own, left, levels, largest)
        values = mean_log(np.array([stack.log_bayes(rho) for rho in RHO]))
        for trial, drawn in zip(own.trials, values, strict=True):
            families.setdefault(trial.cause, []).append(drawn)
    best = np.max([mean_log(np.array(values)) for values in families.values()], axis=0)
    scale = np.sqrt(6.0) / np.pi * float(best.std())
    return float(best.mean() - 0.5772 * scale - scale * np.log(-np.log(1.0 - FALSE_ALARMS)))
