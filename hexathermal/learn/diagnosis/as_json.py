"""Parts of the JSON document of a diagnosis (``hexathermal-diagnosis/1``)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from hexathermal.learn.validation_gain import RunGain
from hexathermal.learn.validation_scores import Figure

if TYPE_CHECKING:
    from hexathermal.learn.diagnosis.channels import Levels
    from hexathermal.learn.diagnosis.result import Candidate, Effect

UM = 1e6


def gained_facts(one: RunGain) -> dict[str, Any]:
    """Return what an extension leaves of a run, or of all, with 95 % intervals of the gains."""
    found: dict[str, Any] = {
        "rmse_before_um": one.rmse_before * UM, "rmse_after_um": one.rmse_after.value * UM,
        "linf_before_um": one.linf_before * UM, "linf_after_um": one.linf_after.value * UM,
    }  # fmt: skip
    for name, gain in (("rmse_gain", one.rmse_gain), ("linf_gain", one.linf_gain)):
        found |= {name: gain.value, f"{name}_95": ends_of(gain)}
    return found


def ends_of(one: Figure) -> list[float | None]:
    """Return the ends of a 95 % interval, None where there is no end."""
    return [end if np.isfinite(end) else None for end in (one.low, one.high)]


def target_of(one: Effect | Candidate) -> str | None:
    """Return the sensor or beam that a cause sits on; runs and sources of heat stand among the settings."""
    return None if one.target in (one.settings.get("run"), one.settings.get("source")) else one.target


def ranked_facts(one: Candidate) -> dict[str, Any]:
    """Return a line of the ranking."""
    return {
        "cause": one.cause,
        "target": target_of(one),
        "evidence": one.evidence,
        "probability": one.probability,
        "visible_rms_um": one.visible * UM,
        "visible_std_um": None if np.isnan(one.spread) else one.spread * UM,
        "settings": dict(one.settings),
    }


def parameter_facts(effect: Effect | None) -> dict[str, Any]:
    """Return parameters as the format has them."""
    if effect is None:
        return {}
    return {
        name: {"value": one.value, "std": one.std if one.std == one.std else None, "unit": one.unit}
        for name, one in effect.parameters.items()
    }


def noise_facts(noise: Levels) -> dict[str, float]:
    """Return the parts of the noise [um]."""
    parts = {"white": noise.white, "landing": noise.landing, "slow": noise.slow, "offset": noise.offset}
    return {name: size * UM for name, size in {**parts, "readings": noise.least}.items()}
