"""Machines with every extension, for tests."""

from __future__ import annotations

import dataclasses

import numpy as np

import hexathermal as ht
from hexathermal.machine.compliance import Compliance
from hexathermal.machine.leg_terms import LegTerm
from hexathermal.machine.measuring_frame import MeasuringFrame

SCREW = LegTerm("periodic-screw-error", "periodic", {"pitch_m": 0.00203}, [0.4e-6, -0.2e-6], np.diag([1e-15, 2e-15]))
SLACK = LegTerm("leg-backlash", "direction", {}, [1.2e-6], np.array([[1e-15]]))


def extended_machine(rng: np.random.Generator, terms: tuple[LegTerm, ...] = (SCREW,), leg: int = 2) -> ht.Hexapod:
    """Return the reference machine with six laws of two thermometers, terms in one leg, plates, a payload and a frame.

    Joints are a little off those of the drawing; two legs' plugs are exchanged, the last leg has one thermometer.
    """
    laws = [
        ht.LegLaw(
            ("T1", "T2")[:n], rng.normal(1.5e-6, 2e-7, n), rng.normal(0.8e-6, 1e-7, n), terms=terms if i == leg else ()
        )
        for i, n in enumerate((2, 2, 2, 2, 2, 1))
    ]  # fmt: skip
    exchange = np.arange(1, 7)
    a, b = rng.choice(6, 2, replace=False)
    exchange[[a, b]] = exchange[[b, a]]
    model = ht.ThermalModel(
        laws, ht.PlateLaw(1.1e-5, "T1", 3e-7), ht.PlateLaw(9e-6, "T1"), rng.uniform(19.0, 21.0, 13), (0.0, 50.0),
        exchange.tolist(),
    )  # fmt: skip
    soft = Compliance(
        rng.uniform(0.5e-8, 4e-8, 6), rng.uniform(20.0, 150.0), rng.normal(size=3) * 0.15,
        [0.7, -1.1, -9.6] + rng.normal(size=3), 1e-9, 0.25, [1e-3, 1e-3, 2e-3],
    )  # fmt: skip
    room = MeasuringFrame("air_temperature", rng.normal(size=3) * 1e-6, rng.normal(size=3) * 1e-6, [1e-7, 1e-7, 2e-7])
    drawn = ht.load_hexapod("reference")
    return dataclasses.replace(
        drawn, platform_joints=drawn.platform_joints + rng.normal(size=(6, 3)) * 1e-5, thermal=model, compliance=soft,
        measuring_frame=room, name="extended",
    )  # fmt: skip
