"""PettingZoo's 24 Atari environments: their names, versions and parameters, and the mode that the parameters select."""

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from difflib import get_close_matches
from functools import partial
from typing import Any

from atari.games.catalog import games

_PONG = {
    2: {"classic": 4, "two_paddles": 10, "soccer": 14, "foozpong": 19, "hockey": 27, "handball": 35, "volleyball": 39,
        "basketball": 45},
    4: {"classic": 6, "two_paddles": 11, "soccer": 16, "foozpong": 21, "hockey": 29, "quadrapong": 33, "handball": 37,
        "volleyball": 41, "basketball": 49},
}  # fmt: skip
_COMBAT_TANK = {(False, False): 1, (False, True): 8, (True, False): 10, (True, True): 13}
_MAZE_CRAZE = {"race": 1, "robbers": 2, "capture": 12}


@dataclass(frozen=True)
class Environment:
    """One of PettingZoo's environments.

    Attributes:
        name: its name without the version, for example "pong".
        version: its newest version, the only one that is made.
        game: id of the game.
        defaults: its parameters with their defaults.
        mode: returns the mode of parameters, in Multi-Agent-ALE's numbering; raises ValueError for a wrong one.

    Example:
        >>> from atari.multiplayer import ENVIRONMENTS
        >>> ENVIRONMENTS["pong"].version, ENVIRONMENTS["pong"].defaults["num_players"]
        (3, 2)
    """

    name: str
    version: int
    game: str
    defaults: Mapping[str, Any]
    mode: Callable[..., int] = field(compare=False)  # a copy of `partial` is not equal

    @property
    def id(self) -> str:
        """PettingZoo's name with the version, for example "pong_v3"."""
        return f"{self.name}_v{self.version}"

    @property
    def players(self) -> tuple[int, ...]:
        """The possible numbers of players."""
        rules = games[self.game].multiplayer
        assert rules is not None
        if "num_players" in self.defaults:
            return tuple(rules.modes)
        return (rules.players(self.choose({})),)

    def choose(self, parameters: Mapping[str, Any]) -> int:
        """The mode for some parameters; the others have their defaults.

        Raises:
            TypeError: the environment does not have a parameter.
            ValueError: a parameter does not have a value.
        """
        for name, value in parameters.items():
            if name not in self.defaults:
                having = ", ".join(self.defaults) or "none of its own"
                raise TypeError(f"{self.id} has no parameter {name!r}; it has: {having}")
            kind = type(self.defaults[name])
            if not isinstance(value, kind) or (kind is int and isinstance(value, bool)):
                raise TypeError(f"{name} of {self.id} must be {kind.__name__}, got {value!r}")
        return self.mode(**{**self.defaults, **parameters})


def _one_of(name: str, value: Any, choices: Mapping[Any, int]) -> int:
    if value not in choices:
        raise ValueError(f"{name} must be one of {', '.join(map(repr, choices))}, got {value!r}")
    return choices[value]


def _pong(num_players: int, game_version: str) -> int:
    if num_players not in _PONG:
        raise ValueError(f"num_players must be 2 or 4, got {num_players}")
    return _one_of("game_version", game_version, _PONG[num_players])


def _combat_plane(game_version: str, guided_missile: bool) -> int:
    return _one_of("game_version", game_version, {"bi-plane": 15, "jet": 21}) + (not guided_missile)


def _combat_tank(has_maze: bool, is_invisible: bool, billiard_hit: bool) -> int:
    return _COMBAT_TANK[is_invisible, billiard_hit] + has_maze


def _maze_craze(game_version: str, visibilty_level: int) -> int:
    if visibilty_level not in range(4):
        raise ValueError(f"visibilty_level must be within 0..3, got {visibilty_level}")
    return 4 * (_one_of("game_version", game_version, _MAZE_CRAZE) - 1) + visibilty_level


_SPACE_INVADERS = {  # what each parameter adds to the mode, and its default
    "alternating_control": (16, False), "moving_shields": (1, True), "zigzaging_bombs": (2, False),
    "fast_bomb": (4, False), "invisible_invaders": (8, False),
}  # fmt: skip


