"""``hexathermal diagnose`` as a user meets it: the finding first, tables, files, clear errors."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path

import pytest

import hexathermal as ht
from hexathermal.cli import main
from hexathermal.learn.diagnosis.result import Diagnosis
from hexathermal.simulate.hidden.drawing import campaign_of
from hexathermal.simulate.hidden.writing import write_campaign
from tests.diagnosed import Ran, diagnosed
from tests.learn.campaign_folders import component_campaign, leg_campaign
from tests.show.drawn_diagnoses import drawn

SEED = 5


@pytest.fixture(scope="module")
def ran(tmp_path_factory: pytest.TempPathFactory) -> Ran:
    """The command on a leg with backlash, run once with every option that writes."""
    place = tmp_path_factory.mktemp("diagnose")
    truth, answer = campaign_of("rough", SEED, causes=("backlash",), strength=1.5)
    roles = {role: [run for run in truth.runs if run.role == role] for role in ("identification", "validation")}
    truth = replace(truth, runs=(*roles["identification"][:5], *roles["validation"][:2]))
    write_campaign(place / "campaign", truth, answer)
    return diagnosed(place / "campaign", place, "extended.toml", "--sensors", ",".join(answer.base))


def test_the_finding_is_the_first_line(ran: Ran) -> None:
    """One sentence with name and size stands first; every table of the issue follows."""
    first = ran.out.splitlines()[0]
    assert first == ran.facts["effects"][0]["sentence"]
    assert first.startswith("The residual is backlash")
    for words in ("probability", "evidence log", "95 % interval", "RMSE before um", "would be named from", "next"):
        assert words in ran.out
    assert ran.err == ""


def test_json_and_tables_say_the_same(ran: Ran) -> None:
    """The step in the table is that of the JSON, its interval 1.96 standard uncertainties wide on each side."""
    step = ran.facts["parameters"]["step_um"]
    row = next(line for line in ran.out.splitlines() if re.match(r"(backlash +-)? +step +-?\d", line))
    value, std, low, high = map(float, re.findall(r"-?\d+\.\d+", row)[:4])
    assert value == pytest.approx(step["value"], abs=2 * std)
    assert std == pytest.approx(step["std"], rel=0.06)
    assert (high - low) / 2 == pytest.approx(1.96 * step["std"], rel=0.1)
    assert low < value < high


def test_the_extended_law_is_used_like_any_other(ran: Ran, capsys: pytest.CaptureFixture[str]) -> None:
    """It holds the term, and `validate` finds the same RMSE on the runs never fitted."""
    law = ht.read_leg_law(ran.files / "extended.toml")
    assert [term.cause for term in law.terms] == ["backlash"]
    assert main(["validate", str(ran.files / "extended.toml"), str(ran.campaign), "--json", "-"]) == 0
    total = json.loads(capsys.readouterr().out)["total"]
    assert total["rmse_um"]["value"] == pytest.approx(ran.facts["gain"]["rmse_after_um"], rel=1e-9)


def test_every_file_that_is_named_is_there(ran: Ran) -> None:
    """Page, pictures, numbers and law: as `written` says, as the terminal says, and no others."""
    named = {Path(file) for file in ran.facts["written"]}
    assert named == {*(ran.files / "report").iterdir(), ran.files / "extended.toml"}
    assert all(str(file) in ran.out for file in named)
    page = (ran.files / "report" / "report.html").read_text(encoding="utf-8")
    assert "The residual is backlash" in page
    inside = json.loads((ran.files / "report" / "diagnosis.json").read_text())
    assert sorted(inside.pop("files")) == sorted(file.name for file in (ran.files / "report").iterdir())
    assert inside == {name: ran.facts[name] for name in inside}


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--sensors", "T99"], ["T99", "T01"]),
        (["--sensors", "T0l"], ["did you mean", "'T0l'"]),
        (["--sensors", ","], ["names no sensor"]),
        (["--law", "no.toml"], ["no law at no.toml"]),
        (["--law", "EXTENDED", "--sensors", "T01"], ["not both"]),
        (["--law", "COMPONENT"], ["kind 'component'", "kind 'leg'"]),
        (["--extend", "EXTENDED"], ["exists already", "--force"]),
        (["--extend", "INSIDE"], ["--extend", "lies inside", "read"]),
        (["--law", "EXTENDED"], ["extended already, by backlash", "--sensors T"]),
        (["--extend", "EXTENDED", "--law", "EXTENDED", "--force"], ["--extend", "is one of the files that are read"]),
        (["--extend", "nowhere/law.toml"], ["there is no folder"]),
        (["--extend", "nowhere/in/law.toml", "--report", "nowhere"], ["there is no folder"]),
        (["--extend", "-"], ["--extend needs the name of a file"]),
        (["--report", "EXTENDED"], ["no folder"]),
        (["--report", "BY HAND"], ["holds report.html, which no diagnosis wrote", "--force"]),
        (["--report", "CAMPAIGN"], ["--report", "lies inside", "read"]),
    ],
)  # fmt: skip
def test_wrong_usage_is_said_in_one_message(
    ran: Ran, words: list[str], said: list[str], capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    """Each mistake: exit code 2, what is wrong and what to try, no traceback, nothing written."""
    from hexathermal.learn.leg_law_files import write_leg_law
    from tests.show.drawn_diagnoses import plain_law

    component = write_leg_law(plain_law("component"), tmp_path / "component.toml")
    stand_for = {"EXTENDED": ran.files / "extended.toml", "INSIDE": ran.campaign / "law.toml", "COMPONENT": component,
                 "CAMPAIGN": ran.campaign / "report", "BY HAND": tmp_path}  # fmt: skip
    (tmp_path / "report.html").write_text("my own page")
    before = {file: file.stat().st_mtime_ns for file in ran.files.rglob("*")}
    assert main(["diagnose", str(ran.campaign), *(str(stand_for.get(word, word)) for word in words)]) == 2
    shown = capsys.readouterr()
    assert all(text in shown.err for text in said)
    assert "Traceback" not in shown.err
    assert not shown.out
    assert {file: file.stat().st_mtime_ns for file in ran.files.rglob("*")} == before


def test_too_little_data_is_answered_as_such(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A part measured for a few hours: the message says what there is and what it needs; bad input, exit code 3."""
    assert main(["diagnose", str(component_campaign(tmp_path / "short")), "--sensors", "T1"]) == 3
    shown = capsys.readouterr()
    assert "too little data" in shown.err
    assert not shown.out


