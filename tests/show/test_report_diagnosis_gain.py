"""The page that ``report`` makes of a diagnosis says what a gain is worth, as the diagnosis's own page does."""

from __future__ import annotations

import html
import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from hexathermal.learn.validation_scores import Figure
from hexathermal.show.diagnosis_gain import gain_words
from hexathermal.show.diagnosis_tables import diagnosis_facts
from hexathermal.show.report_diagnosis import diagnosis_report
from hexathermal.show.report_page import Report
from tests.show.drawn_diagnoses import drawn

MACHINE = {
    "translation_rmse_before_um": 2.0, "translation_rmse_after_um": 1.0, "translation_reduction": 0.5,
    "translation_reduction_95": [0.3, 0.6], "rotation_rmse_before_urad": 2.0, "rotation_rmse_after_urad": 1.9,
    "rotation_reduction": 0.05, "rotation_reduction_95": [-0.2, 0.3],
}  # fmt: skip


def read(facts: dict[str, Any]) -> Report:
    """Return the report of a diagnosis's JSON."""
    return diagnosis_report(json.loads(json.dumps(facts)), Path("nowhere"))


def said(report: Report) -> str:
    """Return what the section of the gain says in words and tables."""
    section = next(one for one in report.sections if one.name == "gain")
    text = " ".join(part for part in section.parts if isinstance(part, str))
    return html.unescape(text).replace("\N{NO-BREAK SPACE}", " ")


@pytest.mark.parametrize("ends", [(-0.35, 0.53), (0.1, 0.3), (-0.4, -0.1)])
def test_a_gain_has_its_interval_and_what_it_proves(ends: tuple[float, float]) -> None:
    """The key figure and the section say interval and proof in the words of the diagnosis's own page; the table too."""
    found = drawn()
    assert found.gain is not None
    value = sum(ends) / 2
    total = replace(found.gain.total, rmse_gain=Figure(value, *ends))
    found = replace(found, gain=replace(found.gain, total=total))
    worth = gain_words(found).partition("um (")[2].partition(")")[0]
    assert "95 %: " in worth
    report = read(diagnosis_facts(found))
    beside = next(pair[2] for pair in report.pairs if pair[0].startswith("RMSE"))
    assert beside == f"before → after: {worth}"
    assert f"All runs never fitted together: RMSE {worth}." in said(report)
    assert "less by (95 %)" in said(report)
    assert f" % ({round(100 * ends[0])} to {round(100 * ends[1])})" in said(report)


def test_a_machine_says_both_of_its_measures() -> None:
    """Translation is proven, rotation is not; runs have intervals of their own."""
    gain = MACHINE | {"runs": {"run-04": MACHINE}}
    axes = {f"{axis}_{unit}": 0.0 for unit, axes in (("um", "xyz"), ("urad", ("rx", "ry", "rz"))) for axis in axes}
    quiet = dict.fromkeys(("noise", "campaign_frame", "frame_of_each_run", "slow_frame"), axes)
    whole = {"kind": "hexapod", "gain": gain, "detection_limits": [], "disturbances": quiet,
             "next_experiment": None}  # fmt: skip
    words = said(read(diagnosis_facts(drawn()) | whole))
    assert "translation RMSE 50 % less, 95 %: 30 to 60 %; proven." in words
    assert "Rotation RMSE 5.0 % less, 95 %: -20 to 30 %; not proven: the interval holds 0." in words
    assert words.count("50 % (30 to 60)") == 2


@pytest.mark.parametrize("ends", [None, [None, None], []])
def test_where_no_interval_is_told_none_is_made_up(ends: list[None] | None) -> None:
    """A gain without an interval is not called proven."""
    facts = diagnosis_facts(drawn())
    facts["gain"] = {**facts["gain"], "rmse_gain_95": ends}
    report = read(facts)
    assert "; proven" not in said(report)
    assert ("not proven: it has no interval" in said(report)) == (ends == [None, None])
