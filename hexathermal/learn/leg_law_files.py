"""leg.toml <-> IdentifiedLaw: the unit border. The format is documented in docs/identification.md."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import tomli_w

from hexathermal.learn.campaign import ZEROS
from hexathermal.learn.law import IdentifiedLaw, Origin, Validity
from hexathermal.learn.noise import ResidualNoise
from hexathermal.learn.sensor_errors import SensorErrors
from hexathermal.machine.forms import Form
from hexathermal.machine.leg_repairs import SensorRepair
from hexathermal.machine.leg_term_files import (
    TERM_TABLES,
    check_covariance,
    joint_matrix,
    joint_table,
    power_of,
    read_repairs,
    read_terms,
    repair_table,
    term_table,
)
from hexathermal.machine.leg_terms import LegTerm
from hexathermal.machine.thermal import LARGEST_EXPANSION_PER_K
from hexathermal.machine.units import from_millionths, metres, millionths, shortest
from hexathermal.poses import FloatArray
from hexathermal.predict.table_writing import refuse_no_folder, written_whole

FORMAT = "hexathermal-leg/1"
TABLES: dict[str, dict[str, str]] = {
    "": {"format": "text!", "kind": "text!", "zero": "text!", "law": "table!", "range": "table!", "residual": "table!",
         "thermometers": "table!", "origin": "table!", "terms": "tables", "repairs": "tables"},
    "law.leg": {"sensors": "texts!", "A_per_K": "number+!", "B_per_K": "number+!", "covariance_per_K2": "matrix!",
                "q0_mm": "mm!", "stroke_mm": "mm(2)", "joint_covariance": "matrix"},
    "law.component": {"sensors": "texts!", "C_um_per_K": "number+!", "D_um_per_m_K": "number+",
                      "covariance_um2_per_K2": "matrix!", "joint_covariance": "matrix"},
    "range": {"lowest_dT_K": "number+!", "highest_dT_K": "number+!", "q_mm": "mm(2)", "temperature_degC": "number(2)"},
    "residual": {"row_um": "number!", "landing_um": "number!", "slow_um": "number!", "slow_time_s": "number!",
                 "offset_um": "number!", "interval_factor": "number!"},
    "thermometers": {"noise_K": "number+!", "slow_K": "number+!", "slow_time_s": "number!"},
    "origin": {"title": "text!", "fingerprint": "text!", "runs": "texts!", "method": "text!",
               "run_fingerprints": "texts"},
    **TERM_TABLES,
}  # fmt: skip
"""Keys of each table and their rules, see `hexathermal.machine.forms.Form`."""


def write_leg_law(law: IdentifiedLaw, path: str | Path) -> Path:
    """Write a law as leg.toml, so that reading it again gives the same law to the last bit; returns the path.

    Raises
    ------
    ArgumentError
        The file cannot be written, or there is no such folder.
    """
    file = Path(path)
    refuse_no_folder(file)
    text = tomli_w.dumps(_document(law), indent=2).encode("utf-8")
    with written_whole(file) as part:
        part.write_bytes(text)
    return file


def _mm(value: float) -> Any:
    """Return metres as the shortest exact millimetres."""
    return shortest(float(value), metres)


def _um(value: Any, power: int = 1) -> Any:
    """Return SI numbers in millionths (squared: `power` 2) as the shortest decimals that are read back the same."""
    return [_um(item, power) for item in value] if isinstance(value, np.ndarray) else millionths(value, power)


def _from_um(raw: Any, power: int = 1) -> Any:
    """Return what `_um` wrote, as it stands in the file."""
    if isinstance(raw, list):
        return np.array([_from_um(item, power) for item in raw])
    return from_millionths(raw, power)


def _document(law: IdentifiedLaw) -> dict[str, Any]:
    """Return the file's content."""
    table: dict[str, Any] = {"sensors": list(law.sensors)}
    if law.kind == "leg":
        table |= {"A_per_K": law.A.tolist(), "B_per_K": law.B.tolist(), "covariance_per_K2": law.covariance.tolist()}
        table["q0_mm"] = _mm(law.retracted_length or 0.0)
        if law.stroke is not None:
            table["stroke_mm"] = [_mm(value) for value in law.stroke]
    else:
        table["C_um_per_K"] = _um(law.A)
        if law.stroked:
            table["D_um_per_m_K"] = _um(law.B)
        table["covariance_um2_per_K2"] = _um(law.covariance, 2)
    if law.joint_covariance is not None:
        table["joint_covariance"] = joint_table(
            law.joint_covariance, _powers(law.kind, len(law.coefficients), law.terms)
        )
    valid: dict[str, Any] = {
        "lowest_dT_K": law.validity.dT[:, 0].tolist(),
        "highest_dT_K": law.validity.dT[:, 1].tolist(),
    }
    if law.validity.q is not None:
        valid["q_mm"] = [_mm(value) for value in law.validity.q]
    if law.validity.degC is not None:
        valid["temperature_degC"] = list(law.validity.degC)
    noise, errors = law.noise, law.errors
    return {
        "format": FORMAT,
        "kind": law.kind,
        "zero": law.zero,
        "law": table,
        "range": valid,
        "residual": {
            "row_um": _um(noise.row),
            "landing_um": _um(noise.landing),
            "slow_um": _um(noise.slow),
            "slow_time_s": noise.slow_time,
            "offset_um": _um(noise.offset),
            "interval_factor": law.factor,
        },
        "thermometers": {
            "noise_K": errors.noise.tolist(),
            "slow_K": errors.slow.tolist(),
            "slow_time_s": errors.slow_time,
        },
        "origin": {
            "title": law.origin.title,
            "fingerprint": law.origin.fingerprint,
            "runs": list(law.origin.runs),
            "method": law.origin.method,
        }
        | ({"run_fingerprints": list(law.origin.run_fingerprints)} if law.origin.run_fingerprints else {}),
        **({"terms": [term_table(term) for term in law.terms]} if law.terms else {}),
        **({"repairs": [repair_table(repair) for repair in law.repairs]} if law.repairs else {}),
    }


