"""Cleaning: every kind of damage is found, counted and named; sound rows are untouched; blocks do not matter."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from hexathermal.errors import ArgumentError
from hexathermal.learn.campaign import joined
from hexathermal.learn.campaign_faults import CampaignError
from hexathermal.learn.campaign_files import load_campaign
from hexathermal.learn.campaign_laws import identify_campaign
from hexathermal.learn.cleaning import usable_blocks, used_run

from .campaign_folders import (
    A_PER_K,
    B_PER_K,
    Q0_M,
    Table,
    cleaned,
    component_campaign,
    leg_campaign,
    leg_table,
    write_table,
)

SHARED = Path(__file__).resolve().parents[3] / "shared"


def test_a_sound_run_loses_only_rows_that_are_not_settled(tmp_path: Path) -> None:
    """Drift is the mean of the beams less q, temperatures count from the first row, nothing settled is left out."""
    kept: dict[str, Table] = {}
    block, record = cleaned(tmp_path, lambda table: kept.setdefault("table", table))
    table = kept["table"]
    settled = table["settled"] == 1.0
    assert [step.step for step in record.steps] == ["not settled"]
    assert record.count("not settled") == (~settled).sum() == record.rows - record.used
    beams = np.mean([table[f"beam{k}_mm"] for k in (1, 2, 3)], axis=0)
    assert np.allclose(block.drift, 1e-3 * (beams - (table["q_mm"] - table["q_mm"][0]))[settled], atol=1e-15)
    assert np.allclose(block.dT[:, 0], (table["T01_degC"] - table["T01_degC"][0])[settled], atol=1e-12)
    assert np.array_equal(block.time, table["time_s"][settled])
    assert block.landing.max() + 1 == 600 // 25
    assert block.q is not None
    assert np.unique(np.round(block.q[block.landing == 3], 6)).size == 1


@pytest.mark.parametrize("jump_um", [2.0, 30.0])
def test_a_jump_of_all_beams_in_a_rest_is_told_and_kept(tmp_path: Path, jump_um: float) -> None:
    """All beams jumping together while the leg rests is noted once where it happens; the drift is left as measured."""
    place = {}

    def edit(table: Table) -> None:
        q, settled = table["q_mm"], table["settled"]
        still = [k for k in range(20, 580) if np.ptp(q[k - 6 : k + 7]) == 0.0 and settled[k - 6 : k + 7].all()]
        place["row"] = still[len(still) // 2]
        for beam in (1, 2, 3):
            table[f"beam{beam}_mm"][place["row"] :] += 1e-3 * jump_um

    block, record = cleaned(tmp_path, edit)
    assert record.count("drift step") == 1
    (step,) = (item for item in record.steps if item.step == "drift step")
    table = leg_table(0, 600)
    assert abs(step.first_time - table["time_s"][place["row"]]) <= 2.0 * record.sampling
    assert np.ptp(block.drift) > 0.9e-6 * jump_um


@pytest.mark.parametrize("rows", [1, 7, 100, 10_000])
def test_the_size_of_blocks_changes_nothing(tmp_path: Path, rows: int) -> None:
    """Blocks hold at most the rows asked for, and together are the run, bit for bit."""

    def edit(table: Table) -> None:
        table["T02_degC"][[50, 51, 400]] += 3.0
        table["beam1_mm"][330:] += 0.01

    campaign = load_campaign(leg_campaign(tmp_path, edit=edit))
    whole, record = used_run(campaign, "a")
    stream = usable_blocks(campaign, "a", rows=rows)
    blocks = list(stream)
    assert {len(block) for block in blocks[:-1]} <= {rows}
    together = joined(blocks)
    for name in ("time", "dT", "drift", "q", "landing", "air"):
        assert np.array_equal(getattr(together, name), getattr(whole, name), equal_nan=True)
    assert stream.record == record


def test_long_runs_come_as_many_blocks_with_damage_at_their_seams(tmp_path: Path) -> None:
    """A run of several pieces: spikes and a step at the seams of the pieces are found as anywhere else."""
    spikes, step = [8191, 8192, 16384, 25000], 16900

    def edit(table: Table) -> None:
        table["T01_degC"][spikes] += 3.0
        table["beam3_mm"][step:] -= 0.05

    campaign = load_campaign(leg_campaign(tmp_path, edit=edit, rows=26_000, validation=False), scan=False)
    stream = usable_blocks(campaign, "a", rows=5000)
    blocks = list(stream)
    assert max(map(len, blocks)) == 5000
    assert stream.record.count("spike", "T01_degC") == len(spikes)
    assert stream.record.count("beam step", "beam3_mm") == 1
    block = joined(blocks)
    assert block.q is not None
    law = (A_PER_K * Q0_M + B_PER_K * block.q) * block.dT[:, 0]
    assert np.nanmax(np.abs(block.drift - law)) < 0.9e-6  # noise of 0.05 K makes 0.6 um at most


@pytest.mark.parametrize(
    ("value", "how"), [(21.0, "stuck"), (np.nan, "missing"), (9999.0, "missing code")], ids=["flat", "empty", "code"]
)
def test_a_law_that_lacks_its_sensor_tells_the_run_and_how(tmp_path: Path, value: float, how: str) -> None:
    """A thermometer that is of no use in one run: the refusal names that run, and what took the values away."""

    def edit(table: Table) -> None:
        table["T02_degC"][:] = value

    campaign = load_campaign(leg_campaign(tmp_path, edit=edit))
    with pytest.raises(ArgumentError, match=rf"sensor T02 lacks 100 % of the rows of run a \({how}\), allowed 10 %"):
        identify_campaign(campaign, ["T02"])
    notes = identify_campaign(campaign, ["T01"]).notes
    assert f"sensor T02 was left out of the search: it lacks 100 % of the rows of run a ({how})" in notes


def test_channels_are_cleaned_one_by_one(tmp_path: Path) -> None:
    """Missing codes, spikes, stuck and dead channels become NaN there and only there, with their counts."""

    def edit(table: Table) -> None:
        table["T01_degC"][[100, 101, 400]] += 2.0
        table["T02_degC"][200:230] = -180.0
        table["T03_degC"][300:360] = table["T03_degC"][300]
        table["T04_degC"][:] = 9999.0

    block, record = cleaned(tmp_path, edit)
    clean, _ = cleaned(tmp_path / "clean")
    assert record.count("spike", "T01_degC") == 3
    assert record.count("missing code", "T02_degC") == 30
    assert record.count("stuck", "T03_degC") == 60
    assert record.count("dead channel", "T04_degC") == 600
    assert np.isnan(block.dT[:, 3]).all()
    lost = np.isnan(block.dT[:, :3])
    times = block.time / 20.0
    assert set(times[lost[:, 0]]) == {100.0, 101.0, 400.0} & set(times)
    assert np.array_equal(np.where(lost, 0.0, block.dT[:, :3]), np.where(lost, 0.0, clean.dT[:, :3]))
    assert np.array_equal(block.drift, clean.drift)


def test_the_clock_is_put_in_order(tmp_path: Path) -> None:
    """Duplicates, rows out of order, a time that jumps ahead and one that is missing go; a gap is noted."""

    def edit(table: Table) -> Table:
        table["time_s"][105] = 1e6
        table["time_s"][107] = np.nan
        order = np.concatenate([np.arange(200), [198, 199], np.arange(200, 400), np.arange(440, 600)])
        return {name: values[order] for name, values in table.items()}

    block, record = cleaned(tmp_path, edit)
    assert record.count("clock jump") == 1
    assert record.count("no time") == 1
    assert record.count("clock disorder") + record.count("duplicate") == 2
    assert record.count("gap") == 1
    assert (np.diff(block.time) > 0.0).all()


def test_the_zero_is_the_first_row_that_may_be_used(tmp_path: Path) -> None:
    """Where the first row is not settled, or a channel has no value there, the next one counts, and it is said."""

    def edit(table: Table) -> None:
        table["settled"][0] = 0.0
        table["T02_degC"][:4] = -180.0

    block, record = cleaned(tmp_path, edit)
    assert block.time[0] == 20.0
    assert block.drift[0] == 0.0
    assert record.zero_time == 20.0
    assert {step.channel for step in record.steps if step.step == "zero"} == {"row", "T02_degC"}
    first = np.flatnonzero(np.isfinite(block.dT[:, 1]))[0]
    assert block.dT[first, 1] == 0.0


def test_beams_are_corrected_for_the_air_only_where_the_laser_did_not(tmp_path: Path) -> None:
    """A pressure front of 20 hPa on 0.7 m of dead path makes 3.8 um and more; the correction takes them off."""

    def edit(table: Table) -> None:
        front = 20.0 * np.arange(600) / 600
        table["air_pressure_hPa"] = 1000.0 + front
        table["air_temperature_degC"] = np.full(600, 20.0)
        table["air_humidity_percent"] = np.full(600, 45.0)
        for beam in (1, 2, 3):
            table[f"beam{beam}_mm"] = table[f"beam{beam}_mm"] + 0.268e-6 * front * (700.0 + table["q_mm"])

    clean, _ = cleaned(tmp_path / "clean")
    left, _ = cleaned(tmp_path / "left", edit)
    corrected, _ = used_run(load_campaign(leg_campaign(tmp_path / "corrected", edit=edit, compensated=False)), "a")
    assert np.abs(left.drift - clean.drift).max() > 3.5e-6
    assert np.abs(corrected.drift - clean.drift).max() < 0.1e-6


def test_short_gaps_of_the_weather_are_bridged_and_long_ones_cost_rows(tmp_path: Path) -> None:
    """Without compensation a row needs the weather: one 600 s old is taken, and said; an older one is not."""

    def edit(table: Table) -> None:
        table["air_pressure_hPa"][100:105] = 9999.0
        table["air_pressure_hPa"][300:360] = 9999.0

    _, record = used_run(load_campaign(leg_campaign(tmp_path, edit=edit, compensated=False)), "a")
    assert record.count("weather held", "air_pressure_hPa") > 20
    assert 20 <= record.count("no weather") <= 30


def test_a_component_counts_from_the_first_row_of_the_campaign(tmp_path: Path) -> None:
    """zero = "campaign": the second run keeps its offsets from the first; stretches end where the input changes."""
    campaign = load_campaign(component_campaign(tmp_path))
    first, _ = used_run(campaign, "a")
    second, _ = used_run(campaign, "b")
    assert first.q is None
    assert first.drift[0] == 0.0
    assert abs(second.drift[0] - 8e-6) < 0.2e-6
    assert abs(second.dT[0, 0] - 2.0) < 0.1
    assert first.landing.max() == 1


def test_a_part_without_beams_is_told_of_none(tmp_path: Path) -> None:
    """A jump of the drift of a component: its displacement sensor lost count; no word of beams that it has not."""
    folder = component_campaign(tmp_path)
    file = folder / "runs" / "a.csv"
    head, *rows = file.read_text(encoding="utf-8").splitlines()
    cut = len(rows) * 3 // 4
    jumped = [",".join([*row.split(",")[:-1], str(float(row.split(",")[-1]) + 5e3)]) for row in rows[cut:]]
    file.write_text("\n".join([head, *rows[:cut], *jumped]) + "\n", encoding="utf-8")
    _, record = used_run(load_campaign(folder), "a")
    assert record.count("count lost") == len(jumped)
    assert not any("beam" in f"{step.step} {step.reason}" for step in record.steps)


@pytest.mark.parametrize(("way_mm", "lost"), [(200.0, False), (50.0, True), (None, True)])
def test_what_a_slide_is_measured_at_may_differ_from_place_to_place(
    tmp_path: Path, way_mm: float | None, lost: bool
) -> None:
    """A warm part is off by 150 um more at the other end of 200 mm; of 50 mm of way, or of none, count was lost."""
    folder = component_campaign(tmp_path)
    file = folder / "runs" / "a.csv"
    head, *rows = file.read_text(encoding="utf-8").splitlines()
    cut, moved = len(rows) // 2, []
    for k, row in enumerate(rows):
        *known, drift = row.split(",")
        place = [] if way_mm is None else [str(way_mm * (k >= cut))]
        moved.append(",".join([*known, *place, str(float(drift) + 150.0 * (k >= cut))]))
    *names, last = head.split(",")
    names += [] if way_mm is None else ["q_mm"]
    file.write_text("\n".join([",".join([*names, last]), *moved]) + "\n", encoding="utf-8")
    if way_mm is not None:
        other = folder / "runs" / "b.csv"
        first, *rest = other.read_text(encoding="utf-8").splitlines()
        placed = [f"{row.rpartition(',')[0]},0.0,{row.rpartition(',')[2]}" for row in rest]
        other.write_text("\n".join([f"{first.rpartition(',')[0]},q_mm,{last}", *placed]) + "\n", encoding="utf-8")
    _, record = used_run(load_campaign(folder), "a")
    assert (record.count("count lost") > 0) == lost


def test_beams_that_count_from_each_run_do_not_fit_a_campaign_that_counts_from_the_first(tmp_path: Path) -> None:
    """zero = "campaign" with beams that start at 0 in a run at another q would be a drift of millimetres: refused."""

    def edit(table: Table) -> None:
        table["q_mm"] += 30.0

    campaign = load_campaign(leg_campaign(tmp_path, edit=edit, zero="campaign"))
    assert used_run(campaign, "a")[0].drift[0] == 0.0
    with pytest.raises(ArgumentError, match='write zero = "run"'):
        used_run(campaign, "b")


def test_a_first_run_without_a_row_is_named_by_those_that_count_from_it(tmp_path: Path) -> None:
    """zero = "campaign" and no usable row in the first run: one error that names that run, whichever is read."""
    folder = component_campaign(tmp_path)
    file = folder / "runs" / "a.csv"
    head, *rows = file.read_text(encoding="utf-8").splitlines()
    lost = [",".join([*row.split(",")[:-1], "1e300"]) for row in rows]
    file.write_text("\n".join([head, *lost]) + "\n", encoding="utf-8")
    campaign = load_campaign(folder, scan=False)
    for run, said in (("a", "hexathermal check shows more"), ("b", "all runs count from its first row")):
        with pytest.raises(CampaignError, match=f"no row of identification run 'a' may be used: .*{said}") as error:
            used_run(campaign, run)
        assert len(error.value.faults) == 1


def test_nothing_usable_is_said_with_the_reasons(tmp_path: Path) -> None:
    """A run without one settled row: the error gives the count and the reason."""

    def edit(table: Table) -> None:
        table["settled"][:] = 0.0

    with pytest.raises(CampaignError, match="no row of identification run 'a' may be used: 600 not settled"):
        cleaned(tmp_path, edit)


def test_a_run_that_cleaning_took_away_is_refused_with_all_of_its_role(tmp_path: Path) -> None:
    """Less than a tenth of a run left: refused after its last block, together with the other such runs of its role."""
    folder = leg_campaign(tmp_path)
    for name in ("a", "b", "c"):
        table = leg_table(3)
        for beam in (1, 2, 3):
            table[f"beam{beam}_mm"][30:] += 5.0
        write_table(folder / "runs" / f"{name}.csv", table)
    campaign = load_campaign(folder)
    blocks = usable_blocks(campaign, "a")
    with pytest.raises(CampaignError, match="beams lost") as error:
        list(blocks)
    assert [Path(file).stem for file, _problem in error.value.faults] == ["a", "b"]
    assert blocks.record.lost > 0.9
    assert len(next(usable_blocks(campaign, "a", least=0.0))) == blocks.record.used > 0


def test_readings_that_no_air_has_are_left_out(tmp_path: Path) -> None:
    """A block of pascals in a column of hPa, some humidities of 130 %: left out and counted, the run goes on."""

    def edit(table: Table) -> None:
        table["air_pressure_hPa"][100:120] *= 100.0
        table["air_humidity_percent"][200:205] = 130.0

    _, record = used_run(load_campaign(leg_campaign(tmp_path, edit=edit, compensated=False)), "a")
    assert record.count("missing code", "air_pressure_hPa") == 20
    assert record.count("missing code", "air_humidity_percent") == 5


def test_the_record_is_plain_data(tmp_path: Path) -> None:
    """A record can be written as JSON, every step with its reason."""
    import json

    _, record = cleaned(tmp_path)
    data = json.loads(json.dumps(record.as_data(), allow_nan=False))
    assert data["rows"] == 600
    assert all(step["reason"] for step in data["steps"])


@pytest.mark.long
@pytest.mark.skipif(not (SHARED / "open-campaigns").is_dir(), reason="the open campaigns are not beside the checkout")
def test_hardly_a_row_of_sound_campaigns_is_left_out() -> None:
    """Of 14 campaigns without damage no temperature and no more than one row in 2000 is left out."""
    rows = lost = 0
    for folder in sorted((SHARED / "open-campaigns").glob("leg-*")):
        campaign = load_campaign(folder, scan=False)
        for run in campaign.runs:
            _, record = used_run(campaign, run)
            rows += record.used
            others = [step for step in record.steps if step.step != "not settled"]
            lost += sum(step.count for step in others)
            assert {step.step for step in others} <= {"drift spike"}
    assert lost < rows / 2000


@pytest.mark.parametrize(("step", "noise_K"), [(0.1, 0.01), (0.1, 0.03), (1e-3, 0.0)])
def test_a_steady_reading_in_steps_is_not_stuck(tmp_path: Path, step: float, noise_K: float) -> None:
    """Thermometers read in steps larger than their noise stand still for long: nothing is stuck. One that stands still
    while the part warms by many steps is, whether it comes back or not.
    """

    def edit(table: Table) -> None:
        rng = np.random.default_rng(6)
        for k in range(4):
            since = (np.arange(600) + 37 * k) % 150
            away = (np.arange(600) + 37 * k) // 150 % 2 == 0
            warm = np.where(away, 1.0 - np.exp(-since / 18.0), np.exp(-since / 18.0))
            read = 20.0 + 60.0 * step * warm + noise_K * rng.standard_normal(600)
            table[f"T0{k + 1}_degC"] = np.round(read / step) * step

    _, record = cleaned(tmp_path / "sound", edit)
    assert record.count("stuck") == 0

    for rows in (slice(76, 170), slice(376, 600)):

        def stuck(table: Table, rows: slice = rows) -> None:
            edit(table)
            table["T03_degC"][rows] = table["T03_degC"][rows.start]

        _, record = cleaned(tmp_path / f"{rows.start}", stuck)
        assert record.count("stuck") == record.count("stuck", "T03_degC") >= rows.stop - rows.start
