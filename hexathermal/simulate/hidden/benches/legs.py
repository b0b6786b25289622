"""What benches of a leg share: the law's drift, and the scatter of landings."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hexathermal.poses import FloatArray
from hexathermal.simulate.hidden.benches.noises import log_uniform


@dataclass(frozen=True, eq=False)
class Leg:
    """A leg and its law.

    Attributes
    ----------
    retracted_length, stroke : float [m]
    base : tuple of int
        Columns of the law's thermocouples.
    coefficients : array, shape (2 k,) [1/K]
        ``[A_1 .. A_k, B_1 .. B_k]``.
    """

    retracted_length: float
    stroke: float
    base: tuple[int, ...]
    coefficients: FloatArray

    def drift(self, temperatures: FloatArray, q: FloatArray) -> FloatArray:
        """Return ``sum_s A_s q0 dT_s + B_s q dT_s`` [m] (paper, eq. 4), temperatures from the first row."""
        dT = temperatures[:, self.base] - temperatures[0, self.base]
        A, B = np.split(self.coefficients, 2)
        return np.asarray(self.retracted_length * (dT @ A) + q * (dT @ B))


def drawn_leg(bases: tuple[tuple[int, ...], ...], generator: np.random.Generator) -> Leg:
    """Return a leg of a real actuator's size, its law on one of some choices of thermocouples.

    Sum of A 1 to 3e-6 /K and of B 0.5 to 2e-6 /K: Invar with steel parts, less what the scale itself expands.
    """
    length = generator.uniform(0.350, 0.700)
    stroke = generator.uniform(0.150, min(0.300, length - 0.180))
    base = bases[generator.integers(len(bases))]
    shares = [generator.dirichlet(np.full(len(base), 8.0)) for _ in range(2)]
    A, B = log_uniform(1e-6, 3e-6, generator), log_uniform(0.5e-6, 2e-6, generator)
    return Leg(round(length, 4), round(stroke, 4), base, np.concatenate([A * shares[0], B * shares[1]]))
