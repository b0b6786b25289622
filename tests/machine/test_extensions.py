"""Values that extend a machine: compliance, measuring frame, exchanged thermometers, uncertain plates; their files."""

from __future__ import annotations

import dataclasses
import pickle
import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import hexathermal as ht
from hexathermal.errors import ArgumentError, FileFormatError
from hexathermal.machine.compliance import Compliance
from hexathermal.machine.measuring_frame import MeasuringFrame
from tests.extended_machines import extended_machine

EXCHANGED = [1, 2, 4, 3, 5, 6]


@settings(max_examples=25)
@given(seed=st.integers(0, 10**9))
def test_extended_machines_keep_every_bit(tmp_path_factory: pytest.TempPathFactory, seed: int) -> None:
    """Written, read, written again and pickled, an extended machine is the same to the last bit, and texts agree."""
    machine = extended_machine(np.random.default_rng(seed))
    folder = tmp_path_factory.mktemp("machine")
    file = ht.write_hexapod(machine, folder)
    again = ht.load_hexapod(file)
    assert again == machine == pickle.loads(pickle.dumps(machine))
    assert ht.write_hexapod(again, folder / "again.toml").read_text() == file.read_text()


def test_each_field_counts_in_equality() -> None:
    """Two machines that differ in one number of an extension are different; arrays of a copy stay read-only."""
    machine = extended_machine(np.random.default_rng(1))
    soft, room, model = machine.compliance, machine.measuring_frame, machine.thermal
    changed = [
        dataclasses.replace(machine, compliance=None), dataclasses.replace(machine, measuring_frame=None),
        *(dataclasses.replace(machine, compliance=dataclasses.replace(soft, **{name: value})) for name, value in (
            ("leg_compliance", 1e-9), ("payload_mass", 3.0), ("payload_centre", [0.0, 0.0, 1.0]),
            ("gravity", [0, 0, 1.0]),
            ("leg_compliance_std", None), ("payload_mass_std", 0.5), ("payload_centre_std", [1.0, 1.0, 1.0]))),
        *(dataclasses.replace(machine, measuring_frame=dataclasses.replace(room, **{name: value})) for name, value in (
            ("sensor", "base_T1"), ("shift", [0, 0, 1e-6]), ("turn", [0, 0, 1e-6]), ("shift_std", None),
            ("turn_std", [1e-6] * 3))),
        dataclasses.replace(machine, thermal=dataclasses.replace(model, thermometers_of_leg=(1, 2, 3, 4, 5, 6))),
        dataclasses.replace(machine, thermal=dataclasses.replace(
            model, platform=dataclasses.replace(model.platform, expansion_std=None))),
    ]  # fmt: skip
    assert all(other != machine for other in changed)
    copy = pickle.loads(pickle.dumps(machine))
    for array in (copy.compliance.leg_compliance, copy.compliance.gravity, copy.measuring_frame.shift):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1.0


def test_recorded_names_stay_where_plugs_are_exchanged() -> None:
    """`sensor_names` are names of the record; each leg's columns are those of the thermometers that tell it."""
    laws = [ht.LegLaw([f"leg{i + 1}_a", "b"][: 1 + i % 2], [1e-6] * (1 + i % 2), [0.0] * (1 + i % 2)) for i in range(6)]
    plain = ht.ThermalModel(laws, ht.PlateLaw(1e-5, "T"))
    swapped = ht.ThermalModel(laws, ht.PlateLaw(1e-5, "T"), thermometers_of_leg=[1, 3, 2, 4, 5, 6])
    assert plain.sensor_names[:5] == ("leg1_a", "leg2_a", "leg2_b", "leg3_a", "leg4_a")
    assert swapped.sensor_names[:5] == ("leg1_a", "leg2_a", "leg3_a", "leg3_b", "leg4_a")
    assert plain.sensor_names[-1] == swapped.sensor_names[-1] == "platform_T"
    assert swapped.columns_of_leg[:4] == (slice(0, 1), slice(2, 4), slice(1, 2), slice(4, 6))
    assert swapped.legs_as_recorded == (0, 2, 1, 3, 4, 5)
    assert swapped.without_states() == swapped


