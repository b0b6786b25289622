"""Hexapod campaigns with hidden effects, drawn and written: as strong as they say, sound to read, the answer apart."""

from __future__ import annotations

import json
from collections import Counter
from pathlib import Path

import numpy as np
import pytest

from hexathermal.errors import ArgumentError, UnknownNameError
from hexathermal.learn.campaign_files import load_campaign
from hexathermal.learn.hexapod_data import hexapod_rows
from hexathermal.machine.files import read_hexapod
from hexathermal.poses import coordinates_from_pose
from hexathermal.simulate.hidden.__main__ import main
from hexathermal.simulate.hidden.machines import halls
from hexathermal.simulate.hidden.machines.campaign import FEIGNED
from hexathermal.simulate.hidden.machines.drawing import KINDS, draw_machine_campaign, machine_campaign_of
from hexathermal.simulate.hidden.machines.effects import CATALOGUE, OUTSIDE, found
from hexathermal.simulate.hidden.machines.motion import LEAST_FREE, freedom
from hexathermal.simulate.hidden.machines.physics import effect, mended_heats, read_heats, seen, stood
from hexathermal.simulate.hidden.machines.strength import unframed, visible, whole
from hexathermal.simulate.hidden.machines.writing import write_machine_campaign

SOON = 30
"""Draws of causes alone that are looked at."""


@pytest.mark.long
@pytest.mark.parametrize("name", list(found()))
def test_a_wanted_strength_is_reached(name: str, seed: int) -> None:
    """Each effect is as strong as wanted, within 3 %, against the white noise of the six coordinates."""
    truth, answer = draw_machine_campaign(np.random.default_rng([seed, 1]), causes=[name], strength=0.3)
    rows = truth.rows("identification")
    assert answer.whole[0] == pytest.approx(0.3, rel=0.03)
    assert np.sqrt(np.mean((effect(truth)[rows] / truth.levels) ** 2)) == pytest.approx(answer.whole[0])
    assert 0.0 < answer.visible[0] < 1.001 * answer.whole[0]


def test_visible_strength_is_what_frames_leave(seed: int) -> None:
    """A motion of the frame, constant in each run, is as strong as it is, and leaves nothing visible."""
    truth, _ = draw_machine_campaign(np.random.default_rng([seed, 2]), causes=())
    generator = np.random.default_rng([seed, 3])
    motions = [np.tile(2.0 * truth.levels * generator.standard_normal(6), (run.time.size, 1)) for run in truth.runs]
    moved = truth.changed(
        runs=tuple(run.changed(moved=motion) for run, motion in zip(truth.runs, motions, strict=True))
    )
    assert whole(truth) < 1e-4
    assert whole(moved) > 0.3
    assert visible(moved) < 1e-3 * whole(moved)


def test_a_campaign_reads_back(seed: int, tmp_path: Path) -> None:
    """Rows, temperatures and poses are those of the truth, to what is written of them; nothing tells of the answer."""
    truth, answer = draw_machine_campaign(np.random.default_rng([seed, 4]), causes=["swapped-legs"], strength=0.5)
    file = write_machine_campaign(tmp_path / "one", truth, answer)
    campaign = load_campaign(tmp_path / "one")
    assert file == tmp_path / "one.answer.json"
    assert [(run.name, run.role) for run in campaign.runs] == [(run.name, run.role) for run in truth.runs]
    for role in ("identification", "validation"):
        rows = hexapod_rows(campaign, role)
        of = truth.rows(role)
        read = read_heats(truth)
        zero = [heat if truth.zero == "run" else read[0] for heat in read]
        dT = np.concatenate([one.legs - first.legs[0] for one, first in zip(read, zero, strict=True)])[of]
        assert np.abs(rows.dT - dT).max() < 2e-3
        assert np.abs(rows.q - truth.all("q")[of]).max() < 1e-9
        told = coordinates_from_pose(rows.commanded, hexapod=rows.hexapod) * np.repeat([1e-3, np.pi / 180.0], 3)
        assert np.abs(told - truth.all("commanded")[of]).max() < 1e-10
    texts = " ".join(path.read_text(encoding="utf-8") for path in (tmp_path / "one").rglob("*") if path.is_file())
    assert not any(word in texts for word in ("swapped", "hidden", "answer", str(answer.seed)))
    assert read_hexapod(tmp_path / "one" / "hexapod.toml") == truth.hexapod
    assert json.loads(file.read_text(encoding="utf-8"))["targets"] == list(answer.targets)


def test_noise_is_as_stated(seed: int) -> None:
    """What the true machine, its frames and its thermometers' readings leave of the measured poses is white noise."""
    truth, answer = draw_machine_campaign(np.random.default_rng([seed, 5]), causes=["leg-backlash"], strength=1.0)
    known = seen(seen(stood(truth, mended_heats(truth)), truth.all("moved")),
                 truth.all("frame"))  # fmt: skip
    true = stood(truth, mended_heats(truth))
    assert np.abs(known - true).max() < 1e-3
    level = truth.all("noise").std(axis=0) / answer.levels
    assert ((level > 0.9) & (level < 1.1)).all()  # 900 rows: 0.024 a standard deviation


