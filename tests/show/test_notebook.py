"""What notebooks show: well-formed, accessible, escaped, in the page's own colours, with the right numbers."""

from __future__ import annotations

import re
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as ET

import numpy as np
import pytest

import hexathermal as ht
from hexathermal.learn.hexapod_data import hexapod_rows
from hexathermal.learn.hexapod_identification import identify_hexapod
from hexathermal.learn.hexapod_validation import validate_hexapod
from hexathermal.learn.identification import identify
from hexathermal.learn.validation import validate
from hexathermal.machine.shown import Shown
from hexathermal.predict.acceptance import accept, read_measured_poses, read_specification
from hexathermal.show.notebook import _DRAWN, html_of
from tests.learn.legs import LEG, SENSORS, drawn_leg
from tests.show.drawn_diagnoses import drawn, extended, plain_law
from tests.show.machine_campaigns import WIDE, moved, other_leg, written

EVIL = '<script>alert("x")</script> & Söhne'
KINDS = sorted(_DRAWN, key=lambda kind: kind.__name__)


@pytest.fixture(scope="module")
def values(tmp_path_factory: pytest.TempPathFactory) -> dict[type, Any]:
    """One value of each kind that notebooks show."""
    place = tmp_path_factory.mktemp("values")
    hexapod = ht.load_hexapod("reference")
    assert hexapod.thermal is not None
    blocks = drawn_leg(np.random.default_rng(3), runs=5, hours=2.0)
    identified = identify(lambda: iter(blocks), SENSORS, LEG)
    view, six = moved(np.random.default_rng(11), WIDE, 4, alike=False)
    campaign = ht.load_campaign(
        written(place / "machine", np.random.default_rng(11), view, six, other_leg(2, 1.2e-6), held=1)
    )
    legs = identify_hexapod(hexapod_rows(campaign, "identification"))
    (place / "spec.toml").write_text(
        'format = "hexathermal-spec/1"\n[uncertainty]\nposition_um = 0.3\n[limits]\nAP_um = 5\n'
    )
    heads = ["x_mm", "y_mm", "z_mm", "rx_deg", "ry_deg", "rz_deg"]
    row = "0,0,0,0,0,0,0.001,0,0,0,0,0\n"
    (place / "poses.csv").write_text(",".join([*heads, *(f"measured_{head}" for head in heads)]) + "\n" + 2 * row)
    found: list[Any] = [
        hexapod, hexapod.thermal, hexapod.thermal.legs[0], hexapod.error_budget(hexapod.home, [22.0] * 6), identified,
        extended(plain_law()), validate(identified.law, blocks, SENSORS), legs,
        validate_hexapod(legs.hexapod("found"), campaign), drawn(), ht.diagnose(campaign),
        accept(read_measured_poses(place / "poses.csv"), read_specification(place / "spec.toml")),
    ]  # fmt: skip
    return {type(value): value for value in found}


def parsed(value: Any) -> ET.Element:
    """Return the HTML of a value as a tree; XML is stricter than HTML: every element is closed, every text escaped."""
    return ET.fromstring(html_of(value))


def words(tree: ET.Element) -> str:
    """Return all text, spaces single."""
    return " ".join(" ".join(tree.itertext()).split())


def cells(tree: ET.Element, first: str) -> list[str]:
    """Return the cells of the row that a name heads."""
    return next(
        ["".join(cell.itertext()).replace("\N{NO-BREAK SPACE}", " ") for cell in row.findall("td")]
        for row in tree.iter("tr")
        if row.find("th") is not None and "".join(row.find("th").itertext()) == first  # type: ignore[union-attr]
    )


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.__name__)
def test_html_is_well_formed_and_every_table_has_its_names(kind: type, values: dict[type, Any]) -> None:
    """Tables have a caption, columns and rows have headers, none of them empty; wide ones scroll by keyboard."""
    tree = parsed(values[kind])
    tables = list(tree.iter("table"))
    assert tables
    for table in tables:
        assert (table.findtext("caption") or "").strip()
        heads = [*table.iter("th")]
        assert all("".join(head.itertext()).strip() and head.get("scope") in ("col", "row") for head in heads)
        assert {head.get("scope") for head in heads} == {"col", "row"}
    assert len(tables) == sum(one.get("tabindex") == "0" for one in tree.iter("div"))


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.__name__)
def test_colours_are_those_of_the_page(kind: type, values: dict[type, Any]) -> None:
    """No colour is set, so that text can be read on light and on dark pages; nothing is fetched or run."""
    html = html_of(values[kind])
    assert not re.search(r"#[0-9a-fA-F]{3,8}\b|rgba?\(|hsla?\(|:(black|white)\b", html)
    assert not re.search(r"<script|https?://|src=|url\(", html)


