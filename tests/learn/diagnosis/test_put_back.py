"""A thermometer that came off in the last fitted run and sits right again in those for validation: others tell."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest

from hexathermal.learn.campaign_files import load_campaign
from hexathermal.learn.diagnosis import Diagnosis, diagnose
from hexathermal.simulate.hidden.drawing import campaign_of
from hexathermal.simulate.hidden.writing import write_campaign
from tests.learn.diagnosis.campaigns import rewritten

MOMENT, SHARE = 6000.0, 0.5


@cache
def found(*, back: bool) -> Diagnosis:
    """The diagnosis where the law's thermometer reads half of the air late in the last fitted run, and on or not."""
    truth, answer = campaign_of("finite_volume", 13, causes=())
    with TemporaryDirectory() as place:
        folder = Path(place) / "campaign"
        write_campaign(folder, truth, answer)
        campaign = load_campaign(folder)
        last = campaign.runs_of("identification")[-1].name
        later = [run.name for run in campaign.runs_of("validation")]
        column = f"{answer.base[0]}_degC"

        def loosen(rows: list[dict[str, str]], begin: float) -> None:
            for row in rows:
                if float(row["time_s"]) >= begin:
                    own, air = float(row[column]), float(row["air_temperature_degC"])
                    row[column] = f"{own + SHARE * (air - own):.4f}"

        rewritten(folder / "runs" / f"{last}.csv", lambda rows: loosen(rows, MOMENT))
        for name in () if back else later:
            rewritten(folder / "runs" / f"{name}.csv", lambda rows: loosen(rows, 0.0))
        return diagnose(load_campaign(folder), answer.base)


@pytest.mark.long
def test_it_is_put_right_until_it_was_put_back_and_not_after() -> None:
    """Name, setting and sentence say that it was mended; runs for validation are read as they are, and lose nothing."""
    said = found(back=True)
    assert said.cause == "sensor-detached", said.sentence
    assert said.effects[0].settings["fixed_again"] == said.candidates[0].settings["fixed_again"] == 1
    assert "(in run-" in said.sentence
    (repair,) = said.extended.repairs
    assert list(repair.parameters["from_s"]) == [said.effects[0].settings["run"]]
    assert said.gain is not None
    assert said.gain.total.rmse_after.value < 1.02 * said.gain.total.rmse_before


@pytest.mark.long
def test_what_stays_off_is_put_right_in_later_runs_too() -> None:
    """The same loss that lasts: the repair goes on, without which the law would be wrong by far more."""
    said = found(back=False)
    assert said.cause == "sensor-detached", said.sentence
    assert "fixed_again" not in said.effects[0].settings
    assert " on; " in said.sentence
    assert len(said.extended.repairs[0].parameters["from_s"]) > 1
    assert said.gain is not None
    assert said.gain.total.rmse_after.value < 0.5 * said.gain.total.rmse_before
