"""Parts with a stroke, as a ball screw or a linear stage: the physics and the motion of a leg, one measured drift.

Such a part has one displacement in place of three beams, and a law ``drift = sum_s C_s dT_s``, ``C = A q0`` of the leg
that it is made of: what it follows has a fixed length.
"""

from __future__ import annotations

import numpy as np

from hexathermal.simulate.hidden.benches.noises import noted
from hexathermal.simulate.hidden.truth import CampaignTruth


def as_part(leg: CampaignTruth, name: str) -> CampaignTruth:
    """Return a leg with nothing hidden as a part with a stroke.

    Parameters
    ----------
    leg : CampaignTruth
        Of kind ``"leg"``.
    name : str
        Of the bench.
    """
    slopes = np.split(leg.coefficients, 2)[0] * leg.retracted_length
    base = [leg.sensors.index(sensor) for sensor in leg.base]
    runs = []
    for run in leg.runs:
        warmed = run.temperatures[:, base] - run.temperatures[0, base]
        runs.append(run.changed(drift=np.asarray(warmed @ slopes), beam_effects=np.zeros_like(run.beam_effects)))
    return noted(leg.changed(kind="component", bench=name, coefficients=slopes, runs=tuple(runs), dead_path=0.0,
                             index_compensated=True))  # fmt: skip
