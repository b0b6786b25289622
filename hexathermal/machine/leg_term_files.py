"""Terms and repairs of a law in TOML files: ``[[terms]]`` and ``[[repairs]]``, see docs/formats.md.

A term's table holds ``cause``, ``shape``, the shape's parameters, ``amplitudes`` with their ``unit`` and
``covariance`` (in the square of that unit). Lengths are millimetres in files: ``pitch_m`` of a term is ``pitch_mm``
there. A shape that has no entry in `PARAMETERS` takes whatever parameters its table holds.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from decimal import Decimal
from typing import Any

import numpy as np

from hexathermal.machine.forms import Form, dotted, shown
from hexathermal.machine.leg_repairs import KINDS, SensorRepair
from hexathermal.machine.leg_terms import BY_MOTION, SHAPES, WEATHERS, WEIGHED, LegTerm
from hexathermal.machine.toml_positions import Where
from hexathermal.machine.units import from_millionths, metres, millionths, shortest
from hexathermal.poses import FloatArray

PARAMETERS: dict[str, dict[str, str]] = {
    "lag": {"sensor": "text!", "ratio": "number!", "time_constant_s": "number!", "order": "number"},
    "lead": {"sensor": "text!", "ratio": "number!", "time_constant_s": "number!"},
    "lead-by-motion": {
        "sensor": "text!",
        "ratio": "number!",
        "time_constant_s": "number!",
        "heat_times_s": "number+!",
        "once": "number+!",
        "twice": "number+!",
    },
    "foretold": {"sensor": "text!", "weights": "table!", "ratio": "number!"}
    | {"time_constant_s": "number!", "order": "number"},
    "temperature": {"sensor": "text!", "ratio": "number!", "weights": "table"},
    "expansion": {"sensor": "text!"},
    "stored-heat": {
        "source": "text!",
        "power": "number",
        "time_constant_s": "number!",
        "source_time_constant_s": "number",
        "source_share": "number",
        "ratio": "number",
    },
    "square": {
        "sensor": "text!",
        "ratio": "number!",
        "weights": "table",
        "reference_degC": "number",
        "calibration_degC": "number",
    },
    "cube": {"sensor": "text!", "ratio": "number!"},
    "bend": {
        "sensor": "text!",
        "ratio": "number!",
        "middle_degC": "number!",
        "width_K": "number!",
        "calibration_degC": "number",
    },
    "room": {"time_constant_s": "number!", "order": "number", "sensor": "text"},
    "air-index": {
        "path_mm": "mm!",
        "stroke_share": "number!",
        "reference_index": "number",
        "weather": "text",
        "time_constant_s": "number",
    },
    "tilt": {},
    "direction": {"play_mm": "mm", "approach": "number"},
    "periodic": {"pitch_mm": "mm!"},
    "wave": {"pitch_mm": "mm!", "origin_mm": "mm!"},
    "position": {},
    "relaxation": {
        "time_constant_s": "number!",
        "kick": "text!",
        "decades": "number",
        "saturation_mm": "mm",
        "renewed": "number",
    },
    "time": {},
}
"""Parameters of each shape in files and their rules, see `hexathermal.machine.forms.Form`."""

POSITIVE = {
    "lag": ("time_constant_s", "order"), "lead": ("time_constant_s",), "lead-by-motion": ("time_constant_s",),
    "foretold": ("time_constant_s", "order"),
    "relaxation": ("time_constant_s", "saturation_mm"), "periodic": ("pitch_mm",), "wave": ("pitch_mm",),
    "bend": ("width_K",), "direction": ("play_mm",),
}  # fmt: skip
"""Parameters that must be above 0; other time constants may be 0, which stands for no delay."""

UNITS = {"lag": "1/K", "lead": "1/K", "lead-by-motion": "1/K", "foretold": "1/K", "temperature": "1/K",
         "expansion": "1/K",
         "square": "1/K^2", "cube": "1/K^3", "bend": "1/K^2", "air-index": "1", "position": "1",
         "room": "um/K", "tilt": "um/rad", "time": "um/h"}  # fmt: skip
"""Units of the amplitudes of each shape; of the others micrometres for a unit of the column."""

COUNTS = {"lead": 2, "expansion": 2, "tilt": 2, "periodic": 2}
"""Amplitudes of shapes that have more than one."""

MOST_DECADES = 6.0
DENSEST_AIR = 1.001
KICKS = ("direction", "move", "step", "begin")

TERM = {"cause": "text!", "shape": "text!", "amplitudes": "number+!", "unit": "text!", "covariance": "matrix"}
REPAIRS: dict[str, dict[str, str]] = {
    "clock": {"offset_s": "number!", "gains_s_per_h": "number"},
    "swap": {"first": "text!", "second": "text!", "not_in": "texts", "only_in": "texts", "zero_else": "texts"},
    "drift": {"sensor": "text!", "rate_K_per_h": "number!", "rates_K_per_h": "table"},
    "detached": {"sensor": "text!", "weights": "table!", "from_s": "table", "again_in": "texts"},
    "loose": {"sensor": "text!", "share": "number!", "from_s": "table", "again_in": "texts", "air_above_K": "table"}
    | {"air_sensor": "text"},
}

TERM_TABLES: dict[str, dict[str, str]] = {
    "term": TERM,
    **{f"term {shape}": TERM | rules for shape, rules in PARAMETERS.items()},
    **{f"repair {kind}": {"cause": "text!", "kind": "text!"} | rules for kind, rules in REPAIRS.items()},
}
"""Tables that a file with terms and repairs must know."""


def unit_of(shape: str) -> str:
    """Return the unit of a shape's amplitudes."""
    return UNITS.get(shape, "um")


