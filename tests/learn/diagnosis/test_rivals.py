"""A small effect that is seen sharply does not hide a large one: the large one may leave a small misfit."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from hexathermal.learn.diagnosis.channels import Levels
from hexathermal.learn.diagnosis.deciding import decided
from hexathermal.learn.diagnosis.evidence import Base, Scored
from hexathermal.learn.diagnosis.foresight import FAINT
from hexathermal.learn.diagnosis.ranking import SURE_WITNESS, Ranked, Step
from hexathermal.learn.diagnosis.rivals import late_or_off, shaped, with_a_misfit
from hexathermal.learn.diagnosis.search import Search
from hexathermal.learn.diagnosis.tolerating import tolerant
from hexathermal.learn.diagnosis.trials import Trial
from tests.learn.diagnosis.noises import channel_like, noisy

SHARP = Levels(0.02, 0.02, 0.5, 0.0, 7200.0)
"""Noise that wanders slowly: little of it is left from one window to the next."""


@pytest.mark.parametrize(
    ("small", "large", "leads"),
    [(0.08, 0.8, "scale-error"), (0.08, 0.0, "creep"), (0.8, 0.8, "creep"), (0.8, 0.0, "creep")],
)
def test_a_large_name_with_a_small_misfit_leads(
    small: float, large: float, leads: str, rng: np.random.Generator
) -> None:
    """What is quick shows more than its size: the larger cause leads where it explains more than a misfit costs."""
    channel = channel_like(rng, runs=5, windows=60)
    n = len(channel)
    quick = rng.standard_normal((n, 1))
    slow = np.sin(np.linspace(0.0, 30.0, n))[:, None]
    data = channel.with_y(noisy(channel, SHARP, rng).y + (small * quick + 1.5 * large * slow)[:, 0])
    base = Base(rng.standard_normal((n, 2)), np.ones(2), 2)
    search = Search(SimpleNamespace(), data, base, 50.0)  # type: ignore[arg-type]
    scored = search.scored(SHARP, [Trial("creep", quick), Trial("scale-error", slow)])
    before = [Ranked(item.trial.cause, item.value, item, SHARP) for item in scored]
    assert max(before, key=lambda item: item.value).cause == "creep"
    after = with_a_misfit(search.channel, search.system, before)
    assert max(after, key=lambda item: item.value).cause == leads


def ranked(cause: str, value: float, visible: float, feigned: float) -> Ranked:
    """A cause of some evidence of which thermometers may feign a part."""
    trial = Trial(cause, np.zeros((3, 0)), feigned=feigned)
    return Ranked(cause, value, Scored(trial, value, visible, 1.0, 0.0, 0.0, np.zeros(0)), Levels(1.0, 0.0, 0.0, 0.0))


@pytest.mark.parametrize(
    ("late", "off", "timed", "leads", "stands"),
    [
        (97.0, 100.0, False, "thermal-lag", True),
        (90.0, 100.0, True, "clock-offset", False),
        (97.0, 95.0, True, "thermal-lag", True),
        (97.0, 95.0, False, "thermal-lag", False),
        (97.0, 3.0, True, "thermal-lag", False),
    ],
)
def test_a_clock_must_lead_a_lag_clearly(late: float, off: float, timed: bool, leads: str, stands: bool) -> None:
    """By a twentieth of the lag's evidence; else what stands for it stands for the lag, where times are known."""
    before = [ranked("thermal-lag", late, 0.1, 0.1), ranked("clock-offset", off, 20.0, 0.0)]
    assert before[0].gated < 1.0
    after = sorted(late_or_off(before, timed=timed), key=lambda item: -item.value)
    assert after[0].cause == leads
    assert after[0].value == max(late, off)
    lag = next(item for item in after if item.cause == "thermal-lag")
    assert (lag.gated > 50.0) == stands


