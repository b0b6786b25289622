"""hexapod.toml: read and written without loss, every bad field reported with its place."""

from __future__ import annotations

import dataclasses
import re
import tomllib
from decimal import Context, Decimal, FloatOperation, Inexact, localcontext
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import tomli_w
from hypothesis import given
from hypothesis import strategies as st

import hexathermal as ht
from hexathermal.errors import ArgumentError, FileFormatError, HexathermalError
from hexathermal.machine.files import read_hexapod
from hexathermal.machine.library import models_folder
from hexathermal.machine.toml_positions import Positions
from hexathermal.machine.units import metres, radians, same, shortest
from tests.machines import general_machine

numbers = st.floats(-1e3, 1e3, allow_nan=False, allow_subnormal=False)


@given(numbers)
def test_no_bit_is_lost_at_the_unit_border(value: float) -> None:
    """Every double is written as a decimal in millimetres or degrees that is read back as the same double."""
    for reader in (metres, radians, same):
        assert reader(shortest(value, reader)) == value


def test_files_keep_every_bit(
    tmp_path: Path, hexapod: ht.Hexapod, two_plates: ht.Hexapod, rng: np.random.Generator
) -> None:
    """Write and read gives an equal machine; writing it again gives the same text."""
    scattered = general_machine(rng)
    six = ht.Hexapod(
        scattered.base_joints, scattered.platform_joints, home=scattered.home,
        name="six laws", grade="A", source="a test",
        retracted_length=rng.uniform(0.2, 0.3, 6), stroke=np.stack([rng.uniform(-0.1, 0, 6), rng.uniform(1, 2, 6)], 1),
        base_cone=rng.uniform(1, 1.5, 6),
        thermal=ht.ThermalModel(
            tuple(ht.LegLaw(("T1", "T2"), rng.normal(0, 1e-6, 2), rng.normal(0, 1e-6, 2),
                            np.diag(rng.uniform(1, 2, 4)) * 1e-15, f"campaign {k}",
                            spread=rng.uniform(0, 1e-8, 4)) for k in range(6)),
            ht.PlateLaw(1.1e-5, "T1"), None, rng.uniform(19, 21, 13), (-10.0, 60.0)),
    )  # fmt: skip
    for machine in (hexapod, two_plates, six):
        file = ht.write_hexapod(machine, tmp_path / machine.name.replace(" ", "-"))
        again = ht.load_hexapod(file)
        assert again == machine
        text = file.read_text()
        assert ht.write_hexapod(again, tmp_path / "again.toml").read_text() == text


GOOD = (models_folder() / "reference" / "hexapod.toml").read_text()


def problems(tmp_path: Path, text: str) -> list[str]:
    """Return the complaints about a machine file."""
    file = tmp_path / "hexapod.toml"
    file.write_bytes(text.encode())
    with pytest.raises(FileFormatError) as caught:
        ht.load_hexapod(file)
    return [str(problem) for problem in caught.value.problems]


def test_all_bad_fields_are_reported_together_with_their_lines(tmp_path: Path) -> None:
    """Five mistakes in one file give five complaints, each with line and column."""
    bad = (
        GOOD.replace('grade = "C"', 'grade = "Z"')
        .replace("q0_mm = 600.0", 'q0_mm = "600"')
        .replace("stroke_mm = [0.0, 250.0]", "stroke_mm = [0.0, 250.0, 3.0]")
        .replace("A_per_K = [1.99e-06]", "A_per_k = [1.99e-06]")
        .replace("platform_mass_kg = 25.0", "platform_mass_kg = nan")
    )
    found = problems(tmp_path, bad)
    lines = bad.splitlines()
    for word in ("grade", "q0_mm", "stroke_mm", "A_per_k", "platform_mass_kg"):
        number = next(k for k, line in enumerate(lines, 1) if line.startswith(word))
        assert any(f"line {number}, column 1" in text and word in text for text in found), (word, found)
    assert any("A_per_K' is missing" in text for text in found)
    assert len(found) == 6


