"""campaign.toml -> Campaign: every bad field of the file and every fault of its tables, in one error.

The format is documented in docs/campaigns.md.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from hexathermal.errors import ArgumentError
from hexathermal.learn.campaign import (
    ACCEPTED,
    FILE,
    KINDS,
    ROLES,
    ZEROS,
    BeamLayout,
    Campaign,
    LegDimensions,
    RecordedInput,
    RunFile,
    Thermocouple,
)
from hexathermal.learn.campaign_columns import AIR, ALSO_INPUTS, MACHINE_THERMOMETER, columns_of
from hexathermal.learn.campaign_faults import Faults
from hexathermal.learn.campaign_scan import scan_tables
from hexathermal.learn.campaign_streams import header_names
from hexathermal.machine.forms import Form, meant, shown
from hexathermal.machine.toml_positions import Where

FORMAT = "hexathermal-campaign/1"
TABLES: dict[str, dict[str, str]] = {
    "": {"format": "text!", "kind": "text!", "title": "text", "zero": "text", "runs": "tables!",
         "thermocouples": "tables", "inputs": "tables", "leg": "table", "interferometer": "table", "hexapod": "text",
         "columns": "table", "cleaning": "table"},
    "runs": {"name": "text!", "file": "text!", "role": "text!"},
    "thermocouples": {"name": "text!", "part": "text", "position_mm": "mm"},
    "inputs": {"name": "text!", "description": "text"},
    "leg": {"q0_mm": "mm!", "stroke_mm": "mm(2)!"},
    "interferometer": {"radius_mm": "mm!", "azimuth_deg": "deg(3)!", "dead_path_mm": "mm!",
                       "index_compensated": "flag!"},
    "cleaning": {"accept": "texts!"},
}  # fmt: skip
"""Keys of each table and their rules, see `hexathermal.machine.forms.Form`."""

FARTHEST_M, WITHIN = 1000.0, "above 0, and less than a kilometre"
"""No length of a leg, or of its beams, is as long as that."""

BESIDE = 0.25
"""Thermocouples sit on the leg or no farther beside it, parts of its length."""

SHORTEST_LEG_M, LEAST_STROKES = 0.01, 0.1
"""No leg is shorter between its joint centres, retracted, than the first [m], nor than this share of its stroke.

