"""``hexathermal diagnose`` on a whole hexapod as a user meets it: the finding, files, the way on, clear errors."""

from __future__ import annotations

import html
import json
import re
from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import hexathermal as ht
from hexathermal.cli import main
from hexathermal.errors import ArgumentError
from hexathermal.learn.diagnosing import diagnose
from hexathermal.learn.machine_diagnosis.noise_levels import coordinates_of
from hexathermal.learn.machine_diagnosis.planning import MachineExperiment
from hexathermal.learn.machine_diagnosis.result import MachineDiagnosis
from hexathermal.learn.machine_diagnosis.view import machine_view
from hexathermal.learn.machine_proposal import diagnosed_rows, open_names, propose_experiment
from hexathermal.machine.leg_terms import LegTerm
from hexathermal.show.diagnosis_page import text
from hexathermal.show.diagnosis_pictures import NARROW_IN, WIDE_IN
from hexathermal.show.machine_figures import plan_figure, promise_figure
from hexathermal.show.machine_report import machine_page
from hexathermal.show.machine_signals import pooled
from hexathermal.show.machine_words import cautions, sentences
from hexathermal.show.report import report_of, subject_of
from tests.browser import complaints
from tests.diagnosed import Ran, diagnosed
from tests.learn.campaign_folders import component_campaign
from tests.show.machine_campaigns import SMALL, WIDE, growing, moved, other_leg, written
from tests.show.test_diagnosis_report import Page

pytestmark = pytest.mark.long

POSES, LEG, CHANGE = 12, 2, 1.2e-6


@pytest.fixture(scope="module")
def ran(tmp_path_factory: pytest.TempPathFactory) -> Ran:
    """The command on a machine with a leg that is not as its law says, run once with every option that writes."""
    place = tmp_path_factory.mktemp("machine")
    rng = np.random.default_rng(11)
    view, six = moved(rng, WIDE, 4, alike=False)
    campaign = written(place / "campaign", rng, view, six, other_leg(LEG, CHANGE), held=1)
    return diagnosed(campaign, place, "extended/hexapod.toml", "--propose", str(POSES))


@pytest.fixture(scope="module")
def page(ran: Ran) -> Page:
    """The report's page."""
    return Page((ran.files / "report" / "report.html").read_text(encoding="utf-8"))


def test_the_finding_is_the_first_line(ran: Ran) -> None:
    """Cause and leg stand in the first sentence; size, evidence, gain, limits and the next experiment follow."""
    first = ran.out.splitlines()[0]
    assert first == ran.facts["effects"][0]["sentence"]
    assert first.startswith("The residual is leg-coefficient")
    assert (ran.facts["cause"], ran.facts["target"]) == ("leg-coefficient", "leg3")
    for words in (
        "95 % interval",
        "evidence log",
        "would be named from",
        "RMSE before",
        "Planned:",
        "next:",
        "Ranked by size over the noise",
    ):
        assert words in ran.out
    assert ran.err == ""


def test_the_true_change_lies_where_the_table_says(ran: Ran) -> None:
    """The table's value is that of the JSON in the unit of the workshop, and the truth lies within 3.5 of its std."""
    row = next(line for line in ran.out.splitlines() if re.match(r"leg-coefficient +leg3 +change of A", line))
    value, std = (float(one) for one in re.findall(r"-?\d+\.\d+", row)[:2])
    told = ran.facts["parameters"]["A_change_per_K"]
    assert value == pytest.approx(told["value"] * 1e6, abs=0.6 * std)
    assert abs(value - CHANGE * 1e6) < 3.5 * std


def test_the_extended_machine_is_used_as_it_is(ran: Ran, capsys: pytest.CaptureFixture[str]) -> None:
    """`validate` finds the diagnosis' errors on the run that was never fitted, and `correct` takes the file."""
    machine = ran.files / "extended" / "hexapod.toml"
    assert main(["validate", str(machine), str(ran.campaign), "--json", "-"]) == 0
    total = json.loads(capsys.readouterr().out)["total"]
    # a diagnosis counts the controller's angles, a validation the vector of the whole rotation: alike to second order
    for name, unit, near in (("translation", "um", 1e-3), ("rotation", "urad", 2e-2)):
        after = ran.facts["gain"][f"{name}_rmse_after_{unit}"]
        assert total[name]["rms_after"]["value"] == pytest.approx(after, rel=near)
        assert after < 0.7 * ran.facts["gain"][f"{name}_rmse_before_{unit}"]
    drawn, names = ht.load_hexapod(machine), ",".join(ht.load_hexapod(machine).sensor_names)
    (ran.files / "poses.csv").write_text("x_mm,y_mm,z_mm,rx_deg,ry_deg,rz_deg\n5,0,12,0,1.5,0\n")
    columns = ",".join(f"{name}_degC" for name in names.split(","))
    (ran.files / "temps.csv").write_text(columns + "\n" + ",".join(["24"] * len(drawn.sensor_names)) + "\n")
    words = ["correct", "--machine", str(machine), "--poses", str(ran.files / "poses.csv")]
    assert main([*words, "--temps", str(ran.files / "temps.csv"), "--out", str(ran.files / "out.csv")]) == 0
    (ran.files / "out.csv").unlink()


