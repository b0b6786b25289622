"""Pictures of diagnoses where there is little room, or little to draw: words stay apart, and bars are seen."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from hexathermal.learn.hexapod_scores import QUANTITIES, PoseScore
from hexathermal.learn.validation_scores import Figure
from hexathermal.show.diagnosis_figures import ranking_figure
from hexathermal.show.diagnosis_pictures import NARROW_IN, WIDE_IN
from hexathermal.show.machine_figures import gain_figure
from hexathermal.show.machine_run_figures import pose_figure
from hexathermal.show.machine_signals import Pooled, Signal
from tests.show.drawn_diagnoses import drawn

WIDTHS = (NARROW_IN, WIDE_IN)


def overlaps(texts: list[Any]) -> list[tuple[str, str]]:
    """Return neighbours among written words that cover each other."""
    shown = [one for one in texts if one.get_visible() and one.get_text()]
    boxes = [one.get_window_extent() for one in shown]
    both = pairwise(zip(shown, boxes, strict=True))
    return [(one.get_text(), other.get_text()) for (one, box), (other, next_box) in both if box.overlaps(next_box)]


@pytest.mark.long
@pytest.mark.parametrize("width", WIDTHS)
def test_axes_of_small_panels_have_numbers_that_can_be_read(width: float, rng: np.random.Generator) -> None:
    """Residuals against the pose: below no panel, nor from one panel to the next, do numbers cover each other."""
    spans = {"x": 4.0, "y": 4.0, "z": 3.0, "rx": 0.07, "ry": 0.07, "rz": 0.012}
    poses = [Signal(name, name, "mm", size * rng.uniform(-1.0, 1.0, 300)) for name, size in spans.items()]
    left = rng.standard_normal((300, 12))
    figure = pose_figure(Pooled(np.zeros(300), tuple(poses), left, left, ()), poses, False, width)
    figure.canvas.draw()
    low = [label for axes in figure.axes[-6:] for label in axes.get_xticklabels()
           if axes.get_xlim()[0] <= label.get_position()[0] <= axes.get_xlim()[1]]  # fmt: skip
    assert len(low) >= 12
    assert overlaps(low) == []


@pytest.mark.parametrize("width", WIDTHS)
def test_names_of_scores_do_not_cover_each_other(width: float) -> None:
    """Before and after of all runs at once has room for a name a row."""
    score = PoseScore(Figure(9e-7, 8e-7, 1e-6), Figure(6e-7, 5e-7, 7e-7), 2e-6, 1e-6, Figure(0.3, 0.2, 0.4))
    scores = dict.fromkeys(QUANTITIES, score)
    found: Any = SimpleNamespace(
        gain=SimpleNamespace(runs={"a": scores}, total=scores, unframed=scores),
        disturbances=SimpleNamespace(frame=np.ones(6)),
    )
    figure = gain_figure(found, width)
    figure.canvas.draw()
    for axes in figure.axes:
        assert overlaps(list(axes.get_yticklabels())) == []


@pytest.mark.parametrize("width", WIDTHS)
def test_evidence_against_every_candidate_is_drawn(width: float) -> None:
    """Where no candidate has evidence for it, bars reach to the left; where one has, none does."""
    found = drawn(verdict="none")
    against = tuple(replace(one, evidence=-1.0 - k) for k, one in enumerate(found.candidates))
    for shown, reach in ((found, 0.0), (replace(found, candidates=against), -float(len(against)))):
        (axes,) = ranking_figure(shown, width).axes
        widths = [bar.get_width() for bar in axes.patches]
        assert min(widths) == pytest.approx(reach)
        assert axes.get_xlim()[0] <= reach
        assert axes.get_xlim()[1] > max(shown.threshold, *widths)
