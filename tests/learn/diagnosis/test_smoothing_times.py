"""How long readings are smoothed: as long as that takes noise and little else, lest noise shrink the law."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from hexathermal.learn.diagnosis import smoothing_times as times
from hexathermal.learn.diagnosis.reading_noise import with_reading_noise
from hexathermal.learn.diagnosis.smoothing import smoothed
from hexathermal.learn.diagnosis.view import View
from hexathermal.poses import FloatArray
from tests.learn.diagnosis.campaigns import viewed
from tests.learn.diagnosis.test_thermometers import with_noise


def reading(view: View, values: FloatArray) -> View:
    """A view of one run and one thermometer of these values, a row each 15 s."""
    time = 15.0 * np.arange(len(values))
    rows = view.runs[0]
    own = replace(rows, signals=replace(rows.signals, time=time, dT={"T": values}))
    return replace(view, runs=(own,), sensors=("T",), base=("T",))


@pytest.mark.parametrize(
    ("noise", "swing", "longest"),
    [(0.0, 0.0, 300.0), (0.05, 0.0, 1200.0), (0.05, 0.1, 300.0), (1.0, 0.1, 1200.0)],
    ids=["without noise", "noisy and slow", "noisy and quick", "noisier than quick"],
)
def test_a_reading_is_smoothed_as_long_as_that_takes_noise_alone(
    noise: float, swing: float, longest: float, rng: np.random.Generator
) -> None:
    """Slow warmth beside noise is smoothed longest; what swings within ten minutes is kept where it stands out."""
    view, _ = viewed("modal", 5, (), 1.0)
    time = 15.0 * np.arange(4000)
    heat = 3.0 * (1.0 - np.exp(-time / 6000.0)) + swing * np.sin(2.0 * np.pi * time / 600.0)
    of = reading(view, heat + noise * rng.standard_normal(len(time)))
    assert of.smoothing["T"] == longest


def test_each_thermometer_has_its_own_time(rng: np.random.Generator) -> None:
    """Columns smoothed together over their own times are those smoothed alone, in their order."""
    time = 20.0 * np.arange(500)
    values = {name: rng.standard_normal(len(time)) for name in "abc"}
    over = {"a": 1200.0, "b": 300.0, "c": 1200.0}
    table = times.smoothed_each(time, values, over)
    for k, name in enumerate(values):
        alone = smoothed(time, values[name][:, None], over[name])[:, 0]
        assert np.allclose(table[:, k], alone, rtol=0.0, atol=1e-12)


def coefficients(view: View) -> FloatArray:
    """The law's coefficients beside the noise that is fitted with them."""
    view = with_reading_noise(view)
    law, channel = view.base_columns, view.channel
    sizes = channel.loose(law)
    return channel.solved(law, sizes, channel.fitted(law, sizes)[0])[1]


def test_a_noisy_thermometer_does_not_shrink_the_law(monkeypatch: pytest.MonkeyPatch) -> None:
    """With 0.2 K of noise in the law's reading A stays within 5 %; smoothed over 300 s alone it loses half."""
    view, _ = viewed("rough", 5, (), 1.0)
    sound = coefficients(view)[0]
    noisy = with_noise(view, view.base[0], 0.2, np.random.default_rng(1))
    assert coefficients(noisy)[0] == pytest.approx(sound, rel=0.05)
    monkeypatch.setattr(times, "SMOOTHING_S", times.SMOOTHING_S[:1])
    shorter = with_noise(view, view.base[0], 0.2, np.random.default_rng(1))
    assert coefficients(shorter)[0] < 0.5 * sound
