"""Every command with closed, full and broken streams, with Ctrl-C at random moments, and with any environment variable.

The commands, their arguments and the values of these come from the parser itself, the other programs and the names of the
environment variables from the files of the package.
"""

import argparse
import contextlib
import os
import random
import re
import resource
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from package_modules import SOURCES

import atari
from atari import cli
from atari.recording.video.formats import FORMATS
from atari.task import env_ids

LARGE = "20000"
LONGEST = 8.0
"""Seconds after which a command that still runs gets Ctrl-C."""
CPU_UNTIL_WORD, WALL_UNTIL_WORD = 2.0, 40.0
"""Seconds of the processor, and on a busy machine of the clock, from Ctrl-C to a first word about it."""
SLOW = 30.0
"""Seconds in which a command ends that without environment variables ends in `LONGEST`."""
MEMORY = 6 << 30
STATES = ("open", "closed", "full", "broken")
PRIVATE = re.compile(r"incompatible function arguments|\bnanobind\b|\b_emulator\b|\batari\.(\w+\.)*_\w+")
KEPT = {"runs", "differences"}
"""Folders in which interrupted commands may leave files: what they hold is resumed or complete. Replays play to their end."""


@dataclass
class Case:
    """A command line, and what it meets."""

    words: list[str]
    streams: dict[str, str] = field(default_factory=dict)
    variables: dict[str, str] = field(default_factory=dict)
    signals: list[float] = field(default_factory=list)
    group: bool = False
    errors: int = 1


@dataclass(frozen=True)
class Ended:
    """How a process has ended."""

    code: int
    by_itself: bool
    silent: str
    errors: str
    files: list[str]


def attack(seed: int) -> None:
    """One command line."""
    source = random.Random(seed)
    case = draw(source)
    with tempfile.TemporaryDirectory() as folder:
        ended = play(case, Path(folder))
        fault = next(faults(case, ended), None)
    if case.variables and not ended.by_itself and fault is None:
        fault = slowness(case)
    assert fault is None, f"{fault}\n{case}\n{ended}"


def draw(source: random.Random) -> Case:
    """A command line, and often one thing that it meets, because most of them end a command early."""
    kind = source.choice(("streams", "variable", "early", "late", "late", "all"))
    words, errors = draw_words(source, long=kind == "late")
    case = Case(words, group=source.random() < 0.5, errors=errors)
    if kind in ("streams", "all"):
        for name in source.sample(("stdin", "stdout", "stderr"), source.choice((1, 1, 2, 3))):
            case.streams[name] = source.choice(STATES[1:])
    if kind in ("variable", "all"):
        case.variables[source.choice(variables())] = draw_value(source)
    if kind != "variable":
        case.signals = [source.uniform(3.0, 7.0) if kind == "late" else source.uniform(0, 2.0)]
        while source.random() < 0.4:
            case.signals.append(case.signals[-1] + source.uniform(0, 0.4))
    if kind == "streams" and source.random() < 0.8:
        case.signals = []
    return case


def draw_value(source: random.Random) -> str:
    """The value of an environment variable: often folders of this machine."""
    if source.random() < 0.6:
        folders = [str(path) for path in Path("/").iterdir() if path.is_dir()]
        return os.pathsep.join(source.sample(folders, source.randrange(1, len(folders) + 1)))
    texts = ("", "0", "1", "-1", "x", " ", "all", "é", "\udcff", "/", ".", "~", "~nobody/x", ":", "\n", "A" * 300)
    return source.choice(texts) + source.choice(("", "", *texts))


@cache
def variables() -> tuple[str, ...]:
    """The names in the sources and in the compiled module that look like environment variables of the package."""
    found: set[str] = set()
    for path in SOURCES.values():
        found |= set(re.findall(r"[\"'](ATARI_[A-Z]+)[\"']", path.read_text("utf-8", "replace")))
    module = find_spec("atari._emulator")
    assert module is not None
    assert module.origin is not None
    found |= {name.decode() for name in re.findall(rb"\bATARI_[A-Z]+(?=\0)", Path(module.origin).read_bytes())}
    return tuple(sorted(found))


@cache
def commands() -> tuple[tuple[tuple[str, ...], argparse.ArgumentParser], ...]:
    """The commands and subcommands of `atari`, with their parsers."""

    def below(words: tuple[str, ...], parser: argparse.ArgumentParser) -> Iterator[Any]:
        groups = [each for each in parser._actions if isinstance(each, argparse._SubParsersAction)]
        if not groups:
            yield words, parser
        for group in groups:
            for name, child in group.choices.items():
                yield from below((*words, name), child)

    return tuple(below((), cli._parser([])))


