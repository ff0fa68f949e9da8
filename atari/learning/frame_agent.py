"""`FrameAgent`: a policy that plays a core frame by frame, for programs that show every frame."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from atari.cores import ByteArray, Core
from atari.games.game import Game
from atari.learning.frame_episode import FrameEpisode
from atari.learning.policies import load_policy
from atari.policy.needs import Needs, in_game, needs_of
from atari.task import Task
from atari.vector.seeds import seed_words


class FrameAgent:
    """A policy with the observations that it needs, made from the frames of a core.

    The agent plays the policy's task: it plays the no-ops and FIRE with which an episode begins, at the start of a game
    and after a lost life, chooses an action for each step, and repeats it for the frames of the step. Observations,
    no-ops and frame skips equal those of `AtariVectorEnv` for equal seeds; with `seeding="ale"` the vector draws other
    no-ops and frame skips. A core plays whole games: where the task would begin a new game after a lost life, the agent
    goes on. The core decides sticky actions, mode and interventions. A policy without `task` and `environment` gets the
    preset "baselines".

    Args:
        policy: a policy as `load_policy` takes it.
        seed: the seed of no-ops, random frame skips, and policies that draw numbers, 0..2**32-1.

    Raises:
        TypeError, ValueError, FileNotFoundError, gymnasium.error.DependencyNotInstalled: see `load_policy`.
    """

    _players = 1

    def __init__(self, policy: Any, seed: int = 0) -> None:
        self._policy = load_policy(policy)
        self._seed = seed
        self.name = self._policy.name
        self.game: str | None = getattr(self._policy, "game", None)
        self._lanes = np.zeros(1, np.int64)

    def task_in(self, game: Game) -> Task:
        """The task that the policy plays in a game.

        Raises:
            ValueError: an option of the policy is wrong, or its task has several players or continuous actions.
        """
        return self._task_of(needs_of(self._policy, game), game)

    def _task_of(self, needs: Needs, game: Game) -> Task:
        if "rom" in needs.options:
            raise ValueError(f"{self.name} has rom={needs.options['rom']!r}, and the core has its ROM; leave it out")
        task = needs.task or self._unsaid(game)
        if task.sound_obs:
            raise ValueError(f"{self.name} has sound_obs=True, and an agent hears no sound; leave it out")
        if task.continuous:
            raise ValueError(f"{self.name} has continuous=True, and an agent chooses one of the actions; leave it out")
        if task.players not in (1, self._players):
            raise ValueError(
                f"{self.name} has players={task.players}, and the game is played by {self._players}; give a policy "
                f"whose task has players={self._players}"
            )
        if task.definition == game:
            return task
        return in_game(task, self._unsaid(game))  # the policy is of another game

    def _unsaid(self, game: Game) -> Task:
        """The task of a policy without `task` and `environment`."""
        return Task.of(game, preset="baselines")

    def begin(self, core: Core, seed: int | None = None) -> None:
        """Begin a game, or go on from another state of it: the first observation fills the stack.

        Args:
            core: the core that is played.
            seed: a seed in place of the agent's.

        Raises:
            ValueError: see `task_in`.
        """
        seed = self._seed if seed is None else seed
        needs = needs_of(self._policy, core.game)
        self._task = self._task_of(needs, core.game)
        self._layout = needs.layout(self._task)
        names = tuple(action.name for action in self._task.action_set)
        self._episode = FrameEpisode(self._task, self._screen)
        self._policy.begin(core.game.id, names, self._lanes, np.array([seed], np.int64))
        _, words = seed_words(seed, np.ones(1, np.bool_), ale=False)
        self._actions = self._play(words[0].tolist(), None if core.episode_frame_number == 0 else 0)

    def act(self, core: Core) -> int:
        """The ALE action number of the next frame, after a frame of the last one."""
        self._episode.core = core
        return next(self._actions)

    def _play(self, seed: list[int] | None, noops: int | None) -> Iterator[int]:
        """The actions of the frames of a game, with the seed and the no-ops of its first episode."""
        task, actions = self._task, [*map(int, self._task.action_set)]
        while True:
            seen, _ = yield from self._episode.reset(seed, noops)
            lost_life = False
            while not lost_life:
                action = actions[self._choose(seen)]
                seen, _, ended, truncated, info = yield from self._episode.step(action)
                lost_life = ended and not (truncated or info["terminated"])
            if task.new_stack_after_life:
                self._policy.begin_episodes(self._lanes)
            seed, noops = None, 0 if task.new_game_after_life else None

    def _choose(self, seen: Any) -> int:
        batch = {name: part[None] for name, part in seen.items()} if isinstance(seen, dict) else seen[None]
        (chosen,) = self._policy(self._layout.apply(batch), self._lanes)
        return int(chosen)

    def _screen(self, core: Core) -> ByteArray:
        return core.screen()
