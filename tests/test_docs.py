"""Every example in README and docs runs and prints what it says; every link leads somewhere; examples run."""

from __future__ import annotations

import doctest
import re
import runpy
from pathlib import Path

import pytest

import hexathermal as ht

ROOT = Path(__file__).resolve().parent.parent
PAGES = sorted([*ROOT.glob("*.md"), *ROOT.glob("docs/**/*.md"), *ROOT.glob("models/**/*.md")])
EXAMPLES = sorted(file for file in ROOT.glob("examples/*.py") if file.name != "__init__.py")


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_examples_of_a_page_run(page: Path) -> None:
    """What a page's examples print is what the page says."""
    failed, _count = doctest.testfile(str(page), module_relative=False, optionflags=doctest.NORMALIZE_WHITESPACE)
    assert failed == 0


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_links_of_a_page_lead_somewhere(page: Path) -> None:
    """Relative links and pictures exist."""
    for target in re.findall(r"\]\(([^)#\s]+)(?:#[^)]*)?\)", page.read_text()):
        if "://" not in target and not target.startswith("mailto:"):
            assert (page.parent / target).exists(), f"{page.name} links to {target}, which does not exist"


def test_the_machine_of_the_formats_page_loads(tmp_path: Path) -> None:
    """The example of a machine file is one: it loads, and corrects with its thirteen thermometers."""
    text = (ROOT / "docs" / "formats.md").read_text(encoding="utf-8")
    file = tmp_path / "hexapod.toml"
    file.write_text(text.split("```toml\n")[1].split("```")[0], encoding="utf-8")
    hexapod = ht.load_hexapod(file)
    assert len(hexapod.sensor_names) == 13
    assert hexapod.corrected_leg_lengths(hexapod.home, [22.0] * 13).shape == (6,)


@pytest.mark.parametrize("example", EXAMPLES, ids=lambda file: file.stem)
def test_example_runs_and_is_short(example: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Each example runs in an empty folder and stays under 80 lines."""
    monkeypatch.chdir(tmp_path)
    runpy.run_path(str(example), run_name="__main__")
    assert len(example.read_text().splitlines()) < 80
