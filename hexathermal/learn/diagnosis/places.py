"""Where the rod stands still: places with a common step, and what they hide of waves of the displacement.

At places ``q = o + n g``, n whole, waves of ``f`` and of ``k / g ± f`` waves per metre are alike (k whole), those of
``k / g`` are constants and those of ``(k + 1/2) / g`` change their sign from place to place, with sine and cosine alike
(sampling theorem: Shannon, Proc. IRE 37 (1949) 10).
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from hexathermal.learn.diagnosis.view import View
from hexathermal.poses import FloatArray

APART_M = 1e-4
"""Places nearer than this are one."""

SHARES = 6
"""The least way from place to place may be up to so many common steps."""

OFF, OFF_M, MOST_ON = 0.02, 5e-6, 0.98
"""How far a place may be off, over the step or in metres, and the part of the windows that must not be farther off."""

LEAST_STEP_M = 2.5e-3
"""Finer steps hide no pitch that is looked for."""

PITCHES = 6
"""Of those that look alike, as many are told."""


def common_step(view: View) -> tuple[float, float] | None:
    """Return the common step of the places where the rod stands still, and the first place [m]; None without one."""
    return view.once(("common step",), lambda: _common_step(view), ())


def _common_step(view: View) -> tuple[float, float] | None:
    """Return what `common_step` keeps."""
    q = np.sort(view.q)
    places = _usual(q)
    ways, first = np.diff(places), float(places[0])
    if not len(ways):
        return None
    for share in range(1, SHARES + 1):
        step = float(ways.min()) / share
        if step < LEAST_STEP_M:
            break
        count = np.round((places - first) / step)
        step = float(count @ (places - first) / (count @ count))  # the step by all places
        if _on(q, step, first).mean() >= MOST_ON:
            return step, first
    return None


def _on(q: FloatArray, step: float, first: float) -> npt.NDArray[np.bool_]:
    """Return which places are a whole number of steps from the first."""
    off = np.abs(q - first - step * np.round((q - first) / step))
    return np.asarray(off < max(OFF * step, OFF_M))


def _usual(q: FloatArray) -> FloatArray:
    """Return places, one of each, without the rarest of them: so many windows may be off a common step."""
    groups = np.split(q, np.flatnonzero(np.diff(q) > APART_M) + 1)
    rare = sorted(groups, key=len)
    windows = np.cumsum([len(group) for group in rare])
    kept = rare[int(np.searchsorted(windows, (1.0 - MOST_ON) * len(q), side="right")) :]
    return np.sort([group.mean() for group in kept])


def alias_words(view: View, pitch: float | None) -> str | None:
    """Return what places with a common step hide of waves of the displacement, with the pitch found, if any [m]."""
    found = common_step(view)
    if found is None:
        return None
    step, told = found[0], f"{found[0] * 1e3:.3g} mm"
    which = "all places" if _on(view.q, *found).all() else "all places but rare ones"
    words = (
        f"{which} are multiples of {told} apart: a periodic error whose pitch is {told} over a whole number (also "
        f"{step / 2 * 1e3:.3g}, {step / 4 * 1e3:.3g} mm) does not show here, and others look like one of a longer pitch"
    )
    if pitch is not None:
        k = np.arange(1, PITCHES + 1) / step
        alike = np.unique(np.concatenate([k - 1.0 / pitch, k + 1.0 / pitch]).round(3))
        alike = alike[alike > 1.01 / pitch][:PITCHES]
        others = ", ".join(f"{1e3 / wave:.3g}" for wave in alike)
        words += (
            f": {pitch * 1e3:.3g} mm may as well be {others} mm or shorter, and the law between these places is a guess"
        )
    return f"{words}; take steps that have no common length to tell the pitch"
