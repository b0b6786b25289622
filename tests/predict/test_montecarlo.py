"""Monte Carlo: published distributions, agreement with the linear budget where it holds, and its refusal where not."""

from __future__ import annotations

import numpy as np
import pytest

import hexathermal as ht
from hexathermal.errors import ArgumentError, NotConvergedError
from hexathermal.predict.budget_defaults import default_sources
from hexathermal.predict.budget_inputs import situation
from hexathermal.predict.montecarlo import drawn_errors, monte_carlo
from hexathermal.predict.montecarlo_draws import Drawn, Sample, shortest_interval, variables
from hexathermal.predict.sources import DISTRIBUTIONS, Source, Sources

TEMPS = [25.0, 24.0, 26.0, 25.5, 23.0, 22.0]


def test_four_uniform_inputs_of_jcgm_101(rng) -> None:
    """JCGM 101, 9.2.3: the sum of four uniform inputs of unit variance has u = 2 and a 95 % interval of +-3.88."""
    y = variables(Source("x", "length", 1.0, "uniform"), (4, 1_000_000), rng).sum(axis=0)[:, None]
    low, high = shortest_interval(y, 0.95)
    assert y.std() == pytest.approx(2.0, abs=0.01)
    assert low[0] == pytest.approx(-3.88, abs=0.04)
    assert high[0] == pytest.approx(3.88, abs=0.04)


def test_shortest_interval_of_a_skew_distribution(rng) -> None:
    """The shortest 95 % interval of an exponential distribution begins at 0 and ends at -ln 0.05."""
    low, high = shortest_interval(rng.exponential(size=(400_000, 1)), 0.95)
    assert low[0] < 1e-3
    assert high[0] == pytest.approx(-np.log(0.05), abs=0.03)


@pytest.mark.parametrize("name", sorted(set(DISTRIBUTIONS.values())))
def test_distributions_have_the_variance_they_say(name: str, rng) -> None:
    """Every distribution is centred, and of unit variance; t of nu / (nu - 2)."""
    source = Source("x", "length", 1.0, name, dof=12.0 if name == "t" else np.inf)
    z = variables(source, (2, 200_000), rng).T
    assert np.abs(z.mean(axis=0)).max() < 0.01
    assert z.var(axis=0) == pytest.approx(np.full(2, 1.2 if name == "t" else 1.0), rel=0.03)
    width = {"uniform": 3, "triangular": 6, "arcsine": 2}.get(name)
    if width:
        assert 0.99 * width**0.5 < np.abs(z).max() <= width**0.5


def test_every_contribution_is_that_of_its_draws(reference: ht.Hexapod, rng) -> None:
    """The covariance of each source alone is that of 40 000 draws through exact kinematics, within their scatter."""
    pose = ht.pose_from_coordinates([5, -10, 12, 1, 1.5, -2], hexapod=reference)
    here = situation(reference, pose, TEMPS, at_tool=[0, 0, 0.12])
    budget = reference.error_budget(pose, TEMPS, at_tool=[0, 0, 0.12])
    own = {item.label: item for item in budget.contributions}
    for source in default_sources(reference):
        drawn = Drawn(here, Sources((source,)))(40_000, rng)
        wanted = own[source.label]
        scale = np.outer(wanted.uncertainty, wanted.uncertainty)
        assert (np.abs(np.cov(drawn.T) - wanted.covariance) <= 0.03 * scale + 1e-24).all(), source.label


def test_linear_budget_may_be_used_where_errors_are_small(reference: ht.Hexapod) -> None:
    """Micrometres on a machine of 1 m: both ways agree; the same seed gives the same draws."""
    delta = 0.15 * reference.error_budget(reference.home, TEMPS).uncertainty
    a, b = (monte_carlo(reference, reference.home, TEMPS, seed=3, tolerance=delta) for _ in range(2))
    assert a.stable
    assert a.linear_may_be_used is True
    assert np.array_equal(a.mean, b.mean)
    assert np.array_equal(a.low, b.low)
    assert (a.scatter <= 0.2 * a.tolerance).all()
    assert a.budget.uncertainty == pytest.approx(a.uncertainty, rel=0.01)


