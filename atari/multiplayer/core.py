"""`MultiplayerCore`: a game of two to four players on the native emulator, without an environment around it."""

import operator
import zlib
from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache
from os import PathLike
from typing import Any, ClassVar, Literal

import numpy as np

from atari import _emulator
from atari.cores import snapshot
from atari.cores.native import STATE_VERSION, as_ale_reads, make_game
from atari.cores.options import SEED_LIMIT
from atari.games.catalog import games
from atari.games.compiler import compile_rules
from atari.games.game import Game
from atari.games.multiplayer import Multiplayer
from atari.games.players import choose_mode, rules_of
from atari.roms import find
from atari.roms import image as rom_image
from atari.validation import check_integer, check_name, check_poke, check_probability

Reference = Literal["multi_agent_ale", "ale_py"]
REFERENCES: tuple[Reference, ...] = ("multi_agent_ale", "ale_py")
_RESTORED = ("repeat_action_probability", "parameters", "corrected_scores", "end_of_reset", "random_words")
"""Options that a snapshot does not contain, and in which two cores must agree to go on alike."""


class MultiplayerCore(_emulator.Emulator):
    """A game for two to four players. All players see one screen, and act in each frame.

    Multi-Agent-ALE 0.1.12 is the reference. ale-py's announced version for several players differs in the numbers of
    modes, the end of a reset and the source of random words; each has an option.

    Args:
        game: id of a game ("pong"), or a `Game`; it must have rules for several players.
        mode: which game to play; None is the first mode for `players`. The mode decides the number of players.
        players: 2, 3 or 4; None is that of `mode`, else the fewest that the game has.
        seed: of RAM, the timer and sticky actions, 0 .. 2**32 - 1.
        repeat_action_probability: of sticky actions, drawn for each player and frame; 0.0 as in PettingZoo. A number
            for all players, or a sequence with one for each. The generator gives the same words in either case.
        difficulty: None is 0.
        frame_skip: frames that an action is held.
        max_num_frames_per_episode: 0 is no limit.
        parameters: numbers that the rules use, for example {"max_turn_time": 0}.
        corrected_scores: use the true score where a rule of Multi-Agent-ALE's reads a wrong byte (flag_capture); the
            other games have nothing to correct.
        mode_numbers: whose numbers of modes `mode` has.
        end_of_reset: of Multi-Agent-ALE, in which player 2 makes the starting actions, too; or of ale-py.
        random_words: one generator for the machine and sticky actions, as in Multi-Agent-ALE; or ale-py's two.
        sound: fill `audio()`.
        rom: path of the ROM file; None searches.

    Raises:
        ValueError, TypeError: an option is wrong, or the game has no rules for several players.

    Example:
        >>> from atari.multiplayer import MultiplayerCore
        >>> core = MultiplayerCore("pong", seed=1)
        >>> core.reset()
        >>> core.act_players([0, 1])
        [0, 0]
        >>> core.ram().shape, core.player_lives
        ((128,), [0, 0])
    """

    name = "multiplayer"
    OPTIONS: ClassVar[frozenset[str]] = frozenset(
        "mode players seed repeat_action_probability difficulty max_num_frames_per_episode parameters corrected_scores "
        "mode_numbers end_of_reset random_words".split()
    )
    """The options that decide the game, frame by frame."""

    def __init__(
        self,
        game: str | Game,
        *,
        mode: int | None = None,
        players: int | None = None,
        seed: int = 1,
        repeat_action_probability: float | Sequence[float] = 0.0,
        difficulty: int | None = None,
        frame_skip: int = 1,
        max_num_frames_per_episode: int = 0,
        parameters: dict[str, int] | None = None,
        corrected_scores: bool = False,
        mode_numbers: Reference = "multi_agent_ale",
        end_of_reset: Reference = "multi_agent_ale",
        random_words: Reference = "multi_agent_ale",
        sound: bool = False,
        rom: str | PathLike[str] | None = None,
    ) -> None:
        given = dict(locals())
        self.game: Game = games.resolve(game)
        self.rom = rom
        self.rules = rules_of(self.game)
        for name, value in (
            ("mode_numbers", mode_numbers),
            ("end_of_reset", end_of_reset),
            ("random_words", random_words),
        ):
            check_name(name, value, REFERENCES)
        self._offset = self.rules.mode_offset if mode_numbers == "ale_py" else 0
        self.mode, self.players = choose_mode(self.rules, self.game, mode, players, self._offset)
        self.sound = sound
        self.frame_skip = check_integer("frame_skip", frame_skip, 1, 10_000)
        probabilities = _probabilities(repeat_action_probability, self.players)
        self.options: dict[str, Any] = {
            **{option: given[option] for option in sorted(self.OPTIONS)},
            "mode": self.mode + self._offset,
            "players": self.players,
            "seed": operator.index(seed),
            "repeat_action_probability": probabilities,
            "parameters": dict(parameters or {}),
        }
        """What `OPTIONS` names, with the defaults filled in, in types of JSON."""
        image = rom_image.read_image(find(self.game, rom))
        self._rom_md5 = rom_image.md5(image)
        super().__init__(
            game=compiled_for_players(
                self.game,
                image,
                _parameters(self.rules, parameters),
                check_switch("corrected_scores", corrected_scores),
            ),
            repeat_action_probability=probabilities[0],
            player_probabilities=probabilities,
            frame_skip=self.frame_skip,
            max_num_frames_per_episode=check_integer(
                "max_num_frames_per_episode", max_num_frames_per_episode, 0, 2**31 - 1
            ),
            sound=sound,
            color_averaging=False,
            seed=check_integer("seed", seed, 0, SEED_LIMIT - 1),
            one_generator=random_words == "multi_agent_ale",
            second_player_starts=end_of_reset == "multi_agent_ale",
        )
        super().set_mode(self.mode)
        if difficulty is not None:
            if difficulty not in self.rules.difficulties:
                raise ValueError(f"difficulty must be one of {self.rules.difficulties}, got {difficulty!r}")
            super().set_difficulty(difficulty)

    def act_players(self, actions: Sequence[int]) -> list[int]:
        """Play `frame_skip` frames with an action (0 .. 17, an ALE number) of each player; a reward for each."""
        if len(actions) != self.players:
            raise ValueError(f"there are {self.players} players, got {len(actions)} actions")
        return super().act_players(actions)

    @property
    def player_lives(self) -> list[int]:
        """Lives of each player: 0 in games without lives, -1 if the player is out."""
        return super().player_lives[: self.players]

    def set_ram(self, index: int, value: int) -> None:
        """Write one byte of RAM."""
        super().set_ram(*check_poke(index, value))

    def close(self) -> None:
        """Do nothing: the core holds no files."""

    def snapshot(self) -> bytes:
        """The whole state as portable bytes."""
        return snapshot.pack(self._facts(), {"state": zlib.compress(self.save(), 1)})

    def restore(self, data: bytes) -> None:
        """Continue from a snapshot.

        Raises:
            TypeError, ValueError: not a snapshot, damaged, or of another game, version, number of players or mode, or
                other sticky actions or rules. The game is as it was.
        """
        facts, blobs = snapshot.unpack(data)
        own = self._facts()
        snapshot.require(facts, {name: own[name] for name in ("core", "game")})
        of = next((players for players, modes in self.rules.modes.items() if facts.get("mode") in modes), self.players)
        if of != self.players:
            raise ValueError(
                f"the snapshot is of a game of {of} players, not of {self.players}; "
                f"restore it into one with players={of}"
            )
        snapshot.require(facts, own)
        snapshot.require_blobs(blobs, "state")
        try:
            state = zlib.decompressobj().decompress(blobs["state"], 1 << 20)
        except zlib.error as error:
            raise ValueError(f"the snapshot is damaged: {error}") from None
        self.load(state)

    def _facts(self) -> dict[str, Any]:
        return {
            "core": self.name,
            "game": self.game.id,
            "rom": self._rom_md5,
            "state version": STATE_VERSION,
            "mode": self.mode,
            **{option: self.options[option] for option in _RESTORED},
        }


