"""leg.toml with terms and repairs: written and read without loss; every bad field is named with its place."""

from __future__ import annotations

import dataclasses
import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hexathermal.errors import FileFormatError
from hexathermal.learn.law import IdentifiedLaw
from hexathermal.learn.leg_law_files import read_leg_law, write_leg_law
from hexathermal.machine.leg_repairs import SensorRepair
from hexathermal.machine.leg_states import sensors_of
from hexathermal.machine.leg_terms import SHAPES, LegTerm
from tests.learn.extended_laws import EXAMPLES, REPAIRS, drawn_signals, law_with
from tests.learn.test_leg_files import drawn

LATE = {"sensor": "T01", "weights": {"T02": 0.5}, "from_s": {"run 1": 1200.5}}
LOOSE = {"sensor": "T02", "share": 0.125, "from_s": {"run 1": 600.0, "run 2": 0.0}, "air_above_K": {"run 1": -0.7}}
REPAIRED = (
    *REPAIRS,
    SensorRepair("sensor-detached", "detached", LATE),
    SensorRepair("sensor-detached", "loose", LOOSE),
)


def extended(seed: int, shapes: list[str], kind: str, joint: bool) -> IdentifiedLaw:
    """Return a drawn law with terms of the shapes, numbers of all digits."""
    rng = np.random.default_rng(seed)
    terms = []
    for shape in shapes:
        cause, parameters, amplitudes = EXAMPLES[shape][int(rng.integers(len(EXAMPLES[shape])))]
        sizes = np.array(amplitudes) * rng.normal(size=len(amplitudes))
        root = rng.normal(size=(len(sizes), len(sizes))) * 1e-7
        # an index of air is one and a little
        least = {key: float(key == "reference_index") for key in parameters}
        own = {key: least[key] + (value - least[key]) * rng.uniform(0.5, 2.0) if isinstance(value, float) else value
               for key, value in parameters.items()}  # fmt: skip
        terms.append(LegTerm(cause, shape, own, sizes, root @ root.T if rng.random() < 0.7 else np.zeros((0, 0))))
    law = dataclasses.replace(drawn(seed, kind, 2), terms=tuple(terms), repairs=REPAIRED[: seed % 8])
    root = rng.normal(size=law.whole_covariance.shape) * 1e-8
    return dataclasses.replace(law, joint_covariance=root @ root.T) if joint else law


def assert_same(one: IdentifiedLaw, other: IdentifiedLaw) -> None:
    """Terms, repairs and joint covariance are the same to the last bit."""
    assert one.repairs == other.repairs
    assert len(one.terms) == len(other.terms)
    for a, b in zip(one.terms, other.terms, strict=True):
        assert (a.cause, a.shape, a.parameters) == (b.cause, b.shape, b.parameters)
        assert np.array_equal(a.amplitudes, b.amplitudes)
        assert np.array_equal(a.covariance, b.covariance)
    assert (one.joint_covariance is None) == (other.joint_covariance is None)
    if one.joint_covariance is not None and other.joint_covariance is not None:
        assert np.array_equal(one.joint_covariance, other.joint_covariance)


@given(
    seed=st.integers(0, 10**6), kind=st.sampled_from(["leg", "component"]), joint=st.booleans(),
    shapes=st.lists(st.sampled_from(sorted(EXAMPLES)), max_size=4),
)  # fmt: skip
def test_terms_survive_writing_and_reading_to_the_last_bit(
    tmp_path_factory: pytest.TempPathFactory, seed: int, kind: str, joint: bool, shapes: list[str]
) -> None:
    """Every shape, every repair, the joint covariance."""
    law = extended(seed, shapes, kind, joint)
    assert_same(law, read_leg_law(write_leg_law(law, tmp_path_factory.mktemp("law") / "leg.toml")))


