"""A run never fitted that is unlike those the law was fitted on is told; sound ones are not."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from hexathermal.cli import main
from hexathermal.learn.campaign_files import load_campaign
from hexathermal.learn.diagnosis import diagnose
from hexathermal.learn.diagnosis.unlike_runs import FAR, unlike_words
from hexathermal.poses import FloatArray
from hexathermal.simulate.hidden.drawing import campaign_of
from hexathermal.simulate.hidden.writing import write_campaign
from tests.learn.diagnosis.campaigns import rewritten


@dataclass
class Left:
    """What a law leaves of a run."""

    run: str
    role: str
    after: FloatArray
    signals: dict[str, FloatArray]


def left(run: str, role: str, size: float, swing: float = 2.0) -> Left:
    """Residuals of a run of that standard deviation [m], about a zero of their own; it warms by `swing` [K]."""
    return Left(run, role, 3e-6 + size * np.tile([-1.0, 1.0], 30), {"dT": np.linspace(0.0, swing, 60)})


FITTED = [left("run-01", "identification", 1e-7), left("run-02", "identification", 2e-7)]


@pytest.mark.parametrize("over", [0.5, 0.9 * FAR])
def test_runs_as_good_as_the_fitted_ones_are_not_told(over: float) -> None:
    """Whatever their zeros are: they count from their own, and against the worst of the fitted ones."""
    assert unlike_words([*FITTED, left("run-03", "validation", over * 2e-7)]) == ()


def test_what_is_told_of_a_run_otherwise_is_not_told_twice() -> None:
    """A run with a step that was found needs no second word; another one beside it does."""
    runs = [*FITTED, left("run-03", "validation", 9e-7), left("run-04", "validation", 8e-7)]
    (words,) = unlike_words(runs, {"run-03"})
    assert words.startswith(
        "In run-04, never fitted, the law leaves up to 0.8 um (standard deviation), against 0.2 um at most"
    )
    assert "run-03" not in words
    assert unlike_words(runs, {"run-03", "run-04"}) == ()


@pytest.mark.parametrize(("swing", "beyond"), [(2.4, False), (4.0, True), (-4.0, True)])
def test_a_run_that_goes_farther_than_the_fitted_ones_may_be_beyond_the_law(swing: float, beyond: bool) -> None:
    """Then that is told as well, with both ranges: a law's own uncertainty grows with the warming."""
    (words,) = unlike_words([*FITTED, left("run-03", "validation", 9e-7, swing)])
    assert ("its first thermometer goes 4 K from its zero there, 2 K at most in those" in words) == beyond
    assert words.endswith("Measure such a run again, to fit the one and judge by the other.")
    both = unlike_words([*FITTED, left("run-03", "validation", 9e-7), left("run-04", "validation", 1e-7)])
    assert both[0].endswith("diagnose again: the others still judge.")


def test_without_runs_to_compare_nothing_is_told() -> None:
    """No run for validation, or none with residuals that differ from nothing."""
    assert unlike_words(FITTED) == ()
    assert unlike_words([]) == ()
    assert unlike_words([left("run-01", "identification", 0.0), left("run-02", "validation", 0.0)]) == ()


@pytest.mark.long
def test_a_fault_that_begins_after_the_fitted_runs_is_not_passed_over(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Nothing is hidden in the fitted runs; a thermometer that comes off in the first run never fitted is told of."""
    truth, answer = campaign_of("quiet", 6, causes=(), shared=True)
    folder = tmp_path / "campaign"
    write_campaign(folder, truth, answer)
    before = diagnose(load_campaign(folder), answer.base)
    assert before.unlike == ()
    campaign = load_campaign(folder)
    run, column = campaign.runs_of("validation")[0].name, f"{answer.base[0]}_degC"

    def wave(rows: list[dict[str, str]]) -> None:
        """The base sensor swings by 3 K about what it reads."""
        for k, row in enumerate(rows):
            row[column] = f"{float(row[column]) + 3.0 * np.sin(6.0 * k / len(rows)):.4f}"

    rewritten(folder / "runs" / f"{run}.csv", wave)
    told = tmp_path / "told.json"
    assert main(["diagnose", str(folder), "--sensors", ",".join(answer.base), "--json", str(told)]) == 0
    after = json.loads(told.read_text(encoding="utf-8"))
    (words,) = after["unlike"]
    assert words.startswith(f"In {run}, never fitted,")
    assert after["verdict"] == before.verdict
    assert after["sentence"].endswith(words)
    assert words in capsys.readouterr().out.replace("\n", " ")
