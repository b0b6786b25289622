"""The machine's law as columns whose coefficients may be off, and what errors of the legs' thermometers make of it.

Coefficients may be off by what the file says of their uncertainty.  A thermometer reads ``dT + n``, and the law makes
``-(A q0 + B q) n`` of its error. What of ``n`` is fast is seen in the readings themselves: it is their difference from
a smooth course of time (`readings`), and a column each lets the rows decide whether it was noise or heat. The zero
that readings count from has the same noise, in the whole campaign and in each run: an offset. What its own reading is
off its course is known of it, and what the course may be off is not.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from hexathermal.errors import ArgumentError
from hexathermal.learn.hexapod_data import PLATES
from hexathermal.learn.machine_diagnosis.view import MachineView
from hexathermal.poses import FloatArray

LAWS = ("kept", "refit")
"""The law of the file, within its stated covariance; or fitted anew beside every cause."""

LOOSE = 3.0
"""Prior of a coefficient that is fitted anew, over its value."""

LEAST_PER_K = 1e-6


@dataclass(frozen=True, eq=False)
class LawColumns:
    """What the law may be off by.

    Attributes
    ----------
    columns : array, shape (n, 6, p) [m]
        For one standard deviation each, so that all priors are N(0, 1).
    known : array, shape (n, 6) [m]
        What errors of the zeros make that their own readings tell.
    words : tuple of str
    shifts : mapping of str to array, shape (c, p) [1/K]
        By which the columns' amplitudes change the coefficients: ``A..`` and ``B..`` of ``"leg1"`` to ``"leg6"`` by the
        view's thermometers, and the expansion of ``"platform"`` and ``"base"``.
    """

    columns: FloatArray
    known: FloatArray
    words: tuple[str, ...]
    shifts: Mapping[str, FloatArray]


def law_columns(view: MachineView, laws: str = "kept") -> LawColumns:
    """Return the law's columns, scaled by the square root of its prior covariance.

    With ``"kept"`` what is stated counts: ``covariance`` of a leg's law (one law for six legs is off by the same on
    all, but for its ``spread``; where it states none, all may be off together, and each by as much by itself),
    ``expansion_std`` of a plate; what states nothing is taken as exact. With ``"refit"`` the laws are fitted anew: one
    for all legs where the machine has one, else six.

    Parameters
    ----------
    view : MachineView
    laws : str
        ``"kept"`` or ``"refit"``.

    Raises
    ------
    ArgumentError
        ``laws`` is neither.
    """
    if laws not in LAWS:
        raise ArgumentError(f"laws is {laws!r}, expected one of {', '.join(map(repr, LAWS))}")
    thermal = view.hexapod.thermal
    assert thermal is not None  # checked where views are made
    parts: list[FloatArray] = []
    words: list[str] = []
    moved: list[tuple[str, int, FloatArray]] = []
    known = np.zeros((len(view), 6))
    for legs, root, label in _roots(view, laws):
        moved += [(f"leg{leg + 1}", len(words), root) for leg in legs]
        columns = np.zeros((len(view), 6, root.shape[1]))
        for leg in legs:
            columns[:, leg] = leg_columns(view, leg) @ root
        parts.append(columns)
        words += [label] * root.shape[1]
    for part, plate in zip(PLATES, (thermal.platform, thermal.base), strict=True):
        if plate is not None and plate.sensor is not None:
            std = getattr(plate, "expansion_std", None) or 0.0
            std = max(LOOSE * abs(plate.expansion), LEAST_PER_K) if laws == "refit" else std
            if std > 0.0:
                moved.append((part, len(words), np.array([[std]])))
                parts.append((std * view.plate_column(part))[..., None])
                words.append(part)
        if plate is not None and plate.sensor is not None and plate.expansion != 0.0:
            at = PLATES.index(part)
            seen = view.plate_readings
            reach = plate.expansion * view.plate_reach(part)
            own, told = _errors(view, reach, seen.flicker[:, at], seen.own[:, at])
            parts.append(own)
            known += told
            words += [f"thermometers of the {part}"] * parts[-1].shape[2]
    for leg in range(6):
        for k in np.flatnonzero(np.abs(view.laws[leg]).sum(axis=0)):
            reach = np.zeros((len(view), 6))
            reach[:, leg] = view.laws[leg, 0, k] * view.retracted[leg] + view.laws[leg, 1, k] * view.q[:, leg]
            own, told = _errors(view, reach, view.readings.flicker[:, leg, k], view.readings.own[:, leg, k])
            parts.append(own)
            words += [f"thermometers of leg {leg + 1}"] * own.shape[2]
            known += told
    return LawColumns(np.concatenate(parts, axis=2), known, tuple(words), _shifts(view, moved, len(words)))


def _shifts(view: MachineView, moved: list[tuple[str, int, FloatArray]], p: int) -> dict[str, FloatArray]:
    """Return how coefficients change with the amplitudes of p columns, from roots and where they begin."""
    found = {f"leg{leg + 1}": np.zeros((2 * len(view.sensors), p)) for leg in range(6)}
    found |= {part: np.zeros((1, p)) for part in PLATES}
    for target, at, root in moved:
        found[target][:, at : at + root.shape[1]] += root
    return found


def leg_columns(view: MachineView, leg: int) -> FloatArray:
    """Return ``q0 dT_s, q dT_s`` of a leg's thermometers, shape (n, 2 s) [m K]."""
    heat = view.heat[:, leg]
    return np.concatenate([view.retracted[leg] * heat, view.q[:, leg, None] * heat], axis=1)


