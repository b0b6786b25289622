"""The pictures of a diagnosis, each with the words for people who do not see it."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from functools import partial

import numpy as np

from hexathermal.learn.diagnosis.result import Diagnosis, RunResidual
from hexathermal.poses import FloatArray
from hexathermal.show import diagnosis_figures as figures
from hexathermal.show import diagnosis_run_figures as along
from hexathermal.show.diagnosis_pictures import Picture
from hexathermal.show.diagnosis_words import changed, lags_outside, noise_rows, shares_windows, signal_words
from hexathermal.show.folded_figures import Fold, fold_figure, folded, folds_of

MOST_RUNS = 12
"""Runs that have a picture of their own."""

MOST_PANELS = 24
"""Runs in the picture of all runs."""


def pictures_of(found: Diagnosis) -> dict[str, list[Picture]]:
    """Return the pictures by section: runs, fitted, signals, folded or as they are, ranking, gain, limits, noise."""
    found = along.without_steps(found)
    held = [run for run in found.residuals if run.role == "validation"]
    fitted = [run for run in found.residuals if run.role != "validation"]
    shown = (held or fitted)[:MOST_RUNS]
    pictures = {
        "runs": [_run(found, run, name) for run, name in zip(shown, file_names(run.run for run in shown), strict=True)],
        "fitted": [_runs(found, fitted)] if held and fitted else [],
        "signals": [
            *(_fold(found, fold, k) for k, fold in enumerate(folds_of(found))),
            *(_signal(found, name) for name in along.signal_names(found)),
        ],
        "ranking": [_ranking(found)] if found.candidates else [],
        "gain": [_gain(found)] if found.gain is not None and changed(found) else [],
        "limits": [_limits(found)] if found.limits else [],
        "noise": [_noise(found), *_whiteness(found)],
    }
    return pictures


def file_names(runs: Iterable[str]) -> list[str]:
    """Return a file's name for each run: letters that every system takes, each name once.

    >>> file_names(["run-01", "day 2", "day/2"])
    ['run-01', 'run-day_2', 'run-day_2-3']
    """
    names: list[str] = []
    for k, run in enumerate(runs):
        own = plain(run)
        name = own if own.startswith("run") else f"run-{own}"
        names.append(name if name not in names else f"{name}-{k + 1}")
    return names


def plain(name: str) -> str:
    """Return a name with letters that every file system and address takes.

    Examples
    --------
    >>> plain("warm up/2")
    'warm_up_2'
    """
    return re.sub(r"[^A-Za-z0-9._-]", "_", name)


def _rms(values: np.ndarray[tuple[int, ...], np.dtype[np.float64]]) -> str:
    """Return the RMS of residuals [um] in words."""
    return f"{1e6 * float(np.sqrt(np.nanmean(values**2))):.3f} µm"


def _run(found: Diagnosis, run: RunResidual, name: str) -> Picture:
    """Return the picture of one run."""
    fitted = "never fitted" if run.role == "validation" else "fitted"
    left = _left(found, run)
    drift = run.measured * 1e6
    alt = (
        f"Run {run.run}, {fitted}: over {np.ptp(run.time) / 3600.0:.1f} hours the measured drift goes from "
        f"{np.nanmin(drift):z.2f} to {np.nanmax(drift):z.2f} µm. {left}"
    )
    caption = f"{run.run} ({fitted}), means of windows. {left}{_gaps([run])}{_begins(found, run)}"
    return Picture(name, alt, caption, partial(along.run_figure, found, run))


def _begins(found: Diagnosis, run: RunResidual) -> str:
    """Return when a run begins, where times of a campaign count from its first run."""
    hours = run.time[0] / 3600.0
    return f" It begins at {hours:.1f} h of the campaign." if found.law.zero == "campaign" and hours > 0.5 else ""


def _left(found: Diagnosis, run: RunResidual) -> str:
    """Return what is left of a run: as it was validated, row by row, where it was; else of its windows."""
    scored = None if found.gain is None else found.gain.runs.get(run.run)
    if scored is None:
        before, after, what = _rms(run.before), _rms(run.after), "RMS of the windows"
    else:
        before, after, what = f"{scored.rmse_before * 1e6:.3f} µm", f"{scored.rmse_after.value * 1e6:.3f} µm", "RMSE"
    return f"{what}: law {before}" + (f", extended law {after}." if changed(found) else ".")


def _runs(found: Diagnosis, runs: list[RunResidual]) -> Picture:
    """Return the picture of all runs for identification."""
    shown = runs[:MOST_PANELS]
    some = f"the first {len(shown)} of {len(runs)}" if len(shown) < len(runs) else f"all {len(runs)}"
    both = "before and after" if changed(found) else "of the law"
    words = f"Residual {both} in {some} runs for identification, to which the law was fitted; one scale for all."
    if steps := along.steps_of(found):
        off = ", ".join(dict.fromkeys(str(one.target) for one in steps))
        words += f" After, the step of the zero in {off} is taken off."
    sizes = "; ".join(f"{run.run} {_rms(run.before)}" + (f" to {_rms(run.after)}" if changed(found) else "")
                      for run in shown)  # fmt: skip
    caption = f"{words}{_gaps(shown)}"
    return Picture("runs-fitted", f"{words} RMS: {sizes}.", caption, partial(along.runs_figure, found, shown))


def _gaps(runs: Sequence[RunResidual]) -> str:
    """Return what gaps between curves are, where there are some."""
    return " Gaps are times without a settled row." if any(len(along.gaps(run.time)) for run in runs) else ""


def _signal(found: Diagnosis, name: str) -> Picture:
    """Return the picture of the residual against one signal."""
    label = signal_words(name, found)[0]
    signal, before, after = along.pooled(found, name)
    share = 100.0 * along.binned(signal, before)[2]
    said = f"the means hold {share:.0f} % of the residual's variance"
    if changed(found):
        said += f"; with the extended law {100.0 * along.binned(signal, after)[2]:.0f} %"
    caption = f"{label[0].upper()}{label[1:]}: {said}."
    alt = (
        f"Residual against the {label}, {len(signal)} windows of all runs, with means of parts of equal count: {said}."
    )
    return Picture(f"residual-{plain(name)}", alt, caption, partial(along.signal_figure, found, name))


def _fold(found: Diagnosis, fold: Fold, k: int) -> Picture:
    """Return the picture of the residual within a pitch or a period that was found."""
    place, before, after = folded(found, fold)
    said = f"means of its parts go through {_span(place, before)}"
    said += f", with the extended law through {_span(place, after)}" if changed(found) else ""
    turned = ", turned by its own phase" if fold.signal == "time" else ""
    caption = f"{fold.words[0].upper()}{fold.words[1:]}, each run less its mean{turned}: {said}."
    alt = f"Residual against the {caption[0].lower()}{caption[1:]}"
    name = f"residual-{'pitch' if fold.signal == 'q' else 'period'}" + (f"-{k + 1}" if k else "")
    return Picture(name, alt, caption, partial(fold_figure, found, fold))


def _span(signal: FloatArray, values: FloatArray) -> str:
    """Return how far means of parts are apart at the most [um] in words."""
    return f"{1e6 * float(np.ptp(along.binned(signal, values)[1])):.3f} µm"


def _ranking(found: Diagnosis) -> Picture:
    """Return the picture of the ranking."""
    best = "; ".join(f"{one.cause} {one.evidence:.1f}" for one in found.candidates[:4])
    alt = f"Evidence of {len(found.candidates)} candidates; a name needs {found.threshold:.1f}. First: {best}."
    caption = "Evidence of each candidate. What ends left of the dotted line is too weak for a name in this campaign."
    return Picture("ranking", alt, caption, partial(figures.ranking_figure, found))


def _gain(found: Diagnosis) -> Picture:
    """Return the picture of the gain."""
    assert found.gain is not None  # the caller asks
    runs = "; ".join(f"{name} {one.rmse_before * 1e6:.3f} to {one.rmse_after.value * 1e6:.3f} µm"
                     for name, one in found.gain.runs.items())  # fmt: skip
    caption = (
        "RMSE of each run for validation: open diamond before, dot after. The bar is the 95 % interval of what is "
        "gained: where it reaches beyond the diamond, the gain is not proven."
    )
    return Picture("gain", f"RMSE before and after: {runs}.", caption, partial(figures.gain_figure, found))


def _limits(found: Diagnosis) -> Picture:
    """Return the picture of the limits of detection."""
    low, high = (edge(one.whole for one in found.limits) * 1e6 for edge in (min, max))
    alt = f"Smallest effects that would be named, from {low:.2g} to {high:.2g} µm of whole RMS; the table has all."
    caption = (
        "How large an effect of each cause must be in this campaign to be named. Dot: what must stay visible when the "
        "law is fitted again; diamond: the whole effect, most of which a law may hide in its coefficients."
    )
    return Picture("limits", alt, caption, partial(figures.limits_figure, found))


def _noise(found: Diagnosis) -> Picture:
    """Return the picture of the noise budget."""
    alt = "Noise: " + ", ".join(f"{name} {size * 1e6:.3f}" for name, size, _words in noise_rows(found)) + " µm."
    caption = "Parts of the noise, and what is left on runs for validation. A law that leaves only noise is done."
    return Picture("noise", alt, caption, partial(figures.noise_figure, found))


def _whiteness(found: Diagnosis) -> list[Picture]:
    """Return the picture of the autocorrelation, where it is known."""
    told = found.whiteness
    if told is None:
        return []
    outside = lags_outside(found)
    both = f"{outside[0]} of {len(told.before)} lags stand out of the band of independent noise"
    both += f", with the extended law {outside[1]}" if len(outside) > 1 else ""
    caption = f"Whitened by the fitted noise, what is left of a window says little of the next one: {both}."
    if shares_windows(found):
        caption = f"Something is left that windows share: {both}."
    return [Picture("autocorrelation", f"{caption} Band: {told.band:.3f}.", caption,
                    partial(figures.whiteness_figure, found))]  # fmt: skip
