"""A page in a real browser, where there is one."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest


def refuse_complaints(file: Path) -> None:
    """Open a page in Chromium at desk and phone width, light and dark: nothing is missing or runs over the edge."""
    playwright = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
    chromium = next(
        (shutil.which(name) for name in ("chromium", "google-chrome", "chrome") if shutil.which(name)), None
    )
    with playwright.sync_playwright() as play:
        try:
            browser = play.chromium.launch(executable_path=chromium, args=["--no-sandbox"])
        except playwright.Error as error:
            pytest.skip(f"there is no browser: {str(error).splitlines()[0]}")
        for width in (1200, 360):
            for scheme in ("light", "dark"):
                view = browser.new_context(viewport={"width": width, "height": 800}, color_scheme=scheme)
                page, said = view.new_page(), list[str]()
                page.on("console", lambda message, said=said: said.append(message.text))
                page.on("requestfailed", lambda request, said=said: said.append(request.url[:80]))
                page.goto(file.as_uri())
                assert said == []
                assert page.evaluate("document.documentElement.scrollWidth") <= width
                assert page.evaluate("[...document.images].every(one => one.complete && one.naturalWidth > 300)")
                shown = page.evaluate("getComputedStyle(document.body).backgroundColor")
                assert shown == ("rgb(255, 255, 255)" if scheme == "light" else "rgb(23, 27, 33)")
        browser.close()
