"""Sums over the usable rows of a run, and what follows: noise, collinearity, separability. Constant memory."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hexathermal.learn.campaign import Block
from hexathermal.learn.cleaning_rules import TO_SIGMA, noise_of
from hexathermal.poses import FloatArray

MOST_TRACE = 2048
"""Rows of a run that are kept for plots."""

SINGULAR = 1e-13
"""Eigenvalues of a correlation, as a part of the largest, up to which sensors say exactly what others say."""

FEWEST_BENDS = 10
"""Second differences within rests that a noise of the drift is taken from."""


@dataclass(frozen=True, eq=False)
class Trace:
    """Some rows of a run, evenly: time [s], `dT` [K], drift [m], q [m] or None, inputs."""

    time: FloatArray
    dT: FloatArray
    drift: FloatArray
    q: FloatArray | None
    inputs: FloatArray


@dataclass(frozen=True)
class Separability:
    """How well the rows can tell `A` and `B` of one sensor apart.

    With ``a = q0 dT`` and ``b = q dT`` the law is ``drift = A a + B b``; `r` is the cosine of the angle between the
    columns, and the uncertainties are those of least squares with one independent reading a landing.

    Attributes
    ----------
    sensor : str
    span : float [K]
        Largest ``|dT|``.
    r : float
        NaN for a part without a stroke.
    warm_q, warm_q_spread : float [m]
        Mean and standard deviation of `q`, each row weighted by ``dT**2``: where the part was when it was warm.
    std_A, std_B : float [1/K for 1 m of noise]
        Uncertainty for each metre of noise of a landing: times 1e-6 m of it, per kelvin. For a part without lengths
        `std_A` is that of the drift per kelvin [m/K for 1 m].
    """

    sensor: str
    span: float
    r: float
    warm_q: float
    warm_q_spread: float
    std_A: float
    std_B: float


class PairSums:
    """Sums of temperatures and of their products over the rows of one run, of `sensors` thermometers in pairs."""

    def __init__(self, sensors: int) -> None:
        shape = (sensors, sensors)
        self.pairs, self.first, self.second = np.zeros(shape), np.zeros(shape), np.zeros(shape)

    def add_heat(self, dT: FloatArray) -> None:
        """Add rows, shape (n, s) [K]; NaN does not count."""
        known = ~np.isnan(dT)
        zeroed, mask = np.where(known, dT, 0.0), known.astype(np.float64)
        self.pairs += mask.T @ mask
        self.first += zeroed.T @ mask
        self.second += zeroed.T @ zeroed


class RunSums(PairSums):
    """Sums over the rows of one run as they pass.

    Parameters
    ----------
    sensors : int
        Thermocouples.
    """

    def __init__(self, sensors: int) -> None:
        s = sensors
        super().__init__(s)
        self.rows, self.landings = 0, 0
        self.moments = np.zeros((3, s))
        self.lowest, self.highest = np.full(s + 5, np.inf), np.full(s + 5, -np.inf)
        self._noise: list[tuple[int, FloatArray]] = []
        self._drift_noise: list[tuple[int, float]] = []
        self._landing_noise: list[tuple[int, float]] = []
        self._kept: list[Trace] = []
        self._stride, self._next = 1, 0

    def add(self, block: Block) -> None:
        """Add the rows of a block."""
        dT, n = block.dT, len(block)
        self.add_heat(dT)
        zeroed = np.nan_to_num(dT)
        q = np.full(n, np.nan) if block.q is None else block.q
        self.moments[0] += np.square(zeroed).sum(axis=0)
        if block.q is not None:
            self.moments[1] += q @ np.square(zeroed)
            self.moments[2] += np.square(q) @ np.square(zeroed)
        seen = np.column_stack([dT, block.drift, q, block.air])
        self.lowest = np.fmin(self.lowest, np.fmin.reduce(seen, axis=0))
        self.highest = np.fmax(self.highest, np.fmax.reduce(seen, axis=0))
        self._add_noise(block)
        self._add_trace(block)
        self.rows += n
        self.landings = int(block.landing[-1]) + 1

    def _add_noise(self, block: Block) -> None:
        """Add the noises of a block."""
        if len(block) < 3:
            return
        self._noise.append((len(block), noise_of(block.dT)))
        bend = np.abs(block.drift[1:-1] - 0.5 * (block.drift[:-2] + block.drift[2:]))
        rest = block.landing[2:] == block.landing[:-2]
        for part, noises in ((bend[rest], self._drift_noise), (bend[~rest], self._landing_noise)):
            if part.size >= FEWEST_BENDS:
                noises.append((part.size, float(TO_SIGMA * np.median(part) / np.sqrt(1.5))))

    def _add_trace(self, block: Block) -> None:
        """Keep some of the rows, with twice the stride whenever they become too many."""
        rows = slice(self._next, None, self._stride)
        # copies: a view would keep the whole block in memory
        q = None if block.q is None else block.q[rows].copy()
        part = (block.time[rows].copy(), block.dT[rows].copy(), block.drift[rows].copy(), q, block.inputs[rows].copy())
        self._kept.append(Trace(*part))
        taken = len(self._kept[-1].time)
        self._next += taken * self._stride - len(block)
        while sum(len(part.time) for part in self._kept) > 2 * MOST_TRACE:
            whole = self.trace()
            kept = slice(None, None, 2)
            q = None if whole.q is None else whole.q[kept]
            odd = len(whole.time) % 2
            self._kept = [Trace(whole.time[kept], whole.dT[kept], whole.drift[kept], q, whole.inputs[kept])]
            self._next += 0 if odd == 0 else self._stride
            self._stride *= 2

    def trace(self) -> Trace:
        """Return the rows that were kept."""
        parts = self._kept
        if not parts:
            s = self.moments.shape[1]
            return Trace(np.zeros(0), np.zeros((0, s)), np.zeros(0), None, np.zeros((0, 0)))
        q = None if parts[0].q is None else np.concatenate([part.q for part in parts if part.q is not None])
        return Trace(np.concatenate([part.time for part in parts]), np.concatenate([part.dT for part in parts]),
                     np.concatenate([part.drift for part in parts]), q,
                     np.concatenate([part.inputs for part in parts]))  # fmt: skip

    def sensor_noise(self) -> FloatArray:
        """Return the noise of each sensor's single readings [K]."""
        if not self._noise:
            return np.full(self.moments.shape[1], np.nan)
        rows = np.array([count for count, _noise in self._noise], dtype=np.float64)[:, None]
        squares = np.square(np.array([noise for _count, noise in self._noise]))
        known = np.isfinite(squares)
        weight = (rows * known).sum(axis=0)
        total = np.where(known, rows * squares, 0.0).sum(axis=0)
        return np.sqrt(np.where(weight > 0.0, total / np.maximum(weight, 1.0), np.nan))

    def drift_noises(self) -> tuple[float, float]:
        """Return the noise of the drift within rests and from rest to rest [m]; NaN where there are too few rows."""
        found = []
        for noises in (self._drift_noise, self._landing_noise):
            rows = sum(count for count, _noise in noises)
            squares = sum(count * noise**2 for count, noise in noises)
            found.append(float(np.sqrt(squares / rows)) if rows else float("nan"))
        return found[0], found[1]


