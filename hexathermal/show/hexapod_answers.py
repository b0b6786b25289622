"""``identify`` and ``validate`` on a campaign of a whole hexapod: options, work, answers."""

from __future__ import annotations

import argparse
import json
import tomllib
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hexathermal.errors import ArgumentError
from hexathermal.show.commands import Answer, Progress, Writing
from hexathermal.show.options import machine, number, path, sensor_names, whole
from hexathermal.show.outputs import machine_place

if TYPE_CHECKING:
    from hexathermal.learn.campaign import Campaign
    from hexathermal.learn.hexapod_design import PoseDesign
    from hexathermal.learn.hexapod_identification import HexapodIdentification
    from hexathermal.learn.hexapod_observability import Observability
    from hexathermal.learn.hexapod_validation import HexapodValidation
    from hexathermal.learn.law import Origin
    from hexathermal.machine.hexapod import Hexapod
    from hexathermal.machine.thermal import LegLaw
    from hexathermal.poses import FloatArray

LARGEST_PROPOSAL = 500
CANDIDATES = 400

IDENTIFY_HEXAPOD = """\
A campaign of kind hexapod (6-D measurements of the platform alone) gives laws of all legs and of the plates, one law
for all legs or one for each, decided on runs left out; --out DIR is then the folder of a machine, with hexapod.toml and
hexapod.origin.toml, by which 'validate' knows runs that were fitted.
"""

EPILOG_IDENTIFY = """\
hexapod campaigns, files of --report DIR:
  laws.png, observability.png (.svg)   coefficients of each kind of laws; what poses and temperatures tell apart
  poses.csv                            with --propose: the poses that would tell the coefficients apart best
  identification.json                  everything as numbers
"""

EPILOG_VALIDATE = """\
hexapod campaigns: hexathermal validate MACHINE CAMPAIGN, MACHINE a bundled name, a hexapod.toml or its folder. Errors
of the platform before and after correction: x y z in um, rx ry rz in urad (rotation vectors), base axes; one picture a
run.
"""


def is_hexapod_campaign(place: Path) -> bool:
    """Whether a path is a campaign of kind ``"hexapod"``; what is no campaign at all is judged elsewhere."""
    file = place / "campaign.toml" if place.is_dir() else place
    try:
        return file.is_file() and tomllib.loads(file.read_text(encoding="utf-8-sig")).get("kind") == "hexapod"
    except (OSError, ValueError):
        return False


def add_hexapod_options(one: argparse.ArgumentParser) -> None:
    """Declare what ``identify`` accepts for hexapod campaigns."""
    group = one.add_argument_group("for a campaign of kind hexapod")
    group.add_argument("--frame", choices=("run", "campaign", "none"), default="run",
                       help="the positioning system's frame is free in each run (default), once, or not")  # fmt: skip
    group.add_argument("--plates", choices=("auto", "fit", "known", "none"), default="auto",
                       help="expansion of plates with a thermometer: the machine's where it states one, else "
                       "found (auto, default); found; the machine's; 0")  # fmt: skip
    group.add_argument("--noise-um", type=number, metavar="UM", help="known noise of x, y, z (default: found)")
    group.add_argument("--noise-urad", type=number, metavar="URAD", help="known noise of rx, ry, rz (default: found)")
    group.add_argument("--legs", nargs="+", type=path, default=[], metavar="LAW",
                       help="laws of the legs from a bench, leg.toml: one for all, or six; judged beside")  # fmt: skip
    group.add_argument("--propose", type=whole(6, LARGEST_PROPOSAL), metavar="N",
                       help="the N poses of a next run that tell the coefficients apart best")  # fmt: skip
    group.add_argument("--criterion", choices=("D", "A", "E"), default="D",
                       help="what is made small by --propose: the volume of all uncertainties (D, default), their mean "
                       "(A), or the largest (E)")  # fmt: skip


