"""The documentation's site, built once for all tests of a run, and what its pages hold."""

from __future__ import annotations

import fcntl
import subprocess
import sys
from collections import defaultdict
from dataclasses import dataclass, field
from html.parser import HTMLParser
from importlib.util import find_spec
from pathlib import Path

import pytest

from tests.pages import ROOT

NEEDED = ("sphinx", "myst_nb", "pydata_sphinx_theme", "sphinx_design")
ASKING = {"a": "href", "link": "href", "script": "src", "img": "src", "iframe": "src", "source": "src"}


def built_site(folder: Path) -> Path:
    """Build the site below a folder, unless another process has done it; fail with what was complained of."""
    if missing := [name for name in NEEDED if find_spec(name) is None]:
        pytest.skip(f"{', '.join(missing)} not installed (extra 'docs')")
    site, said = folder / "site", folder / "site.log"
    with (folder / "site.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not said.exists():
            done = subprocess.run(
                [sys.executable, "-m", "sphinx", "-W", "--keep-going", "-q", "-b", "html",
                 "-D", "nb_execution_mode=off", "-d", str(folder / "doctrees"), str(ROOT / "docs"), str(site)],
                capture_output=True, text=True, check=False,
            )  # fmt: skip
            said.write_text(done.stdout + done.stderr if done.returncode or done.stderr else "", encoding="utf-8")
    assert said.read_text(encoding="utf-8") == "", said.read_text(encoding="utf-8")
    return site


@dataclass
class Page(HTMLParser):
    """What stands in a page of HTML: identifiers, what it asks for by tag, pictures without words, headings, text."""

    ids: set[str] = field(default_factory=set)
    asked: defaultdict[str, list[str]] = field(default_factory=lambda: defaultdict(list))
    wordless: list[str] = field(default_factory=list)
    headings: list[int] = field(default_factory=list)
    text: str = ""

    def __post_init__(self) -> None:
        super().__init__()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Note an element."""
        values = dict(attrs)
        self.ids.update(value for key in ("id", "name") if (value := values.get(key)))
        if (target := values.get(ASKING.get(tag, ""))) is not None:
            self.asked[tag].append(target)
        if tag == "img" and not values.get("alt"):
            self.wordless.append(str(values.get("src")))
        if tag in {"h1", "h2", "h3", "h4", "h5", "h6"}:
            self.headings.append(int(tag[1]))

    def handle_data(self, data: str) -> None:
        """Note text."""
        self.text += data


def read_page(file: Path) -> Page:
    """Return what stands in a page."""
    page = Page()
    page.feed(file.read_text(encoding="utf-8"))
    return page
