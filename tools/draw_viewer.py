"""Draw docs/viewer.png: the viewer's page of a simulated day, in Chromium. Needs playwright and pillow."""

from __future__ import annotations

import io
import tempfile
from pathlib import Path

import numpy as np
from chromium import chromium
from PIL import Image

import hexathermal as ht
from hexathermal.show.viewer import viewer_page
from hexathermal.show.viewer_day import day_course

OUT = Path(__file__).resolve().parent.parent / "docs" / "viewer.png"


def screenshot(html: str) -> bytes:
    """Return the page at desk width as PNG."""
    with tempfile.TemporaryDirectory() as folder, chromium() as browser:
        file = Path(folder) / "page.html"
        file.write_text(html, encoding="utf-8")
        page = browser.new_page(viewport={"width": 1280, "height": 760}, color_scheme="light")
        page.goto(file.as_uri())
        page.wait_for_timeout(1500)
        shot: bytes = page.screenshot()
    return shot


def main() -> None:
    """Draw the day of the reference machine."""
    course = day_course(ht.load_hexapod("reference"), None, np.array([0.0, 0.0, 0.12]), 1, lambda *_told: None)
    picture = Image.open(io.BytesIO(screenshot(viewer_page(course)))).convert("RGB")
    picture.resize((860, 511), Image.Resampling.LANCZOS).save(OUT, optimize=True)
    print(f"{OUT}: {OUT.stat().st_size / 1e3:.0f} kB")


if __name__ == "__main__":
    main()