def check_switch(name: str, value: bool) -> bool:
    """`value`, which must be True or False."""
    if not isinstance(value, (bool, np.bool_)):
        raise TypeError(f"{name} must be True or False, got {value!r}")
    return bool(value)


def _probabilities(value: float | Sequence[float], players: int) -> list[float]:
    """Of sticky actions, for each player."""
    name = "repeat_action_probability"
    if not isinstance(value, (list, tuple, np.ndarray)):
        return [as_ale_reads(check_probability(name, value))] * players
    if len(value) != players:
        raise ValueError(f"{name} must be a number, or one for each of {players} players, got {len(value)}")
    return [as_ale_reads(check_probability(f"{name}[{i}]", number)) for i, number in enumerate(value)]


def _parameters(rules: Multiplayer, given: dict[str, int] | None) -> tuple[tuple[str, int], ...]:
    for name, value in (given or {}).items():
        if name not in rules.parameters:
            having = ", ".join(rules.parameters) or "none"
            raise ValueError(f"parameters has no {name!r}; this game has: {having}")
        check_integer(f"parameters[{name!r}]", value, -(2**31), 2**31 - 1)
    return tuple((given or {}).items())


@lru_cache(maxsize=64)
def compiled_for_players(
    game: Game, image: bytes, parameters: tuple[tuple[str, int], ...] = (), corrected: bool = False
) -> _emulator.Game:
    """The game with its rules for several players, built once and shared."""
    rules = rules_of(game)
    step_rules = rules.corrected if corrected and rules.corrected else rules.rules
    if parameters:
        step_rules = replace(step_rules, state={**step_rules.state, **dict(parameters)})
    return make_game(
        game,
        image,
        compile_rules(step_rules),
        legal_actions=range(18),
        starting_actions=rules.starting_actions,
        default_mode=rules.loading_mode,
        paddle_range=rules.paddle_range,
    )
