"""Draw docs/viewer.png: the viewer's page of a simulated day, in Chromium. Needs playwright and pillow."""

from __future__ import annotations

import io
import shutil
import tempfile
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

import hexathermal as ht
from hexathermal.show.viewer import viewer_page
from hexathermal.show.viewer_day import day_course

OUT = Path(__file__).resolve().parent.parent / "docs" / "viewer.png"
WEBGL = ["--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]


def screenshot(html: str) -> bytes:
    """Return the page at desk width as PNG."""
    playwright: Any = import_module("playwright.sync_api")
    found = next((shutil.which(name) for name in ("chromium", "google-chrome", "chrome") if shutil.which(name)), None)
    with tempfile.TemporaryDirectory() as folder, playwright.sync_playwright() as play:
        file = Path(folder) / "page.html"
        file.write_text(html, encoding="utf-8")
        browser = play.chromium.launch(executable_path=found, args=WEBGL)
        page = browser.new_page(viewport={"width": 1280, "height": 760}, color_scheme="light")
        page.goto(file.as_uri())
        page.wait_for_timeout(1500)
        shot: bytes = page.screenshot()
        browser.close()
    return shot


def main() -> None:
    """Draw the day of the reference machine."""
    course = day_course(ht.load_hexapod("reference"), None, np.array([0.0, 0.0, 0.12]), 1, lambda *_told: None)
    picture = Image.open(io.BytesIO(screenshot(viewer_page(course)))).convert("RGB")
    picture.resize((860, 511), Image.Resampling.LANCZOS).save(OUT, optimize=True)
    print(f"{OUT}: {OUT.stat().st_size / 1e3:.0f} kB")


if __name__ == "__main__":
    main()
