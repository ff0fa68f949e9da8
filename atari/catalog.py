"""The mapping behind `atari.games`: every game by id, each file read the first time it is asked for."""

import difflib
from collections.abc import Iterator, Mapping
from functools import cache
from pathlib import Path

from atari.game import Game, load_game

_FOLDER = Path(__file__).parent / "games"


class Games(Mapping[str, Game]):
    """A read-only mapping from game id (`"ms_pacman"`) to `Game`, in alphabetical order."""

    def __init__(self) -> None:
        self._ids = tuple(sorted(path.stem for path in _FOLDER.glob("*.toml")))

    def __getitem__(self, game_id: str) -> Game:
        if game_id not in self._ids:
            raise KeyError(self.unknown(game_id))
        return _load(game_id)

    def __iter__(self) -> Iterator[str]:
        return iter(self._ids)

    def __len__(self) -> int:
        return len(self._ids)

    def __contains__(self, game_id: object) -> bool:
        return game_id in self._ids

    def __repr__(self) -> str:
        return f"<{len(self)} games: {self._ids[0]} ... {self._ids[-1]}>"

    def playable(self) -> Iterator[Game]:
        """The games that can be made into an environment: those with single-player rules."""
        return (game for game in self.values() if game.single_player)

    def find(self, game_id: object) -> Game:
        """The playable game of this id.

        Raises:
            TypeError: `game_id` is not a string.
            ValueError: there is no such game (the nearest id is suggested), or it has no single-player rules.
        """
        if not isinstance(game_id, str):
            raise TypeError(f"a game is named by a string such as 'breakout', got {game_id!r}")
        if game_id not in self._ids:
            raise ValueError(self.unknown(game_id))
        game = self[game_id]
        if not game.single_player:
            raise ValueError(
                f"{game_id!r} is a two-player cartridge without single-player rules, so there is no environment of it"
            )
        return game

    def unknown(self, game_id: str) -> str:
        """The sentence for a game id that does not exist, with the nearest one that does."""
        compact = {name.replace("_", ""): name for name in self._ids}
        wanted = "".join(letter for letter in str(game_id).lower() if letter.isalnum())
        near = difflib.get_close_matches(wanted, compact, n=1, cutoff=0.5)
        hint = f"did you mean {compact[near[0]]!r}?" if near else "see `atari list` for all of them"
        return f"there is no game {game_id!r}; {hint}"


@cache
def _load(game_id: str) -> Game:
    return load_game(_FOLDER / f"{game_id}.toml")


games = Games()
