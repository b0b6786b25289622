"""Poses that tell the coefficients of a hexapod apart best: a design from candidates within strokes and cones.

Each slot of a planned run has its temperatures; for each, one pose is chosen among the candidates. Criteria, for the
information ``M`` of the coefficients with the frame of the positioning system eliminated (Pukelsheim 1993):

    D   largest  log det M                 smallest volume of the confidence region
    A   smallest trace  s M^-1 s           smallest mean variance of the coefficients in their usual sizes
    E   largest  smallest eigenvalue of  M in these sizes       best in its weakest direction

Slots are gone through in turn, each given the best pose while all others are held, until none changes (coordinate
exchange). It ends, since every exchange improves the criterion, in a design that no single exchange improves.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from hexathermal.errors import ArgumentError
from hexathermal.kinematics.inverse import inverse_kinematics
from hexathermal.learn.hexapod_fit import HexapodModel
from hexathermal.learn.hexapod_model import columns, frame_columns, row_covariance, whitened
from hexathermal.machine.hexapod import Hexapod
from hexathermal.machine.thermal import frozen
from hexathermal.poses import FloatArray, pose_from_coordinates

CRITERIA = ("D", "A", "E")
USUAL_SIZE = 1e-6
"""Expansion [1/K] that uncertainties are weighed against in A and E: all coefficients are of this order."""

SWEEPS = 8


@dataclass(frozen=True, eq=False)
class PoseDesign:
    """Chosen poses.

    Attributes
    ----------
    coordinates : array, shape (m, 6) [mm, deg]
        In the order of the slots.
    chosen : array, shape (m,), int
        Among the candidates.
    criterion : str
    covariance : array, shape (k, k) [1/K^2]
        Of the free coefficients, that the measurement's noise leaves.
    random : array, shape (k,) [1/K]
        Standard uncertainties with random poses: root mean square over `draws` draws from the candidates.
    words : tuple of str
        The free coefficients.
    sweeps : int
        Until no pose changed.
    """

    coordinates: FloatArray
    chosen: npt.NDArray[np.int64]
    criterion: str
    covariance: FloatArray
    random: FloatArray
    words: tuple[str, ...]
    sweeps: int

    @property
    def uncertainty(self) -> FloatArray:
        """Standard uncertainties of the free coefficients [1/K]."""
        return np.sqrt(np.diagonal(self.covariance))


class _Informations:
    """The information matrices of candidates in slots, coefficients first, frame last."""

    def __init__(
        self, hexapod: Hexapod, coordinates: FloatArray, dT: FloatArray, plates: FloatArray, noise: FloatArray,
        model: HexapodModel, leg_noise: float,
    ) -> None:  # fmt: skip
        self.hexapod, self.dT, self.plates, self.model = hexapod, dT, plates, model
        self.poses = pose_from_coordinates(coordinates, hexapod=hexapod)
        self.q = hexapod.strokes(inverse_kinematics(hexapod, self.poses))
        self.V = row_covariance(hexapod, self.poses, noise, leg_noise)
        self.F = frame_columns(hexapod, self.poses)

    def of(self, slot: int, which: npt.NDArray[np.int64] | slice = slice(None)) -> FloatArray:
        """Return the information of candidates in a slot, shape (N, k + 6, k + 6)."""
        q = self.q[which]
        n = len(q)
        dT = np.broadcast_to(self.dT[slot], (n, *self.dT.shape[1:]))
        X = columns(self.hexapod, self.poses[which], q, dT, np.broadcast_to(self.plates[slot], (n, 2)))
        X = X @ self.model.C[: X.shape[2]]
        W = whitened(self.V[which], np.concatenate([X * USUAL_SIZE, self.F[which] * USUAL_SIZE], axis=2))
        return np.asarray(np.swapaxes(W, 1, 2) @ W)


def _eliminated(M: FloatArray, k: int, frame: bool) -> FloatArray:
    """Return the information of the first k unknowns, shape (..., k, k), the others eliminated."""
    if not frame:
        return M[..., :k, :k]
    back = np.linalg.solve(M[..., k:, k:], M[..., k:, :k])
    return np.asarray(M[..., :k, :k] - M[..., :k, k:] @ back)


def _worth(M: FloatArray, criterion: str) -> FloatArray:
    """Return how good information matrices are, larger is better."""
    if criterion == "D":
        return np.asarray(np.linalg.slogdet(M)[1])
    values = np.linalg.eigvalsh(M)
    if criterion == "E":
        return np.asarray(values[..., 0])
    with np.errstate(divide="ignore"):
        return np.asarray(np.where(values[..., 0] > 0.0, -(1.0 / np.maximum(values, 1e-300)).sum(axis=-1), -np.inf))


def designed_poses(
    hexapod: Hexapod,
    candidates: FloatArray,
    dT: FloatArray,
    plates: FloatArray,
    noise: FloatArray,
    model: HexapodModel,
    *,
    criterion: str = "D",
    frame: bool = True,
    known: FloatArray | None = None,
    leg_noise: float = 0.0,
    seed: int = 1,
    draws: int = 20,
) -> PoseDesign:
    """Return the poses, one for each slot of temperatures, that tell the coefficients apart best.

    Parameters
    ----------
    hexapod : Hexapod
    candidates : array, shape (N, 6) [mm, deg]
        Poses that may be chosen, from home, see `reachable_coordinates`; each as often as is good.
    dT : array, shape (m, 6, s) [K]
        Of the legs' thermometers in each slot.
    plates : array, shape (m, 2) [K]
        Of platform and base; NaN: not measured.
    noise : array, shape (6,) [m, m, m, rad, rad, rad]
        Of the measured coordinates.
    model : HexapodModel
        Which coefficients are free.
    criterion : str
        ``"D"``, ``"A"`` or ``"E"``.
    frame : bool
        The frame of the positioning system is free in the run.
    known : array, shape (p, p), optional
        Information that is there already, as `HexapodEquations.S`.
    leg_noise : float [m]
    seed : int
        Of the first guess.
    draws : int
        Random designs that it is compared with.

    Raises
    ------
    ArgumentError
        The criterion is not known, or not even random poses tell the coefficients apart.
    """
    if criterion not in CRITERIA:
        raise ArgumentError(f"criterion is {criterion!r}, expected one of {', '.join(map(repr, CRITERIA))}")
    m, k, n = len(dT), model.C.shape[1], len(candidates)
    informations = _Informations(hexapod, candidates, dT, plates, noise, model, leg_noise)
    generator = np.random.default_rng(seed)
    trials = [generator.integers(n, size=m) for _draw in range(max(1, draws))]
    sums = _sums(informations, trials, known)
    random = np.array([np.diagonal(_covariance(_eliminated(M, k, frame), model)) for M in sums])
    best = int(np.argmax([_worth(_eliminated(M, k, frame), criterion) for M in sums]))
    chosen, M, sweeps = _exchanged(informations, trials[best], sums[best], criterion, (k, frame), generator)
    covariance = _covariance(_eliminated(M, k, frame), model)
    return PoseDesign(
        frozen(candidates[chosen]), chosen, criterion, covariance, np.sqrt(random.mean(axis=0)), model.words, sweeps
    )


def _sums(
    informations: _Informations, trials: list[npt.NDArray[np.int64]], known: FloatArray | None
) -> list[FloatArray]:  # fmt: skip
    """Return the information of designs, and of what is known already."""
    C = informations.model.C
    k = C.shape[1]
    base = np.zeros((k + 6, k + 6))
    if known is not None:
        base[:k, :k] = C.T @ known @ C * USUAL_SIZE**2
    return [base + sum(informations.of(slot, np.array([one]))[0] for slot, one in enumerate(trial)) for trial in trials]


def _exchanged(
    informations: _Informations, start: npt.NDArray[np.int64], M: FloatArray, criterion: str,
    unknowns: tuple[int, bool], generator: np.random.Generator,
) -> tuple[npt.NDArray[np.int64], FloatArray, int]:  # fmt: skip
    """Return the candidates in the slots after exchanging until none gains, their information, and the sweeps made."""
    k, frame = unknowns
    chosen, sweep, changed = start.copy(), 0, True
    while changed and sweep < SWEEPS:
        sweep, changed = sweep + 1, False
        for slot in generator.permutation(len(chosen)):
            each = informations.of(int(slot))
            others = M - each[chosen[slot]]
            worth = _worth(_eliminated(others + each, k, frame), criterion)
            new, now = int(np.nanargmax(worth)), worth[chosen[slot]]
            if worth[new] > now + 1e-9 * abs(now):
                chosen[slot], M, changed = new, others + each[new], True
    return chosen, M, sweep


def _covariance(M: FloatArray, model: HexapodModel) -> FloatArray:
    """Return the covariance of the free coefficients [1/K^2], or refuse where they cannot be told apart."""
    values, vectors = np.linalg.eigh(M)
    if values[0] <= 1e-13 * values[-1]:
        weak = ", ".join(model.words[j] for j in np.argsort(-np.abs(vectors[:, 0]))[:4])
        raise ArgumentError(
            f"not even random poses tell {weak} apart at these temperatures; plan other temperatures, more poses, or "
            "fewer free coefficients"
        )
    return np.asarray((vectors / values) @ vectors.T * USUAL_SIZE**2)
