"""Runs for validation whose table is that of a run for identification: they were fitted, and prove nothing."""

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


def without_copies(campaign: Campaign) -> tuple[Campaign, list[str]]:
    """Return a campaign without such runs, and what is said of them; the first run stays, for others count from it."""
    said, first = copy_words(campaign), campaign.runs[:1]
    if not said:
        return campaign, []
    kept = tuple(run for run in campaign.runs if run in first or run.name not in said)
    left_out = {run.name for run in campaign.runs} - {run.name for run in kept}
    notes = [f"left out: {words}" if name in left_out else words for name, words in said.items()]
    return replace(campaign, runs=kept), notes
