"""The pytest plugin: acceptance tests that read like a sentence, and a pytest that is none the slower for it."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pinocchio as pin
import pytest

from hexathermal.errors import ArgumentError
from hexathermal.poses import pose_from_coordinates
from hexathermal.pytest_plugin import assert_pose_accuracy

pytest_plugins = ["pytester"]

VISITS = np.array([[0.001, 0, 0, 0, 0, 0], [0.003, 0, 0, 0, 0, 0]])

TESTS = """
VISITS = [[0.001, 0, 0, 0, 0, 0], [0.003, 0, 0, 0, 0, 0]]

def test_good(assert_pose_accuracy):
    assert assert_pose_accuracy(VISITS, [0] * 6, AP_um=3, RP_um=2, u_um=0.1).count == 2

def test_bad(assert_pose_accuracy):
    assert_pose_accuracy(VISITS, [0] * 6, AP_um=1, RP_um=2, u_um=0.1)

def test_unclear(assert_pose_accuracy):
    assert_pose_accuracy(VISITS, [0] * 6, AP_um=2.1, u_um=0.1)
"""


def test_fixture_in_a_test_of_a_user(pytester: pytest.Pytester) -> None:
    """A met limit passes, an unmet and an undecided one fail, with value, limit, uncertainty and probability told."""
    pytester.makeconftest('pytest_plugins = ["pytest_hexathermal"]')
    pytester.makepyfile(TESTS)
    done = pytester.runpytest("-p", "no:cacheprovider")
    done.assert_outcomes(passed=1, failed=2)
    done.stdout.fnmatch_lines(
        [
            "*FAIL  AP = 2.000 um, limit 1 um, standard uncertainty 0.1 um, conformance probability 0.0000",
            "*a value up to 0.836 um would pass",
            "*PASS  RP = 1.000 um*",
            "*NOT DECIDED  AP = 2.000 um, limit 2.1 um*0.8413",
        ]
    )
    done.stdout.no_fnmatch_line("*__tracebackhide__*")


def test_an_unused_plugin_loads_nothing() -> None:
    """Until a test asks for the fixture, neither hexathermal nor NumPy is imported."""
    code = "import sys, pytest_hexathermal; print([n for n in ('hexathermal', 'numpy', 'scipy') if n in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_coordinates_matrices_and_se3_are_the_same() -> None:
    """Millimetres and degrees, matrices in metres and Pinocchio's poses give the same values."""
    poses = pose_from_coordinates(VISITS)
    given = ((VISITS, [0] * 6), (poses, np.eye(4)), ([pin.SE3(pose) for pose in poses], pin.SE3.Identity()))
    found = [assert_pose_accuracy(*pair, AP_um=9, u_um=0.1).AP for pair in given]
    assert found == pytest.approx([2e-6] * 3, rel=1e-9)


def test_turns_have_limits_of_their_own() -> None:
    """A rotation of 20 urad keeps 30 urad and not 10; its uncertainty is in urad."""
    turned = [[0, 0, 0, 0, 0, np.degrees(20e-6)]] * 2
    assert assert_pose_accuracy(turned, [0] * 6, AP_rotation_urad=30, RP_rotation_urad=3, u_urad=1).count == 2
    with pytest.raises(AssertionError, match=r"FAIL  AP_rotation = 20.000 urad, limit 10 urad"):
        assert_pose_accuracy(turned, [0] * 6, AP_rotation_urad=10, u_urad=1)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"u_um": 0.1}, "no limit is given"),
        ({"AP_um": 3}, "needs u_um"),
        ({"AP_um": 3, "u_um": 0}, "above 0"),
        ({"AP_rotation_urad": 3, "u_um": 0.1}, "needs u_urad"),
    ],
)
def test_a_test_without_limit_or_uncertainty_is_an_error(options: dict[str, float], words: str) -> None:
    """Nothing passes because something was forgotten; with rule='simple' an uncertainty may be left out."""
    with pytest.raises(ArgumentError, match=words):
        assert_pose_accuracy(VISITS, [0] * 6, **options)  # type: ignore[arg-type]
    assert assert_pose_accuracy(VISITS, [0] * 6, AP_um=3, rule="simple").count == 2


@pytest.mark.parametrize("visits", [VISITS[:1], VISITS[:, :3], [[0] * 6, [0] * 5], []])
def test_what_is_no_pose_is_an_error(visits: object) -> None:
    """One visit, positions alone, ragged lists and nothing are refused."""
    with pytest.raises(ArgumentError):
        assert_pose_accuracy(visits, [0] * 6, AP_um=3, u_um=0.1)
