"""hexapod.toml <-> Hexapod: the unit border. The format is documented in docs/formats.md."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from hexathermal.machine.bodies import Bodies, PoseLimits
from hexathermal.machine.extension_files import EXTENSION_TABLES, read_compliance, read_measuring_frame
from hexathermal.machine.forms import Form, dotted, shown
from hexathermal.machine.hexapod import GRADES, Hexapod
from hexathermal.machine.leg_term_files import TERM_TABLES, read_terms
from hexathermal.machine.thermal import (
    ABSOLUTE_ZERO_DEGC,
    DEFAULT_RANGE_DEGC,
    LARGEST_EXPANSION_PER_K,
    LegLaw,
    PlateLaw,
    ThermalModel,
)
from hexathermal.machine.thermometers import AS_RECORDED, checked_thermometers
from hexathermal.machine.toml_positions import Where

FILE, FORMAT = "hexapod.toml", "hexathermal-hexapod/1"
TABLES: dict[str, dict[str, str]] = {
    "": {"format": "text!", "name": "text!", "source": "text", "grade": "text", "geometry": "table!",
         "thermal": "table", "limits": "table", "bodies": "table", "compliance": "table",
         "measuring_frame": "table"},
    "geometry": {"base_joints_mm": "mm(6,3)!", "platform_joints_mm": "mm(6,3)!", "home_mm": "mm(3)", "q0_mm": "mm6",
                 "stroke_mm": "mm2|mm(6,2)", "base_cone_deg": "deg6", "platform_cone_deg": "deg6"},
    "thermal": {"reference_temperature_degC": "number+!", "valid_degC": "number(2)", "leg": "table", "legs": "tables",
                "platform": "table", "base": "table", "thermometers_of_leg": "number(6)"},
    "thermal.leg": {"sensors": "texts!", "A_per_K": "number+!", "B_per_K": "number+!", "covariance_per_K2": "matrix",
                    "spread_per_K": "number+", "campaign": "text", "terms": "tables"},
    "thermal.plate": {"expansion_per_K": "number!", "sensor": "text", "expansion_std_per_K": "number"},
    "limits": {"convention": "text", "x_mm": "mm(2)!", "y_mm": "mm(2)!", "z_mm": "mm(2)!", "rx_deg": "deg(2)!",
               "ry_deg": "deg(2)!", "rz_deg": "deg(2)!"},
    "bodies": {"leg_body_diameter_mm": "mm!", "leg_rod_diameter_mm": "mm!", "leg_body_mass_kg": "number",
               "leg_rod_mass_kg": "number", "platform_mass_kg": "number", "platform_thickness_mm": "mm",
               "base_thickness_mm": "mm"},
    **TERM_TABLES,
    **EXTENSION_TABLES,
}  # fmt: skip
"""Keys of each table and their rules, see `hexathermal.machine.forms.Form`."""


EXPANSION = f"within +-{LARGEST_EXPANSION_PER_K:g} /K (1/K is meant: the paper's 1.99e-3 um/mm/K is 1.99e-6 /K)"
"""What is asked of every expansion coefficient."""


def read_hexapod(path: str | Path) -> Hexapod:
    """Return the machine of a hexapod.toml, or of a folder that holds one.

    Raises
    ------
    FileFormatError
        Lists every bad field with line and column.
    ArgumentError
        There is no such file.
    """
    form = Form.opened(path, TABLES, FORMAT, "machine file", f"a {FILE} or a folder that holds one", FILE)
    top = form.top
    fields: dict[str, Any] = {"name": top.get("name", ""), "source": top.get("source", "")}
    fields["grade"] = top.get("grade", "C")
    if fields["grade"] not in GRADES:
        form.complain(("grade",), f"grade must be 'A', 'B' or 'C', found {fields['grade']!r}")
    if "geometry" in top:
        fields.update(_geometry(form, top["geometry"]))
    if "thermal" in top:
        fields["thermal"] = _thermal(form, top["thermal"])
        if isinstance(form.data.get("geometry"), dict) and "q0_mm" not in form.data["geometry"]:
            form.complain(("thermal",), "a thermal law needs q0_mm in [geometry]: its drift is A q0 dT + B q dT")
    if "limits" in top:
        fields["limits"] = _limits(form, top["limits"])
    if "bodies" in top:
        fields["bodies"] = _bodies(form, top["bodies"])
    if "compliance" in top:
        fields["compliance"] = read_compliance(form, top["compliance"])
    if "measuring_frame" in top:
        fields["measuring_frame"] = read_measuring_frame(form, top["measuring_frame"])
    form.finish()
    hexapod = form.build(("geometry",), lambda: Hexapod(**fields))
    form.finish()
    assert hexapod is not None  # otherwise finish has raised
    return hexapod


def _geometry(form: Form, data: dict[str, Any]) -> dict[str, Any]:
    """Return the fields of [geometry], with complaints about those that make no machine."""
    before, at = len(form.problems), ("geometry",)
    found = form.table(data, at, "geometry")
    q0, stroke = found.get("q0_mm"), found.get("stroke_mm")
    sound = q0 is not None and form.check((*at, "q0_mm"), q0 > 0.0, "above 0")
    if stroke is not None:
        place = (*at, "stroke_mm")
        sound = form.check(place, stroke[..., 0] < stroke[..., 1], "[low, high] with low < high") and sound
        if "q0_mm" not in data:
            form.complain(place, "geometry.stroke_mm needs q0_mm: a leg is q0 + q long")
        elif sound and not (q0 + stroke[..., 0] > 0.0).all():
            form.complain(place, "geometry.stroke_mm lets a leg shrink to nothing: q0 + low must be above 0")
    for key in ("base_cone_deg", "platform_cone_deg"):
        if key in found:
            form.check((*at, key), (found[key] > 0.0) & (found[key] <= np.pi), "in (0, 180]")
    names = {"base_joints_mm": "base_joints", "platform_joints_mm": "platform_joints", "home_mm": "home",
             "q0_mm": "retracted_length", "stroke_mm": "stroke", "base_cone_deg": "base_cone",
             "platform_cone_deg": "platform_cone"}  # fmt: skip
    fields = {names[key]: value for key, value in found.items()}
    if len(form.problems) == before:
        form.build(at, lambda: Hexapod(**fields))
    return fields


def _leg(form: Form, data: Any, path: Where) -> LegLaw | None:
    """Return one leg's law, or None after a complaint."""
    if not isinstance(data, dict):
        form.complain(path, f"{dotted(path)} must be a table, found {shown(data)}")
        return None
    before = len(form.problems)
    leg = form.table(data, path, "thermal.leg")
    sensors = leg.get("sensors")
    for key in ("A_per_K", "B_per_K"):
        if key not in leg:
            continue
        place = (*path, key)
        form.check(place, np.abs(leg[key]) <= LARGEST_EXPANSION_PER_K, EXPANSION)
        if sensors is not None and leg[key].size != len(sensors):
            form.complain(
                place,
                f"{dotted(place)} has {leg[key].size} values; "
                f"expected 1 value for each of the sensors: {', '.join(sensors)}",
            )
    covariance, spread = leg.get("covariance_per_K2"), leg.get("spread_per_K")
    if covariance is not None and sensors is not None:
        place, zeros = (*path, "covariance_per_K2"), np.zeros(len(sensors))
        if covariance.shape == (2 * zeros.size, 2 * zeros.size):
            sound = form.build(place, lambda: LegLaw(sensors, zeros, zeros, covariance))
            if sound is not None and spread is not None:
                form.build((*path, "spread_per_K"), lambda: LegLaw(sensors, zeros, zeros, covariance, spread=spread))
        else:
            wanted = f"{2 * zeros.size} rows and columns, [A, B] for each of the sensors: {', '.join(sensors)}"
            form.complain(place, f"{dotted(place)} has shape {covariance.shape}; expected {wanted}")
    if spread is not None and covariance is None:
        place = (*path, "spread_per_K")
        form.complain(place, f"{dotted(place)} is part of covariance_per_K2, which is not there")
    terms = read_terms(form, leg.get("terms", ()), (*path, "terms"))
    if sensors is None or len(form.problems) > before:
        return None
    zero = np.zeros(len(sensors))
    form.build((*path, "terms"), lambda: LegLaw(sensors, zero, zero, terms=terms))
    if len(form.problems) > before:
        return None
    A, B, campaign = leg["A_per_K"], leg["B_per_K"], leg.get("campaign", "")
    return form.build(path, lambda: LegLaw(sensors, A, B, covariance, campaign, terms, spread))


