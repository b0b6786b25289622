"""Figures of what a diagnosis decided: ranking, gain, limits of detection, noise."""

from __future__ import annotations

from textwrap import fill
from typing import TYPE_CHECKING, Any

import numpy as np

from hexathermal.learn.diagnosis.result import Candidate, Diagnosis
from hexathermal.learn.machine_diagnosis.result import MachineCandidate, MachineDiagnosis
from hexathermal.show.diagnosis_pictures import LOOK, NARROW_IN
from hexathermal.show.diagnosis_words import changed, noise_rows, placed
from hexathermal.show.figures import BLACK, BLUE, GREEN, GREY, VERMILION
from hexathermal.show.shares import bounded

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


WIDEST = 1.6
"""The axis of what is gained ends at so many times the largest error: intervals of few runs are wider."""


def lying(width: float, count: int, height: float = 0.27) -> tuple[Figure, Axes]:
    """Return a figure of lying bars or dots, `count` of them; call within the style."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, 0.95 + height * count), layout="constrained")
    axes = figure.subplots()
    axes.grid(False, axis="y")
    axes.set_ylim(count - 0.4, -0.6)
    return figure, axes


def ranking_figure(found: Diagnosis | MachineDiagnosis, width: float) -> Figure:
    """Return the evidence of each candidate, and how much a name needed in this campaign.

    Bars to the left, of evidence against a candidate, are drawn only where none has any for it.
    """
    import matplotlib as mpl

    shown: tuple[Candidate | MachineCandidate, ...] = found.candidates
    with mpl.rc_context(LOOK):
        names = [_wrapped(one.cause, one.target, width) for one in shown]
        figure, axes = lying(width, len(shown), 0.36 if any("\n" in name for name in names) else 0.27)
        best, least = max(one.evidence for one in shown), min(one.evidence for one in shown)
        lowest = 0.0 if best > 0.0 else least
        for k, one in enumerate(shown):
            named = k < len(found.effects)
            axes.barh(k, max(one.evidence, lowest), height=0.62, color=VERMILION if named else GREY)
            at = _beyond(one.evidence, found.threshold)
            said = f"{one.evidence:z.1f}".replace("-", "\N{MINUS SIGN}") + ("  named" if named else "")
            axes.annotate(said, (at, k), (4, 0), va="center",
                          textcoords="offset points", fontsize=8.0, color=VERMILION if named else BLACK)  # fmt: skip
        room = 1.22 if width > NARROW_IN else 1.55
        end = lowest + room * (max(found.threshold, best) - lowest)
        side, gap = ("left", 3) if found.threshold - lowest < 0.5 * (end - lowest) else ("right", -3)
        axes.axvline(found.threshold, color=BLACK, ls=":", lw=1.2)
        axes.annotate(f"a name needs {found.threshold:.1f}", (found.threshold, 1.0), (gap, 3), ha=side, va="bottom",
                      fontsize=8.0, xycoords=("data", "axes fraction"), textcoords="offset points")  # fmt: skip
        axes.set_yticks(range(len(shown)), names)
        axes.set_xlim(1.04 * lowest, end)
        axes.set_xlabel("evidence (natural logarithm)")
    return figure


def _beyond(evidence: float, threshold: float) -> float:
    """Return where a bar's number stands: at its end, or clear of the threshold's line."""
    return threshold if evidence < threshold else evidence


def _wrapped(cause: str, target: str | None, width: float) -> str:
    """Return a cause with its target, in lines that leave room for the bars."""
    text = placed(cause, target)
    return fill(text, 42 if width > NARROW_IN else 22, break_on_hyphens=False)


def gain_figure(found: Diagnosis, width: float) -> Figure:
    """Return the RMSE of each run for validation, before and after, with the 95 % interval of the gain."""
    import matplotlib as mpl

    assert found.gain is not None  # the caller asks
    runs = [*found.gain.runs.items(), ("all", found.gain.total)]
    with mpl.rc_context(LOOK):
        (figure, axes), widest = lying(width, len(runs), 0.3), 0.0
        for k, (_name, one) in enumerate(runs):
            after, part = one.rmse_after, one.rmse_gain
            axes.plot([one.rmse_before * 1e6, after.value * 1e6], [k, k], color=GREY, lw=1.0, zorder=1)
            ends = [one.rmse_before * (1.0 - end) * 1e6 for end in (part.high, part.low)] if bounded(part) else []
            widest = max(widest, one.rmse_before * 1e6, after.value * 1e6)
            axes.plot(ends, [k] * len(ends), color=BLUE, lw=3.4, alpha=0.4, zorder=2, solid_capstyle="butt",
                      label="95 % interval of the gain" if k == 0 else None)  # fmt: skip
            axes.plot(after.value * 1e6, k, "o", color=BLUE, ms=6.0, zorder=4, label="extended law" if k == 0 else None)
            axes.plot(one.rmse_before * 1e6, k, "D", mfc="none", color=VERMILION, ms=6.0, mew=1.6, zorder=3,
                      label="law" if k == 0 else None)  # fmt: skip
        if found.reachable is not None and np.isfinite(found.reachable):
            axes.axvline(found.reachable * 1e6, color=GREEN, ls="-.", lw=1.2, label="free fit of all channels")
        axes.set_yticks(range(len(runs)), [name for name, _one in runs])
        axes.set_xlim(0.0, min(axes.get_xlim()[1], WIDEST * widest))
        axes.set_xlabel("RMSE on runs never fitted (µm)")
        figure.legend(loc="outside upper left", ncols=4 if width > NARROW_IN else 2)
    return figure


def limits_figure(found: Diagnosis, width: float) -> Figure:
    """Return from which size on each cause would be named: what must stay visible, and the whole effect."""
    import matplotlib as mpl

    shown = sorted(found.limits, key=lambda item: (item.whole, item.cause))
    with mpl.rc_context(LOOK):
        figure, axes = lying(width, len(shown), 0.24)
        axes.set_xscale("log")
        for k, one in enumerate(shown):
            axes.plot([one.visible * 1e6, one.whole * 1e6], [k, k], color=GREY, lw=1.2, zorder=1)
            axes.plot(one.visible * 1e6, k, "o", color=BLUE, ms=5.0, zorder=3, label="visible" if k == 0 else None)
            axes.plot(one.whole * 1e6, k, "D", mfc="none", color=BLACK, ms=5.0, zorder=2,
                      label="whole effect" if k == 0 else None)  # fmt: skip
        axes.axvline(found.noise.rms * 1e6, color=GREEN, ls="-.", lw=1.2,
                     label="noise within runs")  # fmt: skip
        axes.set_yticks(range(len(shown)), [one.cause for one in shown])
        plain_log(axes)
        axes.set_xlabel("smallest RMS that is named (µm)")
        figure.legend(loc="outside upper left", ncols=3)
    return figure


def plain_log(axes: Axes) -> None:
    """Write decimal numbers at a logarithmic axis, at least three of them."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    low, high = axes.get_xlim()
    steps = (1.0, 1.5, 2.0, 3.0, 5.0, 7.0) if high / low < 12.0 else (1.0, 2.0, 5.0) if high / low < 300.0 else (1.0,)
    axes.xaxis.set_major_locator(LogLocator(subs=steps))
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axes.xaxis.set_minor_formatter(NullFormatter())


