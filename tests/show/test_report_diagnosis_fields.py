"""A diagnosis's JSON that is none: the report says which field is wrong, never what went wrong inside."""

from __future__ import annotations

import copy
import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from hexathermal.errors import FileFormatError
from hexathermal.show.diagnosis_tables import diagnosis_facts
from hexathermal.show.diagnosis_words import UNNAMED, VERDICTS
from hexathermal.show.report_diagnosis import diagnosis_report
from hexathermal.show.report_diagnosis_fields import wrong_fields
from tests.show.drawn_diagnoses import drawn

INSIDE = re.compile("object|attribute|NoneType|indices|argument|subscriptable|operand|iterable|callable|instance")


def told() -> dict[str, Any]:
    """Return the JSON of a diagnosis of a leg."""
    facts: dict[str, Any] = json.loads(json.dumps(diagnosis_facts(drawn())))
    return facts


def places(value: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """Give the place of every field and item of plain data."""
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, item in items:
        yield (*path, key)
        yield from places(item, (*path, key))


def changed(facts: dict[str, Any], place: tuple[Any, ...], new: Any) -> dict[str, Any]:
    """Return plain data with one field exchanged."""
    facts = copy.deepcopy(facts)
    inner: Any = facts
    for key in place[:-1]:
        inner = inner[key]
    inner[place[-1]] = new
    return facts


def test_a_sound_diagnosis_has_no_wrong_field() -> None:
    """What `diagnose` writes is read, whatever it found."""
    assert wrong_fields(told()) == ()


def test_runs_that_are_unlike_are_told_where_causes_are_named(tmp_path: Path) -> None:
    """As a note; where nothing is named the first sentence has it; older files have none."""
    words = "In run-09, never fitted, the law leaves up to 1 um."
    with_causes = told() | {"unlike": [words]}
    assert with_causes["effects"]
    assert words.rstrip(".") in diagnosis_report(with_causes, tmp_path).notes
    nothing = with_causes | {"effects": [], "verdict": "none", "sentence": f"No effect stands. {words}"}
    report = diagnosis_report(nothing, tmp_path)
    assert report.notes.count(words.rstrip(".")) == 0
    assert words in report.finding
    older = {name: value for name, value in told().items() if name != "unlike"}
    assert wrong_fields(older) == ()
    diagnosis_report(older, tmp_path)


@pytest.mark.parametrize(("evidence", "verdict"), [(50.0, UNNAMED), (0.0, VERDICTS["none"])])
def test_where_candidates_stand_and_none_is_named_the_report_says_so(
    tmp_path: Path, evidence: float, verdict: str
) -> None:
    """As `diagnose` itself: nothing can be named, which is not that nothing is there."""
    facts = told() | {"effects": [], "verdict": "none", "cause": None, "target": None, "follows": None}
    for candidate in facts["candidates"]:
        candidate["evidence"] = evidence
    report = diagnosis_report(facts, tmp_path)
    assert report.pairs[0][1] == verdict


@pytest.mark.parametrize(
    ("place", "new", "wanted"),
    [
        (("gain",), "x", "'gain' is 'x', expected an object"),
        (("noise_um",), [1, 2], "'noise_um' is [1, 2], expected an object"),
        (("probability",), "0.9", "'probability' is '0.9', expected a number"),
        (("candidates", 1, "evidence"), None, "'candidates[1].evidence' is null, expected a number"),
        (("effects", 0, "parameters", "step_um", "value"), "big", "'effects[0].parameters.step_um.value' is 'big'"),
        (("verdict",), "maybe", "'verdict' is 'maybe', expected 'effect' or"),
        (("threshold",), True, "'threshold' is True, expected a number"),
    ],
)
def test_a_wrong_field_is_named(tmp_path: Path, place: tuple[Any, ...], new: Any, wanted: str) -> None:
    """Its path in the file, its value and what is expected."""
    with pytest.raises(FileFormatError, match=re.escape(wanted)) as error:
        diagnosis_report(changed(told(), place, new), tmp_path)
    assert error.value.path == str(tmp_path / "diagnosis.json")


@pytest.mark.parametrize("new", ["x", None, [1], {"a": 1}, -3], ids=["text", "null", "list", "object", "number"])
def test_no_message_tells_of_the_inside(tmp_path: Path, new: Any) -> None:
    """Any field exchanged for anything: a report, or an error in words of the file."""
    facts = told()
    for place in places(facts):
        try:
            diagnosis_report(changed(facts, place, new), tmp_path)
        except FileFormatError as error:
            said = str(error).replace("expected an object", "")
            assert not INSIDE.search(said), (place, said)


def test_fields_of_a_machine_are_its_own() -> None:
    """A machine's diagnosis has limits by place, disturbances by axis, and no sensors."""
    axes = {f"{axis}_{'urad' if axis.startswith('r') else 'um'}": 0.1 for axis in ("x", "y", "z", "rx", "ry", "rz")}
    facts: dict[str, Any] = {
        "kind": "hexapod", "title": "", "verdict": "none", "cause": None, "target": None, "probability": 0.7,
        "sentence": "None.", "effects": [], "candidates": [], "follows": None, "threshold": 0.5, "notes": [],
        "gain": None, "next_experiment": None,
        "detection_limits": [{"cause": "payload", "target": None, "strength": None, "translation_um": None,
                                  "rotation_urad": None}],
        "disturbances": dict.fromkeys(("noise", "campaign_frame", "frame_of_each_run", "slow_frame"), axes),
    }  # fmt: skip
    assert wrong_fields(facts) == ()
    facts["disturbances"]["noise"] = axes | {"x_um": "a"}
    assert wrong_fields(facts) == ("'disturbances.noise.x_um' is 'a', expected a number",)
