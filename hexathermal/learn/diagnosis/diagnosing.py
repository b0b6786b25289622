"""`diagnose`: what a law gets wrong on a campaign, the causes, the extended law, and its gain."""

from __future__ import annotations

import gc
from collections.abc import Iterable, Sequence
from dataclasses import replace
from functools import reduce

from threadpoolctl import threadpool_limits

from hexathermal.learn.campaign import Campaign
from hexathermal.learn.cleaning_record import HARMLESS, cleaning_words
from hexathermal.learn.copied_runs import without_copies
from hexathermal.learn.diagnosis.beforehand import Beforehand, among
from hexathermal.learn.diagnosis.causes import catalogue
from hexathermal.learn.diagnosis.course import Course, Progress, base_law, searched
from hexathermal.learn.diagnosis.doubtful import doubtful_readings
from hexathermal.learn.diagnosis.extension import extended_law, gained, joint_law, reachable
from hexathermal.learn.diagnosis.far_landings import far_landings
from hexathermal.learn.diagnosis.given_law import Given, of_another_form, of_another_leg
from hexathermal.learn.diagnosis.judged_steps import JudgedStep, judged_steps, told_steps
from hexathermal.learn.diagnosis.limits import at_most_named, limits_of, sure_of_nothing
from hexathermal.learn.diagnosis.lost_counts import lost_count
from hexathermal.learn.diagnosis.mending import mended, mended_view
from hexathermal.learn.diagnosis.next_experiments import next_experiments
from hexathermal.learn.diagnosis.paying import Paid, kept_out, paid
from hexathermal.learn.diagnosis.places import alias_words
from hexathermal.learn.diagnosis.put_back import put_back, told_back
from hexathermal.learn.diagnosis.recorded import judged_runs, partly_recorded, refuse_silent, refuse_slow, silence_words
from hexathermal.learn.diagnosis.replugged import Exchange, exchanges_between_runs, told_of
from hexathermal.learn.diagnosis.residuals import whiteness, with_followed
from hexathermal.learn.diagnosis.result import Candidate, Diagnosis, Effect, Limit
from hexathermal.learn.diagnosis.rivals import LATE, OFF, STEP, TILT
from hexathermal.learn.diagnosis.room_air import hung, in_the_room, room_words
from hexathermal.learn.diagnosis.search import REPEATED
from hexathermal.learn.diagnosis.stage import Stage, view_of
from hexathermal.learn.diagnosis.trials import Trial
from hexathermal.learn.diagnosis.view import View
from hexathermal.learn.diagnosis.words import effect_of
from hexathermal.learn.law import IdentifiedLaw
from hexathermal.learn.signals import RunRows, campaign_rows

MOST_CANDIDATES = 12

HIDING = 1.0 / 3.0
"""Part of the causes that may hide an effect as large as the noise before it is said that a campaign shows little."""


ROOM = '; if a thermometer hangs in the room, say so in campaign.toml: part = "room" of its [[thermocouples]]'
"""What a reader can do for causes that follow the air."""

OPPOSED = 2.0
"""Coefficients of opposite sign that are no farther from each other than this factor make a difference."""


def diagnose(
    campaign: Campaign,
    sensors: Sequence[str] | None = None,
    *,
    law: IdentifiedLaw | None = None,
    progress: Progress | None = None,
) -> Diagnosis:
    """Return what a law gets wrong on a campaign's measurements, and why.

    The runs for identification are searched; those for validation tell the gain, exchanged plugs and steps of the zero.

    Parameters
    ----------
    campaign : Campaign
        Of kind ``"leg"`` or ``"component"``.
    sensors : sequence of str, optional
        Of the law; by default the one or two that make the drift likeliest, of a part without a stroke those that
        `identify_campaign` chooses. What is wrong with a thermometer that the law does not read does not show.
    law : IdentifiedLaw, optional
        A law whose sensors are taken; its coefficients are fitted anew, since a cause biases them. What these gain over
        those that were given is told apart, `Diagnosis.given`.
    progress : function, optional
        Called as ``progress(done, total, label)``.

    Raises
    ------
    ArgumentError
        The campaign is of another kind.
    DataError
        There is too little data, or the law's sensors have no values.
    CampaignError
        A table is at fault.
    """
    with threadpool_limits(limits=1):  # matrices are small and many, and threads would wait for each other
        found = _diagnosed(campaign, sensors, law, progress)
    gc.collect()  # stages and their searches know each other: a hundred megabytes for each of a machine's legs
    return found


