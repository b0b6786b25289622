"""Limits of a machine's causes in the answer and in the report of its JSON: the same."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest

from hexathermal.show.report import report_of, subject_of
from tests.diagnosed import diagnosed
from tests.show.machine_campaigns import WIDE, moved, other_leg, written


@pytest.mark.long
def test_the_report_has_the_limits_of_the_answer(tmp_path: Path) -> None:
    """From its JSON: the same best and worst place of each cause, and what is advised names the leg."""
    rng = np.random.default_rng(11)
    view, six = moved(rng, WIDE, 4, alike=False)
    campaign = written(tmp_path / "campaign", rng, view, six, other_leg(2, 1.2e-6), held=1)
    ran = diagnosed(campaign, tmp_path, "extended/hexapod.toml")
    folder = ran.files / "report"
    report = report_of(subject_of(str(folder)), None, lambda done, total, label: None)
    limits = next(one for one in report.sections if one.name == "limits")
    cells = re.findall("<t[dh] ?[^>]*>(.*?)</t[dh]>", str(limits.parts[1]).partition("<tbody>")[2])
    answer = [line.split() for line in ran.out.split("would be named from")[1].split("\n\n")[0].splitlines()[1:]]
    assert " ".join(cells).split() == [word for line in answer for word in line]
    assert json.loads((folder / "diagnosis.json").read_text())["advice"][0]["places"] == ["leg-coefficient of leg3"]
