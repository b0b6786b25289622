"""What is usual of three beams: their noise against each other, their jumps, and how they part where the rod moves."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hexathermal.learn.cleaning_channels import SMALLEST_MOVE_M
from hexathermal.learn.cleaning_rules import TO_SIGMA, Flags, medians_of_five, noise_of
from hexathermal.learn.cleaning_sheets import Sheet
from hexathermal.poses import FloatArray

FEWEST = 10
"""Second differences that a noise is taken from."""


@dataclass(frozen=True, eq=False)
class Tilts:
    """How far the beams part at the movements of a run's first rows; m rows that do not rest as the row before.

    Attributes
    ----------
    time : array, shape (m,) [s]
    reach, lasted : array, shape (m,) [m], [s]
        Span of the displacement, and of the time, over five rows before and five behind.
    size : array, shape (m,) [m]
        Largest of the beams' jumps against the others, medians of five rows.
    """

    time: FloatArray
    reach: FloatArray
    lasted: FloatArray
    size: FloatArray


@dataclass(frozen=True, eq=False)
class BeamScales:
    """What is usual of beams.

    Attributes
    ----------
    noise, between : array, shape (3,) [m]
        Of each beam against the others, from row to row of all rows, and of rows that do not rest with both neighbours.
    jump, calm : array, shape (3,) [m]
        Of the medians of five rows behind and before: of all rows, and of those of one rest.
    at_rest, drift_between : float [m]
        Noise of the mean drift within rests, and over all rows.
    tilts : Tilts
    """

    noise: FloatArray
    between: FloatArray
    jump: FloatArray
    calm: FloatArray
    at_rest: float
    drift_between: float
    tilts: Tilts


def against_others(beams: FloatArray) -> FloatArray:
    """Return each beam less the mean of the others, shape (n, 3)."""
    total = beams.sum(axis=1, keepdims=True)
    return np.asarray(beams - (total - beams) / (beams.shape[1] - 1))


def measured(sheet: Sheet) -> FloatArray:
    """Return the drift as read, up to a constant: mean of the beams less the displacement, or the table's own."""
    if sheet.beams.shape[1]:
        return np.asarray(sheet.beams.mean(axis=1) - sheet.q[:, 0])
    return sheet.drift[:, 0]


def resting(sheet: Sheet) -> Flags:
    """Return which rows rest as the row before them."""
    fresh = sheet.fresh[:, 0].astype(bool)
    if sheet.q.shape[1]:
        moved = np.abs(np.diff(sheet.q[:, 0], prepend=sheet.q[0, 0])) > SMALLEST_MOVE_M
        fresh = fresh | moved
    return np.asarray(~fresh)


def beam_scales(sheet: Sheet, rest: Flags) -> BeamScales:
    """Return what is usual in the first rows of a run; `rest` says which rows rest as the row before."""
    drift = measured(sheet)
    within = rest[1:-1] & rest[2:]
    bend = drift[1:-1] - 0.5 * (drift[:-2] + drift[2:])
    between = float(np.nan_to_num(noise_of(drift[:, None])[0])) if len(drift) > 2 else 0.0
    at_rest = TO_SIGMA * float(np.median(np.abs(bend[within]))) / np.sqrt(1.5) if within.sum() >= FEWEST else between
    if not sheet.beams.shape[1]:
        none = np.zeros(0)
        return BeamScales(none, none, none, none, at_rest, between, Tilts(none, none, none, none))
    apart = against_others(sheet.beams)
    jump = jumps(apart)
    usual = TO_SIGMA * np.median(np.abs(jump), axis=0) if len(jump) else np.zeros(apart.shape[1])
    held = _held(rest)
    calm = TO_SIGMA * np.median(np.abs(jump[held]), axis=0) if held.sum() >= FEWEST else usual
    noise = np.nan_to_num(noise_of(apart)) if len(apart) > 2 else np.zeros(apart.shape[1])
    moving = noise
    if (~within).sum() >= FEWEST:
        bends = np.abs(apart[1:-1] - 0.5 * (apart[:-2] + apart[2:]))[~within]
        moving = np.maximum(noise, TO_SIGMA * np.median(bends, axis=0) / np.sqrt(1.5))
    return BeamScales(noise, moving, usual, calm, at_rest, between, _tilts(sheet, rest, jump))


def _tilts(sheet: Sheet, rest: Flags, jump: FloatArray) -> Tilts:
    """Return how far the beams part where the rod moves."""
    rows = np.flatnonzero(~rest)
    time, q = sheet.time[:, 0], sheet.q[:, 0]
    return Tilts(time[rows], spans(q)[rows], spans(time)[rows], np.abs(jump[rows]).max(axis=1))


def _held(rest: Flags) -> Flags:
    """Return the rows with five rows before and five from it on in one rest."""
    windows = np.lib.stride_tricks.sliding_window_view(np.pad(rest, (4, 4)), 9)
    return np.asarray(windows.all(axis=1))


def spans(values: FloatArray) -> FloatArray:
    """Return the span of values over the five rows before each row and five from it on, shape (n,)."""
    windows = np.lib.stride_tricks.sliding_window_view(np.pad(values, (5, 4), mode="edge"), 10)
    return np.asarray(np.ptp(windows, axis=1))


def span_at(values: FloatArray, row: int) -> float:
    """Return what `spans` gives at one row."""
    return float(np.ptp(values[max(0, row - 5) : row + 5]))


def jumps(values: FloatArray) -> FloatArray:
    """Return the median of five rows from a row on less that of the five rows before it, mirrored at the ends."""
    fives = medians_of_five(np.pad(values, ((5, 4), (0, 0)), mode="symmetric"))
    return np.asarray(fives[5:] - fives[:-5])
