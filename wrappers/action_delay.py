"""`ActionDelay`: the console gets the agent's actions some frames later.

People and robots react late, and so does an agent whose network takes its time. A delay of frames is exact inside of a
frame skip, too.
"""

from collections import deque
from typing import Any

import numpy as np

from atari.env.episode_env import EpisodeEnv
from atari.env.restorable import RestorableWrapper, State, layers
from atari.task.fields import CHECKS
from atari.wrappers._checks import Environment, draw, require_atari
from atari.wrappers.dqn_preprocessing import DqnPreprocessing

_CHECK: Any = CHECKS["action_delay"]
_NOOP = 0, 1.0
"""The ALE action and the strength before an agent's first action has arrived."""


class ActionDelay(RestorableWrapper):
    """In each frame the console gets the action that the agent held `delay` frames ago; before that, NOOP.

    Frames are the emulator's, also inside a frame skip: with `delay=2` and a skip of 4, the first two frames of a step
    get the previous step's action. Sticky actions act at the console, after the delay. Put this wrapper outside of all
    others that play frames: it delays the frames of its own `step`, and those that wrappers inside it play in a
    reset (no-ops, FIRE) are not delayed. Each reset begins with NOOP again; only if an inner `DqnPreprocessing` with
    `seamless_lives` continues its stack after a lost life, the delayed actions stay, too. Observations, rewards and
    ends are not changed.

    `gymnasium.wrappers` has delays of observations in steps (`DelayObservation`), but none of actions. `atari.make` has
    the option `action_delay`, which the engine plays.

    Args:
        env: an `AtariEnv`, possibly wrapped.
        delay: frames, 0..60; or (low, high), both included, for a number drawn at each reset from the generator of the
            no-ops, after them.

    Raises:
        TypeError, ValueError: `delay` is of the wrong kind or out of range; the environment is no `AtariEnv`, has an
            `ActionDelay` already, or is the one object of a preset, which has the option `action_delay`.

    Example:
        >>> import atari
        >>> from atari.wrappers import ActionDelay
        >>> env = ActionDelay(atari.AtariEnv("pong", frameskip=4), 2)
        >>> observation, info = env.reset(seed=0)
        >>> observation, reward, terminated, truncated, info = env.step(2)
        >>> info["episode_frame_number"], observation.shape
        (4, (210, 160, 3))
    """

    def __init__(self, env: Environment, delay: int | tuple[int, int]) -> None:
        delay = _CHECK("delay", delay)
        self._atari = require_atari(env, "ActionDelay")
        for layer in layers(env):
            if isinstance(layer, EpisodeEnv):
                raise ValueError(
                    "ActionDelay has no effect around the one object of a preset; make the environment with "
                    f"action_delay={delay}"
                )
            if isinstance(layer, ActionDelay):
                raise ValueError("the environment has an ActionDelay already; use one with the sum of both delays")
        super().__init__(env, delay=list(delay) if isinstance(delay, tuple) else delay)
        self._range: tuple[int, int] = delay if isinstance(delay, tuple) else (delay, delay)
        self._skip = next((layer for layer in layers(env) if isinstance(layer, DqnPreprocessing)), None)
        self._line: deque[tuple[int, float]] = deque()

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Reset; the actions that have not arrived are dropped."""
        game = self._atari.driver.played
        result = self.env.reset(seed=seed, options=options)
        if self._skip is None or not self._skip.keeps_stack or self._atari.driver.played is not game:
            low, high = self._range
            self._line = deque([_NOOP] * (low if low == high else draw(self.env, low, high + 1)))
        return result

    def step(self, action: Any) -> tuple[Any, Any, bool, bool, dict[str, Any]]:
        """Step; the frames get the delayed actions."""
        driver = self._atari.driver
        self._warn_if_restored()
        driver.convert = self._delayed
        try:
            return self.env.step(action)
        finally:
            driver.convert = None

    def _delayed(self, action: int, strength: float) -> tuple[int, float]:
        self._line.append((action, strength))
        return self._line.popleft()

    def _save_state(self) -> State:
        moves = np.zeros((self._range[1], 2), np.float32)
        moves[: len(self._line)] = np.array(self._line, np.float32).reshape(-1, 2)
        return {"delay": len(self._line), "moves": moves}

    def _load_state(self, state: State) -> dict[str, Any]:
        delay, moves = state["delay"], state["moves"]
        if (
            not 0 <= delay <= self._range[1]
            or not np.isfinite(moves).all()
            or not np.isin(moves[:, 0], range(18)).all()
        ):
            raise ValueError("the snapshot is damaged: its delayed actions are no actions")
        return {"_line": deque((int(action), float(strength)) for action, strength in moves[:delay])}
