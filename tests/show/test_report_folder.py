"""The folder of a diagnosis's report: the next report replaces the earlier one, and touches nothing else."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from hexathermal.errors import ArgumentError
from hexathermal.learn.diagnosis.result import Diagnosis
from hexathermal.show.diagnosis_report import write_report
from hexathermal.show.diagnosis_tables import diagnosis_facts
from hexathermal.show.report_folder import files_of_earlier, refuse_foreign
from tests.show.drawn_diagnoses import drawn

pytestmark = pytest.mark.usefixtures("dots")


def _written(found: Diagnosis, folder: Path) -> set[str]:
    """Write a report; returns the names of its files."""
    return {file.name for file in write_report(found, diagnosis_facts(found), folder, lambda *_: None)}


def test_the_next_report_leaves_no_picture_of_the_earlier_one(tmp_path: Path) -> None:
    """Pictures that only the earlier report has are gone; what others put into the folder stays as it was."""
    folder = tmp_path / "report"
    first = _written(drawn(), folder)
    own = {"run-mine.png": b"mine", "notes.txt": b"words", "ext.toml": b"law"}
    for name, content in own.items():
        (folder / name).write_bytes(content)
    refuse_foreign(folder, False)
    second = _written(drawn(verdict="none", held=False), folder)
    assert first - second >= {"gain.png", "runs-fitted.png"}
    assert {file.name for file in folder.iterdir()} == second | set(own)
    assert all((folder / name).read_bytes() == content for name, content in own.items())
    assert files_of_earlier(folder) == second


@pytest.mark.parametrize("name", ["report.html", "diagnosis.json"])
def test_what_no_diagnosis_wrote_is_not_overwritten(name: str, tmp_path: Path) -> None:
    """A page or numbers made by hand are refused by name, also beside an earlier report; with force they are not."""
    _written(drawn(verdict="none", held=False), tmp_path)
    refuse_foreign(tmp_path, False)
    (tmp_path / name).write_text('{"my": "own words by hexathermal"}')
    with pytest.raises(ArgumentError, match=rf"holds {name}, which no diagnosis wrote; .*--force"):
        refuse_foreign(tmp_path, False)
    refuse_foreign(tmp_path, True)


def test_a_list_of_files_never_leads_out_of_the_folder(tmp_path: Path) -> None:
    """Names with folders in them, and folders, are left alone."""
    folder, outside = tmp_path / "report", tmp_path / "outside.png"
    _written(drawn(verdict="none", held=False), folder)
    outside.write_text("kept")
    (folder / "sub").mkdir()
    told = json.loads((folder / "diagnosis.json").read_text())
    (folder / "diagnosis.json").write_text(
        json.dumps(told | {"files": ["../outside.png", str(outside), "sub", 7, ".."]})
    )
    _written(drawn(verdict="none", held=False), folder)
    assert outside.read_text() == "kept"
    assert (folder / "sub").is_dir()
