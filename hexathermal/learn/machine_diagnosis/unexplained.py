"""Flexible shapes without a name: what follows a pose, a displacement, a temperature or time, and no cause explains.

They stand beside the causes as rivals, and what one cause has on a single place they have wider: a leg that is any
smooth function of the pose contains what its joint's offset makes, one that stands otherwise in each run as well; steps
at reversals in all legs contain one leg's.
"""

from __future__ import annotations

import numpy as np

from hexathermal.learn.diagnosis.trials import PREFIX
from hexathermal.learn.hexapod_data import AIR
from hexathermal.learn.machine_diagnosis.candidate import Candidate
from hexathermal.learn.machine_diagnosis.leg_terms import term_candidate
from hexathermal.learn.machine_diagnosis.tables import WAVES, time_waves
from hexathermal.learn.machine_diagnosis.view import MachineView
from hexathermal.poses import FloatArray

POWERS = (1, 2)

CUBES = 0.5
"""Size of what is of third order in the pose, over that of lower order."""

PLAYS_M = (0.0, 120e-6, 480e-6)
"""Ways of the rods in which reversals in all legs become whole."""

MOST_OF_RUNS = 8
"""Columns of what differs from run to run."""

SPREADS = np.concatenate([[1.0], 1.0 / np.arange(1, WAVES + 1)])
"""Sizes of a constant and of cosines of time, as those of a random walk."""


def flexible_candidates(view: MachineView) -> list[Candidate]:
    """Return nameless candidates, each a family of columns with one common size."""
    found = [_family("the pose", _of_pose(view)), _family("time within a run", _moved(view, view.time[:, None]))]
    for leg in range(6):
        columns = np.zeros((len(view), 6, 3))
        columns[:, leg] = _standard(view.q[:, leg, None]) ** np.arange(1, 4)
        found.append(_family(f"the displacement of leg{leg + 1}", columns))
        squares = np.zeros((len(view), 6, 2))
        heat = _standard(view.leg_heat[:, [leg]])
        squares[:, leg] = np.concatenate([heat**2, heat**3], axis=1)
        found.append(_family(f"the temperature of leg{leg + 1}", squares))
        courses = np.zeros((len(view), 6, len(SPREADS)))
        courses[:, leg] = _of_time(view)
        found.append(_family(f"time within a run, in leg{leg + 1}", courses, SPREADS))
    found.append(_family("the legs' temperatures", _moved(view, view.leg_heat)))
    for name, heat in (("the platform's temperature", view.plates[:, 0]), ("the base's temperature", view.plates[:, 1]),
                       (AIR.replace("_", " "), view.air)):  # fmt: skip
        if np.isfinite(heat).all():
            found.append(_family(name, _moved(view, np.stack([heat, heat**2], axis=1))))
    return [one for one in found if one.columns.any()]


def wide_candidates(view: MachineView) -> list[Candidate]:
    """Return nameless candidates that hold what a cause makes of one place, and much besides.

    They are rivals of names alone: where everything is fitted to tell the noise, they would take too much of it.
    """
    smooth, sizes = _smooth(view)
    found = [_family("the last move of every leg", _of_moves(view, play)) for play in PLAYS_M]
    for leg in range(6):
        columns = np.zeros((len(view), 6, len(sizes)))
        columns[:, leg] = smooth
        found.append(_family(f"the pose, in leg{leg + 1}", columns, sizes))
    from_run = _of_runs(view)
    for leg in range(6 if from_run.shape[1] > 1 else 0):
        columns = np.zeros((len(view), 6, from_run.shape[1]))
        columns[:, leg] = from_run
        found.append(_family(f"the run, in leg{leg + 1}", columns))
    return [one for one in found if one.columns.any()]


def _of_runs(view: MachineView) -> FloatArray:
    """Return 1 and cosines of the runs' numbers, shape (n, at most `MOST_OF_RUNS`): of few runs, any value of each."""
    number = np.unique(view.run, return_inverse=True)[1]
    count = int(number.max()) + 1
    waves = np.arange(min(count, MOST_OF_RUNS))
    return np.asarray(np.cos(np.pi * (number[:, None] + 0.5) / count * waves))


def _of_time(view: MachineView) -> FloatArray:
    """Return 1 and cosines of each run's time, the same in all runs, shape (n, SPREADS)."""
    waves = np.ones((len(view), 1 + WAVES))
    for run in np.unique(view.run):
        rows = np.flatnonzero(view.run == run)
        waves[rows, 1:] = time_waves(view, rows)
    return waves


def _family(follows: str, columns: FloatArray, spreads: FloatArray | None = None) -> Candidate:
    """Return a nameless candidate; its columns weigh alike, or as their spreads."""
    rms = np.sqrt((columns**2).mean(axis=(0, 1)))
    kept = columns[..., rms > 0.0]
    k = kept.shape[2]
    scale = 1e-6 / rms[rms > 0.0] * (1.0 if spreads is None else spreads[rms > 0.0])
    return Candidate(PREFIX + follows, None, tuple(f"a{j + 1}" for j in range(k)), ("",) * k, kept, scale, np.zeros(k))


def _coordinates(view: MachineView) -> FloatArray:
    """Return the pose's coordinates about 0 with a spread of 1, shape (n, 6)."""
    return _standard(np.concatenate([view.poses[:, :3, 3], view.poses[:, [2, 0, 1], [1, 2, 0]]], axis=1))


def _smooth(view: MachineView) -> tuple[FloatArray, FloatArray]:
    """Return 1, the pose's coordinates, their products and cubes, shape (n, 34), and the sizes of these."""
    own = _coordinates(view)
    one, two = np.triu_indices(6)
    parts = [np.ones((len(view), 1)), own, own[:, one] * own[:, two], own**3]
    return np.concatenate(parts, axis=1), np.concatenate([np.ones(1 + 6 + len(one)), np.full(6, CUBES)])


def _of_moves(view: MachineView, play: float) -> FloatArray:
    """Return the direction of each leg's last move in that leg, shape (n, 6, 6)."""
    settings = {"play_m": play} if play else {}
    each = [term_candidate(view, "", leg, "direction", ("step",), ("m",), settings).columns for leg in range(6)]
    return np.concatenate(each, axis=2)


def _of_pose(view: MachineView) -> FloatArray:
    """Return first and second powers of the pose's coordinates in each coordinate of the platform, (n, 6, 72)."""
    own = _coordinates(view)
    return _moved(view, np.concatenate([own**power for power in POWERS], axis=1))


def _moved(view: MachineView, values: FloatArray) -> FloatArray:
    """Return rigid motions in proportion to values (n, m), in leg lengths (n, 6, 6 m)."""
    spread = _standard(values)
    return np.asarray((view.frame[:, :, :, None] * spread[:, None, None, :]).reshape(len(view), 6, -1))


def _standard(values: FloatArray) -> FloatArray:
    """Return columns about 0 with a spread of 1; constant ones are 0."""
    centred = values - values.mean(axis=0)
    spread = centred.std(axis=0)
    return np.asarray(centred / np.where(spread > 1e-12 * (1.0 + np.abs(values).max(initial=0.0)), spread, np.inf))
