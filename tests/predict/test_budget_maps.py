"""Budgets over poses and times, sources from files."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest

import hexathermal as ht
from hexathermal import cli
from hexathermal.errors import ArgumentError, FileFormatError, KinematicsError, TemperatureError, UnknownNameError
from hexathermal.predict.budget_defaults import default_sources
from hexathermal.predict.budget_files import read_sources
from hexathermal.predict.budget_maps import budget_map, graded_temperatures, pose_grid
from hexathermal.predict.budget_plates import Plates
from hexathermal.predict.sources import Source
from tests.predict.budget_oracle import thermal_machine

TEMPS = [25.0] * 6


@pytest.mark.long
@pytest.mark.parametrize("view", [
    {}, {"at_tool": [0.01, 0, 0.1], "correction": False, "air_degC": 23.0},
    {"frame": "object", "frames": ht.Frames(object=[5, -6, 90, 3, -4, 50])},
    {"frame": "user", "frames": ht.Frames(user=[100, 20, -30, 10, 20, 30]),
     "plates": Plates(base_degC=23.0, platform_gradient=(3.0, 0.0, 0.0))},
])  # fmt: skip
def test_a_map_holds_the_budgets_of_its_poses(view: dict) -> None:
    """Every place of a map is the budget of its pose, down to rounding: bias, causes, uncertainty, shares, limits."""
    machine = thermal_machine()
    temps = np.linspace(22.0, 27.0, 13)
    sources = default_sources(machine).plus(
        Source("few", "length", 1e-6, dof=4), Source("joined", "scale", 1e-6, dof=5, correlation=0.5 * (1 + np.eye(6)))
    )
    poses = pose_grid(machine, x_mm=(-100, 100, 3), rz_deg=(-5, 5, 2))
    found = budget_map(machine, poses, temps, sources, **view)
    for k, pose in enumerate(poses):
        one = machine.error_budget(pose, temps, sources, **view)
        assert np.abs(found.remaining[k] - one.remaining).max() < 1e-15
        assert np.abs(found.uncorrected[k] - one.uncorrected).max() < 1e-15
        assert found.uncertainty[k] == pytest.approx(one.uncertainty, rel=1e-12)
        assert found.worst_case[k] == pytest.approx(one.worst_case(), rel=1e-12)
        assert found.causes == one.causes
        assert np.abs(found.cause_parts[k] - one.cause_parts).max() < 1e-15
        for label, shares in zip((item.label for item in one.contributions), one.shares, strict=True):
            assert found.shares[k, found.labels.index(label)] == pytest.approx(shares, rel=1e-9, abs=1e-15)
    assert np.allclose(found.shares.sum(axis=1), 1.0)


def test_the_worst_place_is_the_largest(reference: ht.Hexapod) -> None:
    """The worst place of a map is the largest worst case, with its source and axis."""
    poses = pose_grid(reference, x_mm=(-100, 100, 3), rz_deg=(-5, 5, 2))
    found = budget_map(reference, poses, TEMPS, at_tool=[0, 0, 0.1])
    worst = found.worst("turn")
    assert worst.value == found.size("worst_case", "turn").max()
    assert worst.source in found.labels
    assert worst.axis in worst.reason


@pytest.mark.parametrize("correction", [True, False])
def test_a_map_of_many_chunks_tells_its_progress(reference: ht.Hexapod, correction: bool) -> None:
    """Places of any chunk, among refused ones, are those of their own budget; progress ends at the whole."""
    poses = pose_grid(reference, z_mm=(-40, 200, 600))
    told: list[tuple[int, int]] = []
    found = budget_map(
        reference, poses, TEMPS, correction=correction, progress=lambda done, total: told.append((done, total))
    )
    good = np.isfinite(found.worst_case[:, 0])
    assert told[-1] == (600, 600)
    assert np.array_equal(np.flatnonzero(~good), [k for k, _reason in found.refused])
    assert 100 < good.sum() < 500
    for k in np.flatnonzero(good)[::29]:
        one = reference.error_budget(poses[k], TEMPS, correction=correction)
        assert found.worst_case[k] == pytest.approx(one.worst_case(), rel=1e-12)
    with pytest.raises(KinematicsError) as caught:
        reference.error_budget(poses[-1], TEMPS, correction=correction)
    assert dict(found.refused)[599] == str(caught.value)


def test_poses_out_of_reach_stay_with_their_reason(reference: ht.Hexapod) -> None:
    """A pose out of stroke is NaN and told; a map of none but such is an error."""
    found = budget_map(reference, pose_grid(reference, z_mm=(0, 400, 3)), TEMPS)
    assert [k for k, _reason in found.refused] == [1, 2]
    assert "out of stroke" in found.refused[0][1]
    assert np.isnan(found.worst_case[1:]).all()
    assert found.worst().index == 0
    with pytest.raises(ArgumentError, match="out of stroke"):
        budget_map(reference, pose_grid(reference, z_mm=(400, 500, 2)), TEMPS).worst()


def test_singular_poses_stay_with_their_reason(reference: ht.Hexapod) -> None:
    """Poses that legs do not hold, or where a leg has no length, are told beside one that can be reached."""
    free = {"retracted_length": 0.05, "stroke": None, "base_cone": None, "platform_cone": None}
    flat = dataclasses.replace(reference, base_joints=reference.platform_joints * [1, 1, 0] * 1.5, home=[0] * 3, **free)
    found = budget_map(flat, np.stack([flat.home, flat.home]), TEMPS)
    assert [k for k, _reason in found.refused] == [0, 1]
    assert "singular pose" in found.refused[0][1]
    shifted = np.array(reference.base_joints)
    shifted[0] = reference.platform_joints[0]
    bent = dataclasses.replace(
        reference, base_joints=shifted, home=ht.pose_from_coordinates([50, 80, 300, 5, 8, 20]), **free
    )
    found = budget_map(bent, np.stack([np.eye(4), bent.home]), TEMPS)
    assert [k for k, _reason in found.refused] == [0]
    assert "leg 1 has length 0" in found.refused[0][1]
    assert found.uncertainty[1] == pytest.approx(bent.error_budget(bent.home, TEMPS).uncertainty, rel=1e-9)


def test_a_day_follows_its_temperatures_and_plates(reference: ht.Hexapod) -> None:
    """At one pose, drift grows with temperature; plates may differ from row to row."""
    temps = np.linspace(20.0, 30.0, 5)[:, None] * np.ones(6)
    day = budget_map(reference, reference.home, temps, each_plates=[Plates(20.0 + k, 20.0) for k in range(5)])
    assert np.all(np.diff(day.size("uncorrected")) > 0.0)
    assert day.worst().index == 4
    alone = reference.error_budget(reference.home, temps[3], plates=Plates(23.0, 20.0))
    assert np.abs(day.remaining[3] - alone.remaining).max() < 1e-15
    mixed = [Plates(base_degC=24.0), Plates(), Plates(23.0, 24.0), Plates(base_degC=24.0), Plates()]
    found = budget_map(reference, reference.home, temps, each_plates=mixed, each_air_degC=np.linspace(20, 24, 5))
    for k in range(5):
        one = reference.error_budget(reference.home, temps[k], plates=mixed[k], air_degC=20.0 + k)
        assert found.worst_case[k] == pytest.approx(one.worst_case(), rel=1e-12)


def test_bias_that_rules_is_named(reference: ht.Hexapod) -> None:
    """Where the bias is larger than the expanded uncertainty, the reason says so."""
    few = [Source("tiny", "length", 1e-9)]
    worst = budget_map(reference, reference.home, TEMPS, few).worst()
    assert worst.mostly_bias
    assert worst.causes == ("expansion of the base",)
    assert "mostly the bias that remains (the expansion of the base" in worst.reason
    sloped = budget_map(reference, reference.home, TEMPS, few, plates=Plates(base_gradient=(0.0, 50.0, 0.0)))
    assert sloped.worst("turn").causes == ("gradient across the base",)


def test_sources_that_weigh_the_same_are_named_together(reference: ht.Hexapod) -> None:
    """Joints of base and platform make up equal parts and are both told; nothing at all is called nothing."""
    worst = budget_map(reference, reference.home, TEMPS).worst()
    assert set(worst.sources) == {"base joint position", "platform joint position"}
    assert "base joint position and platform joint position, 4" in worst.reason
    cold = budget_map(reference, reference.home, [20.0] * 6, [])
    assert "nothing is off" in cold.worst().reason


def test_gradients_across_the_legs(reference: ht.Hexapod, two_plates: ht.Hexapod) -> None:
    """A gradient along x warms each leg by its middle's x; the mean stays; the platform turns about y."""
    temps = graded_temperatures(reference, 25.0, [4.0, 0.0, 0.0])
    middles = 0.5 * (reference.platform_joints + reference.base_joints)[:, 0]
    assert np.allclose(temps - 25.0, 4.0 * (middles - middles.mean()), atol=1e-12)
    drift = reference.error_budget(reference.home, temps, []).uncorrected
    assert abs(drift[4]) > 10.0 * abs(drift[3])
    many = graded_temperatures(two_plates, 25.0, [4.0, 0.0, 0.0])
    assert many.shape == (14,)
    assert many[0] == many[1] == temps[0]
    assert many[-1] == 25.0


