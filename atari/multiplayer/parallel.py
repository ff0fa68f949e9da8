"""`MultiplayerEnv`: a game of two to four players as a parallel environment of PettingZoo."""

from collections.abc import Iterable, Mapping, Sequence
from os import PathLike
from typing import Any, Literal

import gymnasium
import numpy as np
from gymnasium import spaces
from gymnasium.utils import seeding
from numpy.typing import NDArray
from pettingzoo import ParallelEnv

from atari.actions import PLAYER_ACTIONS
from atari.multiplayer.core import MultiplayerCore, check_switch
from atari.multiplayer.environments import find_environment
from atari.validation import check_integer, check_known, check_name

AGENTS = ("first_0", "second_0", "third_0", "fourth_0")
OBSERVATION_TYPES = ("rgb_image", "grayscale_image", "ram")


class MultiplayerEnv(ParallelEnv[str, NDArray[np.uint8], int]):
    """All agents act in each frame, and see the same observation.

    Spaces, rewards, ends and infos are those of PettingZoo's Atari environments. `parallel_env` and `env` put
    PettingZoo's checks around it; this class is the fast inside.

    Args:
        game: a name of PettingZoo's with or without version ("pong_v3", "pong"), or the id of a game that has rules for
            several players ("backgammon").
        obs_type: "rgb_image" (rows, 160, 3), "grayscale_image" (rows, 160, 1) or "ram" (128,), each uint8.
        full_action_space: all 18 actions instead of those that have an effect.
        max_cycles: steps until all agents are truncated.
        render_mode: None, "rgb_array", or "human", a window.
        auto_rom_install_path: a folder with ROM files; None searches as `atari.roms.find` does.
        seed: of the first game; None takes a random one.
        zero_sum: give each player its reward minus the mean of the others' rewards, as np.float64. The sum over all
            players, those that have ended included, is 0. Rewards of two players that are zero-sum already are doubled;
            in teams of two that are, they become 4/3 of what they were.
        action_sets: the names of each agent's actions, a list for each in their order, or by agent; None gives all
            agents the same set. Not with `full_action_space`.
        **options: the parameters of the environment (for example `num_players=4` of pong), and options of
            `MultiplayerCore`.

    Raises:
        ValueError, TypeError: a name, a parameter or an option that does not exist.

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
        game: str,
        *,
        obs_type: Literal["rgb_image", "grayscale_image", "ram"] = "rgb_image",
        full_action_space: bool = False,
        max_cycles: int = 100_000,
        render_mode: str | None = None,
        auto_rom_install_path: str | PathLike[str] | None = None,
        seed: int | None = None,
        zero_sum: bool = False,
        action_sets: Sequence[Sequence[str]] | Mapping[str, Sequence[str]] | None = None,
        **options: Any,
    ) -> None:
        self.obs_type = check_name("obs_type", obs_type, OBSERVATION_TYPES)
        self.max_cycles = check_integer("max_cycles", max_cycles, 1, 2**31 - 1)
        if render_mode is not None:
            check_name("render_mode", render_mode, ("human", "rgb_array"))
        self.render_mode = render_mode
        environment = find_environment(game)
        if environment is not None:
            own = {name: options.pop(name) for name in list(options) if name in environment.defaults}
            known = _CORE_OPTIONS | set(environment.defaults)
            check_known(environment.id, set(options) - known, sorted(known))
            if "mode" not in options:
                options["mode"] = environment.choose(own)
            elif own:
                raise ValueError(f"give mode or {next(iter(own))}, not both")
        else:
            check_known(game, set(options) - _CORE_OPTIONS, sorted(_CORE_OPTIONS))
        name = environment.id if environment else f"custom_{game}"
        if seed is not None:
            check_integer("seed", seed, 0, 2**63 - 1)
        self.np_random, first_seed = seeding.np_random(seed)
        self.core = MultiplayerCore(
            environment.game if environment else game,
            seed=first_seed % 2**32,
            rom=auto_rom_install_path,
            **options,
        )
        self.metadata = {
            "render_modes": ["human", "rgb_array"],
            "name": name,
            "render_fps": 60,
            "is_parallelizable": True,
        }
        self.possible_agents = list(AGENTS[: self.core.players])
        self.agents = self.possible_agents[:]
        self.zero_sum = check_switch("zero_sum", zero_sum)
        if action_sets is None:
            actions = PLAYER_ACTIONS if full_action_space else self.core.rules.minimal_actions
            self._actions = {agent: [int(a) for a in actions] for agent in self.possible_agents}
        elif full_action_space:
            raise ValueError("give full_action_space or action_sets, not both")
        else:
            self._actions = _own_actions(action_sets, self.possible_agents)
        self.action_mappings = {agent: np.array(numbers, np.int32) for agent, numbers in self._actions.items()}
        self.action_mapping = self.action_mappings[self.possible_agents[0]]
        self.action_spaces = {agent: spaces.Discrete(len(numbers)) for agent, numbers in self._actions.items()}
        space = spaces.Box(0, 255, self._observe().shape, np.uint8)
        self.observation_spaces = dict.fromkeys(self.possible_agents, space)
        self.frame = 0
        self._window: Any = None

    def observation_space(self, agent: str) -> spaces.Box:
        """The space of an agent's observations, the same for all."""
        return self.observation_spaces[agent]

    def action_space(self, agent: str) -> spaces.Discrete:
        """The space of an agent's actions: indices into `action_mappings[agent]`, which has ALE's numbers."""
        return self.action_spaces[agent]

    def reset(
        self, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, NDArray[np.uint8]], dict[str, dict[str, Any]]]:
        """Begin a new game. With a seed, the console is loaded anew, so that equal seeds give equal games."""
        self.np_random, number = seeding.np_random(seed)
        if seed is not None:
            self.core.seed(number % 2**32)
        self.core.reset()
        self.agents = self.possible_agents[:]
        self.frame = 0
        return dict.fromkeys(self.agents, self._observe()), {agent: {} for agent in self.agents}

    def step(
        self, actions: dict[str, int]
    ) -> tuple[
        dict[str, NDArray[np.uint8]],
        dict[str, Any],
        dict[str, bool],
        dict[str, bool],
        dict[str, dict[str, Any]],
    ]:
        """Play a frame. An agent without an action, or that has ended, takes action 0 of the action space."""
        chosen = [numbers[actions.get(agent, 0)] for agent, numbers in self._actions.items()]
        paid: Iterable[Any] = self.core.act_players(chosen)
        paid = _zero_sum(list(paid)) if self.zero_sum else map(np.int32, paid)
        rewards = dict(zip(self.possible_agents, paid, strict=True))
        self.frame += 1
        agents = self.agents
        if self.core.game_over or self.core.truncated:
            terminations = dict.fromkeys(agents, True)
        else:
            lives = dict(zip(self.possible_agents, self.core.player_lives, strict=True))
            terminations = {agent: lives[agent] < 0 for agent in agents}
        self.agents = [agent for agent in agents if not terminations[agent]]
        if self.render_mode == "human":
            self.render()
        return (
            dict.fromkeys(agents, self._observe()),
            {agent: rewards[agent] for agent in agents},
            terminations,
            dict.fromkeys(agents, self.frame >= self.max_cycles),
            {agent: {} for agent in agents},
        )

    def render(self) -> NDArray[np.uint8] | None:
        """The screen (rows, 160, 3), or None and a window."""
        if self.render_mode is None:
            gymnasium.logger.warn("render() does nothing without a render_mode; give render_mode='rgb_array'")
            return None
        screen = self.core.screen_rgb()
        if self.render_mode == "rgb_array":
            return screen
        from atari.rendering import Window  # needs pygame

        if self._window is None:
            self._window = Window(self.core.game, self.core.game.screen.frame_rate)
        self._window.show(screen)
        return None

    def snapshot(self) -> tuple[bytes, int, tuple[str, ...]]:
        """The state of the game, its step and the agents in it."""
        return self.core.snapshot(), self.frame, tuple(self.agents)

    def restore(self, snapshot: tuple[bytes, int, tuple[str, ...]]) -> None:
        """Continue from what `snapshot` returned."""
        data, frame, agents = snapshot
        self.core.restore(data)
        self.frame, self.agents = frame, list(agents)

    def close(self) -> None:
        """Close the window, if there is one."""
        if self._window is not None:
            self._window.close()
            self._window = None

    def _observe(self) -> NDArray[np.uint8]:
        if self.obs_type == "ram":
            return self.core.ram()
        if self.obs_type == "rgb_image":
            return self.core.screen_rgb()
        return self.core.screen_grayscale()[..., None]


def _zero_sum(rewards: list[int]) -> list[np.float64]:
    """Each reward minus the mean of the others, by one division of whole numbers."""
    total, players = sum(rewards), len(rewards)
    return [np.float64((players * reward - total) / (players - 1)) for reward in rewards]


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


_CORE_OPTIONS = frozenset(
    "mode players repeat_action_probability difficulty frame_skip max_num_frames_per_episode parameters "
    "corrected_scores mode_numbers end_of_reset random_words sound".split()
)
"""The options that are passed on to `MultiplayerCore`."""
