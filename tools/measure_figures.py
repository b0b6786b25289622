"""Measure the figures in the prose of docs/ that no other tool measures, and write each where it stands.

Run from the repository's root: ``python tools/measure_figures.py [NAME ...]`` (``--help`` lists the names; all take
some three minutes). Campaigns are drawn by the tests' generators, which share no solver with the package; times are
those of one core, the best of some turns.
"""

from __future__ import annotations

import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parent.parent))

from sections import asked, write_section

import hexathermal as ht
from hexathermal.learn.common import fit_common
from hexathermal.learn.gram import columns_for, gather
from hexathermal.learn.identification import identify
from hexathermal.learn.validation import validate
from hexathermal.machine.compliance import Compliance
from hexathermal.machine.leg_terms import LegTerm
from hexathermal.poses import FloatArray
from hexathermal.predict.budget_maps import budget_map
from hexathermal.predict.montecarlo import monte_carlo
from tests.learn.campaign_folders import Table, cleaned
from tests.learn.legs import LEG, SENSORS, TRUE_A, drawn_leg

UM = 1e6
FIGURES = ("rmse", "mean", "mean_reduction", "rms_reduction")
LAWS, FRESH, CHOICES = 8, 60, 25
LEGS, RUNS, DRAWS = 6, 5, 30
TILTED, JUMPING, LOST = 100, 50, 60
TEMPS = [22.0, 22.1, 22.4, 22.2, 22.0, 21.9]


def intervals() -> str:
    """Return how often intervals of a validation of few runs hold the figures of many."""
    held: dict[int, list[list[bool]]] = {2: [], 3: []}
    for seed in range(LAWS):
        rng = np.random.default_rng(seed)
        rows = drawn_leg(rng)
        law = identify(lambda rows=rows: iter(rows), SENSORS, LEG, wanted=("T07",), sizes=(1,)).law  # type: ignore[misc]
        fresh = drawn_leg(rng, runs=FRESH, role="validation")
        many = validate(law, fresh, SENSORS).total
        for count, found in held.items():
            for _choice in range(CHOICES):
                few = validate(law, [fresh[k] for k in rng.choice(FRESH, count, replace=False)], SENSORS).total
                both = [(getattr(few, name), getattr(many, name).value) for name in FIGURES]
                found.append([one.low <= value <= one.high for one, value in both])
    span = {count: 100.0 * np.mean(found, axis=0) for count, found in held.items()}
    return (
        f"Of {LAWS} drawn laws, each with {FRESH} fresh runs, {CHOICES} choices of 3 of them held the figures of all "
        f"in {span[3].min():.0f} to {span[3].max():.0f} % (RMSE, mean and their reductions), choices of 2 of them in "
        f"{span[2].min():.0f} to {span[2].max():.0f} %: intervals of so few runs are rather too short."
    )


def common() -> str:
    """Return how often a leg that differs is found among equal ones."""
    columns = columns_for(SENSORS, LEG)
    share = {}
    for off in (0.2, 0.1, 0.0):
        found = 0
        for seed in range(DRAWS):
            rng = np.random.default_rng([seed, round(100 * off)])
            sizes = [TRUE_A * (1.0 + off)] + [TRUE_A] * (LEGS - 1)
            legs = {f"leg {k}": gather(drawn_leg(rng, runs=RUNS, A=A), columns) for k, A in enumerate(sizes)}
            found += not fit_common(legs, ("T07",)).use_common
        share[off] = found
    return (
        f"On {DRAWS} drawn campaigns each of {LEGS} legs, {RUNS} runs a leg, one law was refused in {share[0.2]} "
        f"where one leg's A is 20 % off, in {share[0.1]} where it is 10 % off, and in {share[0.0]} where all legs are "
        "equal: with few runs, `--common` cannot see small differences."
    )


def beams() -> str:
    """Return how often a step of a beam is taken back where there is none, and where there is one."""
    rng = np.random.default_rng(1)

    def tilt(table: Table) -> None:
        turn = rng.uniform(5e-6, 40e-6) * np.sin(table["q_mm"] / rng.uniform(20.0, 60.0))
        if rng.random() < 0.5:
            turn = rng.uniform(5e-6, 40e-6) * (table["T01_degC"] - 20.0) / 5.0
        levers = 60.0 * np.cos(2.0 * np.pi * np.arange(3) / 3.0 + rng.uniform(0, 6.3)) + rng.uniform(-25.0, 25.0)  # mm
        for k, lever in enumerate(levers):
            table[f"beam{k + 1}_mm"] += lever * (turn - turn[0])

    def jump(table: Table) -> None:
        ramp = np.clip((np.arange(600) - rng.integers(30, 560)) / 6.0, 0.0, 1.0)
        height = 1e-3 * rng.choice([-1.0, 1.0]) * 10.0 ** rng.uniform(-0.3, 1.3)
        for beam in (1, 2, 3):
            table[f"beam{beam}_mm"] += height * ramp

    def loss(table: Table) -> None:
        if rng.random() < 0.5:
            tilt(table)
        row, size = 25 * rng.integers(1, 23) + rng.integers(6, 20), 2.0 * 100.0 ** rng.uniform()
        table[f"beam{rng.integers(1, 4)}_mm"][row:] += 1e-3 * size * rng.choice([-1.0, 1.0])

    def taken_back(count: int, edit: Callable[[Table], None]) -> int:
        total = 0
        for _draw in range(count):
            with tempfile.TemporaryDirectory() as folder:
                total += cleaned(Path(folder), edit)[1].count("beam step") > 0
        return total

    wrong = (taken_back(TILTED, tilt), taken_back(JUMPING, jump))
    return (
        f"In {TILTED} drawn runs with tilt of up to 40 µrad, and {JUMPING} with a jump of the zero of up to 20 µm, a "
        f"step was taken back in {wrong[0]} and {wrong[1]}; of {LOST} counts of 2 to 200 µm lost within rests, with "
        f"tilt or without, {taken_back(LOST, loss)} were."
    )


