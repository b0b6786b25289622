"""What each run does in its own way: something nameless, that no cause's columns of single runs hide in the null."""

from __future__ import annotations

from pathlib import Path

import pytest

from hexathermal.learn.campaign_files import load_campaign
from hexathermal.learn.diagnosis.diagnosing import diagnose
from hexathermal.simulate.hidden.drawing import campaign_of
from hexathermal.simulate.hidden.writing import write_campaign


@pytest.mark.long
@pytest.mark.parametrize(
    ("bench", "seed"),
    [("rough", 3216184099605005), ("finite_volume", 7224124495952242)],
)
def test_a_floor_that_tilts_another_way_in_each_run_is_unexplained(tmp_path: Path, bench: str, seed: int) -> None:
    """A frame's own starts of each run imitate such a floor, as a slow noise does: tolerated in the null, they would
    leave nothing to be seen of it.
    """
    truth, answer = campaign_of(bench, seed, causes=("outside: floor-tilt",), strength=1.2)
    write_campaign(tmp_path / "campaign", truth, answer)
    found = diagnose(load_campaign(tmp_path / "campaign"), sensors=answer.base)
    assert found.verdict == "unexplained"
    assert not found.effects
