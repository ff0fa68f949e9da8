"""`FrameAgent`: a policy that plays a core frame by frame, for programs that show every frame."""

from collections.abc import Generator, Iterator
from typing import Any, Literal

import numpy as np
from gymnasium.utils import seeding

from atari.actions import Action
from atari.cores import Core
from atari.games.game import Game
from atari.learning.policies import load_policy
from atari.observations.frames import Frame, FrameObservations
from atari.policy.needs import Needs, in_game, needs_of
from atari.task import Task

Start = Literal["game", "life", "middle"]
"""How an episode begins: at the start of a game, after a lost life, or anywhere in a game."""


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
        self._frames: Iterator[int] = iter(())

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
        self._seen = FrameObservations(self._task, needs.layout(self._task))
        names = tuple(action.name for action in self._task.action_set)
        self._actions = [int(Action[name]) for name in names]
        every = self._task.begin_actions
        fires = self._task.fire != "never" and Action.FIRE in every
        self._fire = [int(Action.FIRE), *([int(every[2])] if self._task.third_action else [])] if fires else []
        self._fire_counts = self._task.fire_counts and Action.FIRE in every
        first = int(np.random.SeedSequence(seed).generate_state(2)[0])  # as `AtariEnv.reset` makes it of a seed
        self._random, _ = seeding.np_random(first)
        self._policy.begin(core.game.id, names, self._lanes, np.array([seed], np.int64))
        self._core, self._lives = core, core.lives
        self._frames = self._play("game" if core.episode_frame_number == 0 else "middle")

    def act(self, core: Core) -> int:
        """The ALE action number of the next frame, after a frame of the last one."""
        self._core = core
        return next(self._frames)

    def _play(self, start: Start) -> Iterator[int]:
        """The actions of the frames of a game."""
        while True:
            yield from self._begin_episode(start)
            lost = False
            while not lost:
                lost = yield from self._skip(self._choose())
            if not self._task.seamless_lives:
                self._policy.begin_episodes(self._lanes)
            start = "middle" if self._task.on_reset == "new_game" else "life"

    def _begin_episode(self, start: Start) -> Iterator[int]:
        """The frames before the first observation of an episode."""
        task, before = self._task, self._core.frame_number
        lives_in_skip = task.lives_unit == "frame"
        if start == "life" and task.on_reset == "noop":
            yield from (0,) if lives_in_skip else self._skip(0)
        begins = start == "game" or (start == "life" and lives_in_skip)
        noops = [0] * self._draw_noops() if begins else []
        fire = self._fire if task.fire_unit == "frame" and (begins or start == "middle") else []
        yield from [*fire, *noops] if task.fire == "before_noops" else [*noops, *fire]
        fill = not (start == "life" and task.seamless_lives)
        if start == "life" and (not lives_in_skip or self._core.frame_number == before):
            self._seen.repeat(fill)
        else:
            self._seen.begin(self._frame(), fill)
        if task.fire_unit == "skip" and self._fire:
            for action in self._fire:
                yield from self._skip(action)
            self._seen.repeat()
        self._lives = self._core.lives

    def _draw_noops(self) -> int:
        low, high = self._task.noops
        return int(self._random.integers(low, high + 1)) - self._fire_counts if high else 0

    def _skip(self, action: int) -> Generator[int, None, bool]:
        """The frames of a step. Returns whether a lost life ends the episode."""
        task = self._task
        low, high = task.frames
        left = low if high == low + 1 else int(self._random.integers(low, high))
        lost = ended = over = False
        while left and not ended:
            left -= 1
            yield action
            over = self._core.game_over or self._core.truncated
            lost = (task.lives_unit == "frame" and self._life_lost()) or lost
            ended = over or (lost and not task.seamless_lives)
            self._seen.frame_played(self._frame(), left, ended)
        self._seen.skip_ended(self._frame(), left, ended)
        if task.lives_unit == "skip":
            lost = self._life_lost()
        return lost and not over

    def _frame(self) -> Frame:
        """The present frame."""
        return self._core

    def _life_lost(self) -> bool:
        """Whether a life that counts was lost since the last call."""
        before, self._lives = self._lives, self._core.lives
        return self._task.episodic_life and self._lives < before and (self._lives > 0 or self._task.last_life)

    def _choose(self) -> int:
        """The policy's action."""
        self._seen.see_ram(self._core.ram())
        (chosen,) = self._policy(self._seen.observation(), self._lanes)
        return self._actions[int(chosen)]
