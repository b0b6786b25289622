"""The diagnosis of a machine: each cause by name, place and size; silence; what cannot be told apart; errors."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

import hexathermal as ht
from hexathermal.errors import ArgumentError, DataError, ThermalModelError
from hexathermal.learn.machine_diagnosis.candidate import called
from hexathermal.learn.machine_diagnosis.diagnosing import diagnosed
from hexathermal.learn.machine_diagnosis.result import MachineDiagnosis
from hexathermal.machine.files import read_hexapod
from tests.learn.machine_diagnosis.machines import A, B, Fault, drawn, filed

SIGMAS = 4.0
"""Standard deviations within which a parameter must hold its truth."""

FAULTS = {
    "leg-coefficient": (Fault(legs=((2, 3e-7, 0.0),)), "leg3", {"A_change_per_K": 3e-7, "A_per_K": A + 3e-7}),
    "platform-expansion": (Fault(platform=3e-6), "platform", {"expansion_per_K": 14e-6}),
    "base-expansion": (Fault(base=2e-6), "base", {"expansion_change_per_K": 2e-6}),
    "swapped-legs": (Fault(swapped=(1, 4)), "leg2+leg5", {"share": 1.0}),
    "payload-compliance": (Fault(sag=2e-6, centre=(0.1, 0.0, 0.0)), None, {"sag_um": 2.0, "centre_x_mm": 100.0}),
    "joint-offset": (Fault(base_joint=(3, (3e-6, -4e-6, 2e-6))), "base joint 4", {"offset_x_um": 3.0}),
    "tracker-drift": (Fault(tracker=(3e-7, 0, 0, 0, 3e-7, 0)), "air_temperature", {"shift_x_um_per_K": 0.3}),
    "leg-backlash": (Fault(backlash=(4, 6e-7)), "leg5", {"step_um": 0.6}),
}


@pytest.mark.long
@pytest.mark.parametrize("cause", FAULTS)
def test_each_cause_is_found_where_it_sits(cause: str) -> None:
    """A fault as strong as about half the noise is named, put in its place, sized, and nothing else is.

    The extended machine leaves less on runs never fitted.
    """
    fault, target, truth = FAULTS[cause]
    found = diagnosed(drawn(5, fault), drawn(105, fault, runs=2))
    assert found.verdict == "effect", found.sentence
    assert [(one.cause, one.target) for one in found.effects] == [(cause, target)]
    assert found.probability > 0.9
    for name, value in truth.items():
        one = found.effects[0].parameters[name]
        assert abs(one.value - value) < SIGMAS * one.std, (name, one)
    assert found.gain is not None
    total = found.gain.total
    assert sum(total[key].reduction.value > 0.0 for key in ("translation", "rotation")) >= 1
    assert total["translation"].after.value < 1.05 * np.sqrt(3.0) * 4e-7
    assert found.extended != found.hexapod


@pytest.mark.long
@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize("how", [{}, {"frame": 4e-6}, {"tails": 4.0}], ids=["still", "frames", "tails"])
def test_a_clean_machine_is_called_clean(seed: int, how: dict[str, float]) -> None:
    """Nothing is named on a machine as filed, with a tracker that stands elsewhere in each run, and in heavy tails."""
    found = diagnosed(drawn(20 + seed, **how))
    assert found.verdict == "none", found.sentence
    assert found.extended == found.hexapod
    assert "None above" in found.sentence
    assert found.gain is None


@pytest.mark.long
def test_two_legs_at_once() -> None:
    """Two legs whose laws are wrong are both named, neither hides behind a plate or the tracker."""
    found = diagnosed(drawn(3, Fault(legs=((1, 3e-7, 0.0), (4, -3e-7, 0.0)))))
    assert {(one.cause, one.target) for one in found.effects} == {
        ("leg-coefficient", "leg2"), ("leg-coefficient", "leg5")
    }  # fmt: skip


@pytest.mark.long
def test_an_exchange_and_a_plate_at_once() -> None:
    """An exchange is undone first, and what it hid is found behind it."""
    found = diagnosed(drawn(4, Fault(swapped=(0, 3), platform=4e-6)))
    assert {one.cause for one in found.effects} == {"swapped-legs", "platform-expansion"}
    assert found.extended.thermal is not None
    assert found.extended.thermal.thermometers_of_leg == (4, 2, 3, 1, 5, 6)


def test_places_that_poses_cannot_tell_apart_are_both_named() -> None:
    """Base and platform joint of a leg look alike where poses hardly turn it: the answer holds both names."""
    found = diagnosed(drawn(6, Fault(base_joint=(2, (4e-6, 4e-6, -6e-6))), share=0.002))
    first = found.effects[0]
    assert first.cause == "joint-offset"
    names = {called(first.cause, first.target), *first.equivalent_places}
    assert {"joint-offset of base joint 3", "joint-offset of platform joint 3"} <= names


@pytest.mark.long
def test_noise_is_that_of_the_tracker_whatever_is_wrong() -> None:
    """The noise is found within 10 %, coordinate by coordinate, under an effect ten times as strong."""
    found = diagnosed(drawn(7, Fault(platform=1e-4), poses=100))
    assert found.effects[0].cause == "platform-expansion"
    assert found.disturbances.noise == pytest.approx([4e-7] * 3 + [1e-6] * 3, rel=0.1)


@pytest.mark.long
def test_an_extended_machine_is_written_and_predicts(tmp_path) -> None:  # type: ignore[no-untyped-def]
    """What was named stands in hexapod.toml, and the machine that is read back corrects by it."""
    fault = Fault(legs=((2, 4e-7, 0.0),))
    found = diagnosed(drawn(8, fault), title="six runs")
    ht.write_hexapod(found.extended, tmp_path / "hexapod.toml")
    read = read_hexapod(tmp_path / "hexapod.toml")
    true = filed(legs=[ht.LegLaw("T1", A + 4e-7 * (leg == 2), B) for leg in range(6)])
    temps = 20.0 + np.array([4.0, 5.0, 6.0, 3.0, 4.0, 5.0, 1.0, 2.0])
    lengths = [one.corrected_leg_lengths(one.home, temps) for one in (read, true, filed())]
    assert np.abs(lengths[0] - lengths[1]).max() < 0.2 * np.abs(lengths[2] - lengths[1]).max()


@pytest.mark.long
def test_document_holds_the_format() -> None:
    """The JSON has every key of the format, plain numbers only, and survives a round trip."""
    found = diagnosed(drawn(5, Fault(platform=3e-6), poses=40), drawn(105, Fault(platform=3e-6), runs=1))
    document = found.to_json()
    assert json.loads(json.dumps(document, allow_nan=False)) == document
    assert (document["format"], document["kind"]) == ("hexathermal-diagnosis/1", "hexapod")
    assert {"verdict", "cause", "target", "equivalent", "probability", "parameters", "gain", "candidates",
            "next_experiment"} <= set(document)  # fmt: skip
    assert {"translation_rmse_before_um", "translation_linf_after_um", "rotation_rmse_after_urad", "rmse_before_um",
            "axes"} <= set(document["gain"])  # fmt: skip
    assert set(document["parameters"]["expansion_per_K"]) == {"value", "std", "unit"}
    assert isinstance(found, MachineDiagnosis)


@pytest.mark.long
def test_laws_fitted_anew_hide_no_single_leg() -> None:
    """With the common law fitted anew, what all legs share is its own; a leg that differs is still named."""
    rows = drawn(9, Fault(legs=tuple((leg, 5e-7, 0.0) for leg in range(6) if leg != 1)))
    found = diagnosed(rows, laws="refit")
    assert [(one.cause, one.target) for one in found.effects] == [("leg-coefficient", "leg2")]
    with pytest.raises(ArgumentError, match="'kept', 'refit'"):
        diagnosed(rows, laws="free")


def test_too_little_is_said() -> None:
    """Few poses, poses and temperatures that never change, and a machine without a law are refused with what to do."""
    rows = drawn(1, runs=1, poses=20)
    with pytest.raises(DataError, match="measure more poses"):
        diagnosed(rows)
    many = drawn(1, runs=1, poses=40)
    with pytest.raises(ThermalModelError, match="identify"):
        diagnosed(replace(many, hexapod=replace(many.hexapod, thermal=None)))
    still = replace(many, dT=0.0 * many.dT, plates=0.0 * many.plates, air=None, q=np.tile(many.q[:1], (40, 1)))
    with pytest.raises(DataError, match="nothing can show"):
        diagnosed(still)


@pytest.mark.long
def test_constant_temperatures_leave_what_poses_show() -> None:
    """Without any heat a joint is still found, and the answer says what could not be looked for."""
    rows = drawn(2, Fault(platform_joint=(0, (4e-6, 0.0, -4e-6))), cold=True)
    found = diagnosed(rows)
    assert [(one.cause, one.target) for one in found.effects] == [("joint-offset", "platform joint 1")]
    assert any("not looked for" in note and "leg-coefficient" in note for note in found.notes)