def identify_answer(arguments: argparse.Namespace, progress: Progress) -> Answer:
    """Identify the laws of a whole machine."""
    from hexathermal.learn.campaign_files import load_campaign
    from hexathermal.learn.hexapod_data import hexapod_rows, leg_sensors
    from hexathermal.learn.hexapod_doubts import weak_coefficients
    from hexathermal.learn.hexapod_identification import identify_hexapod
    from hexathermal.learn.hexapod_observability import observability
    from hexathermal.show.hexapod_tables import (
        design_facts,
        design_table,
        hexapod_identification_facts,
        hexapod_laws_table,
        kinds_table,
        observability_table,
    )

    _check_options(arguments)
    campaign = load_campaign(arguments.campaign, needed=("identification",), progress=progress)
    bench = _bench_laws(arguments.legs, leg_sensors(campaign))
    rows = hexapod_rows(campaign, "identification", sensors=_sensors(arguments, campaign, bench))
    progress(0, 0, "identifying (the first run compiles)")
    found = identify_hexapod(rows, frame=arguments.frame, plates=arguments.plates, noise=_noise(arguments),
                             legs=_coefficients(bench, rows.sensors))  # fmt: skip
    widest = found.fits.get("leg-specific", found.fits["common"])
    seen = observability(found.equations.S, widest.model)
    doubts = weak_coefficients(found)
    facts = hexapod_identification_facts(found, seen) | {"warnings": list(doubts)}
    design = None if arguments.propose is None else _proposed(arguments, found, progress)
    if design is not None:
        facts["proposal"] = design_facts(design)
    writing = Writing()
    if arguments.report is not None:
        progress(0, 0, "drawing")
        writing.into(arguments.report, lambda: _identification_report(found, seen, design, facts, arguments.report))
    if arguments.out is not None:
        _write_machine(writing, campaign, found, bench, arguments.out)
    facts["written"] = writing.names
    texts: list[Any] = [_identified(campaign, found), lambda pretty, _: hexapod_laws_table(found, pretty),
                        lambda pretty, _: kinds_table(found, pretty),
                        lambda pretty, _: observability_table(seen, pretty), "\n".join(seen.words)]  # fmt: skip
    if design is not None:
        texts += [_design_words(design), lambda pretty, _: design_table(design, pretty)]
    warnings = [f"warning: {text}" for text in doubts]
    return Answer((*texts, *writing.words), facts, (*warnings, *writing.lost), code=writing.code)


def _check_options(arguments: argparse.Namespace) -> None:
    """Refuse options that contradict, and a folder that would be overwritten, before any work."""
    from hexathermal.machine.writing import machine_file

    if arguments.triples or arguments.quads or arguments.common or arguments.material:
        raise ArgumentError(
            "--triples, --quads, --material and --common are for campaigns of one leg; for a hexapod give --sensors"
        )
    if len(arguments.legs) not in (0, 1, 6):
        raise ArgumentError(f"--legs takes one leg.toml for all legs, or six; found {len(arguments.legs)}")
    if (arguments.noise_um is None) != (arguments.noise_urad is None):
        raise ArgumentError("give both --noise-um and --noise-urad, or neither: then both are found in the residuals")
    if arguments.noise_um is not None and not (arguments.noise_um > 0.0 and arguments.noise_urad > 0.0):
        raise ArgumentError("--noise-um and --noise-urad must be above 0")
    if arguments.out is not None:
        file = machine_file(arguments.out)
        if file.resolve() == own_machine(arguments.campaign):
            raise ArgumentError(f"{file} is the campaign's own machine; give another folder for the identified one")
        machine_place(arguments.out, "--out", arguments.force)


def own_machine(place: Path) -> Path | None:
    """Return the machine file that a campaign names."""
    file = place / "campaign.toml" if place.is_dir() else place
    named = tomllib.loads(file.read_text(encoding="utf-8-sig")).get("hexapod")
    if not isinstance(named, str):
        return None
    found = file.parent / named
    return (found / "hexapod.toml" if found.is_dir() else found).resolve()


