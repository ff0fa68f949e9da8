"""Every file that the package writes: planted links are not followed, and a flipped bit is found when it is read."""

import argparse
import ast
import random
import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from package_modules import SOURCES
from written_files import WRITTEN, missing

from atari import cli
from atari.lab.causal import files as causal_files
from atari.play import Session
from atari.recording import Replay

FILES = [
    name
    for name, one in WRITTEN.items()
    if Path(one.name).suffix and not name.startswith("atari ") and "%" not in one.name
]


@pytest.mark.parametrize("name", FILES)
def test_a_planted_link_is_not_followed(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    if packages := missing(name):
        pytest.skip(f"{', '.join(packages)} is not installed")
    monkeypatch.chdir(tmp_path)
    written = WRITTEN[name]
    write = written.prepare(1)
    victim, target = tmp_path / "victim", tmp_path / "new" / written.name
    victim.write_text("mine")
    target.parent.mkdir()
    for link in (target, target.with_name(f"{target.name}.part"))[0 if written.replaces else 1 :]:
        link.symlink_to(victim)
    write(target)
    assert victim.read_text() == "mine"
    assert not target.is_symlink()
    assert target.stat().st_size > 10


READERS: dict[str, Callable[[Path], Any]] = {
    "RecordReplay": lambda file: (Replay.load(file).header, Replay.load(file).episodes),
    "state of a play session": lambda file: Session("pong", state=file).load(),
    "causal map": lambda file: [
        vars(byte) | {"pixels": byte.pixels.tolist()} for byte in causal_files.load(file).bytes
    ],
}


@pytest.mark.parametrize("name", READERS)
@pytest.mark.filterwarnings("ignore")
def test_a_flipped_bit_is_found(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    file, read = tmp_path / WRITTEN[name].name, READERS[name]
    WRITTEN[name].prepare(1)(file)
    good, data, generator = read(file), file.read_bytes(), random.Random(0)
    refused, flips = 0, 40 if name == "causal map" else 120
    for _ in range(flips):
        flipped = bytearray(data)
        flipped[generator.randrange(len(data))] ^= 1 << generator.randrange(8)
        file.write_bytes(flipped)
        try:
            assert read(file) == good  # such as the date of a member of a zip archive
        except ValueError:
            refused += 1
    assert refused > flips / 2


READ = {("verify", "--replay"), ("train", "--resume")}
"""Options that name a file that is read."""


def outputs_of(parser: argparse.ArgumentParser, words: tuple[str, ...] = ()) -> Iterator[tuple[str, str]]:
    """The commands with their options that name a file."""
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for name, command in action.choices.items():
                yield from outputs_of(command, (*words, name))
        elif action.option_strings and (action.type is Path or "-o" in action.option_strings):
            yield " ".join(words), action.option_strings[0]


def test_the_table_has_every_option_that_names_an_output() -> None:
    options = {one for one in outputs_of(cli._parser([])) if one[1] != "--rom"}
    assert options - READ - {written.command for written in WRITTEN.values()} == set()


BY_ANOTHER = {
    "atari.cli.record": "atari record",
    "atari.cli.sweep": "the lock",
    "atari.classic.monitor_files": "classic Monitor",
    "atari.classic.rewrite.files": "tests/classic/rewrite",
    "atari.classic.video_recorder": "classic Monitor",
    "atari.cores.ale_interface": "screen",
    "atari.cores.verify": "difference",
    "atari.integrations.ray.collection": "Parquet",
    "atari.lab.causal.files": "causal map",
    "atari.lab.causal.picture": "picture of a causal map",
    "atari.lab.dataset": "HDF5",
    "atari.lab.inspector.export": "labels of the lab",
    "atari.learning.diagnosis.page": "atari diagnose",
    "atari.learning.frontier": "atari diagnose",
    "atari.learning.pages": "report",
    "atari.learning.evaluation.compare": "comparison",
    "atari.learning.evaluation.plot": "plot",
    "atari.learning.evaluation.results": "result",
    "atari.learning.memory.memory_file": "the attacker of crashes",
    "atari.learning.run_folder": "atari train",
    "atari.learning.run_log": "log of a training",
    "atari.learning.sweep.plan": "report",
    "atari.learning.sweep.processes": "logs of child processes",
    "atari.learning.programs": "trusted programs",
    "atari.play.base": "state of a play session",
    "atari.recording.minari": "Minari",
    "atari.recording.replay.file_format": "RecordReplay",
    "atari.recording.video.encoder": "MP4",
    "atari.roms.locations": "imported ROM",
    "atari.web.folder": "atari web",
}
"""The modules that write, and what in the table writes through them, or who else attacks them."""

ITSELF = {
    "atari.base.durable",
    "atari.base.writer_process",  # HDF5, which takes the name of the successor
    "atari.base.program",  # the null device
    "atari.classic.monitor_files",  # the successor
    "atari.classic.video_recorder",  # an empty file, as Gym's `touch`
    "atari.recording.video.encoder",  # FFmpeg, as well
    "atari.lab.causal.files",  # in memory
    "atari.learning.memory.memory_file",  # with all its room
    "atari.learning.sweep.processes",  # by `durable.open_to_append`
    "atari.roms.locations",  # a new file by a hard link
    "atari.web.folder",  # in a folder of its own, from which the files are moved
}
"""The modules that open files for writing themselves."""

_METHODS = {"write_text", "write_bytes", "touch", "imwrite", "tofile", "savez", "savez_compressed", "copy", "copyfile"}


def opens(call: ast.Call) -> bool:
    """Whether a call opens a file to write it, by its name and its literal arguments."""
    function = call.func.attr if isinstance(call.func, ast.Attribute) else getattr(call.func, "id", "")
    owner = ast.unparse(call.func).partition(".")[0]
    if function in ("open", "File", "fdopen"):
        texts = [
            node.value for node in ast.walk(call) if isinstance(node, ast.Constant) and isinstance(node.value, str)
        ]
        return any(set(text) <= set("rwaxbt+") and set(text) & set("wax") for text in texts)
    if function in ("copy", "copyfile"):
        return owner == "shutil"
    return function in _METHODS


def test_the_table_has_every_module_that_writes_and_each_writes_a_successor() -> None:
    writing, opening = set(), set()
    words = re.compile("|".join(["durable", "open", "File", "copy", *_METHODS]))
    for name, file in SOURCES.items():
        text = file.read_text(encoding="utf-8")
        for node in ast.walk(ast.parse(text)) if words.search(text) else ():
            if isinstance(node, ast.Attribute) and getattr(node.value, "id", "") == "durable":
                writing.add(name)
            if isinstance(node, ast.Call) and opens(node):
                opening.add(name)
    assert writing == {*BY_ANOTHER}
    assert opening - ITSELF == set()
