"""Reports of measured campaigns: fitted runs, spikes, laws of another kind, parts of which little is known."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest

from hexathermal.cli import main
from hexathermal.errors import ArgumentError
from hexathermal.learn.campaign_files import load_campaign
from hexathermal.learn.check import check_campaign
from hexathermal.learn.leg_law_files import write_leg_law
from hexathermal.show.campaign_figures import NARROWEST_MM, coverage_figure
from hexathermal.show.report import report_of, subject_of
from hexathermal.show.report_campaign import campaign_report
from hexathermal.show.report_campaign_charts import coverage_chart
from hexathermal.show.report_chart import Curve
from hexathermal.show.report_page import Report
from tests.learn.campaign_folders import Table, component_campaign, leg_campaign
from tests.show.drawn_diagnoses import plain_law
from tests.show.reports import silent


@pytest.fixture(scope="module")
def hexapod(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a campaign of a virtual machine, and the machine that was identified on it."""
    folder = tmp_path_factory.mktemp("hexapod")
    words = ["--runs", "2", "--validation", "1", "--rows", "40"]
    assert main(["simulate", "machine", "--out", str(folder / "campaign"), *words, "--quiet"]) == 0
    assert main(["identify", str(folder / "campaign"), "--out", str(folder / "machine"), "--quiet"]) == 0
    return folder


def test_a_machines_law_knows_the_runs_that_it_was_fitted_to(hexapod: Path, tmp_path: Path) -> None:
    """The law's origin stands beside it: a run renamed and called one for validation is told to prove nothing; without
    the origin the report says that it cannot be told.
    """
    renamed = shutil.copytree(hexapod / "campaign", tmp_path / "renamed")
    text = (renamed / "campaign.toml").read_text(encoding="utf-8")
    text = text.replace('name = "run-01"', 'name = "fresh"').replace('role = "validation"', 'role = "unused"')
    text = text.replace('role = "identification"', 'role = "validation"', 1).replace('"unused"', '"identification"')
    (renamed / "campaign.toml").write_text(text, encoding="utf-8")
    told = report_of(subject_of(str(renamed)), hexapod / "machine", silent).notes
    assert [note for note in told if "run fresh was fitted" in note and "then named run-01" in note]
    clean = report_of(subject_of(str(hexapod / "campaign")), hexapod / "machine", silent)
    assert not [note for note in clean.notes if "fitted" in note]
    orphan = shutil.copytree(hexapod / "machine", tmp_path / "orphan")
    (orphan / "hexapod.origin.toml").unlink()
    told = report_of(subject_of(str(hexapod / "campaign")), orphan, silent).notes
    assert [note for note in told if "whether these runs were fitted cannot be told" in note]


def test_the_law_of_a_leg_is_refused_for_a_machine(hexapod: Path, tmp_path: Path) -> None:
    """The message says what it is, and how a machine is made of it."""
    law = write_leg_law(plain_law(), tmp_path / "leg.toml")
    with pytest.raises(ArgumentError, match=r"is the law of a leg; .*'hexathermal apply .* makes one, then --law DIR"):
        report_of(subject_of(str(hexapod / "campaign")), law, silent)


def _run(report: Report, name: str) -> tuple[dict[str, Curve], str]:
    """Return the curves of a run's figure by panel and name, and its caption."""
    chart = next(one for one in report.charts if one.name == name)
    return {f"{panel.title}: {mark.name}": mark for panel in chart.panels for mark in panel.marks
            if isinstance(mark, Curve)}, chart.caption  # fmt: skip


def test_spikes_are_ringed_where_they_were_read(tmp_path: Path) -> None:
    """A spike is a ring at its time and value; one that lies far off the plot is counted, but would flatten it."""
    at, far = 100, 300

    def spiked(table: Table) -> None:
        table["T02_degC"][at] += 2.5
        table["T03_degC"][far] += 40.0

    folder = leg_campaign(tmp_path / "leg", edit=spiked)
    read = np.genfromtxt(folder / "runs" / "a.csv", delimiter=",", names=True)
    marks, caption = _run(campaign_report(load_campaign(folder), None, silent), "run-a")
    rings = marks["Temperatures: left out"]
    assert rings.look == "rings"
    hours = (read["time_s"] - read["time_s"][0]) / 3600.0
    assert rings.x == pytest.approx([hours[at]])
    assert rings.y == pytest.approx([read["T02_degC"][at]])
    assert "2 readings were left out as spikes (rings). Of these 1 lay too far off to be drawn." in caption


def test_a_part_of_which_little_is_known_has_no_table_of_dashes(tmp_path: Path) -> None:
    """Thermocouples without part and place are named in a sentence; with them they have their table."""
    parts = {}
    for folder in (component_campaign(tmp_path / "part"), leg_campaign(tmp_path / "leg")):
        report = campaign_report(load_campaign(folder), None, silent)
        parts[folder.name] = "".join(part for part in report.sections[0].parts if isinstance(part, str))
    assert "Thermocouples: T1; the campaign does not say where they sit." in parts["part"]
    assert "<caption>Thermocouples" not in parts["part"]
    assert "<caption>Thermocouples" in parts["leg"]
    assert "along the leg, mm" in parts["leg"]


def test_pages_speak_to_people(tmp_path: Path) -> None:
    """No page says ``+-``, ``degC`` or ``um`` in its words, nor calls nothing negative."""
    report = campaign_report(load_campaign(leg_campaign(tmp_path / "leg")), None, silent)
    words = " ".join(part for one in report.sections for part in one.parts if isinstance(part, str))
    assert "±" in words
    assert "°C" in words
    for odd in ("+-", " degC", ">degC", " um", ">um", ">-0.0<", ">-0.00<", ">-0.000<"):
        assert odd not in words


def test_a_rod_that_stood_has_an_axis_that_can_be_read(tmp_path: Path) -> None:
    """Noise of the scale is no travel: the axis is a millimetre long, its numbers have no offset."""

    def standing(table: Table) -> None:
        still = 125.0 + 1e-5 * np.arange(len(table["q_mm"]))
        for beam in (1, 2, 3):
            table[f"beam{beam}_mm"] += still - still[0] - table["q_mm"] + table["q_mm"][0]
        table["q_mm"] = still

    folder = leg_campaign(tmp_path / "leg", edit=standing)
    text = (folder / "campaign.toml").read_text(encoding="utf-8")
    first = text.split("[[runs]]")
    (folder / "campaign.toml").write_text("[[runs]]".join(first[:2]), encoding="utf-8")
    check = check_campaign(load_campaign(folder))
    figure, chart = coverage_figure(check), coverage_chart(check)
    assert figure is not None
    assert chart is not None
    low, high = figure.axes[0].get_xlim()
    assert high - low == pytest.approx(NARROWEST_MM)
    assert chart.panels[0].x_range == pytest.approx((low, high), abs=0.05)
    figure.draw_without_rendering()
    assert figure.axes[0].xaxis.get_major_formatter().get_offset() == ""
