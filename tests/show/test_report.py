"""The report: it knows what it is of, its files hold what is drawn, and what cannot be reported is told."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import hexathermal as ht
from hexathermal.errors import ArgumentError, FileFormatError, UnknownNameError
from hexathermal.kinematics.workspace import margins
from hexathermal.learn.leg_law_files import write_leg_law
from hexathermal.machine.thermal import LegLaw, PlateLaw, ThermalModel
from hexathermal.machine.writing import write_hexapod
from hexathermal.show.diagnosis_tables import diagnosis_facts
from hexathermal.show.report import report_of, subject_of
from hexathermal.show.report_chart import Bars, Cells, Chart, Curve, Panel, columns_of, csv_text, file_name
from hexathermal.show.report_files import ENDINGS, write_figures
from hexathermal.show.report_live import live_figure
from hexathermal.show.report_machine_charts import drawing_chart, law_chart, travels
from hexathermal.show.report_page import Report, Section, figure_html
from hexathermal.show.report_still import still_figure
from hexathermal.show.report_thinning import SEEN, kept_of
from tests.show.drawn_diagnoses import drawn, plain_law
from tests.show.reports import PAPER, budget_json, numbers_in, silent

Said = pytest.CaptureFixture[str]


@pytest.fixture
def chart() -> Chart:
    """A figure with everything a figure may hold."""
    x = np.array([0.0, 1.0, 2.0])
    rise = Curve("rise <T>", x, np.array([0.0, np.nan, 2.0]), low=np.zeros(3), high=np.full(3, 3.0))
    rod = Curve("rod", x, x * 10.0, "#1A1A1A", "steps", right=True)
    bars = Bars("evidence", ("a & b", "c"), np.array([1.0, 2.5]))
    cells = Cells("RMSE", ("T1", "T2"), ("T1", "T2"), np.array([[1.0, 2.0], [2.0, np.nan]]), "µm", 1.0, 2.0)
    panels = (
        Panel("Top", (rise, rod), "time", "rise", "h", "K", "rod", "mm"),
        Panel("Ranking", (bars,), "log evidence", "", across=True, line=1.5),
        Panel("Matrix", (cells,), "sensor", "sensor"),
    )
    return Chart("all", "All <kinds>", 'Says "all" & <more>.', "A caption.", panels)


def test_each_kind_is_known_by_what_lies_there(tmp_path: Path, leg: Path) -> None:
    """Folders by their file, JSON by its format, machines by name; a file stands for its folder."""
    assert subject_of(str(leg)).kind == "campaign"
    assert subject_of(str(leg / "campaign.toml")).place == leg.resolve()
    assert subject_of("reference").kind == "machine"
    write_hexapod(ht.load_hexapod("reference"), tmp_path / "hexapod.toml")
    assert subject_of(str(tmp_path)).kind == "machine"
    assert subject_of(str(budget_json(tmp_path))).kind == "budget"
    (tmp_path / "campaign.toml").touch()  # a campaign of a hexapod brings its machine with it
    assert subject_of(str(tmp_path)).kind == "campaign"
    assert subject_of(str(tmp_path / "hexapod.toml")).kind == "machine"


def test_what_is_unclear_is_refused(tmp_path: Path) -> None:
    """Nothing, two things at once, an unknown format, broken JSON: each says what was looked for."""
    with pytest.raises(
        ArgumentError, match=r"nothing that a report can be of; looked for a folder with campaign\.toml"
    ):
        subject_of(str(tmp_path))
    with pytest.raises(UnknownNameError, match="there is nothing at 'referense'"):
        subject_of("referense")
    for name in ("diagnosis.json", "budget.csv"):
        (tmp_path / name).write_text("{}")
    with pytest.raises(ArgumentError, match=r"holds diagnosis\.json, budget\.csv: unclear"):
        subject_of(str(tmp_path))
    for text, words in (("{}", "it names no format"), ('{"format":\n ?}', "line 2, column 2: no JSON")):
        (tmp_path / "odd.json").write_text(text)
        with pytest.raises(FileFormatError, match=words):
            subject_of(str(tmp_path / "odd.json"))


def test_files_hold_the_numbers_that_are_drawn(chart: Chart) -> None:
    """Every number of curves, intervals, bars and matrices stands in a column named by what it is and its unit."""
    text = csv_text(columns_of(chart))
    found = numbers_in(text)
    assert found["time_h"] == [0.0, 1.0, 2.0]
    assert found["Top_rise_T_K"] == [0.0, 2.0]  # what is no number is empty
    assert found["Top_rise_T_high_K"] == [3.0, 3.0, 3.0]
    assert found["Top_rod_mm"] == [0.0, 10.0, 20.0]
    assert found["Ranking_evidence"] == [1.0, 2.5]
    assert found["T1"] == [1.0, 2.0]
    assert "a & b" in text


def test_thinning_keeps_both_ends_and_is_even() -> None:
    """No more rows than allowed, the first and the last among them, equal steps but for the last."""
    for count in (1, 5, 100, 1201, 5003):
        kept = kept_of(count, 100)
        assert len(kept) <= 101
        assert kept[0] == 0
        assert kept[-1] == count - 1
        assert len(set(np.diff(kept)[:-1])) <= 1


@given(st.integers(0, 4999), st.floats(0.5, 100.0), st.integers(0, 2**32 - 1))
def test_thinning_keeps_what_stands_out(at: int, height: float, seed: int) -> None:
    """A spike of one row is drawn wherever it stands; of noise no more than twice as many rows as allowed are drawn."""
    draw = np.random.default_rng(seed)
    smooth, rough = np.sin(np.linspace(0.0, 6.0, 5000)), draw.standard_normal((5000, 3))
    smooth[at] += height
    assert at in kept_of(5000, 200, smooth)
    assert len(kept_of(5000, 200, smooth)) <= 205  # the rest of a sine is not worth a row
    rough[at, 1] = 1e3
    kept = kept_of(5000, 200, rough)
    assert at in kept
    assert len(kept) <= 402
    drawn = np.interp(np.arange(5000), kept_of(5000, 200, smooth), smooth[kept_of(5000, 200, smooth)])
    beside = np.abs(np.arange(5000) - at) > 30  # a line to the spike and back
    assert np.abs(drawn - smooth)[beside].max() <= SEEN * np.ptp(smooth)


@pytest.mark.usefixtures("plotly")
def test_still_and_interactive_show_the_same(chart: Chart) -> None:
    """The still picture's lines and bars, and the plot's traces, hold the chart's numbers."""
    axes = still_figure(chart).axes
    lines = [line.get_ydata() for one in axes for line in one.get_lines()]
    assert any(np.array_equal(line, [0.0, np.nan, 2.0], equal_nan=True) for line in lines)
    assert [patch.get_width() for patch in axes[1].patches] == [1.0, 2.5]
    traces = {trace["name"]: trace for trace in live_figure(chart)["data"]}
    assert traces["rise &lt;T&gt;"]["y"] == [0.0, None, 2.0]
    assert traces["rod"]["yaxis"] == "y101"
    assert traces["evidence"]["x"] == [1.0, 2.5]
    assert traces["RMSE"]["z"] == [[1.0, 2.0], [2.0, None]]


