"""Hidden effects on whole hexapods, one draw: drawn, written as a folder, diagnosed from the folder alone, and judged.

The generator (`hexathermal.simulate.hidden.machines`) and the diagnosis (`hexathermal.learn.machine_diagnosis`) share
no code; they meet here in files: a folder, the JSON of the diagnosis, the answer that stands beside the folder.
"""

from __future__ import annotations

import json
import tempfile
import time
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from benchmarks.hidden_effects import CLEAN, ONE, OUTSIDE, TWO

LEG = "leg"
"""A cause of the catalogue for a leg, on one of six."""

STRENGTHS = (0.15, 0.3, 0.6)
"""Strengths at which rates are stated; `plan` takes them in turn."""

BARS = (0.80, 0.93, 0.97)
"""Rates of right causes that are wanted at these."""

CAUSES = ("leg-coefficient", "platform-expansion", "base-expansion", "swapped-legs", "payload-compliance",
          "joint-offset", "tracker-drift", "leg-backlash")  # fmt: skip
"""The catalogue of a machine; `plan` takes them in turn."""

TURNS = (ONE, ONE, CLEAN, ONE, ONE, OUTSIDE, ONE, ONE, CLEAN, ONE, ONE, TWO)
"""What draws hide, in turn."""

NORMAL_95 = 1.96

UNFRAMED = "_unframed"
"""Of what is told where each run may have a frame of its own."""


@dataclass(frozen=True)
class MachineDraw:
    """What is to be drawn: the seed, the causes that are hidden, None where they are left to the seed, and how strong.

    `measure` says what strength is meant, see `hexathermal.simulate.hidden.machines.strength`.
    """

    seed: int
    causes: tuple[str, ...] | None
    strength: float
    measure: str = "whole"


@dataclass(frozen=True)
class MachineOutcome:
    """What hid in a campaign of a hexapod, and what the diagnosis said.

    Attributes
    ----------
    machine, hall, seed
        Of the answer.
    strength : float
        As wanted.
    causes, targets : list
        Hidden.
    whole, visible : list of float
        Strength of each, against the noise; and where each run may have a frame of its own.
    verdict, names, places, equivalent, equivalent_places, probability
        Said; `places` are the targets, `equivalent_places` those stated to be as good for the first name.
    gain, oracle_gain : dict of str to float or None
        Part of the RMSE on validation runs that is gone, by ``translation`` and ``rotation``; with `UNFRAMED` at the
        end, where each run may have a frame of its own.
    pulls : dict of str to float
        Of each parameter of a rightly named effect: stated less true value, over the stated standard deviation.
    seconds : float
        Of processor time for the diagnosis, reading included.
    failed : str
        The error where the diagnosis raised one.
    """

    machine: str
    hall: str
    seed: int
    strength: float
    causes: list[str]
    targets: list[str | None]
    whole: list[float]
    visible: list[float]
    verdict: str = "failed"
    names: list[str] = field(default_factory=list)
    places: list[str | None] = field(default_factory=list)
    equivalent: list[str] = field(default_factory=list)
    equivalent_places: list[str] = field(default_factory=list)
    probability: float = 0.0
    gain: dict[str, float | None] = field(default_factory=dict)
    oracle_gain: dict[str, float | None] = field(default_factory=dict)
    pulls: dict[str, float] = field(default_factory=dict)
    seconds: float = 0.0
    failed: str = ""

    @property
    def kind(self) -> str:
        """What was hidden: nothing, one, two, a leg's cause, or something outside the catalogues."""
        if not self.causes:
            return CLEAN
        if self.causes[0].startswith("outside"):
            return OUTSIDE
        if len(self.causes) == 2:
            return TWO
        return ONE if self.causes[0] in CAUSES else LEG

    @property
    def right(self) -> bool:
        """Whether the first name is hidden; where none of the catalogues is, whether none is named."""
        return not self.names if self.kind in (CLEAN, OUTSIDE) else bool(self.names) and self.names[0] in self.causes

    @property
    def right_or_equivalent(self) -> bool:
        """Whether the first name, or one that is stated to be equivalent, is hidden."""
        return self.right or bool(self.names and set(self.equivalent) & set(self.causes))

    @property
    def place_right(self) -> bool:
        """Whether the first name is right and sits on the right leg, plate, pair or joint; some sit nowhere."""
        if not (self.right and self.names):
            return False
        hidden = self.targets[self.causes.index(self.names[0])]
        return hidden is None or self.places[0] == hidden

    @property
    def place_right_or_equivalent(self) -> bool:
        """Whether the place is right, or among those stated to be as good."""
        if self.place_right or not (self.right and self.names):
            return self.place_right
        return self.targets[self.causes.index(self.names[0])] in self.equivalent_places

    @property
    def wrong(self) -> bool:
        """Whether something is named that is not hidden, nor stated to be equivalent to something hidden."""
        return bool(self.names) and not self.right_or_equivalent

    def told(self) -> str:
        """Return the draw in a line, with what repeats it."""
        hidden = ", ".join(
            f"{name} of {place} {size:.2f} ({seen:.2f} visible)"
            for name, place, size, seen in zip(self.causes, self.targets, self.whole, self.visible, strict=True)
        ) or "nothing"  # fmt: skip
        named = " + ".join(f"{name} of {place}" for name, place in zip(self.names, self.places, strict=True))
        also = f", or {', '.join(self.equivalent)}" if self.equivalent else ""
        said = self.failed or f"{f'{self.verdict} {named}'.rstrip()}{also} (p {self.probability:.3f})"
        return f"{self.machine}, {self.hall}, {self.seed}: hidden {hidden}; said {said}"

    def to_dict(self) -> dict[str, Any]:
        """Return plain values."""
        return asdict(self)


