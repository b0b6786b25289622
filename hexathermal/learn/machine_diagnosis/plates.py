"""What both plates share: a candidate of one parameter, the change of an expansion."""

from __future__ import annotations

import numpy as np

from hexathermal.learn.hexapod_data import PLATES
from hexathermal.learn.machine_diagnosis.candidate import Candidate
from hexathermal.learn.machine_diagnosis.view import MachineView

USUAL_PER_K = 5e-6


def plate_candidates(view: MachineView, cause: str, part: str) -> list[Candidate]:
    """Return the candidate of a plate, where its temperature is recorded and leaves its zero.

    Parameters
    ----------
    view : MachineView
    cause : str
    part : str
        ``"platform"`` or ``"base"``.
    """
    column = view.plate_column(part)
    if not column.any():
        return []
    settings = {"sensor": view.plate_sensors[PLATES.index(part)]}
    return [Candidate(cause, part, ("expansion_change_per_K",), ("1/K",), column[..., None], np.array([USUAL_PER_K]),
                      np.zeros(1), settings)]  # fmt: skip