def noise_figure(found: Diagnosis, width: float) -> Figure:
    """Return the parts of the noise beside what is left on runs for validation."""
    import matplotlib as mpl

    rows: list[tuple[str, float, Any, str]] = [(name, value, GREY, "") for name, value, _words in noise_rows(found)]
    whole = float(np.sqrt(sum(value**2 for _name, value, *_rest in rows)))
    rows.append(("noise, together", whole, GREEN, ""))
    if found.gain is not None:
        one = found.gain.total
        if changed(found):
            rows.append(("RMSE of the extended law", one.rmse_after.value, BLUE, ""))
        rows.append(("RMSE of the law", one.rmse_before, VERMILION, "//"))
    with mpl.rc_context(LOOK):
        figure, axes = lying(width, len(rows), 0.3)
        for k, (_name, value, colour, hatch) in enumerate(rows):
            axes.barh(k, value * 1e6, height=0.6, facecolor=colour if not hatch else "none", edgecolor=colour,
                      hatch=hatch)  # fmt: skip
            axes.annotate(f"{value * 1e6:.3f}", (value * 1e6, k), (4, 0), textcoords="offset points", va="center",
                          fontsize=8.0)  # fmt: skip
        axes.set_yticks(range(len(rows)), [name for name, *_rest in rows])
        axes.set_xlim(0.0, 1.15 * max(value for _name, value, *_rest in rows) * 1e6)
        axes.set_xlabel("standard deviation (µm)")
    return figure


def whiteness_figure(found: Diagnosis, width: float) -> Figure:
    """Return the autocorrelation of whitened residuals, and the band in which independent noise stays."""
    import matplotlib as mpl
    from matplotlib.figure import Figure

    told = found.whiteness
    assert told is not None  # the caller asks
    lags = np.arange(1, len(told.before) + 1)
    with mpl.rc_context(LOOK):
        figure = Figure(figsize=(width, 2.4), layout="constrained")
        axes = figure.subplots()
        axes.axhspan(-told.band, told.band, color=GREY, alpha=0.25, lw=0.0, label="independent noise")
        axes.plot(lags, told.before, "D", mfc="none", color=VERMILION, ms=4.5, label="law")
        if changed(found):
            axes.plot(lags, told.after, "o", color=BLUE, ms=4.5, label="extended law")
        axes.axhline(0.0, color=BLACK, lw=0.8)
        axes.set_xticks(lags[4::5])
        axes.set_xlabel("windows from one to the other")
        axes.set_ylabel("autocorrelation")
        figure.legend(loc="outside upper left", ncols=3)
    return figure
