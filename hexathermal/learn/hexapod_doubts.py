"""Coefficients of an identified hexapod that its rows hardly tell: which, how uncertain, what to measure instead."""

from __future__ import annotations

import numpy as np

from hexathermal.learn.coverage import TWO_SIDED
from hexathermal.learn.hexapod_identification import HexapodIdentification

WIDE = 0.25
"""A coefficient is not known where its standard uncertainty exceeds this part of the law's largest A, and its 95 %
interval holds 0."""

MOST_OF_STROKE = 0.8
"""Poses that use a larger part of the stroke cannot be blamed for a B that is not known."""


def weak_coefficients(found: HexapodIdentification) -> tuple[str, ...]:
    """Return warnings of coefficients that the rows hardly tell, those of several legs together, with what to do.

    Parameters
    ----------
    found : HexapodIdentification
    """
    fit = found.fit
    u = np.sqrt(np.diagonal(fit.covariance))
    largest = max((abs(value) for value, word in zip(fit.theta, fit.model.words, strict=True) if " A " in f" {word}"),
                  default=0.0)  # fmt: skip
    weak: dict[str, list[int]] = {}
    for k, word in enumerate(fit.model.words):
        if word.startswith("frame "):
            continue
        if TWO_SIDED * u[k] > abs(fit.theta[k]) and u[k] > WIDE * largest:
            weak.setdefault(word.partition(" ")[2] if word.startswith("leg") else word, []).append(k)
    warnings = []
    for name, places in weak.items():
        worst = max(places, key=lambda k: u[k])
        legs = [fit.model.words[k].partition(" ")[0].removeprefix("leg") for k in places]
        of = f" of leg {', '.join(legs)}" if fit.model.words[worst].startswith("leg") else ""
        value, half = fit.theta[worst] * 1e6, TWO_SIDED * u[worst] * 1e6
        warnings.append(
            f"{name}{of}: {'at worst ' if len(places) > 1 else ''}{value:.2f} um/m/K with a standard uncertainty of "
            f"{u[worst] * 1e6:.2f} (95 %: {value - half:.2f} to {value + half:.2f}): these rows do not tell it, and "
            f"the law holds what chance made of it; {_advice(found, name, float(u[worst]))}"
        )
    return tuple(warnings)


def _advice(found: HexapodIdentification, name: str, u: float) -> str:
    """Return what to measure instead."""
    rows = found.rows
    if name in ("platform", "base"):
        rise = float(np.nanmax(np.abs(rows.plates[:, 0 if name == "platform" else 1])))
        return (
            f"the plate's temperature moved by {rise:.1f} K only, or along with the legs'; warm it apart from them, or "
            "state its expansion in the machine (--plates known, or none)"
        )
    rise = float(np.abs(rows.dT).max())
    if name.startswith("A "):
        return f"temperatures moved by up to {rise:.1f} K, legs much alike; warm them by more, and each differently"
    low, high = float(rows.q.min()), float(rows.q.max())
    stroke = rows.hexapod.stroke
    whole = high - low if stroke is None else float((stroke[:, 1] - stroke[:, 0]).max())
    effect = TWO_SIDED * u * max(abs(low), abs(high)) * rise * 1e6
    text = (
        f"displacements from {low * 1e3:.0f} to {high * 1e3:.0f} mm at up to {rise:.1f} K: over these it makes +-"
        f"{effect:.2f} um in a leg. "
    )
    if high - low < MOST_OF_STROKE * whole:
        return text + f"Measure hot with legs long and short, over more of the {whole * 1e3:.0f} mm (--propose N)"
    fewer = "; fewer thermometers in the law (--sensors) help too" if len(found.sensors) > 1 else ""
    return (
        text + f"The stroke is all used: warm the machine by more, or take the legs' laws from a bench (--legs){fewer}"
    )