@pytest.mark.parametrize(
    ("old", "new", "word"),
    [
        ('format = "hexathermal-hexapod/1"', 'format = "hexathermal-hexapod/9"', "this version reads"),
        ("base_joints_mm = [", "base_joints = [", "unknown key 'base_joints'; did you mean 'base_joints_mm'.*known"),
        ("[443.163, -78.142, -663.3]", "[443.163, -78.142]", "different length|shape"),
        ("[443.163, -78.142, -663.3]", "[443.163, inf, -663.3]", "finite"),
        ("home_mm = [0.0, 0.0, 0.0]", "home_mm = [0.0, 0.0]", "shape"),
        ("q0_mm = 600.0", "q0_mm = 0.6", "home is out of stroke"),
        ('sensors = [\n  "T1",\n]', "sensors = []", "list of names"),
        ("A_per_K = [1.99e-06]", "A_per_K = [1.99e-3]", "1/K"),
        ("A_per_K = [1.99e-06]", "A_per_K = [1.99e-6, 1e-6]", "1 value for each of the sensors"),
        ("valid_degC = [0.0, 50.0]", "valid_degC = [50.0, 0.0]", "low, high"),
        ("reference_temperature_degC = 20.0", "reference_temperature_degC = 293.15", "inside valid_degC"),
        ("reference_temperature_degC = 20.0\n", "", "missing"),
        ("[geometry]", "[geometry", "not valid TOML"),
        ("[thermal.leg]", "[[thermal.legs]]", "expected six"),
        ("[geometry]", "[geometri]", "unknown key 'geometri'"),
    ],
)
def test_each_mistake_is_named(tmp_path: Path, old: str, new: str, word: str) -> None:
    """One mistake, one complaint that says what is wrong."""
    assert old in GOOD
    found = problems(tmp_path, GOOD.replace(old, new))
    assert any(re.search(word, text, re.DOTALL) for text in found), found


@given(st.integers(0, len(GOOD) - 1), st.binary(max_size=6), st.integers(0, 40))
def test_damaged_files_give_a_clear_error_or_a_machine(
    tmp_path_factory: pytest.TempPathFactory, at: int, insert: bytes, cut: int
) -> None:
    """Random damage never ends in anything but a machine or one of the package's own errors."""
    data = GOOD.encode()
    file = tmp_path_factory.mktemp("damaged") / "hexapod.toml"
    file.write_bytes(data[:at] + insert + data[at + cut :])
    try:
        assert isinstance(ht.load_hexapod(file), ht.Hexapod)
    except HexathermalError as error:
        assert str(file) in str(error)


def test_a_turned_home_cannot_be_written(tmp_path: Path, reference: ht.Hexapod) -> None:
    """The format holds a home position only: a turned home is refused instead of being lost."""
    turned = ht.Hexapod(
        reference.base_joints, reference.platform_joints, home=ht.pose_from_coordinates([0, 0, 0, 0, 0, 5])
    )
    with pytest.raises(ArgumentError, match="home"):
        ht.write_hexapod(turned, tmp_path)
    assert not list(tmp_path.iterdir())


def test_missing_files_and_folders_are_named(tmp_path: Path) -> None:
    """A path without a machine says where it looked."""
    with pytest.raises(HexathermalError, match="hexapod.toml"):
        ht.load_hexapod(tmp_path)
    with pytest.raises(HexathermalError, match="neither a bundled machine"):
        ht.load_hexapod(tmp_path / "nothing.toml")


def with_geometry(**values: str) -> str:
    """Return the reference machine with other lines in [geometry]."""
    text = GOOD
    for key, value in values.items():
        text = re.sub(rf"(?m)^{key} = .*$", f"{key} = {value}", text)
    return text


