"""The bench held out from tuning: an exact recursion, noise as stated, campaigns that read back."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.stats import chi2

from hexathermal.learn.campaign_files import load_campaign
from hexathermal.learn.cleaning import usable_blocks
from hexathermal.simulate.hidden.benches import held_out
from hexathermal.simulate.hidden.drawing import campaign_of
from hexathermal.simulate.hidden.truth import CampaignTruth, RunTruth
from hexathermal.simulate.hidden.writing import write_campaign


@pytest.fixture(scope="module")
def drawn(seed: int) -> list[CampaignTruth]:
    """Some campaigns."""
    return [held_out.draw(np.random.default_rng([seed, k])) for k in range(6)]


def identification(campaign: CampaignTruth) -> list[RunTruth]:
    """Runs that are fitted."""
    return [run for run in campaign.runs if run.role == "identification"]


@pytest.mark.parametrize("delay", [0.0, 7.3, 26.0, 40.0, 133.7])
def test_recursion_is_the_closed_form(delay: float) -> None:
    """A pulse of heat is answered at every row as its two steps in continuous time, whatever the dead time."""
    step, tau, zeta = 13.0, np.array([45.0, 300.0, 2000.0]), 80.0
    time = step * np.arange(400)

    def after(since: np.ndarray) -> np.ndarray:
        """The step's answer by partial fractions of ``G(s) / s``, from residues at each pole."""
        poles = -1.0 / tau
        share = [
            (1.0 + zeta * pole) / (pole * tau[m] * np.prod([1.0 + tau[k] * pole for k in range(3) if k != m]))
            for m, pole in enumerate(poles)
        ]
        rest = np.maximum(since, 0.0)
        return np.where(since > 0.0, 1.0 + sum(c * np.exp(p * rest) for c, p in zip(share, poles, strict=True)), 0.0)

    source = ((time >= 5 * step) & (time < 60 * step)) * 2.5
    found = held_out.Transfer(tuple(tau), zeta, delay).answer(np.asarray(source, dtype=np.float64), step)
    expected = 2.5 * (after(time - 5 * step - delay) - after(time - 60 * step - delay))
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-11)
    assert expected.max() > 0.5


def test_dead_time_grows_with_distance(seed: int) -> None:
    """Along the body, the motor's heat comes the later and the weaker the farther a thermocouple is from it."""
    generator = np.random.default_rng(seed)
    stations = held_out._stations(held_out._drawn_leg(generator), generator)
    assert (np.diff([one.delay for one in stations.motor]) > 0.0).all()
    nut = stations.nut - stations.places[: held_out.BODY]
    before = nut > 0.0
    assert (np.diff([one.delay for one in stations.friction[: held_out.BODY]])[before[1:]] < 0.0).all()


def test_slow_noise_is_about_one_over_f() -> None:
    """Its variance is one, and between its outer corners power falls as the frequency's power -0.7 to -1.3."""
    generator = np.random.default_rng(3)
    x = np.stack([held_out.slow_noise(100.0, 4096, generator) for _ in range(300)])
    assert x.var() == pytest.approx(1.0, abs=0.1)
    power = np.mean(np.abs(np.fft.rfft(x * np.hanning(4096), axis=1)) ** 2, axis=0)
    frequency = np.fft.rfftfreq(4096)
    within = (frequency > 1.0 / (2.0 * np.pi * 600.0)) & (frequency < 6.0 / (2.0 * np.pi * 100.0))
    slope = np.polyfit(np.log(frequency[within]), np.log(power[within]), 1)[0]
    assert -1.3 < slope < -0.7


def test_campaigns_are_as_described(drawn: list[CampaignTruth]) -> None:
    """Sizes, coefficients, sampling, roles, motion and room are within what the bench states."""
    rests = []
    for campaign in drawn:
        step = campaign.notes["sample_s"]
        assert len(campaign.sensors) == 17
        assert len(campaign.base) == 1
        assert (np.diff(campaign.positions) > 0.003).all()
        assert 0.400 <= campaign.retracted_length <= 0.650
        assert 0.180 <= campaign.stroke[1] <= 0.280
        A, B = campaign.coefficients
        assert 1e-6 <= A <= 3e-6
        assert 0.5e-6 <= B <= 2e-6
        assert 10.0 <= float(step) <= 20.0  # type: ignore[arg-type]
        assert [run.role for run in campaign.runs] == ["identification"] * 8 + ["validation"] * 3
        assert 1.0 < max(np.ptp(run.temperatures, axis=0).max() for run in campaign.runs) < 15.0
        for run in campaign.runs:
            assert (np.diff(run.time) == step).all()
            assert 3.98 < run.time[-1] / 3600.0 < 6.0
            assert run.q.min() >= 0.0
            assert run.q.max() <= campaign.stroke[1]
            assert 0.05 < run.air[:, 2].min() < run.air[:, 2].max() < 0.95
            starts = np.flatnonzero(np.concatenate([[True], np.diff(run.q) != 0.0, [True]]))
            rests.append(np.diff(run.time[np.minimum(starts, len(run.time) - 1)]))
    long = np.concatenate(rests)
    assert np.count_nonzero(long > 3000.0) > 5
    assert np.count_nonzero((long > 60.0) & (long < 1300.0)) > 100


