"""`SyncVectorEnv`: several environments in this process, one after another."""

from collections.abc import Callable, Iterable
from typing import Any

from atari.classic.core import Env
from atari.classic.spaces import Space
from atari.classic.vector.vector_env import Batches, NoCallError, Results, call, check_env_fns, step_and_reset


class SyncVectorEnv(Batches):
    """Steps its environments one after another.

    Args:
        env_fns: functions that make the environments.
        observation_space: the space of one environment's observations; None means the first environment's.
        action_space: the space of one environment's actions; likewise.
        copy: False returns the same array of observations, `observations`, from each step.

    Raises:
        ValueError: there are none.
        RuntimeError: the shapes of their observations differ.

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
        self.env_fns = check_env_fns(env_fns)
        self.envs = [make() for make in self.env_fns]
        self._options: dict[str, Any] = {}
        self._actions: list[Any] | None = None
        self._called: list[Any] = []
        first = self.envs[0]
        self.metadata, self.reward_range, self.spec = first.metadata, first.reward_range, first.spec
        spaces = observation_space or first.observation_space, action_space or first.action_space
        super().__init__(len(self.envs), *spaces, is_copied=copy)
        self._check_spaces()

    def reset_async(self, **options: Any) -> None:  # noqa: D102
        self._options = options

    def reset_wait(self, **kwargs: Any) -> Any:  # noqa: D102
        options, self._options, self._actions = {**self._options, **kwargs}, {}, None
        return self._batch([env.reset(**options) for env in self.envs])

    def step_async(self, actions: Any) -> None:
        """Take the actions for the next `step_wait`.

        Raises:
            ValueError: their number is not that of the environments.
        """
        self._actions = self._one_each(actions, "actions")

    def step_wait(self, **kwargs: Any) -> Results:
        """Step with the actions of `step_async`.

        Raises:
            gymnasium.error.Error: there are no actions.
        """
        actions, self._actions = self._actions, None
        if actions is None:
            raise NoCallError(
                "step_wait() came before step_async(actions); call it first, or step(actions)", "step_async"
            )
        return self._results([step_and_reset(env, action) for env, action in zip(self.envs, actions, strict=True)])

    def call_async(self, name: str, *args: Any, **kwargs: Any) -> None:  # noqa: D102
        self._called = [call(env, name, args, kwargs) for env in self.envs]

    def call_wait(self, **kwargs: Any) -> list[Any]:  # noqa: D102
        called, self._called = self._called, []
        return called

    def set_attr(self, name: str, values: Any) -> None:  # noqa: D102
        for env, value in zip(self.envs, self._checked_values(values), strict=True):
            setattr(env, name, value)

    def seed(self, seeds: Any = None, *, seed: Any = None) -> list[Any]:  # type: ignore[override]  # noqa: D102
        return [env.seed(own) for env, own in zip(self.envs, self._checked_seeds(seeds, seed), strict=True)]

    def close_extras(self, **kwargs: Any) -> None:  # noqa: D102
        for env in self.envs:
            env.close()

    def _check_observation_spaces(self) -> bool:
        return self._check_fit(env.observation_space for env in self.envs)
