"""Runs that are in memory already are not read again, and give the same law and the same gain."""

from __future__ import annotations

from unittest.mock import patch

import numpy as np
import pytest

from hexathermal.learn import cleaning
from hexathermal.learn.campaign import Campaign
from hexathermal.learn.campaign_files import load_campaign
from hexathermal.learn.campaign_laws import identify_campaign, role_blocks, validate_campaign
from hexathermal.learn.diagnosis.extension import gained
from hexathermal.learn.signals import RunRows, campaign_rows
from hexathermal.learn.validation_gain import gain
from hexathermal.simulate.hidden.drawing import campaign_of
from hexathermal.simulate.hidden.writing import write_campaign


@pytest.fixture(scope="module")
def campaign(tmp_path_factory: pytest.TempPathFactory) -> Campaign:
    """A leg with backlash."""
    folder = tmp_path_factory.mktemp("memory") / "campaign"
    write_campaign(folder, *campaign_of("quiet", 11, causes=("backlash",), strength=1.0))
    return load_campaign(folder)


@pytest.fixture(scope="module")
def read(campaign: Campaign) -> dict[str, RunRows]:
    """All its runs in memory."""
    return {rows.run.name: rows for role in ("identification", "validation") for rows in campaign_rows(campaign, role)}


@pytest.mark.parametrize("rows", [100, 16384])
def test_blocks_from_memory_are_those_of_the_files(campaign: Campaign, read: dict[str, RunRows], rows: int) -> None:
    """Values, numbers of rows and runs of each block agree, however long blocks are."""
    for run in campaign.runs:
        from_files = list(cleaning.usable_blocks(campaign, run, rows=rows))
        from_memory = list(cleaning.parts_of(read[run.name].usable, rows))
        assert [len(block) for block in from_memory] == [len(block) for block in from_files]
        for one, other in zip(from_memory, from_files, strict=True):
            assert one.run == other.run
            for name in ("time", "dT", "drift", "q", "landing", "inputs", "air"):
                np.testing.assert_array_equal(getattr(one, name), getattr(other, name))


def test_a_law_from_memory_is_that_of_the_files(campaign: Campaign, read: dict[str, RunRows]) -> None:
    """Law, range and notes are the same to the bit, and no table is opened."""
    wanted = identify_campaign(campaign)
    with patch.object(cleaning.UsableBlocks, "__init__", side_effect=AssertionError("a table was read again")):
        found = identify_campaign(campaign, read=read)
        blocks = list(role_blocks(campaign, "validation", read=read))
    np.testing.assert_array_equal(found.law.coefficients, wanted.law.coefficients)
    np.testing.assert_array_equal(found.law.covariance, wanted.law.covariance)
    assert found.law.validity.degC == wanted.law.validity.degC
    assert found.law.origin == wanted.law.origin
    assert found.notes == wanted.notes
    assert sum(map(len, blocks)) == sum(len(block) for block in role_blocks(campaign, "validation"))


def test_a_gain_needs_landings_alone(campaign: Campaign, read: dict[str, RunRows]) -> None:
    """The gain of one law over another is that of their whole validations."""
    one, other = (identify_campaign(campaign, names).law for names in (campaign.sensors[:1], campaign.sensors[1:3]))
    found = gained(one, other, campaign, read)
    assert found == gain(validate_campaign(one, campaign), validate_campaign(other, campaign))
    assert found == gained(one, other, campaign)