def plan(count: int, seed: int, measure: str = "whole") -> list[MachineDraw]:
    """Return draws: kinds, causes and strengths in turn, seeds from one."""
    import numpy as np

    generator = np.random.default_rng(seed)
    draws, singles = [], 0
    for k in range(count):
        own, kind, causes = int(generator.integers(2**53)), TURNS[k % len(TURNS)], tuple[str, ...]()
        strength = STRENGTHS[k % len(STRENGTHS)]
        if kind == ONE:
            causes = (CAUSES[singles % len(CAUSES)],)
            strength = STRENGTHS[singles % len(STRENGTHS)]
            singles += 1
        elif kind == TWO:
            causes = tuple(str(name) for name in generator.choice(CAUSES, 2, replace=False))
        elif kind == OUTSIDE:
            causes = (str(generator.choice(_foreign())),)
        draws.append(MachineDraw(own, causes, strength, measure))
    return draws


def _foreign() -> list[str]:
    """Return the effects that no catalogue has."""
    from hexathermal.simulate.hidden.machines.effects import found

    return [name for name in found() if name.startswith("outside")]


def true_values(cause: str, hidden: Mapping[str, Any]) -> dict[str, float]:
    """Return an effect's parameters as a diagnosis tells them, from those of the generator's answer.

    Empty where there is no one-to-one: a frame that follows the room with a delay; columns that are exchanged.
    """
    size = {name: float(value) for name, value in hidden.items() if isinstance(value, int | float)}
    if cause == "leg-coefficient":
        own = {f"{letter}_change_per_K": size["size"] * size[f"of_{letter}"] for letter in "AB"}
        both = {f"{name}_{sensor}": value * (sensor == hidden["sensor"]) for name, value in own.items()
                for sensor in ("T1", "T2")}  # fmt: skip
        return own | both
    if cause in ("platform-expansion", "base-expansion"):
        return {"expansion_change_per_K": size["expansion"]}
    if cause == "payload-compliance":
        sag = size["mass"] * 9.80665 * size["compliance"]
        return {"sag_um": sag * 1e6} | {f"centre_{axis}_mm": size[axis] * 1e3 for axis in "xyz"}
    if cause == "joint-offset":
        return {f"offset_{axis}_um": size["size"] * size[axis] * 1e6 for axis in "xyz"}
    if cause == "tracker-drift" and size["delay"] == 0.0:
        turns = {f"turn_{axis}_urad_per_K": size["size"] * size[f"r{axis}"] * 1e6 for axis in "xyz"}
        return {f"shift_{axis}_um_per_K": size["size"] * size[axis] * 1e6 for axis in "xyz"} | turns
    return {"step_um": size["gap"] * 1e6} if cause == "leg-backlash" else {}


