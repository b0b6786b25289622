"""Pictures in few letters show what they showed: every point within a twentieth of a point, every dot, every colour."""

from __future__ import annotations

import re
from urllib.parse import unquote

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from matplotlib.figure import Figure

from hexathermal.show.diagnosis_pictures import themed_svg
from hexathermal.show.svg_size import compact_svg, steps, svg_address

NUMBER = re.compile(r"-?(?:\d+\.?\d*|\.\d+)")
COORDINATE = st.floats(-2000.0, 2000.0)


def walked(path: str) -> np.ndarray:
    """Return the points (n, 2) of a path ``M.. l.. l..``, read as browsers read it."""
    parts = re.findall(r"([Ml])([^Ml]+)", path)
    numbers = np.array([[float(one) for one in NUMBER.findall(rest)] for _letter, rest in parts])
    starts = np.array([letter == "M" for letter, _rest in parts])
    assert starts[0]
    assert starts.sum() == 1
    return np.cumsum(numbers, axis=0)


@given(st.lists(st.tuples(COORDINATE, COORDINATE), min_size=1, max_size=60))
def test_no_point_moves_by_more_than_a_twentieth(points: list[tuple[float, float]]) -> None:
    """Every point of a line is passed within 0.05 pt in each direction, the last one too: no rounding adds up."""
    found = walked(steps(points))
    for point in points:
        assert np.abs(found - point).max(axis=1).min() <= 0.0501
    assert np.abs(found[-1] - points[-1]).max() <= 0.0501
    assert np.abs(found[0] - points[0]).max() <= 0.0501


def picture() -> str:
    """Return a figure with a long line, a broken one, and dots."""
    x = np.linspace(0.0, 1.0, 400)
    figure = Figure(figsize=(4.0, 3.0))
    axes = figure.subplots()
    axes.plot(x, np.sin(40.0 * x), color="#0072B2")
    axes.plot(x, np.where(np.abs(x - 0.5) < 0.1, np.nan, np.cos(30.0 * x)), color="#D55E00")
    axes.plot(x[::20], x[::20] ** 2, ".", color="#009E73")
    return themed_svg(figure, "salt")


def test_a_picture_keeps_its_dots_lines_and_colours() -> None:
    """Twenty dots are twenty places of one mark; lines stay as many; a third of the letters is gone at least."""
    before = picture()
    after = compact_svg(before)
    assert len(after) < 0.67 * len(before)
    paths = re.findall(r'<path d="([^"]+)" marker-start="url\(#([^)]+)\)" marker-mid="url\(#\2\)"', after)
    assert len(paths) == 1
    assert len(walked(paths[0][0])) == 20
    assert f'<marker id="{paths[0][1]}"' in after
    for colour in set(re.findall(r"var\(--c\d\)", before)):
        assert colour in after
    broken = [path for path in re.findall(r' d="([^"]+)"', after) if path.count("M") == 2 and path.count("l") > 100]
    assert len(broken) == 1
    for name in re.findall(r"(?:href=\"|url\()#([^\")]+)", after):
        assert f'id="{name}"' in after


def test_an_address_stands_between_quotes_and_gives_the_picture_back() -> None:
    """No double quote, blank or hash ends it; decoded, it is the picture but for the kind of its quotes."""
    svg = compact_svg(picture())
    address = svg_address(svg)
    assert not set('" #') & set(address)
    assert unquote(address.split(",", 1)[1]).replace("'", '"') == svg
