"""The documentation's site: built without a warning, complete, whole, alone with itself, and open to everybody."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from itertools import pairwise
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import pytest

import hexathermal as ht
from hexathermal.learn.diagnosis.causes import catalogue as leg_causes
from hexathermal.learn.machine_diagnosis.causes import catalogue as machine_causes
from hexathermal.show.commands import found
from tests.pages import ROOT
from tests.site import Page, built_site, read_page

MAIN = ("index.html", "examples.html", "reference/command-line.html", "reference/causes.html",
        "reference/generated/hexathermal.Hexapod.html", "search.html")  # fmt: skip
"""Pages of every kind: text with formulas and tables, pictures, generated ones, lists of pages, the search."""

AXE = {"resultTypes": ["violations"], "preload": False}
"""Every rule of axe but those that fetch style sheets again."""

SEEN = """(() => {
    const one = document.activeElement, style = getComputedStyle(one), box = one.getBoundingClientRect();
    return [one.tagName, box.width > 0 && box.height > 0, style.outlineStyle != "none" || style.boxShadow != "none"];
})()"""
"""Which element has the focus, whether it has a size, and whether it is marked."""


class Quiet(SimpleHTTPRequestHandler):
    """Serves files and keeps no log."""

    def log_message(self, format: str, *args: Any) -> None:
        """Say nothing."""


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory, worker_id: str) -> Path:
    """The site, built without a warning; processes of one run share it."""
    base = tmp_path_factory.getbasetemp()
    return built_site(base if worker_id == "master" else base.parent)


@pytest.fixture(scope="module")
def pages(site: Path) -> dict[Path, Page]:
    """Every page of the site."""
    return {file: read_page(file) for file in sorted(site.rglob("*.html")) if "_static" not in file.parts}


def test_every_page_of_the_docs_is_in_the_site(site: Path) -> None:
    """Each page of docs/ has become one of the site, where it stood."""
    for page in (ROOT / "docs").rglob("*.md"):
        place = page.relative_to(ROOT / "docs")
        if place.parts[0] != "_build":
            assert (site / place.with_suffix(".html")).exists(), place


def test_the_reference_is_complete(site: Path, pages: dict[Path, Page]) -> None:
    """Each public name has a page; each command, cause and bundled machine has its section."""
    for name in ht.__all__:
        assert f"hexathermal.{name}" in pages[site / f"reference/generated/hexathermal.{name}.html"].ids, name
    assert set(found()) <= pages[site / "reference/command-line.html"].ids
    assert {*leg_causes(), *machine_causes()} <= pages[site / "reference/causes.html"].ids
    for name in ht.bundled_hexapods():
        assert name in pages[site / "reference/machines.html"].text


def test_links_of_the_site_lead_somewhere(site: Path, pages: dict[Path, Page]) -> None:
    """Each link, picture, script and style of each page is a file of the site, each anchor stands in its page."""
    broken = []
    for file, page in pages.items():
        for tag, target in ((tag, target) for tag, targets in page.asked.items() for target in targets):
            if "://" in target or target.startswith(("mailto:", "data:")):
                continue
            path, _, anchor = unquote(target).partition("#")
            aim = (file.parent / path.split("?")[0]).resolve() if path else file
            known = pages.get(aim)
            if not aim.exists() or (anchor and tag == "a" and known and anchor not in known.ids):
                broken.append(f"{file.relative_to(site)}: {target}")
    assert broken == []


def test_nothing_is_asked_for_elsewhere(pages: dict[Path, Page]) -> None:
    """No page loads a script, style, picture or frame from outside: the site works offline."""
    for file, page in pages.items():
        loaded = [target for tag, targets in page.asked.items() if tag != "a" for target in targets]
        assert [target for target in loaded if target.startswith(("http:", "https:", "//"))] == [], file.name


def test_pages_are_in_order_and_pictures_have_words(pages: dict[Path, Page]) -> None:
    """Each page has one first heading, no heading skips a level, each picture says what it shows."""
    for file, page in pages.items():
        if file.name in {"search.html", "genindex.html", "py-modindex.html"}:
            continue
        assert page.headings.count(1) == 1, file.name
        assert all(after <= before + 1 for before, after in pairwise(page.headings)), file.name
        assert page.wordless == [], file.name


@pytest.fixture(scope="module")
def address(site: Path) -> Iterator[str]:
    """Where the site is served, to this computer alone."""
    with ThreadingHTTPServer(("127.0.0.1", 0), partial(Quiet, directory=str(site))) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{server.server_port}/"
        server.shutdown()


@pytest.fixture
def opened(window: Callable[..., Any], address: str) -> Callable[..., Any]:
    """Open a page of the site by its name."""
    return lambda name: window(address + name, 1300, height=900)


@pytest.mark.long
@pytest.mark.parametrize("name", MAIN)
def test_a_page_is_open_to_everybody(name: str, opened: Callable[..., Any]) -> None:
    """axe finds nothing at a desk, light and dark; on a telephone nothing runs over the edge."""
    axe = pytest.importorskip("axe_playwright_python.sync_playwright", reason="axe is not installed (extra 'test')")
    page = opened(name)
    for scheme, rules in (("light", {}), ("dark", {"runOnly": ["color-contrast"]})):  # the rest is the same in both
        page.emulate_media(color_scheme=scheme)
        page.wait_for_function("scheme => document.documentElement.dataset.theme === scheme", arg=scheme)
        violations = axe.Axe().run(page, options={**AXE, **rules}).response["violations"]
        assert violations == [], [(one["id"], [node["html"] for node in one["nodes"]][:5]) for one in violations]
    page.set_viewport_size({"width": 360, "height": 900})
    assert page.evaluate("document.documentElement.scrollWidth") <= 360


def test_the_site_is_walked_by_keys(opened: Callable[..., Any]) -> None:
    """The first Tab leads to the way past the navigation; every stop after it is seen; search opens by keys."""
    page = opened("limits.html")
    page.keyboard.press("Tab")
    assert page.evaluate("document.activeElement.textContent.trim()") == "Skip to main content"
    for _ in range(12):
        page.keyboard.press("Tab")
        shown = page.evaluate(SEEN)
        assert shown[1:] == [True, True], shown
    page.keyboard.press("Control+K")
    page.wait_for_selector("dialog[open] input[type=search], .search-button__wrapper.show input[type=search]")
    assert page.evaluate("document.activeElement.type") == "search"


def test_search_finds(opened: Callable[..., Any]) -> None:
    """A search without any server finds the page of a cause and a public name."""
    page = opened("search.html?q=backlash")
    page.wait_for_selector("#search-results li a")
    assert "Catalogue of causes" in page.inner_text("#search-results")
    page = opened("search.html?q=corrected_leg_lengths")
    page.wait_for_selector("#search-results li a")
    assert "corrected_leg_lengths" in page.inner_text("#search-results")
