"""A campaign that hides something, as a folder; its answer stands beside it, never in it."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from hexathermal.poses import FloatArray
from hexathermal.simulate.bench.interferometers import index_of_air
from hexathermal.simulate.campaign_writing import FORMAT, run_entries, write_folder
from hexathermal.simulate.hidden.beams import AZIMUTHS, RADIUS
from hexathermal.simulate.hidden.drawing import Answer
from hexathermal.simulate.hidden.strength import recorded
from hexathermal.simulate.hidden.truth import CampaignTruth, RunTruth

ANSWER_FORMAT = "hexathermal-hidden-answer/1"
WAVELENGTH = 632.99e-9
Column: TypeAlias = tuple[npt.NDArray[Any], int]
TITLES = {"leg": "Leg test bench: thermal expansion", "component": "Machine: thermal drift"}


def campaign_form(truth: CampaignTruth) -> dict[str, Any]:
    """Return what `campaign.toml` says; nothing in it tells that something is hidden."""
    form: dict[str, Any] = {"format": FORMAT, "kind": truth.kind, "title": TITLES[truth.kind], "zero": truth.zero}
    if truth.kind == "leg":
        form["leg"] = {"q0_mm": _mm(truth.retracted_length), "stroke_mm": [_mm(edge) for edge in truth.stroke]}
        form["interferometer"] = {
            "radius_mm": _mm(RADIUS),
            "azimuth_deg": [round(float(np.degrees(azimuth)), 6) for azimuth in AZIMUTHS],
            "dead_path_mm": _mm(truth.dead_path),
            "index_compensated": truth.index_compensated,
        }
    form["thermocouples"] = [
        {"name": name}
        | ({"part": part} if part else {})
        | ({"position_mm": _mm(float(position))} if np.isfinite(position) else {})
        for name, part, position in zip(truth.sensors, truth.parts, truth.positions, strict=True)
    ]
    if truth.input_names:
        form["inputs"] = [{"name": name} for name in truth.input_names]
    form["runs"] = run_entries(truth.runs, parquet=False)
    return form


def _mm(metres: float) -> float:
    """Return metres as millimetres."""
    return round(metres * 1e3, 6)


def beams(truth: CampaignTruth, run: RunTruth) -> FloatArray:
    """Return what three beams show of a run since its first row, shape (n, 3) [m]."""
    drift = run.drift + run.effect + run.noise
    moved = (run.q + drift)[:, None] + run.beam_effects
    moved = moved - moved[0]
    if truth.index_compensated:
        return np.asarray(moved)
    index = index_of_air(WAVELENGTH, *run.air.T)[:, None]
    path = truth.dead_path + run.q[0]
    return np.asarray(((path + moved) * index - path * index[0]) / index[0])


def _to_steps(values: FloatArray, step: float) -> FloatArray:
    """Return values in whole steps; 0: as they are."""
    return np.round(values / step) * step if step > 0.0 else values


def run_columns(truth: CampaignTruth, run: RunTruth) -> dict[str, Column]:
    """Return the columns of a run's table, each with its decimals."""
    notes: Mapping[str, Any] = truth.notes
    step = float(notes.get("temperature_resolution_K", 0.0))
    digits = 3 if step == 0.0 else max(3, int(np.ceil(-np.log10(step))))
    read = _to_steps(recorded(run), step)
    heat = {f"{name}_degC": (read[:, k], digits) for k, name in enumerate(truth.sensors)}
    place = {"q_mm": (run.q * 1e3, 5)} | ({"settled": (run.settled * 1.0, 0)} if notes.get("tells_rests", True) else {})
    inputs = {name: (run.inputs[:, k], 3) for k, name in enumerate(truth.input_names)}
    whole = bool((run.time == np.round(run.time)).all())
    columns: dict[str, Column] = {"time_s": (run.time, 0 if whole else 3)}
    if truth.kind == "leg":
        shown = beams(truth, run)
        columns |= place | heat | {f"beam{k + 1}_mm": (shown[:, k] * 1e3, 6) for k in range(3)} | inputs
    else:
        first = run if truth.zero == "run" else truth.runs[0]
        drift = (run.drift + run.effect - first.effect[0] + run.noise) * 1e6
        drift = _to_steps(drift, float(notes.get("drift_resolution_um", 0.0)))
        stroke = any(np.ptp(one.q) > 0.0 for one in truth.runs)
        columns |= inputs | (place if stroke else {}) | heat | {"drift_um": (drift, 4)}
    names = ("air_temperature_degC", "air_pressure_hPa", "air_humidity_percent")
    air: FloatArray = run.air * np.array([1.0, 1e-2, 1e2])
    recorded_air = [k for k in range(3) if np.isfinite(air[:, k]).any()]
    return columns | {names[k]: (air[:, k], (2, 2, 1)[k]) for k in recorded_air if names[k] not in heat}


def write_campaign(folder: str | Path, truth: CampaignTruth, answer: Answer, *, force: bool = False) -> Path:
    """Write ``folder`` (the campaign) and ``folder.answer.json`` beside it; returns the latter's path.

    Raises
    ------
    ArgumentError
        The folder holds something else, or a campaign without `force`, or cannot be written.
    """
    write_folder(folder, campaign_form(truth), (run_columns(truth, run) for run in truth.runs), force=force)
    return write_answer(folder, answer_data(answer))


def write_answer(folder: str | Path, data: Mapping[str, Any]) -> Path:
    """Write what a campaign's folder hides beside it; returns the file's path."""
    file = Path(folder).with_name(f"{Path(folder).name}.answer.json")
    file.write_text(json.dumps(data, indent=2, allow_nan=False) + "\n", encoding="utf-8")
    return file


def answer_data(answer: Answer) -> dict[str, Any]:
    """Return an answer as plain values; `parameters` in SI units."""
    data = asdict(answer)
    judged = data.pop("oracle")
    data["noise_um"] = data.pop("noise") * 1e6
    data["shared_K"] = data.pop("shared")
    data["oracle"] = {f"rmse_{name}_um": value * 1e6 if np.isfinite(value) else None for name, value in judged.items()}
    return {"format": ANSWER_FORMAT, **data, "parameters": [dict(item) for item in answer.parameters]}