@cache
def programs() -> tuple[str, ...]:
    """The modules of the package that are programs, besides `atari` itself."""
    texts = {name.removesuffix(".__main__"): path.read_text("utf-8", "replace") for name, path in SOURCES.items()}
    found = {name for name, text in texts.items() if re.search(r'^if __name__ == "__main__":', text, re.M)}
    return tuple(sorted(found - {"atari"}))


def draw_words(source: random.Random, long: bool) -> tuple[list[str], int]:
    """A command line, and the most errors that it may have: one, or one for each file of a list.

    A long one is likely to play for a long time: it has no options but numbers, which are large.
    """
    if source.random() < 0.15 and not long:
        module = source.choice(programs())
        words = source.choice(([], ["--help"], ["script.py"], ["nothing.py"], ["list"], ["pong", "--total-steps", "1"]))
        return [sys.executable, "-m", module, *words], 1
    script = Path(sys.executable).with_name("atari")
    begin = [str(script)] if script.exists() and source.random() < 0.5 else [sys.executable, "-m", "atari"]
    if source.random() < 0.05 and not long:
        return [*begin, source.choice(("--version", "--help", "x", ""))], 1
    name, parser = source.choice([each for each in commands() if not long or any(map(is_number, each[1]._actions))])
    given: list[str] = []
    errors = 1
    for action in parser._actions:
        chosen = source.random() < (0.2 if long else 0.12) and (is_number(action) or not long)
        if action.option_strings and not action.required and not chosen:
            continue
        if action.option_strings:
            given.append(source.choice(action.option_strings))
        if long and is_number(action):
            given.append(LARGE)
        elif action.nargs != 0:
            number = {"+": (1, 2), "*": (0, 1, 2), "?": (0, 1), argparse.REMAINDER: (2,)}.get(str(action.nargs), (1,))
            values = [draw_argument(source, action) for _ in range(source.choice(number))]
            errors = max(errors, len(values) if action.nargs == "+" else 1)
            given += values
    return [*begin, *name, *given], errors


def is_number(action: argparse.Action) -> bool:
    """Whether an option takes a large number, and no text."""
    kind: Any = action.type
    return bool(action.option_strings and kind not in (None, Path) and accepts(kind, LARGE) and not accepts(kind, "x"))


def draw_argument(source: random.Random, action: argparse.Action) -> str:
    """A value of an argument, which its type often accepts."""
    if action.choices is not None and source.random() < 0.9:
        return str(source.choice([*action.choices]))
    games = [source.choice([*atari.games]), source.choice([*env_ids.ids()]), "pong"]
    if action.metavar in ("GAME", "GAMES") and source.random() < 0.9:
        return str(source.choice(games))
    if action.metavar in ("POLICY", "AGENT", "SOURCE") and source.random() < 0.6:
        return source.choice(("random", "noop"))
    endings = (*FORMATS, ".png", ".a26", ".a26r", ".json", ".npz", ".h5", ".parquet", ".html", "")
    files = [f"x{source.choice(endings)}", "no/x", "script.py", ".", "/dev/null", str(atari.roms.find("pong"))]
    numbers = ["0", "1", "2", "7", "-1", "0.5", "16", "5000", "1000000", str(2**40), str(2**64), "nan", "1e400", "0,1"]
    pool = [*games, *files, *numbers, "", "é\udcff", "--", "a=b", "\x1b[2J"]
    if action.type in (Path, None):
        return str(source.choice((*files, *pool)))
    kind: Any = action.type
    accepted = [text for text in pool if accepts(kind, text)]
    return str(source.choice(accepted if accepted and source.random() < 0.8 else pool))


def accepts(kind: Any, text: str) -> bool:
    try:
        kind(text)
    except Exception:
        return False
    return True


def play(case: Case, folder: Path) -> Ended:
    """Run a command line; Ctrl-C comes when it is due, and again until the process has ended."""
    home, work, errors = folder / "home", folder / "work", folder / "errors"
    home.mkdir(exist_ok=True)
    work.mkdir(exist_ok=True)
    (work / "script.py").write_text("print(1)\n")
    sent, silent = 0, ""
    with started(case, home, work, errors) as child:
        start = time.monotonic()
        due = case.signals or [LONGEST]
        due = [*due, *(due[-1] + more for more in (6, 9, 12))]
        heard_at = 0.0
        while child.poll() is None and time.monotonic() - start < LONGEST + WALL_UNTIL_WORD:
            now = time.monotonic() - start
            if sent < len(due) and now >= due[sent]:
                if not sent:
                    heard_at, used = now, cpu(child.pid)
                with contextlib.suppress(ProcessLookupError):
                    (os.killpg if case.group else os.kill)(child.pid, signal.SIGINT)
                sent += 1
            if sent and not silent and case.streams.get("stderr", "open") == "open" and "atari: " not in text(errors):
                more = cpu(child.pid) - used
                if more > CPU_UNTIL_WORD or now - heard_at > WALL_UNTIL_WORD:
                    silent = f"no word {now - heard_at:.1f} s after Ctrl-C, with {more:.1f} s of the processor"
            time.sleep(0.02)
        by_itself = not sent
        code = child.poll()
        if code is None:
            silent = silent or "it did not end after Ctrl-C"
    left = sorted(str(path.relative_to(work)) for path in work.rglob("*") if path.is_file())
    left = [name for name in left if name != "script.py" and name.split("/")[0] not in KEPT and ".a26" not in name]
    return Ended(-9 if code is None else code, by_itself, silent, text(errors), left)


