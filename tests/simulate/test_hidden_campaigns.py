"""Campaigns with hidden effects, drawn and written: as strong as they say, sound to read, the answer not in them."""

from __future__ import annotations

import json
import math
import warnings
from collections import Counter
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from hexathermal.errors import ArgumentError, UnknownNameError
from hexathermal.learn.campaign_files import load_campaign
from hexathermal.learn.cleaning import usable_blocks
from hexathermal.simulate.hidden import benches
from hexathermal.simulate.hidden.__main__ import main
from hexathermal.simulate.hidden.contacts import with_contacts
from hexathermal.simulate.hidden.drawing import campaign_of, draw_campaign, possible_causes
from hexathermal.simulate.hidden.effect import Effect
from hexathermal.simulate.hidden.effects import OUTSIDE, found, named
from hexathermal.simulate.hidden.loggers import with_shared_errors
from hexathermal.simulate.hidden.strength import (
    added,
    exact_readings,
    from_zero,
    law_columns,
    left,
    noise_rms,
    oracle,
    scaled,
    settled_rows,
    visible_strength,
    without_noise,
)
from hexathermal.simulate.hidden.truth import CampaignTruth
from hexathermal.simulate.hidden.writing import run_columns, write_campaign

UNSCALED = ("sensor-detached", "swapped-sensors")


def base_effect(*, slope: float) -> Effect:
    """An effect that the base law takes wholly: more of its own columns."""

    def hide(truth: CampaignTruth, parameters: object) -> CampaignTruth:
        columns = law_columns(truth)
        return truth.changed(
            runs=tuple(run.changed(effect=slope * item[:, 0]) for run, item in zip(truth.runs, columns, strict=True))
        )

    return Effect("of the law", lambda truth, generator: {}, hide)


def test_what_the_law_takes_is_not_visible(leg: CampaignTruth) -> None:
    """More of the law's own columns has strength 0, though it moves the drift by many noises."""
    assert visible_strength(leg, base_effect(slope=1e-6).hidden_by({})) < 1e-9


def test_strength_is_what_a_refit_leaves(leg: CampaignTruth, seed: int) -> None:
    """The strength of an effect in the drift is the RMS of its projection off the law's columns over the noise."""
    effect = named("hidden-heat")
    hide = effect.hidden_by(effect.draw(leg, np.random.default_rng(seed)))
    hidden = hide(exact_readings(leg))
    X = settled_rows(hidden, law_columns(hidden), "identification")
    y = settled_rows(hidden, from_zero(hidden, [added(run) for run in hidden.runs]), "identification")
    Q, _ = np.linalg.qr(X)
    left = y - Q @ (Q.T @ y)
    assert visible_strength(leg, hide) == pytest.approx(np.sqrt(np.mean(left**2)) / noise_rms(leg), rel=1e-6)


@pytest.mark.parametrize("name", ["clock-offset", "thermal-lag", "swapped-sensors"])
def test_errors_of_thermometers_are_noise_and_no_part_of_an_effect(
    name: str, component: CampaignTruth, seed: int
) -> None:
    """What stays visible of an effect in readings is the same in a part whose thermometers err half as much."""
    better = component.changed(runs=tuple(run.changed(sensor_errors=0.5 * run.sensor_errors) for run in component.runs))
    effect = named(name)
    hide = effect.hidden_by(effect.draw(component, np.random.default_rng(seed)))
    assert visible_strength(better, hide) == pytest.approx(visible_strength(component, hide), rel=1e-9)


def test_the_noise_is_what_the_true_law_leaves_with_nothing_hidden(component: CampaignTruth) -> None:
    """Of a part that is the displacement's noise, and what errors of the law's thermometers feign."""
    left = []
    for run, rises in zip(component.runs, law_columns(component), strict=True):
        if run.role == "identification":
            misfit = (run.drift + run.noise - rises @ component.coefficients)[run.settled]
            left.append(misfit - misfit.mean())
    found = np.sqrt(np.mean(np.concatenate(left) ** 2))
    # a run's mean takes some of the slow noise
    assert found == pytest.approx(noise_rms(component), rel=0.25)
    assert noise_rms(component) > 1e-6 * float(str(component.notes["noise_rms_um"]))


