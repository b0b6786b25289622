"""The viewer in a real browser: what is drawn is what was predicted, and the page needs nothing from elsewhere."""

from __future__ import annotations

import io
import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import hexathermal as ht
from hexathermal.cli import main
from hexathermal.errors import ArgumentError, FileFormatError
from hexathermal.learn.campaign_files import load_campaign
from hexathermal.learn.hexapod_validation import validate_hexapod
from hexathermal.machine.leg_terms import LegTerm
from hexathermal.machine.thermal import LegLaw
from hexathermal.predict.pose_errors import pose_errors
from hexathermal.show.viewer import magnification, palette, temperature_range, viewer_page
from hexathermal.show.viewer_campaign import campaign_course
from hexathermal.show.viewer_course import Course, still_course, temperatures_course, tool_errors
from hexathermal.show.viewer_day import day_course
from hexathermal.show.viewer_solids import machine_parts

TOOL = np.array([0.0, 0.0, 0.12])
TEMPS = np.array([[20.0] * 6, [22.0, 21.0, 22.0, 23.0, 24.0, 25.0], [24.0] * 6])


def silent(_done: int, _total: int, _label: str) -> None:
    """Show no progress."""


@pytest.fixture(scope="module")
def hexapod() -> ht.Hexapod:
    return ht.load_hexapod("reference")


@pytest.fixture(scope="module")
def course(hexapod: ht.Hexapod) -> Course:
    return temperatures_course(hexapod, hexapod.home, TEMPS, np.array([0.0, 60.0, 120.0]), TOOL, silent)


@pytest.fixture
def opened(window: Callable[..., Any], tmp_path: Path) -> Callable[..., Any]:
    """Open a page of the viewer; it is there when it has told its state."""

    def open_page(html: str, width: int = 1000, scheme: str = "light") -> Any:
        file = tmp_path / "page.html"
        file.write_text(html, encoding="utf-8")
        page = window(file.as_uri(), width, scheme, 700)
        page.wait_for_function("window.viewerState !== undefined")
        return page

    return open_page


def pixels(page: Any) -> np.ndarray:
    """Return what the drawing shows, (rows, columns, 3)."""
    from PIL import Image

    page.wait_for_timeout(150)
    return np.asarray(Image.open(io.BytesIO(page.locator("#pane").screenshot())).convert("RGB")).astype(float)


def state(page: Any) -> dict[str, Any]:
    """Return what the page draws, as its own program tells it."""
    found: dict[str, Any] = page.evaluate("viewerState()")
    return found


def slide(page: Any, frame: int) -> None:
    """Move the slider as a hand does."""
    page.locator("#time").evaluate("(one, k) => { one.value = k; one.dispatchEvent(new Event('input')); }", frame)


def test_the_poses_are_those_that_predict_gives(hexapod: ht.Hexapod, course: Course) -> None:
    """Errors are those of `predicted_pose` of nominal and of corrected lengths, at the tool point."""
    nominal = hexapod.predicted_pose(hexapod.inverse_kinematics(hexapod.home), TEMPS)
    arm = nominal[:, :3, :3] @ TOOL - hexapod.home[:3, :3] @ TOOL
    expected = pose_errors(hexapod.home, nominal) + np.hstack([arm, np.zeros((3, 3))])
    assert np.abs(course.errors[0] - expected).max() < 1e-15
    assert course.shift[0, 2] > 1e-6
    assert np.abs(course.errors[1]).max() < 1e-12


def test_the_ellipsoid_is_the_budgets(hexapod: ht.Hexapod, course: Course) -> None:
    """Semi-axes span k^2 V of the tool point, with k of the 95 % region of three numbers."""
    budget = hexapod.error_budget(hexapod.home, TEMPS[1], at_tool=TOOL)
    spanned = course.regions[1, 1] @ course.regions[1, 1].T
    assert spanned == pytest.approx(7.8147 * budget.covariance[:3, :3], rel=1e-4, abs=1e-18)
    assert course.centres[1, 1] == pytest.approx(budget.remaining[:3], abs=1e-15)
    assert np.linalg.det(course.regions[1, 1]) > 0.0