def test_repairs_of_some_runs_survive_writing_and_reading(tmp_path: Path) -> None:
    """Runs whose plugs are exchanged, runs with rates of their own; a rate that is no number is named."""
    repairs = (
        SensorRepair("swapped-sensors", "swap", {"first": "T01", "second": "T02", "not_in": ["run-07"]}),
        SensorRepair(
            "sensor-drift", "drift", {"sensor": "T01", "rate_K_per_h": 0.1 / 3.0, "rates_K_per_h": {"run 1": 1e-17}}
        ),
    )
    law = law_with((), repairs)
    path = write_leg_law(law, tmp_path / "leg.toml")
    assert_same(law, read_leg_law(path))
    text = path.read_text(encoding="utf-8")
    path.write_text(text.replace('"run 1" = ', '"run 1" = "x" # '), encoding="utf-8")
    with pytest.raises(FileFormatError, match="repairs\\[1\\].rates_K_per_h.run 1 must be a number"):
        read_leg_law(path)


@pytest.mark.parametrize(
    ("term", "old", "new", "said"),
    [
        (LegTerm("missing-sensor", "temperature", {"sensor": "T03", "ratio": 0.3, "weights": {"T02": 0.7}}, [1e-6]),
         "T02 = 0.7", "", "terms[0].weights must be those of one sensor or more"),
        (LegTerm("nonlinear-expansion", "square", {"sensor": "T03", "ratio": 0.3, "weights": {"T02": 0.7}}, [1e-9]),
         "T02 = 0.7", "", "terms[0].weights must be those of one sensor or more"),
        (LegTerm("nonlinear-expansion", "square", {"sensor": "T03", "ratio": 0.3, "weights": {"T02": 0.7}}, [1e-9]),
         "T02 = 0.7", "T02 = -0.7", "terms[0].weights must be parts of the length: 0 or more, one of them above 0"),
        (LegTerm("frame-expansion", "room", {"time_constant_s": 900.0, "order": 2.0}, [1e-7]),
         "order = 2", "order = 3", "terms[0].order must be 1 or 2, found 3"),
    ],
)  # fmt: skip
def test_bad_weights_and_orders_are_named(tmp_path: Path, term: LegTerm, old: str, new: str, said: str) -> None:
    """Weights of nobody, a third stage: what, where, and what it may be."""
    path = write_leg_law(law_with((term,)), tmp_path / "leg.toml")
    text = path.read_text(encoding="utf-8")
    assert old in text
    path.write_text(text.replace(old, new), encoding="utf-8")
    with pytest.raises(FileFormatError, match=re.escape(said)):
        read_leg_law(path)


def test_a_law_reads_no_sensor_whose_weight_it_does_not_state(tmp_path: Path) -> None:
    """Where others stand for a thermometer, its own readings are not asked for: it may be gone."""
    told = LegTerm("missing-sensor", "temperature", {"sensor": "T03", "ratio": 0.3, "weights": {"T02": 1.1}}, [1e-6])
    assert sensors_of((told,)) == ("T02",)
    law = read_leg_law(write_leg_law(law_with((told,)), tmp_path / "leg.toml"))
    signals = drawn_signals(1)
    without = dataclasses.replace(signals, dT={name: values for name, values in signals.dT.items() if name != "T03"})
    np.testing.assert_array_equal(law.predict_signals(without), law.predict_signals(signals))


