"""``hexathermal accept``: exit codes that a test system can trust, JUnit XML, JSON, and no verdict from an error."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from xml.etree import ElementTree as ET

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from hexathermal import cli

Said = pytest.CaptureFixture[str]

POSE = "x_mm,y_mm,z_mm,rx_deg,ry_deg,rz_deg"
TABLE = f"pose,{POSE}," + ",".join(f"measured_{name}" for name in POSE.split(",")) + "\n"
TABLE += "A,0,0,0,0,0,0,0.001,0,0,0,0,0\nA,0,0,0,0,0,0,0.003,0,0,0,0,0\n"
SPEC = 'format = "hexathermal-spec/1"\ntitle = "Hexapod <12> & co"\n[uncertainty]\nposition_um = 0.1\n[limits]\n'
PASS, UNDECIDED, FAIL = "AP_um = 3\n", "AP_um = 2.1\n", "AP_um = 1\n"


@pytest.fixture
def files(tmp_path: Path) -> list[str]:
    """Arguments of an `accept` that passes."""
    (tmp_path / "measured.csv").write_text(TABLE, encoding="utf-8")
    return specified(tmp_path, PASS)


def specified(folder: Path, limits: str) -> list[str]:
    """Arguments of an `accept` with limits."""
    (folder / "spec.toml").write_text(SPEC + limits, encoding="utf-8")
    return ["accept", str(folder / "measured.csv"), "--spec", str(folder / "spec.toml")]


@pytest.mark.parametrize(("limits", "code", "word"), [(PASS, 0, "PASS"), (FAIL, 1, "FAIL"), (UNDECIDED, 2, "NOT DEC")])
def test_verdicts_are_exit_codes(
    files: list[str], tmp_path: Path, limits: str, code: int, word: str, capsys: Said
) -> None:
    """0 pass, 1 fail, 2 not decided; the verdict with its probability goes to stdout, notes to stderr."""
    assert cli.main(specified(tmp_path, limits)) == code
    said = capsys.readouterr()
    assert word in said.out
    assert "probability that all limits are met" in said.out
    assert "ISO 9283 asks for 30" in said.err


@pytest.mark.parametrize(
    "change",
    [
        lambda arguments, _: arguments[:2],
        lambda arguments, _: arguments[:1],
        lambda arguments, _: [*arguments, "--nonsense"],
        lambda arguments, _: [*arguments, "--spec"],
        lambda arguments, _: [*arguments, "--convention", "euler"],
        lambda arguments, _: [*arguments, "--object-frame", "1", "2"],
        lambda arguments, _: ["accept", "nothing.csv", *arguments[2:]],
        lambda arguments, _: [*arguments[:3], "nothing.toml"],
        lambda arguments, _: [*arguments[:3], arguments[1]],
        lambda arguments, _: ["accept", arguments[3], "--spec", arguments[3]],
        lambda arguments, folder: ["accept", str(folder), "--spec", arguments[3]],
        lambda arguments, _: [*arguments, "--junit", "/dev/null"],
        lambda arguments, _: [*arguments, "--junit", "/nowhere/at/all.xml"],
        lambda arguments, _: [*arguments, "--json", "/nowhere/at/all.json"],
        lambda arguments, _: [*arguments, "--junit", arguments[1]],
        lambda arguments, _: [*arguments, "--json", arguments[3]],
        lambda arguments, folder: [*arguments, "--json", f"{folder}/same", "--junit", f"{folder}/same"],
        lambda arguments, _: [*arguments, "zero\0byte"],
    ],
)
def test_no_error_looks_like_a_verdict(files: list[str], tmp_path: Path, change: object, capsys: Said) -> None:
    """Wrong usage, missing files and files that cannot be written end with 3, one message, and no traceback."""
    before = [(tmp_path / name).read_bytes() for name in ("measured.csv", "spec.toml")]
    assert cli.main(change(files, tmp_path)) == 3  # type: ignore[operator]
    said = capsys.readouterr()
    assert said.err.strip()
    assert "Traceback" not in said.err
    assert [(tmp_path / name).read_bytes() for name in ("measured.csv", "spec.toml")] == before


def test_an_error_inside_is_no_fail(files: list[str], monkeypatch: pytest.MonkeyPatch, capsys: Said) -> None:
    """A fault of the program itself ends with 3 too: 1 would say that the machine failed."""

    def broken(*_: object) -> None:
        raise RuntimeError("broken")

    monkeypatch.setattr("hexathermal.predict.acceptance.accept", broken)
    assert cli.main(files) == 3
    assert "error inside hexathermal" in capsys.readouterr().err


def test_other_commands_keep_their_codes() -> None:
    """Wrong usage of another command is still 2, a misspelt name of one too."""
    for words in (["correct", "--nonsense"], ["corect"], ["--nonsense"], []):
        assert cli.main(words) == 2


@pytest.mark.parametrize("name", ["acept", "acccept", "excel", "accept.", "spec.toml", "\0"])
def test_a_misspelt_command_is_no_verdict(files: list[str], name: str, capsys: Said) -> None:
    """A command that is not known ends with 3 where it may have been accept: 2 would say not decided."""
    assert cli.main([name, *files[1:]]) == 3
    assert capsys.readouterr().err.strip()


def test_a_reader_that_goes_away_changes_no_verdict(files: list[str], tmp_path: Path) -> None:
    """With stdout closed early the exit code still is the verdict."""
    program = [sys.executable, "-m", "hexathermal", *specified(tmp_path, FAIL)]
    done = subprocess.Popen(program, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)
    assert done.stdout is not None
    done.stdout.close()
    assert done.wait() == 1


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=40)
@given(st.binary(max_size=60), st.booleans(), st.integers(0, 400))
def test_garbage_is_never_a_verdict(files: list[str], tmp_path: Path, garbage: bytes, table: bool, at: int) -> None:
    """Bytes thrown into a copy of either file end with 3, or with the verdict where they say nothing."""
    arguments = specified(tmp_path, PASS)
    (tmp_path / "measured.csv").write_text(TABLE, encoding="utf-8")
    file = Path(arguments[1 if table else 3])
    text = file.read_bytes()
    file.write_bytes(text[:at] + b"\x00" + garbage + text[at:])
    assert cli.main(arguments) == 3


def test_json_is_the_answer_in_full(files: list[str], tmp_path: Path, capsys: Said) -> None:
    """stdout is JSON and nothing else with '-'; a file holds the same; numbers are in um with their rule."""
    assert cli.main([*specified(tmp_path, UNDECIDED), "--json", "-"]) == 2
    data = json.loads(capsys.readouterr().out)
    assert cli.main([*files, "--json", str(tmp_path / "out.json")]) == 2
    assert json.loads((tmp_path / "out.json").read_text()) == data
    assert (data["format"], data["verdict"], data["exit_code"]) == ("hexathermal-acceptance/1", "not decided", 2)
    result = data["results"][0]
    assert (result["value"], result["upper"], result["standard_uncertainty"]) == (2.0, 2.1, 0.1)
    assert result["conformance_probability"] == pytest.approx(0.841345, abs=1e-6)
    assert result["acceptance_upper"] == pytest.approx(2.1 - 0.1644854, abs=1e-6)
    assert data["poses"][0]["RP_um"] == pytest.approx(1.0)
    assert data["probability_at_least"] == data["probability_at_most"] == result["conformance_probability"]


def test_junit_is_read_by_test_systems(files: list[str], tmp_path: Path) -> None:
    """Counts agree with the cases; names are unique; a fail is a failure, what is not decided an error, never green."""
    limits = "AP_um = [{upper = 3}, {upper = 1}, {upper = 2.1}]\nRP_um = 9\nAP_x_um = 9\n"
    assert cli.main([*specified(tmp_path, limits), "--junit", str(tmp_path / "out.xml")]) == 1
    top = ET.parse(tmp_path / "out.xml").getroot()
    suite = top.find("testsuite")
    assert suite is not None
    cases = suite.findall("testcase")
    counted = {"tests": 5, "failures": len(suite.findall("*/failure")), "errors": len(suite.findall("*/error"))}
    assert counted == {"tests": 5, "failures": 1, "errors": 1}
    for element in (top, suite):
        assert {name: int(element.get(name, "-1")) for name in counted} == counted
    names = [(case.get("classname"), case.get("name")) for case in cases]
    assert len(set(names)) == len(cases) == 5
    assert names[0] == ("acceptance.Hexapod <12> & co", "AP_um pose A")
    failure = suite.find("*/failure")
    assert failure is not None
    assert "AP = 2.0000 um at pose A, limit <= 1 um; standard uncertainty 0.1 um" in failure.get("message", "")
    assert all(float(case.get("time", "nan")) == 0.0 for case in cases)


def test_names_that_xml_cannot_hold_are_written_out(files: list[str], tmp_path: Path) -> None:
    """A control character in a pose's name leaves the XML well-formed."""
    (tmp_path / "measured.csv").write_text(TABLE.replace("A,", "A\x07<&,"), encoding="utf-8")
    assert cli.main([*files, "--junit", str(tmp_path / "out.xml")]) == 0
    case = ET.parse(tmp_path / "out.xml").getroot().find("testsuite/testcase")
    assert case is not None
    assert case.get("name") == "AP_um pose A\\x07<&"


