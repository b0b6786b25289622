"""The parts of the bench `component`, with instruments as they were found on a measured machine tool.

Of its thermometers from row to row, by second differences: 4.5 to 20 mK each 15 s, one 90 to 150 mK; nothing rounded.
"""

from __future__ import annotations

import numpy as np

from hexathermal.simulate.hidden.benches.component import Instruments, measured
from hexathermal.simulate.hidden.truth import CampaignTruth

NAME = "machine_tool"

FINE = Instruments((15.0, 30.0), (0.005, 0.02), (0.003, 0.015), 0.0, 0.1, 0.001)


def draw(generator: np.random.Generator) -> CampaignTruth:
    """Make a campaign in which nothing is hidden; ``stroke`` is (0, 0) where the part has none.

    Parameters
    ----------
    generator : numpy.random.Generator
    """
    return measured(NAME, FINE, generator)
