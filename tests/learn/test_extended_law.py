"""A law with terms: the same row by row, in blocks and at once; what needs more than a row is refused by name."""

from __future__ import annotations

import dataclasses
import json
import shutil
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hexathermal.cli import main
from hexathermal.errors import ArgumentError, UnknownNameError
from hexathermal.learn.campaign_files import load_campaign
from hexathermal.learn.campaign_laws import identify_campaign, role_blocks, validate_campaign
from hexathermal.learn.leg_law_files import write_leg_law
from hexathermal.learn.signals import run_rows
from hexathermal.learn.validation import validate
from hexathermal.learn.validation_gain import gain
from hexathermal.machine.leg_repairs import SensorRepair, repaired
from hexathermal.machine.leg_terms import SHAPES, LegTerm
from tests.learn.campaign_folders import (
    A_PER_K,
    B_PER_K,
    Table,
    campaign_text,
    component_campaign,
    leg_table,
    write_table,
)
from tests.learn.extended_laws import EXAMPLES, Q0, REPAIRS, drawn_signals, law_with, part, terms_of

EVERY = [shape for shape in SHAPES if shape in EXAMPLES]


def read_at(signals, k: int) -> dict[str, float]:  # type: ignore[no-untyped-def]
    """Return the temperatures of a row, as a controller is given them [degC]."""
    return {name: signals.zero_of(name) + values[k] for name, values in signals.dT.items()}


def weather(signals, k: int) -> dict:  # type: ignore[no-untyped-def]
    """Return what a row holds beside temperatures and displacement, as a controller is given it."""
    return {"air": 21.3 + signals.air[k], "index": 1.00027 + signals.index[k], "tilt": signals.tilt[k],
            "pressure_index": 1.00027 + signals.pressure_index[k],
            "inputs": {name: values[k] for name, values in signals.inputs.items()}}  # fmt: skip


@pytest.mark.long
@pytest.mark.parametrize("shape", EVERY)
@given(seed=st.integers(0, 10**6), cuts=st.sets(st.integers(1, 159), max_size=6))
def test_blocks_of_rows_give_what_all_rows_at_once_give(shape: str, seed: int, cuts: set[int]) -> None:
    """To 1e-12 m, however the rows are cut, for every shape."""
    law, signals = law_with(terms_of(shape)), drawn_signals(seed)
    memory, edges = law.memory(), [0, *sorted(cuts), 160]
    pieces = [law.predict_signals(part(signals, slice(a, b)), memory) for a, b in pairwise(edges)]
    assert np.abs(np.concatenate(pieces) - law.predict_signals(signals)).max() < 1e-12


@pytest.mark.parametrize("shape", EVERY)
def test_a_controller_row_by_row_gives_what_all_rows_at_once_give(shape: str) -> None:
    """To 1e-12 m for every shape, with readings in degC and the zero taken from the first row."""
    law, signals = law_with(terms_of(shape)), drawn_signals(7)
    controller = law.controller()
    found = [
        controller.update(
            1000.0 + signals.time[k], read_at(signals, k), signals.q[k],
            **weather(signals, k),
        )
        for k in range(len(signals))
    ]  # fmt: skip
    assert np.abs(np.array(found) - law.predict_signals(signals)).max() < 1e-12
    assert controller.drift == found[-1]


@given(seed=st.integers(0, 10**6), chosen=st.lists(st.sampled_from(REPAIRS), min_size=1, max_size=4, unique_by=id))
def test_causal_repairs_run_row_by_row(seed: int, chosen: list[SensorRepair]) -> None:
    """Swap, drift, detached sensor and a clock that runs behind: to 1e-12 m what they give offline, in any order."""
    law, signals = law_with(terms_of("lag"), tuple(chosen)), drawn_signals(seed, 60)
    memory = law.memory()
    rows = [law.predict_signals(part(signals, slice(k, k + 1)), memory)[0] for k in range(len(signals))]
    assert np.abs(np.array(rows) - law.predict_signals(signals)).max() < 1e-12


