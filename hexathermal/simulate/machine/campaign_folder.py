"""A simulated campaign of a whole machine as a folder: nothing in it tells that no machine stood behind it."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path

from hexathermal.errors import ArgumentError
from hexathermal.machine.hexapod import Hexapod
from hexathermal.machine.writing import write_hexapod
from hexathermal.simulate.campaign_writing import (
    HEXAPOD_FILE,
    HEXAPOD_TITLE,
    Columns,
    HexapodTable,
    hexapod_columns,
    hexapod_form,
    write_folder,
)
from hexathermal.simulate.machine.machine import VirtualMachine
from hexathermal.simulate.machine.runs import MachinePlan, MachineRun

ZEROS = ("campaign", "run")


def machine_run_columns(machine: VirtualMachine, run: MachineRun) -> Columns:
    """Return the columns of a run's table, each with its decimals."""
    recorded = dict(zip(machine.recorded_columns, run.temperatures.T, strict=True))
    temperatures = {name: recorded[name] for name in machine.columns}
    return hexapod_columns(HexapodTable(run.time, run.commanded, run.q, temperatures, run.air, run.measured))


def told_hexapod(machine: VirtualMachine) -> Hexapod:
    """Return the machine as the campaign's folder tells of it: without a law where its thermometers are others."""
    return machine.hexapod if machine.law_told else replace(machine.hexapod, thermal=None)


def write_machine_campaign(
    folder: str | Path,
    machine: VirtualMachine,
    plans: tuple[MachinePlan, ...],
    runs: Iterable[MachineRun],
    *,
    title: str = HEXAPOD_TITLE,
    zero: str = "campaign",
    parquet: bool = False,
    force: bool = False,
) -> tuple[Path, ...]:
    """Write a campaign folder of kind ``"hexapod"``, whole or not at all; returns the paths of its files.

    Parameters
    ----------
    folder : str or Path
        Created; its parent must exist.
    machine : VirtualMachine
        Its nominal `Hexapod` is written as `hexapod.toml` beside the campaign; nothing of the truth is.
    plans : tuple of MachinePlan
        Of all runs.
    runs : iterable of MachineRun
        Taken one after the other.
    title : str
    zero : str
        What temperatures count from: ``"campaign"`` or ``"run"``.
    parquet, force : bool
        Write the runs as Parquet; replace a campaign that stands there.

    Raises
    ------
    ArgumentError
        The folder holds something else, or a campaign without `force`, or cannot be written.
    """
    if zero not in ZEROS:
        raise ArgumentError(f"zero is {zero!r}, expected {' or '.join(map(repr, ZEROS))}")
    form = hexapod_form(plans, title=title, zero=zero, parquet=parquet)
    nominal = told_hexapod(machine)
    return write_folder(
        folder, form, (machine_run_columns(machine, run) for run in runs), force=force,
        beside={HEXAPOD_FILE: lambda path: write_hexapod(nominal, path)},
    )  # fmt: skip
