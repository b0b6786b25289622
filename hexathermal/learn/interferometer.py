"""From the readings of several interferometer beams to a change of length."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from hexathermal.poses import FloatArray, finite_array


def corrected_beams(
    beams: npt.ArrayLike,
    q: npt.ArrayLike,
    index: npt.ArrayLike,
    *,
    zero_index: float,
    zero_q: float,
    dead_path: float,
    nominal_index: float | None = None,
) -> FloatArray:
    """Return beams corrected for the index of air over the whole path that was zeroed."""
    D = finite_array(beams, (), "beams")
    path = dead_path + finite_array(q, (), "q")
    n = finite_array(index, (), "index")
    scale = 1.0 if nominal_index is None else nominal_index / zero_index
    return np.asarray(D * scale - (path * (n - zero_index) / zero_index)[..., None])
