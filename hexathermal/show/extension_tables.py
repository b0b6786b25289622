"""What extends a machine beyond geometry and laws, for ``show-machine``: payload, measuring frame, terms of legs."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from decimal import Decimal
from typing import Any

from hexathermal.machine.extension_files import compliance_table, measuring_frame_table
from hexathermal.machine.hexapod import Hexapod
from hexathermal.machine.leg_term_files import term_table
from hexathermal.machine.leg_terms import LegTerm
from hexathermal.machine.thermometers import AS_RECORDED

Row = tuple[str, str]


def extension_facts(hexapod: Hexapod) -> dict[str, Any]:
    """Return payload and measuring frame by the keys of hexapod.toml, None where the machine has none."""
    soft, frame = hexapod.compliance, hexapod.measuring_frame
    return {
        "compliance": None if soft is None else floats(compliance_table(soft)),
        "measuring_frame": None if frame is None else floats(measuring_frame_table(frame)),
    }


def term_facts(terms: Sequence[LegTerm]) -> list[dict[str, Any]]:
    """Return terms of a leg by the keys of hexapod.toml, each with the standard uncertainties of its amplitudes."""
    found = []
    for term in terms:
        facts = floats(term_table(term))
        facts["amplitudes_std"] = [max(row[k], 0.0) ** 0.5 for k, row in enumerate(facts["covariance"])]
        found.append(facts)
    return found


def floats(value: Any) -> Any:
    """Return what a table of a file holds with its decimals as floats.

    Examples
    --------
    >>> floats({"a": [Decimal("0.5"), "text"]})
    {'a': [0.5, 'text']}
    """
    if isinstance(value, dict):
        return {key: floats(item) for key, item in value.items()}
    if isinstance(value, list):
        return [floats(item) for item in value]
    return float(value) if isinstance(value, Decimal) else value


def extension_rows(facts: dict[str, Any]) -> Iterator[Row]:
    """Give name and text of what extends the whole machine, from `extension_facts`; nothing where nothing does."""
    soft, frame = facts["compliance"], facts["measuring_frame"]
    if soft is not None:
        yield "compliance of the legs", _valued(soft, "leg_um_per_N", "leg_std_um_per_N", "um/N")
        yield "payload", _valued(soft, "payload_kg", "payload_std_kg", "kg")
        yield (
            "centre of the payload, platform frame",
            _valued(soft, "payload_centre_mm", "payload_centre_std_mm", "mm"),
        )
        yield "gravity, base frame", _valued(soft, "gravity_m_s2", "", "m/s2")
    if frame is not None:
        yield "measured poses move with", f"{frame['sensor']}; commands do not"
        yield "shift of the measuring frame", _valued(frame, "shift_um_per_K", "shift_std_um_per_K", "um/K")
        yield "turn of the measuring frame", _valued(frame, "turn_urad_per_K", "turn_std_urad_per_K", "urad/K")


def exchange_rows(told: Sequence[int]) -> Iterator[Row]:
    """Give name and text of exchanged thermometers; nothing where each leg is told by its own."""
    changed = [f"leg {leg + 1} by those of leg {own}" for leg, own in enumerate(told) if own != AS_RECORDED[leg]]
    if changed:
        yield "thermometers as recorded tell", "; ".join(changed) + "; other legs by their own"


def term_cells(term: dict[str, Any]) -> tuple[str, ...]:
    """Return the cells of a term: cause, amplitudes, their standard uncertainties, unit, shape with parameters."""
    known = {"cause", "shape", "amplitudes", "amplitudes_std", "unit", "covariance"}
    parameters = [f"{key} {_told(value)}" for key, value in term.items() if key not in known]
    shape = f"{term['shape']}: {', '.join(parameters)}" if parameters else term["shape"]
    return term["cause"], numbers(term["amplitudes"]), numbers(term["amplitudes_std"]), term["unit"], shape


def _told(value: Any) -> str:
    """Return a parameter as text: a word, numbers, or a number for each of some thermometers."""
    if isinstance(value, dict):
        return " ".join(f"{name} {number:+.3g}" for name, number in value.items())
    return value if isinstance(value, str) else numbers(value)


def _valued(table: dict[str, Any], key: str, spread: str, unit: str) -> str:
    """Return numbers with their unit, and their standard uncertainty where it is stated."""
    text = f"{numbers(table.get(key, 0.0))} {unit}"
    known = table.get(spread)
    return text if known is None else f"{text}, standard uncertainty {numbers(known)} {unit}"


def numbers(values: Any) -> str:
    """Return one number or several as text.

    Examples
    --------
    >>> numbers(0.25), numbers([1.0, -2.5])
    ('0.25', '1, -2.5')
    """
    return ", ".join(f"{value:.5g}" for value in (values if isinstance(values, list) else [values]))
