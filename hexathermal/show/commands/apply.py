"""``hexathermal apply``: a machine whose legs carry an identified law."""

from __future__ import annotations

import argparse
import dataclasses
from typing import TYPE_CHECKING, Any

from hexathermal.errors import ArgumentError
from hexathermal.show.commands import Answer, Progress
from hexathermal.show.options import EXIT_CODES, MACHINE, STYLE, machine, number, path
from hexathermal.show.outputs import machine_place

if TYPE_CHECKING:
    from hexathermal.learn.law import IdentifiedLaw
    from hexathermal.machine.hexapod import Hexapod
    from hexathermal.machine.thermal import ThermalModel

APPLY = """\
Write a machine whose legs carry an identified law: a copy of a machine's hexapod.toml with the law's sensors,
coefficients and covariance. Give one law for all six legs, or six laws in the order of the legs.
"""

EPILOG = f"""\
The machine keeps its reference temperature (the one it was calibrated at); a machine without a thermal law needs
--reference. It also keeps what else extends it: laws of its plates, exchanged thermometers (thermometers_of_leg), its
payload and its measuring frame; terms of its legs go with their laws, and are named. The range of temperatures becomes
reference plus the law's range of dT, widened by --margin.

Terms that extend the law come along; terms of the bench (its frame, the interferometer) and repairs of the campaign's
data do not, for they are no property of the leg: put such faults right at the machine's own sensors. Terms with a state
(lag, stored heat, creep, backlash) need rows in the order of time: 'hexathermal correct' with time_s, or
leg_controllers() in Python. --at-rest leaves them out, for budgets and single poses.

examples:
  hexathermal apply leg.toml --machine reference --out my-machine
  hexathermal apply leg1.toml leg2.toml leg3.toml leg4.toml leg5.toml leg6.toml --machine reference --out my-machine
  hexathermal demo --machine my-machine

{EXIT_CODES}"""


def add(commands: Any) -> None:
    """Declare the command."""
    one = commands.add_parser(
        "apply", help="a machine whose legs carry a law", description=APPLY, epilog=EPILOG, **STYLE
    )
    one.add_argument("laws", nargs="+", type=path, metavar="LAW", help="leg.toml, one or six")
    one.add_argument("--machine", required=True, **MACHINE)
    one.add_argument("--out", required=True, type=path, metavar="DIR", help="folder for hexapod.toml, or a .toml file")
    one.add_argument(
        "--reference", type=number, metavar="DEGC", help="reference temperature (default: the machine's own)"
    )
    one.add_argument("--margin", type=number, default=10.0, metavar="K",
                     help="allowed beyond the temperatures of the fit (default: %(default)g)")  # fmt: skip
    one.add_argument("--at-rest", action="store_true",
                     help="leave out terms that depend on what was before: a machine long at rest")  # fmt: skip
    one.add_argument("--force", action="store_true", help="overwrite an existing machine file")


def run(arguments: argparse.Namespace, progress: Progress) -> Answer:
    """Write a machine that carries laws."""
    from hexathermal.learn.leg_law_files import read_leg_law
    from hexathermal.machine.library import unmistakable
    from hexathermal.machine.thermal import DEFAULT_RANGE_DEGC
    from hexathermal.machine.writing import write_hexapod
    from hexathermal.predict.temperatures import fault

    if len(arguments.laws) not in (1, 6):
        raise ArgumentError(f"found {len(arguments.laws)} laws; give one for all legs, or six in the order of the legs")
    if arguments.margin < 0.0:
        raise ArgumentError(f"--margin must be 0 or more, found {arguments.margin:g} K")
    if arguments.reference is not None and (said := fault(arguments.reference, *DEFAULT_RANGE_DEGC, "what is usual")):
        raise ArgumentError(f"--reference, the temperature at which the geometry was calibrated, {said}")
    out = machine_place(arguments.out, "--out", arguments.force)
    progress(0, 0, "reading the laws")
    laws = [read_leg_law(file) for file in arguments.laws]
    for name, law in zip(arguments.laws, laws, strict=True):
        if law.kind != "leg":
            raise ArgumentError(
                f"{name} is the law of a {law.kind} (C); a machine's leg carries the law of a leg (A, B)"
            )
    hexapod = machine(arguments.machine)
    if hexapod.retracted_length is None:
        raise ArgumentError(f"machine {hexapod.name or arguments.machine} has no q0_mm, which a leg's law needs")
    model = _model(laws, hexapod, arguments)
    file = write_hexapod(dataclasses.replace(hexapod, thermal=model), out)
    warnings = [*_left_out(laws, model), *_replaced(hexapod), *_doubts(laws, hexapod)]
    carried = tuple(dict.fromkeys(term.cause for law in model.legs for term in law.terms))
    low, high = model.valid_degC
    facts = {
        "machine": hexapod.name,
        "written": [str(file)],
        "sensors": list(model.sensor_names),
        "valid_degC": [low, high],
        "reference_temperature_degC": model.reference_temperature_degC.tolist(),
        "laws": [{"sensors": list(law.sensors), "title": law.origin.title} for law in laws],
        "terms": list(carried),
        "states": list(dict.fromkeys(term.cause for term in model.states)),
    }
    text = (
        f"Machine {hexapod.name}: {'all six legs carry one law' if len(laws) == 1 else 'six laws'}; sensors "
        f"{', '.join(model.sensor_names)}.\n{_extended(model, carried)}Temperatures are accepted from {low:g} to "
        f"{high:g} degC.\n"
        f"Written:\n  {file}\nnext: hexathermal {'correct' if model.states else 'demo'} --machine "
        f"{unmistakable(file.parent if out.name == 'hexapod.toml' else file)}"
        f"{' --poses poses.csv --temps temps.csv --out corrected.csv' if model.states else ''}"
    )
    return Answer((text,), facts, tuple(f"warning: {one}" for one in warnings))


