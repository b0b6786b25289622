"""Benches for campaigns with hidden effects: heat obeys published solutions, and each bench is as noisy as it says."""

from __future__ import annotations

import ast
import itertools
from pathlib import Path

import numpy as np
import pytest
from scipy.linalg import expm

from hexathermal.errors import UnknownNameError
from hexathermal.simulate.hidden import benches
from hexathermal.simulate.hidden.benches import component, modal, quiet, rough
from hexathermal.simulate.hidden.benches.motion import carried_out
from hexathermal.simulate.hidden.benches.noises import remembering, walk
from hexathermal.simulate.hidden.truth import CampaignTruth, RunTruth

OWN = ("component", "modal", "quiet", "rough")
LEGS = ("modal", "quiet", "rough")
DRAWS = 4

LEVELS = {
    "noise_rms_um", "thermometers_rms_um", "white_um", "landing_um", "slow_um", "slow_time_s", "sensor_noise_K",
    "sensor_bias_K", "sensor_walk_6h_K", "sample_s", "drift_resolution_um", "temperature_resolution_K",
}  # fmt: skip


@pytest.fixture(scope="module")
def drawn(seed: int) -> dict[str, list[CampaignTruth]]:
    """Some campaigns of every bench."""
    return {
        name: [
            benches.draw(name, np.random.default_rng([seed, k]))
            for k in range(5 * DRAWS if name == "component" else DRAWS)
        ]
        for name in OWN
    }


def each_run(campaigns: list[CampaignTruth]) -> list[tuple[CampaignTruth, RunTruth]]:
    """All runs, each with its campaign."""
    return [(campaign, run) for campaign in campaigns for run in campaign.runs]


def fin(x: np.ndarray, length: float, diffusivity: float, loss: float) -> np.ndarray:
    """Steady rise of a fin whose foot takes a unit source [1 m/s], other end insulated (any text on heat transfer)."""
    m = np.sqrt(loss / diffusivity)
    return np.cosh(m * (length - x)) / (diffusivity * m * np.sinh(m * length))


def test_modes_reach_the_steady_fin() -> None:
    """Heat at a bar's foot, held for a day, gives the closed form of a fin within 1 %, where it is far from heat."""
    bar, x = modal.Bar(0.5, 4e-6, 1.0 / 4000.0), np.linspace(0.1, 0.5, 9)
    feeding = np.tile(bar.source(np.array(0.0), modal.WIDTH), (5760, 1))
    found = bar.modes(feeding, np.zeros(modal.MODES))[-1] @ bar.shapes(x)
    # heat enters as a bell: a fin answers it as a point's heat, times the bell's mean of exp(m x)
    wider = np.exp(0.5 * bar.loss / bar.diffusivity * modal.WIDTH**2)
    np.testing.assert_allclose(found, wider * fin(x, 0.5, bar.diffusivity, bar.loss), rtol=0.01)


def test_kernel_with_images_reaches_the_steady_fin() -> None:
    """The sum over 8 h of the source's answer, with images, is the closed form of a fin, where it is far from heat."""
    x, length, diffusivity, loss = np.linspace(0.15, 0.5, 8), 0.5, 1.2e-5, 1.0 / 3000.0
    found = rough.STEP * rough.kernel(x, np.array([0.0]), length, diffusivity, loss).sum(axis=0)[0]
    wider = np.exp(0.5 * loss / diffusivity * rough.WIDTH**2)
    np.testing.assert_allclose(found, wider * fin(x, length, diffusivity, loss), rtol=0.01)


