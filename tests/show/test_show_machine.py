"""``show-machine`` tells everything that extends a machine."""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path

import numpy as np
import pytest

import hexathermal as ht
from hexathermal.cli import main
from hexathermal.learn.leg_law_files import write_leg_law
from tests.extended_machines import SCREW, SLACK, extended_machine
from tests.learn.extended_laws import EXAMPLES, law_with, terms_of


def test_extensions_are_told(tmp_path: Path, rng: np.random.Generator, capsys: pytest.CaptureFixture[str]) -> None:
    """The JSON gives payload, exchange, measuring frame, terms and standard uncertainties back as the machine has them;
    the tables name each of them.
    """
    machine = extended_machine(rng, (SCREW, SLACK))
    legs = list(machine.thermal.legs)
    legs[0] = dataclasses.replace(legs[0], covariance=np.diag([1e-16, 4e-16, 9e-16, 1.6e-15]))
    machine = dataclasses.replace(machine, thermal=dataclasses.replace(machine.thermal, legs=tuple(legs)))
    ht.write_hexapod(machine, tmp_path)
    assert main(["show-machine", str(tmp_path), "--json"]) == 0
    facts = json.loads(capsys.readouterr().out)
    soft, frame, thermal = facts["compliance"], facts["measuring_frame"], facts["thermal"]
    assert soft["leg_um_per_N"] == pytest.approx(machine.compliance.leg_compliance * 1e6, rel=1e-12)
    assert soft["payload_kg"] == machine.compliance.payload_mass
    assert soft["payload_centre_mm"] == pytest.approx(machine.compliance.payload_centre * 1e3, rel=1e-12)
    assert (soft["leg_std_um_per_N"], soft["payload_std_kg"]) == (pytest.approx(1e-3), 0.25)
    assert frame["sensor"] == "air_temperature"
    assert frame["turn_urad_per_K"] == pytest.approx(machine.measuring_frame.turn * 1e6, rel=1e-12)
    assert thermal["thermometers_of_leg"] == list(machine.thermal.thermometers_of_leg)
    assert thermal["legs"][0]["A_std_um_per_m_K"] == pytest.approx([0.01, 0.02])
    assert thermal["legs"][0]["B_std_um_per_m_K"] == pytest.approx([0.03, 0.04])
    assert thermal["legs"][1]["A_std_um_per_m_K"] is None
    assert (thermal["platform"]["expansion_std_um_per_m_K"], thermal["base"]["expansion_std_um_per_m_K"]) == (0.3, None)
    terms = thermal["legs"][2]["terms"]
    assert [term["cause"] for term in terms] == ["periodic-screw-error", "leg-backlash"]
    assert (terms[0]["pitch_mm"], terms[1]["amplitudes"]) == (2.03, [1.2])
    assert terms[1]["amplitudes_std"] == pytest.approx([np.sqrt(1e-15) * 1e6])
    assert main(["show-machine", str(tmp_path)]) == 0
    said = capsys.readouterr().out
    one, two = sorted(k + 1 for k, own in enumerate(machine.thermal.thermometers_of_leg) if own != k + 1)
    for words in (f"leg {one} by those of leg {two}", "air_temperature; commands do not", "std of A", "leg-backlash",
                  "pitch_mm 2.03", f"{machine.compliance.payload_mass:.5g} kg, standard uncertainty 0.25 kg",
                  "expansion 11 um/m/K, standard uncertainty 0.3, sensor T1"):  # fmt: skip
        assert words in said, words


def test_a_machine_without_extensions_tells_none(capsys: pytest.CaptureFixture[str]) -> None:
    """Nothing is said of what a machine does not have; the JSON says so with null."""
    assert main(["show-machine", "reference", "--json"]) == 0
    facts = json.loads(capsys.readouterr().out)
    assert facts["compliance"] is facts["measuring_frame"] is None
    assert facts["thermal"]["thermometers_of_leg"] == [1, 2, 3, 4, 5, 6]
    assert main(["show-machine", "reference"]) == 0
    said = capsys.readouterr().out
    assert not any(word in said for word in ("payload", "measuring frame", "thermometers as recorded", "std of"))


def test_terms_of_every_shape_are_shown(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A machine may have any term that a leg's law may have, a reading that others foretell with weights among them."""
    shapes = set(EXAMPLES) - {"time", "tilt", "air-index", "room"}  # of the bench, not of the leg
    terms = tuple(term for shape in sorted(shapes) for term in terms_of(shape))
    write_leg_law(law_with(terms), tmp_path / "leg.toml")
    folder = tmp_path / "machine"
    assert main(["apply", str(tmp_path / "leg.toml"), "--machine", "reference", "--out", str(folder)]) == 0
    capsys.readouterr()
    assert main(["show-machine", str(folder)]) == 0
    said = capsys.readouterr().out
    assert [shape for shape in shapes if f" {shape}" not in said] == []
    assert "weights T02 +0.4 T03 +0.7" in said
    assert main(["show-machine", str(folder), "--json"]) == 0
    shown = json.loads(capsys.readouterr().out)["thermal"]["legs"][0]["terms"]
    assert {"T02": 0.4, "T03": 0.7} in [term.get("weights") for term in shown]
