"""Write the bundled machines' hexapod.toml from their published or stated numbers.

Run from the repository's root: ``python tools/make_models.py``.
"""

from __future__ import annotations

from decimal import Decimal
from pathlib import Path

import numpy as np

import hexathermal as ht
from hexathermal.machine.units import radians

MODELS = Path(__file__).resolve().parent.parent / "models"

RUBIN_SOURCE = (
    "Rubin Observatory, lsst-ts/ts_mthexapod, constants.py (drawing coordinates received 2020-02-13): "
    "strut joints, pivot, strut range and position limits"
)


def reference() -> ht.Hexapod:
    """Return a machine of the paper's class: stroke 250 mm, about 30 000 cm3, eq. (8) on every leg."""
    base, platform = [], []
    for third in (0, 120, 240):
        for side in (-1, 1):
            a, p = np.radians(third + side * 10), np.radians(third + side * 50)
            base.append([450 * np.cos(a), 450 * np.sin(a), -663.3])
            platform.append([300 * np.cos(p), 300 * np.sin(p), 0.0])
    law = ht.LegLaw(
        sensors=("T1",),
        A=np.array([1.99e-6]),
        B=np.array([1.09e-6]),
        campaign="published: eq. (8) of Robert et al., thermocouple 7 on every leg",
    )
    invar = ht.PlateLaw(1.6e-6)
    return ht.Hexapod(
        base_joints=np.round(np.array(base) / 1000, 6),
        platform_joints=np.round(np.array(platform) / 1000, 6),
        retracted_length=0.6,
        stroke=[0.0, 0.25],
        home=[0.0, 0.0, 0.0],
        base_cone=np.radians(45.0),
        platform_cone=np.radians(45.0),
        thermal=ht.ThermalModel(
            law, platform=invar, base=invar, reference_temperature_degC=20.0, valid_degC=(0.0, 50.0)
        ),
        name="reference",
        source="A machine of the class of Robert et al., Model-based thermal drift compensation for high-precision "
        "hexapod robot actuators: stroke 250 mm, eq. (8) on every leg. Geometry chosen here",
        grade="C",
        bodies=ht.Bodies(0.080, 0.040, 6.0, 3.0, 25.0, 0.030, 0.040),
    )


def rubin(
    name: str,
    moving_um: list[list[int]],
    fixed_um: list[list[int]],
    pivot_um: list[int],
    travel_um: tuple[int, int],
    turns_deg: tuple[str, str],
) -> ht.Hexapod:
    """Return a Rubin Observatory hexapod: moving points turn about the pivot, strut range about home.

    `travel_um`: position limits of x and y, and of z; `turns_deg`: of rx and ry, and of rz.
    """
    moving, fixed, pivot = np.array(moving_um) / 1e6, np.array(fixed_um) / 1e6, np.array(pivot_um) / 1e6
    home_lengths = np.round(np.linalg.norm(moving - fixed, axis=1), 9)
    (across, along), (tilt, turn) = (value / 1e6 for value in travel_um), (radians(Decimal(text)) for text in turns_deg)
    return ht.Hexapod(
        base_joints=fixed,
        platform_joints=np.round(moving - pivot, 9),
        retracted_length=home_lengths,
        stroke=[-0.0141, 0.0141],
        home=pivot,
        name=name,
        source=RUBIN_SOURCE,
        grade="C",
        limits=ht.PoseLimits(
            (-across, across), (-across, across), (-along, along), (-tilt, tilt), (-tilt, tilt), (-turn, turn),
            convention="fixed-zyx",
        ),
    )  # fmt: skip


CAMERA = rubin(
    "rubin-camera",
    [[227600, 653800, -525000], [-227600, 653800, -525000], [-680000, -129700, -525000],
     [-452300, -524000, -525000], [452300, -524000, -525000], [680000, -129700, -525000]],
    [[472800, 512200, -121400], [-472800, 512200, -121400], [-680000, 153300, -121400],
     [-207200, -665500, -121400], [207200, -665500, -121400], [680000, 153300, -121400]],
    [0, 0, -2758400],
    (11400, 13100),
    ("0.36", "0.10"),
)  # fmt: skip
M2 = rubin(
    "rubin-m2",
    [[0, 1701800, 114300], [-1542350, -719210, 114300], [1542350, -719210, 114300],
     [790, 1460490, 228600], [-1503370, 7660, 228600], [1503370, 7660, 228600]],
    [[0, 1701800, 607300], [-1542350, -719210, 607300], [1542350, -719210, 607300],
     [493790, 1460490, 228600], [-1256870, -419290, 228600], [1256870, -419290, 228600]],
    [0, 0, -703000],
    (10500, 8900),
    ("0.175", "0.05"),
)  # fmt: skip


if __name__ == "__main__":
    for machine in (reference(), CAMERA, M2):
        (MODELS / machine.name).mkdir(parents=True, exist_ok=True)
        print(ht.write_hexapod(machine, MODELS / machine.name))
