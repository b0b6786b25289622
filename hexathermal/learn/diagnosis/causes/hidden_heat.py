"""Stored heat of motion, or of a recorded input, that no thermometer sees."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from itertools import product
from typing import Any

import numpy as np

from hexathermal.learn.cleaning_stuck import stretches
from hexathermal.learn.diagnosis.trials import Cause, Parameter, Trial, Workbench
from hexathermal.learn.diagnosis.view import View
from hexathermal.machine.leg_signals import Memory

CAUSE = Cause(
    name="hidden-heat",
    physics=(
        "Friction or a motor warms a piece of the part that has no thermometer; it stores the heat and gives it away."
    ),
    signature=(
        "The residual follows past motion (or the input) behind a low pass of minutes to hours, and no thermometer."
    ),
    parameters=(
        Parameter("time_constant_s", "s", "log-uniform, 2 min to 4 h"),
        Parameter("source_time_constant_s", "s", "none, or a sixth of it: what is rubbed warms first"),
        Parameter("source_share", "1", "none, or 0.4: the part of what is rubbed itself"),
        Parameter("amplitude", "m per unit of the source", "visible effect of 0.25 to 4 times the noise"),
    ),
    confused_with=(
        "missing-sensor",
        "thermal-lag",
        "creep",
    ),
    experiment="Work for an hour, rest for two, twice, with one more thermometer near its source: nut, motor, spindle.",
    words="heat of {target} is stored where no thermometer sees it",
    thermal=True,
    readings=12,
)

TIMES_S = (120.0, 240.0, 480.0, 960.0, 1920.0, 3840.0, 7680.0, 15360.0)

KEPT_S = (1920.0, 3840.0, 7680.0)
"""Of these heat of an hour before a run may still be there, which its rows do not tell."""

STAGES, OWN_SHARE = 6.0, 0.4
"""How much sooner what is rubbed warms than what expands, and the part of the expansion that may be its own."""

STRETCH, WORKING = 3, 0.4
"""Rows in which the rod moves without a rest, and the least part of all that it moves in which stand in such stretches,
for the time that it moves to be told from the number of moves, after each of which it may creep."""

LASTING = 6
"""So many of the times are tried for heat as long as motion lasts, which in a run of hours is hardly told from more."""


def trials(bench: Workbench) -> Iterator[Trial]:
    """Give heat of motion and of each input behind low passes, acting on the part as a whole or with its length.

    That of motion may warm the screw alone, behind the nut: it acts on what is out of it. A motor that turns warms at
    any speed, and strokes back and forth between two rows leave no way to tell: heat may last as long as motion does.
    """
    view = bench.view
    lengths: tuple[dict[str, Any], ...] = ({},) if not view.stroked else ({}, {"ratio": bench.ratios[bench.main]})
    sources = [("motion", 1), ("motion", 2)] if view.moves else []
    sources += [("motion", 0)] if view.moves and view.once((CAUSE.name, "works"), partial(_works, view), ()) else []
    sources += [(name, power) for name in view.runs[0].signals.inputs for power in (1, 2)]
    for source, power in sources:
        by_way = source == "motion" and power > 0
        for tau in TIMES_S if power else TIMES_S[:LASTING]:
            if view.stroked and by_way:
                yield bench.term(CAUSE.name, "stored-heat", source, source=source, time_constant_s=tau, power=power,
                                 ratio=bench.along_screw)  # fmt: skip
            rubbed = {"source_time_constant_s": tau / STAGES}
            stages: list[dict[str, Any]] = [{}, rubbed]
            if by_way:
                stages.append({**rubbed, "source_share": OWN_SHARE})
            for first, length in product(stages, lengths):
                trial = bench.term(CAUSE.name, "stored-heat", source, source=source, time_constant_s=tau, power=power,
                                   **first, **length)  # fmt: skip
                yield trial
                if tau in KEPT_S and (source, power) == sources[0] and not first and not length:
                    yield bench.not_at_rest(trial, tau)


def _works(view: View) -> bool:
    """Return whether motion often lasts for some rows without a rest."""
    moving = [(Memory().moves(signals.q) != 0.0).astype(np.float64) for signals in view.signals]
    lasts = np.concatenate([stretches(one)[1::2] for one in moving])  # the first row of a run rests
    long = int(lasts[lasts >= STRETCH].sum())
    return long > 0 and long >= WORKING * int(lasts.sum())
