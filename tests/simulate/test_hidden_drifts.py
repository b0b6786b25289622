"""What hidden effects add to the drift: each has the form that its physics gives it."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import numpy as np
import pytest

from hexathermal.simulate.hidden import benches
from hexathermal.simulate.hidden.beams import AZIMUTHS, RADIUS
from hexathermal.simulate.hidden.effects import named
from hexathermal.simulate.hidden.shapes import moves, play
from hexathermal.simulate.hidden.truth import CampaignTruth, RunTruth
from tests.simulate.hidden_effects import hidden, made_up, with_channel


def test_backlash_is_a_gap(leg: CampaignTruth, generator: np.random.Generator) -> None:
    """Long moves one way lie a whole gap beside those the other way; a small reversal makes part of it."""
    # up 20 mm, back by 0.1 mm, up again, back 20 mm
    corners = [0.0, 3600.0, 3700.0, 3800.0, 7200.0]
    truth = made_up(leg, lambda time: np.interp(time, corners, [0.05, 0.07, 0.0699, 0.07, 0.05]))
    found, _ = hidden("backlash", truth, generator, gap=1e-6, engagement=1e-3, start=0.0)
    time, effect = found.runs[0].time, found.runs[0].effect
    up, part, down = (float(np.interp(at, time, effect)) for at in (3600.0, 3700.0, 7200.0))
    assert up == pytest.approx(0.5e-6)
    assert down == pytest.approx(-0.5e-6)
    assert 0.02e-6 < up - part < 0.3e-6


def test_play_only_turns_within_its_gap() -> None:
    """The play operator follows any motion within its width, stays between -0.5 and 0.5, and forgets no reversal."""
    path = np.cumsum(np.random.default_rng(3).standard_normal(500))
    x = play(path, 4.0, 0.0)
    assert x.min() >= -0.5
    assert x.max() <= 0.5
    free = np.abs(x[1:]) < 0.5
    np.testing.assert_allclose(np.diff(x)[free], (np.diff(path) / 4.0)[free], atol=1e-12)


def test_a_screw_repeats_with_its_pitch_in_all_runs(leg: CampaignTruth, generator: np.random.Generator) -> None:
    """The error is one function of q modulo the pitch in all runs, with a second harmonic; some pitches alias 10 mm."""
    truth, parameters = hidden("periodic-screw-error", leg, generator, pitch=0.0073, amplitude=1e-6)
    q = np.concatenate([run.q for run in truth.runs])
    effect = np.concatenate([run.effect for run in truth.runs])
    turn = 2.0 * np.pi * q / 0.0073
    X = np.column_stack([np.sin(turn), np.cos(turn), np.sin(2.0 * turn), np.cos(2.0 * turn)])
    fit = np.linalg.lstsq(X, effect)[0]
    np.testing.assert_allclose(X @ fit, effect, atol=1e-12)
    assert np.hypot(*fit[2:]) / np.hypot(*fit[:2]) == pytest.approx(float(parameters["second"]))
    pitches = [float(named("periodic-screw-error").draw(leg, generator)["pitch"]) for _ in range(200)]
    aliased = [abs(0.010 / pitch - round(0.010 / pitch)) < 1e-9 for pitch in pitches]
    assert 15 <= sum(aliased) <= 75
    assert min(pitches) >= 0.002
    assert max(pitches) <= 0.020


def test_a_jump_is_in_one_run(leg: CampaignTruth, component: CampaignTruth, generator: np.random.Generator) -> None:
    """One run rises within minutes, no other moves; where all count from the campaign's zero, later ones keep it."""
    for truth in (leg, component):
        found, parameters = hidden("zero-jump", truth, generator, height=1e-6, beam=0, ramp=200.0)
        which = [run.name for run in found.runs].index(str(parameters["run"]))
        for k, run in enumerate(found.runs):
            if k != which:
                assert np.ptp(run.effect) == 0.0
                assert run.effect[0] == (1e-6 if k > which and truth.zero == "campaign" else 0.0)
        run = found.runs[which]
        rising = run.time[1:][np.diff(run.effect) > 0.0]
        assert (np.diff(run.effect) >= 0.0).all()
        assert run.effect[-1] == pytest.approx(1e-6)
        assert np.ptp(rising) <= 200.0 + (run.time[1] - run.time[0])


