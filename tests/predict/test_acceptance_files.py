"""Tables of measured poses held against specifications: what is read, and every fault with line and column."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pyarrow.csv
import pyarrow.parquet
import pytest

from hexathermal.errors import ArgumentError, FileFormatError
from hexathermal.poses import Frames
from hexathermal.predict.acceptance import PASS, accept, pose_accuracy, read_measured_poses, read_specification
from tests.predict.acceptance_files import FORMAT, HEADER, MEASURED, POSE, TWO, grouped, judged, values, visits, written


def test_millimetres_and_micrometres(tmp_path: Path) -> None:
    """Visits at 1 um and 3 um: AP = 2 um, RP = 1 um; limits in um are met."""
    found = judged(tmp_path, TWO, "uncertainty = {position_um = 0.1}\nlimits = {AP_um = 3, RP_um = 1.2}\n")
    np.testing.assert_allclose(values(found), [2.0, 1.0], rtol=1e-12)
    assert found.verdict == PASS
    assert found.results[0].decision.uncertainty == pytest.approx(1e-7)


def test_expanded_uncertainty_is_divided_by_its_factor(tmp_path: Path) -> None:
    """U = 0.6 with k = 3 is u = 0.2, and U alone has the specification's k."""
    found = judged(tmp_path, TWO, "coverage_factor = 2.5\n[limits]\nAP_um = {upper = 3, U = 0.6, k = 3}\n"
                                  "RP_um = {upper = 3, U = 0.5}\n")  # fmt: skip
    assert [result.decision.uncertainty for result in found.results] == pytest.approx([0.2e-6, 0.2e-6])


def test_rows_with_the_same_command_are_one_pose(tmp_path: Path) -> None:
    """Without names, poses are P1, P2 in the order of the file; -0 and 0 are the same command."""
    commands = ("0,0,0,0,0,0", "1,0,0,0,0,0", "1,0,0,0,0,0", "-0,0,0,0,0,0")
    answers = ("0.001,0,0,0,0,0", "1,0,0,0,0,0", "1.004,0,0,0,0,0", "0.003,0,0,0,0,0")
    table = visits(*zip(commands, answers, strict=True), header=f"{POSE},{MEASURED}")  # type: ignore[arg-type]
    found = judged(tmp_path, table, 'rule = "simple"\n[limits]\nAP_um = 2.5\n')
    assert [result.pose for result in found.results] == ["P1", "P2"]
    np.testing.assert_allclose(values(found), [2.0, 2.0], rtol=1e-9)


def test_the_tool_and_the_users_axes(tmp_path: Path) -> None:
    """A platform turned by 10 urad about y moves a tool 100 mm above it by 1 um along x: the object frame shows it."""
    turned = f"0,0,0,0,{np.degrees(10e-6):.12f},0"
    table = visits(("A", "0,0,0,0,0,0", turned), ("A", "0,0,0,0,0,0", turned))
    spec = 'rule = "simple"\n[limits]\nAP_um = 9\nAP_x_um = 9\nAP_ry_urad = 20\n'
    np.testing.assert_allclose(values(judged(tmp_path, table, spec)), [0, 0, 10], atol=1e-6)
    tool = Frames(object=[0, 0, 100, 0, 0, 0])
    np.testing.assert_allclose(values(judged(tmp_path, table, spec, frames=tool)), [1, 1, 10], atol=1e-6)
    turned_axes = Frames(user=[0, 0, 0, 0, 0, 90], object=[0, 0, 100, 0, 0, 0])
    np.testing.assert_allclose(values(judged(tmp_path, table, spec, frames=turned_axes)), [1, 0, 0], atol=1e-6)


def test_a_tool_is_as_uncertain_as_turns_make_it(tmp_path: Path) -> None:
    """At the end of an arm of 500 mm, 0.3 um and 0.8 urad are 0.5 um: what passed at the platform is not decided there.

    Axes that are turned, or a user frame that is set elsewhere, change no uncertainty.
    """
    header = f"{HEADER},u_position_um,u_rotation_urad"
    table = visits(*(("A", "0,0,0,0,0,0", f"{x},0,0,0,0,0", "0.3", "0.8") for x in ("0.001", "0.001")), header=header)
    spec = "[limits]\nAP_um = 1.6\n"

    def said(frames: Frames | None) -> tuple[float, str]:
        decision = judged(tmp_path, table, spec, frames=frames).results[0].decision
        return round((decision.uncertainty or 0.0) * 1e6, 9), decision.verdict

    assert said(None) == (0.3, "pass")
    assert said(Frames(user=[100, 20, 0, 0, 30, 0], object=[0, 0, 0, 10, 20, 30])) == (0.3, "pass")
    assert said(Frames(object=[0, 300, 400, 0, 0, 0])) == (0.5, "not decided")