A rod that leaves its tube is about as long as the tube; telescopes of several stages reach a third. Metres written for
millimetres are a thousandth."""

Progress = Callable[[int, int, str], None]


def load_campaign(
    path: str | Path,
    *,
    needed: tuple[str, ...] = (),
    scan: bool = True,
    clocks: bool = True,
    progress: Progress | None = None,
) -> Campaign:
    """Return a campaign after checking its file and, row by row, all its tables.

    Tables are read as a stream, in constant memory; nothing of them is kept.

    Parameters
    ----------
    path : str or Path
        The campaign's folder, or its `campaign.toml`.
    needed : tuple of str
        Roles of which there must be a run, as ``("validation",)``.
    scan : bool
        Whether the rows of the tables are checked too; without it their headers are.
    clocks : bool
        Whether clocks that no measurement has are faults too, as a pause of 54 years within a run; `check` tells of
        them instead.
    progress : callable, optional
        Called as ``progress(done, total, label)``.

    Raises
    ------
    CampaignError
        Lists every fault of every file, with line and column.
    FileFormatError
        `campaign.toml` is no TOML.
    ArgumentError
        There is no campaign at the path.
    """
    if isinstance(path, str | os.PathLike) and os.path.isfile(path) and Path(path).name != FILE:
        raise ArgumentError(f"{path} is no campaign; give the folder of a campaign.toml, or the file of that name")
    form = Form.opened(path, TABLES, FORMAT, "campaign", f"a {FILE} or a folder that holds one", FILE)
    file = form.path
    campaign = _campaign(form, file.parent, needed)
    faults = Faults()
    faults.extend(file, sorted(form.problems, key=lambda problem: (problem.line, problem.column)))
    if campaign is not None:
        scan_tables(campaign, faults, rows=scan, clocks=clocks, progress=progress)
    faults.finish(file)
    assert campaign is not None  # otherwise there are faults
    return campaign


def _campaign(form: Form, folder: Path, needed: tuple[str, ...]) -> Campaign | None:
    """Return the campaign, as far as it can be made of what is right; None where its tables cannot be looked for."""
    top = form.top
    kind = _one_of(form, top, "kind", KINDS, "")
    zero = _one_of(form, top, "zero", ZEROS, "run")
    runs = _runs(form, top, folder, needed)
    thermocouples = _thermocouples(form, top, kind)
    named = tuple(
        RecordedInput(item["name"], item.get("description", ""))
        for item, _at in _entries(form, top, "inputs", lambda item, at: None)
    )
    also = ALSO_INPUTS if kind != "hexapod" else AIR
    inputs = tuple(item for item in named if item.name not in also)
    if any(ord(letter) < 32 for letter in top.get("title", "")):
        form.complain(("title",), f"title {shown(top['title'])} holds a line's end or another control character")
    leg, beams, hexapod = _leg(form, top, kind), _beams(form, top, kind), _hexapod(form, top, kind, folder)
    _refuse_beside(form, thermocouples, leg)
    if not kind:
        return None
    sensors = thermocouples or (_machine_thermometers(runs) if kind == "hexapod" else ())
    campaign = Campaign(folder, kind, top.get("title", ""), zero, runs, sensors, inputs, leg, beams, hexapod,
                        accepted=_accepted(form, top),
                        stated=tuple(item.name for item in named if item.name in also))  # fmt: skip
    return _with_columns(form, top, campaign)


def _one_of(form: Form, data: dict[str, Any], key: str, known: tuple[str, ...], default: str, at: Where = ()) -> str:
    """Return a word of a table, one of those known; `default` where it is not there, or after a complaint."""
    word = data.get(key, default)
    if key in data and word not in known:
        close = meant(word, known)
        hint = "; " * bool(close) + close
        form.complain((*at, key), f"{key} is {shown(word)}, expected {' or '.join(map(repr, known))}{hint}")
        return default
    return str(word)


def _entries(form: Form, top: dict[str, Any], key: str, check: Any) -> list[tuple[dict[str, Any], Where]]:
    """Return the good entries of ``[[key]]``, each with a name of its own."""
    good: list[tuple[dict[str, Any], Where]] = []
    first: dict[str, int] = {}
    for k, data in enumerate(top.get(key, ())):
        at: Where = (key, k)
        if not isinstance(data, dict):
            form.complain(at, f"[[{key}]] must be tables, found {shown(data)}")
            continue
        before = len(form.problems)
        item = form.table(data, at, key)
        name = item.get("name")
        if name is not None:
            if not name.strip() or name != name.strip() or any(letter in "/\\" or ord(letter) < 32 for letter in name):
                form.complain((*at, "name"), f"name {shown(name)} is empty, or holds a slash or blanks around it")
            elif name in first:
                line = form.positions.of((key, first[name]))[0]
                form.complain((*at, "name"), f"name {name!r} is there twice in [[{key}]], first in line {line}")
            else:
                first[name] = k
        check(item, at)
        if len(form.problems) == before:
            good.append((item, at))
    return good


def _runs(form: Form, top: dict[str, Any], folder: Path, needed: tuple[str, ...]) -> tuple[RunFile, ...]:
    """Return the runs; those whose role alone is at fault are kept, so that their tables are looked at too."""
    runs: list[RunFile] = []
    lines: dict[Path, str] = {}

    def check(item: dict[str, Any], at: Where) -> None:
        if "role" in item:
            item["role"] = _one_of(form, item, "role", ROLES, "", at)
        if "name" not in item or not item.get("file"):
            if item.get("file") == "":
                form.complain((*at, "file"), "file is empty, expected the path of a table from the campaign's folder")
            return
        path = folder / item["file"]
        if path in lines:
            form.complain((*at, "file"), f"file {item['file']!r} is the table of run {lines[path]!r} already")
            return
        lines[path] = item["name"]
        runs.append(RunFile(item["name"], path, item.get("role", "")))

    before = len(form.problems)
    _entries(form, top, "runs", check)
    if "runs" in top and not top["runs"]:
        form.complain(("runs",), "there is no run; expected at least one [[runs]]")
    if len(form.problems) == before and runs:
        for role in needed:
            if not any(run.role == role for run in runs):
                have = ", ".join(f"{run.name} ({run.role})" for run in runs)
                form.complain(("runs",), f"there is no {role} run: give a run role = {role!r}; there are: {have}")
    return tuple(runs)


def _thermocouples(form: Form, top: dict[str, Any], kind: str) -> tuple[Thermocouple, ...]:
    """Return the thermocouples."""
    found = _entries(form, top, "thermocouples", lambda item, at: None)
    if kind in ("leg", "component") and not top.get("thermocouples") and not form.problems:
        form.complain((), f"a campaign of kind {kind!r} needs at least one [[thermocouples]]")
    return tuple(
        Thermocouple(item["name"], item.get("part", ""), float(item["position_mm"]) if "position_mm" in item else None)
        for item, _at in found
    )


def _refuse_beside(form: Form, thermocouples: tuple[Thermocouple, ...], leg: LegDimensions | None) -> None:
    """Complain of thermocouples that sit far beside the leg; of most of them, the leg's length is doubted instead."""
    if leg is None:
        return
    length, beside = leg.retracted_length, BESIDE * leg.retracted_length
    low, high = -beside, length + leg.stroke[1] + beside
    placed = [(k, one.name, one.position) for k, one in enumerate(thermocouples) if one.position is not None]
    far = [one for one in placed if not low <= one[2] <= high]
    for k, name, position in far if 2 * len(far) < len(placed) else ():
        form.complain(("thermocouples", k, "position_mm"), (
            f"position_mm of {name} is {position * 1e3:g}, expected {low * 1e3:g} to {high * 1e3:g}: along the leg of "
            f"{length * 1e3:g} mm from the lower joint centre, rod retracted; leave it out where the thermocouple is "
            "not on the leg"
        ))  # fmt: skip


