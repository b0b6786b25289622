"""A law that was identified: coefficients, their covariance, the residual's noise, and where it holds."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from hexathermal.errors import ArgumentError
from hexathermal.learn.noise import ResidualNoise
from hexathermal.learn.sensor_errors import SensorErrors
from hexathermal.machine.thermal import LegLaw, frozen
from hexathermal.poses import FloatArray


@dataclass(frozen=True, eq=False)
class Validity:
    """Where a law was fitted: outside, it extrapolates.

    Attributes
    ----------
    dT : array, shape (k, 2) [K]
        Lowest and highest of each sensor.
    q : (float, float) or None [m]
    degC : (float, float) or None
        Lowest and highest temperature met by the law's sensors; None where the rows did not say.
    """

    dT: FloatArray
    q: tuple[float, float] | None = None
    degC: tuple[float, float] | None = None


@dataclass(frozen=True)
class Origin:
    """Where a law comes from.

    Attributes
    ----------
    title : str
        Of the campaign.
    fingerprint : str
        Of the campaign's files, see `hexathermal.learn.campaign_dataset.fingerprint`.
    runs : tuple of str
        That were fitted.
    method : str
    run_fingerprints : tuple of str
        Of the rows of each fitted run, see `hexathermal.learn.row_fingerprints`; empty where they are not known.
    """

    title: str = ""
    fingerprint: str = ""
    runs: tuple[str, ...] = ()
    method: str = ""
    run_fingerprints: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class IdentifiedLaw:
    """The law of a leg, ``drift = sum_s A_s q0 dT_s + B_s q dT_s`` (paper, eq. 4), or of a part without a stroke,
    ``drift = sum_s C_s dT_s``.

    Attributes
    ----------
    kind : str
        ``"leg"`` (A and B) or ``"component"`` (C).
    sensors : tuple of str
    coefficients : array, shape (2 k,) [1/K] or (k,) [m/K]
        ``[A_1 .. A_k, B_1 .. B_k]``, or ``[C_1 .. C_k]``.
    covariance : array, shape (p, p)
    retracted_length : float or None [m]
    stroke : (float, float) or None [m]
    zero : str
        What temperatures and drift count from: ``"run"``, each run's first row, or ``"campaign"``, the first run's.
    validity : Validity
    noise : ResidualNoise
    errors : SensorErrors
        Of the law's own sensors.
    factor : float
        Half of a 95 % prediction interval over the predicted standard deviation.
    origin : Origin
    """

    kind: str
    sensors: tuple[str, ...]
    coefficients: FloatArray
    covariance: FloatArray
    retracted_length: float | None
    stroke: tuple[float, float] | None
    zero: str
    validity: Validity
    noise: ResidualNoise
    errors: SensorErrors
    factor: float = 1.96
    origin: Origin = field(default_factory=Origin)

    def __post_init__(self) -> None:
        p = len(self.sensors) * (2 if self.kind == "leg" else 1)
        if self.coefficients.shape != (p,) or self.covariance.shape != (p, p):
            raise ArgumentError(
                f"a law of kind {self.kind!r} with {len(self.sensors)} sensors has {p} coefficients; found "
                f"{self.coefficients.shape} and covariance {self.covariance.shape}"
            )
        if self.kind == "leg" and self.retracted_length is None:
            raise ArgumentError("a leg's law needs the retracted length q0")
        object.__setattr__(self, "coefficients", frozen(self.coefficients))
        object.__setattr__(self, "covariance", frozen(self.covariance))

    @property
    def A(self) -> FloatArray:
        """Coefficients of the retracted length [1/K]; of a component, C [m/K]."""
        return self.coefficients[: len(self.sensors)]

    @property
    def B(self) -> FloatArray:
        """Coefficients of the stroke [1/K]; empty for a component."""
        return self.coefficients[len(self.sensors) :]

    @property
    def standard_uncertainty(self) -> FloatArray:
        """Of each coefficient."""
        return np.sqrt(np.diagonal(self.covariance))

    def columns(self, dT: FloatArray, q: FloatArray | None) -> FloatArray:
        """Return the columns ``q0 dT_s, q dT_s`` (or ``dT_s``) that the coefficients multiply, shape (n, p)."""
        if self.kind != "leg":
            return dT
        if q is None:
            raise ArgumentError("a leg's law needs the displacement q")
        return np.concatenate([dT * float(self.retracted_length or 0.0), dT * q[:, None]], axis=1)

    def predict(self, dT: FloatArray, q: FloatArray | None = None) -> FloatArray:
        """Return the predicted drift [m] of rows.

        Parameters
        ----------
        dT : array, shape (n, k) [K]
            Of the law's sensors, in their order.
        q : array, shape (n,) [m]
            Displacement of the rod; None for a component.
        """
        return np.asarray(self.columns(dT, q) @ self.coefficients)

    def slopes(self, q: FloatArray | None, count: int) -> FloatArray:
        """Return each sensor's ``A q0 + B q`` in rows, shape (n, k) [m/K]."""
        if self.kind != "leg" or q is None:
            return np.broadcast_to(self.A, (count, len(self.sensors)))
        return np.asarray(self.A * float(self.retracted_length or 0.0) + self.B * q[:, None])

    def variance(self, dT: FloatArray, q: FloatArray | None, time: FloatArray) -> FloatArray:
        """Return the variance of ``measured - predicted`` in rows of a new run [m^2].

        It holds the coefficients' covariance, the residual's noise and the thermometers' errors.
        """
        X = self.columns(dT, q)
        own = np.einsum("np,pq,nq->n", X, self.covariance, X)
        thermometers = (self.slopes(q, len(dT)) ** 2 * self.errors.variance(time)).sum(axis=1)
        return np.asarray(own + self.noise.variance + thermometers)

    def leg_law(self) -> LegLaw:
        """Return the law as a machine's leg carries it."""
        if self.kind != "leg":
            raise ArgumentError("a law of kind 'component' has no A and B: no leg can carry it")
        return LegLaw(self.sensors, self.A, self.B, self.covariance, self.origin.title)