def test_levels_are_as_noted(drawn: list[CampaignTruth]) -> None:
    """White noise, scatter, readings, walks and biases have the sizes in the notes, these the sizes of the bench."""
    bounds = {"white_um": (0.02, 0.1), "landing_um": (0.05, 0.25), "sensor_noise_K": (0.01, 0.06),
              "sensor_walk_6h_K": (0.0245, 0.05), "sensor_bias_K": (0.03, 0.2)}  # fmt: skip
    for campaign in drawn:
        level = {key: value for key, value in campaign.notes.items() if isinstance(value, float)}
        assert all(low <= level[name] <= high for name, (low, high) in bounds.items())
        assert level["slow_um"] == 0.0 or 0.02 <= level["slow_um"] <= 0.06
        same = [run.settled[1:] & run.settled[:-1] & (np.diff(run.q) == 0.0) for run in campaign.runs]
        jumps = [np.diff(run.noise)[rows] * 1e6 for run, rows in zip(campaign.runs, same, strict=True)]
        # most pairs are of one rest; the median is not moved by the others, nor much by the slow process
        median = np.median(np.abs(np.concatenate(jumps)))
        assert median / 0.6745 / np.sqrt(2.0) == pytest.approx(level["white_um"], rel=0.25)
        noise = np.concatenate([run.noise[run.settled] for run in identification(campaign)])
        assert np.sqrt(np.mean(noise**2)) * 1e6 == pytest.approx(level["noise_rms_um"])
        parts = np.sqrt(level["white_um"] ** 2 + level["landing_um"] ** 2 + level["slow_um"] ** 2)
        assert 0.4 * parts < level["noise_rms_um"] < 2.0 * parts
        readings = np.concatenate([np.diff(run.sensor_errors, axis=0) for run in campaign.runs])
        assert readings.std() / np.sqrt(2.0) == pytest.approx(level["sensor_noise_K"], rel=0.05)
        first = np.mean([run.sensor_errors[:50].mean(axis=0) for run in campaign.runs], axis=0)
        least, most = np.sqrt(chi2.ppf([1e-6, 1.0 - 1e-6], first.size - 1) / first.size)  # of so few thermometers
        assert 0.9 * least < first.std() / level["sensor_bias_K"] < 1.1 * most
        walked = [
            (run.sensor_errors[-30:].mean(axis=0) - run.sensor_errors[:30].mean(axis=0)) / np.sqrt(run.time[-1] / 21600)
            for run in campaign.runs
        ]
        assert np.std(walked) == pytest.approx(level["sensor_walk_6h_K"], rel=0.3)


def test_slow_noise_comes_in_half_of_all() -> None:
    """Of 200 draws of the levels, slow noise is in 70 to 130."""
    generator = np.random.default_rng(5)
    assert 70 <= sum(held_out._levels(generator)["slow_um"] > 0.0 for _ in range(200)) <= 130


def test_a_campaign_is_written_and_read_back(tmp_path: Path, seed: int) -> None:
    """A campaign with something hidden is a folder that loads whole: its runs, readings, and drift at rest."""
    truth, answer = campaign_of("held_out", seed, causes=("backlash",), strength=1.0)
    assert answer.strengths[0] == pytest.approx(1.0, rel=0.1)
    write_campaign(tmp_path / "leg", truth, answer)
    campaign = load_campaign(tmp_path / "leg")
    assert [run.role for run in campaign.runs] == [run.role for run in truth.runs]
    for mine, read in zip(truth.runs, campaign.runs, strict=True):
        blocks = list(usable_blocks(campaign, read))
        used = np.searchsorted(mine.time, np.concatenate([block.time for block in blocks]))
        # only first rows and rows that look like an outlier of heavy tails may be left out
        assert used.size > 0.95 * mine.settled.sum()
        whole = mine.drift + mine.effect + mine.noise
        found = np.concatenate([block.drift for block in blocks])
        np.testing.assert_allclose(found, (whole - whole[0])[used], rtol=0, atol=3e-9)
        heat = np.concatenate([block.dT for block in blocks])
        readings = mine.temperatures + mine.sensor_errors
        np.testing.assert_allclose(heat, (readings - readings[0])[used], rtol=0, atol=1.1e-3)
