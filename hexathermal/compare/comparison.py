"""A campaign against the virtual bench, in one call: where they part, the physics behind it, and the gain."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from math import exp, log
from pathlib import Path

import numpy as np

from hexathermal.compare.bench_runs import BenchRuns, discretisation_error
from hexathermal.compare.differences import (
    Difference,
    ParameterFound,
    differences,
    named_values,
    parameters_found,
)
from hexathermal.compare.measured import MeasuredRun, measured_run
from hexathermal.compare.noise import Noise
from hexathermal.compare.placing import Placed, placed, without_silent
from hexathermal.compare.scores import ChannelScore, ComparedRun, channel_scores, compared_run
from hexathermal.compare.steps import MOST_NAMED, Calibration, calibrated
from hexathermal.compare.unlike import left_of, tolerated, unlike, unlike_notes, unlike_words
from hexathermal.errors import DataError
from hexathermal.learn.campaign import Campaign
from hexathermal.learn.campaign_files import load_campaign
from hexathermal.learn.check_remarks import of_fahrenheit
from hexathermal.learn.copied_runs import without_copies
from hexathermal.learn.gram import MOST_MISSING
from hexathermal.simulate.bench.leg import VirtualLeg

Progress = Callable[[int, int, str], None]

LARGEST_FACTOR = 5.0
"""A named number that is larger or smaller by more than this is said to stand for something else."""

FEWEST_RUNS = 2
"""For identification: a number is named only where a run left out of its estimate is foretold better."""

LEAST_WORSE = 0.01
"""Part by which the RMSE of a channel must have grown for it to be told."""

HEATS = ("motor-heat", "friction-heat")
"""All heat that the leg is given."""

OTHER_LEG = 4
"""From so many named numbers on, the campaign's leg is said to be another one than the bench's."""


@dataclass(frozen=True, eq=False)
class Comparison:
    """A campaign against the virtual bench.

    Attributes
    ----------
    title : str
    placed : Placed
    sensors : tuple of str
        Thermocouples that were compared.
    differences : tuple of Difference
        What was named, in the order of the steps; empty: no difference found.
    parameters : tuple of ParameterFound
        All that was looked for: estimate, smallest difference that would have been named, and what it is confused with.
    scores : tuple of ChannelScore
        On the runs of `scored_role`.
    unexplained : tuple of ChannelScore
        Those that no number of the bench explains, the most unlike first.
    worse : tuple of ChannelScore
        Those that are proven to be simulated worse with what was named, the worst first.
    scored_role : str
        ``"validation"``, or ``"identification"`` where no run for validation could be compared: then no gain is proven.
    runs : tuple of ComparedRun
    noise : Noise
    step : float [s]
    step_error_K, step_error_m : float
        What the step costs, see `hexathermal.compare.bench_runs.discretisation_error`.
    notes : tuple of str
    """

    title: str
    placed: Placed
    sensors: tuple[str, ...]
    differences: tuple[Difference, ...]
    parameters: tuple[ParameterFound, ...]
    scores: tuple[ChannelScore, ...]
    unexplained: tuple[ChannelScore, ...]
    worse: tuple[ChannelScore, ...]
    scored_role: str
    runs: tuple[ComparedRun, ...]
    noise: Noise
    step: float
    step_error_K: float
    step_error_m: float
    notes: tuple[str, ...]

    @property
    def verdict(self) -> str:
        """``"difference"``, ``"unexplained"`` (channels are unlike, and no number explains them) or ``"none"``."""
        return "difference" if self.differences else "unexplained" if self.unexplained else "none"

    @property
    def sentence(self) -> str:
        """What was found, in one sentence or two."""
        left = unlike_words(self.unexplained, self.scored_role) if self.unexplained else ""
        if not self.differences:
            if left:
                return f"Something differs that can be put down to no number of the bench: {left}."
            return "No difference from the virtual bench was found; the table says how large it would have to be."
        told = "; ".join(one.sentence for one in self.differences)
        if len(self.differences) < OTHER_LEG:
            said = f"The bench differs in {told}."
        else:
            said = (
                f"This is another leg than the virtual bench's: {len(self.differences)} of its numbers differ, which "
                f"stand for what the bench lacks as a whole and not for one cause each: {told}."
            )
        worse = ", ".join(one.channel for one in self.worse)
        doubt = f" Yet {worse} {'is' if len(self.worse) == 1 else 'are'} simulated worse with it." if worse else ""
        return f"{said}{doubt}" + (f" Put down to no number of the bench: {left}." if left else "")


def compare_campaign(
    campaign: Campaign | str | Path, *, leg: VirtualLeg | None = None, progress: Progress | None = None
) -> Comparison:
    """Drive the virtual bench by a campaign's motion and room, and say where simulated and measured part.

    Runs for identification say which numbers of the bench differ and by how much (maximum of the evidence, Laplace);
    the gain is measured on runs for validation.

    Parameters
    ----------
    campaign : Campaign, str or Path
        Of kind ``"leg"``, its thermocouples with part and position, the room's temperature recorded.
    leg : VirtualLeg, optional
        Default: the bench's own, its lengths fitted to the campaign's.
    progress : callable, optional
        Called as ``progress(done, total, label)``.

    Raises
    ------
    ArgumentError
        The campaign is of another kind.
    DataError
        It has no positions or room, fewer than `FEWEST_RUNS` runs for identification that can be compared, or nothing
        changes in them.
    CampaignError
        A file is at fault.
    """
    tell = progress or (lambda done, total, label: None)
    if not isinstance(campaign, Campaign):
        campaign = load_campaign(campaign, progress=progress)
    campaign, copies = without_copies(campaign)
    where = placed(campaign, leg)
    runs, skipped = _measured(campaign, where, tell)
    where, runs = without_silent(where, runs, campaign.sensors)
    fitted = [run for run in runs if run.role == "identification"]
    if len(fitted) < FEWEST_RUNS:
        raise _too_few(campaign, len(fitted), skipped)
    _refuse_unchanged(campaign, fitted)
    bench = BenchRuns(where, fitted)
    try:
        calibration = calibrated(bench, progress)
    except np.linalg.LinAlgError:
        raise _unchanged(campaign, "the channels of the runs for identification leave nothing to weigh by") from None
    tell(0, 0, "measuring the gain")
    return _compared(campaign, where, bench, runs, calibration, [*where.notes, *copies, *skipped.values()])


def _compared(
    campaign: Campaign, where: Placed, bench: BenchRuns, runs: Sequence[MeasuredRun], calibration: Calibration,
    notes: list[str],
) -> Comparison:  # fmt: skip
    """Return what a calibrated bench gains on runs, and what it leaves."""
    logs, contact_errors = named_values(calibration)
    every = tuple(compared_run(bench, run, logs, contact_errors) for run in runs)
    role = "validation" if any(run.role == "validation" for run in runs) else "identification"
    names = tuple(campaign.sensors[k] for k in where.sensors)
    found = differences(calibration, names)
    scored = [k for k, run in enumerate(runs) if run.role == role]
    judged = [every[k] for k in scored]
    measured = [runs[k] for k in scored]
    shares, noise = tolerated(calibration.last), calibration.last.noise
    left = left_of(shares, noise, judged, measured)
    score = channel_scores(judged, measured, names, where.places, left.foretold)
    worse, rest = _worse(score), unlike(score, names, left_of(shares, noise, every, runs), left)
    coldest = min(float(run.air.min()) for run in runs)
    notes = [
        *notes, *_doubts(role, found, logs), *_gaps(runs, names),
        *of_fahrenheit(names, [run.lowest_degC for run in runs], coldest),
        *_worse_words(worse, role), *unlike_notes(rest, judged),
    ]  # fmt: skip
    error_K, error_m = discretisation_error(bench, bench.runs[0])
    return Comparison(
        campaign.title or campaign.folder.name, where, names, found, parameters_found(calibration, names), score,
        rest, worse, role, every, noise,
        float(np.max([run.step for run in runs])), error_K, error_m, tuple(notes),
    )  # fmt: skip


def _measured(campaign: Campaign, where: Placed, tell: Progress) -> tuple[list[MeasuredRun], dict[str, str]]:
    """Return the runs that can be compared, and of the others, by name, why they cannot."""
    runs, skipped = list[MeasuredRun](), dict[str, str]()
    for k, run in enumerate(campaign.runs):
        tell(k, len(campaign.runs), f"reading {run.name}")
        found = measured_run(campaign, run, where.sensors)
        if isinstance(found, str):
            skipped[run.name] = found
        else:
            runs.append(found)
    return runs, skipped


def _too_few(campaign: Campaign, count: int, skipped: Mapping[str, str]) -> DataError:
    """Return the error of a campaign with too few runs that the bench can be fitted to, its reasons one a line."""
    reasons = [skipped[run.name] for run in campaign.runs_of("identification") if run.name in skipped]
    if not reasons and not count:
        return DataError(f"{campaign.folder} has no run for identification; give a run role = 'identification'")
    first = f"{campaign.folder}: no run for identification can be compared"
    if count:
        first = (
            f"{campaign.folder}: too little data for a comparison: {count} run for identification can be compared; it "
            f"needs {FEWEST_RUNS}, for a number is named only where a run left out is foretold better: measure "
            "more runs"
        )
    return DataError("\n  ".join([first, *reasons]))


def _refuse_unchanged(campaign: Campaign, runs: list[MeasuredRun]) -> None:
    """Refuse runs in which no thermocouple ever changes."""
    columns = [column[np.isfinite(column)] for run in runs for column in run.rises.T]
    if not any(np.ptp(column) > 0.0 for column in columns if len(column)):
        raise _unchanged(campaign, "no thermocouple changes in any run for identification")


def _unchanged(campaign: Campaign, what: str) -> DataError:
    """Return the error of a campaign in which too little happens."""
    return DataError(f"{campaign.folder}: {what}: do the temperatures, the drift or q change at all?")


def _gaps(runs: Sequence[MeasuredRun], names: Sequence[str]) -> list[str]:
    """Return which thermocouples lack values in more than `MOST_MISSING` of a run's settled rows, in words."""
    lacking = {name: [run.name for run in runs if np.isnan(run.rises[:, k]).mean() > MOST_MISSING]
               for k, name in enumerate(names)}  # fmt: skip
    return [
        f"{name} lacks more than {100.0 * MOST_MISSING:g} % of the settled rows of {', '.join(where)}: it is compared "
        "where it has values"
        for name, where in lacking.items()
        if where
    ]


