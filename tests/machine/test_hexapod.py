"""The machine as a value: frozen, picklable, checked."""

from __future__ import annotations

import dataclasses
import pickle
import re
from typing import Any

import numpy as np
import pytest

import hexathermal as ht
from hexathermal.errors import ArgumentError, HexathermalError, UnknownNameError
from hexathermal.kinematics import inverse


def test_machines_are_frozen_values(hexapod: ht.Hexapod) -> None:
    """Fields cannot be set, arrays not written, and the caller's own array stays apart."""
    with pytest.raises(dataclasses.FrozenInstanceError):
        hexapod.name = "other"  # type: ignore[misc]
    for array in (hexapod.base_joints, hexapod.platform_joints, hexapod.home, hexapod.stroke, hexapod.retracted_length):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0.0
    own = np.array(hexapod.base_joints)
    made = ht.Hexapod(own, hexapod.platform_joints, home=hexapod.home)
    own[0, 0] += 1.0
    assert made.base_joints[0, 0] == hexapod.base_joints[0, 0]


def test_machines_survive_pickling(hexapod: ht.Hexapod) -> None:
    """A pickled machine is equal, read-only, hashes the same and computes the same."""
    hexapod.inverse_kinematics(hexapod.home)
    again = pickle.loads(pickle.dumps(hexapod))
    assert again == hexapod
    assert hash(again) == hash(hexapod)
    assert not again.base_joints.flags.writeable
    assert np.array_equal(again.inverse_kinematics(hexapod.home), hexapod.inverse_kinematics(hexapod.home))
    assert dataclasses.replace(hexapod, name="other") != hexapod


def test_errors_survive_pickling(reference: ht.Hexapod) -> None:
    """An error raised in a worker process keeps message and fields."""
    try:
        reference.forward_kinematics(np.full(6, 0.9))
    except HexathermalError as error:
        again = pickle.loads(pickle.dumps(error))
        assert str(again) == str(error)
        assert again.__dict__ == error.__dict__
        assert type(again) is type(error)
    else:
        pytest.fail("no error")


def test_repr_tells_what_matters(reference: ht.Hexapod) -> None:
    """repr shows stroke, home, joints, coefficients, sensors and what is not compensated."""
    text = repr(reference)
    for words in (
        "reference",
        "grade C",
        "600 mm",
        "0 .. 250 mm",
        "1.99",
        "1.09",
        "leg6_T1",
        "platform not compensated",
    ):
        assert words in text


def test_default_home_is_mid_stroke_and_regular(reference: ht.Hexapod) -> None:
    """Without a home the platform stands above the base with the mean leg at mid-stroke."""
    machine = ht.Hexapod(reference.base_joints, reference.platform_joints, retracted_length=0.6, stroke=[0, 0.25])
    assert machine.inverse_kinematics(machine.home).mean() == pytest.approx(0.725, abs=1e-12)
    free = ht.Hexapod(reference.base_joints * [1, 1, 0], reference.platform_joints)
    assert free.solve_forward(free.inverse_kinematics(free.home)).ok


@pytest.mark.long
def test_a_machine_needs_no_home(rng: np.random.Generator) -> None:
    """Scattered joints, also some that coincide as given, make a machine with a regular home."""
    for _ in range(200):
        base, platform = rng.normal(size=(6, 3)), rng.normal(size=(6, 3))
        platform[0] = base[0]
        machine = ht.Hexapod(base, platform)
        assert machine.home_lengths.min() > 0.0
        assert machine.solve_forward(machine.home_lengths).ok