def test_repairs_do_what_they_say() -> None:
    """Each against the same thing written out."""
    signals = drawn_signals(3)
    t, dT = signals.time, signals.dT
    swap, drift, late, detached = REPAIRS[:4]
    swapped = repaired(signals, [swap])
    assert np.array_equal(swapped.dT["T01"], dT["T02"])
    assert swapped.zero_degC == signals.zero_degC | {"T01": signals.zero_of("T02"), "T02": signals.zero_of("T01")}
    assert np.allclose(repaired(signals, [drift]).dT["T01"], dT["T01"] - 0.03 * t / 3600.0, atol=1e-14)
    assert np.allclose(repaired(signals, [detached]).dT["T02"], 0.4 * dT["T01"] + 0.7 * dT["T03"], atol=1e-14)
    assert np.allclose(repaired(signals, [late]).dT["T03"], np.interp(t - 47.5, t, dT["T03"]), atol=1e-14)
    ahead = repaired(signals, [SensorRepair("clock-offset", "clock", {"offset_s": 30.0})])
    moved = np.interp(t + 30.0, t, dT["T03"])
    assert np.allclose(ahead.dT["T03"], moved - moved[0], atol=1e-14)
    later = SensorRepair(
        "sensor-detached", "detached", {"sensor": "T02", "weights": {"T01": 1.0}, "from_s": {"b": 300}}
    )
    assert np.array_equal(repaired(signals, [later], "a").dT["T02"], dT["T02"])
    begun = repaired(signals, [later], "b").dT["T02"]
    assert np.array_equal(begun, np.where(t >= 300.0, dT["T01"], dT["T02"]))
    assert np.array_equal(repaired(signals, [later]).dT["T02"], dT["T01"])
    fixed = SensorRepair("sensor-detached", "detached", {**later.parameters, "again_in": ["c"]})
    assert np.array_equal(repaired(signals, [fixed], "b").dT["T02"], begun)
    for run in ("c", None):
        assert repaired(signals, [fixed], run).dT["T02"] is dT["T02"]
    for wrong in ({"again_in": ["b"]}, {"again_in": ["c"], "from_s": {"c": 0.0}}):
        with pytest.raises(ArgumentError, match="again_in names runs after those of from_s"):
            SensorRepair("sensor-detached", "detached", {"sensor": "T02", "weights": {"T01": 1.0}, **wrong})


def test_a_loose_sensor_is_freed_of_the_air_by_its_own_reading() -> None:
    """``T = (1 - s) T_part + s T_air`` is undone to rounding: in all runs, or from a moment on, with the air's lead."""
    signals = drawn_signals(3)
    assert signals.air is not None
    part, air, share, above = signals.dT["T01"], signals.air, 0.2, 1.7
    read = dataclasses.replace(signals, dT={**signals.dT, "T01": (1.0 - share) * part + share * air})
    assert np.allclose(repaired(read, [REPAIRS[-1]]).dT["T01"], part, atol=1e-12)
    late = np.where(signals.time >= 300.0, (1.0 - share) * part + share * (air + above), part)
    read = dataclasses.replace(signals, dT={**signals.dT, "T01": late})
    since = {"sensor": "T01", "share": share, "from_s": {"b": 300.0, "c": 0.0}, "air_above_K": {"b": above}}
    repair = SensorRepair("sensor-detached", "loose", since)
    assert np.allclose(repaired(read, [repair], "b").dT["T01"], part, atol=1e-12)
    assert repaired(read, [repair], "a").dT["T01"] is read.dT["T01"]
    with pytest.raises(ArgumentError, match="the air temperature, which is not given"):
        repaired(dataclasses.replace(read, air=None), [repair], "b")
    for wrong in (1.0, -0.1, "0.2x"):
        with pytest.raises(ArgumentError, match="share must be 0 to below 1"):
            SensorRepair("sensor-detached", "loose", {"sensor": "T01", "share": wrong})
    with pytest.raises(ArgumentError, match="leave reference_degC out"):
        law_with((), (repair,)).controller(20.0)


