"""How strong a hidden effect is, and what knowing it would gain.

What counts is what stays visible after the base law has been fitted again, for the law takes much of some effects:

    strength = rms(r_hidden - r_clean) / rms(noise)

over the settled rows of the runs for identification; ``r`` is what least squares of the base law (columns ``q0 dT``,
``q dT`` of the base sensors) leaves of the drift, once with the effect and once without, readings and drift without
errors. The noise is what the law leaves where nothing is hidden: that of the displacement, and what errors of the
law's thermometers feign. Of a leg's noise they make little, of a part's, with 5 to 15 um/K, most.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from hexathermal.poses import FloatArray
from hexathermal.simulate.hidden.effect import Effect, HiddenEffect, Parameters, Truth
from hexathermal.simulate.hidden.truth import CampaignTruth, RunTruth

CLOSE = 0.005
"""A wanted strength counts as reached so closely [1]."""

ROUNDS = 14

SPIKE_M, SPIKE_K = 1.5e-6, 0.9
"""A reading that stands off from its neighbours by more is a spike, which any cleaning leaves out [m], [K]."""


def recorded(run: RunTruth) -> FloatArray:
    """Return what the thermometers read, shape (n, s) [degC]."""
    return run.temperatures + run.sensor_errors


def added(run: RunTruth) -> FloatArray:
    """Return what hidden effects add to the measured drift, shape (n,) [m]."""
    return np.asarray(run.effect + run.beam_effects.mean(axis=1))


def from_zero(truth: CampaignTruth, values: Sequence[FloatArray]) -> list[FloatArray]:
    """Return values of all runs, counted from their first rows or, with a campaign's zero, from the first run's."""
    return [item - (item[0] if truth.zero == "run" else values[0][0]) for item in values]


def law_columns(truth: CampaignTruth, readings: Sequence[FloatArray] | None = None) -> list[FloatArray]:
    """Return the base law's columns of each run, shape (n, p): ``q0 dT``, ``q dT``; of a component ``dT``, or both.

    Parameters
    ----------
    truth : CampaignTruth
    readings : sequence of array, shape (n, s) [degC]
        Of each run; default: as recorded.
    """
    base = [truth.sensors.index(name) for name in truth.base]
    read = [recorded(run) for run in truth.runs] if readings is None else list(readings)
    rises = from_zero(truth, [item[:, base] for item in read])
    if not truth.along:
        return rises
    return [np.hstack([truth.length * dT, run.q[:, None] * dT]) for run, dT in zip(truth.runs, rises, strict=True)]


def without_noise(truth: CampaignTruth) -> CampaignTruth:
    """Return a campaign whose runs for validation read the drift without noise: what a law is meant to foretell."""
    return truth.changed(runs=tuple(
        run.changed(noise=np.zeros_like(run.noise)) if run.role == "validation" else run for run in truth.runs
    ))  # fmt: skip


def settled_rows(clean: CampaignTruth, values: Sequence[FloatArray], role: str) -> FloatArray:
    """Return the settled rows of the runs of a role, one behind the other; those with a spike are left out.

    Parameters
    ----------
    clean : CampaignTruth
        Without the effect, whose own leaps are no spikes.
    values : sequence of array, shape (n, ...)
        Of each run.
    role : str
    """
    pairs = zip(clean.runs, values, strict=True)
    return np.concatenate([item[run.settled & ~_spiked(clean, run)] for run, item in pairs if run.role == role])


def _spiked(truth: CampaignTruth, run: RunTruth) -> npt.NDArray[np.bool_]:
    """Return the rows in which the displacement, or a base sensor, stands off from both its neighbours, shape (n,)."""
    base = [truth.sensors.index(name) for name in truth.base]
    found = np.zeros(run.time.size, dtype=bool)
    for values, smallest in ((run.noise[:, None], SPIKE_M), (run.sensor_errors[:, base], SPIKE_K)):
        off = values[1:-1] - np.clip(
            values[1:-1], np.minimum(values[:-2], values[2:]), np.maximum(values[:-2], values[2:])
        )
        found[1:-1] |= (np.abs(off) > smallest).any(axis=1)
    return found


def exact_readings(truth: CampaignTruth) -> CampaignTruth:
    """Return a campaign whose thermometers read what is there."""
    runs = (run.changed(sensor_errors=np.zeros_like(run.sensor_errors)) for run in truth.runs)
    return truth.changed(runs=tuple(runs))


def noise_rms(truth: CampaignTruth) -> float:
    """Return the RMS of what the law leaves with nothing hidden, on settled rows of identification runs [m].

    As the bench says: of the displacement's noise, and of what the law's thermometers feign; without a word of the
    bench that of the displacement's noise.
    """
    if "noise_rms_um" in truth.notes:
        feigned = float(str(truth.notes.get("thermometers_rms_um", 0.0)))
        return float(np.hypot(float(str(truth.notes["noise_rms_um"])), feigned)) * 1e-6
    noise = settled_rows(truth, [run.noise for run in truth.runs], "identification")
    return float(np.sqrt(np.mean(noise**2)))


def left(truth: CampaignTruth, clean: CampaignTruth, *, offsets: bool = False) -> FloatArray:
    """Return what the base law, fitted again, leaves of the drift without noise [m].

    The rows are those of `clean`, see `settled_rows`. With `offsets`, a constant of each run is fitted too.
    """
    columns = law_columns(truth)
    if offsets:
        which = np.eye(len(truth.runs))
        columns = [np.hstack([item, np.tile(one, (len(item), 1))]) for item, one in zip(columns, which, strict=True)]
    X = settled_rows(clean, columns, "identification")
    X = X / np.maximum(np.linalg.norm(X, axis=0), 1e-300)
    y = settled_rows(clean, from_zero(truth, [run.drift + added(run) for run in truth.runs]), "identification")
    return np.asarray(y - X @ np.linalg.lstsq(X, y)[0])


def visible_strength(
    clean: CampaignTruth,
    hide: Callable[[CampaignTruth], CampaignTruth],
    clean_left: FloatArray | None = None,
    *,
    offsets: bool = False,
) -> float:
    """Return the visible strength of what is hidden in a campaign, see above.

    Parameters
    ----------
    clean : CampaignTruth
    hide : function
        From a campaign without it to the same with it.
    clean_left : array, optional [m]
        ``left(exact_readings(clean), clean)``, where it is known already.
    offsets : bool
        Fit a constant of each run too: what the noise of the first row, from which a run counts, may hide as well.
    """
    exact = exact_readings(clean)
    before = left(exact, clean, offsets=offsets) if clean_left is None else clean_left
    seen = left(hide(exact), clean, offsets=offsets) - before
    return float(np.sqrt(np.mean(seen**2)) / noise_rms(clean))


def scaled(effect: Effect, truth: CampaignTruth, parameters: Parameters, wanted: float) -> tuple[Parameters, float]:
    """Return parameters of an effect whose visible strength is as wanted, see `sized`; and that strength."""
    before = left(exact_readings(truth), truth)
    return sized(effect, parameters, wanted, lambda now: visible_strength(truth, effect.hidden_by(now), before))


def sized(
    effect: HiddenEffect[Truth], parameters: Parameters, wanted: float, strength_of: Callable[[Parameters], float]
) -> tuple[Parameters, float]:
    """Return parameters of an effect as strong as wanted, or as near as its limits let it; and that strength.

    An effect without an amplitude stays as it is.
    """
    best: Parameters = dict(parameters)
    reached = strength_of(best)
    if not effect.amplitude:
        return best, reached
    size, sign = abs(float(parameters[effect.amplitude])), np.sign(float(parameters[effect.amplitude]))
    tried = [(np.log(size), np.log(max(reached, 1e-12)))]
    goal, bounds = np.log(wanted), np.log(np.maximum(effect.limits, 1e-300))
    for _round in range(ROUNDS):
        if abs(np.exp(tried[-1][1] - goal) - 1.0) < CLOSE:
            break
        place = float(np.clip(_next(tried, goal), *bounds))
        if any(abs(place - other) < 1e-9 for other, _ in tried):
            break
        now: Parameters = {**parameters, effect.amplitude: float(sign * np.exp(place))}
        strength = strength_of(now)
        tried.append((place, np.log(max(strength, 1e-12))))
        if abs(tried[-1][1] - goal) < abs(np.log(max(reached, 1e-12)) - goal):
            best, reached = now, strength
    return best, reached


def _next(tried: list[tuple[float, float]], goal: float) -> float:
    """Return the logarithm of the next amplitude: halfway between a weaker and a stronger one, or by the secant."""
    weaker = [place for place, strength in tried if strength < goal]
    stronger = [place for place, strength in tried if strength > goal]
    (a, f), (b, g) = tried[-1], tried[-2] if len(tried) > 1 else (tried[-1][0] + 1.0, tried[-1][1] + 1.0)
    slope = (g - f) / (b - a) if b != a else 1.0
    place = a + (goal - f) / slope if 0.2 < slope < 5.0 else a + (goal - f)
    if weaker and stronger and max(weaker) < min(stronger) and not max(weaker) < place < min(stronger):
        return 0.5 * (max(weaker) + min(stronger))
    return float(place)


@dataclass(frozen=True)
class Oracle:
    """RMSE on validation runs [m], against the measured drift of settled rows.

    Attributes
    ----------
    base : float
        The base law alone, fitted to the runs for identification.
    known : float
        The base law and the shape of each effect, sized by the same fit, with readings mended: what the best diagnosis
        could reach.
    noise : float
        The noise itself.
    base_without_noise, known_without_noise : float
        The first two where the runs for validation are without noise.
    """

    base: float
    known: float
    noise: float
    base_without_noise: float = float("nan")
    known_without_noise: float = float("nan")


def oracle(clean: CampaignTruth, hidden: CampaignTruth, effects: Sequence[tuple[Effect, Parameters]]) -> Oracle:
    """Return what knowing the effects would gain.

    Readings are mended by those of `clean`; those of a thermometer whose reading is lost by what the others foretell
    of it.
    """
    measured = from_zero(hidden, [run.drift + added(run) + run.noise for run in hidden.runs])
    shapes = []
    for effect, parameters in effects:
        alone = effect.hide(clean, parameters)
        shape = from_zero(clean, [added(b) - added(a) for a, b in zip(clean.runs, alone.runs, strict=True)])
        if any(np.abs(item).max() > 0.0 for item in shape):
            shapes.append(shape)
    read = [recorded(run) for run in clean.runs]
    for effect, parameters in effects:
        if effect.lost:
            read = _stand_in(clean, read, str(parameters["target"]))
    known = [
        np.column_stack([columns, *[shape[k] for shape in shapes]])
        for k, columns in enumerate(law_columns(clean, read))
    ]
    noise = from_zero(hidden, [run.noise for run in hidden.runs])
    exact = from_zero(hidden, [run.drift + added(run) + run.noise for run in without_noise(hidden).runs])
    base = law_columns(hidden)
    return Oracle(
        _validation_rmse(clean, base, measured), _validation_rmse(clean, known, measured),
        float(np.sqrt(np.mean(settled_rows(clean, noise, "validation") ** 2))),
        _validation_rmse(clean, base, exact), _validation_rmse(clean, known, exact),
    )  # fmt: skip


def _stand_in(truth: CampaignTruth, readings: Sequence[FloatArray], sensor: str) -> list[FloatArray]:
    """Return readings in which those of a sensor are foretold by the other sensors, by least squares."""
    j = truth.sensors.index(sensor)
    rises = from_zero(truth, readings)
    rows = settled_rows(truth, rises, "identification")
    others = np.delete(np.arange(rows.shape[1]), j)
    weights = np.linalg.lstsq(rows[:, others], rows[:, j])[0]
    found = []
    for read, rise in zip(readings, rises, strict=True):
        mended = read.copy()
        mended[:, j] += rise[:, others] @ weights - rise[:, j]
        found.append(mended)
    return found


def _validation_rmse(truth: CampaignTruth, columns: Sequence[FloatArray], measured: Sequence[FloatArray]) -> float:
    """Return the RMSE on validation runs of columns fitted to the runs for identification [m]; NaN without any."""
    if not any(run.role == "validation" for run in truth.runs):
        return float("nan")
    X, y = (settled_rows(truth, item, "identification") for item in (columns, measured))
    size = np.linalg.norm(X, axis=0)
    size[size == 0.0] = 1.0
    found = np.linalg.lstsq(X / size, y)[0] / size
    X, y = (settled_rows(truth, item, "validation") for item in (columns, measured))
    return float(np.sqrt(np.mean((y - X @ found) ** 2)))
