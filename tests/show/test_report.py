"""The report: it knows what it is of, its files hold what is drawn, and what cannot be reported is told."""

from __future__ import annotations

import csv
import io
import json
import re
import shutil
import sys
from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import hexathermal as ht
from hexathermal.cli import main
from hexathermal.errors import ArgumentError, FileFormatError, UnknownNameError
from hexathermal.kinematics.workspace import margins
from hexathermal.learn.campaign_files import load_campaign
from hexathermal.learn.leg_law_files import write_leg_law
from hexathermal.machine.thermal import LegLaw
from hexathermal.machine.writing import write_hexapod
from hexathermal.show.diagnosis_tables import diagnosis_facts
from hexathermal.show.report import report_of, subject_of
from hexathermal.show.report_campaign import campaign_report
from hexathermal.show.report_chart import Bars, Cells, Chart, Curve, Panel, columns_of, csv_text, kept_of
from hexathermal.show.report_files import ENDINGS, write_figures
from hexathermal.show.report_live import MISSING, live_figure
from hexathermal.show.report_machine_charts import drawing_chart, law_chart, travels
from hexathermal.show.report_page import Report, figure_html, report_page
from hexathermal.show.report_still import still_figure
from tests.show.drawn_diagnoses import drawn, plain_law

Said = pytest.CaptureFixture[str]
PAPER = ("paper-figure-4", "paper-figure-6", "paper-figure-7", "paper-figure-8-run-04")


def silent(_done: int, _total: int, _label: str) -> None:
    """Show no progress."""


def budget_json(folder: Path, *more: str) -> Path:
    """Return the file of a budget of the reference machine."""
    file = folder / "budget.json"
    words = ["budget", "--machine", "reference", "--pose", "0", "0", "0", "0", "0", "0", "--temps", "25", *more]
    assert main([*words, "--json", str(file)]) == 0
    return file


