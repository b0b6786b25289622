"""A user's own sources of uncertainty, from a TOML file.

.. code-block:: toml

    format = "hexathermal-sources/1"
    defaults = true                    # false: only the sources below
    without = ["backlash"]             # default sources that are left out

    [[source]]
    label = "fixture"
    quantity = "pose"                  # see hexathermal.predict.sources.QUANTITIES
    standard = [1e-6, 1e-6, 1e-6, 0, 0, 0]    # SI: m, rad, K, 1/K; or half_width for a bounded distribution
    distribution = "normal"            # normal, uniform, triangular, arcsine, t
    dof = 12
    correlation = "independent"        # or "common"; or matrix = [[...], ...]
    basis = "certificate 4711"

A label of a default source replaces it.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from hexathermal.errors import ArgumentError
from hexathermal.machine.forms import Form
from hexathermal.machine.hexapod import Hexapod
from hexathermal.predict.budget_defaults import default_sources
from hexathermal.predict.sources import Source, Sources

FORMAT = "hexathermal-sources/1"

TABLES = {
    "": {"format": "text!", "defaults": "flag", "without": "texts", "source": "tables"},
    "source": {
        "label": "text!", "quantity": "text!", "standard": "number+", "half_width": "number+", "distribution": "text",
        "dof": "number", "correlation": "text", "matrix": "matrix", "within": "matrix", "basis": "text",
    },
}  # fmt: skip


def read_sources(path: str | Path, hexapod: Hexapod) -> Sources:
    """Return the sources that a file describes for a machine.

    Raises
    ------
    FileFormatError
        Lists every bad field with line and column.
    ArgumentError
        There is no such file.
    """
    file = Path(path)
    if not file.is_file():
        raise ArgumentError(f"no file of sources at {file}; give the path of a TOML file")
    form = Form(file, TABLES)
    top = form.table(form.data, (), "")
    if top.get("format", FORMAT) != FORMAT:
        form.complain(("format",), f"format is {top['format']!r}; this version reads {FORMAT!r}")
    own = [_source(form, data, k) for k, data in enumerate(top.get("source", []))]
    form.finish()
    made = [source for source in own if source is not None]
    known = default_sources(hexapod) if top.get("defaults", True) else Sources(())
    without = form.build(("without",), lambda: known.without(*top.get("without", ())))
    form.finish()
    labels = {source.label for source in made}
    kept = [source for source in without or () if source.label not in labels]
    sources = form.build(("source",), lambda: Sources((*kept, *made)))
    form.finish()
    return sources if sources is not None else Sources(())


def _source(form: Form, data: Any, k: int) -> Source | None:
    """Return one source, or None after a complaint."""
    place = ("source", k)
    if not isinstance(data, dict):
        form.complain(place, "each [[source]] must be a table")
        return None
    before = len(form.problems)
    found = form.table(data, place, "source")
    if ("standard" in data) == ("half_width" in data):
        form.complain(place, "give either standard or half_width")
    if "matrix" in data and "correlation" in data:
        form.complain((*place, "matrix"), "give either correlation or matrix")
    if len(form.problems) > before:
        return None
    rest: dict[str, Any] = {key: found[key] for key in ("within", "basis") if key in found}
    if "dof" in found:
        rest["dof"] = float(found["dof"])
    if "matrix" in found or "correlation" in found:
        rest["correlation"] = found.get("matrix", found.get("correlation"))
    if "half_width" in found:
        kind = found.get("distribution", "uniform")
        return form.build(
            place, lambda: Source.bounded(found["label"], found["quantity"], found["half_width"], kind, **rest)
        )
    return form.build(
        place,
        lambda: Source(found["label"], found["quantity"], found["standard"], found.get("distribution"), **rest),
    )