def _space_invaders(**parameters: bool) -> int:
    return 33 + sum(_SPACE_INVADERS[name][0] * chosen for name, chosen in parameters.items())


def _variation(name: str, version: int, game_version: str, default: int) -> Environment:
    """A game of the cartridge Video Olympics."""
    modes = {players: versions[game_version] for players, versions in _PONG.items()}
    return Environment(name, version, "pong", {"num_players": default}, partial(_by_players, modes))


def _by_players(modes: Mapping[int, int], num_players: int) -> int:
    return _one_of("num_players", num_players, modes)


def _plain(name: str, version: int, mode: int, game: str | None = None) -> Environment:
    return Environment(name, version, game or name, {}, partial(int, mode))


ENVIRONMENTS: Mapping[str, Environment] = {
    environment.name: environment
    for environment in (
        _variation("basketball_pong", 3, "basketball", default=2),
        _plain("boxing", 2, 2),
        Environment("combat_plane", 2, "combat", {"game_version": "bi-plane", "guided_missile": True}, _combat_plane),
        Environment(
            "combat_tank", 2, "combat", {"has_maze": True, "is_invisible": False, "billiard_hit": True}, _combat_tank
        ),
        _plain("double_dunk", 3, 16),
        _plain("entombed_competitive", 3, 2, "entombed"),
        _plain("entombed_cooperative", 3, 3, "entombed"),
        _plain("flag_capture", 2, 1),
        _variation("foozpong", 3, "foozpong", default=4),
        _plain("ice_hockey", 2, 1),
        _plain("joust", 3, 1),
        _plain("mario_bros", 3, 2),
        Environment("maze_craze", 3, "maze_craze", {"game_version": "robbers", "visibilty_level": 0}, _maze_craze),
        _plain("othello", 3, 4),
        Environment("pong", 3, "pong", {"num_players": 2, "game_version": "classic"}, _pong),
        _plain("quadrapong", 4, 33, "pong"),
        Environment(
            "space_invaders",
            2,
            "space_invaders",
            {key: on for key, (_, on) in _SPACE_INVADERS.items()},
            _space_invaders,
        ),
        _plain("space_war", 2, 1),
        _plain("surround", 2, 1),
        _plain("tennis", 3, 2),
        _plain("video_checkers", 4, 10),
        _variation("volleyball_pong", 3, "volleyball", default=4),
        _plain("warlords", 3, 1),
        _plain("wizard_of_wor", 3, 1),
    )
}
"""The environments by name without the version."""


def find_environment(name: str) -> Environment | None:
    """The environment with a name such as "pong", "pong_v3" or "atari/pong-v3".

    Returns:
        None if the name is the id of another game with rules for several players.

    Raises:
        ValueError: there is no such name, or the version is older; the message suggests the nearest.
    """
    plain, version = split_name(name)
    known = ENVIRONMENTS.get(plain)
    if known is not None:
        if version is not None and int(version) != known.version:
            raise ValueError(f"{name} does not exist; the version of {plain} is {known.version}: {known.id}")
        return known
    if version is None and plain in games and games[plain].multiplayer is not None:
        return None
    named = {environment.game for environment in ENVIRONMENTS.values()}
    others = sorted(game.id for game in games.values() if game.multiplayer is not None and game.id not in named)
    near = get_close_matches(plain, [*ENVIRONMENTS, *others], 1)
    hint = f"; did you mean {near[0]!r}?" if near else ""
    raise ValueError(
        f"there is no game of several players named {name!r}{hint} (all: {', '.join([*sorted(ENVIRONMENTS), *others])})"
    )


def split_name(name: str) -> tuple[str, str | None]:
    """A name of PettingZoo's without its version, and the version."""
    match = re.fullmatch(r"(?:atari/)?(.+?)(?:[_-]v(\d+))?", name)
    return (match[1], match[2]) if match else (name, None)
