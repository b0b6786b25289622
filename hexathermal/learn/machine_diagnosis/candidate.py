"""A candidate: a cause that sits on one place of a machine, as columns in the six leg lengths."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Protocol

from hexathermal.learn.diagnosis.trials import Cause
from hexathermal.poses import FloatArray

if TYPE_CHECKING:
    from hexathermal.learn.machine_diagnosis.view import MachineView


@dataclass(frozen=True, eq=False)
class Candidate:
    """A cause at one place, with what it adds to the six leg lengths for a unit of each of its parameters.

    Lengths are those of ``y = L(measured pose) - q0 - q - law`` (`hexathermal.learn.hexapod_model`): how much longer a
    leg looks to the nominal machine than its scale and its law say.

    Attributes
    ----------
    cause : str
        Name of the catalogue.
    target : str or None
        Where it sits: ``"leg3"``, ``"leg3+leg4"``, ``"platform"``, ``"base"``, ``"base joint 4"``, a thermometer.
    names, units : tuple of str
        Of the k parameters, in the core's units.
    columns : array, shape (n, 6, k) [m per unit]
    scale : array, shape (k,)
        Standard deviations of the parameters before anything is measured.
    mean : array, shape (k,)
        Their means before anything is measured: 0, but 1 for the share of an exchange, which is there wholly or not.
    settings : mapping
        What is set and not fitted: names of thermometers, time constants.
    leg_shape : str
        Shape of the term that would join the leg's law (`hexathermal.machine.leg_terms`); empty for others.
    trust : float
        Factor of the log evidence: 1, less for an exchange of legs that differ by little more than readings err.
    """

    cause: str
    target: str | None
    names: tuple[str, ...]
    units: tuple[str, ...]
    columns: FloatArray
    scale: FloatArray
    mean: FloatArray
    settings: Mapping[str, Any] = field(default_factory=dict)
    leg_shape: str = ""
    trust: float = 1.0

    @property
    def called(self) -> str:
        """Cause and target, which tell a candidate from others; settings may still differ."""
        return called(self.cause, self.target)

    @property
    def legs(self) -> tuple[int, ...]:
        """Legs 0 to 5 that it sits on; empty where it moves all."""
        return legs_of(self.target)


def called(cause: str, target: str | None) -> str:
    """Return a cause with its place, as candidates are called; a cause that names its place already is that alone.

    Examples
    --------
    >>> called("leg-coefficient", "leg3"), called("base-expansion", "base"), called("payload-compliance", None)
    ('leg-coefficient of leg3', 'base-expansion', 'payload-compliance')
    """
    return cause if target is None or cause.startswith(f"{target}-") else f"{cause} of {target}"


def legs_of(target: str | None) -> tuple[int, ...]:
    """Return the legs 0 to 5 that a place is on.

    Examples
    --------
    >>> legs_of("leg3+leg4"), legs_of("base joint 4"), legs_of("platform"), legs_of(None)
    ((2, 3), (3,), (), ())
    """
    if target is None:
        return ()
    if "joint" in target:
        return (int(target.rsplit(" ", 1)[1]) - 1,)
    parts = target.split("+")
    return tuple(int(part[3:]) - 1 for part in parts) if parts[0].startswith("leg") else ()


class MachineCauseModule(Protocol):
    """A file of the catalogue."""

    CAUSE: Cause

    def candidates(self, view: MachineView) -> list[Candidate]:
        """Give the cause at each place where these rows could show it."""
