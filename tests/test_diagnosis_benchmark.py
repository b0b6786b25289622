"""The benchmark of the diagnosis: judges as it says, goes on where it stopped, and switches really switch."""

from __future__ import annotations

import json
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parents[1]))

from benchmarks import diagnosis, hidden_rates
from benchmarks.ablation import SWITCHES, without
from benchmarks.hidden_effects import AXES, BENCHES, CLEAN, HELD_OUT, LATER, ONE, OUTSIDE, PARTS, TWO, Outcome, plan
from benchmarks.hidden_timing import finer, longer
from hexathermal.simulate.hidden import benches
from hexathermal.simulate.hidden.drawing import campaign_of
from tests.learn.diagnosis.campaigns import viewed

CREEP = Outcome("quiet", 1, ["creep"], [1.0], "effect", ["creep"], [], 0.99, 0.4, 0.3, 0.4, 0.28, 0.27, 5.0, 1000, 6.0)
CLEARED = replace(CREEP, causes=[], strengths=[], verdict="none", names=[], after=0.4, oracle_after=0.4)


def test_all_benches_take_turns() -> None:
    """A plan holds every bench of the generator, equally often, and repeats for its seed."""
    assert {*BENCHES, HELD_OUT, LATER, PARTS, AXES} == set(benches.found())
    draws = plan(70, 7)
    assert draws == plan(70, 7)
    assert draws[:20] == plan(20, 7)
    assert {name: [bench for bench, _ in draws].count(name) for name in BENCHES} == dict.fromkeys(BENCHES, 10)
    assert len({seed for _, seed in draws}) == 70


def test_outcomes_are_judged_as_they_are() -> None:
    """Right, wrong, equivalent, pair, a name too many: each is told from the others."""
    assert (CREEP.kind, CREEP.right, CREEP.wrong, CREEP.pair, CREEP.extra) == (ONE, True, False, True, False)
    other = replace(CREEP, names=["backlash"])
    assert (other.right, other.right_or_equivalent, other.wrong, other.extra) == (False, False, True, True)
    stated = replace(other, equivalent=["creep"])
    assert (stated.right, stated.right_or_equivalent, stated.wrong) == (False, True, False)
    more = replace(CREEP, names=["creep", "zero-jump"])
    assert (more.right, more.wrong, more.pair, more.extra) == (True, False, False, True)
    two = replace(CREEP, causes=["backlash", "creep"], strengths=[1.0, 0.5])
    assert (two.kind, two.right, two.pair, two.strength) == (TWO, True, False, 0.5)
    assert replace(two, names=["creep", "backlash"]).pair
    stranger = replace(CREEP, causes=["outside: kink"])
    assert (stranger.kind, stranger.right, stranger.wrong) == (OUTSIDE, False, True)
    assert replace(stranger, verdict="unexplained", names=[]).right
    assert (CLEARED.kind, CLEARED.right, replace(CLEARED, verdict="unexplained").right) == (CLEAN, True, False)


def test_gain_is_held_against_the_oracle() -> None:
    """A quarter of 0.4 um gained where the truth gains 0.3 of it is 0.83 of the oracle's; clean draws do not count."""
    assert hidden_rates.gain_ratio([CREEP, CLEARED]) == pytest.approx(0.25 / 0.3)
    assert not hidden_rates.worse(CREEP.gain)
    assert hidden_rates.worse(replace(CREEP, after=0.41).gain)
    assert CREEP.true_gain is None
    exact = replace(CREEP, true_before=0.2, true_after=0.05, oracle_true_before=0.2, oracle_true_after=0.0)
    assert hidden_rates.true_gain_ratio([exact, CLEARED]) == pytest.approx(0.75)
    assert hidden_rates.what_it_gains([exact, CLEARED]).splitlines()[-1].startswith("| all | 2 | 0.83 | 0.00 |")


def test_calibration_is_the_distance_to_the_rate() -> None:
    """Three of four right at 0.99 is an error of 0.24; all right at 1.0 is none."""
    draws = [CREEP] * 3 + [replace(CREEP, names=["backlash"])]
    assert hidden_rates.calibration_error(draws) == pytest.approx(0.24)
    assert hidden_rates.calibration_error([replace(CREEP, probability=1.0)] * 5) == 0.0


def test_the_page_tells_failures_with_their_seed() -> None:
    """A wrong name, an alarm and an error stand in the page with bench and seed; a right name does not."""
    wrong = replace(CREEP, seed=111, names=["backlash"])
    alarm = replace(CLEARED, seed=222, verdict="effect", names=["zero-drift"])
    broken = replace(CREEP, seed=333, verdict="failed", names=[], failed="ArgumentError: no")
    text = diagnosis.page([CREEP, wrong, alarm, broken], 5, "", ())
    told = text.split("## Draws that went wrong")[1]
    assert all(f"quiet {seed}" in told for seed in (111, 222, 333))
    assert "quiet 1:" not in told
    assert "nan" not in text


