"""What a diagnosis says: verdict, causes, gain, limits, and its JSON (``hexathermal-diagnosis/1``)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from hexathermal.learn.diagnosis.alike_by_nature import not_ruled_out
from hexathermal.learn.diagnosis.as_json import UM, gained_facts, noise_facts, parameter_facts, ranked_facts, target_of
from hexathermal.learn.diagnosis.channels import Levels
from hexathermal.learn.diagnosis.constants_beside import BesideConstants, beside_constants
from hexathermal.learn.diagnosis.given_law import Given
from hexathermal.learn.diagnosis.refused import Refused
from hexathermal.learn.diagnosis.trials import PREFIX
from hexathermal.learn.diagnosis.unlike_runs import unlike_words
from hexathermal.learn.law import IdentifiedLaw
from hexathermal.learn.validation_gain import Gain
from hexathermal.machine.shown import Shown
from hexathermal.poses import FloatArray

FORMAT = "hexathermal-diagnosis/1"

ALSO = ", "
"""What stands between further runs of an effect, in its setting ``also``."""


@dataclass(frozen=True)
class Quantity:
    """A parameter with its standard uncertainty, in `unit`; `std` is NaN where none could be told."""

    value: float
    std: float
    unit: str


@dataclass(frozen=True, eq=False)
class Effect:
    """A cause that was named.

    Attributes
    ----------
    cause : str
    target : str or None
        Sensor, input, run or beam that it sits on.
    parameters : mapping of str to Quantity
    settings : mapping
        Parameters that are no numbers, as the name of another sensor.
    probability : float
    equivalent : tuple of str
        Names that these data cannot tell from it.
    visible : float [m]
        RMS of what stays visible after the law is refitted.
    sentence : str
    joined : bool
        Whether it joined the law: it paid on runs left out.
    refused : bool
        Whether it stays out of the law since that would foretell runs never fitted worse.
    taken_back : bool
        Whether cleaning had taken it back before any law was fitted: no law need hold it.
    rivals : mapping of str to float
        Probabilities of those of `equivalent` of which these data speak; the others no data of this kind tell apart.
    """

    cause: str
    target: str | None
    parameters: Mapping[str, Quantity]
    settings: Mapping[str, Any]
    probability: float
    equivalent: tuple[str, ...]
    visible: float
    sentence: str
    joined: bool
    taken_back: bool = False
    refused: bool = False
    rivals: Mapping[str, float] = field(default_factory=dict)

    @property
    def of_judged_run(self) -> bool:
        """Whether it sits in a run for validation, which no law is fitted to."""
        return self.settings.get("role") == "validation"

    @property
    def told_by_thermometers(self) -> bool:
        """Whether the other thermometers told of it without the drift: plugs that changed places between runs."""
        return self.cause == "swapped-sensors" and "runs" in self.settings


@dataclass(frozen=True)
class Candidate:
    """A cause, or something without a name, in the ranking.

    Attributes
    ----------
    cause : str
    target : str or None
    evidence : float
        Natural logarithm of the Bayes factor against nothing.
    probability : float
    visible : float [m]
        RMS of what stays visible of it.
    settings : mapping
        Parameters at which it explains most.
    spread : float [m]
        Standard uncertainty of `visible`.
    """

    cause: str
    target: str | None
    evidence: float
    probability: float
    visible: float
    settings: Mapping[str, Any]
    spread: float = float("nan")


@dataclass(frozen=True)
class Limit:
    """How large an effect of a cause must be in this campaign to be named: visible RMS and whole RMS [m]."""

    cause: str
    visible: float
    whole: float


@dataclass(frozen=True)
class Confusion:
    """Two causes, and the log evidence by which this campaign would tell them apart at twice the limit."""

    causes: tuple[str, str]
    separation: float


@dataclass(frozen=True)
class Experiment:
    """A measurement to make next: which causes it tells apart, by how much log evidence for an effect of some size.

    Attributes
    ----------
    words : str
    causes : tuple of str
        The one that it shows, and those that it is confused with.
    separation : float
        Log evidence that it brings on average.
    size : float [m]
        RMS of the whole effect that this is told for.
    """

    words: str
    causes: tuple[str, ...]
    separation: float
    size: float = 0.0


@dataclass(frozen=True, eq=False)
class Autocorrelation:
    """How whitened residuals of neighbouring windows go together, runs for identification.

    Attributes
    ----------
    before, after : array, shape (l,)
        At lags of 1 to l windows, within runs: what the law leaves and what the extended law leaves.
    band : float
        Independent noise stays within plus and minus this at 19 of 20 lags.
    """

    before: FloatArray
    after: FloatArray
    band: float


@dataclass(frozen=True, eq=False)
class RunResidual:
    """What the law leaves of a run in windows, for pictures: SI units.

    Attributes
    ----------
    run, role : str
    time, measured, before, after : array, shape (w,)
        `before` and `after` are residuals of the law and of the extended law.
    signals : mapping of str to array, shape (w,)
        ``q``, ``direction``, ``dT``, ``rate``, ``since_move``, ``pressure``, ``humidity``, ``air``: those that
        are known.
    """

    run: str
    role: str
    time: FloatArray
    measured: FloatArray
    before: FloatArray
    after: FloatArray
    signals: Mapping[str, FloatArray]


@dataclass(frozen=True, eq=False, repr=False)
class Diagnosis(Shown):
    """What the measurements say about the law.

    Attributes
    ----------
    verdict : str
        ``"effect"``, ``"none"`` or ``"unexplained"``.
    probability : float
        Of the verdict, and of the first name where there is one.
    effects : tuple of Effect
        In the order in which they were found.
    follows : str or None
        Of something unexplained: what it follows.
    candidates : tuple of Candidate
        Best first; effects that were named come first.
    law : IdentifiedLaw
        Before, fitted to the campaign's runs for identification.
    extended : IdentifiedLaw
        With the terms and repairs that joined; the same law where none did.
    gain : Gain or None
        On validation runs; None where there are none.
    reachable : float or None
        RMSE [m] on validation runs that a free fit of flexible columns reaches, for comparison.
    noise : Levels
        Of the drift in the end [m].
    threshold : float
        Log evidence that a name needed in this campaign.
    limits : tuple of Limit
    confusions : tuple of Confusion
    experiments : tuple of Experiment
    residuals : tuple of RunResidual
    notes : tuple of str
    whiteness : Autocorrelation or None
        None where runs are too short to tell.
    given : Given or None
        The law that was given, where one was.
    doubtful : tuple of str
        Of the notes, what makes the readings themselves doubtful.
    refused : Refused or None
        What the law would leave with causes that stay out of it, since it would foretell runs never fitted worse.
    """

    verdict: str
    probability: float
    effects: tuple[Effect, ...]
    follows: str | None
    candidates: tuple[Candidate, ...]
    law: IdentifiedLaw
    extended: IdentifiedLaw
    gain: Gain | None
    reachable: float | None
    noise: Levels
    threshold: float
    limits: tuple[Limit, ...]
    confusions: tuple[Confusion, ...]
    experiments: tuple[Experiment, ...]
    residuals: tuple[RunResidual, ...]
    title: str = ""
    notes: tuple[str, ...] = field(default=())
    whiteness: Autocorrelation | None = None
    given: Given | None = None
    doubtful: tuple[str, ...] = ()
    refused: Refused | None = None

    def __repr__(self) -> str:
        return f"{type(self).__name__}: {self.sentence}"

    @property
    def cause(self) -> str | None:
        """The first name, None where there is none."""
        return self.effects[0].cause if self.effects else None

    @property
    def sentences(self) -> tuple[str, ...]:
        """A sentence for each cause; later ones tell what those before them left."""
        return in_turn([one.sentence for one in self.effects])

    @property
    def _seen(self) -> str:
        """How large what has no name is, and its period, or where it begins, in words."""
        item = next((one for one in self.candidates if one.cause == self.follows), None)
        if item is None:
            return ""
        own = {name: float(item.settings[name]) / 60.0 for name in ("period_s", "time_s") if name in item.settings}
        of = f", of a period of {own['period_s']:.3g} min" if "period_s" in own else ""
        of += f", in {item.settings['run']} from {own['time_s']:.3g} min on" if "time_s" in own else ""
        return f" ({item.visible * UM:.2g} um of it visible, RMS{of})"

    @property
    def beside_constants(self) -> BesideConstants | None:
        """What the gain is beside a constant in each run for validation; None where nothing is judged so."""
        return beside_constants(self.residuals, self.gain, self.law.zero)

    @property
    def unlike(self) -> tuple[str, ...]:
        """Which runs never fitted are unlike those that the law knows; empty where none is."""
        judged = [one for one in self.effects if one.of_judged_run]
        told = {name for one in judged for name in (str(one.target), *str(one.settings.get("also", "")).split(ALSO))}
        return unlike_words(self.residuals, told)

    @property
    def sentence(self) -> str:
        """The diagnosis in one sentence, or one for each cause, and which runs are unlike those that it speaks of.

        Of a law that was given, with other coefficients than these data have, that is first where nothing is named.
        """
        return " ".join(self.framed((self.finding,)))

    def framed(self, said: Sequence[str]) -> tuple[str, ...]:
        """Return sentences of the finding with those of a law that was given, and of runs that are unlike others."""
        given = self.given.words if self.given is not None else ()
        first, last = (given, ()) if self.verdict == "none" else ((), given)
        return (*first, *said, *last, *self.unlike)

    @property
    def possible(self) -> tuple[str, ...]:
        """Names that what has none may have all the same."""
        return not_ruled_out(self.follows or "", self.candidates, [one.cause for one in self.effects])

    @property
    def finding(self) -> str:
        """What is named, or that nothing is, in words."""
        but = f" ({', '.join(self.possible)} not ruled out)" if self.possible else ""
        left = f"omething real is left that {self.follows}{self._seen}, but no cause of the catalogue explains it{but}."
        if self.verdict == "effect":
            hidden = self.follows is not None and all(one.taken_back or one.of_judged_run for one in self.effects)
            return " ".join((*self.sentences, *([f"S{left}"] if hidden else [])))
        if self.verdict == "none":
            limit = max((item.visible for item in self.limits), default=0.0) * UM
            what = f"stands above {limit:.2g} um (visible RMS)" if self.limits else "is seen"
            data = "the runs that it was fitted on" if self.unlike else "these data"
            trusted = "as far as its thermometers can be trusted" if self.unnamed else "to their noise"
            anew = " fitted anew" if self.given is not None and self.given.wrong else ""
            return f"No effect of the catalogue {what}: the law{anew} explains {data} {trusted}."
        return f"S{left}"

    @property
    def unnamed(self) -> tuple[str, ...]:
        """Why nothing is named although some candidates stand above chance; empty where none does."""
        above = [one.cause + (f", {at}" if (at := target_of(one)) and not one.cause.startswith(PREFIX) else "")
                 for one in self.candidates if one.evidence >= self.threshold]  # fmt: skip
        if self.verdict != "none" or not above:
            return ()
        they, are, them = ("these stand", "are", "them") if len(above) > 1 else ("this stands", "is", "it")
        return (
            f"{'; '.join(above)}: {they} above chance, but {are} not named: small errors of the law or of its "
            f"thermometers would look like {them}, or runs left out of the fit do not bear {them} out. The law "
            "explains these data as far as its thermometers can be trusted, not row by row.",
        )

    def to_json(self) -> dict[str, Any]:
        """Return the diagnosis as its JSON document."""
        first = self.effects[0] if self.effects else None
        total = None if self.gain is None else self.gain.total
        return {
            "format": FORMAT,
            "title": self.title,
            "verdict": self.verdict,
            "cause": self.cause,
            "target": None if first is None else target_of(first),
            "equivalent": list(self.possible if first is None else first.equivalent),
            "probability": self.probability,
            "parameters": parameter_facts(first),
            "settings": {} if first is None else dict(first.settings),
            "sentence": self.sentence,
            "unlike": list(self.unlike),
            "effects": [
                {"cause": one.cause, "target": target_of(one), "probability": one.probability,
                 "equivalent": list(one.equivalent), "rivals": dict(one.rivals), "parameters": parameter_facts(one),
                 "settings": dict(one.settings), "visible_rms_um": one.visible * UM, "joined_law": one.joined,
                 "taken_back": one.taken_back, "refused": one.refused, "sentence": one.sentence}
                for one in self.effects
            ],
            "follows": self.follows,
            "gain": None if total is None else {
                **gained_facts(total),
                "runs": {name: gained_facts(run)
                         for name, run in (self.gain.runs if self.gain is not None else {}).items()},
                "rmse_reachable_um": None if self.reachable is None else self.reachable * UM,
            },
            "refused": None if self.refused is None else self.refused.to_json(),
            "beside_constants": None if self.beside_constants is None else self.beside_constants.to_json(),
            "given": None if self.given is None else self.given.to_json(),
            "candidates": [ranked_facts(one) for one in self.candidates],
            "next_experiment": self.experiments[0].words if self.experiments else None,
            "experiments": [{"words": one.words, "causes": list(one.causes), "separation": one.separation,
                             "size_um": one.size * UM} for one in self.experiments],
            "detection_limits_um": {one.cause: one.visible * UM for one in self.limits},
            "detection_limits_whole_um": {one.cause: one.whole * UM for one in self.limits},
            "confusions": [{"causes": list(one.causes), "separation": one.separation} for one in self.confusions],
            "noise_um": noise_facts(self.noise),
            "noise_slow_time_s": self.noise.slow_time,
            "autocorrelation": None if self.whiteness is None else {
                "before": self.whiteness.before.tolist(), "after": self.whiteness.after.tolist(),
                "band_95": self.whiteness.band},
            "threshold": self.threshold,
            "sensors": list(self.law.sensors),
            "doubtful": list(self.doubtful),
            "notes": [*self.notes, *(one.removesuffix(".") for one in self.unnamed)],
        }  # fmt: skip


def in_turn(said: Sequence[str]) -> tuple[str, ...]:
    """Return sentences of causes, the later ones of what those before them left."""
    return (*said[:1], *(words.replace("The residual is ", "What is then left is ", 1) for words in said[1:]))
