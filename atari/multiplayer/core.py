"""`MultiplayerCore`: a game of two to four players on the native emulator, without an environment around it."""

import inspect
import operator
from collections.abc import Sequence
from os import PathLike
from typing import Any, ClassVar, Literal

import atari._emulator as _emulator
from atari.base.validation import check_integer, check_name
from atari.cores import writes
from atari.cores.compiled import compiled_for_players
from atari.cores.native import STATE_VERSION, EmulatorCore, as_ale_reads
from atari.cores.options import SEED_LIMIT
from atari.games.game import Game
from atari.games.multiplayer import Multiplayer
from atari.games.players import choose_mode, rules_of
from atari.multiplayer.resolution import resolve_several
from atari.roms import find
from atari.roms import image as rom_image
from atari.task import Task
from atari.task.checks import check_bool
from atari.task.fields import DEFAULTS, FIELDS, GROUPS
from atari.task.task import GameLike

Reference = Literal["multi_agent_ale", "ale_py"]
REFERENCES: tuple[Reference, ...] = ("multi_agent_ale", "ale_py")
OF_CORE = (
    *GROUPS["game"],
    "repeat_action_probability",
    "frameskip",
    "interventions",
    "max_num_frames_per_episode",
)
"""The fields of a task that a core honours."""

_BASE = {"repeat_action_probability": 0.0, "frameskip": 1, "max_num_frames_per_episode": None}
"""Defaults of a game without a task, instead of the defaults of ALE's v5 environments."""

_RESTORED = ("repeat_action_probability", "parameters", "corrected_scores", "end_of_reset", "random_words")
"""Options outside a snapshot, which must be equal in two cores for the same continuation."""


