"""`diagnose_machine`: what a machine's model gets wrong on a campaign, the causes, the extended machine, its gain."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

import numpy as np
from threadpoolctl import threadpool_limits

from hexathermal.errors import DataError
from hexathermal.learn.campaign import Campaign
from hexathermal.learn.copied_runs import without_copies
from hexathermal.learn.hexapod_data import HexapodRows
from hexathermal.learn.hexapod_noise import without_misses
from hexathermal.learn.hexapod_offset import far_poses
from hexathermal.learn.machine_diagnosis.candidate import called, legs_of
from hexathermal.learn.machine_diagnosis.case import Case, case_of
from hexathermal.learn.machine_diagnosis.causes import catalogue
from hexathermal.learn.machine_diagnosis.course import Course, searched
from hexathermal.learn.machine_diagnosis.deciding import Equivalents, equivalents, probabilities, verdict
from hexathermal.learn.machine_diagnosis.designing import designed
from hexathermal.learn.machine_diagnosis.extension import extended
from hexathermal.learn.machine_diagnosis.gain import MachineGain, MachineResidual, gained, residuals
from hexathermal.learn.machine_diagnosis.leg_sensors import ADVICE
from hexathermal.learn.machine_diagnosis.moving import moved, moved_by
from hexathermal.learn.machine_diagnosis.noise_levels import leg_noise
from hexathermal.learn.machine_diagnosis.observability import MachineObservability, machine_observability
from hexathermal.learn.machine_diagnosis.quantities import quantities, sentence
from hexathermal.learn.machine_diagnosis.recorded import further_sensors, law_rows
from hexathermal.learn.machine_diagnosis.refitted import refitted, told_laws
from hexathermal.learn.machine_diagnosis.result import (
    Disturbances,
    MachineAdvice,
    MachineCandidate,
    MachineDiagnosis,
    MachineEffect,
    MachineLimit,
)
from hexathermal.learn.machine_diagnosis.separation import Noise
from hexathermal.learn.machine_diagnosis.settled import Settled, settled
from hexathermal.learn.machine_diagnosis.single_leg import CANNOT_SHOW, only_on_a_bench
from hexathermal.machine.hexapod import Hexapod
from hexathermal.poses import FloatArray

Progress = Callable[[int, int, str], None]
Fitted: TypeAlias = tuple[Hexapod, tuple[MachineEffect, ...], FloatArray | None]
FEWEST_ROWS = 30
"""Poses below which nothing is asked: some forty places of causes, and frames, would be fitted to them."""

MOST_CANDIDATES = 16
STEPS = 5
OF_A_LAW = "leg-coefficient"
SLOW_NOTE = 0.5
"""Slow drift, over the noise, that is told."""


def diagnose_machine(
    campaign: Campaign, *, hexapod: Hexapod | None = None, laws: str = "kept", progress: Progress | None = None
) -> MachineDiagnosis:
    """Return what a machine's model gets wrong on a campaign's measured poses, and why.

    The runs for identification are searched; those for validation only tell the gain.

    Parameters
    ----------
    campaign : Campaign
        Of kind ``"hexapod"``.
    hexapod : Hexapod, optional
        The machine; default: the campaign's own.
    laws : str
        ``"kept"``: the legs' laws are those of the machine's file, within the covariance that it states; ``"refit"``:
        they are fitted anew beside every cause, and the extended machine has the fitted ones.
    progress : function, optional
        Called as ``progress(done, total, label)``.

    Raises
    ------
    ArgumentError
        The campaign is of another kind, the machine has no thermal law, or `laws` is neither.
    UnknownNameError
        The campaign lacks a thermometer that the law reads.
    DataError
        Too few usable rows, or temperatures and poses that never change.
    """
    if progress is not None:
        progress(0, STEPS, "reading the runs")
    campaign, copies = without_copies(campaign)
    usual = law_rows(campaign, "identification", hexapod)
    further, beside = further_sensors(campaign, usual)
    rows, misses = without_misses(law_rows(campaign, "identification", usual.hexapod, further) if further else usual)
    held, mute = _held_out(campaign, rows.hexapod, further)
    notes = tuple(note for note in (misses, mute, *beside, *copies) if note)
    with threadpool_limits(limits=1):  # matrices are small and many, and threads would wait for each other
        return diagnosed(rows, held, laws=laws, title=campaign.title, notes=notes, progress=progress)


def diagnosed(
    rows: HexapodRows,
    held: HexapodRows | None = None,
    *,
    laws: str = "kept",
    title: str = "",
    notes: tuple[str, ...] = (),
    progress: Progress | None = None,
) -> MachineDiagnosis:
    """Return what a machine's model gets wrong in rows.

    Parameters
    ----------
    rows : HexapodRows
        Of runs for identification.
    held : HexapodRows, optional
        Of runs for validation: they tell the gain, and nothing else.
    laws, progress
        As `diagnose_machine`.
    title : str
    notes : tuple of str
        What is to be said besides.
    """

    def said(done: int, label: str) -> None:
        if progress is not None:
            progress(done, STEPS, label)

    _refuse_dull(rows)
    said(1, "noise and columns")
    case = case_of(rows, laws)
    said(2, "searching for causes")
    course = searched(case)
    said(3, "limits, extension and gain")
    seen = _observed(case, course)
    after, effects, strongest = _effects(course, seen, title)
    left, gain = _residuals(rows, held, after)
    laws_told = told_laws(rows.hexapod, after) if laws == "refit" else ""
    named, probability, follows = verdict(course)
    ranking = _ranking(course)
    said(4, "the next experiment")
    plans = designed(course, effects[0].equivalent_places if effects else (), strongest)
    return MachineDiagnosis(
        named, probability, effects, follows, ranking, rows.hexapod, after, gain, _disturbances(course),
        course.end.threshold, _limits(seen), tuple(str(one) for one in seen.classes), plans,
        left, title, tuple(note for note in (*notes, laws_told, *_notes(course, rows, seen, gain)) if note),
        _advice(effects, ranking, follows, seen),
    )  # fmt: skip


def _refuse_dull(rows: HexapodRows) -> None:
    """Refuse rows in which nothing can show."""
    if len(rows) < FEWEST_ROWS:
        raise DataError(
            f"{len(rows)} usable poses of runs for identification; a diagnosis needs {FEWEST_ROWS} at least, and is "
            "sharp with some hundred: measure more poses"
        )
    plates, air = np.nan_to_num(rows.plates), np.zeros(1) if rows.air is None else np.nan_to_num(rows.air)
    if not (np.ptp(rows.dT) or np.ptp(plates) or np.ptp(air)) and not np.ptp(rows.q, axis=0).any():
        raise DataError(
            "neither a temperature nor a pose ever changes: nothing can show; measure several poses, cold and warm"
        )
    runs = [rows.measured[rows.run == k].reshape(-1, 16) for k in np.unique(rows.run)]
    if not any(np.ptp(poses, axis=0).any() for poses in runs):
        raise DataError(
            "no measured pose changes within a run, not even by noise: these are no measurements; look at the table's "
            "columns measured_x_mm ... measured_rz_deg"
        )


def _held_out(campaign: Campaign, hexapod: Hexapod, further: tuple[str, ...]) -> tuple[HexapodRows | None, str]:
    """Return the rows of runs for validation, None where there are none, and what is to be said of that."""
    if not campaign.runs_of("validation"):
        return None, ""
    try:
        return without_misses(law_rows(campaign, "validation", hexapod, further))[0], ""
    except DataError as error:
        return None, f"runs for validation cannot be used: {error}"


def _observed(case: Case, course: Course) -> MachineObservability:
    """Return what the rows can tell apart, whatever is in them."""
    prior = float(np.median([-case.prior[k] for k, one in enumerate(case.candidates) if one.cause in catalogue()]))
    return machine_observability(case.view, Noise(case.noise.coordinates), laws=case.laws, levels=course.end.null,
                                 threshold=course.end.threshold + prior)  # fmt: skip


def _effects(course: Course, seen: MachineObservability, title: str) -> Fitted:
    """Return the extended machine, the causes that were named, and the amplitudes of the first."""
    hexapod = refitted(course, course.first.view.hexapod, title)
    made = list(settled(course))
    for one in made:
        hexapod = extended(hexapod, one.adoption.candidate, one.whole, one.whole_covariance, title)
    made.sort(key=lambda item: -item.adoption.ranked.odds)
    return hexapod, tuple(_effect(one, seen) for one in made), made[0].found if made else None


def _effect(named: Settled, seen: MachineObservability) -> MachineEffect:
    """Return a named cause with its parameters."""
    one = named.adoption
    case, candidate = one.case, one.candidate
    parameters = quantities(named, case.view)
    size = moved_by(case.view, candidate.columns, named.found, named.covariance)
    close = equivalents(case, one, seen) if len(one.step.ranking) else Equivalents((), ())
    settings = {name: value for name, value in candidate.settings.items() if name != "ratio"}
    return MachineEffect(
        candidate.cause, candidate.target, parameters, settings,
        probabilities(case, one.step).get(candidate.cause, 0.0), close.causes, close.places, size.translation,
        size.rotation, one.ranked.scored.strength, one.pays,
        sentence(candidate, parameters, size.translation, size.rotation),
    )  # fmt: skip


def _residuals(
    rows: HexapodRows, held: HexapodRows | None, after: Hexapod
) -> tuple[tuple[MachineResidual, ...], MachineGain | None]:
    """Return residuals of all runs, and the gain on those for validation."""
    left = residuals(rows, "identification", rows.hexapod, after)
    if held is None:
        return left, None
    judged = residuals(held, "validation", rows.hexapod, after)
    return (*left, *judged), gained(held, judged)


def _ranking(course: Course) -> tuple[MachineCandidate, ...]:
    """Return what was named, then the ranking of the first step."""
    found = list[MachineCandidate]()
    steps = [(one.case, one.step, one.ranked) for one in course.adopted]
    ranking = course.adopted[0].step if course.adopted else course.end
    home = steps[0][0] if steps else course.case
    steps += [(home, ranking, one) for one in ranking.ranking]
    listed = set()
    for case, now, one in steps:
        candidate = case.candidates[one.which]
        if candidate.called in listed or len(found) >= MOST_CANDIDATES:
            continue
        listed.add(candidate.called)
        odds = np.array([0.0, *(item.odds for item in now.ranking)])
        share = float(np.exp(one.odds - np.logaddexp.reduce(odds)))
        settings = {name: value for name, value in candidate.settings.items() if name != "ratio"}
        found.append(MachineCandidate(candidate.cause, candidate.target, one.odds, share, one.scored.strength, settings,
                                      moved(case, one)))  # fmt: skip
    return tuple(found)


def _disturbances(course: Course) -> Disturbances:
    """Return noise and disturbances in physical units."""
    noise, levels = course.case.noise, course.end.null
    sigma = noise.coordinates
    return Disturbances(sigma, noise.freedom, levels.campaign * sigma, levels.frame * sigma, levels.slow * sigma,
                        levels.leg * leg_noise(course.case.view, sigma))  # fmt: skip


def _limits(seen: MachineObservability) -> tuple[MachineLimit, ...]:
    """Return the limits of detection."""
    return tuple(MachineLimit(one.cause, one.target, one.strength, one.translation, one.rotation)
                 for one in seen.limits)  # fmt: skip


def _advice(
    effects: tuple[MachineEffect, ...], ranking: tuple[MachineCandidate, ...], follows: str | None,
    seen: MachineObservability,
) -> tuple[MachineAdvice, ...]:  # fmt: skip
    """Return the measurements that the catalogue advises.

    For what was named and its closest rivals; where nothing was, for the cause of which most could hide.
    """
    known = catalogue()
    if not effects and follows is None:
        most = max(seen.limits, key=lambda one: one.strength if np.isfinite(one.strength) else 0.0, default=None)
        if most is None or most.cause not in known:
            return ()
        return (
            MachineAdvice(
                known[most.cause].CAUSE.experiment, (most.cause,), _on_legs([called(most.cause, most.target)])
            ),
        )
    names = [one.cause for one in effects] + [name for one in effects for name in one.equivalent]
    names += [one.cause for one in ranking]
    asked = [name for name in dict.fromkeys(names) if name in known or name in ADVICE][:3]
    return tuple(MachineAdvice(ADVICE[name] if name in ADVICE else known[name].CAUSE.experiment, (name,),
                               _places(name, effects, ranking)) for name in asked)  # fmt: skip


def _places(
    cause: str, effects: tuple[MachineEffect, ...], ranking: tuple[MachineCandidate, ...]
) -> tuple[str, ...]:  # fmt: skip
    """Return where a cause sits, on legs and their joints: as named, or not ruled out, else as the ranking has it."""
    told = [called(one.cause, one.target) for one in effects]
    told += [place for one in effects for place in one.equivalent_places]
    own = [place for place in told if place.partition(" of ")[0] == cause]
    return _on_legs(own or [called(one.cause, one.target) for one in ranking if one.cause == cause])


def _on_legs(places: list[str]) -> tuple[str, ...]:
    """Return places that are on legs."""
    return tuple(dict.fromkeys(place for place in places if legs_of(place.partition(" of ")[2] or None)))


def _constant(rows: HexapodRows) -> list[str]:
    """Return what is to be said where no temperature moves."""
    heats = (rows.dT, np.nan_to_num(rows.plates), np.zeros(1) if rows.air is None else np.nan_to_num(rows.air))
    if any(np.ptp(heat) > 0.0 for heat in heats):
        return []
    return ["no temperature changes in these runs: laws of legs, growth of plates, exchanged plugs and a frame that "
            "follows the room cannot show; measure while the machine warms or cools by some kelvin"]  # fmt: skip


def _scattering(course: Course) -> list[str]:
    """Return what is to be said of runs, or stretches of them, that scatter more than others."""
    noise, view = course.case.noise, course.case.view
    most = {name: float(noise.scatter[view.run == k].max(initial=1.0)) for k, name in enumerate(view.runs)}
    said = [f"{name} ({times:.1f} times)" for name, times in most.items() if times > 1.0]
    if not said:
        return []
    return [f"poses scatter more than usual in, or in a part of, {', '.join(said)}: they weigh less; something "
            "disturbed the measurement there"]  # fmt: skip


def _several_laws(course: Course) -> list[str]:
    """Return what is to be said where nothing has a name, and the laws of several legs each look off."""
    left = course.left
    if course.adopted or left is None or course.case.named(left.which):
        return []
    odd = {course.case.candidates[one.which].target for one in course.end.ranking
           if one.odds > course.end.threshold and course.case.candidates[one.which].cause == OF_A_LAW}  # fmt: skip
    if len(odd) < 2:
        return []
    legs = ", ".join(sorted(map(str, odd)))
    return [f"the laws of several legs each look off ({legs}): where all differ, 'hexathermal identify' finds all of "
            "them in these runs, and 'diagnose --machine' of what it writes asks again"]  # fmt: skip


def _notes(course: Course, rows: HexapodRows, seen: MachineObservability, gain: MachineGain | None) -> tuple[str, ...]:
    """Return what a reader must know besides."""
    notes = [*course.notes, *far_poses(rows), *(f"{n} rows were left out: {why}" for why, n in rows.left_out.items())]
    levels = course.end.null
    if levels.frame > 0.0:
        notes.append("the measuring frame differs between runs: what moves all poses of a run alike is not told")
    elif levels.campaign > 0.0:
        notes.append("the measuring frame is offset in the whole campaign: constant motions are not told")
    if max(levels.slow, levels.leg) >= SLOW_NOTE:
        notes.append("something slow in time is in the poses that no cause explains: drift of the tracker, or heat")
    notes += _several_laws(course)
    notes += _scattering(course)
    notes += _constant(rows)
    notes += list(seen.missing)
    if seen.absent:
        notes.append(f"not looked for, since nothing recorded would show them: {', '.join(seen.absent)}")
    if seen.unseen:
        notes.append(f"these rows do not see: {', '.join(seen.unseen)}")
    if gain is None:
        notes.append("no run is for validation: what the extended machine gains on new runs is not told")
    absent = only_on_a_bench(course.first.view)
    notes += [f"{name}{CANNOT_SHOW}{words}" for name, words in absent.items()]
    return tuple(notes)