def _extended(model: ThermalModel, carried: tuple[str, ...]) -> str:
    """Return which terms the legs carry, in words; nothing where they carry none."""
    if not carried:
        return ""
    states = ", ".join(dict.fromkeys(term.cause for term in model.states))
    after = f"; {states} depends on what was before: give 'hexathermal correct' poses with time_s" if states else ""
    return f"The law is extended by {', '.join(carried)}{after}.\n"


def _left_out(laws: list[IdentifiedLaw], model: ThermalModel) -> list[str]:
    """Return what of the laws is no property of a leg, or was not wanted."""
    from hexathermal.machine.leg_states import of_bench

    bench = dict.fromkeys(term.cause for law in laws for term in law.terms if of_bench(term))
    repairs = dict.fromkeys(repair.cause for law in laws for repair in law.repairs)
    carried = {term.cause for law in model.legs for term in law.terms}
    rest = [cause for cause in dict.fromkeys(term.cause for law in laws for term in law.terms)
            if cause not in carried and cause not in bench]  # fmt: skip
    left = [f"{', '.join(rest)}: left out, as --at-rest asks"] if rest else []
    if bench:
        left.append(f"{', '.join(bench)}: left out, it tells of the bench that measured, not of the leg")
    if repairs:
        left.append(
            f"{', '.join(repairs)}: not applied, it puts right the data of the campaign; see to the machine's own "
            "sensors, whose names must be the right ones"
        )
    return left


def _replaced(hexapod: Hexapod) -> list[str]:
    """Return which terms of the machine's own legs give way to the laws."""
    old = () if hexapod.thermal is None else hexapod.thermal.legs
    return [
        f"leg {leg + 1}: {', '.join(term.cause for term in law.terms)} of the machine's own law is replaced with it"
        for leg, law in enumerate(old)
        if law.terms
    ]


def _model(laws: list[IdentifiedLaw], hexapod: Hexapod, arguments: argparse.Namespace) -> ThermalModel:
    """Return the machine's thermal model with the laws."""
    import numpy as np

    from hexathermal.machine.thermal import ABSOLUTE_ZERO_DEGC, ThermalModel
    from hexathermal.machine.thermometers import AS_RECORDED

    old = hexapod.thermal
    plates = (None, None) if old is None else (old.platform, old.base)
    told = AS_RECORDED if old is None else old.thermometers_of_leg
    if arguments.reference is not None:
        leg_reference: float | None = arguments.reference
    elif old is None:
        raise ArgumentError(
            f"machine {hexapod.name or arguments.machine} states no reference temperature; give --reference DEGC, the "
            "temperature at which its geometry was calibrated"
        )
    else:
        values = np.unique(old.reference_temperature_degC)
        if len(values) > 1:
            raise ArgumentError(
                "the machine has a reference temperature for each of its sensors, and the law brings others: give one "
                "for all with --reference DEGC"
            )
        leg_reference = float(values[0])
    assert leg_reference is not None  # set above
    span = np.array([[law.validity.dT[:, 0].min(), law.validity.dT[:, 1].max()] for law in laws])
    # every law must hold: the range is what all of them saw
    low, high = float(min(span[:, 0].max(), 0.0)), float(max(span[:, 1].min(), 0.0))
    valid = (leg_reference + low - arguments.margin, leg_reference + high + arguments.margin)
    if not valid[0] < valid[1]:
        raise ArgumentError("the laws were fitted on no range of temperatures; give --margin above 0")
    if valid[0] <= ABSOLUTE_ZERO_DEGC:
        raise ArgumentError(
            f"with --margin {arguments.margin:g} K temperatures from {valid[0]:g} degC would be accepted, below "
            f"absolute zero; give less: the law was fitted from {leg_reference + low:g} to {leg_reference + high:g}"
        )
    rounded = (float(np.floor(valid[0] * 10.0) / 10.0), float(np.ceil(valid[1] * 10.0) / 10.0))
    legs = [law.leg_law() for law in laws]
    model = ThermalModel(legs[0] if len(legs) == 1 else legs, *plates, leg_reference, rounded, told)
    return model.without_states() if arguments.at_rest else model


def _doubts(laws: list[IdentifiedLaw], hexapod: Hexapod) -> list[str]:
    """Return where the machine asks more of a law than its campaign showed."""
    import numpy as np

    warnings = []
    q0, stroke = hexapod.retracted_length, hexapod.stroke
    legs = laws * 6 if len(laws) == 1 else laws
    for k, law in enumerate(legs):
        whose = "" if len(laws) == 1 else f"leg {k + 1}: "
        if law.kind != "leg" or law.retracted_length is None or q0 is None:
            continue
        own = float(np.broadcast_to(q0, 6)[k])
        if abs(own - law.retracted_length) > 0.02 * law.retracted_length:
            warnings.append(
                f"{whose}the machine's retracted length is {own * 1e3:g} mm, the law's "
                f"{law.retracted_length * 1e3:g} mm: A q0 dT is scaled with the machine's, as for the same build"
            )
        if law.validity.q is not None and stroke is not None:
            low, high = np.broadcast_to(stroke, (6, 2))[k]
            if low < law.validity.q[0] - 1e-3 or high > law.validity.q[1] + 1e-3:
                warnings.append(
                    f"{whose}the machine's stroke is {low * 1e3:g} to {high * 1e3:g} mm, the law was fitted from "
                    f"{law.validity.q[0] * 1e3:g} to {law.validity.q[1] * 1e3:g} mm: beyond, it extrapolates"
                )
    return list(dict.fromkeys(warnings))
