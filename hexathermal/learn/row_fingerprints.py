"""Fingerprints of the rows of runs: they tell a table again, renamed, moved, or stored in another format.

Rows of a leg count as they are used, after cleaning; their time, displacement and drift enter, less those of the run's
first row, so that neither the names of columns and runs nor the zero of the campaign matter. Of a whole hexapod time,
displacements of the six rods and measured pose enter, in every row that has them, whatever its thermometers say.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Iterator

import numpy as np

from hexathermal.learn.campaign import Block
from hexathermal.poses import FloatArray

STEPS = np.array([1e-6, 1e-9, 1e-12])
"""What time [s], displacement [m] and drift [m] are rounded to, so that the last bit of a sum does not matter."""


class RowFingerprints:
    """SHA-256 of the rows of each run as they pass, however they are cut into blocks."""

    def __init__(self) -> None:
        self._runs: dict[str, tuple[FloatArray, hashlib._Hash]] = {}

    def passing(self, blocks: Iterable[Block]) -> Iterator[Block]:
        """Give blocks on after adding them."""
        for block in blocks:
            self.add(block)
            yield block

    def add(self, block: Block) -> None:
        """Add the rows of a block."""
        q = np.zeros(len(block)) if block.q is None else block.q
        values = np.column_stack([block.time, q, block.drift])
        values = values[np.isfinite(values).all(axis=1)]
        self._add(block.run.name, values, STEPS)

    def add_poses(self, run: str, time: FloatArray, q: FloatArray, measured: FloatArray) -> None:
        """Add the rows of a whole hexapod: time (n,) [s], displacements (n, 6) [m], measured poses (n, 6) [m, rad]."""
        values = np.column_stack([time, q, measured])
        steps = np.concatenate([STEPS[:1], np.full(6, STEPS[1]), np.full(6, STEPS[2])])
        self._add(run, values[np.isfinite(values).all(axis=1)], steps)

    def _add(self, run: str, values: FloatArray, steps: FloatArray) -> None:
        """Add complete rows."""
        if not len(values):
            return
        first, digest = self._runs.setdefault(run, (values[0], hashlib.sha256()))
        # adding 0.0 makes 0.0 of -0.0
        digest.update((np.rint((values - first) / steps) + 0.0).astype("<f8").tobytes())

    def made(self) -> dict[str, str]:
        """Return the fingerprint of each run."""
        return {name: digest.hexdigest() for name, (_first, digest) in self._runs.items()}
