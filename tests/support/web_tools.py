"""Programs under Node for the tests of the core in WebAssembly, and the games that they play."""

import base64
import json
import os
import shutil
import subprocess
from functools import cache
from pathlib import Path
from typing import Any

import pytest

import atari

TESTS = Path(__file__).parent.parent
BUILD = Path(os.environ.get("WEB_BUILD", TESTS.parent / "build" / "web"))
"""What scripts/web has built."""

GAMES = os.environ["WEB_GAMES"].split(",") if os.environ.get("WEB_GAMES") else list(atari.games)
"""The games that each test plays: all, or those of the environment variable WEB_GAMES."""

needs_core = pytest.mark.skipif(
    not (BUILD / "core.wasm").exists() or shutil.which("node") is None,
    reason="needs Node and the core that scripts/web builds; scripts/test --web runs these tests",
)


def node(program: str, **given: Any) -> Any:
    """What a program of tests/web prints, as JSON, for an input of JSON."""
    done = subprocess.run(
        ["node", str(TESTS / "web" / program)],
        input=json.dumps(given),
        env={**os.environ, "CORE_WASM": str(BUILD / "core.wasm"), "NODE_OPTIONS": ""},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


@cache
def image(game: str) -> str:
    """The image of a game's ROM in base64."""
    return packed(atari.roms.find(game).read_bytes())


def packed(data: bytes) -> str:
    return base64.b64encode(data).decode()


def unpacked(text: str) -> bytes:
    return base64.b64decode(text)
