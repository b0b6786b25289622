"""From a campaign to a law, and from a law to its validation, in one call each: what the command line uses.

``identify`` and ``validate`` work on blocks of rows; here they are given those of a campaign's runs, and what only the
campaign knows: kind, zero, positions of the sensors, range of temperatures, fingerprint.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from hexathermal.errors import ArgumentError, DataError
from hexathermal.learn.campaign import Block, Campaign
from hexathermal.learn.campaign_dataset import fingerprint, table_digest
from hexathermal.learn.check_remarks import of_fahrenheit, of_length, of_stroke
from hexathermal.learn.cleaning import parts_of, usable_blocks
from hexathermal.learn.cleaning_record import CleaningRecord, cleaning_words
from hexathermal.learn.identification import AUTO, Identification, Passing, identify
from hexathermal.learn.law import IdentifiedLaw, Origin
from hexathermal.learn.signals import RunRows
from hexathermal.learn.validation import Validation, validate
from hexathermal.learn.validation_rows import RowsPredictor
from hexathermal.poses import FloatArray

KINDS = {"leg": "a leg (drift = A q0 dT + B q dT)",
         "component": "a component (drift = C dT, or C dT + D q dT)"}  # fmt: skip
"""Kinds of laws in words."""


class _Passed:
    """What passed: lowest and highest temperature of each sensor [degC], and what cleaning did in each run."""

    def __init__(self) -> None:
        self.seen: dict[str, tuple[float, float]] = {}
        self.records: dict[str, CleaningRecord] = {}

    def notes(self) -> tuple[str, ...]:
        """Return what cleaning did, in words; nothing where it did nothing."""
        records = tuple(self.records.values())
        notes = [f"run {record.run} has no usable row: {record.why_rows}" for record in records if not record.used]
        return (*notes, *cleaning_words(records))

    def why(self, run: str, sensor: str) -> str:
        """Return how a sensor lost values in a run, by the steps of cleaning; empty where that is not known."""
        known = [record for record in self.records.values() if record.run == run]
        return known[0].why_values(f"{sensor}_degC") if len(known) == 1 else ""

    def add(self, sensors: Sequence[str], values: FloatArray) -> None:
        """Add rows, shape (n, s)."""
        low, high = np.fmin.reduce(values, axis=0), np.fmax.reduce(values, axis=0)
        for name, lowest, highest in zip(sensors, low, high, strict=True):
            before = self.seen.get(name, (lowest, highest))
            self.seen[name] = (float(np.fmin(before[0], lowest)), float(np.fmax(before[1], highest)))

    def _units(self) -> list[str]:
        """Return what is said of temperatures that can hardly be in degrees Celsius."""
        return of_fahrenheit(tuple(self.seen), [np.array([low for low, _high in self.seen.values()])], float("nan"))

    def filled(self, found: Identification) -> Identification:
        """Return an identification with the range of temperatures that its sensors met, and what cleaning did."""
        found = replace(
            found, notes=(*found.notes, *self.notes()), warnings=(*found.warnings, *self._units(), *_off_stroke(found))
        )
        spans = np.array([self.seen[name] for name in found.law.sensors])
        if not np.isfinite(spans).all():
            return found
        # the last digits are those of dT, not of a thermometer
        degC = (round(float(spans[:, 0].min()), 6), round(float(spans[:, 1].max()), 6))
        return replace(found, law=replace(found.law, validity=replace(found.law.validity, degC=degC)))


def _off_stroke(found: Identification) -> list[str]:
    """Return that a leg is as short as none is, or was where its stroke does not reach: another zero of the scale."""
    off = of_stroke(found.law.validity.q, found.law.stroke)
    said = [f"{off}: B holds for q as recorded; is the scale's zero that of stroke_mm?"] if off else []
    return of_length(found.law.retracted_length, found.law.stroke) or said


def role_blocks(
    campaign: Campaign, role: str, progress: Passing | None = None, passed: _Passed | None = None,
    read: Mapping[str, RunRows] | None = None,
) -> Iterator[Block]:  # fmt: skip
    """Give the usable blocks of all runs of a role, in constant memory.

    Parameters
    ----------
    campaign : Campaign
    role : str
        ``"identification"`` or ``"validation"``.
    progress : function, optional
        Called as ``progress(done, total, label)`` after each block.
    read : mapping of str to RunRows, optional
        Runs that are in memory already, by their names: they are not read again.
    """
    runs = campaign.runs_of(role)
    for k, run in enumerate(runs):
        if read is not None and run.name in read:
            yield from _read_blocks(campaign, read[run.name], passed)
            continue
        blocks = usable_blocks(campaign, run)
        for block in blocks:
            if passed is not None and blocks.zero is not None:
                passed.add(campaign.sensors, block.dT + blocks.zero.heat)
            yield block
            if progress is not None:
                progress(int(1000.0 * (k + blocks.done)), 1000 * len(runs), f"reading {run.name}")
        if passed is not None:
            passed.records[f"{campaign.folder}/{run.name}"] = blocks.record


def _read_blocks(campaign: Campaign, rows: RunRows, passed: _Passed | None) -> Iterator[Block]:
    """Give the usable blocks of a run that is in memory."""
    zero = np.array([rows.signals.zero_degC.get(name, np.nan) for name in campaign.sensors])
    for block in parts_of(rows.usable):
        if passed is not None:
            passed.add(campaign.sensors, block.dT + zero)
        yield block
    if passed is not None:
        passed.records[f"{campaign.folder}/{rows.run.name}"] = rows.record


def _refuse_no_law(campaign: Campaign) -> None:
    """Refuse a campaign that no law of one drift can come from."""
    if campaign.kind == "hexapod":
        raise ArgumentError(
            "a campaign of kind 'hexapod' measures poses, not the drift of one leg; use identify_hexapod, or identify "
            "its legs one by one on a bench"
        )
    if not campaign.sensors:
        raise DataError("the campaign has no thermocouples, so there is nothing that a law could read")


def identify_campaign(
    campaign: Campaign,
    sensors: str | Sequence[str] = AUTO,
    *,
    sizes: Sequence[int] = (1, 2),
    material: str | None = None,
    along: bool | None = None,
    progress: Passing | None = None,
    read: Mapping[str, RunRows] | None = None,
) -> Identification:
    """Return the law that a campaign's runs for identification give.

    Parameters
    ----------
    campaign : Campaign
        Of kind ``"leg"`` or ``"component"``.
    sensors : ``"auto"`` or sequence of str
        Sensors of the law; auto: chosen among all sets.
    sizes : sequence of int
        Sizes of the sets of sensors that are searched.
    material : str, optional
        Of the fixed part, for the check of the result.
    along : bool, optional
        Whether the law of a component reads the displacement; by default runs left out decide.
    progress : function, optional
        Called as ``progress(done, total, label)``.
    read : mapping of str to RunRows, optional
        Runs that are in memory already, by their names.

    Raises
    ------
    ArgumentError
        The campaign is of kind ``"hexapod"``; otherwise as `identify`.
    DataError
        The campaign has no thermocouples; otherwise as `identify`.
    UnknownNameError
        No such sensor or material.
    CampaignError
        A table is at fault.
    """
    _refuse_no_law(campaign)
    passed = _Passed()
    found = identify(
        lambda: role_blocks(campaign, "identification", passed=passed, read=read), campaign.sensors, campaign.leg,
        wanted=sensors, sizes=sizes, zero=campaign.zero, origin=Origin(campaign.title, fingerprint(campaign)),
        material=material, positions=[one.position for one in campaign.thermocouples], progress=progress,
        why=passed.why, along=along,
    )  # fmt: skip
    return passed.filled(found)


def identify_together(
    legs: Mapping[str, Campaign],
    sensors: Sequence[str],
    *,
    material: str | None = None,
    progress: Passing | None = None,
) -> Identification:
    """Return one law, fitted to the runs for identification of several legs of one build.

    Parameters
    ----------
    legs : mapping of a leg's name to its campaign
        All of one kind, retracted length and stroke. Runs are named ``leg/run``.
    sensors : sequence of str
        Of the law; every leg has them.
    material : str, optional
    progress : function, optional

    Raises
    ------
    ArgumentError
        The legs differ in kind, retracted length, stroke or zero, or share a run; otherwise as `identify_campaign`.
    """
    first, *others = legs.values()
    for k, one in enumerate(others):
        refuse_other_build(first, one)
        refuse_same_runs([first, *others[:k]], one)
    shared = [name for name in first.sensors if all(name in one.sensors for one in others)]
    passed = _Passed()

    def rows() -> Iterator[Block]:
        for name, one in legs.items():
            columns = [one.sensors.index(sensor) for sensor in shared]
            for block in role_blocks(one, "identification", passed=passed):
                run = replace(block.run, name=f"{name}/{block.run.name}")
                yield replace(block, run=run, dT=block.dT[:, columns])

    together = hashlib.sha256("".join(map(fingerprint, legs.values())).encode()).hexdigest()
    origin = Origin(", ".join(one.title or one.folder.name for one in legs.values()), together)
    found = identify(rows, shared, first.leg, wanted=sensors, zero=first.zero, origin=origin, material=material,
                     progress=progress)  # fmt: skip
    return passed.filled(found)


def refuse_other_build(first: Campaign, other: Campaign) -> None:
    """Refuse two campaigns that no common law can serve."""
    for what in ("kind", "leg", "zero"):
        if getattr(first, what) != getattr(other, what):
            words = "retracted length or stroke" if what == "leg" else what
            raise ArgumentError(f"{other.folder} is of another {words} than {first.folder}: no common law")


def refuse_same_runs(others: Sequence[Campaign], campaign: Campaign) -> None:
    """Refuse a campaign with a run that another one holds too: counted twice, it would count for two legs."""
    known = {table_digest(run.path): (other, run.name) for other in others for run in other.runs_of("identification")}
    for run in campaign.runs_of("identification"):
        if (twin := known.get(table_digest(run.path))) is not None:
            other, name = twin
            raise ArgumentError(
                f"run {run.name} of {campaign.folder} holds the same rows as run {name} of {other.folder}: a run must "
                "not count for two legs; give campaigns of other legs"
            )


def validate_campaign(law: IdentifiedLaw, campaign: Campaign, progress: Passing | None = None) -> Validation:
    """Return how a law predicts a campaign's runs for validation.

    Parameters
    ----------
    law : IdentifiedLaw
    campaign : Campaign
        Of the law's kind and zero.
    progress : function, optional
        Called as ``progress(done, total, label)``.

    Raises
    ------
    ArgumentError
        The campaign is of another kind or zero than the law, or has no rows to validate on.
    UnknownNameError
        The campaign lacks a sensor of the law.
    CampaignError
        A table is at fault.
    """
    if law.kind != campaign.kind:
        raise ArgumentError(
            f"this is the law of {KINDS[law.kind]}, the campaign is of kind {campaign.kind!r}: take a campaign of kind "
            f"{law.kind!r}, or identify a law from this one"
        )
    if law.zero != campaign.zero:
        raise ArgumentError(
            f"the law counts temperatures from the first row of the {law.zero}, this campaign from that of the "
            f"{campaign.zero}: they cannot be compared; set zero in campaign.toml as it was for the law"
        )
    passed = _Passed()
    predictor = RowsPredictor(law, campaign) if law.extended else None
    found = validate(law, role_blocks(campaign, "validation", progress, passed), campaign.sensors, predictor)
    return replace(found, notes=(*found.notes, *passed.notes()))
