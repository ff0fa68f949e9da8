"""`atari completion`: what the shells complete, in bash and zsh themselves."""

import builtins
import shutil
import subprocess
from pathlib import Path
from typing import Any

import pytest

from atari.cli import main

CATCH = Path(__file__).parents[2] / "examples" / "catch"
CASES = {
    "rec": {"record"},
    "info break": {"breakout"},
    "record ALE/Pon": {"ALE/Pong-v5", "ALE/Pong-ram-v5"},
    "explain PongNo": {"PongNoFrameskip-v0", "PongNoFrameskip-v4"},
    "info catc": {"catch.toml"},
    "record pong --preset dqn": {"dqn2015"},
    "record pong --epis": {"--episodes"},
    "lab ma": {"map", "mario_bros", "maze_craze"},
    "lab map break": {"breakout"},
    "train pp": {"ppo"},
    "replay ver": {"verify"},
    "evaluate rand": {"random"},
    "evaluate random pong": {"pong"},
    "roms verify break": {"breakout"},
}


@pytest.fixture(scope="module")
def bash(tmp_path_factory: pytest.TempPathFactory) -> Path:
    pytest.importorskip("shtab", reason="completion needs shtab")
    if shutil.which("bash") is None:
        pytest.skip("bash is not installed")
    return written(tmp_path_factory.mktemp("shell") / "atari", "bash")


def written(file: Path, shell: str) -> Path:
    capture = pytest.MonkeyPatch()
    lines: list[str] = []
    capture.setattr(builtins, "print", lambda *words, **options: lines.extend(map(str, words)))
    try:
        assert main(["completion", shell]) == 0
    finally:
        capture.undo()
    file.write_text("\n".join(lines))
    return file


@pytest.mark.parametrize("line", CASES)
def test_bash_completes(line: str, bash: Path) -> None:
    words = line.split(" ")
    program = (
        f"source {bash}; COMP_WORDS=(atari {' '.join(words)}); COMP_CWORD={len(words)}; _shtab_atari; "
        'printf "%s\\n" "${COMPREPLY[@]}"'
    )
    result = subprocess.run(["bash", "-c", program], cwd=CATCH, capture_output=True, text=True, timeout=30, check=True)
    assert set(result.stdout.split()) == CASES[line]


def test_the_script_of_zsh_is_right(tmp_path: Path) -> None:
    pytest.importorskip("shtab", reason="completion needs shtab")
    script = written(tmp_path / "_atari", "zsh")
    assert script.read_text().startswith("#compdef atari")
    assert '"--preset[' in script.read_text()
    if shutil.which("zsh"):
        assert subprocess.run(["zsh", "-n", str(script)], timeout=30, check=False).returncode == 0


def test_without_shtab_it_names_the_extra(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    real = builtins.__import__

    def without(name: str, *rest: Any) -> Any:
        if name == "shtab":
            raise ImportError(name)
        return real(name, *rest)

    monkeypatch.setattr(builtins, "__import__", without)
    assert main(["completion", "bash"]) == 1
    assert (
        capsys.readouterr().err == "atari: error: atari completion needs shtab: pip install 'atari-envs[completion]'\n"
    )
