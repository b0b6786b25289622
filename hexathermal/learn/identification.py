"""From the rows of a campaign to a law: search of all sets of sensors, choice, careful fit, checks.

`identify` reads the rows twice: for the Gram matrices of every run, and for largest residuals and windows. Runs for
validation must not be among them.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from hexathermal.errors import ArgumentError, DataError, UnknownNameError
from hexathermal.learn.campaign import LegDimensions
from hexathermal.learn.choice import Choice, choose, given
from hexathermal.learn.fitting import LEAST_RELIABILITY, LawFit, fit_law
from hexathermal.learn.gram import MOST_MISSING, Columns, Grams, Rows, columns_for, gather
from hexathermal.learn.law import IdentifiedLaw, Origin, Validity
from hexathermal.learn.materials import PhysicalCheck, physical_check, profile_warning
from hexathermal.learn.row_fingerprints import RowFingerprints
from hexathermal.learn.selection import RankedSets, fit_sets, rank_sets
from hexathermal.learn.sensor_errors import SensorErrors, sensor_errors
from hexathermal.learn.stroke_choice import LEAST_STROKE, reads_place
from hexathermal.learn.windows import WindowCollector, WindowSet
from hexathermal.machine.shown import Shown
from hexathermal.poses import FloatArray

AUTO = "auto"
Passing = Callable[[int, int, str], None]
"""``progress(done, total, label)``; a total of 0 is not known."""

Why = Callable[[str, str], str]
"""``why(run, sensor)``: how a sensor lost values in a run, as ``"stuck"``; empty where that is not known."""

COLLINEAR_CONDITION, COLLINEAR_VIF = 30.0, 30.0
"""Above, the coefficients of a pair are large, opposite and badly known, though their sum may be well known."""

LARGEST_DISAGREEMENT = 3.0
"""Standard uncertainties by which generalised and ordinary least squares may differ unmentioned."""

UNJUDGED = (
    "C dT + D q dT could not be judged on runs left out: in the others the part stood at too few places, or hardly "
    "warmed; C dT was taken"
)
"""What is said of a part with a stroke where its law could not be compared."""

METHOD = (
    "least squares of windows; covariance from noise of rows, landings, a slow process and run offsets by restricted "
    "likelihood; corrected for errors of the thermometers"
)


@dataclass(frozen=True, eq=False, repr=False)
class Identification(Shown):
    """A law and how it was found.

    Attributes
    ----------
    law : IdentifiedLaw
    fit : LawFit
    ranked : RankedSets
    choice : Choice
    grams : Grams
    check : PhysicalCheck or None
    notes : tuple of str
        What was left out, and what else a reader should know.
    warnings : tuple of str
    """

    law: IdentifiedLaw
    fit: LawFit
    ranked: RankedSets
    choice: Choice
    grams: Grams
    check: PhysicalCheck | None
    notes: tuple[str, ...]
    warnings: tuple[str, ...]

    def __repr__(self) -> str:
        return f"Identification: {' + '.join(self.choice.sensors)}, {self.choice.reason}"

    @property
    def chosen(self) -> int:
        """Number of the chosen set among the ranked, -1 where a larger set was asked for."""
        wanted = set(self.choice.sensors)
        return next((k for k, names in enumerate(self.ranked.names) if set(names) == wanted), -1)


def identify(
    rows: Rows,
    sensors: Sequence[str],
    leg: LegDimensions | None = None,
    *,
    wanted: str | Sequence[str] = AUTO,
    sizes: Sequence[int] = (1, 2),
    zero: str = "run",
    origin: Origin | None = None,
    material: str | None = None,
    positions: Sequence[float | None] = (),
    degC: tuple[float, float] | None = None,
    progress: Passing | None = None,
    why: Why = lambda run, sensor: "",
    along: bool | None = None,
) -> Identification:
    """Return the law of a leg or a component, chosen among all sets of its sensors.

    Parameters
    ----------
    rows : function
        Gives the blocks of the runs for identification anew, each time from the start.
    sensors : sequence of str
        Names of the columns of ``Block.dT``.
    leg : LegDimensions, optional
        None: a component, ``drift = sum_s C_s dT_s``, or ``sum_s C_s dT_s + D_s q dT_s`` where runs left out say so.
    wanted : ``"auto"`` or sequence of str
        Sensors of the law.
    sizes : sequence of int
        Sizes of the sets that are searched.
    zero : str
        What temperatures count from, ``"run"`` or ``"campaign"``.
    origin : Origin, optional
        Title and fingerprint; runs, their fingerprints and method are filled in.
    material : str, optional
        Of the fixed part, for the check.
    positions : sequence of float or None [m]
        Of the sensors along the leg.
    degC : (float, float), optional
        Range of temperatures met.
    progress, why : function, optional
        See `Passing`, and `Why`: asked after the rows have passed.
    along : bool, optional
        Whether the law of a component reads the displacement; by default runs left out decide.

    Raises
    ------
    DataError
        No rows, or too few; columns that depend on each other; a wanted sensor was left out for its gaps.
    UnknownNameError
        No such sensor or material.
    """
    columns, marks = columns_for(sensors, leg), RowFingerprints()
    search, choice, placed = _chosen(rows, columns, sizes, marks, wanted, along, why, progress)
    errors = sensor_errors(search.windows, search.grams.kept_mask, zero == "run")
    fit = _fitted(search.windows, [sensors.index(name) for name in choice.sensors], errors)
    law = _law(search.windows, fit, choice, leg, zero, _origin(origin or Origin(), search.windows, marks), degC)
    check, notes = physical_check(law, material), placed + _notes(search.grams, why, fit, errors)
    warnings = _warnings(fit, search, choice, leg) + (check.warnings if check else ())
    warnings += _profile(search.windows, positions)
    return Identification(law, fit, search.ranked, choice, search.grams, check, notes, warnings)


@dataclass(frozen=True, eq=False)
class _Search:
    """What two passes over the rows gather: products, windows, and the ranked sets."""

    grams: Grams
    windows: WindowSet
    ranked: RankedSets
    placed: bool


def _chosen(
    rows: Rows, columns: Columns, sizes: Sequence[int], marks: RowFingerprints, wanted: str | Sequence[str],
    along: bool | None, why: Why, progress: Passing | None,
) -> tuple[_Search, Choice, tuple[str, ...]]:  # fmt: skip
    """Return the search and the choice, with what is said of a part whose law reads the displacement."""
    say = progress or (lambda _done, _total, _label: None)
    names = None if isinstance(wanted, str) and wanted == AUTO else _names(wanted, columns)
    search = _searched(rows, columns, sizes, marks, say)
    choice = _choice(search, names, why)
    low, high = search.windows.lowest_q, search.windows.highest_q
    if along is False or columns.stroke or high - low <= LEAST_STROKE:
        return search, choice, ()
    if not search.placed:
        return search, choice, ("q_mm is missing in a run: a law that reads it, C dT + D q dT, was not tried",)
    columns = replace(columns, stroke=True, centre=0.5 * (low + high))
    without = _left_out(search.grams, choice)
    try:
        other = _searched(rows, columns, sizes, RowFingerprints(), say)
        chosen = _judged_along(other, choice, names, why)
        with_q = _left_out(other.grams, chosen)
    except DataError:
        with_q = np.full_like(without, np.nan)
    if not np.isfinite(with_q).all():
        return search, choice, (UNJUDGED,) if len(without) > 1 else ()
    if along or reads_place(without, with_q):
        return other, chosen, (_placed_words(without, with_q, search.grams),)
    return search, choice, ()


def _judged_along(search: _Search, choice: Choice, names: tuple[str, ...] | None, why: Why) -> Choice:
    """Return the choice among laws that read the displacement; where too few runs judge it, of the sensors chosen."""
    try:
        return _choice(search, names, why)
    except DataError:
        return Choice(choice.sensors, choice.reason)


def _searched(rows: Rows, columns: Columns, sizes: Sequence[int], marks: RowFingerprints, say: Passing) -> _Search:
    """Return a search among laws of some columns."""
    grams = gather(marks.passing(rows()), columns, lambda done: say(done, 0, "reading the rows"))
    total = int((grams.rows + grams.rows_left_out).sum())
    windows = WindowCollector(columns, grams.kept_mask)
    ranked = rank_sets(
        windows.passing(rows()), grams, sizes, lambda done: say(done, total, "comparing sets of sensors")
    )
    say(0, 0, "fitting the law")
    return _Search(grams, windows.made(), ranked, windows.placed)


def _left_out(grams: Grams, choice: Choice) -> FloatArray:
    """Return the mean square errors of a choice on each run left out, shape (R,) [m^2]."""
    places = np.array([[grams.columns.sensors.index(name) for name in choice.sensors]])
    return fit_sets(grams, places).left_out[:, 0]


def _placed_words(without: FloatArray, with_q: FloatArray, grams: Grams) -> str:
    """Return that the law of a part reads q, and what that is worth."""
    one, two = (float(np.sqrt(np.average(errors, weights=grams.rows))) * 1e6 for errors in (without, with_q))
    return (
        f"the law reads the displacement, C dT + D q dT: on runs left out it leaves an RMSE of {two:.3f} um, "
        f"C dT alone {one:.3f} um"
    )


def _fitted(windows: WindowSet, chosen: Sequence[int], errors: SensorErrors) -> LawFit:
    """Return the fit, on one thread: its matrices are small and many, and threads would wait for each other."""
    from threadpoolctl import threadpool_limits

    with threadpool_limits(limits=1):
        return fit_law(windows, chosen, errors)


def _lacking(grams: Grams, why: Why) -> dict[str, str]:
    """Return of each sensor left out how much of which run it lacks, and how it lost it."""
    found = {}
    for name, part in grams.left_out.items():
        run = grams.lacking_in[name]
        how = why(run, name)
        found[name] = f"{100.0 * part:.0f} % of the rows of run {run}{f' ({how})' if how else ''}"
    return found


def _choice(search: _Search, names: tuple[str, ...] | None, why: Why) -> Choice:
    """Return the choice, or what was asked for; sensors that were left out for their gaps are refused."""
    choice = choose(search.ranked, search.grams) if names is None else given(names)
    gone = [name for name in choice.sensors if name in search.grams.left_out]
    if gone:
        lacks = _lacking(search.grams, why)[gone[0]]
        raise DataError(
            f"sensor {gone[0]} lacks {lacks}, allowed {100.0 * MOST_MISSING:g} %; choose another, or "
            "leave out each run that lacks it ('hexathermal check' names them)"
        )
    return choice


def _names(wanted: str | Sequence[str], columns: Columns) -> tuple[str, ...]:
    """Return the wanted sensors after checking them."""
    names = tuple(wanted.split(",")) if isinstance(wanted, str) else tuple(wanted)
    for name in names:
        if name not in columns.sensors:
            known = ", ".join(columns.sensors)
            raise UnknownNameError(f"the campaign has no sensor {name!r}; it has {known}", columns.sensors)
    if not names or len(set(names)) < len(names):
        raise ArgumentError(f"sensors must be different names, or 'auto'; found {', '.join(names) or 'none'}")
    return names


def _law(
    windows: WindowSet,
    fit: LawFit,
    choice: Choice,
    leg: LegDimensions | None,
    zero: str,
    origin: Origin,
    degC: tuple[float, float] | None,
) -> IdentifiedLaw:
    """Return the law as it is kept."""
    chosen = list(fit.sensors)
    dT = np.column_stack([windows.lowest_dT[chosen], windows.highest_dT[chosen]])
    q = (windows.lowest_q, windows.highest_q) if windows.columns.stroke else None
    return IdentifiedLaw(
        "component" if leg is None else "leg", choice.sensors, fit.coefficients, fit.covariance,
        None if leg is None else leg.retracted_length, None if leg is None else leg.stroke, zero,
        Validity(dT, q, degC), fit.noise, fit.errors, fit.factor, origin,
    )  # fmt: skip


def _origin(origin: Origin, windows: WindowSet, marks: RowFingerprints) -> Origin:
    """Return a law's origin with the runs that were fitted, their fingerprints and the method."""
    runs, prints = tuple(run.run for run in windows.runs), marks.made()
    return replace(origin, runs=runs, method=origin.method or METHOD,
                   run_fingerprints=tuple(prints[run] for run in runs))  # fmt: skip


