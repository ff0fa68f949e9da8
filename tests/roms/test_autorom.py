"""`install` runs AutoROM and checks the files; AutoROM may be missing, the licence declined, or the machine offline.

A module replaces AutoROM. Its `main` prints and prompts as version 0.6.1 does.
"""

import sys
from pathlib import Path
from types import ModuleType

import pytest
from gymnasium.error import DependencyNotInstalled

from atari import roms


class _AutoRom(ModuleType):
    """AutoROM, in which `outcome` happens after the licence was accepted."""

    def __init__(self, outcome: "dict[str, bytes] | str | Exception") -> None:
        super().__init__("AutoROM.AutoROM")
        self.outcome = outcome

    def main(self, accept_license: bool, source_file: None, install_dir: str, quiet: bool) -> None:
        print("AutoROM will download the Atari 2600 ROMs.\n\nExisting ROMs will be overwritten.")
        if not accept_license:
            print("I agree to not distribute these ROMs and wish to proceed: [Y/n]:", end=" ")
            answer = sys.stdin.readline()
            if not answer:
                raise RuntimeError  # click.exceptions.Abort is one
            if answer.strip().lower() not in ("", "y", "yes"):
                return
        if isinstance(self.outcome, Exception):
            raise self.outcome
        if isinstance(self.outcome, str):
            print(self.outcome)
            return
        for name, content in self.outcome.items():
            Path(install_dir, name).write_bytes(content)


@pytest.fixture
def autorom(monkeypatch: pytest.MonkeyPatch, pong: bytes) -> _AutoRom:
    module = _AutoRom({"pong.bin": pong, "breakout.bin": b"<html>not found</html>"})
    package = ModuleType("AutoROM")
    package.AutoROM = module  # type: ignore[attr-defined]
    monkeypatch.setitem(sys.modules, "AutoROM", package)
    monkeypatch.setitem(sys.modules, "AutoROM.AutoROM", module)
    return module


def _answer(monkeypatch: pytest.MonkeyPatch, tmp_path: Path, text: str) -> None:
    (tmp_path / "answer").write_text(text)
    monkeypatch.setattr(sys, "stdin", (tmp_path / "answer").open())


@pytest.mark.usefixtures("autorom")
def test_what_it_brings_is_checked_and_imported(own: Path, pong: bytes) -> None:
    report = roms.install(accept_license=True)
    assert report.imported == {"pong": own / "pong.bin"}
    assert (own / "pong.bin").read_bytes() == pong
    assert len(report.rejected) == 1
    assert "breakout.bin is unknown: its 22 bytes are near to no known game" in report.rejected[0]
    assert [file.name for file in own.iterdir()] == ["pong.bin"]


@pytest.mark.usefixtures("autorom")
def test_the_licence_prompt_is_accepted(
    own: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    _answer(monkeypatch, tmp_path, "y\n")
    assert roms.install().imported == {"pong": own / "pong.bin"}
    assert "I agree to not distribute these ROMs and wish to proceed: [Y/n]:" in capsys.readouterr().out


@pytest.mark.parametrize("answer", ["n\n", ""])
@pytest.mark.usefixtures("autorom")
def test_the_licence_is_declined(own: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, answer: str) -> None:
    _answer(monkeypatch, tmp_path, answer)
    with pytest.raises(PermissionError, match="the licence of the ROM files was not accepted, so nothing"):
        roms.install()
    assert not own.exists()


@pytest.mark.parametrize("accept", [True, False])
@pytest.mark.parametrize(
    "outcome",
    [
        "Network connection error. Check your network settings?",
        "Failed to read tar archive. Check your network connection?",
        OSError("HTTPSConnectionPool: Read timed out"),
        EOFError("Compressed file ended before the end-of-stream marker was reached"),
    ],
)
def test_a_machine_that_is_offline(
    autorom: _AutoRom,
    own: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    outcome: "str | Exception",
    accept: bool,
) -> None:
    autorom.outcome = outcome
    _answer(monkeypatch, tmp_path, "yes\n")
    with pytest.raises(ConnectionError) as caught:
        roms.install(accept_license=accept)
    reason = outcome if isinstance(outcome, str) else repr(outcome)
    assert f"which needs the internet (it says: {reason}); offline, use" in str(caught.value)
    assert "`atari roms import` on files you have" in str(caught.value)
    assert not own.exists()


def test_autorom_is_missing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "AutoROM", None)
    with pytest.raises(DependencyNotInstalled, match=r"pip install 'autorom>=0.6'"):
        roms.install(accept_license=True)
