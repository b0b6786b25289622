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

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from hexathermal.machine.forms import Form, meant
from hexathermal.machine.hexapod import Hexapod
from hexathermal.machine.toml_positions import Where
from hexathermal.predict.budget_blocks import source_factors
from hexathermal.predict.budget_defaults import default_sources
from hexathermal.predict.budget_plates import Plates
from hexathermal.predict.leg_drift import between_reversals
from hexathermal.predict.sources import DISTRIBUTIONS, HALF_WIDTH, QUANTITIES, Source, Sources

FORMAT = "hexathermal-sources/1"

NAMES: Mapping[str, Iterable[str]] = {
    "quantity": QUANTITIES, "distribution": DISTRIBUTIONS, "correlation": ("independent", "common"),
}  # fmt: skip

TABLES = {
    "": {"format": "text!", "defaults": "flag", "without": "texts", "source": "tables"},
    "source": {
        "label": "text!", "quantity": "text!", "standard": "number+", "half_width": "number+", "distribution": "text",
        "dof": "number", "correlation": "text", "matrix": "matrix", "within": "matrix", "basis": "text",
    },
}  # fmt: skip


def read_sources(path: str | Path, hexapod: Hexapod, plates: Plates | None = None) -> Sources:
    """Return the sources that a file describes for a machine, default ones for plates as they are stated.

    Raises
    ------
    FileFormatError
        Lists every bad field with line and column.
    ArgumentError
        There is no such file.
    """
    form = Form.opened(path, TABLES, FORMAT, "file of sources", "a TOML file")
    top = form.top
    known = default_sources(hexapod, plates) if top.get("defaults", True) else Sources(())
    without = top.get("without", ())
    for k, label in enumerate(without):
        if label not in known.labels:
            place = ("without", k) if isinstance(form.data["without"], list) else ("without",)
            listed = ", ".join(known.labels) or "none (defaults = false)"
            form.complain(place, f"label {label!r} in without is not known among the default sources; known: {listed}")
    made: dict[str, Source | None] = {}
    for k, data in enumerate(top.get("source", [])):
        label, source = _source(form, data, k, hexapod)
        if label in made:
            form.complain(("source", k, "label"), f"two sources are called {label!r}; labels must be unique")
        elif label:
            made[label] = source
    form.finish()
    kept = [source for source in known.without(*without) if source.label not in made]
    return Sources((*kept, *(source for source in made.values() if source is not None)))


def _source(form: Form, data: Any, k: int, hexapod: Hexapod) -> tuple[str, Source | None]:
    """Return the label of a source and the source itself, or None after complaints about every bad field of it."""
    place = ("source", k)
    if not isinstance(data, dict):
        form.complain(place, "each [[source]] must be a table")
        return "", None
    before = len(form.problems)
    found = form.table(data, place, "source")
    if ("standard" in data) == ("half_width" in data):
        form.complain(place, "give either standard or half_width")
    if "matrix" in data and "correlation" in data:
        form.complain((*place, "matrix"), "give either correlation or matrix")
    label = found.get("label", "")
    if "label" in found and not label.strip():
        form.complain((*place, "label"), "label is empty; a source needs one")
    for key, names in NAMES.items():
        if key in found and found[key] not in names:
            close = meant(found[key], names) or f"known: {', '.join(names)}"
            form.complain((*place, key), f"{key} {found[key]!r} is not known; {close}")
    for key in ("standard", "half_width"):
        if key in found:
            form.check((*place, key), found[key] >= 0.0, "0 or more")
    if "dof" in found:
        form.check((*place, "dof"), found["dof"] > 0.0, "above 0")
    if "half_width" in found and DISTRIBUTIONS.get(found.get("distribution", "uniform"), "uniform") not in HALF_WIDTH:
        form.complain((*place, "distribution"), f"half_width goes with {', '.join(HALF_WIDTH)}")
    if DISTRIBUTIONS.get(found.get("distribution", "")) == "t" and "dof" not in data:
        form.complain((*place, "distribution"), "a t distribution needs its degrees of freedom (dof)")
    _check_shapes(form, found, place, hexapod)
    return label, _made(form, found, place) if len(form.problems) == before else None


def _check_shapes(form: Form, found: dict[str, Any], place: Where, hexapod: Hexapod) -> None:
    """Complain about numbers and matrices that do not fit the quantity on this machine."""
    quantity = found.get("quantity")
    if quantity not in QUANTITIES:
        return
    label = found.get("label", "").strip() or "without a label"
    for key in ("standard", "half_width"):
        if key in found:
            _probe(form, (*place, key), hexapod, label, quantity, np.abs(found[key]))
    for key, field in (("matrix", "correlation"), ("within", "within")):
        if key in found:
            _probe(form, (*place, key), hexapod, label, quantity, 1.0, **{field: found[key]})


def _probe(form: Form, place: Where, hexapod: Hexapod, *words: Any, **fields: Any) -> None:
    """Complain at a field that a source with nothing else but this field refuses on the machine."""
    form.build(place, lambda: source_factors(between_reversals(hexapod), Source(*words, **fields)))


def _made(form: Form, found: dict[str, Any], place: Where) -> Source | None:
    """Return the source of checked fields."""
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
