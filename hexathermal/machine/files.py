"""hexapod.toml <-> Hexapod: the unit border. The format is documented in docs/formats.md."""

from __future__ import annotations

import tomllib
from collections.abc import Callable
from decimal import Decimal
from pathlib import Path
from typing import Any

import numpy as np

from hexathermal.errors import ArgumentError, FileFormatError, Problem
from hexathermal.machine.bodies import Bodies, PoseLimits
from hexathermal.machine.hexapod import Hexapod
from hexathermal.machine.thermal import LegLaw, PlateLaw, ThermalModel
from hexathermal.machine.toml_positions import Positions
from hexathermal.machine.units import metres, radians, same
from hexathermal.poses import FloatArray

FORMAT = "hexathermal-hexapod/1"
Reader = Callable[[Decimal], float]

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
"""Keys of each table: kind, shape in brackets, ``!`` required, ``+`` one or more, ``6`` one or six."""

_READERS: dict[str, Reader] = {"mm": metres, "deg": radians, "number": same, "matrix": same}


class _Form:
    """A TOML file being read: collects every problem before anything is raised."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.problems: list[Problem] = []
        try:
            text = path.read_bytes().decode("utf-8")
            self.positions = Positions(text)
            self.data: dict[str, Any] = tomllib.loads(text, parse_float=Decimal)
        except UnicodeDecodeError as error:
            raise FileFormatError(str(path), (Problem(1, 1, f"not a text file in UTF-8: {error.reason}"),)) from None
        except tomllib.TOMLDecodeError as error:
            line, column = getattr(error, "lineno", None), getattr(error, "colno", None)
            if line is None:
                digits = [
                    int(word) for word in str(error).replace(",", " ").replace(")", " ").split() if word.isdigit()
                ]
                line, column = digits[-2:] if len(digits) >= 2 else (max(1, text.count("\n")), 1)
            raise FileFormatError(str(path), (Problem(line, column or 1, f"not valid TOML: {error}"),)) from None

    def complain(self, where: str, message: str) -> Any:
        """Note a problem; returns None, so that a caller may return it."""
        line, column = self.positions.of(where)
        self.problems.append(Problem(line, column, message))
        return None

    def table(self, data: dict[str, Any], path: str, kind: str) -> dict[str, Any]:
        """Return the checked values of one table: numbers as arrays in SI units."""
        keys, found = TABLES[kind], {}
        for key in data:
            if key not in keys:
                self.complain(_join(path, key), f"unknown key {key!r}; known: {', '.join(keys)}")
        for key, rule in keys.items():
            if key in data:
                value = self.value(data[key], _join(path, key), rule.rstrip("!"))
                if value is not None:
                    found[key] = value
            elif rule.endswith("!"):
                self.complain(path, f"key {key!r} is missing{f' in [{path}]' if path else ''}")
        return found

    def value(self, value: Any, where: str, rule: str) -> Any:
        """Return one value after checking it against its rule, or None after a complaint."""
        simple: dict[str, tuple[type, str]] = {"text": (str, "a text"), "table": (dict, "a table"), "tables": (list, "tables [[...]]")}
        if rule in simple:
            kind, words = simple[rule]
            if isinstance(value, kind):
                return value
            return self.complain(where, f"{where} must be {words}, found {_shown(value)}")
        if rule == "texts":
            texts = [value] if isinstance(value, str) else value
            if isinstance(texts, list) and texts and all(isinstance(text, str) and text for text in texts):
                return tuple(texts)
            return self.complain(where, f"{where} must be a list of names, found {_shown(value)}")
        unit = rule.partition("(")[0].rstrip("+6|2") if rule[:2] == "mm" else rule.partition("(")[0].rstrip("+6")
        array = self.numbers(value, where, _READERS["mm" if unit.startswith("mm") else unit])
        if array is None:
            return None
        if not _shape_fits(array.shape, rule):
            wanted = _SHAPES.get(rule, "shape " + rule.partition("(")[2].rstrip(")").join("()"))
            return self.complain(where, f"{where} has shape {array.shape}; expected {wanted}")
        return array

    def numbers(self, value: Any, where: str, reader: Reader) -> Any:
        """Return nested lists of numbers as an array in SI units, or None after a complaint."""

        def walk(item: Any) -> Any:
            if isinstance(item, list):
                return [walk(entry) for entry in item]
            if isinstance(item, bool) or not isinstance(item, int | Decimal):
                raise TypeError(f"{where} must hold numbers, found {_shown(item)}")
            number = reader(Decimal(item))
            if not np.isfinite(number):
                raise TypeError(f"{where} must hold finite numbers, found {item}")
            return number

        try:
            return np.asarray(walk(value), dtype=np.float64)
        except TypeError as error:
            return self.complain(where, str(error))
        except ValueError:
            return self.complain(where, f"{where} has rows of different length")

    def build(self, where: str, make: Callable[[], Any]) -> Any:
        """Return what `make` makes, or None after a complaint at `where`."""
        try:
            return make()
        except ArgumentError as error:
            return self.complain(where, str(error))

    def finish(self) -> None:
        """Raise all complaints together, in the order of the file."""
        if self.problems:
            raise FileFormatError(str(self.path), tuple(sorted(self.problems, key=lambda p: (p.line, p.column))))


_SHAPES = {"mm6": "one value, or six", "deg6": "one value, or six", "mm": "one value", "number": "one value",
           "number+": "one value, or a list", "mm2|mm(6,2)": "[low, high], or six such pairs",
           "matrix": "a square matrix"}  # fmt: skip


def _shape_fits(shape: tuple[int, ...], rule: str) -> bool:
    """Whether an array's shape is what a rule asks for."""
    if rule in ("mm6", "deg6"):
        return shape in ((), (6,))
    if rule in ("mm", "number"):
        return shape == ()
    if rule == "number+":
        return len(shape) <= 1 and shape != (0,)
    if rule == "mm2|mm(6,2)":
        return shape in ((2,), (6, 2))
    if rule == "matrix":
        return len(shape) == 2 and shape[0] == shape[1]
    return shape == tuple(int(n) for n in rule.partition("(")[2].rstrip(")").split(","))