@pytest.mark.long
@pytest.mark.parametrize("bench", ["quiet", "component"])
def test_a_wanted_strength_is_reached(bench: str, seed: int) -> None:
    """Effects with an amplitude get the wanted strength within 2 %, or stand at their limit, or where they show most.

    A law that is fitted again does without a thermometer that is at fault: more of the fault shows no more.
    """
    clean, _ = campaign_of(bench, seed, causes=())
    within, tried = 0, np.random.default_rng(seed).permutation(possible_causes(clean))[:9]
    for name in tried.tolist():
        effect = named(name)
        _, answer = campaign_of(bench, seed, causes=(name,), strength=0.7)
        again = visible_strength(clean, effect.hidden_by(answer.parameters[0]))
        assert answer.strengths[0] == pytest.approx(again, rel=1e-9)
        assert answer.together == pytest.approx(answer.strengths[0])
        if name in UNSCALED:
            continue
        size = abs(float(answer.parameters[0][effect.amplitude]))
        low, high = effect.limits
        assert low * (1 - 1e-9) <= size <= high * (1 + 1e-9)
        reached = abs(answer.strengths[0] / 0.7 - 1.0) < 0.02
        if not reached and min(size / low, high / size) >= 1.001:
            assert effect.readings, (name, answer)
            other = [
                {**answer.parameters[0], effect.amplitude: part * float(answer.parameters[0][effect.amplitude])}
                for part in (0.5, 2.0)
            ]
            most = max(visible_strength(clean, effect.hidden_by(parameters)) for parameters in other)
            assert most < 1.01 * answer.strengths[0] < 0.7, (name, answer)
        within += reached
    assert within >= 4


def test_limits_are_kept(leg: CampaignTruth, seed: int) -> None:
    """A strength beyond an effect's limits is not reached; the nearest within them is given, and said.

    It is that at the limit, or more: of a clock ten minutes off a little less may be stronger, moves come round again.
    """
    effect = named("clock-offset")
    parameters, reached = scaled(effect, leg, effect.draw(leg, np.random.default_rng(seed)), 1e4)
    assert abs(float(parameters["offset"])) <= 600.0 * (1.0 + 1e-9)
    at_limit = {**parameters, "offset": math.copysign(600.0, float(parameters["offset"]))}
    strength = visible_strength(leg, effect.hidden_by(at_limit), left(exact_readings(leg), leg))
    assert reached == pytest.approx(strength) or reached > strength
    assert reached < 1e3


@pytest.mark.long
def test_the_oracle_gains_what_the_effect_costs(seed: int) -> None:
    """In the median of draws, knowing the effect brings the error on validation runs near a clean campaign's."""
    clean = [campaign_of("quiet", seed + k, causes=())[1].oracle.base for k in range(3)]
    for name in ("hidden-heat", "backlash", "thermal-lag", "sensor-detached", "swapped-sensors"):
        answers = [campaign_of("quiet", seed + k, causes=(name,), strength=3.0)[1] for k in range(3)]
        known = [answer.oracle.known / own for answer, own in zip(answers, clean, strict=True)]
        assert np.median(known) == pytest.approx(1.0, abs=0.12), name
        base = [answer.oracle.base / own for answer, own in zip(answers, clean, strict=True)]
        assert np.median(base) > 1.2 or name not in ("hidden-heat", "backlash"), name