def test_linear_budget_may_not_be_used_for_a_uniform_source_alone(reference: ht.Hexapod) -> None:
    """One uniform source: the exact 95 % interval is +-0.95 sqrt(3) u, not +-1.96 u; the verdict says no."""
    sources = [Source("offset", "pose", [1e-6] * 6, "uniform")]
    found = monte_carlo(reference, reference.home, TEMPS, sources, most_draws=400_000)
    assert found.linear_may_be_used is not True
    loose = monte_carlo(reference, reference.home, TEMPS, sources, most_draws=400_000, tolerance=0.2e-6)
    assert loose.linear_may_be_used is False
    assert "may not be used" in loose.verdict
    half = 0.5 * (loose.high - loose.low)
    assert half == pytest.approx(np.full(6, 0.95 * 3**0.5 * 1e-6), rel=0.01)


def test_bent_kinematics_shift_the_mean(reference: ht.Hexapod) -> None:
    """Millimetres on the legs bend the answer: the mean moves by half the sum of second derivatives, as it must."""
    s = 1.5e-3
    found = monte_carlo(
        reference, reference.home, [20.0] * 6, [Source("loose", "length", s)], most_draws=200_000, least_draws=200_000
    )
    here = situation(reference, reference.home, [20.0] * 6)
    x = np.zeros((12, here.size))
    x[:, here.blocks("length")[0]] = s * np.vstack([np.eye(6), -np.eye(6)])
    wanted = 0.5 * (here.errors(x).sum(axis=0) - 12.0 * here.errors()[0])[2]
    scatter = found.uncertainty[2] / np.sqrt(found.draws)
    assert abs(wanted) > 5.0 * scatter
    assert found.mean[2] - found.budget.remaining[2] == pytest.approx(wanted, abs=4.0 * scatter)


def test_a_tolerance_that_is_not_met_is_not_decided(reference: ht.Hexapod) -> None:
    """Where the draws do not suffice, the verdict is neither yes nor no; JCGM's digits give its tolerance."""
    found = monte_carlo(reference, reference.home, TEMPS, digits=2, least_draws=20_000, most_draws=20_000)
    assert found.linear_may_be_used is None
    assert "not decided" in found.verdict
    u = found.budget.uncertainty
    assert ((found.tolerance >= 0.5 * u / 100.0) & (found.tolerance <= 0.5 * u / 10.0)).all()


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"probability": 1.0}, "between 0 and 1"), ({"digits": 0}, "digits"), ({"tolerance": -1.0}, "above 0"),
        ({"tolerance": 1e-7, "digits": 2}, "either"), ({"most_draws": 100}, "at least"), ({"seed": -1}, "seed"),
        ({"most_draws": 10**9}, "memory"), ({"least_draws": 1.5}, "whole number"), ({"tolerance": [1, 2]}, "six"),
        ({"most_lost": 0.06}, "most_lost"), ({"most_lost": -0.1}, "most_lost"),
    ],
)  # fmt: skip
def test_senseless_arguments_are_refused(reference: ht.Hexapod, options: dict, words: str) -> None:
    """Every senseless argument is refused before any draw."""
    with pytest.raises(ArgumentError, match=words):
        monte_carlo(reference, reference.home, TEMPS, **options)


def test_draws_that_leave_the_branch_are_refused(reference: ht.Hexapod) -> None:
    """Standard uncertainties of decimetres are no budget: refused, with how many draws are lost and how many may be."""
    with pytest.raises(NotConvergedError, match=r"of 10000 draws \(.* %, allowed 0.1 %: most_lost\) .* too far"):
        monte_carlo(reference, reference.home, TEMPS, [Source("wild", "length", 0.2)])