def test_an_ablation_has_intervals_and_says_how_to_repeat_it() -> None:
    """Rates of few draws stand with what else they may be; the command on the page makes the table again."""
    wrong = replace(CREEP, seed=2, names=["backlash"])
    draws = [(one.bench, one.seed) for one in (CREEP, wrong)]
    found = {(name, *draw): one for name in SWITCHES for draw, one in zip(draws, (CREEP, wrong), strict=True)}
    table = diagnosis.ablated(found, 2, draws)
    assert table.count("| 2 | 0.50 (0.03 to 0.97) |") == len(SWITCHES)
    text = diagnosis.page([CREEP, wrong], 5, table, (), 2)
    assert "--seed 5 --bench quiet --ablation 2 --page" in text
    assert "--ablation" not in diagnosis.page([CREEP, wrong], 5, "", ())


def test_a_draw_is_told_in_words() -> None:
    """The ranking is names and evidence, no list of Python; a verdict without a name leaves no gap."""
    ranked = replace(CREEP, top=[["creep", 57.84], ["zero-jump", 23.6]])
    assert ranked.told().endswith("; ranking: creep 57.8, zero-jump 23.6")
    nameless = replace(ranked, verdict="unexplained", names=[], probability=0.976)
    assert "said unexplained (p 0.976); ranking: creep 57.8" in nameless.told()
    assert replace(nameless, top=[]).told().endswith("; ranking: empty")


def test_records_go_on_where_they_stopped(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Draws on record are not diagnosed again, a line cut off is, and another seed is refused."""
    file, page = tmp_path / "records.jsonl", tmp_path / "page.md"
    draws = plan(4, 9)
    lines = [json.dumps({"seed_of_all": 9})]
    lines += [json.dumps({"without": diagnosis.WHOLE, "outcome": replace(CREEP, bench=bench, seed=seed).to_dict()})
              for bench, seed in draws[:2]]  # fmt: skip
    file.write_text("\n".join(lines) + '\n{"without": "the wh', encoding="utf-8")
    asked: list[diagnosis.Job] = []

    def instead(_judge: object, jobs: list[diagnosis.Job], *_rest: object) -> list[tuple[str, Outcome]]:
        asked.extend(jobs)
        return [(job[0], replace(CREEP, bench=job[1], seed=job[2])) for job in jobs]

    monkeypatch.setattr(diagnosis, "judged", instead)
    words = ["--draws", "4", "--records", str(file), "--page", str(page), "--no-timing"]
    assert diagnosis.main(words) == 0
    assert [job[1:] for job in asked] == draws[2:]
    assert "4 draws" in page.read_text(encoding="utf-8")
    assert diagnosis.main([*words, "--seed", "10"]) == 1


@pytest.mark.parametrize("name", sorted(SWITCHES))
def test_switches_replace_what_is_there_and_put_it_back(name: str) -> None:
    """Every switch but the first changes a function or a constant of the package, and leaves it as it was."""
    from hexathermal.learn.diagnosis import all_trials, course, deciding, evidence, mending, search, stage, timing
    from hexathermal.learn.diagnosis.channels import Channel
    from hexathermal.learn.diagnosis.order import Order
    from hexathermal.learn.diagnosis.witnesses import Witnesses

    def state() -> list[object]:
        searching = (search, search.Search, Witnesses, Order, Channel)
        places = (all_trials, course, deciding, evidence, mending, stage.Stage, timing.Timing, *searching)
        return [dict(vars(place)) for place in places]

    before = state()
    with without(name):
        assert (state() == before) == (name == diagnosis.WHOLE)
    assert state() == before


@pytest.mark.long
@pytest.mark.parametrize(
    "name", ["no parity of the sensors", "noise not fitted again for leaders", "windows as independent"]
)
def test_a_switched_search_still_finds_a_plain_effect(name: str) -> None:
    """What takes the place of a method fits the method's callers: a ranking comes out, a plain effect leads it."""
    from hexathermal.learn.diagnosis.stage import Stage

    view, _answer = viewed("modal", 5, ("backlash",), 2.0)
    with without(name):
        assert Stage(view).step.ranking[0].cause == "backlash"


def test_finer_and_longer_campaigns_are_the_same_physics() -> None:
    """Four times the rows keep start, end, and every fourth row; twice the runs are of other days, of the same leg."""
    truth, _ = campaign_of("rough", 3, causes=())
    fine, long = finer(truth, 4), longer(2, ("backlash",))
    for one, other in zip(truth.runs, fine.runs, strict=True):
        assert len(other.time) == 4 * (len(one.time) - 1) + 1
        np.testing.assert_allclose(other.time[::4], one.time, atol=1e-9)
        np.testing.assert_allclose(other.temperatures[::4], one.temperatures, atol=1e-9)
        assert other.inputs.shape == (len(other.time), one.inputs.shape[1])
    roles = [run.role for run in long.runs]
    assert (roles.count("identification"), roles.count("validation")) == (18, 6)
    assert len({run.name for run in long.runs}) == len({float(run.q.sum()) for run in long.runs}) == len(roles)
    assert all(run.effect.any() and run.beam_effects.any() for run in long.runs)
    same, _ = campaign_of("modal", 1, causes=("backlash",), strength=1.0)
    assert (long.base, long.retracted_length) == (same.base, same.retracted_length)
    np.testing.assert_array_equal(long.coefficients, same.coefficients)
