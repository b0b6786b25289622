"""Tables of a machine's diagnosis for the command line, and its JSON."""

from __future__ import annotations

from typing import Any

from rich.table import Table

from hexathermal.learn.hexapod_data import AXES
from hexathermal.learn.machine_diagnosis.plan_files import planned_facts
from hexathermal.learn.machine_diagnosis.planning import MachineExperiment
from hexathermal.learn.machine_diagnosis.result import MachineDiagnosis
from hexathermal.show.diagnosis_tables import plain
from hexathermal.show.diagnosis_words import how_apart, settings_words
from hexathermal.show.hexapod_tables import unit_of
from hexathermal.show.machine_limits import LIMITS_HEAD, limits_rows
from hexathermal.show.machine_words import amplitude, framed_out, moved, parameter_rows, score_cells
from hexathermal.show.shares import probability
from hexathermal.show.tables import framed

UM = 1e6
MOST_POSES = 60
"""Poses of a plan that are shown; all stand in its files."""


def effects_table(found: MachineDiagnosis, pretty: bool) -> Table:
    """Return the causes that were named, with their parameters."""
    table = framed(pretty, "named", "where", "parameter", "value>", "standard\nuncertainty>", "95 % interval", "unit",
                   "probability>", "not ruled out")  # fmt: skip
    for one in found.effects:
        for k, row in enumerate(parameter_rows(one) or [("-",) * 5]):
            head = (one.cause, one.target or "-") if k == 0 else ("", "")
            alike = ", ".join(one.equivalent_places) or "none other"
            table.add_row(*head, *row, *((probability(one.probability), alike) if k == 0 else ("", "")))
    return table


def ranking_rows(found: MachineDiagnosis) -> list[tuple[str, ...]]:
    """Return every candidate: cause, place, size in um and urad, visible, evidence, probability."""
    rows: list[tuple[str, ...]] = []
    for k, one in enumerate(found.candidates):
        effect = found.effects[k] if k < len(found.effects) else None
        size = moved(one.moved) if effect is None else (amplitude(effect), amplitude(effect, rotation=True))
        chance = one.probability if effect is None else effect.probability
        rows.append((one.cause, one.target or "-", *size, f"{one.strength:z.3f}", f"{one.evidence:z.1f}",
                     probability(chance), settings_words(one.settings) or "-"))  # fmt: skip
    return rows


def ranking_table(found: MachineDiagnosis, pretty: bool) -> Table:
    """Return every cause that was tried, best first."""
    table = framed(pretty, "cause", "named", "where", "RMS um\n(95 %)>", "RMS urad\n(95 %)>", "visible,\nnoise = 1>",
                   "evidence\nlog>", "probability>", "at best with")  # fmt: skip
    for k, (cause, *rest) in enumerate(ranking_rows(found)):
        table.add_row(cause, "yes" if k < len(found.effects) else "", *rest)
    return table


def gain_table(found: MachineDiagnosis, pretty: bool) -> Table:
    """Return errors before and after: per axis over all runs for validation, then distances of each run."""
    assert found.gain is not None  # the caller asks
    table = framed(
        pretty, "run", "error", "RMSE\nbefore>", "RMSE after\n(95 %)>", "less by\n(95 %)>", "largest>", "unit"
    )
    for name, score in found.gain.total.items():
        table.add_row("all", name, *score_cells(score), unit_of(name))
    for run, scores in found.gain.runs.items():
        for name in ("translation", "rotation"):
            table.add_row(run, name, *score_cells(scores[name]), unit_of(name))
    if framed_out(found):
        for name, score in found.gain.unframed.items():
            table.add_row("all, no frame", name, *score_cells(score), unit_of(name))
    return table


def limits_table(found: MachineDiagnosis, pretty: bool) -> Table:
    """Return how large each effect must be in this campaign to be named, at its best and its worst place."""
    table = framed(pretty, "would be named from", *LIMITS_HEAD)
    for row in limits_rows(found.limits):
        table.add_row(*row)
    return table


def promises_table(plan: MachineExperiment, pretty: bool) -> Table:
    """Return by how much log evidence a plan tells names apart."""
    table = framed(pretty, "if true", "told from", "without it\nlog>", "with it\nlog>", "then")
    for one in plan.promises:
        table.add_row(one.true, one.rival, f"{one.before:z.1f}", f"{one.after:z.1f}", apart(one.after))
    return table


def apart(separation: float) -> str:
    """Return how well two names are told apart by so much log evidence.

    Examples
    --------
    >>> apart(0.3), apart(120.0)
    ('not at all', 'told apart')
    """
    return "told apart" if separation >= 6.0 else how_apart(separation)


def poses_table(plan: MachineExperiment, pretty: bool) -> Table:
    """Return the first poses of a plan."""
    units = ("mm",) * 3 + ("deg",) * 3
    table = framed(pretty, "pose>", "run", *(f"{axis}\n{unit}>" for axis, unit in zip(AXES, units, strict=True)))
    for k, pose in enumerate(plan.coordinates[:MOST_POSES]):
        table.add_row(f"{k + 1}", plan.view.runs[int(plan.view.run[k])], *(f"{value:z.3f}" for value in pose))
    return table


def machine_facts(found: MachineDiagnosis, plan: MachineExperiment | None) -> dict[str, Any]:
    """Return a diagnosis as plain values, ready for JSON; with the planned experiment and its poses."""
    told: dict[str, Any] = plain(found.to_json())
    if plan is not None:
        told["next_experiment"] = plain(planned_facts(plan))
    return told