def collinearity(sums: Sequence[PairSums], noise: FloatArray) -> tuple[FloatArray, FloatArray, float, FloatArray]:
    """Return correlation of the sensors within runs, variance inflation, condition number, and slow deviations [K].

    A sensor's slow deviation is what the others do not explain of it, ``1 / (C^-1)_ii``, less its own noise and the
    noise that the others bring in; 0 where the others say it exactly, its inflation infinite.
    """
    s = len(noise)
    count, scatter = np.zeros((s, s)), np.zeros((s, s))
    for total in sums:
        pairs = np.maximum(total.pairs, 1.0)
        scatter += total.second - total.first * total.first.T / pairs
        count += total.pairs
    covariance = scatter / np.maximum(count, 1.0)
    spread = np.sqrt(np.diag(covariance))
    live = np.flatnonzero((spread > 0.0) & (np.diag(count) > 2))
    correlation, inflation, slow = np.full((s, s), np.nan), np.full(s, np.nan), np.full(s, np.nan)
    if not live.size:
        return correlation, inflation, float("nan"), slow
    part = covariance[np.ix_(live, live)] / np.outer(spread[live], spread[live])
    part = np.clip(0.5 * (part + part.T), -1.0, 1.0)
    np.fill_diagonal(part, 1.0)
    correlation[np.ix_(live, live)] = part
    values, vectors = np.linalg.eigh(part)
    lost = values <= SINGULAR * values[-1]
    condition = float("inf") if lost.any() else float(np.sqrt(values[-1] / values[0]))
    inverse = (vectors[:, ~lost] / values[~lost]) @ vectors[:, ~lost].T
    # what the others say exactly has no variance of its own
    told = np.square(vectors[:, lost]).sum(axis=1) > np.sqrt(SINGULAR)
    own = np.maximum(np.diag(inverse), 1.0)
    inflation[live] = np.where(told, np.inf, own)
    weights = -inverse / own[:, None] * spread[live][:, None] / spread[live][None, :]
    np.fill_diagonal(weights, 1.0)
    rest = np.square(spread[live]) / own - np.square(weights) @ np.square(np.nan_to_num(noise[live]))
    slow[live] = np.where(told, 0.0, np.sqrt(np.maximum(rest, 0.0)))
    return correlation, inflation, condition, slow


def separability(sums: list[RunSums], length: float | None, sensors: tuple[str, ...]) -> tuple[Separability, ...]:
    """Return how well each sensor's coefficients can be told apart; see `Separability`."""
    rows = sum(total.rows for total in sums)
    landings = sum(total.landings for total in sums)
    s0, s1, s2 = np.sum([total.moments for total in sums], axis=0) * (landings / max(1, rows))
    stroke = any(np.isfinite(total.lowest[len(sensors) + 1]) for total in sums)
    found = []
    for k, sensor in enumerate(sensors):
        low, high = min(total.lowest[k] for total in sums), max(total.highest[k] for total in sums)
        span = max(abs(low), abs(high)) if np.isfinite(low) else float("nan")
        if not stroke or s0[k] <= 0.0:
            alone = float(1.0 / np.sqrt(s0[k])) / (length or 1.0) if s0[k] > 0.0 else float("inf")
            found.append(Separability(sensor, span, np.nan, np.nan, np.nan, alone, np.nan))
            continue
        warm = float(s1[k] / s0[k])
        spread = float(np.sqrt(max(0.0, s2[k] / s0[k] - warm**2)))
        r = float(s1[k] / np.sqrt(s0[k] * s2[k])) if s2[k] > 0.0 else float("nan")
        free = s0[k] * spread**2  # what is left of q dT when its part along dT is taken off
        std_B = float(1.0 / np.sqrt(free)) if free > 0.0 else float("inf")
        std_A = float(np.sqrt(s2[k] / (s0[k] * free)) / (length or 1.0)) if free > 0.0 else float("inf")
        found.append(Separability(sensor, span, r, warm, spread, std_A, std_B))
    return tuple(found)
