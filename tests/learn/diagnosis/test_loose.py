"""A thermometer that comes loose in part among others that tell little: its own reading, less the air, is enough."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest

from hexathermal.learn.campaign_files import load_campaign
from hexathermal.learn.diagnosis import Diagnosis, diagnose
from hexathermal.learn.diagnosis.causes.sensor_detached import share_of
from hexathermal.learn.diagnosis.stage import Stage
from hexathermal.learn.leg_law_files import read_leg_law, write_leg_law
from hexathermal.simulate.hidden.drawing import campaign_of
from hexathermal.simulate.hidden.writing import write_campaign
from tests.learn.diagnosis.campaigns import rewritten, viewed

WANDER_K = 0.3


def wandering(folder: Path, base: tuple[str, ...], seed: int) -> None:
    """Let all thermometers but the law's wander by themselves for hours, so that none foretells another well."""
    rng = np.random.default_rng(seed)
    for file in sorted((folder / "runs").glob("*.csv")):

        def change(rows: list[dict[str, str]]) -> None:
            time = np.array([float(row["time_s"]) for row in rows])
            for name in rows[0]:
                sensor = name.removesuffix("_degC")
                if name.endswith("_degC") and sensor not in base and name != "air_temperature_degC":
                    phase, period = rng.uniform(0.0, 2.0 * np.pi), rng.uniform(3600.0, 14400.0)
                    error = WANDER_K * np.sqrt(2.0) * np.sin(2.0 * np.pi * time / period + phase)
                    for row, more in zip(rows, error, strict=True):
                        row[name] = f"{float(row[name]) + more:.4f}"

        rewritten(file, change)


def loosened(folder: Path, sensor: str, first: int, moment: float, share: float) -> None:
    """Let a thermometer read a share of the air from a moment of a run on."""
    for k, file in enumerate(sorted((folder / "runs").glob("*.csv"))):

        def change(rows: list[dict[str, str]], k: int = k) -> None:
            for row in rows:
                if k > first or (k == first and float(row["time_s"]) >= moment):
                    own, air = float(row[f"{sensor}_degC"]), float(row["air_temperature_degC"])
                    row[f"{sensor}_degC"] = f"{own + share * (air - own):.4f}"

        rewritten(file, change)


@cache
def found(seed: int, share: float, moment: float = 0.0, first: int = 3, *, alone: bool = True) -> Diagnosis:
    """The diagnosis of a clean campaign of which the law's thermometer reads some air from a moment of a run on.

    `alone`: its thermometers tell little of each other.
    """
    truth, answer = campaign_of("finite_volume", seed, causes=())
    with TemporaryDirectory() as place:
        folder = Path(place) / "campaign"
        write_campaign(folder, truth, answer)
        if alone:
            wandering(folder, answer.base, seed)
        loosened(folder, answer.base[0], first, moment, share)
        return diagnose(load_campaign(folder), answer.base)


@pytest.mark.long
@pytest.mark.parametrize(
    ("seed", "moment", "given"),
    [(13, 6000.0, 0.2)],
)
def test_it_is_named_and_put_right_by_its_own_reading(seed: int, moment: float, given: float) -> None:
    """The name, the share within three of its standard uncertainties, the repair, and what that gains.

    Of a small share the drift knows more than the others, of a large one they know as much as it takes.
    """
    said = found(seed, given, moment)
    assert said.cause == "sensor-detached", said.sentence
    share = said.effects[0].parameters["share"]
    assert share.value == pytest.approx(given, abs=3.0 * share.std + 0.02)
    (repair,) = said.extended.repairs
    assert repair.kind == "loose"
    assert repair.parameters["share"] == pytest.approx(given, abs=0.05)
    assert said.gain is not None
    assert said.gain.total.rmse_after.value < 0.8 * said.gain.total.rmse_before


@pytest.mark.long
def test_a_large_share_is_put_right_by_others_that_tell_it() -> None:
    """Of a thermometer that reads 0.8 of the air from late in the last run on, little is left to divide: others speak.

    They take more than seven tenths of what the law gets wrong on runs for validation.
    """
    said = found(13, 0.8, 10080.0, 7, alone=False)
    assert said.cause == "sensor-detached", said.sentence
    assert [repair.kind for repair in said.extended.repairs] == ["detached"]
    assert said.gain is not None
    assert said.gain.total.rmse_after.value < 0.3 * said.gain.total.rmse_before


@pytest.mark.long
def test_thermometers_that_tell_little_are_no_fault() -> None:
    """The same campaigns with the law's thermometer on its part: nothing is named."""
    assert found(14, 0.0).verdict == "none"


@pytest.mark.long
def test_a_reading_that_runs_away_from_the_air_is_not_loose() -> None:
    """A share below nothing: whatever it is, no thermometer came off."""
    assert found(13, -0.25, 6000.0).cause != "sensor-detached"


@pytest.mark.long
def test_the_repair_is_written_and_read_without_loss(tmp_path: Path) -> None:
    """The extended law with its tables by run."""
    said = found(14, 0.2, 6000.0)
    read = read_leg_law(write_leg_law(said.extended, tmp_path / "leg.toml"))
    assert read.repairs == said.extended.repairs
    assert set(read.repairs[0].parameters) >= {"from_s", "air_above_K"}


def test_the_share_is_that_of_the_reading() -> None:
    """``T_part = T + s / (1 - s) (T - T_air)``: no share of what is not there, and never all of it."""
    assert share_of(0.25) == pytest.approx(0.2)
    assert share_of(-0.1) == 0.0
    assert share_of(1e9) < 1.0


@pytest.mark.long
def test_a_repair_by_its_own_reading_is_taken_where_it_leaves_hardly_more(monkeypatch: pytest.MonkeyPatch) -> None:
    """Others who speak for a thermometer bring errors of their own, which look like causes."""
    view, _answer = viewed("finite_volume", 5, ("sensor-detached",), 2.0)
    stage = Stage(view)
    own = [item for item in stage.search.scored(stage.step.levels, stage.search.trials)
           if item.trial.cause == "sensor-detached" and item.trial.lessened is not None]  # fmt: skip
    best = max(own, key=lambda item: item.value)
    kinds = []
    for more in (0.0, 1e9):
        monkeypatch.setattr("hexathermal.learn.diagnosis.stage.OWN_READING", more)
        kinds.append(stage.with_effect(best).repairs[-1].kind)
    assert kinds == ["detached", "loose"]
