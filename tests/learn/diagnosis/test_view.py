"""Windows of landings, smoothed temperatures, and the columns of shapes in windows."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from hexathermal.learn.diagnosis.all_trials import all_trials
from hexathermal.learn.diagnosis.mending import mended, mended_view, told_by
from hexathermal.learn.diagnosis.pieces import EDGES_S, LONGEST_S, Pooled, pieces_of
from hexathermal.learn.diagnosis.read_later import read_later
from hexathermal.learn.diagnosis.sensor_model import sensor_model
from hexathermal.learn.diagnosis.smoothing import smoothed
from hexathermal.learn.diagnosis.stage import Stage
from hexathermal.learn.diagnosis.view import View
from hexathermal.machine.leg_repairs import SensorRepair
from hexathermal.machine.leg_terms import term_columns
from tests.learn.diagnosis.campaigns import viewed

MEMORYLESS = {
    "temperature": lambda view: {"sensor": view.sensors[3], "ratio": 0.4},
    "square": lambda view: {"sensor": view.base[0], "ratio": 0.4},
    "bend": lambda view: {"sensor": view.base[0], "ratio": 0.4, "middle_degC": 21.0, "width_K": 2.0},
    "position": lambda view: {},
    "time": lambda view: {},
}
REMEMBERING = {
    "lag": lambda view: {"sensor": view.base[0], "ratio": 0.4, "time_constant_s": 600.0, "order": 2},
    "stored-heat": lambda view: {"source": "motion", "time_constant_s": 900.0},
    "direction": lambda view: {},
    "relaxation": lambda view: {"time_constant_s": 200.0, "kick": "direction"},
    "room": lambda view: {"time_constant_s": 1800.0},
}


@pytest.fixture(scope="module")
def view() -> View:
    """A leg with nothing hidden, rows every few seconds."""
    return viewed("quiet", 11, (), 1.0)[0]


def test_windows_share_out_the_usable_rows(view: View) -> None:
    """Every usable row is in one window, a window in one landing, and none is longer than `LONGEST_S`."""
    for rows, piece in zip(view.runs, view.pieces, strict=True):
        np.testing.assert_array_equal(piece.used, np.flatnonzero(rows.settled))
        assert piece.rows.sum() == len(piece.used)
        assert (piece.rows >= 1).all()
        ends = np.append(piece.edges[1:], len(piece.used)) - 1
        landing, time = rows.landing[piece.used], rows.signals.time[piece.used]
        np.testing.assert_array_equal(landing[piece.edges], landing[ends])
        assert (time[ends] - time[piece.edges]).max() <= LONGEST_S + 1e-6


def test_a_landing_begins_with_short_windows(view: View) -> None:
    """What relaxes, relaxes at first: a landing's windows begin 0, 60, 180 and 420 s after its first row."""
    rows, piece = view.runs[0], view.pieces[0]
    time, step = rows.signals.time[piece.used], float(np.median(np.diff(rows.signals.time)))
    for k in np.unique(piece.landing):
        own = time[piece.edges[piece.landing == k]] - time[piece.edges[piece.landing == k][0]]
        for begin, wanted in zip(own, EDGES_S, strict=False):
            assert wanted - 1e-6 <= begin <= wanted + 3.0 * step


def test_windows_do_not_grow_without_end(view: View) -> None:
    """A run that rests for weeks has no more windows than allowed: they get longer."""
    rows = view.runs[0]
    n = 100_000
    still = np.zeros(n)
    signals = replace(rows.signals, time=np.arange(n) * 60.0, q=still, dT={"T": still}, air=None, index=None, tilt=None)
    whole = replace(
        rows, signals=signals, drift=np.zeros(n), landing=np.zeros(n, dtype=np.int64), settled=np.ones(n, dtype=bool)
    )
    assert len(pieces_of(whole).edges) <= 501


@pytest.mark.parametrize("zeroed", [True, False])
def test_windows_of_all_runs_are_those_of_each(view: View, zeroed: bool) -> None:
    """Means made at once are those of each run by itself, less its own zero, for tables as for one column."""
    own = replace(view, zeroed_by_run=zeroed)
    rng = np.random.default_rng(3)
    tables = [rng.standard_normal((len(rows.signals.time), 2)) for rows in view.runs]
    zeros = [table[piece.used[0]] if zeroed else 0.0 for table, piece in zip(tables, view.pieces, strict=True)]
    parts = [piece.means(table - zero) for table, zero, piece in zip(tables, zeros, view.pieces, strict=True)]
    wanted = np.concatenate(parts)
    np.testing.assert_allclose(own.windows_zeroed(tables), wanted, rtol=0.0, atol=1e-13)
    alone = own.windows_zeroed([table[:, 0] for table in tables])[:, 0]
    np.testing.assert_allclose(alone, wanted[:, 0], rtol=0.0, atol=1e-13)
    still = own.windows_zeroed([np.full(len(table), 101325.3) for table in tables])
    assert zeroed == (not still.any())


