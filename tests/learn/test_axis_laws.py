"""Parts that are measured where they stand: their law reads q where that pays, and rows in motion are left out."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from hexathermal.cli import main
from hexathermal.errors import ArgumentError, DataError
from hexathermal.learn.campaign import Block
from hexathermal.learn.campaign_files import load_campaign
from hexathermal.learn.campaign_laws import identify_campaign, validate_campaign
from hexathermal.learn.cleaning import used_run
from hexathermal.learn.identification import identify
from hexathermal.learn.leg_law_files import read_leg_law, write_leg_law
from hexathermal.learn.validation import validate
from hexathermal.machine.leg_signals import LegSignals
from tests.learn.campaign_folders import Table, write_table
from tests.learn.legs import LEG, SENSORS, TRUE_A, drawn_leg

C, D = 4e-6, 11e-6
REST, MOVE = 20, 4


def axis_table(seed: int, rows: int = 720, *, tells: bool = False, at: float | None = None) -> Table:
    """A run of rests and moves of four rows, at which the gauge is 5 um off; drift of ``(C + D q) dT`` of T1."""
    rng = np.random.default_rng(seed)
    stop = np.arange(rows) // (REST + MOVE)
    places = rng.permutation(np.linspace(0.0, 0.4, stop[-1] + 2))
    part = np.clip((np.arange(rows) % (REST + MOVE) - REST + 1) / (MOVE + 1.0), 0.0, 1.0)
    places = places if at is None else np.full_like(places, at)
    q, moving = places[stop] + part * (places[stop + 1] - places[stop]), part > 0.0
    time = 20.0 * np.arange(rows)
    heat = 4.0 * (1.0 - np.exp(-time / 2500.0)) + 1.5 * np.sin(time / 900.0 + seed)
    heat -= heat[0]
    drift = 1e6 * (C + D * q) * heat + 5.0 * moving * np.sign(rng.standard_normal(rows)) + 0.05 * rng.normal(size=rows)
    table: Table = {"time_s": time, "q_mm": np.round(1e3 * q, 4), "T1_degC": 20.0 + heat + 0.01 * rng.normal(size=rows),
                    "T2_degC": 20.0 + 0.2 * rng.normal(size=rows), "drift_um": drift - drift[0]}  # fmt: skip
    return table | ({"settled": 1.0 - moving} if tells else {})


def axis_campaign(folder: Path, *, tells: bool = False) -> Path:
    """Write four runs of an axis, three for identification."""
    text = 'format = "hexathermal-campaign/1"\nkind = "component"\ntitle = "axis"\nzero = "run"\n'
    text += "".join(f'[[thermocouples]]\nname = "{name}"\n' for name in ("T1", "T2"))
    for k in range(4):
        write_table(folder / "runs" / f"r{k}.csv", axis_table(k, tells=tells))
        role = "validation" if k == 3 else "identification"
        text += f'[[runs]]\nname = "r{k}"\nfile = "runs/r{k}.csv"\nrole = "{role}"\n'
    (folder / "campaign.toml").write_text(text, encoding="utf-8")
    return folder


def _parts(seed: int, B: float) -> list[Block]:
    """Runs of a part of ``A q0 dT + B q dT``."""
    return drawn_leg(np.random.default_rng([seed, 7]), runs=5, B=B, bias=0.0)


@pytest.mark.parametrize("seed", range(3))
def test_a_part_that_grows_with_its_stroke_has_two_coefficients_a_sensor(seed: int) -> None:
    """C and D are found within four standard uncertainties, and what reading q is worth is said."""
    blocks = _parts(seed, D)
    found = identify(lambda: blocks, SENSORS, wanted="T07", sizes=(1,))
    assert found.law.stroked
    off = (found.law.coefficients - [TRUE_A * LEG.retracted_length, D]) / found.law.standard_uncertainty
    assert np.abs(off).max() < 4.0
    assert any(note.startswith("the law reads the displacement, C dT + D q dT") for note in found.notes)
    assert found.law.validity.q is not None


def test_a_part_of_fixed_length_has_one() -> None:
    """Where the stroke does not matter no law of ten reads it, although all are told where the part stands."""
    for seed in range(10):
        blocks = _parts(seed, 0.0)
        found = identify(lambda blocks=blocks: blocks, SENSORS, wanted="T07", sizes=(1,))
        assert not found.law.stroked
        assert len(found.law.coefficients) == 1
        assert found.law.validity.q is None


def test_the_law_is_chosen_among_all_sets_by_what_each_form_leaves(tmp_path: Path) -> None:
    """Of two thermometers, one of which shows nothing, the right one is chosen, with C and D near the truth."""
    law = identify_campaign(load_campaign(axis_campaign(tmp_path / "axis"))).law
    assert law.sensors == ("T1",)
    assert law.coefficients == pytest.approx([C, D], rel=0.03)


def test_it_predicts_each_place_by_itself(tmp_path: Path) -> None:
    """``C dT + D q dT`` in rows, signals and a controller alike; without q it says what it needs."""
    law = identify_campaign(load_campaign(axis_campaign(tmp_path / "axis")), ("T1",)).law
    time, q, dT = np.arange(5) * 20.0, np.linspace(0.0, 0.4, 5), np.array([0.0, 1.0, 2.0, 3.0, 2.0])
    expected = law.A[0] * dT + law.B[0] * q * dT
    assert law.predict(dT[:, None], q) == pytest.approx(expected, rel=1e-12, abs=1e-18)
    assert law.predict(LegSignals(time, {"T1": dT}, q, 1.0)) == pytest.approx(expected, rel=1e-12, abs=1e-18)
    controller = law.controller(20.0)
    told = [controller.update(t, {"T1": 20.0 + d}, x) for t, d, x in zip(time, dT, q, strict=True)]
    assert told == pytest.approx(expected, rel=1e-9, abs=1e-15)
    with pytest.raises(ArgumentError, match="this law of a component needs the displacement q"):
        law.predict(dT[:, None])
    with pytest.raises(ArgumentError, match=r"this law needs the displacement q \[m\] in every row"):
        controller.update(100.0, {"T1": 21.0})


def test_its_file_tells_both_in_micrometres_and_comes_back(tmp_path: Path) -> None:
    """leg.toml has ``C_um_per_K`` and ``D_um_per_m_K``; what is written is read to the last bit, extended or not."""
    law = identify_campaign(load_campaign(axis_campaign(tmp_path / "axis")), ("T1",)).law
    file = write_leg_law(law, tmp_path / "law.toml")
    text = file.read_text(encoding="utf-8")
    assert f"D_um_per_m_K = [\n  {law.B[0] * 1e6:.5f}"[:-1] in text
    back = read_leg_law(file)
    assert np.array_equal(back.coefficients, law.coefficients)
    assert np.array_equal(back.covariance, law.covariance)
    file.write_text(text.replace("D_um_per_m_K = [", "D_um_per_m_K = [ 1.0,"), encoding="utf-8")
    with pytest.raises(Exception, match=r"law.D_um_per_m_K has 2 values; expected 1: T1"):
        read_leg_law(file)


def test_runs_never_fitted_are_foretold_and_need_q(tmp_path: Path) -> None:
    """On a run that was left out the law leaves little more than the gauge's noise; a run without q is refused."""
    campaign = load_campaign(axis_campaign(tmp_path / "axis"))
    law = identify_campaign(campaign, ("T1",)).law
    assert validate_campaign(law, campaign).total.rmse.value < 0.2e-6
    placeless = dataclasses.replace(used_run(campaign, "r3")[0], q=None)
    with pytest.raises(DataError, match="has no displacement q_mm, which the law of this component needs"):
        validate(law, [placeless], campaign.sensors)


