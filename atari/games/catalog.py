"""`Games`, the mapping from game id to game definition, whose file is read at its first use; `fingerprint`, a hash."""

import difflib
import hashlib
import json
from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import cache
from os import PathLike
from pathlib import Path

from atari.games.game import Game, load_game
from atari.games.toml_file import read_toml

_FOLDER = Path(__file__).parent / "data"
_IDS = tuple(sorted(path.stem for path in _FOLDER.glob("*.toml")))


class Games(Mapping[str, Game]):
    """A read-only mapping from game id (`"ms_pacman"`) to `Game`, in alphabetical order.

    Instances have no state of their own: `games` here and the package `atari.games` are equal.

    Example:
        >>> import atari
        >>> len(atari.games), "pong" in atari.games, atari.games["pong"].title
        (108, True, 'Pong')
    """

    def __getitem__(self, game_id: str) -> Game:
        if game_id not in _IDS:
            raise KeyError(self.unknown(game_id))
        return _load(game_id)

    def __iter__(self) -> Iterator[str]:
        return iter(_IDS)

    def __len__(self) -> int:
        return len(_IDS)

    def __contains__(self, game_id: object) -> bool:
        return game_id in _IDS

    def __repr__(self) -> str:
        return f"<{len(self)} games: {_IDS[0]} ... {_IDS[-1]}>"

    def playable(self) -> Iterator[Game]:
        """The games with single-player rules, which environments need."""
        return map(self.__getitem__, playable_ids())

    def resolve(self, game: "str | PathLike[str] | Game") -> Game:
        """The game of an argument: an id, a game definition of your own (a path that ends in .toml), or a `Game`.

        Raises:
            TypeError: `game` is none of these.
            ValueError: there is no such game (the message suggests the nearest id), or the file is no game definition.
            FileNotFoundError: there is no such file.
        """
        if isinstance(game, Game):
            return game
        if isinstance(game, PathLike) or (isinstance(game, str) and game.endswith(".toml")):
            return replace(load_game(Path(game)), file=Path(game).absolute())
        if not isinstance(game, str):
            raise TypeError(f"a game is named by a string such as 'breakout', got {game!r}")
        if game not in _IDS:
            raise ValueError(self.unknown(game))
        return self[game]

    def find(self, game: "str | PathLike[str] | Game") -> Game:
        """The game of an argument like `resolve`, if it has single-player rules.

        Raises:
            TypeError, ValueError, FileNotFoundError: see `resolve`; ValueError also without single-player rules.
        """
        found = self.resolve(game)
        if not found.single_player:
            raise ValueError(
                f"{found.id!r} is a two-player cartridge without single-player rules, so there is no environment of "
                "one player; players=2, or --players 2 in a command, plays it"
            )
        return found

    def unknown(self, game_id: str) -> str:
        """The error message for an unknown game id, with the nearest known one."""
        compact = {name.replace("_", ""): name for name in _IDS}
        wanted = "".join(letter for letter in str(game_id).lower() if letter.isalnum())
        near = difflib.get_close_matches(wanted, compact, n=1, cutoff=0.5)
        hint = f"did you mean {compact[near[0]]!r}?" if near else "see `atari info` for all of them"
        return f"there is no game {game_id!r}; {hint}"


@cache
def playable_ids() -> tuple[str, ...]:
    """The ids of `Games.playable`. `import atari` registers them, so this function only searches the files' text."""
    return tuple(name for name in _IDS if "\n[rules]\n" in (_FOLDER / f"{name}.toml").read_text(encoding="utf-8"))


@cache
def _load(game_id: str) -> Game:
    return load_game(_FOLDER / f"{game_id}.toml")


games = Games()
"""All game definitions that ship with the package, by id; `atari.games`."""


_DESCRIPTIVE = ("title", "notes", "ram", "rom")
"""Tables of a game file that do not change how the game is played. The ROM has its own MD5."""


def fingerprint(game: Game) -> str:
    """The first 16 hexadecimal digits of the SHA-256 of the parts of a game definition that concern play.

    Titles, notes and the names of RAM bytes do not count.

    Example:
        >>> import atari
        >>> from atari.games.catalog import fingerprint
        >>> len(fingerprint(atari.games["pong"]))
        16
    """
    if game.file is None and games.get(game.id) is game:
        return _of_file(_FOLDER / f"{game.id}.toml", 0)
    if game.file is not None and game.file.exists():
        return _of_file(game.file, game.file.stat().st_mtime_ns)
    parts = (game.screen, game.controllers, game.minimal_actions, game.legal_actions, game.starting_actions)
    return _digest(repr((*parts, game.modes, game.default_mode, game.difficulties, game.rules, game.multiplayer)))


@cache
def _of_file(path: Path, changed: int) -> str:
    tables = read_toml(path, "a game definition")
    decisive = {name: table for name, table in tables.items() if name not in _DESCRIPTIVE}
    return _digest(json.dumps(decisive, sort_keys=True))


def _digest(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()[:16]
