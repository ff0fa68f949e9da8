"""`SyncVectorEnv`: several environments in this process, one after another."""

from collections.abc import Callable, Iterable, Sequence
from typing import Any

from atari.classic.core import Env
from atari.classic.spaces import Space
from atari.classic.vector.vector_env import Lane, VectorEnv, check_env_fns


class SyncVectorEnv(VectorEnv):
    """Steps its environments one after another.

    Args:
        env_fns: functions that make the environments.
        observation_space: the space of one environment's observations; None means the first environment's.
        action_space: the space of one environment's actions; likewise.
        copy: has no effect; observations are new arrays.

    Raises:
        ValueError: there are none.

    Example:
        >>> from atari import classic
        >>> envs = classic.vector.SyncVectorEnv([lambda: classic.make("CartPole-v1")] * 2)
        >>> envs.seed(0), envs.reset().shape
        ([[0], [1]], (2, 4))
        >>> observations, rewards, dones, infos = envs.step([0, 1])
        >>> rewards.tolist(), dones.tolist()
        ([1.0, 1.0], [False, False])
    """

    def __init__(
        self,
        env_fns: Iterable[Callable[[], Env]],
        observation_space: Space[Any] | None = None,
        action_space: Space[Any] | None = None,
        copy: bool = True,
    ) -> None:
        self.envs = [make() for make in check_env_fns(env_fns)]
        self._lanes = [Lane(env) for env in self.envs]
        first = self.envs[0]
        self.metadata, self.reward_range, self.spec = first.metadata, first.reward_range, first.spec
        spaces = observation_space or first.observation_space, action_space or first.action_space
        super().__init__(len(self.envs), *spaces)

    def close(self) -> None:
        """Close the environments; later calls do nothing."""
        if not self.closed:
            self.closed = True
            for lane in self._lanes:
                lane.close()

    def _reset_all(self, options: dict[str, Any]) -> list[Any]:
        return [lane.reset(options) for lane in self._lanes]

    def _step_all(self, actions: Sequence[Any]) -> list[Any]:
        return [lane.step(action) for lane, action in zip(self._lanes, actions, strict=True)]

    def _call_all(self, name: str, arguments: Sequence[Any], options: dict[str, Any]) -> list[Any]:
        return [lane.call(name, arguments, options) for lane in self._lanes]

    def _seed_all(self, seeds: Sequence[int | None]) -> list[Any]:
        return [lane.seed(seed) for lane, seed in zip(self._lanes, seeds, strict=True)]
