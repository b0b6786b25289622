"""A law that was identified: coefficients, terms, their covariance, the residual's noise, and where it holds."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from itertools import pairwise

import numpy as np

from hexathermal.errors import ArgumentError
from hexathermal.learn.coverage import TWO_SIDED
from hexathermal.learn.noise import ResidualNoise
from hexathermal.learn.sensor_errors import SensorErrors
from hexathermal.machine.leg_repairs import SensorRepair, repaired
from hexathermal.machine.leg_signals import LegSignals
from hexathermal.machine.leg_states import (
    LegController,
    LegMemory,
    of_leg,
    sensors_of,
    terms_columns,
    terms_drift,
)
from hexathermal.machine.leg_terms import LegTerm
from hexathermal.machine.shown import Shown
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
class IdentifiedLaw(Shown):
    """The law of a leg, ``drift = sum_s A_s q0 dT_s + B_s q dT_s`` (paper, eq. 4), or of another part,
    ``drift = sum_s C_s dT_s``, ``sum_s C_s dT_s + D_s q dT_s`` where what expands goes with its displacement q.
    Terms add ``sum_k a_k shape_k`` (`hexathermal.machine.leg_terms`).

    Attributes
    ----------
    kind : str
        ``"leg"`` (A and B) or ``"component"`` (C, or C and D).
    sensors : tuple of str
    coefficients : array, shape (2 k,) or (k,)
        ``[A_1 .. A_k, B_1 .. B_k]`` [1/K], ``[C_1 .. C_k]`` [m/K], or ``[C_1 .. C_k, D_1 .. D_k]`` [m/K, 1/K].
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
    terms : tuple of LegTerm
        That extend the law.
    repairs : tuple of SensorRepair
        Of the thermometers' data, before the law reads them.
    joint_covariance : array, shape (p + k, p + k), optional
        Of the coefficients and all amplitudes, in the order of the terms; without it terms are taken as independent.
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
    factor: float = TWO_SIDED
    origin: Origin = field(default_factory=Origin)
    terms: tuple[LegTerm, ...] = ()
    repairs: tuple[SensorRepair, ...] = ()
    joint_covariance: FloatArray | None = None

    def __post_init__(self) -> None:
        k, p = len(self.sensors), len(self.coefficients)
        allowed = (2 * k,) if self.kind == "leg" else (k, 2 * k)
        if self.coefficients.ndim != 1 or p not in allowed or self.covariance.shape != (p, p):
            raise ArgumentError(
                f"a law of kind {self.kind!r} with {k} sensors has {' or '.join(map(str, allowed))} coefficients; "
                f"found {self.coefficients.shape} and covariance {self.covariance.shape}"
            )
        if self.kind == "leg" and self.retracted_length is None:
            raise ArgumentError("a leg's law needs the retracted length q0")
        object.__setattr__(self, "coefficients", frozen(self.coefficients))
        object.__setattr__(self, "covariance", frozen(self.covariance))
        object.__setattr__(self, "terms", tuple(self.terms))
        object.__setattr__(self, "repairs", tuple(self.repairs))
        if self.joint_covariance is not None:
            whole = p + sum(len(term.amplitudes) for term in self.terms)
            if self.joint_covariance.shape != (whole, whole):
                raise ArgumentError(
                    f"joint_covariance has shape {self.joint_covariance.shape}; expected ({whole}, {whole}): {p} "
                    f"coefficients and {whole - p} amplitudes"
                )
            object.__setattr__(self, "joint_covariance", frozen(self.joint_covariance))

    @property
    def stroked(self) -> bool:
        """Whether the law reads the displacement q: each sensor has two coefficients."""
        return len(self.coefficients) > len(self.sensors)

    @property
    def length(self) -> float:
        """What the first coefficients multiply beside the temperature: q0 of a leg [m], 1 of a component."""
        return 1.0 if self.retracted_length is None else self.retracted_length

    @property
    def A(self) -> FloatArray:
        """Coefficients of the retracted length [1/K]; of a component, C [m/K]."""
        return self.coefficients[: len(self.sensors)]

    @property
    def B(self) -> FloatArray:
        """Coefficients of the stroke [1/K], D of a component; empty where the law does not read q."""
        return self.coefficients[len(self.sensors) :]

    @property
    def standard_uncertainty(self) -> FloatArray:
        """Of each coefficient."""
        return np.sqrt(np.diagonal(self.covariance))

    def columns(self, dT: FloatArray, q: FloatArray | None) -> FloatArray:
        """Return the columns that the coefficients multiply, shape (n, p).

        They are ``q0 dT_s, q dT_s`` of a leg, ``dT_s`` or ``dT_s, q dT_s`` of a component.
        """
        if not self.stroked:
            return dT
        if q is None:
            raise ArgumentError(f"this law of a {self.kind} needs the displacement q")
        return np.concatenate([dT * self.length, dT * q[:, None]], axis=1)

    def predict(self, dT: FloatArray | LegSignals, q: FloatArray | None = None) -> FloatArray:
        """Return the predicted drift [m] of rows.

        Parameters
        ----------
        dT : array, shape (n, k) [K], or LegSignals
            Of the law's sensors, in their order; or all rows of a run, which a law with terms or repairs needs.
        q : array, shape (n,) [m]
            Displacement, beside an array; None for a law that does not read it.

        Returns
        -------
        array, shape (n,) [m]

        Raises
        ------
        ArgumentError
            The law has terms or repairs, which temperatures and displacements of single rows do not tell.
        """
        if isinstance(dT, LegSignals):
            return self.predict_signals(dT)
        if self.extended:
            causes = [term.cause for term in self.terms] + [repair.cause for repair in self.repairs]
            names = ", ".join(dict.fromkeys(causes))
            raise ArgumentError(
                f"this law is extended by {names}, which dT and q of single rows do not tell: call "
                "predict(signals) or predict_signals(signals) with all rows of a run "
                "(hexathermal.learn.signals.run_rows), or feed law.controller() row by row"
            )
        return np.asarray(self.columns(dT, q) @ self.coefficients)

    @property
    def extended(self) -> bool:
        """Whether terms or repairs join the law."""
        return bool(self.terms or self.repairs)

    @property
    def read_sensors(self) -> tuple[str, ...]:
        """Sensors whose readings matter: of the law, its terms and its repairs."""
        replaced = {one.replaced for one in self.repairs}
        own = [name for name in (*self.sensors, *sensors_of(self.terms)) if name not in replaced]
        return tuple(dict.fromkeys([*own, *(name for one in self.repairs for name in one.sensors)]))

    def memory(self) -> LegMemory:
        """Return the memory that a run begins with."""
        return LegMemory(self.terms)

    def repaired(self, signals: LegSignals, memory: LegMemory | None = None, run: str | None = None) -> LegSignals:
        """Return signals behind the law's repairs."""
        return repaired(signals, self.repairs, run, None if memory is None else memory.repairs)

    def base_columns(self, signals: LegSignals) -> FloatArray:
        """Return the columns that the coefficients multiply in rows that are repaired, shape (n, p)."""
        dT = np.column_stack([signals.temperature(name) for name in self.sensors])
        return self.columns(dT, signals.q)

    def predict_signals(
        self, signals: LegSignals, memory: LegMemory | None = None, run: str | None = None,
        before: LegMemory | None = None,
    ) -> FloatArray:  # fmt: skip
        """Return the predicted drift [m] of rows in the order of time, terms and repairs included.

        Of a whole run, what terms add counts from the row from which the run does (`LegSignals.zero_row`), as the
        measured drift does.

        Parameters
        ----------
        signals : LegSignals
            As recorded.
        memory : LegMemory, optional
            Of the rows before (`memory()` at a run's beginning), where rows come one by one or in blocks; without it
            the rows are a whole run.
        run : str, optional
            Name of the run, for repairs that begin in a certain one.
        before : LegMemory, optional
            Of the terms in the runs before this whole run, which follows them on one clock; it goes on.

        Returns
        -------
        array, shape (n,) [m]

        Raises
        ------
        ArgumentError
            A sensor or a recorded input of a term is not there.
        """
        right = self._scaled(self.repaired(signals, memory, run))
        added = terms_drift(self.terms, right, memory if before is None else before)
        added = right.counted(added) if memory is None else added
        return np.asarray(self.base_columns(right) @ self.coefficients + added)

    def variance_signals(
        self, signals: LegSignals, run: str | None = None, before: LegMemory | None = None
    ) -> FloatArray:
        """Return the variance of ``measured - predicted`` in all rows of a new run, shape (n,) [m^2].

        As `variance`, with the amplitudes' covariance; thermometers' errors count in the coefficients' part.
        """
        right = self._scaled(self.repaired(signals, None, run))
        added = right.counted(terms_columns(self.terms, right, before))
        X = np.concatenate([self.base_columns(right), added], axis=1)
        own = np.einsum("np,pq,nq->n", X, self.whole_covariance, X)
        return self._in_rows(own, right.q, right.time)

    @property
    def whole_covariance(self) -> FloatArray:
        """Covariance of the coefficients and all amplitudes."""
        if self.joint_covariance is not None:
            return self.joint_covariance
        parts = [self.covariance, *(term.covariance for term in self.terms)]
        whole = np.zeros((sum(map(len, parts)),) * 2)
        at = 0
        for part in parts:
            whole[at : at + len(part), at : at + len(part)] = part
            at += len(part)
        return whole

    def _scaled(self, signals: LegSignals) -> LegSignals:
        """Return signals with the law's own retracted length, as `predict` takes it."""
        own = self.retracted_length
        return signals if own is None or own == signals.retracted_length else replace(signals, retracted_length=own)

    def controller(
        self, reference_degC: Mapping[str, float] | float | None = None, *, bench: bool = True
    ) -> LegController:
        """Return a controller that is given one row after the other.

        Parameters
        ----------
        reference_degC : mapping of str to float, or float, optional
            Temperatures that the law counts from; without it those of the first row.
        bench : bool
            Whether terms of the bench join (its frame, the interferometer): the drift is then that which the bench
            measures. False: the leg's own.

        Raises
        ------
        ArgumentError
            A repair needs rows that have not come yet; or with a reference, one that takes the air out of a reading:
            it counts from the first row, as the air does.
        """
        if reference_degC is not None and any(one.kind == "loose" for one in self.repairs):
            raise ArgumentError(
                "a repair takes the air out of a sensor's reading, which counts from the first row as the air does: "
                "leave reference_degC out, or fix the sensor and leave the repair out"
            )
        law = self if bench else replace(self, terms=of_leg(self.terms), joint_covariance=None)
        return LegController(law.predict_signals, law.read_sensors, law.terms, law.repairs,
                             law.length, law.stroked, reference_degC)  # fmt: skip

    def slopes(self, q: FloatArray | None, count: int) -> FloatArray:
        """Return each sensor's ``A q0 + B q`` (``C``, ``C + D q``) in rows, shape (n, k) [m/K]."""
        if not self.stroked or q is None:
            return np.broadcast_to(self.A * self.length, (count, len(self.sensors)))
        return np.asarray(self.A * self.length + self.B * q[:, None])

    def variance(self, dT: FloatArray, q: FloatArray | None, time: FloatArray) -> FloatArray:
        """Return the variance of ``measured - predicted`` in rows of a new run [m^2].

        It holds the coefficients' covariance, the residual's noise and the thermometers' errors.
        """
        X = self.columns(dT, q)
        return self._in_rows(np.einsum("np,pq,nq->n", X, self.covariance, X), q, time)

    def _in_rows(self, own: FloatArray, q: FloatArray | None, time: FloatArray) -> FloatArray:
        """Return the law's own variance with that of noise and of the thermometers' errors, shape (n,) [m^2]."""
        thermometers = (self.slopes(q, len(time)) ** 2 * self.errors.variance(time)).sum(axis=1)
        return np.asarray(own + self.noise.variance + thermometers)

    def leg_law(self) -> LegLaw:
        """Return the law as a machine's leg carries it.

        Terms of the bench and repairs of the campaign's data are left out, and from which side the bench's runs began:
        they are no property of the leg. Sensors that only terms read have A and B of 0.
        """
        if self.kind != "leg":
            raise ArgumentError("a law of kind 'component' has no A and B: no leg can carry it")
        p, whole = len(self.coefficients), self.whole_covariance
        edges = np.cumsum([p, *(len(term.amplitudes) for term in self.terms)])
        whole_terms = [
            replace(term, covariance=whole[a:b, a:b]) for term, (a, b) in zip(self.terms, pairwise(edges), strict=True)
        ]
        carried = of_leg(whole_terms)
        added = tuple(name for name in sensors_of(carried) if name not in self.sensors)
        k, more = len(self.sensors), np.zeros(len(added))
        covariance = np.zeros((p + 2 * len(added),) * 2)
        kept = np.concatenate([np.arange(k), np.arange(k) + k + len(added)])
        covariance[np.ix_(kept, kept)] = whole[:p, :p]
        return LegLaw(
            (*self.sensors, *added), np.concatenate([self.A, more]), np.concatenate([self.B, more]), covariance,
            self.origin.title, carried,
        )  # fmt: skip
