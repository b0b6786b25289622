"""Campaigns with something hidden in them, drawn: a bench, causes, how strong they are; and the answer."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from hexathermal.errors import ArgumentError
from hexathermal.simulate.hidden import benches
from hexathermal.simulate.hidden.beams import with_usual_differences
from hexathermal.simulate.hidden.contacts import with_contacts
from hexathermal.simulate.hidden.effect import Effect, Parameters, target_of
from hexathermal.simulate.hidden.effects import OUTSIDE, found, named
from hexathermal.simulate.hidden.loggers import with_shared_errors
from hexathermal.simulate.hidden.shapes import log_uniform
from hexathermal.simulate.hidden.strength import Oracle, noise_rms, oracle, scaled, visible_strength
from hexathermal.simulate.hidden.truth import CampaignTruth

STRENGTHS = (0.25, 2.0)
"""Visible strengths are drawn between these, uniform in their logarithm."""

KINDS = {"none": 0.2, "one": 0.5, "two": 0.15, "outside": 0.15}
"""How often a draw hides what."""

TRIES, TRIES_UNSCALED, REACHED = 10, 40, 0.02
"""An effect is drawn again, up to so many times (more where nothing scales it), until its strength is as wanted within
this part."""


@dataclass(frozen=True)
class Answer:
    """What a campaign hides.

    Attributes
    ----------
    bench : str
    seed : int
        ``campaign_of(bench, seed, causes=causes)`` makes the same again; with the same `strength` where one was given.
    causes : tuple of str
        Names of the catalogue, or ``"outside: ..."``; none of a clean campaign.
    targets : tuple of (str or None)
        Sensor on which each sits.
    parameters : tuple of mapping
        Of each, SI units.
    wanted, strengths : tuple of float
        Visible strength of each, alone, over the noise: as wanted, and as reached.
    strengths_with_offsets : tuple of float
        The same where a constant of each run is fitted too.
    together : float
        Visible strength of all together.
    noise : float [m]
        RMS of what the law leaves with nothing hidden: the displacement's noise, and errors of the law's thermometers.
    base : tuple of str
        Sensors of the base law.
    oracle : Oracle
    shared : float [K]
        RMS of the errors that the logger gives all thermometers; 0 where it does not drift, or was not asked to.
    """

    bench: str
    seed: int
    causes: tuple[str, ...]
    targets: tuple[str | None, ...]
    parameters: tuple[Parameters, ...]
    wanted: tuple[float, ...]
    strengths: tuple[float, ...]
    strengths_with_offsets: tuple[float, ...]
    together: float
    noise: float
    base: tuple[str, ...]
    oracle: Oracle
    shared: float = 0.0


def possible_causes(truth: CampaignTruth) -> tuple[str, ...]:
    """Return the names of the effects that a campaign can have."""
    return tuple(name for name, effect in found().items() if effect.possible(truth))


def draw_campaign(
    bench: str,
    generator: np.random.Generator,
    *,
    causes: Sequence[str] | None = None,
    strength: float | None = None,
) -> tuple[CampaignTruth, Answer]:
    """Draw a campaign of a bench, and hide something in it.

    Parameters
    ----------
    bench : str
        A name of `hexathermal.simulate.hidden.benches.found`.
    generator : numpy.random.Generator
        Gives the seed, which stands in the answer.
    causes : sequence of str, optional
        Names of effects; ``()`` hides nothing. Default: drawn, see `KINDS`.
    strength : float, optional
        Visible strength of each effect over the noise. Default: drawn for each, see `STRENGTHS`.

    Raises
    ------
    UnknownNameError
        There is no such bench or effect.
    ArgumentError
        The bench cannot have an effect, or the strength is not above 0.

    Examples
    --------
    >>> truth, answer = draw_campaign("quiet", np.random.default_rng(1), causes=("backlash",), strength=1.0)
    >>> answer.causes, round(answer.strengths[0], 1)
    (('backlash',), 1.0)
    """
    seed = int(generator.integers(2**53))
    return campaign_of(bench, seed, causes=causes, strength=strength)


def campaign_of(
    bench: str, seed: int, *, causes: Sequence[str] | None = None, strength: float | None = None, shared: bool = False
) -> tuple[CampaignTruth, Answer]:
    """Return the campaign that a seed stands for; see `draw_campaign`.

    With `shared`, the logger of every third campaign drifts: all thermometers err alike besides; and the thermometers
    of every third one are taped on, so that they let in some of the air.
    """
    if strength is not None and not 0.0 < strength < np.inf:
        raise ArgumentError(f"a strength is a number above 0 (1: as strong as the noise), found {strength!r}")
    effects = None if causes is None else [named(name) for name in causes]
    generator = np.random.default_rng([seed, 0])
    clean, error = with_usual_differences(benches.draw(bench, generator), generator), 0.0
    if shared:
        clean, error = with_shared_errors(clean, np.random.default_rng([seed, 3]))
        clean = with_contacts(clean, np.random.default_rng([seed, 4]))
    chosen = _drawn(clean, np.random.default_rng([seed, 1])) if effects is None else effects
    return _hidden(clean, bench, seed, chosen, strength, error)


def hidden_in(
    clean: CampaignTruth, seed: int, causes: Sequence[str], strength: float | None = None
) -> tuple[CampaignTruth, Answer]:
    """Return a campaign in which nothing is hidden yet with effects hidden in it; see `draw_campaign`."""
    return _hidden(clean, clean.bench, seed, [named(name) for name in causes], strength, 0.0)


def _hidden(
    clean: CampaignTruth, bench: str, seed: int, effects: Sequence[Effect], strength: float | None, error: float
) -> tuple[CampaignTruth, Answer]:
    """Return a campaign with effects hidden in it, and the answer; `error` [K] is what its logger drifts by."""
    for effect in effects:
        if not effect.possible(clean):
            raise ArgumentError(
                f"this campaign of bench {bench!r} cannot have {effect.name!r} (no stroke, no beams, or nothing that "
                f"drives it); it can have: {', '.join(possible_causes(clean))}"
            )
    generators = [np.random.default_rng([seed, 2, k]) for k in range(len(effects))]
    drawn = [log_uniform(*STRENGTHS, one) for one in generators]
    wanted = tuple(size if strength is None else strength for size in drawn)
    parts = [_fitting(*item) for item in zip(effects, [clean] * len(effects), wanted, generators, strict=True)]
    pairs = [(effect, parameters) for effect, (parameters, _) in zip(effects, parts, strict=True)]
    hidden = _with_all(pairs, clean)
    answer = Answer(
        bench, seed, tuple(effect.name for effect in effects), tuple(target_of(item) for item, _ in parts),
        tuple(item for item, _ in parts), wanted, tuple(reached for _, reached in parts),
        tuple(visible_strength(clean, effect.hidden_by(item), offsets=True) for effect, item in pairs),
        visible_strength(clean, partial(_with_all, pairs)) if effects else 0.0, noise_rms(clean), clean.base,
        oracle(clean, hidden, pairs), error,
    )  # fmt: skip
    return hidden, answer


def _with_all(pairs: Sequence[tuple[Effect, Parameters]], truth: CampaignTruth) -> CampaignTruth:
    """Return a campaign with all effects hidden in it."""
    for effect, parameters in pairs:
        truth = effect.hide(truth, parameters)
    return truth


def _drawn(truth: CampaignTruth, generator: np.random.Generator) -> list[Effect]:
    """Return effects drawn for a campaign, at most one of them in its readings; faults of readings come last."""
    effects = found()
    names = possible_causes(truth)
    inside = [effects[name] for name in names if not name.startswith(OUTSIDE)]
    kind = str(generator.choice(list(KINDS), p=list(KINDS.values())))
    if kind == "none":
        return []
    if kind == "outside":
        outside = [effects[name] for name in names if name.startswith(OUTSIDE)]
        return [outside[int(generator.integers(len(outside)))]]
    while True:
        picked = generator.choice(len(inside), 2 if kind == "two" else 1, replace=False)
        chosen = sorted((inside[int(k)] for k in picked), key=lambda effect: effect.readings)
        if sum(effect.readings for effect in chosen) < 2:
            return chosen


def _fitting(
    effect: Effect, truth: CampaignTruth, wanted: float, generator: np.random.Generator
) -> tuple[Parameters, float]:
    """Return parameters of an effect with the wanted strength, or the nearest of several draws; and that strength."""
    best: tuple[Parameters, float] | None = None
    for _try in range(TRIES if effect.amplitude else TRIES_UNSCALED):
        now = scaled(effect, truth, effect.draw(truth, generator), wanted)
        if best is None or _apart(now[1], wanted) < _apart(best[1], wanted):
            best = now
        if abs(best[1] / wanted - 1.0) < REACHED:
            break
    assert best is not None  # there is at least one try
    return best


def _apart(strength: float, wanted: float) -> float:
    """Return how far a strength is from the wanted one, in logarithms."""
    return abs(float(np.log(max(strength, 1e-12) / wanted)))
