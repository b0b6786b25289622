"""What a machine must keep to: a specification read from TOML. The format is documented in docs/acceptance.md."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from hexathermal.machine.forms import Form, dotted, meant, shown
from hexathermal.machine.toml_positions import Where
from hexathermal.predict.acceptance.decision_rules import RULES
from hexathermal.predict.acceptance.quantities import ETVE, QUANTITIES, Quantity

FORMAT = "hexathermal-spec/1"

TABLES: dict[str, dict[str, str]] = {
    "": {"format": "text!", "title": "text", "rule": "text", "probability": "number", "coverage_factor": "number",
         "letters": "text", "warm_up_s": "number", "uncertainty": "table", "limits": "table!"},
    "uncertainty": {"position_um": "number", "rotation_urad": "number"},
    "limit": {"upper": "number", "lower": "number", "within": "number", "u": "number", "U": "number", "k": "number",
              "rule": "text", "probability": "number", "nonnegative": "flag", "window_s": "number", "gap_s": "number",
              "poses": "texts"},
}  # fmt: skip
"""Keys of each table and their rules, see `hexathermal.machine.forms.Form`."""

ZONE = ("upper", "lower", "within")
"""Keys that bound a quantity."""

LETTERS = {"xyz": ("rx", "ry", "rz"), "zyx": ("rz", "ry", "rx")}
"""Angles of the coordinates that the letters a, b, c stand for."""

PER_UNIT = 1e6
"""Micrometres in a metre, microradians in a radian: numbers are divided, which rounds once."""


@dataclass(frozen=True)
class Limit:
    """One limit of a specification.

    Attributes
    ----------
    quantity : Quantity
    key : str
        As it stands in the file.
    lower, upper : float or None [m] or [rad]
    uncertainty : float or None [m] or [rad]
        Standard uncertainty of the quantity; None where the measurements themselves must tell, or none is needed.
    rule : str
    probability, coverage_factor : float
    nonnegative : bool
    window : float or None [s]
        Of ETVE; None: the whole record.
    gap : float or None [s]
        Of ETVE: longest time between samples with which it may pass; None: `allowed_gap`.
    poses : tuple of str
        Poses it holds for; empty: all.
    """

    quantity: Quantity
    key: str
    lower: float | None
    upper: float | None
    uncertainty: float | None = None
    rule: str = "iso-14253-1"
    probability: float = 0.95
    coverage_factor: float = 2.0
    nonnegative: bool = False
    window: float | None = None
    gap: float | None = None
    poses: tuple[str, ...] = ()


@dataclass(frozen=True)
class Specification:
    """Limits that a machine must keep, and how they are decided.

    Attributes
    ----------
    title : str
    limits : tuple of Limit
    warm_up : float or None [s]
        End of warming for d60 and dt; None: the last row.
    path : str
    """

    title: str
    limits: tuple[Limit, ...]
    warm_up: float | None = None
    path: str = ""


def read_specification(path: str | Path) -> Specification:
    """Return the specification of a TOML file.

    Raises
    ------
    ArgumentError
        There is no such file.
    FileFormatError
        Lists every bad field with line and column.
    """
    form = Form.opened(path, TABLES, FORMAT, "specification", "a TOML file")
    top = form.top
    letters = top.get("letters")
    if letters is not None and letters not in LETTERS:
        form.complain(("letters",), f"letters must be one of {', '.join(LETTERS)}, found {letters!r}")
        letters = None
    common = _decided_by(form, top, ())
    common["uncertainty"] = _common_uncertainty(form, top.get("uncertainty"))
    limits = []
    for key, value in top.get("limits", {}).items():
        if value == []:
            form.complain(("limits", key), f"{key} is an empty list: it limits nothing; state a limit, or leave it out")
        entries = value if isinstance(value, list) and all(isinstance(item, dict) for item in value) else [value]
        for k, entry in enumerate(entries):
            place = ("limits", key, k) if entries is value else ("limits", key)
            limits.append(_limit(form, key, entry, place, common, letters))
    if "limits" in top and not top["limits"]:
        form.complain(("limits",), "limits holds no limit: nothing could be decided")
    warm_up = top.get("warm_up_s")
    if warm_up is not None:
        form.check(("warm_up_s",), warm_up >= 3600.0, "at least 3600 (d60 is taken after 60 minutes)")
    form.finish()
    title = str(top.get("title", "")).strip() or form.path.stem
    whole = tuple(limit for limit in limits if limit is not None)
    return Specification(title, whole, None if warm_up is None else float(warm_up), str(form.path))


def _decided_by(form: Form, found: dict[str, Any], path: Where) -> dict[str, Any]:
    """Return rule, probability and coverage factor that a table states."""
    fields: dict[str, Any] = {}
    if "rule" in found:
        if found["rule"].lower() in RULES:
            fields["rule"] = found["rule"].lower()
        else:
            close = meant(found["rule"].lower(), RULES, 3)
            message = (
                f"decision rule {found['rule']!r} is not known; {close + ' ' * bool(close)}known: {', '.join(RULES)}"
            )
            form.complain((*path, "rule"), message)
    if "probability" in found:
        p = found["probability"]
        if form.check((*path, "probability"), (p > 0.5) & (p < 1.0), "above 0.5 and below 1"):
            fields["probability"] = float(p)
    for key in ("k", "coverage_factor"):
        if key in found and form.check((*path, key), found[key] > 0.0, "above 0"):
            fields["coverage_factor"] = float(found[key])
    return fields


def _common_uncertainty(form: Form, data: Any) -> dict[str, float]:
    """Return the standard uncertainty of quantities that state none, by unit."""
    found = {} if data is None else form.table(data, ("uncertainty",), "uncertainty")
    fields = {}
    for key, value in found.items():
        if form.check(("uncertainty", key), value > 0.0, "above 0: no measurement is exact"):
            fields[key.rpartition("_")[2]] = float(value) / PER_UNIT
    return fields


def _quantity(form: Form, key: str, place: Where, letters: str | None) -> Quantity | None:
    """Return the quantity of a key, the letters a, b, c read as angles; None after a complaint."""
    stem, _, unit = key.rpartition("_")
    name, _, letter = stem.rpartition("_")
    if letter in ("a", "b", "c"):
        if letters is None:
            message = (
                f'{key}: which angle is {letter!r}? State letters = "zyx" (a is rz, b is ry, c is rx) or '
                f'letters = "xyz"; or name the angle, such as {name}_angle_rz_{unit}, or the turn about an axis, such '
                f"as {name}_rz_{unit}"
            )
            return form.complain(place, message)  # type: ignore[no-any-return]
        key = f"{name}_angle_{LETTERS[letters]['abc'.index(letter)]}_{unit}"
    if key in QUANTITIES:
        return QUANTITIES[key]
    close = meant(key, QUANTITIES, 3, 0.5) or f"known: {', '.join(QUANTITIES)}"
    return form.complain(place, f"unknown quantity {key!r}; {close}")  # type: ignore[no-any-return]


def _limit(form: Form, key: str, value: Any, place: Where, common: dict[str, Any], letters: str | None) -> Limit | None:
    """Return one limit, or None after complaints about every bad field of it."""
    before = len(form.problems)
    quantity = _quantity(form, key, place, letters)
    bare = not isinstance(value, dict)
    if bare:
        number = form.value(value, place, "number")
        found = {} if number is None else {"within" if quantity is not None and quantity.signed else "upper": number}
    else:
        found = form.table(value, place, "limit")
    lower = upper = None
    if quantity is not None and (found if bare else all(name in found for name in ZONE if name in value)):
        lower, upper = _zone(form, quantity, found, place, bare)
    fields = {name: item for name, item in common.items() if name != "uncertainty"} | _decided_by(form, found, place)
    for name in ("window_s", "gap_s"):
        if name in found:
            if quantity is not None and quantity.family != ETVE:
                form.complain((*place, name), f"{name} is of ETVE only, not of {quantity.name}")
            form.check((*place, name), found[name] > 0.0, "above 0")
            fields[name.removesuffix("_s")] = float(found[name])
    if quantity is not None and quantity.signed and found.get("nonnegative"):
        form.complain((*place, "nonnegative"), f"{quantity.name} may be negative: leave out nonnegative")
    u = _uncertainty(form, found, place, fields.get("coverage_factor", 2.0))
    if quantity is None or len(form.problems) > before:
        return None
    return Limit(
        quantity, key, lower, upper, common["uncertainty"].get(quantity.unit) if u is None else u,
        nonnegative=bool(found.get("nonnegative", False)), poses=found.get("poses", ()), **fields,
    )  # fmt: skip


def _zone(
    form: Form, quantity: Quantity, found: dict[str, Any], at: Where, bare: bool
) -> tuple[float | None, float | None]:
    """Return the limits [m] or [rad]; complain where they bound the wrong side or nothing."""
    given = {key: float(found[key]) / PER_UNIT for key in ("lower", "upper", "within") if key in found}

    def where(key: str) -> Where:
        return at if bare else (*at, key)

    if quantity.signed:
        if "within" in given and len(given) > 1:
            form.complain(where("within"), "within stands for lower and upper: give it alone, or those two")
        elif "within" in given:
            _above_zero(form, given["within"], where("within"), found["within"])
            return -given["within"], given["within"]
        elif len(given) != 2:
            form.complain(
                at, f"{quantity.name} may be negative: give within (the largest size), or both lower and upper"
            )
        elif not given["lower"] < given["upper"]:
            form.complain(where("upper"), f"upper must be above lower, found {found['upper']} and {found['lower']}")
    elif set(given) != {"upper"}:
        form.complain(at, f"{quantity.name} cannot be negative: give upper, and no other limit")
    else:
        _above_zero(form, given["upper"], where("upper"), found["upper"])
    return given.get("lower"), given.get("upper")


def _above_zero(form: Form, value: float, where: Where, written: Any) -> None:
    """Complain about a limit that nothing can keep."""
    if not value > 0.0:
        form.complain(where, f"{dotted(where)} must be above 0, found {shown(float(written))}")


def _uncertainty(form: Form, found: dict[str, Any], at: Where, coverage_factor: float) -> float | None:
    """Return the standard uncertainty [m] or [rad] that a limit states, or None."""
    if "u" in found and "U" in found:
        form.complain((*at, "U"), "give u (standard uncertainty) or U (expanded, with k), not both")
    for key, factor in (("u", 1.0), ("U", coverage_factor)):
        if key in found and form.check((*at, key), found[key] > 0.0, "above 0: no measurement is exact"):
            return float(found[key]) / factor / PER_UNIT
    return None
