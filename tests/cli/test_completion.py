"""`atari completion`: what the shells complete, in bash, zsh and tcsh themselves."""

import builtins
import contextlib
import io
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from shells import TcshSession, ZshSession

from atari.cli import main

CATCH = Path(__file__).parents[2] / "examples" / "catch"
CASES = {
    "rec": {"record"},
    "info break": {"breakout"},
    "record ALE/Pon": {"ALE/Pong-v5", "ALE/Pong-ram-v5"},
    "info PongNo": {"PongNoFrameskip-v0", "PongNoFrameskip-v4"},
    "info catc": {"catch.toml"},
    "record pong --preset dqn": {"dqn2015"},
    "record pong --episodes": {"--episodes"},
    "record pong --no-maxp": {"--no-maxpool"},
    "lab ma": {"mario_bros", "maze_craze"},
    "causes break": {"breakout"},
    "causes pong --stat": {"--states"},
    "collect break": {"breakout"},
    "collect pong --format min": {"minari"},
    "lab break": {"breakout"},
    "lab pong --no-br": {"--no-browser"},
    "lab pong --agent rand": {"random"},
    "train pp": {"ppo"},
    "replay ver": {"verify"},
    "evaluate rand": {"random"},
    "evaluate random pong": {"pong"},
    "roms verify break": {"breakout"},
    "roms import catc": {"catch.toml", "catch.asm", "catch.bin"},
    "completion tc": {"tcsh"},
}
BEGINNINGS = {
    "record pong --episodes": "--episodes",
    "record pong --no-maxp": "--no-maxpool",
    "causes pong --stat": "--state",
    "info catc": "catch.",
}
"""Common beginnings of the words of tcsh: its rules have the options of all commands, and files of every suffix."""


def written(folder: Path, shell: str, name: str = "atari") -> Path:
    """The file with what the command prints for a shell."""
    pytest.importorskip("shtab", reason="completion needs shtab")
    with contextlib.redirect_stdout(io.StringIO()) as printed:
        assert main(["completion", shell]) == 0
    (folder / name).write_text(printed.getvalue())
    return folder / name


def installed(shell: str, folders: pytest.TempPathFactory) -> Path:
    """A new folder for the script of a shell, which is installed."""
    if shutil.which(shell) is None:
        pytest.skip(f"{shell} is not installed")
    return folders.mktemp(shell)


@pytest.fixture(scope="module")
def bash(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return written(installed("bash", tmp_path_factory), "bash")


@pytest.mark.parametrize("line", CASES)
def test_bash_completes(line: str, bash: Path) -> None:
    words = line.split(" ")
    program = (
        f"source {bash}; COMP_WORDS=(atari {' '.join(words)}); COMP_CWORD={len(words)}; _shtab_atari; "
        'printf "%s\\n" "${COMPREPLY[@]}"'
    )
    result = subprocess.run(["bash", "-c", program], cwd=CATCH, capture_output=True, text=True, timeout=30, check=True)
    assert set(result.stdout.split()) == CASES[line]


@pytest.fixture(scope="module")
def zsh(tmp_path_factory: pytest.TempPathFactory) -> Iterator[ZshSession]:
    script = written(installed("zsh", tmp_path_factory), "zsh", "_atari")
    with ZshSession(script.parent, CATCH) as session:
        yield session


@pytest.mark.parametrize("line", CASES)
def test_zsh_completes(line: str, zsh: ZshSession) -> None:
    assert zsh.complete(f"atari {line}") == CASES[line]


@pytest.fixture(scope="module")
def tcsh(tmp_path_factory: pytest.TempPathFactory) -> Iterator[TcshSession]:
    with TcshSession(written(installed("tcsh", tmp_path_factory), "tcsh"), CATCH) as session:
        yield session


@pytest.mark.parametrize("line", [line for line, words in CASES.items() if len(words) == 1])
def test_tcsh_completes(line: str, tcsh: TcshSession) -> None:
    word = BEGINNINGS.get(line) or next(iter(CASES[line]))
    assert tcsh.complete("atari", line) == " ".join([*line.split(" ")[:-1], word])


def test_the_script_of_zsh_is_right(tmp_path: Path) -> None:
    script = written(tmp_path, "zsh", "_atari")
    assert script.read_text().startswith("#compdef atari")
    assert '"--preset[' in script.read_text()


def test_without_shtab_it_names_the_extra(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    real = builtins.__import__

    def without(name: str, *rest: Any) -> Any:
        if name == "shtab":
            raise ImportError(name)
        return real(name, *rest)

    monkeypatch.setattr(builtins, "__import__", without)
    assert main(["completion", "bash"]) == 1
    assert (
        capsys.readouterr().err
        == f"atari: error: atari completion needs shtab: {sys.executable} -m pip install 'shtab>=1.10'\n"
    )
