"""Thermometers that are taped on: a little of each reading is the air's, by the tape and along the wires."""

from __future__ import annotations

import numpy as np

from hexathermal.simulate.hidden.loggers import with_errors
from hexathermal.simulate.hidden.truth import CampaignTruth

OFTEN = 1.0 / 3.0
"""How often a campaign's thermometers are taped on."""

MOST = 0.05
"""The largest part of the air in a reading. Engineering value: 1 to 5 % under foil tape, less in a drilled hole."""


def with_contacts(truth: CampaignTruth, generator: np.random.Generator) -> CampaignTruth:
    """Return the campaign with what its contacts add to all readings, ``g (T_air - T)``; to none in most campaigns."""
    often, parts = generator.random(), generator.uniform(0.0, MOST, len(truth.sensors))
    if often > OFTEN or any(np.isnan(run.air[:, 0]).any() for run in truth.runs):
        return truth
    return with_errors(truth, [parts * (run.air[:, :1] - run.temperatures) for run in truth.runs])
