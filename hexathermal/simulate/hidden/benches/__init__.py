"""Benches of different physics, motion, sampling and instruments; each makes a campaign with no effect in it.

A bench is a module of this folder that holds ``NAME`` and ``draw(generator)``, which returns a
`hexathermal.simulate.hidden.truth.CampaignTruth`: effects zero, levels of noise in its `notes`. It is found by itself;
modules without a ``NAME`` hold what several benches use.

Every bench states in `notes`: ``noise_rms_um`` (of the displacement's noise on settled rows of identification runs,
spikes left out), ``thermometers_rms_um`` (of the drift that errors of the law's thermometers feign there),
``white_um``, ``landing_um``, ``slow_um``, ``slow_time_s``, ``sensor_noise_K``, ``sensor_bias_K``,
``sensor_walk_6h_K`` (standard deviation of a thermometer's walk after 6 h), ``sample_s``, and ``drift_resolution_um``
and ``temperature_resolution_K``, to which a log is rounded after an effect has been hidden (0: not rounded; without an
effect the errors of the run hold the rounding already).
"""

from __future__ import annotations

from typing import Protocol, cast

import numpy as np

from hexathermal.simulate.hidden.found_modules import chosen, modules_of
from hexathermal.simulate.hidden.truth import CampaignTruth


class Bench(Protocol):
    """A bench's module."""

    NAME: str

    def draw(self, generator: np.random.Generator) -> CampaignTruth:
        """Make a campaign in which nothing is hidden."""


def found() -> dict[str, Bench]:
    """Return the benches of this folder by their name.

    Examples
    --------
    >>> {"component", "modal", "quiet"} <= set(found())
    True
    """
    return {module.NAME: cast(Bench, module) for module in modules_of(__name__, __file__) if hasattr(module, "NAME")}


def draw(name: str, generator: np.random.Generator) -> CampaignTruth:
    """Make a campaign of a bench, with nothing hidden in it.

    Parameters
    ----------
    name : str
        A name of `found`.
    generator : numpy.random.Generator
        All that is random comes from it: the same state, the same campaign.

    Raises
    ------
    UnknownNameError
        If no bench has the name.

    Examples
    --------
    >>> campaign = draw("modal", np.random.default_rng(1))
    >>> campaign.kind, len(campaign.sensors), len(campaign.runs)
    ('leg', 17, 12)
    """
    return chosen(name, found(), "bench").draw(generator)
