"""An axis that is measured where its slide stands, of the physics and the instruments of the bench `held_out`."""

from __future__ import annotations

import numpy as np

from hexathermal.simulate.hidden.benches import held_out
from hexathermal.simulate.hidden.benches.stroked_parts import as_part
from hexathermal.simulate.hidden.truth import CampaignTruth

NAME = "held_out_axis"


def draw(generator: np.random.Generator) -> CampaignTruth:
    """Make a campaign in which nothing is hidden.

    Parameters
    ----------
    generator : numpy.random.Generator
    """
    return as_part(held_out.draw(generator), NAME, along=True)
