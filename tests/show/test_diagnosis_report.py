"""The report of a diagnosis: one file, nothing from elsewhere, said in words too, in both colour schemes."""

from __future__ import annotations

import json
import re
import shutil
from collections.abc import Callable, Iterator
from dataclasses import replace
from html.parser import HTMLParser
from itertools import pairwise
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import numpy as np
import pytest

from hexathermal.learn.diagnosis.paying import kept_out
from hexathermal.learn.diagnosis.result import Diagnosis, Effect, Quantity, RunResidual
from hexathermal.show.diagnosis_album import pictures_of
from hexathermal.show.diagnosis_page import CSS, table
from hexathermal.show.diagnosis_pictures import BLACK, DARK, PAPER, WIDE_IN, themed_svg
from hexathermal.show.diagnosis_report import report_page, write_report
from hexathermal.show.diagnosis_run_figures import binned, gaps, run_figure, runs_figure, without_steps
from hexathermal.show.diagnosis_tables import diagnosis_facts, joined_words
from hexathermal.show.machine_signals import share
from tests.browser import complaints
from tests.show.drawn_diagnoses import drawn

CASES: dict[str, Any] = {
    "effect": {}, "none": {"verdict": "none"}, "unexplained": {"verdict": "unexplained", "kind": "component"},
    "no proof": {"held": False},
    "bare": {"verdict": "unexplained", "held": False, "limits": (), "confusions": (), "experiments": (), "notes": (),
             "title": ""},
}  # fmt: skip


class Page(HTMLParser):
    """Collects tags, headings and what a page says, spaces that do not break as others; refuses tags not closed."""

    VOID = ("meta", "link", "img", "source", "br")

    def __init__(self, text: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.said: list[tuple[str, str]] = []
        self.feed(text)
        assert not self.open

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attrs)))
        if tag not in self.VOID:
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        if self.open and data.strip():
            self.said.append((self.open[-1], data.replace("\N{NO-BREAK SPACE}", " ")))

    def of(self, *names: str) -> list[dict[str, str | None]]:
        return [attributes for tag, attributes in self.tags if tag in names]


def words_only(found: Diagnosis) -> str:
    """Return the page with a stand-in for each group of pictures."""
    return report_page(found, {name: f"<i>{name}</i>" if group else "" for name, group in pictures_of(found).items()})