def power_of(shape: str) -> int:
    """Return 1 where a shape's amplitudes are told in micrometres, else 0."""
    return int(unit_of(shape).startswith("um"))


def scaled(value: Any, power: int) -> Any:
    """Return SI numbers, a matrix of them too, as decimals in millionths (squared: `power` 2), or as they are (0)."""
    if isinstance(value, np.ndarray) and value.ndim:
        return [scaled(item, power) for item in value]
    return millionths(float(value), power) if power else float(value)


def unscaled(raw: Any, power: int) -> Any:
    """Return what `scaled` made, as it stands in a file."""
    if isinstance(raw, list):
        return np.array([unscaled(item, power) for item in raw])
    return from_millionths(raw, power) if power else float(raw)


def term_table(term: LegTerm) -> dict[str, Any]:
    """Return a term as a file holds it."""
    power = power_of(term.shape)
    table: dict[str, Any] = {"cause": term.cause, "shape": term.shape}
    for key, value in term.parameters.items():
        if key.endswith("_m"):
            lengths = np.asarray(value, dtype=np.float64)
            table[f"{key}m"] = (
                [shortest(one, metres) for one in lengths.tolist()]
                if lengths.ndim
                else shortest(float(lengths), metres)
            )
        else:
            table[key] = _plain(value)
    return table | {"amplitudes": scaled(term.amplitudes, power), "unit": unit_of(term.shape),
                    "covariance": scaled(term.covariance, 2 * power)}  # fmt: skip


def repair_table(repair: SensorRepair) -> dict[str, Any]:
    """Return a repair as a file holds it."""
    own = {key: _plain(value) for key, value in repair.parameters.items()}
    return {"cause": repair.cause, "kind": repair.kind} | own


def _plain(value: Any) -> Any:
    """Return texts and numbers of any make as TOML knows them."""
    if isinstance(value, str | bool):
        return value
    if isinstance(value, Mapping):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, Sequence | np.ndarray):
        return [_plain(item) for item in value]
    return int(value) if isinstance(value, int | np.integer) else float(value)


def read_terms(form: Form, data: Any, path: Where) -> tuple[LegTerm, ...]:
    """Return the terms of ``[[terms]]``; what is wrong is complained of."""
    return tuple(term for term in (_read_term(form, one, (*path, k)) for k, one in enumerate(data)) if term is not None)


def read_repairs(form: Form, data: Any, path: Where) -> tuple[SensorRepair, ...]:
    """Return the repairs of ``[[repairs]]``; what is wrong is complained of."""
    found = (_read_repair(form, one, (*path, k)) for k, one in enumerate(data))
    return tuple(repair for repair in found if repair is not None)


def _named(form: Form, data: Any, path: Where, key: str, known: Sequence[str]) -> str | None:
    """Return the name that tells how a table is to be read, or None after a complaint."""
    if not isinstance(data, dict):
        form.complain(path, f"{dotted(path)} must be a table, found {shown(data)}")
    elif key not in data:
        form.complain(path, f"key {key!r} is missing in [[{dotted(path)}]]; one of: {', '.join(known)}")
    elif data[key] not in known:
        form.complain((*path, key), f"{dotted((*path, key))} must be one of: {', '.join(known)}; "
                                    f"found {shown(data[key])}")  # fmt: skip
    else:
        return str(data[key])
    return None


