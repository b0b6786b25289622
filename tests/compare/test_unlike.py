"""What no number of the bench explains is said; a bench as it should be stays within what is foretold."""

from __future__ import annotations

import re
import secrets
import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from hexathermal.compare.comparison import compare_campaign
from hexathermal.errors import DataError
from hexathermal.simulate.bench.changed import Change, write_changed_campaign

SEED = secrets.randbits(48)

Spoil = Callable[[pd.DataFrame, str], None]


@pytest.fixture(scope="module")
def sound(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A campaign of a bench within its tolerances, other ones than the simulated, from fresh entropy."""
    place = tmp_path_factory.mktemp("unlike") / "sound"
    write_changed_campaign(place, Change("", "", 1.0), SEED, duration=2.0 * 3600.0)
    return place


def spoiled(sound: Path, place: Path, spoil: Spoil) -> Path:
    """Return a copy with every table spoiled."""
    shutil.copytree(sound, place)
    for file in sorted((place / "runs").glob("*.csv")):
        table = pd.read_csv(file)
        spoil(table, file.stem)
        table.to_csv(file, index=False)
    return place


def scale(table: pd.DataFrame, _run: str) -> None:
    """The interferometer's scale is 100 ppm off."""
    for beam in ("beam1_mm", "beam2_mm", "beam3_mm"):
        table[beam] *= 1.0001


def wander(table: pd.DataFrame, _run: str) -> None:
    """One thermometer drifts by 2 K in an hour."""
    table["T09_degC"] += 2.0 * table["time_s"] / 3600.0


def hotter(table: pd.DataFrame, run: str) -> None:
    """In the run for validation alone every thermometer of the leg rises twice as far."""
    if run == "run-04":
        for name in table.columns[table.columns.str.match(r"T\d\d_degC")]:
            table[name] += table[name] - table[name][0]


def reversed_beams(table: pd.DataFrame, _run: str) -> None:
    """The drift has the other sign."""
    way = table["q_mm"] - table["q_mm"][0]
    for beam in ("beam1_mm", "beam2_mm", "beam3_mm"):
        table[beam] = way - 3.0 * (table[beam] - table[beam][0] - way)


def test_a_sound_bench_stays_within_what_is_foretold(sound: Path) -> None:
    """Of tolerances and noise drawn anew none makes a channel twice as bad as foretold; nor is it foretold idly."""
    found = compare_campaign(sound)
    assert found.unexplained == (), f"seed {SEED}: {found.sentence}"
    if not found.differences:
        assert found.verdict == "none"
    ratio = np.array([one.rmse_after / one.foretold for one in found.scores])
    assert 0.3 < np.sqrt(np.mean(ratio**2)) < 1.5, f"seed {SEED}"


@pytest.mark.parametrize(
    ("spoil", "channel"), [(scale, "drift"), (wander, "T09"), (hotter, "T05"), (reversed_beams, "drift")]
)
def test_what_no_number_explains_is_said(sound: Path, tmp_path: Path, spoil: Spoil, channel: str) -> None:
    """Faults that no bench has are told with the channel, whether or not numbers were named in their place."""
    found = compare_campaign(spoiled(sound, tmp_path / "campaign", spoil))
    assert channel in [one.channel for one in found.unexplained], f"seed {SEED}: {found.sentence}"
    assert "no number of the bench explains" in found.sentence.lower()
    assert found.verdict == ("difference" if found.differences else "unexplained")
    assert any("hexathermal diagnose" in note for note in found.notes)
    assert any("other sign" in note for note in found.notes) == (spoil is reversed_beams)


def test_a_thermocouple_without_a_value_is_not_compared(sound: Path, tmp_path: Path) -> None:
    """It has no row and no limit, and a note says why."""

    def silent(table: pd.DataFrame, _run: str) -> None:
        table["T05_degC"] = np.nan

    found = compare_campaign(spoiled(sound, tmp_path / "campaign", silent))
    assert "T05" not in found.sensors
    assert not [one for one in found.parameters if one.target == "T05"]
    assert any(note.startswith("T05: not compared") for note in found.notes)
    assert not [note for note in found.notes if "T05 lacks" in note]


@pytest.mark.filterwarnings("ignore::hexathermal.learn.campaign_clocks.ClockWarning")
@pytest.mark.parametrize(
    ("factor", "words"),
    [(1000.0, "is time_s in milliseconds?"), (1 / 60.0, "is time_s in minutes?"), (1 / 3600.0, "is time_s in hours?")],
)
def test_times_of_another_unit_are_asked_for(sound: Path, tmp_path: Path, factor: float, words: str) -> None:
    """Runs that cannot be compared, since their rows come too slowly or last too short, name the likely unit."""

    def other(table: pd.DataFrame, _run: str) -> None:
        table["time_s"] *= factor

    with pytest.raises(DataError, match=re.escape(words)):
        compare_campaign(spoiled(sound, tmp_path / "campaign", other))
