"""Parts of pages that tools write: each stands between two comments that name it and the tool."""

from __future__ import annotations

from pathlib import Path
from textwrap import fill

DOCS = Path(__file__).resolve().parent.parent / "docs"


def replaced(page: str, name: str, tool: str, text: str) -> str:
    """Return a page with another text in the part called `name`, which `tool` writes; a page without it is an error."""
    begin, end = f"<!-- {name}: tools/{tool}.py -->\n", f"<!-- end of {name} -->"
    if begin not in page or end not in page:
        raise SystemExit(f"the page has no part {begin.strip()} ... {end}")
    before, rest = page.split(begin, 1)
    return f"{before}{begin}{text.rstrip()}\n{end}{rest.split(end, 1)[1]}"


def write_section(page: str, name: str, tool: str, text: str) -> None:
    """Write a part of a page of docs/ anew, a table or a paragraph, and print it."""
    file = DOCS / page
    text = text if text.startswith("|") else fill(" ".join(text.split()), 118, break_on_hyphens=False)
    print(f"{page}, {name}:\n{text}", flush=True)
    file.write_text(replaced(file.read_text(encoding="utf-8"), name, tool, text), encoding="utf-8")
