"""`TrainedPlayer`: the policy of a training in a game of several players."""

from typing import Any

import numpy as np

from atari.actions import Action
from atari.cores import ByteArray
from atari.games.catalog import games
from atari.games.game import Game
from atari.learning import ScoresPolicy
from atari.learning.needs import needs_of
from atari.observations import FrameObservations
from atari.play.multiplayer_session import Observation

_LANE = np.zeros(1, np.int64)


class TrainedPlayer:
    """A policy of the one-player game as a player of a `MultiplayerSession`.

    The policy observes and acts as in its training: once in each step of its task, whose observation is made from the
    frames of the game. Its first observation of a game is a single frame. After a rewind the stack begins anew.

    Args:
        policy: with a `task`, as run folders have it, or an `environment`.
        game: id of the game.
        seed: of random frame skips, and of a policy that draws its actions.
        mirrored: exchange left and right in the images.

    Raises:
        ValueError: the policy does not say what it needs, or sees what a game of several players does not show.
    """

    def __init__(self, policy: ScoresPolicy, game: str | Game, seed: int = 0, mirrored: bool = False) -> None:
        self._policy, self._seed, self._mirrored = policy, seed, mirrored
        found = game if isinstance(game, Game) else games.resolve(game)
        needs, name = needs_of(policy, found), policy.name or "the policy"
        if needs.task is None:
            raise ValueError(f"{name} does not say what it sees; give it a task or an environment")
        if needs.task.obs_type in ("dict", "rgb_dict"):
            raise ValueError(f"{name} sees obs_type={needs.task.obs_type!r}, and players see images or RAM")
        self._game, self._task = found.id, needs.task
        self._names = tuple(action.name for action in self._task.action_set)
        self._layout = needs.layout(self._task)
        self._seen = FrameObservations(self._task, self._layout)
        self.obs_type: Observation = "ram" if self._task.obs_type == "ram" else "screen"
        """Of the observations that this player is called with."""
        self._next = -1
        self._left = 0
        self._action = Action.NOOP

    def __call__(self, observation: ByteArray, info: dict[str, Any]) -> str:
        """The name of the action for the next frame."""
        frame: int = info["frame"]
        if frame != self._next or frame == 0:
            self._begin(observation)
        else:
            self._frame_played(observation)
        self._next = frame + 1
        if self._left == 0:
            self._choose(observation)
        return self._action.name

    def _begin(self, frame: ByteArray) -> None:
        """Begin a game, or go on at a frame that does not follow the last one."""
        self._left = 0
        self._random = np.random.default_rng(self._seed)
        self._policy.begin(self._game, self._names, _LANE, np.array([self._seed]))
        self._seen = FrameObservations(self._task, self._layout)
        self._seen.begin(self._mirror(frame))

    def _frame_played(self, frame: ByteArray) -> None:
        self._left -= 1
        if self._left == 1:
            self._seen.frame_played(self._mirror(frame), 1, False)
        if self._left == 0:
            self._seen.skip_ended(self._mirror(frame), 0, False)

    def _choose(self, frame: ByteArray) -> None:
        """The action of the next step, and its number of frames."""
        low, high = self._task.frames
        self._left = low if high == low + 1 else int(self._random.integers(low, high))
        if self.obs_type == "ram":
            self._seen.see_ram(frame)
        (index,) = self._policy(self._seen.observation(), _LANE)
        self._action = Action[self._names[index]]

    def _mirror(self, frame: ByteArray) -> ByteArray:
        return np.ascontiguousarray(frame[:, ::-1]) if self._mirrored and frame.ndim > 1 else frame