@pytest.mark.parametrize(
    ("header", "rest", "missing"),
    [
        (HEADER.replace(",measured_rx_deg,measured_ry_deg,measured_rz_deg", ""), (), "measured_rx_deg"),
        (f"{HEADER},u_position_um", ("0,0,0", "0.3"), "u_rotation_urad"),
    ],
    ids=["turns", "uncertainty of turns"],
)
def test_a_tool_needs_the_turns_that_move_it(tmp_path: Path, header: str, rest: tuple[str, ...], missing: str) -> None:
    """Without measured turns, or their uncertainty, nothing is said about a point that they move; the column is named.

    At the measured point itself, and seen in other axes, the same table is judged.
    """
    one = ",".join(("0.001,0,0", *rest))
    table = visits(("A", "0,0,0,0,0,0", one), ("A", "0,0,0,0,0,0", one), header=header)
    spec = "[uncertainty]\nposition_um = 0.2\n[limits]\nAP_um = 2.0\n"
    with pytest.raises(ArgumentError, match=missing):
        judged(tmp_path, table, spec, frames=Frames(object=[0, 0, 100, 0, 0, 0]))
    assert judged(tmp_path, table, spec, frames=Frames(user=[1, 2, 3, 0, 0, 90])).verdict == "pass"


def test_parquet_is_the_same(tmp_path: Path) -> None:
    """A Parquet file with the same columns gives the same values, whole numbers as names too."""
    table = visits(*[("7", "0,0,0,0,0,0", f"0.00{k},0,0,0,0,0") for k in (1, 3)])
    source = written(tmp_path, table)
    pyarrow.parquet.write_table(pyarrow.csv.read_csv(source), tmp_path / "measured.parquet")
    spec = read_specification(written(tmp_path, FORMAT + 'rule = "simple"\nlimits = {AP_um = 9}', "spec.toml"))
    one, other = (accept(read_measured_poses(tmp_path / f"measured.{kind}"), spec) for kind in ("csv", "parquet"))
    assert values(one) == values(other)
    assert other.results[0].pose == "7"


def test_groups_are_judged_one_by_one_and_drift_between_them(tmp_path: Path) -> None:
    """AP of each group, dAP = 3 um in the warm one; uncertainty from the rows, sqrt 2 times for a difference."""
    found = judged(tmp_path, grouped(), "[limits]\nAP_um = 5\ndAP_um = 4\nshift_um = 4\n")
    assert [result.group for result in found.results] == ["cold", "warm", "", ""]
    np.testing.assert_allclose(values(found), [1.0, 4.0, 3.0, 3.0], rtol=1e-9)
    u = [result.decision.uncertainty for result in found.results]
    np.testing.assert_allclose(u, np.array([0.2, 0.2, 0.2 * np.sqrt(2), 0.2 * np.sqrt(2)]) * 1e-6)
    assert "group warm" in found.results[2].detail


def test_environmental_variation_in_windows_with_its_temperatures(tmp_path: Path) -> None:
    """Two windows of the same coordinate: 2 um in 10 minutes with 1 K, 4 um in the record with 3 K."""
    spec = "[limits]\nETVE_x_um = [{upper = 9, window_s = 600, gap_s = 600}, {upper = 9}]\n"
    found = judged(tmp_path, grouped(), spec)
    np.testing.assert_allclose(values(found), [2.0, 4.0], rtol=1e-9)
    assert "room 1 K" in found.results[0].detail
    assert "room 3 K" in found.results[1].detail
    assert found.verdict == PASS


def test_a_record_with_gaps_does_not_pass(tmp_path: Path) -> None:
    """Samples as far apart as the window prove nothing: not decided, unless gap_s allows them; a fail stays one."""
    said = [judged(tmp_path, grouped(), f"[limits]\nETVE_x_um = {{upper = {top}, window_s = 600}}\n") for top in (9, 1)]
    assert [found.verdict for found in said] == ["not decided", "fail"]
    assert "gaps" in said[0].results[0].decision.note