def _powers(kind: str, count: int, terms: Sequence[LegTerm]) -> list[int]:
    """Return which coefficients and amplitudes are told in millionths (1), and which as they are (0)."""
    own = [0 if kind == "leg" else 1] * count
    return [*own, *(power_of(term.shape) for term in terms for _amplitude in term.amplitudes)]


def read_leg_law(path: str | Path) -> IdentifiedLaw:
    """Return the law of a leg.toml.

    Raises
    ------
    FileFormatError
        Lists every bad field with line and column.
    ArgumentError
        There is no such file.
    """
    form = Form.opened(path, TABLES, FORMAT, "law", "a leg.toml, which 'hexathermal identify' writes")
    top = form.top
    kind = top.get("kind", "leg")
    if kind not in ("leg", "component"):
        form.complain(("kind",), f"kind must be 'leg' or 'component', found {kind!r}")
        form.finish()
    if top.get("zero", "run") not in ZEROS:
        form.complain(("zero",), f"zero must be 'run' or 'campaign', found {top['zero']!r}")
    parts: dict[str, dict[str, Any]] = {key: form.table(top[key], (key,), f"law.{kind}" if key == "law" else key)
             for key in ("law", "range", "residual", "thermometers", "origin") if key in top}  # fmt: skip
    form.finish()
    for key in ("row_um", "landing_um", "slow_um", "offset_um"):
        form.check(("residual", key), parts["residual"][key] >= 0.0, "0 or more")
    for place in (("residual", "slow_time_s"), ("residual", "interval_factor"), ("thermometers", "slow_time_s")):
        form.check(place, parts[place[0]][place[1]] > 0.0, "above 0")
    terms = read_terms(form, top.get("terms", ()), ("terms",))
    repairs = read_repairs(form, top.get("repairs", ()), ("repairs",))
    _sizes(form, kind, parts)
    form.finish()
    powers = _powers(kind, len(parts["law"]["sensors"]) * _each(parts["law"]), terms)
    if "joint_covariance" in parts["law"]:
        check_covariance(form, parts["law"]["joint_covariance"], len(powers), ("law", "joint_covariance"))
        form.finish()
    law = form.build(("law",), lambda: _law(kind, top["zero"], parts, form.data, terms, repairs))
    form.finish()
    assert law is not None  # otherwise finish has raised
    return law


def _each(law: dict[str, Any]) -> int:
    """Return how many coefficients each sensor of a law has."""
    return 1 if "C_um_per_K" in law and "D_um_per_m_K" not in law else 2