def test_the_air_of_a_loose_sensor_counts_from_the_row_that_temperatures_count_from() -> None:
    """Rows before the zero are not usable, and the air goes on meanwhile; before it came loose no air is asked for."""
    signals = drawn_signals(4)
    assert signals.air is not None
    part = signals.dT["T01"] - signals.dT["T01"][5]
    others = {name: values - values[5] for name, values in signals.dT.items()}
    read = 0.8 * part + 0.2 * (signals.air - signals.air[5])
    late = dataclasses.replace(signals, dT={**others, "T01": read})
    since = {"sensor": "T01", "share": 0.2, "from_s": {"b": 0.0}}
    repair = SensorRepair("sensor-detached", "loose", since)
    assert np.allclose(repaired(late, [repair], "b").dT["T01"], part, atol=1e-12)
    after = SensorRepair("sensor-detached", "loose", {**since, "from_s": {"b": 1e9}})
    assert repaired(dataclasses.replace(late, air=None), [after], "b").dT["T01"] is read


def test_repairs_of_some_runs_leave_the_others_as_they_are() -> None:
    """Plugs exchanged in some runs, a rate for each run; a controller, whose run has no name, takes what came last."""
    signals = drawn_signals(3)
    t, dT = signals.time, signals.dT
    swap = SensorRepair("swapped-sensors", "swap", {"first": "T01", "second": "T02", "not_in": ["a"]})
    before = repaired(signals, [swap], "a")
    assert before.dT["T01"] is dT["T01"]
    assert before.zero_degC == signals.zero_degC
    for run in ("b", "of a later campaign", None):
        after = repaired(signals, [swap], run)
        assert np.array_equal(after.dT["T01"], dT["T02"])
        assert after.zero_of("T02") == signals.zero_of("T01")
    own = {"sensor": "T01", "rate_K_per_h": 0.06, "rates_K_per_h": {"a": 0.0, "b": 0.03}}
    drift = SensorRepair("sensor-drift", "drift", own)
    for run, rate in (("a", 0.0), ("b", 0.03), ("c", 0.06), (None, 0.06)):
        taken = repaired(signals, [drift], run).dT["T01"]
        assert np.allclose(taken, dT["T01"] - rate * t / 3600.0, atol=1e-14)
    with pytest.raises(ArgumentError, match="not_in holds names of runs"):
        SensorRepair("swapped-sensors", "swap", {"first": "T01", "second": "T02", "not_in": "run-01"})
    with pytest.raises(ArgumentError, match="rates_K_per_h is a table"):
        SensorRepair("sensor-drift", "drift", {"sensor": "T01", "rate_K_per_h": 0.1, "rates_K_per_h": 0.2})


def test_a_clock_that_runs_ahead_is_no_matter_for_a_controller() -> None:
    """Offline it is run; a controller says that it would need the future."""
    law = law_with((), (SensorRepair("clock-offset", "clock", {"offset_s": 30.0}),))
    assert np.isfinite(law.predict_signals(drawn_signals(1))).all()
    with pytest.raises(ArgumentError, match="temperatures that come later"):
        law.controller()
    with pytest.raises(ArgumentError, match="row by row that cannot be run"):
        law.predict_signals(drawn_signals(1), law.memory())


@pytest.mark.parametrize("shape", EVERY)
def test_a_leg_that_follows_the_law_is_corrected_to_zero(shape: str) -> None:
    """Lengths are asked for row by row; the leg, warm by the same law along the lengths that it was given, is as long
    as wanted to 1e-12 m; uncorrected it is not.
    """
    law, signals = law_with(terms_of(shape)), drawn_signals(11, 80)
    controller, wanted = law.controller(), Q0 + signals.q
    commands = np.empty(len(signals))
    for k in range(len(signals)):
        at = (signals.time[k], read_at(signals, k))
        commands[k] = controller.corrected_length(wanted[k], *at, **weather(signals, k))
        controller.update(*at, commands[k] - Q0, **weather(signals, k))
        assert controller.corrected_length(commands[k] + controller.drift) == pytest.approx(commands[k], abs=1e-12)
    true = commands + law.predict_signals(dataclasses.replace(signals, q=commands - Q0))
    assert np.abs(true - wanted).max() < 1e-12
    assert np.abs(law.predict_signals(signals)).max() > 1e-7