def _worse(scores: Sequence[ChannelScore]) -> tuple[ChannelScore, ...]:
    """Return the channels that are proven to be simulated worse than before, and than foretold, the worst first."""
    worse = [
        one
        for one in scores
        if one.reduction.high < 0.0 and one.reduction.value < -LEAST_WORSE and one.rmse_after > one.foretold
    ]
    return tuple(sorted(worse, key=lambda one: one.reduction.value))


def _worse_words(worse: Sequence[ChannelScore], role: str) -> list[str]:
    """Return the channels that are simulated worse than before, in words."""
    if not worse:
        return []
    most = worse[0]
    names = ", ".join(one.channel for one in worse)
    grown = [-100.0 * value for value in (most.reduction.value, most.reduction.high, most.reduction.low)]
    return [
        f"with what was named {names} {'is' if len(worse) == 1 else 'are'} simulated worse on the runs for {role} than "
        f"by the bench as it is ({most.channel}: RMSE up by {grown[0]:.0f} %, 95 % interval {grown[1]:.0f} to "
        f"{grown[2]:.0f} %): what was named stands for something there that the bench lacks"
    ]


def _doubts(role: str, named: Sequence[Difference], logs: Mapping[str, float]) -> list[str]:
    """Return what a reader should know of the scores and of what was named."""
    notes = []
    if role == "identification":
        notes.append("no run for validation could be compared: the scores are those of the runs that were fitted")
    if len(named) >= MOST_NAMED:
        notes.append(
            f"{len(named)} numbers differ, and no more are sought: others may differ as well, their estimates stand in "
            "the table"
        )
    heat = [one for one in named if one.name in HEATS]
    if len(heat) == len(HEATS) and max(one.low for one in heat) < min(one.high for one in heat):
        notes.append(
            f"{' and '.join(HEATS)} differ by one factor, within their intervals: rises tell heat only over "
            "conductances and capacities, and all of these smaller by it would look the same; measure the motor's power"
        )
    notes += [
        f"{name}: a factor of {exp(value):.2g} is no number of that part any more; the bench lacks something there"
        for name, value in logs.items()
        if abs(value) > log(LARGEST_FACTOR)
    ]
    return notes
