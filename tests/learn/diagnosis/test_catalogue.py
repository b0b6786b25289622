"""The catalogue: seventeen causes, one file each, complete; and the diagnosis knows nothing of what hides effects."""

from __future__ import annotations

import ast
import subprocess
import sys
from pathlib import Path

import pytest

import hexathermal.learn.diagnosis as diagnosis
from hexathermal.learn.diagnosis.causes import catalogue
from hexathermal.machine.leg_terms import SHAPES

NAMES = {
    "thermal-lag", "missing-sensor", "hidden-heat", "nonlinear-expansion", "frame-expansion", "air-refraction",
    "abbe-tilt", "backlash", "periodic-screw-error", "scale-error", "creep", "zero-drift", "zero-jump", "clock-offset",
    "sensor-drift", "sensor-detached", "swapped-sensors",
}  # fmt: skip
"""As docs and the JSON's format have them."""

FOLDER = Path(diagnosis.__file__).parent


def test_the_catalogue_has_the_names_of_the_format() -> None:
    """Seventeen names, spelt as in the JSON's format, no more and no fewer; each in the file of its name."""
    assert set(catalogue()) == NAMES
    files = {file.stem.replace("_", "-") for file in (FOLDER / "causes").glob("*.py")} - {"--init--"}
    assert files == NAMES


@pytest.mark.parametrize("name", sorted(NAMES))
def test_a_cause_is_complete(name: str) -> None:
    """Physics, signature, parameters with unit and prior, what it is confused with, experiment, words."""
    cause = catalogue()[name].CAUSE
    for text in (cause.physics, cause.signature, cause.experiment):
        assert len(text.split()) >= 5
        assert text[0].isupper()
        assert text.endswith(".")
    assert cause.parameters
    for one in cause.parameters:
        assert one.name
        assert one.unit
        assert one.prior
    assert cause.confused_with
    assert set(cause.confused_with) <= NAMES - {name}
    assert len(cause.words.split()) >= 4
    assert "{" not in cause.words.format(target="T07")


def test_shapes_of_terms_are_known_to_the_law() -> None:
    """Each shape that a file of the catalogue names is one that the extended law has."""
    named = set()
    for file in (FOLDER / "causes").glob("*.py"):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and node.func.attr == "term":
                shape = node.args[1]
                assert isinstance(shape, ast.Constant), file.name
                named.add(shape.value)
    assert named
    assert named <= set(SHAPES)


@pytest.mark.long
def test_the_diagnosis_names_no_generator() -> None:
    """No file of the diagnosis imports the simulation, and importing all of it loads none of it."""
    for file in FOLDER.rglob("*.py"):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            names = [item.name for item in node.names] if isinstance(node, ast.Import) else []
            names += [node.module or ""] if isinstance(node, ast.ImportFrom) else []
            assert not any("simulate" in name for name in names), file.name
    code = (
        "import sys, hexathermal.learn.diagnosis; from hexathermal.learn.diagnosis.causes import catalogue; "
        "catalogue(); print([name for name in sys.modules if name.startswith('hexathermal.simulate')])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
