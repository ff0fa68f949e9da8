"""`StickyActions`: with some probability, a step repeats the previous action instead of the chosen one.

Without this, an agent can memorise a sequence of button presses (Machado et al. 2018, "Revisiting the Arcade
Learning Environment", section 5). `AtariEnv` does it inside the emulator, frame by frame, with
`repeat_action_probability`. This wrapper serves other environments, and draws like Stable-Baselines3's.
"""

from typing import Any

import numpy as np
from gymnasium import spaces

from atari.base.validation import check_action_index, check_probability
from atari.env import AtariEnv
from atari.env.restorable import RestorableWrapper, State
from atari.wrappers._checks import Environment, action_meanings, noop_action


class StickyActions(RestorableWrapper):
    """With some probability, play the action of the previous step again.

    An episode starts with NOOP as the previous action. One number is drawn from `np_random` each step. If no inner
    wrapper skips frames, that is one for each frame, as in ALE. (Gymnasium's `StickyAction` never repeats
    at the first step.)

    Args:
        env: the environment.
        repeat_action_probability: the probability of repeating, 0..1.

    Raises:
        TypeError, ValueError: it is no probability, or the environment's actions are already sticky or lack NOOP.

    Example:
        >>> import atari
        >>> from atari.wrappers import StickyActions
        >>> env = StickyActions(atari.AtariEnv("pong", repeat_action_probability=0.0), 0.25)
        >>> env.reset(seed=0)[0].shape
        (210, 160, 3)
    """

    def __init__(self, env: Environment, repeat_action_probability: float = 0.25) -> None:
        repeat_action_probability = check_probability("repeat_action_probability", repeat_action_probability)
        inner = env.unwrapped
        if isinstance(inner, AtariEnv) and inner.task.repeat_action_probability != 0.0:
            raise ValueError(
                f"the actions of {inner.game.id} are sticky already (probability "
                f"{inner.task.repeat_action_probability}); make it with repeat_action_probability=0.0"
            )
        if isinstance(env.action_space, spaces.Discrete) and "NOOP" not in action_meanings(env):
            raise ValueError(
                "StickyActions starts an episode with NOOP, which is no action of this game; make the environment with "
                "full_action_space=True, or with repeat_action_probability instead of this wrapper"
            )
        super().__init__(env, repeat_action_probability=repeat_action_probability)
        self._probability = repeat_action_probability
        self._action = noop_action(env)

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Reset; the previous action becomes NOOP."""
        self._action = noop_action(self.env)
        return self.env.reset(seed=seed, options=options)

    def step(self, action: Any) -> tuple[Any, Any, bool, bool, dict[str, Any]]:
        """Play this action, or the previous one again.

        Raises:
            TypeError, ValueError: the action is not in the action space, even if the previous one would be played.
        """
        space = self.action_space
        if isinstance(space, spaces.Discrete):
            check_action_index(action, int(space.n), "StickyActions")
        elif np.shape(action) != space.shape:
            raise TypeError(f"an action is an array of shape {space.shape}, got {action!r}")
        self._warn_if_restored()
        if self.np_random.random() < self._probability:
            action = self._action
        result = self.env.step(action)
        self._action = action
        return result

    def _save_state(self) -> State:
        discrete = isinstance(self.action_space, spaces.Discrete)
        return {"action": int(self._action) if discrete else np.asarray(self._action, np.float32)}

    def _load_state(self, state: State) -> dict[str, Any]:
        if state["action"] not in self.action_space:
            raise ValueError(f"the snapshot is damaged: {state['action']!r} is no action of {self.action_space}")
        return {"_action": state["action"]}
