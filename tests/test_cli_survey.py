"""Every command alike: help that teaches, one meaning of the common options, suggestions, no traceback whatever."""

from __future__ import annotations

import argparse
import json
import re
import shlex
import shutil
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

import hexathermal as ht
from hexathermal import cli
from hexathermal.show.parsing import Parser
from hexathermal.show.usage import parser
from tests.trajectory_files import correct_arguments

Said = pytest.CaptureFixture[str]

ENVELOPE = ["format", "command", "version", "exit_code", "warnings", "written"]


def commands(top: argparse.ArgumentParser, names: tuple[str, ...] = ()) -> Iterator[tuple[tuple[str, ...], Parser]]:
    """Yield words and parser of each command."""
    below = [action for action in top._actions if isinstance(action, argparse._SubParsersAction)]
    for action in below:
        for name, one in action.choices.items():
            yield from commands(one, (*names, name))
    if not below:
        assert isinstance(top, Parser)
        yield names, top


ALL = dict(commands(parser(ht.__version__)))
NAMES = [pytest.param(names, id="-".join(names)) for names in ALL]
SHELL = shutil.which("bash")


@pytest.fixture(scope="module")
def bench(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A small campaign of a leg."""
    folder = tmp_path_factory.mktemp("bench") / "campaign"
    words = ["simulate", "bench", "--out", str(folder), "--runs", "1", "--validation", "1", "--hours", "0.5",
             "--interval", "60", "--quiet"]  # fmt: skip
    assert cli.main(words) == 0
    return folder


@pytest.mark.parametrize("names", NAMES)
def test_every_help_teaches(names: tuple[str, ...], capsys: Said) -> None:
    """Help exits 0, explains, shows an example that names the command, the exit codes and the common options."""
    assert cli.main([*names, "--help"]) == 0
    said = capsys.readouterr()
    assert said.err == ""
    for words in ("exit codes:", "--json [FILE]", "--quiet", "--verbose", f"  hexathermal {' '.join(names)}"):
        assert words in said.out
    assert re.search(r"^examples?:$", said.out, re.MULTILINE)
    assert max(map(len, said.out.splitlines())) <= 120


@pytest.mark.parametrize("names", NAMES)
def test_every_example_of_a_help_is_accepted(names: tuple[str, ...]) -> None:
    """What the examples of the help show is parsed without complaint, to the last option."""
    top = parser(ht.__version__)
    text = str(ALL[names].epilog).replace("\\\n", " ")
    shown = re.findall(r"^  hexathermal (.*)$", text[text.index("example") :].split("exit codes:")[0], re.MULTILINE)
    assert shown
    for line in shown:
        words = shlex.split(line.split(" > ")[0])
        arguments, rest = top.parse_known_args(words)
        assert rest == [], line
        assert arguments.command == words[0]


@pytest.mark.parametrize("names", NAMES)
def test_every_option_is_explained_and_means_the_same(names: tuple[str, ...]) -> None:
    """Each option has a help; a name that two commands share takes the same kind of value and the same metavar."""
    takes = {"--json": "FILE", "--machine": "NAME", "--seed": "N", "--user-frame": "V", "--object-frame": "V",
             "--pose": "V", "--at-tool": "V", "--convention": "NAME", "--truth": "FILE", "--plots": "DIR",
             "--report": "DIR", "--sensors": "NAMES", "--propose": "N", "--poses": "FILE"}  # fmt: skip
    for action in ALL[names]._actions:
        assert action.help, action
        for option in action.option_strings:
            if option in takes:
                assert action.metavar == takes[option], (names, option)


@pytest.mark.parametrize("names", NAMES)
def test_a_misspelt_option_is_2_and_has_a_suggestion(names: tuple[str, ...], capsys: Said) -> None:
    """An unknown option ends with 2 (``accept``: 3), what was meant, and where help is; nothing is done."""
    needed = [action for action in ALL[names]._actions if action.required]
    words = [str(action.choices[0] if isinstance(action.choices, tuple) else "x") for action in needed
             if not action.option_strings]  # fmt: skip
    for action in needed:
        if action.option_strings:
            words += [action.option_strings[0], "x"]
    if names == ("budget",):
        words.append("--day")
    assert cli.main([*names, *words, "--quite"]) == (3 if names == ("accept",) else 2)
    said = capsys.readouterr()
    assert "unknown option --quite; did you mean '--quiet'?" in said.err
    assert f"see 'hexathermal {' '.join(names)} --help'" in said.err
    assert said.out == ""


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["dmo"], "unknown command 'dmo'; did you mean 'demo'?"),
        (["simulate", "benhc"], "did you mean 'bench'?"),
        (["simulate"], "hexathermal simulate bench --out DIR"),
        (["--quiet", "demo"], "options stand after it: hexathermal demo --quiet"),
        (["demo", "--quiet", "--verbose"], "not allowed with"),
        (["demo", "--seed", "1", "--seed", "2"], "given twice"),
        (["demo", "--json", ""], "empty"),
        (["machines", "extra"], "unexpected argument: extra"),
        (["identify", "{c}", "--sensors", "t01"], "did you mean 'T01'?"),
        (["identify", "{c}", "--sensors", ","], "names no sensor"),
        (["identify", "{c}", "--sensors", "T01", "--propose", "9"], "for a campaign of kind 'hexapod' only"),
        (["identify", "{c}", "--material", "stel"], "did you mean 'steel'?"),
        (["validate", "{m}", "{c}"], "is a machine, the campaign is of one leg"),
        (["view", "--port", "x", "--no-browser"], "not a whole number from 0 to 65535"),
        (["check", "{c}", "--plots", "{c}/campaign.toml"], "lies inside"),
        (["check", "{c}/none"], "no campaign at"),
        (["demo", "--out", "{m}/hexapod.toml"], "no folder"),
        (["budget", "--machine", "reference", "--pose", "0", "0", "0", "--temps", "25"], "takes 6 finite numbers"),
        (["completion", "bsh"], "did you mean 'bash'?"),
    ],
)
def test_mistakes_are_explained(
    words: list[str], said: str, bench: Path, tmp_path: Path, capsys: Said, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What is misspelt, doubled, contradictory or of another kind ends with 2 and one message that says what to try."""
    monkeypatch.chdir(tmp_path)
    ht.write_hexapod(ht.load_hexapod("reference"), tmp_path / "m")
    before = sorted(tmp_path.rglob("*"))
    assert cli.main([word.format(c=bench, m=tmp_path / "m") for word in words]) == 2
    shown = capsys.readouterr()
    assert said in shown.err
    assert shown.err.startswith("error: ")
    assert shown.out == ""
    assert sorted(tmp_path.rglob("*")) == before


def test_a_pose_out_of_reach_is_4_and_in_the_units_of_the_command_line(tmp_path: Path, capsys: Said) -> None:
    """A pose far away ends as one out of stroke does, and nobody is asked whether millimetres were given."""
    for words in (["view", "--save", str(tmp_path / "v.html")], ["budget", "--machine", "reference", "--temps", "25"]):
        assert cli.main([*words, "--pose", "0", "0", "9999", "0", "0", "0"]) == 4
        said = capsys.readouterr().err
        assert "--pose 0 0 9999 0 0 0 (mm and deg)" in said
        assert "were millimetres given" not in said
    home = ["budget", "--machine", "reference", "--temps", "25", "--pose", "0", "0"]
    assert cli.main([*home, "1200", "0", "0", "0"]) == 4
    assert "mm too long; choose a pose closer to home" in capsys.readouterr().err
    assert cli.main([*home, "0", "0", "0", "0", "--map", "x=-5000:5000:3", "--out", str(tmp_path / "o")]) == 0
    assert "were millimetres given" not in capsys.readouterr().out + (tmp_path / "o" / "map.csv").read_text()


JSON = [
    ["machines"], ["show-machine", "reference"], ["completion", "bash"], ["check", "{c}"],
    ["identify", "{c}", "--sensors", "T01", "--out", "{o}/leg.toml"], ["correct", "{correct}"],
    ["budget", "--machine", "reference", "--pose", "0", "0", "0", "0", "0", "0", "--temps", "25", "--out", "{o}/b"],
    ["simulate", "bench", "--out", "{o}/s", "--runs", "1", "--validation", "0", "--hours", "0.5", "--interval", "60"],
    ["demo", "--out", "{o}/d"], ["view", "--save", "{o}/v.html"], ["warm-up"],
]  # fmt: skip


@pytest.mark.long
@pytest.mark.parametrize("words", JSON, ids=lambda words: words[0])
def test_json_has_one_envelope(words: list[str], bench: Path, tmp_path: Path, capsys: Said) -> None:
    """``--json`` puts one JSON object on stdout and nothing else there; its first keys are those of every command;
    what it says was written is there.
    """
    given = [word.format(c=bench, o=tmp_path, correct="{correct}") for word in words]
    if given[-1] == "{correct}":
        given = correct_arguments(tmp_path)
    assert cli.main([*given, "--json"]) == 0
    answer = json.loads(capsys.readouterr().out)
    assert list(answer)[: len(ENVELOPE)] == ENVELOPE
    assert answer["command"] == given[0]
    assert (answer["exit_code"], answer["version"]) == (0, ht.__version__)
    assert re.fullmatch(r"hexathermal-[a-z-]+/\d+", answer["format"])
    assert all(Path(file).is_file() for file in answer["written"])
    assert ("--out" in given or "--save" in given) == bool(answer["written"])


def test_json_into_a_file_is_what_goes_to_stdout(tmp_path: Path, capsys: Said) -> None:
    """With a file the tables are printed as ever, and the file holds what ``--json`` alone prints."""
    file = tmp_path / "m.json"
    assert cli.main(["machines", "--json", str(file)]) == 0
    assert "rubin-m2" in capsys.readouterr().out
    assert cli.main(["machines", "--json", "-"]) == 0
    assert capsys.readouterr().out == file.read_text()


def test_quiet_says_warnings_and_errors_only(bench: Path, tmp_path: Path, capsys: Said) -> None:
    """``--quiet`` leaves stdout empty; a warning is still said, an error is, and JSON that was asked for comes."""
    words = ["identify", str(bench), "--sensors", "T01", "--out", str(tmp_path / "leg.toml")]
    assert cli.main([*words, "--quiet"]) == 0
    said = capsys.readouterr()
    assert said.out == ""
    assert all(line.startswith("warning:") for line in said.err.splitlines())
    assert said.err
    assert cli.main([*words, "--quiet"]) == 2
    assert "exists already" in capsys.readouterr().err
    assert cli.main(["machines", "--quiet", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["machines"]


def test_verbose_tells_steps_on_stderr(bench: Path, capsys: Said) -> None:
    """``--verbose`` tells each step with its time and the exit code on stderr; stdout is as without it."""
    assert cli.main(["check", str(bench)]) == 0
    plain = capsys.readouterr()
    assert cli.main(["check", str(bench), "--verbose"]) == 0
    told = capsys.readouterr()
    assert told.out == plain.out
    steps = [line for line in told.err.splitlines() if re.match(r" +\d+\.\d s  ", line)]
    assert any("reading run-01" in line for line in steps)
    assert steps[-1].endswith("done, exit code 0")


@pytest.mark.skipif(SHELL is None, reason="no bash")
@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (["ch"], {"check"}),
        (["completion", ""], {"bash", "zsh", "tcsh"}),
        (["simulate", ""], {"bench", "machine"}),
        (["correct", "--poses", "po"], {"poses.csv"}),
        (["check", ""], {"camp"}),
        (["demo", "--machine", "ru"], {"rubin-camera", "rubin-m2"}),
        (["demo", "--machine", "mine"], {"mine.toml"}),
        (["check", "--net"], {"--netcdf"}),
        (["budget", "--frame", ""], {"machine", "user", "object"}),
    ],
)
def test_bash_completes(words: list[str], expected: set[str], tmp_path: Path, capsys: Said) -> None:
    """Commands, options, choices, files, folders and bundled machines are completed where they are wanted."""
    assert cli.main(["completion", "bash"]) == 0
    (tmp_path / "c.bash").write_text(capsys.readouterr().out)
    here = tmp_path / "here"
    (here / "camp").mkdir(parents=True)
    for name in ("poses.csv", "mine.toml"):
        (here / name).touch()
    line = shlex.join(["hexathermal", *words])
    script = (
        f"source {shlex.quote(str(tmp_path / 'c.bash'))}; cd {shlex.quote(str(here))}; COMP_WORDS=({line}); "
        f"COMP_CWORD={len(words)}; COMP_LINE={shlex.quote(line)}; COMP_POINT=${{#COMP_LINE}}; "
        '_shtab_hexathermal; printf "%s\\n" "${COMPREPLY[@]}"'
    )
    done = subprocess.run([str(SHELL), "--norc", "-c", script], capture_output=True, text=True, check=False)
    assert done.stderr == ""
    assert set(done.stdout.split()) == expected


@pytest.mark.parametrize("shell", ["bash", "zsh", "tcsh"])
def test_completions_are_sound(shell: str, capsys: Said) -> None:
    """Every shell's script names every command; a shell that is here finds no fault in its syntax."""
    assert cli.main(["completion", shell]) == 0
    script = capsys.readouterr().out
    assert all(names[0] in script for names in ALL)
    program = shutil.which(shell)
    if program is not None:
        done = subprocess.run([program, "-n"], input=script, capture_output=True, text=True, check=False)
        assert (done.returncode, done.stderr) == (0, "")


POSES = "x_mm,y_mm,z_mm,rx_deg,ry_deg,rz_deg"
BAD = {
    "empty.csv": b"", "binary.csv": bytes(range(256)) * 9, "nan.csv": f"{POSES}\n0,0,nan,0,0,0\n".encode(),
    "columns.csv": b"x,y\n1,2\n", "units.csv": f"{POSES.replace('_mm', '_m')}\n0,0,0,0,0,0\n".encode(),
    "empty.toml": b"", "binary.toml": bytes(range(256)), "other.toml": b'format = "x"\n[a]\nb = 1\n',
}  # fmt: skip
"""Files that nothing can be made of."""

TAKERS = [
    "correct --machine reference --poses {f} --temps {f} --out {o}/o.csv",
    "correct --machine {f} --poses {f} --temps {f} --out {o}/o.csv",
    "show-machine {f}",
    "demo --machine {f} --out {o}/d",
    "simulate bench --out {o}/s --scenario {f}",
    "simulate machine --out {o}/s --poses {f}",
    "simulate machine --out {o}/s --machine {f}",
    "check {f}",
    "identify {f}",
    "identify {c} --sensors T01 --common {f}",
    "validate {f} {c}",
    "diagnose {f}",
    "diagnose {c} --law {f}",
    "compare {f}",
    "apply {f} --machine reference --out {o}/m",
    "view --temps {f} --save {o}/v.html",
    "view --campaign {f} --save {o}/v.html",
    "view --machine {f} --save {o}/v.html",
    "accept {f} --spec {f}",
    "budget --machine reference --pose 0 0 0 0 0 0 --temps {f}",
    "budget --machine reference --temps 25 --path {f}",
    "budget --machine reference --pose 0 0 0 0 0 0 --temps 25 --sources {f}",
]


@pytest.mark.long
@pytest.mark.parametrize("line", TAKERS)
def test_files_that_are_none_are_refused(line: str, bench: Path, tmp_path: Path, capsys: Said) -> None:
    """Whatever file is given for whatever is wanted: an error of the input, one message, no traceback, nothing left."""
    for name, content in BAD.items():
        (tmp_path / name).write_bytes(content)
    for name in (*BAD, "none.csv", "."):
        before = sorted(tmp_path.iterdir())
        words = [word.format(f=tmp_path / name, o=tmp_path, c=bench) for word in line.split()]
        code = cli.main(words)
        said = capsys.readouterr()
        assert code in (2, 3), (name, said.err)
        assert said.err.startswith("error: "), name
        assert "Traceback" not in said.err
        assert "inside hexathermal" not in said.err
        assert str(tmp_path / name) in said.err, said.err
        assert said.out == ""
        assert sorted(tmp_path.iterdir()) == before


WRITERS = [
    "demo --out {o}/d",
    "check {c} --plots {o}/p",
    "simulate bench --out {o}/s --runs 1 --validation 0 --hours 0.5 --interval 60 --plots {o}/p --truth {o}/t.json",
    "simulate machine --out {o}/s --runs 1 --validation 0 --rows 4 --plots {o}/p",
    "identify {c} --sensors T01 --out {o}/l.toml --report {o}/r",
    "budget --machine reference --pose 0 0 0 0 0 0 --temps 25 --map x=0:5:2 --out {o}/b",
    "view --save {o}/v.html",
]


@pytest.mark.long
@pytest.mark.skipif(sys.platform == "win32", reason="limits of a process")
@pytest.mark.parametrize("line", ["machines --json {o}/m.json", *WRITERS], ids=lambda line: line.split(" -")[0])
def test_a_full_disk_ends_with_1_and_leaves_nothing(line: str, bench: Path, tmp_path: Path, capsys: Said) -> None:
    """Where a file cannot be written to its end, the message says so and no part of an answer is left."""
    import resource

    words = [word.format(o=tmp_path, c=bench) for word in line.split()]
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (128, before[1]))  # a write beyond fails as on a full disk
    try:
        code = cli.main(words)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    said = capsys.readouterr().err
    assert code == 1, said
    assert said.splitlines()[-1].startswith("error: ")
    assert "Traceback" not in said
    assert "inside hexathermal" not in said
    assert sorted(tmp_path.iterdir()) == []


