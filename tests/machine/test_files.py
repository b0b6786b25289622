"""hexapod.toml: read and written without loss, every bad field reported with its place."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import hexathermal as ht
from hexathermal.errors import ArgumentError, FileFormatError, HexathermalError
from hexathermal.machine.library import models_folder
from hexathermal.machine.units import metres, radians, same, shortest
from tests.machines import general_machine

numbers = st.floats(-1e3, 1e3, allow_nan=False, allow_subnormal=False)


@given(numbers)
def test_no_bit_is_lost_at_the_unit_border(value: float) -> None:
    """Every double is written as a decimal in millimetres or degrees that is read back as the same double."""
    for reader in (metres, radians, same):
        assert reader(shortest(value, reader)) == value


def test_files_keep_every_bit(
    tmp_path: Path, hexapod: ht.Hexapod, two_plates: ht.Hexapod, rng: np.random.Generator
) -> None:
    """Write and read gives an equal machine; writing it again gives the same text."""
    scattered = general_machine(rng)
    six = ht.Hexapod(
        scattered.base_joints, scattered.platform_joints, home=scattered.home,
        name="six laws", grade="A", source="a test",
        retracted_length=rng.uniform(0.2, 0.3, 6), stroke=np.stack([rng.uniform(-0.1, 0, 6), rng.uniform(1, 2, 6)], 1),
        base_cone=rng.uniform(1, 1.5, 6),
        thermal=ht.ThermalModel(
            tuple(ht.LegLaw(("T1", "T2"), rng.normal(0, 1e-6, 2), rng.normal(0, 1e-6, 2),
                            np.diag(rng.uniform(1, 2, 4)) * 1e-15, f"campaign {k}") for k in range(6)),
            ht.PlateLaw(1.1e-5, "T1"), None, rng.uniform(19, 21, 13), (-10.0, 60.0)),
    )  # fmt: skip
    for machine in (hexapod, two_plates, six):
        file = ht.write_hexapod(machine, tmp_path / machine.name.replace(" ", "-"))
        again = ht.load_hexapod(file)
        assert again == machine
        text = file.read_text()
        assert ht.write_hexapod(again, tmp_path / "again.toml").read_text() == text


GOOD = (models_folder() / "reference" / "hexapod.toml").read_text()


def problems(tmp_path: Path, text: str) -> list[str]:
    """Return the complaints about a machine file."""
    file = tmp_path / "hexapod.toml"
    file.write_text(text)
    with pytest.raises(FileFormatError) as caught:
        ht.load_hexapod(file)
    return [str(problem) for problem in caught.value.problems]


def test_all_bad_fields_are_reported_together_with_their_lines(tmp_path: Path) -> None:
    """Five mistakes in one file give five complaints, each with line and column."""
    bad = (
        GOOD.replace('grade = "C"', 'grade = "Z"')
        .replace("q0_mm = 600.0", 'q0_mm = "600"')
        .replace("stroke_mm = [0.0, 250.0]", "stroke_mm = [0.0, 250.0, 3.0]")
        .replace("A_per_K = [1.99e-06]", "A_per_k = [1.99e-06]")
        .replace("platform_mass_kg = 25.0", "platform_mass_kg = nan")
    )
    found = problems(tmp_path, bad)
    lines = bad.splitlines()
    for word in ("grade", "q0_mm", "stroke_mm", "A_per_k", "platform_mass_kg"):
        number = next(k for k, line in enumerate(lines, 1) if line.startswith(word))
        assert any(f"line {number}, column 1" in text and word in text for text in found), (word, found)
    assert any("A_per_K' is missing" in text for text in found)
    assert len(found) == 6


@pytest.mark.parametrize(
    ("old", "new", "word"),
    [
        ('format = "hexathermal-hexapod/1"', 'format = "hexathermal-hexapod/9"', "this version reads"),
        ("base_joints_mm = [", "base_joints = [", "unknown key 'base_joints'.*known"),
        ("[443.163, -78.142, -663.3]", "[443.163, -78.142]", "different length|shape"),
        ("[443.163, -78.142, -663.3]", "[443.163, inf, -663.3]", "finite"),
        ("home_mm = [0.0, 0.0, 0.0]", "home_mm = [0.0, 0.0]", "shape"),
        ("q0_mm = 600.0", "q0_mm = 0.6", "home is out of stroke"),
        ('sensors = [\n  "T1",\n]', "sensors = []", "list of names"),
        ("A_per_K = [1.99e-06]", "A_per_K = [1.99e-3]", "1/K"),
        ("A_per_K = [1.99e-06]", "A_per_K = [1.99e-6, 1e-6]", "1 value for each of the sensors"),
        ("valid_degC = [0.0, 50.0]", "valid_degC = [50.0, 0.0]", "low, high"),
        ("reference_temperature_degC = 20.0", "reference_temperature_degC = 293.15", "inside valid_degC"),
        ("reference_temperature_degC = 20.0\n", "", "missing"),
        ("[geometry]", "[geometry", "not valid TOML"),
        ("[thermal.leg]", "[[thermal.legs]]", "expected six"),
        ("[geometry]", "[geometri]", "unknown key 'geometri'"),
    ],
)
def test_each_mistake_is_named(tmp_path: Path, old: str, new: str, word: str) -> None:
    """One mistake, one complaint that says what is wrong."""
    import re

    assert old in GOOD
    found = problems(tmp_path, GOOD.replace(old, new))
    assert any(re.search(word, text, re.DOTALL) for text in found), found


@given(st.integers(0, len(GOOD) - 1), st.binary(max_size=6), st.integers(0, 40))
def test_damaged_files_give_a_clear_error_or_a_machine(
    tmp_path_factory: pytest.TempPathFactory, at: int, insert: bytes, cut: int
) -> None:
    """Random damage never ends in anything but a machine or one of the package's own errors."""
    data = GOOD.encode()
    file = tmp_path_factory.mktemp("damaged") / "hexapod.toml"
    file.write_bytes(data[:at] + insert + data[at + cut :])
    try:
        assert isinstance(ht.load_hexapod(file), ht.Hexapod)
    except HexathermalError as error:
        assert str(file) in str(error)


def test_a_turned_home_cannot_be_written(tmp_path: Path, reference: ht.Hexapod) -> None:
    """The format holds a home position only: a turned home is refused instead of being lost."""
    turned = ht.Hexapod(
        reference.base_joints, reference.platform_joints, home=ht.pose_from_coordinates([0, 0, 0, 0, 0, 5])
    )
    with pytest.raises(ArgumentError, match="home"):
        ht.write_hexapod(turned, tmp_path)
    assert not list(tmp_path.iterdir())


def test_missing_files_and_folders_are_named(tmp_path: Path) -> None:
    """A path without a machine says where it looked."""
    with pytest.raises(HexathermalError, match="hexapod.toml"):
        ht.load_hexapod(tmp_path)
    with pytest.raises(HexathermalError, match="neither a bundled machine"):
        ht.load_hexapod(tmp_path / "nothing.toml")