@pytest.fixture(scope="module")
def leg(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A small campaign of a leg on the virtual bench."""
    folder = tmp_path_factory.mktemp("bench") / "leg"
    words = ["--runs", "3", "--validation", "1", "--hours", "3", "--interval", "60"]
    assert main(["simulate", "bench", "--out", str(folder), *words]) == 0
    return folder


@pytest.fixture(scope="module")
def leg_report(leg: Path) -> Report:
    return campaign_report(load_campaign(leg), None, silent)


@pytest.fixture(scope="module")
def short(leg_report: Report) -> Report:
    """The report with the first two figures of each section: pages are drawn fast."""
    sections = []
    for one in leg_report.sections:
        kept = [part for part in one.parts if isinstance(part, Chart)][:2]
        sections.append(replace(one, parts=tuple(part for part in one.parts if isinstance(part, str) or part in kept)))
    return replace(leg_report, sections=tuple(sections))


@pytest.fixture(scope="module")
def page(short: Report) -> str:
    return report_page(short)


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


def numbers_in(text: str) -> dict[str, list[float]]:
    """Return the columns of a CSV text, cells that hold nothing left out."""
    header, *rows = list(csv.reader(io.StringIO(text)))
    found: dict[str, list[float]] = {}
    for k, name in enumerate(header):
        cells = [row[k] for row in rows if row[k]]
        if name and cells and re.fullmatch(r"-?[\d.]+(e[+-]?\d+)?", cells[0]):
            found[name] = [float(cell) for cell in cells]
    return found


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
    for text, words in (("{}", "the format is None"), ('{"format":\n ?}', "line 2, column 2: no JSON")):
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


def test_the_page_needs_nothing_from_elsewhere(page: str) -> None:
    """plotly's program is in it once; every source is inside; headings step down by one; every table has a caption."""
    assert page.count('id="store-plotly"') == 1
    assert not re.search(r'(?:src|href)="(?!data:|#)', page)
    levels = [int(level) for level in re.findall(r"<h(\d)", page)]
    assert levels[0] == 1
    assert all(after - before <= 1 for before, after in pairwise(levels))
    ids = re.findall(r' id="([^"]+)"', page)
    assert len(ids) == len(set(ids))
    assert page.count("<table>") == page.count("<caption>")
    assert page.count('<img class="still"') == page.count("<figcaption>") == page.count('class="live"')
    assert len(page.encode()) < 8e6


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


@pytest.fixture
def quick(monkeypatch: pytest.MonkeyPatch) -> None:
    """Leave plotly's program out of the page: what is tested here does not need it."""
    monkeypatch.setattr("hexathermal.show.report_page.program", lambda: "")


@pytest.mark.usefixtures("quick")
def test_the_command_writes_and_never_overwrites(tmp_path: Path, capsys: Said) -> None:
    """A page and its figures once; again only by --force; the answer as JSON names both."""
    file, out, figures = budget_json(tmp_path), tmp_path / "page.html", tmp_path / "figures"
    words = ["report", str(file), "--out", str(out)]
    capsys.readouterr()
    assert main([*words, "--figures", str(figures), "--json", "-"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["format"] == "hexathermal-report/1"
    assert told["kind"] == "budget"
    assert told["written"][0] == str(out)
    assert sorted(Path(name).name for name in told["written"][1:]) == sorted(one.name for one in figures.iterdir())
    out.write_text("kept")
    assert main(words) == 2
    assert "exists already" in capsys.readouterr().err
    assert main(["report", str(file), "--out", str(tmp_path / "b.html"), "--figures", str(figures)]) == 2
    assert "contributions.png" in capsys.readouterr().err
    assert out.read_text() == "kept"
    assert main([*words, "--force"]) == 0
    assert out.read_text(encoding="utf-8").startswith("<!DOCTYPE html>")


def test_nothing_is_written_into_what_is_read(leg: Path, monkeypatch: pytest.MonkeyPatch, capsys: Said) -> None:
    """Neither by name, nor by the name that nobody gave inside the folder of the campaign."""
    before = sorted(leg.iterdir())
    monkeypatch.chdir(leg)
    assert main(["report", "."]) == 2
    assert "lies inside leg, which is read" in capsys.readouterr().err
    assert main(["report", str(leg), "--out", "/tmp/x.html", "--figures", str(leg / "figures")]) == 2
    assert sorted(leg.iterdir()) == before


@pytest.mark.parametrize(
    ("words", "code", "said"),
    [
        (["{tmp}"], 2, "nothing that a report can be of"),
        (["refrence"], 2, "did you mean 'reference'"),
        (["{tmp}/odd.json"], 3, "the format is 'odd'"),
        (["{tmp}/broken.json"], 3, "no JSON"),
        (["{tmp}/empty.json"], 3, "no budget that can be read: 'bias_uncorrected' is missing"),
        (["{tmp}/odd.txt"], 2, "cannot tell what"),
        (["reference", "--out", "{tmp}/page.pdf"], 2, "the name of a page ends in .html"),
        (["reference", "--out", "{tmp}/none/page.html"], 2, "there is no folder"),
        (["reference", "--figures", "{tmp}/odd.txt"], 2, "it is no folder"),
        (["reference", "--law", "leg.toml"], 2, "held against a measured campaign"),
    ],
)
def test_wrong_input_is_told(words: list[str], code: int, said: str, tmp_path: Path, capsys: Said) -> None:
    """Each says what is wrong, ends with the documented code, shows no traceback and writes nothing."""
    texts = {"odd.json": '{"format": "odd"}', "broken.json": "{", "odd.txt": "",
             "empty.json": '{"format": "hexathermal-budget/1"}'}  # fmt: skip
    for name, text in texts.items():
        (tmp_path / name).write_text(text)
    given = [word.format(tmp=tmp_path) for word in words]
    if "--out" not in given:
        given += ["--out", str(tmp_path / "page.html")]
    assert main(["report", *given]) == code
    error = capsys.readouterr().err
    assert said in error
    assert "Traceback" not in error
    assert sorted(one.name for one in tmp_path.iterdir()) == sorted(texts)


def test_without_plotly_the_extra_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Said) -> None:
    """Nothing is worked out before; the message says what to install."""
    monkeypatch.setitem(sys.modules, "plotly.offline", None)
    assert main(["report", "reference", "--out", str(tmp_path / "page.html")]) == 2
    assert "pip install 'hexathermal[report]'" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []
    assert MISSING.startswith("a report needs plotly")


@pytest.mark.usefixtures("quick")
def test_an_interrupt_leaves_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Said) -> None:
    """Ctrl-C while figures are written: neither page nor folder."""
    file, calls = budget_json(tmp_path), []

    def stop(*_named: Any) -> None:
        calls.append(1)
        raise KeyboardInterrupt

    monkeypatch.setattr("hexathermal.show.report_files.draw", stop)
    out = tmp_path / "page.html"
    assert main(["report", str(file), "--out", str(out), "--figures", str(tmp_path / "figures")]) == 130
    assert calls
    assert "nothing half-written" in capsys.readouterr().err
    assert [one.name for one in tmp_path.iterdir()] == ["budget.json"]


@pytest.fixture(scope="module")
def shown(page: str) -> Iterator[Any]:
    """Open pages in Chromium, offline; nothing is complained of, and nothing but the file is asked for."""
    playwright = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
    found = next((shutil.which(name) for name in ("chromium", "google-chrome", "chrome") if shutil.which(name)), None)
    with playwright.sync_playwright() as play:
        try:
            browser = play.chromium.launch(executable_path=found, args=["--no-sandbox"])
        except playwright.Error as error:
            pytest.skip(f"there is no browser: {str(error).splitlines()[0]}")
        yield browser
        browser.close()


@pytest.fixture
def opened(shown: Any, page: str, tmp_path: Path) -> Iterator[Any]:
    """Open the leg's page at a width, in a scheme, when its plots are drawn."""
    contexts, said, asked = [], list[str](), list[str]()
    file = tmp_path / "page.html"
    file.write_text(page, encoding="utf-8")

    def open_page(width: int = 1100, scheme: str = "light", scripts: bool = True) -> Any:
        contexts.append(shown.new_context(viewport={"width": width, "height": 800}, color_scheme=scheme, offline=True,
                                          java_script_enabled=scripts))  # fmt: skip
        one = contexts[-1].new_page()
        one.on("console", lambda message: said.append(message.text))
        one.on("pageerror", lambda error: said.append(str(error)))
        one.on("request", lambda request: asked.append(request.url))
        one.goto(file.as_uri())
        if scripts:
            one.wait_for_function("document.documentElement.dataset.report === 'drawn'")
        return one

    yield open_page
    assert said == []
    assert all(url.startswith(("file:", "data:", "blob:")) for url in asked), asked
    for context in contexts:
        context.close()


def test_plots_are_drawn_at_desk_and_phone_in_both_schemes(opened: Any, short: Report) -> None:
    """Every figure has a plot; nothing runs over the edge; a dark page has light letters in its plots."""
    for width, scheme, ink in ((1100, "light", "rgb(26, 26, 26)"), (360, "dark", "rgb(232, 234, 237)")):
        one = opened(width, scheme)
        assert one.locator("figure.drawn .live svg.main-svg >> nth=0").count() == 1
        assert one.locator("figure.drawn").count() == len(short.charts)
        assert one.evaluate("document.documentElement.scrollWidth") <= width
        assert one.locator(".still >> visible=true").count() == 0
        letters = one.locator(".xtick text").first
        assert letters.evaluate("one => getComputedStyle(one).fill") == ink


def test_a_plot_obeys_keys_and_buttons(opened: Any) -> None:
    """Plus zooms in, 0 shows all, an arrow moves; a button hides a curve and says so; CSV saves what is drawn."""
    one = opened()
    pane = one.locator("#paper-figure-8-run-04 .live")
    span = "one => one._fullLayout.xaxis.range"
    pane.focus()
    whole = pane.evaluate(span)
    one.keyboard.press("+")
    near = pane.evaluate(span)
    assert near[1] - near[0] == pytest.approx(0.7 * (whole[1] - whole[0]))
    one.keyboard.press("ArrowRight")
    assert pane.evaluate(span)[0] > near[0]
    one.keyboard.press("0")
    assert pane.evaluate(span) == pytest.approx(whole)
    residual = one.locator("#paper-figure-8-run-04 .curve", has_text="residual")
    residual.focus()
    one.keyboard.press("Enter")
    assert residual.get_attribute("aria-pressed") == "false"
    visible = "one => one._fullData.filter(trace => trace.visible === true).map(trace => trace.name)"
    assert "residual" not in pane.evaluate(visible)
    assert "measured" in pane.evaluate(visible)
    with one.expect_download() as saved:
        one.locator("#paper-figure-8-run-04 .save").click()
    assert saved.value.suggested_filename == "paper-figure-8-run-04.csv"
    header = Path(saved.value.path()).read_text(encoding="utf-8").splitlines()[0]
    assert header.startswith("time_h,rod_extension_mm")


def test_the_plot_draws_the_numbers_of_the_file(opened: Any, leg_report: Report) -> None:
    """What plotly holds of figure 8 in the browser is what its CSV holds."""
    chart = next(one for one in leg_report.charts if one.name == "paper-figure-8-run-04")
    told = numbers_in(csv_text(columns_of(chart)))
    pane = opened().locator("#paper-figure-8-run-04 .live")
    traces = pane.evaluate("one => Object.fromEntries(one.data.map(trace => [trace.name, Array.from(trace.y)]))")
    for name in ("measured", "predicted", "residual"):
        assert traces[name] == pytest.approx(told[f"{name}_um"], rel=1e-6)


def test_paper_and_readers_without_scripts_get_the_still_pictures(opened: Any, tmp_path: Path) -> None:
    """On paper, and without scripts, every picture is seen, and no plot, button or empty frame is."""
    one = opened(1100, "dark")
    one.emulate_media(media="print", color_scheme="light")
    count = one.locator("figure").count()
    assert one.locator(".still >> visible=true").count() == count
    assert one.locator(".live >> visible=true").count() == 0
    assert one.locator(".tools >> visible=true").count() == 0
    assert one.pdf()[:5] == b"%PDF-"
    plain = opened(360, "light", False)
    assert plain.locator(".still >> visible=true").count() == count
    assert plain.locator(".live >> visible=true").count() == 0


def test_the_page_is_accessible(opened: Any) -> None:
    """axe finds no violation, with the tables of numbers open; in a dark scheme contrast is enough too."""
    axe = pytest.importorskip("axe_playwright_python.sync_playwright", reason="axe-playwright-python is not installed")
    for scheme, options in (("light", {}), ("dark", {"runOnly": ["color-contrast"]})):
        one = opened(1100, scheme)
        if not options:
            one.evaluate("document.querySelectorAll('details').forEach(one => { one.open = true; })")
        # a plot is one picture to a reader: its frame is named, what is inside is not looked at
        found = axe.Axe().run(one, context={"exclude": [[".main-svg"]]}, options=options)
        assert [(item["id"], item["nodes"][0]["html"][:120]) for item in found.response["violations"]] == []


def test_a_matrix_keeps_its_colours_in_a_dark_scheme(opened: Any) -> None:
    """The scale of figure 6 is the same in both schemes, so that dark stays worse and bright better."""
    scale = "one => JSON.stringify(one.data[0].colorscale)"
    found = {opened(1100, scheme).locator("#paper-figure-6 .live").evaluate(scale) for scheme in ("light", "dark")}
    assert len(found) == 1
