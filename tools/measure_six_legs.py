"""Measure how well laws of six legs are found, and write the tables into docs/six-legs.md.

Run from the repository's root: ``python tools/measure_six_legs.py [NAME ...]`` (all: some five minutes). Campaigns
whose legs follow their law are drawn by the tests' generator, which shares no solver with the package; the others are
those of ``hexathermal simulate machine``, through which heat flows.
"""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parent.parent))

from sections import asked, write_section

import hexathermal as ht
from hexathermal.learn.hexapod_data import HexapodRows, hexapod_rows
from hexathermal.learn.hexapod_identification import HexapodIdentification, identify_hexapod
from hexathermal.learn.hexapod_scores import QUANTITIES, best_factor, pose_scores
from hexathermal.learn.hexapod_validation import HexapodValidation, validate_hexapod
from hexathermal.poses import FloatArray
from hexathermal.predict.pose_errors import pose_errors
from hexathermal.simulate.machine.building import virtual_machine
from hexathermal.simulate.machine.campaign_folder import write_machine_campaign
from hexathermal.simulate.machine.runs import mounted_thermometers, planned_machine_runs, simulate_machine
from hexathermal.simulate.machine.truth import effective_laws
from tests.learn.hexapods import EQUAL, PLATES, drawn_rows

SEEDS, SPREADS = (1, 2, 3, 4), (0.0, 0.05, 0.15)
SHORT = "rubin-m2"
"""A machine of short stroke."""

DRAWS, APART = 30, (0.02, 0.05, 0.10)
MACHINES, FRESH = 150, 300
UM, UM_M_K, COVERAGE = 1e6, 1e6, 1.96


@dataclass(frozen=True)
class Measured:
    """A simulated campaign: what its law leaves, and how far its laws lie from those that the thermometers read."""

    spread: float
    identified: HexapodValidation
    published: HexapodValidation
    chosen: str
    off: dict[str, FloatArray]
    """By what is known of plates: estimate less truth, shape (6, 2) [um/m/K]."""
    inside: dict[str, FloatArray]
    """Whether the 95 % intervals hold the truth."""


