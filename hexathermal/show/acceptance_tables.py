"""An acceptance as tables, sentences and plain values, for the command line and for test systems."""

from __future__ import annotations

import math
from typing import Any

from rich.table import Table

from hexathermal.predict.acceptance import FAIL, NOT_DECIDED, PASS, Acceptance, Limit, Result
from hexathermal.predict.acceptance.quantities import ETVE, QUANTITIES, accuracy_values
from hexathermal.show.tables import framed

FORMAT = "hexathermal-acceptance/1"

CODES = {PASS: 0, FAIL: 1, NOT_DECIDED: 2}
"""Exit code of each verdict."""


MOST_ROWS = 200
"""Of the table: more nobody reads, and a file for machines holds all."""


def place(result: Result) -> str:
    """Return where a result comes from."""
    return f"pose {result.pose}" + (f" group {result.group}" if result.group else "")


def label(result: Result) -> str:
    """Return the quantity with its unit, and of ETVE its window."""
    if result.limit.quantity.family != ETVE:
        return result.limit.key
    window = result.limit.window
    return f"{result.limit.key} in {'the whole record' if window is None else f'{window:g} s'}"


ALMOST = 1e-4
"""Probabilities nearer to 0 or 1 are not told in digits."""


def chance(p: float | None) -> str:
    """Return a probability as percent, never rounded to 0 or 100."""
    if p is None:
        return "not known"
    if p > 1.0 - ALMOST:
        return "above 99.99 %"
    return f"{100.0 * p:z.2f} %" if p >= ALMOST else "below 0.01 %"


def _between(bounds: tuple[float, float]) -> str:
    """Return the bounds of a probability as text."""
    low, high = bounds
    words = [] if low < ALMOST else [chance(low) if low > 1.0 - ALMOST else f"at least {chance(low)}"]
    if high <= 1.0 - ALMOST:
        words.append(chance(high) if high < ALMOST else f"at most {chance(high)}")
    return ", ".join(words) or "not known"


def micro(value: float | None) -> float | None:
    """Return metres as micrometres (radians as microradians), None where there is no finite number."""
    return None if value is None or not math.isfinite(value) else float(f"{value * 1e6:.12g}")


def _number(value: float | None) -> str:
    """Return a length or a turn as text."""
    shown = micro(value)
    return "" if shown is None else f"{shown:z.4f}" if abs(shown) < 1e3 else f"{shown:z.1f}"


def _zone(result: Result) -> str:
    """Return the limits as text."""
    lower, upper = micro(result.decision.lower), micro(result.decision.upper)
    if lower is None:
        return f"<= {upper:g}"
    return f">= {lower:g}" if upper is None else f"{lower:g} to {upper:g}"


def sentence(result: Result) -> str:
    """Return a result in words: value, limits, uncertainty, rule and probability."""
    decision, unit = result.decision, result.limit.quantity.unit
    u = "not stated" if decision.uncertainty is None else f"{micro(decision.uncertainty):.4g} {unit}"
    text = (
        f"{decision.statement.upper()}: {result.limit.quantity.name} = {_number(decision.value)} {unit} at "
        f"{place(result)}, limit {_zone(result)} {unit}; standard uncertainty {u}; rule {decision.rule}"
    )
    if decision.rule == "iso-14253-1":
        text += f" ({100.0 * result.limit.probability:g} %)"
    text += f"; conformance probability {chance(decision.probability)}; {result.count} rows"
    return text + "".join(f"; {more}" for more in (result.detail, decision.note) if more)


def verdict_lines(acceptance: Acceptance) -> str:
    """Return the verdict in words."""
    verdicts = [result.decision.verdict for result in acceptance.results]
    counts = ", ".join(f"{verdicts.count(kind)} {kind}" for kind in CODES if kind in verdicts)
    made = f"{len(verdicts)} decision{'s' * (len(verdicts) != 1)}"
    line = f"{acceptance.verdict.upper()}: {acceptance.specification.title} ({made}: {counts})"
    if acceptance.probability is not None:
        line += f"\nprobability that all limits are met: {_between(acceptance.probability)}"
    largest: dict[Limit, Result] = {}
    for result in acceptance.results:
        other = largest.setdefault(result.limit, result)
        if abs(result.decision.value) > abs(other.decision.value):
            largest[result.limit] = result
    details = [f"{label(item)}, largest at {place(item)}: {item.detail}" for item in largest.values() if item.detail]
    if len(acceptance.results) > MOST_ROWS:
        line = f"{line}\nthe table holds {MOST_ROWS} decisions, those that do not pass first; --json holds all"
    return "\n".join([line, *details])


def results_table(acceptance: Acceptance, pretty: bool) -> Table:
    """Return one row for each limit at each pose; of very many those that do not pass first."""
    table = framed(pretty, "quantity", "pose", "group", "value>", "limit>", "u>", "probability>", "verdict")
    listed = acceptance.results
    if len(listed) > MOST_ROWS:
        listed = tuple(sorted(listed, key=lambda result: result.decision.verdict == PASS))[:MOST_ROWS]
    for result in listed:
        decision = result.decision
        table.add_row(
            label(result), result.pose, result.group or "-", _number(decision.value), _zone(result),
            _number(decision.uncertainty) or "-", chance(decision.probability), decision.statement,
        )  # fmt: skip
    return table


def acceptance_data(acceptance: Acceptance) -> dict[str, Any]:
    """Return an acceptance as plain values, ready for JSON: micrometres and microradians."""
    return {
        "format": FORMAT,
        "verdict": acceptance.verdict,
        "exit_code": CODES[acceptance.verdict],
        "probability_at_least": None if acceptance.probability is None else acceptance.probability[0],
        "probability_at_most": None if acceptance.probability is None else acceptance.probability[1],
        "title": acceptance.specification.title,
        "specification": acceptance.specification.path,
        "measured": str(acceptance.measured.path),
        "results": [_result(result) for result in acceptance.results],
        "poses": [
            {"pose": pose, "group": group or None, "visits": found.count} | _values(accuracy_values(found))
            for (pose, group), found in acceptance.accuracies.items()
        ],
        "notes": list(acceptance.notes),
    }


def _values(found: dict[str, float]) -> dict[str, float | None]:
    """Return values by the names with units."""
    units = {quantity.name: key for key, quantity in QUANTITIES.items()}
    return {units[name]: micro(value) for name, value in found.items()}


def _result(result: Result) -> dict[str, Any]:
    """Return one result as plain values."""
    decision, limit = result.decision, result.limit
    zone = (None, None) if decision.acceptance is None else decision.acceptance
    return {
        "quantity": limit.quantity.name,
        "unit": limit.quantity.unit,
        "pose": result.pose,
        "group": result.group or None,
        "rows": result.count,
        "value": micro(decision.value),
        "lower": micro(decision.lower),
        "upper": micro(decision.upper),
        "standard_uncertainty": micro(decision.uncertainty),
        "rule": decision.rule,
        "probability_asked": limit.probability if decision.rule == "iso-14253-1" else None,
        "coverage_factor": None if decision.rule in ("iso-14253-1", "simple") else limit.coverage_factor,
        "conformance_probability": decision.probability,
        "verdict": decision.verdict,
        "statement": decision.statement,
        "acceptance_possible": decision.acceptance is not None,
        "acceptance_lower": micro(zone[0]),
        "acceptance_upper": micro(zone[1]),
        "detail": result.detail,
        "note": decision.note,
    }