def _notes(grams: Grams, why: Why, fit: LawFit, errors: SensorErrors) -> tuple[str, ...]:
    """Return what was left out."""
    lacking, local = _lacking(grams, why), [grams.columns.sensors[k] for k in sorted(errors.local)]
    notes = [f"sensor {name} was left out of the search: it lacks {words}" for name, words in lacking.items()]
    lost = int(grams.rows_left_out.sum())
    if lost:
        notes.append(
            f"{lost} of {lost + int(grams.rows.sum())} rows were left out: a compared sensor has no value there"
        )
    if local:
        notes.append(
            f"{', '.join(local)}: what the other sensors do not foretell is too large for a thermometer's "
            "error and is taken for heat; no slow bias of theirs could be told"
        )
    if not fit.corrected:
        notes.append(
            f"not corrected for errors of the thermometers: reliability {fit.reliability:.2f} is below "
            f"{LEAST_RELIABILITY:g}; the doubt is in the covariance"
        )
    apart = np.abs(fit.generalised - fit.coefficients) / np.sqrt(np.diagonal(fit.covariance))
    if apart.max() > LARGEST_DISAGREEMENT:
        notes.append(
            f"fast and slow changes tell laws that differ by {apart.max():.1f} standard uncertainties: the law misses "
            "part of what happens (lag, hidden heat, another sensor); its uncertainty holds for runs like these"
        )
    return tuple(notes)


