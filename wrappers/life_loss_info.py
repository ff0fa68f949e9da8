"""`LifeLossInfo`: a lost life is reported as a termination, and the game continues.

A learner that cuts its returns at lost lives, as with `EpisodicLife`, here plays whole games, without a reset after
each life; this is `life_loss_info` of ale-py's vector environment.
"""

from typing import Any

from atari.env.episode_env import EpisodeEnv
from atari.env.restorable import RestorableWrapper, layers
from atari.wrappers._checks import Environment, require_atari
from atari.wrappers.episodic_life import EpisodicLife


class LifeLossInfo(RestorableWrapper):
    """Report a lost life as `terminated`. The next step continues the game; only a reset begins a new one.

    The lives after a step are compared with the lives before it. Put it outside a frame skip, and leave `EpisodicLife`
    out. If a step loses a life and reaches a limit, it is both terminated and truncated; ale-py's vector environment
    then reports only the loss, and resets.

    Args:
        env: an `AtariEnv`, possibly wrapped.
        last_life: also report the loss of the last life when the game is not over yet; some games (Bank Heist, Frogger)
            continue for a while with no life left.

    Raises:
        TypeError: the environment is no `AtariEnv`.
        ValueError: an inner `EpisodicLife` ends the episodes at lost lives.

    Example:
        >>> import atari
        >>> from atari.wrappers import LifeLossInfo
        >>> env = LifeLossInfo(atari.make("breakout"))
        >>> observation, info = env.reset(seed=0)
        >>> lost = False
        >>> while not lost:
        ...     observation, reward, lost, truncated, info = env.step(1)
        >>> info["lives"]
        4
        >>> env.step(1)[4]["lives"]
        4
    """

    def __init__(self, env: Environment, *, last_life: bool = False) -> None:
        self._atari = require_atari(env, "LifeLossInfo")
        if any(
            isinstance(layer, EpisodicLife) or (isinstance(layer, EpisodeEnv) and layer.preprocessing.episodic_life)
            for layer in layers(env)
        ):
            raise ValueError("an inner EpisodicLife ends the episodes that LifeLossInfo lets go on; leave one out")
        super().__init__(env, last_life=last_life)
        self._last_life = last_life

    def step(self, action: Any) -> tuple[Any, Any, bool, bool, dict[str, Any]]:
        """Step; also terminate if a life was lost."""
        before = self._atari.core.lives
        observation, reward, terminated, truncated, info = self.env.step(action)
        lives = self._atari.core.lives
        lost = lives < before and (lives > 0 or self._last_life)
        return observation, reward, terminated or lost, truncated, info
