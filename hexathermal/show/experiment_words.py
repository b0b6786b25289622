"""What an experiment promises, in words, and what is left for one to decide."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from hexathermal.show.shares import probability

if TYPE_CHECKING:
    from hexathermal.learn.diagnosis.result import Effect, Experiment

NEVER_TOLD = {
    "abbe-tilt": "one displacement does not tell a part's tilt, whatever its runs: measure at two places side by side",
    "creep": "runs at rest do not tell what gives way since the part was clamped: clamp it anew between runs",
}
"""Why no data of a part tell another cause, and what does; see `alike_by_nature`."""


LEAST_TOLD = 0.01
"""Probability from which on that of another name is told: where it is smaller, something else speaks against it."""


def alike_words(one: Effect, kind: str) -> str:
    """Return which other causes the data do not rule out, with their probabilities where data speak of them."""
    if not one.equivalent:
        return "No other cause of the catalogue explains these data as well."
    likely = [name for name in one.equivalent if one.rivals.get(name, 0.0) >= LEAST_TOLD]
    held_back = [name for name in one.equivalent if name in one.rivals and name not in likely]
    never = [name for name in one.equivalent if name not in one.rivals]
    told = [f"{name} (probability {probability(one.rivals[name])})" for name in likely]
    said = [f"These data do not rule out {', '.join(told)}: an experiment must decide, see below."] if told else []
    if held_back:
        said.append(
            f"These data speak about as much for {', '.join(held_back)}, but errors of the thermometers might feign "
            "that, or the other thermometers do not show it: if you suspect it, an experiment must decide, see below."
        )
    for name in never:
        why = NEVER_TOLD.get(name) if kind != "leg" else None
        said.append(f"No data of this kind rule out {name}{'' if why is None else f': {why}'}.")
    return " ".join(said)


def promise_words(one: Experiment) -> str:
    """Return what an experiment promises.

    Examples
    --------
    >>> from hexathermal.learn.diagnosis.result import Experiment
    >>> promise_words(Experiment("Rest.", ("zero-drift",), 2.3, 1.2e-7))
    'log evidence 2.3, odds 10 to 1, for an effect of 0.12 um RMS'
    """
    from hexathermal.learn.diagnosis.words import two_digits

    told = f"log evidence {promised(one)}, odds {odds(one.separation)}"
    return f"{told}, for an effect of {two_digits(one.size * 1e6)} um RMS" if one.size > 0.0 else told


def promised(one: Experiment) -> str:
    """Return the log evidence that an experiment promises; beyond what decides anything it is not told how much.

    >>> from hexathermal.learn.diagnosis.result import Experiment
    >>> promised(Experiment("Rest.", (), 2.3)), promised(Experiment("Rest.", (), 150.0))
    ('2.3', '150 or more')
    """
    from hexathermal.learn.diagnosis.next_experiments import DECIDED

    return f"{one.separation:z.1f}" if one.separation < DECIDED else f"{DECIDED:g} or more"


def told_apart(one: Experiment) -> str:
    """Return what an experiment tells apart; a cause alone is told from no effect."""
    names = tuple(dict.fromkeys(one.causes))
    return ", ".join(names if len(names) > 1 else (*names, "no effect"))


def odds(evidence: float) -> str:
    """Return log evidence as odds that people can weigh.

    Examples
    --------
    >>> odds(0.2), odds(2.3), odds(114.0)
    ('1 to 1', '10 to 1', 'above 1000 to 1')
    """
    if not math.isfinite(evidence):
        return "not known"
    size = abs(evidence)
    if size > math.log(1000.0):
        return "above 1000 to 1" if evidence > 0.0 else "below 1 to 1000"
    ratio = math.exp(size)
    shown = f"{ratio:.0f}" if ratio < 20.0 else f"{float(f'{ratio:.2g}'):.0f}"
    return f"{shown} to 1" if evidence >= 0.0 else f"1 to {shown}"
