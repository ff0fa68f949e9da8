"""Every wrapper and context manager ends quietly if the environment is closed inside it."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import atari
from atari.cores import NativeCore
from atari.lab import Freeze, Poke, RamLabels, Watch
from atari.recording import RecordReplay, RecordVideo


def single() -> Any:
    return atari.AtariEnv("breakout", render_mode="rgb_array")


def vector() -> Any:
    return atari.AtariVectorEnv("breakout", 2)


def core() -> Any:
    made = NativeCore("breakout", seed=0)
    made.reset()
    return made


AROUND: dict[str, Callable[[Any, Path], Any]] = {
    "Freeze": lambda env, folder: Freeze(env, {49: 1}),
    "Poke": lambda env, folder: Poke(env, {49: 1}),
    "Watch": lambda env, folder: Watch(env, "lives"),
    "RamLabels": lambda env, folder: RamLabels(env),
    "RecordReplay": lambda env, folder: RecordReplay(env, folder / "a.a26r"),
    "RecordVideo": lambda env, folder: RecordVideo(env, folder),
}


@pytest.mark.parametrize("name", AROUND)
@pytest.mark.parametrize("make", [single, vector, core])
def test_closed_inside(name: str, make: Callable[[], Any], tmp_path: Path) -> None:
    if name == "RecordVideo":
        pytest.importorskip("av", reason="PyAV is not installed")
    if make is core and name not in ("Freeze", "Poke"):
        return
    env = make()
    if make is not core:
        env.reset(seed=0)
    around = AROUND[name](env, tmp_path)
    env.close()
    for method in ("release", "stop", "close", "close"):
        if hasattr(around, method):
            getattr(around, method)()
    if name == "Freeze":
        with around:
            pass