def test_means_are_means(view: View) -> None:
    """A window's value is the mean of its rows, for tables as for one column."""
    rows, piece = view.runs[1], view.pieces[1]
    table = np.column_stack([rows.drift, rows.signals.time])
    means = piece.means(table)
    k = len(piece.edges) // 2
    own = piece.used[piece.edges[k] : piece.edges[k + 1]]
    np.testing.assert_allclose(means[k], table[own].mean(axis=0), rtol=1e-12)
    np.testing.assert_allclose(piece.means(rows.drift), means[:, 0], rtol=1e-12)


def test_the_channel_counts_runs_and_landings(view: View) -> None:
    """One start a run, one fresh window a landing, rows as many as there are."""
    channel = view.channel
    assert channel.start.sum() == len(view.runs)
    assert channel.fresh.sum() == sum(len(np.unique(piece.landing)) for piece in view.pieces)
    assert channel.rows.sum() == sum(rows.settled.sum() for rows in view.runs)
    assert (channel.step[channel.start] == 0.0).all()
    assert (channel.step[~channel.start] > 0.0).all()


def test_smoothing_keeps_a_parabola_and_takes_noise(rng: np.random.Generator) -> None:
    """A parabola in time passes unchanged; white noise of rows every 10 s loses two thirds or more."""
    time = np.arange(0.0, 6000.0, 10.0)
    parabola = (2e-7 * time**2 - 1e-3 * time + 3.0)[:, None]
    np.testing.assert_allclose(smoothed(time, parabola), parabola, atol=1e-9)
    noise = rng.standard_normal((600, 1))
    assert smoothed(time, noise).std() < 0.34


def test_smoothing_knows_no_direction_of_time(rng: np.random.Generator) -> None:
    """Smoothed backwards is the smoothed, backwards: it can feign no lag."""
    time, values = np.arange(0.0, 6000.0, 10.0), rng.standard_normal((600, 2)).cumsum(axis=0)
    np.testing.assert_allclose(smoothed(time, values[::-1])[::-1], smoothed(time, values), atol=1e-9)


@pytest.mark.parametrize("shape", sorted(MEMORYLESS))
def test_shapes_without_a_memory_need_windows_only(view: View, shape: str) -> None:
    """From mean signals a shape without a memory is what the mean of its rows is, within 2 % of its size."""
    parameters = MEMORYLESS[shape](view)
    quick, slow = view.quick_columns(shape, parameters), view.columns(shape, parameters)
    assert np.abs(quick - slow).max() < 0.02 * np.abs(slow).max()


def test_with_one_zero_the_displacement_counts_from_the_campaign_s_first_row() -> None:
    """Of a part whose runs go on one behind the other, a scale that is off is right at the first row of all alone."""
    part = viewed("component", 4589137713060650, ("scale-error",), 2.0)[0]
    assert not part.zeroed_by_run
    assert np.ptp([signals.q[0] for signals in part.signals]) > 0.05
    quick, slow = part.quick_columns("position", {}), part.columns("position", {})
    assert np.abs(quick - slow).max() < 1e-3


@pytest.mark.parametrize("shape", sorted(REMEMBERING))
def test_shapes_with_a_memory_run_over_all_rows(view: View, shape: str) -> None:
    """A column is the mean over windows of the law's own shape over all rows, moves too, less its value at the zero."""
    parameters = REMEMBERING[shape](view)
    found = view.columns(shape, parameters)
    own = []
    for signals, piece in zip(view.signals, view.pieces, strict=True):
        rows = term_columns(shape, signals, parameters)
        own.append(piece.means(rows - rows[piece.used[0]]))
    np.testing.assert_allclose(found, np.concatenate(own), rtol=1e-12, atol=1e-18)
    assert np.ptp(found) > 0.0


@pytest.mark.parametrize("shape", ["lag", "lead", "stored-heat", "temperature"])
def test_a_ratio_asked_later_is_made_of_what_was_kept(view: View, shape: str) -> None:
    """Whatever ratio was asked for before, columns are those of the law's own shape at the ratio asked for."""
    known = {"lag": REMEMBERING["lag"](view), "lead": {"sensor": view.base[0], "time_constant_s": 300.0},
             "stored-heat": {"source": "motion", "time_constant_s": 900.0},
             "temperature": {"sensor": view.sensors[3]}}[shape]  # fmt: skip
    for ratio in (0.4, -1.3, 0.0):
        parameters = {**known, "ratio": ratio}
        own = [term_columns(shape, signals, parameters) for signals in view.signals]
        zeroed = [rows - rows[piece.used[0]] for rows, piece in zip(own, view.pieces, strict=True)]
        wanted = view.windows(zeroed)
        np.testing.assert_allclose(view.columns(shape, parameters), wanted, rtol=0.0, atol=1e-12 * np.abs(wanted).max())


