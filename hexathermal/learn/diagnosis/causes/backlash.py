"""The rod stops elsewhere when it comes from the other side."""

from __future__ import annotations

from collections.abc import Iterator

from hexathermal.learn.diagnosis.trials import Cause, Parameter, Trial, Workbench

CAUSE = Cause(
    name="backlash",
    physics=(
        "Play between screw and nut, or friction in the guide: the position depends on the direction of the last move."
    ),
    signature="A step of constant size at each reversal, at any temperature.",
    parameters=(
        Parameter("approach", "1", "-1 to 1: how the first position of each run was reached"),
        Parameter("play_m", "m", "none, or 0.3 to 9 mm: the way in which a reversal becomes whole"),
        Parameter("step", "m", "visible effect of 0.25 to 4 times the noise"),
    ),
    confused_with=(
        "creep",
        "periodic-screw-error",
    ),
    experiment="Approach the same positions from both sides, twenty times, without warming.",
    words="the leg stops in another place when it comes from the other side",
    readings=40,
)

APPROACHES = (-1.0, -0.5, 0.5, 1.0)
"""Directions, or parts of the play, from which all runs may begin."""

PLAYS_M = (0.3e-3, 1e-3, 3e-3, 9e-3)
"""Ways of the rod in which a nut crosses its play, or preloads turn round."""


def trials(bench: Workbench) -> Iterator[Trial]:
    """Give the direction of the last move, from each way in which the runs' first positions may have been reached."""
    if bench.view.moves:
        yield bench.term(CAUSE.name, "direction", None)
        for approach in APPROACHES:
            yield bench.term(CAUSE.name, "direction", None, approach=approach)
        for play in PLAYS_M:
            for approach in (0.0, APPROACHES[0], APPROACHES[-1]):
                yield bench.term(CAUSE.name, "direction", None, approach=approach, play_m=play)
