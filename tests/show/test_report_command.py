"""``hexathermal report``: it writes whole pages or nothing, never over what is read, and says what is wrong."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

import pytest

from hexathermal.cli import main
from hexathermal.show.report_live import MISSING
from tests.show.reports import budget_json

Said = pytest.CaptureFixture[str]


@pytest.fixture
def quick(plotly: None, monkeypatch: pytest.MonkeyPatch) -> None:
    """Leave plotly's program out of the page: what is tested here does not need it."""
    monkeypatch.setattr("hexathermal.show.report_page.program", lambda: "")


@pytest.mark.usefixtures("quick")
def test_the_command_writes_and_never_overwrites(tmp_path: Path, capsys: Said) -> None:
    """A page and its figures once; again only by --force; the answer as JSON names both."""
    file, out, figures = budget_json(tmp_path), tmp_path / "page.html", tmp_path / "figures"
    words = ["report", str(file), "--out", str(out)]
    capsys.readouterr()
    assert main([*words, "--figures", str(figures), "--json", "-"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["format"] == "hexathermal-report/1"
    assert told["kind"] == "budget"
    assert told["written"][0] == str(out)
    assert sorted(Path(name).name for name in told["written"][1:]) == sorted(one.name for one in figures.iterdir())
    out.write_text("kept")
    assert main(words) == 2
    assert "exists already" in capsys.readouterr().err
    assert main(["report", str(file), "--out", str(tmp_path / "b.html"), "--figures", str(figures)]) == 2
    assert "contributions.png" in capsys.readouterr().err
    assert out.read_text() == "kept"
    assert main([*words, "--force"]) == 0
    assert out.read_text(encoding="utf-8").startswith("<!DOCTYPE html>")


@pytest.mark.usefixtures("plotly")
def test_nothing_is_written_into_what_is_read(
    leg: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Said
) -> None:
    """Neither by name, nor by the name that nobody gave inside the folder of the campaign."""
    before = sorted(leg.iterdir())
    monkeypatch.chdir(leg)
    assert main(["report", "."]) == 2
    assert "lies inside leg, which is read" in capsys.readouterr().err
    assert main(["report", str(leg), "--out", str(tmp_path / "x.html"), "--figures", str(leg / "figures")]) == 2
    assert sorted(leg.iterdir()) == before


@pytest.mark.usefixtures("plotly")
@pytest.mark.parametrize(
    ("words", "code", "said"),
    [
        (["{tmp}"], 2, "nothing that a report can be of"),
        (["refrence"], 2, "did you mean 'reference'"),
        (["{tmp}/odd.json"], 3, "the format is 'odd'"),
        (["{tmp}/broken.json"], 3, "no JSON"),
        (["{tmp}/empty.json"], 3, "no budget that can be read: 'bias_uncorrected' is missing"),
        (["{tmp}/odd.txt"], 2, "cannot tell what"),
        (["reference", "--out", "{tmp}/page.pdf"], 2, "the name of a page ends in .html"),
        (["reference", "--out", "{tmp}/none/page.html"], 2, "there is no folder"),
        (["reference", "--figures", "{tmp}/odd.txt"], 2, "it is no folder"),
        (["reference", "--law", "leg.toml"], 2, "held against a measured campaign"),
    ],
)
def test_wrong_input_is_told(words: list[str], code: int, said: str, tmp_path: Path, capsys: Said) -> None:
    """Each says what is wrong, ends with the documented code, shows no traceback and writes nothing."""
    texts = {"odd.json": '{"format": "odd"}', "broken.json": "{", "odd.txt": "",
             "empty.json": '{"format": "hexathermal-budget/1"}'}  # fmt: skip
    for name, text in texts.items():
        (tmp_path / name).write_text(text)
    given = [word.format(tmp=tmp_path) for word in words]
    if "--out" not in given:
        given += ["--out", str(tmp_path / "page.html")]
    assert main(["report", *given]) == code
    error = capsys.readouterr().err
    assert said in error
    assert "Traceback" not in error
    assert sorted(one.name for one in tmp_path.iterdir()) == sorted(texts)


def test_without_plotly_the_extra_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Said) -> None:
    """Nothing is worked out before; the message says what to install."""
    monkeypatch.setitem(sys.modules, "plotly.offline", None)
    assert main(["report", "reference", "--out", str(tmp_path / "page.html")]) == 2
    assert "pip install 'hexathermal[report]'" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []
    assert MISSING.startswith("a report needs plotly")


@pytest.mark.long
@pytest.mark.usefixtures("quick")
@pytest.mark.parametrize("at", ["report_page.figure_html", "report_files.write_figures", "report_files.draw"])
def test_an_interrupt_leaves_nothing(at: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Said) -> None:
    """Ctrl-C while the page is made, between page and figures, and while they are written: neither page nor folder."""
    file, calls = budget_json(tmp_path), []

    def stop(*_named: Any) -> None:
        calls.append(1)
        raise KeyboardInterrupt

    monkeypatch.setattr(f"hexathermal.show.{at}", stop)
    out = tmp_path / "page.html"
    assert main(["report", str(file), "--out", str(out), "--figures", str(tmp_path / "figures")]) == 130
    assert calls
    assert "nothing half-written" in capsys.readouterr().err
    assert [one.name for one in tmp_path.iterdir()] == ["budget.json"]
