"""hexapod.toml <-> Hexapod: the unit border. The format is documented in docs/formats.md."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from hexathermal.errors import ArgumentError
from hexathermal.machine.bodies import Bodies, PoseLimits
from hexathermal.machine.forms import Form, shown
from hexathermal.machine.hexapod import Hexapod
from hexathermal.machine.thermal import LegLaw, PlateLaw, ThermalModel

FORMAT = "hexathermal-hexapod/1"
TABLES: dict[str, dict[str, str]] = {
    "": {"format": "text!", "name": "text!", "source": "text", "grade": "text", "geometry": "table!",
         "thermal": "table", "limits": "table", "bodies": "table"},
    "geometry": {"base_joints_mm": "mm(6,3)!", "platform_joints_mm": "mm(6,3)!", "home_mm": "mm(3)", "q0_mm": "mm6",
                 "stroke_mm": "mm2|mm(6,2)", "base_cone_deg": "deg6", "platform_cone_deg": "deg6"},
    "thermal": {"reference_temperature_degC": "number+", "valid_degC": "number(2)", "leg": "table", "legs": "tables",
                "platform": "table", "base": "table"},
    "thermal.leg": {"sensors": "texts!", "A_per_K": "number+!", "B_per_K": "number+!", "covariance_per_K2": "matrix",
                    "campaign": "text"},
    "thermal.plate": {"expansion_per_K": "number!", "sensor": "text"},
    "limits": {"convention": "text", "x_mm": "mm(2)!", "y_mm": "mm(2)!", "z_mm": "mm(2)!", "rx_deg": "deg(2)!",
               "ry_deg": "deg(2)!", "rz_deg": "deg(2)!"},
    "bodies": {"leg_body_diameter_mm": "mm!", "leg_rod_diameter_mm": "mm!", "leg_body_mass_kg": "number",
               "leg_rod_mass_kg": "number", "platform_mass_kg": "number", "platform_thickness_mm": "mm",
               "base_thickness_mm": "mm"},
}  # fmt: skip
"""Keys of each table and their rules, see `hexathermal.machine.forms.Form`."""


def read_hexapod(path: str | Path) -> Hexapod:
    """Return the machine of a hexapod.toml, or of a folder that holds one.

    Raises
    ------
    FileFormatError
        Lists every bad field with line and column.
    ArgumentError
        There is no such file.
    """
    file = Path(path)
    file = file / "hexapod.toml" if file.is_dir() else file
    if not file.is_file():
        raise ArgumentError(f"no machine file at {file}; expected a hexapod.toml or a folder that holds one")
    form = Form(file, TABLES)
    top = form.table(form.data, "", "")
    if top.get("format", FORMAT) != FORMAT:
        form.complain("format", f"format is {top['format']!r}; this version reads {FORMAT!r}")
    fields: dict[str, Any] = {"name": top.get("name", ""), "source": top.get("source", "")}
    fields["grade"] = top.get("grade", "C")
    if fields["grade"] not in ("A", "B", "C"):
        form.complain("grade", f"grade must be 'A', 'B' or 'C', found {fields['grade']!r}")
    geometry = form.table(top.get("geometry", {}), "geometry", "geometry")
    names = {"base_joints_mm": "base_joints", "platform_joints_mm": "platform_joints", "home_mm": "home",
             "q0_mm": "retracted_length", "stroke_mm": "stroke", "base_cone_deg": "base_cone",
             "platform_cone_deg": "platform_cone"}  # fmt: skip
    fields.update({names[key]: value for key, value in geometry.items()})
    if "thermal" in top:
        fields["thermal"] = _thermal(form, top["thermal"])
    if "limits" in top:
        fields["limits"] = _limits(form, form.table(top["limits"], "limits", "limits"))
    if "bodies" in top:
        fields["bodies"] = _bodies(form, form.table(top["bodies"], "bodies", "bodies"))
    form.finish()
    hexapod = form.build("geometry", lambda: Hexapod(**fields))
    form.finish()
    assert isinstance(hexapod, Hexapod)
    return hexapod


def _leg(form: Form, data: Any, path: str) -> Any:
    """Return one leg's law, or None after a complaint."""
    if not isinstance(data, dict):
        return form.complain(path, f"{path} must be a table, found {shown(data)}")
    before = len(form.problems)
    leg = form.table(data, path, "thermal.leg")
    if len(form.problems) > before:
        return None
    return form.build(
        path,
        lambda: LegLaw(
            leg["sensors"], leg["A_per_K"], leg["B_per_K"], leg.get("covariance_per_K2"), leg.get("campaign", "")
        ),
    )


def _plate(form: Form, thermal: dict[str, Any], part: str) -> Any:
    """Return one plate's law, or None where there is none or after a complaint."""
    if part not in thermal:
        return None
    path = f"thermal.{part}"
    plate = form.table(thermal[part], path, "thermal.plate")
    if "expansion_per_K" not in plate:
        return None
    return form.build(path, lambda: PlateLaw(float(plate["expansion_per_K"]), plate.get("sensor")))


def _thermal(form: Form, data: dict[str, Any]) -> Any:
    """Return the thermal model, or None after complaints."""
    before = len(form.problems)
    thermal = form.table(data, "thermal", "thermal")
    if ("leg" in thermal) == ("legs" in thermal):
        return form.complain("thermal", "give either [thermal.leg] for all legs, or six [[thermal.legs]]")
    if "leg" in thermal:
        laws: Any = _leg(form, thermal["leg"], "thermal.leg")
    else:
        laws = tuple(_leg(form, leg, f"thermal.legs.{i}") for i, leg in enumerate(thermal["legs"]))
        if len(laws) != 6:
            form.complain("thermal.legs.0", f"found {len(laws)} [[thermal.legs]]; expected six, one for each leg")
    platform, base = _plate(form, thermal, "platform"), _plate(form, thermal, "base")
    if "reference_temperature_degC" not in thermal:
        form.complain("thermal", "key 'reference_temperature_degC' is missing in [thermal]")
    if len(form.problems) > before:
        return None
    keys = ("reference_temperature_degC", "valid_degC")
    options = {key: thermal[key] for key in keys if key in thermal}
    return form.build("thermal", lambda: ThermalModel(laws, platform, base, **options))


def _limits(form: Form, limits: dict[str, Any]) -> Any:
    """Return travel limits, or None after complaints."""
    axes = ("x_mm", "y_mm", "z_mm", "rx_deg", "ry_deg", "rz_deg")
    if any(axis not in limits for axis in axes):
        return None
    pairs = {axis.partition("_")[0]: tuple(limits[axis]) for axis in axes}
    return form.build("limits", lambda: PoseLimits(**pairs, convention=limits.get("convention", "fixed-xyz")))


def _bodies(form: Form, bodies: dict[str, Any]) -> Any:
    """Return bodies, or None after complaints."""
    names = {key: key.removesuffix("_mm").removesuffix("_kg") for key in TABLES["bodies"]}
    if any(key not in bodies for key in ("leg_body_diameter_mm", "leg_rod_diameter_mm")):
        return None
    return form.build("bodies", lambda: Bodies(**{names[key]: float(value) for key, value in bodies.items()}))
