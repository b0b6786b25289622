"""Parts with a stroke, as a ball screw or a linear stage: the physics and the motion of a leg, one measured drift.

Such a part has one displacement in place of three beams. Of most the law is ``drift = sum_s C_s dT_s``, ``C = A q0`` of
the leg that it is made of: what it follows has a fixed length. Of one that is measured where its nut or its slide
stands it is ``sum_s C_s dT_s + D_s q dT_s``, ``D = 6 B``; its log does not say when it rests.
"""

from __future__ import annotations

import numpy as np

from hexathermal.simulate.hidden.benches.noises import noted
from hexathermal.simulate.hidden.truth import CampaignTruth

ALONG = 6.0
"""B of a leg in D of a part: what is out of the nut is all that grows there, and not of Invar."""


def as_part(leg: CampaignTruth, name: str, *, along: bool = False) -> CampaignTruth:
    """Return a leg with nothing hidden as a part with a stroke.

    Parameters
    ----------
    leg : CampaignTruth
        Of kind ``"leg"``.
    name : str
        Of the bench.
    along : bool
        Whether the part is measured where it stands.
    """
    A, B = np.split(leg.coefficients, 2)
    coefficients = np.concatenate([A * leg.retracted_length, ALONG * B]) if along else A * leg.retracted_length
    part = leg.changed(kind="component", bench=name, coefficients=coefficients, dead_path=0.0, index_compensated=True,
                       notes={**leg.notes, "tells_rests": not along})  # fmt: skip
    base = [leg.sensors.index(sensor) for sensor in leg.base]
    runs = []
    for run in leg.runs:
        warmed = run.temperatures[:, base] - run.temperatures[0, base]
        drift = (warmed * part.slopes(run.q)).sum(axis=1)
        runs.append(run.changed(drift=np.asarray(drift), beam_effects=np.zeros_like(run.beam_effects)))
    return noted(part.changed(runs=tuple(runs)))