def _leg(form: Form, top: dict[str, Any], kind: str) -> LegDimensions | None:
    """Return the leg's dimensions, or None where there are none or after complaints."""
    if "leg" not in top:
        if kind == "leg":
            form.complain((), "table [leg] is missing: a campaign of kind 'leg' needs q0_mm and stroke_mm")
        return None
    before, at = len(form.problems), ("leg",)
    found = form.table(top["leg"], at, "leg")
    if "q0_mm" in found:
        form.check((*at, "q0_mm"), 0.0 < found["q0_mm"] < FARTHEST_M, WITHIN)
    if "stroke_mm" in found:
        low, high = found["stroke_mm"]
        ends = -FARTHEST_M < low < high < FARTHEST_M
        if form.check((*at, "stroke_mm"), ends, "[low, high] with low < high, within a kilometre") and "q0_mm" in found:
            form.check((*at, "stroke_mm"), found["q0_mm"] + low > 0.0, "[low, high] with q0 + low above 0")
    if len(form.problems) == before and {"q0_mm", "stroke_mm"} <= found.keys():
        _refuse_short(form, at, float(found["q0_mm"]), float(found["stroke_mm"][1] - found["stroke_mm"][0]))
    if len(form.problems) > before:
        return None
    low, high = found["stroke_mm"]
    return LegDimensions(float(found["q0_mm"]), (float(low), float(high)))


def _refuse_short(form: Form, at: Where, length: float, stroke: float) -> None:
    """Complain of a leg that is too short to be one, or to hold its stroke [m]."""
    shown_mm = f"q0_mm is {length * 1e3:g}"
    if length < LEAST_STROKES * stroke:
        what = f"{shown_mm}, less than a tenth of the stroke of {stroke * 1e3:g} mm: a leg holds its retracted rod"
        form.complain((*at, "q0_mm"), f"{what}; is q0_mm in metres?")
    elif length < SHORTEST_LEG_M:
        what = f"{shown_mm}, expected {SHORTEST_LEG_M * 1e3:g} or more between the joint centres, rod retracted"
        form.complain((*at, "q0_mm"), f"{what}; are q0_mm and stroke_mm in metres?")


