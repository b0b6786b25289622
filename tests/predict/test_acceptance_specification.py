"""Specifications: what is read, and every fault with line and column."""

from __future__ import annotations

from pathlib import Path

import pytest

from hexathermal.errors import ArgumentError, FileFormatError
from hexathermal.predict.acceptance import read_specification
from tests.predict.acceptance_files import FORMAT, written

SPEC = FORMAT + "[limits]\n"


@pytest.mark.parametrize(
    ("spec", "line", "words"),
    [
        ("[limits]\nAP_um = 1\n", 1, "'format' is missing"),
        (FORMAT.replace("/1", "/2") + "[limits]\nAP_um = 1\n", 1, "this version reads"),
        (FORMAT, 1, "'limits' is missing"),
        (SPEC, 2, "holds no limit"),
        (SPEC + "AP = 1\n", 3, "did you mean 'AP_um'"),
        (SPEC + "AP_um = true\n", 3, "must be a number"),
        (SPEC + "AP_um = -1\n", 3, "must be above 0"),
        (SPEC + "AP_um = nan\n", 3, "finite"),
        (SPEC + "AP_um = {upper = 1, lower = 0}\n", 3, "cannot be negative"),
        (SPEC + "AP_um = {}\n", 3, "give upper"),
        (SPEC + "AP_x_um = {upper = 1}\n", 3, "may be negative"),
        (SPEC + "AP_x_um = {upper = 1, lower = 2}\n", 3, "above lower"),
        (SPEC + "AP_x_um = {within = 1, upper = 2}\n", 3, "give it alone"),
        (SPEC + "AP_um = {upper = 1, u = 0}\n", 3, "no measurement is exact"),
        (SPEC + "AP_um = {upper = 1, u = 1, U = 2}\n", 3, "not both"),
        (SPEC + "AP_um = {upper = 1, rule = 'simpel'}\n", 3, "did you mean 'simple'"),
        (SPEC + "AP_um = {upper = 1, probability = 95}\n", 3, "above 0.5 and below 1"),
        (SPEC + "AP_um = {upper = 1, window_s = 60}\n", 3, "of ETVE only"),
        (SPEC + "AP_um = {upper = 1, uper = 60}\n", 3, "unknown key 'uper'; did you mean 'upper'"),
        (SPEC + "AP_um = {upper = 1, nonnegative = 1}\n", 3, "true or false"),
        (SPEC + "AP_x_um = {within = 1, nonnegative = true}\n", 3, "may be negative"),
        (FORMAT + "warm_up_s = 60\n[limits]\nAP_um = 1\n", 2, "at least 3600"),
        (FORMAT + "[limits]\nRP_um = 1\nAP_um = []\n", 4, "empty list"),
        (FORMAT + "letters = 'abc'\n[limits]\nAP_um = 1\n", 2, "one of xyz, zyx"),
        (FORMAT + "[uncertainty]\nposition_um = 0\n[limits]\nAP_um = 1\n", 3, "above 0"),
        (FORMAT + "limits = 3\n", 2, "must be a table"),
        (SPEC + "AP_um = [1, 2]\n", 3, "one value"),
        (SPEC + "AP_um = \n", 3, "not valid TOML"),
    ],
)
def test_bad_specifications_name_line_and_reason(tmp_path: Path, spec: str, line: int, words: str) -> None:
    """Every bad field of a specification is found where it stands, with what would be right."""
    with pytest.raises(FileFormatError, match=words) as caught:
        read_specification(written(tmp_path, spec, "spec.toml"))
    assert [problem.line for problem in caught.value.problems] == [line]


def test_the_specification_of_the_documentation_is_one(tmp_path: Path) -> None:
    """The example of docs/acceptance.md reads as it stands: units, both sides, expanded uncertainty, two windows."""
    page = (Path(__file__).parents[2] / "docs" / "acceptance.md").read_text(encoding="utf-8")
    found = read_specification(written(tmp_path, page.split("```toml\n")[1].split("```")[0], "spec.toml"))
    numbers = [[limit.lower, limit.upper, limit.uncertainty] for limit in found.limits]
    micro = [[None if number is None else round(number * 1e6, 12) for number in row] for row in numbers]
    read = [(limit.key, *row, limit.window) for limit, row in zip(found.limits, micro, strict=True)]
    assert read == [
        ("AP_um", None, 10, 0.3, None),
        ("RP_um", None, 2, 0.2, None),
        ("AP_rz_urad", -20, 20, 1.5, None),
        ("AP_z_um", -3, 5, 0.3, None),
        ("ETVE_z_um", None, 3, 0.3, 3600.0),
        ("ETVE_z_um", None, 8, 0.3, None),
    ]


def test_all_bad_fields_come_together(tmp_path: Path) -> None:
    """Three faults are three problems of one error."""
    text = FORMAT + "rule = 'none'\n[limits]\nAP = 1\nRP_um = 'x'\n"
    with pytest.raises(FileFormatError) as caught:
        read_specification(written(tmp_path, text, "spec.toml"))
    assert [problem.line for problem in caught.value.problems] == [2, 4, 5]


def test_every_bad_field_of_one_table_is_told(tmp_path: Path) -> None:
    """Six bad fields of one inline table, one of them behind an unknown quantity, are six problems with columns."""
    spec = 'limits.RP_um = { upper = "x", u = -1, rule = "foo", probability = 7, k = 0 }\nlimits.XX_um = { u = -1 }\n'
    with pytest.raises(FileFormatError) as caught:
        read_specification(written(tmp_path, FORMAT + spec, "spec.toml"))
    places = [(problem.line, problem.column) for problem in caught.value.problems]
    assert places == [(2, 1 + spec.index(word)) for word in ("upper", "u = ", "rule", "prob", "k =")] + [
        (3, 8),
        (3, 18),
    ]


def test_a_specification_that_is_not_there_is_told(tmp_path: Path) -> None:
    """A missing file and a folder are no specification; a number is no path."""
    for path, words in ((tmp_path / "none.toml", "no specification at"), (tmp_path, "it is a folder"), (3, "named by")):
        with pytest.raises(ArgumentError, match=words):
            read_specification(path)  # type: ignore[arg-type]
