"""Ingredients of the diagnosis, each taken off in turn: what it is worth, on the same draws.

A switch replaces one function or constant of `hexathermal.learn.diagnosis` while draws are diagnosed; nothing else
changes. A name that is gone from the package is an error, so that no row of the table measures nothing.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from functools import cached_property
from typing import Any
from unittest.mock import patch

import numpy as np
from scipy.optimize import minimize_scalar


def _constant(value: Any) -> Callable[..., Any]:
    """Return a function of anything that returns a value."""
    return lambda *_arguments, **_named: value


def _without_parity() -> list[Any]:
    """What the other thermometers say of one is not asked: the drift alone speaks, with order and clocks."""
    from hexathermal.learn.diagnosis.witnesses import Witnesses

    def drift_alone(_witnesses: Any, ranked: Any) -> Any:
        return replace(ranked, value=ranked.value + ranked.best.trial.advantage)

    return [patch.object(Witnesses, "parity", _constant(0.0)), patch.object(Witnesses, "heard", drift_alone)]


def _exact_thermometers() -> list[Any]:
    """The law's thermometers without errors, and no sensor's parity."""
    from hexathermal.learn.diagnosis.evidence import Base
    from hexathermal.learn.diagnosis.stage import Stage

    def plain(stage: Stage) -> Base:
        X, sd = stage._plain
        return Base(X, sd, X.shape[1])

    law_alone = cached_property(plain)
    law_alone.__set_name__(Stage, "base")
    return [patch.object(Stage, "base", law_alone), *_without_parity()]


def _noise_of_the_null() -> list[Any]:
    """Every leader is scored at the noise that was fitted without it."""
    from hexathermal.learn.diagnosis.search import Search

    return [patch.object(Search, "_fit", lambda _search, _scored, begin: (begin, 0.0))]


def _no_tolerance() -> list[Any]:
    """The null tolerates no misfit: many rows make any trifle large."""
    from hexathermal.learn.diagnosis import evidence

    return [patch.object(evidence, "TOLERATED", 1e-6)]


def _nothing_shared() -> list[Any]:
    """A logger gives no error to all thermometers."""
    from hexathermal.learn.diagnosis import feigning, mending

    def none(view: Any) -> list[Any]:
        return [np.zeros((len(signals), 0)) for signals in view.signals]

    return [patch.object(feigning, "common_error", _constant(None)), patch.object(mending, "doubted_alike", none)]


def _no_timing() -> list[Any]:
    """Temperatures are not held against motion."""
    from hexathermal.learn.diagnosis.timing import Timing

    return [patch.object(Timing, "advantage", _constant(0.0))]


def _no_order() -> list[Any]:
    """The order of temperatures along the leg is not looked at."""
    from hexathermal.learn.diagnosis.order import Order

    return [patch.object(Order, "advantage", _constant(0.0))]


def _no_threshold() -> list[Any]:
    """A name needs better odds than nothing has, and no more."""
    from hexathermal.learn.diagnosis import course

    return [patch.object(course, "chance_threshold", _constant(0.0)), patch.object(course, "LEAST_THRESHOLD", 0.0)]


def _white_noise() -> list[Any]:
    """Windows are independent: no scatter of landings, no slow process, no offsets."""
    from hexathermal.learn.diagnosis.channels import Channel, Levels

    def fitted(channel: Channel, X: Any, sd: Any, *_begin: Any, **_named: Any) -> tuple[Levels, float]:
        """Return the level of white noise with the largest evidence, and that evidence."""

        def white(log: float) -> Levels:
            return Levels(channel.scale * math.exp(log), 0.0, 0.0, 0.0)

        found = minimize_scalar(lambda log: -channel.evidence(X, sd, white(log)), bounds=(-3.0, 5.0), method="bounded")
        return white(found.x), -float(found.fun)

    return [patch.object(Channel, "fitted", fitted)]


def _no_strangers() -> list[Any]:
    """There is nothing without a name: each misfit is a cause of the catalogue."""
    from hexathermal.learn.diagnosis import all_trials

    return [patch.object(all_trials, "flexible_trials", _constant(()))]


def _no_gain_gate() -> list[Any]:
    """No name need pay on runs left out."""
    from hexathermal.learn.diagnosis import course

    return [patch.object(course, "worth", _constant((True, True)))]


def _no_tempering() -> list[Any]:
    """Evidence between causes counts in full, as if models were no sketches."""
    from hexathermal.learn.diagnosis import deciding

    return [patch.object(deciding, "SHAPE_ERROR", 0.0)]


def _best_alone() -> list[Any]:
    """A cause says what its best trial says at its best size: parameters are not integrated over."""
    from hexathermal.learn.diagnosis import chance, evidence, forms

    def best(values: Any) -> Any:
        return values.max(axis=0)

    return [patch.object(module, "mean_log", best) for module in (chance, evidence, forms)]


def _no_pairs() -> list[Any]:
    """Causes are taken one after the other: two are not weighed together, nor is a first name asked again."""
    from hexathermal.learn.diagnosis import course

    alone = patch.object(course, "_two_for", lambda _stage, decision, _threshold: decision)
    return [alone, patch.object(course, "rival_beside", _constant(None))]


SWITCHES: dict[str, Callable[[], list[Any]]] = {
    "the whole method": list,
    "thermometers taken as exact": _exact_thermometers,
    "no parity of the sensors": _without_parity,
    "noise not fitted again for leaders": _noise_of_the_null,
    "null without tolerance": _no_tolerance,
    "no errors that all share": _nothing_shared,
    "no clocks against motion": _no_timing,
    "no order along the leg": _no_order,
    "no threshold by chance": _no_threshold,
    "windows as independent": _white_noise,
    "nothing nameless": _no_strangers,
    "no gain gate": _no_gain_gate,
    "evidence not tempered": _no_tempering,
    "the best trial alone": _best_alone,
    "no pairs": _no_pairs,
}
"""What is taken off, and how."""


@contextmanager
def without(name: str) -> Iterator[None]:
    """Take an ingredient off for a while."""
    with ExitStack() as stack:
        for one in SWITCHES[name]():
            stack.enter_context(one)
        yield
