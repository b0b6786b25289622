"""A small effect that is seen sharply does not hide a large one: the large one may leave a small misfit."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from hexathermal.learn.diagnosis.channels import Levels
from hexathermal.learn.diagnosis.deciding import decided
from hexathermal.learn.diagnosis.evidence import Base, Scored
from hexathermal.learn.diagnosis.ranking import Ranked, Step
from hexathermal.learn.diagnosis.rivals import late_or_off, with_a_misfit
from hexathermal.learn.diagnosis.search import Search
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
