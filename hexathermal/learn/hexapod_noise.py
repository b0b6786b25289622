"""Noise of measured poses, frames of the positioning system and its misses: found in turns, by fits of the rows alone.

A row is a miss where the squared residual of its six coordinates, each over its robust spread, exceeds `MISSED` times
the usual one. The residual is that of laws fitted to the same rows, one a leg: identification and validation have one
rule, and a bad law that is validated makes no misses.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hexathermal.errors import DataError
from hexathermal.kinematics.jacobian import jacobian
from hexathermal.learn.hexapod_data import AXES, HexapodRows
from hexathermal.learn.hexapod_fit import HexapodFit, fit_model, model_of
from hexathermal.learn.hexapod_model import HexapodEquations, hexapod_equations, pose_residuals, used
from hexathermal.poses import FloatArray

START_NOISE = np.array([1e-6, 1e-6, 1e-6, 2e-6, 2e-6, 2e-6])
"""First guess of the coordinates' noise; the residuals replace it [m, rad]."""

SMALLEST_NOISE = 1e-12
"""Noise of a coordinate below this [m, rad] is rounding: simulated data without noise."""

MISSED = 45.0
"""A row whose squared weighted residual over six coordinates exceeds this many times the usual square of one is a miss
of the positioning system: in normal noise, one row in 10^7."""

MEDIAN_CHI2_6 = 5.348
ROUNDS, JUDGED = 4, 3
"""Turns in all, and those in which misses are looked for, each time among all rows: a large one draws the first fit
away, so that good rows seem to miss."""


@dataclass(frozen=True)
class Kinds:
    """What all kinds of laws share: thermometers, those chosen, expansions of plates (None: free), and the frame."""

    sensors: tuple[str, ...]
    chosen: tuple[str, ...]
    plates: tuple[float | None, float | None]
    frame: str

    def fit(self, equations: HexapodEquations, name: str, given: FloatArray | None = None) -> HexapodFit:
        """Return the fit of a kind of laws."""
        extra = tuple(f"frame {axis}" for axis in AXES) if self.frame == "campaign" else ()
        return fit_model(equations, model_of(name, self.sensors, self.chosen, common=name == "common",
                                             plates=self.plates, legs=given, extra=extra))  # fmt: skip

    def widest(self, equations: HexapodEquations) -> HexapodFit:
        """Return the leg-specific fit, or the common one where rows cannot tell the legs apart."""
        try:
            return self.fit(equations, "leg-specific")
        except DataError:
            return self.fit(equations, "common")


def settled(
    rows: HexapodRows, kinds: Kinds, noise: FloatArray | None, rounds: int = ROUNDS
) -> tuple[HexapodRows, HexapodEquations, FloatArray, float, FloatArray]:
    """Return rows without misses, their equations, noise of coordinates and of legs, and frames: found in turns."""
    sigma, leg_noise = START_NOISE if noise is None else np.asarray(noise, dtype=np.float64), 0.0
    frames, whole = np.zeros((len(rows.runs), 6)), rows
    for turn in range(rounds):
        equations = hexapod_equations(rows, sigma, leg_noise, kinds.frame, frames)
        fit = kinds.widest(equations)
        frames = frames + frames_of(rows, equations, fit.b, kinds.frame)
        if turn < JUDGED:
            rows = _without_misses(whole, pose_residuals(whole, leg_and_plate(fit.b, rows), frames))
        left = pose_residuals(rows, leg_and_plate(fit.b, rows), frames)
        if noise is None:
            unknowns = fit.theta.size + (6 * len(rows.runs) if kinds.frame == "run" else 0)
            sigma = np.sqrt((left**2).sum(axis=0) / max(1.0, len(rows) - unknowns / 6.0))
            sigma = np.maximum(sigma, SMALLEST_NOISE)
        elif turn:
            leg_noise = _leg_noise(rows, fit, leg_noise, sigma)
    return rows, hexapod_equations(rows, sigma, leg_noise, kinds.frame, frames), sigma, leg_noise, frames


def leg_and_plate(b: FloatArray, rows: HexapodRows) -> FloatArray:
    """Return the coefficients of legs and plates, without a campaign's frame."""
    return b[: 12 * len(rows.sensors) + 2]


def frames_of(rows: HexapodRows, equations: HexapodEquations, b: FloatArray, frame: str) -> FloatArray:
    """Return the frame of each run that belongs to b, shape (runs, 6)."""
    found = np.zeros((len(rows.runs), 6))
    if frame == "campaign":
        found[:] = b[-6:]
    elif frame == "run":
        for run in equations.runs:
            found[rows.runs.index(run.run)] = run.frame(b)
    return found


def _without_misses(rows: HexapodRows, left: FloatArray) -> HexapodRows:
    """Return rows without those where the positioning system missed, by the residuals of all."""
    scale = np.median(np.abs(left), axis=0) / 0.6745
    square = ((left / np.where(scale > 0.0, scale, 1.0)) ** 2).sum(axis=1)
    usual = float(np.median(square)) / MEDIAN_CHI2_6
    keep = square <= MISSED * max(usual, 1e-300)
    reason = f"the positioning system missed (squared residual above {MISSED:g} times the usual)"
    return used(rows, keep, reason)


def _leg_noise(rows: HexapodRows, fit: HexapodFit, before: float, noise: FloatArray) -> float:
    """Return what the legs add to a given noise, so that the weighted residuals come out as they should."""
    ratio = fit.chi2 / fit.freedom
    # within three standard deviations of chance, the given noise explains all
    if ratio <= 1.0 + 3.0 * np.sqrt(2.0 / fit.freedom) and before == 0.0:
        return 0.0
    J = jacobian(rows.hexapod, rows.measured)
    tracker = float(((J * noise) ** 2).sum(axis=2).mean())
    return float(np.sqrt(max(0.0, (tracker + before**2) * ratio - tracker)))


def without_misses(rows: HexapodRows) -> tuple[HexapodRows, str]:
    """Return rows without misses of the positioning system, by the rule of identification, and what is to be said.

    Laws of each leg, of recorded plates and a frame for each run are fitted to these rows for this alone.

    Parameters
    ----------
    rows : HexapodRows

    Returns
    -------
    rows : HexapodRows
        Those left out are counted in `left_out`.
    note : str
        Why misses cannot be told, where too few rows or constant temperatures leave nothing to fit; else empty.
    """
    plates = tuple(None if known else 0.0 for known in rows.recorded_plates)
    kinds = Kinds(rows.sensors, rows.sensors, (plates[0], plates[1]), "run")
    unknowns = 12 * len(rows.sensors) + 2 + 6 * len(rows.runs)
    if len(rows) * 6 < 2 * unknowns:
        return rows, f"{len(rows)} poses are too few to tell misses of the positioning system: none was looked for"
    try:
        return settled(rows, kinds, None, rounds=JUDGED)[0], ""
    except DataError:
        return (
            rows,
            "misses of the positioning system cannot be told, for temperatures hardly change: none was looked for",
        )
