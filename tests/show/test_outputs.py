"""What is read is never written over: campaigns, laws, machines."""

from __future__ import annotations

import json
from argparse import Namespace
from pathlib import Path

import pytest

from hexathermal.cli import main
from hexathermal.errors import ArgumentError
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
    """A law is not replaced by an answer, a text not by --json; an earlier answer is."""
    law, text, answer = tmp_path / "leg.toml", tmp_path / "notes.txt", tmp_path / "a.json"
    law.write_text("x")
    text.write_text("my notes")
    answer.write_text(json.dumps({"verdict": "none"}))
    with pytest.raises(ArgumentError, match="one of the files that are read"):
        protect(Namespace(law=law, json=str(law)))
    with pytest.raises(ArgumentError, match="no earlier answer"):
        protect(Namespace(law=law, json=str(text)))
    protect(Namespace(law=law, json=str(answer)))
    protect(Namespace(law=law, json="-"))


def test_two_results_have_two_names(tmp_path: Path) -> None:
    """A law and an answer of one name, however spelt, are refused: one would be lost; folders may be shared."""
    one = tmp_path / "one"
    with pytest.raises(ArgumentError, match=r"--extend and --json both name .*give each a name of its own"):
        protect(Namespace(extend=one, json=str(tmp_path / "x" / ".." / "one")))
    with pytest.raises(ArgumentError, match="both name"):
        protect(Namespace(report=one, extend=one))
    protect(Namespace(report=one, plots=one, json="-"))
