"""Pages in a real browser, where there is one: whatever a test opens must not complain, nor ask for anything else."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import pytest

from tools.chromium import PATIENCE_MS
from tools.chromium import chromium as started

OWN = ("file:", "data:", "blob:")
"""What a page that is one file may ask for."""


@pytest.fixture(scope="module")
def chromium() -> Iterator[Any]:
    """A browser; without one the test is left out."""
    playwright = pytest.importorskip("playwright.sync_api", reason="playwright is not installed (extra 'test')")
    with ExitStack() as stack:
        try:
            browser = stack.enter_context(started())
        except playwright.Error as error:
            pytest.skip(f"there is no browser: {str(error).splitlines()[0]}")
        yield browser


@pytest.fixture
def window(chromium: Any) -> Iterator[Callable[..., Any]]:
    """Open a page; in the end nothing was complained of, nothing is missing, and nothing was asked for elsewhere.

    A file is opened offline, and has nothing to say at all.
    """
    contexts, said = list[Any](), list[str]()

    def open_page(address: str, width: int = 1000, scheme: str = "light", height: int = 800, **more: Any) -> Any:
        alone = address.startswith("file:")
        own = OWN if alone else ("data:", "{0.scheme}://{0.netloc}/".format(urlsplit(address)))
        view = chromium.new_context(
            viewport={"width": width, "height": height}, color_scheme=scheme, offline=alone, **more
        )
        contexts.append(view)
        view.set_default_timeout(PATIENCE_MS)
        page = view.new_page()
        page.on("console", lambda message: _idle(message, alone) or said.append(message.text))
        page.on("pageerror", lambda error: said.append(str(error)))
        page.on("request", lambda request: request.url.startswith(own) or said.append(f"asks for {request.url[:80]}"))
        page.on("requestfailed", lambda request: said.append(f"does not get {request.url[:80]}"))
        page.goto(address)
        return page

    yield open_page
    for view in contexts:
        view.close()
    assert said == [], said


def _idle(message: Any, alone: bool) -> bool:
    """Return whether a message is no complaint: drawing by software is slow, and a site's theme tells what it does."""
    return "GPU stall" in message.text or not (alone or message.type in ("warning", "error"))


def complaints(window: Callable[..., Any], file: Path) -> list[str]:
    """Open a page at desk and phone width, light and dark; return what is missing, runs over the edge or is pale."""
    found = list[str]()
    for width in (1200, 360):
        for scheme, paper in (("light", "rgb(255, 255, 255)"), ("dark", "rgb(23, 27, 33)")):
            page = window(file.as_uri(), width, scheme)
            where = f"at {width} px, {scheme}:"
            if (wide := page.evaluate("document.documentElement.scrollWidth")) > width:
                found.append(f"{where} the page is {wide} px wide")
            if not page.evaluate("[...document.images].every(one => one.complete && one.naturalWidth > 300)"):
                found.append(f"{where} a picture is missing")
            if (shown := page.evaluate("getComputedStyle(document.body).backgroundColor")) != paper:
                found.append(f"{where} the paper is {shown}")
            tables = (
                "[...document.querySelectorAll('.stacked')].filter(one => one.offsetWidth > one.parentNode.clientWidth)"
            )
            if width < 640 and (count := page.evaluate(f"{tables}.length")):
                found.append(f"{where} {count} tables that are stacked are cut off")
            cut = (
                "[...document.querySelectorAll('.scroll')].filter(one => one.scrollWidth > one.clientWidth && "
                "!one.closest('details')).map(one => one.getAttribute('aria-label'))"
            )
            if width > 640 and (names := page.evaluate(cut)):
                found.append(f"{where} tables are cut off: {', '.join(names)}")
    return found
