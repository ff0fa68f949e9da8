"""`MultiplayerEnv`: a task of two to four players as a parallel environment of PettingZoo."""

import copy
from collections.abc import Mapping, Sequence
from os import PathLike
from typing import Any

import gymnasium
import numpy as np
from gymnasium import spaces
from gymnasium.utils import seeding
from numpy.typing import NDArray
from pettingzoo import ParallelEnv
from typing_extensions import Self

import atari._emulator as _emulator
from atari.base.notebook import picture
from atari.base.png import png
from atari.base.validation import check_integer, check_known, check_name
from atari.cores import snapshot
from atari.env.settings import make_episode
from atari.games.actions import PLAYER_ACTIONS
from atari.multiplayer.ale import Console, MultiplayerAle
from atari.multiplayer.core import OF_CORE, OWN_OPTIONS, REFERENCES, MultiplayerCore
from atari.multiplayer.names import OBS_TYPES, PettingZooNames
from atari.multiplayer.resolution import resolve_several
from atari.task import Task
from atari.task.checks import NO_LIMIT
from atari.task.json_form import identity, require_same
from atari.task.task import GameLike
from atari.vector.layout import Layout
from atari.vector.results import indexed, zero_sum
from atari.vector.seeds import words_of

AGENTS = ("first_0", "second_0", "third_0", "fourth_0")

_BASE = {
    "repeat_action_probability": 0.0,
    "frameskip": 1,
    "max_num_frames_per_episode": None,
    "max_episode_steps": 100_000,
    "seeding": "ale",
}
"""Defaults of a game without a task, as in PettingZoo's environments, instead of the defaults of ALE's v5."""

Infos = dict[str, dict[str, Any]]


