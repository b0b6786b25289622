"""Runs with one and the same table: for validation they prove nothing, fitted twice they are judged by their copies."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from hexathermal.learn.campaign import Campaign
from hexathermal.learn.campaign_dataset import table_digest


def repeated(campaign: Campaign) -> dict[str, str]:
    """Return runs with the same table, to the byte, as a run for identification, and its name.

    Runs for identification repeat the first of them; each table is read once.
    """
    first: dict[bytes, str] = {}
    found = {}
    for run in (*campaign.runs_of("identification"), *campaign.runs_of("validation")):
        mark = table_digest(run.path)
        if mark in first:
            found[run.name] = first[mark]
        elif run.role == "identification":
            first[mark] = run.name
    return found


def copied_runs(campaign: Campaign, same: Mapping[str, str] | None = None) -> dict[str, str]:
    """Return runs for validation among the `repeated` ones, which are `same` where they are known."""
    known = repeated(campaign) if same is None else same
    return {run.name: known[run.name] for run in campaign.runs_of("validation") if run.name in known}


def copy_words(campaign: Campaign, same: Mapping[str, str] | None = None) -> dict[str, str]:
    """Return what is said of copies for validation, by their names."""
    return {
        name: f"{name} is for validation, but holds the same table as {other}, which is fitted: it proves nothing"
        for name, other in copied_runs(campaign, same).items()
    }


def twin_words(campaign: Campaign, same: Mapping[str, str] | None = None) -> list[str]:
    """Return what is said of runs for identification with the table of another one."""
    known = repeated(campaign) if same is None else same
    return [
        f"{run.name} holds the same table as {known[run.name]}: it counts twice, and left out of a fit it is judged by "
        "its copy; give each run once"
        for run in campaign.runs_of("identification")
        if run.name in known
    ]


def repeated_words(campaign: Campaign) -> list[str]:
    """Return what is said of copies for validation, then of twins."""
    same = repeated(campaign)
    return [*copy_words(campaign, same).values(), *twin_words(campaign, same)]


def without_copies(campaign: Campaign) -> tuple[Campaign, list[str]]:
    """Return a campaign without copies for validation, and what is said of these and of twins.

    The first run stays, for others may count from it.
    """
    same = repeated(campaign)
    said, first, twins = copy_words(campaign, same), campaign.runs[:1], twin_words(campaign, same)
    if not said:
        return campaign, twins
    kept = tuple(run for run in campaign.runs if run in first or run.name not in said)
    left_out = {run.name for run in campaign.runs} - {run.name for run in kept}
    notes = [f"left out: {words}" if name in left_out else words for name, words in said.items()]
    return replace(campaign, runs=kept), [*notes, *twins]