def test_every_value_that_says_it_is_shown_is_shown() -> None:
    """Each public value with `_repr_html_` has its tables, and no table waits for a value that never asks."""
    everything = [getattr(ht, name) for name in ht.__all__]
    asking = {one for one in everything if isinstance(one, type) and issubclass(one, Shown)}
    assert asking <= set(_DRAWN)
    assert all(issubclass(kind, Shown) for kind in _DRAWN)
    with pytest.raises(TypeError, match="a dict has no tables for a notebook; these have: Acceptance, Budget"):
        html_of({})


@pytest.mark.long
def test_a_value_draws_itself_and_importing_draws_nothing() -> None:
    """`import hexathermal` is all: the last line of a cell is a table; what draws it is loaded only then."""
    code = (
        "import sys, hexathermal as ht; hexapod = ht.load_hexapod('reference'); "
        "before = 'hexathermal.show.notebook' in sys.modules; html = hexapod._repr_html_(); "
        "print(before, html.startswith('<div class=\"hexathermal\">'))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["False", "True"]


def test_a_machine_with_wicked_names_is_escaped(values: dict[type, Any]) -> None:
    """Names of machines, sensors and campaigns come as text, never as elements."""
    hexapod = values[ht.Hexapod]
    law = ht.LegLaw(EVIL, 2e-6, 1e-6, campaign=EVIL)
    plate = ht.PlateLaw(1e-5, EVIL)
    machine = replace(hexapod, name=EVIL, source=EVIL, thermal=ht.ThermalModel(law, plate))
    for value in (machine, machine.thermal, law, machine.error_budget(machine.home, [22.0] * 7)):
        tree = parsed(value)
        assert not list(tree.iter("script"))
        assert EVIL in words(tree)
    drawing = parsed(machine).find(".//svg")
    assert drawing is not None
    assert EVIL in str(drawing.get("aria-label"))


def test_a_machine_shows_geometry_law_and_drawing(values: dict[type, Any]) -> None:
    """Lengths, coefficients and references stand with their units; the drawing has a name and twelve joints."""
    tree = parsed(values[ht.Hexapod])
    assert cells(tree, "retracted length q0") == ["600 mm"]
    assert cells(tree, "reference temperature") == ["20 °C"]
    assert cells(tree, "1 to 6")[:3] == ["T1", "1.99", "1.09"]
    assert "A µm/m/K" in words(tree)
    assert cells(tree, "1")[:3] == ["443.163", "-78.142", "-663.300"]
    drawing = tree.find("svg")
    assert drawing is not None
    assert (drawing.get("role"), drawing.get("stroke")) == ("img", "currentColor")
    assert len(list(drawing.iter("circle"))) == 12


def test_every_joint_is_drawn_within_the_drawing(hexapod: ht.Hexapod) -> None:
    """Machines of any size fill the drawing, and none leaves it."""
    for size in (1e-3, 1.0, 40.0):
        scaled = ht.Hexapod(hexapod.base_joints * size, hexapod.platform_joints * size, home=[0, 0, size * 0.3])
        drawing = parsed(scaled).find("svg")
        assert drawing is not None
        box = [float(value) for value in str(drawing.get("viewBox")).split()]
        places = np.array([[float(str(one.get(key))) for key in ("cx", "cy")] for one in drawing.iter("circle")])
        assert (places > 4.0).all()
        assert (places < np.array(box[2:]) - 4.0).all()
        assert np.ptp(places, axis=0).max() > 150.0
        assert re.search(r"\b[125]0*(e-\d+|\.?\d*)? mm", words(drawing))


def test_a_law_shows_its_uncertainty_range_and_terms(values: dict[type, Any]) -> None:
    """A, B with standard uncertainty and 95 % interval; the amplitude of a term with its own."""
    law = values[type(plain_law())]
    tree = parsed(law)
    assert cells(tree, "A T07") == ["2.0000", "0.0100", "1.9804 to 2.0196", "µm/m/K"]
    assert cells(tree, "backlash") == ["0.31", "0.02", "µm", "direction"]
    assert cells(tree, "dT of T07") == ["-2.00 to 8.00 K"]
    component = parsed(plain_law("component"))
    assert cells(component, "C T07")[-1] == "µm/K"


def test_a_machines_law_shows_what_its_covariance_says() -> None:
    """Standard uncertainties stand beside A and B where they are known, and are left out where they are not."""
    known = parsed(ht.LegLaw("T1", 2e-6, 1e-6, np.diag([4e-16, 9e-16])))
    assert cells(known, "T1")[:4] == ["2", "0.02", "1", "0.03"]
    assert "std" not in words(parsed(ht.LegLaw("T1", 2e-6, 1e-6)))


def test_a_budget_shows_bias_uncertainty_and_every_source(values: dict[type, Any]) -> None:
    """Numbers are those of the budget [um, urad]; the sources stand below each other with their sum."""
    budget = values[ht.Budget]
    tree = parsed(budget)
    for name, expected in (("drift, uncorrected", budget.uncorrected), ("bias that remains", budget.remaining),
                           ("expanded, 95 %", budget.expanded())):  # fmt: skip
        assert cells(tree, name) == [f"{value * 1e6:z.3f}" for value in expected]
    for item in budget.contributions:
        assert cells(tree, item.label)[:6] == [f"{value * 1e6:z.3f}" for value in item.uncertainty]
    assert "x µm" in words(tree)
    assert "22.00 °C" in words(tree)


def test_identification_and_validation_show_choice_verdict_and_runs(values: dict[type, Any]) -> None:
    """The reason of the choice, the coefficients, the verdict, and a row for each run and for all."""
    found = values[ht.Identification]
    tree = parsed(found)
    assert " ".join(found.choice.reason.split()) in words(tree).replace("µ", "u")
    assert cells(tree, f"A {found.law.sensors[0]}")[0] == f"{found.law.A[0] * 1e6:.4f}"
    proof = values[ht.Validation]
    tree = parsed(proof)
    assert proof.verdict.value in words(tree).lower()
    assert cells(tree, "all")[2] == f"{proof.total.rmse.value * 1e6:.3f}"


def test_a_diagnosis_shows_cause_size_gain_and_what_else_was_tried(values: dict[type, Any]) -> None:
    """The sentence comes first; parameters with uncertainty; every candidate and limit can be unfolded."""
    tree = parsed(values[ht.Diagnosis])
    first = tree.find("p")
    assert first is not None
    assert words(first) == "The residual is backlash of 0.31 ± 0.01 µm."
    assert cells(tree, "backlash")[1:5] == ["step", "0.310", "0.010", "0.290 to 0.330"]
    assert len(tree.findall("details")) == 2
    assert "a note of a < b" in words(tree)
    for verdict in ("none", "unexplained"):
        assert "Causes and their parameters" not in words(parsed(drawn(verdict, held=False)))


def test_a_machines_diagnosis_shows_the_leg(values: dict[type, Any]) -> None:
    """The leg is named in the first sentence, and the change of its coefficient stands with its uncertainty."""
    found = values[ht.MachineDiagnosis]
    tree = parsed(found)
    first = tree.find("p")
    assert first is not None
    assert words(first) == found.effects[0].sentence.replace("um", "µm").replace("urad", "µrad")
    value = found.effects[0].parameters["A_change_per_K"]
    assert abs(float(cells(tree, "leg-coefficient")[2]) - value.value * 1e6) <= value.std * 1e6


def test_the_text_of_a_finding_is_one_line(values: dict[type, Any]) -> None:
    """Terminals print the finding, not the arrays behind it."""
    for kind in (ht.Diagnosis, ht.MachineDiagnosis, ht.Identification, ht.Validation):
        text = repr(values[kind])
        assert text.startswith(f"{kind.__name__}: ")
        assert "\n" not in text
        assert len(text) < 600


NOTEBOOK = Path(__file__).resolve().parents[2] / "examples" / "hexathermal.ipynb"


def test_the_notebook_is_stored_without_outputs() -> None:
    """Outputs and counts are stripped: a difference in the repository is a difference in the notebook."""
    nbformat = pytest.importorskip("nbformat", reason="nbformat is not installed (extra 'docs')")
    notebook = nbformat.read(NOTEBOOK, as_version=4)
    nbformat.validate(notebook)
    code = [cell for cell in notebook.cells if cell.cell_type == "code"]
    assert all(not cell.outputs and cell.execution_count is None for cell in code)
    assert len({cell.id for cell in notebook.cells}) == len(notebook.cells)


@pytest.mark.long
def test_the_notebook_runs_and_shows_machine_law_budget_and_diagnoses(tmp_path: Path) -> None:
    """Every cell runs in an empty folder; each kind of value shows itself, and what was hidden is found."""
    nbformat = pytest.importorskip("nbformat", reason="nbformat is not installed (extra 'docs')")
    nbclient = pytest.importorskip("nbclient", reason="nbclient is not installed (extra 'docs')")
    pytest.importorskip("ipykernel", reason="ipykernel is not installed (extra 'docs')")
    notebook = nbformat.read(NOTEBOOK, as_version=4)
    nbclient.NotebookClient(notebook, timeout=900, resources={"metadata": {"path": str(tmp_path)}}).execute()
    shown = [output.data["text/html"] for cell in notebook.cells if cell.cell_type == "code"
             for output in cell.outputs if "text/html" in output.get("data", {})]  # fmt: skip
    texts = [words(ET.fromstring(html)) for html in shown]
    assert len(texts) == 9
    for what in ("Hexapod reference", "Error budget of reference", "Law of a leg", "Runs", "residual is backlash",
                 "residual is payload-compliance", "Terms that extend it", "Thermal model"):  # fmt: skip
        assert any(what in text for text in texts), what
    assert not any(tmp_path.iterdir())
