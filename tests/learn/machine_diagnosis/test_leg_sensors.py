"""Legs with several thermometers: one that the law should read, and two whose plugs are exchanged, found from files."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import hexathermal as ht
from hexathermal.learn.campaign import Campaign
from hexathermal.learn.campaign_files import load_campaign
from hexathermal.learn.machine_diagnosis.diagnosing import diagnose_machine
from hexathermal.learn.machine_diagnosis.leg_sensors import reading_law, sensor_candidates, swapped_law, with_laws
from hexathermal.learn.machine_diagnosis.single_leg import CANNOT_SHOW
from hexathermal.learn.machine_diagnosis.view import machine_view
from hexathermal.machine.leg_terms import LegTerm
from tests.learn.hexapods import temperatures
from tests.learn.machine_diagnosis.machines import A, B, drawn, filed
from tests.learn.test_hexapod_validation import written

LEG = 2
"""The leg that is wrong, from 0."""

SHARE = 0.7
"""Of the first thermometer in a law of two."""

MISSED = 0.2
"""Coefficients of the thermometer that the law does not read, over those of the one that it reads."""


def two_sensors(**changes: object) -> ht.Hexapod:
    """The machine whose laws read two thermometers a leg; together they weigh what the one weighed."""
    law = ht.LegLaw(["T1", "T2"], [SHARE * A, (1 - SHARE) * A], [SHARE * B, (1 - SHARE) * B])
    return filed(legs=(law,) * 6, reference_temperature_degC=20.0, **changes)


def campaign(folder: Path, fault: str, *, law: int = 1, seed: int = 21, less: str = "") -> Campaign:
    """Write a campaign of a machine with two thermometers a leg.

    What truly warms a leg is ``w`` of the generator, one course a leg; the second thermometer goes its own way, and the
    first is such that the law of the file, were it whole and rightly plugged, gives w. `less` loses T2: on the legs
    "but one", or in a "row".
    """
    rows, rng = drawn(seed, runs=4, poses=60), np.random.default_rng(seed + 1000)
    second = np.concatenate([temperatures(rng, 60)[0] for _run in range(4)])
    warm = rows.dT[..., 0]
    first = (warm - (1 - SHARE) * second) / SHARE if law == 2 else warm.copy()
    if fault == "missing":
        first[:, LEG] = warm[:, LEG] - MISSED * second[:, LEG]
    if fault == "swapped":
        first[:, LEG], second[:, LEG] = second[:, LEG].copy(), first[:, LEG].copy()
    hexapod = two_sensors() if law == 2 else filed()
    written(folder, replace(rows, dT=first[..., None]), hexapod=hexapod, identified=3)
    legs = [LEG] if less == "but one" else range(6)
    for k, name in enumerate(rows.runs):
        file = folder / f"{name}.csv"
        head, *lines = file.read_text(encoding="utf-8").splitlines()
        more = 20.0 + second[rows.run == k]
        names = [f"leg{leg + 1}_T2_degC" for leg in legs]
        told = [[f"{row[leg]:.9f}" for leg in legs] for row in more]
        if less == "row" and k == 1:
            told[7][0] = ""
        table = [",".join([line, *own]) for line, own in zip(lines, told, strict=True)]
        file.write_text("\n".join([",".join([head, *names]), *table]) + "\n", encoding="utf-8")
    return load_campaign(folder)


@pytest.mark.long
def test_a_thermometer_that_the_law_should_read_is_found(tmp_path: Path) -> None:
    """Its leg, name, A and B are told; the extended machine reads it, from its file as well, and is clean."""
    folder = campaign(tmp_path, "missing")
    found = diagnose_machine(folder)
    one = found.effects[0]
    assert (found.verdict, found.cause, one.target) == ("effect", "missing-sensor", f"leg{LEG + 1}")
    assert dict(one.settings) == {"thermometer": "T2"}
    assert "T2" in one.sentence
    for name, true in (("A_per_K_T2", MISSED * A), ("B_per_K_T2", MISSED * B)):
        assert abs(one.parameters[name].value - true) < 4.0 * one.parameters[name].std
    assert one.parameters["A_per_K_T2"].std < 0.2 * MISSED * A
    scores = found.gain.total["translation"]
    assert scores.after.value < 0.9 * scores.before.value
    assert found.extended.thermal.legs[LEG].sensors == ("T1", "T2")
    assert [law.sensors for law in found.extended.thermal.legs].count(("T1",)) == 5
    ht.write_hexapod(found.extended, tmp_path / "extended")
    again = diagnose_machine(folder, hexapod=ht.load_hexapod(tmp_path / "extended"))
    assert again.verdict == "none"
    assert any("near that thermometer" in advice.words for advice in found.advice)


@pytest.mark.long
@pytest.mark.parametrize("law", [1, 2])
def test_exchanged_plugs_of_one_leg_are_found(tmp_path: Path, law: int) -> None:
    """Of two that the law reads, and of one that it reads and one that it does not; the extended machine is clean."""
    folder = campaign(tmp_path, "swapped", law=law)
    found = diagnose_machine(folder)
    one = found.effects[0]
    assert (found.verdict, found.cause, one.target) == ("effect", "swapped-sensors", f"leg{LEG + 1}")
    assert dict(one.settings) == {"exchanged": "T1", "with": "T2"}
    assert abs(one.parameters["share"].value - 1.0) < 4.0 * one.parameters["share"].std
    assert "plugs of T1 and T2 on leg3 are exchanged" in one.sentence
    assert found.extended.thermal.legs[LEG].sensors == (("T2", "T1") if law == 2 else ("T2",))
    assert diagnose_machine(folder, hexapod=found.extended).verdict == "none"


@pytest.mark.parametrize("laws", ["kept", "refit"])
def test_clean_legs_with_further_thermometers_are_clean(tmp_path: Path, laws: str) -> None:
    """A thermometer that no law reads and that tells nothing is looked at, and names nothing."""
    found = diagnose_machine(campaign(tmp_path, ""), laws=laws)
    assert found.verdict == "none"
    assert not any(note.startswith(("missing-sensor" + CANNOT_SHOW, "swapped-sensors")) for note in found.notes)


@pytest.mark.long
@pytest.mark.parametrize(("less", "said"), [("but one", "T2 is on leg 3 alone"), ("row", "T2 of the legs is not rec")])
def test_thermometers_that_not_all_rows_tell_cost_no_row(tmp_path: Path, less: str, said: str) -> None:
    """They are left aside, which is said with what would show their causes, and no row is lost."""
    found = diagnose_machine(campaign(tmp_path, "missing", less=less))
    assert sum(len(run.time) for run in found.residuals) == 240
    assert any(said in note for note in found.notes)
    assert any(note.startswith("missing-sensor" + CANNOT_SHOW) for note in found.notes)


@pytest.mark.long
def test_plugs_exchanged_beside_laws_fitted_anew_keep_their_coefficients(tmp_path: Path) -> None:
    """With laws="refit" the coefficients of a place stay those of the place, whatever column tells it."""
    found = diagnose_machine(campaign(tmp_path, "swapped", law=2), laws="refit")
    law = found.extended.thermal.legs[LEG]
    by_column = dict(zip(law.sensors, law.A, strict=True))
    assert by_column["T2"] == pytest.approx(SHARE * A, rel=0.1)
    assert by_column["T1"] == pytest.approx((1 - SHARE) * A, rel=0.1)


def test_one_thermometer_a_leg_asks_nothing() -> None:
    """No candidate is made where there is nothing to exchange or to add."""
    assert sensor_candidates(machine_view(drawn(3, runs=1, poses=20))) == []


def test_laws_that_read_otherwise_keep_what_they_state() -> None:
    """Terms follow their plug, references their column; a new thermometer has its own block of the covariance."""
    square = LegTerm("nonlinear-expansion", "square", {"sensor": "T1", "ratio": 0.5}, [1e-9])
    law = ht.LegLaw(["T1"], [A], [B], np.diag([1e-16, 4e-16]), terms=[square], spread=[1e-9, 0.0])
    other = swapped_law(law, {"exchanged": "T1", "with": "T2"})
    assert (other.sensors, other.terms[0].parameters["sensor"]) == (("T2",), "T2")
    more = reading_law(law, "T2", np.array([1e-7, 2e-7]), np.array([[9e-16, 1e-16], [1e-16, 9e-16]]))
    assert more.A.tolist() == [A, 1e-7]
    assert more.B.tolist() == [B, 2e-7]
    assert more.covariance.tolist() == [[1e-16, 0, 0, 0], [0, 9e-16, 0, 1e-16], [0, 0, 4e-16, 0], [0, 1e-16, 0, 9e-16]]
    assert more.spread.tolist() == [1e-9, 0.0, 0.0, 0.0]
    twice = reading_law(more, "T2", np.array([1e-7, 0.0]), np.zeros((2, 2)))
    assert twice.A.tolist() == [A, 2e-7]
    model = filed(reference_temperature_degC=np.arange(20.0, 28.0)).thermal
    wide = with_laws(model, [reading_law(own, "T2", np.zeros(2), np.zeros((2, 2))) for own in model.legs])
    told = dict(zip(wide.sensor_names, wide.reference_temperature_degC, strict=True))
    assert (told["leg3_T1"], told["leg3_T2"], told["base_T1"]) == (22.0, 23.5, 27.0)