def test_a_machine_tells_what_extends_it() -> None:
    """The short text of a machine names payload, exchanged thermometers and measuring frame; of a plain one none."""
    machine = extended_machine(np.random.default_rng(4))
    words = ("payload", "thermometers recorded of legs", "air_temperature")
    assert all(word in repr(machine) for word in words)
    assert not any(word in repr(ht.load_hexapod("reference")) for word in words)


GOOD = """
[compliance]
leg_um_per_N = 0.02
payload_kg = 40.0
payload_centre_mm = [0.0, 10.0, 120.0]
gravity_m_s2 = [0.0, 0.0, -9.81]
leg_std_um_per_N = 0.002

[measuring_frame]
sensor = "air_temperature"
shift_um_per_K = [0.5, 0.0, -1.0]
turn_std_urad_per_K = [0.1, 0.1, 0.1]
"""


def written(tmp_path: Path, old: str = "", new: str = "") -> Path:
    """Return a machine file with both tables, and plates that state an uncertainty, one text in it changed."""
    machine = ht.load_hexapod("reference")
    model = dataclasses.replace(
        machine.thermal,
        platform=ht.PlateLaw(1.1e-5, "T1", 3e-7),
        thermometers_of_leg=EXCHANGED,
        reference_temperature_degC=20.0,
    )
    file = ht.write_hexapod(dataclasses.replace(machine, thermal=model), tmp_path)
    text = file.read_text() + GOOD
    assert old in text
    file.write_text(text.replace(old, new))
    return file


def test_a_file_is_read_in_its_units(tmp_path: Path) -> None:
    """Micrometres, millimetres and microradians of the file become SI; what is left out has its default."""
    machine = ht.load_hexapod(written(tmp_path))
    assert machine.compliance == Compliance(2e-8, 40.0, [0.0, 0.01, 0.12], [0.0, 0.0, -9.81], 2e-9)
    wanted = MeasuringFrame("air_temperature", [5e-7, 0.0, -1e-6], turn_std=[1e-7] * 3)
    assert machine.measuring_frame == wanted
    assert machine.thermal.thermometers_of_leg == tuple(EXCHANGED)
    assert machine.thermal.platform.expansion_std == 3e-7
    short = written(tmp_path, "gravity_m_s2 = [0.0, 0.0, -9.81]\n", "")
    assert ht.load_hexapod(short).compliance.gravity.tolist() == [0.0, 0.0, -9.80665]


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("leg_um_per_N = 0.02", "leg_um_per_N = -0.02", "leg_um_per_N must be in .0, 100. um/N, found -0.02"),
        ("leg_um_per_N = 0.02", "leg_um_per_N = [0.02, 0.02]", "one value, or six"),
        ("leg_um_per_N = 0.02\n", "", "'leg_um_per_N' is missing in .compliance"),
        ("leg_um_per_N", "leg_um_per_n", "did you mean 'leg_um_per_N'"),
        ("payload_kg = 40.0", "payload_kg = nan", "finite"),
        ("payload_kg = 40.0", "payload_kg = 4e9", "kg, found"),
        ("[0.0, 10.0, 120.0]", "[0.0, 10.0]", "shape"),
        ("-9.81]", "-9810.0]", r"gravity_m_s2\[2\] must be within"),
        ("leg_std_um_per_N = 0.002", "leg_std_um_per_N = [0, 0, 0, 0, 0, -1]", r"leg_std_um_per_N\[5\]"),
        ('sensor = "air_temperature"', 'sensor = ""', "name of a recorded temperature"),
        ("shift_um_per_K = [0.5", "shift_um_per_K = [5e5", "um/K, found"),
        ("[0.1, 0.1, 0.1]", "[0.1, -0.1, 0.1]", r"turn_std_urad_per_K\[1\] must be 0 or more"),
        ("[1, 2, 4, 3, 5, 6]", "[1, 2, 4, 4, 5, 6]", "each leg from 1 to 6 once"),
        ("[1, 2, 4, 3, 5, 6]", "[1, 2, 4, 3, 5]", "shape"),
        ("expansion_std_per_K = 3e-07", "expansion_std_per_K = -3e-7", "expansion_std_per_K must be in"),
    ],
)
def test_each_mistake_is_named_with_its_line(tmp_path: Path, old: str, new: str, said: str) -> None:
    """One mistake, one complaint that says what is wrong, at the line where it stands."""
    file = written(tmp_path, old, new)
    with pytest.raises(FileFormatError) as caught:
        ht.load_hexapod(file)
    assert re.search(said, str(caught.value)), str(caught.value)
    lines = file.read_text().splitlines()
    told = [lines[problem.line - 1] for problem in caught.value.problems]
    wrong = new.partition(" = ")[0].strip("[,") if new else "[compliance]"
    assert any(wrong in line for line in told), told