def test_what_is_kept_is_made_once(view: View) -> None:
    """What a key stands for is made at the first question; another key is another thing."""
    made = [view.once(("a test", key), lambda key=key: [key]) for key in (1, 2, 1)]  # type: ignore[misc]
    assert made == [[1], [2], [1]]
    assert made[0] is made[2]


def test_temperatures_count_from_the_zero(view: View) -> None:
    """The smoothed temperatures of each run are 0 in its first usable row, so that the law's columns are too."""
    for signals, piece in zip(view.signals, view.pieces, strict=True):
        for name in view.sensors:
            assert abs(signals.dT[name][piece.used[0]]) < 1e-12


def test_reading_later_is_a_shift(view: View) -> None:
    """A sensor read 0 s later is itself; two minutes later, what comes then, less the same at the zero."""
    name, at = view.base[0], 0
    rows = view.tables([name])
    np.testing.assert_allclose(read_later(view, rows, 0.0)[:, 0], view.temperatures(name), atol=1e-9)
    moved = read_later(view, rows, 120.0)[:, 0]
    for signals, piece in zip(view.signals, view.pieces, strict=True):
        time = signals.time
        later = piece.means(np.interp(time + 120.0, time, signals.dT[name]))
        own = moved[at : at + len(later)]
        at += len(later)
        np.testing.assert_allclose(own - own[0], later - later[0], atol=1e-9)
        assert np.ptp(own) > 0.0


@pytest.mark.parametrize("offset", [-400.0, -45.0, 7.0, 150.0])
def test_reading_later_is_what_the_repair_of_a_clock_reads(view: View, offset: float) -> None:
    """Smoothed temperatures shifted are the smoothed ones of mended data, but for errors of reading at ends of runs."""
    repair = SensorRepair("clock-offset", "clock", {"offset_s": offset})
    mended_view = replace(view, runs=tuple(mended(rows, repair) for rows in view.runs))
    for name in view.sensors:
        found = read_later(view, view.tables([name]), offset)[:, 0]
        told = mended_view.temperatures(name)
        apart = found - told
        # a zero is one row, and its error stays in the run
        apart -= np.array([apart[view.channel.run == k].mean() for k in range(len(view.runs))])[view.channel.run]
        assert np.sqrt((apart**2).mean()) < 0.03 * told.std(), name


@pytest.mark.parametrize("offset", [-300.0, 0.0, 200.0])
def test_with_one_zero_each_run_is_read_as_the_repair_reads_it(view: View, offset: float) -> None:
    """Where all runs count from one zero, the run that has it counts from it read later, the others as they did."""
    runs = []
    for k, rows in enumerate(view.runs):
        dT = {name: values + 0.5 * k for name, values in rows.signals.dT.items()}
        runs.append(replace(rows, signals=replace(rows.signals, dT=dT)))
    one = replace(view, runs=tuple(runs), zeroed_by_run=False, smooths=False)
    repair = SensorRepair("clock-offset", "clock", {"offset_s": offset})
    mended_view = replace(one, runs=tuple(mended(rows, repair) for rows in one.runs))
    for name in view.sensors[::4]:
        found = read_later(one, one.tables([name]), offset)[:, 0]
        np.testing.assert_allclose(found, mended_view.temperatures(name), rtol=0.0, atol=1e-9)


def test_what_had_not_come_to_rest_decays_in_its_own_run(view: View) -> None:
    """One column for each run, ``exp(-t / tau)`` less what it was at the zero, and nothing in any other run."""
    tau = 3600.0
    starts = view.starts(tau)
    run = view.channel.run
    assert starts.shape == (len(run), len(view.runs))
    decays = view.windows_zeroed([np.exp(-rows.signals.time / tau) for rows in view.runs])[:, 0]
    assert starts[np.arange(len(run)), run] == pytest.approx(decays, abs=0.02)
    assert np.abs(starts).sum() == pytest.approx(np.abs(starts[np.arange(len(run)), run]).sum())


