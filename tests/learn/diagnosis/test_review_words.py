"""Sentences say what is true, in units of the workshop."""

from __future__ import annotations

from hexathermal.learn.diagnosis.result import Quantity
from hexathermal.learn.diagnosis.words import _sentence, told


def test_a_clock_behind_is_said_to_be_behind() -> None:
    """The sign of the offset decides the word."""
    ahead = _sentence("clock-offset", None, {"offset_s": Quantity(120.0, 5.0, "s")}, {}, 3e-7)
    behind = _sentence("clock-offset", None, {"offset_s": Quantity(-120.0, 5.0, "s")}, {}, 3e-7)
    assert "runs ahead of that" in ahead
    assert "runs behind that" in behind


def test_both_exchanged_plugs_are_named() -> None:
    """The sentence names the two thermometers."""
    said = _sentence("swapped-sensors", "T08", {}, {"other": "T07"}, 3e-7)
    assert "the plugs of T08 and T07 are exchanged" in said


def test_units_are_those_of_the_workshop() -> None:
    """Parts in a million, millimetres and micrometres for a metre: no powers of ten to read."""
    assert told(Quantity(-3.3084, 0.4809, "1e-6")) == "-3.31 ± 0.48 um/m"
    assert told(Quantity(0.0171, 8.4e-5, "m")) == "17.100 ± 0.084 mm"
    assert told(Quantity(-1.45e-7, 6.7e-9, "1/K^2")) == "-0.1450 ± 0.0067 um/m/K^2"
    assert told(Quantity(0.913, 0.077, "1")) == "0.913 ± 0.077"
