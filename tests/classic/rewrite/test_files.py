"""`python -m atari.classic --modern`: diffs, and files that are replaced."""

import os
import sys
from pathlib import Path

import pytest

from atari.base import durable
from atari.classic.__main__ import main
from atari.classic.rewrite.files import OldFile

OLD = "import gym\nenv = gym.make('CartPole-v1')\nstate = env.reset()\n"
NEW = "import gymnasium as gym\nenv = gym.make('CartPole-v1')\nstate, _ = env.reset()\n"


@pytest.fixture
def script(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    path = Path("old.py")
    path.write_text(OLD)
    return path


def test_a_diff_changes_nothing(script: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--modern", "old.py"]) == 0
    printed = capsys.readouterr()
    assert printed.out == (
        "--- old.py\n+++ old.py (modern)\n@@ -1,3 +1,3 @@\n-import gym\n+import gymnasium as gym\n"
        " env = gym.make('CartPole-v1')\n-state = env.reset()\n+state, _ = env.reset()\n"
    )
    assert printed.err == "atari.classic: old.py: not changed; --write changes it\n"
    assert [path.name for path in Path().iterdir()] == ["old.py"]
    assert script.read_text() == OLD


def test_write_twice(script: Path, capsys: pytest.CaptureFixture[str]) -> None:
    script.chmod(0o750)
    assert main(["--modern", "old.py", "--write"]) == 0
    assert (script.read_text(), Path("old.py.orig").read_text()) == (NEW, OLD)
    assert sorted(path.name for path in Path().iterdir()) == ["old.py", "old.py.orig"]
    if os.name == "posix":
        assert script.stat().st_mode & 0o777 == 0o750
    before = script.stat()
    capsys.readouterr()
    assert main(["--modern", "--write", "old.py"]) == 0
    assert capsys.readouterr() == ("", "atari.classic: old.py: nothing to change\n")
    assert (script.stat().st_mtime_ns, script.stat().st_ino) == (before.st_mtime_ns, before.st_ino)


def test_marks_are_counted(script: Path, capsys: pytest.CaptureFixture[str]) -> None:
    script.write_text(OLD + "*a, = env.step(0)")
    main(["--modern", "old.py"])
    printed = capsys.readouterr()
    assert "+# atari.classic: step() returns five values now" in printed.out
    assert "1 to check by hand" in printed.err
    assert printed.out.endswith(" *a, = env.step(0)\n\\ No newline at end of file\n")


def test_encodings_and_line_breaks_stay(script: Path) -> None:
    data = ("# -*- coding: latin-1 -*-\nname = 'é'\n" + OLD).encode("latin-1").replace(b"\n", b"\r\n")
    script.write_bytes(data)
    assert OldFile(script).write()
    assert script.read_bytes() == data.replace(b"import gym\r", b"import gymnasium as gym\r").replace(
        b"state =", b"state, _ ="
    )
    assert Path("old.py.orig").read_bytes() == data
    script.write_bytes(b"\xef\xbb\xbf" + OLD.encode())
    Path("old.py.orig").unlink()
    assert OldFile(script).write()
    assert script.read_bytes() == b"\xef\xbb\xbf" + NEW.encode()


def error(words: list[str], capsys: pytest.CaptureFixture[str]) -> str:
    assert main(["--modern", *words]) == 1
    return capsys.readouterr().err


def test_links_are_refused(script: Path, capsys: pytest.CaptureFixture[str]) -> None:
    if sys.platform == "win32":
        return
    Path("link.py").symlink_to(script)
    assert "link.py is a link, which --write does not replace" in error(["link.py", "--write"], capsys)
    assert main(["--modern", "link.py"]) == 0
    os.link(script, "second.py")
    assert "second.py has a second name (a hard link)" in error(["second.py", "--write"], capsys)
    assert script.read_text() == OLD
    assert not list(Path().glob("*.orig")) + list(Path().glob("*.part"))


def test_a_file_that_changed_since_it_was_read_is_refused(script: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = OldFile(script)
    script.write_text(OLD + "more = 1\n")
    with pytest.raises(ValueError, match=r"old\.py has changed since it was read; run the command again"):
        file.write()
    file = OldFile(script)

    def change_now(descriptor: int) -> None:
        script.write_text("mine = 2\n")
        os.fsync(descriptor)

    monkeypatch.setattr(durable, "sync", change_now)
    with pytest.raises(ValueError, match="has changed"):
        file.write()
    assert script.read_text() == "mine = 2\n"
    assert not list(Path().glob("*.part"))


def test_another_old_text_is_kept(script: Path, capsys: pytest.CaptureFixture[str]) -> None:
    Path("old.py.orig").write_text("precious")
    assert "old.py.orig exists with another text" in error(["old.py", "--write"], capsys)
    assert (script.read_text(), Path("old.py.orig").read_text()) == (OLD, "precious")
    Path("old.py.orig").write_text(OLD)  # of a --write that a kill has ended
    assert main(["--modern", "old.py", "--write"]) == 0
    assert script.read_text() == NEW


@pytest.mark.parametrize(
    "line",
    [
        "print 'hello'",
        "print 'a %d' % 3, 4",
        "    x = 1\nexcept ValueError, e:",
        "raise ValueError, 'x'",
        "exec 'x'",
        "x = 0777",
    ],
)
def test_python_2_gets_a_hint(script: Path, line: str, capsys: pytest.CaptureFixture[str]) -> None:
    script.write_text(
        "import gym\n" + ("try:\n" if "except" in line else "") + line + "\n    pass\n" * ("except" in line)
    )
    assert "this is Python 2; `2to3 -w FILE` of Python 3.12 or older converts it" in error(["old.py"], capsys)


def test_other_errors(script: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert "nothing.py" in error(["nothing.py"], capsys)
    script.write_text("import gym\nx = (1\n")
    assert "atari: error: old.py, line 2: '(' was never closed (x = (1)" in error(["old.py"], capsys)
    for data in (b"\xff\xfe", b"x = '\xe9'\n"):
        script.write_bytes(data)
        assert "old.py is not text in UTF-8, and so no Python script" in error(["old.py"], capsys)
    for data in (b"%PDF-1.4 \xff", b"\x89PNG\r\n\x1a\n", b"\0\1"):
        script.write_bytes(data)
        assert "old.py is not text, and so no Python script; name a script or a notebook" in error(["old.py"], capsys)
    for words, said in (
        ([], "--modern takes at least one file"),
        (["old.py", "--wirte"], "there is no option --wirte; did you mean --write?"),
    ):
        assert main(["--modern", *words]) == 2
        assert f"{said}; usage: python -m atari.classic --modern FILE... [--write]" in capsys.readouterr().err


def test_the_command_without_modern(script: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--modren", "old.py"]) == 2
    assert capsys.readouterr().err == "atari.classic: there is no option --modren; did you mean --modern?; see --help\n"
    Path("old.ipynb").write_text('{"cells": []}')
    assert main(["old.ipynb"]) == 2
    assert "is a notebook, which Jupyter runs: replace its line `import gym`" in capsys.readouterr().err


def test_what_is_no_file(script: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--modern", "none.py"]) == 1
    assert capsys.readouterr().err == "atari: error: there is no file none.py; check the path\n"
    assert main(["--modern", "."]) == 1
    assert capsys.readouterr().err == "atari: error: . is a folder; name the scripts and notebooks in it\n"