def test_a_report_takes_frames_of_runs_out_of_what_is_left(ran: Ran, tmp_path: Path) -> None:
    """Where the measuring frame differs between runs the report's first numbers, and its picture, are without it."""
    facts = json.loads(json.dumps(ran.facts))
    said = {}
    for name, frame in (("same", 0.0), ("differs", 20.0)):
        facts["disturbances"]["frame_of_each_run"] = dict.fromkeys(facts["disturbances"]["noise"], frame)
        facts["gain"]["without_frame_of_each_run"] |= {"translation_rmse_before_um": 0.9162,
                                                       "translation_rmse_after_um": 0.6906}  # fmt: skip
        (tmp_path / f"{name}.json").write_text(json.dumps(facts))
        report = report_of(subject_of(str(tmp_path / f"{name}.json")), None, lambda done, total, label: None)
        value, beside = next(pair[1:] for pair in report.pairs if pair[0].startswith("translation RMSE"))
        aside, _, worth = beside.partition(": ")
        assert re.fullmatch(r"\S+ % \w+, 95 %: \S+ to \S+ %; (not )?proven.*", worth)
        chart = next(one for one in report.charts if one.name == "gain")
        said[name] = (value, aside, chart.panels[0].marks[0].names)
    assert said["differs"] == ("0.916 → 0.691 µm", "before → after, frame of each run out", ("all, no frame",))
    assert said["same"][0] != said["differs"][0]
    assert said["same"][1:] == ("before → after", tuple(ran.facts["gain"]["runs"]))


def test_every_file_that_is_named_is_there(ran: Ran) -> None:
    """Page, pictures, poses, numbers and machine: as `written` says, as the terminal says, and no others."""
    named = {Path(file) for file in ran.facts["written"]}
    assert named == {*(ran.files / "report").iterdir(), ran.files / "extended" / "hexapod.toml"}
    assert all(str(file) in ran.out for file in named)
    inside = json.loads((ran.files / "report" / "diagnosis.json").read_text())
    assert sorted(inside.pop("files")) == sorted(file.name for file in (ran.files / "report").iterdir())
    assert inside == {name: ran.facts[name] for name in inside}


def test_the_planned_poses_are_those_of_the_files(ran: Ran) -> None:
    """As many rows as asked for, the same in CSV and JSON, reachable, with the separation that is promised."""
    plan = ran.facts["next_experiment"]
    lines = (ran.files / "report" / "poses-run-1.csv").read_text().splitlines()
    assert lines[0] == "time_s,x_mm,y_mm,z_mm,rx_deg,ry_deg,rz_deg"
    six = np.array([[float(value) for value in line.split(",")[1:]] for line in lines[1:]])
    assert six.shape == (POSES, 6)
    assert six.tolist() == plan["runs"][0]["poses_mm_deg"]
    hexapod = ht.load_hexapod(ran.campaign / "hexapod.toml")
    q = hexapod.strokes(hexapod.inverse_kinematics(ht.pose_from_coordinates(six, hexapod=hexapod)))
    assert hexapod.stroke is not None
    assert ((q >= hexapod.stroke[:, 0]) & (q <= hexapod.stroke[:, 1])).all()
    assert plan["separation"] == min(one["after"] for one in plan["separations"])


def test_the_page_is_sound(page: Page) -> None:
    """Tags close, headings step down by one, links lead to ids, tables are headed, nothing comes from elsewhere."""
    levels = [int(tag[1]) for tag, _ in page.tags if re.fullmatch(r"h\d", tag)]
    assert levels[0] == 1
    assert all(after - before <= 1 for before, after in pairwise(levels))
    ids = [attributes["id"] for _, attributes in page.tags if "id" in attributes]
    assert len(ids) == len(set(ids))
    assert {str(link["href"])[1:] for link in page.of("a")} <= set(ids)
    assert len(page.of("caption")) == len(page.of("table"))
    assert not page.of("script", "iframe", "object", "b")  # the title's <b> is words
    assert not re.search(
        r"\bnan\b|None|\binf\b|\burad\b|\bum\b", " ".join(text for tag, text in page.said if tag != "style")
    )
    for attributes in page.of("img", "source", "link"):
        for name in ("src", "srcset", "href"):
            assert (attributes.get(name) or "data:").startswith("data:")


