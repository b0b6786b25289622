"""A cause that someone adds is one module; its term may have a shape of its own."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import hexathermal as ht
from hexathermal.learn.campaign_files import load_campaign
from hexathermal.learn.diagnosis import diagnose
from hexathermal.learn.diagnosis.causes import catalogue
from hexathermal.learn.diagnosis.trials import Cause, Trial, Workbench
from hexathermal.machine.leg_signals import LegSignals, Memory
from hexathermal.machine.leg_terms import SHAPES
from hexathermal.poses import FloatArray
from hexathermal.simulate.hidden.drawing import campaign_of
from hexathermal.simulate.hidden.writing import write_campaign

NAME, SHAPE = "sagging", "hollow"
SIZE = 20e-6


def hollow(signals: LegSignals, parameters: Mapping[str, Any], memory: Memory) -> FloatArray:
    """A parabola of the displacement less its first value [m^2]."""
    found = signals.q**2
    return np.asarray(found - memory.first("hollow", found))


def trials(bench: Workbench) -> Iterator[Trial]:
    """Give the parabola."""
    yield Trial(NAME, bench.view.columns(SHAPE, {}), None, SHAPE, {})


@pytest.mark.long
def test_a_new_cause_with_a_shape_of_its_own_is_named_and_joins_the_law(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Nothing but the module and the shape is needed: it is found, told, and its law is read back as it was written."""
    cause = Cause(
        NAME, "The guide sags.", "A parabola of the displacement.", (), ("scale-error",), "Turn it over.", "it sags"
    )
    monkeypatch.setitem(SHAPES, SHAPE, hollow)
    monkeypatch.setitem(catalogue(), NAME, SimpleNamespace(CAUSE=cause, trials=trials))
    truth, answer = campaign_of("quiet", 12, causes=())
    runs = tuple(replace(run, effect=run.effect + SIZE * (run.q**2 - run.q[0] ** 2)) for run in truth.runs)
    write_campaign(tmp_path / "leg", truth.changed(runs=runs), answer)
    found = diagnose(load_campaign(tmp_path / "leg"), answer.base)
    assert found.cause == NAME
    assert found.to_json()["parameters"]["amplitude_1_um"]["value"] == pytest.approx(1e6 * SIZE, rel=0.2)
    ht.write_leg_law(found.extended, tmp_path / "leg.toml")
    assert ht.read_leg_law(tmp_path / "leg.toml").terms == found.extended.terms