def test_mistakes_of_all_tables_are_told_together(tmp_path: Path) -> None:
    """A wrong number in each of three tables gives three complaints at once."""
    file = written(tmp_path, "payload_kg = 40.0", "payload_kg = true")
    file.write_text(
        file.read_text().replace('"air_temperature"', "3").replace("[1, 2, 4, 3, 5, 6]", "[1, 1, 1, 1, 1, 1]")
    )
    with pytest.raises(FileFormatError) as caught:
        ht.load_hexapod(file)
    assert len(caught.value.problems) == 3


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: Compliance(-1e-9, 1.0), "gives way"),
        (lambda: Compliance(0.02, 1.0), "um/N given"),
        (lambda: Compliance([1e-8] * 5, 1.0), "one value for all legs, or six"),
        (lambda: Compliance(1e-8, np.inf), "payload_mass"),
        (lambda: Compliance(1e-8, [1.0, 2.0]), "one number"),
        (lambda: Compliance(1e-8, 1.0, [0.0, 1.0]), "payload_centre"),
        (lambda: Compliance(1e-8, 1.0, gravity=[0.0, 0.0, -9806.65]), "m/s"),
        (lambda: Compliance(1e-8, 1.0, payload_mass_std=-1.0), "payload_mass_std"),
        (lambda: Compliance(1e-8, 1.0, payload_centre_std=[0.0, 0.0, -1.0]), "payload_centre_std"),
        (lambda: MeasuringFrame(""), "by its name"),
        (lambda: MeasuringFrame("air", [1.0, 0.0, 0.0]), "check its unit"),
        (lambda: MeasuringFrame("air", turn_std=[-1e-6, 0.0, 0.0]), "turn_std must be 0 or more"),
        (lambda: MeasuringFrame("air", time_constant=-1.0), "time_constant must be in"),
        (lambda: MeasuringFrame("air", time_constant=60.0).followed([0.0, 1.0], [1.0, 0.0]), "backwards"),
        (lambda: ht.PlateLaw(1e-5, None, -1e-7), "expansion_std_per_K"),
        (lambda: ht.ThermalModel(ht.LegLaw("T", 1e-6, 1e-6), thermometers_of_leg=[0, 1, 2, 3, 4, 5]), "1 to 6 once"),
        (lambda: dataclasses.replace(ht.load_hexapod("reference"), compliance=1e-8), "must be a Compliance"),
        (lambda: dataclasses.replace(ht.load_hexapod("reference"), measuring_frame="air"), "must be a MeasuringFrame"),
    ],
)
def test_senseless_extensions_are_refused(make, said: str) -> None:
    """Wrong signs, shapes, kinds and units are named where a value is made."""
    with pytest.raises(ArgumentError, match=said):
        make()