@pytest.mark.long
@pytest.mark.parametrize(
    "line", [line for line in WRITERS if not line.startswith(("check", "view"))], ids=lambda line: line.split(" -")[0]
)
def test_an_interrupt_at_the_last_step_leaves_nothing(
    line: str, bench: Path, tmp_path: Path, capsys: Said, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Ctrl-C at the last step that is told, when all but the last file is written, ends with 130 and leaves nothing."""
    steps: list[str] = []
    stop_at = [10**9]

    @contextmanager
    def bar(*_given: object) -> Iterator[object]:
        """Give what counts the steps, and raises in the last."""

        def move(_done: int, _total: int, label: str = "") -> None:
            steps.append(label)
            if len(steps) == stop_at[0]:
                raise KeyboardInterrupt

        yield move

    monkeypatch.setattr(cli, "_bar", bar)
    for place in ("whole", "stopped"):
        (tmp_path / place).mkdir()
    assert cli.main([word.format(o=tmp_path / "whole", c=bench) for word in line.split()]) == 0
    stop_at[0] = len(steps)
    steps.clear()
    assert cli.main([word.format(o=tmp_path / "stopped", c=bench) for word in line.split()]) == 130
    assert "nothing half-written is left" in capsys.readouterr().err
    assert any((tmp_path / "whole").iterdir())
    assert sorted((tmp_path / "stopped").iterdir()) == []
