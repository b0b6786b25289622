"""Plans carried out on a virtual hexapod: its forward solution and rotations share nothing with the package's."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

import hexathermal as ht
from hexathermal.kinematics.inverse import inverse_kinematics
from hexathermal.kinematics.sampled_poses import reachable_coordinates
from hexathermal.learn.hexapod_model import row_covariance
from hexathermal.learn.machine_diagnosis.candidate import Candidate
from hexathermal.learn.machine_diagnosis.causes import all_candidates
from hexathermal.learn.machine_diagnosis.scenarios import Scenario, usual_scenarios
from hexathermal.learn.machine_diagnosis.separation import Noise
from hexathermal.learn.machine_diagnosis.view import MachineView, planned_view
from hexathermal.simulate.hidden.machines.physics import as_filed, measured
from hexathermal.simulate.hidden.machines.truth import MachineRunTruth, MachineTruth
from tests.learn.hexapods import NOISE, machine

FRAME = 100.0
SIZES = np.geomspace(1e-3, 30.0, 30)
PLATFORM, BASE = "platform-expansion", "base-expansion"


def lawful() -> ht.Hexapod:
    """The reference machine with a law whose plates have thermometers."""
    law = ht.LegLaw(("T1",), [2.0e-6], [1.1e-6])
    model = ht.ThermalModel(law, ht.PlateLaw(6e-6, "T1"), ht.PlateLaw(6e-6, "T1"))
    return replace(machine(), thermal=model)


def warmed_at_home(rows: int = 30, *, plates: bool = True, air: bool = True) -> MachineView:
    """A machine that stays at home while everything warms alike by 5 K."""
    hexapod, course = lawful(), 5.0 * np.linspace(0.0, 1.0, rows)
    return planned_view(
        hexapod, np.repeat(hexapod.home[None], rows, axis=0), np.repeat(course[:, None, None], 6, axis=1),
        plates=np.repeat(course[:, None], 2, axis=1) if plates else None, air=course if air else None,
    )  # fmt: skip


def chosen(view: MachineView, *names: str) -> list[Candidate]:
    """Candidates of a view by their names; of several settings the first."""
    made = {one.called: one for one in reversed(all_candidates(view))}
    return [made[name] for name in names]


def truth_of(view: MachineView, coordinates: np.ndarray) -> MachineTruth:
    """A virtual machine that does what a plan says; coordinates (n, 6) [mm, deg]."""
    runs = []
    for k, name in enumerate(view.runs):
        own = view.run == k
        n = int(own.sum())
        six = coordinates[own] * ([1e-3] * 3 + [np.pi / 180.0] * 3)
        zeros = np.zeros((n, 6))
        runs.append(MachineRunTruth(
            name, "identification", view.time[own], six, view.q[own], 20.0 + view.dT[own], 20.0 + view.plates[own],
            20.0 + np.nan_to_num(view.air[own]), np.zeros(view.dT[own].shape), np.zeros((n, 2)), np.zeros(n), zeros,
            zeros, zeros, np.zeros((n, 6, 3)), zeros,
        ))  # fmt: skip
    hexapod = view.hexapod
    empty = np.zeros(0)
    return as_filed(MachineTruth(
        hexapod, "plan", tuple(runs), "run", NOISE, (True, True), True, empty, empty, empty, hexapod.base_joints,
        hexapod.platform_joints,
    ))  # fmt: skip


def residual(view: MachineView, truth: MachineTruth) -> np.ndarray:
    """Leg lengths that the law does not explain, shape (n, 6) [m], as a faulty machine would show them."""
    six = measured(truth) * ([1e3] * 3 + [180.0 / np.pi] * 3)
    poses = ht.pose_from_coordinates(six, hexapod=view.hexapod)
    lengths = inverse_kinematics(view.hexapod, poses)
    return lengths - view.retracted - view.q - replace(view, poses=poses).law_drift


def reached(
    view: MachineView, candidates: list[Candidate], clean: np.ndarray, draws: int, rng: np.random.Generator
) -> np.ndarray:
    """Log evidence of candidates, shape (draws, c), of residuals with noise: dense, by the definition of it.

    The frame of each run is integrated over a wide prior; each candidate has its best size.
    """
    V = row_covariance(view.hexapod, view.poses, NOISE, 0.0)
    L = np.linalg.cholesky(V)
    n = len(view)
    runs = np.unique(view.run)
    U = np.zeros((n, 6, 6 * len(runs)))
    for k, run in enumerate(runs):
        own = view.run == run
        U[own, :, 6 * k : 6 * k + 6] = FRAME * (view.frame * NOISE)[own]
    W = np.linalg.solve(L, U).reshape(6 * n, -1)
    P = np.linalg.inv(np.eye(6 * n) + W @ W.T)
    y = np.linalg.solve(L, clean[..., None]).reshape(-1, 1) + rng.standard_normal((6 * n, draws))
    found = []
    for one in candidates:
        Z = np.linalg.solve(L, one.columns * np.hypot(one.scale, one.mean)).reshape(6 * n, -1)
        G, g = Z.T @ P @ Z, Z.T @ P @ y
        each = []
        for size in SIZES:
            H = np.linalg.inv(G + np.eye(len(G)) / size**2)
            gain = 0.5 * np.einsum("id,ij,jd->d", g, H, g)
            each.append(gain - 0.5 * np.linalg.slogdet(np.eye(len(G)) + size**2 * G)[1])
        found.append(np.max(each, axis=0))
    return np.array(found).T


def random_plan(
    view: MachineView, slots: int, rng: np.random.Generator, way: Scenario | None = None
) -> tuple[MachineView, np.ndarray]:
    """As many random feasible poses under a scenario, a random one where none is given."""
    six = reachable_coordinates(view.hexapod, slots, rng)
    way = way or usual_scenarios()[int(rng.integers(len(usual_scenarios())))]
    dT, plates, air = way.temperatures(np.linspace(0.0, 1.0, slots), 1)
    poses = ht.pose_from_coordinates(six, hexapod=view.hexapod)
    return planned_view(view.hexapod, poses, dT, plates=plates, air=air), six


def usual_noise() -> Noise:
    """Noise of the virtual tracker."""
    return Noise(NOISE)
