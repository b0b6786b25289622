"""Lines of many thermometers can be told apart, and each still shows its part."""

from __future__ import annotations

import colorsys

from matplotlib.colors import to_rgb

from hexathermal.learn.campaign import Thermocouple
from hexathermal.show.campaign_figures import PART_COLOURS, STYLES, looks

BODY = tuple(Thermocouple(f"T{k:02d}", "body") for k in range(1, 15))
ROD = tuple(Thermocouple(f"T{k}", "rod") for k in range(15, 18))


def hue(colour: str) -> float:
    """Return the hue of a colour, 0 to 1."""
    return colorsys.rgb_to_hsv(*to_rgb(colour))[0]


def test_no_two_of_seventeen_thermometers_look_alike() -> None:
    """Fourteen on the body, more than there are styles: colour and style together are each one's own."""
    drawn = looks(BODY + ROD)
    assert len(set(drawn)) == 17


def test_hue_runs_along_a_part_and_stays_nearer_to_it_than_to_another() -> None:
    """From the first to the last of the body hue goes one way; the rod's few have the rod's colour as it is."""
    drawn = looks(BODY + ROD)
    body = [hue(colour) for colour, _style in drawn[:14]]
    assert body == sorted(body)
    blue, vermilion = (hue(colour) for colour in PART_COLOURS[:2])
    assert all(abs(one - blue) < abs(one - vermilion) for one in body)
    assert drawn[14:] == [(PART_COLOURS[1], style) for style in STYLES[:3]]
