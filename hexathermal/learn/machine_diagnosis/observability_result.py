"""What poses and temperatures of a machine can tell, as values: limits, separations, classes that look alike."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hexathermal.errors import ArgumentError
from hexathermal.learn.machine_diagnosis.candidate import called
from hexathermal.poses import FloatArray


@dataclass(frozen=True)
class DetectionLimit:
    """How large an effect must be to be named.

    Attributes
    ----------
    cause : str
    target : str or None
    strength : float
        RMS of the effect over the noise, over the six coordinates; infinite where the rows do not see it.
    translation, rotation : float [m], [rad]
        The same, RMS of each coordinate.
    parameters : dict of str to (float, str)
        Least value of each parameter, alone, and its unit.
    visible : float
        Part of the effect (RMS) that law and frames do not absorb, 0 to 1.
    """

    cause: str
    target: str | None
    strength: float
    translation: float
    rotation: float
    parameters: dict[str, tuple[float, str]]
    visible: float

    @property
    def name(self) -> str:
        """Cause and target in words."""
        return called(self.cause, self.target)

    @property
    def seen(self) -> bool:
        """Whether any effect, however large, would be named."""
        return bool(np.isfinite(self.strength))


@dataclass(frozen=True)
class Separation:
    """Two candidates, and the least log evidence by which the true one beats the other on average.

    `alike` is the correlation of what is visible of the two: with its sign of single columns, else the largest one.
    """

    first: str
    second: str
    evidence: float
    alike: float


@dataclass(frozen=True)
class AlikeClass:
    """Candidates that these rows cannot tell apart, and what of poses and temperatures explains it."""

    names: tuple[str, ...]
    causes: tuple[str, ...]
    reasons: tuple[str, ...]

    def __str__(self) -> str:
        return f"{', '.join(self.names)} look alike: {'; '.join(self.reasons) or 'their columns are nearly the same'}"


@dataclass(frozen=True, eq=False)
class MachineObservability:
    """What poses and temperatures of a machine can tell.

    Attributes
    ----------
    limits : tuple of DetectionLimit
        In the order of the candidates.
    absent : tuple of str
        Causes of the catalogue of which these rows could show nothing at any place.
    evidence : array, shape (c, c)
        Row true, column its rival: mean log evidence between them at twice the limit; NaN where the row is not seen.
    separations : tuple of Separation
        Of each two candidates that are seen, least first.
    classes : tuple of AlikeClass
        Of two candidates and more.
    hidden : tuple of str
        Of each cause that is not seen, everywhere or in some places, in words: where, and why.
    missing : tuple of str
        Recorded channels that candidates would need.
    circumstances : tuple of str
        What limits these rows: constant or equal temperatures, few poses.
    threshold, power, close : float
        What was asked for, see `machine_observability`.
    """

    limits: tuple[DetectionLimit, ...]
    absent: tuple[str, ...]
    evidence: FloatArray
    separations: tuple[Separation, ...]
    classes: tuple[AlikeClass, ...]
    hidden: tuple[str, ...]
    missing: tuple[str, ...]
    circumstances: tuple[str, ...]
    threshold: float
    power: float
    close: float

    @property
    def unseen(self) -> tuple[str, ...]:
        """Causes, and candidates, that these rows do not see at all."""
        return (*self.absent, *(limit.name for limit in self.limits if not limit.seen))

    @property
    def words(self) -> tuple[str, ...]:
        """What is to be said: what is not seen, what looks alike, what is missing."""
        return (*(str(one) for one in self.classes), *self.hidden, *self.missing)

    def limit(self, cause: str, target: str | None = None) -> DetectionLimit:
        """Return the limit of a candidate."""
        for one in self.limits:
            if (one.cause, one.target) == (cause, target):
                return one
        names = ", ".join(one.name for one in self.limits)
        asked = called(cause, target)
        raise ArgumentError(f"{asked} was not among the candidates: {names}")

    def equivalents(self, cause: str, target: str | None = None) -> tuple[str, ...]:
        """Return the names of candidates that explain one, when it is true, as well as itself: within `close`."""
        i = self.limits.index(self.limit(cause, target))
        near = np.flatnonzero(self.evidence[i] < self.close)
        return tuple(self.limits[j].name for j in near if j != i)