def _sensors(
    arguments: argparse.Namespace, campaign: Campaign, bench: tuple[LegLaw, ...] | None
) -> tuple[str, ...] | None:
    """Return the thermometers that are asked for; auto: those of laws from a bench, else those of the machine's law."""
    from hexathermal.learn.hexapod_data import leg_sensors
    from hexathermal.machine.files import read_hexapod

    needed = tuple(dict.fromkeys(name for law in bench or () for name in law.sensors))
    if arguments.sensors != "auto":
        names = sensor_names(arguments.sensors)
        for name in needed:
            if name not in names:
                raise ArgumentError(f"the laws of --legs read {name!r}, which --sensors leaves out: name it there too")
        return names
    if needed:
        return needed
    recorded = leg_sensors(campaign)
    model = None if campaign.hexapod is None else read_hexapod(campaign.hexapod).thermal
    if model is not None and model.legs and all(name in recorded for law in model.legs for name in law.sensors):
        return tuple(dict.fromkeys(name for law in model.legs for name in law.sensors))
    return recorded


def _noise(arguments: argparse.Namespace) -> FloatArray | None:
    """Return the known noise of the six coordinates, or None."""
    import numpy as np

    if arguments.noise_um is None:
        return None
    return np.array([arguments.noise_um] * 3 + [arguments.noise_urad] * 3) * 1e-6


def _bench_laws(files: list[Path], sensors: tuple[str, ...]) -> tuple[LegLaw, ...] | None:
    """Return the six legs' laws from a bench, whose thermometers the machine must have."""
    from hexathermal.learn.leg_law_files import read_leg_law

    laws = []
    for file in files:
        law = read_leg_law(file)
        if law.kind != "leg":
            raise ArgumentError(
                f"{file} is the law of a component; a leg of the machine needs the law of a leg (A and B)"
            )
        for name in law.sensors:
            if name not in sensors:
                raise ArgumentError(
                    f"{file} reads thermometer {name!r}; the machine's legs have {', '.join(sensors)}: name the "
                    f"columns leg1_{name}_degC ..., or map them by [columns] in campaign.toml"
                )
        laws.append(law.leg_law())
    return tuple(laws * 6) if len(laws) == 1 else tuple(laws) or None


def _coefficients(laws: tuple[LegLaw, ...] | None, sensors: tuple[str, ...]) -> dict[str, FloatArray] | None:
    """Return laws from a bench as coefficients of the machine's thermometers, shape (6, 2, k)."""
    import numpy as np

    if laws is None:
        return None
    found = np.zeros((6, 2, len(sensors)))
    for leg, law in enumerate(laws):
        for k, name in enumerate(law.sensors):
            found[leg, :, sensors.index(name)] = law.A[k], law.B[k]
    return {"bench": found}


def _proposed(arguments: argparse.Namespace, found: HexapodIdentification, progress: Progress) -> PoseDesign:
    """Return the poses of a next run, at the temperatures of the warmest run, beside what is known already."""
    import numpy as np

    from hexathermal.kinematics.sampled_poses import reachable_coordinates
    from hexathermal.learn.hexapod_design import designed_poses
    from hexathermal.learn.hexapod_fit import without_frame

    progress(0, 0, "designing poses")
    rows = found.rows
    warmest = max(range(len(rows.runs)), key=lambda k: float(np.abs(rows.dT[rows.run == k]).sum(initial=0.0)))
    here = np.flatnonzero(rows.run == warmest)
    slots = here[np.linspace(0, len(here) - 1, arguments.propose).round().astype(int)]
    candidates = reachable_coordinates(rows.hexapod, CANDIDATES, np.random.default_rng(1))
    fit = found.fits.get("leg-specific", found.fits["common"])
    p = 12 * len(rows.sensors) + 2
    free = [k for k, word in enumerate(fit.model.words) if not word.startswith("frame ")]
    model = replace(fit.model, fixed=fit.model.fixed[:p], C=fit.model.C[:p][:, free],
                    words=tuple(fit.model.words[k] for k in free))  # fmt: skip
    return designed_poses(
        rows.hexapod, candidates, rows.heat[slots], rows.plates[slots], found.noise, model,
        criterion=arguments.criterion, frame=found.frame != "none", known=without_frame(found.equations.S, p),
        leg_noise=found.leg_noise,
    )  # fmt: skip


