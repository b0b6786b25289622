"""My own logger's CSV: other names, other units, decimal commas and gaps become a campaign, and a law."""

from __future__ import annotations

import csv
from datetime import datetime, timedelta
from pathlib import Path

import numpy as np

import hexathermal as ht
from hexathermal.simulate.bench.bench import Bench, BenchRun, planned_runs, simulate_bench

COLUMNS = {"Weg [um]": ("q_mm", 1e-3, 0.0), "Ruhe": ("settled", 1.0, 0.0), "Kanal 7 [K]": ("T07_degC", 1.0, -273.15),
           "Kanal 15 [K]": ("T15_degC", 1.0, -273.15)}  # fmt: skip
COLUMNS |= {f"Laser {name} [um]": (f"beam{k}_mm", 1e-3, 0.0) for k, name in enumerate("ABC", 1)}
"""The logger's column -> the campaign's column, and value = factor * logged + offset."""

STAMP = "%d.%m.%Y %H:%M:%S"
CAMPAIGN = """\
format = "hexathermal-campaign/1"
kind = "leg"
title = "Leg 3, from the logger of the workshop"
thermocouples = [{ name = "T07" }, { name = "T15" }]
leg = { q0_mm = 600.0, stroke_mm = [0.0, 250.0] }
interferometer = { radius_mm = 60.0, azimuth_deg = [0.0, 120.0, 240.0], dead_path_mm = 0.0, index_compensated = true }
"""


def log(run: BenchRun, file: Path, start: datetime, generator: np.random.Generator) -> None:
    """Write what the logger of the workshop writes; a simulated bench stands for the leg."""
    kelvin = 273.15 + run.temperatures.T
    values = [1e6 * run.q, run.settled, kelvin[6], kelvin[14], *(1e6 * run.beams.T)]
    with file.open("w", encoding="latin-1", newline="") as stream:
        out = csv.writer(stream, delimiter=";")
        out.writerow(["Zeitstempel", *COLUMNS])
        for seconds, *row in zip(run.time, *values, strict=True):
            if generator.random() > 0.003:  # it forgets rows, and writes --- for values that it lost
                cells = ["---" if generator.random() < 0.002 else f"{value:.3f}".replace(".", ",") for value in row]
                out.writerow([(start + timedelta(seconds=float(seconds))).strftime(STAMP), *cells])


def translate(logged: Path, table: Path) -> None:
    """Write a logger's file as a table of a campaign: names and units are changed, gaps stay gaps."""
    with logged.open(encoding="latin-1", newline="") as stream:
        rows = list(csv.DictReader(stream, delimiter=";"))
    first = datetime.strptime(rows[0]["Zeitstempel"], STAMP)
    with table.open("w", encoding="utf-8", newline="") as stream:
        (out := csv.writer(stream)).writerow(["time_s", *(name for name, _, _ in COLUMNS.values())])
        for row in rows:
            texts = {column: row[column].replace(",", ".") for column in COLUMNS}
            cells = ["" if texts[column] == "---" else f"{factor * float(texts[column]) + offset:.6f}"
                     for column, (_name, factor, offset) in COLUMNS.items()]  # fmt: skip
            out.writerow([(datetime.strptime(row["Zeitstempel"], STAMP) - first).total_seconds(), *cells])


def main() -> None:
    """Log four mornings, make a campaign of them, check it, and identify and validate a law."""
    (folder := Path("leg-3")).mkdir(exist_ok=True)
    generator, runs = np.random.default_rng(3), ""
    for day, run in enumerate(simulate_bench(seed=3, plans=planned_runs(Bench(), 3, identification=3, validation=1))):
        logged = Path(f"messung_{day + 1}.csv")
        log(run, logged, datetime(2026, 3, 2 + day, 8), generator)
        translate(logged, folder / f"{run.name}.csv")
        runs += f'[[runs]]\nname = "{run.name}"\nfile = "{run.name}.csv"\nrole = "{run.role}"\n'
    (folder / "campaign.toml").write_text(CAMPAIGN + runs, encoding="utf-8")

    campaign = ht.load_campaign(folder)
    for one in ht.check_campaign(campaign).runs:
        lost = sum(step.count for step in one.record.steps if step.step == "missing")
        print(f"{one.run.name}: {one.record.used} of {one.record.rows} rows usable; {lost} values are missing")
    law = ht.identify_campaign(campaign).law
    print(f"law of {' + '.join(law.sensors)}: A {law.A[0] * 1e6:.2f}, B {law.B[0] * 1e6:.2f} um/m/K")
    new = ht.validate_campaign(law, campaign).total
    print(f"on a morning never fitted: drift {new.drift_rms * 1e6:.2f} um RMS, {new.rmse.value * 1e6:.2f} um left")


if __name__ == "__main__":
    main()