def test_modes_solve_the_heat_equation() -> None:
    """A moving source's modes agree with finite differences of the same bar within 1 % of the largest rise."""
    bar, rows, cells = modal.Bar(0.4, 1e-5, 1.0 / 3000.0), 400, 400
    way = 0.2 + 0.1 * np.sin(np.arange(rows) / 40.0)
    feeding = bar.source(way, modal.WIDTH)
    dx = bar.length / cells
    x = dx * (np.arange(cells) + 0.5)
    second = np.diag(np.full(cells, -2.0)) + np.diag(np.ones(cells - 1), 1) + np.diag(np.ones(cells - 1), -1)
    second[0, 0] = second[-1, -1] = -1.0
    system = bar.diffusivity * second / dx**2 - bar.loss * np.eye(cells)
    kept = expm(system * modal.STEP)
    gain = np.linalg.solve(system, kept - np.eye(cells))
    found = np.zeros((rows, cells))
    for k in range(rows - 1):
        bell = np.exp(-0.5 * ((x - way[k]) / modal.WIDTH) ** 2) / (modal.WIDTH * np.sqrt(2.0 * np.pi))
        found[k + 1] = kept @ found[k] + gain @ bell
    mine = bar.modes(feeding, np.zeros(modal.MODES)) @ bar.shapes(x)
    assert np.abs(mine - found).max() < 0.01 * found.max()


def test_network_steps_exactly_and_keeps_energy(seed: int) -> None:
    """Lumps follow the matrix exponential, and at rest give the room all heat they take."""
    generator = np.random.default_rng([seed, 99])
    network = component.drawn_network(generator)
    count, step = len(network.capacity), 45.0
    heat = generator.uniform(0.0, 100.0, (300, count))
    room = 20.0 + np.cumsum(generator.normal(0.0, 0.01, 300))
    found = network.temperatures(heat, room, step)
    whole = np.diag(network.conductance.sum(axis=1) + network.to_room) - network.conductance
    system = -whole / network.capacity[:, None]
    kept = expm(system * step)
    gain = np.linalg.solve(system, kept - np.eye(count)) / network.capacity
    one = np.full(count, room[0])
    for k in range(299):
        one = kept @ one + gain @ (heat[k] + network.to_room * room[k])
        np.testing.assert_allclose(found[k + 1], one, rtol=0, atol=1e-9)
    days = np.tile(heat[0], (60_000, 1))
    warm = network.temperatures(days, np.full(60_000, 20.0), 60.0)[-1]
    assert network.to_room @ (warm - 20.0) == pytest.approx(heat[0].sum(), rel=1e-4)


def test_lag_is_of_first_order() -> None:
    """A unit step is answered by ``1 - exp(-t / tau)`` at every row."""
    found = quiet.lagged(np.ones(100), 60.0)
    np.testing.assert_allclose(found, 1.0 - np.exp(-quiet.STEP * np.arange(100) / 60.0), rtol=0, atol=1e-12)


def test_near_a_source_heat_comes_sooner_and_stronger() -> None:
    """In the network of the quiet leg, each answer to the motor falls and slows down with distance."""
    leg = quiet.drawn_leg(((0,),), np.random.default_rng(1))
    weights = quiet._weights(leg, np.linspace(0.0, 0.3, 12), 0.1, 6e-6)[:, 0, : quiet.BODY]
    assert (np.diff(weights.sum(axis=0)) < 0.0).all()
    mean_time = np.array(quiet.TIMES) @ weights / weights.sum(axis=0)
    assert (np.diff(mean_time) > 0.0).all()


def test_motion_is_as_planned() -> None:
    """Moves run at their speed, rests last as long as planned, and what would end too late is not begun."""
    motion = carried_out(
        iter([(0.02, 1e-3, 30.0), (0.02, 1e-3, 9.0), (0.01, 2e-3, 50.0), (0.09, 1e-3, 1.0)]), 0.0, 10.0, 110.0
    )
    np.testing.assert_allclose(motion.start, [10.0, 60.0])
    np.testing.assert_allclose(motion.end, [30.0, 65.0])
    np.testing.assert_allclose(motion.at(np.array([0.0, 20.0, 59.0, 62.5, 100.0])), [0.0, 0.01, 0.02, 0.015, 0.01])
    assert motion.rest(np.array([9.0, 10.0, 59.0, 64.0])).tolist() == [0, 1, 1, 2]
    assert motion.settled(np.array([0.0, 20.0, 33.0, 34.0, 62.0]), 4.0).tolist() == [True, False, False, True, False]
    speed, place = motion.speed(1.0, 110)
    assert speed.sum() == pytest.approx(0.03)
    assert place[20] == pytest.approx(0.0105)


