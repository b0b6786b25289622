"""Hexapod campaigns with something hidden in them, drawn: machine, hall, causes, how strong they are; the answer."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from hexathermal.errors import ArgumentError
from hexathermal.simulate.hidden.effect import Parameters, always, target_of
from hexathermal.simulate.hidden.machines import strength as strengths
from hexathermal.simulate.hidden.machines.campaign import draw_clean
from hexathermal.simulate.hidden.machines.effect import MachineEffect
from hexathermal.simulate.hidden.machines.effects import CATALOGUE, OUTSIDE, found, named
from hexathermal.simulate.hidden.machines.strength import MachineOracle, oracle
from hexathermal.simulate.hidden.machines.truth import MachineTruth
from hexathermal.simulate.hidden.shapes import log_uniform
from hexathermal.simulate.hidden.strength import sized

STRENGTHS = (0.1, 1.0)
"""Strengths are drawn between these, uniform in their logarithm."""

KINDS = {"none": 0.2, "one": 0.5, "two": 0.12, "leg": 0.06, "outside": 0.12}
"""How often a draw hides what; ``leg``: a cause of the catalogue for a leg."""

MEASURES: Mapping[str, Callable[[MachineTruth], float]] = {"whole": strengths.whole, "visible": strengths.visible}
"""What a strength may mean, see `hexathermal.simulate.hidden.machines.strength`."""

TRIES, REACHED = 12, 0.02
"""An effect is drawn again, up to so many times, until its strength is as wanted within this part."""


@dataclass(frozen=True)
class MachineAnswer:
    """What a campaign of a hexapod hides.

    Attributes
    ----------
    machine, hall : str
    seed : int
        ``machine_campaign_of(seed, ...)`` with the same causes, strength, hall, machine and measure makes it again.
    causes : tuple of str
        Names of the catalogue for machines, of that for a leg, or ``"outside: ..."``; none of a clean campaign.
    targets : tuple of (str or None)
        Part on which each sits.
    parameters : tuple of mapping
        Of each, SI units.
    wanted : tuple of float
        Strength of each, alone, as wanted.
    whole, visible : tuple of float
        As reached: against the noise, and against it where each run may have a frame of its own.
    together : float
        Strength of all together, whole.
    feigned : float
        Strength of what errors of the thermometers feign.
    levels : tuple of six float [m, m, m, rad, rad, rad]
        Standard deviations of the measured coordinates.
    oracle : MachineOracle
    """

    machine: str
    hall: str
    seed: int
    causes: tuple[str, ...]
    targets: tuple[str | None, ...]
    parameters: tuple[Parameters, ...]
    wanted: tuple[float, ...]
    whole: tuple[float, ...]
    visible: tuple[float, ...]
    together: float
    feigned: float
    levels: tuple[float, ...]
    oracle: MachineOracle


def draw_machine_campaign(
    generator: np.random.Generator,
    *,
    causes: Sequence[str] | None = None,
    strength: float | None = None,
    hall: str | None = None,
    machine: str | None = None,
    measure: str = "whole",
) -> tuple[MachineTruth, MachineAnswer]:
    """Draw a campaign of a hexapod, and hide something in it.

    Parameters
    ----------
    generator : numpy.random.Generator
        Gives the seed, which stands in the answer.
    causes : sequence of str, optional
        Names of `hexathermal.simulate.hidden.machines.effects.found`; ``()`` hides nothing. Default: drawn, see
        `KINDS`.
    strength : float, optional
        Of each effect over the noise. Default: drawn for each, see `STRENGTHS`.
    hall : str, optional
        A name of `hexathermal.simulate.hidden.machines.halls.found`. Default: drawn.
    machine : str, optional
        A name of `hexathermal.simulate.hidden.machines.geometry.machine_names`. Default: drawn.
    measure : str
        What strength is meant: ``"whole"`` or ``"visible"``, see `hexathermal.simulate.hidden.machines.strength`.

    Raises
    ------
    UnknownNameError
        There is no such effect, hall or machine.
    ArgumentError
        The campaign cannot have an effect, the strength is not above 0, or the measure is not known.

    Examples
    --------
    >>> truth, answer = draw_machine_campaign(np.random.default_rng(1), causes=["leg-backlash"], strength=0.5)
    >>> answer.causes, round(answer.whole[0], 2), len(truth.runs)
    (('leg-backlash',), 0.5, 6)
    """
    seed = int(generator.integers(2**53))
    return machine_campaign_of(seed, causes=causes, strength=strength, hall=hall, machine=machine, measure=measure)


def machine_campaign_of(
    seed: int,
    *,
    causes: Sequence[str] | None = None,
    strength: float | None = None,
    hall: str | None = None,
    machine: str | None = None,
    measure: str = "whole",
) -> tuple[MachineTruth, MachineAnswer]:
    """Return the campaign that a seed stands for; see `draw_machine_campaign`."""
    if strength is not None and not 0.0 < strength < np.inf:
        raise ArgumentError(f"a strength is a number above 0 (1: as strong as the noise), found {strength!r}")
    if measure not in MEASURES:
        raise ArgumentError(f"measure is {measure!r}, expected {' or '.join(map(repr, MEASURES))}")
    effects = None if causes is None else [named(name) for name in causes]
    clean, name = draw_clean(np.random.default_rng([seed, 0]), hall=hall, machine=machine, recorded=_needs_all(effects))
    if effects is None:
        effects = _drawn(clean, np.random.default_rng([seed, 1]))
    for effect in effects:
        if not effect.possible(clean):
            raise ArgumentError(f"this campaign cannot have {effect.name!r}: nothing recorded tells of what drives it")
    generators = [np.random.default_rng([seed, 2, k]) for k in range(len(effects))]
    drawn = [log_uniform(*STRENGTHS, one) for one in generators]
    wanted = tuple(size if strength is None else strength for size in drawn)
    parts = [_fitting(effect, clean, size, one, MEASURES[measure])
             for effect, size, one in zip(effects, wanted, generators, strict=True)]  # fmt: skip
    hidden, alone = clean, []
    for effect, parameters in zip(effects, parts, strict=True):
        hidden = effect.hide(hidden, parameters)
        alone.append(effect.hide(clean, parameters))
    answer = MachineAnswer(
        name, clean.hall, seed, tuple(effect.name for effect in effects), tuple(target_of(part) for part in parts),
        tuple(parts), wanted, tuple(strengths.whole(one) for one in alone),
        tuple(strengths.visible(one) for one in alone), strengths.whole(hidden) if effects else 0.0,
        strengths.feigned(clean), tuple(clean.levels.tolist()), oracle(hidden),
    )  # fmt: skip
    return hidden, answer


def _needs_all(effects: Sequence[MachineEffect] | None) -> bool:
    """Return whether temperatures of plates and room must be recorded for what is to be hidden."""
    return effects is not None and any(effect.possible is not always for effect in effects)


def possible_causes(truth: MachineTruth) -> tuple[str, ...]:
    """Return the names of the effects that a campaign can have."""
    return tuple(name for name, effect in found().items() if effect.possible(truth))


def _drawn(truth: MachineTruth, generator: np.random.Generator) -> list[MachineEffect]:
    """Return effects drawn for a campaign."""
    names = possible_causes(truth)
    kind = str(generator.choice(list(KINDS), p=list(KINDS.values())))
    if kind == "none":
        return []
    foreign = [name for name in names if name.startswith(OUTSIDE)]
    own = [name for name in names if name in CATALOGUE]
    among = {"outside": foreign, "leg": [name for name in names if name not in (*foreign, *own)]}.get(kind, own)
    picked = generator.choice(among, 2 if kind == "two" else 1, replace=False)
    return [named(str(name)) for name in picked]


def _fitting(
    effect: MachineEffect, truth: MachineTruth, wanted: float, generator: np.random.Generator,
    measure: Callable[[MachineTruth], float],
) -> Parameters:  # fmt: skip
    """Return parameters of an effect with the wanted strength, or the nearest of several draws."""
    best: Parameters = {}
    least = np.inf
    for _try in range(TRIES):
        parameters = effect.draw(truth, generator)
        now, reached = sized(effect, parameters, wanted, lambda some: measure(effect.hide(truth, some)))
        if abs(np.log(max(reached, 1e-12) / wanted)) < least:
            best, least = now, abs(float(np.log(max(reached, 1e-12) / wanted)))
        if least < REACHED:
            break
    return best