class MultiplayerEnv(PettingZooNames, ParallelEnv[str, Any, int]):
    """All agents act in each step. Without `agent_indicator`, they see the same observation.

    A name without a preset has the spaces, rewards, ends and infos of PettingZoo's Atari environments. Any task
    for several players is played like in `AtariVectorEnv`, with the channels of images last. `parallel_env` and `env`
    put PettingZoo's checks around this fast class.

    Observations are uint8: (rows, columns, 3) for obs_type="rgb", (rows, columns) for "grayscale" and (128,) for "ram",
    or a dict; with `stack_num` images are (rows, columns, stack_num), in RGB (rows, columns, 3 * stack_num).

    Args:
        game: a name of PettingZoo's with or without version ("pong_v3", "pong"), the id of a game that has rules for
            several players ("backgammon"), an environment ID, the path of a game file, a `Game`, or a `Task`.
        preset: name of a preprocessing, one of `atari.PRESETS` for several players: "multiplayer_dqn".
        render_mode: None, "rgb_array", or "human", a window.
        rom: a ROM file, or a folder with ROM files; None searches like `atari.roms.find`. PettingZoo's name is
            `auto_rom_install_path`.
        seed: for the first game; None takes a random one.
        action_sets: the names of each agent's actions, a list for each agent in their order, or by agent; None
            gives all agents the actions of the task.
        **options: fields of `Task`; the parameters of PettingZoo's environment (for example `num_players=4` of pong);
            and the options of `MultiplayerCore` that are no fields: `parameters`, `corrected_scores`, `mode_numbers`,
            `end_of_reset`, `random_words`, `sound`. PettingZoo's `max_cycles` is another name of `max_episode_steps`,
            obs_type="rgb_image" of "rgb", and "grayscale_image" of "grayscale" with stack_num=1.

    Attributes:
        task: the task.
        core: the `MultiplayerCore`.
        frame: steps of the episode.
        np_random: PettingZoo's generator of the last seed, from which SuperSuit's `frame_skip_v0` draws. The game does
            not draw from it.

    Raises:
        ValueError, TypeError: a name, a parameter or an option does not exist, or a field is for one player.

    Example:
        >>> from atari.multiplayer import parallel_env
        >>> env = parallel_env("pong", num_players=4)
        >>> observations, infos = env.reset(seed=42)
        >>> env.agents
        ['first_0', 'second_0', 'third_0', 'fourth_0']
        >>> actions = {agent: env.action_space(agent).sample() for agent in env.agents}
        >>> observations, rewards, terminations, truncations, infos = env.step(actions)
        >>> observations["first_0"].shape
        (210, 160, 3)
    """

    def __init__(
        self,
        game: GameLike,
        *,
        preset: str | None = None,
        render_mode: str | None = None,
        rom: str | PathLike[str] | None = None,
        auto_rom_install_path: str | PathLike[str] | None = None,
        seed: int | None = None,
        action_sets: Sequence[Sequence[str]] | Mapping[str, Sequence[str]] | None = None,
        **options: Any,
    ) -> None:
        if render_mode is not None:
            check_name("render_mode", render_mode, ("human", "rgb_array"))
        if rom is not None and auto_rom_install_path is not None:
            raise TypeError("auto_rom_install_path and rom are two names of one option; give one of them")
        own = {name: options.pop(name) for name in OWN_OPTIONS if name in options}
        if action_sets is not None and (given := {"actions", "full_action_space"} & {*options}):
            raise ValueError(f"give {min(given)} or action_sets, not both")
        others = ("max_cycles", "render_mode", "rom", "action_sets", *own)
        translated = _translated(options, preset)
        ale_numbers = check_name("mode_numbers", own.pop("mode_numbers", REFERENCES[0]), REFERENCES) == "ale_py"
        self._task, name = resolve_several(game, preset, translated, _BASE, "MultiplayerEnv", others, ale_numbers)
        self.render_mode = render_mode
        self.metadata = {
            "render_modes": ["human", "rgb_array"],
            "name": name,
            "render_fps": 60,
            "is_parallelizable": True,
        }
        channels_last = self._task.stack_num is not None and self._task.kind.image is not None
        self._layout = Layout.check(self._task, channels_last, "uint8")
        seed = int(np.random.SeedSequence().generate_state(1)[0]) if seed is None else _checked(seed)
        emulated = {name: getattr(self._task, name) for name in OF_CORE if name not in ("game", "frameskip")}
        self.core = MultiplayerCore(
            Task(self._task.definition, frameskip=1, **emulated),  # type: ignore[arg-type]
            rom=rom if auto_rom_install_path is None else auto_rom_install_path,
            **own,
        )
        settings = {
            "random_seed": 0,
            "repeat_action_probability": float(np.max(self._task.repeat_action_probability)),
            "max_num_frames_per_episode": self._task.max_num_frames_per_episode or 0,
            "sound_obs": self.core.sound,
        }
        self._console = Console(self, settings, {"frame_skip": "make the environment with frameskip"})
        self._ale = MultiplayerAle(self._console)
        self.possible_agents = list(AGENTS[: self.core.players])
        self.agents = self.possible_agents[:]
        sets = [[action.name for action in self._task.action_set]] * self.core.players
        self._actions = _own_actions(sets if action_sets is None else action_sets, self.possible_agents)
        self.action_mappings = {agent: np.array(numbers, np.int32) for agent, numbers in self._actions.items()}
        self.action_mapping = self.action_mappings[self.possible_agents[0]]
        self.action_spaces = {agent: spaces.Discrete(len(numbers)) for agent, numbers in self._actions.items()}
        self._episode = self._make_episode(self._load(seed))
        seen = self._seen_by(self.possible_agents, self._episode.observation)
        self.observation_spaces = {agent: _space(observation) for agent, observation in seen.items()}
        self._window: Any = None

    def observation_space(self, agent: str) -> spaces.Space[Any]:
        """The space of an agent's observations."""
        return self.observation_spaces[agent]

    def action_space(self, agent: str) -> spaces.Discrete:
        """The space of an agent's actions: indices into `action_mappings[agent]`, which has ALE's numbers."""
        return self.action_spaces[agent]

    def reset(self, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[dict[str, Any], Infos]:
        """Begin a new game. With a seed, the game is loaded again, so that equal seeds give equal games.

        There are no options but one without effect, "options", which PettingZoo's API tests give.

        Raises:
            TypeError: there is no such option.
            ValueError: the seed is not within 0..2**63-1.
        """
        check_known("reset", [str(name) for name in options or {} if name != "options"], ("seed",))
        seed = None if seed is None else _checked(seed)

        def begin() -> Any:
            if seed is not None:
                self._load(seed)
            self.core.reset()
            return self.core

        words = None if seed is None else self._words(seed)
        observation, _ = self._episode.reset(self.core, begin, seed=words)
        self.agents = self.possible_agents[:]
        return self._seen_by(self.agents, observation), {agent: {} for agent in self.agents}

    def step(
        self, actions: dict[str, int]
    ) -> tuple[dict[str, Any], dict[str, Any], dict[str, bool], dict[str, bool], Infos]:
        """Play a step. An agent without an action, or that has ended, takes action 0 of the action space."""
        agents = self.agents
        if not agents:
            return {}, {}, {}, {}, {}
        moves = {agent: actions.get(agent, 0) if agent in agents else 0 for agent in self.possible_agents}
        numbers = [self._actions[agent][index] for agent, index in moves.items()]
        observation, paid, terminated, truncated, _ = self._episode.step(self.core, numbers)
        out = dict(zip(self.possible_agents, self._episode.out, strict=True))
        terminations = {agent: terminated or out[agent] for agent in agents}
        truncations = {agent: truncated and not out[agent] for agent in agents}
        self.agents = [agent for agent in agents if not terminations[agent]]  # truncated agents stay, as in PettingZoo
        if self.render_mode == "human":
            self.render()
        amounts: Any = np.array(paid, np.int32)
        if self._task.zero_sum:
            amounts = zero_sum(amounts[None])[0]
        rewards = dict(zip(self.possible_agents, amounts, strict=True))
        return (
            self._seen_by(agents, observation),
            {agent: rewards[agent] for agent in agents},
            terminations,
            truncations,
            {agent: {} for agent in agents},
        )

    def _repr_html_(self) -> str:
        """The screen, for a notebook."""
        game, playing = self.core.game, ", ".join(self.agents)
        caption = f"{game.title}: frame {self.core.episode_frame_number:,}, {playing or 'the game is over'}"
        return picture(png(self.core.screen_rgb()), caption, game.screen.shape)

    def render(self) -> NDArray[np.uint8] | None:
        """The screen (rows, 160, 3), or None and a window."""
        if self.render_mode is None:
            gymnasium.logger.warn("render() does nothing without a render_mode; give render_mode='rgb_array'")
            return None
        screen: NDArray[np.uint8] = self.core.screen_rgb()
        if self.render_mode == "rgb_array":
            return screen
        from atari.env.rendering import Window  # it needs pygame

        if self._window is None:
            self._window = Window(self.core.game, self.core.game.screen.frame_rate)
        self._window.show(screen)
        return None

    def snapshot(self) -> bytes:
        """The whole environment as portable bytes: task, game, all generators, counters, agents and stacked images."""
        facts = {"of": "MultiplayerEnv", "task": identity(self.task), "agents": self.agents}
        return snapshot.pack(facts, {"core": self.core.snapshot(), "episode": self._episode.save()})

    def restore(self, data: bytes) -> None:
        """Continue from a result of `snapshot`, also in another process.

        Raises:
            TypeError, ValueError: it is no such result, is damaged, or belongs to another task; nothing has changed.
        """
        facts, blobs = snapshot.unpack(data)
        snapshot.require(facts, {"of": "MultiplayerEnv"})
        require_same(facts.get("task"), self.task)
        snapshot.require_blobs(blobs, "core", "episode")
        episode, agents = self._continued(blobs["episode"]), facts.get("agents")
        playing = [agent for agent, out in zip(self.possible_agents, episode.out, strict=True) if not out]
        if not isinstance(agents, list) or agents != [agent for agent in playing if agent in agents]:
            raise ValueError(f"the snapshot is damaged: its agents cannot be {agents!r:.200}")
        self.core.restore(blobs["core"])
        self._episode, self.agents = episode, agents

    def __getstate__(self) -> dict[str, Any]:
        """Pickling and copying keep the position in the game; a copy opens a window of its own."""
        return {**vars(self), "_window": None, "_episode": self._episode.save()}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self._episode = self._continued(state["_episode"])

    def __copy__(self) -> Self:
        """A copy with a core of its own."""
        return copy.deepcopy(self)

    def close(self) -> None:
        """Close the window, if there is one."""
        if self._window is not None:
            self._window.close()
            self._window = None

    def _make_episode(self, seed: list[int] | None = None) -> _emulator.Episode:
        idle = [self._actions[agent][0] for agent in self.possible_agents]
        return make_episode(self._task, idle=idle, seed=seed)

    def _continued(self, state: bytes) -> _emulator.Episode:
        episode = self._make_episode()
        episode.load(state)
        return episode

    def _words(self, seed: int) -> list[int]:
        """The seeds of the core and of the episode's generator, as in the lane of a vector."""
        return words_of(seed, ale=self._task.seeding == "ale")

    def _load(self, seed: int) -> list[int]:
        """Load the game again with a seed, and return its words."""
        self.np_random = seeding.np_random(seed)[0]
        words = self._words(seed)
        self._console.ale_settings.set_seed(words[0])
        self._console.load_game()
        return words

    def _seen_by(self, agents: Sequence[str], observation: Any) -> dict[str, Any]:
        """The observation of each agent, from one of the engine."""
        seen = indexed(self._layout.apply(indexed(observation, np.newaxis)), 0)
        if not self._task.agent_indicator:
            return dict.fromkeys(agents, seen)
        return {agent: indexed(seen, self.possible_agents.index(agent)) for agent in agents}


def _checked(seed: Any) -> int:
    return check_integer("seed", seed, 0, 2**63 - 1)


def _space(observation: Any) -> spaces.Space[Any]:
    if isinstance(observation, dict):
        return spaces.Dict({name: _space(part) for name, part in observation.items()})
    return spaces.Box(0, 255, observation.shape, np.uint8)


def _translated(options: Mapping[str, Any], preset: str | None) -> dict[str, Any]:
    """PettingZoo's options with the names of a task."""
    fields = dict(options)
    if "max_cycles" in fields:
        if "max_episode_steps" in fields:
            raise TypeError("max_cycles and max_episode_steps are two names of one option; give one of them")
        fields["max_episode_steps"] = check_integer("max_cycles", fields.pop("max_cycles"), 1, NO_LIMIT)
    kind = fields.get("obs_type")
    if isinstance(kind, str) and kind in OBS_TYPES:
        fields["obs_type"] = OBS_TYPES[kind]
        if kind == "grayscale_image" and preset is None:
            fields.setdefault("stack_num", 1)
    return fields


def _own_actions(sets: Any, agents: list[str]) -> dict[str, list[int]]:
    """ALE's numbers of each agent's actions, from their names."""
    if isinstance(sets, Mapping):
        if set(sets) != set(agents):
            raise ValueError(f"action_sets must have a list for each of {', '.join(agents)}, got {', '.join(sets)}")
        sets = [sets[agent] for agent in agents]
    if not isinstance(sets, (list, tuple)) or not all(isinstance(names, (list, tuple)) for names in sets):
        raise TypeError(f"action_sets must be a list of names for each agent, or those by agent, got {sets!r}")
    if len(sets) != len(agents):
        raise ValueError(f"action_sets must have {len(agents)} lists, one for each agent, got {len(sets)}")
    numbers = {action.name: int(action) for action in PLAYER_ACTIONS}
    for agent, names in zip(agents, sets, strict=True):
        if not names or len(set(map(str, names))) != len(names):
            raise ValueError(f"action_sets of {agent} must have one action or more, each once, got {names!r}")
        for name in names:
            check_name(f"action_sets of {agent}: an action", name, numbers)
    return {agent: [numbers[name] for name in names] for agent, names in zip(agents, sets, strict=True)}
