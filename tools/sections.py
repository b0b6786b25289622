"""Parts of pages that tools write: each stands between two comments that name it and the tool."""

from __future__ import annotations

import argparse
from collections.abc import Collection, Sequence
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


def asked(description: str | None, parts: Collection[str], arguments: Sequence[str] | None) -> Collection[str]:
    """Return the parts that the command line names, or all; another name ends it."""
    parser = argparse.ArgumentParser(description=(description or "").split("\n\n")[0])
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"parts: {', '.join(parts)} (default: all)")
    names: list[str] = parser.parse_args(arguments).names
    unknown = set(names) - set(parts)
    if unknown:
        parser.error(f"no part is called {', '.join(sorted(unknown))}; there are {', '.join(parts)}")
    return names or parts
