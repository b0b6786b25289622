"""The scale, or the lead of the screw, is wrong by a constant part."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from hexathermal.learn.diagnosis.trials import Cause, Parameter, Trial, Workbench
from hexathermal.learn.diagnosis.view import View
from hexathermal.poses import FloatArray

CAUSE = Cause(
    name="scale-error",
    physics=(
        "The scale that the displacement is read from, or the wavelength of the laser, is off by some parts "
        "in a million."
    ),
    signature="The residual is proportional to the displacement at any temperature.",
    parameters=(Parameter("scale", "1", "visible effect of 0.25 to 4 times the noise"),),
    confused_with=(
        "periodic-screw-error",
        "air-refraction",
    ),
    experiment="The whole stroke up and down within minutes, ten times, before any warming.",
    words="the scale of the displacement is wrong by a constant part",
    readings=20,
    misfit=0.05,  # whatever a law gets wrong of the rod's warmth goes with the displacement times a mean temperature
    bent=0.55,  # scales are bowed, or wrong by different parts in their pieces; of a cube it is 0.6 to 2
)

BOWED = 0.7
"""Size of what the bow of a scale shows, as `Trial.started`: half as much as the scale does."""


def trials(bench: Workbench) -> Iterator[Trial]:
    """Give the displacement, and with it a bow of the scale, which no law carries."""
    if bench.view.moves:
        trial = bench.term(CAUSE.name, "position", None, quick=True)
        yield trial
        yield replace(trial, columns=np.column_stack([trial.columns, _bow(bench.view)]), starts=1, started=BOWED)


def _bow(view: View) -> FloatArray:
    """Return a parabola about the middle of the stroke, less that at the zero, in windows, shape (n, 1)."""
    low, high = float(view.q.min()), float(view.q.max())
    half = max(0.5 * (high - low), 1e-12)
    return view.windows_zeroed([((signals.q[:, None] - 0.5 * (low + high)) / half) ** 2 for signals in view.signals])
