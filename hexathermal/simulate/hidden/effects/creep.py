"""After each move, or after the beginning of each run, something relaxes, by the logarithm or a stretched exponential.

What all moves have left adds up.
"""

from __future__ import annotations

import numpy as np

from hexathermal.poses import FloatArray
from hexathermal.simulate.hidden.effect import Effect, Parameters, with_stroke
from hexathermal.simulate.hidden.shapes import add, either_sign, log_uniform, moves
from hexathermal.simulate.hidden.truth import CampaignTruth, RunTruth

WHOLE = 0.005
"""Moves of a few times this length relax fully [m]; shorter ones in part."""
MOVES_AT_ONCE = 200

DIRECTED = 2.0 / 3.0
"""How often what relaxes has the direction of the move; else every move loosens alike."""

BEGUN, SLOWER, UNLIKE = 0.25, 4.0, 0.1
"""How often it is what was clamped for a run that relaxes, by how much slower, and how unlike runs are."""


def draw(truth: CampaignTruth, generator: np.random.Generator) -> Parameters:
    """Draw the law, the height of one long move [m], its time [s], and of a stretched exponential the exponent.

    Source: exponents of 0.3 to 0.7 of glues and preloads; stick-slip relaxes within minutes, glue within an hour.
    """
    found: dict[str, float | int | str] = {
        "law": str(generator.choice(["logarithm", "stretched"])),
        "height": either_sign(generator) * log_uniform(0.1e-6, 2e-6, generator),
        "time": log_uniform(60.0, 1800.0, generator),
        "exponent": float(generator.uniform(0.4, 0.7)),
    }
    found["directed"] = bool(generator.random() < DIRECTED)
    if generator.random() < BEGUN:
        found |= {"begun": True, "time": SLOWER * float(found["time"]), "unlike": int(generator.integers(2**31))}
    return found


def remaining(since: FloatArray, parameters: Parameters) -> FloatArray:
    """Return which part still has to relax, times [s] after a move: 1 at first, then less."""
    past, time = np.clip(since, 0.0, None), float(parameters["time"])
    if parameters["law"] == "stretched":
        return np.asarray(np.exp(-((past / time) ** float(parameters["exponent"]))))
    # a decade below the time until the first change, three decades in all
    first = 0.1 * time
    return np.asarray(np.clip(1.0 - np.log1p(past / first) / np.log1p(1e3), 0.0, None))


def hide(truth: CampaignTruth, parameters: Parameters) -> CampaignTruth:
    """Add ``height sum over moves of tanh(length / 5 mm) remaining(t - t_move)``, or of its size alone; or one of runs.

    Of runs it is ``height (1 + unlike) remaining(t)``.
    """
    if parameters.get("begun"):
        return _from_beginnings(truth, parameters)

    def relaxing(run: RunTruth) -> FloatArray:
        """Return what has still to relax [m]."""
        times, lengths = moves(run)
        found = np.zeros(run.time.size)
        # moves in groups: a matrix of all rows and all moves would be large
        for k in range(0, times.size, MOVES_AT_ONCE):
            part = slice(k, k + MOVES_AT_ONCE)
            since = run.time[:, None] - times[part]
            left = np.where(since >= 0.0, remaining(since, parameters), 0.0)
            sizes = np.tanh(lengths[part] / WHOLE)
            found += left @ (sizes if parameters["directed"] else np.abs(sizes))
        return float(parameters["height"]) * found

    return add(truth, relaxing)


def _from_beginnings(truth: CampaignTruth, parameters: Parameters) -> CampaignTruth:
    """Add what relaxes from the beginning of each run on."""
    unlike = np.random.default_rng(int(parameters["unlike"])).normal(1.0, UNLIKE, len(truth.runs))
    height = float(parameters["height"])
    return truth.changed(
        runs=tuple(
            run.changed(effect=run.effect + height * size * remaining(run.time - run.time[0], parameters))
            for run, size in zip(truth.runs, unlike.tolist(), strict=True)
        )
    )


EFFECT = Effect("creep", draw, hide, with_stroke, "height", (1e-9, 2e-5))
