"""A small campaign of a leg, and its report, that many tests look at."""

from __future__ import annotations

from pathlib import Path

import pytest

from hexathermal.cli import main
from hexathermal.learn.campaign_files import load_campaign
from hexathermal.show.report_campaign import campaign_report
from hexathermal.show.report_page import Report
from tests.show.reports import silent


@pytest.fixture(scope="session")
def plotly() -> None:
    """Leave out tests of plots where plotly is not installed."""
    pytest.importorskip("plotly.graph_objects", reason="plotly is not installed (extra 'report')")


@pytest.fixture(scope="session")
def leg(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A small campaign of a leg on the virtual bench."""
    folder = tmp_path_factory.mktemp("bench") / "leg"
    words = ["--runs", "3", "--validation", "1", "--hours", "3", "--interval", "60"]
    assert main(["simulate", "bench", "--out", str(folder), *words]) == 0
    return folder


@pytest.fixture(scope="session")
def leg_report(leg: Path) -> Report:
    return campaign_report(load_campaign(leg), None, silent)