def test_a_run_without_a_verdict_leaves_old_results_alone(files: list[str], tmp_path: Path) -> None:
    """Results of an earlier run stay whole where a later one cannot be judged, and no part of a file is left."""
    out = tmp_path / "out.xml"
    assert cli.main([*files, "--junit", str(out)]) == 0
    before = out.read_bytes()
    (tmp_path / "measured.csv").write_text("nothing", encoding="utf-8")
    assert cli.main([*files, "--junit", str(out)]) == 3
    assert out.read_bytes() == before
    assert not list(tmp_path.glob("*.part"))


@pytest.mark.parametrize("text", ["notes\n", "", "<html><testsuites/></html>", '{"format": "x"}'])
def test_a_file_that_is_no_earlier_result_is_kept(files: list[str], tmp_path: Path, text: str, capsys: Said) -> None:
    """--junit replaces JUnit XML, of whatever writer, and nothing else but with --force."""
    out = tmp_path / "out.xml"
    out.write_text(text, encoding="utf-8")
    assert cli.main([*files, "--junit", str(out)]) == 3
    assert "exists and is no earlier JUnit XML" in capsys.readouterr().err
    assert out.read_text(encoding="utf-8") == text
    assert cli.main([*files, "--junit", str(out), "--force"]) == 0
    assert ET.parse(out).getroot().tag == "testsuites"
    for other in ("<testsuite name='a'/>", "\ufeff<?xml version='1.0'?>\n<!-- mine -->\n<testsuites>\n</testsuites>"):
        out.write_text(other, encoding="utf-8")
        assert cli.main([*files, "--junit", str(out)]) == 0
        assert len(ET.parse(out).getroot()) == 1


