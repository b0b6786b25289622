"""Checks of campaigns of a whole machine: noise that was put in comes out, what cannot be told apart is said."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from hexathermal import load_hexapod, pose_from_coordinates
from hexathermal.cli import main
from hexathermal.kinematics.inverse import inverse_kinematics
from hexathermal.learn.campaign_files import load_campaign
from hexathermal.learn.check_hexapod import HexapodCheck, check_hexapod_campaign, hexapod_warnings
from hexathermal.machine.writing import write_hexapod

from .campaign_folders import Table, write_table

POSE = ("x_mm", "y_mm", "z_mm", "rx_deg", "ry_deg", "rz_deg")
NOISE_UM, NOISE_URAD, NOISE_K = 0.5, 2.0, 0.02
ROWS = 240


def machine_table(seed: int, held: int) -> Table:
    """Return a run of the reference machine: every pose is held for some rows, legs warm differently, noise on all."""
    rng, hexapod = np.random.default_rng(seed), load_hexapod("reference")
    six = np.repeat(rng.uniform([-8, -8, -8, -1, -1, -1], [8, 8, 8, 1, 1, 1], (ROWS // held, 6)), held, axis=0)
    q = hexapod.strokes(inverse_kinematics(hexapod, pose_from_coordinates(six, hexapod=hexapod))) * 1e3
    time = 60.0 * np.arange(ROWS)
    table: Table = {"time_s": time} | dict(zip(POSE, six.T, strict=True))
    table |= {f"leg{leg + 1}_q_mm": q[:, leg] for leg in range(6)}
    for leg in range(6):
        heat = 4.0 * np.sin(np.pi * time / time[-1] * (1.0 + 0.4 * leg)) ** 2
        table[f"leg{leg + 1}_T1_degC"] = 20.0 + heat + NOISE_K * rng.standard_normal(ROWS)
    noise = rng.standard_normal((ROWS, 6)) * ([NOISE_UM * 1e-3] * 3 + [np.degrees(NOISE_URAD * 1e-6)] * 3)
    slow = 5e-3 * np.sin(time / time[-1])[:, None]
    return table | {f"measured_{name}": (six + slow + noise)[:, k] for k, name in enumerate(POSE)}


def machine_campaign(
    folder: Path, edit: Callable[[Table], Table | None] = lambda table: None, held: int = 6, validation: bool = True
) -> Path:
    """Write a campaign of two runs; `edit` alters the table of the first one."""
    folder.mkdir(parents=True, exist_ok=True)
    write_hexapod(load_hexapod("reference"), folder / "machine.toml")
    text = 'format = "hexathermal-campaign/1"\nkind = "hexapod"\nhexapod = "machine.toml"\ntitle = "stand"\n'
    for seed, name in enumerate(("a", "b")):
        table = machine_table(seed, held)
        if name == "a":
            table = edit(table) or table
        write_table(folder / f"{name}.csv", table)
        role = "validation" if name == "b" and validation else "identification"
        text += f'[[runs]]\nname = "{name}"\nfile = "{name}.csv"\nrole = "{role}"\n'
    (folder / "campaign.toml").write_text(text, encoding="utf-8")
    return folder


def checked(folder: Path, **options: object) -> HexapodCheck:
    """Return the check of a campaign of a machine."""
    return check_hexapod_campaign(load_campaign(machine_campaign(folder, **options)))  # type: ignore[arg-type]


def test_noise_of_coordinates_and_thermometers_is_that_put_in(tmp_path: Path) -> None:
    """Within 20 %, where poses are held; slow deviations of 5 um do not enter; every pose is counted."""
    check = checked(tmp_path)
    assert np.allclose(check.noise[:3], NOISE_UM * 1e-6, rtol=0.2)
    assert np.allclose(check.noise[3:], NOISE_URAD * 1e-6, rtol=0.2)
    assert np.allclose(check.sensor_noise, NOISE_K, rtol=0.2)
    assert [one.poses for one in check.runs] == [ROWS // 6, ROWS // 6]
    assert check.runs[0].clock.duration == 60.0 * (ROWS - 1)
    assert check.lowest_degC.min() > 19.8
    assert 23.5 < check.highest_degC.min() < 24.5
    assert np.allclose(np.diag(check.correlation), 1.0)


def test_poses_that_are_never_held_leave_the_noise_open(tmp_path: Path) -> None:
    """With another pose in every row the noise is not known, the scatter from pose to pose is."""
    check = checked(tmp_path, held=1)
    assert np.isnan(check.noise).all()
    assert np.allclose(check.scatter[:3], NOISE_UM * 1e-6, rtol=0.2)


def test_legs_that_warm_alike_at_one_place_are_not_told_apart(tmp_path: Path) -> None:
    """Small poses about home cannot tell A from B of the legs: it is said, with what to measure."""
    said = hexapod_warnings(checked(tmp_path))
    assert any("coefficients cannot be told apart from the rest (leg1 A T1, leg1 B T1" in text for text in said)


def test_rows_codes_and_dead_thermometers_are_counted(tmp_path: Path) -> None:
    """Missing poses are left out with a count, codes of a thermometer do not count, and one without value is named."""

    def edit(table: Table) -> None:
        table["measured_x_mm"][10:15] = np.nan
        table["leg2_T1_degC"][40:44] = -180.0
        table["settled"] = np.ones(ROWS)
        table["settled"][:3] = 0.0

    check = checked(tmp_path, edit=edit)
    assert check.runs[0].left_out == {"not settled": 3, "no measured pose": 5}
    assert len(check.runs[0].time) == ROWS - 8
    assert check.lowest_degC[1] > 19.0

    def kill(table: Table) -> None:
        table["leg2_T1_degC"][:] = 9999.0

    folder = machine_campaign(tmp_path / "dead", edit=kill)
    file = folder / "b.csv"
    head, *rows = file.read_text().splitlines()
    k = head.split(",").index("leg2_T1_degC")
    lines = [",".join([*row.split(",")[:k], "9999", *row.split(",")[k + 1 :]]) for row in rows]
    file.write_text("\n".join([head, *lines]) + "\n")
    said = hexapod_warnings(check_hexapod_campaign(load_campaign(folder)))
    assert "leg2_T1: not one reading in the whole campaign" in said


def test_a_machine_without_thermometers_is_checked(tmp_path: Path) -> None:
    """No temperatures: noise of the poses is still found, and why nothing can be told apart is said."""

    def edit(table: Table) -> Table:
        return {name: values for name, values in table.items() if not name.endswith("_degC")}

    folder = machine_campaign(tmp_path, edit=edit)
    check = check_hexapod_campaign(load_campaign(folder))
    assert check.campaign.sensors == ()
    assert np.isfinite(check.noise).all()
    assert check.observability is None
    assert any("what can be told apart cannot be said" in text for text in hexapod_warnings(check))


@pytest.mark.parametrize(
    ("columns", "factor", "wanted"),
    [
        (("measured_y_mm",), 1e3, "measured_y_mm moves over"),
        (("measured_rz_deg",), np.pi / 180.0, "measured_rz_deg moves over"),
        (("measured_z_mm",), -1.0, "measured_z_mm moves against z_mm"),
    ],
)
def test_measured_poses_in_another_unit_are_a_fault(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], columns: tuple[str, ...], factor: float, wanted: str
) -> None:
    """Micrometres, radians and turned signs beside the commanded pose: exit code 3, with the column."""

    def edit(table: Table) -> None:
        for name in columns:
            table[name] *= factor

    assert main(["check", str(machine_campaign(tmp_path, edit=edit))]) == 3
    printed = capsys.readouterr().err
    assert wanted in printed
    assert printed.count("\n") == 2


@pytest.mark.long
def test_the_command_answers_for_a_machine(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Tables on stdout, pictures of every run, JSON without NaN."""
    folder = machine_campaign(tmp_path / "stand")
    code = main(["check", str(folder), "--plots", str(tmp_path / "plots"), "--json", str(tmp_path / "check.json")])
    printed = capsys.readouterr()
    assert code == 0, printed.err
    for text in ("stand (kind hexapod): 2 runs", "leg6_T1", "measured less", "leg1 A T1", "Written into"):
        assert text in printed.out
    names = {file.name for file in (tmp_path / "plots").iterdir()}
    assert {"run-a.png", "run-b.svg", "noise.png", "collinearity.png", "observability.png"} <= names
    data = json.loads((tmp_path / "check.json").read_text())
    assert data["kind"] == "hexapod"
    assert abs(data["coordinates"][0]["noise"] - NOISE_UM) < 0.1
    assert len(data["observability"]["coefficients"]) == 12
