"""What a budget is taken at: one machine, pose and temperatures, and the block of numbers that may be off there."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from hexathermal.errors import ArgumentError
from hexathermal.kinematics import layout as at
from hexathermal.kinematics.constants import LARGEST_CONDITION
from hexathermal.kinematics.inverse import inverse_kinematics
from hexathermal.kinematics.jacobian import condition_number
from hexathermal.kinematics.refusals import refuse_forward
from hexathermal.machine.hexapod import Hexapod
from hexathermal.machine.thermal import TemperaturesLike
from hexathermal.poses import FloatArray, Frames, PoseLike, finite_array, pose_array
from hexathermal.predict.budget_blocks import blocks, deviation_factors, deviation_size
from hexathermal.predict.budget_plates import Plates as Plates
from hexathermal.predict.budget_plates import plate_rows
from hexathermal.predict.budget_rates import Places, certain, pose_numbers
from hexathermal.predict.budget_view import View as View
from hexathermal.predict.budget_view import look
from hexathermal.predict.correction import corrected_leg_lengths, predicted_pose
from hexathermal.predict.leg_drift import between_reversals
from hexathermal.predict.sources import Source
from hexathermal.predict.temperatures import active_model, check_stated, check_temperatures, temperature_array


@dataclass(frozen=True, eq=False)
class Situation:
    """One machine at one pose and one set of temperatures, ready to be deviated from.

    Attributes
    ----------
    told : array, shape (6,) [m]
        Commanded lengths.
    dT, lag : array, shape (n,) [K]
        Reading minus reference, and minus the air, for each sensor.
    plates : array, shape (2, 8)
        Expansion [1/K], temperature [K] (0 where a sensor tells it), gradient [K/m] and the point that does not move
        [m] of platform and base.
    axes : array, shape (3, 3)
        Turns base axes into those of the budget's frame.
    arm : array, shape (3,) [m]
        The point of the budget, from the platform's origin, in platform axes.
    correction : bool
    frame : str
    """

    hexapod: Hexapod
    pose: FloatArray
    temps: FloatArray
    told: FloatArray
    dT: FloatArray
    lag: FloatArray
    plates: FloatArray
    axes: FloatArray
    arm: FloatArray
    correction: bool
    frame: str
    numbers: FloatArray = field(repr=False)

    @property
    def size(self) -> int:
        """How many numbers may be off."""
        return deviation_size(self.hexapod)

    def blocks(self, quantity: str) -> tuple[npt.NDArray[np.int64], int, int]:
        """Return where a quantity's numbers stand in a deviation, see `hexathermal.predict.budget_blocks.blocks`."""
        return blocks(self.hexapod, quantity)

    def factors(self, source: Source) -> tuple[FloatArray, bool]:
        """Return how the variables of a source move a deviation, see `deviation_factors`.

        The second value tells whether they count as one component.
        """
        return deviation_factors(self.hexapod, source), source.joint

    @property
    def places(self) -> Places:
        """The one place of a map that this is."""
        return Places(
            self.hexapod, self.pose[None], self.told[None], self.dT[None], self.lag[None], self.plates[None],
            self.axes[None], self.arm, self.numbers[None],
        )  # fmt: skip

    def errors(
        self, deviations: FloatArray | None = None, told: FloatArray | None = None, load: float = 1.0
    ) -> FloatArray:
        """Return exact errors (N, 6) of the point for many deviations (N, size); one row where there is none.

        `load` 0: the payload is not there.

        Raises
        ------
        NotConvergedError
            A deviation is too far off for the branch of the pose to be certain.
        """
        machines = self.places.machine(0, x=deviations, told=told)
        return certain(*self.places.solved(0, *machines, deviations, load), expected=deviations is None)

    def tried(self, deviations: FloatArray) -> tuple[FloatArray, npt.NDArray[np.bool_]]:
        """Return errors (N, 6) for many deviations (N, size), and which of them are certain."""
        return self.places.solved(0, *self.places.machine(0, x=deviations), deviations)

    def rates(self) -> FloatArray:
        """Return the derivatives (6, size + 6) of the error for each deviation, at the expected true pose."""
        return np.asarray(self.places.rates(self.errors(), self.places.machine(0)[1])[0])


def situation(
    hexapod: Hexapod,
    pose: PoseLike,
    temps: TemperaturesLike,
    *,
    correction: bool = True,
    frame: str = "machine",
    frames: Frames | None = None,
    at_tool: npt.ArrayLike | None = None,
    plates: Plates | None = None,
    air_degC: float | None = None,
) -> Situation:
    """Return the situation of a budget; parameters and errors as in `hexathermal.predict.budget.error_budget`."""
    hexapod = between_reversals(hexapod)
    model = active_model(hexapod)
    # copies: compiled loops are slow to start on arrays that must not be written
    wanted, readings = np.array(pose_array(pose)), np.array(temperature_array(hexapod, temps))
    if wanted.shape != (4, 4) or readings.ndim != 1:
        raise ArgumentError(
            f"a budget is taken at one pose and one set of temperatures, found shapes {wanted.shape} and "
            f"{readings.shape}; budget_map takes many"
        )
    check_temperatures(hexapod, readings)
    refuse_singular(hexapod, wanted)
    told = commanded(hexapod, wanted, readings, correction)
    reference = np.asarray(model.reference_temperature_degC)
    air = float(checked_air(hexapod, air_degC))
    seen = look(frame, frames, at_tool)
    axes = seen.axes(wanted)
    rows = plate_rows(hexapod, readings, plates or Plates())
    numbers = pose_numbers(hexapod, wanted[None], axes[None], seen.arm)[0]
    return Situation(
        hexapod, wanted, readings, told, readings - reference, readings - air, rows, axes, seen.arm, correction, frame,
        numbers,
    )  # fmt: skip


def commanded(hexapod: Hexapod, poses: FloatArray, temps: FloatArray, correction: bool) -> FloatArray:
    """Return the lengths (..., 6) that are commanded at poses (..., 4, 4); those that cannot be held are refused."""
    if correction:
        return corrected_leg_lengths(hexapod, poses, temps)
    told = inverse_kinematics(hexapod, poses)
    predicted_pose(hexapod, told, temps)
    return told


def checked_air(hexapod: Hexapod, given: npt.ArrayLike | None, shape: tuple[int, ...] = ()) -> FloatArray:
    """Return temperatures of the air [degC]; where none is given, the reference temperature."""
    if given is None:
        return np.full(shape, np.mean(active_model(hexapod).reference_temperature_degC))
    air = finite_array(given, shape, "air_degC" if shape == () else "each_air_degC")
    if air.shape != shape:
        raise ArgumentError(f"air_degC has shape {air.shape}; expected {'one temperature' if shape == () else shape}")
    for value in (air.min(), air.max()) if air.size else ():
        check_stated(hexapod, float(value), "air")
    return air


def refuse_singular(hexapod: Hexapod, pose: FloatArray) -> None:
    """Raise where leg lengths do not hold the platform."""
    if not condition_number(hexapod, pose) <= LARGEST_CONDITION:
        refuse_forward(hexapod, at.SINGULAR, pose, inverse_kinematics(hexapod, pose))