def test_a_shape_without_rules_is_carried_too(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A shape that somebody adds needs no change of the files: texts, numbers, lengths in mm."""
    monkeypatch.setitem(SHAPES, "bump", lambda signals, parameters, memory: np.exp(-(signals.q**2)))
    own = {"where_m": 0.0123456789, "width_m": 1.7e-3, "sensor": "T01", "power": 2.0, "signed": True,
           "knots_m": [0.001, 0.2], "heights": [1.5, 2.0]}  # fmt: skip
    law = law_with((LegTerm("bump", "bump", own, [np.pi * 1e-7, 2e-7]),))
    assert_same(law, read_leg_law(write_leg_law(law, tmp_path / "leg.toml")))
    assert "where_mm = 12.3456789" in (tmp_path / "leg.toml").read_text(encoding="utf-8")


BAD = [
    ('shape = "lag"', 'shape = "delay"', "terms[0].shape must be one of: lag, "),
    ('shape = "lag"\n', "", "key 'shape' is missing in [[terms[0]]]"),
    ('sensor = "T01"', 'sensors = "T01"', "unknown key 'sensors'"),
    ("time_constant_s = 900.0", "time_constant_s = 0", "terms[0].time_constant_s must be above 0, found 0"),
    ('unit = "1/K"', 'unit = "um"', "terms[0].unit of shape 'lag' must be '1/K', found 'um'"),
    ('unit = "um"', 'unit = "1"', "terms[1].unit of shape 'periodic' must be 'um'"),
    ("pitch_mm = 2.03", "pitch_mm = -2.03", "terms[1].pitch_mm must be above 0"),
    ("pitch_mm = 2.03", "pitch_m = 2.03", "unknown key 'pitch_m'"),
    ("  -0.2,\n", "", "terms[1].amplitudes has 1 values; expected 2"),
    ('kick = "move"', 'kick = "jump"', "terms[2].kick must be one of: direction, move, step"),
    ('kick = "move"', 'kick = "move"\ndecades = 7', "terms[2].decades must be 0 to 6"),
    ('kick = "move"', 'kick = "move"\nsaturation_mm = 0', "terms[2].saturation_mm must be above 0"),
    ('kick = "move"', 'kick = "move"\nrenewed = 2', "terms[2].renewed must be 0 or 1, with kick 'step' or 'begin' 0"),
    ('kick = "move"', 'kick = "begin"\nsaturation_mm = 2', "terms[2].saturation_mm must be of moves"),
    ('source = "motion"', 'source = "motion"\nsource_time_constant_s = -5', "source_time_constant_s must be 0 or more"),
    ('source = "motion"', 'source = "motion"\nsource_share = 1.2', "source_share must be 0 to 1"),
    ('kind = "swap"', 'kind = "exchange"', "repairs[0].kind must be one of: clock, swap, drift, detached"),
    ('second = "T02"\n', "", "key 'second' is missing in [repairs[0]]"),
    ("rate_K_per_h = 0.03", 'rate_K_per_h = "x"', "repairs[1].rate_K_per_h must be a number"),
    ("T03 = 0.7", 'T03 = "x"', "repairs[2].weights.T03 must be a number"),
    ("T03 = 0.7", "T02 = 0.7", "weights are those of other sensors"),
    ("T02 = 0.9", 'T02 = "y"', "terms[3].weights.T02 must be a number"),
    ("T02 = 0.9", "T01 = 0.9", "terms[3].weights must be those of other sensors"),
]  # fmt: skip


@pytest.mark.parametrize(("old", "new", "said"), BAD)
def test_each_bad_field_is_named_with_its_place(tmp_path: Path, old: str, new: str, said: str) -> None:
    """What is wrong, what was expected, line and column of it."""
    terms = (
        LegTerm("thermal-lag", "lag", {"sensor": "T01", "ratio": 0.5, "time_constant_s": 900.0}, [1e-6]),
        LegTerm("periodic-screw-error", "periodic", {"pitch_m": 0.00203}, [0.1e-6, -0.2e-6]),
        LegTerm("creep", "relaxation", {"time_constant_s": 60.0, "kick": "move"}, [0.2e-6]),
        LegTerm("thermal-lag", "foretold", {"sensor": "T01", "weights": {"T02": 0.9}, "ratio": 0.5,
                                            "time_constant_s": 901.0}, [1e-6]),
        LegTerm("hidden-heat", "stored-heat", {"source": "motion", "time_constant_s": 902.0}, [0.1]),
    )  # fmt: skip
    law = law_with(terms, (REPAIRS[0], REPAIRS[1], REPAIRS[3]))
    file = write_leg_law(dataclasses.replace(law, joint_covariance=law.whole_covariance), tmp_path / "leg.toml")
    text = file.read_text(encoding="utf-8")
    assert old in text
    changed = text.replace(old, new)
    file.write_text(changed, encoding="utf-8")
    with pytest.raises(FileFormatError) as caught:
        read_leg_law(file)
    found = [problem for problem in caught.value.problems if said in problem.message]
    assert found, str(caught.value)
    assert found[0].line > changed.count("\n", 0, changed.index("[law]"))
    assert found[0].column > 0


@pytest.mark.parametrize(("heats", "said"), [
    ({"once": [50.0]}, "terms[0].once must be as many as heat_times_s: 2"),
    ({"heat_times_s": [120.0, 120.0]}, "terms[0].heat_times_s must be times above 0, none of them twice"),
    ({"heat_times_s": [120.0, -9.0]}, "terms[0].heat_times_s must be times above 0"),
    ({"heat_times_s": 120.0, "once": 1.0, "twice": 2.0}, "terms[0].twice must be a list"),
])  # fmt: skip
def test_low_passes_of_the_speed_are_lists_of_one_length(tmp_path: Path, heats: dict[str, object], said: str) -> None:
    """A number, another count, one time twice or none above 0 is named; tuples and arrays are read back as lists."""
    own = {"sensor": "T01", "ratio": 0.5, "time_constant_s": 300.0, "heat_times_s": (120.0, 900.0),
           "once": np.array([50.0, -20.0]), "twice": [-10.0, 200.0]}  # fmt: skip
    law = law_with((LegTerm("thermal-lag", "lead-by-motion", own, [2e-6]),))
    assert read_leg_law(write_leg_law(law, tmp_path / "right.toml")).terms == law.terms
    wrong = law_with((LegTerm("thermal-lag", "lead-by-motion", own | heats, [2e-6]),))
    with pytest.raises(FileFormatError) as caught:
        read_leg_law(write_leg_law(wrong, tmp_path / "wrong.toml"))
    assert said in str(caught.value)


@pytest.mark.parametrize(("matrix", "said"), [
    ("[[1.0]]", "law.joint_covariance has shape (1, 1); expected (5, 5)"),
    (str([[float(i == j) + (i < j) for j in range(5)] for i in range(5)]), "law.joint_covariance must be symmetric"),
    (str((np.eye(5) * 3.0 - 1.0).tolist()), "law.joint_covariance has a negative eigenvalue"),
])  # fmt: skip
def test_a_bad_joint_covariance_is_named(tmp_path: Path, matrix: str, said: str) -> None:
    """Of another size, not symmetric, or no covariance."""
    law = law_with((LegTerm("backlash", "direction", {}, [1e-7]),))
    file = write_leg_law(law, tmp_path / "leg.toml")
    text = file.read_text(encoding="utf-8").replace("q0_mm", f"joint_covariance = {matrix}\nq0_mm")
    file.write_text(text, encoding="utf-8")
    with pytest.raises(FileFormatError) as caught:
        read_leg_law(file)
    assert said in str(caught.value)


def test_all_bad_terms_are_named_at_once(tmp_path: Path) -> None:
    """Two terms and a repair at fault make three complaints."""
    law = law_with((LegTerm("backlash", "direction", {}, [1e-7]),) * 2, REPAIRS[:1])
    file = write_leg_law(law, tmp_path / "leg.toml")
    text = file.read_text(encoding="utf-8").replace('unit = "um"', 'unit = "nm"').replace('first = "T01"', "first = 1")
    file.write_text(text, encoding="utf-8")
    with pytest.raises(FileFormatError) as caught:
        read_leg_law(file)
    assert len(caught.value.problems) == 3
    assert len({problem.line for problem in caught.value.problems}) == 3


def test_the_terms_of_the_formats_page_are_read(tmp_path: Path) -> None:
    """The example of the page, put behind a law, is read as it stands there."""
    page = Path(__file__).parents[2] / "docs" / "formats.md"
    examples = [part.split("```")[0] for part in page.read_text(encoding="utf-8").split("```toml\n")[1:]]
    example = next(text for text in examples if "[[terms]]" in text)
    file = write_leg_law(law_with(), tmp_path / "leg.toml")
    file.write_text(file.read_text(encoding="utf-8") + example, encoding="utf-8")
    law = read_leg_law(file)
    assert law.terms[0].parameters["time_constant_s"] == 1200.0
    assert law.repairs[0].parameters["from_s"] == {"run-03": 5400.0, "run-04": 0.0}


def test_from_which_side_runs_of_the_bench_began_stays_on_the_bench() -> None:
    """A leg carries its backlash to a machine, and how the bench reached its first positions is not known there."""
    law = law_with((LegTerm("backlash", "direction", {"approach": 1.0, "play_m": 0.001}, [1e-7], [[1e-18]]),))
    (carried,) = law.leg_law().terms
    assert carried.parameters == {"play_m": 0.001}
    assert carried.amplitudes.tolist() == [1e-7]
    assert carried.covariance.tolist() == [[1e-18]]