def test_processes_have_the_spread_and_memory_they_state() -> None:
    """The process that remembers has unit variance and ``exp(-lag)``; walks have unit variance after their rows."""
    generator = np.random.default_rng(7)
    x = remembering(50.0, (400, 4000), generator)
    np.testing.assert_allclose(x[[0, 200, 399]].var(axis=1), 1.0, atol=0.1)
    assert (x[100] * x[150]).mean() == pytest.approx(np.exp(-1.0), abs=0.06)
    assert walk(100.0, (101, 4000), generator)[-1].var() == pytest.approx(1.0, abs=0.1)


def test_every_bench_draws_a_whole_campaign_without_effects(seed: int) -> None:
    """Each bench that is found gives runs of both roles in the agreed shapes, effects zero, drift by the law."""
    for name, bench in benches.found().items():
        campaign = bench.draw(np.random.default_rng([seed, 5]))
        assert campaign.bench == name
        assert {run.role for run in campaign.runs} == {"identification", "validation"}
        s, zero = len(campaign.sensors), campaign.runs[0]
        assert len(campaign.parts) == len(campaign.positions) == s
        base = [campaign.sensors.index(one) for one in campaign.base]
        for run in campaign.runs:
            n = len(run.time)
            assert run.temperatures.shape == run.sensor_errors.shape == (n, s)
            assert run.air.shape == run.beam_effects.shape == (n, 3)
            assert run.inputs.shape == (n, len(campaign.input_names))
            assert run.q.shape == run.settled.shape == run.drift.shape == run.noise.shape == (n,)
            assert not run.effect.any()
            assert not run.beam_effects.any()
            assert (np.diff(run.time) > 0.0).all()
            first = run if campaign.zero == "run" else zero
            dT = run.temperatures[:, base] - first.temperatures[0, base]
            length = campaign.retracted_length if campaign.kind == "leg" else 1.0
            columns = np.hstack([dT * length, dT * run.q[:, None]])[:, : len(campaign.coefficients)]
            np.testing.assert_allclose(columns @ campaign.coefficients, run.drift, rtol=0, atol=1e-12)


def test_a_bench_is_found_by_its_name(seed: int) -> None:
    """The same generator gives the same campaign, another one another; an unknown bench is named with the known."""
    assert set(OWN) <= set(benches.found())
    for name in OWN:
        one, same, other = (benches.draw(name, np.random.default_rng([seed, k])) for k in (3, 3, 4))
        assert np.array_equal(one.runs[2].noise, same.runs[2].noise)
        assert np.array_equal(one.runs[2].temperatures, same.runs[2].temperatures)
        assert not np.array_equal(one.runs[2].noise[:50], other.runs[2].noise[:50])
    with pytest.raises(UnknownNameError, match="no bench is called 'modl'.*modal"):
        benches.draw("modl", np.random.default_rng(1))


@pytest.mark.parametrize("name", OWN)
def test_notes_state_the_levels(name: str, drawn: dict[str, list[CampaignTruth]]) -> None:
    """Every level is noted as a number, and the noise's RMS is what its parts make, spikes left out."""
    for campaign in drawn[name]:
        assert LEVELS <= set(campaign.notes)
        level = {key: float(campaign.notes[key]) for key in LEVELS}  # type: ignore[arg-type]
        parts = np.hypot(np.hypot(level["white_um"], level["landing_um"]), level["slow_um"])
        if level["drift_resolution_um"]:
            parts = np.hypot(parts, level["drift_resolution_um"] / np.sqrt(12.0))
        # a sample of heavy tails may be far wider than its law
        assert 0.5 * parts < level["noise_rms_um"] < (5.0 if name == "rough" else 1.7) * parts


