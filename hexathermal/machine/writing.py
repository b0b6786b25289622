"""Hexapod -> hexapod.toml, so that reading it again gives the same machine to the last bit."""

from __future__ import annotations

import os
import re
from pathlib import Path
from typing import Any

import numpy as np
import tomli_w

from hexathermal.errors import ArgumentError
from hexathermal.machine.extension_files import compliance_table, measuring_frame_table
from hexathermal.machine.files import FORMAT
from hexathermal.machine.forms import Reader
from hexathermal.machine.hexapod import Hexapod
from hexathermal.machine.leg_term_files import term_table
from hexathermal.machine.thermal import LegLaw, PlateLaw, ThermalModel
from hexathermal.machine.thermometers import AS_RECORDED
from hexathermal.machine.units import metres, radians, same, shortest
from hexathermal.poses import FloatArray

_ROW = re.compile(r"\[\s*\n([^\[\]\"]*?),?\s*\n\s*\]")
"""An innermost array of numbers that is spread over lines."""


def _on_one_line(row: re.Match[str]) -> str:
    """Return a row of numbers on one line."""
    return "[" + " ".join(row.group(1).split()) + "]"


def machine_file(path: Path) -> Path:
    """Return the file of a machine: a path that ends in ``.toml`` is it, any other the folder of ``hexapod.toml``.

    Examples
    --------
    >>> machine_file(Path("my-machine")).as_posix()
    'my-machine/hexapod.toml'
    """
    return path if path.suffix == ".toml" and not os.path.isdir(path) else path / "hexapod.toml"


def write_hexapod(hexapod: Hexapod, path: str | Path) -> Path:
    """Write a machine as hexapod.toml; returns the file's path.

    A path that ends in ``.toml`` is the file, any other the folder that gets ``hexapod.toml``; folders are made. The
    file is written whole or not at all.

    Raises
    ------
    ArgumentError
        Home is turned: the format holds a home position only. A text is no Unicode. The place cannot be written.
    """
    if not isinstance(hexapod, Hexapod):
        raise ArgumentError(f"hexapod must be a Hexapod, not {type(hexapod).__name__}")
    if not isinstance(path, str | os.PathLike):
        raise ArgumentError(f"a machine file is named by a text or a path, not by {type(path).__name__}")
    file = machine_file(Path(path))
    try:
        text = _ROW.sub(_on_one_line, tomli_w.dumps(_document(hexapod), indent=2)).encode("utf-8")
    except UnicodeEncodeError as error:
        raise ArgumentError(f"a text of machine {hexapod.name!r} cannot be written in UTF-8: {error}") from None
    part = file.with_suffix(".toml.part")
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        try:
            part.write_bytes(text)
            os.replace(part, file)
        finally:
            part.unlink(missing_ok=True)
    except (OSError, ValueError) as error:
        why = getattr(error, "strerror", None) or error
        raise ArgumentError(f"cannot write the machine file {str(file)!r}: {why}; choose another place") from error
    return file


def _numbers(array: FloatArray | float, reader: Reader) -> Any:
    """Return an array as nested lists of the shortest exact decimals."""
    if isinstance(array, np.ndarray) and array.ndim:
        return [_numbers(row, reader) for row in array]
    return float(array) if reader is same else shortest(float(array), reader)


def _one_or_all(array: FloatArray, reader: Reader) -> Any:
    """Return one entry where all are the same; as texts, since 0 and -0 are equal as numbers."""
    entries = _numbers(array, reader)
    return entries[0] if len({str(entry) for entry in entries}) == 1 else entries


