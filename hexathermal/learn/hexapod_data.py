"""The rows of a hexapod campaign that may be used: poses commanded and measured, displacements, temperatures.

Temperatures count from the zero of the campaign (its first row, or each run's); measured poses are absolute, in the
machine's frame. A row is left out, counted and said, where a number is missing or a logger's missing code, where it is
not settled, or where the positioning system missed (`hexathermal.learn.hexapod_identification`). Nothing is repaired.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from hexathermal.errors import ArgumentError, DataError, UnknownNameError
from hexathermal.learn.campaign import Campaign, RunFile
from hexathermal.learn.campaign_dataset import read_run
from hexathermal.learn.cleaning_rules import CODE_RULE, codes_in
from hexathermal.learn.row_fingerprints import RowFingerprints
from hexathermal.machine.files import read_hexapod
from hexathermal.machine.hexapod import Hexapod
from hexathermal.machine.thermal import frozen
from hexathermal.machine.thermometers import AS_RECORDED
from hexathermal.poses import FloatArray, pose_from_coordinates

if TYPE_CHECKING:
    import xarray as xr

AXES = ("x", "y", "z", "rx", "ry", "rz")
PLATES = ("platform", "base")
AIR = "air_temperature"


@dataclass(frozen=True, eq=False)
class HexapodRows:
    """Usable rows of some runs of a hexapod campaign; n rows, s thermometers a leg. SI units.

    Attributes
    ----------
    hexapod : Hexapod
    sensors : tuple of str
        Names of the thermometers that every leg has, without ``leg1_``.
    plate_sensors : tuple of (str or None, str or None)
        Names of the platform's and the base's thermometer.
    runs : tuple of str
    run : array, shape (n,), int
        Which of the runs a row belongs to.
    time : array, shape (n,) [s]
        Since the run's first row.
    commanded, measured : array, shape (n, 4, 4) [m]
    q : array, shape (n, 6) [m]
        Displacements of the rods by their scales.
    dT : array, shape (n, 6, s) [K]
        As recorded of the legs, from the zero; see `heat`.
    plates : array, shape (n, 2) [K]
        Of platform and base; NaN where not recorded.
    zero_degC, plates_zero_degC : array, shape (6, s), (2,) [degC]
        Temperatures of the zero as recorded, mean over the runs.
    left_out : dict of str to int
        Reasons and numbers of rows.
    fingerprints : dict of str to str
        Of the rows of each run, see `hexathermal.learn.row_fingerprints`.
    air : array, shape (n,) [K], optional
        Of the air, from the zero; NaN in rows without a value; None where it is not recorded.
    """

    hexapod: Hexapod
    sensors: tuple[str, ...]
    plate_sensors: tuple[str | None, str | None]
    runs: tuple[str, ...]
    run: npt.NDArray[np.int64]
    time: FloatArray
    commanded: FloatArray
    measured: FloatArray
    q: FloatArray
    dT: FloatArray
    plates: FloatArray
    zero_degC: FloatArray
    plates_zero_degC: FloatArray
    left_out: dict[str, int] = field(default_factory=dict)
    fingerprints: dict[str, str] = field(default_factory=dict)
    air: FloatArray | None = None

    def __len__(self) -> int:
        return len(self.time)

    @property
    def retracted(self) -> FloatArray:
        """Inter-articular lengths at q = 0, shape (6,) [m]."""
        return _retracted(self.hexapod)

    @property
    def heat(self) -> FloatArray:
        """Temperatures that tell each leg, shape (n, 6, s) [K]: `dT` with exchanged thermometers put right."""
        return heat_of_legs(self.hexapod, self.dT)

    @property
    def recorded_plates(self) -> tuple[bool, bool]:
        """Whether platform and base have a thermometer."""
        return self.plate_sensors[0] is not None, self.plate_sensors[1] is not None

    def rows(self, keep: npt.NDArray[np.bool_]) -> HexapodRows:
        """Return some of the rows."""
        names = ("run", "time", "commanded", "measured", "q", "dT", "plates")
        air = None if self.air is None else self.air[keep]
        return replace(self, air=air, **{name: getattr(self, name)[keep] for name in names})


def heat_of_legs(hexapod: Hexapod, recorded: FloatArray) -> FloatArray:
    """Return temperatures by the legs that they tell, from those by the legs under which they are recorded.

    Parameters
    ----------
    hexapod : Hexapod
    recorded : array, shape (..., 6, s)

    Examples
    --------
    >>> import dataclasses
    >>> import hexathermal as ht
    >>> hexapod = ht.load_hexapod("reference")
    >>> model = dataclasses.replace(hexapod.thermal, thermometers_of_leg=[1, 2, 4, 3, 5, 6])
    >>> heat_of_legs(dataclasses.replace(hexapod, thermal=model), np.arange(6.0)[:, None])[:, 0].tolist()
    [0.0, 1.0, 3.0, 2.0, 4.0, 5.0]
    """
    if hexapod.thermal is None or hexapod.thermal.thermometers_of_leg == AS_RECORDED:
        return recorded
    return np.asarray(recorded[..., [own - 1 for own in hexapod.thermal.thermometers_of_leg], :])


def _retracted(hexapod: Hexapod) -> FloatArray:
    """Return q0, or refuse a machine that has none."""
    if hexapod.retracted_length is None:
        raise ArgumentError(f"machine {hexapod.name!r} has no q0_mm in its hexapod.toml: a law needs it (A q0 dT)")
    return hexapod.retracted_length


def hexapod_rows(
    campaign: Campaign, role: str, *, hexapod: Hexapod | None = None, sensors: Sequence[str] | None = None
) -> HexapodRows:
    """Return the usable rows of all runs of a role.

    Parameters
    ----------
    campaign : Campaign
        Of kind ``"hexapod"``.
    role : str
    hexapod : Hexapod, optional
        Default: the campaign's own.
    sensors : sequence of str, optional
        Thermometers of each leg, without ``leg1_``. Default: all that every leg has.

    Raises
    ------
    ArgumentError
        The campaign is of another kind.
    DataError
        The campaign has no run of the role, no thermometer that all legs share, or no usable row.
    UnknownNameError
        A leg lacks one of the sensors; `available` lists those recorded.
    """
    if campaign.kind != "hexapod" or campaign.hexapod is None:
        raise ArgumentError(f"a campaign of kind {campaign.kind!r} measures no poses; expected kind 'hexapod'")
    machine = read_hexapod(campaign.hexapod) if hexapod is None else hexapod
    _retracted(machine)
    names = leg_sensors(campaign, sensors)
    plates = (_plate_sensor(campaign, machine, "platform"), _plate_sensor(campaign, machine, "base"))
    found: list[dict[str, Any]] = []
    left_out: dict[str, int] = {}
    marks = RowFingerprints()
    runs = campaign.runs_of(role)
    if not runs:
        raise DataError(f"there is no {role} run in the campaign: give a run role = {role!r} in campaign.toml")
    first = None
    if campaign.zero == "campaign":
        first = _zero(_table(campaign, campaign.runs[0], names, plates, machine, {}, RowFingerprints()))
    for k, run in enumerate(runs):
        table = _table(campaign, run, names, plates, machine, left_out, marks)
        if not len(table["time"]):
            continue
        zero = _zero(table) if first is None else first
        table |= {"run": np.full(len(table["time"]), k), "zero": zero[0], "plates_zero": zero[1], "air_zero": zero[2]}
        found.append(table)
    if not found:
        raise DataError(f"{campaign.file}: no row of the {role} runs can be used: {_said(left_out)}")
    whole = {name: np.concatenate([table[name] for table in found]) for name in ("run", "time", "six", "seen", "q")}
    heat, plate, air = (np.concatenate([table[name] - table[zero] for table in found]) for name, zero in
                        (("heat", "zero"), ("plates", "plates_zero"), ("air", "air_zero")))  # fmt: skip
    return HexapodRows(
        machine, names, plates, tuple(run.name for run in runs), whole["run"], frozen(whole["time"]),
        frozen(pose_from_coordinates(whole["six"], hexapod=machine)),
        frozen(pose_from_coordinates(whole["seen"], hexapod=machine)), frozen(whole["q"]), frozen(heat), frozen(plate),
        frozen(np.mean([table["zero"] for table in found], axis=0)),
        frozen(np.mean([table["plates_zero"] for table in found], axis=0)), left_out, marks.made(),
        frozen(air) if np.isfinite(air).any() else None,
    )  # fmt: skip


def _said(left_out: dict[str, int]) -> str:
    """Return reasons and counts as text."""
    return "; ".join(f"{count} rows: {reason}" for reason, count in left_out.items()) or "there are no rows"


def leg_sensors(campaign: Campaign, wanted: Sequence[str] | None = None) -> tuple[str, ...]:
    """Return the thermometers that all six legs have, or those wanted, without ``leg1_``."""
    each = [[name.removeprefix(f"leg{leg}_") for name in campaign.sensors if name.startswith(f"leg{leg}_")]
            for leg in range(1, 7)]  # fmt: skip
    common = tuple(name for name in each[0] if all(name in own for own in each))
    if wanted is not None:
        for name in wanted:
            if wanted.count(name) > 1:
                raise ArgumentError(f"sensor {name!r} is named twice; a law reads each of its thermometers once")
            if name not in common:
                raise UnknownNameError(
                    f"not every leg has a thermometer {name!r} (columns leg1_{name}_degC to leg6_{name}_degC); all "
                    f"legs have: {', '.join(common) or 'none in common'}",
                    common,
                )
        return tuple(wanted)
    if not common:
        raise DataError(
            f"{campaign.file}: no thermometer is on all six legs: a law needs columns as leg1_T1_degC to leg6_T1_degC; "
            f"the tables have {', '.join(campaign.sensors) or 'none'}"
        )
    return common


def _plate_sensor(campaign: Campaign, hexapod: Hexapod, part: str) -> str | None:
    """Return the name of a plate's thermometer: the machine's own where it is recorded, else the first."""
    own = [name.removeprefix(f"{part}_") for name in campaign.sensors if name.startswith(f"{part}_")]
    law = None if hexapod.thermal is None else getattr(hexapod.thermal, part)
    if law is not None and law.sensor is not None and law.sensor.removeprefix(f"{part}_") in own:
        return str(law.sensor)
    return own[0] if own else None


def _table(
    campaign: Campaign,
    run: RunFile,
    sensors: tuple[str, ...],
    plates: tuple[str | None, str | None],
    machine: Hexapod,
    left_out: dict[str, int],
    marks: RowFingerprints,
) -> dict[str, Any]:
    """Return the usable rows of a run as it stands in its table; counts what is left out, adds its fingerprint.

    Where the machine's measuring frame follows the air, rows need its temperature, if it is recorded at all.
    """
    data = read_run(campaign, run)
    names = list(campaign.sensors)
    heat = data["temperature"].values
    time = data["time"].values
    six, seen = (
        np.column_stack([data[prefix + axis].values for axis in AXES]) * ([1e3] * 3 + [180.0 / np.pi] * 3)
        for prefix in ("", "measured_")
    )
    own = np.stack([
        heat[:, [names.index(f"leg{leg}_{sensor}") for sensor in sensors]] for leg in range(1, 7)
    ], axis=1)  # fmt: skip
    plate = np.full((len(time), 2), np.nan)
    for k, (part, sensor) in enumerate(zip(PLATES, plates, strict=True)):
        if sensor is not None:
            plate[:, k] = heat[:, names.index(f"{part}_{sensor.removeprefix(part + '_')}")]
    good = np.ones(len(time), dtype=bool)
    known = np.array([sensor is not None for sensor in plates])
    no_reading = codes_in(own, True).any(axis=(1, 2)) | codes_in(plate, True).any(axis=1)
    own, plate = (np.where(codes_in(part, True), np.nan, part) for part in (own, plate))
    marks.add_poses(run.name, time, data["leg_q"].values, seen * ([1e-3] * 3 + [np.pi / 180.0] * 3))
    air = data[AIR].values if AIR in data else np.full(len(time), np.nan)
    air = np.where(codes_in(air[:, None], True)[:, 0], np.nan, air)
    follows = None if machine.measuring_frame is None else machine.measuring_frame.sensor
    airless = ~np.isfinite(air) if follows == AIR and np.isfinite(air).any() else ~good
    reasons = (
        ("not settled", data["settled"].values != 1.0 if "settled" in data else ~good),
        ("the measured pose is missing", ~np.isfinite(seen).all(axis=1)),
        ("the measured pose is a logger's missing code", coded(data, "measured_")),
        (f"a thermometer reads {CODE_RULE}", no_reading),
        ("a thermometer gave no value",
         ~(np.isfinite(own).all(axis=(1, 2)) & np.isfinite(plate[:, known]).all(axis=1))),
        ("the air, which the measuring frame follows, has no temperature", airless),
        ("time, commanded pose or a displacement is missing",
         ~(np.isfinite(six).all(axis=1) & np.isfinite(data["leg_q"].values).all(axis=1) & np.isfinite(time))),
        ("commanded pose or a displacement is a logger's missing code", coded(data, "") | coded(data, "leg")),
    )  # fmt: skip
    for reason, bad in reasons:
        count = int((good & bad).sum())
        if count:
            left_out[reason] = left_out.get(reason, 0) + count
        good &= ~bad
    told = np.flatnonzero(np.isfinite(own).all(axis=(1, 2)) & np.isfinite(plate[:, known]).all(axis=1))
    read = np.flatnonzero(np.isfinite(air))
    first = None if not told.size else (own[told[0]], plate[told[0]], air[read[0]] if read.size else np.nan)
    begun = float(np.nanmin(time)) if np.isfinite(time).any() else 0.0
    return {"time": time[good] - begun, "six": six[good], "seen": seen[good], "q": data["leg_q"].values[good],
            "heat": own[good], "plates": plate[good], "air": air[good], "first": first}  # fmt: skip


def coded(data: xr.Dataset, which: str) -> npt.NDArray[np.bool_]:
    """Return in which rows of a run a number is a logger's missing code, shape (n,), before units: 9999 mm, -9999 deg.

    Parameters
    ----------
    data : xarray.Dataset
        As `hexathermal.learn.campaign_dataset.read_run` gives it.
    which : str
        ``"measured_"`` or ``""``: coordinates of the measured or commanded pose; ``"leg"``: displacements.
    """
    if which == "leg":
        return np.asarray(codes_in(data["leg_q"].values * 1e3, False).any(axis=1))
    six = [data[which + axis].values * (1e3 if k < 3 else 180.0 / np.pi) for k, axis in enumerate(AXES)]
    return np.asarray(codes_in(np.column_stack(six), False).any(axis=1))


def _zero(table: dict[str, Any]) -> tuple[FloatArray, FloatArray, float]:
    """Return the temperatures of legs, plates and air that a run counts from: those of its first row that has them all.

    The air has its own first row.

    Whether the pose of that row can be used does not matter: temperatures alone count from a zero.
    """
    first: tuple[FloatArray, FloatArray, float] | None = table["first"]
    if first is None:
        raise DataError("the run that temperatures count from has no row with all of them; set zero in campaign.toml")
    return first
