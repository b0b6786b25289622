"""Pages of Markdown as their readers meet them: links, anchors, and blocks that are typed in, in order."""

from __future__ import annotations

import contextlib
import doctest
import io
import os
import re
import shlex
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from markdown_it import MarkdownIt
from markdown_it.token import Token

from hexathermal.cli import main

ROOT = Path(__file__).resolve().parent.parent
TYPED = {"console", "shell", "bash", "sh"}
SHELL = re.compile(r"[|<>&;*?$`~]|^\w+=")
EXIT = re.compile(r"#\s*exits? (\d+)\s*$")
HTML_ANCHOR = re.compile(r"<a (?:id|name)=\"([^\"]+)\"")


def tokens(page: Path) -> list[Token]:
    """Return the tokens of a page's blocks."""
    return MarkdownIt("commonmark").enable("table").parse(page.read_text(encoding="utf-8"))


def links(page: Path) -> Iterator[str]:
    """Give the targets of all links and pictures."""
    for token in tokens(page):
        for child in token.children or ():
            target = child.attrGet("href") or child.attrGet("src")
            if target:
                yield str(target)


def anchors(page: Path) -> set[str]:
    """Return what a link can aim at in a page: headings as a forge names them, and anchors written out."""
    found, blocks = set(HTML_ANCHOR.findall(page.read_text(encoding="utf-8"))), tokens(page)
    for k, token in enumerate(blocks):
        if token.type == "heading_open":
            text = "".join(child.content for child in blocks[k + 1].children or ())
            slug = re.sub(r"[^\w\- ]", "", text.lower()).replace(" ", "-")
            found.add(next(name for n in range(99) if (name := f"{slug}-{n}" if n else slug) not in found))
    return found


def blocks(page: Path) -> Iterator[tuple[str, str, int]]:
    """Give kind, text and first line of each block that a reader runs."""
    for token in tokens(page):
        kind = token.info.split()[0] if token.type == "fence" and token.info.split() else ""
        first = token.content.lstrip().split("\n")[0]
        if kind in TYPED and "no-run" not in first:
            yield "console", token.content, (token.map or [0])[0] + 2
        if kind in {"pycon", "python"} and ">>>" in token.content:
            yield "python", token.content, (token.map or [0])[0] + 2


def commands(text: str) -> Iterator[tuple[str, list[str], int]]:
    """Give each command of a block, what the block shows as its output, and the exit code it tells.

    With prompts (``$ ``), other lines are output; without, each line is a command. Lines that end in a backslash go on,
    and so does a here-document. ``# exits 1`` at the end of a command says that it ends so.
    """
    lines, prompted = text.splitlines(), any(line.startswith("$ ") for line in text.splitlines())
    k = 0
    while k < len(lines):
        line = lines[k].removeprefix("$ ")
        k += 1
        if not line.strip() or line.lstrip().startswith("#"):
            continue
        while line.endswith("\\"):
            line = f"{line[:-1]}{lines[k].strip()}"
            k += 1
        told = EXIT.search(line)
        if here := re.search(r"<<-?\s*['\"]?(\w+)", line):
            end = lines.index(here[1], k)
            line = "\n".join([line, *lines[k : end + 1]])
            k = end + 1
        shown = []
        while prompted and k < len(lines) and not lines[k].startswith("$ "):
            shown.append(lines[k])
            k += 1
        yield line, shown, int(told[1]) if told else 0


def typed(command: str) -> tuple[int, str, str]:
    """Run a command in the current folder and return exit code, stdout and stderr; ours in this process."""
    words = [] if "\n" in command else shlex.split(command, comments=True)
    if words[:1] == ["hexathermal"] and not SHELL.search(EXIT.sub("", command).split(" #")[0]):
        out, err = io.StringIO(), io.StringIO()
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            code = main(words[1:])
        return code, out.getvalue(), err.getvalue()
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ.get('PATH', '')}"
    environment = {**os.environ, "PATH": path, "PYTHONWARNINGS": "default"}
    done = subprocess.run(["bash", "-ec", command], capture_output=True, text=True, env=environment, check=False)
    return done.returncode, done.stdout, done.stderr


def squeezed(text: str) -> str:
    """Return a text whose white space is single blanks."""
    return " ".join(text.split())


def type_in(page: Path, folder: Path, monkeypatch: pytest.MonkeyPatch) -> int:
    """Do what a page says, from its first line to its last, in a folder; return how many blocks were run.

    Every command ends with the exit code that the page tells, 0 where it tells none; every line shown below a command
    is one of its output. Python examples print what the page says, and keep their names from block to block.
    """
    monkeypatch.chdir(folder)
    known: dict[str, Any] = {"__name__": "__main__"}
    runner, parser = doctest.DocTestRunner(optionflags=doctest.NORMALIZE_WHITESPACE), doctest.DocTestParser()
    count = 0
    for kind, text, line in blocks(page):
        count += 1
        if kind == "python":
            test = parser.get_doctest(text, known, page.name, str(page), line - 1)
            said: list[str] = []
            runner.run(test, out=said.append, clear_globs=False)
            known = test.globs
            assert not said, "".join(said)
            continue
        for command, shown, wanted in commands(text):
            code, out, err = typed(command)
            place = f"{page.name}, block at line {line}: {command}"
            assert code == wanted, f"{place}\nexit code {code}, not {wanted}\n{out}{err}"
            everything = squeezed(f"{out}\n{err}")
            for one in shown:
                for part in re.split(r"\.\.\.|…", one):
                    assert squeezed(part) in everything, f"{place}\ndoes not say {part!r} but\n{out}{err}"
    return count
