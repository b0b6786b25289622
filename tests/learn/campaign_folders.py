"""Small campaigns for tests: a leg on a bench with a known law, written as a folder; and how to damage its tables."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from hexathermal.learn.campaign import Block
from hexathermal.learn.campaign_faults import CampaignError
from hexathermal.learn.campaign_files import load_campaign
from hexathermal.learn.cleaning import used_run
from hexathermal.learn.cleaning_record import CleaningRecord

SENSORS = ("T01", "T02", "T03", "T04")
A_PER_K, B_PER_K, Q0_M = 2e-6, 1.1e-6, 0.6
STEP_S = 20.0

Table = dict[str, np.ndarray]


def leg_table(seed: int = 1, rows: int = 600, *, noise_K: float = 0.05, noise_um: float = 0.03) -> Table:
    """Return a run: rests of 25 rows at 10 mm steps, warming and cooling; drift of the law of T01, noise on all."""
    rng = np.random.default_rng(seed)
    time = STEP_S * np.arange(rows)
    q = np.round(10.0 * ((np.arange(rows) // 25) * 7 % 24) + 5.0, 4)
    settled = (np.arange(rows) % 25 >= 2).astype(float)
    settled[:2] = 1.0
    heat = 5.0 * np.sin(np.pi * time / time[-1]) ** 2 + 1.5 * np.sin(9.0 * time / time[-1])
    heat -= heat[0]
    table: Table = {"time_s": time, "q_mm": q, "settled": settled}
    for k, name in enumerate(SENSORS):
        lag = np.interp(time - 300.0 * k, time, heat) * (1.0 - 0.2 * k)
        table[f"{name}_degC"] = np.round(20.0 + lag + noise_K * rng.standard_normal(rows), 4)
    drift_mm = 1e3 * (A_PER_K * Q0_M * heat + B_PER_K * q * 1e-3 * heat)
    for beam in (1, 2, 3):
        noise = noise_um * 1e-3 * rng.standard_normal(rows)
        table[f"beam{beam}_mm"] = np.round(drift_mm + q - q[0] + noise * (np.arange(rows) > 0), 6)
    table["air_temperature_degC"] = np.round(20.0 + 0.02 * rng.standard_normal(rows), 3)
    table["air_pressure_hPa"] = np.round(1000.0 + 5.0 * time / time[-1] + 0.05 * rng.standard_normal(rows), 3)
    table["air_humidity_percent"] = np.round(45.0 + 0.5 * rng.standard_normal(rows), 2)
    return table


def write_table(file: Path, table: Table) -> None:
    """Write a table as CSV; NaN is an empty field."""
    file.parent.mkdir(parents=True, exist_ok=True)
    rows = zip(*table.values(), strict=True)
    lines = [",".join("" if value != value else repr(float(value)) for value in row) for row in rows]
    file.write_text("\n".join([",".join(table), *lines]) + "\n", encoding="utf-8")


def campaign_text(runs: dict[str, str], *, compensated: bool = True, zero: str = "run", more: str = "") -> str:
    """Return the campaign.toml of a leg; `runs` gives each run's role, `more` goes to the top."""
    head = f'format = "hexathermal-campaign/1"\nkind = "leg"\ntitle = "small bench"\nzero = "{zero}"\n{more}\n'
    leg = f"[leg]\nq0_mm = {Q0_M * 1e3}\nstroke_mm = [0.0, 250.0]\n\n"
    beams = (
        "[interferometer]\nradius_mm = 60.0\nazimuth_deg = [0.0, 120.0, 240.0]\ndead_path_mm = 700.0\n"
        f"index_compensated = {str(compensated).lower()}\n\n"
    )
    heat = "".join(
        f'[[thermocouples]]\nname = "{name}"\npart = "body"\nposition_mm = {50 * k}\n' for k, name in enumerate(SENSORS)
    )
    files = "".join(
        f'[[runs]]\nname = "{name}"\nfile = "runs/{name}.csv"\nrole = "{role}"\n' for name, role in runs.items()
    )
    return head + leg + beams + heat + files


def leg_campaign(
    folder: Path,
    *,
    edit: Callable[[Table], Table | None] = lambda table: None,
    validation: bool = True,
    rows: int = 600,
    compensated: bool = True,
    zero: str = "run",
) -> Path:
    """Write a campaign of two or three runs; `edit` alters the table of the first one."""
    roles = {"a": "identification", "b": "identification"} | ({"c": "validation"} if validation else {})
    for seed, name in enumerate(roles):
        table = leg_table(seed, rows)
        if name == "a":
            table = edit(table) or table
        write_table(folder / "runs" / f"{name}.csv", table)
    (folder / "campaign.toml").write_text(campaign_text(roles, compensated=compensated, zero=zero), encoding="utf-8")
    return folder


def component_campaign(folder: Path, rows: int = 400) -> Path:
    """Write a campaign of a component with one thermocouple and a spindle's speed."""
    rng = np.random.default_rng(3)
    time = 15.0 * np.arange(rows)
    for name in ("a", "b"):
        heat = 3.0 * (1.0 - np.exp(-time / 1500.0))
        speed = np.where(time < time[rows // 2], 3000.0, 0.0)
        table = {"time_s": time, "spindle_speed_rpm": speed,
                 "T1_degC": 21.0 + heat + 0.01 * rng.standard_normal(rows) + (2.0 if name == "b" else 0.0),
                 "drift_um": 4.0 * heat + 0.02 * rng.standard_normal(rows) + (8.0 if name == "b" else 0.0)}  # fmt: skip
        write_table(folder / "runs" / f"{name}.csv", table)
    text = 'format = "hexathermal-campaign/1"\nkind = "component"\ntitle = "spindle"\nzero = "campaign"\n'
    text += '[[thermocouples]]\nname = "T1"\n[[inputs]]\nname = "spindle_speed_rpm"\n'
    text += '[[runs]]\nname = "a"\nfile = "runs/a.csv"\nrole = "identification"\n'
    text += '[[runs]]\nname = "b"\nfile = "runs/b.csv"\nrole = "validation"\n'
    (folder / "campaign.toml").write_text(text, encoding="utf-8")
    return folder


def cleaned(folder: Path, edit: Callable[[Table], Table | None] = lambda table: None) -> tuple[Block, CleaningRecord]:
    """Return the first run of a campaign whose first table was altered."""
    return used_run(load_campaign(leg_campaign(folder, edit=edit)), "a")


def changed(folder: Path, old: str, new: str, count: int = 1) -> None:
    """Replace a text in campaign.toml."""
    file = folder / "campaign.toml"
    text = file.read_text(encoding="utf-8")
    assert old in text
    file.write_text(text.replace(old, new, count), encoding="utf-8")


def messages(folder: Path, **options: tuple[str, ...] | bool) -> list[str]:
    """Return the faults of a campaign as texts, file names without folders."""
    with pytest.raises(CampaignError) as error:
        load_campaign(folder, **options)  # type: ignore[arg-type]
    return [f"{Path(file).name}:{p.line}:{p.column} {p.message}" for file, p in error.value.faults]