@pytest.mark.long
@pytest.mark.parametrize("seed", [733])
def test_a_frame_that_had_not_come_to_rest_is_found_and_its_law_carries_the_room_alone(seed: int) -> None:
    """Free starts explain what the room of a run alone does not; they stand in the null, and join no law."""
    found, _ = viewed("quiet", seed, ("frame-expansion",), 1.6)
    stage = Stage(found)
    leader = stage.step.ranking[0]
    assert leader.cause == "frame-expansion"
    trials = [trial for trial in stage.search.trials if trial.cause == "frame-expansion"]
    assert {trial.starts for trial in trials} == {0, len(found.runs)}
    assert {trial.carried for trial in trials} == {1}
    own = next(item for item in stage.search.scored(leader.levels, trials) if item.trial.starts)
    after = stage.with_effect(own)
    assert len(after.law[0]) == found.base_columns.shape[1] + 1
    assert after.base.X.shape[1] == stage.base.X.shape[1] + 1 + len(found.runs)
    assert after.base.plain == stage.base.plain + 1


def _repairs(view: View) -> list[SensorRepair]:
    """A repair of each kind, of the law's thermometer where it is of one."""
    own, *others = (view.base[0], *(name for name in view.sensors if name not in view.base))
    return [
        SensorRepair("clock-offset", "clock", {"offset_s": 240.0}),
        SensorRepair("swapped-sensors", "swap", {"first": own, "second": others[0]}),
        SensorRepair("sensor-drift", "drift", {"sensor": own, "rate_K_per_h": 0.1}),
        SensorRepair("sensor-detached", "detached", {"sensor": own, "weights": {others[0]: 0.4, others[1]: 0.6}}),
        SensorRepair("sensor-detached", "loose", {"sensor": own, "share": 0.3}),
    ]


@pytest.mark.long
@pytest.mark.parametrize("kind", ["clock", "detached", "loose"])
def test_a_mended_view_keeps_only_what_the_repair_leaves(kind: str) -> None:
    """What a view made before its data were mended is made anew where it reads what was mended, and nowhere else.

    A view that was asked for all its trials and then mended tells the same as one that is mended and asked for the
    first time: temperatures, all trials' columns, what the thermometers may err by.
    """
    asked = replace(viewed("modal", 5, (), 1.0)[0])
    repair = next(one for one in _repairs(asked) if one.kind == kind)
    fresh = mended_view(replace(asked), repair)
    told_by(asked, lambda sensor: sensor_model(asked, sensor))
    all_trials(Stage(asked).bench)
    creep = {"time_constant_s": 200.0, "kick": "direction"}
    before = asked.columns("relaxation", creep)
    kept = mended_view(asked, repair)
    for one, other in zip(kept.signals, fresh.signals, strict=True):
        assert one.zero_degC == other.zero_degC
        for name in asked.sensors:
            np.testing.assert_allclose(one.dT[name], other.dT[name], atol=1e-12)
    both = [told_by(view, lambda sensor, of=view: sensor_model(of, sensor)) for view in (kept, fresh)]
    np.testing.assert_allclose(both[0].law, both[1].law, atol=1e-12)
    np.testing.assert_allclose(both[0].alike[0], both[1].alike[0], atol=1e-9)
    trials = [all_trials(Stage(view).bench) for view in (kept, fresh)]
    assert len(trials[0]) == len(trials[1])
    for one, other in zip(*trials, strict=True):
        assert (one.cause, one.target, one.shape) == (other.cause, other.target, other.shape)
        np.testing.assert_allclose(one.columns, other.columns, rtol=1e-6, atol=1e-9)
    assert kept.columns("relaxation", creep) is before, "motion was not mended"


@pytest.mark.parametrize("zeroed", [False, True])
def test_compiled_means_are_those_of_usable_rows(zeroed: bool) -> None:
    """One pass gathers, takes the zero away and sums; what never changes is 0 to the last bit once zeroed."""
    rng = np.random.default_rng(5)
    used = np.flatnonzero(rng.uniform(size=400) < 0.7)
    first = int((used < 250).sum())
    edges = np.sort(np.unique(np.concatenate([[0, first], rng.choice(len(used), 30)])))
    rows, zeros = np.diff(np.append(edges, len(used))).astype(float), np.repeat([0, first], [first, len(used) - first])
    pooled = Pooled(used, edges, rows, zeros)
    values = np.column_stack([rng.normal(size=(400, 3)), np.full(400, 0.1)])
    found = pooled.means(values, zeroed=zeroed)
    told = values[used] - values[used[zeros]] if zeroed else values[used]
    wanted = [part.mean(axis=0) for part in np.split(told, edges[1:])]
    assert np.allclose(found, wanted, rtol=0.0, atol=1e-14)
    assert np.array_equal(found[:, :1], pooled.means(values[:, 0], zeroed=zeroed))
    assert not zeroed or not found[:, 3].any()
