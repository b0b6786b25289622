"""The report's page: alone with itself, obedient, readable at a desk, on a telephone, on paper, and by everybody."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest

from hexathermal.show.report_chart import columns_of, csv_text
from hexathermal.show.report_page import Report, report_page
from tests.show.reports import numbers_in

SHOWN = ("paper-figure-4", "noise", "paper-figure-6", "paper-figure-8-run-04")
"""A curve, bars, a matrix, curves in panels."""


@pytest.fixture(scope="module")
def short(leg_report: Report) -> Report:
    """The report with one figure of each kind of mark: its page is drawn fast."""
    sections = []
    for one in leg_report.sections:
        kept = tuple(part for part in one.parts if isinstance(part, str) or part.name in SHOWN)
        sections.append(replace(one, parts=kept))
    return replace(leg_report, sections=tuple(sections))


@pytest.fixture(scope="module")
def page(plotly: None, short: Report) -> str:
    return report_page(short)


def test_the_page_needs_nothing_from_elsewhere(page: str) -> None:
    """plotly's program is in it once; every source is inside; headings step down by one; every table has a caption."""
    assert page.count('id="store-plotly"') == 1
    assert not re.search(r'(?:src|href)="(?!data:|#)', page)
    levels = [int(level) for level in re.findall(r"<h(\d)", page)]
    assert levels[0] == 1
    assert all(after - before <= 1 for before, after in pairwise(levels))
    ids = re.findall(r' id="([^"]+)"', page)
    assert len(ids) == len(set(ids))
    assert len(re.findall(r"<table\b", page)) == page.count("<caption>")
    assert page.count('<img class="still') == page.count("<figcaption>") == page.count('class="live"')
    assert len(page.encode()) < 8e6


@pytest.fixture
def opened(window: Callable[..., Any], page: str, tmp_path: Path) -> Callable[..., Any]:
    """Open the leg's page at a width, in a scheme, when its plots are drawn."""
    file = tmp_path / "page.html"
    file.write_text(page, encoding="utf-8")

    def open_page(width: int = 1100, scheme: str = "light", scripts: bool = True) -> Any:
        one = window(file.as_uri(), width, scheme, java_script_enabled=scripts)
        if scripts:
            one.wait_for_function("document.documentElement.dataset.report === 'drawn'")
        return one

    return open_page


@pytest.mark.long
def test_plots_are_drawn_at_desk_and_phone_in_both_schemes(opened: Any, short: Report) -> None:
    """Every figure has a plot; nothing runs over the edge; a dark page has light letters in its plots."""
    for width, scheme, ink in ((1100, "light", "rgb(26, 26, 26)"), (360, "dark", "rgb(232, 234, 237)")):
        one = opened(width, scheme)
        assert one.locator("figure.drawn .live svg.main-svg >> nth=0").count() == 1
        assert one.locator("figure.drawn").count() == len(short.charts)
        assert one.evaluate("document.documentElement.scrollWidth") <= width
        assert one.locator(".still >> visible=true").count() == 0
        ends = one.eval_on_selector_all(".annotation-text", "all => all.map(one => one.getBoundingClientRect().right)")
        assert max(ends) <= width
        letters = one.locator(".xtick text").first
        assert letters.evaluate("one => getComputedStyle(one).fill") == ink


@pytest.mark.long
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


@pytest.mark.long
def test_the_plot_draws_the_numbers_of_the_file(opened: Any, leg_report: Report) -> None:
    """What plotly holds of figure 8 in the browser is what its CSV holds."""
    chart = next(one for one in leg_report.charts if one.name == "paper-figure-8-run-04")
    told = numbers_in(csv_text(columns_of(chart)))
    pane = opened().locator("#paper-figure-8-run-04 .live")
    traces = pane.evaluate("one => Object.fromEntries(one.data.map(trace => [trace.name, Array.from(trace.y)]))")
    for name in ("measured", "predicted", "residual"):
        assert traces[name] == pytest.approx(told[f"{name}_um"], rel=1e-6)


@pytest.mark.long
def test_paper_and_readers_without_scripts_get_the_still_pictures(opened: Any, tmp_path: Path) -> None:
    """On paper, and without scripts, every picture is seen, and no plot, button or empty frame is.

    Words about the page itself, which are its last, take no sheet of paper.
    """
    one = opened(1100, "dark")
    one.emulate_media(media="print", color_scheme="light")
    count = one.locator("figure").count()
    assert one.locator(".still >> visible=true").count() == count
    assert one.locator(".live >> visible=true").count() == 0
    assert one.locator(".tools >> visible=true").count() == 0
    assert not one.locator("footer").is_visible()
    assert one.pdf()[:5] == b"%PDF-"
    plain = opened(360, "light", False)
    assert plain.locator(".still >> visible=true").count() == count
    assert plain.locator(".live >> visible=true").count() == 0


@pytest.mark.long
def test_the_page_is_accessible(opened: Any) -> None:
    """axe finds no violation, with the tables of numbers open; in a dark scheme contrast is enough too."""
    axe = pytest.importorskip("axe_playwright_python.sync_playwright", reason="axe-playwright-python is not installed")
    for scheme, options in (("light", {}), ("dark", {"runOnly": ["color-contrast"]})):
        one = opened(1100, scheme)
        if not options:
            one.evaluate("document.querySelectorAll('details').forEach(one => { one.open = true; })")
        # a plot is one picture to a reader: its frame is named, what is inside is not looked at
        found = axe.Axe().run(one, context={"exclude": [[".main-svg"]]}, options={"preload": False, **options})
        assert [(item["id"], item["nodes"][0]["html"][:120]) for item in found.response["violations"]] == []


@pytest.mark.long
def test_a_matrix_keeps_its_colours_in_a_dark_scheme(opened: Any) -> None:
    """The scale of figure 6 is the same in both schemes, so that dark stays worse and bright better."""
    scale = "one => JSON.stringify(one.data[0].colorscale)"
    found = {opened(1100, scheme).locator("#paper-figure-6 .live").evaluate(scale) for scheme in ("light", "dark")}
    assert len(found) == 1
