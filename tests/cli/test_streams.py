"""Commands with closed and full streams, and Ctrl-C."""

import json
import os
import signal
import struct
import subprocess
import sys
import threading
from importlib import import_module
from pathlib import Path

import pytest
from cli_tools import Capture, Patch

from atari.base.program import ctrl_c_as_event, interruptible
from atari.base.progress import ProgressBar

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="the shell and the signals of POSIX")


def run(redirections: str, *words: str, **variables: str) -> "subprocess.CompletedProcess[str]":
    """Run a command of `atari` with redirections of the shell."""
    shell = ["sh", "-c", f'exec "$@" {redirections}', "sh", sys.executable, "-m", *words]
    environment = {**os.environ, **variables}
    return subprocess.run(shell, capture_output=True, text=True, timeout=120, check=False, env=environment)


@pytest.mark.parametrize("words", ["atari --version", "atari.classic --help", "atari.integrations.envpool -h"])
def test_a_closed_stdout_is_refused_with_a_sentence(words: str) -> None:
    done = run(">&-", *words.split())
    sentence = "atari: error: stdout is closed, and the result goes there; redirect it to a file, or to /dev/null\n"
    assert (done.returncode, done.stderr) == (1, sentence)


def test_other_closed_streams_do_not_matter() -> None:
    assert run("<&-", "atari", "info", "pong").stdout.startswith("pong: Pong\n")
    assert run("2>&-", "atari", "info", "nothing").returncode == 1
    assert run("<&- 2>&-", "atari", "info", "pong").stdout.startswith("pong: Pong\n")
    assert run("<&- 2>&-", "atari", "record").returncode == 2


FORKS = """
import gc, os, sys
from atari.cli import main

def run(stream, file, *commands):
    for words in commands:
        child = os.fork()
        if child == 0:
            os.dup2(file, stream)
            sys.exit(main(words.split()))
        os.write(2, f"{os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])}\\n".encode())

for words in ("info --games", "info pong --json", "roms list", "record --help", "--help"):  # what these read is read once, for all forks
    main(words.split())
print(flush=True)
gc.freeze()  # the ends of the forks need not look at what all have
reader, broken = os.pipe()
os.close(reader)
full = os.open("/dev/full", os.O_WRONLY)
run(1, full, "info --games", "info --ids", "--help", "record --help")
run(1, broken, "info pong --json", "--help", "roms list")
run(2, full, "info --games", "info nothing", "record")
"""
"""Commands in forks of one process, which is imported once, with a full or a broken stream; prints their exit codes."""


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no full device")
def test_full_and_broken_streams() -> None:
    done = subprocess.run([sys.executable, "-c", FORKS], capture_output=True, text=True, timeout=120, check=True)
    full = ["atari: error: No space left on device: stdout", "1"]
    assert done.stderr.splitlines() == [*full * 4, *["0"] * 3, "0", "1", "2"]
    assert "\n\ngame " in done.stdout


@pytest.mark.parametrize("words", [["atari", "info"], ["atari.classic", "x.py"], ["atari.cli.sweep", "list"]])
def test_ctrl_c_while_the_package_is_imported(words: list[str], tmp_path: Path) -> None:
    """A numpy of our own sends the signal."""
    (tmp_path / "numpy.py").write_text("import os, signal\nos.kill(os.getpid(), signal.SIGINT)\nwhile True: pass\n")
    done = run("", *words, PYTHONPATH=str(tmp_path))
    assert (done.returncode, done.stderr) == (130, "atari: interrupted\n")


def test_ctrl_c_is_reported_at_once_and_a_bounce_is_ignored(capfd: Capture) -> None:
    with interruptible():
        with ctrl_c_as_event() as stop:
            signal.raise_signal(signal.SIGINT)
            assert stop.is_set()
            assert capfd.readouterr().err == "atari: stopping; Ctrl-C again stops at once\n"
        signal.raise_signal(signal.SIGINT)
    assert capfd.readouterr().err == ""


def test_a_ctrl_c_that_python_drops_is_raised_again(monkeypatch: Patch) -> None:
    monkeypatch.setattr("atari.base.program._said", {})

    class Finalized:
        def __del__(self) -> None:
            signal.raise_signal(signal.SIGINT)

    def drop() -> None:
        finalized = Finalized()
        del finalized
        threading.Event().wait(60)
        pytest.fail("it went on")

    with pytest.raises(KeyboardInterrupt), interruptible():
        drop()


def test_ctrl_c_waits_for_the_end_of_an_import(tmp_path: Path, monkeypatch: Patch) -> None:
    """Torch's C++ code would end the process."""
    monkeypatch.setattr("atari.base.program._said", {})
    monkeypatch.syspath_prepend(tmp_path)
    (tmp_path / "signalling.py").write_text("import signal\nsignal.raise_signal(signal.SIGINT)\nDONE = True\n")

    def play() -> None:
        assert import_module("signalling").DONE
        threading.Event().wait(60)
        pytest.fail("it went on")

    with pytest.raises(KeyboardInterrupt), interruptible():
        play()


def test_a_process_that_ignores_ctrl_c_goes_on_ignoring_it() -> None:
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        with interruptible(), ctrl_c_as_event() as stop:
            signal.raise_signal(signal.SIGINT)
            assert not stop.is_set()
    finally:
        signal.signal(signal.SIGINT, before)


def test_a_progress_bar_stays_full_past_its_end() -> None:
    with ProgressBar(total=100, file=open(os.devnull, "w")) as bar:
        bar.update(64)
        assert bar.total == 100
        bar.update(64)
        assert (bar.n, bar.total) == (128, 128)


def in_terminal(*words: str, columns: int = 80) -> list[str]:
    """The lines that a command of `atari` prints to a terminal, with stdout and stderr in their order."""
    import fcntl  # here, because Windows has no such modules
    import termios

    terminal, its_end = os.openpty()
    fcntl.ioctl(its_end, termios.TIOCSWINSZ, struct.pack("HHHH", 24, columns, 0, 0))
    environment = {name: value for name, value in os.environ.items() if name != "COLUMNS"}
    command = [sys.executable, "-m", "atari", *words]
    child = subprocess.Popen(command, stdin=its_end, stdout=its_end, stderr=its_end, env=environment)
    os.close(its_end)
    data = b""
    while True:
        try:
            data += (read := os.read(terminal, 4096))
        except OSError:  # Linux: the command has ended
            read = b""
        if not read:
            break
    child.wait()
    os.close(terminal)
    return data.decode().split("\r\n")[:-1]


def test_a_terminal_gets_whole_words() -> None:
    path = f"/no/{'long-' * 20}folder/game.a26r"
    lines = in_terminal("replay", "show", path)
    assert lines == ["atari: error: there is no file", f"  {path};", "  check the path"]  # the path is whole
    lines = in_terminal("info", "pong", columns=60)
    piped = run("", "atari", "info", "pong").stdout.splitlines()
    assert max(map(len, lines)) <= 60 < max(map(len, piped))
    assert " ".join(lines).split() == " ".join(piped).split()
    first = next(index for index, line in enumerate(lines) if line.startswith("  about "))
    assert lines[first + 1].startswith(" " * 16)
    assert lines[first + 1][16] != " "


def test_json_stays_as_it_is_in_a_terminal() -> None:
    lines = in_terminal("info", "pong", "--json", columns=40)
    assert max(map(len, lines)) > 40
    assert json.loads("\n".join(lines)) == json.loads(run("", "atari", "info", "pong", "--json").stdout)
