"""Make `hexathermal/kinematics/modes_start.npz`: five generic complex machines and their 40 postures each.

A solution x is drawn first and the machine chosen to fit it (the constants c_i of the legs are solved for);
the other 39 are reached by monodromy: the machine is led around random closed triangles in the space of
complex machines, and each solution followed around the loop ends at a solution, often another one.
40 is the number for a general machine, so the search is over when 40 are found.  The other four machines
are drawn, and the 40 solutions followed to them.

Run from the repository root; the same seed gives the same file up to rounding::

    python tools/make_modes_start.py
"""

from __future__ import annotations

import argparse
import itertools
import pathlib

import numpy as np
import numpy.typing as npt

from hexathermal.kinematics import modes_tracker as tracker

C128 = npt.NDArray[np.complex128]
TARGET = pathlib.Path(__file__).parents[1] / "hexathermal" / "kinematics" / "modes_start.npz"
SOLUTIONS = 40
MACHINES = 5
MOST_LOOPS = 100


def draw(random: np.random.Generator, *shape: int) -> C128:
    """Return complex normal numbers of unit variance."""
    numbers: C128 = (random.normal(size=shape) + 1j * random.normal(size=shape)) / np.sqrt(2)
    return numbers


def leg_values(legs: C128, x: C128) -> C128:
    """Return q_i(x) (6,) of a machine (6, 7), term by term as `modes_tracker` defines them."""
    c, p, b = legs[:, 0], legs[:, 1:4], legs[:, 4:]
    e0, ev, h0, hv = x[0], x[1:4], x[4], x[5:]
    straight, crossed = e0 * hv - h0 * ev, np.cross(ev, hv)
    turned = (e0 * e0 - ev @ ev) * p + 2 * (p @ ev)[:, None] * ev + 2 * e0 * np.cross(ev, p)  # e p e*
    values: C128 = x[4:] @ x[4:] + c * (x[:4] @ x[:4]) - 2 * (b * turned).sum(axis=1)
    values += 2 * (p - b) @ straight - 2 * (p + b) @ crossed
    return values


def draw_machine(random: np.random.Generator) -> tuple[C128, C128]:
    """Return a random complex machine (6, 7) and one of its solutions (8,), a unit vector."""
    x = draw(random, 8)
    x[4:] -= x[:4] * (x[:4] @ x[4:]) / (x[:4] @ x[:4])  # onto the Study quadric
    legs = np.zeros((6, 7), np.complex128)
    legs[:, 1:] = 0.8 * draw(random, 6, 6)
    legs[:, 0] = -leg_values(legs, x) / (x[:4] @ x[:4])
    return legs, x / np.linalg.norm(x)


def add_distinct(known: C128, candidates: C128) -> C128:
    """Append the candidates that differ from all known unit vectors by more than 1e-6, phase apart."""
    for x in candidates:
        products = known.conj() @ x
        if np.linalg.norm(x - products[:, None] * known, axis=1).min() > 1e-6:
            known = np.concatenate([known, x[None]])
    return known


def find_all(random: np.random.Generator) -> tuple[C128, C128]:
    """Return a machine (6, 7) and its 40 solutions (40, 8)."""
    legs, x = draw_machine(random)
    known = x[None]
    for loop in range(MOST_LOOPS):
        corners = [legs, 0.8 * draw(random, 6, 7), 0.8 * draw(random, 6, 7), legs]
        points, good = known, np.ones(len(known), np.bool_)
        for here, there in itertools.pairwise(corners):
            points, states, _ = tracker.track_all(here, there, points, 0.2)
            good &= states == tracker.REGULAR
        known = add_distinct(known, points[good])
        print(f"loop {loop + 1}: {len(known)} solutions")
        if len(known) == SOLUTIONS:
            return legs, known
    raise RuntimeError(f"{len(known)} solutions after {MOST_LOOPS} loops, not {SOLUTIONS}; try another seed")


def follow_all(legs: C128, solutions: C128, target: C128) -> C128:
    """Return the 40 solutions of another machine."""
    ends, states, _ = tracker.track_all(legs, target, solutions, 0.2)
    distinct = add_distinct(ends[:1], ends[1:])
    if np.any(states != tracker.REGULAR) or len(distinct) != SOLUTIONS:
        raise RuntimeError("a path was lost on the way to another start machine; try another seed")
    return ends


def main() -> None:
    """Write the file and say how well its solutions solve the equations."""
    parser = argparse.ArgumentParser(description="Make the start machines of hexathermal.kinematics.modes.")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--output", type=pathlib.Path, default=TARGET)
    arguments = parser.parse_args()
    random = np.random.default_rng(arguments.seed)
    first, known = find_all(random)
    machines, solutions = [first], [known]
    for _ in range(MACHINES - 1):
        machines.append(0.8 * draw(random, 6, 7))
        solutions.append(follow_all(first, known, machines[-1]))
    pairs = zip(machines, solutions, strict=True)
    worst = max(float(np.abs(leg_values(legs, x)).max()) for legs, points in pairs for x in points)
    np.savez_compressed(arguments.output, legs=np.array(machines), solutions=np.array(solutions))
    print(f"{arguments.output}: largest equation error {worst:.1e}")


if __name__ == "__main__":
    main()