@pytest.mark.parametrize("shape", EVERY)
def test_predict_takes_an_extended_law_as_it_is(shape: str) -> None:
    """Given all rows of a run, `predict` is what the law says of them, terms, states and all."""
    law, signals = law_with(terms_of(shape)), drawn_signals(11, 80)
    assert np.array_equal(law.predict(signals), law.predict_signals(signals))
    plain = dataclasses.replace(law, terms=(), joint_covariance=None)
    dT = np.column_stack([signals.dT[name] for name in plain.sensors])
    np.testing.assert_allclose(plain.predict(signals), plain.predict(dT, signals.q), rtol=0.0, atol=1e-18)


def test_single_rows_are_refused_by_name() -> None:
    """`predict` of a law with a lag says which term is in the way and what to call; so does `validate` on blocks."""
    law = law_with(terms_of("lag"))
    with pytest.raises(ArgumentError, match=r"extended by thermal-lag.*predict_signals.*controller"):
        law.predict(np.zeros((1, 2)), np.zeros(1))
    with pytest.raises(ArgumentError, match="joint_covariance has shape"):
        dataclasses.replace(law, joint_covariance=np.eye(4))
    with pytest.raises(ArgumentError, match="needs sensor 'T02'"):
        law.predict_signals(dataclasses.replace(drawn_signals(1), dT={"T01": np.zeros(160)}))
    with pytest.raises(ArgumentError, match="needs the air temperature"):
        law_with(terms_of("room")).predict_signals(dataclasses.replace(drawn_signals(1), air=None))


def test_a_bad_row_leaves_no_trace() -> None:
    """A missing or broken reading, or time running backwards, is refused; the next row is taken as if it never was."""
    law = law_with(terms_of("lag"))
    two = [law.controller(), law.controller()]
    for one in two:
        one.update(0.0, {"T01": 20.0, "T02": 20.0}, 0.1)
    for bad in ((1.0, {"T01": 20.0}, 0.1), (1.0, {"T01": np.nan, "T02": 20.0}, 0.1), (-1.0, {"T01": 2, "T02": 2}, 0.1)):
        with pytest.raises(ArgumentError, match=r"missing|no reading|never decreases"):
            two[0].update(*bad)
    after = [one.update(60.0, {"T01": 21.0, "T02": 22.0}, 0.2) for one in two]
    assert after[0] == after[1]
    with pytest.raises(ArgumentError, match="no row yet"):
        law.controller().corrected_length(0.7)


def test_the_variance_holds_the_amplitudes() -> None:
    """Against the sum written out; joint covariance and its blocks agree where nothing is correlated."""
    covariance = np.array([[4e-16]])
    term = LegTerm("backlash", "direction", {}, [0.3e-6], covariance)
    law, signals = law_with((term,)), drawn_signals(5)
    base = law_with().variance_signals(signals)
    dT = np.column_stack([signals.dT["T01"], signals.dT["T02"]])
    assert np.allclose(base, law_with().variance(dT, signals.q, signals.time), rtol=1e-12)
    added = 4e-16 * term.columns(signals)[:, 0] ** 2
    assert np.allclose(law.variance_signals(signals), base + added, rtol=1e-12)
    joint = dataclasses.replace(law, joint_covariance=law.whole_covariance)
    assert np.array_equal(joint.variance_signals(signals), law.variance_signals(signals))
    whole = law.whole_covariance.copy()
    whole[0, 4] = whole[4, 0] = 1e-16
    crossed = dataclasses.replace(law, joint_covariance=whole).variance_signals(signals)
    more = 2e-16 * Q0 * dT[:, 0] * term.columns(signals)[:, 0]
    assert np.allclose(crossed, law.variance_signals(signals) + more, rtol=1e-9)