def _identified(campaign: Campaign, found: HexapodIdentification) -> str:
    """Return what was found, in words."""
    from hexathermal.learn.hexapod_data import PLATES

    rows, noise = found.rows, found.noise * 1e6
    lines = [
        f"Campaign {campaign.title or campaign.folder.name} (kind hexapod): {len(rows.runs)} runs for identification, "
        f"{len(rows)} poses, thermometers {', '.join(found.sensors)} on each leg"
        f"{''.join(f', {part}' for part, have in zip(PLATES, rows.recorded_plates, strict=True) if have)}.",
        f"Chosen: {'one law for all legs' if found.chosen == 'common' else found.chosen + ' laws'} - {found.reason}.",
        f"Noise of the measured coordinates ({'as given' if found.noise_given else 'found in the residuals'}): "
        f"x y z {', '.join(f'{value:z.2f}' for value in noise[:3])} um, "
        f"rx ry rz {', '.join(f'{value:z.2f}' for value in noise[3:])} urad"
        f"{f'; {found.leg_noise * 1e6:z.2f} um more in each leg' if found.leg_noise else ''}.",
    ]
    return "\n".join([*lines, *(f"note: {note}" for note in found.notes)])


def _design_words(design: PoseDesign) -> str:
    """Return what the proposal is."""
    return (
        f"Proposed: {len(design.coordinates)} poses of a next run, {len(set(design.chosen.tolist()))} different ones "
        f"(criterion {design.criterion}), at the temperatures of the warmest run; together with this campaign they "
        "leave:"
    )


def _write_machine(
    writing: Writing, campaign: Campaign, found: HexapodIdentification, bench: tuple[LegLaw, ...] | None, place: Path
) -> None:
    """Write the identified machine, and then where it comes from."""
    from hexathermal.learn.hexapod_origin import identified_origin, origin_file, write_origin
    from hexathermal.machine.writing import write_hexapod

    title = campaign.title or campaign.folder.name
    made = found.hexapod(title, bench if found.chosen == "bench" else None)
    files = writing.into(place, lambda: [write_hexapod(made, place)])
    if files:
        origin = identified_origin(campaign, found, title)
        writing.into(origin_file(files[0]), lambda: [write_origin(origin, made, files[0])])


def _identification_report(
    found: HexapodIdentification, seen: Observability, design: PoseDesign | None, facts: dict[str, Any], folder: Path
) -> list[Path]:
    """Write pictures, poses and numbers; returns their paths."""
    from hexathermal.predict.table_writing import written_folder
    from hexathermal.show.hexapod_figures import laws_figure, observability_figure
    from hexathermal.show.identification_figures import save_both

    with written_folder(folder) as part:
        files = save_both(laws_figure(found), part, "laws")
        files += save_both(observability_figure(seen), part, "observability")
        if design is not None:
            lines = ["x_mm,y_mm,z_mm,rx_deg,ry_deg,rz_deg"]
            lines += [",".join(f"{value:z.4f}" for value in pose) for pose in design.coordinates]
            files.append(part / "poses.csv")
            files[-1].write_text("\n".join(lines) + "\n", encoding="utf-8")
        files.append(part / "identification.json")
        files[-1].write_text(json.dumps(facts, indent=2, allow_nan=False) + "\n", encoding="utf-8")
    return [folder / file.name for file in files]