def test_uncertainty_of_repeatability_is_a_bound(tmp_path: Path, rng: np.random.Generator) -> None:
    """Noise u of each coordinate scatters RP of n visits by u sqrt(1/n + 9/(n-1)) at most, which a line nears."""
    found = judged(tmp_path, grouped(), "[limits]\nRP_um = 5\n")
    assert found.results[0].decision.uncertainty == pytest.approx(0.2e-6 * np.sqrt(0.5 + 9.0))
    for count, least in ((2, 0.1), (4, 0.1), (10, 0.8), (30, 0.8)):
        places = np.broadcast_to(np.eye(4), (500, count, 4, 4)).copy()
        places[:, :, :3, 3] = rng.normal(size=(500, count, 3)) + [[20.0 * k, 0, 0] for k in range(count)]
        scatter = float(np.std([pose_accuracy(each, np.eye(4)).RP for each in places]))
        bound = np.sqrt(1.0 / count + 9.0 / (count - 1))
        assert least * bound < scatter < 1.1 * bound


def test_each_pose_has_its_own_uncertainty_and_limits_their_poses(tmp_path: Path) -> None:
    """The largest uncertainty of a pose's own rows counts; a limit for one pose says nothing of another."""
    rows = [(f"{u}", pose, "0,0,0,0,0,0", "0.001,0,0,0,0,0") for pose, u in
            (("A", 0.1), ("A", 0.2), ("B", 0.4), ("B", 0.3))]  # fmt: skip
    table = visits(*rows, header=f"u_position_um,{HEADER}")  # type: ignore[arg-type]
    found = judged(tmp_path, table, "[limits]\nAP_um = [{upper = 5}, {upper = 9, poses = ['B']}]\n")
    assert [(item.pose, item.decision.uncertainty) for item in found.results] == [
        ("A", pytest.approx(0.2e-6)), ("B", pytest.approx(0.4e-6)), ("B", pytest.approx(0.4e-6)),
    ]  # fmt: skip


def test_rule_probability_and_factor_of_the_file_decide(tmp_path: Path) -> None:
    """AP = 2 um, u = 0.1 um, limit 2.1 um: pass at 80 % or with k = 1 alone; a limit's word outweighs the top's."""
    for top, limit, verdict in (
        ("", "{upper = 2.1, u = 0.1}", "not decided"),
        ("probability = 0.8\n", "{upper = 2.1, u = 0.1}", PASS),
        ("probability = 0.8\n", "{upper = 2.1, u = 0.1, probability = 0.9}", "not decided"),
        ("rule = 'u-rule'\n", "{upper = 2.1, u = 0.1}", "not decided"),
        ("rule = 'u-rule'\ncoverage_factor = 1\n", "{upper = 2.1, u = 0.1}", PASS),
        ("rule = 'u-rule'\n", "{upper = 2.1, u = 0.1, k = 1}", PASS),
        ("rule = 'u-rule'\n", "{upper = 2.1, rule = 'simple'}", PASS),
    ):
        assert judged(tmp_path, TWO, f"{top}[limits]\nAP_um = {limit}\n").verdict == verdict, (top, limit)


def test_turns_of_a_turned_pose_over_time(tmp_path: Path) -> None:
    """At a pose turned by (10, 20, 30) degrees, 0, 2 and 6 urad of rz are an ETVE of 6, d60 of 2 and dt of 6 urad."""
    at = [f"0,0,0,10,20,{30 + np.degrees(turn * 1e-6):.12f}" for turn in (0, 2, 6, 1)]
    rows = [(f"{k * 3600}", "A", "0,0,0,10,20,30", answer) for k, answer in enumerate(at)]
    table = visits(*rows, header=f"time_s,{HEADER}")  # type: ignore[arg-type]
    limits = "[limits]\nETVE_rx_urad = 9\nETVE_rz_urad = 9\nd60_rz_urad = 9\ndt_rz_urad = 9\n"
    found = judged(tmp_path, table, f"rule = 'simple'\nwarm_up_s = 7200\n{limits}")
    np.testing.assert_allclose(values(found), [0, 6, 2, 6], atol=1e-6)


def test_letters_are_read_as_axes_only_where_they_are_told(tmp_path: Path) -> None:
    """AP_a is about z or about x, as `letters` says; without it the key is refused with both readings."""
    turned = visits(*[("A", "0,0,0,0,0,0", f"0,0,0,{np.degrees(1e-6):.12f},0,{np.degrees(3e-6):.12f}")] * 2)
    for letters, value in (("zyx", 3.0), ("xyz", 1.0)):
        found = judged(tmp_path, turned, f'rule = "simple"\nletters = "{letters}"\n[limits]\nAP_a_urad = 9\n')
        assert values(found) == pytest.approx([value], rel=1e-6)
    with pytest.raises(FileFormatError, match="which angle is 'a'"):
        judged(tmp_path, turned, "[limits]\nAP_a_urad = 9\n")