@pytest.fixture(scope="module")
def report(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """The folder of a report with an effect."""
    folder = tmp_path_factory.mktemp("report") / "diagnosis"
    found = drawn()
    write_report(found, diagnosis_facts(found), folder, lambda *_: None)
    yield folder
    shutil.rmtree(folder)


@pytest.mark.parametrize("case", CASES)
def test_every_verdict_makes_a_sound_page(case: str) -> None:
    """Each verdict, with and without runs for validation: tags close, headings step down by one, links lead to ids."""
    found = drawn(**CASES[case])
    page = Page(words_only(found))
    levels = [int(tag[1]) for tag, _ in page.tags if re.fullmatch(r"h\d", tag)]
    assert levels[0] == 1
    assert levels.count(1) == 1
    assert all(after - before <= 1 for before, after in pairwise(levels))
    ids = [attributes["id"] for _, attributes in page.tags if "id" in attributes]
    assert len(ids) == len(set(ids))
    assert {str(link["href"])[1:] for link in page.of("a")} <= set(ids)
    assert all("scope" in head for head in page.of("th"))
    assert len(page.of("caption")) == len(page.of("table"))
    assert page.of("html") == [{"lang": "en"}]
    assert not re.search(r"\bnan\b|None|\binf\b", " ".join(text for tag, text in page.said if tag != "style"))


def test_the_finding_stands_first() -> None:
    """Before any other paragraph the page says the sentence of the diagnosis."""
    page = Page(words_only(drawn()))
    assert next(text for tag, text in page.said if tag == "p") == "The residual is backlash of 0.31 ± 0.01 µm."


def test_names_of_runs_cannot_become_tags() -> None:
    """A title and a run with angle brackets are shown as they are, in words and in alternative texts."""
    found = drawn()
    page = Page(words_only(found))
    assert not page.of("b")
    assert any(text == 'Diagnosis of bench <1> & "more", law of T07' for _, text in page.said)
    assert Page(pictures_of(found)["fitted"][0].drawn(Path("/dev/null"))).of("b") == []


def test_nothing_is_loaded_from_elsewhere(report: Path) -> None:
    """Pictures are inside the page, no script and no address of a network."""
    page = Page((report / "report.html").read_text(encoding="utf-8"))
    assert not page.of("script", "iframe", "object")
    for attributes in page.of("img", "source", "link"):
        for name in ("src", "srcset", "href"):
            assert (attributes.get(name) or "data:").startswith("data:")
    assert not re.search(r"url\(|@import", " ".join(text for tag, text in page.said if tag == "style"))


def test_every_picture_says_what_it_shows(report: Path) -> None:
    """Each has an alternative text with numbers, a caption, a narrow variant, and its PNG beside the page."""
    page = Page((report / "report.html").read_text(encoding="utf-8"))
    pictures, names = page.of("img"), [str(one["id"]) for one in page.of("figure")]
    assert len(pictures) == len(names) == len(page.of("figcaption")) == len(page.of("source"))
    assert all(re.search(r"\d", str(one["alt"])) and len(str(one["alt"])) > 40 for one in pictures)
    assert sorted(file.name for file in report.glob("*.png")) == sorted(f"{name}.png" for name in names)
    assert all((report / f"{name}.png").read_bytes().startswith(b"\x89PNG") for name in names)
    assert {"residual-direction", "residual-q", "residual-since_move", "ranking", "gain", "limits"} <= set(names)
    assert "residual-pressure" not in names  # it did not vary


def test_pictures_follow_the_colour_scheme(report: Path) -> None:
    """Each picture has colours for light and dark, and none of the house's colours is fixed."""
    page = Page((report / "report.html").read_text(encoding="utf-8"))
    for attributes in page.of("img"):
        svg = unquote(str(attributes["src"]).split(",", 1)[1])
        rules, drawing = svg.split("</style>", 1)
        assert "prefers-color-scheme:dark" in rules
        assert DARK[BLACK] in rules
        assert DARK[PAPER] in rules
        assert not [colour for colour in DARK if colour.lower() in drawing]
        assert "#000000" not in drawing.replace("stroke:#000000;stroke-opacity:0", "")  # an edge that is not drawn


def _luminance(colour: str) -> float:
    """Return the relative luminance of a colour as WCAG 2 defines it."""
    parts = np.array([int(colour[k : k + 2], 16) for k in (1, 3, 5)]) / 255.0
    linear = np.where(parts <= 0.04045, parts / 12.92, ((parts + 0.055) / 1.055) ** 2.4)
    return float(linear @ [0.2126, 0.7152, 0.0722])


def test_lines_stand_out_in_both_schemes() -> None:
    """Curves have a contrast of 3 : 1 against the paper, letters 4.5 : 1 (WCAG 2, 1.4.11 and 1.4.3)."""
    for scheme in (dict(zip(DARK, DARK, strict=True)), DARK):
        paper = _luminance(scheme[PAPER])
        for colour, shown in scheme.items():
            if colour in (PAPER, "#E4E4E4"):
                continue
            high, low = sorted((paper, _luminance(shown)), reverse=True)
            assert (high + 0.05) / (low + 0.05) > (4.5 if colour == BLACK else 3.0), colour


def test_the_numbers_stand_beside_the_page(report: Path) -> None:
    """diagnosis.json is the diagnosis: numbers that are none are null, numbers of NumPy are numbers."""
    facts = json.loads((report / "diagnosis.json").read_text())
    assert facts["format"] == "hexathermal-diagnosis/1"
    assert facts["parameters"]["pitch_m"] == {"value": 2e-3, "std": None, "unit": "m"}
    assert facts["candidates"][2]["settings"] == {"bumps": 6}


def test_a_failed_report_leaves_nothing(tmp_path: Path) -> None:
    """Where a picture cannot be drawn, no half-made folder stays."""
    found = drawn()

    def stop(done: int, _total: int, _label: str) -> None:
        if done == 2:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        write_report(found, {}, tmp_path / "report", stop)
    assert list(tmp_path.iterdir()) == []


def test_runs_with_names_alike_have_files_of_their_own(report: Path) -> None:
    """'proof & test' and 'proof + test' become two files."""
    assert len(list(report.glob("run-proof___test*.png"))) == 2


def test_the_same_picture_gives_the_same_bytes() -> None:
    """A report is reproducible: drawing twice gives one text."""
    found = drawn()
    first, second = (themed_svg(runs_figure(found, found.residuals, WIDE_IN), "x") for _ in range(2))
    assert first == second


def _at_rest() -> Diagnosis:
    """Return a diagnosis whose run moves (windows of 20 s), rests (of 300 s), and has two times without any."""
    moving, resting = 20.0 * np.arange(40), 800.0 + 300.0 * np.arange(12)
    time = np.concatenate([moving, resting, [resting[-1] + 1800.0], resting[-1] + 4000.0 + 20.0 * np.arange(5)])
    size = len(time)
    run = RunResidual("rest", "validation", time, np.linspace(1e-6, 2e-6, size), np.full(size, 1e-7),
                      np.zeros(size), {"q": time})  # fmt: skip
    return replace(drawn(), residuals=(drawn().residuals[0], run))


@pytest.mark.parametrize("draw", [run_figure, lambda found, run, width: runs_figure(found, [run], width)])
def test_curves_go_on_through_rest_and_show_every_window(draw: Callable[..., Any]) -> None:
    """Windows at rest, 300 s apart, are joined; times without rows are left white; a window alone between is a dot."""
    found = _at_rest()
    run = found.residuals[1]
    assert gaps(run.time).tolist() == [52, 53]
    for axes in [one for one in draw(found, run, WIDE_IN).axes if one.get_visible()]:
        dots = [line for line in axes.lines if line.get_linestyle() == "None" and line.get_label() != "measured"]
        curves = [line for line in axes.lines if len(line.get_xdata()) > 10 and line.get_linestyle() != "None"]
        assert len(curves) == 2
        for curve in curves:
            drawn_at = np.asarray(curve.get_xdata())
            assert np.flatnonzero(np.isnan(drawn_at)).tolist() == [52, 54]
        assert [line.get_xdata().tolist() for line in dots] == [[run.time[52] / 3600.0]] * 2
        assert {line.get_color() for line in dots} == {line.get_color() for line in curves}


def test_a_caption_says_what_gaps_are() -> None:
    """Pictures with times without rows say so; those without any do not."""
    said = pictures_of(_at_rest())
    assert "Gaps are times without a settled row." in said["runs"][0].caption
    assert "Gaps" not in said["fitted"][0].caption


def test_rare_rows_and_long_windows_are_no_gaps() -> None:
    """Rows every 20 minutes, and windows of 1200 s of a run of days, are joined; a night without rows is not."""
    assert not len(gaps(1200.0 * np.arange(30)))
    long = np.concatenate([60.0 * np.arange(200), 12000.0 + 1200.0 * np.arange(50), [12000.0 + 1200.0 * 50 + 30000.0]])
    assert gaps(long).tolist() == [250]


def test_means_of_parts_hold_what_they_should(rng: np.random.Generator) -> None:
    """A step with direction is held whole by the means of directions; noise by no more than its number of parts."""
    direction = np.where(rng.random(600) < 0.5, -1.0, 1.0)
    x, y, share = binned(direction, 3.0 * direction)
    assert x.tolist() == [-1.0, 1.0]
    assert y == pytest.approx([-3.0, 3.0])
    assert share == pytest.approx(1.0)
    assert binned(rng.random(600), rng.standard_normal(600))[2] < 0.08
    assert binned(direction, np.zeros(600))[2] == 0.0


def test_a_share_is_none_by_chance_and_whole_of_a_step(rng: np.random.Generator) -> None:
    """Noise follows no signal, whatever the number of rows; a step of it does wholly; what is not known does not count.

    Of 400 signals of noise, at 2e-4 each, more than two have a share in less than one of ten thousand tests.
    """
    chance = [share(rng.random(n), rng.standard_normal(n)) for n in (30, 60, 200, 900) for _ in range(100)]
    assert np.count_nonzero(chance) <= 2
    straight = rng.random(900)
    assert share(straight, straight + 0.5 * rng.standard_normal(900)) == pytest.approx(0.25, abs=0.08)
    side = np.where(rng.random(200) < 0.5, -1.0, 1.0)
    assert share(side, 2.0 * side) == pytest.approx(1.0)
    holes = np.where(rng.random(200) < 0.3, np.nan, side)
    assert share(holes, 2.0 * side) == pytest.approx(1.0)
    assert share(np.ones(200), side) == 0.0
    assert share(np.full(200, np.nan), side) == 0.0


@pytest.mark.long
def test_a_browser_shows_it_without_a_word_of_complaint(report: Path, window: Callable[..., Any]) -> None:
    """Chromium at desk and phone width, light and dark: nothing is missing, nothing runs over the edge."""
    assert complaints(window, report / "report.html") == []


def test_a_step_of_the_zero_is_off_in_the_pictures_of_what_is_left() -> None:
    """A step is no term of the law: what is left after it is found is drawn without it, in its run, from its moment."""
    moment = 3000.0
    step = Effect("zero-jump", "a/b", {"time_s": Quantity(moment, 60.0, "s"), "step_um": Quantity(-0.5, 0.01, "um")},
                  {"run": "a/b"}, 0.98, (), 1e-7, "The residual is zero-jump.", True)  # fmt: skip
    found = drawn(effects=(step,))
    freed = without_steps(found)
    for before, after in zip(found.residuals, freed.residuals, strict=True):
        own = (before.run == "a/b") & (before.time >= moment)
        assert after.after == pytest.approx(before.after + 0.5e-6 * own)
        assert after.before is before.before
    assert "the step of the zero in a/b is taken off" in pictures_of(found)["fitted"][0].caption
    page = words_only(found)
    assert "It is no term of the law" in page
    assert "It joined the law" not in page
    other = drawn()
    assert without_steps(other).residuals == other.residuals


def test_a_step_that_frees_no_coefficient_is_told_as_that() -> None:
    """Where a law freed of a step foretells runs never fitted worse, the step is drawn, and said to change nothing."""
    step = Effect("zero-jump", "a/b", {"time_s": Quantity(3000.0, 60.0, "s"), "step_um": Quantity(-0.5, 0.01, "um")},
                  {"run": "a/b"}, 0.98, (), 1e-7, "The residual is zero-jump.", True)  # fmt: skip
    kept = kept_out(step)
    assert (
        kept.sentence == "The residual is zero-jump; coefficients freed of it foretell runs never fitted worse: "
        "they stay as they were."
    )
    assert joined_words(kept) == "no term"
    found = drawn(effects=(kept,))
    assert any((one.after != other.after).any()
               for one, other in zip(without_steps(found).residuals, found.residuals, strict=True))  # fmt: skip
    page = words_only(found)
    assert "would foretell runs never fitted worse" in page
    assert "the coefficients are freed of it" not in page


def test_an_interval_may_take_a_line_of_its_own() -> None:
    """So a table of many columns has room: in a cell of numbers a line breaks before the bracket and nowhere else."""
    page = table("Room", ("run", "less by (95 %)>", "why"), [("run 1", "20 % (-35 to 53)", "a (b c)")])
    assert "20\N{NO-BREAK SPACE}% (-35\N{NO-BREAK SPACE}to\N{NO-BREAK SPACE}53)</td>" in page
    assert "(95\N{NO-BREAK SPACE}%)</th>" in page
    assert "<td>a (b c)</td>" in page
    assert "td.n{white-space:nowrap}" not in CSS


def test_wide_tables_are_stacked_on_a_phone_and_stay_tables() -> None:
    """A table of five columns says the name of each cell's column, and its roles to readers' aids; a narrow one not."""
    wide = Page(table("Wide", ("run", "a>", "b>", "c", "d"), [("x", "1", "2", "3", "4")]))
    assert [one["data-of"] for one in wide.of("td")] == ["a", "b", "c", "d"]
    assert [one["role"] for one in wide.of("table", "tr", "td")] == ["table", "row", "row", *["cell"] * 4]
    narrow = Page(table("Narrow", ("run", "a>"), [("x", "1")]))
    assert narrow.of("table", "td") == [{}, {"class": "n"}]
