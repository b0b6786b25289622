"""What a simulated machine truly was, for a file of its own: never for the campaign's folder. SI units."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from hexathermal.poses import FloatArray, pose_from_coordinates
from hexathermal.predict.pose_errors import pose_errors
from hexathermal.simulate.bench.thermocouples import MountedThermocouples
from hexathermal.simulate.machine.machine import VirtualMachine
from hexathermal.simulate.machine.runs import MachineRun, mounted_thermometers

FORMAT = "hexathermal-machine-truth/1"


def homogeneous_laws(machine: VirtualMachine) -> FloatArray:
    """Return A and B of each leg where it is warm all over, exactly, shape (6, 2) [1/K]."""
    model = machine.hexapod.thermal
    if machine.growth == "law" and model is not None:
        return np.array([[law.A.sum(), law.B.sum()] for law in model.legs])
    found = np.empty((6, 2))
    for i, leg in enumerate(machine.heat.legs):
        cold = np.zeros(leg.size)
        low, high = (float(leg.growth(cold[None] + 1.0, np.array([q]), cold)[0]) for q in (0.0, leg.stroke[1]))
        B = (high - low) / leg.stroke[1]
        found[i] = (low - B * machine.lowest[i]) / machine.retracted[i], B
    return found


def effective_laws(
    machine: VirtualMachine, runs: Sequence[MachineRun], thermometers: MountedThermocouples | None = None
) -> FloatArray:
    """Return A and B of each leg that fit the true growth best from the temperature at its first thermometer.

    Least squares with a constant for each leg and run; shape (6, 2) [1/K].

    Parameters
    ----------
    machine : VirtualMachine
    runs : sequence of MachineRun
    thermometers : MountedThermocouples, optional
        Temperatures as these read them, without noise and bias (contact, gain): what a campaign can find. Default: the
        true temperatures of the surfaces.
    """
    found = np.empty((6, 2))
    count = len(machine.sensors)
    surfaces = [machine.surfaces(run.truth.history) for run in runs]
    if thermometers is not None:
        surfaces = [thermometers.quiet(one, run.air) for one, run in zip(surfaces, runs, strict=True)]
    for i in range(6):
        columns, growths = [], []
        for surface, run in zip(surfaces, runs, strict=True):
            T, growth = surface[:, count * i], run.truth.growth[:, i]
            X = np.column_stack([machine.retracted[i] * (T - 20.0), run.truth.q[:, i] * (T - 20.0)])
            columns.append(X - X.mean(axis=0))
            growths.append(growth - growth.mean())
        found[i] = np.linalg.lstsq(np.concatenate(columns), np.concatenate(growths), rcond=None)[0]
    return found


def machine_truth(machine: VirtualMachine, seed: int, runs: Sequence[MachineRun]) -> dict[str, Any]:
    """Return what a campaign was made of, ready for JSON.

    Parameters
    ----------
    machine : VirtualMachine
    seed : int
    runs : sequence of MachineRun
        All runs; the effective laws are those of the runs for identification.
    """
    laws = homogeneous_laws(machine)
    fitted = [run for run in runs if run.role == "identification"]
    thermometers = mounted_thermometers(machine, seed)
    effective, as_read = (effective_laws(machine, fitted or list(runs), one) for one in (None, thermometers))
    return {
        "format": FORMAT,
        "seed": seed,
        "growth": machine.growth,
        "legs": [
            {"homogeneous": {"A_per_K": float(a), "B_per_K": float(b)},
             "effective": {"A_per_K": float(c), "B_per_K": float(d)},
             "as_read": {"A_per_K": float(e), "B_per_K": float(f)}, "parameters": asdict(leg)}
            for (a, b), (c, d), (e, f), leg in zip(laws, effective, as_read, machine.heat.legs, strict=True)
        ],
        "platform": asdict(machine.heat.platform),
        "base": asdict(machine.heat.base),
        "tracker": asdict(machine.tracker),
        "thermometers": {
            name: {"offset_K": float(offset), "gain": float(gain), "contact_error": float(contact)}
            for name, offset, gain, contact in zip(
                machine.columns, thermometers.offset, thermometers.gain, thermometers.contact_error, strict=True)
        },
        "runs": [_run_truth(machine, run) for run in runs],
    }  # fmt: skip


def _run_truth(machine: VirtualMachine, run: MachineRun) -> dict[str, Any]:
    """Return the true course of a run."""
    wanted = pose_from_coordinates(run.commanded, hexapod=machine.hexapod)
    return {
        "name": run.name,
        "role": run.role,
        "frame_m_rad": run.frame.tolist(),
        "growth_um": (run.truth.growth * 1e6).round(5).tolist(),
        "pose_error_um_urad": (pose_errors(wanted, run.truth.poses) * 1e6).round(5).tolist(),
        "platform_expansion_um_per_m": (run.truth.expansions[:, 0] * 1e6).round(6).tolist(),
        "base_expansion_um_per_m": (run.truth.expansions[:, 1] * 1e6).round(6).tolist(),
    }


def machine_run_summary(machine: VirtualMachine, run: MachineRun) -> dict[str, Any]:
    """Return a run in numbers, from what is written of it alone."""
    home = machine.hexapod
    wanted, seen = (pose_from_coordinates(six, hexapod=home) for six in (run.commanded, run.measured))
    errors = pose_errors(wanted, seen)
    shift, turn = np.linalg.norm(errors[:, :3], axis=1), np.linalg.norm(errors[:, 3:], axis=1)
    rise = run.temperatures - run.temperatures[0]
    return {
        "name": run.name,
        "role": run.role,
        "hours": float(run.time[-1] / 3600.0),
        "poses": int(run.time.size),
        "largest_leg_rise_K": round(float(rise[:, :-2].max()), 3),
        "largest_platform_rise_K": round(float(rise[:, -2].max()), 3),
        "largest_base_rise_K": round(float(rise[:, -1].max()), 3),
        "largest_shift_um": round(float(shift.max()) * 1e6, 3),
        "largest_turn_urad": round(float(turn.max()) * 1e6, 3),
        "rms_shift_um": round(float(np.sqrt((shift**2).mean())) * 1e6, 3),
        "rms_turn_urad": round(float(np.sqrt((turn**2).mean())) * 1e6, 3),
    }