@pytest.mark.parametrize("beam", [1, 2, 3])
def test_a_beam_that_loses_count_jumps_alone_and_at_once(
    leg: CampaignTruth, generator: np.random.Generator, beam: int
) -> None:
    """By three times the height, from one row to the next: the mean of the beams jumps by the height."""
    found, parameters = hidden("zero-jump", leg, generator, height=1e-6, beam=beam, ramp=0.0)
    for before, run in zip(leg.runs, found.runs, strict=True):
        np.testing.assert_array_equal(run.effect, before.effect)
        added = run.beam_effects - before.beam_effects
        others = np.delete(added, beam - 1, axis=1)
        assert not others.any()
        if run.name == parameters["run"]:
            assert np.count_nonzero(np.diff(added[:, beam - 1])) == 1
            assert added[-1].mean() == pytest.approx(1e-6)
        else:
            assert not added[:, beam - 1].any() or leg.zero == "campaign"


def test_creep_relaxes_after_a_move(leg: CampaignTruth, generator: np.random.Generator) -> None:
    """After one long move its height is left, then less and less; a move back takes its own away from it."""
    truth = made_up(leg, lambda time: np.interp(time, [1000.0, 1010.0], [0.05, 0.09]))
    for law in ("logarithm", "stretched"):
        found, _ = hidden("creep", truth, generator, law=law, height=1e-6, time=200.0, begun=False)
        (run,) = found.runs
        times, lengths = moves(run)
        assert times.tolist() == [1010.0]
        assert lengths[0] == pytest.approx(0.04)
        effect = run.effect
        assert not effect[run.time < 1010.0].any()
        assert effect[run.time == 1010.0][0] == pytest.approx(1e-6, rel=1e-6)
        assert (np.diff(effect[run.time >= 1010.0]) <= 0.0).all()
        # neither law is an exponential: after a fast start they relax longer than exp would
        at = [float(np.interp(1010.0 + since, run.time, effect)) for since in (100.0, 1000.0, 2000.0)]
        assert at[2] / at[1] > 1.2 * (at[1] / at[0]) ** (1000.0 / 900.0)


def test_creep_of_what_was_clamped_goes_on_from_each_beginning(leg: CampaignTruth, seed: int) -> None:
    """Whatever moves, it relaxes from the first row of each run on, in all runs nearly alike."""
    generator = np.random.default_rng(seed)
    for law in ("logarithm", "stretched"):
        own = {"law": law, "height": 1e-6, "time": 1000.0, "begun": True, "unlike": 5}
        found, _ = hidden("creep", leg, generator, **own)
        firsts = np.array([run.effect[0] for run in found.runs])
        assert all((np.diff(run.effect) <= 0.0).all() for run in found.runs)
        assert firsts == pytest.approx(1e-6, rel=0.5)
        assert 0.02 < firsts.std() / firsts.mean() < 0.3
        shapes = [float(np.interp(3000.0, run.time - run.time[0], run.effect)) / run.effect[0] for run in found.runs]
        np.testing.assert_allclose(shapes, shapes[0])


def test_moves_are_counted_from_rows() -> None:
    """A move over several rows is one, a turn between two rows makes two, what a controller wobbles is none."""
    q = 1e-3 * np.array([0.0, 0.0, 4.0, 8.0, 8.0001, 8.0, 12.0, 9.0, 9.0])
    run = benches.draw("quiet", np.random.default_rng(1)).runs[0].changed(q=q, time=10.0 * np.arange(9))
    times, lengths = moves(run)
    assert times.tolist() == [30.0, 60.0, 70.0]
    np.testing.assert_allclose(lengths, [0.008, 0.004, -0.003], atol=1e-12)