def test_a_legs_colour_is_that_of_the_leg_that_is_warm(hexapod: ht.Hexapod) -> None:
    """Exchanged thermometers are put right."""
    model = replace(hexapod.thermal, thermometers_of_leg=(1, 2, 4, 3, 5, 6))
    swapped = replace(hexapod, thermal=model)
    shown = temperatures_course(swapped, swapped.home, np.array([[20.0, 21, 22, 23, 24, 25]]), None, TOOL, silent)
    assert shown.legs_degC.tolist() == [[20.0, 21.0, 23.0, 22.0, 24.0, 25.0]]


@pytest.mark.parametrize("term", [
    LegTerm("thermal-lag", "lag", {"sensor": "T1", "ratio": 0.5, "time_constant_s": 900.0}, [1e-6]),
    LegTerm("backlash", "direction", {}, [0.3e-6]),
])  # fmt: skip
def test_laws_that_remember_are_drawn_in_the_order_of_time(hexapod: ht.Hexapod, term: LegTerm) -> None:
    """The same temperatures drift otherwise later; without times they are refused; the ellipsoid says what it lacks."""
    law = hexapod.thermal.legs[0]
    machine = replace(
        hexapod, thermal=replace(hexapod.thermal, legs=(LegLaw(law.sensors, law.A, law.B, terms=(term,)),) * 6)
    )
    temps, lags = np.array([[20.0] * 6, [24.0] * 6, [24.0] * 6]), term.cause == "thermal-lag"
    shown = temperatures_course(machine, machine.home, temps, np.array([0.0, 60.0, 3600.0]), TOOL, silent)
    later = np.abs(shown.errors[0, 2] - shown.errors[0, 1]).max()
    assert (later > 1e-7) == lags
    assert any("without thermal-lag" in note for note in shown.notes) == lags
    assert np.isfinite(shown.regions).all()
    assert np.abs(shown.errors[1]).max() < 1e-9
    with pytest.raises(ArgumentError, match="add time_s"):
        temperatures_course(machine, machine.home, temps, None, TOOL, silent)


@pytest.mark.long
def test_the_day_is_simulated_and_stays_within_its_region(hexapod: ht.Hexapod) -> None:
    """Correction takes most of the drift away; what is left lies in the budget's region in nearly all frames."""
    day = day_course(hexapod, None, TOOL, 1, silent)
    assert day.shift[1].max() < 0.3 * day.shift[0].max()
    inside = [np.linalg.norm(np.linalg.solve(axes, error[:3] - centre)) <= 1.0
              for axes, error, centre in zip(day.regions[1], day.errors[1], day.centres[1], strict=True)]  # fmt: skip
    assert np.mean(inside) > 0.9
    assert np.ptp(day.ideal[:, 0, 3]) > 0.05
    held = day_course(hexapod, hexapod.home, TOOL, 1, silent)
    assert not np.ptp(held.ideal, axis=0).any()


def test_a_campaign_shows_what_was_measured_and_what_the_law_leaves(tmp_path: Path) -> None:
    """Errors before and after are those of the validation; runs follow each other, trails begin anew."""
    where = tmp_path / "campaign"
    assert main(["simulate", "machine", "--out", str(where), "--runs", "1", "--validation", "1", "--rows", "12"]) == 0
    machine = ht.load_hexapod(where / "hexapod.toml")
    shown = campaign_course(machine, load_campaign(where), np.zeros(3), silent)
    truth = validate_hexapod(machine, load_campaign(where), "validation")
    held = np.array(["(validation)" in label for label in shown.labels])
    assert held.sum() == len(truth.rows)
    assert np.abs(shown.errors[0, held] - truth.before).max() < 1e-12
    assert np.abs(shown.errors[1, held] - truth.after).max() < 1e-12
    assert len(set(shown.group)) == 2
    assert np.abs(shown.legs_degC[held] - (truth.rows.zero_degC + truth.rows.dT)[:, :, 0]).max() < 1e-9


def test_every_part_of_the_machine_is_drawn_where_it_is(hexapod: ht.Hexapod) -> None:
    """Bodies hang on base joints, rods on platform joints, in their diameters; they overlap along the leg."""
    parts = {part.name: part for part in machine_parts(hexapod)}
    assert len(parts) == 16
    assert np.ptp(parts["leg1_body"].vertices[:, :2], axis=0).max() == pytest.approx(
        hexapod.bodies.leg_body_diameter, rel=0.01
    )
    assert parts["leg1_body"].vertices[:, 2].min() == pytest.approx(0.0, abs=1e-9)
    assert parts["leg1_rod"].vertices[:, 2].max() == pytest.approx(0.0, abs=1e-9)
    reach = parts["leg1_body"].vertices[:, 2].max() - parts["leg1_rod"].vertices[:, 2].min()
    assert reach > hexapod.home_lengths[0]


