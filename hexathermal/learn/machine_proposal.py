"""What to measure next on a machine that was diagnosed: which names to tell apart, poses and temperatures that do.

The names are those that the diagnosis leaves open: what was named and what these data cannot tell from it; else places
that these poses and temperatures confuse whatever is in them; else what was named and its closest rival; else, or where
the rows tell those apart already, the cause that hides best, to be told from nothing. The plan is that of
`hexathermal.learn.machine_diagnosis.planning.next_experiment`, beside the rows that are measured already.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from hexathermal.errors import ArgumentError, KinematicsError
from hexathermal.learn.campaign import Campaign
from hexathermal.learn.hexapod_data import HexapodRows
from hexathermal.learn.machine_diagnosis.candidate import Candidate, called
from hexathermal.learn.machine_diagnosis.causes import all_candidates
from hexathermal.learn.machine_diagnosis.noise_levels import leg_noise
from hexathermal.learn.machine_diagnosis.observability import CLOSE
from hexathermal.learn.machine_diagnosis.planning import SLOTS, MachineExperiment, next_experiment
from hexathermal.learn.machine_diagnosis.recorded import law_rows
from hexathermal.learn.machine_diagnosis.result import MachineCandidate, MachineDiagnosis, MachineEffect
from hexathermal.learn.machine_diagnosis.separation import Noise
from hexathermal.learn.machine_diagnosis.single_leg import single_leg_candidates
from hexathermal.learn.machine_diagnosis.tables import Levels
from hexathermal.learn.machine_diagnosis.view import MachineView, machine_view

MOST_NAMES = 4
"""Places that one plan is to tell apart."""

FAR = 10.0
"""Between settings of which one is there and the other is not, as the logarithm of a ratio."""

ALIKE = " look alike: "
"""Between names and reasons in `MachineDiagnosis.alike`."""


def diagnosed_rows(campaign: Campaign, found: MachineDiagnosis, role: str) -> HexapodRows:
    """Return the rows of a role as a diagnosis read them: its machine, and the thermometers of its laws."""
    return law_rows(campaign, role, found.hexapod)


def open_names(found: MachineDiagnosis) -> tuple[str, ...]:
    """Return the names, with their places, that a next experiment should tell apart; the likeliest first.

    A single name is to be told from nothing. None at all where nothing was named and these rows see every cause.
    """
    for names in _questions(found):
        if names:
            return tuple(dict.fromkeys(names))[:MOST_NAMES]
    return ()


def _questions(found: MachineDiagnosis) -> Iterator[list[str]]:
    """Give names that are open, the most urgent question first: two causes weigh more than two places of one."""
    for one in found.effects:
        if one.equivalent_places:
            yield [called(one.cause, one.target), *one.equivalent_places]
    alike = [words.partition(ALIKE)[0].split(", ") for words in found.alike]
    yield from sorted(alike, key=lambda names: len({name.partition(" of ")[0] for name in names}) == 1)
    if found.effects:
        first = found.effects[0]
        named = {called(one.cause, one.target) for one in found.effects}
        rivals = [called(one.cause, one.target) for one in found.candidates if not one.cause.startswith("follows")]
        yield [called(first.cause, first.target), *[name for name in rivals if name not in named][:1]]
    seen = [one for one in found.limits if np.isfinite(one.strength)]
    yield [called(worst.cause, worst.target) for worst in sorted(seen, key=lambda one: -one.strength)[:1]]


def propose_experiment(
    campaign: Campaign, found: MachineDiagnosis, poses: int = SLOTS, *, laws: str = "kept", seed: int = 1
) -> MachineExperiment:
    """Return the poses and temperatures that tell best apart what a diagnosis leaves open.

    Parameters
    ----------
    campaign : Campaign
        That was diagnosed.
    found : MachineDiagnosis
        Of it.
    poses : int
        Of the run that is planned.
    laws : str
        As in the diagnosis.
    seed : int

    Raises
    ------
    ArgumentError
        Nothing is open, or no plan shows it.
    """
    asked = [names for names in _questions(found) if names]
    if not asked:
        raise ArgumentError("there is nothing to tell apart: no cause was named, and these rows see all of them")
    view = machine_view(diagnosed_rows(campaign, found, "identification"))
    first = _plan(view, asked[0], found, poses, laws, seed)
    if first.promises[0].before < CLOSE or len(asked) == 1:
        return first
    # these data tell them apart already: the next question, where that is open
    try:
        second = _plan(view, asked[1], found, poses, laws, seed)
    except (ArgumentError, KinematicsError):
        return first
    return second if second.promises[0].before < CLOSE else first


def _plan(
    view: MachineView, asked: Sequence[str], found: MachineDiagnosis, poses: int, laws: str, seed: int
) -> MachineExperiment:
    """Return the plan that tells names apart."""
    names = tuple(dict.fromkeys(asked))[:MOST_NAMES]
    noise = found.disturbances.noise
    return next_experiment(
        view, _candidates(view, names, found), Noise(noise), slots=poses, strength=_strength(found, names), laws=laws,
        levels=_levels(view, found), seed=seed,
    )  # fmt: skip


def _candidates(view: MachineView, names: tuple[str, ...], found: MachineDiagnosis) -> list[Candidate]:
    """Return the candidates of names, each with the settings nearest to those that the diagnosis found."""
    every = [*all_candidates(view), *single_leg_candidates(view)]
    known: tuple[MachineCandidate | MachineEffect, ...] = (*found.candidates[::-1], *found.effects[::-1])
    settings = {called(one.cause, one.target): one.settings for one in known}
    # a place that was not ranked takes the settings of its cause
    of_cause = {one.cause: one.settings for one in known}
    chosen = []
    for name in names:
        own = [one for one in every if one.called == name]
        wanted = settings.get(name, of_cause.get(name.partition(" of ")[0], {}))
        chosen += sorted(own, key=lambda one, wanted=wanted: _apart(one.settings, wanted))[:1]  # type: ignore[misc]
    if not chosen:
        raise ArgumentError(f"these rows show nothing of {', '.join(names)}: nothing can be planned from them")
    return chosen


def _apart(one: Mapping[str, Any], other: Mapping[str, Any]) -> float:
    """Return how far settings lie apart: numbers by the logarithm of their ratio, all others by being another.

    Examples
    --------
    >>> _apart({"play_m": 2e-3, "kick": True}, {"play_m": 1e-3, "kick": True}) < _apart({}, {"play_m": 1e-3})
    True
    """
    far = 0.0
    for name in {*one, *other}:
        a, b = one.get(name), other.get(name)
        if all(isinstance(value, int | float) and value > 0.0 for value in (a, b)):
            far += abs(math.log(float(a) / float(b)))  # type: ignore[arg-type]
        else:
            far += FAR * (a != b)
    return far


def _strength(found: MachineDiagnosis, names: tuple[str, ...]) -> float | None:
    """Return the RMS over the noise, over six coordinates, of what was named; None where it was not."""
    for one in found.effects:
        if called(one.cause, one.target) == names[0]:
            return whole_strength(one, found)
    return None


def whole_strength(one: MachineEffect, found: MachineDiagnosis) -> float:
    """Return the RMS of an effect on the platform over the noise, over the six coordinates."""
    noise = np.square(found.disturbances.noise)
    far, turned = one.translation**2 / noise[:3].mean(), one.rotation**2 / noise[3:].mean()
    return float(np.sqrt((far + turned) / 6.0))


def _levels(view: MachineView, found: MachineDiagnosis) -> Levels:
    """Return the sizes of disturbances over the noise, as the campaign had them."""
    said, noise = found.disturbances, found.disturbances.noise
    return Levels(frame=float((said.frame / noise).mean()), slow=float((said.slow / noise).mean()),
                  leg=said.leg / leg_noise(view, noise), campaign=float((said.campaign / noise).mean()))  # fmt: skip