def test_without_noise_the_runs_for_validation_read_the_drift_itself(leg: CampaignTruth) -> None:
    """Noise of the runs for identification stays; where that is none too, the law of a clean leg errs nowhere."""
    exact = without_noise(leg)
    assert [run.noise.any() for run in exact.runs] == [run.role == "identification" for run in leg.runs]
    pairs = zip(exact.runs, leg.runs, strict=True)
    assert all(one.noise is two.noise for one, two in pairs if one.role == "identification")
    judged = oracle(leg, leg, [])
    assert judged.base_without_noise == pytest.approx(oracle(exact, exact, []).base, rel=1e-9)
    fitted_without = leg.changed(
        runs=tuple(run.changed(noise=run.noise * (run.role == "validation")) for run in leg.runs)
    )
    judged = oracle(fitted_without, fitted_without, [])
    assert judged.base == pytest.approx(judged.noise, rel=1e-9)
    assert judged.base_without_noise < 1e-9 * judged.base


def test_spikes_do_not_count(seed: int) -> None:
    """Of a leg with spikes and gaps, effects in readings have a strength too, over the same rows as without them."""
    for name in ("swapped-sensors", "clock-offset", "sensor-detached"):
        _, answer = campaign_of("rough", seed, causes=(name,), strength=1.0)
        assert 0.0 < answer.strengths[0] < 50.0


def test_nothing_hidden_gains_nothing(leg: CampaignTruth) -> None:
    """Of a clean campaign the oracle's two errors are one."""
    clean = oracle(leg, leg, [])
    assert clean.base == clean.known


@pytest.mark.long
def test_draws_hide_none_one_two_or_outside() -> None:
    """Draws take all four turns; at most one of two effects is in the readings; the seed repeats them."""
    kinds = Counter[str]()
    for k in range(40):
        hidden, answer = campaign_of("component", k)
        outside = [name for name in answer.causes if name.startswith(OUTSIDE)]
        kinds["outside" if outside else str(len(answer.causes))] += 1
        assert len(set(answer.causes)) == len(answer.causes)
        assert sum(named(name).readings for name in answer.causes) < 2
        if k < 4:
            again, same = campaign_of("component", answer.seed, causes=answer.causes)
            assert same == answer
            assert all(
                np.array_equal(a.effect, b.effect) and np.array_equal(a.sensor_errors, b.sensor_errors)
                for a, b in zip(hidden.runs, again.runs, strict=True)
            )
    assert set(kinds) == {"0", "1", "2", "outside"}


@pytest.mark.long
def test_a_logger_gives_all_thermometers_one_error_in_every_third_draw() -> None:
    """Where asked for, all thermometers of about a third of the campaigns err alike besides; the truth stays."""
    errors = []
    for k in range(24):
        plain, _ = campaign_of("quiet", k, causes=())
        drifting, size = with_shared_errors(plain, np.random.default_rng([k, 3]))
        added = [b.sensor_errors - a.sensor_errors for a, b in zip(plain.runs, drifting.runs, strict=True)]
        assert all(np.ptp(table, axis=1).max() < 1e-12 for table in added)
        assert all(np.array_equal(a.drift, b.drift) for a, b in zip(plain.runs, drifting.runs, strict=True))
        assert float(np.sqrt(np.mean(np.concatenate(added) ** 2))) == pytest.approx(size, rel=0.8)
        assert (noise_rms(drifting) > noise_rms(plain)) == (size > 0.0)
        assert campaign_of("quiet", k, causes=(), shared=True)[1].shared == size
        errors.append(size)
    assert 3 <= np.count_nonzero(errors) <= 14
    assert max(errors) <= 0.06


