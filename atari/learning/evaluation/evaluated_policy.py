"""`EvaluatedPolicy`: a policy in the environments of the task that an evaluation plays."""

from typing import Any

import numpy as np
import numpy.typing as npt

from atari.policy import LoadedPolicy
from atari.policy.needs import needs_of
from atari.task import Task
from atari.task.checks import NO_LIMIT
from atari.task.fields import GROUPS
from atari.vector import AtariVectorEnv

IntArray = npt.NDArray[np.int64]


class EvaluatedPolicy:
    """A policy in the environments of a task. It translates the policy's actions, and makes some of them random.

    Args:
        policy: the policy.
        task: the task that is played, from `played_task`.
        epsilon: the probability of a random action.

    Raises:
        ValueError: the policy needs an environment that does not exist, or has an action that the task lacks.
        FileNotFoundError: the game's ROM file does not exist.
    """

    def __init__(self, policy: LoadedPolicy, task: Task, epsilon: float) -> None:
        self.task = task
        self._policy, self._epsilon = policy, epsilon
        self._generators: dict[int, np.random.Generator] = {}
        needs = needs_of(policy, task.definition)
        self._options = needs.options
        every = tuple(action.name for action in task.action_set)
        self._names = every if needs.actions is None else needs.actions
        if missing := [name for name in self._names if name not in every]:
            raise ValueError(
                f"the policy has the action {missing[0]!r} in {task.game}, where this protocol has {', '.join(every)}; "
                "choose a protocol with all 18 actions, such as 'machado2018', or a policy with these"
            )
        self._every = len(every)
        self._indices = np.array([every.index(name) for name in self._names])
        self.max_frames = task.max_num_frames_per_episode or NO_LIMIT
        try:
            self.make(1).close()  # so that errors are raised before the first game of an evaluation
        except TypeError as error:  # the options may be from a file
            raise ValueError(f"the environment of the policy: {error}") from error

    def make(self, lanes: int, num_threads: int = 1) -> AtariVectorEnv:
        """Environments of the game. They wait for a reset after the end of a game or a life."""
        run: dict[str, Any] = {"autoreset_mode": "Disabled", "num_threads": num_threads, "game_info": True}
        return AtariVectorEnv(self.task, lanes, **run, **self._options)

    def facts(self) -> dict[str, Any]:
        """The options of the policy's observations, as the types of JSON."""
        options = {name: str(value) if name in ("rom", "dtype") else value for name, value in self._options.items()}
        return {name: getattr(self.task, name) for name in GROUPS["observation"]} | options

    def begin(self, lanes: IntArray, seeds: IntArray) -> None:
        """Begin games in some lanes, each with its seed."""
        for lane, seed in zip(lanes.tolist(), seeds.tolist(), strict=True):
            self._generators[lane] = np.random.default_rng([seed, 1])  # the policy may use the seed itself
        self._policy.begin(self.task.game, self._names, lanes, seeds)

    def begin_episodes(self, lanes: IntArray) -> None:
        """Begin the episodes after a lost life in some lanes, where the games go on."""
        if self.task.new_stack_after_life:
            self._policy.begin_episodes(lanes)

    def act(self, observations: Any, lanes: IntArray) -> IntArray:
        """The actions of some lanes, (n,) indices of the environment's actions.

        Raises:
            ValueError: the policy returns no actions.
        """
        chosen = self._indices[self._policy(observations, lanes)]
        if self._epsilon > 0:
            for row, lane in enumerate(lanes.tolist()):
                generator = self._generators[lane]
                if generator.random() < self._epsilon:
                    chosen[row] = generator.integers(self._every)
        return chosen
