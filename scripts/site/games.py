"""The pages of the games, `games/<id>.md`, their media, and the index of all."""

import os
import subprocess
import sys
from collections.abc import Collection, Iterator

from gamepages import index, text
from gamepages.plays import ROOT
from gamepages.render import folder_of
from page import Page

import atari
from atari.games.game import Game


def pages() -> Iterator[Page]:
    """A page for each game, the media of those in `SITE_GAMES`, and the index."""
    shown = _chosen()
    if shown:
        render = ROOT / "scripts" / "site" / "gamepages" / "render.py"
        subprocess.run([sys.executable, str(render), *shown], check=True)
    yield from texts(atari.games.values(), shown)
    for name in shown:
        for path in sorted(folder_of(atari.games[name]).iterdir()):
            yield Page(f"games/{name}/{path.name}", path)


def texts(games: Collection[Game], shown: Collection[str]) -> Iterator[Page]:
    """The index and the page of each game; those of `shown` have media."""
    yield Page("games/index.md", index.page(games, shown))
    for game in games:
        media = frozenset(path.name for path in folder_of(game).iterdir()) if game.id in shown else frozenset[str]()
        yield Page(f"games/{game.id}.md", text.page(game, media))


def _chosen() -> list[str]:
    """The games of `SITE_GAMES`: names with commas, a number of games, or all of them if it is not set.

    Raises:
        ValueError: there is no such game.
    """
    chosen = os.environ.get("SITE_GAMES", "")
    if not chosen or chosen.isdigit():
        return list(atari.games)[: int(chosen or len(atari.games))]
    return [atari.games.resolve(name.strip()).id for name in chosen.split(",")]
