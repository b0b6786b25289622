"""The rows that are diagnosed: what the laws read, and further thermometers of the legs where they are recorded wholly.

A thermometer that no law reads may tell what a law should read, but costs nothing: where it would cost a row, or is not
on every leg, it is left aside, and that is said.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hexathermal.errors import DataError
from hexathermal.learn.campaign import Campaign
from hexathermal.learn.hexapod_data import HexapodRows, hexapod_rows
from hexathermal.learn.hexapod_validation import readable_law
from hexathermal.machine.files import read_hexapod
from hexathermal.machine.hexapod import Hexapod

LEAST_K = 1e-3
"""A thermometer that never moves by more [K] is dead."""


def law_rows(campaign: Campaign, role: str, hexapod: Hexapod | None, further: Sequence[str] = ()) -> HexapodRows:
    """Return the usable rows of a role, with the thermometers that the legs' laws read.

    Parameters
    ----------
    campaign : Campaign
    role : str
    hexapod : Hexapod, optional
    further : sequence of str
        Thermometers of every leg that are wanted besides.
    """
    machine, sensors = hexapod, None
    if machine is None and campaign.hexapod is not None:
        machine = read_hexapod(campaign.hexapod)
    if machine is not None and campaign.kind == "hexapod":
        laws = readable_law(machine, campaign).legs
        sensors = tuple(dict.fromkeys([*(name for law in laws for name in law.sensors), *further]))
    return hexapod_rows(campaign, role, hexapod=machine, sensors=sensors)


def further_sensors(campaign: Campaign, rows: HexapodRows) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Return thermometers that every leg has, no law reads and all rows tell, and what is to be said of others.

    Parameters
    ----------
    campaign : Campaign
    rows : HexapodRows
        Of the runs for identification, as `law_rows` gives them.
    """
    each = [{name.removeprefix(f"leg{leg}_") for name in campaign.sensors if name.startswith(f"leg{leg}_")}
            for leg in range(1, 7)]  # fmt: skip
    others = sorted(set.union(*each) - set(rows.sensors))
    found, notes = [], []
    for name in others:
        legs = [str(leg + 1) for leg in range(6) if name in each[leg]]
        if len(legs) < 6:
            notes.append(f"thermometer {name} is on leg {', '.join(legs)} alone: whether a law should read it is asked "
                         "where every leg has it")  # fmt: skip
        elif _whole(campaign, rows, name):
            found.append(name)
        else:
            notes.append(f"thermometer {name} of the legs is not recorded in every row, or never moves: whether a law "
                         "should read it is not asked")  # fmt: skip
    return tuple(found), tuple(notes)


def _whole(campaign: Campaign, rows: HexapodRows, sensor: str) -> bool:
    """Whether a thermometer is recorded in every usable row, of runs for validation as well, and alive on each leg."""
    s = len(rows.sensors)
    try:
        wide = law_rows(campaign, "identification", rows.hexapod, (sensor,))
        if len(wide) != len(rows) or not np.array_equal(wide.dT[..., :s], rows.dT):
            return False
        if campaign.runs_of("validation"):
            usual = law_rows(campaign, "validation", rows.hexapod)
            held = law_rows(campaign, "validation", rows.hexapod, (sensor,))
            if len(held) != len(usual) or not np.array_equal(held.dT[..., :s], usual.dT):
                return False
    except DataError:
        return False
    return bool((np.ptp(wide.dT[..., -1], axis=0) > LEAST_K).all())
