"""Every folder of models/ is a publication: data, source, derivation, grade, licence, limits, picture; and is right."""

from __future__ import annotations

import re
import runpy
import tomllib
from pathlib import Path
from typing import Any

import matplotlib.image
import numpy as np
import numpy.typing as npt
import pytest

import hexathermal as ht
from hexathermal.kinematics.workspace import margins, reachable_volume
from hexathermal.machine.library import models_folder

F64 = npt.NDArray[np.float64]

ROOT = Path(__file__).resolve().parents[2]
FOLDERS = sorted(path for path in models_folder().iterdir() if path.is_dir())
SECTIONS = ("Source", "Derivation", "Grade", "Licence", "Limits")

folder_of = pytest.mark.parametrize("folder", FOLDERS, ids=lambda folder: folder.name)


def section(folder: Path, name: str) -> str:
    """Return the text of one section of a README."""
    text = (folder / "README.md").read_text(encoding="utf-8")
    found = re.search(rf"^## {name}\n(.*?)(?=^## |\Z)", text, flags=re.MULTILINE | re.DOTALL)
    return found.group(1).strip() if found else ""


def tool(name: str) -> dict[str, Any]:
    """Return what a script of tools/ defines."""
    return runpy.run_path(str(ROOT / "tools" / f"{name}.py"), run_name=name)


def test_all_folders_are_bundled_machines() -> None:
    """There are folders, each holds a machine, and the library lists exactly these."""
    assert len(FOLDERS) >= 3
    assert tuple(folder.name for folder in FOLDERS) == ht.bundled_hexapods()


@folder_of
def test_readme_says_what_a_publication_must(folder: Path) -> None:
    """Title, picture and the sections source, derivation, grade, licence and limits, none empty, in this order."""
    text = (folder / "README.md").read_text(encoding="utf-8")
    assert text.startswith(f"# {folder.name}\n")
    assert "](picture.png)" in text
    places = [text.find(f"\n## {name}\n") for name in SECTIONS]
    assert min(places) > 0
    assert places == sorted(places)
    for name in SECTIONS:
        assert len(section(folder, name)) > 60, name
    assert "make_models.py" in section(folder, "Derivation")
    assert re.search(r"\bMIT\b", section(folder, "Licence"))


@folder_of
def test_readme_and_machine_agree(folder: Path) -> None:
    """Name, grade, source and whether a thermal law is active are the same in README and machine."""
    hexapod = ht.load_hexapod(folder.name)
    assert hexapod.name == folder.name
    assert section(folder, "Grade").startswith(f"{hexapod.grade}:")
    assert len(hexapod.source) > 40
    assert ("compensation is not active" in section(folder, "Limits")) == (hexapod.thermal is None)


@folder_of
def test_machine_is_read_and_written_without_loss(folder: Path, tmp_path: Path) -> None:
    """The file, read and written again, has the same text, and is read as an equal machine."""
    hexapod = ht.load_hexapod(folder / "hexapod.toml")
    written = ht.write_hexapod(hexapod, tmp_path / folder.name)
    assert ht.load_hexapod(written) == hexapod
    assert written.read_text() == (folder / "hexapod.toml").read_text()


@folder_of
def test_home_is_reachable(folder: Path) -> None:
    """At home every leg is inside its stroke, cones and travel are kept, the legs are apart, the pose is regular."""
    hexapod = ht.load_hexapod(folder.name)
    found = margins(hexapod, hexapod.home, collisions=True)
    assert found.reachable
    assert found.stroke.min() > 0.0
    assert found.clearance > 0.0
    assert found.condition_number < 10.0


@folder_of
def test_picture_is_a_picture(folder: Path) -> None:
    """picture.png is a PNG of a sane size, below 150 kB, and not blank."""
    file = folder / "picture.png"
    assert file.read_bytes()[:8] == b"\x89PNG\r\n\x1a\n"
    assert 20_000 < file.stat().st_size < 150_000
    pixels = matplotlib.image.imread(file)
    height, width = pixels.shape[:2]
    assert 600 <= width <= 1600
    assert 400 <= height <= 1200
    ink = (pixels[..., :3].min(axis=2) < 0.9).mean()
    assert 0.01 < ink < 0.5


def test_pictures_are_drawn_by_the_tool(tmp_path: Path) -> None:
    """tools/draw_models.py draws a machine again, in the size of the picture that is kept."""
    file = tmp_path / "picture.png"
    tool("draw_models")["picture"](ht.load_hexapod("rubin-m2"), file)
    kept = matplotlib.image.imread(models_folder() / "rubin-m2" / "picture.png")
    assert matplotlib.image.imread(file).shape == kept.shape


def test_files_are_written_by_the_tool() -> None:
    """tools/make_models.py makes exactly the machines that are kept."""
    made = tool("make_models")
    machines = {machine.name: machine for machine in (made["reference"](), made["CAMERA"], made["M2"])}
    assert sorted(machines) == sorted(folder.name for folder in FOLDERS)
    for name, machine in machines.items():
        assert machine == ht.load_hexapod(name)