@pytest.mark.parametrize("name", LEGS)
def test_legs_are_a_real_actuators(name: str, drawn: dict[str, list[CampaignTruth]]) -> None:
    """Lengths, stroke, coefficients, rises, drift and weather stay within what a hexapod's leg shows on a bench."""
    for campaign in drawn[name]:
        A, B = np.split(campaign.coefficients, 2)
        assert 0.350 <= campaign.retracted_length <= 0.700
        assert 0.150 <= campaign.stroke[1] <= 0.300
        assert 1e-6 <= A.sum() <= 3e-6
        assert 0.5e-6 <= B.sum() <= 2e-6
        assert (np.diff(campaign.positions) > 0.003).all()
        assert 0.0 < campaign.positions[0]
        assert campaign.positions[-1] < campaign.retracted_length
        swing = max(np.ptp(run.temperatures, axis=0).max() for run in campaign.runs)
        assert 1.0 < swing < 18.0
        largest = max(np.abs(run.drift).max() for run in campaign.runs)
        assert 0.5e-6 < largest < 25e-6
        for run in campaign.runs:
            assert run.q.min() >= -1e-9
            assert run.q.max() <= campaign.stroke[1] + 1e-9
            assert 150.0 < np.ptp(run.air[:, 1]) < 1550.0
            assert 0.05 < run.air[:, 2].min() < run.air[:, 2].max() < 0.95


@pytest.mark.parametrize("name", LEGS)
def test_a_settled_row_rests(name: str, drawn: dict[str, list[CampaignTruth]]) -> None:
    """A settled row lies at one of the places of the plan: rows of one rest share one position, exactly."""
    for _campaign, run in each_run(drawn[name]):
        q = run.q[run.settled]
        assert len(np.unique(q.round(9))) < 0.6 * len(q)
        assert 0.5 < run.settled.mean() < 1.0


def test_modal_measures_as_stated(drawn: dict[str, list[CampaignTruth]]) -> None:
    """12 runs of 6 h at 15 s with 17 thermocouples; most moves are 10 mm, rests last from seconds to half an hour."""
    for campaign in drawn["modal"]:
        assert [run.role for run in campaign.runs].count("identification") == 9
        assert len(campaign.runs) == 12
        assert len(campaign.sensors) == 17
        assert all(np.allclose(np.diff(run.time), 15.0) and run.time[-1] == 21600.0 for run in campaign.runs)
        jumps = np.concatenate([np.diff(run.q[run.settled]) for run in campaign.runs])
        moved = np.abs(jumps[np.abs(jumps) > 1e-6])
        assert np.mean(np.abs(moved - 0.010) < 1e-6) > 0.3
        assert moved.max() > 0.5 * campaign.stroke[1]


def test_modal_noise_is_white_and_of_landings(drawn: dict[str, list[CampaignTruth]]) -> None:
    """Within a rest the displacement's noise is white of the stated level; between rests it has no memory."""
    for campaign in drawn["modal"]:
        within, between = [], []
        for run in campaign.runs:
            same = run.settled[1:] & run.settled[:-1] & (np.diff(run.q) == 0.0)
            within.append(np.diff(run.noise)[same])
            starts = np.flatnonzero(run.settled & np.concatenate([[True], np.diff(run.q) != 0.0]))
            between.append(run.noise[starts])
        white = np.concatenate(within).std() / np.sqrt(2.0) * 1e6
        # two moves within a row may end where they began: some rows of a rest are of two
        assert white == pytest.approx(campaign.notes["white_um"], rel=0.25)
        product = np.concatenate([x[1:] * x[:-1] for x in between])
        assert abs(product.mean()) < 6.0 * product.std() / np.sqrt(product.size)


def test_components_come_in_all_kinds(drawn: dict[str, list[CampaignTruth]]) -> None:
    """Some parts of machine tools have a stroke, some count from the campaign's first row; drift is read in 0.1 um."""
    campaigns = drawn["component"]
    assert {campaign.zero for campaign in campaigns} == {"run", "campaign"}
    assert {campaign.stroke[1] > 0.0 for campaign in campaigns} == {True, False}
    assert {float(campaign.notes["temperature_resolution_K"]) for campaign in campaigns} == {0.0, 0.1}  # type: ignore[arg-type]
    for campaign in campaigns:
        assert campaign.kind == "component"
        assert campaign.input_names == ("spindle_speed_rpm",)
        assert np.isnan(campaign.positions).all()
        assert 8 <= len(campaign.sensors) <= 16
        assert ((np.abs(campaign.coefficients) >= 5e-6) & (np.abs(campaign.coefficients) <= 15e-6)).all()
        for run in campaign.runs:
            assert 30.0 <= np.diff(run.time).min() <= np.diff(run.time).max() <= 60.0
            assert 7.8 <= (run.time[-1] - run.time[0]) / 3600.0 <= 16.0
            read = (run.drift + run.noise) * 1e7
            np.testing.assert_allclose(read, np.round(read), atol=1e-6)
            assert run.q.any() == (campaign.stroke[1] > 0.0)
            if campaign.notes["temperature_resolution_K"]:
                tenths = (run.temperatures + run.sensor_errors) * 10.0
                np.testing.assert_allclose(tenths, np.round(tenths), atol=1e-6)