def _plate(form: Form, thermal: dict[str, Any], part: str) -> PlateLaw | None:
    """Return one plate's law, or None where there is none or after a complaint."""
    if part not in thermal:
        return None
    before, path = len(form.problems), ("thermal", part)
    plate = form.table(thermal[part], path, "thermal.plate")
    if "expansion_per_K" in plate:
        small = np.abs(plate["expansion_per_K"]) <= LARGEST_EXPANSION_PER_K
        form.check((*path, "expansion_per_K"), small, EXPANSION)
    if "expansion_std_per_K" in plate:
        spread = plate["expansion_std_per_K"]
        sound = (spread >= 0.0) & (spread <= LARGEST_EXPANSION_PER_K)
        form.check((*path, "expansion_std_per_K"), sound, f"in [0, {LARGEST_EXPANSION_PER_K:g}] /K")
    if "sensor" in plate:
        form.check((*path, "sensor"), bool(plate["sensor"]), "a name, or left out where the plate has no thermometer")
    if len(form.problems) > before:
        return None
    expansion, spread = float(plate["expansion_per_K"]), plate.get("expansion_std_per_K")
    told = None if spread is None else float(spread)
    return form.build(path, lambda: PlateLaw(expansion, plate.get("sensor"), told))


def _thermal(form: Form, data: dict[str, Any]) -> ThermalModel | None:
    """Return the thermal model, or None after complaints."""
    before, at = len(form.problems), ("thermal",)
    thermal = form.table(data, at, "thermal")
    laws: Any = None
    if ("leg" in data) == ("legs" in data):
        form.complain(at, "give either [thermal.leg] for all legs, or six [[thermal.legs]]")
    elif "leg" in thermal:
        laws = _leg(form, thermal["leg"], (*at, "leg"))
    elif "legs" in thermal:
        laws = tuple(_leg(form, leg, (*at, "legs", i)) for i, leg in enumerate(thermal["legs"]))
        if len(laws) != 6:
            form.complain((*at, "legs"), f"found {len(laws)} [[thermal.legs]]; expected six, one for each leg")
    platform, base = _plate(form, thermal, "platform"), _plate(form, thermal, "base")
    exchange = thermal.get("thermometers_of_leg", np.array(AS_RECORDED))
    form.build((*at, "thermometers_of_leg"), lambda: checked_thermometers(exchange))
    sound = len(form.problems) == before
    valid = thermal.get("valid_degC", np.array(DEFAULT_RANGE_DEGC))
    reference = thermal.get("reference_temperature_degC")
    ordered = ABSOLUTE_ZERO_DEGC <= valid[0] < valid[1]
    wanted = f"[low, high] with {ABSOLUTE_ZERO_DEGC:g} <= low < high"
    if form.check((*at, "valid_degC"), ordered, wanted) and reference is not None:
        inside = (valid[0] <= reference) & (reference <= valid[1])
        form.check((*at, "reference_temperature_degC"), inside, f"inside valid_degC [{valid[0]:g}, {valid[1]:g}]")
    model = form.build(at, lambda: ThermalModel(laws, platform, base, thermometers_of_leg=exchange)) if sound else None
    if model is not None and reference is not None and reference.size not in (1, len(model.sensor_names)):
        form.complain(
            (*at, "reference_temperature_degC"),
            f"thermal.reference_temperature_degC has {reference.size} values; expected one, "
            f"or 1 value for each of the sensors: {', '.join(model.sensor_names)}",
        )
    if reference is None or len(form.problems) > before:
        return None
    return form.build(at, lambda: ThermalModel(laws, platform, base, reference, valid, exchange))


