"""Tables of a campaign's check, for the command line to print."""

from __future__ import annotations

import numpy as np
from rich.table import Table

from hexathermal.learn.check import CampaignCheck
from hexathermal.learn.check_cycles import cycles
from hexathermal.learn.check_words import hours, told_apart
from hexathermal.poses import FloatArray
from hexathermal.show.tables import framed

LONGEST_NUMBER = 1e9
"""From here on a number is given to three digits and a power of ten."""


def number(value: float, digits: int) -> str:
    """Return a number with its digits; a dash where it is not known.

    Examples
    --------
    >>> number(3.996, 2), number(2.8e296, 2), number(float("nan"), 2)
    ('4.00', '2.8e+296', '-')
    """
    if np.isnan(value):
        return "-"
    if abs(value) >= LONGEST_NUMBER:
        return f"{value:.3g}"
    return f"{value:z.{digits}f}"


def overview(check: CampaignCheck) -> str:
    """Return what the campaign is, in some lines."""
    campaign, durations = check.campaign, hours(check)
    rows, used = sum(run.record.rows for run in check.runs), sum(run.record.used for run in check.runs)
    roles = " and ".join(f"{len(campaign.runs_of(role))} for {role}" for role in ("identification", "validation"))
    sampling = sorted({float(f"{run.record.sampling:.4g}") for run in check.runs if np.isfinite(run.record.sampling)})
    steps = (
        f"{sampling[0]:g} s" if len(sampling) == 1 else f"{sampling[0]:g} to {sampling[-1]:g} s" if sampling else "-"
    )
    lines = [
        f"{campaign.title or 'Campaign without a title'} (kind {campaign.kind}): {len(check.runs)} runs, {roles};",
        f"{number(float(np.nansum(durations)), 1)} h, one row every {steps}, {rows} rows, {used} of them usable, "
        f"{len(campaign.sensors)} thermocouples.",
        f"Temperatures and drift count from the first row of "
        f"{'each run' if campaign.zero == 'run' else 'the first run'}.",
    ]
    return "\n".join(lines)


def runs_table(check: CampaignCheck, pretty: bool) -> Table:
    """Return one line a run: duration, rows, ranges, noise of the drift."""
    stroke = any(run.q is not None for run in check.runs)
    columns = ["run", "role", "h>", "rows>", "usable>", "rests>", "dT\nK>", "drift\num>", "noise\num>"]
    if stroke:
        columns += ["rest to rest\num>", "q\nmm>"]
    table = framed(pretty, *columns)
    for run, duration in zip(check.runs, hours(check), strict=True):
        empty = not run.record.used
        heat = "-" if empty else f"{np.nanmin(run.lowest_dT):+z.1f} to {np.nanmax(run.highest_dT):+z.1f}"
        drift = "-" if empty else f"{run.drift[0] * 1e6:+z.2f} to {run.drift[1] * 1e6:+z.2f}"
        cells = [run.run.name, run.run.role, number(duration, 2), str(run.record.rows), str(run.record.used),
                 str(run.landings), heat, drift, number(run.drift_noise * 1e6, 3)]  # fmt: skip
        if stroke:
            cells.append(number(run.landing_noise * 1e6, 3))
            cells.append("-" if run.q is None else f"{run.q[0] * 1e3:z.0f} to {run.q[1] * 1e3:z.0f}")
        table.add_row(*cells)
    return table


def sensors_table(check: CampaignCheck, pretty: bool) -> Table:
    """Return one line a thermocouple: noise, slow deviation, ranges over all runs, collinearity."""
    table = framed(pretty, "sensor", "part", "noise\nmK>", "slow\nmK>", "lowest\ndegC>", "highest\ndegC>",
                   "largest dT\nK>", "inflation>", "most like>")  # fmt: skip
    with np.errstate(all="ignore"):
        low = np.fmin.reduce([run.lowest_degC for run in check.runs])
        high = np.fmax.reduce([run.highest_degC for run in check.runs])
    for k, item in enumerate(check.campaign.thermocouples):
        like = most_like(check.campaign.sensors, check.correlation, k)
        table.add_row(item.name, item.part or "-", number(check.sensor_noise[k] * 1e3, 1),
                      number(check.sensor_slow[k] * 1e3, 1), number(low[k], 2), number(high[k], 2),
                      number(check.separability[k].span, 2), number(check.inflation[k], 1), like)  # fmt: skip
    return table