class MultiplayerCore(EmulatorCore):
    """A game for two to four players. All players see one screen, and act in each frame.

    It is an `atari.cores.Core` whose `act` plays an action of player 1, and NOOP of the others.

    Multi-Agent-ALE 0.1.12 is the reference. ale-py's announced version for several players differs in the numbers of
    modes, the end of a reset and the source of random words; each has an option.

    Args:
        game: PettingZoo's name ("pong_v3") or a game's, an environment ID, the path of a game file, a `Game`, or a
            `Task`. A name, a file or a `Game` is played without sticky actions, frame skip and limit.
        seed: for RAM, the timer and sticky actions, 0 .. 2**32 - 1.
        parameters: numbers that the rules use, for example {"max_turn_time": 0}.
        corrected_scores: use the true score if a rule of Multi-Agent-ALE reads a wrong byte (flag_capture); the other
            games have nothing to correct.
        mode_numbers: the project whose numbers `mode` has.
        end_of_reset: Multi-Agent-ALE's, in which player 2 also makes the starting actions; or ale-py's.
        random_words: one generator for the machine and sticky actions, as in Multi-Agent-ALE; or ale-py's two.
        sound: fill `audio()`.
        rom: path of the ROM file; None searches.
        **options: the fields of `Task` that `OF_CORE` names: `players` (None means the mode's number), `mode`,
            `difficulty`, `repeat_action_probability` (a number, or one for each player), `frameskip`,
            `max_num_frames_per_episode` and `interventions`; and PettingZoo's parameters (`num_players`).

    Attributes:
        task: the task.

    Raises:
        ValueError, TypeError: an option is wrong, or the game has no rules for several players; or the task has a field
            that only an environment plays.

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
        game: GameLike,
        *,
        seed: int = 1,
        parameters: dict[str, int] | None = None,
        corrected_scores: bool = False,
        mode_numbers: Reference = "multi_agent_ale",
        end_of_reset: Reference = "multi_agent_ale",
        random_words: Reference = "multi_agent_ale",
        sound: bool = False,
        rom: str | PathLike[str] | None = None,
        **options: Any,
    ) -> None:
        references = {"mode_numbers": mode_numbers, "end_of_reset": end_of_reset, "random_words": random_words}
        for name, value in references.items():
            check_name(name, value, REFERENCES)
        task, _ = resolve_several(game, None, options, _BASE, "MultiplayerCore", OWN_OPTIONS, mode_numbers == "ale_py")
        self.task: Task = task
        _check_fields(task)
        self.game: Game = task.definition
        self.rom = rom
        self.rules = rules_of(self.game)
        mode, self.players = choose_mode(self.game, task.mode, task.players)
        self.sound = bool(sound)
        self.frame_skip = task.frames[0]
        limit = task.max_num_frames_per_episode or 0
        sticky = task.repeat_action_probability
        each = sticky if isinstance(sticky, tuple) else (sticky,) * self.players
        probabilities = [as_ale_reads(probability) for probability in each]
        self.options: dict[str, Any] = {
            "corrected_scores": check_bool("corrected_scores", corrected_scores),
            "difficulty": task.set_difficulty,
            "end_of_reset": end_of_reset,
            "max_num_frames_per_episode": limit,
            "mode": mode + (self.rules.mode_offset if mode_numbers == "ale_py" else 0),
            "mode_numbers": mode_numbers,
            "parameters": dict(parameters or {}),
            "players": self.players,
            "random_words": random_words,
            "repeat_action_probability": probabilities,
            "seed": operator.index(seed),
        }
        """The options named by `OPTIONS`, with the defaults filled in, in types of JSON."""
        image = rom_image.read_image(find(self.game, rom))
        self.rom_md5 = rom_image.md5(image)
        super().__init__(
            game=compiled_for_players(
                self.game, image, _parameters(self.rules, parameters), self.options["corrected_scores"]
            ),
            repeat_action_probability=probabilities[0],
            player_probabilities=probabilities,
            frame_skip=self.frame_skip,
            max_num_frames_per_episode=limit,
            sound=self.sound,
            color_averaging=False,
            seed=check_integer("seed", seed, 0, SEED_LIMIT - 1),
            one_generator=random_words == "multi_agent_ale",
            second_player_starts=end_of_reset == "multi_agent_ale",
        )
        super().set_mode(mode)
        if task.set_difficulty is not None:
            super().set_difficulty(task.set_difficulty)
        for write in writes.make_writes(self.game, task.interventions):
            self.add_write(write)

    def act_players(self, actions: Sequence[int]) -> list[int]:
        """Play `frameskip` frames with an action (0 .. 17, an ALE number) of each player; returns a reward for each."""
        if len(actions) != self.players:
            raise ValueError(f"there are {self.players} players, got {len(actions)} actions")
        return super().act_players(actions)

    # `__wrapped__` lets `_emulator.Episode`, which has an action of each player, play this core in C++.
    act_players.__signature__ = inspect.signature(act_players)  # type: ignore[attr-defined]
    act_players.__wrapped__ = _emulator.Emulator.act_players  # type: ignore[attr-defined]

    @property
    def player_lives(self) -> list[int]:
        """Lives of each player: 0 in games without lives, -1 if the player is out."""
        return super().player_lives[: self.players]

    def seed(self, seed: int) -> None:
        """Start over with this seed, without loading the game again."""
        super().seed(check_integer("seed", seed, 0, SEED_LIMIT - 1))

    def set_mode(self, mode: int) -> None:
        """Play one of the modes for these players, by Multi-Agent-ALE's number, from the next reset on."""
        chosen, _ = choose_mode(self.game, check_integer("mode", mode, -(2**31), 2**31 - 1), self.players)
        self.options["mode"] += chosen - self.mode
        self.task = self.task.with_checked(mode=chosen)
        super().set_mode(chosen)

    def set_difficulty(self, difficulty: int) -> None:
        """Play one of the game's difficulties from the next frame on."""
        if check_integer("difficulty", difficulty, 0, 3) not in self.rules.difficulties:
            raise ValueError(
                f"difficulty of {self.game.id} must be one of {self.rules.difficulties}, got {difficulty!r}"
            )
        self.task = self.task.with_checked(difficulty=difficulty)
        self.options["difficulty"] = self.task.set_difficulty
        super().set_difficulty(difficulty)

    def with_options(self, **fields: Any) -> "MultiplayerCore":
        """A new core with other fields of the task, which has not begun a game.

        Raises:
            TypeError, ValueError: see `Task.of`.
        """
        return type(self)(**{**self._arguments(), "game": self.task.replace(**fields)})

    def _arguments(self) -> dict[str, Any]:
        own = {name: self.options[name] for name in ("seed", *OWN_OPTIONS) if name != "sound"}
        return {"game": self.task, "rom": self.rom, "sound": self.sound, **own}

    def _check(self, facts: dict[str, Any]) -> None:
        modes = self.rules.modes
        of = next((players for players, numbers in modes.items() if facts.get("mode") in numbers), self.players)
        if facts.get("game") == self.game.id and of != self.players:
            raise ValueError(
                f"the snapshot is of a game of {of} players, not of {self.players}; "
                f"restore it into one with players={of}"
            )
        super()._check(facts)

    def _facts(self) -> dict[str, Any]:
        return {
            "core": self.name,
            "game": self.game.id,
            "rom": self.rom_md5,
            "state version": STATE_VERSION,
            "mode": self.mode,
            "interventions": writes.fact(self.task.interventions),
            **{option: self.options[option] for option in _RESTORED},
        }


OWN_OPTIONS = (
    "parameters",
    "corrected_scores",
    "mode_numbers",
    "end_of_reset",
    "random_words",
    "sound",
)
"""Options of `MultiplayerCore` that are no fields of a task, and that `MultiplayerEnv` has, too."""


def _check_fields(task: Task) -> None:
    for name in FIELDS:
        if name not in OF_CORE and getattr(task, name) != DEFAULTS[name]:
            raise ValueError(
                f"MultiplayerCore plays frames, and {name}={getattr(task, name)!r} is of an environment; "
                "use MultiplayerEnv or AtariVectorEnv, or leave it out"
            )
    if isinstance(task.frameskip, tuple):
        raise ValueError(
            f"MultiplayerCore plays an equal number of frames in each step, got frameskip={task.frameskip}; "
            "use MultiplayerEnv, or a number"
        )


def _parameters(rules: Multiplayer, given: dict[str, int] | None) -> tuple[tuple[str, int], ...]:
    for name, value in (given or {}).items():
        if name not in rules.parameters:
            having = ", ".join(rules.parameters) or "none"
            raise ValueError(f"parameters has no {name!r}; this game has: {having}")
        check_integer(f"parameters[{name!r}]", value, -(2**31), 2**31 - 1)
    return tuple((given or {}).items())