def test_positions_alone_are_enough_for_positions(tmp_path: Path) -> None:
    """Without measured angles positions are judged, with a note on turns; limits of turns are refused."""
    shifts = ",".join(MEASURED.split(",")[:3])
    table = visits(*[("A", "0,0,0,0,0,5", "0.001,0,0")] * 2, header=f"pose,{POSE},{shifts}")
    found = judged(tmp_path, table, 'rule = "simple"\nlimits = {AP_um = 2}\n')
    assert values(found) == pytest.approx([1.0])
    assert any("nothing is said about turns" in note for note in found.notes)
    with pytest.raises(ArgumentError, match="angles were not measured"):
        judged(tmp_path, table, 'rule = "simple"\nlimits = {AP_rz_urad = 2}\n')


def test_few_visits_and_unused_columns_are_told(tmp_path: Path) -> None:
    """ISO 9283 asks for 30 visits; a column that nobody reads is named."""
    table = TWO.replace(",measured_rz_deg", ",measured_rz_deg,operator").replace("0\n", "0,me\n")
    found = judged(tmp_path, table, 'rule = "simple"\nlimits = {AP_um = 9}\n')
    assert any("visited 2 times; ISO 9283 asks for 30" in note for note in found.notes)
    assert any("operator" in note for note in found.notes)


@pytest.mark.parametrize(
    ("table", "line", "column", "words"),
    [
        (TWO.replace("A,0,0,0,0,0,0,0.003", "A,0,0,0,0,0,0,"), 3, 8, "measured_x_mm is"),
        (TWO.replace("A,0,0,0,0,0,0,0.003", ",0,0,0,0,0,0,0.003"), 3, 1, "pose is missing"),
        (TWO.replace("A,0,0,0,0,0,0,0.003", "A,0,0,1,0,0,0,0.003"), 3, 4, "one command"),
        (TWO.replace("pose", "time_s").replace("A", "5"), 3, 1, "times must increase"),
        (TWO.replace("measured_y_mm", "y2"), 1, 1, "measured_y_mm"),
        (TWO.replace("measured_ry_deg", "ry2"), 1, 1, "measured_ry_deg"),
        (TWO.replace("pose", "cycle").replace("A", "1"), 3, 1, "there already, on line 2"),
        (TWO.replace("pose", "u_position_um").replace("A", "0"), 2, 1, "expected above 0"),
        (TWO.replace("0.003", "1e200"), 3, 8, "expected within"),
        (HEADER + "\n", 1, 1, "no rows"),
    ],
)
def test_bad_tables_name_line_and_column(tmp_path: Path, table: str, line: int, column: int, words: str) -> None:
    """Missing and contradicting fields are found where they stand."""
    with pytest.raises(FileFormatError, match=words) as caught:
        read_measured_poses(written(tmp_path, table))
    assert (caught.value.problems[0].line, caught.value.problems[0].column) == (line, column)


def test_thousands_of_faults_are_counted(tmp_path: Path) -> None:
    """A file that is wrong throughout shows twenty lines, and how many more there are."""
    table = visits(*[("A", f"{k},0,0,0,0,0", "0,0,0,0,0,0") for k in range(100)])
    with pytest.raises(FileFormatError, match="80 more fields") as caught:
        read_measured_poses(written(tmp_path, table))
    assert len(caught.value.problems) == 20


def test_a_quantity_known_not_to_be_negative(tmp_path: Path) -> None:
    """AP = 2 um, u = 2 um, limit 5.3 um: p = 0.951 as it is, 0.941 cut at 0 - no longer enough."""
    said = [
        judged(tmp_path, TWO, f"[limits]\nAP_um = {{upper = 5.3, u = 2, nonnegative = {flag}}}\n").results[0].decision
        for flag in ("false", "true")
    ]
    assert [item.verdict for item in said] == [PASS, "not decided"]
    assert [item.probability for item in said] == pytest.approx([0.950529, 0.941199], abs=1e-6)


@pytest.mark.parametrize(
    ("table", "limit", "words"),
    [
        (TWO, "AP_um = 1", "no uncertainty is stated"),
        (TWO, "AP_um = {upper = 1, u = 0.1, poses = 'B'}", "'B' was not measured; measured: A"),
        (TWO, "dAP_um = {upper = 1, u = 0.1}", "at least two groups"),
        (TWO, "ETVE_x_um = {upper = 1, u = 0.1}", "add the column time_s"),
        (TWO, "d60_x_um = {within = 1, u = 0.1}", "add the column time_s"),
        (TWO.rsplit("A", 1)[0], "AP_um = {upper = 1, u = 0.1}", "pose A has 1 visit; expected at least 2"),
        (grouped().replace("warm,A", "warm,B"), "dAP_um = 5", "pose A was visited in group cold only"),
        (grouped().rsplit("1800", 1)[0], "dAP_um = 5", "pose A, group warm has 1 visit"),
        (grouped(), "d60_x_um = 5", "at least 3600"),
        (grouped(), "ETVE_x_um = {upper = 5, window_s = 9999}", "longer than the record"),
    ],
)
def test_limits_that_cannot_be_answered_are_refused(tmp_path: Path, table: str, limit: str, words: str) -> None:
    """A limit without the data it needs is an error that names both, never passed over."""
    with pytest.raises(ArgumentError, match=words) as caught:
        judged(tmp_path, table, f"[limits]\n{limit}\n")
    assert limit.split(" ")[0] in str(caught.value)


