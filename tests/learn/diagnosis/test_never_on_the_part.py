"""A thermometer of the law that was off its part before the first row: it reads mostly air in every run."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest

from hexathermal.learn.campaign_files import load_campaign
from hexathermal.learn.diagnosis import Diagnosis, diagnose
from hexathermal.learn.diagnosis.beside_the_law import BesideTheLaw
from hexathermal.learn.diagnosis.causes import sensor_detached
from hexathermal.learn.diagnosis.ranking import Ranked
from hexathermal.learn.diagnosis.rivals import ORDERED, SURELY, never_on_its_part
from hexathermal.learn.diagnosis.stage import Stage, view_of
from hexathermal.learn.diagnosis.trials import Trial
from hexathermal.learn.diagnosis.view import View
from hexathermal.learn.signals import campaign_rows
from hexathermal.machine.leg_signals import LegSignals
from hexathermal.poses import FloatArray
from hexathermal.simulate.hidden.drawing import campaign_of
from hexathermal.simulate.hidden.effects import named
from hexathermal.simulate.hidden.writing import write_campaign
from tests.learn.diagnosis.campaigns import altered, first_name, viewed

SHARE, LONG_AGO_S = 0.85, -1e9


def write_loose(folder: Path, bench: str, seed: int, share: float = SHARE) -> tuple[str, ...]:
    """Write a campaign in which the last of the law's thermometers reads air in all runs; return the law's."""
    truth, answer = campaign_of(bench, seed, causes=())
    first = next(run for run in truth.runs if run.role == "identification")
    loose = {"target": max(answer.base), "run": first.name, "moment": LONG_AGO_S, "time": 60.0, "share": share,
             "fixed": False}  # fmt: skip
    write_campaign(folder, named("sensor-detached").hide(truth, loose), answer)
    return answer.base


@cache
def loosened(bench: str, seed: int, share: float = SHARE) -> View:
    """The runs for identification of such a campaign, from its files."""
    with TemporaryDirectory() as place:
        base = write_loose(Path(place) / "campaign", bench, seed, share)
        campaign = load_campaign(Path(place) / "campaign")
        return view_of(campaign, campaign_rows(campaign, "identification"), base)


@cache
def found(bench: str, seed: int) -> Diagnosis:
    """The diagnosis of such a campaign."""
    with TemporaryDirectory() as place:
        base = write_loose(Path(place) / "campaign", bench, seed)
        return diagnose(load_campaign(Path(place) / "campaign"), base)


def begun(view: View) -> list[Trial]:
    """The trials of losses before the first row."""
    return [trial for trial in sensor_detached.trials(Stage(view).bench) if trial.tight]


@pytest.mark.long
@pytest.mark.parametrize(
    ("bench", "seed"),
    [
        ("finite_volume", 1),
        ("rough", 4),
        ("free_convection", 3),
        ("quiet", 5),
    ],
)
def test_it_is_named(bench: str, seed: int) -> None:
    """No row ever showed it on the part, but places along the leg tell what it should read, and the drift agrees."""
    assert first_name(loosened(bench, seed)) == "sensor-detached"


@pytest.mark.long
def test_the_others_speak_for_it_in_whatever_run() -> None:
    """The repair has no moment and no run: a controller leaves out its readings; the share is told, and it pays."""
    said = found("finite_volume", 1)
    (repair,) = said.extended.repairs
    assert repair.replaced == said.effects[0].target
    assert "from_s" not in repair.parameters
    assert "since the beginning" in said.effects[0].sentence
    share = said.effects[0].parameters["share"]
    assert abs(share.value - SHARE) < 3.0 * share.std < 0.3
    assert said.gain is not None
    assert said.gain.total.rmse_after.value < 0.3 * said.gain.total.rmse_before


def test_what_others_speak_for_is_not_asked_again() -> None:
    """Where the others stand for a thermometer its parity is empty: no loss of contact is looked for there."""
    view = loosened("finite_volume", 1)
    stage = Stage(view)
    after = stage.with_effect(stage.search.scored(stage.levels, begun(view))[0])
    model = after.bench.model(view.base[-1])
    assert model is not None
    assert model.spoken_for
    assert not begun(after.view)


@pytest.mark.long
@pytest.mark.parametrize(("seed", "share"), [(1, 0.35), (3, 0.5), (3, 0.7)])
def test_a_share_in_all_runs_is_told_by_the_drift_alone(seed: int, share: float) -> None:
    """No place tells what it should read; the repair takes the air out of its reading, in whatever run."""
    view = replace(loosened("quiet", seed, share), positions={})
    assert first_name(view) == "sensor-detached"
    stage = Stage(view)
    leader = next(item for item in stage.search.step(stage.search.trials).ranking if item.cause == "sensor-detached")
    assert leader.best.trial.parity is None
    repair = stage.with_effect(leader.best).repairs[-1]
    assert repair.kind == "loose"
    assert set(repair.parameters) == {"sensor", "share"}
    assert abs(repair.parameters["share"] - share) < 0.05


def test_a_reading_that_has_less_than_nothing_of_the_air_is_no_loss_of_contact() -> None:
    """One that runs away from the air in all runs looks like a share below none, whatever the drift says for it."""
    view, _ = viewed("quiet", 1, (), 1.0)
    own = view.base[0]

    def away(_run: int, signals: LegSignals) -> FloatArray:
        assert signals.air is not None
        return np.asarray(signals.dT[own] + 0.3 * (signals.dT[own] - signals.air))

    stage = Stage(replace(altered(view, own, away), positions={}))
    (alone,) = [trial for trial in sensor_detached.trials(stage.bench) if trial.parity is None]
    scored = stage.search.scored(stage.levels, [alone])[0]
    heard = stage.search.witnesses.heard(Ranked(alone.cause, scored.value, scored, stage.levels))
    assert stage.search.witnesses.error(scored, stage.levels) < 0.0 < scored.value
    assert heard.value <= 0.0


def test_without_places_nobody_knows() -> None:
    """What was never on the part taught nobody what the others foretell: places must tell it."""
    view = loosened("finite_volume", 1)
    assert begun(view)
    assert not begun(replace(view, positions={}))


@pytest.mark.long
@pytest.mark.parametrize("bench", ["finite_volume", "free_convection", "rough", "quiet"])
def test_a_sound_thermometer_shows_no_share_of_the_air(bench: str) -> None:
    """The parity of thermometers on their part speaks against it, for all that the air goes as they do."""
    view, _ = viewed(bench, 3, (), 1.0)
    stage = Stage(view)
    for trial in begun(view):
        shown = stage.search.witnesses.shown(trial)
        assert shown is not None
        assert shown.gain < 0.0
        assert abs(shown.amplitude) < 0.3


@pytest.mark.long
def test_what_it_reads_besides_the_air_is_asked_for_the_part() -> None:
    """Where places foretell roughly, its own readings less the air tell the drift better what it should have read."""
    view = loosened("free_convection", 1)
    stage = Stage(view)
    plain, *taught = stage.search.scored(stage.levels, [trial for trial in begun(view) if trial.base is None])
    assert max(item.value for item in taught) > plain.value + 10.0


@pytest.mark.long
@pytest.mark.parametrize(("bench", "seed"), [("finite_volume", 1), ("free_convection", 1)])
def test_a_thermometer_in_the_air_is_no_exchange_with_a_neighbour(bench: str, seed: int) -> None:
    """A neighbour's reading stands for it as well as all others do; the parity knows of the air.

    Where the order along the leg speaks for an exchange, or the parity says little, an exchange stays what it is.
    """
    step = Stage(loosened(bench, seed)).step
    (lost,) = [item for item in step.ranking if item.cause == "sensor-detached"]
    trial = lost.best.trial
    assert lost.witness > SURELY
    plugs = Trial("swapped-sensors", trial.columns, trial.target, parameters={"other": "T02"}, advantage=1.0)
    beside = replace(lost, cause=plugs.cause, best=replace(lost.best, trial=plugs), value=1.2 * lost.value, borne=20.0)
    assert [item.cause for item in by_value(never_on_its_part([lost, beside]))] == ["sensor-detached", plugs.cause]
    ordered = replace(beside, best=replace(beside.best, trial=replace(plugs, advantage=ORDERED + 1.0)))
    later = replace(beside, best=replace(beside.best, trial=replace(plugs, parameters={"from_run": "run-02"})))
    for pair in ([lost, ordered], [lost, later], [replace(lost, witness=1.0), beside],
                 [lost, replace(beside, value=2.0 * lost.value)]):  # fmt: skip
        assert never_on_its_part(pair) == pair


def by_value(ranked: list[Ranked]) -> list[Ranked]:
    """Causes, the likeliest first."""
    return sorted(ranked, key=lambda item: -item.value)


def test_its_share_is_looked_for() -> None:
    """Shares on a grid, and the one that the parity shows, are taken out of readings before they teach.

    The best of them stand for the reading as the law's own temperature: no amplitude is left to be found.
    """
    view = loosened("finite_volume", 1)
    mended = [trial for trial in begun(view) if trial.base is not None]
    assert len(mended) == len(begun(view)) - len(mended) == len(sensor_detached.SHARES) + 2
    for trial in mended:
        assert trial.anew
        assert not trial.columns.shape[1]


def test_the_zero_of_a_campaign_was_read_in_the_air_too() -> None:
    """Nothing stands off from the first row on: the parity holds the air less what is foretold, and no constant."""
    view = replace(loosened("finite_volume", 1), zeroed_by_run=False)
    (model,) = [Stage(view).bench.model(sensor) for sensor in view.base]
    assert model is not None
    assert view.airs is not None
    trial = begun(view)[0]
    assert trial.parity is not None
    gaps = [air - profiles @ model.expected[0] for air, profiles in zip(view.airs, model.profiles, strict=True)]
    assert trial.parity(model)[0][:, 0] == pytest.approx(model.means(gaps), abs=1e-12)


def test_no_row_of_all_runs_is_left_out_of_what_it_reads() -> None:
    """The trial explains the whole of each run: the drift's columns are those of all windows."""
    view = loosened("finite_volume", 1)
    for trial in [one for one in begun(view) if one.base is None]:
        assert (np.abs(trial.columns).max(axis=1) > 0.0).mean() > 0.9


def test_a_reading_that_is_replaced_as_it_is_has_no_size_to_be_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    """Whatever the law's last coefficient is, against the first too: what the parity says counts wholly."""
    monkeypatch.setattr(BesideTheLaw, "amplitude", lambda _own, _trial: (1.0, -1.0, 0.0))
    view = loosened("finite_volume", 1)
    stage = Stage(view)
    for trial in [one for one in begun(view) if one.base is not None]:
        own = stage.search.witnesses._gain(trial, trial.target)
        (scored,) = stage.search.scored(stage.levels, [trial])
        said = stage.search.witnesses.spoken(scored)
        assert 0.0 < own == said
