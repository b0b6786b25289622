"""The index of air was not applied, or not over the dead path."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache

import numpy as np

from hexathermal.learn.diagnosis.trials import Cause, Parameter, Trial, Workbench
from hexathermal.learn.interferometer import index_along_run

CAUSE = Cause(
    name="air-refraction",
    physics=(
        "Light is slower in dense air: a path L read without its index is wrong by L (n - n0), 0.27 um per "
        "metre and hPa."
    ),
    signature="The residual follows the pressure, which nothing thermal does, and grows with the path.",
    parameters=(Parameter("share", "1", "of the index that was not applied; 1: all of it"),),
    confused_with=(
        "frame-expansion",
        "zero-drift",
    ),
    experiment="A day at rest on which the weather changes, compared with a refractometer every hour.",
    words="the index of refraction of air was not applied over the whole path",
    readings=24,
)


def trials(bench: Workbench) -> Iterator[Trial]:
    """Give the index over the dead path, over the path with the stroke, and over the leg; the laser's scale, too."""
    view = bench.view
    if view.kind != "leg" or any(rows.signals.index is None for rows in view.runs):
        return
    dead = view.dead_path
    for path, share in {(dead, 0.0), (dead, 1.0), (view.length, 1.0)} if dead > 0.0 else {(view.length, 1.0)}:
        yield bench.term(CAUSE.name, "air-index", None, quick=True, path_m=path, stroke_share=share)
        if share > 0.0 and view.moves and all(rows.signals.zero_index is not None for rows in view.runs):
            yield bench.term(CAUSE.name, "air-index", None, quick=True, path_m=path, stroke_share=share,
                             reference_index=_standard_index())  # fmt: skip


@cache
def _standard_index() -> float:
    """Return the index of air at 20 degC, 1013.25 hPa and 50 %, which a laser takes for the air's if nothing is set."""
    return round(float(index_along_run(np.array([[20.0, 101325.0, 0.5]]))[0]), 7)
