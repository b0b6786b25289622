"""The command line at work: signals, pipes, terminals, the demo, the cache, and arguments that make no sense."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import threading
import time
import warnings
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import hexathermal as ht
from hexathermal import cli
from hexathermal.show.commands import Answer
from tests.learn.campaign_folders import component_campaign
from tests.trajectory_files import HEAT, POSE, POSES, SENSORS, correct_arguments

KERNELS = ("lengths_loops", "forward_loops", "careful_loops", "modes_tracker")
EXIT_CODES = {0, 1, 2, 3, 4, 130}

Said = pytest.CaptureFixture[str]


@pytest.fixture
def files(tmp_path: Path) -> list[str]:
    """Arguments of a `correct` that works: two poses, one row of temperatures."""
    return correct_arguments(tmp_path)


def program(*arguments: str, **options: object) -> subprocess.CompletedProcess[str]:
    """Run the program as a user does."""
    command = [sys.executable, "-m", "hexathermal", *arguments]
    return subprocess.run(command, capture_output=True, text=True, check=False, **options)  # type: ignore[call-overload]


def test_main_works_outside_the_main_thread(capsys: Said) -> None:
    """Signals are the main thread's; the command line can still be called from another one."""
    codes: list[int] = []
    worker = threading.Thread(target=lambda: codes.append(cli.main(["--version"])))
    worker.start()
    worker.join()
    assert codes == [0]


@pytest.mark.long
@pytest.mark.skipif(sys.platform == "win32", reason="signals")
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, getattr(signal, "SIGHUP", signal.SIGTERM)])
def test_a_stopped_run_leaves_nothing(files: list[str], tmp_path: Path, number: signal.Signals) -> None:
    """Ctrl-C and termination in the middle of a long file end with 130 and remove what was written."""
    if signal.getsignal(number) is signal.SIG_IGN:
        pytest.skip("the tests run where this signal is ignored, as under nohup, and so do their children")
    (tmp_path / "p.csv").write_text(f"{POSES}\n" + f"{POSE}\n" * 1_000_000)
    with subprocess.Popen([sys.executable, "-m", "hexathermal", *files], stderr=subprocess.PIPE, text=True) as running:
        part, patience = tmp_path / "o.csv.part", time.monotonic() + 60.0
        while not (part.exists() and part.stat().st_size) and running.poll() is None and time.monotonic() < patience:
            time.sleep(0.01)
        running.send_signal(number)
        said = running.communicate(timeout=60)[1]
    assert running.returncode == 130, said
    assert "interrupted" in said
    assert "Traceback" not in said
    assert sorted(file.name for file in tmp_path.iterdir()) == ["p.csv", "t.csv"]


@pytest.mark.skipif(sys.platform == "win32", reason="pipes")
def test_a_reader_that_leaves_is_no_error() -> None:
    """``hexathermal ... | head -1`` ends without a word."""
    read, write = os.pipe()
    os.close(read)
    try:
        done = subprocess.run(
            [sys.executable, "-m", "hexathermal", "machines"],
            stdout=write,
            stderr=subprocess.PIPE,
            text=True,
            check=False,
        )
    finally:
        os.close(write)
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.long
@pytest.mark.skipif(sys.platform == "win32", reason="shells")
def test_closed_streams_are_no_error(tmp_path: Path) -> None:
    """``>&-`` and ``2>&-`` end as they would with a reader, without a traceback."""
    for closed in (">&-", "2>&-"):
        done = subprocess.run(
            ["sh", "-c", f'"$0" -m hexathermal machines {closed}', sys.executable],
            capture_output=True, text=True, check=False,
        )  # fmt: skip
        assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.long
@pytest.mark.skipif(sys.platform == "win32", reason="locales")
def test_names_beyond_the_locale_are_explained(files: list[str], tmp_path: Path) -> None:
    """A name with letters that the locale cannot write works, or is refused with what to do; it is no bug report."""
    files[files.index("--out") + 1] = str(tmp_path / "\u00e9.csv")
    plain = dict(os.environ, LC_ALL="C", PYTHONUTF8="0", PYTHONCOERCECLOCALE="0")
    done = program(*files, env=plain)
    assert "please report" not in done.stderr
    assert done.returncode == 0 or (done.returncode == 2 and "PYTHONUTF8=1" in done.stderr)


