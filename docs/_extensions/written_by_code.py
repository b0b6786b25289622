"""Directives whose text the code writes while the site is built: what it says cannot differ from what it does.

``{command-line}``
    Each command's ``--help``, from the parser.
``{causes}``
    A catalogue of causes: ``leg`` or ``machine``.
``{machines}``
    The bundled machines.
``{examples}``
    The files of ``examples/``, each with what it says about itself (its notebooks become pages of their own).
``{other-pages}``
    The pages of docs/ itself that the page does not list already: a new page appears by itself.
"""

from __future__ import annotations

import argparse
import ast
import os
from collections.abc import Iterable
from pathlib import Path
from typing import Any, ClassVar
from unittest import mock

from docutils import nodes
from docutils.parsers.rst import directives
from docutils.statemachine import StringList
from sphinx.application import Sphinx
from sphinx.directives.other import TocTree
from sphinx.ext import autosummary
from sphinx.util.docutils import SphinxDirective

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
NOTEBOOKS = "notebooks"
HELP_COLUMNS = "98"
COLON = "\ue000"
"""Stands for a colon for a while: a letter that no text holds."""

STANDS_FOR = {
    "README.md": "/index.md",
    "CHANGELOG.md": "/reference/changes.md",
    "CONTRIBUTING.md": "/reference/contributing.md",
    "examples/README.md": "/examples.md",
    "examples/hexathermal.ipynb": f"/{NOTEBOOKS}/hexathermal.ipynb",
    "models/README.md": "/reference/machines.md",
}
"""Pages of the site for files that are not in docs/."""


class Written(SphinxDirective):
    """A directive whose Markdown is made by `lines`."""

    has_content = False

    def lines(self) -> Iterable[str]:
        """Return the text."""
        raise NotImplementedError

    def run(self) -> list[nodes.Node]:
        """Parse the text as if it stood in the page."""
        text = StringList("\n".join(self.lines()).splitlines(), source=f"written by {self.name}")
        holder = nodes.Element()
        holder.document = self.state.document
        self.state.nested_parse(text, self.content_offset, holder, match_titles=True)
        return holder.children


def fenced(text: str, language: str = "text") -> list[str]:
    """Return lines of a block of code, with a fence longer than any inside."""
    return [f"~~~~{language}", *text.rstrip().splitlines(), "~~~~", ""]


def parsers(parser: argparse.ArgumentParser, names: tuple[str, ...] = ()) -> Iterable[tuple[str, str]]:
    """Give title and help of each command, and of the commands of a command."""
    yield " ".join(names) or parser.prog, parser.format_help()
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for name, child in action.choices.items():
                yield from parsers(child, (*names, name))


class CommandLine(Written):
    """Each command's help."""

    def lines(self) -> Iterable[str]:
        """Return a section a command."""
        import hexathermal
        from hexathermal.show.usage import parser

        with mock.patch.dict(os.environ, COLUMNS=HELP_COLUMNS, NO_COLOR="1"):
            for title, text in parsers(parser(hexathermal.__version__)):
                yield from (f"## {title}", "", *fenced(text))


class Causes(Written):
    """A catalogue of causes."""

    required_arguments = 1

    def lines(self) -> Iterable[str]:
        """Return a section a cause."""
        if self.arguments[0] == "leg":
            from hexathermal.learn.diagnosis.causes import catalogue
        else:
            from hexathermal.learn.machine_diagnosis.causes import catalogue  # type: ignore[assignment]
        for name, module in catalogue().items():
            cause = module.CAUSE
            yield from (f"### {name}", "", cause.physics, "")
            yield from ("Signature", f": {cause.signature}", "", "Parameters")
            yield ": " + "; ".join(f"`{one.name}` [{one.unit}], {one.prior}" for one in cause.parameters)
            yield from ("", "Confused with", ": " + ", ".join(f"`{other}`" for other in cause.confused_with), "")
            yield from ("Experiment that tells", f": {cause.experiment}", "")
            yield from ("The diagnosis says", f": “{cause.words.replace('{target}', '…')}”", "")


class Machines(Written):
    """The bundled machines."""

    def lines(self) -> Iterable[str]:
        """Return a table."""
        import hexathermal

        yield from ("| name | grade | thermal law | source |", "|---|---|---|---|")
        for name in hexathermal.bundled_hexapods():
            hexapod = hexathermal.load_hexapod(name)
            law = "active" if hexapod.thermal else "none"
            yield f"| `{name}` | {hexapod.grade} | {law} | {hexapod.source or '–'} |"


