"""What a thermometer's fault is in the drift beside the law alone, no doubt of any thermometer taking part of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from hexathermal.learn.diagnosis.channels import Channel, Levels
from hexathermal.learn.diagnosis.spans import visible
from hexathermal.learn.diagnosis.trials import Trial
from hexathermal.poses import FloatArray


@dataclass(frozen=True, eq=False)
class BesideTheLaw:
    """The law as it reads its thermometers.

    Attributes
    ----------
    channel : Channel
        The drift in windows.
    X : array, shape (n, p)
        Columns of the law and of what joined it.
    sd : array, shape (p,)
        Sizes of their priors.
    sensors : sequence of str
        Of the law, in the order of its columns.
    """

    channel: Channel
    X: FloatArray
    sd: FloatArray
    sensors: Sequence[str]

    def amplitude(self, trial: Trial) -> tuple[float, float, float]:
        """Return A of a fault's sensor, the amplitude of the fault's last column, and its standard uncertainty."""
        X = np.column_stack([self.X, trial.columns])
        sd = np.concatenate([self.sd, np.full(trial.columns.shape[1], self.sd.max())])
        mean, covariance = self.channel.estimated(X, sd, self._levels)
        A = mean[self.sensors.index(str(trial.target))]
        return float(A), float(mean[-1]), float(np.sqrt(covariance[-1, -1]))

    def error(self, trial: Trial) -> float:
        """Return the size of a fault: its amplitude over the law's own A."""
        A, fault, _spread = self.amplitude(trial)
        return fault / A if A else 0.0

    def visible(self, trial: Trial) -> float:
        """Return what of a fault is visible in the drift, RMS, less its standard uncertainty [m].

        Where thermometers are doubted, what their parity shows of a fault is no misfit any more, however large it is.
        """
        if not trial.columns.shape[1]:
            return 0.0
        _A, fault, spread = self.amplitude(trial)
        return max(abs(fault) - spread, 0.0) * float(visible(trial.columns[:, -1:], self.X)[0])

    @cached_property
    def _levels(self) -> Levels:
        """Noise of the drift beside the law."""
        return self.channel.fitted(self.X, self.sd)[0]
