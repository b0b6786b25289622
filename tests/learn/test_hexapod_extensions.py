"""What extends a machine beyond laws survives identify, validate, apply and correct, and spoils no law."""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path

import numpy as np
import pytest

import hexathermal as ht
from hexathermal.cli import main
from hexathermal.errors import ArgumentError, UnknownNameError
from hexathermal.learn.hexapod_data import HexapodRows, hexapod_rows
from hexathermal.learn.hexapod_identification import identify_hexapod
from hexathermal.learn.hexapod_model import columns, lengths_of_laws
from hexathermal.learn.hexapod_stated import in_machine_frame, terms_drift
from hexathermal.learn.law import IdentifiedLaw, Origin, Validity
from hexathermal.learn.leg_law_files import write_leg_law
from hexathermal.learn.machine_diagnosis.case import case_of
from hexathermal.learn.noise import ResidualNoise
from hexathermal.learn.sensor_errors import SensorErrors
from hexathermal.machine.compliance import Compliance
from hexathermal.machine.leg_terms import LegTerm
from hexathermal.machine.measuring_frame import MeasuringFrame
from tests.extended_machines import SCREW
from tests.learn.hexapods import NOISE
from tests.learn.machine_diagnosis.machines import PLATES, A, B, Fault, drawn, filed
from tests.learn.test_hexapod_validation import written

STEP = 1.5e-6
DRIFT = (0.8e-6, -0.5e-6, 0.4e-6, 1e-6, -2e-6, 1.5e-6)
MOVED = (0.0, 40e-6, -25e-6)
SAG = 6e-6
WEIGHT = 60.0 * 9.80665
CENTRE = (0.05, -0.03, 0.15)
SLACK = LegTerm("leg-backlash", "direction", {}, [STEP], np.array([[1e-16]]))

FAULTS = {
    "platform-expansion": Fault(platform=5e-6),
    "base-expansion": Fault(base=-3e-6),
    "swapped-legs": Fault(swapped=(2, 3)),
    "payload-compliance": Fault(sag=SAG, centre=CENTRE),
    "joint-offset": Fault(base_joint=(4, MOVED)),
    "tracker-drift": Fault(tracker=DRIFT),
    "leg-backlash": Fault(backlash=(1, STEP)),
}
ALL = Fault(platform=5e-6, swapped=(2, 3), sag=SAG, centre=CENTRE, base_joint=(4, MOVED), tracker=DRIFT,
            backlash=(1, STEP))  # fmt: skip


def told(fault: Fault, law: float = 1.0) -> ht.Hexapod:
    """The machine whose file states a fault, but for the plates; its legs' laws are off by a factor."""
    machine = filed()
    legs = [ht.LegLaw("T1", law * A, law * B) for _leg in range(6)]
    exchange = list(range(1, 7))
    if fault.swapped is not None:
        one, two = fault.swapped
        exchange[one], exchange[two] = two + 1, one + 1
    if fault.backlash is not None:
        legs[fault.backlash[0]] = dataclasses.replace(legs[0], terms=(SLACK,))
    model = dataclasses.replace(machine.thermal, legs=tuple(legs), thermometers_of_leg=exchange)
    machine = dataclasses.replace(machine, thermal=model)
    if fault.sag:
        soft = Compliance(fault.sag / WEIGHT, 60.0, fault.centre)
        machine = dataclasses.replace(machine, compliance=soft)
    if fault.base_joint is not None:
        moved = np.zeros((6, 3))
        moved[fault.base_joint[0]] = fault.base_joint[1]
        machine = dataclasses.replace(machine, base_joints=machine.base_joints + moved)
    if any(fault.tracker):
        room = MeasuringFrame("air_temperature", fault.tracker[:3], fault.tracker[3:])
        machine = dataclasses.replace(machine, measuring_frame=room)
    return machine


def kept(one: ht.Hexapod, other: ht.Hexapod) -> bool:
    """Whether two machines agree in all that extends them, laws and plates aside."""
    return bool(
        one.compliance == other.compliance
        and one.measuring_frame == other.measuring_frame
        and one.thermal.thermometers_of_leg == other.thermal.thermometers_of_leg
        and [law.terms for law in one.thermal.legs] == [law.terms for law in other.thermal.legs]
        and np.array_equal(one.base_joints, other.base_joints)
        and np.array_equal(one.platform_joints, other.platform_joints)
    )


