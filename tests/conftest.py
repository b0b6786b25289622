"""Machines and random poses that many tests share; every random draw shows its seed when a test fails."""

from __future__ import annotations

import argparse
import os
from pathlib import Path

# before numba is imported: tests must not depend on how many threads a machine has
os.environ.setdefault("OMP_NUM_THREADS", "1")

import numpy as np
import pytest
from hypothesis import settings

import hexathermal as ht
from tests.browser import chromium as chromium
from tests.browser import window as window

settings.register_profile("house", deadline=None, max_examples=60, derandomize=True, print_blob=True)
settings.load_profile("house")


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--share", metavar="K/N", default="1/1", type=_share,
                     help="of the tests marked long, run share K of N; all without it")  # fmt: skip


def _share(text: str) -> tuple[int, int]:
    """Return which share of how many."""
    try:
        k, n = map(int, text.split("/"))
    except ValueError:
        k, n = 0, 0
    if not 1 <= k <= n:
        raise argparse.ArgumentTypeError(f"'{text}' is no share: write K/N with K from 1 to N, as in 2/5")
    return k, n


def _together(item: pytest.Item) -> str:
    """Return what is run in one share: a test, or all of a module that is long, whose tests share what takes long."""
    module = item.getparent(pytest.Module)
    marks = [] if module is None else [one.name for one in module.own_markers]
    return module.nodeid if module is not None and "long" in marks else item.nodeid


def pytest_report_header(config: pytest.Config) -> str:
    k, n = config.getoption("share")
    return "long tests: all" if n == 1 else f"long tests: share {k} of {n} (--share {k}/{n}; all without it)"


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Leave other shares of the long tests out, and begin with drawn campaigns in both halves of what remains.

    Two processes take one half each, and share the draws.
    """
    k, n = config.getoption("share")
    long = {item: _together(item) for item in items if item.get_closest_marker("long")}
    order = {unit: j for j, unit in enumerate(dict.fromkeys(long.values()))}
    others = {item for item, unit in long.items() if order[unit] % n != k - 1}
    config.hook.pytest_deselected(items=[item for item in items if item in others])
    items[:] = [item for item in items if item not in others]
    items.sort(key=lambda item: "outcomes" not in getattr(item, "fixturenames", ()))
    drawn = sum("outcomes" in getattr(item, "fixturenames", ()) for item in items)
    first, half = drawn // 2, len(items) // 2
    items[:] = items[:first] + items[drawn : drawn + half - first] + items[first:drawn] + items[drawn + half - first :]


@pytest.fixture
def dots(monkeypatch: pytest.MonkeyPatch) -> None:
    """Pictures of a report are a dot each: for tests of its files, not of what they show."""
    from matplotlib.figure import Figure

    from hexathermal.show.diagnosis_pictures import Picture
    from hexathermal.show.figures import draw

    def drawn(one: Picture, png: Path) -> str:
        draw(Figure((0.02, 0.02)), png, "png")
        return f'<figure id="{one.name}"></figure>'

    monkeypatch.setattr(Picture, "drawn", drawn)


@pytest.fixture
def rng(request: pytest.FixtureRequest) -> np.random.Generator:
    """A generator whose seed depends on the test's name only."""
    seed = sum(ord(letter) * (k + 1) for k, letter in enumerate(request.node.nodeid))
    print(f"seed {seed}")
    return np.random.default_rng(seed)


@pytest.fixture(params=ht.bundled_hexapods())
def hexapod(request: pytest.FixtureRequest) -> ht.Hexapod:
    """Each bundled machine."""
    return ht.load_hexapod(request.param)


@pytest.fixture
def reference() -> ht.Hexapod:
    return ht.load_hexapod("reference")


@pytest.fixture
def two_plates() -> ht.Hexapod:
    """The reference machine with a thermometer on each plate, steel, and a two-sensor law on every leg."""
    import dataclasses

    law = ht.LegLaw(("T7", "T15"), np.array([1.2e-6, 0.8e-6]), np.array([0.5e-6, 0.6e-6]))
    model = ht.ThermalModel(
        law, ht.PlateLaw(11.5e-6, "T1"), ht.PlateLaw(11.5e-6, "T1"), reference_temperature_degC=20.0, valid_degC=(0, 50)
    )
    return dataclasses.replace(ht.load_hexapod("reference"), thermal=model, name="two plates")