def _diagnosed(
    campaign: Campaign, sensors: Sequence[str] | None, law: IdentifiedLaw | None, progress: Progress | None
) -> Diagnosis:
    """Return what `diagnose` finds."""
    if progress is not None:
        progress(0, 5, "reading the runs")
    campaign, copies = without_copies(campaign)
    rows = campaign_rows(campaign, "identification")
    refuse_slow(rows)
    base = base_law(campaign, rows, sensors, law)
    refuse_silent(rows, base.sensors)
    room = in_the_room(campaign, rows, base.sensors)
    rows, judged = ([hung(one, room) for one in own] for own in (rows, campaign_rows(campaign, "validation")))
    plain = view_of(campaign, (*rows, *judged_runs(judged, (base,))[0]), base.sensors, placed=base.stroked)
    plugs = exchanges_between_runs(plain)
    repairs = tuple(one.repair for one in plugs)
    sound = [reduce(mended, repairs, one) for one in rows]
    course = searched(campaign, base, sound, progress, repairs)
    if progress is not None:
        progress(4, 5, "what it gains on runs never fitted")
    last = course.last
    extended = extended_law(base, last)
    if extended.repairs:
        fitted = [one.run.name for one in rows]
        extended = replace(extended, repairs=put_back(extended.repairs, plain, fitted))
        course = replace(course, found=tuple(told_back(one, extended.repairs) for one in course.found))
    held, mute = judged_runs(judged, (base, extended))
    read = {one.run.name: one for one in (*rows, *judged)}
    seen = replace(campaign, runs=tuple(run for run in campaign.runs if run.name not in mute))
    levels = course.steps[0].levels
    limits, confusions = limits_of(course.first, levels, course.threshold)
    jumped = judged_steps(plain, extended, held, course.threshold, _nameless(course))
    told = _told_before(course, plain, plugs, jumped)
    final = paid(campaign, seen, rows, held, base, extended, course, read, jumped)
    effects = _effects(course, final, told)
    limits = at_most_named(limits, _smallest(course, effects))
    verdict, probability, follows = _verdict(course, effects, sure_of_nothing(limits, levels.rms))
    candidates = _candidates(course, told)
    doubtful = (*copies, *doubtful_readings(campaign, [*rows, *judged], course.first.channel.y, levels))
    notes = (
        *doubtful, *room_words(room), *of_another_leg(law, campaign), *of_another_form(law, base),
        *_notes(course, final.stage),
        *_opposed(effects), *_sees_little(verdict, limits, levels.rms),
        *_chosen(base, given=sensors is not None or law is not None), *_unseen(course, rows, mute),
        *_cleaned((*rows, *judged)),
    )  # fmt: skip
    return Diagnosis(
        verdict, probability, effects, follows, candidates, base, final.law, final.gain,
        reachable(campaign, last, held, base, extended.repairs), last.channel.counted(last.levels), course.threshold,
        limits, confusions, next_experiments(course, limits, confusions, _candidates(course, ())),
        with_followed(final.residuals, course.last, course.end.leader), campaign.title, notes,
        whiteness(course.first, final.stage),
        None if law is None else Given(law, gained(law, base, seen, read)), doubtful, final.refused,
    )  # fmt: skip


def _told_before(
    course: Course, plain: View, plugs: Sequence[Exchange], jumped: Sequence[JudgedStep]
) -> list[Beforehand]:
    """Return what others than the search told: plugs that changed places, beams that lost count, steps where judged."""
    found, view, law = list[Beforehand](), plain, course.first.law
    p = plain.base_columns.shape[1] if plugs else 0
    for one in plugs:
        found.append(told_of(one, view, law[0][:p], law[1][:p, :p]))
        view = mended_view(view, one.repair)
    tilting = any(one.ranked.cause == TILT for one in course.found)
    lost = lost_count(plain, course.first.levels.rms, _jumps(course), tilting=tilting)
    return [*found, *(one for one in (lost, told_steps(jumped, plain)) if one is not None)]


