"""Limits of detection of a machine's causes, cause by cause: at the best and at the worst place, by size over noise."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from hexathermal.learn.machine_diagnosis.result import UM, MachineLimit

LIMITS_WORDS = (
    "Ranked by size over the noise, all axes together, not by um or urad alone; rows by the worst place. um, urad: RMS "
    "shift and turn of the platform."
)
"""By what limits are ranked."""

LIMITS_ON_PAGES = LIMITS_WORDS.replace("um", "µm").replace("urad", "µrad")
"""The same, where a page has all letters."""


LIMITS_HEAD = ("best at", "um>", "urad>", "worst at", "um>", "urad>")
"""What `limits_rows` tell behind the name."""


def limits_by_cause(limits: Iterable[MachineLimit]) -> list[tuple[str, list[MachineLimit]]]:
    """Return limits cause by cause, the one that is seen best first; without places that these rows do not see."""
    groups: dict[str, list[MachineLimit]] = {}
    for one in limits:
        if np.isfinite(one.strength):
            groups.setdefault(one.cause, []).append(one)
    for places in groups.values():
        places.sort(key=lambda one: one.strength)
    return sorted(groups.items(), key=lambda item: (item[1][-1].strength, item[0]))


def limits_rows(limits: Iterable[MachineLimit]) -> list[tuple[str, ...]]:
    """Return limits by cause: its name, then place, RMS [um] and [urad] of the best and of the worst place."""
    rows: list[tuple[str, ...]] = []
    for cause, places in limits_by_cause(limits):
        ends = [(one.target or "-", f"{one.translation * UM:.2g}", f"{one.rotation * UM:.2g}")
                for one in (places[0], places[-1])]  # fmt: skip
        rows.append((cause, *ends[0], *(ends[1] if len(places) > 1 else ("", "", ""))))
    return rows


def limits_told(told: dict[str, Any]) -> list[MachineLimit]:
    """Return the limits of a machine, in SI; infinite where its rows see nothing of a cause."""
    return [
        MachineLimit(one["cause"], one["target"], *(
            np.inf if one[name] is None else one[name] * factor
            for name, factor in (("strength", 1.0), ("translation_um", 1.0 / UM), ("rotation_urad", 1.0 / UM))
        ))
        for one in told["detection_limits"]
    ]  # fmt: skip