def most_like(sensors: tuple[str, ...], correlation: FloatArray, k: int) -> str:
    """Return the sensor that sensor `k` is most like, and their correlation."""
    others = np.where(np.arange(len(sensors)) == k, np.nan, correlation[k])
    if not np.isfinite(others).any():
        return "-"
    best = int(np.nanargmax(np.abs(others)))
    return f"{sensors[best]} {others[best]:z.4f}"


def ranges_table(check: CampaignCheck, pretty: bool) -> Table:
    """Return the range of every thermocouple in every run [degC]."""
    table = framed(pretty, "sensor", *(f"{run.run.name}\ndegC>" for run in check.runs))
    for k, sensor in enumerate(check.campaign.sensors):
        spans = [(run.lowest_degC[k], run.highest_degC[k]) for run in check.runs]
        table.add_row(sensor, *("-" if np.isnan(low) else f"{low:z.1f}-{high:z.1f}" for low, high in spans))
    return table


def apart_table(check: CampaignCheck, pretty: bool) -> Table:
    """Return one line a sensor: what the data can tell of its coefficients."""
    leg = check.campaign.leg
    if all(np.isnan(item.r) for item in check.separability) and leg is None:
        table = framed(pretty, "sensor", "largest dT\nK>", "C for 1 um\num/K>", "the data tell")
        for item in check.separability:
            table.add_row(item.sensor, number(item.span, 2), number(item.std_A, 4), told_apart(item))
        return table
    table = framed(pretty, "sensor", "r>", "A for 1 um\num/m/K>", "B for 1 um\num/m/K>", "A and B")
    for item in check.separability:
        table.add_row(item.sensor, number(item.r, 3), number(item.std_A, 3), number(item.std_B, 3), told_apart(item))
    return table


MOST_HOURS = 1e5
"""A clock beyond is none, and told in few digits."""


def cleaning_table(check: CampaignCheck, pretty: bool) -> Table:
    """Return what cleaning did over all runs, each step with its channels, the first of its places and its reason."""
    table = framed(pretty, "step", "count>", "runs>", "what", "channels", "first", "reason")
    steps: dict[tuple[str, str, str], tuple[dict[str, int], dict[str, float]]] = {}
    for run in check.runs:
        for step in run.record.steps:
            channels, runs = steps.setdefault((step.step, step.action, step.reason), ({}, {}))
            channels[step.channel] = channels.get(step.channel, 0) + step.count
            runs[run.run.name] = min(runs.get(run.run.name, np.inf), step.first_time)
    for (name, action, reason), (channels, runs) in steps.items():
        order = sorted(channels.items(), key=lambda item: -item[1])
        which = ", ".join(channel if len(order) == 1 else f"{channel} {count}" for channel, count in order)
        run_name, time = next(iter(runs.items()))
        hours = time / 3600.0
        first = f"{run_name}, {hours:.{'2f' if abs(hours) < MOST_HOURS else '3g'}} h"
        table.add_row(name, str(sum(channels.values())), str(len(runs)), action, which, first, reason)
    if not steps:
        table.add_row("-", "0", "0", "nothing left out", "-", "-", "every row and value may be used")
    return table


def remarks(check: CampaignCheck) -> str:
    """Return what is to be said of collinearity, cycles and weather."""
    lines = []
    if np.isfinite(check.condition):
        lines.append(f"All sensors together: condition number {check.condition:z.0f} (1: independent, 30: collinear).")
    lines += [
        f"{item.sensor} swings with a period of {item.period / 60.0:z.0f} min and +-{item.amplitude:z.2f} K in "
        f"{item.runs} of {len(check.runs)} runs: {item.cause}."
        for item in cycles(check)
    ]
    if np.isfinite(check.weather).all():
        (t_low, p_low, h_low), (t_high, p_high, h_high) = check.weather
        compensated = check.campaign.beams is not None and check.campaign.beams.index_compensated
        lines.append(
            f"Air: {t_low:z.1f} to {t_high:z.1f} degC, {p_low / 100.0:z.1f} to {p_high / 100.0:z.1f} hPa, "
            f"{h_low * 100.0:z.0f} to {h_high * 100.0:z.0f} %."
        )
        if np.isfinite(check.weather_effect):
            done = "the laser's electronics took it off" if compensated else "it is taken off by the weather"
            lines.append(
                f"Without correction for the index of air that span is worth {check.weather_effect * 1e6:z.1f} um on "
                f"the longest path; {done}."
            )
    return "\n".join(lines)
