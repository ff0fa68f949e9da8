"""`PreprocessedEnv`: the observations of deep Q-networks for a game of several players, `preset="dqn"`."""

from typing import Any

import cv2
import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray
from pettingzoo import ParallelEnv

from atari.multiplayer.core import check_switch
from atari.multiplayer.parallel import MultiplayerEnv
from atari.validation import check_integer

OWN_OPTIONS = ("frame_skip", "shape", "stack", "player_indicator")


class PreprocessedEnv(ParallelEnv[str, NDArray[np.uint8], int]):
    """Repeated actions, and stacked gray images, uint8 with the planes last, as SuperSuit has them.

    A step plays `frame_skip` frames, fewer if the game ends, and adds up the rewards. An image is the maximum of the
    last two of these frames, scaled by OpenCV's INTER_AREA. The stack has the newest image last; a reset fills it
    with the first image. `max_cycles` of the game counts frames.

    Args:
        env: the game, with obs_type="grayscale_image".
        frame_skip: frames of a step.
        shape: (rows, columns) of the images.
        stack: images of an observation.
        player_indicator: append a plane for each player, as SuperSuit's `agent_indicator` does for images: 255 in the
            plane of the agent that observes, 0 in the others. One network can then play all sides.

    Raises:
        ValueError, TypeError: an argument is wrong.

    Example:
        >>> from atari.multiplayer import parallel_env
        >>> env = parallel_env("pong", preset="dqn", player_indicator=True)
        >>> observations, infos = env.reset(seed=1)
        >>> observations["second_0"].shape, observations["second_0"][0, 0, 4:].tolist()
        ((84, 84, 6), [0, 255])
    """

    def __init__(
        self,
        env: MultiplayerEnv,
        *,
        frame_skip: int = 4,
        shape: tuple[int, int] = (84, 84),
        stack: int = 4,
        player_indicator: bool = False,
    ) -> None:
        if not isinstance(env, MultiplayerEnv) or env.obs_type != "grayscale_image":
            raise ValueError(f"PreprocessedEnv needs a MultiplayerEnv with obs_type='grayscale_image', got {env!r}")
        if not isinstance(shape, (tuple, list)) or len(shape) != 2:
            raise TypeError(f"shape must be two integers (rows, columns), got {shape!r}")
        rows, columns = (check_integer("shape", length, 1, 10_000) for length in shape)
        self.env = env
        self.frame_skip = check_integer("frame_skip", frame_skip, 1, 10_000)
        check_integer("stack", stack, 1, 1000)
        self.possible_agents, self.metadata, self.render_mode = env.possible_agents, env.metadata, env.render_mode
        self.action_spaces, self.core = env.action_spaces, env.core
        self._stack = np.zeros((rows, columns, stack), np.uint8)
        shown = len(self.possible_agents) if check_switch("player_indicator", player_indicator) else 0
        self._indicators = dict(zip(self.possible_agents, 255 * np.eye(shown, dtype=np.uint8), strict=False))
        space = spaces.Box(0, 255, (rows, columns, stack + shown), np.uint8)
        self.observation_spaces = dict.fromkeys(self.possible_agents, space)

    @property
    def agents(self) -> list[str]:
        """The agents in the game."""
        return self.env.agents

    def observation_space(self, agent: str) -> spaces.Box:
        """The space of an agent's observations, the same for all."""
        return self.observation_spaces[agent]

    def action_space(self, agent: str) -> spaces.Discrete:
        """The space of an agent's actions, as of the game."""
        return self.action_spaces[agent]

    def reset(
        self, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, NDArray[np.uint8]], dict[str, dict[str, Any]]]:
        """Begin a new game, as `MultiplayerEnv.reset`."""
        observations, infos = self.env.reset(seed, options)
        self._stack[:] = self._scaled(observations[self.possible_agents[0]])[..., None]
        return self._observations(self.agents), infos

    def step(
        self, actions: dict[str, int]
    ) -> tuple[
        dict[str, NDArray[np.uint8]],
        dict[str, Any],
        dict[str, bool],
        dict[str, bool],
        dict[str, dict[str, Any]],
    ]:
        """Play `frame_skip` frames. An agent that ends in one of them has the rewards up to its end."""
        agents = list(self.agents)
        if not agents:
            return {}, {}, {}, {}, {}
        rewards: dict[str, Any] = {}
        terminations: dict[str, bool] = {}
        truncations: dict[str, bool] = {}
        frames: list[NDArray[np.uint8]] = []
        for _ in range(self.frame_skip):
            observations, paid, ended, truncated, _ = self.env.step(actions)
            frames.append(next(iter(observations.values())))
            rewards.update({agent: rewards.get(agent, 0) + reward for agent, reward in paid.items()})
            terminations.update(ended)
            truncations.update(truncated)
            if not self.agents or any(truncated.values()):
                break
        self._stack = np.roll(self._stack, -1, axis=-1)
        self._stack[..., -1] = self._scaled(np.maximum(frames[-1], frames[max(len(frames) - 2, 0)]))
        return self._observations(agents), rewards, terminations, truncations, {agent: {} for agent in agents}

    def render(self) -> NDArray[np.uint8] | None:
        """The screen (rows, 160, 3) of the last frame, or None and a window."""
        return self.env.render()

    def snapshot(self) -> tuple[Any, NDArray[np.uint8]]:
        """The state of the game and the stack of images."""
        return self.env.snapshot(), self._stack.copy()

    def restore(self, snapshot: tuple[Any, NDArray[np.uint8]]) -> None:
        """Continue from what `snapshot` returned."""
        game, stack = snapshot
        self.env.restore(game)
        self._stack = stack.copy()

    def close(self) -> None:
        """Close the window, if there is one."""
        self.env.close()

    def _scaled(self, frame: NDArray[np.uint8]) -> NDArray[np.uint8]:
        rows, columns, _ = self._stack.shape
        image: Any = cv2.resize(frame[..., 0], (columns, rows), interpolation=cv2.INTER_AREA)
        return np.asarray(image, np.uint8)

    def _observations(self, agents: list[str]) -> dict[str, NDArray[np.uint8]]:
        if not self._indicators:
            return dict.fromkeys(agents, self._stack.copy())
        size = self._stack.shape[:2]
        planes = {agent: np.broadcast_to(self._indicators[agent], (*size, len(self._indicators))) for agent in agents}
        return {agent: np.concatenate((self._stack, plane), axis=-1) for agent, plane in planes.items()}


def preprocessed(game: str, **options: Any) -> PreprocessedEnv:
    """`PreprocessedEnv` around `MultiplayerEnv(game)`, with options of both."""
    if "obs_type" in options:
        raise ValueError("preset='dqn' has gray images; leave obs_type out")
    own = {name: options.pop(name) for name in OWN_OPTIONS if name in options}
    return PreprocessedEnv(MultiplayerEnv(game, obs_type="grayscale_image", **options), **own)
