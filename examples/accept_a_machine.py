"""Accept a machine: a specification, measured poses, a verdict with its probability, and JUnit XML."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np

import hexathermal as ht
from hexathermal.predict.acceptance import accept, read_measured_poses, read_specification
from hexathermal.show.acceptance_tables import sentence, verdict_lines
from hexathermal.show.junit import junit

SPEC = """
format = "hexathermal-spec/1"
title = "Hexapod 12, warm"

[uncertainty]           # standard uncertainty of every quantity; it is never taken as nought
position_um = 0.3
rotation_urad = 1.0

[limits]
AP_um = 4.0             # pose accuracy (ISO 9283)
RP_um = 2.0             # pose repeatability
AP_rz_urad = { within = 6.0 }
shift_um = { upper = 3.0, u = 0.4 }   # between the cold and the warm group
"""

AXES = ("x_mm", "y_mm", "z_mm", "rx_deg", "ry_deg", "rz_deg")
NOISE = np.array([2e-4, 2e-4, 2e-4, 3e-5, 3e-5, 3e-5])
"""Of a visit: machine and laser tracker [mm, deg]."""


def measure(hexapod: ht.Hexapod, corrected: bool, file: Path) -> None:
    """Visit three poses ten times, cold and warm; a simulation stands for machine and tracker. Writes their table."""
    generator = np.random.default_rng(12)
    commands = np.array([[0, 0, 0, 0, 0, 0], [30, 10, 15, 0, 1, 0], [-30, 20, -10, 1, 0, 5]], dtype=float)
    with file.open("w", encoding="utf-8", newline="") as stream:
        out = csv.writer(stream)
        out.writerow(["pose", "group", "cycle", *AXES, *(f"measured_{axis}" for axis in AXES)])
        for group, warmth in (("cold", 0.0), ("warm", 5.0)):
            temps = 20.0 + warmth * np.array([1.0, 1.05, 0.9, 1.1, 1.0, 0.95])
            for cycle in range(1, 11):
                for k, coordinates in enumerate(commands):
                    pose = ht.pose_from_coordinates(coordinates, hexapod=hexapod)
                    told = hexapod.inverse_kinematics(pose)
                    if corrected:
                        told = hexapod.corrected_leg_lengths(pose, temps)
                    stands = ht.coordinates_from_pose(hexapod.predicted_pose(told, temps), hexapod=hexapod)
                    measured = stands + NOISE * generator.standard_normal(6)
                    numbers = (f"{value:.7f}" for value in (*coordinates, *measured))
                    out.writerow([f"P{k + 1}", group, cycle, *numbers])


def main() -> None:
    """Hold the machine against its specification, first without thermal correction, then with it."""
    Path("spec.toml").write_text(SPEC, encoding="utf-8")
    specification = read_specification("spec.toml")
    hexapod = ht.load_hexapod("reference")
    for name, corrected in (("without", False), ("with", True)):
        file = Path(f"{name}-correction.csv")
        measure(hexapod, corrected, file)
        found = accept(read_measured_poses(file), specification)
        print(f"{name} correction: {verdict_lines(found).splitlines()[0]}")
        worst = min(found.results, key=lambda one: one.decision.probability or 0.0)
        print(f"  least sure, at {worst.pose}: {sentence(worst)}")
        Path(f"{name}-correction.xml").write_bytes(junit(found))
    print("JUnit XML:", ", ".join(sorted(str(one) for one in Path().glob("*.xml"))))
    print("the same on the command line, with the exit codes 0 pass, 1 fail, 2 not decided:")
    print("  hexathermal accept with-correction.csv --spec spec.toml --junit accept.xml")


if __name__ == "__main__":
    main()
