"""Tables, plain values and figures of the check of a campaign of a whole machine."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from rich.table import Table

from hexathermal.learn.check_hexapod import HexapodCheck, HexapodRunCheck, hexapod_warnings
from hexathermal.learn.check_words import FORMAT, plain
from hexathermal.learn.hexapod_data import AXES
from hexathermal.show.campaign_figures import broken, temperatures
from hexathermal.show.campaign_tables import most_like, number
from hexathermal.show.figures import BLACK, BLUE, STYLE, VERMILION
from hexathermal.show.hexapod_tables import observability_facts
from hexathermal.show.tables import framed

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MOST_POINTS = 4096


def overview(check: HexapodCheck) -> str:
    """Return what the campaign is, in some lines."""
    campaign = check.campaign
    roles = " and ".join(f"{len(campaign.runs_of(role))} for {role}" for role in ("identification", "validation"))
    hours = sum(one.clock.duration for one in check.runs) / 3600.0
    rows, used = sum(one.rows for one in check.runs), sum(len(one.time) for one in check.runs)
    return "\n".join([
        f"{campaign.title or 'Campaign without a title'} (kind hexapod): {len(check.runs)} runs, {roles};",
        f"{number(hours, 1)} h, {rows} rows, {used} of them usable, {len(campaign.sensors)} thermometers.",
        f"Temperatures count from the first row of {'each run' if campaign.zero == 'run' else 'the first run'}.",
    ])  # fmt: skip


def runs_table(check: HexapodCheck, pretty: bool) -> Table:
    """Return one line a run: duration, rows, poses, temperatures, largest deviations."""
    table = framed(pretty, "run", "role", "h>", "rows>", "usable>", "poses>", "temperatures\ndegC>",
                   "largest shift\num>", "largest turn\nurad>", "left out")  # fmt: skip
    for one in check.runs:
        span = shift = turn = "-"
        if np.isfinite(one.heat).any():
            span = f"{np.nanmin(one.heat):z.1f} to {np.nanmax(one.heat):z.1f}"
        if len(one.time):
            largest = [np.linalg.norm(part, axis=1).max() * 1e6 for part in np.split(one.deviation, 2, axis=1)]
            shift, turn = (f"{value:z.2f}" for value in largest)
        why = "; ".join(f"{count} {reason}" for reason, count in one.left_out.items()) or "-"
        table.add_row(one.run.name, one.run.role, number(one.clock.duration / 3600.0, 2), str(one.rows),
                      str(len(one.time)), str(one.poses), span, shift, turn, why)  # fmt: skip
    return table


def coordinates_table(check: HexapodCheck, pretty: bool) -> Table:
    """Return one line a measured coordinate: noise, scatter from pose to pose, range of the deviation."""
    table = framed(
        pretty, "measured less\ncommanded", "noise\npose held>", "pose to pose>", "lowest>", "highest>", "unit"
    )
    low, high = _range(check)
    for k, axis in enumerate(AXES):
        table.add_row(axis, *(number(values[k] * 1e6, 3) for values in (check.noise, check.scatter, low, high)),
                      "um" if k < 3 else "urad")  # fmt: skip
    return table


def _range(check: HexapodCheck) -> tuple[Any, Any]:
    """Return the lowest and highest deviations over all runs."""
    whole = np.concatenate([one.deviation for one in check.runs])
    return np.fmin.reduce(whole, axis=0, initial=np.nan), np.fmax.reduce(whole, axis=0, initial=np.nan)


def thermometers_table(check: HexapodCheck, pretty: bool) -> Table:
    """Return one line a thermometer: noise, slow deviation, range over all runs, likeness."""
    table = framed(pretty, "thermometer", "noise\nmK>", "slow\nmK>", "lowest\ndegC>", "highest\ndegC>",
                   "largest dT\nK>", "inflation>", "most like>")  # fmt: skip
    for k, name in enumerate(check.campaign.sensors):
        table.add_row(name, number(check.sensor_noise[k] * 1e3, 1), number(check.sensor_slow[k] * 1e3, 1),
                      number(check.lowest_degC[k], 2), number(check.highest_degC[k], 2),
                      number(check.largest_dT[k], 2), number(check.inflation[k], 1),
                      most_like(check.campaign.sensors, check.correlation, k))  # fmt: skip
    return table


def remarks(check: HexapodCheck) -> str:
    """Return what is to be said of likeness and of what can be told apart."""
    lines = []
    if np.isfinite(check.condition):
        lines.append(f"All thermometers together: condition number {check.condition:z.0f} (1: independent).")
    if check.observability is not None:
        lines.append("Laws of each leg and plate with a thermometer, by the runs for identification:")
        lines += [f"  {text}" for text in check.observability.words]
    return "\n".join(lines)


def hexapod_check_facts(check: HexapodCheck) -> dict[str, Any]:
    """Return a check as plain values, units in the names; what is not known is null."""
    low, high = _range(check)
    seen = check.observability
    data = {
        "format": FORMAT, "title": check.campaign.title, "kind": check.campaign.kind,
        "runs": [
            {"name": one.run.name, "role": one.run.role, "rows": one.rows, "usable": len(one.time),
             "left_out": one.left_out, "hours": one.clock.duration / 3600.0, "sampling_s": one.clock.sampling,
             "poses": one.poses, "noise_um_urad": one.noise * 1e6, "pose_to_pose_um_urad": one.scatter * 1e6}
            for one in check.runs
        ],
        "coordinates": [
            {"name": axis, "unit": "um" if k < 3 else "urad", "noise": check.noise[k] * 1e6,
             "pose_to_pose": check.scatter[k] * 1e6, "lowest_deviation": low[k] * 1e6,
             "highest_deviation": high[k] * 1e6}
            for k, axis in enumerate(AXES)
        ],
        "sensors": [
            {"name": name, "noise_K": check.sensor_noise[k], "slow_deviation_K": check.sensor_slow[k],
             "lowest_degC": check.lowest_degC[k], "highest_degC": check.highest_degC[k],
             "largest_dT_K": check.largest_dT[k], "variance_inflation": check.inflation[k]}
            for k, name in enumerate(check.campaign.sensors)
        ],
        "correlation": check.correlation, "condition_number": check.condition,
        "observability": None if seen is None else observability_facts(seen),
        "observability_missing": check.why_not, "warnings": list(hexapod_warnings(check)),
    }  # fmt: skip
    found: dict[str, Any] = plain(data)
    return found


def hexapod_run_figure(check: HexapodCheck, run: HexapodRunCheck) -> Figure:
    """Return temperatures, and shifts and turns of the platform off the commanded pose, of a run against time."""
    import matplotlib as mpl
    from matplotlib.figure import Figure

    rows = slice(None, None, max(1, len(run.time) // MOST_POINTS))
    hours = run.time[rows] / 3600.0
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(7.6, 7.4), layout="constrained")
        panels = figure.subplots(3, 1, sharex=True, height_ratios=[1.5, 1.0, 1.0])
        temperatures(panels[0], hours, run.heat[rows], check.campaign.thermocouples)
        panels[0].set_title(f"{run.run.name} ({run.run.role}): {len(run.time)} of {run.rows} rows usable")
        looks = ((BLUE, "-", "o"), (VERMILION, "--", "s"), (BLACK, ":", "^"))
        for axes, first, label in ((panels[1], 0, "shift off the commanded\npose (µm)"),
                                   (panels[2], 3, "turn off the commanded\npose (µrad)")):  # fmt: skip
            for k, (colour, style, mark) in enumerate(looks):
                x, y = broken(hours, run.deviation[rows, first + k] * 1e6)
                axes.plot(x, y, color=colour, ls=style, lw=0.8, marker=mark, ms=2.2, label=AXES[first + k])
            axes.set_ylabel(label)
            axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), fontsize=8.0)
        panels[-1].set_xlabel("time since the run's first row (h)")
        figure.align_ylabels()
    return figure
