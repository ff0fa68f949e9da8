"""The files of a page: its built parts, the replays that it shows with their films, ROMs, and the table of games.

`scripts/web` builds the parts into the folder `page` beside this module, which is in a wheel if it was built before.
`shelf.json` lists the replays and the ROMs: {"format": 1, "replays": [{"name", "title", "game", "replay", "film"}],
"roms": [...]}, with names of files. A page has ROMs of a user's own games and of `catch`, and no others.
"""

import json
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from atari.games.catalog import games
from atari.games.game import Game
from atari.roms import find
from atari.roms.image import md5, read_image
from atari.web.table import table_files

FORMAT = 1
"""The version of `shelf.json`."""

PARTS = Path(__file__).parent / "page"
"""The built parts of the page."""

_CATCH = "catch.toml"
_LONGEST = 80  # letters of a name
_ODD = r"[^A-Za-z0-9_.-]+"  # what is not in names of files and links


@dataclass(frozen=True)
class Shown:
    """A replay on a page.

    Attributes:
        name: the name in links, `#show=NAME`; `page_files` makes it fit, and unique.
        title: the text for readers.
        game: the game.
        replay: the bytes of the replay.
        film: its film, which readers without the ROM see; None if there is none.
    """

    name: str
    title: str
    game: Game
    replay: bytes
    film: bytes | None = None


def is_built() -> bool:
    """Whether the parts of the page are there."""
    return (PARTS / "core.wasm").exists()


def check_built() -> None:
    """Check that the parts of the page are there.

    Raises:
        FileNotFoundError: they are not.
    """
    if not is_built():
        raise FileNotFoundError(
            "this package was built without the page; run scripts/web in a clone of the repository (it needs "
            "Emscripten), then install the package from there, or install a wheel of a release"
        )


def whole_table() -> list[Game]:
    """The games of the package, and `catch`, whose ROM comes with the page."""
    return [*games.values(), games.resolve(PARTS / _CATCH)]


def page_files(shown: Sequence[Shown], table: Iterable[Game]) -> dict[str, bytes]:
    """The files of a page by name, for `bundle.site` and `bundle.one_file`.

    Args:
        shown: the replays, in the order in which the page offers them. It shows the first one at its start.
        table: the games that the page knows beside those of the replays. If two have the same id, the last one counts.
            The ROMs of games with a game file of their own are on the page.

    Raises:
        FileNotFoundError: the page was not built, or there is no ROM of a user's game.
        ValueError: the ROM of a user's game is that of another game, which a page must not contain; or the name of its
            definition has odd letters.
    """
    check_built()
    known = {game.id: game for game in (*table, *(one.game for one in shown))}
    roms = {_rom_name(game): own_image(game) for game in known.values() if game.file}
    shown = unique(shown)
    shelf = {"format": FORMAT, "replays": [_row(one) for one in shown], "roms": list(roms)}
    return {
        **{path.name: path.read_bytes() for path in sorted(PARTS.iterdir()) if path.stem != Path(_CATCH).stem},
        **roms,
        "shelf.json": json.dumps(shelf, ensure_ascii=False).encode(),
        **{f"replays/{one.name}.a26r": one.replay for one in shown},
        **{f"replays/{one.name}.film": one.film for one in shown if one.film},
        **{f"table/{name}": data for name, data in table_files(known.values()).items()},
    }


def _row(one: Shown) -> dict[str, str | None]:
    path = f"replays/{one.name}"
    film = f"{path}.film" if one.film else None
    return {"name": one.name, "title": one.title, "game": one.game.id, "replay": f"{path}.a26r", "film": film}


def _rom_name(game: Game) -> str:
    return "catch.bin" if game.file == PARTS / _CATCH else f"roms/{game.id}.bin"


def own_image(game: Game) -> bytes:
    """The ROM of a user's game, which a page contains.

    Raises:
        FileNotFoundError, ValueError: see `page_files`.
    """
    if re.search(_ODD, game.id):
        raise ValueError(
            "a page takes games whose definitions have names of letters, digits, '_', '-' and '.', got "
            f"{str(game.file)!r}; rename it"
        )
    image = read_image(find(game))
    other = next((known for known in games.values() if known.rom.md5 == md5(image)), None)
    if other is not None:
        raise ValueError(
            f"the ROM of {game.file} is that of {other.title}, which a page must not contain: only readers who have "
            f"it can play it; show a replay of {other.id!r} instead"
        )
    return image


def unique(shown: Iterable[Shown]) -> list[Shown]:
    """The replays with names that links and disks take. Names differ, also without case, and titles differ."""
    found: list[Shown] = []
    names: set[str] = set()
    titles: set[str] = set()
    for one in shown:
        plain = re.sub(_ODD, "-", one.name)[:_LONGEST].strip(".-") or one.game.id
        name, number = plain, 1
        while name.lower() in names:
            number += 1
            name = f"{plain}-{number}"
        title = f"{one.title} ({name})" if one.title in titles else one.title
        names.add(name.lower())
        titles.add(title)
        found.append(replace(one, name=name, title=title))
    return found