@pytest.mark.parametrize("name", CATALOGUE)
def test_knowing_the_effect_gains_all_but_the_noise(name: str, seed: int) -> None:
    """With frames of runs put aside, the true machine leaves the noise, the machine as filed no less."""
    _truth, answer = draw_machine_campaign(np.random.default_rng([seed, 6]), causes=[name], strength=3.0)
    judged = answer.oracle
    for kind in ("translation", "rotation"):
        known, noise = getattr(judged.known_unframed, kind), getattr(judged.noise, kind)
        filed = getattr(judged.filed_unframed, kind)
        assert 0.9 * noise < known < 1.5 * noise  # a frame that creeps stays, and 12 of 1800 numbers are fitted
        assert known < 1.05 * filed


def test_frames_are_put_aside_exactly(seed: int) -> None:
    """What is left of any differences has no motion of a run in it: to put them aside again changes nothing."""
    truth, _ = draw_machine_campaign(np.random.default_rng([seed, 7]), causes=())
    values = truth.levels * np.random.default_rng([seed, 8]).standard_normal((900, 6))
    left = unframed(truth, values)
    assert np.abs(unframed(truth, left) - left).max() < 1e-12


def test_the_seed_makes_the_campaign_again(seed: int) -> None:
    """The seed in the answer, with the same wishes, gives the same poses to the last bit."""
    truth, answer = draw_machine_campaign(np.random.default_rng([seed, 9]), causes=["joint-offset"], strength=0.4)
    again, same = machine_campaign_of(answer.seed, causes=["joint-offset"], strength=0.4)
    assert same == answer
    assert np.array_equal(effect(again), effect(truth))


@pytest.mark.long
def test_draws_hide_what_the_kinds_say(seed: int) -> None:
    """None, one, two, a leg's and a foreign effect all come; machines, halls, zeros and roles differ."""
    generator = np.random.default_rng([seed, 10])
    drawn = [draw_machine_campaign(generator) for _k in range(SOON)]
    kinds: Counter[str] = Counter()
    for _truth, answer in drawn:
        first = answer.causes[0] if answer.causes else ""
        kinds[
            "none" if not first else "outside" if first.startswith(OUTSIDE) else "two" if len(answer.causes) == 2
            else "one" if first in CATALOGUE else "leg"
        ] += 1  # fmt: skip
        assert all(size > 0.0 for size in answer.whole)
        assert answer.feigned < 1.02 * FEIGNED
    assert set(kinds) <= set(KINDS)
    assert len(kinds) >= 3
    assert kinds["one"] > kinds["leg"]
    assert {answer.hall for _truth, answer in drawn} == set(halls.found())
    assert len({answer.machine for _truth, answer in drawn}) >= 3
    assert {truth.zero for truth, _answer in drawn} == {"run", "campaign"}
    assert all(sum(run.role == "validation" for run in truth.runs) == 2 for truth, _answer in drawn)
    assert len({tuple(run.role for run in truth.runs) for truth, _answer in drawn}) > 3


@pytest.mark.long
def test_no_pose_is_near_a_singular_posture() -> None:
    """A machine that can reach a posture in which its legs hardly hold it is not sent there; one of these 24 can."""
    generator = np.random.default_rng([2618408741, 10])
    for _k in range(24):
        truth, _answer = draw_machine_campaign(generator)
        assert (freedom(truth.hexapod, truth.all("commanded")) >= LEAST_FREE - 1e-9).all()


def test_refusals_say_what_there_is(seed: int) -> None:
    """Unknown effects, halls, machines and measures, and strengths that are none, are refused by name."""
    generator = np.random.default_rng([seed, 11])
    with pytest.raises(UnknownNameError, match="leg-backlash"):
        draw_machine_campaign(generator, causes=["backlash"])
    with pytest.raises(UnknownNameError, match="machine hall"):
        draw_machine_campaign(generator, hall="cellar")
    with pytest.raises(UnknownNameError, match="rubin-m2"):
        draw_machine_campaign(generator, machine="delta")
    with pytest.raises(ArgumentError, match="'whole' or 'visible'"):
        draw_machine_campaign(generator, measure="seen")
    with pytest.raises(ArgumentError, match="above 0"):
        draw_machine_campaign(generator, strength=-1.0)


def test_the_command_writes_machines(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """`--machines` writes campaigns with answers beside; what stands there is not overwritten, errors are told."""
    words = [str(tmp_path / "all"), "--machines", "--cause", "leg-coefficient", "--strength", "0.5", "--seed", "3"]
    assert main(words) == 0
    answer = json.loads((tmp_path / "all" / "machine-001.answer.json").read_text(encoding="utf-8"))
    assert answer["causes"] == ["leg-coefficient"]
    assert load_campaign(tmp_path / "all" / "machine-001").kind == "hexapod"
    assert main(words) == 1
    assert "--force" in capsys.readouterr().err
    assert main([*words, "--force", "--cause", "backlash"]) == 1
    assert "no effect on a machine is called 'backlash'" in capsys.readouterr().err
