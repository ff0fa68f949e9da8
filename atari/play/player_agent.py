"""`PlayerAgent`: a policy as one player in a game for several players."""

from typing import Any

import numpy as np

from atari.cores import ByteArray, Core
from atari.games.game import Game
from atari.learning.frame_agent import FrameAgent
from atari.multiplayer import MultiplayerCore
from atari.policy.needs import Needs
from atari.task import Task
from atari.task.kinds import ObsType


class PlayerAgent(FrameAgent):
    """A policy that plays as one of several players, with the observations that it needs.

    It presses no button at the start of a game or after a lost life, because the players share the game. A policy
    without a task gets `Task.of(game, players=...)`: four frames an action, the game's minimal actions. In a game
    that shows player 2 as a mirror image of player 1, a one-player policy sees mirrored images as player 2.

    Args:
        policy: a policy, see `load_policy`.
        player: the player, 0 is the first. It is the policy's lane.
        core: the core of the game.
        obs_type: the observations of a policy without a task.

    Raises:
        TypeError, ValueError, FileNotFoundError, gymnasium.error.DependencyNotInstalled: see `FrameAgent`, `task_in`.
    """

    def __init__(self, policy: Any, player: int, core: MultiplayerCore, obs_type: ObsType) -> None:
        super().__init__(policy)
        self._lanes = np.array([player], np.int64)
        self._players, self._obs_type = core.players, obs_type
        plays_first = self.task_in(core.game).players == 1
        self._mirrored = plays_first and player == 1 and core.mode in core.rules.mirrored_modes

    def _task_of(self, needs: Needs, game: Game) -> Task:
        if needs.task is not None and needs.task.definition != game:
            raise ValueError(f"{self.name} is a policy for {needs.task.game}, not for {game.id}")
        task = super()._task_of(needs, game)
        if task.agent_indicator:
            raise ValueError(f"{self.name} has agent_indicator=True, which sessions do not draw; leave it out")
        return task.replace(fire="never", noops=(0, 0), episodic_life=False, life_loss_info=False)

    def _unsaid(self, game: Game) -> Task:
        return Task.of(game, players=self._players, obs_type=self._obs_type)

    def _screen(self, core: Core) -> ByteArray:
        screen = core.screen()
        return np.ascontiguousarray(screen[:, ::-1]) if self._mirrored else screen
