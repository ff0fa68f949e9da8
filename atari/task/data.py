"""`TaskData`: the fields of a `Task`, the checks of its constructor, and what follows from the fields."""

import copy
import operator
from dataclasses import dataclass, field
from typing import Any

from typing_extensions import Self

from atari.base.validation import check_integer
from atari.cores.compiled import reward_formula
from atari.cores.options import CoreOptions
from atari.cores.writes import make_writes
from atari.games.actions import PLAYER_ACTIONS, Action
from atari.games.catalog import fingerprint, games
from atari.games.game import Game
from atari.games.interventions import resolve
from atari.games.players import choose_mode, rules_of
from atari.task.fields import DEFAULTS, FIELDS, GROUPS, WRAPPED, TaskFields, check_field
from atari.task.observation_kinds import KINDS, Kind
from atari.task.rules import check_together, default_ineffective


@dataclass(frozen=True, repr=False)
class TaskData(TaskFields):
    """The fields of a task, checked and completed, and what follows from them; see `Task`."""

    definition: Game = field(init=False, compare=False)
    """The game definition."""

    def __post_init__(self) -> None:
        fields = {name: check_field(name, getattr(self, name)) for name in FIELDS}
        self._find_game(fields)
        default_ineffective(fields, given=FIELDS)
        check_together(fields, self.definition)
        self._name_action_set(fields)
        for name, value in fields.items():
            object.__setattr__(self, name, value)
        if self.sound_obs and (others := self.fields_of_wrappers()):
            raise ValueError(
                f"sound_obs=True is for an AtariEnv without wrappers, and {others[0]}={getattr(self, others[0])!r} "
                "needs them; leave one of them out"
            )
        if self.third_action and Action.FIRE in self.begin_actions and len(self.begin_actions) < 3:
            raise ValueError(
                f"third_action=True plays the third action, and {self.game} has only {len(self.begin_actions)}; "
                "use actions='full'"
            )

    def _find_game(self, fields: dict[str, Any]) -> None:
        """Resolve the fields that depend on the game: its id, mode, difficulty and interventions."""
        several = fields["players"] > 1
        game = games.resolve(fields["game"]) if several else games.find(fields["game"])
        object.__setattr__(self, "definition", game)
        fields["game"] = game.id
        fields["rules"] = fields["rules"] or fingerprint(game)
        fields["interventions"] = resolve(game, fields["interventions"])
        make_writes(game, fields["interventions"])  # as a core does: the values of a label depend on the compiled write
        if fields["reward"] is not None:
            reward_formula(game, fields["reward"])
        if several:
            rules = rules_of(game)
            fields["mode"], _ = choose_mode(game, fields["mode"], fields["players"])
            difficulty = 0 if fields["difficulty"] is None else check_integer("difficulty", fields["difficulty"], 0, 3)
            if difficulty not in rules.difficulties and fields["difficulty"] is not None:
                raise ValueError(f"difficulty of {game.id} must be one of {rules.difficulties}, got {difficulty}")
            fields["difficulty"] = difficulty
            return
        chosen = fields["difficulty"]
        if isinstance(chosen, int) and chosen == 0:
            chosen = None  # ALE's default, which is not one of backgammon's difficulties
        CoreOptions.check(
            game,
            repeat_action_probability=fields["repeat_action_probability"],
            mode=fields["mode"],
            difficulty=chosen,
            max_num_frames_per_episode=fields["max_num_frames_per_episode"] or 0,
        )
        fields["mode"] = game.default_mode if fields["mode"] is None else operator.index(fields["mode"])
        fields["difficulty"] = 0 if chosen is None else operator.index(chosen)

    def _name_action_set(self, fields: dict[str, Any]) -> None:
        """Check the names of actions, and replace the game's own sets of actions by their names."""
        minimal, full = _action_sets(self.definition, fields["players"])
        chosen = fields["actions"]
        if not isinstance(chosen, str):
            if fields["continuous"]:
                raise ValueError(f"actions={list(chosen)!r} has no effect with continuous=True; leave one of them out")
            wanted = tuple(Action[name] for name in chosen)
            if missing := [action.name for action in wanted if action not in full]:
                raise ValueError(f"{self.definition.id} has no action {missing[0]}; it has {_names(full)}")
            chosen = "minimal" if wanted == minimal else "full" if wanted == full else chosen
        fields["actions"] = "minimal" if chosen == "full" and minimal == full else chosen

    def differences(self, other: "TaskData") -> dict[str, tuple[Any, Any]]:
        """The fields in which two tasks differ, with both values. An unknown ROM equals every ROM.

        Raises:
            TypeError: `other` is no task.
        """
        if not isinstance(other, TaskData):
            raise TypeError(f"a task is compared with a task, got {other!r}; atari.Task.of() makes one")
        pairs = {name: (getattr(self, name), getattr(other, name)) for name in FIELDS}
        if None in pairs["rom_md5"]:
            del pairs["rom_md5"]
        return {name: pair for name, pair in pairs.items() if pair[0] != pair[1]}

    @property
    def action_set(self) -> tuple[Action, ...]:
        """The actions by index."""
        minimal, full = _action_sets(self.definition, self.players)
        if isinstance(self.actions, str):
            return full if self.actions == "full" else minimal
        return tuple(Action[name] for name in self.actions)

    @property
    def begin_actions(self) -> tuple[Action, ...]:
        """The actions for the start of episodes, even if the agent lacks them: all that the game uses.

        If the agent has an action that the game does not use, these are all legal actions.
        """
        minimal, full = _action_sets(self.definition, self.players)
        return minimal if {*self.action_set} <= {*minimal} else full

    @property
    def kind(self) -> Kind:
        """The row of the observation type in `KINDS`."""
        return KINDS[self.obs_type]

    @property
    def new_stack_after_life(self) -> bool:
        """Whether the stack of images begins anew after each lost life that a step returns as a termination."""
        return not self.life_loss_info and (not self.seamless_lives or self.on_reset == "new_game")

    @property
    def new_game_after_life(self) -> bool:
        """Whether a reset after a lost life that ended the episode begins a new game."""
        return self.episodic_life and self.on_reset == "new_game"

    @property
    def preprocessed(self) -> bool:
        """Whether wrappers around an `AtariEnv` play the task; otherwise an `AtariEnv` does alone."""
        return bool(self.fields_of_wrappers())

    def fields_of_wrappers(self) -> list[str]:
        """The fields that an `AtariEnv` alone does not honour."""
        own_shape = [] if self.kind.method else ["obs_type"]
        return [name for name in WRAPPED if getattr(self, name) != DEFAULTS[name]] + own_shape

    def emulator_task(self) -> Self:
        """The part of this task that an `AtariEnv` plays inside the wrappers: single frames."""
        kept = (*GROUPS["game"], *GROUPS["play"], "max_num_frames_per_episode", "sound_obs")
        others = ("game", "rom_md5", "frameskip", *WRAPPED)
        fields = {name: getattr(self, name) for name in kept if name not in others}
        return type(self)(self.definition, frameskip=1, obs_type="rgb" if self.kind.image else "ram", **fields)  # type: ignore[arg-type]

    @property
    def set_mode(self) -> int | None:
        """The mode for a core; None means the default mode of a game for one player."""
        return None if self.players == 1 and self.mode == self.definition.default_mode else self.mode

    @property
    def set_difficulty(self) -> int | None:
        """The difficulty for a core; None means ALE's default, 0."""
        return self.difficulty or None

    def with_checked(self, **fields: Any) -> Self:
        """This task with fields set in the running game, which has checked them."""
        changed = {name: value for name, value in fields.items() if value != getattr(self, name)}
        if not changed:
            return self
        task = copy.copy(self)
        for name, value in changed.items():
            object.__setattr__(task, name, value)
        return task

    @property
    def frames(self) -> tuple[int, int]:
        """The range of the frame skip, (low, high): low..high-1."""
        return self.frameskip if isinstance(self.frameskip, tuple) else (self.frameskip, self.frameskip + 1)

    def __repr__(self) -> str:
        game = str(self.definition.file) if self.definition.file else self.game
        changed = [f"{name}={value!r}" for name, value in self.as_options().items() if value != DEFAULTS[name]]
        return f"Task({', '.join([repr(game), *changed])})"

    def as_options(self) -> dict[str, Any]:
        """The fields other than the game that the game does not decide, with interventions as definitions."""
        fields: dict[str, Any] = {name: getattr(self, name) for name in FIELDS if name != "game"}
        fields["interventions"] = tuple(one.definition() for one in self.interventions)
        if self.rules == fingerprint(self.definition):
            fields["rules"] = ""
        several = self.players > 1
        default = choose_mode(self.definition, None, self.players)[0] if several else None
        fields["mode"] = None if several and self.mode == default else self.set_mode
        fields["difficulty"] = self.set_difficulty
        return fields


def _action_sets(game: Game, players: int) -> tuple[tuple[Action, ...], tuple[Action, ...]]:
    if players > 1:
        return rules_of(game).minimal_actions, PLAYER_ACTIONS
    return game.minimal_actions, game.legal_actions


def _names(actions: tuple[Action, ...]) -> str:
    return ", ".join(action.name for action in actions)
