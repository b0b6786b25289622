"""Draw docs/report-campaign.png and docs/report-machine.png: parts of two reports in Chromium, light and dark.

Needs playwright and pillow, as the viewer's picture does.
"""

from __future__ import annotations

import io
import tempfile
from pathlib import Path

from chromium import chromium
from PIL import Image

from hexathermal.cli import main as hexathermal

DOCS = Path(__file__).resolve().parent.parent / "docs"
WIDTH, HEIGHT, SHOWN = 900, 620, 640
"""Of the window, and of the picture [px]."""


def screenshot(file: Path, figure: str, scheme: str) -> Image.Image:
    """Return what a page shows from one of its figures on, as a picture."""
    with chromium() as browser:
        page = browser.new_page(viewport={"width": WIDTH, "height": HEIGHT}, color_scheme=scheme)
        page.goto(file.as_uri())
        page.wait_for_function("document.documentElement.dataset.report === 'drawn'")
        if figure:
            page.evaluate(
                "name => document.getElementById(name).previousElementSibling.scrollIntoView({behavior: 'instant'})",
                figure,
            )
            page.wait_for_timeout(300)
        shot: bytes = page.screenshot()
    return Image.open(io.BytesIO(shot)).convert("RGB")


def beside(parts: list[Image.Image], file: Path) -> None:
    """Write pictures side by side, small."""
    sheet = Image.new("RGB", (WIDTH * len(parts), HEIGHT), "white")
    for k, part in enumerate(parts):
        sheet.paste(part, (WIDTH * k, 0))
    small = sheet.resize((SHOWN * len(parts), round(HEIGHT * SHOWN / WIDTH)), Image.Resampling.LANCZOS)
    small.save(file, optimize=True)
    print(f"{file}: {file.stat().st_size / 1e3:.0f} kB")


def main() -> None:
    """Draw both reports."""
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        leg, machine = folder / "leg.html", folder / "machine.html"
        hexathermal(["simulate", "bench", "--out", str(folder / "leg"), "--runs", "4", "--validation", "1"])
        hexathermal(["report", str(folder / "leg"), "--out", str(leg)])
        hexathermal(["report", "reference", "--out", str(machine)])
        beside([screenshot(leg, "", "light"), screenshot(leg, "paper-figure-8-run-05", "dark")],
               DOCS / "report-campaign.png")  # fmt: skip
        beside([screenshot(machine, "", "light"), screenshot(machine, "day", "dark")], DOCS / "report-machine.png")


if __name__ == "__main__":
    main()
