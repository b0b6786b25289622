"""Causes in forms that a law's first sketch does not have are named too, and what slips where it stands is nobody's."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from hexathermal.learn.diagnosis import course
from hexathermal.learn.diagnosis.course import _later
from hexathermal.learn.diagnosis.deciding import FAR, NEARLY, Decision, decided
from hexathermal.learn.diagnosis.joining import Found
from hexathermal.learn.diagnosis.ranking import Ranked, Step
from hexathermal.learn.diagnosis.stage import Stage
from hexathermal.learn.diagnosis.view import View
from hexathermal.learn.interferometer import index_along_run
from hexathermal.poses import FloatArray
from tests.learn.diagnosis.campaigns import viewed
from tests.learn.diagnosis.test_evidence import ranked, step

THRESHOLD = 6.0


def with_drift(view: View, added: list[FloatArray], strength: float) -> View:
    """A view in whose runs something is added to the drift, `strength` times the noise, RMS."""
    size = strength * Stage(view).levels.rms / np.concatenate(added).std()
    runs = [replace(rows, drift=rows.drift + size * own) for rows, own in zip(view.runs, added, strict=True)]
    return replace(view, runs=tuple(runs))


def low_pass(time: FloatArray, values: FloatArray, tau: float) -> FloatArray:
    """A first-order low pass row by row, at rest in the first one."""
    out = values.copy()
    for k in range(1, len(out)):
        out[k] = out[k - 1] + (1.0 - np.exp(-(time[k] - time[k - 1]) / tau)) * (values[k] - out[k - 1])
    return out


def cubes(view: View) -> list[FloatArray]:
    """Warming to the third power, with the length."""
    sensor = view.base[0]
    return [(s.retracted_length + 0.5 * s.q) * s.dT[sensor] ** 3 for s in (rows.signals for rows in view.runs)]


def tube(view: View) -> list[FloatArray]:
    """The index of air of the dead path, which follows the station's by seven minutes."""
    found = []
    for rows in view.runs:
        assert rows.weather is not None
        index = index_along_run(rows.weather)
        found.append(low_pass(rows.signals.time, index - index[0], 420.0))
    return found


def long_reversals(view: View) -> list[FloatArray]:
    """A reversal that takes 6 mm of the rod to become whole, by an exponential."""
    found = []
    for rows in view.runs:
        turned, out = 0.0, []
        for way in np.diff(rows.signals.q, prepend=rows.signals.q[0]):
            turned = np.sign(way) + (turned - np.sign(way)) * np.exp(-abs(way) / 0.006) if abs(way) > 5e-6 else turned
            out.append(turned)
        found.append(np.asarray(out))
    return found


def warm_screw(view: View) -> list[FloatArray]:
    """Heat of speed in a screw, behind twenty minutes, which acts on what is out of the nut."""
    found, least = [], float(view.q.min()) - 0.6 * float(np.ptp(view.q))
    for rows in view.runs:
        speed = np.abs(np.gradient(rows.signals.q, rows.signals.time))
        out = low_pass(rows.signals.time, speed, 1200.0) * (rows.signals.q - least)
        found.append(out - out[0])
    return found


def slipping(view: View) -> list[FloatArray]:
    """A part that slips at a rate that goes with the displacement."""
    return [np.cumsum(rows.signals.q * np.gradient(rows.signals.time)) for rows in view.runs]


@pytest.mark.long
@pytest.mark.parametrize(
    ("made", "cause", "setting"),
    [(cubes, "nonlinear-expansion", None), (tube, "air-refraction", "time_constant_s"),
     (long_reversals, "backlash", "play_m"), (warm_screw, "hidden-heat", "ratio")],
)  # fmt: skip
def test_a_further_form_is_named(made: Any, cause: str, setting: str | None) -> None:
    """A cube of the warming, air in a tube, a reversal that takes millimetres, warm screw: by name, in that form."""
    view, _ = viewed("quiet", 2, (), 1.0)
    leader = decided(Stage(with_drift(view, made(view), 1.5)).step, THRESHOLD).leader
    assert leader is not None
    assert leader.cause == cause
    assert (leader.best.trial.shape == "cube") if setting is None else (setting in leader.best.trial.parameters)


def worn_outwards(view: View) -> list[FloatArray]:
    """A screw that wears all along the campaign, the more, the farther out its nut works."""
    found, way = [], 0.0
    for rows, piece in zip(view.runs, view.pieces, strict=True):
        ways = way + np.cumsum(np.abs(np.diff(rows.signals.q, prepend=rows.signals.q[0])))
        way = float(ways[-1])
        out = ways * rows.signals.q
        found.append(out - out[piece.used[0]])
    return found


def swelling(view: View) -> list[FloatArray]:
    """A part that swells with the humidity behind four hours, on its way from another one when a run begins."""
    found = []
    for k, rows in enumerate(view.runs):
        assert rows.weather is not None
        time, humidity = rows.signals.time, rows.weather[:, 2]
        before = 0.01 * (-1.0) ** k * np.exp(-(time - time[0]) / 14400.0)
        out = low_pass(time, humidity, 14400.0) + before
        found.append(out - out[view.pieces[k].used[0]])
    return found


@pytest.mark.long
@pytest.mark.parametrize(
    ("made", "what"),
    [(slipping, "the time at each displacement"), (worn_outwards, "the way travelled"), (swelling, "the humidity")],
)
def test_what_no_cause_explains_has_no_name(made: Any, what: str) -> None:
    """A rate that goes with the displacement, wear that grows outwards, a part that swells: real, and unexplained."""
    view, _ = viewed("quiet", 2, (), 1.0)
    decision = decided(Stage(with_drift(view, made(view), 1.5)).step, THRESHOLD)
    assert decision.leader is not None
    assert decision.leader.cause == f"follows {what}"


def doubted(cause: str, value: float, gated: float) -> Ranked:
    """A cause of which so much counts against nothing."""
    item = ranked(cause, value)
    return replace(item, best=replace(item.best, trial=replace(item.best.trial, doubt=value - gated)))


@pytest.mark.parametrize(
    ("gated", "lead", "named"),
    [(NEARLY + 0.05, FAR + 1.0, True), (NEARLY - 0.05, FAR + 1.0, False), (NEARLY + 0.05, FAR - 1.0, False)],
)
def test_a_name_far_ahead_of_what_has_none_stands_with_it(gated: float, lead: float, named: bool) -> None:
    """Something nameless shows that there is something: a name far ahead needs a little less against nothing."""
    nameless = ranked("follows time (a rhythm)", THRESHOLD + 1.0, columns=4)
    name = doubted("frame-expansion", nameless.value + lead, gated * THRESHOLD)
    decision = decided(step(nameless, name), THRESHOLD)
    assert decision.named == named
    assert decision.leader is not None


@pytest.mark.parametrize(("pays", "then"), [(True, "creep"), (False, "scale-error")])
def test_what_mops_up_a_shape_hides_no_other_cause(monkeypatch: pytest.MonkeyPatch, pays: bool, then: str) -> None:
    """Creep beside backlash that runs left out deny is passed over for the next; a cause that pays is the next."""
    monkeypatch.setattr(course, "worth", lambda *_stages, later: (pays, pays))
    first = Found(ranked("backlash", 1000.0), Decision(None, 1.0, {}, ()), True, np.zeros(1), np.zeros(1))
    order: Step = step(ranked("creep", 80.0), ranked("scale-error", 60.0))
    stage = cast("Stage", SimpleNamespace(step=order, with_effect=lambda _best: None))
    leader = _later(stage, [first], THRESHOLD).leader
    assert leader is not None
    assert leader.cause == then