def test_the_wheel_holds_the_models() -> None:
    """models/ is put into the wheel as hexathermal/models, where the library looks for it."""
    with (ROOT / "pyproject.toml").open("rb") as file:
        wheel = tomllib.load(file)["tool"]["hatch"]["build"]["targets"]["wheel"]
    assert wheel["force-include"]["models"] == "hexathermal/models"


PAPER = {"A": 1.99e-6, "B": 1.09e-6, "stroke": 0.25}


def test_the_reference_machine_has_the_papers_numbers() -> None:
    """Eq. (8) in 1/K, one thermometer a leg, stroke 250 mm, Invar plates without one; the drift is eq. (8)'s."""
    hexapod = ht.load_hexapod("reference")
    law = hexapod.thermal
    assert law is not None
    assert law.sensor_names == tuple(f"leg{leg}_T1" for leg in range(1, 7))
    assert all(leg.A.tolist() == [PAPER["A"]] and leg.B.tolist() == [PAPER["B"]] for leg in law.legs)
    assert np.array_equal(hexapod.stroke, [[0.0, PAPER["stroke"]]] * 6)
    for plate in (law.platform, law.base):
        assert plate is not None
        assert 1.2e-6 <= plate.expansion <= 2.0e-6
        assert plate.sensor is None
    # eq. (8) as printed: micrometres from millimetres and kelvins
    q0_mm, q_mm, dT = 600.0, 125.0, 3.0
    printed = 1.99e-3 * q0_mm * dT + 1.09e-3 * q_mm * dT
    lengths = np.full(6, (q0_mm + q_mm) / 1e3)
    assert hexapod.leg_drift(lengths, [20.0 + dT] * 6) * 1e6 == pytest.approx([printed] * 6, abs=1e-9)


def test_the_reference_machines_joints_are_those_of_its_derivation() -> None:
    """Radii 450 and 300 mm, pairs at 10 degrees either side, 725 mm legs at home, to the 1 um of its coordinates."""
    hexapod = ht.load_hexapod("reference")
    for joints, radius, middle in ((hexapod.base_joints, 0.45, 0.0), (hexapod.platform_joints, 0.3, 60.0)):
        assert np.abs(np.hypot(joints[:, 0], joints[:, 1]) - radius).max() < 1e-6
        angles = np.sort(np.degrees(np.arctan2(joints[:, 1], joints[:, 0])) % 360.0)
        expected = np.sort([(middle + third + side) % 360.0 for third in (0, 120, 240) for side in (-10, 10)])
        assert np.abs(angles - expected).max() < 2e-4
    assert np.abs(hexapod.inverse_kinematics(hexapod.home) - 0.725).max() < 1e-5


def test_the_readme_states_the_reference_workspace() -> None:
    """The volume and bounds in the README lie within bounds found anew, at a coarser resolution."""
    text = section(models_folder() / "reference", "Derivation").replace("\n", " ")
    found = re.search(r"fill ([\d ]+) cm³, between ([\d. ]+) and ([\d. ]+) cm³", text)
    assert found is not None
    value, low, high = (float(number.replace(" ", "")) * 1e-6 for number in found.groups())
    lower, upper = reachable_volume(ht.load_hexapod("reference"), resolution=0.001).bounds
    assert lower < low < value < high < upper
    assert high - low < 2e-4 * value


# A check published with the Rubin Observatory's controller software (lsst-ts/ts_mthexapod, test of the inverse
# kinematics, which holds it against the controller's own model): leg i joins fixed joint i and moving joint i.
CHECK_FIXED = np.array([
    [0.47055, 0.51351, -0.125], [-0.47055, 0.51351, -0.125], [-0.67999, 0.15075, -0.125],
    [-0.20944, -0.66426, -0.125], [0.20944, -0.66426, -0.125], [0.67999, 0.15075, -0.125],
])  # fmt: skip
CHECK_MOVING = np.array([
    [0.20944, 0.66426, -0.555], [-0.20944, 0.66426, -0.555], [-0.67999, -0.15075, -0.555],
    [-0.47055, -0.51351, -0.555], [0.47055, -0.51351, -0.555], [0.67999, -0.15075, -0.555],
])  # fmt: skip
CHECK_PIVOT = np.array([0.0, 0.0, -2.7584])
CHECK_POSE = [-60.3, 104.5, -10.9, *np.degrees([-0.0355, -0.0205, -0.0004])]  # mm, deg
CHECK_CHANGES = np.array([0.15205, 0.07204, -0.04667, 0.13381, 0.02959, -0.07292])


def test_published_leg_lengths_are_met() -> None:
    """Published changes of six lengths at a published pose, to five decimals; the other convention misses them."""
    hexapod = ht.Hexapod(CHECK_FIXED, CHECK_MOVING - CHECK_PIVOT, home=CHECK_PIVOT)
    at_home = hexapod.inverse_kinematics(hexapod.home)
    pose = ht.pose_from_coordinates(CHECK_POSE, "fixed-zyx", hexapod)
    changes = hexapod.inverse_kinematics(pose) - at_home
    assert np.abs(changes - CHECK_CHANGES).max() <= 5e-6
    assert np.abs(hexapod.forward_kinematics(at_home + changes) - pose).max() < 1e-12
    other = ht.pose_from_coordinates(CHECK_POSE, "fixed-xyz", hexapod)
    assert np.abs(hexapod.inverse_kinematics(other) - at_home - CHECK_CHANGES).max() > 1e-4


