"""leg.toml: written and read without loss; every bad field is named with its place."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hexathermal.errors import ArgumentError, FileFormatError
from hexathermal.learn.law import IdentifiedLaw, Origin, Validity
from hexathermal.learn.leg_law_files import read_leg_law, write_leg_law
from hexathermal.learn.noise import ResidualNoise
from hexathermal.learn.sensor_errors import SensorErrors


def drawn(seed: int, kind: str, k: int) -> IdentifiedLaw:
    rng = np.random.default_rng(seed)
    p = 2 * k if kind == "leg" else k
    root = rng.normal(size=(p, p)) * 1e-8
    covariance = root @ root.T
    leg = kind == "leg"
    return IdentifiedLaw(
        kind, tuple(f"T{i:02d}" for i in range(k)), rng.normal(size=p) * 1e-6, 0.5 * (covariance + covariance.T),
        rng.uniform(0.1, 1.0) if leg else None, (0.0, rng.uniform(0.1, 0.3)) if leg else None,
        "run" if seed % 2 else "campaign",
        Validity(np.sort(rng.normal(size=(k, 2)), axis=1), (0.0, rng.random()) if leg else None,
        (rng.normal(), 30.0 + rng.random())), ResidualNoise(*(rng.random(3) * 1e-7), rng.random() * 3000.0 + 1.0, 0.0),
        SensorErrors(rng.random(k), rng.random(k), 1.0 + rng.random() * 5000.0, bool(seed % 2)), 1.9 + rng.random(),
        Origin("a leg; Ångström µ \"quoted\"", "abc123", ("run-01", "run-02"), "method", ("aa", "bb")),
    )  # fmt: skip


@given(seed=st.integers(0, 10**6), kind=st.sampled_from(["leg", "component"]), k=st.integers(1, 4))
def test_a_law_survives_writing_and_reading_to_the_last_bit(
    tmp_path_factory: pytest.TempPathFactory, seed: int, kind: str, k: int
) -> None:
    """Every number and text of a law comes back the same."""
    law = drawn(seed, kind, k)
    back = read_leg_law(write_leg_law(law, tmp_path_factory.mktemp("law") / "leg.toml"))
    for name in ("coefficients", "covariance"):
        assert np.array_equal(getattr(law, name), getattr(back, name))
    assert np.array_equal(law.validity.dT, back.validity.dT)
    for name in ("kind", "sensors", "retracted_length", "stroke", "zero", "noise", "factor", "origin"):
        assert getattr(law, name) == getattr(back, name)
    assert (law.validity.q, law.validity.degC) == (back.validity.q, back.validity.degC)
    assert np.array_equal(law.errors.noise, back.errors.noise)
    assert np.array_equal(law.errors.slow, back.errors.slow)
    assert (law.errors.slow_time, law.errors.zeroed_by_run) == (back.errors.slow_time, back.errors.zeroed_by_run)


def test_all_bad_fields_are_named_at_once(tmp_path: Path) -> None:
    """An unknown key, a wrong unit, a negative deviation, a short list: each with line and column."""
    file = write_leg_law(drawn(1, "leg", 1), tmp_path / "leg.toml")
    lines = file.read_text(encoding="utf-8").splitlines()
    text = "\n".join(lines) + "\n"
    for old, new in (("q0_mm =", "q0_inch ="), ("row_um = ", 'row_um = "x" #')):
        text = text.replace(old, new)
    file.write_text(text, encoding="utf-8")
    with pytest.raises(FileFormatError) as caught:
        read_leg_law(file)
    message = str(caught.value)
    assert "unknown key 'q0_inch'" in message
    assert "key 'q0_mm' is missing" in message
    assert "residual.row_um must be a number" in message
    assert all(problem.line > 0 for problem in caught.value.problems)


@pytest.mark.parametrize(("old", "new", "said"), [
    ('kind = "leg"', 'kind = "arm"', "kind must be 'leg' or 'component'"),
    ('format = "hexathermal-leg/1"', 'format = "hexathermal-leg/9"', "this version reads"),
    ('zero = "run"', 'zero = "noon"', "zero must be"),
    ("landing_um = ", "landing_um = -", "must be 0 or more"),
    ('  "bb",\n', "", "origin.run_fingerprints has 1 values; expected 2, one for each of origin.runs"),
    ("highest_dT_K = [\n", "highest_dT_K = [\n  1.0,\n", "range.highest_dT_K has 2 values; expected 1: T00"),
])  # fmt: skip
def test_each_bad_field_is_named(tmp_path: Path, old: str, new: str, said: str) -> None:
    """What is wrong, and what was expected."""
    file = write_leg_law(drawn(1, "leg", 1), tmp_path / "leg.toml")
    text = file.read_text(encoding="utf-8")
    assert old in text
    file.write_text(text.replace(old, new), encoding="utf-8")
    with pytest.raises(FileFormatError, match=said):
        read_leg_law(file)


def test_a_range_that_ends_below_its_beginning_is_named(tmp_path: Path) -> None:
    """Lowest and highest that changed places: every value would lie outside, and each row be called extrapolated."""
    file = write_leg_law(drawn(1, "leg", 1), tmp_path / "leg.toml")
    text = file.read_text(encoding="utf-8")
    swapped = text.replace("lowest_dT_K", "_").replace("highest_dT_K", "lowest_dT_K").replace("_ =", "highest_dT_K =")
    for broken, said in (
        (swapped, "range.highest_dT_K lies below"),
        (re.sub(r"\nq_mm = \[[^]]*\]", "\nq_mm = [ 200.0, 10.0 ]", text), r"range.q_mm must be \[low, high\]"),
        (re.sub(r"stroke_mm = \[[^]]*\]", "stroke_mm = [ 250.0, 0.0 ]", text), r"law.stroke_mm must be \[low, high\]"),
    ):
        assert broken != text
        file.write_text(broken, encoding="utf-8")
        with pytest.raises(FileFormatError, match=said):
            read_leg_law(file)


def test_no_file_and_no_place_are_refused(tmp_path: Path) -> None:
    """A missing law, and a place that cannot be written."""
    with pytest.raises(ArgumentError, match="'hexathermal identify' writes"):
        read_leg_law(tmp_path / "none.toml")
    (tmp_path / "file").write_text("", encoding="utf-8")
    for folder in ("file", "missing"):
        with pytest.raises(ArgumentError, match=rf"there is no folder .*{folder}; create it first"):
            write_leg_law(drawn(1, "leg", 1), tmp_path / folder / "leg.toml")
    assert sorted(item.name for item in tmp_path.iterdir()) == ["file"]


def test_a_component_is_no_leg() -> None:
    """C cannot be carried by a machine's leg; a leg's law can, with its covariance."""
    with pytest.raises(ArgumentError, match="no leg can carry it"):
        drawn(1, "component", 1).leg_law()
    law = drawn(1, "leg", 2)
    carried = law.leg_law()
    assert np.array_equal(carried.A, law.A)
    assert np.array_equal(carried.covariance, law.covariance)
