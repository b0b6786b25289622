"""Tables of a comparison of a campaign with the virtual bench, and the same as plain values."""

from __future__ import annotations

from typing import Any

import numpy as np
from rich.table import Table

from hexathermal.compare.comparison import Comparison
from hexathermal.compare.differences import ParameterFound
from hexathermal.compare.parameters import NAMES
from hexathermal.compare.scores import ChannelScore
from hexathermal.show.identification_tables import figure_facts
from hexathermal.show.shares import bounded
from hexathermal.show.tables import framed

FORMAT = "hexathermal-comparison/1"

FACTOR = "factor, or part\nof the air>"
"""What the number of a difference is: a factor on the bench's, of a thermocouple its part of the air."""


def three(value: float) -> str:
    """Return a factor, or a part, with three decimals, of 10 and more with three digits.

    >>> three(0.518), three(37.278), three(129.4), three(-0.0001)
    ('0.518', '37.3', '129', '0.000')
    """
    return f"{value:z.3f}" if abs(value) < 9.9995 else f"{value:.3g}" if abs(value) < 999.5 else f"{value:.0f}"


def differences_table(found: Comparison, pretty: bool) -> Table:
    """Return what was named."""
    table = framed(pretty, "what differs", FACTOR, "95 % interval", "probability>", "runs left out\nbetter>",
                   "not told apart from", "may stand for")  # fmt: skip
    for one in found.differences:
        name = f"{one.name} {one.target}".strip()
        same = ", ".join(f"{other} ({value:z.2f})" for other, value in one.equivalent) or "-"
        better = f"{one.runs_better[0]} of {one.runs_better[1]}" if one.runs_better[1] else "-"
        table.add_row(name, three(one.value), f"{three(one.low)} to {three(one.high)}", f"{one.probability:.3f}",
                      better, same, one.meaning)  # fmt: skip
    return table


def scores_table(found: Comparison, pretty: bool) -> Table:
    """Return every channel before and after."""
    table = framed(pretty, "channel", "part", "position\nmm>", "unit", "RMSE\nbefore>", "RMSE\nafter>",
                   "RMSE\nforetold>", "largest\nbefore>", "largest\nafter>", "RMSE less by",
                   "95 % interval")  # fmt: skip
    for one in found.scores:
        factor, unit = scale_of(one)
        numbers = (one.rmse_before, one.rmse_after, one.foretold, one.linf_before, one.linf_after)
        gain = one.reduction
        same = not found.differences
        table.add_row(
            one.channel, one.part or "-", "-" if one.position is None else f"{one.position * 1e3:z.1f}", unit,
            *(f"{value * factor:z.3f}" for value in numbers), "-" if same else f"{100.0 * gain.value:z.0f} %",
            "-" if same or not bounded(gain) else f"{100.0 * gain.low:z.0f} to {100.0 * gain.high:z.0f} %",
        )  # fmt: skip
    return table


def parameters_table(found: Comparison, pretty: bool) -> Table:
    """Return all numbers that were looked for, thermocouples only where they say something.

    Not needed is what would have been named by itself, but not beside what is named, or is not told apart from it.
    """
    table = framed(pretty, "number", FACTOR, "95 % interval", "named", "would have been named",
                   "cannot be separated from")  # fmt: skip
    for one in filter(lambda one: one.speaks, found.parameters):
        alike = ", ".join(name for name, _value in one.alike) or "-"
        named = "yes" if one.named else "not needed" if one.needless else ""
        table.add_row(f"{one.name} {one.target}".strip(), three(one.value), f"{three(one.low)} to {three(one.high)}",
                      named, limit_words(one), alike)  # fmt: skip
    return table


def limit_words(one: ParameterFound) -> str:
    """Return from where on a number would have been named."""
    if one.named:
        return "is named"
    if one.target:
        return f"above {one.limit_high:z.3f}"
    if one.limit_low <= 0.0 or not np.isfinite(one.limit_high):
        return "never by these data"
    return f"below {one.limit_low:z.2f} or above {one.limit_high:z.2f}"


def scale_of(one: ChannelScore) -> tuple[float, str]:
    """Return the factor to the unit that a channel is shown in, and that unit."""
    return (1e6, "um") if one.channel == "drift" else (1.0, "K")


def comparison_facts(found: Comparison) -> dict[str, Any]:
    """Return a comparison as plain values (JSON)."""
    noise = found.noise
    return {
        "format": FORMAT,
        "title": found.title,
        "verdict": found.verdict,
        "sentence": found.sentence,
        "sensors": list(found.sensors),
        "differences": [
            {"name": one.name, "target": one.target or None, "value": one.value, "low": one.low, "high": one.high,
             "probability": one.probability, "log_evidence": one.log_evidence, "meaning": one.meaning,
             "runs_better": one.runs_better[0], "runs_left_out": one.runs_better[1],
             "equivalent": [{"name": name, "value": value} for name, value in one.equivalent],
             "next_experiment": one.experiment}
            for one in found.differences
        ],
        "parameters": [_parameter_facts(one) for one in found.parameters],
        "scored_runs": found.scored_role,
        "unexplained": [one.channel for one in found.unexplained],
        "worse": [one.channel for one in found.worse],
        "channels": [_channel_facts(one) for one in found.scores],
        "noise": {"slow_K": noise.slow, "common_K": noise.common, "time_s": noise.time,
                  "drift_slow_um": noise.drift_slow, "drift_time_s": noise.drift_time,
                  "landing_scatter_um": noise.scatter,
                  "own_factor": dict(zip(found.sensors, noise.own.tolist(), strict=True))},
        "step_s": found.step,
        "step_error": {"largest_K": found.step_error_K, "largest_um": found.step_error_m * 1e6},
        "notes": list(found.notes),
    }  # fmt: skip


def _parameter_facts(one: ParameterFound) -> dict[str, Any]:
    """Return a number that was looked for as plain values."""
    never = one.name in NAMES and (one.limit_low <= 0.0 or not np.isfinite(one.limit_high))
    return {
        "name": one.name, "target": one.target or None, "value": one.value, "low": one.low, "high": one.high,
        "named": one.named, "log_evidence": one.log_evidence, "named_below": None if never else one.limit_low,
        "named_above": None if never else one.limit_high,
        "not_separated": [{"name": name, "correlation": value} for name, value in one.alike],
        "next_experiment": one.experiment,
    }  # fmt: skip


def _channel_facts(one: ChannelScore) -> dict[str, Any]:
    """Return a channel's scores as plain values."""
    factor, unit = scale_of(one)
    return {
        "channel": one.channel, "part": one.part or None,
        "position_mm": None if one.position is None else one.position * 1e3, "unit": unit,
        "rmse_before": one.rmse_before * factor, "rmse_after": one.rmse_after * factor,
        "linf_before": one.linf_before * factor, "linf_after": one.linf_after * factor,
        "rmse_foretold": one.foretold * factor, "rmse_reduction": figure_facts(one.reduction),
    }  # fmt: skip
