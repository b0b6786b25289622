"""A contact that comes and goes: how much of the air a thermometer reads changes all the time."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
import pytest

from hexathermal.learn.campaign_files import load_campaign
from hexathermal.learn.diagnosis import diagnose
from hexathermal.learn.diagnosis.beside_others import air_above_at_zero, coming_and_going
from hexathermal.learn.diagnosis.causes import sensor_detached
from hexathermal.learn.diagnosis.causes.sensor_detached import LEAST_WANDERING
from hexathermal.learn.diagnosis.deciding import decided
from hexathermal.learn.diagnosis.evidence import LEAST
from hexathermal.learn.diagnosis.mending import mended_view
from hexathermal.learn.diagnosis.result import Quantity
from hexathermal.learn.diagnosis.sensor_model import SensorModel, sensor_model
from hexathermal.learn.diagnosis.stage import Stage
from hexathermal.learn.diagnosis.tolerating import tolerant
from hexathermal.learn.diagnosis.view import View
from hexathermal.learn.diagnosis.words import _sentence
from hexathermal.learn.leg_law_files import read_leg_law, write_leg_law
from hexathermal.machine.leg_signals import LegSignals
from hexathermal.poses import FloatArray
from hexathermal.simulate.hidden.drawing import campaign_of
from hexathermal.simulate.hidden.writing import write_campaign
from tests.learn.diagnosis.campaigns import altered, rewritten, viewed

SHARE, SPREAD, DWELL_S = 0.25, 0.15, 1500.0


def model_of(view: View) -> SensorModel:
    """The model of the law's thermometer."""
    model = sensor_model(view, view.base[0])
    assert model is not None
    return model


def wandering(time: FloatArray, rng: np.random.Generator) -> FloatArray:
    """A first-order process of unit variance."""
    kept = np.exp(-np.diff(time, prepend=time[0] - 1e9) / DWELL_S)
    found, state = np.empty(len(time)), 0.0
    for row, (one, kick) in enumerate(zip(kept, rng.standard_normal(len(time)), strict=True)):
        state = one * state + np.sqrt(1.0 - one**2) * kick
        found[row] = state
    return found


@cache
def spoilt(bench: str, seed: int, *, by_air: bool) -> View:
    """A sound leg whose thermometer reads more and less of the air, or wanders as far whatever the air does."""
    view, _ = viewed(bench, seed, (), 1.0)
    sensor, model = view.base[0], model_of(view)

    def error(k: int, signals: LegSignals, rng: np.random.Generator) -> FloatArray:
        assert signals.air is not None
        gap = signals.air - signals.dT[sensor] + air_above_at_zero(model, k)
        share = np.clip(SHARE + SPREAD * wandering(signals.time, rng), 0.0, 0.9)
        return np.asarray(share * gap)

    rng = np.random.default_rng(seed)
    errors = [error(k, rows.signals, rng) for k, rows in enumerate(view.runs)]
    if not by_air:
        size = float(np.sqrt(np.mean([np.var(one) for one in errors])))
        errors = [size * wandering(rows.signals.time, rng) for rows in view.runs]
    return altered(view, sensor, lambda k, signals: signals.dT[sensor] + errors[k] - errors[k][0])


BENCHES = [("modal", 2), ("finite_volume", 3), ("held_out", 5)]


@pytest.mark.long
@pytest.mark.parametrize(("bench", "seed"), BENCHES)
def test_the_parity_tells_a_share_of_the_air_from_a_reading_that_wanders(bench: str, seed: int) -> None:
    """What a loose contact reads wrong grows with the way to the air; the error of a bad channel does not."""
    loose, _ = coming_and_going(model_of(spoilt(bench, seed, by_air=True)))
    drifting, _ = coming_and_going(model_of(spoilt(bench, seed, by_air=False)))
    sound, _ = coming_and_going(model_of(viewed(bench, seed, (), 1.0)[0]))
    assert loose > LEAST_WANDERING > max(drifting, sound)


