"""Figures: what they show and how they are written."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import hexathermal as ht
from hexathermal.errors import ArgumentError
from hexathermal.show.figures import day_figure, save_figure
from hexathermal.simulate.demonstration import demonstrate


@pytest.mark.long
def test_the_figure_speaks_for_itself(tmp_path: Path) -> None:
    """Axes carry quantities and units, the curves are those of the day; other endings than images are refused."""
    result = demonstrate(ht.load_hexapod("reference"))
    figure = day_figure(result)
    labels = [axes.get_ylabel() for axes in figure.axes]
    assert [label.rpartition("(")[2] for label in labels] == ["°C)", "µm)", "µrad)"]
    assert "(h)" in figure.axes[-1].get_xlabel()
    drawn = figure.axes[1].lines[0].get_ydata()
    wanted = np.linalg.norm(result.errors_without[..., :3], axis=-1).max(axis=-1) * 1e6
    assert np.array_equal(np.asarray(drawn), wanted)
    for name, start in (("a.png", b"\x89PNG"), ("a.svg", b"<?xml"), ("a.pdf", b"%PDF")):
        assert save_figure(figure, tmp_path / name).read_bytes().startswith(start)
    with pytest.raises(ArgumentError, match="cannot write a figure"):
        save_figure(figure, tmp_path / "a.txt")