def _read_term(form: Form, data: Any, path: Where) -> LegTerm | None:
    """Return one term, or None after complaints."""
    shape = _named(form, data, path, "shape", tuple(SHAPES))
    if shape is None:
        return None
    before = len(form.problems)
    if shape in PARAMETERS:
        found = form.table(data, path, f"term {shape}")
        _read_numbers(form, found, path)
    else:
        own = {key: value for key, value in data.items() if key in TERM}
        found = form.table(own, path, "term") | _free(form, data, path)
    parameters = {key: value for key, value in found.items() if key not in TERM}
    _check_parameters(form, shape, parameters, path)
    amplitudes = found.get("amplitudes")
    if "unit" in found and found["unit"] != unit_of(shape):
        form.complain((*path, "unit"), f"{dotted((*path, 'unit'))} of shape {shape!r} must be {unit_of(shape)!r}, "
                                       f"found {shown(found['unit'])}")  # fmt: skip
    if amplitudes is not None:
        _check_amplitudes(form, shape, amplitudes, found.get("covariance"), path)
    if len(form.problems) > before or amplitudes is None:
        return None
    power = power_of(shape)
    sizes = np.atleast_1d(unscaled(data["amplitudes"], power) if power else amplitudes)
    covariance = np.zeros((0, 0))
    if "covariance" in found:
        covariance = unscaled(data["covariance"], 2 * power) if power else found["covariance"]
    own = {f"{key[:-2]}m" if key.endswith("_mm") else key: _number(value) for key, value in parameters.items()}
    return form.build(path, lambda: LegTerm(found["cause"], shape, own, sizes, covariance))


def _number(value: Any) -> Any:
    """Return an array as a number, or a list of them."""
    return value.tolist() if isinstance(value, np.ndarray) else value


def _free(form: Form, data: dict[str, Any], path: Where) -> dict[str, Any]:
    """Return parameters of a shape that has no rules: texts, flags, lengths in mm and other numbers."""
    found = {}
    for key, value in data.items():
        if key not in TERM:
            plain = isinstance(value, str | bool)
            size = f"({len(value)})" if isinstance(value, list) else ""
            rule = f"mm{size}" if key.endswith("_mm") else "number+"
            read = value if plain else form.value(value, (*path, key), rule)
            if read is not None:
                found[key] = read
    return found


def _check_parameters(form: Form, shape: str, parameters: Mapping[str, Any], path: Where) -> None:
    """Complain of parameters that no shape can be made with."""
    positive = POSITIVE.get(shape, ())
    for key, value in parameters.items():
        if key in positive:
            form.check((*path, key), value > 0.0, "above 0")
        elif key in ("time_constant_s", "source_time_constant_s") and shape in PARAMETERS:
            form.check((*path, key), value >= 0.0, "0 or more")
        elif key in ("sensor", "source"):
            form.check((*path, key), bool(value), "a name")
        elif key == "weights" and shape in WEIGHED:
            form.check((*path, key), bool(value), "those of one sensor or more")
            parts = shape != "square" or (all(part >= 0.0 for part in value.values()) and sum(value.values()) > 0.0)
            form.check((*path, key), parts or not value, "parts of the length: 0 or more, one of them above 0")
        elif key == "weights" and shape in PARAMETERS:
            form.check((*path, key), bool(value) and parameters.get("sensor") not in value, "those of other sensors")
    if shape == BY_MOTION and parameters.keys() >= {"heat_times_s", "once", "twice"}:
        _check_heats(form, parameters, path)
    if "order" in parameters and shape in ("lag", "foretold", "room"):
        form.check((*path, "order"), parameters["order"] in (1.0, 2.0), "1 or 2")
    if "reference_index" in parameters and shape == "air-index":
        form.check(
            (*path, "reference_index"), 1.0 <= parameters["reference_index"] <= DENSEST_AIR, f"1 to {DENSEST_AIR:g}"
        )
    if "weather" in parameters and shape == "air-index":
        known = ", ".join(map(repr, WEATHERS))
        form.check((*path, "weather"), parameters["weather"] in WEATHERS, f"{known}, or left out")
    if "source_share" in parameters and shape == "stored-heat":
        form.check((*path, "source_share"), 0.0 <= parameters["source_share"] <= 1.0, "0 to 1")
    if "decades" in parameters and shape == "relaxation":
        form.check((*path, "decades"), 0.0 <= parameters["decades"] <= MOST_DECADES, f"0 to {MOST_DECADES:g}")
    if "approach" in parameters and shape == "direction":
        form.check((*path, "approach"), -1.0 <= parameters["approach"] <= 1.0, "-1 to 1")
    if "renewed" in parameters and shape == "relaxation":
        allowed = (0.0,) if parameters.get("kick") in ("step", "begin") else (0.0, 1.0)
        form.check((*path, "renewed"), parameters["renewed"] in allowed, "0 or 1, with kick 'step' or 'begin' 0")
    if "saturation_mm" in parameters and shape == "relaxation":
        form.check((*path, "saturation_mm"), parameters.get("kick") != "begin", "of moves, not with kick 'begin'")
    if "kick" in parameters and shape == "relaxation":
        form.check((*path, "kick"), parameters["kick"] in KICKS, f"one of: {', '.join(KICKS)}")