def test_a_few_lost_draws_are_counted_and_count_as_outside(reference: ht.Hexapod) -> None:
    """One draw of a heavy tail does not end the run: it is counted, told, and lies outside every interval."""
    wild = [Source("wild", "length", 1e-5, dof=1.3)]
    options = {"least_draws": 20_000, "most_draws": 20_000, "probability": 0.9, "seed": 2}
    found = monte_carlo(reference, reference.home, TEMPS, wild, **options)
    assert 0 < found.lost < 20
    assert found.note.startswith(f"{found.lost} of 20000 draws")
    assert found.as_dict()["lost_draws"] == found.lost
    here = situation(reference, reference.home, TEMPS)
    errors = Drawn(here, Sources(tuple(wild)))(20_000, np.random.default_rng(3))
    kept = errors[~np.isnan(errors[:, 0])]
    assert len(kept) < 20_000
    inside = ((kept >= found.low) & (kept <= found.high)).sum(axis=0) / 20_000
    assert np.abs(inside - 0.9).max() < 0.01
    with pytest.raises(NotConvergedError, match="allowed 0 %"):
        monte_carlo(reference, reference.home, TEMPS, wild, most_lost=0.0, **options)
    calm = monte_carlo(reference, reference.home, TEMPS, [Source("calm", "length", 1e-6)])
    assert (calm.lost, calm.note) == (0, "")


def test_draws_are_exact(reference: ht.Hexapod, rng) -> None:
    """Poses of drawn lengths have those lengths to 1e-14 m, also millimetres away; turns are exact rotation vectors."""
    from scipy.spatial.transform import Rotation

    pose = ht.pose_from_coordinates([5, -10, 12, 1, 1.5, -2], hexapod=reference)
    here = situation(reference, pose, [20.0] * 6)
    for spread in (1e-7, 1e-5, 1e-3):
        x = np.zeros((200, here.size))
        x[:, here.blocks("length")[0]] = spread * rng.normal(size=(200, 6))
        e = here.errors(x)
        reached = np.repeat(pose[None], 200, axis=0)
        reached[:, :3, 3] += e[:, :3]
        reached[:, :3, :3] = Rotation.from_rotvec(e[:, 3:]).as_matrix() @ pose[:3, :3]
        wanted = here.told + x[:, here.blocks("length")[0]]
        assert np.abs(reference.inverse_kinematics(reached) - wanted).max() < 1e-14


def test_errors_of_drawn_lengths(reference: ht.Hexapod, rng) -> None:
    """Errors of drawn lengths are those of forward kinematics, at a point and in a frame; no law is asked for."""
    pose = ht.pose_from_coordinates([5, -10, 12, 1, 1.5, -2], hexapod=reference)
    lengths = reference.inverse_kinematics(pose) + 1e-5 * rng.normal(size=(300, 6))
    found = drawn_errors(reference, pose, lengths, at_tool=[0, 0, 0.1])
    reached = reference.forward_kinematics(lengths)
    arm = np.array([0, 0, 0.1])
    wanted = reached[:, :3, 3] + reached[:, :3, :3] @ arm - pose[:3, 3] - pose[:3, :3] @ arm
    assert np.abs(found[:, :3] - wanted).max() < 1e-14
    with pytest.raises(ArgumentError, match="shape"):
        drawn_errors(reference, pose, lengths[:, :5])
    with pytest.raises(NotConvergedError, match="too far"):
        drawn_errors(reference, pose, lengths + 0.2)


@pytest.mark.parametrize(("p", "length"), [(0.95, 10_000), (0.99, 10_000), (0.9999, 1_000_000), (0.999, 100_000)])
def test_sequences_have_the_length_of_jcgm_101(p: float, length: int) -> None:
    """A sequence has 10^4 draws or 100 / (1 - p) (JCGM 101, 7.9.4), not one more for the rounding of 1 - p."""
    assert Sample(p).length == length


def test_the_shortest_interval_of_few_values_is_their_range() -> None:
    """Where the probability rounds to all values, the interval is the whole range."""
    low, high = shortest_interval(np.array([[3.0], [1.0], [2.0]]), 0.95)
    assert (low.item(), high.item()) == (1.0, 3.0)
