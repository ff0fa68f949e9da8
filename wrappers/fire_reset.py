"""`FireReset`: press FIRE at the start of each episode.

Some games, such as Breakout, wait until FIRE is pressed; an agent that never presses it learns nothing.
"""

from typing import Any

from gymnasium import spaces

from atari.env.env import options_of_reset
from atari.env.restorable import RestorableWrapper
from atari.wrappers._checks import Environment, begin_meanings, step_named


class FireReset(RestorableWrapper):
    """After a reset, play one step of FIRE. Games without a FIRE action are not changed.

    The game decides, not the agent: if the `actions` of an `AtariEnv` are some of the game's, FIRE and action 2 are the
    game's.

    If the episode ends during these steps, the environment is reset once more.

    Args:
        env: the environment; around a frame skip, FIRE is held for the whole skip.
        then_action_2: play one step of action 2 of the action set after FIRE, whichever action that is, as OpenAI's
            Baselines and Stable-Baselines3 do.

    Raises:
        ValueError: `then_action_2` is true, with fewer than three actions or a continuous action space.

    Example:
        >>> import atari
        >>> from atari.wrappers import FireReset
        >>> env = FireReset(atari.AtariEnv("breakout", frameskip=1))
        >>> env.reset(seed=0)[1]["episode_frame_number"]
        1
    """

    def __init__(self, env: Environment, *, then_action_2: bool = False) -> None:
        super().__init__(env, then_action_2=then_action_2)
        names = begin_meanings(env)
        self._actions = ["FIRE"] if "FIRE" in names else []
        if self._actions and then_action_2:
            if not isinstance(env.action_space, spaces.Discrete) or len(names) < 3:
                raise ValueError(
                    f"then_action_2 needs at least three discrete actions, got {env.action_space}; "
                    "use full_action_space=True or then_action_2=False"
                )
            self._actions.append(names[2])

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Reset, then press FIRE.

        Args:
            seed: the seed of the environment.
            options: "fire" false omits FIRE; the other options are passed on.
        """
        inner = options_of_reset(options)
        fires = inner.pop("fire", True)
        observation, info = self.env.reset(seed=seed, options=inner or None)
        for action in self._actions if fires else ():
            observation, _, terminated, truncated, step_info = step_named(self.env, action)
            info.update(step_info)
            if terminated or truncated:
                observation, info = self.env.reset(seed=seed, options=inner or None)
        return observation, info