@pytest.mark.parametrize(
    ("make", "kind", "words"),
    [
        (lambda m: pose_grid(m), ArgumentError, "at least one span"),
        (lambda m: pose_grid(m, w_mm=(0, 1, 2)), UnknownNameError, "not known"),
        (lambda m: pose_grid(m, x_mm=(0, 1, 0)), ArgumentError, "whole number"),
        (lambda m: pose_grid(m, x_mm=(0, 1)), ArgumentError, "low, high, count"),
        (lambda m: pose_grid(m, x_mm=(0, 1, 999), y_mm=(0, 1, 999)), ArgumentError, "more than"),
        (lambda m: budget_map(m, np.stack([m.home] * 2), [TEMPS] * 3), ArgumentError, "pair up"),
        (lambda m: budget_map(m, np.stack([m.home] * 2), TEMPS, each_plates=[Plates()] * 3), ArgumentError, "3 plates"),
        (lambda m: budget_map(m, m.home, TEMPS, plates=25.0), ArgumentError, "must be a Plates"),
        (lambda m: budget_map(m, m.home, TEMPS, each_plates=[3]), ArgumentError, "must be a Plates"),
        (lambda m: budget_map(m, m.home, TEMPS, frame="tool"), UnknownNameError, "not known"),
        (lambda m: budget_map(m, m.home, TEMPS, frmae="user"), TypeError, "frmae"),
        (lambda m: budget_map(m, m.home, TEMPS, air_degC=-400.0), TemperatureError, "impossible"),
        (lambda m: budget_map(m, m.home, TEMPS, each_air_degC=[1.0, 2.0]), ArgumentError, "shape"),
        (lambda m: budget_map(m, m.home, TEMPS, probability=1.0), ArgumentError, "between 0 and 1"),
        (lambda m: budget_map(m, m.home, [60.0] * 6), TemperatureError, "range of validity"),
        (lambda m: budget_map(m, m.home, TEMPS).worst("twist"), UnknownNameError, "not known"),
        (lambda m: budget_map(m, m.home, TEMPS).size("bias"), UnknownNameError, "not known"),
        (lambda m: graded_temperatures(m, 25.0, [1.0]), ArgumentError, "shape"),
    ],
)  # fmt: skip
def test_senseless_maps_are_refused(reference: ht.Hexapod, make, kind: type, words: str) -> None:
    """Every senseless argument says what is wrong with it."""
    with pytest.raises(kind, match=words):
        make(reference)


