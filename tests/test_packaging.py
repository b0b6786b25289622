"""What is installed is what is here: wheel and source archive are whole, versions follow the changelog."""

from __future__ import annotations

import contextlib
import io
import os
import re
import tarfile
import tomllib
import zipfile
from pathlib import Path
from typing import Any

import pytest

import hexathermal as ht
from hexathermal import cli

ROOT = Path(__file__).resolve().parent.parent
PACKAGE = ROOT / "hexathermal"
IN_WHEEL = ("py.typed", "kinematics/modes_start.npz", "show/viewer.js", "show/viewer.css",
            *(f"models/{name}/hexapod.toml" for name in ht.bundled_hexapods()))  # fmt: skip
IN_SDIST = ("README.md", "CHANGELOG.md", "CONTRIBUTING.md", "CITATION.cff", "LICENSE", "Makefile", "pyproject.toml",
            "pytest_hexathermal.py", "tests/conftest.py", "tests/test_packaging.py", "examples/planner.py",
            "docs/formats.md", "docs/demo.png", "benchmarks/__main__.py", "tools/make_models.py")  # fmt: skip


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """The wheel, the source archive, and the wheel made of the source archive."""
    backend = pytest.importorskip("hatchling.build", reason="hatchling is not installed (extra 'dev')")
    folder, here = tmp_path_factory.mktemp("dist"), Path.cwd()
    try:
        with contextlib.redirect_stdout(io.StringIO()):
            os.chdir(ROOT)
            wheel = folder / backend.build_wheel(str(folder))
            sdist = folder / backend.build_sdist(str(folder))
            with tarfile.open(sdist) as archive:
                # Python 3.11.0 to 3.11.3 know no filters
                safely: dict[str, Any] = {"filter": "data"} if hasattr(tarfile, "data_filter") else {}
                archive.extractall(folder / "source", **safely)
            os.chdir(next((folder / "source").iterdir()))
            again = folder / "again"
            again.mkdir()
            second = again / backend.build_wheel(str(again))
    finally:
        os.chdir(here)
    return {"wheel": wheel, "sdist": sdist, "again": second}


def contents(wheel: Path) -> dict[str, bytes]:
    """Return the files of a wheel by name."""
    with zipfile.ZipFile(wheel) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


def test_the_wheel_holds_every_file_of_the_package(built: dict[str, Path]) -> None:
    """Each module, the viewer's page, the models and the start of the modes are in it; nothing else of ours is."""
    names = set(contents(built["wheel"]))
    ours = {
        f"hexathermal/{file.relative_to(PACKAGE).as_posix()}"
        for file in PACKAGE.rglob("*")
        if file.is_file() and "__pycache__" not in file.parts
    }
    assert ours <= names
    assert {f"hexathermal/{name}" for name in IN_WHEEL} <= names
    tops = {name.split("/")[0] for name in names}
    assert tops == {"hexathermal", "pytest_hexathermal.py", f"hexathermal-{ht.__version__}.dist-info"}
    assert not any("__pycache__" in name or name.endswith((".nbi", ".nbc", ".part")) for name in names)


def test_a_wheel_of_the_source_archive_is_the_same(built: dict[str, Path]) -> None:
    """Built from the archive the wheel holds the same files with the same bytes."""
    first, again = contents(built["wheel"]), contents(built["again"])
    assert first == again


def test_the_source_archive_can_be_tested_and_documented(built: dict[str, Path]) -> None:
    """Tests, examples, documentation, benchmarks and tools come along; builds and caches do not."""
    with tarfile.open(built["sdist"]) as archive:
        names = {name.split("/", 1)[1] for name in archive.getnames() if "/" in name}
    assert set(IN_SDIST) <= names
    assert not any(part in name for name in names for part in ("__pycache__", "_build/", ".so", ".venv", "generated/"))


def test_the_wheel_starts_the_program_and_the_fixture(built: dict[str, Path]) -> None:
    """Entry points name a function and a module that are in the wheel."""
    files = contents(built["wheel"])
    points = next(text.decode() for name, text in files.items() if name.endswith("entry_points.txt"))
    assert "hexathermal = hexathermal.__main__:main" in points
    assert "pytest_hexathermal = pytest_hexathermal" in points


def test_versions_follow_the_changelog(capsys: pytest.CaptureFixture[str]) -> None:
    """The newest heading of CHANGELOG.md, __version__, --version and CITATION.cff say the same."""
    newest = re.search(r"^## (\S+)", (ROOT / "CHANGELOG.md").read_text(encoding="utf-8"), re.MULTILINE)
    assert newest is not None
    assert newest[1] == ht.__version__
    assert cli.main(["--version"]) == 0
    assert capsys.readouterr().out == f"hexathermal {newest[1]}\n"
    assert f"\nversion: {newest[1]}\n" in (ROOT / "CITATION.cff").read_text(encoding="utf-8")


def test_extras_are_few_and_every_dependency_has_a_lower_bound() -> None:
    """Five extras; each dependency says from which version on it serves."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    extras = project["optional-dependencies"]
    assert sorted(extras) == ["bench", "dev", "docs", "report", "test"]
    wanted = [*project["dependencies"], *(name for extra in extras.values() for name in extra)]
    assert [name for name in wanted if ">=" not in name and not name.startswith("hexathermal[")] == []


def test_readme_is_short_and_whole() -> None:
    """One sentence, one picture, one equation, twelve lines of code, two commands, limitations, how to cite."""
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    assert len(text.splitlines()) < 100
    assert text.count("![") == 1
    assert len(re.findall(r"^\$\$", text, re.MULTILINE)) == 1
    assert len(re.findall(r"^>>> ", text, re.MULTILINE)) == 12
    commands = text.split("## Two commands")[1].split("```")[1].splitlines()[1:]
    assert len([line for line in commands if not line.startswith("#")]) == 2
    for heading in ("## Limitations", "## How to cite"):
        assert heading in text
