"""Campaigns of the hidden-effects generator, read back from their folders as the diagnosis reads them."""

from __future__ import annotations

import csv
from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest

from hexathermal.learn.campaign_files import load_campaign
from hexathermal.learn.diagnosis import feigning, mending
from hexathermal.learn.diagnosis.course import Course, base_law, searched
from hexathermal.learn.diagnosis.deciding import decided
from hexathermal.learn.diagnosis.evidence import LEAST
from hexathermal.learn.diagnosis.stage import Stage, view_of
from hexathermal.learn.diagnosis.tolerating import tolerant
from hexathermal.learn.diagnosis.view import View
from hexathermal.learn.signals import campaign_rows
from hexathermal.machine.leg_signals import LegSignals
from hexathermal.poses import FloatArray
from hexathermal.simulate.hidden.drawing import Answer, campaign_of
from hexathermal.simulate.hidden.writing import write_campaign

MOST_KEPT = 8
"""Views keep all that was ever made of them: a hundred of them fill a machine."""


@lru_cache(maxsize=MOST_KEPT)
def viewed(bench: str, seed: int, causes: tuple[str, ...], strength: float) -> tuple[View, Answer]:
    """The runs for identification of a campaign, from its files, and its answer."""
    truth, answer = campaign_of(bench, seed, causes=causes, strength=strength)
    with TemporaryDirectory() as place:
        folder = Path(place) / "campaign"
        write_campaign(folder, truth, answer)
        campaign = load_campaign(folder)
        return view_of(campaign, campaign_rows(campaign, "identification"), answer.base), answer


def course_of(folder: Path, bench: str, seed: int, causes: tuple[str, ...], strength: float) -> Course:
    """The course of a diagnosis of a campaign that is written into a folder and read back."""
    truth, answer = campaign_of(bench, seed, causes=causes, strength=strength)
    write_campaign(folder, truth, answer)
    campaign = load_campaign(folder)
    rows = campaign_rows(campaign, "identification")
    return searched(campaign, base_law(campaign, rows, answer.base, None), rows)


def first_name(view: View) -> str | None:
    """The cause that is named first, or what is nameless."""
    leader = decided(tolerant(Stage(view), LEAST).step, LEAST).leader
    return None if leader is None else leader.cause


def nothing_shared(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let the null of views made from now on know no error that all thermometers share."""
    monkeypatch.setattr(feigning, "common_error", lambda _view: None)
    monkeypatch.setattr(mending, "doubted_alike", lambda own: [np.zeros((len(one), 0)) for one in own.signals])


def altered(view: View, sensor: str, change: Callable[[int, LegSignals], FloatArray]) -> View:
    """The view with a sensor's readings changed by ``change(run number, signals) -> array``."""
    runs = []
    for k, rows in enumerate(view.runs):
        values = change(k, rows.signals)
        runs.append(replace(rows, signals=replace(rows.signals, dT={**rows.signals.dT, sensor: values})))
    return replace(view, runs=tuple(runs))


def rewritten(file: Path, change: Callable[[list[dict[str, str]]], None]) -> None:
    """Write a run's table anew after its rows, values by column as text, were changed in place."""
    with file.open(newline="") as lines:
        rows = list(csv.DictReader(lines))
    change(rows)
    with file.open("w", newline="") as lines:
        table = csv.DictWriter(lines, list(rows[0]))
        table.writeheader()
        table.writerows(rows)
