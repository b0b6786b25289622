"""Where the law of a whole machine comes from: NAME.origin.toml beside NAME.toml, which ``identify`` writes.

A hexapod.toml says what a machine is, in a format that others read too; that is why the fingerprints of the runs that
its law was fitted to stand in a file of their own beside it. Keys of the file:

=====================  =====================================================================================
`format`               ``"hexathermal-origin/1"``
`law`                  SHA-256 of the law's thermometers and coefficients: tells whether the file is that law's
`title`                of the campaign
`fingerprint`          of the campaign's files
`runs`                 that were fitted
`run_fingerprints`     of the rows of each of them, see `hexathermal.learn.row_fingerprints`
`method`               the kind of laws, and why
=====================  =====================================================================================
"""

from __future__ import annotations

import hashlib
from pathlib import Path
from typing import TYPE_CHECKING

import tomli_w

from hexathermal.learn.law import Origin
from hexathermal.machine.forms import Form
from hexathermal.machine.hexapod import Hexapod
from hexathermal.machine.thermal import ThermalModel
from hexathermal.predict.table_writing import written_whole
from hexathermal.predict.temperatures import active_model

if TYPE_CHECKING:
    from hexathermal.learn.campaign import Campaign
    from hexathermal.learn.hexapod_identification import HexapodIdentification

FORMAT = "hexathermal-origin/1"
TABLES = {"": {"format": "text!", "law": "text!", "title": "text!", "fingerprint": "text!", "runs": "texts!",
               "run_fingerprints": "texts!", "method": "text!"}}  # fmt: skip
"""Keys and their rules, see `hexathermal.machine.forms.Form`."""


def origin_file(machine: Path) -> Path:
    """Return the file beside a machine's that tells where its law comes from.

    Examples
    --------
    >>> origin_file(Path("my-machine/hexapod.toml")).as_posix()
    'my-machine/hexapod.origin.toml'
    """
    return machine.with_name(f"{machine.stem}.origin.toml")


def law_digest(model: ThermalModel) -> str:
    """Return the SHA-256 of a law's thermometers and coefficients, to the last bit."""
    legs = [(law.sensors, law.A.tolist(), law.B.tolist()) for law in model.legs]
    plates = [None if plate is None else (plate.expansion, plate.sensor) for plate in (model.platform, model.base)]
    return hashlib.sha256(repr((legs, plates)).encode()).hexdigest()


def identified_origin(campaign: Campaign, found: HexapodIdentification, title: str) -> Origin:
    """Return where an identified law comes from; of runs with the same rows the first stands for all."""
    from hexathermal.learn.campaign_dataset import fingerprint

    runs = [run.run for run in found.equations.runs]
    marks = {found.rows.fingerprints[run]: run for run in reversed(runs)}
    known = dict(reversed(marks.items()))
    method = f"6-D measurements of the platform; {found.chosen}: {found.reason}"
    return Origin(title, fingerprint(campaign), tuple(known.values()), method, tuple(known))


def write_origin(origin: Origin, hexapod: Hexapod, machine: Path) -> Path:
    """Write where the law of a machine comes from beside its file; returns the path.

    Parameters
    ----------
    origin : Origin
    hexapod : Hexapod
    machine : Path
        Of the machine's toml file.

    Raises
    ------
    ThermalModelError
        The machine has no law.
    ArgumentError
        The file cannot be written.
    """
    file = origin_file(machine)
    document = {"format": FORMAT, "law": law_digest(active_model(hexapod)), "title": origin.title,
                "fingerprint": origin.fingerprint, "runs": list(origin.runs),
                "run_fingerprints": list(origin.run_fingerprints), "method": origin.method}  # fmt: skip
    with written_whole(file) as part:
        part.write_bytes(tomli_w.dumps(document).encode("utf-8"))
    return file


def read_origin(machine: Path, model: ThermalModel) -> tuple[Origin | None, str]:
    """Return where the law of a machine comes from; or None, and why it cannot be told.

    Parameters
    ----------
    machine : Path
        Of the machine's toml file.
    model : ThermalModel
        Its law.

    Raises
    ------
    FileFormatError
        The file is there, and breaks its format: every bad field with line and column.
    """
    file = origin_file(machine)
    if not file.is_file():
        return None, f"there is no {file.name} beside {machine.name}"
    form = Form(file, TABLES)
    top = form.table(form.data, (), "")
    if top.get("format", FORMAT) != FORMAT:
        form.complain(("format",), f"format is {top['format']!r}; this version reads {FORMAT!r}")
    form.finish()
    if len(top["runs"]) != len(top["run_fingerprints"]):
        said = f"run_fingerprints has {len(top['run_fingerprints'])} values; expected {len(top['runs'])}, one a run"
        form.complain(("run_fingerprints",), said)
    form.finish()
    if top["law"] != law_digest(model):
        return None, f"{file.name} belongs to another law than that of {machine.name}"
    return Origin(top["title"], top["fingerprint"], top["runs"], top["method"], top["run_fingerprints"]), ""
