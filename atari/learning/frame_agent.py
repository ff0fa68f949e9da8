"""`FrameAgent`: a policy that plays a core frame by frame, as programs that show every frame need it."""

from collections import deque
from collections.abc import Mapping
from typing import Any

import cv2
import numpy as np

from atari.actions import Action
from atari.cores import Core
from atari.learning.policies import load_policy
from atari.learning.policy import Policy
from atari.protocols import Protocol
from atari.wrappers.presets import preset_protocol

_LANE = np.zeros(1, np.int64)


class FrameAgent:
    """A policy with the observations that it needs, made from the frames of a core.

    A policy chooses an action every four frames, from images or RAM as its `environment` says, with sticky actions as
    the core has them. FIRE is pressed at the beginning and after a lost life, if the policy's preset does so.

    Args:
        policy: as of `load_policy`, or a policy.
        seed: of policies that draw numbers.

    Raises:
        TypeError, ValueError, FileNotFoundError, gymnasium.error.DependencyNotInstalled: see `load_policy`.
    """

    def __init__(self, policy: "str | Policy", seed: int = 0) -> None:
        self._policy = load_policy(policy) if isinstance(policy, str) else policy
        self._seed = seed
        self.name: str = getattr(self._policy, "name", "") or str(policy)
        self.game: str | None = getattr(self._policy, "game", None)
        environment = getattr(self._policy, "environment", None) or {}
        if not isinstance(environment, Mapping):
            raise ValueError(f"the environment of {self.name} must be a mapping of options, got {environment!r}")
        self._environment = dict(environment)
        preset = self._environment.get("preset", "baselines")
        self._protocol: Protocol = preset if isinstance(preset, Protocol) else preset_protocol(preset or "baselines")
        self._skip = self._protocol.frame_skip[0]
        self._stack: deque[Any] = deque(maxlen=self._environment.get("stack_num", 4))
        self._before: Any = None
        self._frame = 0
        self._lives = 0
        self._fires = 0
        self._action = 0
        self._actions: list[int] = []

    def begin(self, core: Core) -> None:
        """Begin a game, or go on from another state of it: the first observation fills the stack."""
        names = self._environment.get("actions")
        if names is None:
            full = self._environment.get("full_action_space", False)
            names = [action.name for action in (core.game.legal_actions if full else core.game.minimal_actions)]
        self._actions = [int(Action[name]) for name in names]
        begin = getattr(self._policy, "begin", None)
        if begin is not None:
            begin(core.game.id, tuple(names), _LANE, np.array([self._seed], np.int64))
        self._stack.clear()
        self._frame, self._before = 0, None
        self._lives, self._fires = core.lives, self._skip * self._needs_fire(core)

    def act(self, core: Core) -> int:
        """The ALE action number of the next frame."""
        if core.lives < self._lives:
            self._fires = self._skip * self._needs_fire(core)
        self._lives = core.lives
        if self._frame % self._skip == 0:
            self._action = self._choose(core)
        elif self._frame % self._skip == self._skip - 1 and self._protocol.max_pool:
            self._before = self._screen(core)
        self._frame += 1
        if self._fires:
            self._fires -= 1
            return int(Action.FIRE)
        return self._action

    def _choose(self, core: Core) -> int:
        if self._environment.get("obs_type") == "ram":
            observation = core.ram()[None]
        else:
            image = self._image(core)
            if not self._stack and self._protocol.padding == "zero":
                self._stack.extend([np.zeros_like(image)] * (self._stack.maxlen or 1))
            self._stack.extend([image] * (1 if self._stack else self._stack.maxlen or 1))
            last = self._environment.get("channels_last", False)
            observation = np.stack(self._stack, axis=-1 if last else 0)[None]
        chosen = np.asarray(self._policy(observation, _LANE))
        if chosen.shape != (1,) or chosen.dtype.kind not in "iu" or not 0 <= chosen[0] < len(self._actions):
            raise ValueError(
                f"{self.name} must return one of {len(self._actions)} actions, (1,) integers, got {chosen!r}"
            )
        return self._actions[int(chosen[0])]

    def _image(self, core: Core) -> Any:
        screen = self._screen(core)
        if self._before is not None:
            screen = np.maximum(screen, self._before)
        size = self._environment.get("img_width", 84), self._environment.get("img_height", 84)
        return cv2.resize(screen, size, interpolation=cv2.INTER_AREA)

    def _screen(self, core: Core) -> Any:
        gray = self._environment.get("obs_type") != "rgb" and self._environment.get("grayscale", True)
        return core.screen_grayscale() if gray else core.screen_rgb()

    def _needs_fire(self, core: Core) -> bool:
        return self._protocol.fire != "never" and Action.FIRE in core.game.minimal_actions