def test_rows_in_motion_are_left_out_where_no_column_tells_rests(tmp_path: Path) -> None:
    """The same rows are used as where the table has the column; the reason is said, and runs never at rest are kept."""
    kept = {}
    for tells in (False, True):
        folder = axis_campaign(tmp_path / f"axis-{tells}", tells=tells)
        kept[tells], record = used_run(load_campaign(folder), "r0")
        said = {step.step: step.reason for step in record.steps}
        assert ("no column settled" in said["not settled"]) is not tells
    assert np.array_equal(kept[False].time, kept[True].time)
    table = axis_table(0)
    table["q_mm"] = np.linspace(0.0, 400.0, len(table["q_mm"]))
    write_table(tmp_path / "axis-False" / "runs" / "r0.csv", table)
    block, _ = used_run(load_campaign(tmp_path / "axis-False"), "r0")
    assert len(block) > 0.9 * len(table["q_mm"])


@pytest.mark.parametrize(
    ("still", "said"), [(1, "C dT + D q dT: on runs left out"), (2, "could not be judged on runs left out")]
)
def test_runs_that_stand_still_take_no_law_away(tmp_path: Path, still: int, said: str) -> None:
    """Of three runs one or two stand still: D is judged by those that move, or is not; C dT is there in any case."""
    folder = axis_campaign(tmp_path / "axis")
    for k in range(still):
        write_table(folder / "runs" / f"r{k}.csv", axis_table(k, at=0.1))
    found = identify_campaign(load_campaign(folder))
    assert found.law.sensors == ("T1",)
    assert any(said in note for note in found.notes)


def test_a_run_without_q_is_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A law that reads the displacement is not tried then, and a note says so; a run never fitted is passed over."""
    folder = axis_campaign(tmp_path / "axis")
    for name in ("r3", "r1"):
        table = axis_table(int(name[1]))
        del table["q_mm"]
        write_table(folder / "runs" / f"{name}.csv", table)
        if name == "r3":
            assert main(["diagnose", str(folder), "--sensors", "T1"]) == 0
            assert "not judged, what the law reads has no values there: r3" in capsys.readouterr().out
    found = identify_campaign(load_campaign(folder))
    assert not found.law.stroked
    assert any(note.startswith("q_mm is missing in a run") for note in found.notes)


def test_a_noisy_scale_is_no_motion(tmp_path: Path) -> None:
    """Rows at rest are used although the scale reads 5 um off and on."""
    folder, rng = axis_campaign(tmp_path / "axis"), np.random.default_rng(1)
    table = axis_table(0)
    table["q_mm"] = table["q_mm"] + 0.005 * rng.standard_normal(720)
    write_table(folder / "runs" / "r0.csv", table)
    block, _ = used_run(load_campaign(folder), "r0")
    assert len(block) > 0.98 * (720 - 720 // (REST + MOVE) * MOVE)


def test_the_commands_tell_the_form(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """``identify`` shows D with its unit and why it is there; ``validate`` takes the law."""
    folder, law = axis_campaign(tmp_path / "axis"), tmp_path / "law.toml"
    assert main(["identify", str(folder), "--out", str(law)]) == 0
    text = capsys.readouterr().out
    assert "D T1" in text
    assert "um/m/K" in text
    assert "C dT + D q dT" in text
    assert main(["validate", str(law), str(folder)]) == 0
    assert main(["diagnose", str(folder), "--law", str(law)]) == 0