def test_a_folders_own_meshes_are_drawn(hexapod: ht.Hexapod, tmp_path: Path) -> None:
    """Millimetres become metres; other parts stay derived; what is no mesh, or of no part, is refused."""
    import trimesh

    place = tmp_path / "meshes"
    place.mkdir()
    trimesh.creation.box((300.0, 200.0, 50.0)).export(place / "platform.stl")
    trimesh.creation.box((60.0, 60.0, 500.0)).export(place / "body.stl")
    parts = {part.name: part for part in machine_parts(hexapod, tmp_path)}
    assert np.ptp(parts["platform"].vertices, axis=0) == pytest.approx([0.3, 0.2, 0.05])
    assert np.ptp(parts["leg6_body"].vertices, axis=0) == pytest.approx([0.06, 0.06, 0.5])
    assert "platform_joints" not in parts
    assert "base_joints" in parts
    (place / "rod.stl").write_text("no mesh")
    with pytest.raises(FileFormatError, match=r"rod\.stl.*cannot be read|holds no triangles"):
        machine_parts(hexapod, tmp_path)
    (place / "rod.stl").rename(place / "arm.stl")
    with pytest.raises(ArgumentError, match="named after no part"):
        machine_parts(hexapod, tmp_path)


def test_the_magnification_makes_a_drift_seen(course: Course) -> None:
    """The largest drift is drawn between 2 and 15 % of a leg; a machine without drift is drawn as it is."""
    share = magnification(course) * course.shift.max() / course.hexapod.home_lengths.mean()
    assert 0.02 < share <= 0.15
    plain = ht.load_hexapod("rubin-camera")
    assert magnification(still_course(plain, plain.home, TOOL)) == 1.0
    with pytest.raises(ArgumentError, match="from 1 to 1e7"):
        viewer_page(course, magnify=0.5)


@pytest.mark.long
def test_the_picture_is_not_blank_and_offline(course: Course, opened: Callable[..., Any]) -> None:
    """The machine covers part of the drawing, at desk and phone width, light and dark; the page is below 3 MB."""
    html = viewer_page(course)
    assert len(html.encode()) < 3e6
    for width, scheme in ((1000, "light"), (360, "dark")):
        page = opened(html, width, scheme)
        shown = pixels(page)
        ground = np.median(shown[:, :8], axis=1)[:, None]
        assert 0.05 < (np.abs(shown - ground).max(axis=2) > 30.0).mean() < 0.8
        assert page.evaluate("document.documentElement.scrollWidth") <= width


@pytest.mark.long
def test_the_legend_is_right(course: Course, opened: Callable[..., Any]) -> None:
    """Ticks span the range of all frames, colours are the palette's, each leg tells its temperature and wears it."""
    page = opened(viewer_page(course))
    slide(page, 1)
    low, high = temperature_range(course) or (0.0, 0.0)
    assert (low, high) == (20.0, 25.0)
    ticks = page.locator("#ticks span").all_text_contents()
    assert [float(tick) for tick in ticks] == pytest.approx(np.linspace(low, high, 5), abs=0.051)
    assert page.locator("#legs li").all_text_contents() == [f"{k + 1}: {t:.1f}" for k, t in enumerate(TEMPS[1])]
    expected = [np.interp((t - low) / (high - low) * 31, range(32), channel) for t in TEMPS[1]
                for channel in np.array(palette()).T]  # fmt: skip
    dots = page.locator("#legs .dot").evaluate_all("all => all.map(one => getComputedStyle(one).backgroundColor)")
    found = [int(part) for dot in dots for part in dot[4:-1].split(",")]
    assert found == pytest.approx(255.0 * np.array(expected), abs=1.0)
    drawn = np.array(state(page)["colours"])
    assert drawn / drawn.max() == pytest.approx(np.reshape(expected, (6, 3)) / np.max(expected), abs=0.01)
    assert "°C" in page.locator("#legend-title").inner_text()