def bench_law(folder: Path) -> str:
    """The true law of the legs as a bench would have written it."""
    made = IdentifiedLaw("leg", ("T1",), np.array([A, B]), np.eye(2) * 1e-18, 0.6, (0.0, 0.25), "campaign",
                         Validity(np.array([[-1.0, 10.0]])), ResidualNoise(1e-7, 1e-7, 1e-7, 600.0, 1e-7),
                         SensorErrors(np.array([0.01]), np.array([0.01]), 3600.0),
                         origin=Origin("bench", "-", ("run-1",), "-"))  # fmt: skip
    return str(write_leg_law(made, folder / "leg.toml"))


def corrected(machine: Path, rows: HexapodRows, folder: Path) -> np.ndarray:
    """Corrected lengths that the command line writes for the first rows of a campaign, shape (n, 6) [m]."""
    first = slice(0, 12)
    pose = ["x_mm", "y_mm", "z_mm", "rx_deg", "ry_deg", "rz_deg"]
    six = ht.coordinates_from_pose(rows.commanded[first], hexapod=rows.hexapod)
    heat = np.column_stack([rows.time[first], 20.0 + rows.dT[first, :, 0], 20.0 + rows.plates[first]])
    parts = [*(f"leg{k}" for k in range(1, 7)), "platform", "base"]
    for name, head, table in (("poses", pose, np.column_stack([rows.time[first], six])),
                              ("temps", [f"{part}_T1_degC" for part in parts], heat)):  # fmt: skip
        np.savetxt(folder / f"{name}.csv", table, delimiter=",", header=",".join(["time_s", *head]), comments="",
                   fmt="%.12g")  # fmt: skip
    out = folder / "corrected.csv"
    assert main(["correct", "--machine", str(machine), "--poses", str(folder / "poses.csv"), "--temps",
                 str(folder / "temps.csv"), "--out", str(out), "--force"]) == 0  # fmt: skip
    found = np.genfromtxt(out, delimiter=",", names=True)
    return np.column_stack([found[f"leg{k}_length_mm"] for k in range(1, 7)]) * 1e-3