def test_hidden_heat_is_stored_and_leaves(leg: CampaignTruth, component: CampaignTruth, seed: int) -> None:
    """Heat rises with motion, or with a recorded input, and leaves at rest by two time constants."""
    generator = np.random.default_rng(seed)
    truth = made_up(leg, lambda time: 0.1 + 0.02 * np.sin(np.clip(time, 0.0, 3600.0) / 50.0))
    found, parameters = hidden("hidden-heat", truth, generator, height=1e-6)
    (run,) = found.runs
    assert run.effect[0] == 0.0
    assert run.effect.max() == pytest.approx(1e-6)
    rest = run.time >= 3700.0
    X = np.column_stack([np.exp(-run.time[rest] / float(parameters[name])) for name in ("fast", "slow")])
    np.testing.assert_allclose(X @ np.linalg.lstsq(X, run.effect[rest])[0], run.effect[rest], atol=1e-10)
    driven, _ = hidden("hidden-heat", component, generator, source=component.input_names[0], power=1.0)
    assert any(np.ptp(run.effect) > 0.0 for run in driven.runs)


def test_unapplied_index_follows_pressure(leg: CampaignTruth, generator: np.random.Generator) -> None:
    """The beams follow what is lacking by 0.268 ppm/hPa or -0.93 ppm/K of the path: the dead one, or with q."""
    truth = made_up(leg, lambda time: np.full(time.size, 0.1))
    (run,) = truth.runs
    air = np.column_stack([np.linspace(20.0, 22.0, run.time.size), np.linspace(1.0e5, 1.01e5, run.time.size),
                           np.full(run.time.size, 0.4)])  # fmt: skip
    truth = truth.changed(runs=(run.changed(air=air),))
    for path, length in (("dead", truth.dead_path), ("whole", truth.dead_path + 0.1)):
        for weather, change in (("pressure", 10.0 * 0.268e-6), ("temperature", 2.0 * -0.93e-6)):
            found, _ = hidden("air-refraction", truth, generator, path=path, share=0.5, weather=weather)
            assert found.runs[0].effect[-1] / (0.5 * length) == pytest.approx(change, rel=0.02)


def test_a_station_lacks_the_pressure_the_temperature_or_neither(leg: CampaignTruth) -> None:
    """Of many draws about a quarter lacks the pressure alone, some 15 % the temperature alone."""
    draw = named("air-refraction").draw
    lacking = [draw(leg, np.random.default_rng(seed)).get("weather") for seed in range(400)]
    assert 70 < lacking.count("pressure") < 130
    assert 35 < lacking.count("temperature") < 90


def test_tilt_shows_in_the_beams_and_leaks(leg: CampaignTruth, generator: np.random.Generator) -> None:
    """Beams differ by angle times radius, their mean by angle times offset; it follows q or two temperatures."""
    for source in ("stroke", "temperatures"):
        truth, parameters = hidden("abbe-tilt", leg, generator, source=source, angle=50e-6)
        beams = np.concatenate([run.beam_effects for run in truth.runs])
        angle = beams.mean(axis=1) / float(parameters["offset"])
        assert np.abs(angle).max() == pytest.approx(50e-6)
        apart = beams - beams.mean(axis=1, keepdims=True)
        lever = RADIUS * np.cos(np.array(AZIMUTHS) - float(parameters["direction"]))
        np.testing.assert_allclose(apart, np.outer(angle, lever), atol=1e-15)


def test_the_frame_follows_the_room_late(leg: CampaignTruth, generator: np.random.Generator) -> None:
    """A step of the room begins slowly in the frame, and reaches the slope times the step after hours."""
    truth = made_up(leg, lambda time: np.full(time.size, 0.1))
    (run,) = truth.runs
    air = run.air.copy()
    air[run.time > 7200.0, 0] += 1.0
    found, _ = hidden("frame-expansion", truth.changed(runs=(run.changed(air=air),)), generator, skin=300.0,
                      core=900.0, slope=1e-6)  # fmt: skip
    rise = found.runs[0].effect - float(np.interp(7200.0, run.time, found.runs[0].effect))
    assert rise[-1] == pytest.approx(1e-6, rel=0.01)
    first, second = (float(np.interp(at, run.time, rise)) for at in (7260.0, 7500.0))
    assert first < 0.3 * 60.0 / 900.0 * 1e-6
    assert second > 2.0 * 5.0 * first


