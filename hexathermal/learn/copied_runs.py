"""Runs with one and the same table: for validation they prove nothing, fitted twice they are judged by their copies."""

from __future__ import annotations

from dataclasses import replace

from hexathermal.learn.campaign import Campaign
from hexathermal.learn.campaign_dataset import table_digest


def copied_runs(campaign: Campaign) -> dict[str, str]:
    """Return runs for validation with the same table, to the byte, as one for identification, and that one's name."""
    if not campaign.runs_of("validation"):
        return {}
    fitted = {table_digest(run.path): run.name for run in campaign.runs_of("identification")}
    marks = {run.name: table_digest(run.path) for run in campaign.runs_of("validation")}
    return {name: fitted[mark] for name, mark in marks.items() if mark in fitted}


def copy_words(campaign: Campaign) -> dict[str, str]:
    """Return what is said of such runs, by their names."""
    return {
        name: f"{name} is for validation, but holds the same table as {other}, which is fitted: it proves nothing"
        for name, other in copied_runs(campaign).items()
    }


def twin_words(campaign: Campaign) -> list[str]:
    """Return what is said of runs for identification with the table of another one."""
    first: dict[bytes, str] = {}
    found = []
    for run in campaign.runs_of("identification"):
        other = first.setdefault(table_digest(run.path), run.name)
        if other != run.name:
            found.append(
                f"{run.name} holds the same table as {other}: it counts twice, and left out of a fit it is judged by "
                "its copy; give each run once"
            )
    return found


def without_copies(campaign: Campaign) -> tuple[Campaign, list[str]]:
    """Return a campaign without copies for validation, and what is said of these and of twins.

    The first run stays, for others may count from it.
    """
    said, first, twins = copy_words(campaign), campaign.runs[:1], twin_words(campaign)
    if not said:
        return campaign, twins
    kept = tuple(run for run in campaign.runs if run in first or run.name not in said)
    left_out = {run.name for run in campaign.runs} - {run.name for run in kept}
    notes = [f"left out: {words}" if name in left_out else words for name, words in said.items()]
    return replace(campaign, runs=kept), [*notes, *twins]