def _check_heats(form: Form, parameters: Mapping[str, Any], path: Where) -> None:
    """Complain of low passes of the speed that are no lists of one length, or of one time twice."""
    lists = {key: np.asarray(parameters[key]) for key in ("heat_times_s", "once", "twice")}
    for key, values in lists.items():
        form.check((*path, key), values.ndim == 1, "a list")
    times = np.atleast_1d(lists.pop("heat_times_s"))
    apart = len(set(times.tolist())) == len(times)
    form.check((*path, "heat_times_s"), apart and bool((times > 0.0).all()), "times above 0, none of them twice")
    for key, values in lists.items():
        form.check((*path, key), values.size == times.size, f"as many as heat_times_s: {times.size}")


def _check_amplitudes(
    form: Form, shape: str, amplitudes: FloatArray, covariance: FloatArray | None, path: Where
) -> None:
    """Complain of amplitudes that do not fit the shape, and of a matrix that is no covariance of them."""
    k, wanted = amplitudes.size, COUNTS.get(shape, 1)
    if shape in PARAMETERS and k != wanted:
        form.complain((*path, "amplitudes"), f"{dotted((*path, 'amplitudes'))} has {k} values; expected {wanted}")
    elif covariance is not None:
        check_covariance(form, covariance, k, (*path, "covariance"))


def check_covariance(form: Form, matrix: FloatArray, size: int, where: Where) -> None:
    """Complain of a matrix that is no covariance of `size` numbers."""
    name = dotted(where)
    if matrix.shape != (size, size):
        form.complain(where, f"{name} has shape {matrix.shape}; expected ({size}, {size})")
    elif not np.allclose(matrix, matrix.T, rtol=1e-9, atol=0.0):
        form.complain(where, f"{name} must be symmetric")
    elif not is_covariance(matrix):
        form.complain(where, f"{name} has a negative eigenvalue: it is no covariance")


def is_covariance(matrix: FloatArray) -> bool:
    """Whether a symmetric matrix has no negative eigenvalue, numbers of very different units told apart."""
    scale = np.sqrt(np.abs(np.diagonal(matrix)))
    scale = np.where(scale > 0.0, scale, 1.0)
    return bool(np.linalg.eigvalsh(matrix / np.outer(scale, scale)).min(initial=0.0) >= -1e-9 * len(matrix))


def _read_repair(form: Form, data: Any, path: Where) -> SensorRepair | None:
    """Return one repair, or None after complaints."""
    kind = _named(form, data, path, "kind", tuple(KINDS))
    if kind is None:
        return None
    before = len(form.problems)
    found = form.table(data, path, f"repair {kind}")
    _read_numbers(form, found, path)
    if len(form.problems) > before:
        return None
    parameters = {key: _number(value) for key, value in found.items() if key not in ("cause", "kind")}
    return form.build(path, lambda: SensorRepair(found["cause"], kind, parameters))


def _read_numbers(form: Form, found: dict[str, Any], path: Where) -> None:
    """Read tables of numbers by name, in place; what is no number is complained of."""
    for key in ("weights", "from_s", "rates_K_per_h", "air_above_K"):
        if key in found:
            numbers = {name: form.value(value, (*path, key, name), "number") for name, value in found[key].items()}
            found[key] = {name: float(value) for name, value in numbers.items() if value is not None}


def joint_table(matrix: FloatArray, powers: Sequence[int]) -> list[list[Decimal | float]]:
    """Return a joint covariance of numbers that are told in millionths (power 1) or as they are (0)."""
    return [[scaled(matrix[i, j], powers[i] + powers[j]) for j in range(len(powers))] for i in range(len(powers))]


def joint_matrix(raw: list[list[Any]], powers: Sequence[int]) -> FloatArray:
    """Return what `joint_table` made, as it stands in a file."""
    return np.array([[unscaled(value, powers[i] + powers[j]) for j, value in enumerate(row)]
                     for i, row in enumerate(raw)])  # fmt: skip