def test_expansion_bends(leg: CampaignTruth, generator: np.random.Generator) -> None:
    """The square is one of the temperature from 20 degC; Invar's curve has the same bend in its middle and no kink."""
    warm = 20.0 + np.linspace(-6.0, 6.0, 2881)
    still = made_up(leg, lambda time: np.zeros(time.size))
    truth = with_channel(still, still.base[0], warm)
    for curve in ("square", "invar"):
        found, _ = hidden("nonlinear-expansion", truth, generator, curve=curve, target=still.base[0], bend=1e-7,
                          middle=20.0, width=2.0)  # fmt: skip
        effect = found.runs[0].effect
        step = warm[1] - warm[0]
        second = np.diff(effect, 2) / step**2
        assert second.max() == pytest.approx({"square": 2e-7, "invar": 1e-7}[curve], rel=0.01)
        assert np.abs(np.diff(second)).max() < 1e-3 * second.max() + 1e-10


def test_the_rest_of_the_catalogue(leg: CampaignTruth, component: CampaignTruth, seed: int) -> None:
    """A wrong scale is a slope of q, a missing sensor one of its temperature, a drift one of time."""
    generator = np.random.default_rng(seed)

    def straight(runs: tuple[RunTruth, ...], x: Callable[[RunTruth], np.ndarray]) -> float:
        """The correlation of an effect with something."""
        values = [x(run) - x(run)[0] for run in runs]
        effects = [run.effect - run.effect[0] for run in runs]
        return abs(float(np.corrcoef(np.concatenate(values), np.concatenate(effects))[0, 1]))

    truth, _ = hidden("scale-error", leg, generator)
    assert 0.99 < straight(truth.runs, lambda run: run.q) < 1.0
    truth, parameters = hidden("missing-sensor", leg, generator, place="fixed")
    j = truth.sensors.index(str(parameters["target"]))
    assert straight(truth.runs, lambda run: run.temperatures[:, j]) == pytest.approx(1.0)
    truth, _ = hidden("zero-drift", leg, generator, unlike=0.0)
    assert 0.98 < straight(truth.runs, lambda run: run.time) <= 1.0
    truth, _ = hidden("zero-drift", leg, generator, unlike=0.3, curvature=0.0, rate=1e-10, runs=3)
    rates = [float(run.effect[-1] / (run.time[-1] - run.time[0])) for run in truth.runs]
    assert 0.05 < np.std(rates) / np.mean(rates) < 0.8
    for run, one in zip(truth.runs, rates, strict=True):
        np.testing.assert_allclose(run.effect, one * (run.time - run.time[0]), atol=1e-15)
    truth, _ = hidden("zero-drift", component, generator, curvature=0.0)
    ends = [(run.effect[0], run.effect[-1]) for run in truth.runs]
    assert all(abs(b[0]) >= abs(a[1]) - 1e-15 for a, b in pairwise(ends))