def test_a_damaged_campaign_is_an_error_of_its_table(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A column that is cut off is reported with file and line, exit code 3."""
    folder = leg_campaign(tmp_path / "leg")
    file = next(folder.rglob("*.csv"))
    lines = file.read_text().splitlines()
    lines[7] = lines[7].rsplit(",", 3)[0]
    file.write_text("\n".join(lines) + "\n")
    assert main(["diagnose", str(folder), "--sensors", "T01"]) == 3
    shown = capsys.readouterr()
    assert file.name in shown.err
    assert "8" in shown.err
    assert "Traceback" not in shown.err


@pytest.mark.parametrize("words", [["--laws", "keep"], ["--propose", "20"], ["--machine", "reference"]])
def test_options_of_a_machine_are_refused(ran: Ran, words: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    """What is for six legs together does nothing for one: it is refused by name, not passed over."""
    assert main(["diagnose", str(ran.campaign), *words]) == 2
    shown = capsys.readouterr()
    assert words[0] in shown.err
    assert "kind 'hexapod'" in shown.err
    assert not shown.out


@pytest.fixture
def found(monkeypatch: pytest.MonkeyPatch, request: pytest.FixtureRequest) -> Diagnosis:
    """A diagnosis made by hand in the place of the search."""
    import hexathermal.learn.diagnosis as diagnosis

    given: Diagnosis = drawn(**request.param)
    monkeypatch.setattr(diagnosis, "diagnose", lambda *_args, **_more: given)
    return given


@pytest.mark.parametrize("found", [{"verdict": "none"}], indirect=True)
def test_where_nothing_joins_the_law_is_written_and_said(
    found: Diagnosis, ran: Ran, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """--extend gives a law that can be used in any case; that it holds no term is a warning."""
    out = tmp_path / "law.toml"
    assert main(["diagnose", str(ran.campaign), "--extend", str(out)]) == 0
    shown = capsys.readouterr()
    assert shown.out.startswith("No effect of the catalogue stands above 0.02 um")
    assert "nothing joined the law" in shown.err
    assert ht.read_leg_law(out).coefficients.tolist() == found.law.coefficients.tolist()
    assert not ht.read_leg_law(out).extended
    assert "RMSE after" not in shown.out


@pytest.mark.usefixtures("dots")
@pytest.mark.parametrize("found", [{}], indirect=True)
@pytest.mark.parametrize("place", ["new/report/law.toml", "new/law.toml"])
def test_a_law_may_go_into_the_folder_that_the_report_makes(
    found: Diagnosis, place: str, ran: Ran, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """--extend into the folder of --report, or a parent made with it: both are written, and stay side by side."""
    report, law = tmp_path / "new" / "report", tmp_path / place
    words = ["diagnose", str(ran.campaign), "--report", str(report), "--extend", str(law)]
    assert main(words) == 0
    assert ht.read_leg_law(law).extended == found.extended.extended
    assert (report / "report.html").is_file()
    assert main([*words, "--force"]) == 0
    assert law.is_file()
    assert not capsys.readouterr().err


@pytest.mark.parametrize("found", [{"verdict": "unexplained"}, {"held": False}], indirect=True)
def test_what_is_not_known_is_said(found: Diagnosis, ran: Ran, capsys: pytest.CaptureFixture[str]) -> None:
    """What something nameless follows; and that without runs for validation no gain is known."""
    assert main(["diagnose", str(ran.campaign)]) == 0
    out = capsys.readouterr().out
    assert ("no runs for validation" in out) == (found.gain is None)
    assert out.startswith("Something real is left that follows the humidity" if found.follows else "The residual is")
    assert "nan" not in out.replace("unexplained", "")


@pytest.mark.parametrize("found", [{"kind": "component"}], indirect=True)
def test_json_to_stdout_is_nothing_else(found: Diagnosis, ran: Ran, capsys: pytest.CaptureFixture[str]) -> None:
    """With --json - stdout is one JSON document with the ranking and limits."""
    assert main(["diagnose", str(ran.campaign), "--json", "-"]) == 0
    facts = json.loads(capsys.readouterr().out)
    assert facts["format"] == "hexathermal-diagnosis/1"
    assert facts["cause"] == found.cause == "backlash"
    assert [one["cause"] for one in facts["candidates"]][:2] == ["backlash", "creep"]


def test_help_teaches(capsys: pytest.CaptureFixture[str]) -> None:
    """--help names every cause of the catalogue, what evidence means, the files, and examples."""
    from hexathermal.learn.diagnosis.causes import catalogue
    from hexathermal.learn.machine_diagnosis.causes import catalogue as of_machines

    assert main(["diagnose", "--help"]) == 0
    text = capsys.readouterr().out
    assert all(name in text for name in (*catalogue(), *of_machines()))
    for words in (
        "--laws",
        "--propose",
        "--machine",
        "--sensors",
        "--law",
        "--extend",
        "--report",
        "--json",
        "examples:",
        "evidence",
        "report.html",
    ):
        assert words in text
