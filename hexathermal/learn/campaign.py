"""A campaign: what `campaign.toml` says, and the rows of its runs, zeroed and ready to be used."""

from __future__ import annotations

import re
from collections.abc import Container, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from hexathermal.poses import FloatArray

KINDS = ("leg", "component", "hexapod")
ROLES = ("identification", "validation")
ZEROS = ("run", "campaign")
FILE = "campaign.toml"

ACCEPTED = ("missing-blocks", "clock-disorder", "unusual-weather")
"""Faults that `[cleaning] accept` of `campaign.toml` takes as they are; what is lost is left out and counted."""


AIR_COLUMN = "air_temperature_degC"
"""Column of the station's air temperature."""

AIR_PARTS = frozenset({"air", "ambient", "environment", "lab", "laboratory", "room", "surroundings", "workshop"})
"""Words for what a thermocouple hangs in: one stands for the station's air where no column records that."""

BESIDE_AIR = frozenset({"", "in", "of", "sensor", "t", "tc", "temp", "temperature", "the", "thermocouple"})
"""Words that may stand beside these; with others it is no room, as an air bearing or a cabinet of a control room."""


@dataclass(frozen=True)
class Thermocouple:
    """One thermocouple of a campaign.

    Parameters
    ----------
    name : str
        Its column is ``<name>_degC``.
    part : str
        Part it sits on, empty where the campaign does not say; see `hangs_in_air`.
    position : float or None [m]
        Along the leg from the lower joint's centre, rod retracted.
    """

    name: str
    part: str = ""
    position: float | None = None

    @property
    def hangs_in_air(self) -> bool:
        """Whether its part, or its name where none is stated, says that it hangs in the room's air.

        Examples
        --------
        >>> [Thermocouple("T01", part).hangs_in_air for part in ("room air", "Ambient", "air bearing", "")]
        [True, True, False, False]
        >>> [Thermocouple(name).hangs_in_air for name in ("T_room", "Tair", "roomTemp2", "T12")]
        [True, True, True, False]
        """
        apart = re.sub(r"([a-z])([A-Z])", r"\1 \2", self.part or self.name).lower()
        words = re.split(r"[^a-z]+", apart)
        hanging = [word in AIR_PARTS or word.removeprefix("t") in AIR_PARTS for word in words]
        return any(hanging) and all(air or word in BESIDE_AIR for air, word in zip(hanging, words, strict=True))


@dataclass(frozen=True)
class RecordedInput:
    """Any other recorded cause, as a spindle's speed; its column has its name."""

    name: str
    description: str = ""


@dataclass(frozen=True)
class LegDimensions:
    """Retracted inter-articular length and stroke of a leg on the bench [m]."""

    retracted_length: float
    stroke: tuple[float, float]


@dataclass(frozen=True)
class BeamLayout:
    """Where the three interferometer beams run.

    Parameters
    ----------
    radius : float [m]
        Distance of the beams from the leg's axis.
    azimuths : tuple of float [rad]
        Angles of the beams about the leg's axis, one for each.
    dead_path : float [m]
        Path between the zero of the interferometer and the target at the zero of the displacement.
    index_compensated : bool
        Whether the laser's electronics applied the index of air already.
    """

    radius: float
    azimuths: tuple[float, ...]
    dead_path: float
    index_compensated: bool


@dataclass(frozen=True)
class RunFile:
    """One run: its name, its table and its role; a run for validation is never fitted."""

    name: str
    path: Path
    role: str


@dataclass(frozen=True, eq=False)
class Campaign:
    """What `campaign.toml` says, checked; the tables stay on disk until they are read.

    Attributes
    ----------
    folder : Path
    kind : str
        ``"leg"``, ``"component"`` or ``"hexapod"``.
    title : str
    zero : str
        ``"run"``: temperatures and drift count from each run's own first row; ``"campaign"``: from the first row of the
        first run.
    runs : tuple of RunFile
    thermocouples : tuple of Thermocouple
    inputs : tuple of RecordedInput
    leg : LegDimensions or None
    beams : BeamLayout or None
    hexapod : Path or None
        Of kind ``"hexapod"``: the machine's `hexapod.toml`.
    columns : mapping of str to str
        Names of the format and the names that the logger gave them, where they differ.
    accepted : tuple of str
        Faults of the tables that the campaign takes as they are, see `ACCEPTED`.
    stated : tuple of str
        Columns of the format that stand among the campaign's inputs: its tables must have them.
    """

    folder: Path
    kind: str
    title: str
    zero: str
    runs: tuple[RunFile, ...]
    thermocouples: tuple[Thermocouple, ...]
    inputs: tuple[RecordedInput, ...] = ()
    leg: LegDimensions | None = None
    beams: BeamLayout | None = None
    hexapod: Path | None = None
    columns: Mapping[str, str] = field(default_factory=dict)
    accepted: tuple[str, ...] = ()
    stated: tuple[str, ...] = ()

    @property
    def file(self) -> Path:
        """The campaign's `campaign.toml`."""
        return self.folder / FILE

    @property
    def sensors(self) -> tuple[str, ...]:
        """Names of the thermocouples."""
        return tuple(item.name for item in self.thermocouples)

    @property
    def air_thermometer(self) -> str | None:
        """The first thermocouple that hangs in the room's air."""
        return next((item.name for item in self.thermocouples if item.hangs_in_air), None)

    def air_column(self, names: Container[str]) -> str | None:
        """Return the column of a table, of its names, that tells the air's temperature; None where none does."""
        hanging = None if self.air_thermometer is None else f"{self.air_thermometer}_degC"
        return next((name for name in (AIR_COLUMN, hanging) if name is not None and name in names), None)

    def runs_of(self, role: str) -> tuple[RunFile, ...]:
        """Return the runs of a role."""
        return tuple(run for run in self.runs if run.role == role)


@dataclass(frozen=True, eq=False)
class Block:
    """Consecutive rows of one run that may be used: settled, cleaned, zeroed. SI units.

    Attributes
    ----------
    run : RunFile
    time : array, shape (n,) [s]
        Since the run's first row.
    dT : array, shape (n, s) [K]
        Temperatures less those of the zero, one column a thermocouple; NaN in a channel that was rejected there.
    drift : array, shape (n,) [m]
        Measured drift since the zero.
    q : array, shape (n,) [m], or None
        Displacement of the rod (0: retracted), as read by the scale; None for a part without a stroke.
    landing : array, shape (n,), int
        Number of the rest between two moves that a row belongs to, from 0, increasing; the independent unit of scatter.
        A part without a stroke counts stretches between changes of its inputs.
    inputs : array, shape (n, k)
        Recorded inputs in the file's own units.
    air : array, shape (n, 3)
        Air temperature [degC], pressure [Pa] and relative humidity [1]; NaN where not recorded.
    """

    run: RunFile
    time: FloatArray
    dT: FloatArray
    drift: FloatArray
    q: FloatArray | None
    landing: npt.NDArray[np.int64]
    inputs: FloatArray
    air: FloatArray

    def __len__(self) -> int:
        return len(self.time)


def joined(blocks: list[Block]) -> Block:
    """Return blocks of one run as one."""
    first = blocks[0]

    def both(name: str) -> Any:
        parts = [getattr(block, name) for block in blocks]
        return None if parts[0] is None else np.concatenate(parts)

    names = ("time", "dT", "drift", "q", "landing", "inputs", "air")
    return Block(first.run, **{name: both(name) for name in names})
