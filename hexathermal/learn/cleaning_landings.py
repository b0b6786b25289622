"""The rests of a run: stops of what moves; of a part that has no stroke, stretches between changes of its inputs."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from hexathermal.learn.cleaning_channels import SMALLEST_MOVE_M
from hexathermal.learn.cleaning_rules import noise_of
from hexathermal.learn.cleaning_sheets import Sheet
from hexathermal.poses import FloatArray

INPUT_NOISES, INPUT_PART = 8.0, 0.05
"""An input that changes from row to row by more than so many of its noises, and by more than this part of its span from
nothing so far, starts another stretch: a motor that stood still at first had no noise then."""


class Landings:
    """Numbers the rests of a run, or the stretches between changes of its inputs."""

    def __init__(self) -> None:
        self._number = -1
        self._last: FloatArray | None = None
        self._noise: FloatArray | None = None
        self._ends: tuple[FloatArray, FloatArray] | None = None

    def numbered(self, sheet: Sheet) -> npt.NDArray[np.int64]:
        """Return the number of the landing of each row."""
        has_stroke = sheet.q.shape[1] > 0
        watched = sheet.q if has_stroke else sheet.inputs
        limit = SMALLEST_MOVE_M if has_stroke else self._least_change(watched)
        before = watched[:1] if self._last is None else self._last
        step = np.abs(np.diff(watched, axis=0, prepend=before)) > limit
        fresh = step.any(axis=1) | sheet.fresh[:, 0].astype(bool)
        if self._number < 0:
            fresh[0] = True
        self._last = watched[-1:].copy()
        numbers = self._number + np.cumsum(fresh)
        self._number = int(numbers[-1])
        return numbers.astype(np.int64)

    def _least_change(self, inputs: FloatArray) -> FloatArray:
        """Return by what each input must change at each row to begin another stretch, shape (n, k)."""
        if self._noise is None:
            self._noise = np.nan_to_num(noise_of(inputs)) if len(inputs) > 2 else np.zeros(inputs.shape[1])
        return np.maximum(np.maximum(INPUT_NOISES * self._noise, 1e-9), INPUT_PART * self._spans(inputs))

    def _spans(self, inputs: FloatArray) -> FloatArray:
        """Return the span of each input, and of nothing, up to each row, shape (n, k)."""
        nothing = np.zeros((1, inputs.shape[1]))
        low, high = (nothing, nothing) if self._ends is None else self._ends
        least = np.fmin.accumulate(np.concatenate([low, inputs]))[1:]
        most = np.fmax.accumulate(np.concatenate([high, inputs]))[1:]
        self._ends = least[-1:].copy(), most[-1:].copy()
        return np.asarray(most - least)