@pytest.mark.long
def test_the_slider_moves_the_drawn_platform(course: Course, opened: Callable[..., Any]) -> None:
    """The platform is drawn its error times the stated factor away, the picture changes, and the words follow."""
    page = opened(viewer_page(course, magnify=20000))
    pictures, places = [], []
    for frame in (0, 2):
        slide(page, frame)
        pictures.append(pixels(page))
        places.append(state(page))
        assert page.locator("#label").inner_text() == course.labels[frame]
        assert page.locator("#shift").inner_text() == f"{course.shift[0, frame] * 1e6:.2f} µm"
    assert "20 000 times larger" in page.locator("#stated").inner_text().replace("\u202f", " ")
    moved = np.array(places[1]["drawn"]) - np.array(places[0]["drawn"])
    assert moved == pytest.approx(20000 * course.errors[0, 2, :3], rel=1e-3, abs=1e-4)
    assert (np.abs(pictures[1] - pictures[0]).max(axis=2) > 30.0).mean() > 0.01


@pytest.mark.long
def test_two_temperatures_give_two_colours(hexapod: ht.Hexapod, opened: Callable[..., Any]) -> None:
    """Legs at the cold and at the hot end differ on the screen, and only legs' own pixels do."""
    temps = np.array([[20.0] * 6, [30.0] * 6])
    still = temperatures_course(hexapod, hexapod.home, temps, None, TOOL, silent)
    page = opened(viewer_page(replace(still, errors=np.zeros((2, 2, 6)))))
    pictures = []
    for frame in (0, 1):
        slide(page, frame)
        pictures.append(pixels(page))
    cold, hot = pictures
    legs = np.abs(hot - cold).max(axis=2) > 60.0
    assert 0.01 < legs.mean() < 0.3
    assert np.median(cold[legs][:, 2]) > np.median(cold[legs][:, 1])  # blue above green: dark violet
    assert np.median(hot[legs][:, 1]) > 2.0 * np.median(hot[legs][:, 2])  # green far above blue: yellow


@pytest.mark.long
def test_the_switch_shows_what_correction_does(course: Course, opened: Callable[..., Any]) -> None:
    """Corrected legs put the platform on the ghost; the magnification asked for is drawn and stated."""
    page = opened(viewer_page(course))
    slide(page, 2)
    page.locator("input[name=way][value='1']").check()
    there = state(page)
    assert there["tool"] == pytest.approx(there["wanted"], abs=1e-6)
    assert page.locator("#shift").inner_text() == "0.00 µm"
    page.locator("input[name=way][value='0']").check()
    page.locator("#magnify").fill("1000")
    apart = np.subtract(state(page)["tool"], state(page)["wanted"])
    assert apart == pytest.approx(1000 * course.errors[0, 2, :3], rel=1e-4, abs=1e-7)


@pytest.mark.long
def test_play_runs_to_the_end_and_pause_stops(course: Course, opened: Callable[..., Any]) -> None:
    """Play goes on by itself from where it stands; Pause stops it; keys move the slider."""
    page = opened(viewer_page(course))
    slide(page, 0)
    page.locator("#play").click()
    page.wait_for_function("viewerState().frame === 2 && !viewerState().playing")
    assert page.locator("#play").inner_text() == "Play"
    press = "() => { const one = document.getElementById('play'); one.click(); return one.textContent; }"
    first, second = page.evaluate(f"[({press})(), ({press})()]")  # at once: three frames are over soon
    assert (first, second) == ("Pause", "Play")
    assert not state(page)["playing"]
    slide(page, 0)
    page.locator("#time").press("ArrowRight")
    assert state(page)["frame"] == 1


@pytest.mark.long
def test_a_machine_without_law_is_drawn_without_drift(opened: Callable[..., Any]) -> None:
    """No numbers are shown that nobody knows; nothing on the page, its legend and its description speak of a drift."""
    plain = ht.load_hexapod("rubin-camera")
    page = opened(viewer_page(still_course(plain, plain.home, np.zeros(3))))
    assert "magnified" not in page.inner_text("aside") + str(page.get_attribute("#pane", "aria-label"))
    assert "the machine as it is drawn" in page.inner_text("aside")
    assert not page.locator("#shift").is_visible()
    assert not page.locator("#magnify").is_visible()
    assert np.ptp(pixels(page)) > 100.0


