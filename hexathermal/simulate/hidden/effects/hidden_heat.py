"""Heat of motion, or of a recorded input, is stored where no thermometer sits, and leaves slowly.

Two bodies take it beside each other, or one from the other: what is rubbed warms first, then what expands.
"""

from __future__ import annotations

import numpy as np

from hexathermal.poses import FloatArray
from hexathermal.simulate.hidden.effect import Effect, Parameters, with_stroke
from hexathermal.simulate.hidden.shapes import add, cascade, either_sign, first_order, log_uniform, step_sizes
from hexathermal.simulate.hidden.truth import CampaignTruth, RunTruth


def _driving(truth: CampaignTruth) -> list[str]:
    """Return the recorded inputs that change."""
    return [
        name for k, name in enumerate(truth.input_names) if any(np.ptp(run.inputs[:, k]) > 0.0 for run in truth.runs)
    ]


def possible(truth: CampaignTruth) -> bool:
    """Return whether something makes heat."""
    return with_stroke(truth) or bool(_driving(truth))


def draw(truth: CampaignTruth, generator: np.random.Generator) -> Parameters:
    """Draw the source, the power of it that makes heat, two time constants [s], the faster one's share, the height [m].

    Engineering values: a nut empties within minutes, a screw or a housing within an hour or two. Friction heat goes
    with speed (Coulomb) up to its square (viscous).
    """
    sources = _driving(truth) + (["speed"] if with_stroke(truth) else [])
    found: dict[str, float | int | str] = {
        "source": str(generator.choice(sources)),
        "power": float(generator.choice([1.0, 1.5, 2.0])),
        "fast": log_uniform(240.0, 1200.0, generator),
        "slow": log_uniform(1800.0, 7200.0, generator),
        "share": float(generator.uniform(0.3, 0.7)),
        "height": either_sign(generator) * log_uniform(0.3e-6, 4e-6, generator),
    }
    found["bodies"] = str(generator.choice(["beside", "behind"]))
    return found


def hide(truth: CampaignTruth, parameters: Parameters) -> CampaignTruth:
    """Add the stored heat, ``height`` where it is largest in the campaign; a run begins with none."""
    power, share = float(parameters["power"]), float(parameters["share"])

    def stored(run: RunTruth) -> FloatArray:
        """Return the heat stored in both, any unit."""
        if parameters["source"] == "speed":
            rate = np.abs(step_sizes(run)) / np.diff(run.time, prepend=2.0 * run.time[0] - run.time[1])
        else:
            rate = np.abs(run.inputs[:, truth.input_names.index(str(parameters["source"]))])
        heat = np.concatenate([[0.0], rate[1:] ** power])
        if parameters["bodies"] == "behind":
            return cascade(run.time, heat, (float(parameters["fast"]), float(parameters["slow"])))
        fast, slow = (first_order(run.time, heat, float(parameters[name])) for name in ("fast", "slow"))
        return np.asarray(share * fast + (1.0 - share) * slow)

    largest = max(float(stored(run).max()) for run in truth.runs)
    scale = float(parameters["height"]) / largest if largest > 0.0 else 0.0
    return add(truth, lambda run: scale * stored(run))


EFFECT = Effect("hidden-heat", draw, hide, possible, "height", (1e-9, 3e-5))
