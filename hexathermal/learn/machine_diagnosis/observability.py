"""What poses and temperatures of a whole machine can tell: how large a fault must be, and which faults look alike.

Everything follows from the columns of the candidates alone (`hexathermal.learn.machine_diagnosis.separation`); nothing
that was measured enters, so the same is told of a campaign and of a plan.

**Limit of detection.** Named is what gains a log evidence above a threshold T.  With q the square, over the noise, of
what k parameters explain, and their prior at its best size, that is ``1/2 (q - k - k log(q / k))``, so that q must
exceed the root ``need`` of it at T; the least effect is the noncentrality x at which ``P(chi2_k(x) >= need)`` is the
power asked for.  Of several parameters that show unequally well it is a mean: directions differ.

**Classes.** Candidates of which each two separate by less than a log evidence of `CLOSE`, each true at twice its limit
(complete linkage): these data answer with all their names.

A machine at home whose room warms by 5 K, and it with the room, cannot tell which plate grows:

>>> from dataclasses import replace
>>> import hexathermal as ht
>>> from hexathermal.learn.machine_diagnosis.view import planned_view
>>> plate = ht.PlateLaw(11.5e-6, "T1")
>>> model = ht.ThermalModel(ht.LegLaw("T1", 2e-6, 1e-6), plate, plate)
>>> hexapod = replace(ht.load_hexapod("reference"), thermal=model)
>>> rise = np.linspace(0.0, 5.0, 20)[:, None]
>>> view = planned_view(hexapod, np.repeat(hexapod.home[None], 20, axis=0), np.repeat(rise[:, None], 6, axis=1),
...                     plates=np.repeat(rise, 2, axis=1))
>>> seen = machine_observability(view, Noise(np.array([4e-7] * 3 + [1e-6] * 3)))
>>> seen.equivalents("platform-expansion", "platform")[0]
'base-expansion'
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from hexathermal.errors import ArgumentError
from hexathermal.learn.machine_diagnosis.causes import all_candidates, catalogue
from hexathermal.learn.machine_diagnosis.circumstances import Circumstance, circumstances, missing_channels
from hexathermal.learn.machine_diagnosis.observability_result import (
    AlikeClass,
    DetectionLimit,
    MachineObservability,
    Separation,
)
from hexathermal.learn.machine_diagnosis.separation import (
    FREE_FRAME,
    Information,
    Noise,
    base_of,
    expected_evidence,
    information_of_rows,
    least_amplitude,
    needed_square,
    places_of,
    share_left,
)
from hexathermal.learn.machine_diagnosis.tables import Levels
from hexathermal.poses import FloatArray

if TYPE_CHECKING:
    from hexathermal.learn.machine_diagnosis.candidate import Candidate
    from hexathermal.learn.machine_diagnosis.view import MachineView

__all__ = [
    "CLOSE",
    "POWER",
    "THRESHOLD",
    "TWICE",
    "MachineObservability",
    "Shapes",
    "limits_of",
    "machine_observability",
    "mean_square_at",
    "one_of_each",
    "shapes_of",
    "usual_size",
]

THRESHOLD = 6.0
"""Log evidence above which a cause is named, where the caller does not say."""

POWER = 0.9
"""Part of campaigns in which an effect at its limit is named."""

CLOSE = 6.0
"""Log evidence below which two candidates are not told apart."""

TWICE = 2.0
"""Strength at which separations are asked, over the limit."""


def one_of_each(candidates: Sequence[Candidate]) -> tuple[Candidate, ...]:
    """Return one candidate of each cause and target: where settings differ, that in their middle."""
    groups: dict[str, list[Candidate]] = {}
    for one in candidates:
        groups.setdefault(one.called, []).append(one)
    return tuple(group[len(group) // 2] for group in groups.values())


def usual_size(one: Candidate) -> FloatArray:
    """Return the root mean square of a candidate's parameters before anything is measured, shape (k,)."""
    return np.hypot(one.scale, one.mean)


@dataclass(frozen=True, eq=False)
class Shapes:
    """Candidates beside each other: where their columns stand, usual sizes (K,), and what rows tell of them."""

    names: tuple[str, ...]
    places: tuple[slice, ...]
    scale: FloatArray
    information: Information
    G: FloatArray