def _warnings(fit: LawFit, search: _Search, choice: Choice, leg: LegDimensions | None) -> tuple[str, ...]:
    """Return what a reader must know before trusting the law."""
    warnings, ranked = [], search.ranked
    names = [set(one) for one in ranked.names]
    if set(choice.sensors) in names:
        k = names.index(set(choice.sensors))
        if ranked.vif[k] > COLLINEAR_VIF or ranked.condition[k] > COLLINEAR_CONDITION:
            both = "C and D" if leg is None else "A and B"
            alike = " + ".join(choice.sensors) if len(choice.sensors) > 1 else f"{both} of {choice.sensors[0]}"
            warnings.append(
                f"{alike} show nearly the same (condition number {ranked.condition[k]:.0f}, "
                f"variance inflation {ranked.vif[k]:.0f}): single coefficients are badly known, predictions are not"
            )
    count = len(search.grams.runs)
    if count < 4:
        warnings.append(
            f"{count} run{'s' if count > 1 else ''} for identification: uncertainties that rest on "
            "the spread between runs are weak; record at least 6"
        )
    moved = np.abs(fit.robust - fit.least_squares) / np.sqrt(np.diagonal(fit.covariance))
    if moved.max() > 3.0:
        warnings.append(
            f"the robust fit differs from least squares by {moved.max():.1f} standard uncertainties: few landings pull "
            "the law; see 'hexathermal check'"
        )
    windows = search.windows
    if windows.columns.stroke and windows.highest_q - windows.lowest_q < 1e-3:
        warnings.append("the rod hardly moved (q changed by less than 1 mm): A and B cannot be told apart")
    return tuple(warnings)


def _profile(windows: WindowSet, positions: Sequence[float | None]) -> tuple[str, ...]:
    """Return the warning about the temperatures along the leg."""
    chosen = [k for k, x in enumerate(positions) if x is not None]
    if len(chosen) < 4:
        return ()
    profiles = np.concatenate([run.X[:, chosen] for run in windows.runs])
    said = profile_warning(np.array([positions[k] for k in chosen], dtype=np.float64), profiles)
    return (said,) if said else ()
