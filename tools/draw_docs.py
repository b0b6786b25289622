"""Draw docs/pictures: walk the pages, and take the pictures that their own commands write.

Run from the repository's root: ``python tools/draw_docs.py``, or with names of pictures to draw only those.
"""

from __future__ import annotations

import sys
import tempfile
from importlib import import_module
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from PIL import Image

from hexathermal.cli import main as command
from hexathermal.learn.campaign_files import load_campaign
from hexathermal.learn.check import CampaignCheck, check_campaign
from hexathermal.predict.acceptance import decide
from hexathermal.show.campaign_figures import coverage_figure

mpl.use("Agg")

import matplotlib.pyplot as plt

ROOT = Path(__file__).resolve().parent.parent
OUT = ROOT / "docs" / "pictures"
WIDTH, MOST = 1000, 120_000

WRITTEN = {
    "budget": ("tour.md", "budget/contributions.png"),
    "path": ("tutorials/planner.md", "along/path.png"),
    "front": ("tutorials/test-engineer.md", "identified/front.png"),
    "validation": ("tutorials/test-engineer.md", "validated/run-07.png"),
    "stated": ("tutorials/metrologist.md", "stated/contributions.png"),
    "matrices": ("how-to/choose-sensors.md", "identified/matrices.png"),
    "coverage": ("how-to/plan-a-campaign.md", "coverage.png"),
    "direction": ("how-to/read-a-diagnosis.md", "diagnosed/residual-direction.png"),
}
"""Each picture, the page that shows it, and the file in the folder in which the page was walked."""


def walk(page: str, folder: Path) -> None:
    """Do what a page says, and what it leaves to its readers for pictures."""
    pytest: Any = import_module("pytest")
    pages: Any = import_module("tests.pages")
    with pytest.MonkeyPatch.context() as patch:
        pages.type_in(ROOT / "docs" / page, folder, patch)
    if page.endswith("plan-a-campaign.md"):
        draw_coverage(folder)
    if page.endswith("read-a-diagnosis.md"):
        command(["diagnose", str(folder / "loose"), "--sensors", "T07", "--report", str(folder / "diagnosed")])


def draw_coverage(folder: Path) -> None:
    """Draw where the leg was when it was warm, for both plans of the page."""
    files = []
    for name in ("middle", "everywhere"):
        check = check_campaign(load_campaign(folder / name))
        figure = coverage_figure(check) if isinstance(check, CampaignCheck) else None
        if figure is None:
            raise SystemExit(f"{name}: no coverage to draw")
        figure.suptitle(f"plan '{name}'")
        figure.axes[0].set_xlim(-5.0, 255.0)  # mm: the whole stroke
        figure.axes[0].ticklabel_format(useOffset=False)
        files.append(folder / f"coverage-{name}.png")
        figure.savefig(files[-1], dpi=110)
    parts = [Image.open(file).convert("RGB") for file in files]
    whole = Image.new("RGB", (max(part.width for part in parts), sum(part.height for part in parts)), "white")
    top = 0
    for part in parts:
        whole.paste(part, (0, top))
        top += part.height
    whole.save(folder / "coverage.png")


def draw_decision(file: Path) -> None:
    """Draw the two decisions of the metrologist's tutorial: one value, one limit, two uncertainties."""
    value, limit = 2.6523, 3.0  # um
    figure, sides = plt.subplots(1, 2, figsize=(9, 3), sharex=True, layout="constrained")
    for axes, u in zip(sides, (0.30, 0.15), strict=True):
        x = np.linspace(1.5, 4.0, 501)
        density = np.exp(-(((x - value) / u) ** 2) / 2) / (u * np.sqrt(2 * np.pi))
        said = decide(value, u, upper=limit)
        axes.plot(x, density, color="black")
        axes.fill_between(x, density, where=x <= limit, color="#0072b2", alpha=0.3, label="inside")
        axes.fill_between(x, density, where=x >= limit, color="#d55e00", alpha=0.8, hatch="///", label="outside")
        axes.axvline(limit, color="black", linestyle="--")
        axes.set_title(f"u = {u:.2f} µm: {100 * (said.probability or 0.0):.0f} % inside: {said.verdict}")
        axes.set_xlabel("accuracy AP at P1 [µm]; limit 3 µm dashed")
        axes.set_yticks([])
        axes.legend(loc="upper left", frameon=False)
    figure.savefig(file, dpi=110)
    plt.close(figure)


def shrink(source: Path, name: str) -> None:
    """Write a picture of the width of a page, small enough for a repository."""
    picture = Image.open(source).convert("RGB")
    if picture.width > WIDTH:
        picture = picture.resize((WIDTH, round(picture.height * WIDTH / picture.width)), Image.Resampling.LANCZOS)
    file = OUT / f"{name}.png"
    picture.quantize(128, dither=Image.Dither.NONE).save(file, optimize=True)
    size = file.stat().st_size
    print(f"{file.relative_to(ROOT)}: {size / 1e3:.0f} kB")
    if size > MOST:
        raise SystemExit(f"{file.name} is larger than {MOST / 1e3:.0f} kB")


def main(names: list[str]) -> None:
    """Draw the pictures with these names, or all."""
    sys.path.insert(0, str(ROOT))
    OUT.mkdir(exist_ok=True)
    unknown = set(names) - {*WRITTEN, "decision"}
    if unknown:
        raise SystemExit(f"no picture {', '.join(sorted(unknown))}; there are {', '.join(WRITTEN)}, decision")
    wanted = {name: where for name, where in WRITTEN.items() if not names or name in names}
    for page in dict.fromkeys(page for page, _file in wanted.values()):
        with tempfile.TemporaryDirectory() as folder:
            walk(page, Path(folder))
            for name, (shown_in, file) in wanted.items():
                if shown_in == page:
                    shrink(Path(folder) / file, name)
    if not names or "decision" in names:
        with tempfile.TemporaryDirectory() as folder:
            draw_decision(Path(folder) / "decision.png")
            shrink(Path(folder) / "decision.png", "decision")


if __name__ == "__main__":
    main(sys.argv[1:])