def _join(path: str, key: str) -> str:
    return f"{path}.{key}" if path else key


def _shown(value: Any) -> str:
    text = repr(value) if not isinstance(value, Decimal) else str(value)
    return text if len(text) <= 60 else text[:57] + "..."


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
    form = _Form(file)
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


def _leg(form: _Form, data: Any, path: str) -> Any:
    """Return one leg's law, or None after a complaint."""
    if not isinstance(data, dict):
        return form.complain(path, f"{path} must be a table, found {_shown(data)}")
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


def _plate(form: _Form, thermal: dict[str, Any], part: str) -> Any:
    """Return one plate's law, or None where there is none or after a complaint."""
    if part not in thermal:
        return None
    path = f"thermal.{part}"
    plate = form.table(thermal[part], path, "thermal.plate")
    if "expansion_per_K" not in plate:
        return None
    return form.build(path, lambda: PlateLaw(float(plate["expansion_per_K"]), plate.get("sensor")))


def _thermal(form: _Form, data: dict[str, Any]) -> Any:
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


def _limits(form: _Form, limits: dict[str, Any]) -> Any:
    """Return travel limits, or None after complaints."""
    axes = ("x_mm", "y_mm", "z_mm", "rx_deg", "ry_deg", "rz_deg")
    if any(axis not in limits for axis in axes):
        return None
    pairs = {axis.partition("_")[0]: tuple(limits[axis]) for axis in axes}
    return form.build("limits", lambda: PoseLimits(**pairs, convention=limits.get("convention", "fixed-xyz")))


def _bodies(form: _Form, bodies: dict[str, Any]) -> Any:
    """Return bodies, or None after complaints."""
    names = {key: key.removesuffix("_mm").removesuffix("_kg") for key in TABLES["bodies"]}
    if any(key not in bodies for key in ("leg_body_diameter_mm", "leg_rod_diameter_mm")):
        return None
    return form.build("bodies", lambda: Bodies(**{names[key]: float(value) for key, value in bodies.items()}))