def errors(found: HexapodIdentification, truth: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return estimate less truth [um/m/K] and whether the 95 % intervals hold it, each shape (6, 2)."""
    laws = found.laws()
    off = np.array([[law.A[0], law.B[0]] for law in laws]) - truth
    std = np.sqrt(np.array([np.diagonal(law.covariance) for law in laws if law.covariance is not None]))
    return off * UM_M_K, np.abs(off) <= COVERAGE * std


def measured(seed: int, spread: float) -> Measured:
    """Simulate a campaign as the command does by default, identify its laws, validate them."""
    reference = ht.load_hexapod("reference")
    machine = virtual_machine(reference, seed, spread=spread)
    plans = planned_machine_runs(machine, seed)
    runs = list(simulate_machine(machine, seed, plans))
    with tempfile.TemporaryDirectory() as folder:
        write_machine_campaign(folder, machine, plans, iter(runs))
        campaign = ht.load_campaign(folder)
        rows = hexapod_rows(campaign, "identification")
        found = {plates: identify_hexapod(rows, plates=plates) for plates in ("known", "fit")}
        known = found["known"]
        scores = [validate_hexapod(one, campaign) for one in (known.hexapod(), reference)]
    fitted = [run for run in runs if run.role == "identification"]
    truth = effective_laws(machine, fitted, mounted_thermometers(machine, seed))
    both = {plates: errors(one, truth) for plates, one in found.items()}
    return Measured(spread, scores[0], scores[1], known.chosen, {name: one[0] for name, one in both.items()},
                    {name: one[1] for name, one in both.items()})  # fmt: skip


def span(values: Iterable[float], digits: int = 1) -> str:
    """Return the smallest and the largest of some numbers."""
    found = list(values)
    return f"{min(found):.{digits}f} to {max(found):.{digits}f}"


def percent(parts: FloatArray) -> str:
    """Return a share of truths in whole percent."""
    return f"{100.0 * np.mean(parts):.0f} %"


@cache
def campaigns() -> list[Measured]:
    """Return the campaigns of all seeds and spreads, simulated once."""
    return [measured(seed, spread) for spread in SPREADS for seed in SEEDS]


def platform() -> Iterator[str]:
    """Give the table of errors on runs for validation."""
    found = campaigns()
    noise = np.array(virtual_machine(ht.load_hexapod("reference")).tracker.noise) * UM
    alone = [np.linalg.norm(part) for part in (noise[:3], noise[3:])]
    yield from ("| RMS on validation runs | not corrected | identified | published law (eq. 8) |", "|---|---|---|---|")
    for k, (name, unit) in enumerate((("translation", "µm"), ("rotation", "µrad"))):
        cells = [span(one.identified.total[name].before.value * UM for one in found)]
        cells += [span(getattr(one, law).total[name].after.value * UM for one in found)
                  for law in ("identified", "published")]  # fmt: skip
        yield f"| {name}, {unit} | {' | '.join(cells)} |"
        framed = [span((getattr(one, law).framed[k] * UM for one in found), 2) for law in ("identified", "published")]
        before = span((one.identified.framed_before[k] * UM for one in found), 2)
        yield f"| without each run's mean motion (noise alone: {alone[k]:.2f}) | {before} | {' | '.join(framed)} |"


def laws() -> Iterator[str]:
    """Give the table of the laws of legs, and which kind was chosen."""
    found = campaigns()
    yield from ("| legs spread by | own laws taken | plates | A held | B held | A off, µm/m/K | B off, µm/m/K |",
                "|---|---|---|---|---|---|---|")  # fmt: skip
    for spread in SPREADS:
        some = [one for one in found if one.spread == spread]
        own = sum(one.chosen == "leg-specific" for one in some)
        for plates in ("known", "fit"):
            held = np.array([one.inside[plates] for one in some])
            off = np.array([one.off[plates] for one in some])
            within = [percent(held[..., k]) for k in (0, 1)]
            away = [span(off[..., k].ravel(), 2) for k in (0, 1)]
            cells = [f"{100 * spread:.0f} %", f"{own} of {len(some)}", plates, *within, *away]
            yield f"| {' | '.join(cells)} |"


def drawn() -> Iterator[str]:
    """Give the table of campaigns whose legs follow the law."""
    heads = [
        f"{DRAWS} drawn machines each, legs spread by",
        "own laws taken",
        "A held",
        "B held",
        "A without the spread",
    ]
    yield from (f"| {' | '.join(heads)} |", "|---|---|---|---|---|")
    for spread in (0.0, *APART):
        own, held, bare = 0, [], []
        for seed in range(DRAWS):
            rng = np.random.default_rng([seed, round(1000 * spread)])
            truth = EQUAL * (1.0 + spread * rng.standard_normal((6, 1)))
            found = identify_hexapod(drawn_rows(rng, truth, runs=6))
            off, inside = errors(found, truth)
            own += found.chosen == "leg-specific"
            held.append(inside)
            std = np.sqrt(np.array([law.covariance[0, 0] - (0.0 if law.spread is None else law.spread[0] ** 2)
                                    for law in found.laws() if law.covariance is not None]))  # fmt: skip
            bare.append(np.abs(off[:, 0]) <= COVERAGE * std * UM_M_K)
        told = np.array(held)
        yield (f"| {100 * spread:.0f} % | {own} of {DRAWS} | {percent(told[..., 0])} | {percent(told[..., 1])} | "
               f"{percent(np.array(bare))} |")  # fmt: skip


def scored(rows: HexapodRows) -> tuple[list[FloatArray], list[FloatArray]]:
    """Return the errors of each run without and with the law that the rows were drawn with."""
    legs = ht.LegLaw(("T1",), EQUAL[0, :1], EQUAL[0, 1:])
    platform_plate, base_plate = (ht.PlateLaw(float(value), "T1") for value in PLATES)
    exact = replace(rows.hexapod, thermal=ht.ThermalModel(legs, platform_plate, base_plate))
    temps = 20.0 + np.concatenate([rows.dT[:, :, 0], rows.plates], axis=1)
    lengths = rows.retracted + rows.q
    told = [rows.hexapod.forward_kinematics(lengths), exact.predicted_pose(lengths, temps)]
    before, after = (pose_errors(one, rows.measured) for one in told)
    parts = [rows.run == k for k in range(len(rows.runs))]
    return [before[part] for part in parts], [after[part] for part in parts]


def intervals() -> Iterator[str]:
    """Give the table of how often the intervals of a validation hold the truth, the law being exact."""
    many = pose_scores(*scored(drawn_rows(np.random.default_rng(0), runs=FRESH)))
    heads = [
        f"{MACHINES} drawn machines each, runs",
        "RMS after correction held",
        "reduction held",
        "said over or under",
    ]
    yield from (f"| {' | '.join(heads)} |", "|---|---|---|---|")
    for count in (2, 3, 6):
        after: list[bool] = []
        less: list[bool] = []
        said = 0
        for seed in range(MACHINES):
            errors = scored(drawn_rows(np.random.default_rng([seed, count]), runs=count))
            found, gain = pose_scores(*errors), best_factor(*errors)
            said += not gain.low <= 1.0 <= gain.high
            for name in QUANTITIES:
                for one, true, held in ((found[name].after, many[name].after, after),
                                        (found[name].reduction, many[name].reduction, less)):  # fmt: skip
                    held.append(one.low <= true.value <= one.high)
        both = [
            [percent(np.array(held[k :: len(QUANTITIES)])) for k in range(len(QUANTITIES))] for held in (after, less)
        ]
        spans = [f"{min(one, key=_number)} to {max(one, key=_number)}" for one in both]
        yield f"| {count} | {' | '.join(spans)} | {100 * said / MACHINES:.1f} % |"


def _number(part: str) -> float:
    """Return the number of a percentage."""
    return float(part.split()[0])


def short() -> Iterator[str]:
    """Give what a machine of short stroke tells of A and B."""
    hexapod = ht.load_hexapod(SHORT)
    told = []
    for seed in SEEDS:
        machine = virtual_machine(hexapod, seed)
        plans = planned_machine_runs(machine, seed)
        with tempfile.TemporaryDirectory() as folder:
            write_machine_campaign(folder, machine, plans, simulate_machine(machine, seed, plans))
            found = identify_hexapod(hexapod_rows(ht.load_campaign(folder), "identification"))
        told += [np.sqrt(np.diagonal(law.covariance)) for law in found.laws() if law.covariance is not None]
    A, B = (span((one[k] * UM_M_K for one in told), 2 - k) for k in (0, 1))
    most = 1e3 * float(np.abs(hexapod.length_limits - hexapod.home_lengths).max())
    yield (f"Of {SHORT}, whose legs move by ±{most:.0f} mm, {len(SEEDS)} campaigns tell A with a standard uncertainty "
           f"of {A} µm/m/K, B with one of {B} µm/m/K: its B is what chance made of it.")  # fmt: skip


WRITTEN: dict[str, Callable[[], Iterator[str]]] = {
    "intervals": intervals, "platform": platform, "laws": laws, "drawn": drawn, "short stroke": short,
}  # fmt: skip
"""Each part of docs/six-legs.md by its name, with what measures it."""


def main(arguments: Sequence[str] | None = None) -> None:
    """Measure the parts that were named, or all, and write the page."""
    for name in asked(__doc__, WRITTEN, arguments):
        write_section("six-legs.md", name, "measure_six_legs", "\n".join(WRITTEN[name]()))


if __name__ == "__main__":
    main()
