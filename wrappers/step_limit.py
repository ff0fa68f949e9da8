"""`StepLimit`: Gymnasium's `TimeLimit`, which `gymnasium.make(env.spec)` puts in its former place."""

import gymnasium
from gymnasium.wrappers import TimeLimit

from atari.env.restorable import Restorable


class StepLimit(Restorable, TimeLimit):
    """Truncate episodes after `max_episode_steps` steps of the agent.

    The spec of a `TimeLimit` is the environment's spec with another `max_episode_steps`, which `gymnasium.make` applies
    inside all other wrappers. The steps would then be frames.

    Args:
        env: the environment.
        max_episode_steps: the most steps of an episode, which begins with each reset.
    """

    _state = ("_elapsed_steps",)

    spec = gymnasium.Wrapper.spec
