"""Hidden effects, one draw: a campaign is drawn, written as a folder, diagnosed from the folder alone, and judged.

The generator (`hexathermal.simulate.hidden`) and the diagnosis (`hexathermal.learn.diagnosis`) share no code; they meet
here in files: a campaign folder, the JSON of the diagnosis, the answer that stands beside the folder.
"""

from __future__ import annotations

import json
import tempfile
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from hexathermal.learn.diagnosis import Diagnosis

CLEAN, ONE, TWO, OUTSIDE = "clean", "one", "two", "outside"
KINDS = (CLEAN, ONE, TWO, OUTSIDE)
BENCHES = ("modal", "finite_volume", "component", "machine_tool", "quiet", "rough", "actuator")
"""Benches of `hexathermal.simulate.hidden`."""

HELD_OUT = "held_out"
"""The bench that no figure of the diagnosis was ever chosen by: looked at for the closing figures only."""

LATER = "free_convection"
"""A bench that came when the diagnosis was made: no figure of it was chosen by that one either."""

PARTS = "held_out_actuator"
"""Parts with a stroke, of the physics of the bench `HELD_OUT`."""

AXES = "held_out_axis"
"""The same, measured where they stand: their law reads the displacement."""

TESTED = ("finite_volume", HELD_OUT, LATER, PARTS)
"""The benches of the test suite, legs and a part: figures of the diagnosis were chosen by the first of them only."""

TOP = 4


@dataclass(frozen=True)
class Outcome:
    """What hid in a campaign, and what the diagnosis said.

    Attributes
    ----------
    bench : str
    seed : int
        ``campaign_of(bench, seed, shared=True)`` makes the campaign again.
    causes : list of str
    strengths : list of float
        Visible RMS of each effect over the noise.
    verdict : str
    names : list of str
        In the order in which they were named.
    equivalent : list of str
        Names that are told to be as good as the first.
    probability : float
    before, after : float or None [um]
        RMSE on validation runs of the law and of the extended law.
    oracle_before, oracle_after, noise : float or None [um]
        The same of the law extended by the truth, and of the noise itself.
    true_before, true_after, oracle_true_before, oracle_true_after : float or None [um]
        The first four where the validation runs are without noise.
    strengths_beside_zeros : list of float
        As `strengths`, where a constant of each run is fitted too.
    seconds : float
        Of processor time for the diagnosis.
    rows : int
    threshold : float
    top : list
        Causes that lead the ranking, with their evidence.
    failed : str
        The error where the diagnosis raised one.
    """

    bench: str
    seed: int
    causes: list[str]
    strengths: list[float]
    verdict: str = ""
    names: list[str] = field(default_factory=list)
    equivalent: list[str] = field(default_factory=list)
    probability: float = 0.0
    before: float | None = None
    after: float | None = None
    oracle_before: float | None = None
    oracle_after: float | None = None
    noise: float | None = None
    seconds: float = 0.0
    rows: int = 0
    threshold: float = 0.0
    top: list[list[Any]] = field(default_factory=list)
    failed: str = ""
    true_before: float | None = None
    true_after: float | None = None
    oracle_true_before: float | None = None
    oracle_true_after: float | None = None
    strengths_beside_zeros: list[float] = field(default_factory=list)

    @property
    def kind(self) -> str:
        """Whether nothing, one, two, or something outside the catalogue was hidden."""
        if not self.causes:
            return CLEAN
        return OUTSIDE if self.causes[0].startswith("outside") else (ONE if len(self.causes) == 1 else TWO)

    @property
    def strength(self) -> float:
        """Visible strength of the weakest effect; 0 where there is none."""
        return min(self.strengths, default=0.0)

    @property
    def strength_beside_zeros(self) -> float:
        """The same where a constant of each run is fitted too."""
        return min(self.strengths_beside_zeros, default=0.0)

    @property
    def first(self) -> str | None:
        """The first name."""
        return self.names[0] if self.names else None

    @property
    def right(self) -> bool:
        """Whether the verdict is the truth: the first name is hidden, or none is and none is said."""
        if self.kind == CLEAN:
            return self.verdict == "none"
        return self.verdict == "unexplained" if self.kind == OUTSIDE else self.first in self.causes

    @property
    def right_or_equivalent(self) -> bool:
        """Whether the first name, or one that is stated to be equivalent, is hidden."""
        return self.right or (self.kind in (ONE, TWO) and bool(self.names and set(self.equivalent) & set(self.causes)))

    @property
    def wrong(self) -> bool:
        """Whether the first name is not hidden, nor an equivalent that is stated."""
        return bool(self.names) and not self.right_or_equivalent

    @property
    def pair(self) -> bool:
        """Whether all names, and no others, are hidden."""
        return sorted(self.names) == sorted(self.causes)

    @property
    def extra(self) -> bool:
        """Whether any name, first or later, is hidden nowhere, nor stated to be equivalent."""
        return self.wrong or bool(set(self.names[1:]) - set(self.causes))

    @property
    def gain(self) -> float | None:
        """Part of the law's RMSE on validation runs that the extension takes away."""
        return _part_gained(self.before, self.after)

    @property
    def oracle_gain(self) -> float | None:
        """The same of the truth."""
        return _part_gained(self.oracle_before, self.oracle_after)

    @property
    def true_gain(self) -> float | None:
        """The same as `gain` where the validation runs are without noise."""
        return _part_gained(self.true_before, self.true_after)

    @property
    def oracle_true_gain(self) -> float | None:
        """The same as `oracle_gain` where the validation runs are without noise."""
        return _part_gained(self.oracle_true_before, self.oracle_true_after)

    def told(self) -> str:
        """Return the draw in a line, with what repeats it."""
        hidden = (
            ", ".join(f"{name} {size:.2f}" for name, size in zip(self.causes, self.strengths, strict=True)) or "nothing"
        )
        named = f"{self.verdict} {' + '.join(self.names)}".rstrip()
        said = self.failed or f"{named} (p {self.probability:.3f})"
        ranking = ", ".join(f"{name} {evidence:.1f}" for name, evidence in self.top) or "empty"
        return f"{self.bench} {self.seed}: hidden {hidden}; said {said}; ranking: {ranking}"

    def to_dict(self) -> dict[str, Any]:
        """Return plain values."""
        return asdict(self)


