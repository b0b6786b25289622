"""Figures of an identification and a validation: nothing covers what it explains."""

from __future__ import annotations

import dataclasses
from itertools import pairwise

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.text import Text

from hexathermal.learn.gram import columns_for, gather
from hexathermal.learn.identification import identify
from hexathermal.learn.selection import rank_sets
from hexathermal.learn.validation import validate
from hexathermal.show.identification_figures import front_figure, validation_figure
from tests.learn.legs import LEG, SENSORS, drawn_leg


def test_a_validated_run_shows_its_rod_and_says_whether_it_was_fitted(rng: np.random.Generator) -> None:
    """The legend of four sensors stands outside of the axes; a fitted run is no run "never fitted"."""
    blocks = drawn_leg(rng, runs=3)
    law = identify(lambda: blocks, SENSORS, LEG, wanted="T03,T07,T12,T15", sizes=(1,)).law
    fresh = dataclasses.replace(drawn_leg(rng, runs=1, role="validation")[0])
    found = validate(law, [fresh, blocks[1]], SENSORS)
    headings = []
    for curves in found.curves:
        figure = validation_figure(found, curves, law.sensors)
        canvas = FigureCanvasAgg(figure)
        canvas.draw()
        top, _bottom, heat = figure.axes
        legend = heat.get_legend()
        assert legend is not None
        assert legend.get_window_extent().y0 >= top.get_window_extent().y1 - 1.0
        headings.append(top.get_title(loc="left"))
    assert headings == ["validation-0: never fitted", "identification-1: fitted (as identification-1), proves nothing"]
    old = dataclasses.replace(law, origin=dataclasses.replace(law.origin, run_fingerprints=()))
    unknown = validate(old, [fresh], SENSORS)
    figure = validation_figure(unknown, unknown.curves[0], law.sensors)
    assert figure.axes[0].get_title(loc="left") == "validation-0: run for validation"


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_names_on_the_front_do_not_cover_each_other(seed: int) -> None:
    """The names of the front's sets stand apart, however close its points are."""
    blocks = drawn_leg(np.random.default_rng(seed), runs=3, hours=1.0)
    ranked = rank_sets(blocks, gather(blocks, columns_for(SENSORS, LEG)))
    figure = front_figure(ranked)
    FigureCanvasAgg(figure).draw()
    named = ["–".join(ranked.names[k]) for k in ranked.front()]
    boxes = sorted((Text.get_window_extent(text) for text in figure.axes[1].texts if text.get_text() in named),
                   key=lambda box: box.y0)  # fmt: skip
    assert len(boxes) >= len(named)
    assert all(above.y0 >= below.y1 - 1.0 for below, above in pairwise(boxes))