@pytest.mark.parametrize(("other", "alike"), [(54.0, ("missing-sensor",)), (20.0, ())])
def test_a_name_as_likely_by_the_data_is_told_though_thermometers_may_feign_it(
    other: float, alike: tuple[str, ...]
) -> None:
    """Two causes of like evidence are told together, even where one would not stand alone."""
    first, second = ranked("frame-expansion", 54.2, 10.0, 0.0), ranked("missing-sensor", other, 1.0, 5.0)
    assert second.gated < 4.5 < second.value
    found = decided(Step((first, second), SHARP, 0.0), 4.5)
    assert found.leader is first
    assert found.equivalent == alike


def fault(cause: str, value: float, sure: float, *, wanders: bool) -> Ranked:
    """A fault of T01 of which the parity says so much beyond any other."""
    trial = Trial(cause, np.zeros((3, 1)), "T01", parity=lambda _model: (np.zeros((3, 1)), np.ones(1)), wanders=wanders)
    best = Scored(trial, value, 10.0, 1.0, 0.0, 1.0, np.ones(1))
    return Ranked(cause, value, best, SHARP, witness=sure)


@pytest.mark.parametrize(("beyond", "leads"), [(40.0, "sensor-detached"), (-1.0, "sensor-drift")])
def test_what_has_a_shape_does_not_wander(beyond: float, leads: str) -> None:
    """A loss of contact that the parity shows beyond any chance leads a reading that only wanders, of that sensor."""
    wandering = fault("sensor-drift", 900.0, 500.0, wanders=True)
    lost = fault("sensor-detached", 700.0, SURE_WITNESS + beyond, wanders=False)
    after = shaped([wandering, lost])
    assert max(after, key=lambda item: item.value).cause == leads
    assert after[0] is wandering
    elsewhere = replace(lost, best=replace(lost.best, trial=replace(lost.best.trial, target="T02")))
    assert shaped([wandering, elsewhere])[1].value == elsewhere.value


def test_no_shape_leads_a_contact_that_comes_and_goes() -> None:
    """What the parity says for a drift's shape stands beside a reading that wanders, not beside a share of the air."""
    loose = fault("sensor-detached", 900.0, SURE_WITNESS + 40.0, wanders=True)
    drift = fault("sensor-drift", 700.0, SURE_WITNESS + 40.0, wanders=False)
    trial = replace(loose.best.trial, parameters={"contact": "comes and goes"})
    contact = replace(loose, best=replace(loose.best, trial=trial))
    assert shaped([contact, drift])[1].value == 700.0
    assert shaped([loose, drift])[1].value > 900.0


@pytest.mark.parametrize(("stands", "behind", "tolerated"), [
    (FAINT + 20.0, 5.0, False), (FAINT - 3.0, 5.0, True), (FAINT + 20.0, 60.0, True),
])  # fmt: skip
def test_what_leads_is_not_tolerated_beside_a_name_as_good_that_stands(
    stands: float, behind: float, tolerated: bool
) -> None:
    """What thermometers may feign goes to the null, unless a name as likely stands by itself, clearly."""
    feigned = replace(ranked("missing-sensor", 80.0, 1.0, 1.0), best=shape("missing-sensor", 80.0, 1.0, 1.0))
    other = replace(ranked("zero-drift", 80.0 - behind, 1.0, 0.0), best=shape("zero-drift", 80.0 - behind, 10.0, 0.0))
    other = replace(other, best=replace(other.best, trial=replace(other.best.trial, doubt=80.0 - behind - stands)))
    assert feigned.gated < 4.5 <= other.gated == pytest.approx(stands)
    seen: list[Any] = []

    def put(best: Scored, *, feigned: bool) -> SimpleNamespace:
        seen.append(best)
        return SimpleNamespace(step=Step((other,), SHARP, 0.0))

    stage: Any = SimpleNamespace(step=Step((feigned, other), SHARP, 0.0), tolerating=put)
    tolerant(stage, 4.5)
    assert (seen == [feigned.best]) == tolerated


def shape(cause: str, value: float, visible: float, feigned: float) -> Scored:
    """One column of a cause."""
    return Scored(Trial(cause, np.zeros((3, 1)), feigned=feigned), value, visible, 1.0, 0.0, 1.0, np.ones(1))