@pytest.mark.long
def test_contact_that_is_lost_once_does_not_come_and_go() -> None:
    """From one moment on a share of the air is read, which goes with the air as well: that moment is told."""
    view, _ = viewed("modal", 2, (), 1.0)
    sensor, model = view.base[0], model_of(view)

    def lost(k: int, signals: LegSignals) -> FloatArray:
        assert signals.air is not None
        gap = signals.air - signals.dT[sensor] + air_above_at_zero(model, k)
        off = (k > 3) or ((k == 3) * (signals.time >= 4000.0))
        return np.asarray(signals.dT[sensor] + SHARE * (gap * off - (gap * off)[0]))

    loose = altered(view, sensor, lost)
    assert coming_and_going(model_of(loose))[0] > LEAST_WANDERING
    tried = [trial.parameters for trial in sensor_detached.trials(Stage(loose).bench)]
    assert tried
    assert not any("contact" in parameters for parameters in tried)
    best = next(item.best.trial for item in Stage(loose).step.ranking if item.cause == "sensor-detached")
    assert best.parameters["run"] == view.runs[3].run.name


@pytest.mark.long
@pytest.mark.parametrize(("bench", "seed"), [("modal", 2)])
def test_each_has_its_name(bench: str, seed: int) -> None:
    """Of the same size and slowness: a contact that comes and goes, or a reading that drifts."""
    loose, drifting = (decided(tolerant(Stage(spoilt(bench, seed, by_air=own)), LEAST).step, LEAST).leader
                       for own in (True, False))  # fmt: skip
    assert loose is not None
    assert loose.cause == "sensor-detached"
    assert loose.best.trial.parameters == {"contact": "comes and goes"}
    assert drifting is not None
    assert drifting.cause == "sensor-drift"


@pytest.mark.parametrize("share", [0.1, 0.3])
def test_a_share_that_stays_does_not_come_and_go(share: float) -> None:
    """A thermometer that reads the same share of the air all the time goes with the air, but does not wander."""
    view, _ = viewed("modal", 3, (), 1.0)
    model = model_of(view)

    def aired(k: int, signals: LegSignals) -> FloatArray:
        assert signals.air is not None
        gap = signals.air - signals.dT[view.base[0]] + air_above_at_zero(model, k)
        return np.asarray(signals.dT[view.base[0]] + share * (gap - gap[0]))

    assert coming_and_going(model_of(altered(view, view.base[0], aired)))[0] < LEAST_WANDERING


def test_a_thermometer_that_others_speak_for_is_not_asked() -> None:
    """What is left of its parity is no reading of its own."""
    view = spoilt("modal", 2, by_air=True)
    bench = Stage(view).bench
    found = [trial for trial in sensor_detached.trials(bench) if trial.by_air]
    assert found
    repair = found[0].repair
    assert repair is not None
    mended = Stage(mended_view(view, repair())).bench
    assert not any(trial.by_air for trial in sensor_detached.trials(mended))


def test_it_is_said_in_words() -> None:
    """It has not come off for good, and no moment is told."""
    wander = {"wander_K": Quantity(0.5, 0.02, "K")}
    said = _sentence("sensor-detached", "T05", wander, {"contact": "comes and goes"}, 3e-7)
    assert "T05 reads the air in part, now more, now less" in said
    assert "come off" not in said


@pytest.mark.long
def test_from_files_to_files(tmp_path: Path) -> None:
    """Told from a campaign's folder as what it is, put right in runs never fitted, written and read without loss."""
    truth, answer = campaign_of("modal", 2, causes=())
    folder, rng = tmp_path / "campaign", np.random.default_rng(7)
    write_campaign(folder, truth, answer)
    name = f"{answer.base[0]}_degC"

    def loosened(rows: list[dict[str, str]]) -> None:
        time = np.array([float(row["time_s"]) for row in rows])
        shares = np.clip(2.0 * (SHARE + SPREAD * wandering(time, rng)), 0.0, 0.9)
        for row, share in zip(rows, shares.tolist(), strict=True):
            own, air = float(row[name]), float(row["air_temperature_degC"])
            row[name] = f"{own + share * (air - own):.4f}"

    for file in sorted((folder / "runs").glob("*.csv")):
        rewritten(file, loosened)
    found = diagnose(load_campaign(folder), answer.base)
    said = found.to_json()["effects"][0]
    assert (said["cause"], said["target"]) == ("sensor-detached", answer.base[0])
    assert said["settings"] == {"contact": "comes and goes"}
    assert set(said["parameters"]) == {"wander_K"}
    assert found.gain is not None
    assert found.gain.total.rmse_after.value < 0.9 * found.gain.total.rmse_before
    read = read_leg_law(write_leg_law(found.extended, tmp_path / "leg.toml"))
    assert [(one.cause, one.kind, one.parameters) for one in read.repairs] == [
        (one.cause, one.kind, one.parameters) for one in found.extended.repairs
    ]