@pytest.mark.skipif(sys.platform == "win32", reason="devices")
def test_devices_and_pipes_are_refused(files: list[str], tmp_path: Path, capsys: Said) -> None:
    """Devices and pipes are neither replaced by a result, nor read as a machine."""
    pipe = tmp_path / "pipe.csv"
    os.mkfifo(pipe)
    (tmp_path / "null.csv").symlink_to("/dev/null")
    for name in (str(pipe), str(tmp_path / "null.csv"), "/dev/full"):
        files[files.index("--out") + 1] = name
        assert cli.main([*files, "--force"]) == 2
        assert "no plain file" in capsys.readouterr().err
    assert pipe.is_fifo()
    assert Path("/dev/null").is_char_device()
    for name in (str(pipe), "/dev/zero"):
        assert cli.main(["show-machine", name]) == 2
        assert "no plain file" in capsys.readouterr().err
    assert cli.main(["show-machine", str(tmp_path)]) == 2
    assert "no machine file" in capsys.readouterr().err


@pytest.mark.skipif(sys.platform == "win32", reason="signals")
def test_an_interrupt_while_loading_is_quiet() -> None:
    """Ctrl-C while the command line is being loaded ends with 130 and no traceback."""
    code = (
        "import sys, builtins, runpy, hexathermal\n"
        "load = builtins.__import__\n"
        "def stop(name, *rest, **named):\n"
        "    if name == 'hexathermal.cli': raise KeyboardInterrupt\n"
        "    return load(name, *rest, **named)\n"
        "builtins.__import__ = stop\n"
        "runpy.run_module('hexathermal', run_name='__main__')\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 130
    assert "interrupted" in done.stderr
    assert "Traceback" not in done.stderr


@pytest.mark.long
@pytest.mark.skipif(sys.platform == "win32", reason="signals")
@pytest.mark.parametrize("start", ["module", "script"])
@pytest.mark.parametrize("loaded", ["numpy", "hexathermal.machine.hexapod", "hexathermal.cli", "rich.console"])
def test_an_interrupt_while_anything_loads_is_quiet(start: str, loaded: str, tmp_path: Path) -> None:
    """Ctrl-C at any of the imports ends `python -m hexathermal` and the script with 130 and one line."""
    (tmp_path / "sitecustomize.py").write_text(
        "import os, signal, sys\n"
        "class Stop:\n"
        "    def find_spec(self, name, path=None, target=None):\n"
        f"        if name == {loaded!r}: os.kill(os.getpid(), signal.SIGINT)\n"
        "sys.meta_path.insert(0, Stop())\n"
    )
    script = tmp_path / "hexathermal"
    script.write_text("import sys\nfrom hexathermal.__main__ import main\nsys.exit(main())\n")
    started = ["-m", "hexathermal"] if start == "module" else [str(script)]
    path = os.pathsep.join([str(tmp_path), str(Path(ht.__file__).parents[1])])
    done = subprocess.run([sys.executable, *started, "machines"], capture_output=True, text=True, check=False,
                          env=os.environ | {"PYTHONPATH": path}, cwd=tmp_path.parent)  # fmt: skip
    assert (done.returncode, done.stdout) == (130, "")
    assert done.stderr == "interrupted; nothing half-written is left\n"


def test_another_program_that_imports_the_package_keeps_its_signals() -> None:
    """Only the command line watches for signals; what imports hexathermal is interrupted as ever."""
    code = "import signal, hexathermal; print(signal.getsignal(signal.SIGINT) is signal.default_int_handler)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "True\n"


def test_fonts_find_a_place_without_a_home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Where the home folder cannot be written matplotlib gets a folder for the demo; else it keeps its own."""
    for name in ("MPLCONFIGDIR", "XDG_CONFIG_HOME", "XDG_CACHE_HOME"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("HOME", str(tmp_path))
    with cli._place_for_fonts():
        assert "MPLCONFIGDIR" not in os.environ
    monkeypatch.setattr(os, "access", lambda *_where: False)
    with cli._place_for_fonts():
        assert Path(os.environ["MPLCONFIGDIR"]).is_dir()
    assert "MPLCONFIGDIR" not in os.environ


@pytest.mark.long
@pytest.mark.filterwarnings("default::UserWarning")
def test_letters_that_a_font_lacks_are_told_in_one_line(tmp_path: Path, capsys: Said) -> None:
    """A sensor called in Chinese is drawn as a box; one note says so, without code; --quiet leaves it out."""
    folder = component_campaign(tmp_path / "part", rows=60)
    for file in (folder / "campaign.toml", *(folder / "runs").iterdir()):
        file.write_text(file.read_text(encoding="utf-8").replace("T1", "温度"), encoding="utf-8")
    for words, lines in (([], 1), (["--quiet"], 0)):
        assert cli.main(["check", str(folder), "--plots", str(tmp_path / "plots"), "--force", *words]) == 0
        said = capsys.readouterr().err
        assert len([line for line in said.splitlines() if line.startswith("note: pictures show boxes for ")]) == lines
        assert ("温" in said) == bool(lines)
        assert "Glyph" not in said
        assert ".py" not in said


@pytest.mark.filterwarnings("default::RuntimeWarning")
def test_what_a_library_warns_of_is_one_line(monkeypatch: pytest.MonkeyPatch, capsys: Said) -> None:
    """Twice the same warning is told once, by its words and kind, without place and line of code."""

    def run(*_given: object) -> Answer:
        for _time in range(2):
            warnings.warn("odd numbers", RuntimeWarning, stacklevel=1)
        return Answer()

    monkeypatch.setattr("hexathermal.show.commands.machines.run", run)
    assert cli.main(["machines"]) == 0
    assert capsys.readouterr().err == "note: odd numbers (RuntimeWarning)\n"


@pytest.mark.long
@pytest.mark.skipif(sys.platform == "win32", reason="pseudo-terminals")
def test_progress_is_for_terminals_only(files: list[str], tmp_path: Path) -> None:
    """A bar moves on stderr where that is a terminal, and nothing is written there where it is none."""
    import pty

    (tmp_path / "p.csv").write_text(f"{POSES}\n" + f"{POSE}\n" * 150_000)
    quiet = program(*files)
    assert (quiet.returncode, quiet.stderr) == (0, "")
    assert "\x1b" not in quiet.stdout
    ours, theirs = pty.openpty()
    environment = dict(os.environ, TERM="xterm", COLUMNS="100")
    with subprocess.Popen(
        [sys.executable, "-m", "hexathermal", *files, "--force"], stdout=subprocess.PIPE, stderr=theirs, env=environment
    ) as running:
        os.close(theirs)
        shown = b""
        while True:
            try:
                some = os.read(ours, 4096)
            except OSError:
                break
            if not some:
                break
            shown += some
        printed = running.communicate(timeout=60)[0]
    os.close(ours)
    assert running.returncode == 0
    assert b"correcting" in shown
    assert b"%" in shown
    assert b"\x1b" not in printed


@pytest.mark.long
def test_demo_writes_its_files_and_correction_helps(tmp_path: Path, capsys: Said) -> None:
    """Table, summary, CSV and figure appear; the largest errors shrink; a second day replaces the first."""
    folder = tmp_path / "deep" / "down"
    assert cli.main(["demo", "--out", str(folder), "--seed", "3"]) == 0
    said = capsys.readouterr()
    assert sorted(file.name for file in folder.iterdir()) == ["day.csv", "day.png", "summary.json"]
    assert (folder / "day.png").read_bytes().startswith(b"\x89PNG")
    numbers = json.loads((folder / "summary.json").read_text())
    for key in ("largest_shift_um", "largest_turn_urad"):
        assert numbers[key]["with"] < numbers[key]["without"]
        assert f"{numbers[key]['without']:.2f}" in said.out
        assert f"{numbers[key]['with']:.2f}" in said.out
    assert numbers["largest_shift_um"]["with"] < 0.5 * numbers["largest_shift_um"]["without"]
    assert "No thermometer on: platform, base." in said.out
    for words in ("3 % standard deviation", "lag", "gradients", "generic", "about the centre of its joints"):
        assert words in said.out
    hours = [line for line in said.out.splitlines() if line.split()[1:2] in (["works"], ["rests"])]
    assert len(hours) == 13
    assert cli.main(["demo", "--out", str(folder), "--seed", "4"]) == 0
    assert json.loads((folder / "summary.json").read_text())["seed"] == 4


def test_demo_keeps_what_no_demo_wrote(tmp_path: Path, capsys: Said) -> None:
    """A file of the same name that is no demo's is kept, unless --force is given."""
    (tmp_path / "day.csv").write_text("my own day")
    (tmp_path / "summary.json").write_text('["mine"]')
    assert cli.main(["demo", "--out", str(tmp_path)]) == 2
    assert "which no demo wrote" in capsys.readouterr().err
    assert (tmp_path / "day.csv").read_text() == "my own day"
    assert cli.main(["demo", "--out", str(tmp_path), "--force"]) == 0
    assert (tmp_path / "day.csv").read_text().startswith("time_s,")


def test_warm_up_leaves_nothing_to_compile(capsys: Said) -> None:
    """After ``warm-up`` every compiled loop has a build, and calls with other layouts make no new one."""
    assert cli.main(["warm-up"]) == 0
    assert "compiled" in capsys.readouterr().out
    loops = {
        (name, key): loop
        for name, module in sys.modules.items()
        if name.startswith("hexathermal.kinematics.")
        for key, loop in vars(module).items()
        if hasattr(loop, "signatures") and loop.py_func.__module__ == name
    }
    built = {name for (name, _key), loop in loops.items() if loop.signatures}
    assert {f"hexathermal.kinematics.{part}" for part in KERNELS} <= built
    entry = list(loops.values())
    before = [len(loop.signatures) for loop in entry]
    hexapod = ht.load_hexapod("reference")
    still = np.repeat(hexapod.home[None], 6, axis=0)
    still.setflags(write=False)
    for pose in (hexapod.home, still, still[::2], np.asfortranarray(still), still.astype(np.float32)):
        for temps in (np.full(6, 21.0), [21.0] * 6, np.full((len(pose) if pose.ndim == 3 else 4, 6), 21.0)):
            told = hexapod.corrected_leg_lengths(pose, temps)
            hexapod.corrected_pose(pose, temps)
            hexapod.predicted_pose(told, temps)
            hexapod.solve_forward(told)
        hexapod.jacobian(pose)
    assert [len(loop.signatures) for loop in entry] == before


WORDS = ["correct", "machines", "show-machine", "--machine", "--poses", "--temps", "--out", "--json", "--seed",
         "--force", "--convention", "--user-frame", "reference", "rubin-m2", "{tmp}/p.csv", "{tmp}/t.csv", "{tmp}",
         "{tmp}/none/x.csv", "fixed-zyx", "-1e-3", "nan", "0", "-h", "--", "[b]x[/b]", "\u00e9\udcff", ""]  # fmt: skip


@pytest.mark.long
@given(arguments=st.lists(st.sampled_from(WORDS) | st.text(max_size=8), max_size=9))
@settings(max_examples=300, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_no_arguments_whatever_show_a_traceback(
    files: list[str], tmp_path: Path, arguments: list[str], capsys: Said
) -> None:
    """Any arguments end with a stated exit code and without a traceback; what was there is still there."""
    before = [(tmp_path / name).read_bytes() for name in ("p.csv", "t.csv")]
    assert cli.main([word.replace("{tmp}", str(tmp_path)) for word in arguments]) in EXIT_CODES
    said = capsys.readouterr()
    assert "Traceback" not in said.err + said.out
    assert "error inside hexathermal:" not in said.err
    assert [(tmp_path / name).read_bytes() for name in ("p.csv", "t.csv")] == before


@given(
    change=st.lists(
        st.tuples(st.integers(0, 200), st.sampled_from(list("\"',;\n\r\0x9.-eNa \t"))), min_size=1, max_size=3
    ),
    which=st.sampled_from(["p.csv", "t.csv"]),
)
@settings(max_examples=60, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_damaged_files_never_show_a_traceback(
    files: list[str], tmp_path: Path, change: list[tuple[int, str]], which: str, capsys: Said
) -> None:
    """Files with letters changed at random are corrected or refused with a place; a refused run leaves nothing."""
    texts = {"p.csv": f"{POSES}\n" + f"{POSE}\n" * 3, "t.csv": f"{SENSORS}\n{HEAT}\n"}
    letters = list(texts[which])
    for place, letter in change:
        letters[place % len(letters)] = letter
    texts[which] = "".join(letters)
    for name, text in texts.items():
        (tmp_path / name).write_text(text, newline="")
    code = cli.main([*files, "--force"])
    said = capsys.readouterr()
    assert code in (0, 3, 4), said.err
    assert "Traceback" not in said.err
    assert (tmp_path / "o.csv").exists() == (code == 0)
    assert not (tmp_path / "o.csv.part").exists()
    if code:
        assert f"{which}, line " in said.err or "p.csv, line " in said.err
    (tmp_path / "o.csv").unlink(missing_ok=True)