def _effects(course: Course, final: Paid, told: Sequence[Beforehand]) -> tuple[Effect, ...]:
    """Return what was named, with the numbers of the law that it joined or would join; what was told before, too."""

    def of(last: Stage, places: Iterable[int]) -> dict[int, Effect]:
        mean, covariance = joint_law(last)
        return {k: effect_of(course.found[k], course.stages[k], last, covariance, mean) for k in places}

    at = of(final.stage, [k for k in range(len(course.found)) if k not in final.out])
    if final.out:
        at |= {k: kept_out(one) for k, one in of(course.last, final.out).items()}
    effects = [at[k] for k in sorted(at)]
    return tuple(among(effects, told, _largest(course), lambda one: one.effect))


def _largest(course: Course) -> float:
    """Return the most that is visible of an effect that the search named [m]."""
    return max((one.ranked.best.visible for one in course.found), default=0.0)


def _smallest(course: Course, effects: Sequence[Effect]) -> dict[str, float]:
    """Return the least that is visible of an effect of each cause that the search named [m]."""
    searched_for = {one.ranked.cause for one in course.found}
    sizes = sorted((one for one in effects if one.cause in searched_for), key=lambda one: -one.visible)
    return {one.cause: one.visible for one in sizes}


def _jumps(course: Course) -> list[tuple[str, float]]:
    """Return runs and moments [s] of the jumps of the zero that were named."""
    jumps = [one.ranked.best.trial.parameters for one in course.found if one.ranked.cause == STEP]
    return [(str(own["run"]), float(own["time_s"])) for own in jumps]


def _verdict(course: Course, effects: Sequence[Effect], nothing: float) -> tuple[str, float, str | None]:
    """Return verdict, its probability, and what something unexplained follows.

    `nothing` is how sure these data can make that nothing is there.
    """
    left = _nameless(course)
    if effects:
        return "effect", effects[0].probability, left
    if left is not None:
        return "unexplained", course.end.probability, left
    return "none", min(course.end.probability, nothing), None


def _nameless(course: Course) -> str | None:
    """Return what was left without a name."""
    leader = course.end.leader
    return leader.cause if leader is not None and not leader.named else None


def _candidates(course: Course, told: Sequence[Beforehand]) -> tuple[Candidate, ...]:
    """Return causes that were named, in their order, what has no name then, and the ranking of the first step."""
    found = []
    for one in course.found:
        best = one.ranked.best
        found.append(Candidate(one.ranked.cause, best.trial.target, float(one.ranked.value), one.decision.probability,
                               best.visible, dict(best.trial.parameters), best.spread))  # fmt: skip
    found = among(found, told, _largest(course), lambda one: one.candidate)
    first, last = course.steps[0], course.end
    decision = course.found[0].decision if course.found else last
    left = [(last.leader, last)] if found and last.leader is not None and not last.leader.named else []
    for item, said in (*left, *((item, decision) for item in first.ranking)):
        if item.cause not in {one.cause for one in found} and len(found) < MOST_CANDIDATES:
            trial = item.best.trial
            found.append(Candidate(item.cause, trial.target, float(item.value),
                                   said.probabilities.get(item.cause, 0.0), item.best.visible,
                                   dict(trial.parameters), item.best.spread))  # fmt: skip
    return tuple(found)


