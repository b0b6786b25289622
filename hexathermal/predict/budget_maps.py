"""Error budgets over poses and over times: maps, paths and days; which is worst, and why."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Unpack

import numpy as np
import numpy.typing as npt

from hexathermal.errors import ArgumentError, UnknownNameError
from hexathermal.machine.hexapod import Hexapod
from hexathermal.machine.thermal import TemperaturesLike, frozen
from hexathermal.poses import FloatArray, PoseLike, finite_array, pose_array, pose_from_coordinates
from hexathermal.predict.budget import checked_sources
from hexathermal.predict.budget_gum import checked_probability, coverage_factor
from hexathermal.predict.budget_inputs import checked_air
from hexathermal.predict.budget_many import CHUNK, Chunk, SourceTable, budgets_of_chunk, source_table
from hexathermal.predict.budget_map import BudgetMap
from hexathermal.predict.budget_plates import Plates, each_of, stated_alike
from hexathermal.predict.budget_view import View, settings
from hexathermal.predict.leg_drift import between_reversals
from hexathermal.predict.sources import Source
from hexathermal.predict.temperatures import active_model, check_temperatures, temperature_array

LARGEST_GRID = 100_000


def budget_map(
    hexapod: Hexapod,
    poses: npt.ArrayLike,
    temps: TemperaturesLike,
    sources: Iterable[Source] | None = None,
    *,
    probability: float = 0.95,
    each_plates: Sequence[Plates] | None = None,
    each_air_degC: npt.ArrayLike | None = None,
    progress: Callable[[int, int], None] | None = None,
    **view: Unpack[View],
) -> BudgetMap:
    """Return budgets at many poses, at many sets of temperatures, or at pairs of both.

    Poses that cannot be reached (stroke, cone, singular) stay in the map as NaN, with their reason in `refused`; wrong
    temperatures and arguments are errors.

    Parameters
    ----------
    hexapod : Hexapod
    poses : array, shape (N, 4, 4) or (4, 4) [m]
        A grid (`pose_grid`), a path, or one pose for a day.
    temps : array, shape (N, n) or (n,) [degC], or mapping
        Broadcast against the poses.
    sources, and keywords of `View`
        As in `hexathermal.predict.budget.error_budget`.
    each_plates, each_air_degC
        Plates and air of each place, in place of `plates` and `air_degC` for all.
    progress : callable, optional
        ``progress(done, total)``.

    Raises
    ------
    ArgumentError, HexathermalError
        Shapes that do not fit each other; as `error_budget`, save for poses that cannot be reached.

    Examples
    --------
    >>> import hexathermal as ht
    >>> hexapod = ht.load_hexapod("reference")
    >>> found = budget_map(hexapod, pose_grid(hexapod, x_mm=(-50, 50, 3)), [25.0] * 6)
    >>> found.worst().index in (0, 2)                      # the ends of the path
    True
    """
    flat, hot = _paired(hexapod, poses, temps)
    count, p = len(flat), checked_probability(probability)
    check_temperatures(hexapod, hot)
    correction, seen, common, air_degC = settings(**view)
    plates = each_of(common, each_plates, count)
    air = np.broadcast_to(checked_air(hexapod, air_degC), (count,))
    air = air if each_air_degC is None else checked_air(hexapod, each_air_degC, (count,))
    made = _Made(flat, hot, p, seen.frame)
    tables = _tables(hexapod, sources, plates)
    made.prepare({label for _rows, table in tables for label in table.labels})
    for rows, table in tables:
        for first in range(0, len(rows), CHUNK):
            part = rows[first : first + CHUNK]
            own = [plates[k] for k in part]
            chunk = budgets_of_chunk(hexapod, flat[part], hot[part], air[part], own, seen, correction, table)
            made.add(part, table.labels, chunk, progress)
    return made.finished()


def _tables(
    hexapod: Hexapod, sources: Iterable[Source] | None, plates: list[Plates]
) -> list[tuple[npt.NDArray[np.intp], SourceTable]]:
    """Return sources with the places that they are of: default ones know which plates are stated."""
    groups = stated_alike(plates) if sources is None else [np.arange(len(plates), dtype=np.intp)]
    middle = between_reversals(hexapod)
    return [(rows, source_table(middle, checked_sources(hexapod, sources, plates[rows[0]]))) for rows in groups]


class _Made:
    """A map being made: arrays that chunks fill."""

    def __init__(self, poses: FloatArray, temps: FloatArray, probability: float, frame: str) -> None:
        self.poses, self.temps, self.probability, self.frame = poses, temps, probability, frame
        self.done, self.refused = 0, dict[int, str]()
        self.numbers = np.full((4, len(poses), 6), np.nan)
        self.causes: dict[int, tuple[tuple[str, ...], FloatArray]] = {}

    def prepare(self, labels: Iterable[str]) -> None:
        """Make room for the sources of all places."""
        self.labels = tuple(sorted(labels))
        self.shares = np.full((len(self.poses), len(self.labels), 6), np.nan)

    def add(
        self,
        part: npt.NDArray[np.intp],
        labels: tuple[str, ...],
        chunk: Chunk,
        progress: Callable[[int, int], None] | None,
    ) -> None:
        """Add the budgets of some places."""
        own, whole = part[chunk.kept], chunk.variances.sum(axis=1, keepdims=True)
        u = np.sqrt(whole[:, 0])
        worst = np.abs(chunk.remaining) + coverage_factor(chunk.dof, self.probability) * u
        self.numbers[:, own] = chunk.uncorrected, chunk.remaining, u, worst
        shares = np.divide(chunk.variances, whole, out=np.zeros_like(chunk.variances), where=whole > 0.0)
        self.shares[own[:, None], [self.labels.index(label) for label in labels]] = shares
        self.causes |= {int(k): found for k, found in zip(own, chunk.causes, strict=True)}
        self.refused |= {int(part[k]): reason for k, reason in chunk.refused.items()}
        self.done += len(part)
        if progress is not None:
            progress(self.done, len(self.poses))

    def finished(self) -> BudgetMap:
        """Return the map."""
        names = tuple(dict.fromkeys(name for k in sorted(self.causes) for name in self.causes[k][0]))
        parts = np.full((len(self.poses), len(names), 6), np.nan)
        for k, (own, values) in self.causes.items():
            parts[k] = 0.0
            parts[k, [names.index(name) for name in own]] = values
        drift, remaining, uncertainty, worst = (frozen(array) for array in self.numbers)
        return BudgetMap(
            frozen(self.poses), frozen(self.temps), drift, remaining, uncertainty, worst,
            tuple(sorted(self.refused.items())), self.labels, frozen(self.shares), self.probability, self.frame, names,
            frozen(parts),
        )  # fmt: skip


def _paired(hexapod: Hexapod, poses: PoseLike, temps: TemperaturesLike) -> tuple[FloatArray, FloatArray]:
    """Return poses (N, 4, 4) and temperatures (N, n)."""
    flat, hot = pose_array(poses, "poses"), temperature_array(hexapod, temps)
    if flat.ndim > 3 or hot.ndim > 2:
        raise ArgumentError(f"poses and temps of a map are lists, found shapes {flat.shape} and {hot.shape}")
    flat, hot = flat.reshape(-1, 4, 4), hot.reshape(-1, hot.shape[-1])
    count = max(len(flat), len(hot))
    if len(flat) not in (1, count) or len(hot) not in (1, count) or not min(len(flat), len(hot)):
        raise ArgumentError(
            f"{len(flat)} poses and {len(hot)} sets of temperatures do not pair up; give one or as many"
        )
    return np.broadcast_to(flat, (count, 4, 4)), np.broadcast_to(hot, (count, hot.shape[1]))


def pose_grid(
    hexapod: Hexapod,
    *,
    convention: str = "fixed-xyz",
    around: npt.ArrayLike = (0.0,) * 6,
    **spans: tuple[float, float, int],
) -> FloatArray:
    """Return poses on a grid of coordinates counted from home.

    Parameters
    ----------
    hexapod : Hexapod
    convention : str
    around : array, shape (6,) [mm, deg]
        Coordinates that no span moves.
    x_mm, y_mm, z_mm, rx_deg, ry_deg, rz_deg : (low, high, count)
        At least one; ``count`` values from low to high. The last one given changes fastest.

    Returns
    -------
    array, shape (N, 4, 4) [m]

    Raises
    ------
    UnknownNameError
        A span of another name.
    ArgumentError
        No span, a count that is no whole number above 0, or more than 100 000 poses.
    """
    return pose_from_coordinates(grid_coordinates(around, spans), convention, hexapod)


def grid_coordinates(around: npt.ArrayLike, spans: dict[str, tuple[float, float, int]]) -> FloatArray:
    """Return the coordinates (N, 6) [mm, deg] of a grid, see `pose_grid`."""
    names = ("x_mm", "y_mm", "z_mm", "rx_deg", "ry_deg", "rz_deg")
    centre = finite_array(around, (6,), "around")
    if not spans:
        raise ArgumentError(f"a grid needs at least one span: {', '.join(names)}")
    values = []
    for name, span in spans.items():
        if name not in names:
            raise UnknownNameError(f"span {name!r} is not known; choose from {', '.join(names)}", names)
        try:
            low, high, count = span
        except (TypeError, ValueError):
            raise ArgumentError(
                f"span {name} must be (low, high, count), such as (-50.0, 50.0, 11), found {span!r}"
            ) from None
        if not isinstance(count, int | np.integer) or isinstance(count, bool) or count < 1:
            raise ArgumentError(f"count of span {name} must be a whole number above 0, found {count!r}")
        ends = finite_array([low, high], (2,), f"span {name}")
        values.append(np.linspace(ends[0], ends[1], int(count)))
        if np.prod([float(len(row)) for row in values]) > LARGEST_GRID:
            raise ArgumentError(f"the grid has more than {LARGEST_GRID} poses; give smaller counts")
    mesh = np.meshgrid(*values, indexing="ij")
    out = np.tile(centre, (mesh[0].size, 1))
    for name, grid in zip(spans, mesh, strict=True):
        out[:, names.index(name)] = grid.ravel()
    return out


def graded_temperatures(hexapod: Hexapod, mean_degC: float, gradient_K_per_m: npt.ArrayLike) -> FloatArray:
    """Return temperatures of a machine with a gradient across its six legs.

    ``T_i = mean + g . (m_i - m)`` with the middles ``m_i`` of the legs at home and their mean ``m``, base axes.
    Thermometers of plates read the mean; `Plates` holds the gradients of plates.

    Parameters
    ----------
    hexapod : Hexapod
    mean_degC : float
    gradient_K_per_m : array, shape (3,)

    Returns
    -------
    array, shape (n,) [degC]
        In the order of `hexapod.sensor_names`.
    """
    model = active_model(hexapod)
    slope = finite_array(gradient_K_per_m, (3,), "gradient_K_per_m")
    if slope.shape != (3,):
        raise ArgumentError(f"gradient_K_per_m has shape {slope.shape}; expected (3,)")
    mean = float(finite_array(mean_degC, (), "mean_degC"))
    moved = hexapod.platform_joints @ hexapod.home[:3, :3].T + hexapod.home[:3, 3]
    middles = 0.5 * (moved + hexapod.base_joints)
    legs = mean + (middles - middles.mean(axis=0)) @ slope
    temps = np.full(len(model.sensor_names), mean)
    for leg, own in enumerate(model.columns_of_leg):
        temps[own] = legs[leg]
    return temps
