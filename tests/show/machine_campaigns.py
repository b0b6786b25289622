"""Small campaigns of a virtual hexapod, as files, with one thing wrong or nothing."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np

import hexathermal as ht
from hexathermal.learn.machine_diagnosis.view import MachineView, planned_view
from hexathermal.machine.writing import write_hexapod
from hexathermal.simulate.campaign_writing import HEXAPOD_FILE, hexapod_columns, hexapod_form, write_folder
from hexathermal.simulate.hidden.machines.physics import measured
from hexathermal.simulate.hidden.machines.truth import MachineTruth
from tests.learn.hexapods import NOISE
from tests.learn.machine_diagnosis.planned import lawful, truth_of
from tests.learn.machine_diagnosis.test_plan_diagnosed import recorded

ROWS = 40
SMALL, WIDE = np.array([5.0, 5.0, 5.0, 0.5, 0.5, 0.5]), np.array([30.0, 30.0, 30.0, 4.0, 4.0, 4.0])
"""Moves about home [mm, deg]."""


def moved(rng: np.random.Generator, moves: np.ndarray, runs: int, *, alike: bool) -> tuple[MachineView, np.ndarray]:
    """Return runs of random poses in which everything warms alike, or each part by itself; and the poses."""
    hexapod, n = lawful(), runs * ROWS
    six = np.round(rng.uniform(-1.0, 1.0, (n, 6)) * moves, 4)

    def course() -> np.ndarray:
        """One part's warming in all runs."""
        t = np.linspace(0.0, 1.0, ROWS)
        return np.concatenate([rng.uniform(2.0, 5.0) * np.sin(rng.uniform(1.5, 6.0) * t) for _ in range(runs)])

    parts = np.repeat(course()[:, None], 9, axis=1) if alike else np.column_stack([course() for _ in range(9)])
    view = planned_view(
        hexapod, ht.pose_from_coordinates(six, hexapod=hexapod), parts[:, :6, None], plates=parts[:, 6:8],
        air=parts[:, 8], run=np.repeat(np.arange(runs), ROWS), time=np.tile(60.0 * np.arange(ROWS), runs),
    )  # fmt: skip
    return view, six


def written(
    folder: Path, rng: np.random.Generator, view: MachineView, six: np.ndarray,
    fault: Callable[[MachineTruth], MachineTruth] = lambda truth: truth, held: int = 0,
) -> Path:  # fmt: skip
    """Write a campaign whose last `held` runs are for validation; returns its folder."""
    truth = fault(truth_of(view, six))
    runs = [
        run.changed(
            noise=NOISE * rng.standard_normal((run.time.size, 6)),
            role="validation" if k >= len(truth.runs) - held else "identification",
        )
        for k, run in enumerate(truth.runs)
    ]
    truth = truth.changed(runs=tuple(runs))
    shown = np.split(measured(truth), np.cumsum([run.time.size for run in runs])[:-1])
    tables = (hexapod_columns(recorded(run, poses)) for run, poses in zip(runs, shown, strict=True))
    form = hexapod_form(truth.runs, title="drawn <b>", zero=truth.zero)
    write_folder(folder, form, tables, beside={HEXAPOD_FILE: lambda path: write_hexapod(truth.hexapod, path)})
    return folder


def growing(platform: float) -> Callable[[MachineTruth], MachineTruth]:
    """A platform that grows otherwise than its file says, by so much [1/K]."""
    return lambda truth: truth.changed(expansions=truth.expansions + [platform, 0.0])


def other_leg(leg: int, change: float) -> Callable[[MachineTruth], MachineTruth]:
    """A leg whose A differs from its law by so much [1/K]; counted from 0."""

    def wrong(truth: MachineTruth) -> MachineTruth:
        """Change one leg."""
        A = truth.A.copy()
        A[leg] += change
        return truth.changed(A=A)

    return wrong