def shapes_of(
    view: MachineView, candidates: Sequence[Candidate], noise: Noise, laws: str = "kept", levels: Levels = FREE_FRAME
) -> Shapes:
    """Return what the rows of a view tell of candidates.

    Raises
    ------
    ArgumentError
        There is no candidate, or one's columns do not belong to the rows.
    """
    n = len(view.poses)
    if not candidates:
        raise ArgumentError("no candidate was given: nothing can be told apart")
    for one in candidates:
        if one.columns.shape[:2] != (n, 6):
            raise ArgumentError(f"{one.called} has columns of shape {one.columns.shape}; expected ({n}, 6, k)")
    base = base_of(view, laws, noise, levels)
    columns = np.concatenate([one.columns for one in candidates], axis=2)
    made = information_of_rows(view, base, columns, noise, levels)
    return Shapes(
        tuple(one.called for one in candidates),
        places_of([one.columns.shape[2] for one in candidates]),
        np.concatenate([usual_size(one) for one in candidates]),
        made, made.visible(base.sizes),
    )  # fmt: skip


def machine_observability(
    view: MachineView, noise: Noise, candidates: Sequence[Candidate] | None = None, *, laws: str = "kept",
    levels: Levels = FREE_FRAME, threshold: float = THRESHOLD, power: float = POWER, close: float = CLOSE,
) -> MachineObservability:  # fmt: skip
    """Return what the rows of a view, measured or planned, can tell of candidates.

    Parameters
    ----------
    view : MachineView
    noise : Noise
    candidates : sequence of Candidate, optional
        Made of this view; of those that differ in settings alone, the one in the middle counts. Default: the whole
        catalogue at every place where these rows could show it.
    laws : str
        ``"kept"`` within its stated uncertainty, or ``"refit"`` beside every candidate, see `law_columns`.
    levels : Levels
        Sizes of what disturbs each run beside the noise; default: the measuring frame alone, free in each.
    threshold : float
        Log evidence that a name needs.
    power : float
        Part of campaigns in which an effect at its limit is to be named.
    close : float
        Log evidence below which two candidates look alike.

    Raises
    ------
    ArgumentError
        As `shapes_of`; a threshold below 0, a power not between 0 and 1.
    """
    if not (threshold >= 0.0 and 0.0 < power < 1.0 and close >= 0.0):
        raise ArgumentError(f"expected threshold >= 0, 0 < power < 1, close >= 0; found {threshold}, {power}, {close}")
    everything = candidates is None
    candidates = one_of_each(all_candidates(view) if candidates is None else candidates)
    there = {one.cause for one in candidates} if everything else set(catalogue())
    absent = tuple(cause for cause in catalogue() if cause not in there)
    shapes = shapes_of(view, candidates, noise, laws, levels)
    limits = limits_of(candidates, shapes, threshold, power)
    found = _evidence(limits, shapes)
    facts = circumstances(view)
    return MachineObservability(
        limits, absent, found, _separations(found, shapes), _classes(candidates, limits, found, close, facts),
        _hidden(limits, absent, facts), missing_channels(view), tuple(fact.words for fact in facts), threshold, power,
        close,
    )  # fmt: skip


def _hidden(limits: Sequence[DetectionLimit], absent: Sequence[str], facts: Sequence[Circumstance]) -> tuple[str, ...]:
    """Return of each cause that is not seen, everywhere or in some places, where and why."""
    lines = []
    for cause in dict.fromkeys([*absent, *(limit.cause for limit in limits)]):
        own = [limit for limit in limits if limit.cause == cause]
        lost = [limit for limit in own if not limit.seen]
        if own and not lost:
            continue
        where = "not seen" if len(lost) == len(own) else f"not seen of {', '.join(str(one.target) for one in lost)}"
        reasons = "; ".join(fact.words for fact in facts if fact.concerns([cause]))
        lines.append(f"{cause}: {where}{f' ({reasons})' if reasons else ''}")
    return tuple(lines)


def limits_of(
    candidates: Sequence[Candidate], shapes: Shapes, threshold: float = THRESHOLD, power: float = POWER
) -> tuple[DetectionLimit, ...]:
    """Return the limit of detection of each candidate."""
    return tuple(_limit(one, own, shapes, threshold, power) for one, own in zip(candidates, shapes.places, strict=True))


