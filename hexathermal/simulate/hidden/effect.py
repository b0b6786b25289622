"""What an effect is: a name, parameters that can be drawn, and what it does to the truth of a campaign."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Generic, TypeAlias, TypeVar

import numpy as np

from hexathermal.simulate.hidden.truth import CampaignTruth

Truth = TypeVar("Truth")
"""What is true of a campaign: `CampaignTruth`, or `hexathermal.simulate.hidden.machines.truth.MachineTruth`."""

Parameters: TypeAlias = Mapping[str, float | int | str]
"""Parameters of an effect: SI units; ``target`` names the sensor on which it sits; angles are in rad."""


def always(truth: object) -> bool:
    """Return that every campaign can have the effect."""
    return True


def with_stroke(truth: CampaignTruth) -> bool:
    """Return whether the part has a stroke that it uses."""
    return any(np.ptp(run.q) > 1e-6 for run in truth.runs)


def with_beams(truth: CampaignTruth) -> bool:
    """Return whether interferometers measure the displacement."""
    return truth.kind == "leg"


@dataclass(frozen=True)
class HiddenEffect(Generic[Truth]):
    """One way in which a campaign departs from its law.

    Attributes
    ----------
    name : str
        As in the catalogue of causes; effects that no catalogue has begin with ``"outside: "``.
    draw : callable
        ``draw(truth, generator) -> parameters``: from ranges that such machines show.
    hide : callable
        ``hide(truth, parameters) -> truth``: the same parameters hide the same. What a thermometer sits on
        (`RunTruth.temperatures`) is never changed; a thermometer's fault goes into its errors.
    possible : callable
        Whether a campaign can have it at all.
    amplitude : str
        Name of the parameter that makes it stronger; empty where nothing does.
    limits : (float, float)
        Smallest and largest absolute value of that parameter.
    readings : bool
        Whether it changes what thermometers read, not the displacement.
    lost : bool
        Whether what the thermometer should have read is gone: others must stand in for it.
    """

    name: str
    draw: Callable[[Truth, np.random.Generator], Parameters]
    hide: Callable[[Truth, Parameters], Truth]
    possible: Callable[[Truth], bool] = always
    amplitude: str = ""
    limits: tuple[float, float] = (0.0, float("inf"))
    readings: bool = False
    lost: bool = False

    def hidden_by(self, parameters: Parameters) -> Callable[[Truth], Truth]:
        """Return `hide` with these parameters."""
        return lambda truth: self.hide(truth, parameters)


Effect: TypeAlias = HiddenEffect[CampaignTruth]
"""An effect on a leg or a component."""


def target_of(parameters: Parameters) -> str | None:
    """Return the sensor or the part on which an effect sits, or None."""
    return str(parameters["target"]) if "target" in parameters else None