def place_of(text: str, word: str) -> str:
    """Return line and column of the first appearance of a word, as complaints write them."""
    before = text[: text.index(word)]
    return f"line {before.count(chr(10)) + 1}, column {len(before) - before.rfind(chr(10))}:"


BAD_VALUES = with_geometry(
    q0_mm="-5", stroke_mm="[5, -5]", base_cone_deg="400", platform_cone_deg="-1",
    A_per_K="[2e-3]", B_per_K="[1e-6, 1e-6]", valid_degC="[50.0, 0.0]", reference_temperature_degC="[20.0, 1.0, 2.0]",
    expansion_per_K="1.6", leg_rod_diameter_mm="0", leg_rod_mass_kg="-1.0",
) + (
    '\n[limits]\nconvention = "zzz"\nx_mm = [1, -1]\ny_mm = [2, -2]\nz_mm = [-1, 1]\nrx_deg = [-1, 1]\n'
    "ry_deg = [-1, 1]\nrz_deg = [-1, 1]\n"
)  # fmt: skip


@pytest.mark.parametrize("unknown", [False, True])
def test_values_that_make_no_machine_are_all_reported_at_their_keys(tmp_path: Path, unknown: bool) -> None:
    """Each impossible value has its own complaint at its own key, also when unknown keys stand beside them."""
    text = BAD_VALUES.replace("q0_mm", "zz = 1\nq0_mm").replace("campaign", "zz = 1\ncampaign")
    text = text.replace("convention", "zz = 1\nconvention").replace("leg_rod_mass_kg", "zz = 1\nleg_rod_mass_kg")
    text = text if unknown else BAD_VALUES
    found = problems(tmp_path, text)
    for word in ("q0_mm", "stroke_mm", "base_cone_deg", "platform_cone_deg", "B_per_K", "valid_degC", "convention",
                 "x_mm", "y_mm", "leg_rod_diameter_mm", "leg_rod_mass_kg", "2e-3", "expansion_per_K"):  # fmt: skip
        assert any(entry.startswith(place_of(text, word)) for entry in found), (word, found)
    assert len(found) == 14 + 4 * unknown, found