def pulls_of(said: Mapping[str, Any], answer: Mapping[str, Any]) -> dict[str, float]:
    """Return by how many stated standard deviations parameters of a rightly named effect are off."""
    name, place = said.get("cause"), said.get("target")
    if name not in answer["causes"]:
        return {}
    which = answer["causes"].index(name)
    if answer["targets"][which] not in (None, place):
        return {}
    true = true_values(str(name), answer["parameters"][which])
    return {
        key: (float(one["value"]) - true[key]) / float(one["std"])
        for key, one in said.get("parameters", {}).items()
        if key in true and one.get("std")
    }


def gains_of(said: Mapping[str, Any], oracle: Mapping[str, Any]) -> tuple[dict[str, float | None], ...]:
    """Return gains of translation and rotation, of the diagnosis and of the oracle; again for `UNFRAMED`."""
    found: dict[str, float | None] = {}
    best: dict[str, float | None] = {}
    gain = said.get("gain") or {}
    for end, scores in (("", gain), (UNFRAMED, gain.get("without_frame_of_each_run") or {})):
        for kind, unit in (("translation", "um"), ("rotation", "urad")):
            before, after = (scores.get(f"{kind}_rmse_{when}_{unit}") for when in ("before", "after"))
            found[kind + end] = None if not before or after is None else 1.0 - after / before
            filed, known = oracle[f"{kind}_filed{end}_{unit}"], oracle[f"{kind}_known{end}_{unit}"]
            best[kind + end] = 1.0 - known / filed if filed else None
    return found, best


def outcome_of(draw: MachineDraw) -> MachineOutcome:
    """Make the campaign of a draw, write it, diagnose the folder, and return what came of it."""
    from hexathermal.errors import HexathermalError
    from hexathermal.simulate.hidden.machines.drawing import machine_campaign_of
    from hexathermal.simulate.hidden.machines.writing import write_machine_campaign

    truth, drawn = machine_campaign_of(draw.seed, causes=draw.causes, strength=draw.strength, measure=draw.measure)
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place) / "campaign"
        answer = json.loads(write_machine_campaign(folder, truth, drawn).read_text(encoding="utf-8"))
        start = time.process_time()
        try:
            said, failed = _diagnosed(folder), ""
        except (HexathermalError, ValueError, ArithmeticError, AssertionError, LookupError) as error:
            said, failed = {}, f"{type(error).__name__}: {error}"
        seconds = time.process_time() - start
    gain, best = gains_of(said, answer["oracle"])
    effects = said.get("effects", ())
    return MachineOutcome(
        answer["machine"], answer["hall"], draw.seed, draw.strength, answer["causes"], answer["targets"],
        answer["whole"], answer["visible"], said.get("verdict", "failed"), [one["cause"] for one in effects],
        [one["target"] for one in effects], [_name(one) for one in said.get("equivalent", [])],
        list(effects[0].get("equivalent_places", [])) if effects else [],
        said.get("probability", 0.0), gain, best, pulls_of(said, answer), seconds, failed,
    )  # fmt: skip


def _name(one: object) -> str:
    """Return the cause of an equivalent, which may be told with its place."""
    return str(one).split(" of ")[0]


def _diagnosed(folder: Path) -> dict[str, Any]:
    """Return the JSON document of a diagnosis of a campaign's folder."""
    from hexathermal.learn.campaign_files import load_campaign
    from hexathermal.learn.machine_diagnosis.diagnosing import diagnose_machine

    said = diagnose_machine(load_campaign(folder)).to_json()
    found: dict[str, Any] = json.loads(json.dumps(said, allow_nan=False))
    return found
