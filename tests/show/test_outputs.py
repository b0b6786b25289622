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
