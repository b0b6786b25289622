"""Single landings far from all others: what happened at one stop is no cause, but a reader wants to know of it."""

from __future__ import annotations

import numpy as np

from hexathermal.learn.diagnosis.stage import Stage

FAR = 8.0
"""Standard deviations of landings, from the median of absolute deviations, beyond which one stands off by itself."""

FEWEST = 20
"""Landings that tell how landings scatter."""

MOST_FAR = 0.02
"""Part of the landings that may stand off, and one in any case: of more the scatter has heavy tails."""

MOST_TOLD = 3


def far_landings(stage: Stage) -> list[str]:
    """Return which landings of a stage with all that joined stand off, largest first; nothing where many do.

    A landing's residual is the mean of its windows, less the median of its run; robust deviations as in Rousseeuw and
    Croux, J. American Statistical Association 88 (1993) 1273.
    """
    channel, view = stage.channel, stage.view
    if not channel.has_landings:
        return []
    landing = np.cumsum(channel.fresh) - 1
    rows = np.bincount(landing, channel.rows)
    firsts = np.flatnonzero(channel.fresh)
    run = channel.run[firsts]
    mean = np.bincount(landing, channel.rows * stage.left) / rows
    for k in np.unique(run):
        mean[run == k] -= np.median(mean[run == k])
    spread = float(np.median(np.abs(mean)) / 0.6745)
    far = np.flatnonzero(np.abs(mean) > FAR * max(spread, stage.levels.landing))
    if len(mean) < FEWEST or not 0 < len(far) <= max(1.0, MOST_FAR * len(mean)):
        return []
    said = []
    for one in far[np.argsort(-np.abs(mean[far]))][:MOST_TOLD]:
        first = firsts[one]
        said.append(
            f"{view.runs[run[one]].run.name} at {view.time[first] / 3600.0:.2f} h, {view.q[first] * 1e3:.1f} mm: "
            f"{mean[one] * 1e6:+.2g} um"
        )
    more = f"; and {len(far) - MOST_TOLD} more" if len(far) > MOST_TOLD else ""
    return [
        f"single landings stand off by more than {FAR:g} times the scatter of all others, which no cause explains: "
        f"{'; '.join(said)}{more}. Look at what happened at that stop"
    ]