@pytest.mark.parametrize(
    ("old", "new", "place", "word"),
    [
        ("q0_mm = 600.0", "q0_mm = [600, 600, 600, -1.25, 600, 600]", "-1.25", "above 0"),
        ("q0_mm = 600.0\n", "", "stroke_mm", "needs q0_mm"),
        ("q0_mm = 600.0\n", "", "[thermal]", "needs q0_mm"),
        ("stroke_mm = [0.0, 250.0]", "stroke_mm = [-600.0, 250.0]", "stroke_mm", "shrink to nothing"),
        ('"T1",\n]', '"T1",\n "T1"\n]\nzz = 3', '"T1"\n', "'T1' twice"),
        ("= 20.0", "= [20.0, 60.0]", "60.0", "inside valid_degC"),
        ("= 20.0", "= [20.0, 21.0]", "reference_temp", "1 value for each of the sensors: leg1_T1"),
        ("campaign", "covariance_per_K2 = [[1]]\nzz = 1\ncampaign", "covariance", "2 rows and columns"),
        ("campaign", "covariance_per_K2 = [[1, 2], [3, 4]]\nzz = 1\ncampaign", "covariance", "symmetric"),
        ("campaign", "spread_per_K = [1e-8, 1e-8]\nzz = 1\ncampaign", "spread", "is part of covariance_per_K2"),
        ("campaign", "covariance_per_K2 = [[1e-18, 0], [0, 1e-18]]\nspread_per_K = [1e-9]\nzz = 1\ncampaign", "spread",
         "expected"),
        ("campaign", "covariance_per_K2 = [[1e-18, 0], [0, 1e-18]]\nspread_per_K = [2e-9, 0]\nzz = 1\ncampaign",
         "spread", "no larger"),
        ("expansion_per_K = 1.6e-06\n", 'expansion_per_K = 1.6e-06\nsensor = ""\n', "sensor =", "must be a name"),
        ("leg_body_diameter_mm = 80.0", "leg_body_diameter_mm = 80.0\nzz = 1", "zz", "unknown key"),
        ("[192.836, -229.813, 0.0],", "[300],", "[300]", "different length"),
        ("[192.836, -229.813, 0.0],", "[192.836, nan, 0.0],", "nan", "finite"),
        ("[192.836, -229.813, 0.0],", "[192.836, [[1]], 0.0],", "[[1]]", "too deep"),
        ("[192.836, -229.813, 0.0],", "[192.836, true, 0.0],", "true", "must be a number"),
        ("q0_mm = 600.0", "q0_mm = 1e9999999999999999999", "q0_mm", "finite number, found 1e9999999999999999999"),
        ("q0_mm = 600.0", "q0_mm = 1e400", "q0_mm", "finite"),
        ("q0_mm = 600.0", "q0_mm = 1e-999999999999999", "q0_mm", "too small"),
        ("q0_mm = 600.0", f"q0_mm = {'9' * 5000}", "9" * 5000, "too many digits"),
        ("q0_mm = 600.0", f"q0_mm = 0x{'f' * 5000}", "q0_mm", "finite"),
        ("q0_mm = 600.0", f"q0_mm = {'[' * 5000}{']' * 5000}", "q0_mm", "too deep"),
        ("q0_mm = 600.0", "q0_mm = = 3", "= 3", "not valid TOML"),
        ('name = "reference"', 'name = """\n[geometry]\nq0_mm = 3\n"""\nfoo.bar = 3', "foo", "unknown key 'foo'"),
        ('name = "reference"', 'name = "a\u2028b\u0085c"\nzz = 3', "zz", "unknown key 'zz'"),
        ("[thermal.leg]", '["thermal" . leg] # [x]\n"z z" = 1', '"z z"', "unknown key 'z z'"),
        ("[geometry]\n", "[geometry]\n'é' = {a = [1, 2], b = 3}\n", "'é'", "unknown key 'é'"),
    ],
)  # fmt: skip
def test_each_complaint_names_its_place(tmp_path: Path, old: str, new: str, place: str, word: str) -> None:
    """The complaint stands at the line and column of the key, or of the array's element."""
    assert old in GOOD
    text = GOOD.replace(old, new, 1)
    found = problems(tmp_path, text)
    start = place_of(text, "[" * 5000) if "[" * 5000 in text else place_of(text, place)
    if "[" * 5000 in text:
        start = start.partition(",")[0]
    assert any(entry.startswith(start) and word in entry for entry in found), (start, found)


@pytest.mark.parametrize("name", ["geometry", "format"])
def test_one_cause_has_one_complaint(tmp_path: Path, name: str) -> None:
    """A missing table or key is reported once."""
    table = GOOD[GOOD.index("[geometry]") : GOOD.index("[thermal]")]
    line = 'format = "hexathermal-hexapod/1"\n'
    found = problems(tmp_path, GOOD.replace(table if name == "geometry" else line, ""))
    assert found == [f"line 1, column 1: key '{name}' is missing"]


