"""Write the tables of docs/diagnosis.md from the code: ``python tools/write_diagnosis_tables.py``."""

from __future__ import annotations

import ast
import sys
from importlib import import_module
from pathlib import Path

import numpy as np

from hexathermal.learn.diagnosis.causes import catalogue

PAGE = Path(__file__).resolve().parents[1] / "docs" / "diagnosis.md"

PACKAGE = "hexathermal.learn.diagnosis"

UNITS = ("UM", "HOUR_S")
"""Numbers that are no choice."""

LISTED = 12
"""Numbers of one name that are told one by one."""


def _own_numbers(name: str) -> dict[str, object]:
    """Return the numbers that a module of the method states itself, alone or several, by their names."""
    module = import_module(f"{PACKAGE}.{name}")
    tree = ast.parse(Path(str(module.__file__)).read_text(encoding="utf-8"))
    aims = [aim for node in tree.body if isinstance(node, ast.Assign) for aim in node.targets]
    aims += [node.target for node in tree.body if isinstance(node, ast.AnnAssign)]
    names = [leaf.id for aim in aims for leaf in ast.walk(aim) if isinstance(leaf, ast.Name) and leaf.id.isupper()]
    return {one: getattr(module, one) for one in names if one not in UNITS and _items(getattr(module, one))}


def _items(value: object) -> list[str]:
    """Return a number, or several, as they are told; nothing of what is no number."""
    if isinstance(value, dict):
        parts = [(key, _items(one)) for key, one in value.items()]
        return [f"{key}: {' and '.join(own)}" for key, own in parts] if all(own for _key, own in parts) else []
    if isinstance(value, tuple | list) and value and all(isinstance(item, tuple | list) for item in value):
        inner = [_items(item) for item in value]
        return [f"({', '.join(own)})" for own in inner] if all(inner) else []
    value = value.tolist() if isinstance(value, np.ndarray) else value
    items = list(value) if isinstance(value, tuple | list) else [value]
    numbers = [item for item in items if isinstance(item, int | float)]
    if len(numbers) != len(items) or all(isinstance(item, bool) for item in numbers):
        return []
    told = [str(item) if isinstance(item, bool) else f"{item:g}" for item in numbers]
    return told if len(told) <= LISTED else [f"{told[0]} to {told[-1]} in {len(told)} steps"]


def numbers_by_module() -> dict[str, dict[str, object]]:
    """Return the numbers of all modules of the method that have any, causes last."""
    folder = PAGE.parents[1] / PACKAGE.replace(".", "/")
    files = sorted(folder.glob("*.py")) + sorted((folder / "causes").glob("*.py"))
    names = [".".join(file.relative_to(folder).with_suffix("").parts) for file in files if file.stem != "__init__"]
    return {name: numbers for name in names if (numbers := _own_numbers(name))}


def constants_table() -> str:
    """Return the numbers of the method."""
    lines = ["| module | numbers |", "|---|---|"]
    for name, numbers in numbers_by_module().items():
        told = (f"`{one}` {', '.join(_items(value))}" for one, value in numbers.items())
        lines.append(f"| `{name}` | {' · '.join(told)} |")
    return "\n".join(lines) + "\n"


def catalogue_table() -> str:
    """Return the catalogue: physics, signature, parameters, what it is confused with, and the experiment."""
    head = (
        "| cause | physics | signature | parameters: what is known before | confused with | what decides | readings |"
    )
    lines = [head, "|---|---|---|---|---|---|---|"]
    for name, module in catalogue().items():
        cause = module.CAUSE
        known = "; ".join(f"`{one.name}` [{one.unit}]: {one.prior}" for one in cause.parameters)
        alike = ", ".join(cause.confused_with)
        decides = f"{cause.experiment} | {cause.readings or 'the fault itself'}"
        lines.append(f"| `{name}` | {cause.physics} | {cause.signature} | {known} | {alike} | {decides} |")
    return "\n".join(lines) + "\n"


def written(text: str) -> str:
    """Return the page with its tables as the code has them."""
    for name, table in (("catalogue", catalogue_table()), ("constants", constants_table())):
        begin, end = f"<!-- {name}: tools/write_diagnosis_tables.py -->\n", f"<!-- end of {name} -->"
        before, rest = text.split(begin, 1)
        text = f"{before}{begin}{table}{end}{rest.split(end, 1)[1]}"
    return text


if __name__ == "__main__":
    PAGE.write_text(written(PAGE.read_text(encoding="utf-8")), encoding="utf-8")
    sys.stdout.write(f"{PAGE} written\n")
