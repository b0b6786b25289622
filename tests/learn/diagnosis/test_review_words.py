"""Sentences say what is true, in units of the workshop."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np

from hexathermal.learn.diagnosis.result import Effect, Quantity
from hexathermal.learn.diagnosis.words import _amplitudes, _doubts, _sentence, told
from hexathermal.show.diagnosis_words import effect_rows


def test_a_clock_behind_is_said_to_be_behind() -> None:
    """The sign of the offset decides the word."""
    ahead = _sentence("clock-offset", None, {"offset_s": Quantity(120.0, 5.0, "s")}, {}, 3e-7)
    behind = _sentence("clock-offset", None, {"offset_s": Quantity(-120.0, 5.0, "s")}, {}, 3e-7)
    assert "runs ahead of that" in ahead
    assert "runs behind that" in behind


def test_backlash_says_on_which_side_the_leg_is_longer() -> None:
    """A step is told as what moves to larger q leave over moves to smaller q: the sign is a word, too."""
    for step, word in ((0.3, "longer"), (-0.3, "shorter")):
        words = _sentence("backlash", None, {"step_um": Quantity(step, 0.02, "um")}, {}, 1e-7)
        assert f"from the other side, {word} where q grew last;" in words


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


def test_what_stays_out_of_the_law_is_not_said_to_move_anything() -> None:
    """A thermometer that runs left out do without goes along with the drift; one that joins moves the part."""
    out = _sentence("missing-sensor", "T04", {}, {}, 8.3e-7, joined=False)
    assert "moves the part" not in out
    assert out.endswith("0.83 um of it stays visible when the law is refitted, but runs left out do without it: it "
                        "stays out of the law.")  # fmt: skip
    joined = _sentence("missing-sensor", "T04", {}, {}, 5e-6)
    assert joined.endswith("moves the part; 5.0 um of it stays visible when the law is refitted.")


def test_a_step_of_the_zero_has_the_size_that_was_found() -> None:
    """The last fit is that of the law: of a term its amplitude is taken, of a step that is no term it is not."""

    def sizes(shape: str) -> tuple[list[float], list[float]]:
        best = SimpleNamespace(trial=SimpleNamespace(shape=shape, carried=1))
        found: Any = SimpleNamespace(ranked=SimpleNamespace(best=best), amplitudes=[-0.099], spread=[0.002])
        final: Any = SimpleNamespace(joined=(best,), view=SimpleNamespace(base_columns=np.zeros((5, 2))))
        values, spread = _amplitudes(found, final, np.array([1.0, 2.0, -0.112]), np.diag([1.0, 1.0, 0.055**2]))
        return list(values), list(spread)

    assert sizes("") == ([-0.099], [0.002])
    assert sizes("direction") == ([-0.112], [0.055])


def test_a_kick_that_short_moves_give_in_part_is_that_of_a_long_one() -> None:
    """The sentence says from which length on a move kicks wholly; the table has both in units of the workshop."""
    parameters = {"saturation_m": Quantity(0.015, 0.003, "m"), "kick_um": Quantity(0.8, 0.02, "um")}
    said = _sentence("creep", None, parameters, {"kick": "direction"}, 3e-7)
    assert "(long moves from 15.0 ± 3.0 mm; after each long move 0.800 ± 0.020 um)" in said
    assert "after each move 0.8" in _sentence("creep", None, {"kick_um": parameters["kick_um"]}, {}, 3e-7)
    parameters["source_time_constant_s"] = Quantity(640.0, 90.0, "s")
    effect = Effect("creep", None, parameters, {"reference_index": 1.0002712345678}, 0.9, (), 3e-7, said, True)
    rows = effect_rows(effect, "leg")
    assert rows[0] == ("move from which on it kicks fully", "15.0", "3.0", "9.1 to 20.9", "mm")
    assert rows[2][:2] == ("time constant of the rubbing surface", "10.7")
    assert rows[2][-1] == "min"
    assert rows[3][:2] == ("reference index", "1.0002712")


def test_a_sentence_tells_what_is_not_ruled_out_and_what_is_not_sure() -> None:
    """A name tells its rivals; an amplitude below two standard uncertainties has neither size nor sign."""

    def said(
        amplitudes: list[float], spread: list[float], alike: tuple[str, ...] = (), shape: str = "any", cause: str = "a"
    ) -> str:
        trial = SimpleNamespace(shape=shape)
        found: Any = SimpleNamespace(ranked=SimpleNamespace(cause=cause, best=SimpleNamespace(trial=trial)))
        return _doubts(found, np.array(amplitudes), np.array(spread), alike)

    assert said([3.0, 0.1], [1.0, 1.0]) == ""
    assert said([0.1, 0.1], [1.0, 1.0], shape="") == ""
    assert said([1.6, -1.7], [1.0, 1.0], shape="periodic") == ""
    assert "neither its size nor its sign is sure" in said([-1.9, 0.1], [1.0, 1.0])
    assert said([3.0], [1.0], ("hidden-heat", "creep")) == "; not ruled out by these data: hidden-heat, creep"
    assert "with the wrong sign" in said([-0.5], [0.1], cause="air-refraction")
    assert said([0.5], [0.1], cause="air-refraction") == ""
