"""Laws of a whole hexapod from 6-D measurements of its platform alone, or judged by them: `identify_hexapod`.

Three kinds of laws are compared on runs left out: one law for all legs; one law for each leg; laws that come from
elsewhere, as from campaigns of the legs on a bench.  A kind with more freedom is taken only where it is better on runs
left out by more than its spread between runs explains.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from hexathermal.errors import ArgumentError, DataError
from hexathermal.learn.choice import decided
from hexathermal.learn.hexapod_data import PLATES, HexapodRows
from hexathermal.learn.hexapod_fit import HexapodFit
from hexathermal.learn.hexapod_model import HexapodEquations, pose_residuals
from hexathermal.learn.hexapod_noise import Kinds, frames_of, leg_and_plate, settled
from hexathermal.learn.hexapod_offset import far_poses
from hexathermal.learn.hexapod_spread import leg_spread
from hexathermal.learn.hexapod_stated import refuse_unread_terms, stated_notes, terms_of_legs
from hexathermal.machine.hexapod import Hexapod
from hexathermal.machine.shown import Shown
from hexathermal.machine.thermal import DEFAULT_RANGE_DEGC, LegLaw, PlateLaw, ThermalModel, frozen
from hexathermal.machine.thermometers import AS_RECORDED
from hexathermal.poses import FloatArray

PLATES_CHOICES = ("auto", "fit", "known", "none")


@dataclass(frozen=True, eq=False, repr=False)
class HexapodIdentification(Shown):
    """What six-leg identification found.

    Attributes
    ----------
    rows : HexapodRows
        Those used.
    sensors : tuple of str
        Of the chosen law.
    equations : HexapodEquations
    fits : dict of str to HexapodFit
        ``"common"``, ``"leg-specific"`` and ``"bench"`` where laws were given.
    chosen : str
    reason : str
    left_out_rmse : dict of str to (float, float) [m, rad]
        On runs left out: translation and rotation, root mean square distance.
    fit_rmse : dict of str to (float, float) [m, rad]
        Of the fitted rows.
    noise : array, shape (6,) [m, rad]
        Standard deviations of the six coordinates: given, or found in the residuals.
    noise_given : bool
    leg_noise : float [m]
        What is left in each leg beside the given noise.
    frame : str
    frames : array, shape (runs, 6) [m, rad]
        Of the positioning system, under the chosen law.
    notes : tuple of str
    spread : array, shape (2 k,) [1/K]
        Standard deviation of ``[A_1 .. A_k, B_1 .. B_k]`` between legs, see `hexathermal.learn.hexapod_spread`; NaN
        where the rows cannot tell the legs apart.
    """

    rows: HexapodRows
    sensors: tuple[str, ...]
    equations: HexapodEquations
    fits: dict[str, HexapodFit]
    chosen: str
    reason: str
    left_out_rmse: dict[str, tuple[float, float]]
    fit_rmse: dict[str, tuple[float, float]]
    noise: FloatArray
    noise_given: bool
    leg_noise: float
    frame: str
    frames: FloatArray
    notes: tuple[str, ...]
    spread: FloatArray

    def __repr__(self) -> str:
        return f"HexapodIdentification: {self.chosen}, {self.reason}"

    @property
    def fit(self) -> HexapodFit:
        """The chosen fit."""
        return self.fits[self.chosen]

    def laws(self, title: str = "") -> tuple[LegLaw, ...]:
        """Return the law of each leg, with its covariance and the terms that the machine states of it.

        One law for all holds the spread between legs too.
        """
        terms = terms_of_legs(self.rows.hexapod)
        fit, s = self.fit, len(self.rows.sensors)
        at = [self.rows.sensors.index(name) for name in self.sensors]
        covariance = fit.full_covariance
        laws = []
        for leg in range(6):
            which = np.array([2 * s * leg + s * symbol + place for symbol in (0, 1) for place in at])
            own = covariance[np.ix_(which, which)]
            spread = np.nan_to_num(self.spread) if self.chosen == "common" else np.zeros(len(which))
            own = own + np.diag(spread**2)
            known = own if own.any() else None
            A, B = fit.b[which[: len(at)]], fit.b[which[len(at) :]]
            laws.append(LegLaw(self.sensors, A, B, known, title, terms[leg], spread if spread.any() else None))
        return tuple(laws)

    def hexapod(self, title: str = "", legs: tuple[LegLaw, ...] | None = None) -> Hexapod:
        """Return the machine with the chosen laws; references are the temperatures of the zero.

        Expansions of plates without a thermometer stay as the machine has them; so do exchanged thermometers, terms of
        legs, payload, joints and measuring frame. `legs`: six laws from elsewhere, as they were given, with their own
        covariances, where those are chosen; one without terms gets the leg's own.
        """
        rows, old = self.rows, self.rows.hexapod.thermal
        plates = (self._plate(0), self._plate(1))
        laws = self.laws(title) if legs is None else tuple(
            replace(law, terms=law.terms or own) for law, own in zip(legs, terms_of_legs(rows.hexapod), strict=True)
        )  # fmt: skip
        told = AS_RECORDED if old is None else old.thermometers_of_leg
        # references stand in the order of the record
        zero = [float(rows.zero_degC[recorded - 1, rows.sensors.index(name)])
                for recorded in AS_RECORDED for name in laws[told.index(recorded)].sensors]  # fmt: skip
        zero += [float(value) for value, law in zip(rows.plates_zero_degC, plates, strict=True)
                 if law is not None and law.sensor is not None]  # fmt: skip
        valid = DEFAULT_RANGE_DEGC if old is None else old.valid_degC
        model = ThermalModel(laws, *plates, np.round(zero, 4), valid, told)
        return replace(rows.hexapod, thermal=model, grade="A")

    def _plate(self, k: int) -> PlateLaw | None:
        """Return the law of the platform (0) or base (1): found, known, or only stated."""
        rows, fit, part = self.rows, self.fit, PLATES[k]
        before: PlateLaw | None = None if rows.hexapod.thermal is None else getattr(rows.hexapod.thermal, part)
        sensor, value = rows.plate_sensors[k], float(fit.b[12 * len(rows.sensors) + k])
        if sensor is not None and part in fit.model.words:
            at = fit.model.words.index(part)
            return PlateLaw(value, sensor, float(np.sqrt(fit.covariance[at, at])))
        if sensor is not None and value != 0.0:
            return PlateLaw(value, sensor, None if before is None else before.expansion_std)
        return before if before is None or before.sensor is None else replace(before, sensor=None)


def identify_hexapod(
    rows: HexapodRows,
    *,
    sensors: Sequence[str] | None = None,
    frame: str = "run",
    plates: str = "auto",
    noise: FloatArray | None = None,
    legs: Mapping[str, FloatArray] | None = None,
) -> HexapodIdentification:
    """Return laws of a hexapod from poses and temperatures.

    Parameters
    ----------
    rows : HexapodRows
        Of runs for identification.
    sensors : sequence of str, optional
        Of each leg; default: all of `rows`.
    frame : str
        What the positioning system's frame is free in: ``"run"``, ``"campaign"`` or ``"none"``.
    plates : str
        Expansion of plates that have a thermometer: ``"fit"``, ``"known"`` (the machine's), ``"none"`` (0), ``"auto"``
        (the machine's where it states one for that thermometer, else fit).
    noise : array, shape (6,), optional [m, m, m, rad, rad, rad]
        Standard deviations of the measured coordinates; default: found in the residuals.
    legs : mapping of str to array, shape (6, 2, k), optional
        Laws from elsewhere by name, as ``"bench"``: A and B of the sensors on each leg [1/K].

    Raises
    ------
    ArgumentError
        An option is none of those known, the machine states no expansion of a plate, or terms of its legs read a
        thermometer that is not chosen.
    UnknownNameError
        The machine's measuring frame follows a temperature that is not recorded.
    DataError
        Too few rows, or coefficients that these rows cannot tell apart.
    """
    if plates not in PLATES_CHOICES:
        raise ArgumentError(f"plates is {plates!r}, expected one of {', '.join(map(repr, PLATES_CHOICES))}")
    chosen = _told_by(rows, sensors)
    notes: list[str] = []
    kinds = Kinds(rows.sensors, chosen, _plates(rows, plates, notes), frame)
    rows, equations, sigma, leg_noise, frames = settled(rows, kinds, noise)
    fits = {} if legs is None else {name: kinds.fit(equations, name, given) for name, given in legs.items()}
    for name in ("common", "leg-specific"):
        try:
            fits[name] = kinds.fit(equations, name)
        except DataError as error:
            if not fits:
                raise
            notes.append(f"no {name} law: {error}")
    notes += _stated_plates(equations, kinds) if plates == "auto" else []
    best, reason = _chosen(fits, equations)
    spread = _spread(fits, rows.sensors, chosen)
    scores = {name: _scores(rows, equations, one, frame, frames) for name, one in fits.items()}
    notes += [*([_said_spread(chosen, spread)] if best == "common" else []), *_doubts(rows)]
    return HexapodIdentification(
        rows, chosen, equations, fits, best, reason, {name: one[0] for name, one in scores.items()},
        {name: one[1] for name, one in scores.items()}, sigma, noise is not None, leg_noise, frame,
        frames + frames_of(rows, equations, fits[best].b, frame), tuple(notes), spread,
    )  # fmt: skip


def _told_by(rows: HexapodRows, sensors: Sequence[str] | None) -> tuple[str, ...]:
    """Return the thermometers of the laws; refused are too few rows, and a choice that lacks what terms read."""
    chosen = rows.sensors if sensors is None else tuple(sensors)
    refuse_unread_terms(rows.hexapod, chosen)
    need = 12 * len(chosen) + 8
    if len(rows) * 6 < 2 * need:
        raise DataError(f"{len(rows)} poses cannot tell {need} unknowns; at least {need // 3 + 1} are needed")
    return chosen


def _spread(fits: dict[str, HexapodFit], sensors: tuple[str, ...], chosen: tuple[str, ...]) -> FloatArray:
    """Return the spread between legs of each coefficient of a law, NaN where legs have no laws of their own."""
    if "leg-specific" not in fits:
        return np.full(2 * len(chosen), np.nan)
    fit, s, found = fits["leg-specific"], len(sensors), []
    covariance = fit.full_covariance
    for symbol in (0, 1):
        for name in chosen:
            which = 2 * s * np.arange(6) + s * symbol + sensors.index(name)
            found.append(leg_spread(fit.b[which], covariance[np.ix_(which, which)]))
    return frozen(np.array(found))


def _said_spread(chosen: tuple[str, ...], spread: FloatArray) -> str:
    """Return in words what the covariance of one law for all legs holds of their spread."""
    if np.isnan(spread).any():
        return "the spread between legs cannot be told, and the covariance of the law for all of them lacks it"
    names = [f"{letter} {name}" for letter in "AB" for name in chosen]
    each = ", ".join(f"{name} {value * 1e6:.3f}" for name, value in zip(names, spread, strict=True))
    return (
        f"legs spread about the law for all by {each} um/m/K (standard deviation, from their own laws; never 0, for "
        "equal laws may differ by what their uncertainties hide): it is in the covariance that is written"
    )


def _plates(rows: HexapodRows, plates: str, notes: list[str]) -> tuple[float | None, float | None]:
    """Return the expansions of platform and base, None where they are to be found."""
    out: list[float | None] = []
    for k, part in enumerate(("platform", "base")):
        law = None if rows.hexapod.thermal is None else getattr(rows.hexapod.thermal, part)
        if rows.plate_sensors[k] is None:
            out.append(0.0)
            notes.append(f"the {part} has no thermometer: its expansion is part of what the legs' laws absorb")
        elif plates == "auto" and law is not None and law.sensor == rows.plate_sensors[k]:
            out.append(law.expansion)
        elif plates in ("fit", "auto"):
            out.append(None)
            notes.append(
                f"the {part}'s coefficient is effective: what in the legs follows its temperature is in it too"
            )
        elif plates == "known" and law is not None:
            out.append(law.expansion)
        elif plates == "known":
            raise ArgumentError(f"the machine states no expansion of its {part}; use --plates fit, or state it")
        else:
            out.append(0.0)
    return out[0], out[1]


def _doubts(rows: HexapodRows) -> list[str]:
    """Return what is to be said of the rows."""
    notes = [
        *far_poses(rows),
        *stated_notes(rows),
        *(f"{count} rows were left out: {text}" for text, count in rows.left_out.items()),
    ]
    if len(rows.runs) == 1:
        notes.append(
            "one run only: uncertainties are those of independent rows, and nothing is judged on runs left out"
        )
    return notes


def _stated_plates(equations: HexapodEquations, kinds: Kinds) -> list[str]:
    """Return notes on plates whose stated expansion the data contradict."""
    try:
        fit = replace(kinds, plates=(None if kinds.plates[0] else 0.0, None if kinds.plates[1] else 0.0)).widest(
            equations
        )
    except DataError:
        return []
    notes = []
    for part, stated in zip(("platform", "base"), kinds.plates, strict=True):
        if stated and part in fit.model.words:
            k = fit.model.words.index(part)
            value, u = fit.theta[k] * 1e6, float(np.sqrt(fit.covariance[k, k])) * 1e6
            if abs(value - stated * 1e6) > 3.0 * u:
                notes.append(
                    f"the {part} is taken to expand by {stated * 1e6:.2f} um/m/K, as the machine states; found freely "
                    f"it is {value:.2f} +- {u:.2f}, with what in the legs follows its temperature (--plates fit)"
                )
    return notes


def _chosen(fits: dict[str, HexapodFit], equations: HexapodEquations) -> tuple[str, str]:
    """Return the kind of laws that runs left out speak for, and why."""
    names = list(fits)
    told = [k for k, run in enumerate(equations.runs) if run.freedom]
    runs = [equations.runs[k] for k in told]
    weights = np.array([run.freedom for run in runs])
    best, reasons = names[0], []
    for name in names[1:]:
        one, two = fits[best].left_out[told], fits[name].left_out[told]
        if best not in ("common", "leg-specific") and np.isnan(one).any():
            one = np.array([run.square(fits[best].b) / run.freedom for run in runs])
        if len(weights) < 2 or not (np.isfinite(one).all() and np.isfinite(two).all()):
            reasons.append(f"{name} cannot be judged on runs left out")
            continue
        found = decided(one, two, weights, 0, 0)
        ratio = float(np.sqrt((weights @ two) / (weights @ one)))
        words = (
            f"{name} leaves {100.0 * (ratio - 1.0):+.1f} % weighted RMS against {best} on {len(weights)} runs left out"
        )
        reasons.append(words + (": better beyond doubt" if found.pair else ": no better beyond its uncertainty"))
        best = name if found.pair else best
    return best, "; ".join(reasons) or "the only kind of laws"


def _scores(
    rows: HexapodRows, equations: HexapodEquations, fit: HexapodFit, frame: str, frames: FloatArray
) -> tuple[tuple[float, float], tuple[float, float]]:
    """Return translation and rotation RMS distance on runs left out, and of the fit."""
    pairs = []
    for left_out in (True, False):
        squares, count = np.zeros(2), 0
        for k, run in enumerate(equations.runs):
            b = fit.left_out_b[k] if left_out else fit.b
            if not np.isfinite(b).all():
                continue
            own = np.zeros_like(frames)
            own[:] = frames
            if frame == "run":
                own[rows.runs.index(run.run)] += run.frame(b)
            elif frame == "campaign":
                own += b[-6:]
            part = rows.rows(rows.run == rows.runs.index(run.run))
            e = pose_residuals(part, leg_and_plate(b, rows), own)
            squares += [(e[:, :3] ** 2).sum(), (e[:, 3:] ** 2).sum()]
            count += len(e)
        pairs.append(tuple(np.sqrt(squares / count)) if count else (float("nan"), float("nan")))
    return (float(pairs[0][0]), float(pairs[0][1])), (float(pairs[1][0]), float(pairs[1][1]))
