"""Machines that campaigns are of: those that come with the package, and drawn ones; each with a drawn law."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from hexathermal.machine.hexapod import Hexapod
from hexathermal.machine.library import bundled_hexapods, load_hexapod
from hexathermal.machine.thermal import LegLaw, PlateLaw, ThermalModel
from hexathermal.poses import FloatArray
from hexathermal.simulate.hidden.shapes import log_uniform

DRAWN = "drawn"
DRAWN_SHARE = 0.4
"""Part of the campaigns that are of a drawn machine; the others are of bundled ones in equal parts."""

WORST = 30.0
"""Largest condition of a drawn machine: largest over smallest singular value of the legs' lines, moments counted in
radii of the platform."""

SENSORS = (("T1",), ("T1", "T2"))
ONE_SENSOR = 0.75


def machine_names() -> tuple[str, ...]:
    """Return what machines there are: `DRAWN` and the bundled ones."""
    return (DRAWN, *bundled_hexapods())


def draw_machine(generator: np.random.Generator, name: str | None = None) -> Hexapod:
    """Draw a machine with a law of its legs, and perhaps of its plates.

    Parameters
    ----------
    generator : numpy.random.Generator
    name : str, optional
        One of `machine_names`; default: drawn.
    """
    if name is None:
        others = bundled_hexapods()
        shares = [DRAWN_SHARE] + [(1.0 - DRAWN_SHARE) / len(others)] * len(others)
        name = str(generator.choice(machine_names(), p=shares))
    hexapod = draw_geometry(generator) if name == DRAWN else load_hexapod(name)
    return replace(hexapod, thermal=draw_law(generator))


def draw_law(generator: np.random.Generator) -> ThermalModel:
    """Draw what a machine's file says of its legs and plates.

    Engineering values: a leg of steel whose scale is of glass or invar grows by 1 to 12e-6 of its retracted length, and
    by 0.5 to 11e-6 of its stroke; legs differ by some per cent where each was measured. Plates are left out, or grow by
    1 to 13e-6 (invar to steel).
    """
    sensors = SENSORS[0] if generator.random() < ONE_SENSOR else SENSORS[1]
    share = generator.dirichlet(np.full(len(sensors), 4.0))
    A = log_uniform(1e-6, 12e-6, generator) * share
    B = log_uniform(0.5e-6, 11e-6, generator) * share[::-1]
    spread = 0.05 if generator.random() < 0.5 else 0.0

    def near(values: FloatArray) -> FloatArray:
        """Return coefficients of one leg, to 1e-9 as files have them."""
        return np.round(values * (1.0 + spread * generator.standard_normal(values.size)), 9)

    def plate() -> PlateLaw | None:
        """Return the law of a plate, if it has one."""
        return PlateLaw(round(log_uniform(1e-6, 13e-6, generator), 9), "T1") if generator.random() < 0.5 else None

    laws = [LegLaw(sensors, near(A), near(B)) for _leg in range(6)]
    return ThermalModel(laws if spread else laws[0], plate(), plate(), valid_degC=(-10.0, 60.0))


def draw_geometry(generator: np.random.Generator) -> Hexapod:
    """Draw joints in pairs about a circle on each plate, moved about a little; the base's frame is at home or not.

    Engineering values: radii of 120 to 900 mm, platforms of 0.4 to 1.05 of the base, pairs 6 to 42 degrees apart, legs
    as steep as 35 to 70 degrees, strokes of 4 to 35 per cent of the length.
    """
    while True:
        radius = log_uniform(0.12, 0.9, generator)
        upper = radius * float(generator.uniform(0.4, 1.05))
        height = radius * float(generator.uniform(0.7, 1.9))
        base = _ring(radius, np.radians(generator.uniform(3.0, 21.0)), 0.0, generator)
        platform = _ring(upper, np.radians(generator.uniform(3.0, 21.0)), np.pi / 3.0, generator)
        # leg i goes to the nearer joint of the next pair
        platform = np.roll(platform, 1, axis=0)
        platform[:, 2] -= float(generator.choice([0.0, 0.25 * radius * generator.random()]))
        home = np.array([0.0, 0.0, height])
        if generator.random() < 0.5:
            base, home = base - home, np.zeros(3)
        if condition(base, platform + home) > WORST:
            continue
        lengths = np.linalg.norm(platform + home - base, axis=1)
        span = float(generator.uniform(0.04, 0.35)) * lengths.mean()
        retracted = np.round(lengths - span * generator.uniform(0.4, 0.6), 6)
        return Hexapod(
            np.round(base, 6), np.round(platform, 6), retracted, (0.0, round(span, 6)), np.round(home, 6),
            name="hexapod", source="no machine that exists", grade="C",
        )  # fmt: skip


def _ring(radius: float, half: float, start: float, generator: np.random.Generator) -> FloatArray:
    """Return three pairs of joints about a circle, shape (6, 3), each half an angle from its pair's middle."""
    middles = start + np.repeat([0.0, 2.0 * np.pi / 3.0, 4.0 * np.pi / 3.0], 2)
    angles = middles + half * np.tile([-1.0, 1.0], 3)
    ring = radius * np.column_stack([np.cos(angles), np.sin(angles), np.zeros(6)])
    return ring + radius * 0.02 * generator.standard_normal((6, 3))


def condition(base: FloatArray, platform: FloatArray) -> float:
    """Return how ill the legs hold the platform, see `WORST`; joints of both plates in one frame."""
    legs = platform - base
    along = legs / np.linalg.norm(legs, axis=1)[:, None]
    arm = platform - platform.mean(axis=0)
    lines = np.hstack([along, np.cross(arm, along) / np.linalg.norm(arm, axis=1).mean()])
    return float(np.linalg.cond(lines))
