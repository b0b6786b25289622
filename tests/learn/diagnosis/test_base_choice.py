"""Where nobody names the law's thermometers, the runs do."""

from __future__ import annotations

from dataclasses import replace

import pytest

from hexathermal.learn.diagnosis.base_choice import likelier_sensors
from tests.learn.diagnosis.campaigns import viewed


@pytest.mark.long
@pytest.mark.parametrize("bench", ["modal", "rough"])
def test_a_neighbour_gives_way_to_the_thermometer_that_the_leg_follows(bench: str) -> None:
    """From any thermometer the search arrives where the drift is likeliest, and stays there."""
    view, answer = viewed(bench, 5, (), 1.0)  # its leg follows one thermometer
    others = [name for name in view.sensors if name not in answer.base]
    arrived = {likelier_sensors(replace(view, base=(name,))) for name in (others[0], others[-1])}
    arrived.add(likelier_sensors(replace(view, base=answer.base)))
    assert arrived == {answer.base}
