"""Every example in README and docs runs and prints what it says; every link leads somewhere."""

from __future__ import annotations

import doctest
import re
from pathlib import Path
from urllib.parse import urlsplit

import pytest

import hexathermal as ht
from tests.pages import ROOT, anchors, blocks, links, tokens, type_in

BUILT = ("docs/_build", "docs/reference/generated")
PAGES = sorted(
    page
    for place in ("*.md", "docs/**/*.md", "models/**/*.md", "examples/*.md")
    for page in ROOT.glob(place)
    if not page.relative_to(ROOT).as_posix().startswith(BUILT)
)
ADDRESS = re.compile(r"https?://[^\s)>\"'`\]]+")
ADDRESSES = {"https://github.com/lsst-ts/ts_mthexapod"}
"""All that pages name outside the repository. Tests ask nobody; who adds one looks whether it answers."""

WALKS = ("README.md", "docs/tour.md", "docs/tutorials/*.md", "docs/how-to/*.md")
WALKED = sorted(page for place in WALKS for page in ROOT.glob(place) if page.name != "index.md")


def name(page: Path) -> str:
    """Return a page's name in the tests."""
    return str(page.relative_to(ROOT))


@pytest.mark.parametrize("page", [page for page in PAGES if page not in WALKED], ids=name)
def test_examples_of_a_page_run(page: Path) -> None:
    """What a page's examples print is what the page says."""
    failed, _count = doctest.testfile(str(page), module_relative=False, optionflags=doctest.NORMALIZE_WHITESPACE)
    assert failed == 0


@pytest.mark.parametrize("page", PAGES, ids=name)
def test_examples_of_a_page_look_like_code(page: Path) -> None:
    """What is typed at a prompt stands in a block of code, never in a quotation of a quotation of a quotation."""
    assert [token.map for token in tokens(page) if token.type == "blockquote_open" and token.level > 0] == []


@pytest.mark.long
@pytest.mark.parametrize("page", WALKED, ids=name)
def test_a_page_can_be_walked(page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Who types in what a page says, commands and Python, in an empty folder from top to bottom, gets what it shows."""
    assert type_in(page, tmp_path, monkeypatch) == len(list(blocks(page)))


@pytest.mark.parametrize("page", PAGES, ids=name)
def test_links_of_a_page_lead_somewhere(page: Path) -> None:
    """Relative links and pictures exist, and so does the heading that a link names."""
    for link in links(page):
        if "://" in link or link.startswith("mailto:"):
            continue
        target, _, anchor = link.partition("#")
        file = page.parent / target if target else page
        assert file.exists(), f"{page.name} links to {target}, which does not exist"
        if anchor and file.suffix == ".md":
            assert anchor in anchors(file), f"{page.name} links to {link}; {file.name} has no such heading"


def test_addresses_outside_are_known() -> None:
    """Pages lead outside to a few addresses only, each looked at once: a misspelt one, or one in clear, is none."""
    named = {found.rstrip(".,;:") for page in PAGES for found in ADDRESS.findall(page.read_text(encoding="utf-8"))}
    assert named == ADDRESSES
    for address in named:
        parts = urlsplit(address)
        assert (parts.scheme, parts.port, parts.query) == ("https", None, "")
        assert re.fullmatch(r"([a-z0-9-]+\.)+[a-z]{2,}", parts.netloc)


@pytest.mark.parametrize("page", [page for page in PAGES if "<!-- end of " in page.read_text("utf-8")], ids=name)
def test_parts_that_tools_write_are_written(page: Path) -> None:
    """Each part that a tool writes has an end, holds something, and is known to that tool by its name."""
    text = page.read_text(encoding="utf-8")
    parts = re.findall(r"<!-- ([\w ]+): (tools/\w+\.py) -->\n(.*?)<!-- end of \1 -->", text, flags=re.DOTALL)
    assert len(parts) == text.count("<!-- end of ") == len(re.findall(r"<!-- [\w ]+: tools/", text))
    for part, tool, written in parts:
        assert f'"{part}"' in (ROOT / tool).read_text(encoding="utf-8"), f"{tool} writes no {part!r}"
        assert re.search(r"\d", written), part


def test_the_machine_of_the_formats_page_loads(tmp_path: Path) -> None:
    """The example of a machine file is one: it loads, and corrects with its thirteen thermometers."""
    text = (ROOT / "docs" / "formats.md").read_text(encoding="utf-8")
    file = tmp_path / "hexapod.toml"
    file.write_text(text.split("```toml\n")[1].split("```")[0], encoding="utf-8")
    hexapod = ht.load_hexapod(file)
    assert len(hexapod.sensor_names) == 13
    assert hexapod.corrected_leg_lengths(hexapod.home, [22.0] * 13).shape == (6,)
