"""Names after the first one, and names that are as good as one another."""

from __future__ import annotations

from hexathermal.learn.diagnosis.deciding import SOUND, decided
from hexathermal.learn.diagnosis.evidence import LEAST
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
    assert decision.probability < 0.5 < 0.97 < decision.together <= SOUND
    alone = decided(step(ranked("creep", 80.0)), LEAST)
    assert alone.together == alone.probability
