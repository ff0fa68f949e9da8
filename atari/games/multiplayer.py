"""`Multiplayer`: the rules of a game for two to four players, the table `[multiplayer]` of its file."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from atari.base.frozen import FrozenDict
from atari.base.typed_table import check_table
from atari.games.actions import Action, Switch, parse_actions, parse_starting_actions
from atari.games.rules import Rules, parse_rules
from atari.games.toml_file import check_paddle_range


@dataclass(frozen=True)
class Multiplayer:
    """The rules of a game for two to four players, with mode numbers of Multi-Agent-ALE.

    Attributes:
        modes: modes by number of players.
        loading_mode: the mode of the reset that follows the loading of the ROM.
        minimal_actions: the actions that have an effect, the same for each player. All 18 are legal.
        starting_actions: held by player 1, then by player 2, at the end of a reset.
        difficulties: bit 0 is the left difficulty switch at A, bit 1 the right one.
        rules: with the outputs `reward_1`, `lives_1`, `reward_2`, `lives_2`, ... and `terminal`.
        corrected: the same with a true score, if the rule of the reference reads a wrong byte; else None.
        paddle_range: replaces the range in `[controllers]`.
        parameters: numbers that the rules use and a user may set, by name.
        mode_offset: the difference of ale-py's numbers of these modes.
        mirrored_modes: modes of two players in which player 2 plays player 1's game in a mirror: the court is the same
            if left and right are exchanged, and an action moves both players alike.
        notes: irregularities, in words.
    """

    modes: Mapping[int, tuple[int, ...]]
    loading_mode: int
    minimal_actions: tuple[Action, ...]
    starting_actions: tuple[Action | Switch, ...]
    difficulties: tuple[int, ...]
    rules: Rules
    corrected: Rules | None
    paddle_range: tuple[int, int] | None
    parameters: Mapping[str, int]
    mode_offset: int
    mirrored_modes: tuple[int, ...]
    notes: tuple[str, ...]

    @property
    def most_players(self) -> int:
        """The most players of a mode; the rules have rewards and lives for each of them."""
        return max(self.modes)

    def players(self, mode: int) -> int:
        """The number of players in a mode."""
        return next(players for players, modes in self.modes.items() if mode in modes)


_NUMBERS = tuple[int, ...]
_NEEDED = {
    "modes": dict, "loading_mode": int, "minimal": Any, "starting": Any, "difficulties": _NUMBERS, "rules": dict
}  # fmt: skip
_OPTIONAL = {
    "paddle_range": tuple[int, int], "parameters": dict, "mode_offset": int, "mirrored_modes": _NUMBERS,
    "notes": tuple[str, ...],
}  # fmt: skip


def parse_multiplayer(table: Mapping[str, Any]) -> Multiplayer:
    """Read and check a `[multiplayer]` table.

    Raises:
        ValueError: the content is not such a table; the message has the place and the expected content.
    """
    check_table(table, "[multiplayer]", _NEEDED, _OPTIONAL)
    modes = _modes(table["modes"])
    most = max(modes)
    if not table["difficulties"] or not set(table["difficulties"]) <= {0, 1, 2, 3}:
        raise ValueError(f"[multiplayer] difficulties {table['difficulties']} are not among 0, 1, 2, 3")
    mirrored = table.get("mirrored_modes", [])
    if not set(mirrored) <= set(modes.get(2, ())):
        raise ValueError(f"[multiplayer] mirrored_modes {mirrored} are not among the modes of two players")
    return Multiplayer(
        modes=modes,
        loading_mode=table["loading_mode"],
        minimal_actions=parse_actions(table["minimal"]),
        starting_actions=parse_starting_actions(table["starting"]),
        difficulties=tuple(table["difficulties"]),
        rules=_rules(table, most, "step"),
        corrected=_rules(table, most, "corrected_step") if "corrected_step" in table["rules"] else None,
        paddle_range=check_paddle_range("[multiplayer]", table.get("paddle_range")),
        parameters=FrozenDict(table.get("parameters", {})),
        mode_offset=table.get("mode_offset", 0),
        mirrored_modes=tuple(mirrored),
        notes=tuple(table.get("notes", ())),
    )


def _modes(table: Any) -> Mapping[int, tuple[int, ...]]:
    check_table(table, "[multiplayer] modes", {}, dict.fromkeys(("2", "3", "4"), _NUMBERS))
    modes = {int(players): tuple(numbers) for players, numbers in table.items() if numbers}
    if not modes:
        raise ValueError("[multiplayer] modes needs the modes of 2, 3 or 4 players")
    return FrozenDict(modes)


def _rules(table: Mapping[str, Any], players: int, step: str) -> Rules:
    """The rules with one of their steps. The parameters are variables that keep their value."""
    parameters = table.get("parameters", {})
    optional = ("corrected_step", "mode_select", "kept_over_reset")
    check_table(table["rules"], "[multiplayer.rules]", {"state": Any, "step": Any}, dict.fromkeys(optional, Any))
    rules = {key: value for key, value in table["rules"].items() if key != "corrected_step"}
    rules["step"] = table["rules"][step]
    if isinstance(rules["state"], Mapping):
        rules["state"] = {**parameters, **rules["state"]}
        rules["kept_over_reset"] = [*parameters, *rules.get("kept_over_reset", [])]
    outputs = [name for player in range(1, players + 1) for name in (f"reward_{player}", f"lives_{player}")]
    try:
        return parse_rules(rules, tuple(outputs))
    except ValueError as error:
        raise ValueError(f"[multiplayer]: {error}") from None