def _document(hexapod: Hexapod) -> dict[str, Any]:
    """Return the file's content."""
    if not np.array_equal(hexapod.home[:3, :3], np.eye(3)):
        raise ArgumentError(
            "hexapod.toml holds a home position only: turn the platform frame so that home is not turned"
        )
    document: dict[str, Any] = {
        "format": FORMAT,
        "name": hexapod.name,
        "source": hexapod.source,
        "grade": hexapod.grade,
    }
    document["geometry"] = _geometry(hexapod)
    if hexapod.thermal is not None:
        document["thermal"] = _thermal(hexapod.thermal)
    if hexapod.limits is not None:
        limits = hexapod.limits
        axes: dict[str, Any] = {"convention": limits.convention}
        for axis in ("x", "y", "z"):
            axes[f"{axis}_mm"] = _numbers(np.array(getattr(limits, axis)), metres)
        for axis in ("rx", "ry", "rz"):
            axes[f"{axis}_deg"] = _numbers(np.array(getattr(limits, axis)), radians)
        document["limits"] = axes
    if hexapod.bodies is not None:
        bodies = hexapod.bodies
        kg = ("leg_body_mass", "leg_rod_mass", "platform_mass")
        mm = ("leg_body_diameter", "leg_rod_diameter", "platform_thickness", "base_thickness")
        document["bodies"] = {f"{key}_mm": _numbers(getattr(bodies, key), metres) for key in mm}
        document["bodies"] |= {f"{key}_kg": _numbers(getattr(bodies, key), same) for key in kg}
    if hexapod.compliance is not None:
        document["compliance"] = compliance_table(hexapod.compliance)
    if hexapod.measuring_frame is not None:
        document["measuring_frame"] = measuring_frame_table(hexapod.measuring_frame)
    return document


def _geometry(hexapod: Hexapod) -> dict[str, Any]:
    """Return the table [geometry]."""
    table: dict[str, Any] = {
        "base_joints_mm": _numbers(hexapod.base_joints, metres),
        "platform_joints_mm": _numbers(hexapod.platform_joints, metres),
        "home_mm": _numbers(hexapod.home[:3, 3], metres),
    }
    if hexapod.retracted_length is not None:
        table["q0_mm"] = _one_or_all(hexapod.retracted_length, metres)
    if hexapod.stroke is not None:
        table["stroke_mm"] = _one_or_all(hexapod.stroke, metres)
    if hexapod.base_cone is not None:
        table["base_cone_deg"] = _one_or_all(hexapod.base_cone, radians)
    if hexapod.platform_cone is not None:
        table["platform_cone_deg"] = _one_or_all(hexapod.platform_cone, radians)
    return table


def _thermal(model: ThermalModel) -> dict[str, Any]:
    """Return the table [thermal]."""
    table: dict[str, Any] = {
        "reference_temperature_degC": _one_or_all(model.reference_temperature_degC, same),
        "valid_degC": _numbers(np.array(model.valid_degC), same),
    }
    if model.thermometers_of_leg != AS_RECORDED:
        table["thermometers_of_leg"] = list(model.thermometers_of_leg)
    legs = [_leg(law) for law in model.legs]
    if len({str(leg) for leg in legs}) == 1:
        table["leg"] = legs[0]
    else:
        table["legs"] = legs
    for part, plate in (("platform", model.platform), ("base", model.base)):
        if plate is not None:
            table[part] = _plate(plate)
    return table


def _leg(law: LegLaw) -> dict[str, Any]:
    """Return one leg's table."""
    table: dict[str, Any] = {
        "sensors": list(law.sensors),
        "A_per_K": _numbers(law.A, same),
        "B_per_K": _numbers(law.B, same),
    }
    if law.covariance is not None:
        table["covariance_per_K2"] = _numbers(law.covariance, same)
    if law.spread is not None:
        table["spread_per_K"] = _numbers(law.spread, same)
    if law.campaign:
        table["campaign"] = law.campaign
    if law.terms:
        table["terms"] = [term_table(term) for term in law.terms]
    return table


def _plate(plate: PlateLaw) -> dict[str, Any]:
    """Return one plate's table."""
    table: dict[str, Any] = {"expansion_per_K": plate.expansion}
    if plate.sensor is not None:
        table["sensor"] = plate.sensor
    if plate.expansion_std is not None:
        table["expansion_std_per_K"] = plate.expansion_std
    return table
