"""What a diagnosis costs: campaigns of nine runs of 6 h for identification, rows every 15 s, and with more rows."""

from __future__ import annotations

import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from benchmarks.hidden_effects import diagnosed

if TYPE_CHECKING:
    from hexathermal.simulate.hidden.truth import CampaignTruth, RunTruth

BENCH, SEED, STEP_S = "modal", 1, 15.0
CASES = (("nothing hidden", ()), ("one effect", ("backlash",)), ("two effects", ("thermal-lag", "scale-error")))


@dataclass(frozen=True)
class Timed:
    """Seconds of one core for a campaign of some rows."""

    label: str
    rows: int
    seconds: float


def finer(truth: CampaignTruth, factor: int) -> CampaignTruth:
    """Return a campaign with `factor` times its rows, linear between those it has, with a little noise."""
    import numpy as np

    generator = np.random.default_rng(factor)
    little = {"sensor_errors": 5e-3, "noise": 5e-9}

    def between(run: RunTruth) -> RunTruth:
        place = np.arange(0.0, len(run.time) - 1 + 1e-9, 1.0 / factor)
        at = np.arange(len(run.time))
        names = (
            "time",
            "q",
            "temperatures",
            "sensor_errors",
            "air",
            "inputs",
            "drift",
            "noise",
            "effect",
            "beam_effects",
        )
        fields: dict[str, object] = {}
        for name in names:
            values = getattr(run, name)
            flat = values.reshape(len(values), -1)
            table = np.column_stack([np.interp(place, at, column) for column in flat.T]) if flat.shape[1] else flat
            table = table.reshape(len(place), *values.shape[1:]) if flat.shape[1] else np.zeros((len(place), 0))
            fields[name] = table + little.get(name, 0.0) * generator.standard_normal(table.shape)
        lower, upper = np.floor(place).astype(int), np.ceil(place).astype(int)
        return run.changed(settled=run.settled[lower] & run.settled[upper], **fields)

    return truth.changed(runs=tuple(between(run) for run in truth.runs))


def longer(factor: int, causes: Sequence[str]) -> CampaignTruth:
    """Return a campaign with `factor` times the runs: of other days, since copies would be more evidence than data."""
    import numpy as np

    from hexathermal.simulate.hidden.beams import with_usual_differences
    from hexathermal.simulate.hidden.benches.modal import ROLES, draw
    from hexathermal.simulate.hidden.drawing import hidden_in

    generator = np.random.default_rng([SEED, 0])
    clean = with_usual_differences(draw(generator, [role for role in ROLES for _ in range(factor)]), generator)
    return hidden_in(clean, SEED, causes, 1.0)[0]


def _seconds(truth: CampaignTruth, base: Sequence[str], folder: Path) -> float:
    """Return the processor time of a diagnosis from a folder."""
    from hexathermal.simulate.hidden.drawing import campaign_of
    from hexathermal.simulate.hidden.writing import write_campaign

    _, answer = campaign_of(BENCH, SEED, causes=())
    write_campaign(folder, truth, answer)
    start = time.process_time()
    diagnosed(folder, list(base))
    return time.process_time() - start


def timed() -> list[Timed]:
    """Return what campaigns cost, the compiler warm: as they are, with more rows, with more runs."""
    from hexathermal.simulate.hidden.drawing import campaign_of

    found = []
    with tempfile.TemporaryDirectory() as place:
        jobs = [(label, campaign_of(BENCH, SEED, causes=causes, strength=1.0)[0]) for label, causes in CASES]
        one = jobs[1][1]
        jobs += [(f"one effect, rows every {STEP_S / factor:g} s", finer(one, factor)) for factor in (2, 4)]
        jobs += [(f"one effect, {factor} times the runs", longer(factor, CASES[1][1])) for factor in (2, 4)]
        for k, (label, truth) in enumerate([jobs[0], *jobs]):
            seconds = _seconds(truth, truth.base, Path(place) / str(k))
            if k:  # the first one warms up
                found.append(
                    Timed(label, sum(len(run.time) for run in truth.runs if run.role == "identification"), seconds)
                )
    return found
