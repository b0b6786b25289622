"""``hexathermal diagnose`` on a hexapod with nothing wrong."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest

import hexathermal as ht
from hexathermal.cli import main
from tests.show.machine_campaigns import WIDE, moved, written


def test_a_clean_machine_is_answered_so(
    tmp_path: Path, rng: np.random.Generator, capsys: pytest.CaptureFixture[str]
) -> None:
    """Nothing is named above so many um and urad; --extend then writes the machine as it was, and says so."""
    view, six = moved(rng, WIDE, 3, alike=False)
    folder = written(tmp_path / "clean", rng, view, six)
    assert main(["diagnose", str(folder), "--extend", str(tmp_path / "same"), "--json", str(tmp_path / "a.json")]) == 0
    shown = capsys.readouterr()
    far, turned = re.match(r"None above ([\d.]+) um / ([\d.]+) urad", shown.out).groups()  # type: ignore[union-attr]
    facts = json.loads((tmp_path / "a.json").read_text())
    limits = [one for one in facts["detection_limits"] if one["strength"] is not None]
    assert float(far) == pytest.approx(max(one["translation_um"] for one in limits), rel=0.06)
    assert float(turned) == pytest.approx(max(one["rotation_urad"] for one in limits), rel=0.06)
    assert facts["verdict"] == "none"
    assert "nothing joined the machine" in shown.err
    same = ht.load_hexapod(tmp_path / "same")
    assert same.platform_joints.tolist() == ht.load_hexapod(folder / "hexapod.toml").platform_joints.tolist()
    assert same.thermal is not None
    assert same.compliance is None