def _part_gained(before: float | None, after: float | None) -> float | None:
    """Return the part of an RMSE that is taken away; None where it is not known."""
    return None if not before or after is None else 1.0 - after / before


def diagnosed(folder: Path, sensors: list[str]) -> Diagnosis:
    """Return the diagnosis of a campaign's folder."""
    from hexathermal.learn.campaign_files import load_campaign
    from hexathermal.learn.diagnosis import diagnose

    return diagnose(load_campaign(folder), sensors)


def outcome_of(bench: str, seed: int, causes: tuple[str, ...] | None = None, strength: float | None = None) -> Outcome:
    """Draw what a seed stands for, write it, diagnose the folder, and return what came of it."""
    from hexathermal.errors import HexathermalError
    from hexathermal.simulate.hidden.drawing import campaign_of
    from hexathermal.simulate.hidden.strength import without_noise
    from hexathermal.simulate.hidden.writing import write_campaign

    truth, drawn = campaign_of(bench, seed, causes=causes, strength=strength, shared=True)
    rows = sum(len(run.time) for run in truth.runs)
    said: dict[str, Any] = {}
    exact: tuple[float | None, float | None] = None, None
    failed = ""
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place) / "campaign"
        answer = json.loads(write_campaign(folder, truth, drawn).read_text(encoding="utf-8"))
        start = time.process_time()
        try:
            found = diagnosed(folder, answer["base"])
            said = json.loads(json.dumps(found.to_json(), allow_nan=False))
        except (HexathermalError, ValueError, ArithmeticError, AssertionError, LookupError) as error:
            failed = f"{type(error).__name__}: {error}"
        seconds = time.process_time() - start
        if not failed:
            write_campaign(Path(place) / "exact", without_noise(truth), drawn)
            exact = _errors(found, Path(place) / "exact")
    gain, oracle = said.get("gain") or {}, answer["oracle"]
    return Outcome(
        bench, seed, answer["causes"], answer["strengths"], said.get("verdict", "failed"),
        [one["cause"] for one in said.get("effects", ())], said.get("equivalent", []), said.get("probability", 0.0),
        gain.get("rmse_before_um"), gain.get("rmse_after_um"), oracle["rmse_base_um"], oracle["rmse_known_um"],
        oracle["rmse_noise_um"], seconds, rows, said.get("threshold", 0.0),
        [[one["cause"], round(one["evidence"], 1)] for one in said.get("candidates", ())[:TOP]], failed, *exact,
        oracle["rmse_base_without_noise_um"], oracle["rmse_known_without_noise_um"],
        list(drawn.strengths_with_offsets),
    )  # fmt: skip


def _errors(found: Diagnosis, folder: Path) -> tuple[float | None, float | None]:
    """Return the RMSE [um] of the law and of the extended law on the validation runs of a folder."""
    from hexathermal.learn.campaign_files import load_campaign
    from hexathermal.learn.diagnosis.extension import gained

    gain = gained(found.law, found.extended, load_campaign(folder))
    return (None, None) if gain is None else (1e6 * gain.total.rmse_before, 1e6 * gain.total.rmse_after.value)


def plan(count: int, seed: int, of: Sequence[str] = BENCHES) -> list[tuple[str, int]]:
    """Return benches and seeds of draws: benches in turn, seeds from one."""
    import numpy as np

    seeds = np.random.default_rng(seed).integers(2**53, size=count)
    return [(of[k % len(of)], int(one)) for k, one in enumerate(seeds)]
