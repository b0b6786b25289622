"""Pages and code are spelt as a dictionary of common mistakes wants them; the runner of pages sees what is wrong."""

from __future__ import annotations

import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import pytest

from tests.pages import ROOT, anchors, commands, links, type_in

PLACES = ("README.md", "CHANGELOG.md", "CONTRIBUTING.md", "docs", "hexathermal", "models", "examples", "tools",
          "benchmarks", "pytest_hexathermal.py")  # fmt: skip


@pytest.mark.skipif(find_spec("codespell_lib") is None, reason="codespell is not installed (extra 'dev')")
def test_spelling() -> None:
    """codespell finds no misspelt word in pages and code (words it may skip: [tool.codespell] in pyproject.toml)."""
    done = subprocess.run([sys.executable, "-m", "codespell_lib", *PLACES], cwd=ROOT, capture_output=True, text=True,
                          check=False)  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr


def page_of(folder: Path, text: str) -> Path:
    """Write a page."""
    file = folder / "page.md"
    file.write_text(text, encoding="utf-8")
    return file


def test_a_walk_goes_in_order_in_one_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Commands and Python see each other's files, names last from block to block, a block marked no-run is left out."""
    page = page_of(
        tmp_path,
        "```console\ncat > one.txt <<'EOF'\n12\nEOF\n```\n"
        "```pycon\n>>> import pathlib\n>>> one = int(pathlib.Path('one.txt').read_text())\n\n```\n"
        "```console\n# no-run\nfalse\n```\n"
        "```pycon\n>>> one + 1\n13\n\n```\n"
        "```console\n$ hexathermal --version\nhexathermal ...\n$ test -e \\\n    two.txt  # exits 1\n```\n",
    )
    assert type_in(page, tmp_path, monkeypatch) == 4


@pytest.mark.parametrize(
    "block",
    [
        "```console\nhexathermal machines --no-such-option\n```",
        "```shell\n$ echo yes\nno\n```",
        "```console\nfalse\n```",
        "```pycon\n>>> 1 + 1\n3\n\n```",
        "```console\ntrue  # exits 1\n```",
    ],
)
def test_a_walk_stops_where_the_page_is_wrong(block: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A command that fails, one that succeeds where a failure was promised, and other output than shown are seen."""
    with pytest.raises(AssertionError):
        type_in(page_of(tmp_path, block), tmp_path, monkeypatch)


def test_commands_of_a_block() -> None:
    """Comments are no commands, a backslash goes on, what follows a prompt's line is its output."""
    assert list(commands("# why\na b \\\n   c\nd  # exits 2\n")) == [("a b c", [], 0), ("d  # exits 2", [], 2)]
    assert list(commands("$ a\nx\n\ny\n$ b\n")) == [("a", ["x", "", "y"], 0), ("b", [], 0)]


def test_links_and_anchors_are_found(tmp_path: Path) -> None:
    """Links over two lines, pictures and links in tables count; code does not; headings are named as a forge does."""
    page = page_of(
        tmp_path,
        "# A `b`: C-d (e)\n\n[two\nlines](x.md#y) ![p](p.png) `[no](no.md)`\n\n"
        "| [t](t.md) |\n|---|\n\n## Twice\n## Twice\n",
    )
    assert list(links(page)) == ["x.md#y", "p.png", "t.md"]
    assert anchors(page) == {"a-b-c-d-e", "twice", "twice-1"}