def test_one_fail_fails_and_probabilities_bound_the_whole(tmp_path: Path) -> None:
    """A fail outweighs what is not decided; 1 minus the sum of doubts and the least probability bound the whole's."""
    spec = "uncertainty = {position_um = 0.1}\nlimits = {AP_um = %s, RP_um = %s}\n"
    said = {(a, b): judged(tmp_path, TWO, spec % (a, b)) for a in (1, 2.1, 3) for b in (0.5, 1.1, 2)}
    assert {tops: found.verdict for tops, found in said.items()} == {
        (1, 0.5): "fail", (1, 1.1): "fail", (1, 2): "fail",
        (2.1, 0.5): "fail", (2.1, 1.1): "not decided", (2.1, 2): "not decided",
        (3, 0.5): "fail", (3, 1.1): "not decided", (3, 2): "pass",
    }  # fmt: skip
    assert said[2.1, 1.1].probability == pytest.approx((1.0 - 2.0 * 0.158655, 0.841345), abs=1e-5)
    assert said[1, 0.5].probability == pytest.approx((0.0, 0.0), abs=1e-6)


@pytest.mark.parametrize("convention", ["fixed-xyz", "fixed-zyx"])
def test_letters_are_differences_of_angles(tmp_path: Path, convention: str) -> None:
    """At a rotated command, across 180 degrees, AP_a .. AP_c are mean less commanded angle and RP_c is 3 S of it."""
    command = (-20.0, 60.0, 179.9999)
    around = np.radians([5.0e-5, -3.0e-5, 4.0e-4]) * 1e6
    rows = []
    for sign in (-1.0, 1.0):
        angles = np.array(command) + np.degrees((around + sign * np.array([2.0, 0.0, 0.0])) * 1e-6)
        angles[2] -= 360.0
        rows.append(("A", "0,0,0," + ",".join(map(repr, command)), "0,0,0," + ",".join(map(repr, angles.tolist()))))
    spec = 'rule = "simple"\nletters = "zyx"\n[limits]\n' + "".join(f"AP_{k}_urad = 90\n" for k in "cba")
    found = judged(tmp_path, visits(*rows), spec + "RP_c_urad = 9\n", convention=convention)
    assert values(found) == pytest.approx([*around, 3.0 * 2.0 * 2.0**0.5], rel=1e-5)


def test_angles_are_refused_near_gimbal_lock(tmp_path: Path) -> None:
    """At ry = 89.5 degrees a letter's limit is refused, with the quantity to limit instead, and the turn is not."""
    locked = visits(*[("A", "0,0,0,0,89.5,0", "0,0,0,0,89.5001,0")] * 2)
    spec = 'rule = "simple"\nletters = "zyx"\n[limits]\n'
    with pytest.raises(ArgumentError, match=r"AP_c_urad: pose A has ry within 1 degree.*AP_rx_urad"):
        judged(tmp_path, locked, spec + "AP_c_urad = 9\n")
    assert values(judged(tmp_path, locked, spec + "AP_ry_urad = 9\n")) == pytest.approx([np.radians(1e-4) * 1e6])


def test_rows_of_a_pose_in_any_order(tmp_path: Path) -> None:
    """Rows of a pose and of a group are found wherever they stand in the table, in the order of the file."""
    names = [f"N{k}" for k in (3, 1, 3, 2, 1, 3)]
    table = visits(*[(name, f"{name[1]},0,0,0,0,0", f"{name[1]},0,0,0,0,0") for name in names])
    measured = read_measured_poses(written(tmp_path, table))
    assert measured.pose_names == ("N3", "N1", "N2")
    assert [measured.rows(name).tolist() for name in measured.pose_names] == [[0, 2, 5], [1, 4], [3]]
    assert measured.rows("N3", "").tolist() == [0, 2, 5]
    assert measured.rows("N3", "other").size == measured.rows("none").size == 0
