"""What no number of the bench explains is said; a bench as it should be stays within what is foretold."""

from __future__ import annotations

import re
import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from hexathermal.compare.comparison import _worse, compare_campaign
from hexathermal.compare.scores import ChannelScore
from hexathermal.compare.unlike import Left, unlike
from hexathermal.errors import DataError
from hexathermal.learn.validation_scores import Figure
from hexathermal.simulate.bench.changed import Change, write_changed_campaign

SEED = 20140612

Spoil = Callable[[pd.DataFrame, str], None]


@pytest.fixture(scope="module")
def sound(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A campaign of a bench within its tolerances, other ones than the simulated."""
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
    assert found.unexplained == (), found.sentence
    if not found.differences:
        assert found.verdict == "none"
    ratio = np.array([one.rmse_after / one.foretold for one in found.scores])
    assert 0.3 < np.sqrt(np.mean(ratio**2)) < 1.5


def noisy(table: pd.DataFrame, _run: str) -> None:
    """A logger of much noise: 0.1 K in every reading."""
    rng = np.random.default_rng(len(table))
    for name in table.columns[table.columns.str.match(r"T\d\d_degC")]:
        table[name] += rng.normal(0.0, 0.1, len(table))


def coarse(table: pd.DataFrame, _run: str) -> None:
    """A logger of steps of half a kelvin."""
    for name in table.columns[table.columns.str.match(r"T\d\d_degC")]:
        table[name] = (table[name] * 2.0).round() / 2.0


@pytest.mark.long
@pytest.mark.parametrize("spoil", [noisy, coarse])
def test_a_poor_logger_is_no_difference(sound: Path, tmp_path: Path, spoil: Spoil) -> None:
    """Noise and resolution of single rows are foretold."""
    found = compare_campaign(spoiled(sound, tmp_path / "campaign", spoil))
    assert found.unexplained == (), found.sentence


def test_what_the_bench_as_it_is_explains_is_not_left_unexplained() -> None:
    """Nor is worse what is within what is foretold; in few runs more is asked than in all."""

    def left(*rows: tuple[float, float, float]) -> Left:
        return Left(*np.array([*rows, (0.0, 0.0, 1.0)]).T)

    def scored(name: str, before: float, after: float, foretold: float) -> ChannelScore:
        gain = 1.0 - after / before
        return ChannelScore(
            name, "body", 0.1, before, after, before, after, Figure(gain, gain - 0.1, gain + 0.1), foretold
        )

    scores = [scored("T01", 0.5, 5.0, 1.0), scored("T02", 5.0, 2.5, 1.0), scored("T03", 0.1, 0.3, 1.0)]
    judged = left(*((one.rmse_before, one.rmse_after, one.foretold) for one in scores))
    few = unlike(scores, ["T01", "T02", "T03"], left((0.5, 5.0, 1.0), (1.5, 1.5, 1.0), (0.1, 0.3, 1.0)), judged)
    assert few == ()
    every = unlike(scores, ["T01", "T02", "T03"], left((0.5, 5.0, 1.0), (2.5, 2.2, 1.0), (0.1, 0.3, 1.0)), judged)
    assert [one.channel for one in every] == ["T02"]
    assert [one.channel for one in _worse(scores)] == ["T01"]


@pytest.mark.long
@pytest.mark.parametrize(
    ("spoil", "channel"), [(scale, "drift"), (wander, "T09"), (hotter, "T05"), (reversed_beams, "drift")]
)
def test_what_no_number_explains_is_said(sound: Path, tmp_path: Path, spoil: Spoil, channel: str) -> None:
    """Faults that no bench has are told with the channel, whether or not numbers were named in their place."""
    found = compare_campaign(spoiled(sound, tmp_path / "campaign", spoil))
    assert channel in [one.channel for one in found.unexplained], found.sentence
    assert "down to no number of the bench" in found.sentence
    assert found.verdict == ("difference" if found.differences else "unexplained")
    assert any("hexathermal diagnose" in note for note in found.notes)
    assert any("other sign" in note for note in found.notes) == (spoil is reversed_beams)


@pytest.mark.long
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
