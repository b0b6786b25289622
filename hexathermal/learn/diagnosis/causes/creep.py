"""The leg relaxes after each move."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from hexathermal.learn.diagnosis.trials import Cause, Parameter, Trial, Workbench
from hexathermal.learn.diagnosis.view import View
from hexathermal.machine.leg_signals import Memory
from hexathermal.poses import FloatArray

CAUSE = Cause(
    name="creep",
    physics="Friction, grease or glued joints give way for seconds to minutes after the rod has stopped; what was "
    "clamped, glued or loaded for a run gives way for hours.",
    signature="A decay after each move, towards the same end or with its direction; or one from the beginning of each "
    "run on, alike in all.",
    parameters=(
        Parameter("time_constant_s", "s", "log-uniform, 20 s to 75 min; from the beginning of runs to 150 min"),
        Parameter("decades", "1", "0: one exponential; 1.5 or 3: relaxation times over so many decades"),
        Parameter("saturation_m", "m", "none, 4 or 15 mm: shorter moves kick in part, where their lengths differ"),
        Parameter("renewed", "1", "0: what moves leave adds up; 1: each wipes out what earlier ones left"),
        Parameter("kick", "m", "visible effect of 0.25 to 4 times the noise"),
    ),
    confused_with=(
        "backlash",
        "hidden-heat",
        "zero-drift",
        "frame-expansion",
    ),
    experiment="One move, then half an hour of rest, ten times, without warming.",
    words="the leg relaxes after each move",
    thermal=True,
    readings=20,
)

TIMES_S = (20.0, 30.0, 45.0, 67.0, 100.0, 150.0, 220.0, 480.0, 1000.0, 2000.0, 4400.0)
"""Close together up to the first windows of a landing: there a step some time after each stop has a like shape."""

BROAD = {1.5: (10.0, 30.0, 100.0, 300.0), 3.0: (20.0, 80.0, 320.0)}
"""Decades of a broad relaxation, and the shortest times in it: glue and friction creep with the logarithm of time."""

BEGUN = {
    0.0: (300.0, 1000.0, 1700.0, 3000.0, 5200.0, 9000.0),
    1.5: (120.0, 300.0, 800.0, 2000.0),
    3.0: (20.0, 60.0, 200.0),
}
"""The same from the beginning of a run on; what takes longer than a run is a drift with time."""

FEWEST_BEGUN = 4
"""In fewer runs a slow noise may go alike from all beginnings."""

SATURATIONS_M, LEAST_TOLD = (0.004, 0.015), 0.15
"""Ways in which a kick becomes whole, where the sizes of moves differ by so much of their mean."""

LONGEST_SIGNED_S = 20_000.0
"""What follows the sign of moves and stays for longer is hardly creep: it goes as positions and reversals do."""

LONGEST_RENEWED_S = 1500.0
"""What each move renews in its direction, and stays for longer, is backlash."""

ALIKE = 0.8
"""Correlation with decays after every move alike, from which on a decay with the direction is no other shape."""


def trials(bench: Workbench) -> Iterator[Trial]:
    """Give decays after moves, with and without their direction, and with their length; and from each beginning on.

    Heat of motion, which a thermometer may read wrong, follows every move alike: it knows no direction.
    """
    yield from _from_the_beginning(bench)
    if bench.view.moves:
        single: list[dict[str, Any]] = [{"time_constant_s": tau} for tau in TIMES_S]
        broad = [{"time_constant_s": tau, "decades": decades} for decades, times in BROAD.items() for tau in times]
        short = _saturations(bench.view)
        for times in single + broad:
            alike = bench.term(CAUSE.name, "relaxation", None, kick="move", **times)
            yield alike
            longest = times["time_constant_s"] * 10.0 ** times.get("decades", 0.0)
            kicks: list[dict[str, Any]] = [{"kick": "direction"}, {"kick": "step"}]
            kicks += [{"kick": kick, "saturation_m": full} for full in short for kick in ("move", "direction")]
            kicks.append({"kick": "move", "renewed": 1.0})
            if longest < LONGEST_RENEWED_S:
                kicks.append({"kick": "direction", "renewed": 1.0})
            kicks = [kick for kick in kicks if kick["kick"] == "move" or longest <= LONGEST_SIGNED_S]
            for kick in kicks:
                trial = bench.term(CAUSE.name, "relaxation", None, **kick, **times)
                unlike = kick["kick"] != "move" and _apart(trial.columns[:, 0], alike.columns[:, 0])
                yield replace(trial, unfeigned=unlike)


def _from_the_beginning(bench: Workbench) -> Iterator[Trial]:
    """Give decays from the beginning of each run on, alike in all; parts that never move warm so when they begin."""
    if not begins_anew(bench.view):
        return
    for decades, times in BEGUN.items():
        for tau in times:
            own: dict[str, Any] = {"time_constant_s": tau, "kick": "begin"}
            own |= {"decades": decades} if decades else {}
            yield bench.term(CAUSE.name, "relaxation", None, **own)


def begins_anew(view: View) -> bool:
    """Return whether what gives way from the beginning of each run on may be told; what never moves is not clamped."""
    return (view.kind == "leg" or view.moves) and often_begun(view)


def often_begun(view: View) -> bool:
    """Return whether enough runs begin anew to tell what goes alike from the beginning of each."""
    return view.goes_on.count(False) >= FEWEST_BEGUN


def _saturations(view: View) -> list[float]:
    """Return ways in which a kick becomes whole [m] that moves of this campaign tell from each other."""
    ways = [np.abs(Memory().lengths(signals.q)) for signals in view.signals]
    ends = np.concatenate([way[np.diff(way, append=0.0) < 0.0] for way in ways])
    if not len(ends):
        return []
    told = {full: -np.expm1(-ends / full) for full in SATURATIONS_M}
    return [full for full, sizes in told.items() if sizes.std() > LEAST_TOLD * sizes.mean()]


def _apart(one: FloatArray, other: FloatArray) -> bool:
    """Return whether two columns are clearly not the same: a rod that moves one way only has one direction."""
    size = float(np.sqrt((one @ one) * (other @ other)))
    return bool(abs(one @ other) < ALIKE * size)