def with_backlash(table: Table) -> Table:
    """Return a run whose leg has 0.8 um of backlash and whose displacement is read in the rows of movements too."""
    moved = np.diff(table["q_mm"], prepend=table["q_mm"][0])
    last = np.maximum.accumulate(np.where(moved != 0.0, np.arange(len(moved)), 0))
    step = 0.4e-3 * np.sign(moved[last])
    return {name: values + step if name.startswith("beam") else values for name, values in table.items()}


@pytest.fixture(scope="module")
def campaign(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A leg with backlash: two runs to identify, two to validate."""
    folder = tmp_path_factory.mktemp("backlash")
    roles = {"a": "identification", "b": "identification", "c": "validation", "d": "validation"}
    for seed, name in enumerate(roles):
        write_table(folder / "runs" / f"{name}.csv", with_backlash(leg_table(seed)))
    (folder / "campaign.toml").write_text(campaign_text(roles), encoding="utf-8")
    return folder


def test_a_term_that_is_true_makes_the_validation_better(
    campaign: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """RMSE and largest residual fall by the backlash, per run too, and the gain is proven by its interval; the command
    line prints the same figures.
    """
    loaded = load_campaign(campaign)
    law = dataclasses.replace(identify_campaign(loaded, ["T01"]).law, coefficients=np.array([A_PER_K, B_PER_K]))
    extended = dataclasses.replace(law, terms=(LegTerm("backlash", "direction", {}, [0.8e-6], [[1e-18]]),))
    before, after = validate_campaign(law, loaded), validate_campaign(extended, loaded)
    assert after.rows == before.rows
    assert after.total.drift_rms == before.total.drift_rms
    assert after.total.rmse.value < 0.6 * before.total.rmse.value
    assert after.total.linf.value < before.total.linf.value
    assert all(after.runs[name].rmse.value < before.runs[name].rmse.value for name in ("c", "d"))
    better = gain(before, after)
    assert better.proven
    assert better.total.rmse_before == pytest.approx(before.total.rmse.value, rel=1e-12)
    ratio = after.total.rmse.value / before.total.rmse.value
    assert better.total.rmse_gain.value == pytest.approx(1.0 - ratio, rel=1e-9)
    assert better.runs["c"].linf_before == before.runs["c"].linf.value
    same = gain(after, after)
    assert not same.proven
    assert same.total.rmse_gain.value == pytest.approx(0.0, abs=1e-12)
    worse = gain(after, before)
    assert worse.total.rmse_gain.high < 0.0
    file, old = write_leg_law(extended, tmp_path / "leg.toml"), write_leg_law(law, tmp_path / "old.toml")
    answer = tmp_path / "v.json"
    assert main(["validate", str(file), str(campaign), "--before", str(old), "--json", str(answer)]) == 0
    told = json.loads(answer.read_text(encoding="utf-8"))
    assert told["total"]["rmse_um"]["value"] == pytest.approx(after.total.rmse.value * 1e6, rel=1e-9)
    assert told["law"]["terms"] == ["backlash"]
    assert told["gain"]["total"]["rmse_gain"]["value"] == pytest.approx(1.0 - ratio, rel=1e-9)
    said = capsys.readouterr().out
    assert "The law is extended by backlash." in said
    assert "Gain over the law before" in said


def test_repairs_put_a_damaged_campaign_right(campaign: Path, tmp_path: Path) -> None:
    """A swapped pair, a drifting sensor and a sensor that is dead in one run: with the repairs a validation has the
    figures of the sound campaign; without them that run is lost, and the others are worse.
    """
    sound, damaged = load_campaign(campaign), tmp_path / "damaged"
    shutil.copytree(campaign, damaged)
    for name in "abcd":
        seed = "abcd".index(name)
        table = with_backlash(leg_table(seed))
        T01, T03 = table["T01_degC"].copy(), table["T03_degC"].copy()
        table["T01_degC"] = np.full_like(T01, 20.0) if name == "c" else T01
        table["T02_degC"], table["T03_degC"] = T03, table["T02_degC"].copy()
        table["T04_degC"] = T01 + 0.5 * table["time_s"] / 3600.0
        write_table(damaged / "runs" / f"{name}.csv", table)
    law = identify_campaign(sound, ["T01"]).law
    repairs = (
        SensorRepair("sensor-drift", "drift", {"sensor": "T04", "rate_K_per_h": 0.5}),
        SensorRepair("swapped-sensors", "swap", {"first": "T02", "second": "T03"}),
        SensorRepair("sensor-detached", "detached", {"sensor": "T01", "weights": {"T04": 1.0}, "from_s": {"c": 0.0}}),
    )
    term = LegTerm("missing-sensor", "temperature", {"sensor": "T03", "ratio": 0.5}, [0.5e-6])
    wanted = validate_campaign(dataclasses.replace(law, terms=(term,)), sound)
    found = validate_campaign(dataclasses.replace(law, terms=(term,), repairs=repairs), load_campaign(damaged))
    assert found.rows == wanted.rows
    assert found.total.rmse.value == pytest.approx(wanted.total.rmse.value, rel=1e-3)
    assert found.runs["c"].linf.value == pytest.approx(wanted.runs["c"].linf.value, rel=1e-3)
    without = validate_campaign(dataclasses.replace(law, terms=(term,)), load_campaign(damaged))
    assert "c" not in without.runs
    assert gain(without, found).skipped == ("c",)
    with pytest.raises(ArgumentError, match="not validated on the same rows"):
        gain(without, dataclasses.replace(found, landings={"c": found.landings["c"]}))
    assert without.runs["d"].rmse.value > 1.1 * found.runs["d"].rmse.value


def test_states_come_from_all_rows_of_a_run(campaign: Path) -> None:
    """Rows that may not be used move the states: predictions of the usable rows are those of the whole run."""
    loaded = load_campaign(campaign)
    law = dataclasses.replace(identify_campaign(loaded, ["T01"]).law, terms=terms_of("relaxation")[:1])
    rows = run_rows(loaded, "c")
    curves = next(one for one in validate_campaign(law, loaded).curves if one.run == "c")
    said = law.predict_signals(rows.signals)
    assert np.array_equal(curves.predicted, said[rows.settled])
    assert not rows.settled.all()


def test_an_extended_law_meets_the_same_checks(campaign: Path) -> None:
    """A sensor that only a term reads must be there; a law without terms goes the old way, bit by bit."""
    loaded = load_campaign(campaign)
    law = identify_campaign(loaded, ["T01"]).law
    far = dataclasses.replace(
        law, terms=(LegTerm("missing-sensor", "temperature", {"sensor": "T99", "ratio": 0}, [0]),)
    )
    with pytest.raises(UnknownNameError, match="reads sensor 'T99', which the campaign does not have"):
        validate_campaign(far, loaded)
    with pytest.raises(ArgumentError, match="predict_signals"):
        validate(
            dataclasses.replace(law, terms=terms_of("position")), role_blocks(loaded, "validation"), loaded.sensors
        )
    zero = dataclasses.replace(law, terms=(LegTerm("backlash", "direction", {}, [0.0]),))
    with_term, without = validate_campaign(zero, loaded), validate_campaign(law, loaded)
    assert with_term.total == without.total


def test_a_component_with_stored_heat(tmp_path: Path) -> None:
    """A component's law takes terms too; its lengths are one metre for a kelvin."""
    loaded = load_campaign(component_campaign(tmp_path))
    law = identify_campaign(loaded, ["T1"]).law
    term = LegTerm("hidden-heat", "stored-heat", {"source": "spindle_speed_rpm", "time_constant_s": 600.0}, [1e-10])
    found = validate_campaign(dataclasses.replace(law, terms=(term,)), loaded)
    assert found.rows == validate_campaign(law, loaded).rows