def test_words_cannot_become_tags(chart: Chart) -> None:
    """Titles, names and alternative texts with angle brackets are shown as they are."""
    html = figure_html(chart)
    assert "<kinds>" not in html
    assert "<T>" not in html
    assert "<more>" not in html
    assert 'alt="Says &quot;all&quot; &amp; &lt;more&gt;."' in html


def test_the_papers_figures_are_there(leg_report: Report) -> None:
    """A leg's report has figures 4, 6, 7 and 8, every run, noise, likeness and coverage, each once and with words."""
    names = [chart.name for chart in leg_report.charts]
    assert len(names) == len(set(names))
    assert set(PAPER) <= set(names)
    assert {"run-01", "run-04", "noise", "collinearity", "coverage"} <= set(names)
    assert all(re.search(r"\d", chart.alt) and len(chart.alt) > 40 for chart in leg_report.charts)
    assert all(not re.search(r"\bnan\b|\binf\b|None", chart.alt + chart.caption) for chart in leg_report.charts)


def test_a_point_is_named_once_and_only_where_there_is_room(leg_report: Report) -> None:
    """A set that is on the front and chosen has its name once, in the zoom; what is told of a point always has it."""
    front = next(one for one in leg_report.charts if one.name == "paper-figure-7")
    few = tuple(Curve(f"curve {k}", np.array([1.0, 2.0 + k]), np.ones(2), labels=("a", f"b{k}")) for k in range(3))
    traces = live_figure(replace(front, panels=(replace(front.panels[1], marks=few),)))["data"]
    assert [one["text"] for one in traces] == [["a", "b0"], ["", "b1"], ["", "b2"]]
    assert all(one["hovertext"][0] == "a" for one in traces)
    drawn = live_figure(front)["data"]
    assert {one["xaxis"] for one in drawn if "text" in one} == {"x2"}
    assert all("hovertext" in one for one in drawn)


