"""How well the data tell a parameter that is tried at several values."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from hexathermal.learn.diagnosis.ranking import Ranked

if TYPE_CHECKING:
    from hexathermal.learn.diagnosis.stage import Stage


def grid_spread(leader: Ranked, stage: Stage, name: str) -> float:
    """Return the standard uncertainty of a parameter that was tried at several values: by their evidence, and steps.

    Parameters
    ----------
    leader : Ranked
        The cause, at the best of these values.
    stage : Stage
        In which it leads.
    name : str
        Of the parameter.
    """
    best = leader.best.trial
    own = best.origin, best.shape
    alike = [one for one in stage.trials_left if (one.origin, one.shape) == own and name in one.parameters]
    scored = stage.search.scored(leader.levels, alike)
    values = np.array([float(one.trial.parameters[name]) for one in scored])
    evidence = np.array([one.value for one in scored])
    weights = np.exp(evidence - evidence.max())
    weights /= weights.sum()
    mean = float(weights @ values)
    apart = np.abs(np.unique(values) - float(best.parameters[name]))
    step = float(np.min(apart[apart > 0.0], initial=np.inf))
    within = step / np.sqrt(12.0) if np.isfinite(step) else 0.0
    return float(np.sqrt(weights @ (values - mean) ** 2 + within**2))
