"""The page of the method says what the code does: its tables are the code's."""

from __future__ import annotations

import runpy
from pathlib import Path

from hexathermal.learn.diagnosis import deciding

ROOT = Path(__file__).resolve().parents[3]


def test_tables_of_the_page_are_those_of_the_code() -> None:
    """Catalogue and numbers in docs/diagnosis.md are current; if not, run tools/write_diagnosis_tables.py."""
    tool = runpy.run_path(str(ROOT / "tools" / "write_diagnosis_tables.py"), run_name="tables")
    text = (ROOT / "docs" / "diagnosis.md").read_text(encoding="utf-8")
    assert tool["written"](text) == text
    told = tool["numbers_by_module"]()
    assert {"deciding", "rivals", "causes.creep"} <= set(told)
    assert told["deciding"]["NEARLY"] == deciding.NEARLY
    assert text.count("| `") >= 17 + len(told)
