#!/usr/bin/env python
"""Renders media of games on all processors: a folder for each game in build/site-cache, kept until its sources change.

    python scripts/site/gamepages/render.py [GAME ...]    # default: all

Prints the games that were rendered, with seconds and bytes.
"""

import hashlib
import os
import shutil
import sys
import time
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))

import atari
from atari.games.game import Game
from gamepages.plays import ROOT, play_of

CACHE = ROOT / "build" / "site-cache"
_SOURCES = ("gamepages/media.py", "pictures.py")


def folder_of(game: Game) -> Path:
    """The folder of a game's media. Its name has a hash of everything that they are made from."""
    play = play_of(game.id)
    digest = hashlib.sha256(repr(game).encode() + repr((game.rom, game.rules, game.multiplayer)).encode())
    for path in (*(ROOT / "scripts" / "site" / name for name in _SOURCES), *([play.path] if play else [])):
        digest.update(path.read_bytes())
    return CACHE / f"{game.id}-{digest.hexdigest()[:16]}"


def render(name: str) -> str:
    """Render a game into a new folder, which gets its name when it is complete. Return a line about it."""
    from gamepages import media  # here: a process that renders nothing needs no PyAV

    started, folder = time.monotonic(), folder_of(atari.games[name])
    partial = folder.with_name(folder.name + ".partial")
    shutil.rmtree(partial, ignore_errors=True)
    partial.mkdir(parents=True)
    media.render(atari.games[name], partial)
    for old in CACHE.glob(f"{name}-" + "?" * 16):
        shutil.rmtree(old)
    partial.rename(folder)
    size = sum(path.stat().st_size for path in folder.iterdir())
    return f"{name:20} {time.monotonic() - started:6.1f} s {size / 1e3:8.0f} kB"


def main(names: list[str]) -> None:
    """Render what is missing of these games."""
    missing = [name for name in names or list(atari.games) if not folder_of(atari.games[name]).exists()]
    started = time.monotonic()
    with ProcessPoolExecutor(max_workers=int(os.environ.get("SITE_JOBS", "0")) or os.cpu_count()) as pool:
        for line in pool.map(render, missing):
            print(line, flush=True)
    if missing:
        print(f"media of {len(missing)} games in {time.monotonic() - started:.0f} s", flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
