"""Chromium, where it is installed: for the pictures of the documentation, and for the tests of pages."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from typing import Any

PROGRAMS = ("chromium", "google-chrome", "chrome")
ARGUMENTS = ["--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
"""WebGL is drawn by software: pictures are the same on every computer."""

PATIENCE_MS = 120_000
"""A busy computer may take so long to start it."""


@contextmanager
def chromium() -> Iterator[Any]:
    """Give a browser of playwright: the program of this computer, or the one that playwright brought.

    Raises
    ------
    ModuleNotFoundError
        playwright is not installed.
    playwright.sync_api.Error
        There is no browser.
    """
    playwright: Any = import_module("playwright.sync_api")
    program = next((place for name in PROGRAMS if (place := shutil.which(name))), None)
    with playwright.sync_playwright() as play:
        browser = play.chromium.launch(executable_path=program, args=ARGUMENTS, timeout=PATIENCE_MS)
        try:
            yield browser
        finally:
            browser.close()