def test_every_picture_of_the_issue_is_there(ran: Ran, page: Page) -> None:
    """Residuals against time, pose, length, direction, temperatures; ranking, gain, limits, plan; each in words."""
    names = {str(one["id"]) for one in page.of("figure")}
    wanted = {"all-coordinates", "all-legs", "follows", "ranking", "gain", "limits", "plan", "plan-promise"}
    followed = ("pose", "length", "direction", "leg-temperature", "platform-temperature", "base-temperature",
                "air-temperature")  # fmt: skip
    assert wanted | {f"residual-{name}" for name in followed} <= names
    assert {file.stem for file in (ran.files / "report").glob("*.png")} == names
    assert all(re.search(r"\d", str(one["alt"])) and len(str(one["alt"])) > 40 for one in page.of("img"))


def test_the_residual_follows_the_leg_that_is_wrong(page: Page) -> None:
    """Of all signals, the temperature of leg 3 stands out, and nothing follows it with the extended machine."""
    said = next(text for tag, text in page.said if tag == "figcaption" and "Most:" in text)
    assert re.search(r"Most: .* follows the temperature of leg 3,", said)
    before, after = (int(one) for one in re.findall(r"(\d+)\s%", said))
    assert before > 30
    assert after < 8


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--sensors", "T1"], ["--sensors", "kind 'hexapod'", "--laws"]),
        (["--law", "leg.toml"], ["--law", "kind 'hexapod'"]),
        (["--laws", "fit"], ["--laws", "keep", "refit"]),
        (["--propose", "5"], ["--propose", "6 to 500", "5"]),
        (["--propose", "many"], ["--propose", "many"]),
        (["--extend", "EXTENDED"], ["exists already", "--force"]),
        (["--extend", "INSIDE"], ["lies inside", "read"]),
        (
            ["--extend", "EXTENDED", "--machine", "EXTENDED", "--force"],
            ["--extend", "is one of the files that are read"],
        ),
        (["--extend", "FOLDER", "--machine", "EXTENDED", "--force"], ["--extend", "read"]),
        (["--machine", "nowhere"], ["nowhere", "bundled"]),
        (["--machine", "rubin-m2"], ["rubin-m2", "no thermal law", "identify"]),
        (["--report", "EXTENDED"], ["no folder"]),
        (["--report", "BY HAND"], ["holds report.html, which no diagnosis wrote", "--force"]),
    ],
)
def test_wrong_usage_is_said_in_one_message(
    ran: Ran, words: list[str], said: list[str], capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    """Each mistake: exit code 2, what is wrong and what to try, no traceback, nothing written."""
    stand_for = {"EXTENDED": ran.files / "extended" / "hexapod.toml", "INSIDE": ran.campaign / "new.toml",
                 "FOLDER": ran.files / "extended", "BY HAND": tmp_path}  # fmt: skip
    (tmp_path / "report.html").write_text("my own page")
    before = {file: file.stat().st_mtime_ns for file in ran.files.rglob("*")}
    try:
        code = main(["diagnose", str(ran.campaign), *(str(stand_for.get(word, word)) for word in words)])
    except SystemExit as end:
        code = int(end.code or 0)
    shown = capsys.readouterr()
    assert code == 2
    assert all(text in shown.err for text in said), shown.err
    assert "Traceback" not in shown.err
    assert not shown.out
    assert {file: file.stat().st_mtime_ns for file in ran.files.rglob("*")} == before


def test_a_machine_without_a_law_and_a_short_campaign_are_refused(
    ran: Ran, tmp_path: Path, rng: np.random.Generator, capsys: pytest.CaptureFixture[str]
) -> None:
    """Twenty poses are too few: the message has both numbers; a damaged table is told by file and line, with code 3."""
    view, six = moved(rng, WIDE, 1, alike=False)
    folder = written(tmp_path / "short", rng, view, six)
    table = next(folder.rglob("*.csv"))
    lines = table.read_text().splitlines()
    table.write_text("\n".join(lines[:21]) + "\n")
    assert main(["diagnose", str(folder)]) == 3
    assert re.search(r"20 usable poses .* needs 30", capsys.readouterr().err)
    lines[7] = lines[7].rsplit(",", 3)[0]
    table.write_text("\n".join(lines) + "\n")
    assert main(["diagnose", str(folder)]) == 3
    shown = capsys.readouterr().err
    assert table.name in shown
    assert "8" in shown
    assert "Traceback" not in shown


def test_two_names_and_the_poses_to_add(
    tmp_path: Path, rng: np.random.Generator, capsys: pytest.CaptureFixture[str]
) -> None:
    """Small moves while everything warms alike: both plates are named, and why, and poses that tell them apart."""
    view, six = moved(rng, SMALL, 3, alike=True)
    folder = written(tmp_path / "alike", rng, view, six, growing(5e-6))
    assert main(["diagnose", str(folder), "--propose", "20", "--json", str(tmp_path / "a.json")]) == 0
    shown = capsys.readouterr().out
    facts = json.loads((tmp_path / "a.json").read_text())
    plates = {"platform-expansion", "base-expansion"}
    assert all(name.partition(" of ")[0] in shown.splitlines()[0] for name in plates)
    assert re.search(r"^ *20 +run-1( +-?\d+\.\d{3}){6}$", shown, re.MULTILINE)  # the last pose of the table
    assert {facts["cause"], *facts["effects"][0]["equivalent_places"]} >= plates
    assert any("all temperatures follow one course" in one for one in facts["alike"])
    plan = facts["next_experiment"]
    assert set(plan["tells_apart"]) >= plates
    pairs = [one for one in plan["separations"] if {one["true"], one["rival"]} == plates]
    assert all(one["after"] > 6.0 > one["before"] for one in pairs)
    assert len(plan["runs"][0]["poses_mm_deg"]) == 20


@pytest.fixture(scope="module")
def found(ran: Ran) -> MachineDiagnosis:
    """The same diagnosis in Python."""
    made = diagnose(ht.load_campaign(ran.campaign))
    assert isinstance(made, MachineDiagnosis)
    return made


def test_python_gives_what_the_command_gives(ran: Ran, found: MachineDiagnosis) -> None:
    """One function for every kind of campaign: a hexapod's answer is the command's."""
    told = found.to_json()
    assert told["sentence"] == ran.facts["sentence"]
    assert told["gain"]["translation_rmse_after_um"] == ran.facts["gain"]["translation_rmse_after_um"]


def test_arguments_of_the_other_kind_are_refused(ran: Ran, tmp_path: Path) -> None:
    """Thermometers and laws of one leg do nothing for six, a machine nothing for one leg: both are refused."""
    machine = ht.load_campaign(ran.campaign)
    with pytest.raises(ArgumentError, match=r"sensors is for .* one leg"):
        diagnose(machine, ["T1"])
    part = ht.load_campaign(component_campaign(tmp_path / "part"))
    with pytest.raises(ArgumentError, match=r"laws is for .* hexapod; this one is of kind 'component'"):
        diagnose(part, laws="refit")
    with pytest.raises(ArgumentError, match=r"hexapod is for"):
        diagnose(part, hexapod=ht.load_hexapod("reference"))


def test_what_is_open_is_asked_in_order(ran: Ran, found: MachineDiagnosis) -> None:
    """Equivalents of what was named come first, then what looks alike, two causes before two joints, then the rival."""
    effect = replace(found.effects[0], equivalent_places=("joint-offset of base joint 3",))
    own = "leg-coefficient of leg3"
    joints = "joint-offset of base joint 1, joint-offset of platform joint 1 look alike: few poses"
    plates = "platform-expansion, base-expansion look alike: one course"
    assert open_names(replace(found, effects=(effect,), alike=(joints,))) == (own, "joint-offset of base joint 3")
    assert open_names(replace(found, alike=(joints, plates)))[0] == "platform-expansion"
    first, rival = open_names(replace(found, alike=()))
    assert first == own
    assert rival not in (own, "")
    hardest = max((one for one in found.limits if np.isfinite(one.strength)), key=lambda one: one.strength)
    assert open_names(replace(found, effects=(), alike=()))[0].startswith(hardest.cause)
    nothing = replace(found, effects=(), alike=(), limits=())
    assert open_names(nothing) == ()
    with pytest.raises(ArgumentError, match="nothing to tell apart"):
        propose_experiment(ht.load_campaign(ran.campaign), nothing)


VARIANTS: dict[str, dict[str, Any]] = {
    "none": {"verdict": "none", "effects": ()},
    "unexplained": {"verdict": "unexplained", "effects": (), "follows": "follows the pose"},
    "no proof": {"gain": None, "notes": ("no run is for validation",)},
    "bare": {"effects": (), "verdict": "none", "gain": None, "limits": (), "alike": (), "experiments": (), "notes": (),
             "candidates": (), "title": ""},
    "two names": {"alike": ("a of b, c of d look alike: their columns are nearly the same",), "follows": "is left"},
}  # fmt: skip


@pytest.mark.parametrize("variant", VARIANTS)
def test_every_verdict_makes_a_sound_page_and_answer(found: MachineDiagnosis, variant: str) -> None:
    """With and without names, gain, limits or a title: tags close, tables are headed, and no number is "nan"."""
    one = replace(found, **VARIANTS[variant])
    drawn = dict.fromkeys(("runs", "all", "follows", "pose", "legs", "parts", "ranking", "gain", "limits", "plan"), "")
    page = Page(machine_page(one, drawn, None))
    assert len(page.of("caption")) == len(page.of("table"))
    assert {str(link["href"])[1:] for link in page.of("a")} <= {str(tag["id"]) for _, tag in page.tags if "id" in tag}
    said = " ".join(text for tag, text in page.said if tag != "style")
    assert not re.search(r"\bnan\b|None\b(?! above)|\binf\b", said)
    assert ("never fitted" in said) or one.gain is None
    first = next(words for tag, words in page.said if tag == "p")
    assert first == html.unescape(text(sentences(one)[0]))


def test_a_law_that_remembers_is_written_with_a_warning(found: MachineDiagnosis) -> None:
    """What single poses cannot be corrected for is said where the machine is written, once, and only then."""
    assert not cautions(found)
    thermal = found.extended.thermal
    assert thermal is not None
    legs = list(thermal.legs)
    own = {"sensor": legs[0].sensors[0], "ratio": 0.5, "time_constant_s": 900.0}
    lag = LegTerm("thermal-lag", "lag", own, np.array([1e-7]))
    legs[0] = ht.LegLaw(legs[0].sensors, legs[0].A, legs[0].B, terms=(lag,))
    late = replace(found, extended=replace(found.extended, thermal=replace(thermal, legs=tuple(legs))))
    (said,) = cautions(late)
    assert "thermal-lag" in said
    assert "time_s" in said
    assert not cautions(replace(late, hexapod=late.extended))


def test_a_plan_of_one_name_is_told_from_nothing(ran: Ran, found: MachineDiagnosis) -> None:
    """Where a single cause is asked for, the plan promises to show it at all; a part that stays cold is drawn too."""
    alone = replace(found, effects=(), alike=())
    plan = propose_experiment(ht.load_campaign(ran.campaign), alone, 8)
    assert isinstance(plan, MachineExperiment)
    assert [one.rival for one in plan.promises] == ["nothing"]
    assert plan.promises[0].after > plan.promises[0].before
    for width in (WIDE_IN, NARROW_IN):
        labels = [text.get_text() for axes in promise_figure(plan, width).axes for text in axes.get_yticklabels()]
        assert any("not nothing" in text for text in labels)
        heat = plan_figure(plan, width).axes[2]
        assert {"platform", "base", "air"} <= set(heat.get_legend_handles_labels()[1])


def test_pictures_do_not_know_where_the_tracker_stood(ran: Ran, found: MachineDiagnosis) -> None:
    """Where frames differ, a rigid motion of all poses of a run, turn and shift, changes no picture of its residual."""
    campaign = ht.load_campaign(ran.campaign)
    free = replace(found, disturbances=replace(found.disturbances, frame=np.full(6, 2e-5)))
    rng, others = np.random.default_rng(5), []
    for run in free.residuals:
        rows = diagnosed_rows(campaign, free, run.role)
        own = rows.run == rows.runs.index(run.run)
        view = machine_view(rows)
        legs = view.frame[own] @ rng.normal(0.0, 5e-5, 6)
        added = coordinates_of(replace(view, poses=view.poses[own], time=view.time[own]), legs)
        others.append(replace(run, before=run.before + added, legs_before=run.legs_before + legs))
    shifted = replace(free, residuals=tuple(others))
    still, other = pooled(campaign, free), pooled(campaign, shifted)
    assert np.abs(still.before - other.before).max() < 1e-6
    assert np.abs(pooled(campaign, replace(shifted, disturbances=found.disturbances)).before - other.before).max() > 1.0


def test_a_browser_shows_it_without_a_word_of_complaint(ran: Ran, window: Callable[..., Any]) -> None:
    """Chromium at desk and phone width, light and dark: nothing is missing, nothing runs over the edge."""
    assert complaints(window, ran.files / "report" / "report.html") == []