def _sizes(form: Form, kind: str, parts: dict[str, dict[str, Any]]) -> None:
    """Complain where lists do not have a value for each sensor, or a matrix is no covariance."""
    sensors = parts["law"]["sensors"]
    k = len(sensors)
    own: tuple[str, ...] = ("A_per_K", "B_per_K", "C_um_per_K", "D_um_per_m_K")
    lists = [("law", key) for key in own if key in parts["law"]]
    lists += [("range", "lowest_dT_K"), ("range", "highest_dT_K")]
    lists += [("thermometers", "noise_K"), ("thermometers", "slow_K")]
    for where in lists:
        array = np.atleast_1d(parts[where[0]][where[1]])
        if array.size != k:
            form.complain(where, f"{'.'.join(where)} has {array.size} values; expected {k}: {', '.join(sensors)}")
        elif where[0] == "thermometers":
            form.check(where, parts[where[0]][where[1]] >= 0.0, "0 or more")
        elif where[1] in ("A_per_K", "B_per_K"):
            small = np.abs(parts["law"][where[1]]) <= LARGEST_EXPANSION_PER_K
            form.check(where, small, f"within +-{LARGEST_EXPANSION_PER_K:g} /K (1/K is meant)")
        elif where[1] == "D_um_per_m_K":
            small = np.abs(parts["law"][where[1]]) <= LARGEST_EXPANSION_PER_K * 1e6
            form.check(where, small, f"within +-{LARGEST_EXPANSION_PER_K * 1e6:g} um/m/K")
    name = "covariance_per_K2" if kind == "leg" else "covariance_um2_per_K2"
    matrix, p = parts["law"][name], _each(parts["law"]) * k
    if matrix.shape != (p, p):
        form.complain(("law", name), f"law.{name} has shape {matrix.shape}; expected ({p}, {p})")
    elif not np.allclose(matrix, matrix.T, rtol=1e-9, atol=0.0):
        form.complain(("law", name), f"law.{name} must be symmetric")
    elif np.linalg.eigvalsh(matrix).min() < -1e-9 * np.abs(matrix).max():
        form.complain(("law", name), f"law.{name} has a negative eigenvalue: it is no covariance")
    runs, marks = parts["origin"]["runs"], parts["origin"].get("run_fingerprints", ())
    if marks and len(marks) != len(runs):
        said = f"origin.run_fingerprints has {len(marks)} values; expected {len(runs)}, one for each of origin.runs"
        form.complain(("origin", "run_fingerprints"), said)
    if kind == "leg":
        form.check(("law", "q0_mm"), parts["law"]["q0_mm"] > 0.0, "above 0")
    _ranges(form, parts)


def _ranges(form: Form, parts: dict[str, dict[str, Any]]) -> None:
    """Complain where a range ends below where it begins."""
    for where in (("law", "stroke_mm"), ("range", "q_mm"), ("range", "temperature_degC")):
        pair = _pair(parts[where[0]].get(where[1]))
        if pair is not None and pair[0] > pair[1]:
            form.complain(where, f"{'.'.join(where)} must be [low, high] with low not above high")
    low, high = (np.atleast_1d(parts["range"][key]) for key in ("lowest_dT_K", "highest_dT_K"))
    if low.shape == high.shape and (low > high).any():
        form.complain(("range", "highest_dT_K"), "range.highest_dT_K lies below range.lowest_dT_K")


def _pair(array: FloatArray | None) -> tuple[float, float] | None:
    """Return two numbers as a tuple."""
    return None if array is None else (float(array[0]), float(array[1]))


def _law(
    kind: str, zero: str, parts: dict[str, dict[str, Any]], raw: dict[str, Any], terms: tuple[LegTerm, ...],
    repairs: tuple[SensorRepair, ...],
) -> IdentifiedLaw:  # fmt: skip
    """Return the law of checked tables; micrometres are taken as written, so that nothing is rounded twice."""
    law, valid, noise = parts["law"], parts["range"], parts["residual"]
    errors, origin = parts["thermometers"], parts["origin"]
    if kind == "leg":
        coefficients = np.concatenate([np.atleast_1d(law["A_per_K"]), np.atleast_1d(law["B_per_K"])])
        covariance, q0 = law["covariance_per_K2"], float(law["q0_mm"])
    else:
        told = [raw["law"][key] for key in ("C_um_per_K", "D_um_per_m_K") if key in raw["law"]]
        coefficients = np.concatenate([np.atleast_1d(_from_um(values)) for values in told])
        covariance, q0 = _from_um(raw["law"]["covariance_um2_per_K2"], 2), None
    joint = None
    if "joint_covariance" in law:
        joint = joint_matrix(raw["law"]["joint_covariance"], _powers(kind, len(coefficients), terms))
    dT = np.column_stack([np.atleast_1d(valid["lowest_dT_K"]), np.atleast_1d(valid["highest_dT_K"])])
    um = {key: _from_um(raw["residual"][f"{key}_um"]) for key in ("row", "landing", "slow", "offset")}
    return IdentifiedLaw(
        kind, law["sensors"], coefficients, covariance, q0, _pair(law.get("stroke_mm")), zero,
        Validity(dT, _pair(valid.get("q_mm")), _pair(valid.get("temperature_degC"))),
        ResidualNoise(um["row"], um["landing"], um["slow"], float(noise["slow_time_s"]), um["offset"]),
        SensorErrors(np.atleast_1d(errors["noise_K"]), np.atleast_1d(errors["slow_K"]), float(errors["slow_time_s"]),
                     zero == "run"),
        float(noise["interval_factor"]),
        Origin(origin["title"], origin["fingerprint"], origin["runs"], origin["method"],
               origin.get("run_fingerprints", ())),
        terms, repairs, joint,
    )  # fmt: skip