@pytest.mark.long
@pytest.mark.parametrize("name", [*FAULTS, "all"])
def test_round_trip_from_the_command_line(name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A machine that states what extends it, with laws 30 % off: ``identify`` finds the true laws and plates within
    their uncertainties and keeps the rest as it is; ``validate`` leaves the noise in runs never fitted; ``correct``
    sends the true machine to where it should stand; ``apply`` keeps the rest too.
    """
    fault = ALL if name == "all" else FAULTS[name]
    rows = drawn(11, fault, runs=5, poses=40)
    stated = told(fault, 1.3)
    written(tmp_path / "c", rows, hexapod=stated, identified=4)
    assert main(["identify", str(tmp_path / "c"), "--out", str(tmp_path / "m"), "--plates", "fit"]) == 0
    found = ht.load_hexapod(tmp_path / "m")
    assert kept(found, stated)
    plates = np.array(PLATES) + [fault.platform, fault.base]
    for plate, truth in zip((found.thermal.platform, found.thermal.base), plates, strict=True):
        assert plate.expansion_std is not None
        assert abs(plate.expansion - truth) < 4.0 * plate.expansion_std
    for law in found.thermal.legs:
        off = np.abs([law.A[0] - A, law.B[0] - B])
        assert (off < 4.0 * np.sqrt(np.diag(law.covariance))).all()
    assert main(["validate", str(tmp_path / "m"), str(tmp_path / "c"), "--json", str(tmp_path / "v.json")]) == 0
    total = json.loads((tmp_path / "v.json").read_text(encoding="utf-8"))["total"]
    for k, axis in enumerate(("x", "y", "z", "rx", "ry", "rz")):
        assert total[axis]["rms_after"]["value"] < 1.4 * NOISE[k] * 1e6
    assert main(["apply", bench_law(tmp_path), "--machine", str(tmp_path / "m"), "--out", str(tmp_path / "a")]) == 0
    applied = ht.load_hexapod(tmp_path / "a")
    said = capsys.readouterr().err
    assert ("leg 2: leg-backlash of the machine's own law is replaced" in said) == (fault.backlash is not None)
    bare = dataclasses.replace(found, thermal=found.thermal.without_states())
    assert kept(applied, bare)
    _stands_where_it_should(fault, rows, tmp_path)


def _stands_where_it_should(fault: Fault, rows: HexapodRows, folder: Path) -> None:
    """The true machine, sent the corrected lengths of the identified one, is within 1 um of the pose."""
    lengths = corrected(folder / "m", rows, folder)
    true = told(fault)
    law = (ht.PlateLaw(PLATES[0] + fault.platform, "T1"), ht.PlateLaw(PLATES[1] + fault.base, "T1"))
    true = dataclasses.replace(true, thermal=dataclasses.replace(true.thermal, platform=law[0], base=law[1]))
    n = len(lengths)
    temps = np.column_stack([20.0 + rows.dT[:n, :, 0], 20.0 + rows.plates[:n]])
    stands = true.leg_controllers().predicted_pose(lengths, temps, rows.time[:n])
    assert np.abs(stands - rows.commanded[:n])[:, :3, 3].max() < 1e-6
    assert np.abs(stands - rows.commanded[:n])[:, :3, :3].max() < 3e-6


@pytest.mark.parametrize(
    "name", ["swapped-legs", "payload-compliance", "joint-offset", "tracker-drift", "leg-backlash"]
)
def test_what_is_not_stated_spoils_the_fit(name: str) -> None:
    """The same rows fitted with a machine that does not state the fault leave 1.2 times as much at least."""
    rows = drawn(12, FAULTS[name], poses=60)
    left = [identify_hexapod(dataclasses.replace(rows, hexapod=machine), plates="fit").fit_rmse["leg-specific"]
            for machine in (told(FAULTS[name]), filed())]  # fmt: skip
    assert max(without / with_ for with_, without in zip(*left, strict=True)) > 1.2


@pytest.mark.long
def test_a_simulated_machine_has_what_it_states(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A virtual machine with payload, exchanged plugs and a drifting frame shows them in its campaign: identified and
    validated with its own file it leaves what the same machine without them leaves, within 5 %; with the file of that
    one three times as much. A term of a leg is said not to be simulated, and is not in the campaign's machine.
    """
    fault = dataclasses.replace(ALL, base_joint=None, sag=60e-6, tracker=tuple(3.0 * np.array(DRIFT)))
    loaded, left = told(fault), {}
    for name, hexapod in (("loaded", loaded), ("bare", filed())):
        ht.write_hexapod(hexapod, tmp_path / name)
        assert main(["simulate", "machine", "--machine", str(tmp_path / name), "--out", str(tmp_path / f"{name}-c"),
                     "--runs", "3", "--validation", "1", "--rows", "50"]) == 0  # fmt: skip
    assert "warning: leg 2: leg-backlash is not simulated" in capsys.readouterr().err
    shown = ht.load_hexapod(tmp_path / "loaded-c")
    assert (shown.compliance, shown.measuring_frame) == (loaded.compliance, loaded.measuring_frame)
    assert shown.thermal.thermometers_of_leg == loaded.thermal.thermometers_of_leg
    assert not shown.thermal.has_terms
    for name, campaign in (("loaded", "loaded"), ("bare", "bare"), ("wrong", "loaded")):
        folder = tmp_path / f"{campaign}-c"
        if name == "wrong":
            ht.write_hexapod(ht.load_hexapod(tmp_path / "bare-c"), folder)
        assert main(["identify", str(folder), "--out", str(tmp_path / f"{name}-m")]) == 0
        assert main(["validate", str(tmp_path / f"{name}-m"), str(folder), "--json", str(tmp_path / "v.json")]) == 0
        facts = json.loads((tmp_path / "v.json").read_text(encoding="utf-8"))["after_without_mean_motion"]
        left[name] = np.array([facts["translation_um"], facts["rotation_urad"]])
    assert np.abs(left["loaded"] / left["bare"] - 1.0).max() < 0.05
    assert (left["wrong"] > 3.0 * left["bare"]).any()


def test_diagnosis_and_identification_see_the_same_residual() -> None:
    """At the machine's own laws the residual of leg lengths is the same in both: sag, terms and exchange count once."""
    fault = dataclasses.replace(ALL, tracker=(0.0,) * 6)
    machine = told(fault)
    legs = list(machine.thermal.legs)
    legs[5] = dataclasses.replace(legs[5], terms=(SCREW,))
    machine = dataclasses.replace(machine, thermal=dataclasses.replace(machine.thermal, legs=tuple(legs)))
    rows = dataclasses.replace(drawn(13, fault, runs=2, poses=30), hexapod=machine)
    b = np.array([*np.tile([A, B], 6), *PLATES])
    own = lengths_of_laws(rows, rows.measured) - columns(machine, rows.measured, rows.q, rows.heat, rows.plates) @ b
    assert np.abs(case_of(rows).y - own).max() < 1e-15
    assert np.ptp(terms_drift(rows)[:, 1]) == pytest.approx(STEP, rel=1e-6)


def test_references_stand_where_they_are_recorded() -> None:
    """With exchanged thermometers each reference is the zero of the thermometer of that name."""
    rows = drawn(14, FAULTS["swapped-legs"], runs=2, poses=40)
    zero = 20.0 + 0.1 * np.arange(6.0)[:, None]
    rows = dataclasses.replace(rows, hexapod=told(FAULTS["swapped-legs"]), zero_degC=zero)
    model = identify_hexapod(rows).hexapod().thermal
    known = dict(zip(model.sensor_names, model.reference_temperature_degC.tolist(), strict=True))
    for leg in range(6):
        assert known[f"leg{leg + 1}_T1"] == zero[leg, 0]


def test_notes_tell_what_was_taken_off() -> None:
    """Exchange, backlash, payload and drift of the frame are each told with their size."""
    notes = identify_hexapod(dataclasses.replace(drawn(15, ALL), hexapod=told(ALL))).notes
    for words in (
        "leg 3 is told by the thermometers recorded as those of leg 4", "leg 2 keeps leg-backlash", "up to 0.75 um",
        "payload of 60 kg", "drift of the measuring frame with air_temperature",
    ):  # fmt: skip
        assert any(words in note for note in notes), words


def test_the_frame_needs_its_temperature(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A frame whose temperature is not recorded is refused in one message with what is recorded; rows without it are
    left out and counted; a plate's or a leg's thermometer serves as well.
    """
    rows, machine = drawn(16, FAULTS["tracker-drift"], runs=2, poses=40), told(FAULTS["tracker-drift"])
    airless = dataclasses.replace(rows, air=None)
    written(tmp_path / "c", airless, hexapod=machine, identified=2)
    assert main(["identify", str(tmp_path / "c")]) == 2
    said = capsys.readouterr().err
    assert "follows 'air_temperature'" in said
    assert "platform_T1" in said
    assert "Traceback" not in said
    gone = rows.air.copy()
    gone[[3, 50, 51]] = np.nan
    campaign = written(tmp_path / "d", dataclasses.replace(rows, air=gone), hexapod=machine, identified=2)
    left = hexapod_rows(campaign, "identification")
    assert left.left_out == {"the air, which the measuring frame follows, has no temperature": 3}
    assert len(hexapod_rows(campaign, "identification", hexapod=filed())) == len(rows)
    for sensor, heat in (("platform_T1", rows.plates[:, 0]), ("leg2_T1", rows.dT[:, 1, 0])):
        room = MeasuringFrame(sensor, DRIFT[:3])
        other = dataclasses.replace(rows, hexapod=dataclasses.replace(machine, measuring_frame=room))
        back = rows.measured[:, :3, 3] - in_machine_frame(other)[:, :3, 3]
        assert np.abs(back - heat[:, None] * DRIFT[:3]).max() < 1e-12
    elsewhere = dataclasses.replace(machine, measuring_frame=MeasuringFrame("hall_T9", DRIFT[:3]))
    with pytest.raises(UnknownNameError) as error:
        identify_hexapod(dataclasses.replace(rows, hexapod=elsewhere))
    assert "air_temperature" in error.value.available


def test_terms_need_their_thermometer() -> None:
    """A term of a leg whose thermometer is not chosen is refused with leg, cause and thermometer."""
    term = LegTerm("nonlinear-expansion", "square", {"sensor": "T2", "ratio": 0.0}, [1e-9], np.array([[1e-24]]))
    machine = filed()
    legs = list(machine.thermal.legs)
    legs[3] = ht.LegLaw(("T1", "T2"), [A, 0.0], [B, 0.0], terms=(term,))
    machine = dataclasses.replace(machine, thermal=ht.ThermalModel(legs))
    with pytest.raises(
        ArgumentError, match="leg 4 of the machine has nonlinear-expansion, which reads thermometer 'T2'"
    ):
        identify_hexapod(dataclasses.replace(drawn(17, runs=2), hexapod=machine))
