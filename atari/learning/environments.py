"""The environments that an agent learns in: a vector environment made from the options of the training."""

import pickle
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from atari.actions import Action
from atari.games.catalog import games
from atari.games.game import Game
from atari.learning.options import TrainingOptions
from atari.vector import AtariVectorEnv
from atari.wrappers.presets import preset_protocol

ByteArray = npt.NDArray[np.uint8]


class TrainingEnvironments:
    """Environments with SAME_STEP autoreset, and the scores of the whole games that were played in them.

    Args:
        options: of the training.
        num_envs: how many environments.
        num_threads: threads that play them.
        stacked: whether observations are stacks; otherwise each is a single image or RAM vector.

    Attributes:
        actions: names of the actions; action i of `step` is the i-th of them.
        shape: of an observation.
        padding: what fills the stack at the start of an episode, "zero" or "reset", the first one.
        policy_options: what a policy needs to see the same; see `atari.learning.Policy`.
    """

    def __init__(self, options: TrainingOptions, num_envs: int, num_threads: int = 1, stacked: bool = True) -> None:
        game = games.find(options.game)
        protocol = replace(preset_protocol(options.protocol, episodic_life=options.episodic_life), clip_reward=True)
        if protocol.episodic_life:  # the stack begins anew where the learner's episode does
            protocol = replace(protocol, seamless_lives=False)
        if options.sticky is not None:
            protocol = replace(protocol, repeat_action_probability=options.sticky)
        sees: dict[str, Any] = {"obs_type": "ram"}
        if options.obs == "pixels":
            size, stack = options.image_size, options.stack
            sees = {"obs_type": "grayscale", "img_height": size, "img_width": size, "stack_num": stack}
        given = sees if stacked or options.obs == "ram" else {**sees, "stack_num": 1}
        self._envs = AtariVectorEnv(
            game, num_envs, preset=protocol, autoreset_mode="SameStep", num_threads=num_threads, **given
        )
        self.actions, self._indices = _actions(game, protocol.full_action_space, options.actions)
        self._ram = RamStack(num_envs, options.stack) if options.obs == "ram" and stacked else None
        self.padding = protocol.padding
        space: Any = self._envs.single_observation_space
        self.shape: tuple[int, ...] = space.shape if self._ram is None else self._ram.shape
        stacked_ram = {"ram_stack": options.stack} if options.obs == "ram" else {}
        self.policy_options: dict[str, Any] = {**sees, **stacked_ram, "actions": list(self.actions)}
        self.num_envs = num_envs
        self.games: list[tuple[float, int]] = []

    def reset(self, seed: int) -> ByteArray:
        """Begin new games; environment i is seeded with seed + i."""
        observations, info = self._envs.reset(seed=seed)
        self._count_games(info)
        return observations if self._ram is None else self._ram.push(observations, np.ones(self.num_envs, np.bool_))

    def step(
        self, actions: npt.NDArray[np.int64], out: Any = None
    ) -> tuple[ByteArray, Any, Any, Any, Mapping[str, Any]]:
        """Play one step; rewards are clipped. See `AtariVectorEnv.step`."""
        observations, rewards, terminations, truncations, info = self._envs.step(self._indices[actions], out=out)
        self._count_games(info.get("final_info", {}))
        if self._ram is not None:
            observations = self._ram.push(observations, terminations | truncations)
        return observations, rewards, terminations, truncations, info

    def final_observations(self, info: Mapping[str, Any]) -> ByteArray:
        """The last observations of the episodes that have ended in a step with this `info`; zero elsewhere."""
        final: ByteArray = info["final_obs"]
        return final if self._ram is None else self._ram.final(final)

    def _count_games(self, info: Mapping[str, Any]) -> None:
        if "episode" in info:
            ended = info["_episode"]
            self.games += zip(info["episode"]["r"][ended].tolist(), info["episode"]["l"][ended].tolist(), strict=True)

    def take_games(self) -> list[tuple[float, int]]:
        """Score and length in frames of the whole games that have ended since the last call."""
        taken, self.games = self.games, []
        return taken

    def state(self) -> dict[str, Any]:
        """The positions in all games, as `restore` takes them."""
        return {
            "snapshots": pickle.dumps(self._envs.snapshot()),
            "ram": None if self._ram is None else self._ram.rows.copy(),
        }

    def restore(self, state: dict[str, Any]) -> None:
        """Continue from the positions of `state`."""
        self._envs.reset(seed=0)
        self._envs.restore(None, pickle.loads(state["snapshots"]))
        if self._ram is not None:
            self._ram.rows = state["ram"]
        self.games = []

    def close(self) -> None:
        """Close the environments."""
        self._envs.close()


class RamStack:
    """The last RAM vectors of some environments, (environments, size, 128) uint8, the oldest first.

    At the beginning of an episode all are the first one.
    """

    def __init__(self, num_envs: int, size: int) -> None:
        self.shape = (size, 128)
        self.rows = self._before = np.zeros((num_envs, size, 128), np.uint8)

    def push(
        self, ram: ByteArray, started: npt.NDArray[np.bool_], lanes: npt.NDArray[np.int64] | None = None
    ) -> ByteArray:
        """Add a vector to all environments, or to some `lanes`, and return their stacks, a new array.

        In those that have `started`, the vector is the first.
        """
        self._before = self.rows if lanes is None else self.rows[lanes]
        rows = self.final(ram)
        rows[started] = ram[started, None]
        if lanes is None:
            self.rows = rows
        else:
            self.rows[lanes] = rows
        return rows

    def final(self, ram: ByteArray) -> ByteArray:
        """The stacks that the last `push` would have given with these vectors, had nothing started."""
        return np.concatenate([self._before[:, 1:], ram[:, None]], 1)

    def resize(self, num_envs: int) -> None:
        """Make room for more environments."""
        missing = max(0, num_envs - len(self.rows))
        self.rows = np.concatenate([self.rows, np.zeros((missing, *self.shape), np.uint8)])


def _actions(game: Game, full: bool, names: Sequence[str] | None) -> tuple[tuple[str, ...], npt.NDArray[np.int64]]:
    """Names of the actions, and their indices in the action space."""
    every = [Action(action).name for action in (game.legal_actions if full else game.minimal_actions)]
    chosen = every if names is None else list(names)
    missing = [name for name in chosen if name not in every]
    if missing or not chosen:
        raise ValueError(f"actions of {game.id} are {', '.join(every)}; got {', '.join(chosen)}")
    return tuple(chosen), np.array([every.index(name) for name in chosen])
