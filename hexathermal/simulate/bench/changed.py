"""A bench of which one number is not what it should be: to try out what finds it, from the campaign's files alone.

All other numbers are drawn within their tolerance; the leg is cut into other cells, its rod moves at another speed, its
users rest and move otherwise, its thermocouples are better or worse.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from hexathermal.simulate.bench.bench import (
    Bench,
    BenchRun,
    Mounted,
    RunPlan,
    mounted,
    planned_runs,
    recorded,
    true_run,
)
from hexathermal.simulate.bench.campaign_folder import write_campaign

TOLERANCE = 0.01
"""Standard deviation of the logarithm of every number that is as it should be."""

LARGEST_FACTOR = 2.0
"""The changed number is multiplied by a factor from its inverse to this, log-uniform."""

CONTACT = (0.15, 0.60)
"""Part by which a thermocouple follows the air that came loose."""

SENSOR = "sensor-reads-air"

NUMBERS: dict[str, tuple[str, ...]] = {
    "motor-heat": ("drive.moving_power",),
    "friction-heat": ("drive.screw_torque",),
    "convection": ("body.convection", "rod.convection", "body.motor_convection", "joints.piece_convection"),
    "convection-body": ("body.convection",),
    "convection-rod": ("rod.convection",),
    "convection-motor": ("body.motor_convection",),
    "convection-platforms": ("joints.piece_convection",),
    "contact-gap": ("contact.gap_conductance",),
    "contact-bushes": ("contact.nut_conductance", "contact.guide_conductance"),
    "conduction-body": ("body.conductivity", "body.spindle_conductivity"),
    "conduction-rod": ("rod.conductivity",),
    "conduction-motor": ("body.motor_conductance",),
    "conduction-joints": ("joints.leg_conductance", "joints.piece_conductance"),
    "heat-capacity": ("body.heat_capacity", "body.spindle_capacity", "rod.heat_capacity"),
    "expansion-body": ("body.expansion",),
    "expansion-rod": ("rod.expansion",),
    "expansion-scale": ("rod.scale_expansion",),
    "expansion-joints": ("joints.expansion",),
    "expansion-bracket": ("body.head_bracket_expansion",),
}
"""Names of what may be changed, and the fields of `VirtualLeg` that are multiplied."""


@dataclass(frozen=True)
class Change:
    """What truly differs in a campaign.

    Attributes
    ----------
    name : str
        A name of `NUMBERS`, ``"sensor-reads-air"``, or empty: nothing.
    target : str
        The thermocouple, or empty.
    value : float
        Factor on the number (1 for nothing); of a thermocouple, the part by which it follows the air.
    """

    name: str
    target: str
    value: float


def drawn_change(generator: np.random.Generator, names: tuple[str, ...] | None = None) -> Change:
    """Return a change: which, and how large; `names` says among which (default all, sensors as often as five)."""
    chosen = str(generator.choice(list(names or (*NUMBERS, *(SENSOR,) * 5))))
    if not chosen:
        return Change("", "", 1.0)
    if chosen == SENSOR:
        places = Bench().thermocouples.places
        return Change(SENSOR, places[int(generator.integers(len(places)))][0], float(generator.uniform(*CONTACT)))
    reach = np.log(LARGEST_FACTOR)
    return Change(chosen, "", float(np.exp(generator.uniform(-reach, reach))))


def changed_bench(change: Change, generator: np.random.Generator) -> Bench:
    """Return a bench with a change; everything else drawn within its tolerance."""
    bench = Bench(interval=float(generator.choice([10.0, 15.0, 20.0])))
    leg: Any = bench.leg
    for name, paths in NUMBERS.items():
        factor = float(np.exp(TOLERANCE * generator.standard_normal())) * (change.value if name == change.name else 1.0)
        for path in paths:
            part, field = path.split(".")
            old = getattr(leg, part)
            leg = replace(leg, **{part: replace(old, **{field: getattr(old, field) * factor})})
    cells = [int(count) for count in generator.integers(23, 38, 2)]
    pace = float(generator.uniform(0.75, 1.5))
    drive = replace(leg.drive, speed=leg.drive.speed * pace, moving_power=leg.drive.moving_power * pace)
    leg = replace(leg, body=replace(leg.body, cells=cells[0]), rod=replace(leg.rod, cells=cells[1]), drive=drive)
    worse = generator.uniform(0.5, 1.5, 3)
    kinds = bench.thermocouples
    kinds = replace(kinds, noise=kinds.noise * worse[0], bias=kinds.bias * worse[1],
                    cold_junction=kinds.cold_junction * worse[2])  # fmt: skip
    pause = tuple(sorted(generator.uniform(6.0, 20.0, 2).tolist()))
    return replace(bench, leg=leg, thermocouples=kinds, scenario=replace(bench.scenario, pause=pause))


def write_changed_campaign(
    folder: str | Path,
    change: Change,
    seed: int,
    *,
    identification: int = 3,
    validation: int = 1,
    duration: float = 3.0 * 3600.0,
) -> Bench:
    """Write the campaign of a changed bench; returns the bench.

    Parameters
    ----------
    folder : str or Path
    change : Change
    seed : int
        Of all else that is drawn.
    identification, validation : int
        Runs.
    duration : float [s]
        Of each run.
    """
    bench = changed_bench(change, np.random.default_rng([seed, 9]))
    plans = planned_runs(bench, seed, identification=identification, validation=validation, duration=duration)
    write_campaign(folder, bench, plans, _runs(bench, change, seed, plans))
    return bench


def _runs(bench: Bench, change: Change, seed: int, plans: tuple[RunPlan, ...]) -> Iterator[BenchRun]:
    """Return the runs as they are recorded."""
    instruments = _instruments(bench, change, seed)
    for k, plan in enumerate(plans):
        truth = true_run(bench, plan, np.random.default_rng([seed, 2, k]))
        yield recorded(bench, truth, instruments, np.random.default_rng([seed, 3, k]))


def _instruments(bench: Bench, change: Change, seed: int) -> Mounted:
    """Return the instruments, one thermocouple loose where that is the change."""
    instruments = mounted(bench, seed)
    if change.name != SENSOR:
        return instruments
    names = [name for name, _part, _position in bench.thermocouples.places]
    contact = instruments.thermocouples.contact_error.copy()
    contact[names.index(change.target)] = change.value
    return replace(instruments, thermocouples=replace(instruments.thermocouples, contact_error=contact))
