"""Files of acceptance tests: tables of visits, specifications, and what they are judged to be."""

from __future__ import annotations

from pathlib import Path

from hexathermal.predict.acceptance import Acceptance, accept, read_measured_poses, read_specification

POSE = "x_mm,y_mm,z_mm,rx_deg,ry_deg,rz_deg"
MEASURED = ",".join(f"measured_{name}" for name in POSE.split(","))
HEADER = f"pose,{POSE},{MEASURED}"
FORMAT = 'format = "hexathermal-spec/1"\n'


def visits(*rows: tuple[str, str, str], header: str = HEADER) -> str:
    """A table of visits: name, command and measurement of each."""
    return "\n".join([header, *(",".join(row) for row in rows)]) + "\n"


TWO = visits(("A", "0,0,0,0,0,0", "0.001,0,0,0,0,0"), ("A", "0,0,0,0,0,0", "0.003,0,0,0,0,0"))


def written(folder: Path, text: str, name: str = "measured.csv") -> Path:
    """A file with a text."""
    (folder / name).write_text(text, encoding="utf-8")
    return folder / name


def judged(folder: Path, table: str, spec: str, **options: object) -> Acceptance:
    """Hold a table against a specification."""
    measured = read_measured_poses(written(folder, table), **options)  # type: ignore[arg-type]
    return accept(measured, read_specification(written(folder, FORMAT + spec, "spec.toml")))


def values(acceptance: Acceptance) -> list[float]:
    """Values of all results [um] or [urad]."""
    return [result.decision.value * 1e6 for result in acceptance.results]


def grouped() -> str:
    """Two groups of two visits, ten minutes apart, 1 um and 4 um off; temperatures and uncertainties recorded."""
    header = f"time_s,group,{HEADER},room_degC,u_position_um"
    visited = [("cold", 0.0005), ("cold", 0.0015), ("warm", 0.0035), ("warm", 0.0045)]
    rows = [
        (f"{600 * k}", group, "A", "0,0,0,0,0,0", f"{x},0,0,0,0,0", f"{20 + k}", "0.2")
        for k, (group, x) in enumerate(visited)
    ]
    return visits(*rows, header=header)  # type: ignore[arg-type]