def _limits(form: Form, data: dict[str, Any]) -> PoseLimits | None:
    """Return travel limits, or None after complaints."""
    before, at = len(form.problems), ("limits",)
    limits = form.table(data, at, "limits")
    convention = limits.pop("convention", "fixed-xyz")
    p = (-1.0, 1.0)
    form.build((*at, "convention"), lambda: PoseLimits(p, p, p, p, p, p, convention))
    for key, pair in limits.items():
        form.check((*at, key), pair[0] < pair[1], "[low, high] with low < high")
    if len(form.problems) > before:
        return None
    pairs: dict[str, Any] = {key.partition("_")[0]: (float(pair[0]), float(pair[1])) for key, pair in limits.items()}
    return form.build(at, lambda: PoseLimits(**pairs, convention=convention))


def _bodies(form: Form, data: dict[str, Any]) -> Bodies | None:
    """Return bodies, or None after complaints."""
    before, at = len(form.problems), ("bodies",)
    bodies = form.table(data, at, "bodies")
    for key, value in bodies.items():
        diameter = "diameter" in key
        form.check((*at, key), value > 0.0 if diameter else value >= 0.0, "above 0" if diameter else "0 or more")
    if len(form.problems) > before:
        return None
    sizes = {key.removesuffix("_mm").removesuffix("_kg"): float(value) for key, value in bodies.items()}
    return form.build(at, lambda: Bodies(**sizes))
