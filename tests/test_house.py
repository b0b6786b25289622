"""The house: storeys point one way, files stay small, importing is cheap and compiles nothing."""

from __future__ import annotations

import ast
import subprocess
import sys
from pathlib import Path

import pytest

import hexathermal as ht

PACKAGE = Path(ht.__file__).parent
FILES = sorted(PACKAGE.rglob("*.py"))


def test_storeys_point_one_way() -> None:
    """The import contracts of pyproject.toml hold."""
    cli = pytest.importorskip("importlinter.cli", reason="import-linter is not installed (extra 'dev')")
    assert cli.lint_imports(config_filename=str(PACKAGE.parent / "pyproject.toml"), no_cache=True) == 0


@pytest.mark.parametrize("file", FILES, ids=lambda file: str(file.relative_to(PACKAGE)))
def test_files_and_functions_stay_small_and_silent(file: Path) -> None:
    """No file above 400 lines, no function above 60; only cli.py prints; only the mechanism uses Pinocchio's models."""
    text = file.read_text()
    assert len(text.splitlines()) <= 400
    name = file.relative_to(PACKAGE).as_posix()
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            assert (node.end_lineno or 0) - node.lineno <= 60, f"{name}: {node.name}"
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "print":
            assert name == "cli.py", f"{name}:{node.lineno} prints"
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id == "pin":
            allowed = name.startswith("machine/pinocchio_") or name == "show/viewer.py"
            assert allowed or node.attr == "SE3", f"{name}:{node.lineno} uses pinocchio.{node.attr}"


def test_importing_the_package_loads_no_compiler() -> None:
    """`import hexathermal` imports neither numba nor scipy, matplotlib or pyarrow: nothing can be compiled."""
    code = (
        "import sys, hexathermal; heavy = ('numba', 'scipy', 'matplotlib', 'pyarrow', 'rich', 'trimesh', 'meshcat'); "
        "print([name for name in heavy if name in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_public_names_are_sorted_and_documented() -> None:
    """__all__ is sorted, complete and every name has a docstring."""
    assert list(ht.__all__) == sorted(ht.__all__)
    for name in ht.__all__:
        assert getattr(ht, name).__doc__, name
