"""Laws that are fitted anew are in the extended machine; kept ones are not touched."""

from __future__ import annotations

import numpy as np
import pytest

import hexathermal as ht
from hexathermal.learn.machine_diagnosis.diagnosing import diagnosed
from hexathermal.machine.files import read_hexapod
from tests.learn.machine_diagnosis.machines import A, B, Fault, drawn

SIGMAS = 4.0
CHANGE = 5e-7


@pytest.fixture(scope="module")
def rows():  # type: ignore[no-untyped-def]
    """A machine whose six legs expand alike, by a quarter more than its file says."""
    return drawn(41, Fault(legs=tuple((leg, CHANGE, 0.0) for leg in range(6))), runs=3, poses=60)


def test_a_law_fitted_anew_joins_the_machine(rows, tmp_path) -> None:  # type: ignore[no-untyped-def]
    """What all legs share needs no name, stands in the machine with its covariance, is told, and is read back."""
    found = diagnosed(rows, laws="refit")
    assert not found.effects
    thermal = found.extended.thermal
    assert thermal.common_law
    law = thermal.legs[0]
    off = np.array([law.A[0] - A - CHANGE, law.B[0] - B]) / np.sqrt(np.diagonal(law.covariance))
    assert np.abs(off).max() < SIGMAS
    assert np.sqrt(law.covariance[0, 0]) < 0.2 * CHANGE
    assert any("laws fitted anew" in note and "legs 1, 2, 3, 4, 5, 6" in note for note in found.notes)
    after = np.concatenate([run.after for run in found.residuals])
    assert after.std() < np.concatenate([run.before for run in found.residuals]).std()
    ht.write_hexapod(found.extended, tmp_path / "hexapod.toml")
    assert read_hexapod(tmp_path / "hexapod.toml").thermal.legs[3].A == pytest.approx(law.A)


@pytest.mark.long
def test_a_leg_that_differs_besides_has_its_own_law(rows) -> None:  # type: ignore[no-untyped-def]
    """Of a leg that is named the whole change counts once: its law is the shared one and its own change."""
    more = drawn(42, Fault(legs=tuple((leg, CHANGE * (1 + 2 * (leg == 1)), 0.0) for leg in range(6))))
    found = diagnosed(more, laws="refit")
    assert [(one.cause, one.target) for one in found.effects] == [("leg-coefficient", "leg2")]
    for leg, law in enumerate(found.extended.thermal.legs):
        std = np.sqrt(law.covariance[0, 0])
        assert abs(law.A[0] - A - CHANGE * (1 + 2 * (leg == 1))) < SIGMAS * std


@pytest.mark.long
def test_a_kept_law_stays(rows) -> None:  # type: ignore[no-untyped-def]
    """Without being asked, no leg's law is changed but by a cause that is named."""
    found = diagnosed(rows, laws="kept")
    named = {one.target for one in found.effects if one.cause == "leg-coefficient"}
    for leg, law in enumerate(found.extended.thermal.legs):
        assert f"leg{leg + 1}" in named or law.A[0] == A
    assert not any("fitted anew" in note for note in found.notes)
