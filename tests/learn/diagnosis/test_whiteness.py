"""What is left of windows, whitened by the fitted noise, knows nothing of its neighbours where the law is right."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from hexathermal.learn.campaign_files import load_campaign
from hexathermal.learn.diagnosis import diagnose
from hexathermal.learn.diagnosis.result import Autocorrelation
from hexathermal.simulate.hidden.drawing import campaign_of
from hexathermal.simulate.hidden.writing import write_campaign


def whiteness(folder: Path, bench: str, *causes: str) -> Autocorrelation:
    """The autocorrelation of a leg with something hidden, twice as strong as the noise."""
    truth, answer = campaign_of(bench, 7, causes=causes, strength=2.0)
    write_campaign(folder, truth, answer)
    found = diagnose(load_campaign(folder), answer.base)
    assert [one.cause for one in found.effects] == list(causes)
    told = found.to_json()["autocorrelation"]
    assert found.whiteness is not None
    assert told == {"before": found.whiteness.before.tolist(), "after": found.whiteness.after.tolist(),
                    "band_95": found.whiteness.band}  # fmt: skip
    return found.whiteness


@pytest.mark.long
def test_independent_noise_is_left_of_a_sound_leg_and_beside_a_named_cause(tmp_path: Path) -> None:
    """Most lags stay in the band of independent noise; an effect sticks out at the first ones until it has its name."""
    sound = whiteness(tmp_path / "sound", "quiet")
    assert (np.abs(sound.before) < sound.band).mean() >= 0.75
    np.testing.assert_array_equal(sound.before, sound.after)
    loose = whiteness(tmp_path / "loose", "modal", "backlash")
    assert np.abs(loose.before).max() > 2.0 * loose.band
    assert (np.abs(loose.after) < loose.band).mean() >= 0.75
