"""The page in which the games play, with the recorded plays, if the installed package has it."""

from collections.abc import Iterator

from gamepages.facts import FILM
from gamepages.plays import play_of
from gamepages.render import folder_of
from page import Page

import atari
from atari.recording import Replay
from atari.recording.replay.shown import title
from atari.web.bundle import ONE_FILE, one_file, site
from atari.web.shelf import PARTS, Shown, page_files, whole_table

PLAYER = "play/index.html"
"""The place of the page, if it were in docs/."""


def is_built() -> bool:
    """Whether the package was built with the page."""
    return (PARTS / "core.wasm").exists()


def pages() -> Iterator[Page]:
    """The files of the page, and the page without replays in one file. The replays are those of games with films."""
    if not is_built():
        print("The package has no page in which the games play: it was built without scripts/web.", flush=True)
        return
    table = whole_table()
    for name, content in site(page_files([*_shown()], table)).items():
        yield Page(f"play/{name}", content)
    yield Page(f"play/{ONE_FILE}", one_file(page_files([], table)))


def link() -> str:
    """A link to the page; nothing if it is not there."""
    return f"[The page, with a play of each game]({PLAYER}){{ .md-button }}" if is_built() else ""


def _shown() -> Iterator[Shown]:
    for game in atari.games.values():
        play, film = play_of(game.id), folder_of(game) / FILM
        if play is not None and film.exists():
            replay = Replay.load(play.path)
            yield Shown(game.id, title(game, replay.episodes), game, play.path.read_bytes(), film.read_bytes())
