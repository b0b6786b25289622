"""A plan carried out on a virtual machine and diagnosed from its files: it names what random choices leave open."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import hexathermal as ht
from hexathermal.learn.machine_diagnosis.candidate import called
from hexathermal.learn.machine_diagnosis.diagnosing import diagnose_machine
from hexathermal.learn.machine_diagnosis.planner import joined
from hexathermal.learn.machine_diagnosis.planning import next_experiment
from hexathermal.learn.machine_diagnosis.result import MachineDiagnosis
from hexathermal.learn.machine_diagnosis.view import MachineView, planned_view
from hexathermal.machine.writing import write_hexapod
from hexathermal.simulate.campaign_writing import (
    HEXAPOD_FILE,
    HexapodTable,
    hexapod_columns,
    hexapod_form,
    write_folder,
)
from hexathermal.simulate.hidden.machines.physics import measured
from hexathermal.simulate.hidden.machines.truth import MachineRunTruth
from tests.learn.hexapods import NOISE
from tests.learn.machine_diagnosis.planned import BASE, PLATFORM, chosen, lawful, random_plan, truth_of, usual_noise

PARTS = (PLATFORM, BASE)
GROWTH, SLOTS = 2e-6, 20


def small_moves(rng: np.random.Generator) -> tuple[MachineView, np.ndarray]:
    """A campaign of small moves about home in which everything warms alike."""
    six = np.round(rng.uniform(-1.0, 1.0, (60, 6)) * [5.0, 5.0, 5.0, 0.5, 0.5, 0.5], 4)
    rise, hexapod = 5.0 * np.linspace(0.0, 1.0, 60), lawful()
    view = planned_view(
        hexapod, ht.pose_from_coordinates(six, hexapod=hexapod), np.repeat(rise[:, None, None], 6, axis=1),
        plates=np.repeat(rise[:, None], 2, axis=1), air=rise,
    )  # fmt: skip
    return view, six


def recorded(run: MachineRunTruth, measured: np.ndarray) -> HexapodTable:
    """What is written of a run: thermometers read without error."""
    heat = {f"leg{leg + 1}_T1": run.legs[:, leg, 0] for leg in range(6)}
    heat |= {f"{part}_T1": run.plates[:, k] for k, part in enumerate(("platform", "base"))}
    told = [1e3] * 3 + [180.0 / np.pi] * 3
    return HexapodTable(run.time, run.commanded * told, run.q, heat, run.air, measured * told)


def diagnosed(
    folder: Path, view: MachineView, six: np.ndarray, part: int, rng: np.random.Generator
) -> MachineDiagnosis:
    """What is told of the files of a machine whose plate grows otherwise than its file says."""
    truth = truth_of(view, six)
    expansions = truth.expansions.copy()
    expansions[part] += GROWTH
    noisy = [run.changed(noise=NOISE * rng.standard_normal((run.time.size, 6))) for run in truth.runs]
    truth = truth.changed(expansions=expansions, runs=tuple(noisy))
    shown = np.split(measured(truth), np.cumsum([run.time.size for run in truth.runs])[:-1])
    tables = (hexapod_columns(recorded(run, poses)) for run, poses in zip(truth.runs, shown, strict=True))
    form = hexapod_form(truth.runs, title="plan", zero=truth.zero)
    write_folder(folder, form, tables, beside={HEXAPOD_FILE: lambda path: write_hexapod(truth.hexapod, path)})
    return diagnose_machine(ht.load_campaign(folder))


def lead(found: MachineDiagnosis, part: int) -> float:
    """By how much log evidence the true plate leads every other cause of the ranking."""
    own = [one.evidence for one in found.candidates if one.target == PARTS[part].partition("-")[0]]
    other = [one.evidence for one in found.candidates if one.cause not in PARTS[part]]
    return max(own, default=0.0) - max([0.0, *other])


@pytest.mark.long
def test_the_plan_names_the_plate_that_random_choices_leave_open(rng: np.random.Generator, tmp_path: Path) -> None:
    """After small moves of a machine that warms all over, the planned run names the true plate alone, whichever it is;
    the lead over all other causes is more than twice that of random poses and scenarios, mean of two.
    """
    known, six = small_moves(rng)
    sizes = {name: np.array([GROWTH]) for name in PARTS}
    plan = next_experiment(known, chosen(known, *PARTS), usual_noise(), slots=SLOTS, amplitudes=sizes)
    for part, name in enumerate(PARTS):
        both, where = joined([known, plan.view]), np.concatenate([six, plan.coordinates])
        found = diagnosed(tmp_path / f"plan-{part}", both, where, part, rng)
        assert (found.verdict, called(str(found.cause), found.effects[0].target)) == ("effect", name)
        assert not found.effects[0].equivalent
        others = []
        for draw in range(2):
            view, poses = random_plan(known, SLOTS, rng)
            both = joined([known, view])
            folder = tmp_path / f"random-{part}-{draw}"
            others.append(lead(diagnosed(folder, both, np.concatenate([six, poses]), part, rng), part))
        assert lead(found, part) > 2.0 * max(float(np.mean(others)), 0.0)
