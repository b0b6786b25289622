"""Legs that tests draw: seventeen thermometers on a warm leg, landings, slow biases; the truth is known."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from hexathermal.learn.campaign import Block, LegDimensions, RunFile

LEG = LegDimensions(0.6, (0.0, 0.25))
SENSORS = tuple(f"T{k + 1:02d}" for k in range(17))
TRUE_A, TRUE_B = 2.0e-6, 1.1e-6
STEP_S = 30.0


def drawn_leg(
    rng: np.random.Generator,
    runs: int = 8,
    hours: float = 3.0,
    *,
    noise: float = 0.03,
    bias: float = 0.05,
    landing: float = 0.15e-6,
    A: float = TRUE_A,
    B: float = TRUE_B,
    true_sensors: tuple[int, ...] = (6,),
    role: str = "identification",
) -> list[Block]:
    """Return one block a run; drift = A q0 dT + B q dT of the mean of the true sensors, with heavy-tailed landings."""
    return [_run(rng, f"{role}-{r}", hours, noise, bias, landing, A, B, true_sensors, role) for r in range(runs)]


def _run(rng, name, hours, noise, bias, landing, A, B, true_sensors, role) -> Block:  # type: ignore[no-untyped-def]
    n = int(hours * 3600 / STEP_S)
    t = np.arange(n) * STEP_S
    moving, q, number = np.zeros(n, bool), np.empty(n), np.zeros(n, np.int64)
    at, k, landing_number = rng.uniform(0.02, 0.2), 0, 0
    while k < n:
        rest = k + int(rng.exponential(25)) + 4
        q[k:rest], number[k:rest] = at, landing_number
        k = rest
        for _move in range(int(rng.integers(2, 14))):
            at = at + 0.01 if rng.random() < 0.5 else at - 0.01
            at = 0.02 - at if at < 0.0 else 0.5 - at if at > 0.25 else at
            landing_number += 1
            q[k : k + 3], number[k : k + 3], moving[k : k + 3] = at, landing_number, True
            k += 3
    from scipy.signal import lfilter

    x = np.linspace(0.0, 1.0, len(SENSORS))
    modes = [lfilter([1 - a], [1, -a], moving.astype(float)) for a in np.exp(-STEP_S / np.array([1200.0, 5000.0]))]
    room = rng.normal() * np.sin(t / 3600.0 + rng.uniform(0, 6))
    true = 4.0 * np.outer(modes[0], np.exp(-2.5 * x)) + 9.0 * np.outer(modes[1], 1.0 - 0.6 * x)
    true = true + np.outer(room, 0.7 + 0.3 * x)
    true = true - true[0]
    a = np.exp(-STEP_S / 3000.0)
    start = rng.normal(size=(1, len(SENSORS)))
    slow = (
        lfilter([np.sqrt(1 - a * a)], [1, -a], rng.normal(size=true.shape), axis=0) + start * a ** np.arange(n)[:, None]
    )
    read = true + bias * slow + noise * rng.normal(size=true.shape)
    warm = true[:, list(true_sensors)].mean(axis=1)
    scatter = landing * rng.standard_t(4, size=landing_number + 20) / np.sqrt(2.0)
    drift = (A * LEG.retracted_length + B * q) * warm + scatter[number] + 0.02e-6 * rng.normal(size=n)
    run = RunFile(name, Path(name + ".csv"), role)
    return Block(run, t, read - read[0], drift - drift[0], q, number, np.zeros((n, 0)), np.full((n, 3), np.nan))