def test_a_name_cannot_become_part_of_the_page(course: Course) -> None:
    """Names are escaped where they are words, and cannot end a script."""
    odd = replace(course, hexapod=replace(course.hexapod, name="</script><b>x"), title="<i>day</i>")
    html = viewer_page(odd)
    assert "<b>x" not in html.replace("<\\/script><b>x", "")
    assert "<i>day" not in html


def test_the_command_writes_a_page_and_says_what_it_shows(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:  # fmt: skip
    """Measured temperatures become a page; its numbers come as JSON; a page that exists is kept."""
    file, temps = tmp_path / "page.html", tmp_path / "temps.csv"
    header = ",".join(f"leg{leg}_T1_degC" for leg in range(1, 7))
    temps.write_text(f"{header}\n" + "".join(",".join(map(str, row)) + "\n" for row in TEMPS))
    words = ["view", "--temps", str(temps), "--at-tool", "-5,0,120", "--save", str(file)]
    assert main([*words, "--json", "-"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["frames"] == 3
    assert told["range_degC"] == [20.0, 25.0]
    assert told["tool_point_mm"] == [-5.0, 0.0, 120.0]
    assert file.read_text(encoding="utf-8").startswith("<!DOCTYPE html>")
    assert main(words) == 2
    assert "exists already" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "code", "said"),
    [
        (["--machine", "refrence"], 2, "did you mean 'reference'"),
        (["--temps", "{bad}"], 3, "leg6_T1_degC is missing"),
        (["--temps", "{hot}"], 3, "leg6_T1 in row 2 is 95 degC, outside"),
        (["--temps", "{none}"], 2, "is not there"),
        (["--campaign", "{none}"], 2, "no campaign at"),
        (["--campaign", "{leg}"], 2, "of kind 'component'"),
        (["--machine", "rubin-m2", "--temps", "{hot}"], 2, "has no thermal law"),
        (["--pose", "500", "0", "0", "0", "0", "0"], 4, "out of stroke"),
        (["--pose", "5", "0"], 2, "--pose takes 6"),
        (["--at-tool", "1e9", "0", "0"], 2, "--at-tool 1e9 0 0 is more than 1000 m from the platform's origin"),
        (["--magnify", "0"], 2, "from 1 to 1e7"),
        (["--no-browser"], 2, "leave them out with --save"),
    ],
)
def test_wrong_input_is_told(
    words: list[str], code: int, said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:  # fmt: skip
    """Each says what is wrong, ends with the documented code, and writes nothing."""
    names = [f"leg{leg}_T1_degC" for leg in range(1, 7)]
    files = {key: tmp_path / f"{key}.csv" for key in ("bad", "hot", "none")}
    files["leg"] = tmp_path / "leg" / "campaign.toml"
    files["leg"].parent.mkdir()
    files["bad"].write_text(",".join(names[:5]) + "\n20,20,20,20,20\n")
    files["hot"].write_text(",".join(names) + "\n20,20,20,20,20,20\n20,20,20,20,20,95\n")
    (tmp_path / "leg" / "r.csv").write_text("time_s,T1_degC,drift_um\n0,20,0\n60,21,1\n")
    files["leg"].write_text(
        'format = "hexathermal-campaign/1"\nkind = "component"\n[[runs]]\nname = "r"\nfile = "r.csv"\n'
        'role = "identification"\n[[thermocouples]]\nname = "T1"\n'
    )
    out = tmp_path / "page.html"
    assert main(["view", *(word.format(**files) for word in words), "--save", str(out)]) == code
    assert said in capsys.readouterr().err
    assert not out.exists()


def test_errors_of_a_point_are_those_of_the_points() -> None:
    """The shift of the tool point is the difference of where it is and where it is wanted."""
    rng = np.random.default_rng(3)
    wanted, reached = (ht.pose_from_coordinates(rng.uniform(-3.0, 3.0, (4, 6))) for _ in range(2))
    there, here = (poses[:, :3, :3] @ TOOL + poses[:, :3, 3] for poses in (reached, wanted))
    assert np.abs(tool_errors(wanted, reached, TOOL)[:, :3] - (there - here)).max() < 1e-15