def _notes(course: Course, made: Stage) -> tuple[str, ...]:
    """Return what a reader must know besides."""
    notes = [
        f"{_sited(item.cause, item.best.trial.target)} stands above chance, but predicts runs left out of the fit no "
        "better: it is not named"
        for item in course.refused
    ]
    for one in course.found:
        if not one.joined:
            which = _sited(one.ranked.cause, one.ranked.best.trial.target)
            notes.append(f"{which} does not pay on runs left out of the fit: it does not join the law")
    notes += [_told(item.trial) for item in made.joined
              if item.trial.cause == REPEATED and "weights" in item.trial.parameters]  # fmt: skip
    late = course.last.late
    if late is not None and not {LATE, OFF} & {one.ranked.cause for one in course.found}:
        how = f"{'late' if late > 0.0 else 'early'} by some {abs(late):.0f} s"
        notes.append(f"the temperatures are {how} against the drift: thermometers and loggers are off by so much, and "
                     "it has no name")  # fmt: skip
    notes += far_landings(course.last)
    view = course.first.view
    pitches = [one.ranked.best.trial.parameters.get("pitch_m") for one in course.found]
    alike = alias_words(view, next((pitch for pitch in pitches if pitch is not None), None))
    notes += [] if alike is None else [alike]
    if len(view.base) == 1 and view.kind == "leg" and course.first.bench.model(view.base[0]) is None:
        notes.append("too few other thermometers: a fault of the law's own sensor cannot be told from the leg's")
    return tuple(notes)


def _opposed(effects: Sequence[Effect]) -> list[str]:
    """Return that two thermometers act as a difference of temperatures does."""
    several = [(one.target, next(iter(one.parameters.values())).value) for one in effects
               if one.cause == REPEATED and one.parameters]  # fmt: skip
    pairs = [(one, other) for k, (one, a) in enumerate(several) for other, b in several[k + 1 :]
             if a * b < 0.0 and max(abs(a), abs(b)) < OPPOSED * min(abs(a), abs(b))]  # fmt: skip
    return [
        f"{one} and {other} act nearly alike with opposite signs: together they are a difference of temperatures, as "
        "bends a part, or two thermometers that read nearly the same"
        for one, other in pairs
    ]


def _told(trial: Trial) -> str:
    """Return what a law needs that takes a thermometer for what others tell."""
    weights = trial.parameters["weights"]
    who = "it and the thermometers beside it" if trial.target in weights else "the thermometers beside it"
    return f"{trial.target} stands for its place as {who} tell: the law reads {', '.join(sorted(weights))}"


def _sees_little(verdict: str, limits: Sequence[Limit], noise: float) -> list[str]:
    """Return that a campaign in which nothing is seen can see little, where many causes may hide behind its noise."""
    hiding = sum(one.visible > noise for one in limits)
    if verdict != "none" or hiding <= HIDING * len(limits):
        return []
    return [
        f"these data show little: {hiding} of {len(limits)} causes could hide an effect larger than the noise; "
        "measure more runs, or longer ones with more moves and rests"
    ]


def _sited(cause: str, target: str | None) -> str:
    """Return a cause with what it sits on."""
    return cause if target is None else f"{cause} ({target})"


def _chosen(base: IdentifiedLaw, *, given: bool) -> list[str]:
    """Return what a law that these data chose cannot show."""
    if given:
        return []
    return [
        f"the law's sensors ({', '.join(base.sensors)}) are those that these data speak for: what is wrong with "
        "another thermometer does not show in them; name the sensors of your law where you know them"
    ]


def _unseen(course: Course, rows: Sequence[RunRows], mute: Sequence[str]) -> list[str]:
    """Return what was not looked at, and why."""
    partly = partly_recorded(rows)
    notes = [*silence_words(rows), *partly]
    if mute:
        notes.append(f"not judged, what the law reads has no values there: {', '.join(mute)}")
    tried = {trial.cause for trial in course.first.search.trials}
    lost = [name for name in catalogue() if name not in tried]
    if lost:
        who = "not every run records" if partly else "this campaign does not record"
        hint = "" if partly or not {"frame-expansion", "sensor-detached"} & set(lost) else ROOM
        notes.append(f"not looked for, since {who} what would show them: {', '.join(lost)}{hint}")
    return notes


def _cleaned(rows: Sequence[RunRows]) -> tuple[str, ...]:
    """Return what cleaning did where it did more than leave out movements and doubles."""
    records = [one.record for one in rows]
    eventful = any(step.step not in HARMLESS for record in records for step in record.steps)
    return cleaning_words(records) if eventful else ()