def test_runs_with_names_alike_keep_a_figure_each(chart: Chart) -> None:
    """Names that differ in signs or size of letters only, or have no Latin letter, make a file and an anchor each."""
    names = ["warm <b>", "Warm b", "加", "熱"]
    charts = tuple(replace(chart, name=file_name(name)) for name in names)
    report = Report("campaign", "", "", "", (), (Section("runs", "Runs", "Runs", charts),))
    assert [one.name for one in report.charts] == ["warm-b", "warm-b-2", "figure", "figure-2"]


def test_files_hold_what_the_papers_figures_draw(leg_report: Report) -> None:
    """Every line of the still figures 4, 7 and 8, and every cell of 6, stands in the CSV of the figure."""
    for chart in leg_report.charts:
        if chart.name not in PAPER:
            continue
        columns = [values for table in columns_of(chart) for values in (
            np.array([cell for cell in column.cells if not isinstance(cell, str)]) for column in table)]  # fmt: skip
        everything = np.concatenate(columns)
        everything = everything[np.isfinite(everything)]
        figure = still_figure(chart)
        shown = [np.asarray(line.get_ydata(), dtype=float) for axes in figure.axes for line in axes.get_lines()
                 if len(np.unique(line.get_ydata())) > 2]  # fmt: skip
        shown += [np.ma.compressed(picture.get_array()) for axes in figure.axes for picture in axes.get_images()]
        assert shown
        for values in shown:
            known = values[np.isfinite(values)]
            nearest = np.abs(known[:, None] - everything[None, :]).min(axis=1)
            assert nearest.max() <= 1e-6 * np.abs(known).max()


def test_figures_become_three_files_each(leg_report: Report, tmp_path: Path) -> None:
    """PNG, SVG and CSV of every figure, all or none: what fails leaves no folder."""
    some = Report("campaign", "", "", "", (), leg_report.sections[-1:])
    files = write_figures(some, tmp_path / "figures", silent)
    assert sorted(file.name for file in files) == sorted(
        f"{chart.name}{ending}" for chart in some.charts for ending in ENDINGS
    )
    for file in files:
        start = file.read_bytes()[:60]
        assert {".png": b"\x89PNG", ".svg": b"<?xml", ".csv": b"time_h,"}[file.suffix] in start

    def stop(_done: int, _total: int, _label: str) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        write_figures(some, tmp_path / "other", stop)
    assert not (tmp_path / "other").exists()


def test_a_law_that_is_given_is_the_one_that_is_proven(leg: Path, tmp_path: Path) -> None:
    """--law is held against the runs for validation, and its coefficients are shown."""
    file = write_leg_law(plain_law(), tmp_path / "leg.toml")
    report = report_of(subject_of(str(leg)), file, silent)
    assert report.facts["law"]["coefficients"][0]["value"] == pytest.approx(2.0)
    assert report.facts["law"]["sensors"] == ["T07"]
    assert "law of T07" in report.finding
    with pytest.raises(ArgumentError, match="held against a measured campaign; reference is a machine"):
        report_of(subject_of("reference"), file, silent)


def test_a_diagnosis_is_reported_by_its_json(tmp_path: Path) -> None:
    """The finding stands first; ranking, gain and limits are drawn with the numbers of the file."""
    file = tmp_path / "diagnosis.json"
    facts = diagnosis_facts(drawn())
    file.write_text(json.dumps(facts))
    report = report_of(subject_of(str(tmp_path)), None, silent)
    assert report.finding == facts["sentence"]
    charts = {chart.name: chart for chart in report.charts}
    assert {"ranking", "gain", "limits"} <= set(charts)
    evidence = numbers_in(csv_text(columns_of(charts["ranking"])))
    total = np.sum(list(evidence.values()), axis=0)
    assert total == pytest.approx([one["evidence"] for one in facts["candidates"]])
    del facts["candidates"]
    file.write_text(json.dumps(facts))
    with pytest.raises(FileFormatError, match="'candidates' is missing"):
        report_of(subject_of(str(tmp_path)), None, silent)


def test_the_folder_of_a_budget_says_what_its_json_says(tmp_path: Path) -> None:
    """Both give the same contributions and the same map; the bars of an axis add up to its uncertainty."""
    more = ["--map", "x=-50:50:3", "y=-50:50:4", "--out", str(tmp_path / "map")]
    file = budget_json(tmp_path, *more)
    told, read = (report_of(subject_of(str(place)), None, silent) for place in (file, tmp_path / "map"))
    for one, other in zip(told.charts, read.charts, strict=True):
        assert one.name == other.name
        assert csv_text(columns_of(one)) == csv_text(columns_of(other))
    assert [chart.name for chart in told.charts] == ["contributions", "map-shift", "map-turn"]
    bars = [mark for panel in told.charts[0].panels for mark in panel.marks if isinstance(mark, Bars) and not mark.mark]
    stacked = np.sum([bar.values for bar in bars if bar.names[0] == "x"], axis=0)
    budget = json.loads(file.read_text())["budget"]
    assert stacked == pytest.approx(budget["standard_uncertainty"][:3])
    cells = told.charts[1].panels[0].marks[0]
    assert isinstance(cells, Cells)
    assert cells.values.shape == (4, 3)  # y upwards, x across
    first = json.loads(file.read_text())["map"]["rows"][1]  # x = -50, the second y
    assert cells.values[1, 0] == pytest.approx(np.linalg.norm(first[18:21]))


