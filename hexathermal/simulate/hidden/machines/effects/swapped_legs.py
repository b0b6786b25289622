"""The thermometers of two legs are exchanged: each leg's columns hold what the other's thermometers read."""

from __future__ import annotations

import numpy as np

from hexathermal.simulate.hidden.effect import Parameters
from hexathermal.simulate.hidden.machines.effect import MachineEffect, number_of
from hexathermal.simulate.hidden.machines.truth import MachineRunTruth, MachineTruth


def draw(truth: MachineTruth, generator: np.random.Generator) -> Parameters:
    """Draw the two legs. ``apart`` is by how many times more their temperatures differ than the hall made them."""
    one, other = sorted(int(leg) for leg in generator.choice(6, 2, replace=False))
    return {"target": f"leg{one + 1}+leg{other + 1}", "apart": 1.0}


def hide(truth: MachineTruth, parameters: Parameters) -> MachineTruth:
    """Exchange the columns of the two legs, and drive their temperatures apart."""
    one, other = (number_of(leg) for leg in str(parameters["target"]).split("+"))
    read_from = list(truth.read_from)
    read_from[one], read_from[other] = read_from[other], read_from[one]

    def driven(run: MachineRunTruth) -> MachineRunTruth:
        """Return the run with the two legs farther apart, or nearer."""
        legs = run.legs.copy()
        middle = 0.5 * (legs[:, one] + legs[:, other])
        for leg in (one, other):
            legs[:, leg] = middle + float(parameters["apart"]) * (legs[:, leg] - middle)
        return run.changed(legs=legs)

    return truth.changed(runs=tuple(driven(run) for run in truth.runs), read_from=tuple(read_from))


EFFECT = MachineEffect("swapped-legs", draw, hide, amplitude="apart", limits=(0.01, 30.0))