@contextlib.contextmanager
def started(case: Case, home: Path, work: Path, errors: Path) -> Iterator["subprocess.Popen[bytes]"]:
    """The process; whatever it has started is killed in the end."""
    environment = {name: value for name, value in os.environ.items() if not name.startswith("ATARI_")}
    environment |= {"HOME": str(home), "XDG_DATA_HOME": str(home), "BROWSER": "true", "OMP_NUM_THREADS": "1"}
    environment |= {"SDL_VIDEODRIVER": "dummy", "SDL_AUDIODRIVER": "dummy", **case.variables}
    closed = [number for number, name in enumerate(("stdin", "stdout", "stderr")) if case.streams.get(name) == "closed"]

    def prepare() -> None:
        signal.signal(signal.SIGINT, signal.default_int_handler)
        resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        for number in closed:
            os.close(number)

    with contextlib.ExitStack() as stack:
        opened = [
            stack.enter_context(stream(case.streams.get("stdin", "open"), os.devnull, "rb")),
            stack.enter_context(stream(case.streams.get("stdout", "open"), os.devnull, "wb")),
            stack.enter_context(stream(case.streams.get("stderr", "open"), str(errors), "wb")),
        ]
        child = subprocess.Popen(
            case.words,
            **dict(zip(("stdin", "stdout", "stderr"), opened, strict=True)),
            cwd=work,
            env=environment,
            start_new_session=True,
            preexec_fn=prepare,
        )
        try:
            yield child
        finally:
            with contextlib.suppress(ProcessLookupError):
                os.killpg(child.pid, signal.SIGKILL)
            child.wait()


@contextlib.contextmanager
def stream(state: str, path: str, mode: str) -> Iterator[Any]:
    """A stream for a process: the file of a path, a full device, or a pipe without another end."""
    if state == "broken":
        reader, writer = os.pipe()
        ends = (reader, writer) if mode == "rb" else (writer, reader)
        os.close(ends[1])
        with open(ends[0], mode) as file:
            yield file
        return
    with open("/dev/full" if state == "full" else path, mode) as file:
        yield file


def faults(case: Case, ended: Ended) -> Iterator[str]:
    """What is wrong with an end."""
    outside = not re.search(r'File ".*/(atari|roms|wrappers)/.*\.py"', ended.errors)
    first = re.search(
        r'File ".*/atari/base/start\.py"', ended.errors
    )  # the module that prepares the process for Ctrl-C
    early = not ended.by_itself and bool(outside or first)  # Python itself was starting, or the user's script ran
    if ended.silent:
        yield ended.silent
    if "Traceback" in ended.errors and not early and 'File "script.py"' not in ended.errors:
        yield "a traceback"
    if ended.code not in (0, 1, 2, 130, -signal.SIGINT):  # the last is Ctrl-C in the very end of Python
        yield f"exit code {ended.code}"
    if found := PRIVATE.search(ended.errors):
        yield f"a name that users do not know: {found[0]}"
    if len(re.findall(r"^.*error: ", ended.errors, re.M)) > case.errors + (case.streams.get("stdout") == "full"):
        yield "more than one error"
    if ended.code == 0 and case.streams.get("stdout") in ("closed", "full") and "script.py" not in case.words:
        yield "exit code 0, and the output is nowhere"
    if ended.code and (unnamed := [name for name in ended.files if name not in ended.errors]):
        yield f"files are left: {unnamed}"


def slowness(case: Case) -> str | None:
    """The fault of a command that environment variables make slow."""
    plain = Case(case.words, case.streams)
    with tempfile.TemporaryDirectory() as folder:
        if not play(plain, Path(folder)).by_itself:
            return None
    with tempfile.TemporaryDirectory() as folder:
        home = Path(folder, "home")
        home.mkdir()
        with started(case, home, home, Path(folder, "errors")) as child:
            try:
                child.wait(SLOW)
            except subprocess.TimeoutExpired:
                return f"no end in {SLOW:.0f} s, with {cpu(child.pid):.1f} s of the processor, but without the variable"
    return None


def cpu(process: int) -> float:
    """The seconds of the processor that a process has used."""
    try:
        fields = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
    except (FileNotFoundError, ProcessLookupError):
        return 0.0
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def text(path: Path) -> str:
    return path.read_text(errors="backslashreplace") if path.exists() else ""