def test_published_lengths_of_a_zigzag_machine_are_met() -> None:
    """The same source's machine with shared joints, rings of 1.2 and 2.3 m, shifted: to 0.01 um as printed."""
    lower, upper = np.radians([10, 130, 130, 250, 250, 10]), np.radians([70, 70, 190, 190, 310, 310])
    moving = np.column_stack([1.2 * np.cos(lower), 1.2 * np.sin(lower), np.zeros(6)])
    fixed = np.column_stack([2.3 * np.cos(upper), 2.3 * np.sin(upper), np.full(6, 0.81)])
    hexapod = ht.Hexapod(fixed, moving, home=[0.0, 0.0, 0.0])
    shifted = ht.pose_from_coordinates([0.5, -3.02, 2.5, 0, 0, 0])
    changes = hexapod.inverse_kinematics(shifted) - hexapod.inverse_kinematics(hexapod.home)
    assert np.abs(changes * 1e6 - [1895.25, 443.86, -2443.52, 515.74, -2268.74, -3776.62]).max() <= 0.006


RUBIN = {
    "rubin-camera": (
        [[227600, 653800, -525000], [-227600, 653800, -525000], [-680000, -129700, -525000],
         [-452300, -524000, -525000], [452300, -524000, -525000], [680000, -129700, -525000]],
        [[472800, 512200, -121400], [-472800, 512200, -121400], [-680000, 153300, -121400],
         [-207200, -665500, -121400], [207200, -665500, -121400], [680000, 153300, -121400]],
        [0, 0, -2758400], [11400, 11400, 13100, 0.36, 0.36, 0.10],
    ),
    "rubin-m2": (
        [[0, 1701800, 114300], [-1542350, -719210, 114300], [1542350, -719210, 114300],
         [790, 1460490, 228600], [-1503370, 7660, 228600], [1503370, 7660, 228600]],
        [[0, 1701800, 607300], [-1542350, -719210, 607300], [1542350, -719210, 607300],
         [493790, 1460490, 228600], [-1256870, -419290, 228600], [1256870, -419290, 228600]],
        [0, 0, -703000], [10500, 10500, 8900, 0.175, 0.175, 0.05],
    ),
}  # fmt: skip
"""Published facts: moving joints, fixed joints, pivot (um), largest x, y, z (um) and rx, ry, rz (deg)."""


def published_changes(moving: F64, fixed: F64, pivot: F64, six: F64) -> F64:
    """Return the change of the struts [um], written from the published equation, for one position (um, deg)."""
    (cx, cy, cz), (sx, sy, sz) = np.cos(np.radians(six[3:])), np.sin(np.radians(six[3:]))
    turn = (
        np.array([[1, 0, 0], [0, cx, -sx], [0, sx, cx]])
        @ np.array([[cy, 0, sy], [0, 1, 0], [-sy, 0, cy]])
        @ np.array([[cz, -sz, 0], [sz, cz, 0], [0, 0, 1]])
    )
    moved = six[:3] + pivot + (moving - pivot) @ turn.T - fixed
    return np.asarray(np.linalg.norm(moved, axis=1) - np.linalg.norm(moving - fixed, axis=1))


@pytest.mark.parametrize("name", RUBIN)
def test_rubin_struts_follow_the_published_equation(name: str, rng: np.random.Generator) -> None:
    """Strokes at 50 positions are the struts' changes by the published equation and coordinates, to 1 nm."""
    moving, fixed, pivot, most = (np.array(values, dtype=float) for values in RUBIN[name])
    hexapod = ht.load_hexapod(name)
    assert hexapod.stroke is not None
    assert hexapod.stroke == pytest.approx(np.array([[-14.1e-3, 14.1e-3]] * 6), abs=1e-15)
    for _ in range(50):
        six = rng.uniform(-1.0, 1.0, 6) * most
        pose = ht.pose_from_coordinates(six * [1e-3, 1e-3, 1e-3, 1, 1, 1], "fixed-zyx", hexapod)
        strokes = hexapod.strokes(hexapod.inverse_kinematics(pose))
        assert np.abs(strokes * 1e6 - published_changes(moving, fixed, pivot, six)).max() < 1e-3


@pytest.mark.parametrize(
    "name",
    [
        "rubin-camera",
        "rubin-m2",
    ],
)
def test_rubin_position_limits_are_the_published_ones(name: str) -> None:
    """Travel of the pivot, either way, in the published rotation order."""
    limits = ht.load_hexapod(name).limits
    assert limits is not None
    assert limits.convention == "fixed-zyx"
    most = RUBIN[name][3]
    for axis, value in zip(("x", "y", "z", "rx", "ry", "rz"), most, strict=True):
        expected = value * 1e-6 if axis in "xyz" else np.radians(value)
        assert getattr(limits, axis) == pytest.approx((-expected, expected), rel=1e-12), axis
