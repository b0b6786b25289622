"""What poses and temperatures can tell apart, and the poses that tell it best."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

import hexathermal as ht
from hexathermal.errors import ArgumentError
from hexathermal.kinematics.limits import margins
from hexathermal.kinematics.sampled_poses import reachable_coordinates
from hexathermal.learn.hexapod_data import HexapodRows
from hexathermal.learn.hexapod_design import PoseDesign, designed_poses
from hexathermal.learn.hexapod_fit import HexapodModel, fit_model, model_of
from hexathermal.learn.hexapod_model import hexapod_equations
from hexathermal.learn.hexapod_observability import observability
from tests.learn.hexapods import EQUAL, NOISE, drawn_rows, machine, temperatures

OWN = model_of("leg-specific", ("T1",), ("T1",), common=False, plates=(None, None))
COMMON = model_of("common", ("T1",), ("T1",), common=True, plates=(None, None))


def planned(rng: np.random.Generator, six: np.ndarray, dT: np.ndarray, plates: np.ndarray) -> HexapodRows:
    """Rows of a planned run at poses and temperatures; what is measured there does not matter."""
    rows = drawn_rows(rng, runs=1, coordinates=six, noise=np.zeros(6), frame=0.0)
    return dataclasses.replace(rows, dT=dT[..., None], plates=plates)


def test_homogeneous_warmth_at_one_pose_hides_the_plates(rng: np.random.Generator) -> None:
    """Everything at one temperature and one pose: six equal legs look like the platform by |r| > 0.99, and that is
    said in words; many poses and temperatures make them different.
    """
    home = np.zeros((30, 6))
    warmth = np.linspace(0.0, 5.0, 30)[:, None]
    same = planned(rng, home, np.repeat(warmth, 6, axis=1), np.repeat(warmth, 2, axis=1))
    seen = observability(hexapod_equations(same, NOISE, 0.0, "none").S, COMMON)
    legs, platform = seen.groups.index("six equal legs (A T1)"), seen.groups.index("the platform")
    assert abs(seen.likeness[legs, platform]) > 0.99
    assert any("the platform against six equal legs (A T1): r = " in words for words in seen.words)
    assert not any(one.told_apart for one in seen.coefficients if one.name == "platform")
    spread = drawn_rows(rng, runs=3)
    other = observability(hexapod_equations(spread, NOISE, 0.0, "none").S, COMMON)
    assert abs(other.likeness[legs, platform]) < 0.9
    assert all(one.told_apart for one in other.coefficients)
    assert other.condition < 0.1 * seen.condition


def test_singular_values_are_those_of_the_columns(rng: np.random.Generator) -> None:
    """Singular values, uncertainties and inflations agree with numpy's SVD and inverse of the stacked, weighted columns
    with the frame among them.
    """
    rows = drawn_rows(rng, runs=1)
    equations = hexapod_equations(rows, NOISE, 2e-7, "run")
    seen = observability(equations.S, OWN)
    from hexathermal.learn.hexapod_model import columns, frame_columns, row_covariance

    X = columns(rows.hexapod, rows.measured, rows.q, rows.dT, rows.plates)
    F = frame_columns(rows.hexapod, rows.measured)
    L = np.linalg.cholesky(row_covariance(rows.hexapod, rows.measured, NOISE, 2e-7))
    W = np.linalg.solve(L, np.concatenate([X, F], axis=2)).reshape(-1, 20)
    # the order of theta is that of b here
    W = W[:, [*(int(k) for k in np.argmax(OWN.C, axis=0)), *range(14, 20)]]
    Q, _r = np.linalg.qr(W[:, 14:])
    rest = W[:, :14] - Q @ (Q.T @ W[:, :14])
    values = np.linalg.svd(rest / np.linalg.norm(rest, axis=0), compute_uv=False)
    assert np.allclose(values, seen.singular_values, rtol=1e-6)
    u = np.sqrt(np.diagonal(np.linalg.inv(rest.T @ rest)))
    assert np.allclose(u, [one.uncertainty for one in seen.coefficients], rtol=1e-6)
    assert np.allclose(1.0 / np.linalg.norm(rest, axis=0), [one.alone for one in seen.coefficients], rtol=1e-6)


def test_a_leg_that_never_moves_is_not_told_apart(rng: np.random.Generator) -> None:
    """With the legs held at one length A and B are the same column: both are said not to be told apart, by name."""
    n = 40
    dT, plates = temperatures(rng, n)
    still = planned(rng, np.zeros((n, 6)), dT, plates)
    seen = observability(hexapod_equations(still, NOISE, 1e-7, "none").S, COMMON)
    lost = {one.name for one in seen.coefficients if not one.told_apart}
    assert {"A T1", "B T1"} <= lost
    assert "A T1" in seen.words[-1]
    assert "B T1" in seen.words[-1]
    with pytest.raises(ArgumentError, match="cannot tell"):
        fit_model(hexapod_equations(still, NOISE, 1e-7, "none"), COMMON)


def test_a_dead_coefficient_has_no_finite_uncertainty() -> None:
    """A coefficient without any information is infinitely uncertain, and the others are not disturbed."""
    model = HexapodModel("x", np.zeros(2), np.eye(2), ("A T1", "platform"))
    seen = observability(np.diag([4.0, 0.0]), model)
    assert [one.uncertainty for one in seen.coefficients] == [0.5, np.inf]


def problem(rng: np.random.Generator, slots: int = 24) -> tuple[ht.Hexapod, np.ndarray, np.ndarray, np.ndarray]:
    """A machine, candidates, and the temperatures of a planned run."""
    dT, plates = temperatures(rng, slots)
    return machine(), reachable_coordinates(machine(), 60, rng), dT, plates


def truly(rng: np.random.Generator, design: PoseDesign | np.ndarray, dT: np.ndarray, plates: np.ndarray) -> np.ndarray:
    """The covariance that poses leave, by the equations of identification."""
    six = design if isinstance(design, np.ndarray) else design.coordinates
    S = OWN.C.T @ hexapod_equations(planned(rng, six, dT, plates), NOISE, 0.0, "run").S @ OWN.C
    return np.linalg.inv(S)


@pytest.mark.long
@pytest.mark.parametrize("criterion", ["D", "A", "E"])
def test_designed_poses_are_better_than_random_ones(rng: np.random.Generator, criterion: str) -> None:
    """Poses are within all limits; their covariance is what identification would state, smaller than that of 20 random
    designs in the design's own criterion, and the mean uncertainty is smaller by more than a fifth.
    """
    hexapod, candidates, dT, plates = problem(rng)
    design = designed_poses(hexapod, candidates, dT[..., None], plates, NOISE, OWN, criterion=criterion)
    assert margins(hexapod, ht.pose_from_coordinates(design.coordinates, hexapod=hexapod)).reachable.all()
    covariance = truly(rng, design, dT, plates)
    # planned at the commanded poses, identified at the measured ones: microns apart
    assert np.allclose(np.diagonal(covariance), np.diagonal(design.covariance), rtol=2e-3)
    worth = {
        "D": lambda C: np.linalg.slogdet(C)[1], "A": np.trace, "E": lambda C: np.linalg.eigvalsh(C)[-1],
    }[criterion]  # fmt: skip
    random = [truly(rng, candidates[rng.integers(60, size=24)], dT, plates) for _draw in range(20)]
    assert worth(covariance) < min(worth(C) for C in random)
    mean = np.mean([np.sqrt(np.diagonal(C)) for C in random], axis=0)
    assert np.mean(np.sqrt(np.diagonal(covariance)) / mean) < 0.8


def test_no_exchange_improves_the_design(rng: np.random.Generator) -> None:
    """Every single exchange of a pose, tried one by one through the equations of identification, is no better."""
    hexapod, candidates, dT, plates = problem(rng, 8)
    candidates = candidates[:10]
    design = designed_poses(hexapod, candidates, dT[..., None], plates, NOISE, COMMON)

    def worth(chosen: np.ndarray) -> float:
        S = COMMON.C.T @ hexapod_equations(planned(rng, candidates[chosen], dT, plates), NOISE, 0.0, "run").S @ COMMON.C
        return float(np.linalg.slogdet(S)[1])

    best = worth(design.chosen)
    for slot in range(8):
        for other in range(10):
            changed = design.chosen.copy()
            changed[slot] = other
            assert worth(changed) <= best + 1e-3


@pytest.mark.long
def test_designed_campaigns_find_laws_closer_to_the_truth(rng: np.random.Generator) -> None:
    """Over 30 campaigns each with fresh noise, the laws' errors at designed poses are smaller (root mean square of all
    twelve coefficients) than at random poses.
    """
    hexapod, candidates, dT, plates = problem(rng, 40)
    design = designed_poses(hexapod, candidates, dT[..., None], plates, NOISE, OWN)
    errors = []
    for six in (design.coordinates, candidates[rng.integers(60, size=40)]):
        off = []
        for _campaign in range(30):
            rows = drawn_rows(rng, runs=1, coordinates=six, frame=0.0)
            fit = fit_model(hexapod_equations(rows, NOISE, 0.0, "run"), OWN)
            off.append(fit.theta[:12] - EQUAL.ravel())
        errors.append(np.sqrt(np.mean(np.square(off))))
    assert errors[0] < errors[1]


def test_what_is_known_already_is_not_measured_again(rng: np.random.Generator) -> None:
    """With earlier runs the next run's design leaves less uncertainty than either alone."""
    hexapod, candidates, dT, plates = problem(rng)
    known = hexapod_equations(drawn_rows(rng, runs=2), NOISE, 0.0, "run").S
    alone = designed_poses(hexapod, candidates, dT[..., None], plates, NOISE, OWN)
    both = designed_poses(hexapod, candidates, dT[..., None], plates, NOISE, OWN, known=known)
    before = np.sqrt(np.diagonal(np.linalg.inv(OWN.C.T @ known @ OWN.C)))
    assert (both.uncertainty < alone.uncertainty).all()
    assert (both.uncertainty < before).all()


def test_a_design_that_cannot_be_is_refused(rng: np.random.Generator) -> None:
    """An unknown criterion, and a run in which nothing warms, are refused with what to try."""
    hexapod, candidates, dT, plates = problem(rng)
    with pytest.raises(ArgumentError, match="expected one of 'D', 'A', 'E'"):
        designed_poses(hexapod, candidates, dT[..., None], plates, NOISE, OWN, criterion="G")
    with pytest.raises(ArgumentError, match="plan other temperatures"):
        designed_poses(hexapod, candidates, 0.0 * dT[..., None], plates, NOISE, OWN)
