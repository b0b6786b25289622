"""An actuator: a part with a stroke, of the physics and the instruments of one of four benches of legs."""

from __future__ import annotations

import numpy as np

from hexathermal.simulate.hidden.benches import finite_volume, modal, quiet, rough
from hexathermal.simulate.hidden.benches.stroked_parts import as_part
from hexathermal.simulate.hidden.truth import CampaignTruth

NAME = "actuator"
LEGS = (finite_volume, modal, quiet, rough)


def draw(generator: np.random.Generator) -> CampaignTruth:
    """Make a campaign in which nothing is hidden.

    Parameters
    ----------
    generator : numpy.random.Generator
    """
    return as_part(LEGS[int(generator.integers(len(LEGS)))].draw(generator), NAME)
