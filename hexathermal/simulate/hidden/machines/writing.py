"""A campaign of a hexapod that hides something, as a folder; its answer stands beside it, never in it."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from hexathermal.machine.writing import write_hexapod
from hexathermal.poses import FloatArray
from hexathermal.simulate.campaign_writing import (
    HEXAPOD_FILE,
    HEXAPOD_TITLE,
    HexapodTable,
    hexapod_columns,
    hexapod_form,
    write_folder,
)
from hexathermal.simulate.hidden.machines.drawing import MachineAnswer
from hexathermal.simulate.hidden.machines.physics import Heat, measured, read_heats
from hexathermal.simulate.hidden.machines.truth import MachineRunTruth, MachineTruth
from hexathermal.simulate.hidden.writing import write_answer

ANSWER_FORMAT = "hexathermal-hidden-machine-answer/1"


def write_machine_campaign(
    folder: str | Path, truth: MachineTruth, answer: MachineAnswer, *, force: bool = False
) -> Path:
    """Write ``folder`` (the campaign) and ``folder.answer.json`` beside it; returns the latter's path.

    Raises
    ------
    ArgumentError
        The folder holds something else, or a campaign without `force`, or cannot be written.
    """
    shown = np.split(measured(truth), np.cumsum([run.time.size for run in truth.runs])[:-1])
    parts = zip(truth.runs, read_heats(truth), shown, strict=True)
    tables = (hexapod_columns(table_of(truth, run, read, poses)) for run, read, poses in parts)
    form = hexapod_form(truth.runs, title=HEXAPOD_TITLE, zero=truth.zero)
    write_folder(
        folder, form, tables, force=force, beside={HEXAPOD_FILE: lambda path: write_hexapod(truth.hexapod, path)}
    )
    return write_answer(folder, machine_answer_data(answer))


def table_of(truth: MachineTruth, run: MachineRunTruth, read: Heat, poses: FloatArray) -> HexapodTable:
    """Return what is recorded of a run, whose readings and measured coordinates (n, 6) [m, rad] are given."""
    temperatures = {
        f"leg{leg + 1}_{sensor}": read.legs[:, leg, k] for leg in range(6) for k, sensor in enumerate(truth.sensors)
    }
    for k, part in enumerate(("platform", "base")):
        if truth.plates_recorded[k]:
            temperatures[f"{part}_T1"] = read.plates[:, k]
    air = run.air + run.air_errors if truth.air_recorded else None
    return HexapodTable(run.time - run.time[0], _told(run.commanded), run.q, temperatures, air, _told(poses))


def _told(coordinates: FloatArray) -> FloatArray:
    """Return coordinates [m, rad] as controllers speak [mm, deg]."""
    return np.hstack([coordinates[:, :3] * 1e3, np.degrees(coordinates[:, 3:])])


def machine_answer_data(answer: MachineAnswer) -> dict[str, Any]:
    """Return an answer as plain values; `parameters` in SI units."""
    data = asdict(answer)
    judged = data.pop("oracle")
    data["oracle"] = {
        f"{kind}_{what}_{unit}": value * 1e6 if np.isfinite(value) else None
        for what, distances in judged.items()
        for (kind, value), unit in zip(distances.items(), ("um", "urad"), strict=True)
    }
    return {"format": ANSWER_FORMAT, **data, "parameters": [dict(item) for item in answer.parameters]}