def validate_answer(arguments: argparse.Namespace, progress: Progress) -> Answer:
    """Validate the law of a whole machine."""
    from hexathermal.learn.campaign_files import load_campaign
    from hexathermal.learn.hexapod_validation import validate_hexapod
    from hexathermal.show.hexapod_tables import hexapod_validation_facts, hexapod_validation_table

    name = str(arguments.law)
    hexapod = machine(name)
    origin, why = law_origin(name, hexapod)
    campaign = load_campaign(arguments.campaign, needed=("validation",), progress=progress)
    progress(0, 0, "validating (the first run compiles)")
    found = validate_hexapod(hexapod, campaign, origin=origin)
    facts = hexapod_validation_facts(found)
    if origin is None:
        facts["notes"].append(f"whether these runs were fitted cannot be told: {why}")
    writing = Writing()
    if arguments.report is not None:
        writing.into(arguments.report, lambda: _validation_report(found, facts, arguments.report, progress))
    texts: list[Any] = [lambda pretty, _: hexapod_validation_table(found, pretty), _validated(found, facts["notes"])]
    warnings = [
        f"warning: run {run} was fitted: the law was identified on its rows, then named {before}; it proves nothing"
        for run, before in found.fitted.items()
    ]
    return Answer((*texts, *writing.words), facts, (*warnings, *writing.lost), code=writing.code)


def law_origin(name: str, hexapod: Hexapod) -> tuple[Origin | None, str]:
    """Return where the law of a machine comes from, or why that is not known; by its name or path."""
    from hexathermal.learn.hexapod_origin import read_origin
    from hexathermal.machine.library import bundled_hexapods

    if name in bundled_hexapods():
        return None, "the law of a bundled machine holds no fingerprints of its runs"
    file = Path(name) / "hexapod.toml" if Path(name).is_dir() else Path(name)
    return (None, "it has no law") if hexapod.thermal is None else read_origin(file, hexapod.thermal)


def _validated(found: HexapodValidation, notes: list[str]) -> str:
    """Return the verdict, in words."""
    lines = []
    for name, unit in (("translation", "um"), ("rotation", "urad")):
        one, verdict = found.total[name], found.verdict[name]
        what = f"{'the law ' if verdict.name in ('BETTER', 'WORSE') else ''}{verdict.value}"
        lines.append(
            f"Verdict on {name}: {what}; RMS {one.before.value * 1e6:z.2f} -> {one.after.value * 1e6:z.2f} {unit}, "
            f"largest {one.largest_before * 1e6:z.2f} -> {one.largest_after * 1e6:z.2f} {unit}."
        )
    (near, turned), (left, turn) = found.framed_before, found.framed
    lines.append(
        "Without each run's mean motion (frame of the positioning system, a calibration at other temperatures than the "
        f"zero, offsets that are not heat): RMS {near * 1e6:z.2f} -> {left * 1e6:z.2f} um and {turned * 1e6:z.2f} -> "
        f"{turn * 1e6:z.2f} urad."
    )
    return "\n".join([*lines, *(f"note: {note}" for note in notes)])


def _validation_report(found: HexapodValidation, facts: dict[str, Any], folder: Path, progress: Progress) -> list[Path]:
    """Write pictures and numbers; returns their paths."""
    from hexathermal.predict.table_writing import written_folder
    from hexathermal.show.hexapod_figures import validation_figure
    from hexathermal.show.identification_figures import save_both

    files = []
    with written_folder(folder) as part:
        for k, run in enumerate(found.runs):
            progress(k, len(found.runs), "drawing")
            name = "".join(letter if letter.isalnum() or letter in "-_." else "_" for letter in run)
            files += save_both(validation_figure(found, run), part, name)
        files.append(part / "validation.json")
        files[-1].write_text(json.dumps(facts, indent=2, allow_nan=False) + "\n", encoding="utf-8")
    return [folder / file.name for file in files]
