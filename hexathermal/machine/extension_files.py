"""[compliance] and [measuring_frame] of hexapod.toml, read and written; see docs/extended-machine.md."""

from __future__ import annotations

from typing import Any

import numpy as np

from hexathermal.machine.compliance import (
    LARGEST_COMPLIANCE,
    LARGEST_GRAVITY,
    LARGEST_MASS,
    STANDARD_GRAVITY,
    Compliance,
)
from hexathermal.machine.forms import Form
from hexathermal.machine.measuring_frame import LARGEST_DRIFT, LONGEST_DELAY, MeasuringFrame
from hexathermal.machine.units import metres, millionths, shortest
from hexathermal.poses import FloatArray

EXTENSION_TABLES: dict[str, dict[str, str]] = {
    "compliance": {"leg_um_per_N": "um6!", "payload_kg": "number!", "payload_centre_mm": "mm(3)",
                   "gravity_m_s2": "number(3)", "leg_std_um_per_N": "um6", "payload_std_kg": "number",
                   "payload_centre_std_mm": "mm(3)"},
    "measuring_frame": {"sensor": "text!", "shift_um_per_K": "um(3)", "turn_urad_per_K": "um(3)",
                        "shift_std_um_per_K": "um(3)", "turn_std_urad_per_K": "um(3)",
                        "time_constant_s": "number"},
}  # fmt: skip
"""Keys and rules of both tables, see `hexathermal.machine.forms.Form`."""

FRAME_KEYS = {"shift": "shift_um_per_K", "turn": "turn_urad_per_K", "shift_std": "shift_std_um_per_K",
              "turn_std": "turn_std_urad_per_K"}  # fmt: skip


def read_compliance(form: Form, data: dict[str, Any]) -> Compliance | None:
    """Return what [compliance] says, or None after complaints."""
    before, at = len(form.problems), ("compliance",)
    found = form.table(data, at, "compliance")
    for key in ("leg_um_per_N", "leg_std_um_per_N"):
        if key in found:
            sound = (found[key] >= 0.0) & (found[key] <= LARGEST_COMPLIANCE)
            form.check((*at, key), sound, f"in [0, {LARGEST_COMPLIANCE * 1e6:g}] um/N")
    if "payload_kg" in found:
        form.check((*at, "payload_kg"), np.abs(found["payload_kg"]) <= LARGEST_MASS, f"within +-{LARGEST_MASS:g} kg")
    if "gravity_m_s2" in found:
        sound = np.abs(found["gravity_m_s2"]) <= LARGEST_GRAVITY
        form.check((*at, "gravity_m_s2"), sound, f"within +-{LARGEST_GRAVITY:g} m/s^2")
    for key in ("payload_std_kg", "payload_centre_std_mm"):
        if key in found:
            form.check((*at, key), found[key] >= 0.0, "0 or more")
    if len(form.problems) > before:
        return None
    spread = found.get("payload_std_kg")
    return form.build(
        at,
        lambda: Compliance(
            found["leg_um_per_N"], float(found["payload_kg"]), found.get("payload_centre_mm", np.zeros(3)),
            found.get("gravity_m_s2", np.array(STANDARD_GRAVITY)), found.get("leg_std_um_per_N"),
            None if spread is None else float(spread), found.get("payload_centre_std_mm"),
        ),
    )  # fmt: skip


def compliance_table(compliance: Compliance) -> dict[str, Any]:
    """Return the table [compliance]."""
    own = compliance
    table: dict[str, Any] = {
        "leg_um_per_N": _one_or_six(own.leg_compliance),
        "payload_kg": own.payload_mass,
        "payload_centre_mm": _millimetres(own.payload_centre),
        "gravity_m_s2": own.gravity.tolist(),
    }
    if own.leg_compliance_std is not None:
        table["leg_std_um_per_N"] = _one_or_six(own.leg_compliance_std)
    if own.payload_mass_std is not None:
        table["payload_std_kg"] = own.payload_mass_std
    if own.payload_centre_std is not None:
        table["payload_centre_std_mm"] = _millimetres(own.payload_centre_std)
    return table


def read_measuring_frame(form: Form, data: dict[str, Any]) -> MeasuringFrame | None:
    """Return what [measuring_frame] says, or None after complaints."""
    before, at = len(form.problems), ("measuring_frame",)
    found = form.table(data, at, "measuring_frame")
    if "sensor" in found:
        form.check((*at, "sensor"), bool(found["sensor"]), "the name of a recorded temperature")
    for name, key in FRAME_KEYS.items():
        if key not in found:
            continue
        unit = "urad/K" if name.startswith("turn") else "um/K"
        form.check((*at, key), np.abs(found[key]) <= LARGEST_DRIFT, f"within +-{LARGEST_DRIFT * 1e6:g} {unit}")
        if name.endswith("_std"):
            form.check((*at, key), found[key] >= 0.0, "0 or more")
    delay = float(found.get("time_constant_s", 0.0))
    form.check((*at, "time_constant_s"), np.array(0.0 <= delay <= LONGEST_DELAY), f"in [0, {LONGEST_DELAY:g}] s")
    if len(form.problems) > before:
        return None
    values = {name: found[key] for name, key in FRAME_KEYS.items() if key in found}
    return form.build(at, lambda: MeasuringFrame(found["sensor"], **values, time_constant=delay))


def measuring_frame_table(frame: MeasuringFrame) -> dict[str, Any]:
    """Return the table [measuring_frame]."""
    table: dict[str, Any] = {"sensor": frame.sensor}
    for name, key in FRAME_KEYS.items():
        value = getattr(frame, name)
        if value is not None:
            table[key] = _millionths(value)
    if frame.time_constant > 0.0:
        table["time_constant_s"] = frame.time_constant
    return table


def _millionths(values: FloatArray) -> list[Any]:
    """Return numbers in millionths, to the last digit."""
    return [millionths(value) for value in values.tolist()]


def _millimetres(values: FloatArray) -> list[Any]:
    """Return metres as the shortest decimals that are read back as they were."""
    return [shortest(value, metres) for value in values.tolist()]


def _one_or_six(values: FloatArray) -> Any:
    """Return six numbers in millionths, one where all are the same; as texts, since 0 and -0 are equal as numbers."""
    entries = _millionths(values)
    return entries[0] if len({str(entry) for entry in entries}) == 1 else entries
