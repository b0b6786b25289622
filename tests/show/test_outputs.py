"""What is read is never written over: campaigns, laws, machines."""

from __future__ import annotations

import json
import re
from argparse import Namespace
from pathlib import Path

import pytest

from hexathermal.cli import main
from hexathermal.errors import ArgumentError
from hexathermal.machine.library import load_hexapod
from hexathermal.machine.writing import write_hexapod
from hexathermal.show.outputs import protect
from tests.learn.campaign_folders import leg_campaign


@pytest.mark.parametrize(
    "words",
    [
        ["check", "{c}", "--json", "{c}/campaign.toml"],
        ["check", "{c}", "--json", "{c}/new.json"],
        ["check", "{c}/campaign.toml", "--plots", "{c}/plots"],
        ["identify", "{c}", "--out", "{c}/campaign.toml", "--force"],
        ["identify", "{c}", "--report", "{c}"],
        ["identify", "{c}", "--json", "{c}/../{name}/runs.json"],
    ],
)
def test_a_campaign_is_never_written_into(words: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Results inside the campaign's folder are refused before any work, however they are spelt; nothing changes."""
    folder = leg_campaign(tmp_path / "campaign")
    before = {file: file.read_bytes() for file in folder.rglob("*") if file.is_file()}
    assert main([word.format(c=folder, name=folder.name) for word in words]) == 2
    assert "which is read" in capsys.readouterr().err
    assert {file: file.read_bytes() for file in folder.rglob("*") if file.is_file()} == before


@pytest.mark.parametrize("option", ["--out {c}/page.html", "--out page.html --figures {c}", "--out {c}/runs/p.html"])
def test_nor_into_a_campaign_that_is_not_read(
    option: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """A report of a machine is refused inside a folder of measurements, which is named; nothing changes."""
    folder = leg_campaign(tmp_path / "campaign", rows=30)
    before = sorted(tmp_path.rglob("*"))
    monkeypatch.chdir(tmp_path)
    assert main(["report", "reference", *option.format(c=folder).split()]) == 2
    said = capsys.readouterr().err
    assert "lies inside campaign, which holds campaign.toml" in said
    assert f"give a place outside of {folder}" in said
    assert sorted(tmp_path.rglob("*")) == before


def test_a_file_that_is_read_is_not_replaced_and_json_only_by_json(tmp_path: Path) -> None:
    """A law is not replaced by an answer, a text or another program's JSON not by --json; an earlier answer is."""
    law, text, answer = tmp_path / "leg.toml", tmp_path / "notes.txt", tmp_path / "a.json"
    foreign = tmp_path / "package.json"
    foreign.write_text(json.dumps({"name": "my-app", "format": "1"}))
    law.write_text("x")
    text.write_text("my notes")
    answer.write_text(json.dumps({"format": "hexathermal-diagnosis/1", "verdict": "none"}))
    with pytest.raises(ArgumentError, match="one of the files that are read"):
        protect(Namespace(law=law, json=str(law)))
    with pytest.raises(ArgumentError, match="no earlier answer"):
        protect(Namespace(law=law, json=str(text)))
    with pytest.raises(ArgumentError, match="no earlier answer"):
        protect(Namespace(law=law, json=str(foreign)))
    protect(Namespace(law=law, json=str(answer)))
    protect(Namespace(law=law, json="-"))


def test_two_results_have_two_names(tmp_path: Path) -> None:
    """A law and an answer of one name, however spelt, are refused: one would be lost; folders may be shared."""
    one = tmp_path / "one"
    with pytest.raises(ArgumentError, match=r"--extend and --json both name .*give each a name of its own"):
        protect(Namespace(extend=one, json=str(tmp_path / "x" / ".." / "one")))
    law = tmp_path / "leg.toml"
    with pytest.raises(ArgumentError, match="both name"):
        protect(Namespace(out=law, report=law))
    with pytest.raises(ArgumentError, match="both name"):
        protect(Namespace(report=one, extend=one))
    protect(Namespace(report=one, plots=one, json="-"))


OWN_NAMES = [
    "apply leg.toml --machine reference --out o --json o/hexapod.toml",
    "diagnose c --report o --extend o/diagnosis.json",
    "diagnose c --report o --json o/report.html",
    "diagnose c --extend o --json o/hexapod.toml",
    "identify c --report o --out o/sets.csv",
    "identify c --out o --json o/hexapod.origin.toml",
    "identify c --out o.toml --json o.origin.toml",
    "budget --machine reference --pose 0 0 0 0 0 0 --temps 22 --out o --json o/budget.csv",
    "check c --plots o --json o/noise.png",
    "check c --plots o --netcdf o/Noise.PNG",
    "compare c --plots o --json x/../o/run-01-channels.png",
    "demo --out o --json o/summary.json",
    "demo --json hexathermal-demo/day.csv",
    "validate leg.toml c --report o --json o/validation.json",
    "report reference --figures o --json o/drawing.csv",
    "simulate bench --out c --plots o --truth o/run-01.png",
]


@pytest.mark.parametrize("words", OWN_NAMES)
def test_no_result_takes_the_name_of_a_file_that_the_command_writes_itself(
    words: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """It is refused before any work, with both options, however it is spelt: one of the two would be lost."""
    monkeypatch.chdir(tmp_path)
    assert main(words.split()) == 2
    said = capsys.readouterr().err
    assert "writes itself; give it a name of its own" in said
    assert len(re.findall(r"--[a-z]+", said)) == 2
    assert not list(tmp_path.iterdir())


def test_other_names_in_a_folder_of_results_are_free(tmp_path: Path) -> None:
    """An answer beside the pictures, a law in the folder of a report: nothing is lost."""
    o = tmp_path / "o"
    protect(Namespace(command="check", plots=o, json=str(o / "check.json"), netcdf=o / "runs.nc"))
    protect(Namespace(command="diagnose", report=o, extend=o / "law.toml", json=str(o / "a.json")))
    protect(Namespace(command="demo", out=o, json=str(o / "deeper" / "summary.json")))
    with pytest.raises(ArgumentError, match="writes itself"):
        protect(Namespace(command="of somebody else", out=o, json=str(o / "a.json")))


@pytest.mark.long
@pytest.mark.parametrize(
    ("words", "option"),
    [
        ("check c --plots o", "plots"),
        ("identify c --sensors T01 --report o", "report"),
        ("validate leg.toml c --report o", "report"),
        ("apply leg.toml --machine reference --out o", "out"),
        ("demo --out o", "out"),
        ("budget --machine reference --pose 0 0 0 0 0 0 --temps 22 --map x=0:1:2 --out o", "out"),
        ("report reference --figures o", "figures"),
    ],
)
def test_all_names_that_a_command_writes_are_known(
    words: str, option: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Every file in its folder of results has a name that is refused to other results."""
    monkeypatch.chdir(tmp_path)
    if " c " in words or "leg.toml" in words:
        leg_campaign(tmp_path / "c", rows=200)
    if "leg.toml" in words:
        assert main(["identify", "c", "--sensors", "T01", "--out", "leg.toml", "--quiet"]) == 0
    assert main([*words.split(), "--quiet"]) == 0
    files = list(Path("o").iterdir())
    assert files
    for file in files:
        with pytest.raises(ArgumentError, match="writes itself"):
            protect(Namespace(command=words.split()[0], **{option: Path("o")}, json=str(tmp_path / file)))


@pytest.mark.parametrize(
    "words",
    [
        "identify leg --out notes.txt",
        "diagnose leg --extend notes.txt",
        "identify machine --out notes.toml",
        "diagnose machine --extend notes.toml",
        "apply leg.toml --machine reference --out notes.toml",
        "apply leg.toml --machine reference --out law.toml",
        "identify leg --out own/hexapod.toml",
    ],
)
def test_force_replaces_laws_only(
    words: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Notes, and a law of another kind, are kept with --force too; the message says what alone it replaces."""
    monkeypatch.chdir(tmp_path)
    for kind in ("leg", "hexapod"):
        folder = tmp_path / {"hexapod": "machine"}.get(kind, kind)
        folder.mkdir()
        (folder / "campaign.toml").write_text(f'kind = "{kind}"')
    for name in ("notes.txt", "notes.toml"):
        (tmp_path / name).write_text("my notes")
    (tmp_path / "law.toml").write_text('format = "hexathermal-leg/1"')
    write_hexapod(load_hexapod("reference"), tmp_path / "own")
    before = {file: file.read_bytes() for file in tmp_path.rglob("*") if file.is_file()}
    assert main([*words.split(), "--force"]) == 2
    said = capsys.readouterr().err
    assert re.search(r"is no (law|machine) .*--force replaces nothing else; give another name for --(out|extend)", said)
    assert {file: file.read_bytes() for file in tmp_path.rglob("*") if file.is_file()} == before


@pytest.mark.skipif(not Path("/proc/self").exists(), reason="there is no place here where nothing can be made")
@pytest.mark.parametrize(
    "words",
    [
        "report reference --out /proc/r.html",
        "report reference --figures /proc/r",
        "view --save /proc/v.html",
        "simulate bench --out /proc/x",
        "simulate machine --out /proc/x",
        "simulate bench --out c --truth /proc/t.json",
        "simulate bench --out c --plots /proc/p",
        "apply leg.toml --machine reference --out /proc/m",
        "apply leg.toml --machine reference --out notes.txt",
        "apply leg.toml --machine reference --out notes.txt/deep",
        "identify c --out /proc/leg.toml",
        "identify c --report /proc/r",
        "diagnose c --report /proc/r",
        "check c --netcdf /proc/c.nc",
        "demo --out /proc/d",
        "machines --json /proc/m.json",
    ],
)
def test_a_place_that_cannot_be_written_is_told_in_words_before_any_work(
    words: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Where nothing can be made, wrong usage: the place, why, and to give another; nothing is computed or left."""

    def work(*_arguments: object) -> None:
        raise AssertionError("work was begun")

    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("hexathermal.show.report.report_of", work)
    monkeypatch.setattr("hexathermal.show.commands.view._course", work)
    (tmp_path / "notes.txt").write_text("my notes")
    assert main(words.split()) == 2
    said = capsys.readouterr().err
    assert "/proc" in said or "notes.txt" in said
    assert re.search(r"give another (place|name)|names a hexapod.toml, or the folder", said)
    assert "Errno" not in said
    assert [file.name for file in tmp_path.iterdir()] == ["notes.txt"]
