"""A trajectory of a machine whose legs' laws remember: what remembers, and what is taken for granted of rows unseen."""

from __future__ import annotations

from hexathermal.errors import ThermalModelError
from hexathermal.machine.hexapod import Hexapod
from hexathermal.machine.leg_terms import BY_MOTION
from hexathermal.predict.leg_states import LegControllers
from hexathermal.predict.table_streams import TableStream
from hexathermal.predict.temperatures import active_model


def states_of(hexapod: Hexapod, poses: TableStream, temps: TableStream) -> LegControllers | None:
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
    return LegControllers(hexapod)


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


def unseen_warnings(hexapod: Hexapod, unseen: int) -> tuple[str, ...]:
    """Return how many rows of temperatures no pose has met, of a law that remembers temperatures."""
    follows = _following(hexapod)
    if not unseen or not follows:
        return ()
    rows = "1 row of temperatures" if unseen == 1 else f"{unseen} rows of temperatures"
    return (
        f"no pose meets {rows}, before the first pose or between two poses, and the legs' law holds {follows}, which "
        "depends on what was before: the legs are taken to be at rest at the first pose and to warm evenly from one "
        "to the next; give a pose for each row of temperatures, also while the platform stands",
    )


def _following(hexapod: Hexapod) -> str:
    """Return the causes of the law's terms that remember temperatures, in words; empty where none does."""
    states = active_model(hexapod).states
    return ", ".join(
        dict.fromkeys(term.cause for term in states if "sensor" in term.parameters and term.shape != BY_MOTION)
    )
