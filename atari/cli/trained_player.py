"""`TrainedPlayer`: the policy of a training in a game of several players."""

from collections.abc import Sequence
from typing import Any

import cv2
import numpy as np

from atari.actions import Action
from atari.cores import ByteArray
from atari.learning import ScoresPolicy
from atari.play.multiplayer_session import Observation
from atari.wrappers.presets import preset_protocol

_LANE = np.zeros(1, np.int64)


class TrainedPlayer:
    """A policy of the one-player game as a player of a `MultiplayerSession`.

    The policy observes and acts as in its training: every fourth frame (the frame skip of its preset), the maximum of
    the last two frames, in gray and scaled, or RAM; stacked. Its first observation of a game is a single frame. After a
    rewind the stack begins anew.

    Args:
        policy: with `environment`, the options of its observations, as run folders have it.
        game: id of the game.
        seed: of a policy that draws its actions.
        mirrored: exchange left and right in the images.
    """

    def __init__(self, policy: ScoresPolicy, game: str, seed: int = 0, mirrored: bool = False) -> None:
        sees = policy.environment
        protocol = preset_protocol(sees["preset"])
        self._policy, self._game, self._seed, self._mirrored = policy, game, seed, mirrored
        self._names: Sequence[str] = tuple(sees["actions"])
        self._skip = protocol.frame_skip[0]
        self._max_pool, self._padding = protocol.max_pool, protocol.padding
        self.obs_type: Observation = "rgb" if protocol.pool_rgb else "grayscale"
        """Of the observations that this player is called with."""
        if sees.get("obs_type") == "ram":
            self.obs_type = "ram"
        else:
            self._stack: ByteArray = np.zeros((sees["stack_num"], sees["img_height"], sees["img_width"]), np.uint8)
        self._next = self._first = -1
        self._before: ByteArray | None = None
        self._action = Action.NOOP

    def __call__(self, observation: ByteArray, info: dict[str, Any]) -> str:
        """The name of the action for the next frame."""
        frame: int = info["frame"]
        if frame != self._next or frame == 0:
            self._begin(frame)
        self._next = frame + 1
        if (frame - self._first) % self._skip == 0:
            seen = observation[None] if self.obs_type == "ram" else self._push(observation)[None]
            (index,) = self._policy(seen, _LANE)
            self._action = Action[self._names[index]]
        self._before = observation
        return self._action.name

    def _begin(self, frame: int) -> None:
        """Begin a game, or go on at a frame that does not follow the last one."""
        self._first, self._before = frame, None
        self._policy.begin(self._game, self._names, _LANE, np.array([self._seed]))

    def _push(self, frame: ByteArray) -> ByteArray:
        """The stack with the image of this frame."""
        first = self._before is None
        if self._before is not None and self._max_pool:
            frame = np.maximum(self._before, frame)
        if self.obs_type == "rgb":
            frame = np.asarray(cv2.cvtColor(frame, cv2.COLOR_RGB2GRAY), np.uint8)
        if self._mirrored:
            frame = np.ascontiguousarray(frame[:, ::-1])
        rows, columns = self._stack.shape[1:]
        image = np.asarray(cv2.resize(frame, (columns, rows), interpolation=cv2.INTER_AREA), np.uint8)
        self._stack = np.concatenate([self._stack[1:], image[None]])
        if first:
            self._stack[:-1] = 0 if self._padding == "zero" else image
        return self._stack
