"""All contenders, and who of them can take part here."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module

from benchmarks.case import Case
from benchmarks.contender import Contender, Unavailable

MODULES = (
    "hexathermal_methods",
    "cpp_yardstick",
    "mujoco_tendons",
    "pinocchio_numpy",
    "pinocchio_loops",
    "numpy_batches",
)


def entered(case: Case, modules: tuple[str, ...] = MODULES) -> tuple[list[Contender], dict[str, str]]:
    """Return the contenders that can take part, and for each of the others the reason why not."""
    contenders: list[Contender] = []
    missing: dict[str, str] = {}
    for module in modules:
        enter: Callable[[Case], Contender] = import_module(f"benchmarks.contenders.{module}").enter
        try:
            contenders.append(enter(case))
        except Unavailable as reason:
            missing[module] = str(reason)
    return contenders, missing