class Examples(Written):
    """The files of ``examples/``."""

    def lines(self) -> Iterable[str]:
        """Return a section a file: its first docstring line, its text."""
        for file in sorted(EXAMPLES.glob("*.py")):
            if file.name == "__init__.py":
                continue
            self.env.note_dependency(str(file))
            text = file.read_text(encoding="utf-8")
            said = (ast.get_docstring(ast.parse(text)) or "").splitlines()[0]
            yield from (f"## {file.stem.replace('_', ' ').capitalize()}", "", said, "", f"`examples/{file.name}`", "")
            yield from fenced(text, "python")


class OtherPages(TocTree):
    """A list of the pages that the page does not name yet, nor ``:but:`` (pages listed elsewhere)."""

    option_spec: ClassVar[dict[str, Any]] = {**TocTree.option_spec, "but": directives.unchanged_required}

    def run(self) -> list[nodes.Node]:
        """List them by name."""
        here = self.env.doc2path(self.env.docname).read_text(encoding="utf-8").splitlines()
        listed = {self.env.docname, *here, *self.options.pop("but", "").split()}
        pages = [page for page in sorted(self.env.found_docs) if "/" not in page and page not in listed]
        self.content = StringList([f"/{page}" for page in pages])
        return super().run()


def bring_notebooks(app: Sphinx) -> None:
    """Copy the notebooks of ``examples/`` to where the site's pages are; ones that are the same keep their age."""
    folder = Path(app.srcdir) / NOTEBOOKS
    folder.mkdir(exist_ok=True)
    for file in EXAMPLES.glob("*.ipynb"):
        place = folder / file.name
        if not place.exists() or place.read_bytes() != file.read_bytes():
            place.write_bytes(file.read_bytes())


def turn_links(_app: Sphinx, page: str, source: list[str]) -> None:
    """Lead links that leave docs/ to the page of the site that stands for the file."""
    up = "../" * (page.count("/") + 1)
    for file, place in STANDS_FOR.items():
        source[0] = source[0].replace(f"]({up}{file}", f"]({place}")


def mend_dashes(_app: Sphinx, document: nodes.document) -> None:
    """Set a dash between a parameter and what it is: smart quotes, which would, also join the two of ``--force``."""
    for text in list(document.findall(nodes.Text)):
        if text.astext() == " -- ":
            text.parent.replace(text, nodes.Text(" – "))


def hide_colon(_app: Sphinx, what: str, _name: str, _thing: object, _options: object, lines: list[str]) -> None:
    """Keep napoleon from taking what stands before a colon in a property's first line for its type."""
    if what == "property" and lines:
        lines[0] = lines[0].replace(":", COLON)


def show_colon(_app: Sphinx, _what: str, _name: str, _thing: object, _options: object, lines: list[str]) -> None:
    """Put the colons back."""
    lines[:] = [line.replace(COLON, ":") for line in lines]


def name_handles(_app: Sphinx, _page: str, _template: str, context: dict[str, Any], _document: object) -> None:
    """Name the handles that fold the navigation: the theme draws an arrow alone, which a screen reader cannot read."""
    made = context["generate_toctree_html"]

    def generate_toctree_html(*arguments: Any, **options: Any) -> Any:
        tree = made(*arguments, **options)
        for handle in tree.select("li > details > summary") if hasattr(tree, "select") else ():
            link = handle.find_parent("li").find("a")
            handle["aria-label"] = f"Pages of {link.get_text(strip=True)}" if link else "More pages"
        return tree

    context["generate_toctree_html"] = generate_toctree_html


def setup(app: Sphinx) -> dict[str, Any]:
    """Declare the directives to Sphinx."""
    autosummary.WELL_KNOWN_ABBREVIATIONS += ("eq.", "eqs.")  # no ends of a first sentence
    app.connect("builder-inited", bring_notebooks)
    app.connect("source-read", turn_links)
    app.connect("autodoc-process-docstring", hide_colon, priority=400)  # napoleon has 500
    app.connect("autodoc-process-docstring", show_colon, priority=600)
    app.connect("doctree-read", mend_dashes)
    app.connect("html-page-context", name_handles, priority=900)  # after the theme
    app.add_directive("command-line", CommandLine)
    app.add_directive("causes", Causes)
    app.add_directive("machines", Machines)
    app.add_directive("examples", Examples)
    app.add_directive("other-pages", OtherPages)
    return {"parallel_read_safe": True, "version": "1"}