def _beams(form: Form, top: dict[str, Any], kind: str) -> BeamLayout | None:
    """Return where the beams run, or None where it is not said or after complaints."""
    if "interferometer" not in top:
        if kind == "leg":
            needs = "radius_mm, azimuth_deg, dead_path_mm and index_compensated"
            form.complain((), f"table [interferometer] is missing: a campaign of kind 'leg' needs {needs}")
        return None
    before, at = len(form.problems), ("interferometer",)
    found = form.table(top["interferometer"], at, "interferometer")
    for key in ("radius_mm", "dead_path_mm"):
        if key in found:
            form.check((*at, key), 0.0 <= found[key] < FARTHEST_M, "0 or more, and less than a kilometre")
    if "azimuth_deg" in found:
        turned = np.mod(found["azimuth_deg"], 2.0 * np.pi)
        apart = len(np.unique(np.round(turned, 6))) == turned.size
        form.check((*at, "azimuth_deg"), apart, "three different angles")
    if len(form.problems) > before:
        return None
    azimuths = tuple(float(angle) for angle in found["azimuth_deg"])
    return BeamLayout(float(found["radius_mm"]), azimuths, float(found["dead_path_mm"]), found["index_compensated"])


def _hexapod(form: Form, top: dict[str, Any], kind: str, folder: Path) -> Path | None:
    """Return the machine's file, or None where there is none or after a complaint."""
    if "hexapod" not in top:
        if kind == "hexapod":
            form.complain((), "key 'hexapod' is missing: a campaign of kind 'hexapod' names the machine's hexapod.toml")
        return None
    if kind and kind != "hexapod":
        form.complain(("hexapod",), f"hexapod belongs to kind 'hexapod'; this campaign is of kind {kind!r}")
        return None
    file: Path = folder / top["hexapod"]
    if file.is_dir():
        form.complain(("hexapod",), f"hexapod names a folder, {file}; give the machine's file: {file / 'hexapod.toml'}")
    elif not file.is_file():
        form.complain(("hexapod",), f"there is no machine file {file}")
    return file


def _machine_thermometers(runs: tuple[RunFile, ...]) -> tuple[Thermocouple, ...]:
    """Return the thermometers of a whole machine by the columns of its first table."""
    names = header_names(runs[0].path, Faults()) if runs else ()
    found = (MACHINE_THERMOMETER.fullmatch(name) for name in names)
    return tuple(Thermocouple(match.group(1)) for match in found if match)


def _accepted(form: Form, top: dict[str, Any]) -> tuple[str, ...]:
    """Return the faults that the campaign takes as they are."""
    if "cleaning" not in top:
        return ()
    names: tuple[str, ...] = form.table(top["cleaning"], ("cleaning",), "cleaning").get("accept", ())
    for name in names:
        _one_of(form, {"accept": name}, "accept", ACCEPTED, "", ("cleaning",))
    return names


def _with_columns(form: Form, top: dict[str, Any], campaign: Campaign) -> Campaign:
    """Return the campaign with its own names of columns; clashes of names are complained of."""
    names = [column.name for column in columns_of(campaign)]
    for section, items in (("thermocouples", campaign.thermocouples), ("inputs", campaign.inputs)):
        for item in items:
            column = f"{item.name}_degC" if section == "thermocouples" else item.name
            if names.count(column) > 1:
                form.complain((section,), f"{item.name!r} takes column {column}, which the format has already")
    own: dict[str, str] = {}
    for name, other in top.get("columns", {}).items():
        at: Where = ("columns", name)
        if name not in names:
            close = meant(name, names) or f"known: {', '.join(names)}"
            form.complain(at, f"[columns] names {name!r}, which is no column of this campaign; {close}")
        elif not isinstance(other, str) or not other.strip():
            form.complain(at, f"columns.{name} must be the name of a column, found {shown(other)}")
        elif other in own.values():
            form.complain(at, f"column {other!r} stands for two columns of the format")
        else:
            own[name] = other.strip()
    _refuse_shared(form, own, names)
    return replace(campaign, columns=own)


def _refuse_shared(form: Form, own: dict[str, str], names: list[str]) -> None:
    """Complain of a column that would be read under two names of the format."""
    for name, other in own.items():
        if other in names and other != name and own.get(other, other) == other:
            form.complain(
                ("columns", name),
                f"column {other!r} would be read as {name} and as {other}: it is a column of the format itself; give "
                f"{other} a name in [columns] too, or take this line out",
            )