ODD_TOML = """\
title = '''
[fake]
x = 3''' # y = [
rows = [
  [300],
  [1, "a]\\"", # ] here
   2_0],
]
[ thermal . leg ]
A = 1.5e-6
["thermal".'b c']
foo.bar = 1979-05-27 07:32:00
"\\u00e9" = {x = 1, y = [1, {z = 2}]}
[[legs]]
a = ""
[[legs]]
a = {}
[legs.sub]
1.5 = []
"""
ODD_PLACES = {
    ("title",): (1, 1), ("rows",): (4, 1), ("rows", 0): (5, 3), ("rows", 0, 0): (5, 4), ("rows", 1): (6, 3),
    ("rows", 1, 1): (6, 7), ("rows", 1, 2): (7, 4), ("thermal",): (9, 1), ("thermal", "leg"): (9, 1),
    ("thermal", "leg", "A"): (10, 1), ("thermal", "b c"): (11, 1), ("thermal", "b c", "foo"): (12, 1),
    ("thermal", "b c", "foo", "bar"): (12, 5), ("thermal", "b c", "é"): (13, 1), ("thermal", "b c", "é", "x"): (13, 13),
    ("thermal", "b c", "é", "y"): (13, 20), ("thermal", "b c", "é", "y", 1, "z"): (13, 29), ("legs",): (14, 1),
    ("legs", 0): (14, 1), ("legs", 0, "a"): (15, 1), ("legs", 1): (16, 1), ("legs", 1, "a"): (17, 1),
    ("legs", 1, "sub"): (18, 1), ("legs", 1, "sub", "1"): (19, 1), ("legs", 1, "sub", "1", "5"): (19, 3),
    ("legs", 7): (14, 1), ("nothing",): (1, 1),
}  # fmt: skip


@pytest.mark.parametrize("end", ["\n", "\r\n"])
def test_places_follow_toml(end: str) -> None:
    """Strings over lines, comments, quoted and dotted keys, inline tables and nested arrays do not shift places."""
    text = ODD_TOML.replace("\n", end)
    assert tomllib.loads(text)["thermal"]["b c"]["é"]["y"][1] == {"z": 2}
    positions = Positions(text)
    assert {where: positions.of(where) for where in ODD_PLACES} == ODD_PLACES


values = st.recursive(
    st.one_of(st.integers(), st.booleans(), st.floats(), st.text(), st.dates()),
    lambda inner: st.one_of(st.lists(inner, max_size=3), st.dictionaries(st.text(), inner, max_size=3)),
    max_leaves=12,
)


@given(st.dictionaries(st.text(), values, max_size=4), st.booleans())
def test_every_value_of_a_toml_file_has_its_place(document: dict[str, object], multiline: bool) -> None:
    """Whatever TOML is written, the text at a key's place starts with that key or its table's bracket."""
    text = tomli_w.dumps(document, multiline_strings=multiline)
    positions, lines = Positions(text), text.split("\n")

    def walk(value: object, where: tuple[str | int, ...]) -> None:
        line, column = positions.of(where)
        rest = lines[line - 1][column - 1 :]
        if where and isinstance(where[-1], str):
            assert rest[0] in "[\"'" or rest.startswith(where[-1]), (where, rest)
            assert where in positions._offsets
        for key, entry in value.items() if isinstance(value, dict) else enumerate(value if type(value) is list else ()):
            walk(entry, (*where, key))

    walk(tomllib.loads(text), ())


def test_text_that_is_none_is_named_with_its_place(tmp_path: Path) -> None:
    """A byte order mark is accepted; bytes that are no UTF-8 are reported at their line and column."""
    file = tmp_path / "hexapod.toml"
    file.write_bytes(b"\xef\xbb\xbf" + GOOD.encode())
    assert ht.load_hexapod(file) == ht.load_hexapod("reference")
    for mark in (b"", b"\xef\xbb\xbf"):
        file.write_bytes(mark + 'a = 1\n"é" = "'.encode() + b'\xff"')
        with pytest.raises(FileFormatError, match="line 2, column 8: not a text file in UTF-8"):
            ht.load_hexapod(file)
    file.write_text('a = 1\nb = "ä')
    with pytest.raises(FileFormatError, match="line 2, column 7: not valid TOML"):
        ht.load_hexapod(file)


def test_a_file_that_cannot_be_read_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """What the system says about an unreadable file stands in the package's own error."""
    file = ht.write_hexapod(ht.load_hexapod("reference"), tmp_path)

    def refuse(path: Path) -> bytes:
        raise PermissionError(13, "Permission denied", str(path))

    monkeypatch.setattr(Path, "read_bytes", refuse)
    with pytest.raises(FileFormatError, match="cannot be read: Permission denied"):
        ht.load_hexapod(file)