def test_help_teaches_both_files(capsys: Said) -> None:
    """After reading the help both files can be written; its example of a specification is one."""
    assert cli.main(["accept", "--help"]) == 0
    said = capsys.readouterr().out
    for word in (*POSE.split(",")[:1], "measured_x_mm", "time_s", "group", "hexathermal-spec/1", "--junit", "--json"):
        assert word in said
    for code in ("  0    pass", "  1    fail", "  2    not decided", "  3    no verdict", "  130  interrupted"):
        assert code in said
    assert max(map(len, said.splitlines())) <= 120


def test_the_specification_of_the_help_is_one(tmp_path: Path, capsys: Said) -> None:
    """The example in the help reads as it stands."""
    from hexathermal.predict.acceptance import read_specification

    cli.main(["accept", "--help"])
    lines = capsys.readouterr().out.split("SPEC.toml:\n")[1].split("quantities")[0]
    (tmp_path / "spec.toml").write_text(lines, encoding="utf-8")
    assert [limit.key for limit in read_specification(tmp_path / "spec.toml").limits] == [
        "AP_um", "RP_um", "AP_rz_urad", "ETVE_z_um",
    ]  # fmt: skip


def test_an_empty_list_of_limits_is_no_pass(files: list[str], tmp_path: Path, capsys: Said) -> None:
    """A limit written as [] is bad input with line and column, and no JUnit appears."""
    words = specified(tmp_path, "RP_um = 9\nAP_um = []\n")
    assert cli.main([*words, "--junit", str(tmp_path / "j.xml")]) == 3
    assert "line 7, column 1" in capsys.readouterr().err
    assert not (tmp_path / "j.xml").exists()


def test_junit_and_json_are_written_together(files: list[str], tmp_path: Path, capsys: Said) -> None:
    """Where JSON cannot be written, JUnit is not left behind, nor the other way; where both can, both are there."""
    both = [*files, "--junit", str(tmp_path / "j.xml"), "--json"]
    assert cli.main([*both, str(tmp_path / "no" / "a.json")]) == 3
    assert not (tmp_path / "j.xml").exists()
    no = [*files, "--json", str(tmp_path / "a.json"), "--junit", str(tmp_path / "no" / "j.xml")]
    assert cli.main(no) == 3
    assert not (tmp_path / "a.json").exists()
    assert cli.main([*both, str(tmp_path / "a.json")]) == 0
    assert ET.parse(tmp_path / "j.xml").getroot().tag == "testsuites"
    assert json.loads((tmp_path / "a.json").read_text())["verdict"] == "pass"
    capsys.readouterr()


def test_a_hole_in_the_record_is_not_decided(tmp_path: Path, capsys: Said) -> None:
    """ETVE from a record with a hole of 7 minutes in windows of an hour: not decided, no probability, a note."""
    header = TABLE.splitlines()[0].replace("pose,", "time_s,")
    rows = [f"{t}" + ",0" * 12 for t in range(0, 7200, 10) if not 3000 < t < 3420]
    (tmp_path / "measured.csv").write_text("\n".join([header, *rows]) + "\n", encoding="utf-8")
    words = specified(tmp_path, "ETVE_z_um = {upper = 5, window_s = 3600}\n")
    assert cli.main([*words, "--json", "-"]) == 2
    said = capsys.readouterr()
    assert "gaps" in said.err
    data = json.loads(said.out)
    assert data["results"][0]["conformance_probability"] is None
    assert data["probability_at_least"] is None
    (tmp_path / "spec.toml").write_text(SPEC + "ETVE_z_um = {upper = 5, window_s = 3600, gap_s = 500}\n")
    assert cli.main(words) == 0
    capsys.readouterr()
