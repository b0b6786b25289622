"""What the examples print is what their README says, and what they write can be used; the README lists them all."""

from __future__ import annotations

import io
import re
import runpy
import sys
from contextlib import redirect_stdout
from pathlib import Path
from types import ModuleType
from typing import Any
from xml.etree import ElementTree as ET

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hexathermal.cli import main

FOLDER = Path(__file__).resolve().parent.parent / "examples"
README = (FOLDER / "README.md").read_text(encoding="utf-8")
SAID = dict(re.findall(r"### (\w+)\.py\n\n```text\n(.*?)\n```", README, flags=re.DOTALL))
EXAMPLES = sorted(file.stem for file in FOLDER.glob("*.py") if file.name != "__init__.py")
NUMBER = re.compile(r"(?<![\w.])[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?")


def printed(name: str) -> str:
    """Run an example where we are, and return what it prints."""
    out = io.StringIO()
    with redirect_stdout(out):
        runpy.run_path(str(FOLDER / f"{name}.py"), run_name="__main__")
    return out.getvalue().rstrip()


def test_the_index_lists_every_example() -> None:
    """Each file of the folder is linked, none is listed that is not there, and five show what they print."""
    linked = set(re.findall(r"\]\((\w+\.(?:py|ipynb))\)", README))
    assert linked == {file.name for file in FOLDER.glob("*.[pi]*") if file.suffix in (".py", ".ipynb")} - {
        "__init__.py"
    }
    assert len(SAID) == 5


STORY = "find_the_fault_of_a_machine"
"""The example of which a page tells, with its figures."""


def told(page: str) -> list[float]:
    """Return the decimal figures of a page's story of the example, less the place of the payload [m]."""
    text = (FOLDER.parent / "docs" / page).read_text(encoding="utf-8")
    story = text.split(f"examples/{STORY}.py")[1].split("\n\n")[0]
    return [float(one) for one in re.findall(r"\d+\.\d+(?! m )", story)]


@pytest.mark.parametrize("name", EXAMPLES)
def test_an_example_runs_and_prints_what_the_readme_shows(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """In an empty folder, under 80 lines. Words are the same, numbers to 2 % or two hundredths: processors differ."""
    monkeypatch.chdir(tmp_path)
    for module in ("egse.hexapod.symetrie.hexapod", "egse.hexapod.symetrie", "egse.hexapod", "egse"):
        monkeypatch.setitem(sys.modules, module, None)  # as if it were not installed
    said = printed(name)
    for line, shown in zip(said.splitlines(), SAID.get(name, said).splitlines(), strict=True):
        assert NUMBER.sub("#", line) == NUMBER.sub("#", shown)
        values, expected = ([float(one) for one in NUMBER.findall(text)] for text in (line, shown))
        assert values == pytest.approx(expected, rel=0.02, abs=0.02)
    if name == STORY:
        values = [abs(float(one)) for one in NUMBER.findall(said)]
        for figure in (figures := told("reading-a-machine-diagnosis.md")):
            assert min(abs(value - figure) for value in values) <= 0.02 * figure + 0.02, figure
        assert len(figures) > 6
    assert len((FOLDER / f"{name}.py").read_text(encoding="utf-8").splitlines()) < 80
    _use(name)


def _use(name: str) -> None:
    """Take what an example wrote into the command line and other programs."""
    if name == "my_own_logger":
        assert main(["check", "leg-3", "--quiet"]) == 0
    if name == "accept_a_machine":
        cases = {one: ET.parse(f"{one}-correction.xml").getroot() for one in ("with", "without")}
        assert {one: len(list(tree.iter("failure"))) for one, tree in cases.items()} == {"with": 0, "without": 6}
        for one, code in (("with", 0), ("without", 1)):
            assert main(["accept", f"{one}-correction.csv", "--spec", "spec.toml", "--quiet"]) == code
    if name == "a_day":
        assert Path("day/day.png").read_bytes().startswith(b"\x89PNG")
    if name == "bench_to_correction":
        assert main(["show-machine", "machine", "--quiet"]) == 0


class Controller:
    """A controller that takes poses in user and object frames, written from their definition with SciPy."""

    def homing(self) -> None:
        """Stand at home."""
        self.platform = np.eye(4)

    def configure_coordinates_systems(self, *twelve: float) -> None:
        """Take the user frame in the machine frame, and the object frame in the platform frame."""
        self.user, self.tool = _matrix(twelve[:6]), _matrix(twelve[6:])

    def move_absolute(self, *six: float) -> None:
        """Bring the object to a pose in the user frame."""
        self.platform = self.user @ _matrix(six) @ np.linalg.inv(self.tool)

    def get_user_positions(self) -> list[float]:
        """Return the object in the user frame."""
        return _six(np.linalg.inv(self.user) @ self.platform @ self.tool)

    def get_machine_positions(self) -> list[float]:
        """Return the platform in the machine frame."""
        return _six(self.platform)


def _matrix(six: tuple[float, ...]) -> np.ndarray[Any, Any]:
    """Return the matrix of six coordinates [mm, deg], turns about fixed axes x, y, z."""
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = Rotation.from_euler("xyz", six[3:], degrees=True).as_matrix(), six[:3]
    return T


def _six(T: np.ndarray[Any, Any]) -> list[float]:
    """Return six coordinates of a matrix."""
    return [*T[:3, 3], *Rotation.from_matrix(T[:3, :3]).as_euler("xyz", degrees=True)]


def test_a_controller_with_frames_of_its_own_goes_where_it_should(monkeypatch: pytest.MonkeyPatch) -> None:
    """The command, in user and object frames, brings a warm machine's tool to less than a thousandth of a nanometre."""
    module: Any = ModuleType("egse.hexapod.symetrie.hexapod")
    module.HexapodSimulator = Controller
    monkeypatch.setitem(sys.modules, module.__name__, module)
    for parent in ("egse", "egse.hexapod", "egse.hexapod.symetrie"):
        monkeypatch.setitem(sys.modules, parent, ModuleType(parent))
    text = printed("poses_only_controller")
    apart = re.search(r"its pose is ours to (\S+) nm", text)
    off = re.search(r"off by (\S+) nm; without correction (\S+) um", text)
    assert apart is not None
    assert off is not None
    assert float(apart[1]) < 1e-3
    assert float(off[1]) < 1e-3
    assert float(off[2]) > 1.0
