"""Words of a machine's diagnosis for people: amplitudes with intervals, gains, limits, what poses do not show."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from hexathermal.show.diagnosis_words import parameter, rounded, span
from hexathermal.show.shares import less, parts, proven

if TYPE_CHECKING:
    from hexathermal.learn.hexapod_scores import PoseScore
    from hexathermal.learn.machine_diagnosis.moving import Moved
    from hexathermal.learn.machine_diagnosis.result import MachineDiagnosis, MachineEffect

UM = 1e6


def changed(found: MachineDiagnosis) -> bool:
    """Return whether something joined the machine, or its laws were fitted anew, so that there is an after."""
    return bool(found.effects) or found.extended != found.hexapod


def cautions(found: MachineDiagnosis) -> list[str]:
    """Return what in an extended machine needs more than the pose and temperatures of one moment, or is not used."""
    said = list[str]()
    before, after = found.hexapod.thermal, found.extended.thermal
    if before is not None and after is not None and len(after.states) > len(before.states):
        known = [term.cause for term in before.states]
        causes = ", ".join(dict.fromkeys(term.cause for term in after.states if term.cause not in known)) or "a term"
        said.append(
            f"the extended machine holds {causes}, which depends on what was before: 'correct' needs rows in the order "
            "of the motion with time_s, Python hexapod.leg_controllers(); single poses and budgets refuse it, unless "
            "'hexathermal apply --at-rest' leaves it out"
        )
    if found.extended.measuring_frame is not None and found.hexapod.measuring_frame is None:
        said.append(
            "tracker-drift is of the measurement: [measuring_frame] stands in the file, 'correct' does not follow it"
        )
    return said


def sentences(found: MachineDiagnosis) -> list[str]:
    """Return the finding: one sentence, and one for each further cause; with what is not ruled out."""
    return [
        one.sentence
        + (f" Not ruled out by these data: {', '.join(one.equivalent_places)}." if one.equivalent_places else "")
        for one in found.effects
    ] or [found.sentence]


def parameter_rows(one: MachineEffect) -> list[tuple[str, ...]]:
    """Return the parameters of a cause: name, value, standard uncertainty, 95 % interval, unit."""
    from hexathermal.learn.machine_diagnosis.quantities import spoken

    rows: list[tuple[str, ...]] = []
    for name, quantity in one.parameters.items():
        shown = parameter(name, quantity)
        rows.append((spoken(name), *shown.cells, "" if shown.unit == "1" else shown.unit))
    return rows


def relative_std(one: MachineEffect) -> float:
    """Return the relative standard uncertainty of an effect's size, NaN where it could not be told.

    The size is proportional to the amplitudes; of several, that of the one that is known best counts.
    """
    free = {name: value for name, value in one.parameters.items() if not _follows(name, one)}
    parts = [value.std / abs(value.value) for value in free.values() if math.isfinite(value.std) and value.value]
    return min(parts, default=math.nan)


def _follows(name: str, one: MachineEffect) -> bool:
    """Whether a parameter follows from others of the same cause."""
    if name == "offset_um" or name.startswith("centre_"):
        return True
    changes = any("_change_" in other for other in one.parameters)
    return changes and "_change_" not in name


def amplitude(one: MachineEffect, rotation: bool = False) -> str:
    """Return the RMS of an effect on the platform with its 95 % interval [um or urad]."""
    value = (one.rotation if rotation else one.translation) * UM
    return sized(value, value * relative_std(one))


def sized(value: float, std: float) -> str:
    """Return a size with its 95 % interval, where an uncertainty is known.

    Examples
    --------
    >>> sized(0.31, 0.02), sized(0.31, float("nan"))
    ('0.310 (0.271 to 0.349)', '0.31')
    """
    return f"{rounded(value, std)} ({span(value, std, positive=True)})" if math.isfinite(std) else f"{value:.2g}"


def moved(one: Moved) -> tuple[str, str]:
    """Return how far a candidate moves the platform, RMS with its 95 % interval [um] and [urad]."""
    far = sized(one.translation * UM, one.translation_std * UM)
    return far, sized(one.rotation * UM, one.rotation_std * UM)


def gain_words(found: MachineDiagnosis) -> str:
    """Return what the extended machine gains on runs for validation, in words."""
    if found.gain is None:
        return "There are no runs for validation: what the extended machine gains on new runs is not known."
    if not changed(found):
        near, turned = found.gain.total["translation"], found.gain.total["rotation"]
        return (
            f"On runs never fitted the machine leaves an RMSE of {near.before.value * UM:.3f} um and "
            f"{turned.before.value * UM:.3f} urad; nothing joined it."
        )
    said = ", ".join(_brought(scores, unit) for scores, unit in _pairs(found.gain.total))
    words = f"On runs never fitted the extended machine brings the RMSE {said}."
    if framed_out(found):
        freed = ", ".join(_brought(scores, unit) for scores, unit in _pairs(found.gain.unframed))
        words += f" Without each run's own mean motion, since the measuring frame differs between runs: {freed}."
    return words


def _pairs(scores: dict[str, PoseScore]) -> list[tuple[PoseScore, str]]:
    """Return the scores of translation and rotation with their units."""
    return [(scores["translation"], "um"), (scores["rotation"], "urad")]


def _brought(one: PoseScore, unit: str) -> str:
    """Return what one score says."""
    part = one.reduction
    return f"from {one.before.value * UM:.3f} to {one.after.value * UM:.3f} {unit} ({less(part)}; {proven(part)})"


def framed_out(found: MachineDiagnosis) -> bool:
    """Return whether the measuring frame differs between runs, so that errors count without it too."""
    return bool(found.disturbances.frame.any())


def score_cells(one: PoseScore) -> tuple[str, str, str, str]:
    """Return before, after with its 95 % interval, reduction with its interval, largest before and after."""
    after, part = one.after, one.reduction
    inside = f" ({after.low * UM:.3f} to {after.high * UM:.3f})" if math.isfinite(after.low + after.high) else ""
    return (
        f"{one.before.value * UM:.3f}", f"{after.value * UM:.3f}{inside}",
        f"{parts(part.value)} % ({parts(part.low)} to {parts(part.high)})",
        f"{one.largest_before * UM:.2f} -> {one.largest_after * UM:.2f}",
    )  # fmt: skip


def notes_of(found: MachineDiagnosis) -> tuple[list[str], list[str]]:
    """Return notes on this campaign, and causes that these runs cannot show with what would show them."""
    from hexathermal.learn.machine_diagnosis.single_leg import CANNOT_SHOW

    absent = [note.partition(CANNOT_SHOW) for note in found.notes if CANNOT_SHOW in note]
    return [note for note in found.notes if CANNOT_SHOW not in note], [
        f"{name}: {words}" for name, _said, words in absent
    ]


def noise_words(found: MachineDiagnosis) -> str:
    """Return noise and disturbances, in words."""
    said = found.disturbances
    noise = [f"{value * UM:.2f}" for value in said.noise]
    words = f"Noise of a pose: x y z {', '.join(noise[:3])} um, rx ry rz {', '.join(noise[3:])} urad"
    parts = (("frame of each run", said.frame), ("frame of the campaign", said.campaign), ("slow in a run", said.slow))
    for name, size in parts:
        if size.any():
            words += f"; {name} {size[:3].mean() * UM:.2f} um and {size[3:].mean() * UM:.2f} urad"
    if said.leg > 0.0:
        words += f"; slow in each leg {said.leg * UM:.2f} um"
    return words + "."