@pytest.mark.parametrize("change", [{"prec": 4}, {"Emax": 2, "Emin": -2}, {"traps": [FloatOperation, Inexact]}])
def test_a_machine_does_not_depend_on_the_callers_decimals(tmp_path: Path, change: dict[str, Any]) -> None:
    """The caller's decimal precision, range and traps change neither a machine that is read nor a file written."""
    file = tmp_path / "hexapod.toml"
    file.write_text(GOOD.replace("443.163,", "443.16312345678901,").replace("45.0", "45.12345678901234"))
    machine = ht.load_hexapod(file)
    text = ht.write_hexapod(machine, tmp_path / "a.toml").read_text()
    with localcontext(Context(**change)):
        assert ht.load_hexapod(file) == machine
        assert ht.write_hexapod(machine, tmp_path / "b.toml").read_text() == text


@given(st.floats(-1e3, 1e3))
def test_millimetres_are_rounded_once(value: float) -> None:
    """A decimal in millimetres becomes the double nearest to its thousandth."""
    assert metres(Decimal(value)) == float(Fraction(value) / 1000)


def test_the_sign_of_zero_is_kept(tmp_path: Path, reference: ht.Hexapod) -> None:
    """-0.0 is written and read as -0.0, also where the other legs have 0.0."""
    for reader in (metres, radians, same):
        assert np.signbit(reader(shortest(-0.0, reader)))
        assert not np.signbit(reader(shortest(0.0, reader)))
    stroke = np.array([[0.0, 0.25]] * 5 + [[-0.0, 0.25]])
    laws = [ht.LegLaw("T1", 0.0 * sign, 1e-6) for sign in (1, 1, 1, 1, 1, -1)]
    machine = ht.Hexapod(
        reference.base_joints, reference.platform_joints, 0.6, stroke, home=[-0.0, 0, 0], thermal=ht.ThermalModel(laws)
    )
    again = ht.load_hexapod(ht.write_hexapod(machine, tmp_path))
    assert again.stroke is not None
    assert again.thermal is not None
    assert np.array_equal(np.signbit(again.stroke), np.signbit(stroke))
    assert np.signbit(again.home[0, 3])
    assert [bool(np.signbit(law.A[0])) for law in again.thermal.legs] == [False] * 5 + [True]


def test_what_cannot_be_written_leaves_nothing_behind(tmp_path: Path, reference: ht.Hexapod) -> None:
    """Wrong arguments, places that are files and texts that are no Unicode are refused, without a file."""
    place = tmp_path / "file"
    place.write_text("")
    odd = dataclasses.replace(reference, name="lone \ud800")
    calls: list[tuple[Any, Any]] = [
        (reference, None), (None, tmp_path), (reference, place), (reference, place / "a" / "b.toml"),
        (reference, "/proc/nowhere/machine.toml"), (reference, str(tmp_path / "a\0b.toml")), (odd, tmp_path / "x.toml"),
    ]  # fmt: skip
    for machine, path in calls:
        with pytest.raises(ArgumentError):
            ht.write_hexapod(machine, path)
    with pytest.raises(ArgumentError, match="by NoneType"):
        read_hexapod(None)  # type: ignore[arg-type]
    assert list(tmp_path.iterdir()) == [place]


def test_only_a_path_that_ends_in_toml_is_a_file(tmp_path: Path, reference: ht.Hexapod) -> None:
    """Any other path is the folder, also with a dot in its name."""
    assert ht.write_hexapod(reference, tmp_path / "machine.v2") == tmp_path / "machine.v2" / "hexapod.toml"
    assert ht.write_hexapod(reference, tmp_path / "machine.toml") == tmp_path / "machine.toml"
    assert ht.load_hexapod(tmp_path / "machine.v2") == reference
    assert not list(tmp_path.rglob("*.part"))