@pytest.mark.long
def test_taped_thermometers_let_in_some_of_the_air_in_every_third_draw() -> None:
    """Where asked for, each reading of about a third of the campaigns has 0 to 5 % of the air in it, always as much."""
    taped = 0
    for k in range(24):
        plain, _ = campaign_of("quiet", k, causes=())
        found = with_contacts(plain, np.random.default_rng([k, 4]))
        added = np.concatenate([b.sensor_errors - a.sensor_errors
                                for a, b in zip(plain.runs, found.runs, strict=True)])  # fmt: skip
        gaps = np.concatenate([run.air[:, :1] - run.temperatures for run in plain.runs])
        parts = (added * gaps).sum(axis=0) / (gaps**2).sum(axis=0)
        np.testing.assert_allclose(added, parts * gaps, atol=1e-9)
        assert np.all((parts >= -1e-12) & (parts <= 0.05))
        assert all(np.array_equal(a.drift, b.drift) for a, b in zip(plain.runs, found.runs, strict=True))
        taped += bool(parts.any())
        both = with_contacts(with_shared_errors(plain, np.random.default_rng([k, 3]))[0], np.random.default_rng([k, 4]))
        asked = campaign_of("quiet", k, causes=(), shared=True)[0]
        assert all(np.array_equal(a.sensor_errors, b.sensor_errors)
                   for a, b in zip(asked.runs, both.runs, strict=True))  # fmt: skip
    assert 3 <= taped <= 14


def test_two_effects_add_up(seed: int) -> None:
    """Two effects in the drift are both there, each as alone."""
    both, answer = draw_campaign("quiet", np.random.default_rng(seed), causes=("backlash", "zero-drift"), strength=1.0)
    clean, _ = campaign_of("quiet", answer.seed, causes=())
    alone = [named(name).hide(clean, item) for name, item in zip(answer.causes, answer.parameters, strict=True)]
    for run, before, *one in zip(both.runs, clean.runs, *(truth.runs for truth in alone), strict=True):
        np.testing.assert_allclose(run.effect - before.effect, sum(item.effect for item in one), atol=1e-15)


def test_bad_wishes_are_refused() -> None:
    """An unknown bench or effect, one that the bench cannot have, and no strength are refused with what there is."""
    generator = np.random.default_rng(1)
    with pytest.raises(UnknownNameError, match="quiet"):
        draw_campaign("loud", generator)
    with pytest.raises(UnknownNameError, match="creep"):
        draw_campaign("quiet", generator, causes=("crawl",))
    with pytest.raises(ArgumentError, match="zero-drift"):
        draw_campaign("component", generator, causes=("abbe-tilt",))
    for strength in (0.0, -1.0, float("nan"), float("inf")):
        with pytest.raises(ArgumentError, match="above 0"):
            draw_campaign("quiet", generator, causes=("creep",), strength=strength)


@pytest.mark.long
@pytest.mark.parametrize("bench", sorted(benches.found()))
def test_folders_are_sound(bench: str, seed: int, tmp_path: Path) -> None:
    """What is written reads back without a fault; on settled rows the drift is the truth to a few nanometres."""
    truth, answer = campaign_of(bench, seed, causes=("hidden-heat",), strength=1.0)
    file = write_campaign(tmp_path / "a", truth, answer)
    campaign = load_campaign(tmp_path / "a")
    assert campaign.sensors == truth.sensors
    assert [run.role for run in campaign.runs] == [run.role for run in truth.runs]
    columns = from_zero(truth, [run.drift + added(run) + run.noise for run in truth.runs])
    for run, own, measured in zip(campaign.runs, truth.runs, columns, strict=True):
        rows = {round(float(t - own.time[0]), 3): k for k, t in enumerate(own.time)}
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            blocks = list(usable_blocks(campaign, run))
        used = np.concatenate([[rows[round(float(t), 3)] for t in block.time] for block in blocks])
        least = 0.9 if "settled" in run_columns(truth, own) else 0.7  # stops of one row
        assert len(used) > least * own.settled.sum()
        apart = np.concatenate([block.drift for block in blocks]) - measured[used]
        limit = 2e-9 + float(str(truth.notes["drift_resolution_um"])) * 1e-6
        assert np.median(np.abs(apart)) < limit
    stored = {item.name for item in (tmp_path / "a").rglob("*") if item.is_file()}
    assert stored == {"campaign.toml", *(f"{run.name}.csv" for run in truth.runs)}
    assert file.parent == tmp_path
    told = json.loads(file.read_text())
    assert told["causes"] == ["hidden-heat"]
    assert told["oracle"]["rmse_known_um"] == pytest.approx(answer.oracle.known * 1e6)