def test_component_runs_are_cut_from_one_record(drawn: dict[str, list[CampaignTruth]]) -> None:
    """Where all runs count from the first, time and temperature run on from run to run; speed holds 10 to 60 min."""
    for campaign in drawn["component"]:
        held = []
        for run in campaign.runs:
            changes = run.time[1:][np.diff(run.inputs[:, 0]) != 0.0]
            held.extend(np.diff(changes))
        # two draws of the same rest follow each other as one
        assert min(held) >= 600.0 - 60.0
        if campaign.zero == "run":
            assert all(run.time[0] == 0.0 and run.settled[0] for run in campaign.runs)
            continue
        for one, other in itertools.pairwise(campaign.runs):
            assert other.time[0] - one.time[-1] <= 60.0
            assert np.abs(other.temperatures[0] - one.temperatures[-1]).max() < 0.5


def test_quiet_has_nothing_but_white_noise(drawn: dict[str, list[CampaignTruth]]) -> None:
    """Thermometers are exact, the displacement has 0.02 um of white noise: the law explains all but that."""
    for campaign in drawn["quiet"]:
        assert [len(campaign.runs), campaign.runs[0].time[1], campaign.runs[0].time[-1]] == [8, 5.0, 10800.0]
        assert campaign.notes["noise_rms_um"] == pytest.approx(0.02, rel=0.05)
        for run in campaign.runs:
            assert not run.sensor_errors.any()
            assert abs((run.noise[1:] * run.noise[:-1]).mean()) < 6.0 * run.noise.var() / np.sqrt(run.noise.size)
            rests = np.count_nonzero(np.diff(run.q[run.settled])) + 1
            assert rests < 60


def test_rough_is_rough(drawn: dict[str, list[CampaignTruth]]) -> None:
    """Rows are missing, displacements spike, one thermocouple is noisy, and landings have heavy tails."""
    gaps, spikes, tails = 0, 0, []
    for campaign in drawn["rough"]:
        noisy = campaign.sensors.index(str(campaign.notes["noisy_sensor"]))
        assert campaign.sensors[noisy] not in campaign.base
        for run in campaign.runs:
            gaps += np.count_nonzero(np.diff(run.time) > 61.0)
            spikes += np.count_nonzero(np.abs(run.noise) > 2.5e-6)
            jitter = np.median(np.abs(np.diff(run.sensor_errors, axis=0)), axis=0)
            assert jitter.argmax() == noisy
            places = np.concatenate([[True], np.diff(run.q) != 0.0]) & run.settled
            tails.append(run.noise[places] / np.median(np.abs(run.noise[places])))
    assert gaps > 10
    assert spikes > 10
    usual = np.concatenate(tails)
    # of a normal law 0.07 % lie beyond five median deviations
    assert np.mean(np.abs(usual) > 5.0) > 0.005


def test_physics_of_benches_is_their_own() -> None:
    """No bench made here takes a formula from the virtual bench, nor knows of what learns."""
    folder = Path(benches.__file__).parent
    for name in (*OWN, "air", "legs", "motion", "noises"):
        tree = ast.parse((folder / f"{name}.py").read_text(encoding="utf-8"))
        modules = {node.module or "" for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)}
        allowed = ("hexathermal.poses", "hexathermal.simulate.hidden")
        assert not [one for one in modules if one.startswith("hexathermal") and not one.startswith(allowed)]
