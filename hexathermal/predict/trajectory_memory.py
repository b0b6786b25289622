"""A trajectory of a machine whose legs' laws remember: what remembers, and what is taken for granted of rows unseen."""

from __future__ import annotations

import numpy as np

from hexathermal.errors import KinematicsError, ThermalModelError
from hexathermal.machine.hexapod import Hexapod
from hexathermal.machine.leg_terms import BY_MOTION
from hexathermal.poses import FloatArray
from hexathermal.predict.leg_states import LegControllers
from hexathermal.predict.pairing import Piece, Temperatures
from hexathermal.predict.table_streams import Rows, TableStream
from hexathermal.predict.temperatures import active_model


class Motion:
    """Poses as one motion that the legs' laws remember; the platform stands at each pose until the next.

    Attributes
    ----------
    states : LegControllers
    unmet : int
        Rows of temperatures, before the first pose or between poses, that the laws have read while the platform stood.
    """

    def __init__(self, hexapod: Hexapod) -> None:
        self.states, self.unmet = LegControllers(hexapod), 0
        self._early: list[tuple[FloatArray, FloatArray]] | None = []  # None once a pose was told

    def corrected(self, T: FloatArray, rows: Rows, followed: Temperatures) -> tuple[FloatArray, FloatArray | None]:
        """Return corrected lengths (n, 6) and times of the next poses (n, 4, 4), between which temperatures go on."""
        lengths, times = list[FloatArray](), list[FloatArray]()
        for piece in followed.pieces(rows, unmet=True):
            self.unmet += len(piece.between[0])
            if piece.first < piece.last:
                time = piece.time if rows.time is None else rows.time[piece.first : piece.last]
                assert time is not None  # `motion_of` has asked for it
                lengths.append(self._told(T[piece.first : piece.last], piece, time))
                times.append(time)
            elif self._early is not None:
                self._early.append(piece.between)  # the legs stand as the first pose will tell them
            elif len(piece.between[0]):
                self.states.stay(piece.between[1], piece.between[0])
        return np.concatenate(lengths), np.concatenate(times)

    def _told(self, T: FloatArray, piece: Piece, time: FloatArray) -> FloatArray:
        """Return corrected lengths of a piece; an error has the row among all."""
        early = [*(self._early or ()), piece.between]
        between = np.concatenate([one[0] for one in early]), np.concatenate([one[1] for one in early])
        try:
            found = self.states.corrected_leg_lengths(T, piece.numbers, time, between=between)
        except KinematicsError as error:
            error.index = (error.index[0] + piece.first, *error.index[1:])
            raise
        self._early = None
        return found

    @property
    def words(self) -> str:
        """What the rows are that no pose meets, in words."""
        if not self.unmet:
            return ""
        rows = "1 row of temperatures" if self.unmet == 1 else f"{self.unmet} rows of temperatures"
        return f"; {rows} before and between poses, while the platform stands at each pose until the next"


def motion_of(hexapod: Hexapod, poses: TableStream, temps: TableStream) -> Motion | None:
    """Return what remembers the rows before; None where the legs' laws need none."""
    states = active_model(hexapod).states
    if not states:
        return None
    recorded = sorted({str(term.parameters.get("source", "motion")) for term in states} - {"motion"})
    if recorded:
        raise ThermalModelError(
            f"the legs' law reads the recorded input {recorded[0]!r}, which a trajectory does not have; use "
            "hexapod.leg_controllers() with inputs, or take the term out of the machine's file"
        )
    if not (poses.header.has_time or temps.header.has_time):
        raise _no_times(hexapod, poses)
    return Motion(hexapod)


def _no_times(hexapod: Hexapod, poses: TableStream) -> ThermalModelError:
    """Return the error of a motion whose times nobody states."""
    causes = ", ".join(dict.fromkeys(term.cause for term in active_model(hexapod).states))
    return ThermalModelError(
        f"the legs' law holds {causes}, which depends on what was before: add time_s [s] to {poses.path}, rows in the "
        "order of the motion"
    )


def memory_warnings(hexapod: Hexapod, poses: TableStream, temps: TableStream, one_row: bool) -> tuple[str, ...]:
    """Return what is taken for granted where the law remembers; refuse times that cannot be those of the poses."""
    states = active_model(hexapod).states
    causes = ", ".join(dict.fromkeys(term.cause for term in states))
    if not poses.header.has_time:
        if one_row:
            raise _no_times(hexapod, poses)
        return (
            f"{poses.path} has no time_s, and the legs' law holds {causes}, which depends on what was before: row k is "
            f"taken to be at time_s of row k of {temps.path}; add time_s to the poses where that is not so",
        )
    follows = _following(hexapod)
    if one_row and follows:
        return (
            f"{temps.path} has one row: temperatures that never change leave {follows} at 0; give "
            "temperatures as they change along the motion",
        )
    return ()


def _following(hexapod: Hexapod) -> str:
    """Return the causes of the law's terms that remember temperatures, in words; empty where none does."""
    states = active_model(hexapod).states
    return ", ".join(
        dict.fromkeys(term.cause for term in states if "sensor" in term.parameters and term.shape != BY_MOTION)
    )