def test_outside_effects_have_their_form(leg: CampaignTruth, seed: int) -> None:
    """A bump has a place, a cubic no slope, a kink a corner, wear grows with the way, a loop does not close at once."""
    generator = np.random.default_rng(seed)
    ramp = made_up(leg, lambda time: np.interp(time, [0.0, 14400.0], [0.0, 0.25]))
    x = ramp.runs[0].q / 0.25
    truth, bump = hidden("outside: bump", ramp, generator, height=1e-6)
    far = np.abs(ramp.runs[0].q - float(bump["place"])) > 3.0 * float(bump["width"])
    assert np.abs(truth.runs[0].effect[far]).max() < 1e-9
    assert truth.runs[0].effect.max() > 0.9e-6
    truth, _ = hidden("outside: cubic", ramp, generator, height=1e-6)
    assert abs(np.polynomial.Polynomial.fit(x, truth.runs[0].effect, 1).convert().coef[1]) < 5e-9
    truth, _ = hidden("outside: wear", ramp, generator, wear=1e-6, power=1.0)
    np.testing.assert_allclose(truth.runs[0].effect, 1e-6 * x, atol=1e-12)
    warm = with_channel(ramp, ramp.base[0], 20.0 + 5.0 * np.sin(np.pi * x))
    truth, _ = hidden("outside: kink", warm, generator, sensor=ramp.base[0], kink=23.0, slope=1e-6)
    assert truth.runs[0].effect.max() == pytest.approx(2e-6)
    assert truth.runs[0].effect[0] == 0.0
    truth, _ = hidden("outside: hysteresis", warm, generator, sensor=ramp.base[0], gap=1.0, height=1e-6)
    up, down = (float(np.interp(at, x, truth.runs[0].effect)) for at in (0.25, 0.75))
    assert up - down == pytest.approx(0.94e-6, abs=0.06e-6)
    truth, _ = hidden("outside: ratchet", warm, generator, sensor=ramp.base[0], every=0.5, slope=1e-6)
    slips = truth.runs[0].effect
    assert (np.diff(slips) >= 0.0).all()
    assert slips[-1] == slips.max() == pytest.approx(4.75e-6, abs=0.26e-6)  # it cools, and stays where it was
    still = made_up(leg, lambda time: np.full(time.size, 0.1))
    truth, rhythm = hidden("outside: room-rhythm", still, generator, height=1e-6)
    effect = truth.runs[0].effect
    cycles = int(((effect[:-1] < 0.0) & (effect[1:] >= 0.0)).sum())
    assert abs(cycles - 14400.0 / float(rhythm["period"])) <= 2.0
    assert np.ptp(effect) == pytest.approx(1e-6, rel=0.05)


def test_outside_effects_of_the_day(leg: CampaignTruth, seed: int) -> None:
    """A floor tilts by another part of its daily wave in each run; swelling follows humidity late."""
    generator = np.random.default_rng(seed)
    truth, _ = hidden("outside: floor-tilt", leg, generator, height=1e-6)
    assert len({round(float(run.effect[0] * 1e12)) for run in truth.runs}) == len(truth.runs)
    assert max(float(np.abs(run.effect).max()) for run in truth.runs) <= 1.4e-6
    still = made_up(leg, lambda time: np.full(time.size, 0.1))
    (run,) = still.runs
    air = run.air.copy()
    air[run.time > 7200.0, 2] += 0.1
    wet = still.changed(runs=(run.changed(air=air),))
    truth, _ = hidden("outside: humidity", wet, generator, swelling=1e-5, time=1200.0)
    rise = truth.runs[0].effect - float(np.interp(7200.0, run.time, truth.runs[0].effect))
    assert rise[-1] == pytest.approx(1e-6, rel=0.01)
    assert float(np.interp(8400.0, run.time, rise)) == pytest.approx(0.63e-6, abs=0.1e-6)


def test_a_clamp_needs_two_warmings(leg: CampaignTruth, seed: int) -> None:
    """Nothing where the room or the place stays as it was; the product of both where both warm."""
    generator = np.random.default_rng(seed)
    still = made_up(leg, lambda time: np.full(time.size, 0.1))
    (run,) = still.runs
    grows = run.time / run.time[-1]
    warm = with_channel(still, still.sensors[0], 20.0 + 4.0 * grows)
    air = run.air.copy()
    own = {"sensor": still.sensors[0], "size": 1e-7, "late": 60.0}
    for rise, most in ((0.0, 0.0), (2.0, 8e-7)):
        air[:, 0] = 20.0 + rise * grows
        truth, _ = hidden(
            "outside: clamp", warm.changed(runs=(warm.runs[0].changed(air=air.copy()),)), generator, **own
        )
        assert truth.runs[0].effect[-1] == pytest.approx(most, rel=0.02, abs=1e-15)
        assert truth.runs[0].effect[len(grows) // 2] == pytest.approx(most / 4.0, rel=0.03, abs=1e-15)
