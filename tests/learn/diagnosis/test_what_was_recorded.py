"""What some runs do not record and others do is told by its run; counts of cleaning say of what they are."""

from __future__ import annotations

from dataclasses import replace

from hexathermal.learn.cleaning_record import NOTED, ROW, VALUE, CleaningRecord, CleaningStep, cleaning_words
from hexathermal.learn.diagnosis.recorded import partly_recorded
from tests.learn.diagnosis.campaigns import viewed


def test_a_run_without_the_air_is_named() -> None:
    """One of the runs records no air: that run, what is missing and what to do; nothing where all or none does."""
    view, _answer = viewed("modal", 1, (), 1.0)
    mute = [replace(rows, signals=replace(rows.signals, air=None, index=None)) for rows in view.runs]
    assert partly_recorded(view.runs) == partly_recorded(mute) == []
    name, count = view.runs[1].run.name, len(view.runs)
    (said,) = partly_recorded([view.runs[0], mute[1], *view.runs[2:]])
    assert said.startswith(f"not recorded in {name} of {count} runs, but in others: the air temperature")
    assert f"take {name} out of campaign.toml" in said


def test_counts_of_values_are_not_taken_for_rows() -> None:
    """A dead channel loses its values, not the rows; of several channels their number."""

    def step(name: str, channel: str, action: str, count: int) -> CleaningStep:
        return CleaningStep(name, channel, action, count, "", 0.0)

    steps = (step("dead channel", "T03_degC", VALUE, 100), step("not settled", "row", ROW, 30),
             step("spike", "T01_degC", VALUE, 2), step("spike", "T02_degC", VALUE, 3),
             step("drift step", "row", NOTED, 4))  # fmt: skip
    (said,) = cleaning_words([CleaningRecord("run-01", 100, 70, 1500.0, 15.0, 0.0, steps)])
    assert said.startswith(
        "70 of 100 rows are usable; cleaning: dead channel 100 values of T03_degC, not settled 30, "
        "spike 5 values of 2 channels, drift step 4 ("
    )