def best(work: Callable[[], object], turns: int = 5) -> float:
    """Return the shortest time of some turns [s], after one that counts for nothing."""
    work()
    found = []
    for _turn in range(turns):
        begin = time.perf_counter()
        work()
        found.append(time.perf_counter() - begin)
    return min(found)


def said(seconds: float) -> str:
    """Return a time as prose has it, two digits.

    Examples
    --------
    >>> said(0.0123), said(3.21e-6), said(2.0)
    ('12 ms', '3.2 µs', '2.0 s')
    """
    unit, size = next((pair for pair in (("s", 1.0), ("ms", 1e-3), ("µs", 1e-6)) if seconds >= pair[1]), ("ns", 1e-9))
    number = float(f"{seconds / size:.1e}")
    return f"{number:.0f} {unit}" if number >= 10.0 else f"{number:.1f} {unit}"


def motion(hexapod: ht.Hexapod, count: int) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return poses about home, temperatures of all thermometers, and times a second apart."""
    t = np.arange(float(count))
    five = [20.0 * np.sin(t / 300.0 + k) for k in range(3)] + [np.sin(t / 500.0 + k) for k in range(3)]
    temps = 20.0 + np.linspace(1.0, 2.0, len(hexapod.sensor_names)) * (1.0 - np.exp(-t / 3000.0))[:, None]
    return ht.pose_from_coordinates(np.column_stack(five), hexapod=hexapod), temps, t


def remembering() -> str:
    """Return the times of a machine whose legs lag."""
    drawn = ht.load_hexapod("reference")
    assert drawn.thermal is not None
    lag = LegTerm("thermal-lag", "lag", {"sensor": "T1", "ratio": 0.5, "time_constant_s": 900.0}, np.array([1e-6]))
    legs = tuple(replace(leg, terms=(lag,)) for leg in drawn.thermal.legs)
    hexapod = replace(drawn, thermal=replace(drawn.thermal, legs=legs))
    poses, temps, t = motion(hexapod, 100_000)
    rows = hexapod.leg_controllers()

    def single() -> None:
        nonlocal rows
        rows = hexapod.leg_controllers()
        for k in range(200):
            rows.corrected_leg_lengths(poses[k], temps[k], t[k])

    block = best(lambda: hexapod.leg_controllers().corrected_leg_lengths(poses, temps, t), 3)
    return (
        f"A row of `leg_controllers()` of legs that lag takes {said(best(single) / 200)} alone, and 1e5 rows as a "
        f"block take {said(block)} (one core)."
    )


def loaded() -> str:
    """Return the times of a machine with a payload."""
    soft = Compliance(leg_compliance=2e-8, payload_mass=60.0, payload_centre=[0.02, 0.0, 0.15])
    machine = replace(ht.load_hexapod("reference"), compliance=soft)
    poses, temps, _t = motion(machine, 20_000)
    lengths = machine.corrected_leg_lengths(poses, temps)
    told, reached = machine.corrected_pose, machine.predicted_pose
    times = [
        best(lambda: told(poses[7], TEMPS)), best(lambda: told(poses, temps)) / len(poses),
        best(lambda: reached(lengths[7], TEMPS)), best(lambda: reached(lengths, temps)) / len(poses),
    ]  # fmt: skip
    alone, batch, back, batches = map(said, times)
    return (
        f"With a payload a corrected pose takes {alone} alone and {batch} in a batch, a predicted one {back} and "
        f"{batches} (one core)."
    )


def budgets() -> str:
    """Return the times of budgets over many places, and of a Monte Carlo."""
    hexapod = ht.load_hexapod("reference")
    poses, _temps, _t = motion(hexapod, 4096)
    place = best(lambda: budget_map(hexapod, poses, TEMPS), 2) / len(poses)
    draws = 1_000_000
    simulated = best(lambda: monte_carlo(hexapod, hexapod.home, TEMPS, least_draws=draws, most_draws=draws), 2)
    return (
        f"A place of a map takes {said(place)} (of {len(poses)}), a Monte Carlo of 10⁶ draws with the default sources "
        f"{said(simulated)} (one core)."
    )


WRITTEN: dict[str, tuple[str, Callable[[], str]]] = {
    "intervals of validation": ("identification.md", intervals),
    "a common law": ("identification.md", common),
    "steps of beams": ("campaigns.md", beams),
    "times of legs that remember": ("extended-law.md", remembering),
    "times with a payload": ("extended-machine.md", loaded),
    "times of budgets": ("budget.md", budgets),
}
"""Each part of a page by its name, with what measures it."""


def main(arguments: Sequence[str] | None = None) -> None:
    """Measure the parts that were named, or all."""
    for name in asked(__doc__, WRITTEN, arguments):
        page, measure = WRITTEN[name]
        write_section(page, name, "measure_figures", measure())


if __name__ == "__main__":
    main()