SOURCES = """\
format = "hexathermal-sources/1"
without = ["backlash"]

[[source]]
label = "fixture"
quantity = "pose"
half_width = [2e-6, 2e-6, 1e-6, 0, 0, 0]
basis = "certificate"

[[source]]
label = "encoder"
quantity = "length"
standard = 2e-8
dof = 7
correlation = "common"
"""


def test_sources_of_a_file(tmp_path: Path, reference: ht.Hexapod) -> None:
    """A file leaves default sources out, replaces them by label and adds its own."""
    file = tmp_path / "sources.toml"
    file.write_text(SOURCES)
    found, known = read_sources(file, reference), default_sources(reference)
    assert set(found.labels) == set(known.labels) - {"backlash"} | {"fixture"}
    assert found["fixture"].distribution == "uniform"
    assert found["encoder"].distribution == "t"
    assert found["encoder"].correlation == "common"
    file.write_text(SOURCES.replace('without = ["backlash"]', "defaults = false"))
    assert read_sources(file, reference).labels == ("fixture", "encoder")


@pytest.mark.parametrize(
    ("old", "new", "line", "words"),
    [
        ('"backlash"', '"backlsh"', 2, "not known"),
        ('quantity = "length"', 'quantity = "lenght"', 12, "not known"),
        ("standard = 2e-8", "standard = -2e-8", 13, "0 or more"),
        ("standard = 2e-8", "", 10, "standard or half_width"),
        ("dof = 7", "dofs = 7", 14, "unknown key"),
        ('"common"', "3", 15, "must be a text"),
        ('correlation = "common"', "matrix = [[1, 2], [2, 1]]", 15, "not positive semidefinite"),
        ("hexathermal-sources/1", "hexathermal-sources/9", 1, "this version reads"),
        ('label = "encoder"', 'label = "fixture"', 11, "unique"),
    ],
)
def test_bad_sources_are_told_with_their_line(
    tmp_path: Path, reference: ht.Hexapod, old: str, new: str, line: int, words: str
) -> None:
    """Each bad field of a file of sources is told with its line."""
    file = tmp_path / "sources.toml"
    file.write_text(SOURCES.replace(old, new))
    with pytest.raises(FileFormatError, match=words) as caught:
        read_sources(file, reference)
    assert caught.value.problems[0].line == line