def _errors(
    view: MachineView, reach: FloatArray, flicker: FloatArray, own: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return what errors of a thermometer make, of its readings and of the zeros they count from, and what is known.

    Parameters
    ----------
    view : MachineView
    reach : array, shape (n, 6) [m/K]
        What a kelvin does to the lengths.
    flicker, own : array, shape (n,)
        Of the thermometer (`hexathermal.learn.machine_diagnosis.readings.Readings`).

    Returns
    -------
    columns : array, shape (n, 6, k) [m]
    known : array, shape (n, 6) [m]
    """
    if not flicker.any():
        return np.zeros((len(view), 6, 0)), np.zeros((len(view), 6))
    noise, parts, known = reading_noise(view), [reach * flicker[:, None]], zero_errors(view, flicker)
    for shared in view.zeros:
        first = int(np.flatnonzero(shared)[0])
        unsure = noise * np.sqrt(1.0 - _noise_in_beginnings(view) * (1.0 - own[first])) if known[first] else noise
        parts.append(np.where(shared[:, None], reach * unsure, 0.0))
    return np.stack(parts, axis=2), reach * known[:, None]


def zero_errors(view: MachineView, flicker: FloatArray) -> FloatArray:
    """Return the errors of the zeros, as far as the readings that they were tell them, shape (n, ...) [K].

    What such a reading is off its course it is off itself, as far as that is noise, and all that count from it are
    too small by that.

    Parameters
    ----------
    view : MachineView
    flicker : array, shape (n, ...) [K]
        Of thermometers.
    """
    errors = np.zeros(flicker.shape)
    for shared in view.zeros:
        first = int(np.flatnonzero(shared)[0])
        # the zero must be a reading of these rows, and no other zero stand for it
        if (len(view.zeros) == 1 or not shared.all()) and not view.dT[first].any():
            errors[shared] += _noise_in_beginnings(view) * flicker[first]
    return errors


def _noise_in_beginnings(view: MachineView) -> float:
    """Return the part l of the flicker where runs begin that is noise (`readings`)."""
    size = view.readings.beginning
    return min((reading_noise(view) / size) ** 2, 1.0) if size > 0.0 else 0.0


def reading_noise(view: MachineView) -> float:
    """Return the noise of a reading [K]: the least of all thermometers, since fast heat only adds to what is seen."""
    noise = view.readings.noise
    noise = noise[view.read] if view.read.any() else noise
    return float(noise[noise > 0.0].min(initial=np.inf)) if noise.any() else 0.0


def _roots(view: MachineView, laws: str) -> list[tuple[tuple[int, ...], FloatArray, str]]:
    """Return groups of legs that are off together, a root of their covariance (2 s, r), and their name."""
    thermal = view.hexapod.thermal
    assert thermal is not None  # checked where views are made
    every = tuple(range(6))
    found: list[tuple[tuple[int, ...], FloatArray, str]] = []
    if laws == "refit":
        sizes = LOOSE * np.abs(view.laws).reshape(6, -1)
        sizes = np.where(sizes > 0.0, np.maximum(sizes, LEAST_PER_K), 0.0)
        if thermal.common_law:
            return [(every, _used(np.diag(sizes[0])), "the legs' law")]
        return [((leg,), _used(np.diag(sizes[leg])), f"the law of leg {leg + 1}") for leg in every]
    for leg, law in enumerate(thermal.legs):
        if law.covariance is None:
            continue
        places = _places(view, law.sensors)
        # equal laws that state no spread may be off by what they state together, and each by itself
        spread = np.zeros(len(law.covariance)) if law.spread is None else law.spread
        shared = law.covariance - np.diag(spread**2)
        if not thermal.common_law:
            found.append(((leg,), _placed(_root(law.covariance), places, view), f"the law of leg {leg + 1}"))
            continue
        if leg == 0:
            found.append((every, _placed(_root(shared), places, view), "the legs' law"))
        if law.spread is None:
            found.append(((leg,), _placed(_root(law.covariance), places, view), f"the law of leg {leg + 1}"))
        elif spread.any():
            found.append(((leg,), _placed(_used(np.diag(spread)), places, view), f"the law of leg {leg + 1}"))
    return found


def _places(view: MachineView, sensors: tuple[str, ...]) -> list[int]:
    """Return where ``[A .. B ..]`` of a law's own sensors stand among those of the view."""
    at = [view.sensors.index(name) for name in sensors]
    return at + [len(view.sensors) + k for k in at]


def _placed(root: FloatArray, places: list[int], view: MachineView) -> FloatArray:
    """Return a root with its rows put where they stand."""
    out = np.zeros((2 * len(view.sensors), root.shape[1]))
    out[places] = root
    return out


def _root(covariance: FloatArray) -> FloatArray:
    """Return a root of a covariance, without directions that it knows exactly."""
    values, vectors = np.linalg.eigh(covariance)
    kept = values > 1e-12 * max(float(values[-1]), 0.0)
    return np.asarray(vectors[:, kept] * np.sqrt(values[kept]))


def _used(root: FloatArray) -> FloatArray:
    """Return a root without columns of zeros."""
    return np.asarray(root[:, root.any(axis=0)])