def _limit(one: Candidate, own: slice, shapes: Shapes, threshold: float, power: float) -> DetectionLimit:
    """Return a candidate's limit of detection."""
    s = shapes.scale[own]
    G = shapes.G[own, own]
    weight = np.diag(np.square(s))
    share = share_left(shapes.information, shapes.G, own, shapes.scale)
    k = len(s)
    x = least_amplitude(needed_square(threshold, k), power, k)
    total = float(np.trace(weight @ G))
    rows = 6.0 * shapes.information.rows
    if share == 0.0 or total <= 0.0:
        lost = {name: (float("inf"), unit) for name, unit in zip(one.names, one.units, strict=True)}
        return DetectionLimit(one.cause, one.target, float("inf"), float("inf"), float("inf"), lost, 0.0)
    t2 = x / total
    whole, shift, turn = (float(np.trace(weight @ square[own, own])) * t2 for square in shapes.information.squares)
    alone = least_amplitude(needed_square(threshold, 1), power, 1)
    with np.errstate(divide="ignore"):
        values = np.sqrt(alone / np.maximum(np.diagonal(G), 0.0))
    parameters = {name: (float(v), unit) for name, v, unit in zip(one.names, values, one.units, strict=True)}
    return DetectionLimit(
        one.cause, one.target, float(np.sqrt(whole / rows)), float(np.sqrt(2.0 * shift / rows)),
        float(np.sqrt(2.0 * turn / rows)), parameters, share,
    )  # fmt: skip


def mean_square_at(shapes: Shapes, which: int, strength: float) -> FloatArray:
    """Return the mean square of a candidate's amplitudes, shape (k, k), at an RMS of its effect over the noise."""
    own = shapes.places[which]
    weight = np.diag(np.square(shapes.scale[own]))
    whole = float(np.trace(weight @ shapes.information.squares[0][own, own]))
    return weight * (strength**2 * 6.0 * shapes.information.rows / whole) if whole > 0.0 else weight


def _evidence(limits: Sequence[DetectionLimit], shapes: Shapes) -> FloatArray:
    """Return the mean log evidence of each true candidate over each rival at twice its limit, shape (c, c)."""
    c = len(limits)
    found = np.full((c, c), np.nan)
    for i, limit in enumerate(limits):
        if limit.seen:
            Theta = mean_square_at(shapes, i, TWICE * limit.strength)
            own = shapes.places[i]
            values = [float(expected_evidence(shapes.G, rival, own, Theta, shapes.scale)) for rival in shapes.places]
            found[i] = values[i] - np.array(values)
    return found


def _separations(found: FloatArray, shapes: Shapes) -> tuple[Separation, ...]:
    """Return the separations of each two candidates that are seen, least first."""
    roots = [_inverse_root(shapes.G[own, own]) for own in shapes.places]
    pairs = []
    for i, first in enumerate(shapes.names):
        for j in range(i + 1, len(shapes.names)):
            least = min(found[i, j], found[j, i])
            if np.isfinite(least):
                cross = roots[i].T @ shapes.G[shapes.places[i], shapes.places[j]] @ roots[j]
                alike = float(cross[0, 0]) if cross.size == 1 else float(np.linalg.norm(cross, 2))
                pairs.append(Separation(first, shapes.names[j], float(least), float(np.clip(alike, -1.0, 1.0))))
    return tuple(sorted(pairs, key=lambda pair: pair.evidence))


def _inverse_root(A: FloatArray) -> FloatArray:
    """Return B with ``B' A B = 1`` in the directions that A sees."""
    values, vectors = np.linalg.eigh(A)
    live = values > 1e-9 * max(float(values[-1]), 1e-300)
    return np.asarray(vectors[:, live] / np.sqrt(values[live]))


def _classes(
    candidates: Sequence[Candidate], limits: Sequence[DetectionLimit], found: FloatArray, close: float,
    facts: Sequence[Circumstance],
) -> tuple[AlikeClass, ...]:  # fmt: skip
    """Return groups of which each two look alike."""
    from scipy.cluster.hierarchy import fcluster, linkage
    from scipy.spatial.distance import squareform

    seen = [k for k, limit in enumerate(limits) if limit.seen]
    if len(seen) < 2:
        return ()
    both = found[np.ix_(seen, seen)]
    apart = np.maximum(np.minimum(both, both.T), 0.0)
    np.fill_diagonal(apart, 0.0)
    groups = fcluster(linkage(squareform(apart, checks=False), "complete"), close, "distance")
    made = []
    for group in range(1, int(groups.max()) + 1):
        own = [seen[k] for k in np.flatnonzero(groups == group)]
        if len(own) > 1:
            causes = tuple(dict.fromkeys(candidates[k].cause for k in own))
            reasons = tuple(fact.words for fact in facts if fact.concerns(causes))
            made.append(AlikeClass(tuple(limits[k].name for k in own), causes, reasons))
    return tuple(made)