@pytest.mark.parametrize(
    ("change", "word"),
    [
        ({"base_joints": np.zeros((5, 3))}, r"expected \(6, 3\)|expected"),
        ({"base_joints": np.full((6, 3), np.nan)}, "nan"),
        ({"platform_joints": "joints"}, "real numbers"),
        ({"retracted_length": -0.6}, "above 0"),
        ({"retracted_length": [0.6, 0.6]}, "six"),
        ({"retracted_length": None}, "stroke needs retracted_length"),
        ({"stroke": [0.25, 0.0]}, "low < high"),
        ({"stroke": [-0.7, 0.25]}, "shrink"),
        ({"stroke": [0, 250]}, None),
        ({"stroke": [0.0, 0.01]}, "home is out of stroke: leg"),
        ({"home": [0, 0, 500]}, "out of stroke.*units"),
        ({"home": np.ones((4, 4))}, "last row"),
        ({"base_cone": 45.0}, "degrees"),
        ({"platform_cone": 0.0}, r"\(0, pi\]"),
        ({"grade": "D"}, "grade"),
        ({"thermal": "law"}, "ThermalModel"),
    ],
)
def test_bad_machines_are_refused(reference: ht.Hexapod, change: dict[str, object], word: str | None) -> None:
    """Every wrong field is refused with its name and what was expected."""
    if word is None:
        dataclasses.replace(reference, **change)  # a huge stroke is odd but possible
        return
    with pytest.raises(ArgumentError, match=word):
        dataclasses.replace(reference, **change)


@pytest.mark.parametrize(
    ("make", "word"),
    [
        (lambda: ht.LegLaw((), [], []), "at least one sensor"),
        (lambda: ht.LegLaw(("T1", "T1"), [1e-6, 1e-6], [1e-6, 1e-6]), "twice"),
        (lambda: ht.LegLaw(("T1",), [1.99], [1e-6]), "1/K"),
        (lambda: ht.LegLaw(("T1",), [1e-6, 2e-6], [1e-6]), "shape"),
        (lambda: ht.LegLaw(("T1",), [1e-6], [1e-6], np.array([[1.0, 2.0], [0.0, 1.0]])), "symmetric"),
        (lambda: ht.LegLaw(("T1",), [1e-6], [1e-6], np.array([[1.0, 2.0], [2.0, 1.0]])), "negative eigenvalue"),
        (lambda: ht.PlateLaw(11.5), "1/K"),
        (lambda: ht.ThermalModel((ht.LegLaw(("T1",), [1e-6], [1e-6]),) * 5), "six"),
        (lambda: ht.ThermalModel(ht.LegLaw(("T1",), [1e-6], [1e-6]), valid_degC=(30, 20)), "low, high"),
        (lambda: ht.ThermalModel(ht.LegLaw(("T1",), [1e-6], [1e-6]), reference_temperature_degC=[20, 21]), "reference"),
        (lambda: ht.ThermalModel(ht.LegLaw(("T1",), [1e-6], [1e-6]), reference_temperature_degC=293.15), "outside"),
    ],
)
def test_bad_laws_are_refused(make: object, word: str) -> None:
    """Sensors, units, covariance, references and ranges are checked when a law is made."""
    with pytest.raises(ArgumentError, match=word):
        make()  # type: ignore[operator]


def test_unknown_machine_lists_the_bundled_ones() -> None:
    """A misspelled name lists what there is."""
    with pytest.raises(UnknownNameError, match=r"reference, rubin-camera, rubin-m2") as caught:
        ht.load_hexapod("refrence")
    assert caught.value.available == ht.bundled_hexapods()


def test_strokes_are_lengths_minus_q0(hexapod: ht.Hexapod) -> None:
    """strokes(lengths) = lengths - q0."""
    lengths = hexapod.inverse_kinematics(hexapod.home)
    assert np.array_equal(hexapod.strokes(lengths), lengths - hexapod.retracted_length)
    assert inverse.inverse_kinematics(hexapod, hexapod.home).shape == (6,)


PAIR = (-1.0, 1.0)


@pytest.mark.parametrize(
    ("limits", "word"),
    [
        ((None, 1, 2, 3, 4, 5), "limit of x"),
        ([("a", "b")] * 6, "limit of x"),
        ([PAIR] * 5 + [(1.0, 1.0)], "limit of rz"),
        ([PAIR] * 5 + [(0.0, np.inf)], "limit of rz"),
        ([PAIR] * 6 + ["zzz"], "convention 'zzz' is not known; choose"),
        ([PAIR] * 6 + [None], "convention must be a name"),
    ],
)
def test_travel_limits_are_pairs_in_a_known_convention(limits: Any, word: str) -> None:
    """What is no pair [low, high], or no known convention, is refused by name."""
    with pytest.raises((ArgumentError, UnknownNameError), match=re.escape(word)):
        ht.PoseLimits(*limits)
    assert ht.PoseLimits(*[PAIR] * 6, convention="Moving_ZYX").x == PAIR