def test_travels_end_where_a_limit_is_met() -> None:
    """At the end of each travel some limit is met to a thousandth, and a little farther it is passed."""
    hexapod = ht.load_hexapod("reference")
    for k, ends in enumerate(travels(hexapod).values()):
        for end in ends:
            six = np.zeros((2, 6))
            six[:, k] = end, end + np.sign(end) * 1e-3
            left = margins(hexapod, ht.pose_from_coordinates(six, hexapod=hexapod))
            assert left.reachable.tolist() == [True, False]
            assert left.share[0] < 1e-3


def test_the_law_is_drawn_with_its_uncertainty() -> None:
    """The band is 1.96 standard deviations of ``A q0 + B q``, by the covariance that the file states."""
    plain = ht.load_hexapod("reference")
    assert plain.thermal is not None
    one = plain.thermal.legs[0]
    law = LegLaw(one.sensors, one.A, one.B, covariance=np.diag([1e-16, 4e-16]))
    chart = law_chart(replace(plain, thermal=replace(plain.thermal, legs=(law,) * 6)))
    assert chart is not None
    (curve,) = chart.panels[0].marks
    assert isinstance(curve, Curve)
    assert curve.low is not None
    assert curve.y[0] == pytest.approx(1.99e-6 * 0.6 * 1e6)
    half = 1.96e6 * np.hypot(1e-8 * 0.6, 2e-8 * 0.25)
    assert curve.y[-1] - curve.low[-1] == pytest.approx(half)


def test_the_drawing_is_the_machine(tmp_path: Path) -> None:
    """Joints in millimetres, legs between them as long as the inverse kinematics says."""
    hexapod = ht.load_hexapod("reference")
    above, front = (next(mark for mark in panel.marks if isinstance(mark, Curve) and mark.name == "legs")
                    for panel in drawing_chart(hexapod).panels)  # fmt: skip
    ends = np.stack([above.x, above.y, front.y], axis=1).reshape(6, 3, 3)
    assert np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1) == pytest.approx(hexapod.home_lengths * 1e3)


@pytest.mark.parametrize("name", ["reference", "rubin-camera"])
def test_the_numbers_of_the_legs_stand_beside_them(name: str) -> None:
    """No number in the drawing of a machine lies on a leg, on an edge of its plate or on the frame of the panel."""
    figure = still_figure(drawing_chart(ht.load_hexapod(name)))
    figure.draw_without_rendering()
    for axes in figure.axes:
        frame = axes.get_window_extent()
        texts = [text for text in axes.texts if text.get_text()]
        assert texts
        for text in texts:
            box = text.get_window_extent()
            assert frame.x0 < box.x0 < box.x1 < frame.x1
            for line in axes.lines:
                near = line.get_label() == "legs" or line.get_color() == text.get_color()
                if line.get_linestyle() == "None" or not near:
                    continue
                x, y = axes.transData.transform(np.column_stack([line.get_xdata(), line.get_ydata()])).T
                way = np.interp(np.arange(0.0, len(x) - 1.0, 1e-3), np.arange(len(x)), x)
                high = np.interp(np.arange(0.0, len(x) - 1.0, 1e-3), np.arange(len(x)), y)
                over = (way > box.x0) & (way < box.x1) & (high > box.y0) & (high < box.y1)
                assert not over.any(), (text.get_text(), line.get_label())


@pytest.mark.parametrize("platform", [PlateLaw(1.6e-6, "top"), None])
def test_a_budget_is_told_whatever_the_plates_carry(platform: PlateLaw | None, tmp_path: Path) -> None:
    """A machine with a thermometer on its platform, or without a law for it, has the budget on its page."""
    machine = ht.load_hexapod("reference")
    assert machine.thermal is not None
    warm = ThermalModel(machine.thermal.legs, platform, PlateLaw(1.6e-6))
    file = write_hexapod(replace(machine, thermal=warm), tmp_path / "own")
    report = report_of(subject_of(str(file)), None, silent)
    assert "budget" in report.facts
    assert not [note for note in report.notes if "budget" in note]