def test_nothing_in_a_folder_tells_the_effect(tmp_path: Path, seed: int) -> None:
    """`campaign.toml` is the same with and without an effect, and so are the names of the columns."""
    for name, causes in (("a", ()), ("b", ("air-refraction",)), ("c", ("swapped-sensors",))):
        write_campaign(tmp_path / name, *campaign_of("quiet", seed, causes=causes, strength=1.0))
    texts = [(tmp_path / name / "campaign.toml").read_text() for name in "abc"]
    heads = [(tmp_path / name / "runs" / "run-01.csv").read_text().partition("\n")[0] for name in "abc"]
    assert texts[0] == texts[1] == texts[2]
    assert heads[0] == heads[1] == heads[2]


def test_beams_without_compensation(tmp_path: Path, seed: int) -> None:
    """Where the laser does not apply the index, beams hold it, and correction gives the drift back within 30 nm."""
    truth, answer = campaign_of("quiet", seed, causes=())
    write_campaign(tmp_path / "a", truth.changed(index_compensated=False), answer)
    campaign = load_campaign(tmp_path / "a")
    run, own = campaign.runs[0], truth.runs[0]
    blocks = list(usable_blocks(campaign, run))
    found = np.concatenate([block.drift for block in blocks])
    rows = np.searchsorted(own.time, np.concatenate([block.time for block in blocks]))
    measured = (own.drift + own.noise)[rows] - own.noise[0]
    assert np.abs(found - measured).max() < 0.15e-6
    assert np.sqrt(np.mean((found - measured) ** 2)) < 0.03e-6


def test_the_check_of_a_folder_finds_no_fault(tmp_path: Path, seed: int) -> None:
    """`hexathermal check` reads a campaign of each kind to its end; no beam lost count in it."""
    from hexathermal.show.commands.check import run

    for bench in ("finite_volume", "component"):
        write_campaign(tmp_path / bench, *campaign_of(bench, seed, causes=()))
        given = SimpleNamespace(campaign=tmp_path / bench, plots=None, netcdf=None, force=False, ranges=False)
        answer = run(given, lambda done, total, label: None)  # type: ignore[arg-type]
        assert answer.code == 0
        assert not [text for text in answer.warnings if "beam step" in text]


def test_the_script_writes_campaigns(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The script writes as many as asked, the same for the same seed; what it cannot do it says in words."""
    words = ["--bench", "component", "--count", "2", "--seed", "3", "--cause", "zero-drift", "--strength", "1"]
    assert main([str(tmp_path / "x"), *words]) == 0
    assert main([str(tmp_path / "y"), *words]) == 0
    for k in (1, 2):
        a, b = (tmp_path / place / f"component-{k:03d}.answer.json" for place in "xy")
        assert a.read_text() == b.read_text()
        assert json.loads(a.read_text())["causes"] == ["zero-drift"]
    assert main([str(tmp_path / "x"), *words]) == 1
    assert "--force" in capsys.readouterr().err
    assert main([str(tmp_path / "x"), *words, "--force"]) == 0
    assert main([str(tmp_path / "z"), "--bench", "no"]) == 1
    assert "finite_volume" in capsys.readouterr().err


def test_every_possible_cause_is_known() -> None:
    """A part without a stroke cannot have what needs one; a leg can have all."""
    truth, _ = campaign_of("quiet", 1, causes=())
    assert possible_causes(truth) == tuple(found())
    still = truth.changed(kind="component", runs=tuple(run.changed(q=np.zeros(run.time.size)) for run in truth.runs))
    gone = set(found()) - set(possible_causes(still))
    assert gone >= {"backlash", "creep", "scale-error", "abbe-tilt", "air-refraction", "hidden-heat"}
    assert not gone & {"zero-drift", "thermal-lag", "clock-offset", "frame-expansion"}
