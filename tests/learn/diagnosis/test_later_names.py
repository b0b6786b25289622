"""Names after the first one, and names that are as good as one another."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from hexathermal.learn.diagnosis.deciding import SOUND, decided
from hexathermal.learn.diagnosis.evidence import LEAST
from hexathermal.learn.diagnosis.ranking import Ranked
from tests.learn.diagnosis.test_evidence import ranked, step


def test_a_later_name_needs_no_more_than_what_imitates_it() -> None:
    """Once a cause was named, wear that says as much leaves a drift of the zero its name, and so does what it left.

    What lies farther behind than the shape error of the first one has none.
    """
    wear, bumps = ranked("follows the way", 30.0), ranked("follows the displacement", 50.0, columns=6)
    alike, little, far = (ranked("zero-drift", value) for value in (29.9, 45.5, 40.0))
    assert not decided(step(wear, alike), LEAST).named
    assert decided(step(wear, alike), LEAST, before=100.0).named
    assert not decided(step(bumps, little), LEAST).named
    assert decided(step(bumps, little), LEAST, before=200.0).named
    assert not decided(step(bumps, far), LEAST, before=200.0).named


def test_names_that_are_as_good_are_as_sure_together() -> None:
    """Two that share what is believed are each half as likely as both."""
    decision = decided(step(ranked("swapped-sensors", 80.0), ranked("missing-sensor", 80.0)), LEAST)
    assert decision.probability < 0.5 < 0.98 * SOUND < decision.together <= SOUND
    alone = decided(step(ranked("creep", 80.0)), LEAST)
    assert alone.together == alone.probability


def test_a_name_that_is_far_ahead_stands_beside_one_that_thermometers_may_feign() -> None:
    """Where one thermal name stands, another that explains far more leads, although a little more of it may be feigned.

    Not where it is hardly ahead, nor where far more of it may be feigned, nor where nothing else stands.
    """

    def feigned(cause: str, value: float, gated: float) -> Ranked:
        """A name with some evidence, and less of it against a misfit that thermometers feign."""
        plain = ranked(cause, value)
        trial = replace(plain.best.trial, feigned=plain.best.visible / np.sqrt(2.0 * gated))
        item = replace(plain, best=replace(plain.best, trial=trial))
        assert item.gated == pytest.approx(gated, rel=0.1)
        return item

    other = feigned("missing-sensor", 60.0, 1.2 * LEAST)
    ahead, hardly, less = (
        feigned("swapped-sensors", value, part * LEAST) for value, part in ((200.0, 0.9), (66.0, 0.9), (200.0, 0.4))
    )
    for item, leads in ((ahead, True), (hardly, False), (less, False)):
        leader = decided(step(item, other), LEAST).leader
        assert leader is not None
        assert (leader.cause == "swapped-sensors") == leads
    assert decided(step(ahead), LEAST).leader is None