def test_laws_with_different_sensors_have_independent_sources(reference: ht.Hexapod) -> None:
    """Legs with different numbers of sensors get a budget; a source common to them is refused."""
    laws = (ht.LegLaw(("a", "b"), [1e-6, 1e-6], [1e-6, 0.0]), *[ht.LegLaw("a", 2e-6, 1e-6)] * 5)
    machine = dataclasses.replace(reference, thermal=ht.ThermalModel(laws))
    assert machine.error_budget(machine.home, [25.0] * 7).uncertainty.all()
    with pytest.raises(ArgumentError, match="different numbers of sensors"):
        machine.error_budget(machine.home, [25.0] * 7, [Source("c", "coefficients", 1e-8, correlation="common")])


def test_every_bad_field_of_sources_is_told(tmp_path: Path, reference: ht.Hexapod) -> None:
    """Bad fields of several sources, two in one of them, unknown labels and wrong shapes are told in one error."""
    text = SOURCES.replace('["backlash"]', '["backlash", "nope", "nada"]').replace('"fixture"', '""')
    text = text.replace("-6, 2e-6", "-6, -2e-6").replace('"length"', '"lenght"').replace("dof = 7", "dof = 0")
    text += '[[source]]\nlabel = "m"\nquantity = "length"\nstandard = [1, 2]\nmatrix = [[1, 0], [0, 1]]\n'
    file = tmp_path / "sources.toml"
    file.write_text(text)
    with pytest.raises(FileFormatError) as caught:
        read_sources(file, reference)
    assert [problem.line for problem in caught.value.problems] == [2, 2, 5, 7, 12, 14, 19, 20]
    words = ["--pose", *"000000", "--temps", "25", "--sources", str(file)]
    assert cli.main(["budget", "--machine", "reference", *words]) == 3
